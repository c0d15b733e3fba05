"""Studies: the plan says which cases are measured, by what, and which tables show them; the file holds their rows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import reduce
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Final, NamedTuple, Self, TypeAlias, final

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from pnt_gym.cells.base.config import Section
from pnt_gym.cells.base.problems import list_problems

from ..ground.cli import UsageError, check_known
from ..ground.files import read_yaml
from ..ground.metrics import wilson
from ..ground.places import SHIPPED
from ..judging.rows import Count, check_model

STUDIES: Final = SHIPPED / "configs" / "studies"
"""Plans that ship, NAME.yaml."""
LEVEL: Final = "level"
"""The axis whose values are labels of the plan's levels, or names of levels that ship."""
Scalar: TypeAlias = str | int | float | bool | None
SCALARS: Final = (str, int, float, bool)
"""Types of the values of an axis, beside none."""
Settings: TypeAlias = Mapping[str, Any]
Figures: TypeAlias = dict[str, Any]
"""Figures of a case by name; a row is the labels of a case and figures."""


class Amount(NamedTuple):
    """How much is measured of a case: throws or work shifts; from which seed."""

    throws: int
    seed: int


class Case(NamedTuple):
    """What one or several rows of a study are about.

    Attributes:
        labels: the part, and the value of each axis; they stand in the rows.
        settings: what the measurement is given.
        measure: the measuring function, MODULE.FUNCTION of benchmarks/studies.
        amount: how much is measured.
    """

    labels: dict[str, Scalar]
    settings: dict[str, Any]
    measure: str
    amount: Amount

    def __str__(self) -> str:
        return ", ".join(f"{name} {label}" for name, label in self.labels.items())

    def rows_of(self, rows: Iterable[Figures]) -> list[Figures]:
        """Those of the rows that are of the case."""
        return [row for row in rows if self.labels.items() <= row.items()]


@final
class Table(Section):
    """A table of the rows of some parts.

    What a cell shows is an expression of Jinja: a figure with a filter that writes it, such as `success|percent` or
    `landing.mean|mm(2)`. A figure with an interval is shown with it, and a cell of which a figure is missing is a dash.
    """

    title: str
    block: str = Field("", description="Name of the table in pages, as in `<!-- table:NAME -->`; none shows it.")
    parts: tuple[str, ...] = Field((), description="Parts whose rows it shows; all of them without one.")
    where: Mapping[str, tuple[Any, ...]] = Field({}, description="Values of axes whose rows it shows.")
    index: Mapping[str, str] = Field({}, description="What names a line: expressions by the names of their columns.")
    figures: Mapping[str, str] = Field({}, description="What each row has: expressions by the names of their columns.")
    columns: str = Field("", description="Axis, or figure, that has a column for each of its values.")
    figure: str = Field("", description="What these columns show; a mean where several rows meet in a cell.")
    note: str = Field("", description="A template of Jinja, of what the file tells, and of the part's settings.")

    @model_validator(mode="after")
    def _check(self) -> Self:
        if bool(self.columns) != bool(self.figure) or bool(self.columns) == bool(self.figures):
            raise ValueError(f"table {self.title!r}: figures are needed, or columns and a figure")
        return self


def _fits(values: Any) -> bool:
    """Whether an axis has a mapping of values to settings, or a list of values."""
    if isinstance(values, Mapping):
        return all(settings is None or isinstance(settings, Mapping) for settings in values.values())
    return isinstance(values, list | tuple) and all(value is None or isinstance(value, SCALARS) for value in values)


@final
class Part(Section):
    """Cases that are measured alike: every combination of the values of the axes."""

    measure: str = Field(pattern=r"^\w+\.\w+$", description="MODULE.FUNCTION of benchmarks/studies.")
    share: float = Field(1.0, gt=0.0, le=1.0, description="Of the throws of the plan that each case has.")
    settings: Mapping[str, Any] = Field({}, description="What the measurement is given in every case.")
    axes: Mapping[str, Any] = Field(
        {},
        description="By name a mapping of values to settings that each brings along, or by the dotted path of a "
        "setting a list of its values; the last word of the path is the axis's name.",
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        names = [name.rpartition(".")[2] for name in self.axes]
        if len(set(names)) != len(names):
            raise ValueError(f"axes: names {names} must differ from one another")
        for name, values in self.axes.items():
            if not (values and _fits(values)):
                raise ValueError(f"axes.{name}: a list of values or a mapping of values to settings is needed")
            if not isinstance(values, Mapping) and len(set(map(str, values))) != len(values):
                raise ValueError(f"axes.{name}: values {list(values)} must differ from one another")
        return self

    def count(self, throws: int) -> int:
        """Throws of a case."""
        return max(round(self.share * throws), 1)


@final
class StudyPlan(Section):
    """A study: parts of cases, and tables of what they came to."""

    study: str = Field(pattern=r"^\w+$", description="Its name.")
    about: str = Field(description="What it finds out.")
    throws: int = Field(ge=1, le=10**9, description="Of each case, or work shifts where these are judged.")
    seed: int = Field(0, ge=0)
    levels: Mapping[str, Mapping[str, Any]] = Field({}, description="By label, as a level's file would say them.")
    parts: Mapping[str, Part] = Field(min_length=1)
    names: Mapping[str, Mapping[Any, str]] = Field(
        {}, description="What tables call values, by axis; values of one name share a column."
    )
    tables: tuple[Table, ...] = ()

    @model_validator(mode="after")
    def _check(self) -> Self:
        for table in self.tables:
            for name in table.parts:
                if name not in self.parts:
                    raise ValueError(f"table {table.title!r}: no part {name!r}; parts are {', '.join(self.parts)}")
        return self

    @property
    def name(self) -> str:
        """Name of the study, and of the file of its results."""
        return self.study

    @property
    def needs_data(self) -> bool:
        """Whether a part compares with measured data, whose folder its setting `data` then is."""
        return any("data" in part.settings for part in self.parts.values())

    def cases(self, *names: str) -> list[Case]:
        """The cases of the parts of these names, or of all parts without a name, one after the other.

        Raises:
            UsageError: the study has no such part.
        """
        check_known("part", names, self.parts)
        cases: list[Case] = []
        for name, part in self.parts.items():
            axes = [self._values(path, values) for path, values in part.axes.items()]
            for choice in product(*axes) if not names or name in names else ():
                labels = {"part": name, **{axis: label for axis, label, _ in choice}}
                settings = reduce(merge, (settings for _, _, settings in choice), dict(part.settings))
                cases.append(Case(labels, settings, part.measure, Amount(part.count(self.throws), self.seed)))
        return cases

    def _values(self, path: str, values: Any) -> Iterator[tuple[str, Scalar, Mapping[str, Any]]]:
        """Name, value and settings of each value of an axis."""
        if isinstance(values, Mapping):
            yield from ((path, label, settings or {}) for label, settings in values.items())
            return
        *folders, name = path.split(".")
        for label in values:
            settings: Any = self.levels.get(label, {"base": label}) if path == LEVEL else label
            yield name, label, reduce(lambda inner, key: {key: inner}, [*reversed(folders)], {name: settings})


def merge(settings: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Settings with changes, mapping by mapping."""
    both = {name: (settings[name], value) for name, value in changes.items() if name in settings}
    inner = {
        name: merge(old, new) if isinstance(old, Mapping) and isinstance(new, Mapping) else new
        for name, (old, new) in both.items()
    }
    return {**settings, **changes, **inner}


def is_plan(path: Path) -> bool:
    """Whether a YAML file holds the plan of a study, and not that of a benchmark."""
    data = read_yaml(path, "benchmark")
    return isinstance(data, Mapping) and "study" in data


def read(path: Path) -> StudyPlan:
    """The plan in a YAML file.

    Raises:
        UsageError: the file is missing or damaged, or its plan does not hold together.
    """
    try:
        return StudyPlan.model_validate(read_yaml(path, "study"))
    except ValidationError as error:
        raise UsageError(*list_problems(f"study {str(path)!r}", error, StudyPlan)) from None


def shipped_study(name: str) -> StudyPlan:
    """The plan of a study that ships.

    Raises:
        UsageError: none of that name does.
    """
    known = sorted(path.stem for path in STUDIES.glob("*.yaml"))
    check_known("study", [name], known)
    return read(STUDIES / f"{name}.yaml")


def share(cases: Sequence[bool]) -> Figures:
    """Share of true cases with Wilson's interval, as a figure of a row; shares of rows that meet are pooled."""
    return _share(sum(cases), len(cases))


def _share(true: int, count: int) -> Figures:
    return {**asdict(wilson(true, count)), "true": true, "count": count}


def pool(rows: Sequence[Settings]) -> Settings:
    """Rows as one: each number the mean, each share that of all their cases, and each list all their entries."""
    first = rows[0]
    numbers = [name for name, value in first.items() if isinstance(value, float)]
    shares = [name for name, value in first.items() if isinstance(value, Mapping) and "count" in value]
    lists = [name for name, value in first.items() if isinstance(value, list)]
    return {
        **first,
        **{name: sum(row[name] for row in rows) / len(rows) for name in numbers},
        **{name: [entry for row in rows for entry in row[name]] for name in lists},
        **{name: _share(*(sum(row[name][part] for row in rows) for part in ("true", "count"))) for name in shares},
    }


class StudyFile(BaseModel):
    """Form of a study's file; the figures of its rows are those of its plan."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    study: Annotated[str, Field(max_length=100)]
    version: Annotated[str, Field(max_length=100)]
    seed: Annotated[int, Field(ge=0)]
    throws: Count
    digest: Annotated[str, Field(max_length=100)] = ""
    world: Annotated[int, Field(ge=1)] = 1
    rows: list[dict[str, Any]]


def matches(data: Any) -> bool:
    """Whether a file of results is that of a study."""
    return isinstance(data, dict) and {"study", "rows", "throws"} <= data.keys()


def check(path: Path, data: Any) -> None:
    """Make sure that a study's file has its form.

    Raises:
        UsageError: it has another one.
    """
    check_model(path, StudyFile, data)

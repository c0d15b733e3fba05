"""Throws as rows: from the info of a step, as the rounded columns that a benchmark keeps, and back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Final, Self, final

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pnt_gym.arrays import Bools, Floats, Ints

from ..ground.files import jsonable
from ..ground.infos import results
from .record import mappings
from .rows import LARGEST, Amount, Columns, Count, Number

FIELDS: Final = {
    "item": ("item", np.int64),
    "landing_error": ("landing_error", np.float64),
    "is_success": ("is_success", np.bool_),
    "cycle_time": ("cycle_time", np.float64),
    "clipped": ("residual_clipped", np.bool_),
}
"""Fields of a throw that every cell's info has: key and type in the info by our name."""
METRES: Final = {"landing_along": "landing_along_m", "landing_across": "landing_across_m"}
"""Names with unit of some cells' lengths in JSON records."""
FAILURES: Final = ("unpicked", "dropped", "recontact", "rim")
"""Causes of failure in order of precedence; `rim`: the target was reached, but the object did not stay."""
OUTCOMES: Final = {
    "sorted": "s",
    "astray": "a",
    "unpicked": "p",
    "dropped": "d",
    "recontact": "t",
    "rim": "r",
    "missed": "m",
}
"""Letter of each outcome: sorted; success in a bin of another kind; not picked; dropped before the release; touched
again by the robot; crossed the opening without staying; or missed it. In a cell whose info has no failures every
failure counts as missed."""
PLACES: Final = ("along_m", "across_m")
"""Columns with the landing along and across the throw [m]."""
INFO: Final = {
    "along_m": "landing_along",
    "across_m": "landing_across",
    "pick": "pick_in_shift",
    "recontact": "recontact",
    "belong": "belongs",
    "passed": "passed",
    "dropped": "dropped",
    "tries": "tries",
    "energy_j": "energy",
}
"""Columns that some cells tell, and their `info` keys."""
TOTALS: Final = ("clipped", "recontact", "ended", "belong", "passed", "dropped", "tries", "energy_j")
"""Columns of a result that hold totals of all its throws."""


@final
@dataclass(frozen=True)
class Throws:
    """N throws in the order of counting, one array entry each."""

    item: Ints
    """Index into the core's `item_names`."""
    landing_error: Floats
    is_success: Bools
    cycle_time: Floats
    clipped: Bools
    """Whether the action was infeasible and a shortened one was executed."""
    reward: Floats
    info: dict[str, NDArray[Any]]
    """All other values of the cell's info, by key."""
    errors: tuple[str, ...] = ()
    """Keys of the values from which a controller learns: the errors of the core's correction."""

    @classmethod
    def of(cls, info: Mapping[str, Any], reward: NDArray[Any], errors: tuple[str, ...]) -> Self:
        """Throws of one step of a vector environment, from its info and rewards."""
        columns = results(info, len(reward))
        fields: dict[str, Any] = {name: columns.pop(key).astype(kind) for name, (key, kind) in FIELDS.items()}
        return cls(**fields, reward=np.array(reward, dtype=np.float64), info=columns, errors=errors)

    def __len__(self) -> int:
        return len(self.item)

    @property
    def sorted(self) -> Bools:
        """Whether each object ended in a bin of its kind (N,); the success in cells without `sorted`."""
        return self.info.get("sorted", self.is_success).astype(np.bool_)

    @property
    def picked(self) -> Bools:
        """Whether the cup held each object when the throw began (N,); True in cells without `picked`."""
        return self.info.get("picked", np.full(len(self), True)).astype(np.bool_)

    def flag(self, name: str) -> Bools | None:
        """Mask of a failure of `FAILURES` (N,); None in cells without it."""
        if name == "unpicked":
            return ~self.picked if "picked" in self.info else None
        return self.info[name].astype(np.bool_) if name in self.info else None

    @property
    def error(self) -> Floats:
        """Errors in the coordinates that actions correct (N, E)."""
        columns = [self.info[name].astype(np.float64) for name in self.errors]
        return np.stack(columns, axis=-1) if columns else np.zeros((len(self), 0))


def outcomes(throws: Throws) -> list[str]:
    """Letter of `OUTCOMES` of each throw; an outcome that the cell does not tell counts as missed."""
    *letters, missed = OUTCOMES.values()
    never = np.zeros(len(throws), dtype=np.bool_)
    causes = (throws.flag(name) for name in FAILURES)
    kinds = [throws.sorted, throws.is_success, *(never if cause is None else cause for cause in causes)]
    return np.select(kinds, letters, missed).tolist()


def live_rows(throws: Throws) -> dict[str, NDArray[Any]]:
    """Columns (N,) of throws that have just been carried out, those that the cell's info allows."""
    info, letters = throws.info, np.array(outcomes(throws))
    causes = [*(name for name in FAILURES if throws.flag(name) is not None), *(("missed",) if "rim" in info else ())]
    columns: dict[str, NDArray[Any]] = {
        **{column: info[name] for column, name in INFO.items() if name in info},
        "error_m": throws.landing_error,
        "cycle_s": throws.cycle_time,
        "success": throws.is_success,
        "sorted": throws.sorted,
        "clipped": throws.clipped,
        "reward": throws.reward,
        **{_share(name): letters == OUTCOMES[name] for name in causes},
    }
    if "belongs" in info:
        columns["ended"] = info["ended_in"] >= 0
    if "picked" in info:
        columns["picked"] = throws.picked
    return _columns(columns)


def kept_columns(throws: Throws) -> dict[str, Any]:
    """Throws as columns, rounded to 0.01 mm and 0.1 ms; cells without landing along and across have the error alone.

    Totals of all throws are single numbers: objects in bins, in their own bins, passed and dropped, and energy [J].
    """
    rows = live_rows(throws)
    totals = {name: round(float(rows[name].sum()), 1) for name in TOTALS if name in rows}
    places = [name for name in PLACES if name in rows] or ["error_m"]
    return {
        "item": throws.item.tolist(),
        **{name: jsonable(rows[name], 5) for name in places},
        "cycle_s": jsonable(throws.cycle_time, 4),
        "outcome": "".join(outcomes(throws)),
        **({"pick": rows["pick"].tolist()} if "pick" in rows else {}),
        "recontact": 0,  # of a cell that does not tell
        **{name: total if name == "energy_j" else int(total) for name, total in totals.items()},
    }


def kept_rows(columns: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
    """Columns (N,) of the throws that a benchmark keeps; of a total, every throw has an equal part."""
    letters = np.array(list(columns["outcome"]))
    count, shares = len(letters), {name: letters == letter for name, letter in OUTCOMES.items()}
    rows = {name: np.array(columns[name], dtype=np.float64) for name in (*PLACES, "error_m") if name in columns}
    if "error_m" not in rows:
        rows["error_m"] = np.hypot(rows["along_m"], rows["across_m"])
    rows |= {
        "cycle_s": np.array(columns["cycle_s"]),
        "success": shares["sorted"] | shares["astray"],
        "sorted": shares["sorted"],
        **{_share(name): column for name, column in shares.items()},
        **{name: np.full(count, columns[name] / count) for name in TOTALS if name in columns},
    }
    if "pick" in columns:
        rows["pick"] = np.array(columns["pick"])
    if "dropped" in columns:
        rows["picked"] = ~shares["unpicked"]
    return _columns(rows)


def _columns(columns: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Columns with one for each throw, and with the objects that could have been sorted."""
    ones = np.ones(len(columns["error_m"]))
    offered = {"offered": ones + columns["passed"]} if "passed" in columns else {}
    return {"throw": ones, **columns, **offered}


def _share(outcome: str) -> str:
    """Name of the column of throws with an outcome."""
    return f"share_{outcome}"


def throw_records(throws: Throws, item_names: Sequence[str]) -> list[dict[str, Any]]:
    """One JSON object per throw: the fields of every cell, then all values of this cell's info."""
    columns = {
        "item": [item_names[i] for i in throws.item],
        "landing_error_m": throws.landing_error,
        "success": throws.is_success,
        "cycle_time_s": throws.cycle_time,
        "clipped": throws.clipped,
        "reward": throws.reward,
        **{METRES.get(name, name): column for name, column in throws.info.items()},
    }
    if {"target_x", "target_y"} <= set(columns):
        columns["target"] = np.stack([columns.pop("target_x"), columns.pop("target_y")], axis=-1)
    return mappings(columns)


class ThrowColumns(Columns):
    """Form of the columns of N throws; totals of all throws are single numbers."""

    item: list[Count]
    along_m: list[Number | None] = Field(default_factory=list)
    across_m: list[Number | None] = Field(default_factory=list)
    error_m: list[Amount | None] = Field(default_factory=list)
    cycle_s: list[Annotated[float, Field(gt=0.0, le=LARGEST)]]
    outcome: Annotated[str, Field(pattern=f"^[{''.join(OUTCOMES.values())}]*$")]
    pick: list[Count] = Field(default_factory=list)
    clipped: Count
    recontact: Count
    ended: Count = 0
    belong: Count = 0
    passed: Count = 0
    dropped: Count = 0
    tries: Count = 0
    energy_j: Amount = 0.0

    @model_validator(mode="after")
    def _check_together(self) -> Self:
        given = self.model_fields_set
        if given & {*PLACES, "error_m"} not in ({*PLACES}, {"error_m"}):
            raise ValueError("landings are the columns along_m and across_m, or the column error_m")
        if len(given & {"ended", "belong"}) == 1:
            raise ValueError("of the totals ended and belong one is missing")
        for name in ("clipped", "recontact", "ended", "belong", "dropped"):
            if getattr(self, name) > len(self.outcome):
                raise ValueError(f"{name} is {getattr(self, name)}; there are {len(self.outcome)} throws")
        return self

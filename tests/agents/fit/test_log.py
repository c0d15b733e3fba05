"""The log of throws: what the cell knew and what came of it, nothing hidden; and every mistake in one sentence."""

import csv
import io
import os
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.controllers import make_controller
from agents.fit import reading
from agents.fit.log import COLUMNS, GROUPS, ThrowLog
from agents.fit.reading import MOST, MOST_LINES
from agents.ground.cli import UsageError
from agents.judging.recorder import Recorder
from agents.judging.trials import open_trial
from agents.pictures.stage import Stage
from tests.tools.fitting import WASTE, level, same_logs, throw, usual_log

Rows = list[dict[str, str]]


def test_a_log_is_read_as_it_was_written(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(usual_log().text(WASTE.items))
    assert path.read_text().splitlines()[0].split(",") == list(COLUMNS)
    assert same_logs(reading.read(path, WASTE), usual_log())
    assert {name for names in GROUPS.values() for name in names} | {"item"} == COLUMNS.keys()


def test_landings_are_those_of_the_throws_with_the_cameras_noise() -> None:
    log, record = throw(level(feedback={"noise": 0.0, "unseen": 0.0, "view": 1.0}), 40)
    info = record.throws.info
    np.testing.assert_array_equal(log.sealed == 1.0, info["picked"])
    np.testing.assert_array_equal(log.has_landing, info["picked"] & ~info["dropped"])
    error = np.hypot(*(log.landing - log.target).T)[log.has_landing]
    np.testing.assert_allclose(error, record.throws.landing_error[log.has_landing], atol=1e-9)
    noisy, _ = throw(level(feedback={"noise": 0.003, "unseen": 0.0, "view": 1.0}), 40)
    noise = (noisy.landing - log.landing)[log.has_landing]
    assert 0.002 < noise.std() < 0.004
    far, _ = throw(level(feedback={"noise": 0.0, "unseen": 0.0, "view": 0.03}), 40)
    assert not (far.has_landing & (np.hypot(*(log.landing - log.target).T) > 0.03)).any()


def test_a_cell_with_a_camera_logs_what_that_camera_measured() -> None:
    log, record = throw(level(picks_per_shift=5), 40, env="PnTAdapt-v0")
    seen = np.isfinite(record.throws.info["seen_along"])
    np.testing.assert_array_equal(log.has_landing, seen & record.throws.info["picked"] & ~record.throws.info["dropped"])


def test_nothing_hidden_is_in_a_log() -> None:
    """What is true of objects is overwritten with NaN, and the log of what the cell knows stays the same."""
    with closing(open_trial("PnTRelease-v0", WASTE, 8, 1)) as trial:
        trial.env.reset(seed=0)
        context = trial.core.context
        plans, _ = trial.core.plan(np.zeros((8, 2)))
        known = ThrowLog.of(context, plans)
        o = context.objects
        grasp = context.measured_grasp  # what the sensors measured, which is computed from the true place
        names = ("mass", "size", "drag", "com_depth", "seal", "delay", "jitter", "yaw", "spin", "pick_chance")
        blind = context.replace(
            objects=o.replace(**{name: np.full_like(getattr(o, name), np.nan) for name in names}),
            unseen=np.full_like(context.unseen, np.nan),
        )
        assert same_logs(ThrowLog.of(blind, plans), known)
        np.testing.assert_array_equal(known.grasp, grasp)


def test_watched_throws_have_the_log_of_an_evaluation() -> None:
    with closing(Stage("analytic", "PnTRelease-v0", "waste_plain", 3)) as stage:
        recorder = Recorder(stage.core)
        stage.begin(recorder.watch)
        steps = recorder.keep(stage.steps)
        for _ in range(3):
            next(steps)
        text = recorder.text(3)
    with closing(open_trial("PnTRelease-v0", "waste_plain", 1, 1)) as trial:
        recorder = Recorder(trial.core)
        record: Any = trial.run(recorder.watch(make_controller("analytic", trial.env)), 3, 3)
        assert text == recorder.text(3, record)


def test_only_a_conveyor_has_a_log() -> None:
    with closing(open_trial("OneJointThrow-v0", None, 2, 1)) as trial:
        with pytest.raises(UsageError, match="--log goes with PnTConveyor-v0"):
            Recorder(trial.core)
        assert make_controller("analytic", trial.env).name == "analytic"


def changed(change: Callable[[Rows], Rows]) -> str:
    """The usual log with changed rows, as text."""
    rows = change(list(csv.DictReader(io.StringIO(usual_log().text(WASTE.items)))))
    output = io.StringIO()
    names = list(dict.fromkeys(name for row in rows for name in row)) if rows else list(COLUMNS)
    writer = csv.DictWriter(output, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return output.getvalue()


def scaled(*groups: str, factor: float = 1000.0) -> Callable[[Rows], Rows]:
    names = {name for group in groups for name in GROUPS[group]}
    return lambda rows: [
        {name: str(factor * float(text)) if name in names and text else text for name, text in row.items()}
        for row in rows
    ]


def read(change: Callable[[Rows], Rows], folder: Path) -> ThrowLog:
    path = folder / "log.csv"
    path.write_text(changed(change))
    return reading.read(path, WASTE)


def each(**values: str) -> Callable[[Rows], Rows]:
    return lambda rows: [{**row, **values} for row in rows]


def swapped(field: str) -> Callable[[Rows], Rows]:
    x, y, *_ = GROUPS[field]
    return lambda rows: [{**row, x: row[y], y: row[x]} for row in rows]


def renamed(before: str, after: str) -> Callable[[Rows], Rows]:
    return lambda rows: [{after if name == before else name: text for name, text in row.items()} for row in rows]


def without(*names: str) -> Callable[[Rows], Rows]:
    return lambda rows: [{name: text for name, text in row.items() if name not in names} for row in rows]


MISTAKES: dict[str, tuple[Callable[[Rows], Rows], str]] = {
    "no throws": (lambda rows: [], "has no throws below its header"),
    "no landings": (each(landing_x="", landing_y=""), "the log has no landings"),
    "three throws": (
        lambda rows: [row for row in rows if row["landing_x"]][:3],
        "the log has 3 landings; a fit needs",
    ),
    "picks in mm": (
        scaled("pick"),
        "throw [0-9]+ of the log: pick_[xyz] is .* from -5 to 5 m; it looks like millimetres",
    ),
    "landings in mm": (scaled("landing"), "landing_[xy] is .*it looks like millimetres"),
    "velocities in mm a second": (
        scaled("velocity"),
        "release_v[xyz] is .* m/s; it must be from -20 to 20 m/s; it looks like millimetres a second",
    ),
    "all in mm": (scaled("pick", "release", "landing", "target", "size", "grasp"), "it looks like millimetres"),
    "grams": (scaled("mass"), "mass is .* kg; it must be from .* kg for item '[a-z0-9_]+'; it looks like grams"),
    "degrees": (scaled("yaw", factor=57.3), "yaw is .* rad; it must be from -6.28 to 6.28 rad; it looks like degrees"),
    "picks swapped": (swapped("pick"), "pick_x and pick_y look swapped"),
    "landings swapped": (swapped("landing"), "landing_x and landing_y look swapped"),
    "a column twice": (lambda rows: [{**row, " item": row["item"]} for row in rows], "more than one column 'item'"),
    "no velocity": (without("release_vx"), "lacks the columns 'release_vx'"),
    "no pick": (without("pick_x", "item"), "lacks the columns 'item' and 'pick_x'"),
    "nan": (each(pick_x="nan"), "throw 1 of the log has no pick_x"),
    "infinite": (each(mass="inf"), "mass is inf; it must be finite"),
    "words": (each(mass="heavy"), "mass is 'heavy', no number"),
    "a misspelled column": (
        renamed("belt_speed", "belt_sped"),
        "unknown column 'belt_sped'; did you mean 'belt_speed'. known are .*; rename the column or drop it",
    ),
    "a needed column in capitals": (
        renamed("pick_x", "Pick_X"),
        "unknown column 'Pick_X'; did you mean 'pick_x'",
    ),
    "unknown item": (each(item="brick"), "unknown item 'brick'; known are"),
    "no setting": (without("percent"), "percent is empty, and the level has several speed settings"),
    "another setting": (each(percent="90"), "do not have the speed that the level's limits give"),
    "another belt": (each(belt_speed="0.5"), "belt.speed of the level is 0.25"),
    "releases swapped": (swapped("velocity"), "release_vx and release_vy look swapped"),
    "stands still": (each(release_vx="0", release_vy="0", release_vz="0"), "check frame, units and columns"),
    "no mass": (each(mass="-0.1"), "throw 1 of the log: mass is -0.1; it must be above 0"),
    "no length": (each(length="0"), "length is 0; it must be above 0"),
    "sealed twice": (each(sealed="2"), "sealed is 2; it must be 0 or 1"),
    "sealed and not": (each(sealed="0"), "landings of objects that were not sealed"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_every_mistake_is_one_sentence(name: str, tmp_path: Path) -> None:
    from agents.fit.model import ThrowModel  # noqa: PLC0415 - for the one mistake that the motion shows

    change, sentence = MISTAKES[name]
    path = tmp_path / "log.csv"
    path.write_text(changed(change))
    with pytest.raises(UsageError, match=sentence) as caught:
        ThrowModel(reading.read(path, WASTE), WASTE)
    assert "\n" not in str(caught.value)


EXTREMES = {
    name: ("-5.1", "5.1") for field in ("pick", "release", "target", "landing") for name in GROUPS[field]
} | {
    **dict.fromkeys(GROUPS["velocity"], ("-21", "1e5")), "percent": ("0.4", "101"), "belt_speed": ("-11", "1e12"),
    **dict.fromkeys(("length", "width", "height", "mass", "seal"), ("1e-5", "1e4")), "yaw": ("-6.3", "180"),
    **dict.fromkeys(("grasp_x", "grasp_y"), ("-1.5", "1.5")), "sealed": ("-1", "2"), "lost": ("-1", "0.5"),
}  # fmt: skip


@pytest.mark.parametrize("name", sorted(set(COLUMNS) - {"item"}))
@pytest.mark.parametrize("side", [0, 1])
def test_every_column_has_a_range_on_both_sides(name: str, side: int, tmp_path: Path) -> None:
    def change(rows: Rows) -> Rows:
        return [{**row, name: EXTREMES[name][side]} if k == 4 else row for k, row in enumerate(rows)]

    with pytest.raises(UsageError, match=rf"throw 5 of the log: {name} is .*it must be ") as caught:
        read(change, tmp_path)
    assert "\n" not in str(caught.value)


UNITS = {
    "mass": (1e3, "grams"), "length": (1e2, "centimetres"), "height": (1e3, "millimetres"),
    "seal": (1e-3, "kilonewtons"),
    "release_vy": (1e3, "millimetres a second"), "yaw": (57.3, "degrees"), "grasp_x": (1e3, "millimetres"),
    "landing_y": (1e3, "millimetres"), "width": (39.4, "inches"), "percent": (0.01, "shares of 1"),
}  # fmt: skip


@pytest.mark.parametrize("name", UNITS)
def test_a_column_in_another_unit_is_told_by_the_unit(name: str, tmp_path: Path) -> None:
    factor, unit = UNITS[name]
    with pytest.raises(UsageError, match=rf"{name} is .*; it looks like {unit}$"):
        read(lambda rows: [{**row, name: row[name] and str(factor * float(row[name]))} for row in rows], tmp_path)


def test_a_long_log_names_the_throw_of_the_file(tmp_path: Path) -> None:
    """Of a long log a part is drawn, and an error still says where its value stands."""
    with pytest.raises(UsageError, match="of the log: mass is 9999 kg") as caught, pytest.warns(UserWarning):
        read(lambda rows: [{**rows[0], "mass": "9999" if k % 7 == 3 else "0.01"} for k in range(3000)], tmp_path)
    number = int(str(caught.value).split()[1])
    assert (number - 1) % 7 == 3
    assert number > 3


@pytest.mark.parametrize("kind", ["fifo", "/dev/zero", "endless line", "many lines", "folder", "pipe"])
def test_what_has_no_end_is_no_log(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv" if "/" not in kind else Path(kind)
    if kind == "fifo":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    elif kind == "endless line":
        path.write_text("x" * 10**6)
    elif kind == "many lines":
        with path.open("wb") as file:
            file.write(b"\n" * (MOST_LINES + 1))
    ends = os.pipe()
    with pytest.raises(UsageError, match=r"cannot read log .*: (it |its |Is a)") as caught:
        reading.read(Path(f"/dev/fd/{ends[0]}") if kind == "pipe" else path, WASTE)
    assert "\n" not in str(caught.value)
    for end in ends:
        os.close(end)


@pytest.mark.parametrize("text", ["", "\n\n", "item;pick_x\ncan;1", "\x00\x01"])
def test_what_is_no_table_is_refused(text: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(text)
    with pytest.raises(UsageError, match="log"):
        reading.read(path, WASTE)
    with pytest.raises(UsageError, match="No such file"):
        reading.read(tmp_path / "none.csv", WASTE)
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(UsageError, match="cannot read log"):
        reading.read(path, WASTE)


@pytest.mark.parametrize("mark", [";", "\t", "|"])
def test_a_spreadsheets_log_with_decimal_commas_is_read(mark: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    text = usual_log().text(WASTE.items).replace(",", mark).replace(".", ",")
    path.write_text(f"\ufeff{text}")
    assert same_logs(reading.read(path, WASTE), usual_log())
    path.write_text(text.replace("0,", "1.000,0", 1))
    with pytest.raises(UsageError, match=r"is '-?1\.000\..*', no number"):
        reading.read(path, WASTE)


def test_repeated_throws_count_once(tmp_path: Path) -> None:
    with pytest.warns(UserWarning, match="throws repeat another one"):
        twice = read(lambda rows: [row for row in rows for _ in range(2)], tmp_path)
    assert twice.has_landing.sum() == usual_log().has_landing.sum()


def test_a_long_log_is_sampled(tmp_path: Path) -> None:
    """A million rows are 400 draws; this test has fewer, to be quick."""
    with pytest.warns(UserWarning) as warned:
        log = read(lambda rows: [{**row, "landing_x": row["landing_x"] and f"{float(row['landing_x']) + 1e-9 * k}"}
                                 for k in range(40) for row in rows], tmp_path)  # fmt: skip
    assert any("400 of the log's 2,400 throws are used" in str(w.message) for w in warned)
    assert MOST * 0.9 < len(log) <= MOST


def test_odd_logs_are_read_with_a_warning(tmp_path: Path) -> None:
    with pytest.warns(UserWarning, match="columns 'note' and 'shift' of the log are not read"):
        read(each(note="x", shift="2"), tmp_path)
    with pytest.warns(UserWarning, match="the log has 14 landings"):
        read(lambda rows: [row for row in rows if row["landing_x"]][:14], tmp_path)
    with pytest.warns(UserWarning, match="throws have neither a landing nor a word whether the cup sealed"):
        read(without("sealed", "lost"), tmp_path)
    with pytest.warns(UserWarning, match="all landings are of can"):
        read(each(item="can"), tmp_path)

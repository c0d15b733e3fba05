"""The table and the figure of a benchmark of shifts."""

from typing import Any

from agents.report.figures import over_the_shift
from agents.report.tables import shift_table


def row(controller: str, level: str, throws: int, error: float) -> dict[str, Any]:
    means = dict.fromkeys((f"landing_error_{part}_m" for part in ("mean", "first_10", "second_half")), error)
    more = {"shifts": 4, "landing_near_share": 0.9, "landing_error_by_pick_m": [error] * 8}
    return {"label": controller, "controller": controller, "level": level, "throws": throws, **means, **more}


def test_an_error_is_told_over_that_of_the_static_policy_of_as_many_throws() -> None:
    rows = [
        row("static", "day", 100, 0.020), row("static", "day", 10, 0.040), row("ema", "day", 100, 0.010),
        row("ema", "day", 10, 0.010), row("recurrent_ppo", "day", 7, 0.010), row("ema", "still", 100, 0.010),
    ]  # fmt: skip
    over = [line[7] for line in shift_table({"table": rows}).rows]
    assert over == ["1.00", "1.00", "0.50", "0.25", "0.50", "-"]


def test_levels_have_panels_in_rows() -> None:
    levels = [f"level{k}" for k in range(3)]
    figure = over_the_shift({"table": [row("ema", level, 1, 0.010) for level in levels]})
    shown = [axes for axes in figure.axes if axes.get_visible()]
    assert [axes.get_title() for axes in shown] == [f"level {level}" for level in levels]
    assert len(figure.axes) == 4  # two rows of two, and the last is empty
    assert all(len(axes.lines) == 1 for axes in shown)

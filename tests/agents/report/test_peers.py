"""The table of cells of other papers."""

from agents.ground.metrics import wilson
from agents.report import headline
from agents.report.headline import PUBLISHED


def test_published_shares_stand_below_ours_with_the_interval_of_our_throws() -> None:
    row = {"label": "mlp", "throws": 1000, "level": "cubes", "success_rate": 0.9955, "sorted_per_min": 75.0}
    plan = {"levels": ["cubes"], "picks": 10000, "picks_on": {"cubes": 2000}, "env": "PnTRelease-v0"}
    rows = headline.peers({"plan": plan, "table": [row]}).rows
    interval = wilson(1991, 2000)
    shown = f"99.55 % ({100 * interval.low:.2f}..{100 * interval.high:.2f})"
    assert rows[0] == ["cubes", "mlp", "1,000", "2,000", shown, "75.0"]
    assert [(line[1], line[4]) for line in rows[1:]] == [(n, f"{100 * share:.1f} %") for n, share in PUBLISHED["cubes"]]

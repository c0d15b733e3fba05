"""Tables of text made from rows of figures."""

from agents.ground.drawings import dress, subplots
from agents.reproduce.finding import Row
from agents.reproduce.grids import table_findings


def test_all_rows_stand_in_tables_and_figures_are_drawn() -> None:
    figure, (axes,) = subplots(1, 1, (3.0, 2.0))
    axes.plot([0.0, 1.0], [0.0, 1.0], label="a line")
    dress(axes, "across", "up", "title", legend="upper left", xlim=(0.0, 2.0), yscale="log")
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.get_title()) == ("across", "up", "title")
    assert (axes.get_xlim(), axes.get_yscale()) == ((0.0, 2.0), "log")
    assert axes.get_legend() is not None
    rows = (Row.ours("paper/a", 1.0, "s"), Row.compared("paper/b/c", 2.0, 2.0, "m", note="same"))
    found = table_findings("All", iter(rows), {"drawn.svg": figure}, {"more": 3}, drop="paper/")
    assert (found.rows, found.data) == (rows, {"more": 3})
    assert found.figures["drawn.svg"].lstrip().startswith("<?xml")
    assert {grid.headline: [line[0] for line in grid.rows] for grid in found.grids} == {
        "All": ["b c"],
        "All: ours": ["a"],
    }
    assert table_findings("Nothing drawn", rows, drop="").figures == {}

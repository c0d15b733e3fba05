"""The tables of the study of methods: one cell a method, what is impossible as a dash, nothing lost."""

from agents.report.methods import NAMES, methods_chapter, methods_figure, methods_table, pays_table, reasons_table


def found(pace: float) -> dict[str, float]:
    """Figures of a method that sorts so many objects a minute."""
    return {
        "sorted_per_min": pace, "success": 0.5, "cycle_time": 1.25, "wait_time": 0.01, "flown_over_planned": 0.9998,
        "unpicked": 0.08, "dropped": 0.02, "missed": 0.4, "rim": 0.1, "recovery": 0.25, "energy_per_pick_j": 12.4,
    }  # fmt: skip


DATA = {
    "throws": 9,
    "seed": 3,
    "methods": {
        "nominal": {
            "15": {name: {"impossible": "no object has a feasible throw"} for name in NAMES},
            "40": {name: found(10.0 * k) for k, name in enumerate(NAMES)},
        },
        "opening": {"0.14": {name: found(7.0) for name in NAMES}},
        "distance": {"0.9": {name: {"impossible": "."} if "place" in name else found(8.0) for name in NAMES}},
        "grip": {"0.2": {name: {"impossible": "."} if "direct" in name else found(6.0) for name in NAMES}},
    },
}


def test_every_level_and_percentage_is_a_row_and_every_method_a_column():
    grid = methods_table(DATA)
    assert [row[0] for row in grid.rows] == ["`nominal`, 15 %", "`nominal`, 40 %"]
    assert grid.rows[0][1:] == ["-"] * 5
    assert grid.rows[1][1:] == ["0.0 (50 %)", "10.0 (50 %)", "20.0 (50 %)", "30.0 (50 %)", "40.0 (50 %)"]
    assert len(grid.header) == 6


def test_the_reasons_are_those_at_forty_percent():
    grid = reasons_table(DATA)
    assert [row[:2] for row in grid.rows] == [["nominal", said] for said in NAMES.values()]
    shares = ["8.0 %", "2.0 %", "40.0 %", "10.0 %", "25.0 %"]
    assert grid.rows[0][2:] == ["1.250 s", "0.010 s", "0.9998", *shares, "12 J"]
    assert [len(row) for row in grid.rows] == [len(grid.header)] * len(NAMES)


def test_openings_distances_and_weights_follow_one_another():
    grid = pays_table(DATA)
    said = ["opening 140 mm", "bin 0.90 m beyond the robot's middle", "cans of 200 g, held with 20 N"]
    assert [row[0] for row in grid.rows] == said
    assert grid.rows[1][1:] == ["-", *["8.0 (50 %)"] * 4]
    assert grid.rows[2][1:] == [*["6.0 (50 %)"] * 4, "-"]
    assert grid.note.startswith("Sorted per minute, in brackets the success rate: 4 throws per cell")


def test_the_figure_has_a_line_for_each_method_in_each_panel():
    panels = methods_figure(DATA).axes
    assert [panel.get_title() for panel in panels] == ["level nominal", "opening", "distance", "grip"]
    for panel in panels:
        assert [line.get_label() for line in panel.lines] == list(NAMES.values())
    assert panels[0].lines[3].get_ydata()[1] == 30.0
    assert set(methods_chapter("methods", DATA).figures) == {"methods.svg"}

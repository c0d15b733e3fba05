"""The report's chapter on a reproduction, from rows written here."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from agents.report.__main__ import Arguments, Chapter, main, read_chapters
from agents.report.hassan import table1
from agents.report.page import alignments, cells, page
from agents.report.readme import stale_readme, with_blocks
from agents.report.reproduction import headlines, of_paper

PUBLISHED = {("inside", 15): 30.0, ("inside", 30): 68.0, ("inside", 40): 120.0}


def measured(sorted_count: int, recontacts: int) -> dict[str, Any]:
    common = {"trials": 9, "landing_error_max": 0.0071, "peak_torque": 140.4}
    return {
        "0": {**common, "sorted": 9, "recontacts": 0},
        "1": {**common, "sorted": sorted_count, "recontacts": recontacts},
    }


def row(quantity: str, published: Any, reproduced: Any, verdict: str = "ours", **more: Any) -> dict[str, Any]:
    main_entries = {"quantity": quantity, "published": published, "reproduced": reproduced}
    return {**main_entries, "unit": "picks/min", "verdict": verdict, "note": "a note", "paper": "hassan", **more}


def record() -> dict[str, Any]:
    rows: list[dict[str, Any]] = []
    for protocol, peak in (("paper-clock", 2.0), ("limits-respected", 1.0)):
        for (zone, percent), value in PUBLISHED.items():
            name = f"table1/{protocol}/min-time-throw/{zone}/{percent}"
            more = {"peak_acceleration_ratio": peak, "simulated": measured(4, 1), "picks_per_min_dwell_0.1": 9.5}
            rows.append(row(name, value, value / peak + 0.04, "reproduced", **more))
    for name in ("mean", "worst"):
        rows.append(row(f"table1/paper-clock/{name}-difference", None, 2.93 if name == "mean" else 5.46))
    for percent in (15, 30):
        name = f"table1/limits-respected/free-direction-throw/inside/{percent}"
        rows.append(
            row(name, None, 31.0, peak_acceleration_ratio=1.0, simulated=measured(3, 0), hand_above_ceiling_m=0.13)
        )
    name = "table1/limits-respected/free-direction-per-pick"
    rows.append(row(f"{name}/loss-max", None, 3.5, loss_by_cell={"inside/15": 2.15, "inside/40": 3.5}))
    batch = {"picks": 256, "planned": 255, "straight": 2, "limits_kept": 255}
    rows.append(row(f"{name}/time-per-pick-inside-40", None, 812.4, **batch))
    rows.append(row("headroom/hand-cap-0/inside/15", None, None, "infeasible"))
    rows.append(row("headroom/hand-cap-0/inside/30", None, 67.9))
    rows.append(row("hassan/inconsistency/gain", 57.5, 135.3, "misprint", note="a | b"))
    choe = [
        row("choe/example/length", 0.32058, 0.3237, "misprint"),
        row("choe/example/angle", 10.0, 10.0, "reproduced"),
        row("choe/fig-8/same-ends/symmetric-ellipse", None, 0.36125),
        row("choe/fig-8/same-ends/proposed", "shortest", "shortest", "reproduced", length_m=0.32373),
        row("choe/time/long/arc", None, 0.7, length_m=0.9),
        row("choe/saving/arc", None, 17.0),
        row("choe/nodes/count", None, 80.0),
    ]
    rows += [{**found, "paper": "choe", "unit": "m"} for found in choe]
    return {
        "command": "python -m agents.reproduce all",
        "versions": {"python": "3", "casadi": "3.7"},
        "seconds": {"hassan/table1": 3.0, "choe/example": 1.0},
        "papers": ["hassan", "choe"],
        "figures": {"hassan": ["hassan_free_direction.svg", "gone.svg"], "choe": []},
        "data": {},
        "rows": rows,
    }


@pytest.fixture
def results(tmp_path: Path) -> Path:
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "hassan_free_direction.svg").write_text("<?xml?>\n<svg>drawing</svg>\n")
    (tmp_path / "reproduction.json").write_text(json.dumps(record()))
    return tmp_path


@pytest.fixture
def chapters(results: Path) -> dict[str, Chapter]:
    return {chapter.title: chapter for chapter in read_chapters(results)}


def tables(chapter: Chapter) -> dict[str, list[list[str]]]:
    return {headline: cells(text) for headline, text in chapter.parts}


def test_every_paper_has_a_chapter(chapters: dict[str, Chapter]) -> None:
    assert list(chapters) == ["reproduction: Hassan et al. 2022", "reproduction: Choe et al. 2023"]
    for chapter in chapters.values():
        assert chapter.note
        for _, table in chapter.parts:
            assert len({len(line) for line in cells(table)}) == 1
            assert len(alignments(table)) == len(cells(table)[0])


def test_table_1_is_a_matrix_with_the_published_line_first(chapters: dict[str, Chapter]) -> None:
    lines = tables(chapters["reproduction: Hassan et al. 2022"])["Table I, published and reproduced"]
    assert lines == [
        [
            "picks/min", "inside 15 %", "inside 30 %", "inside 40 %", "outside 35 %", "outside 40 %", "outside 45 %",
            "peak acceleration",
        ],
        ["minimum-time throw, published", "30", "68", "120", "-", "-", "-", "-"],
        ["minimum-time throw, paper clock", "15.0", "34.0", "60.0", "-", "-", "-", "2.00 A"],
        ["minimum-time throw, within the limits", "30.0", "68.0", "120.0", "-", "-", "-", "1.00 A"],
        ["free direction, optimum", "31.0", "31.0", "-", "-", "-", "-", "1.00 A"],
    ]  # fmt: skip


def test_the_simulator_has_its_own_matrix(chapters: dict[str, Chapter]) -> None:
    found = tables(chapters["reproduction: Hassan et al. 2022"])
    (lines,) = (table for headline, table in found.items() if "simulator" in headline)
    by_name = {line[0]: line[1:] for line in lines}
    assert by_name["minimum-time throw, paper clock"] == [
        "7.1 mm, 4/9", "7.1 mm, 4/9", "7.1 mm, 4/9", "-", "-", "-", "0/27", "3/27", "140 N m",
    ]  # fmt: skip
    assert by_name["free direction, optimum"][-3:] == ["0/18", "0/18", "140 N m"]


def test_infeasible_cells_and_misprints_are_shown(chapters: dict[str, Chapter]) -> None:
    found = tables(chapters["reproduction: Hassan et al. 2022"])
    capped = next(line for line in found["Release in a free direction, and what bounds cost"] if "not above" in line[0])
    assert capped[1:3] == ["infeasible", "67.9"]
    quick = {line[0]: line[1:4] for line in found["Free direction, planned per pick"]}
    assert quick["loss of picks/min against the optimum"] == ["2.1 %", "-", "3.5 %"]
    assert quick["of them straight"] == ["-", "-", "2"]
    assert quick["processor time per pick"] == ["-", "-", "812 us"]
    odd = found["Hassan et al. 2022: what does not agree"]
    assert odd[1:] == [["gain", "57.5 picks/min", "135.3 picks/min", "misprint", "a | b"]]
    other = tables(chapters["reproduction: Choe et al. 2023"])
    assert other["The published example"][1:] == [
        ["example length", "0.32058 m", "0.3237 m", "misprint", "a note"],
        ["example angle", "10 m", "10 m", "reproduced", "a note"],
    ]
    (lengths,) = (table for headline, table in other.items() if headline.startswith("Lengths"))
    assert lengths[1][:5] == ["same ends", "0.3237 m", "0.3613 m", "-", "-"]
    (times,) = (table for headline, table in other.items() if headline.startswith("Time of a pick-and-place"))
    assert times[1:] == [["arc", "0.700 s", "0.900 m", "-", "-", "17.0 %", "-", "-", "-"]]
    assert other["Further figures"][1:] == [["nodes count", "-", "80 m", "a note"]]


def test_only_drawings_that_exist_are_in_the_page(results: Path, chapters: dict[str, Chapter]) -> None:
    figures = chapters["reproduction: Hassan et al. 2022"].figures
    assert set(figures) == {"hassan_free_direction.svg", "hassan_picks_per_min.svg"}
    text = page(list(chapters.values()))
    assert "<svg>drawing</svg>" in text
    assert '<td class="left">a | b</td>' in text
    main(Arguments(results, results / "none.md"))
    written = (results / "README.md").read_text()
    for name in figures:
        assert f"(figures/{name})" in written
        assert (results / "figures" / name).is_file()


def test_a_readme_shows_table_1(results: Path) -> None:
    readme = results / "readme.md"
    readme.write_text("<!-- table:reproduction -->\n<!-- /table -->\n")
    assert stale_readme(readme, results)
    text = with_blocks(readme.read_text(), results)
    assert "| minimum-time throw, published | 30 | 68 | 120 |" in text
    assert "Paper clock: 2.9 % off on average, 5.5 % at worst." in text
    assert "up to 0.13 m above" in text


def test_the_terminal_shows_the_headlines() -> None:
    found = {grid.headline: grid for grid in headlines(record())}
    assert found["Table I, published and reproduced"] == table1(of_paper(record(), "hassan"))
    assert ["misprint", "1"] in found["Choe et al. 2023: verdicts"].rows
    assert not any("methods" in headline for headline in found)


def test_other_files_of_published_figures_keep_their_plain_table(tmp_path: Path) -> None:
    rows = [{"quantity": "a", "published": None, "reproduced": 2.0, "unit": "m", "verdict": "ours", "note": "b | c"}]
    (tmp_path / "other.json").write_text(json.dumps({"rows": rows}))
    (chapter,) = read_chapters(tmp_path)
    ((_, table),) = chapter.parts
    assert cells(table)[1] == ["a", "-", "2", "m", "ours", "b | c"]

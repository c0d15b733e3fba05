"""Tables that print themselves: what stands in a cell is text, whatever it holds."""

import io
import re
from html.parser import HTMLParser

import pytest
from markdown_it import MarkdownIt
from rich.console import Console

from agents.ground.tables import Grid, html_text, markdown_text, settings_text
from agents.judging.throw_record import ThrowRecord

GRID = Grid("what [it] shows", ["name", "mm", "verdict", "note"], [["a|b", "1.5", "ours", "<b>x</b> & y"]], "under it")


class Cells(HTMLParser):
    """Texts and classes of a page's cells; fails on tags that no table has."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.texts: list[str] = []
        self.classes: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag in ("table", "thead", "tbody", "tr", "th", "td")
        if tag in ("th", "td"):
            self.classes.append(dict(attrs).get("class") or "")
            self.texts.append("")

    def handle_data(self, data: str) -> None:
        if self.texts:
            self.texts[-1] += data.strip("\n")


def test_settings_stand_on_one_line_whatever_they_are() -> None:
    settings = {"patience": 1.40, "weights": {"cycle": -0.5, "wait": 2.0}, "guide": "runs/own"}
    assert settings_text(settings) == "patience 1.4, weights (cycle -0.5, wait 2), guide runs/own"


def test_markdown_escapes_bars_and_tags() -> None:
    assert GRID.markdown().splitlines() == [
        "| name | mm | verdict | note |",
        "| --- | ---: | --- | --- |",
        r"| a\|b | 1.5 | ours | \<b>x\</b> & y |",
    ]


def test_names_of_columns_are_escaped_too() -> None:
    grid = Grid("", ["<i>a", "b|c"], [])
    assert grid.markdown().splitlines()[0] == r"| \<i>a | b\|c |"
    assert Cells(grid.html()).texts == ["<i>a", "b|c"]


@pytest.mark.parametrize(
    ("text", "written"),
    [
        ("two\nlines\r\nhere", "two lines here"),
        ("< 2.5 mm and <3", "< 2.5 mm and <3"),
        ("<script>", r"\<script>"),
        ("</td>", r"\</td>"),
        ("<!-- x -->", r"\<!-- x -->"),
        ("|", r"\|"),
        ("`code`", "`code`"),
        ("x [1] y", "x [1] y"),
        ("[a](javascript:alert(1))", r"[a\](javascript:alert(1))"),
    ],
)
def test_text_stays_one_line_of_text(text: str, written: str) -> None:
    assert markdown_text(text) == written


TEXT = ("[a](javascript:alert(1))", "[a][b]", "[a]: b", "![a](b)", "<b>x", "<javascript:x>", "a|b", "a & b", "[a]")


@pytest.mark.parametrize("escapes", ["", "\\", "\\\\", "\\\\\\"])
@pytest.mark.parametrize("text", TEXT)
def test_no_text_in_a_cell_is_a_link_a_picture_or_a_tag(text: str, escapes: str) -> None:
    own = re.sub(r"([]|<])", lambda found: escapes + found[1], text)
    page = Grid("", ("a", "b"), [(own, "1")]).markdown() + "\n\n[b]: javascript:x\n"
    html = MarkdownIt("commonmark").enable("table").render(page)
    assert not re.search(r"<(a|img|b|script)\b", html), html
    assert html.count("<td") == 2


def test_html_has_code_between_backticks_and_nothing_else() -> None:
    assert html_text("`a<b>` & <i>, a ` alone") == "<code>a&lt;b&gt;</code> &amp; &lt;i&gt;, a ` alone"


def test_html_escapes_tags_and_aligns_figures_to_the_right() -> None:
    cells = Cells(GRID.html())
    assert cells.texts == ["name", "mm", "verdict", "note", "a|b", "1.5", "ours", "<b>x</b> & y"]
    assert cells.classes == ["left", "", "left", "left"] * 2
    hostile = Grid("", ['"><script>'], [["<script>alert('x')</script>"]])
    assert Cells(hostile.html()).texts == ['"><script>', "<script>alert('x')</script>"]


@pytest.mark.parametrize(
    ("cells", "dashes"),
    [
        (("1.5 mm", "-", "+3 % (+1..+5)"), "---:"),
        (("< 2", "(3)", "-0.4"), "---:"),
        (("none", "1.25", "2"), "---:"),
        (("more than 5", "3", "2"), "---:"),
        (("-", "", "-"), "---:"),
        (("`pair` +1 %", "`atc` 2", "-"), "---"),
        (("waste", "flight, 2 cores", "3"), "---"),
        (("v1", "v2", "v3"), "---"),
    ],
)
def test_a_column_is_one_of_figures_if_most_of_its_cells_are(cells: tuple[str, ...], dashes: str) -> None:
    grid = Grid("", ["who", "what"], [["1", cell] for cell in cells])
    assert grid.markdown().splitlines()[1] == f"| --- | {dashes} |"


def test_rows_of_another_length_are_a_mistake() -> None:
    with pytest.raises(ValueError, match="shorter"):
        Grid("", ["a", "b"], [["x"]]).html()


def test_the_terminal_shows_brackets_and_aligns_long_text_to_the_left() -> None:
    screen = Console(width=120, record=True, file=io.StringIO())
    screen.print(
        Grid("t [1]", ["a", "[b]", "c"], [["[red]x", "1", "a sentence that is longer than any figure"]]).terminal()
    )
    text = screen.export_text()
    for shown in ("t [1]", "[b]", "[red]x"):
        assert shown in text


def test_controllers_are_compared_side_by_side() -> None:
    figures = {"landing_error_mean_m": 0.012, "landing_error_p95_m": 0.03, "success_rate": 0.9, "success_low": 0.8}
    more = {"landing_near_share": 0.875, "success_high": 0.95, "picks_per_min": 41.26, "sorted_per_min": 37.1}
    table = ThrowRecord.comparison("title", [("ridge", 30, {**figures, **more}), ("analytic", 0, {**figures, **more})])
    assert [list(column.cells) for column in table.columns] == [
        ["ridge", "analytic"], ["30 throws", "-"], ["12.0 mm"] * 2, ["30.0 mm"] * 2, ["87.5 %"] * 2,
        ["90.0 % (80.0..95.0)"] * 2, ["41.3"] * 2, ["37.1"] * 2,
    ]  # fmt: skip

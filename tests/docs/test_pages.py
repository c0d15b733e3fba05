"""What the site makes of code, levels and registry: everything is there, and says what it should."""

import re
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from numpy.typing import ArrayLike
from sphinx.util.typing import stringify_annotation

import pnt_gym
from agents.controllers import NAMES
from agents.dispatchers.registry import NAMES as LINE_NAMES
from agents.ground.console import COMMANDS
from agents.ground.levels import FAMILIES
from agents.report.blocks import fill
from agents.reproduce.papers import PAPERS, package
from docs.pages import (
    breaks,
    cite,
    commands,
    controllers,
    docstrings,
    environments,
    items,
    levels,
    made,
    papers,
    size,
    texts,
)
from pnt_gym.arrays import Floats
from pnt_gym.cells.base.catalogue import CATALOGUE
from pnt_gym.cells.conveyor.config import ConveyorConfig
from tests.tools.throws import same_bits

DOCS = Path(__file__).resolve().parents[2] / "docs"
README = (DOCS.parent / "README.md").read_text(encoding="utf-8")
MOST_BYTES = 900_000


pytestmark = pytest.mark.usefixtures("results_as_they_stand")


def names(text):
    """First cells of a table's rows, without their marks."""
    rows = [line for line in text.splitlines() if line.startswith("|")][2:]
    return [re.sub(r"^\[(.*)\]\(.*\)$", r"\1", row.split("|")[1].strip()).strip("`") for row in rows]


@pytest.mark.parametrize("family", FAMILIES)
def test_every_shipped_level_is_in_its_table_and_leads_to_its_file(family):
    config, table = FAMILIES[family], levels.level_table(family)
    assert sorted(names(table)) == sorted(config.level_names())
    files = [made.ROOT / "docs" / target for target in re.findall(r"\]\((.*?)\)", table.replace("(arXiv", ""))]
    assert [file.stem for file in files] == names(table)
    assert all(file.is_file() for file in files)
    assert "| `waste` |" in table or family != "PnT"  # what `tight` differs from


def test_settings_reach_into_sections_lists_and_alternatives():
    said = names(levels.setting_table("PnT"))
    assert {"motion.dwell", "bins.fixed", "bins.fixed[].accepts", "bins.random", "bins.random.side"} <= set(said)
    assert len(said) == len(set(said)) > 60
    assert ConveyorConfig.load().motion.dwell == 0.1
    assert "| `motion.dwell` | `0.1` |" in levels.setting_table("PnT")


def test_every_item_of_the_catalogue_is_listed():
    assert {name for which in items.SETS for name in names(items.item_table(which))} == set(CATALOGUE)
    assert {"mass", "drag", "seal_force", "source"} <= set(names(items.key_table("")))


def test_every_controller_is_described_and_tried_everywhere():
    table = controllers.controller_table("")
    assert tuple(names(table)) == NAMES
    rows = dict(zip(NAMES, table.splitlines()[2:], strict=True))
    assert rows["ridge"].startswith("| `ridge` | yes | all that throw |")
    assert rows["oracle"].startswith("| `oracle` | no | all that throw |")
    assert rows["kalman"].startswith("| `kalman` | yes | `PnTAdapt-v0` |")
    assert tuple(names(controllers.line_controller_table(""))) == LINE_NAMES


def test_every_command_shows_its_help():
    said = commands.command_help("")
    assert names(commands.command_table("")) == [f"pnt-gym {name}" for name in COMMANDS]
    for name in COMMANDS:
        assert f"### `pnt-gym {name}`" in said
        assert f"```text\npnt-gym {name} [-h]" in said
    assert str(DOCS.parent) not in said + commands.command_help("checkout")


@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_every_environment_has_a_page_and_a_small_picture(env_id):
    assert made.hand_text((DOCS / "environments" / f"{env_id}.md").read_text()) == "\n"
    text = environments.page(env_id)
    assert text.startswith(f"# {env_id}\n")
    assert "## Action Space" in text
    picture = (DOCS / "pictures" / f"{env_id}.webp").read_bytes()
    assert picture[8:12] == b"WEBP"
    assert b"ANIM" in picture[:64]
    assert len(picture) <= MOST_BYTES


def test_a_page_names_the_levels_that_its_environment_takes():
    taken = {env_id: set(environments.levels(env_id)) for env_id in pnt_gym.ENV_IDS}
    drift = {"day", "steps", "drift_mix", "day_far", "steps_far", "drift_mix_far"}
    assert taken["PnTAdapt-v0"] == set(ConveyorConfig.level_names()) > drift
    assert taken["PnTConveyor-v0"] == taken["PnTRelease-v0"] == taken["PnTAdapt-v0"] - drift
    assert taken["OneJointThrow-v0"] - taken["OneJointSort-v0"] == {"paper"}
    assert "`day`" in environments.page("PnTAdapt-v0")
    assert "`day`" not in environments.page("PnTConveyor-v0")


@pytest.mark.parametrize("env_id", [env_id for env_id in pnt_gym.ENV_IDS if env_id != "PnTLine-v0"])
def test_what_is_hidden_is_on_the_page_of_datasets(env_id):
    shown = re.findall(r"^<!-- made: hidden (.*) -->$", (DOCS / "datasets.md").read_text(), flags=re.MULTILINE)
    assert shown
    rows = names(environments.hidden_table(env_id))
    assert rows in [names(environments.hidden_table(shown_id)) for shown_id in shown]
    assert rows == [*environments.default_env(env_id).core.hidden()]


@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_a_bandit_is_what_no_action_changes(env_id):
    """The kind that page and README name is that of the code, and shows in what comes after different actions."""
    kind = environments.kind(env_id)
    (row,) = re.findall(rf"^\| `{env_id}` \|.*\| (.*?) \|$", README, flags=re.MULTILINE)
    assert row == kind
    following = []
    for first in (-0.3, 0.3):
        env = gym.make_vec(env_id, num_envs=8)
        env.reset(seed=3)
        action = np.zeros(env.action_space.shape, dtype=env.action_space.dtype)
        if env_id == "PnTLine-v0":
            action[:] = first > 0
        else:
            action[:, 0] = first
        following.append(env.step(action)[0])
        env.close()
    assert same_bits(*following) == (kind == environments.BANDIT)


def test_pages_of_results_become_pages_of_the_site():
    text = "![a](figures/cup.svg) [b](../docs/levels.md#c) [d](grasp.md)"
    site = "![a](../../results/figures/cup.svg) [b](../levels.md#c) [d](grasp.md)"
    assert made.results_page(text) == site


def test_links_to_other_files_lead_to_their_texts(tmp_path):
    page, guide = made.RESULTS / "cup.md", DOCS / "papers" / "hassan.md"
    text = "[a\nb](tables/cup.md#c) [d](grasp.md) [e](../docs/levels.md) ![f](tables/cup.md) [g](none.md)"
    linked = text.replace("[a\nb](tables/cup.md#c)", '<a href="../files/results/tables/cup.md.txt">a\nb</a>')
    assert texts.link_texts(text, page) == linked
    assert 'href="../files/CHANGELOG.md.txt"' in texts.link_texts("[a](../../CHANGELOG.md)", guide)
    texts.write_texts({page: text}, tmp_path)
    (file,) = (file for file in tmp_path.rglob("*") if file.is_file())
    assert file == tmp_path / "files/results/tables/cup.md.txt"
    assert "rigid        " in file.read_text()
    assert texts.aligned("| a | bb |\n| --- | ---: |\n| ccc | 1 |\n") == "a    bb\n---  --\nccc   1\n"


def test_words_of_a_page_are_those_of_its_article(tmp_path):
    page = "<nav>no word</nav><article><h1>Two words</h1><p>and <b>three</b> more</p></article><p>none</p>"
    (tmp_path / "a.html").write_text(page)
    assert size.page_words(tmp_path) == {"a.html": 5}


def test_the_site_is_one_to_be_read():
    """By its sources, without the reference, whose words are those of the code; the build counts everything."""
    pages = [*made.page_files(), *made.results_files()]
    words = sum(len(made.site_page(page.read_text(encoding="utf-8")).split()) for page in pages)
    assert len(pages) + 2 <= size.MOST_PAGES  # the tour and the search
    assert words <= size.MOST_WORDS


def test_the_citation_is_that_of_the_file():
    said = cite.citation("")
    assert "doi = {10.1109/TMECH.2022.3164247}" in said
    assert "author = {{The pnt_gym maintainers}}" in said
    assert said.count("@article{") == 4


def test_arrays_are_called_by_their_names():
    plain = stringify_annotation(Floats, "smart")
    assert docstrings.shorten_signature(f"(a: {plain})") == "(a: NDArray[~numpy.float64])"
    assert docstrings.shorten_signature(stringify_annotation(ArrayLike | None, "smart")) == "ArrayLike | None"
    assert (
        docstrings.shorten_signature("~numpy._typing.ArrayLike | None") == "ArrayLike | None"
    )  # as from Python 3.12 on
    assert docstrings.shorten_signature("(a: ~typing.Any = <factory>)") == "(a: ~typing.Any = ...)"
    assert docstrings.shorten_signature(None) is None


def test_marked_blocks_are_filled_and_unknown_ones_refused():
    stale = "a\n<!-- made: levels PnT -->\nold\n<!-- /made -->\nb"
    assert made.site_page(stale) == "a\nold\nb"
    assert made.hand_text(stale) == "a\n\nb"
    assert fill(stale, made.KINDS) == f"a\n<!-- made: levels PnT -->\n{levels.level_table('PnT')}\n<!-- /made -->\nb"
    other = "<!-- other: PnT -->\nold\n<!-- /other -->"
    assert fill(other, made.KINDS) == made.site_page(other) == other
    assert made.site_page('```python title="x/y.py"\n1\n```') == "```{code-block} python\n:caption: x/y.py\n\n1\n```"
    assert "| analytic |" in fill("<!-- table:benchmark -->\n<!-- /table -->", made.KINDS)
    with pytest.raises(KeyError):
        fill("<!-- made: nothing -->\n<!-- /made -->", made.KINDS)


@pytest.mark.parametrize("page", made.page_files(), ids=lambda page: page.relative_to(DOCS).as_posix())
def test_a_page_holds_what_is_made(page):
    """`make pages` writes it; each mark has its end, so that the site makes all of it."""
    text = page.read_text(encoding="utf-8")
    assert fill(text, made.KINDS) == text
    rest = fill(text, dict.fromkeys(made.KINDS, lambda _: ""), is_marked=False)
    for kind in made.KINDS:
        assert text.count(f"<!-- {kind}:") == text.count(f"<!-- /{kind} -->")
        assert f"<!-- {kind}:" not in rest


@pytest.mark.parametrize("paper", PAPERS)
def test_every_part_of_a_paper_says_what_it_computes(paper):
    table = papers.part_table(paper)
    assert names(table) == [*package(paper).PARTS]
    assert all(len(row.split("|")[2]) > 12 for row in table.splitlines()[2:])


def test_docstrings_are_text_and_code():
    lines = ["the |x| of a_ * b, `c_ * d`:", "", "    e = |f|", "after |g|"]
    assert docstrings.escape_docstring(lines) == [
        r"the \|x\| of a\_ \* b, `c_ * d`::",
        "",
        "    e = |f|",
        r"after \|g\|",
    ]
    assert docstrings.escape_docstring(["Args:", "    x: y"]) == ["Args:", "    x: y"]


def test_units_stay_with_their_numbers():
    assert breaks.UNIT.sub("_", "12.4 mm, 99.1 %; +1.0 (+0.8..+1.2) %") == "12.4_mm, 99.1_%; +1.0 (+0.8..+1.2)_%"
    assert breaks.UNIT.sub("_", "8 metres of 3 sizes") == "8 metres of 3 sizes"


NUMBERS = (
    "zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve",
    "thirteen", "fourteen", "fifteen",
)  # fmt: skip


def counts(things):
    """Numbers in words before a thing, in the README and in all pages."""
    pages = [DOCS.parent / "README.md", *DOCS.glob("*.md"), *DOCS.parent.glob("results/*.md")]
    text = " ".join(page.read_text(encoding="utf-8") for page in pages)
    words = re.findall(rf"\b({'|'.join(NUMBERS)})\s+{things}", text, re.IGNORECASE)
    return {NUMBERS.index(word.lower()) for word in words}


def test_pages_count_environments_and_questions_as_there_are():
    kinds = [environments.kind(env_id) for env_id in pnt_gym.ENV_IDS]
    pages = [*(DOCS.parent / "results").glob("*.md")]
    assert counts(r"environments\b(?! are sequences)") == {len(kinds)}
    assert counts(r"environments are sequences") == {kinds.count("sequential")}
    assert counts("bandits") == {kinds.count("contextual bandit")}
    assert counts("questions") == {len(pages) - 1}  # one page lists the others


PICTURES = sorted([*(DOCS / "pictures").iterdir(), *(DOCS.parent / "results" / "figures").iterdir()])
WIDEST = 520.0
"""Widest drawing whose text a phone still shows at a legible size [pt]."""


def test_every_picture_is_shown_on_a_page():
    pages = [DOCS.parent / "README.md", *DOCS.glob("*.md"), *DOCS.glob("[!_]*/*.md")]
    pages += [*DOCS.parent.glob("results/*.md"), *DOCS.parent.glob("results/tables/*.md")]
    text = "".join(page.read_text(encoding="utf-8") for page in pages)
    assert [path.name for path in PICTURES if path.name not in text] == []


def test_drawings_fit_the_width_of_a_phone():
    widths = {
        path.name: re.search(r'<svg[^>]*\swidth="([\d.]+)pt"', path.read_text("utf-8"))
        for path in PICTURES
        if path.suffix == ".svg"
    }
    assert {name: width[1] for name, width in widths.items() if width and float(width[1]) > WIDEST} == {}

"""Signs of life: a bar on a terminal, elsewhere a line on stderr now and then, of what is not done yet."""

import io
import re
import time
from collections.abc import Callable

import pytest
from rich.console import Console

from agents.ground import tables
from agents.ground.tables import throws_bar

Told = Callable[[str], str]


@pytest.fixture(autouse=True)
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lines come at once."""
    monkeypatch.setattr(tables, "FIRST", 0.01)
    monkeypatch.setattr(tables, "LONGEST", 0.02)


@pytest.fixture
def told(capsys: pytest.CaptureFixture[str]) -> Told:
    """Waits until a text has appeared on stderr; returns what appeared."""

    def wait(text: str) -> str:
        lines, end = "", time.monotonic() + 60.0
        while text not in lines and time.monotonic() < end:
            time.sleep(0.005)
            lines += capsys.readouterr().err
        return lines

    return wait


def test_a_line_tells_of_work_that_nobody_sees(told: Told) -> None:
    with throws_bar("interval") as bar:
        task = bar.add_task("rows thrown again", total=3, interval="")
        bar.update(task, advance=1, interval="2.5 mm")
        line = told("1/3 2.5 mm").splitlines()[-1]
        assert re.search(r"rows thrown again .* 1/3 2\.5 mm 0:\d\d:\d\d ", line)
        bar.update(task, advance=1, interval="2.5 mm")
        assert " 2/3 2.5 mm" in told("2/3")


def test_tasks_that_are_done_are_told_only_where_no_other_goes_on(told: Told) -> None:
    with throws_bar() as bar:
        bar.advance(bar.add_task("practice", total=1))
        assert "practice" in told("practice")  # the command may yet do what has no task
        second = bar.add_task("evaluation", total=2)
        told("evaluation")
        assert "practice" not in told("evaluation")
        bar.advance(second, 2)
        told("2/2")
        assert "practice" not in told("2/2")


def test_nothing_is_told_before_there_is_a_task_and_after_the_end(capsys: pytest.CaptureFixture[str]) -> None:
    with throws_bar() as bar:
        time.sleep(0.05)
        assert capsys.readouterr().err == ""
        bar.add_task("shifts", total=3)
    capsys.readouterr()
    time.sleep(0.05)
    assert capsys.readouterr() == ("", "")


def test_a_terminal_shows_the_bar_alone(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    text = io.StringIO()
    screen = Console(file=text, force_terminal=True, width=100)
    monkeypatch.setattr(tables, "console", lambda **_: screen)
    with throws_bar() as bar:
        bar.add_task("shifts", total=3)
        time.sleep(0.05)
    assert "shifts" in text.getvalue()
    assert capsys.readouterr() == ("", "")


def test_a_quiet_bar_shows_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with throws_bar(quiet=True) as bar:
        bar.advance(bar.add_task("sac on PnTConveyor-v0", total=3))
        time.sleep(0.05)
    assert capsys.readouterr() == ("", "")

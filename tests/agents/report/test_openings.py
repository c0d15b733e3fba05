"""What pages of results open with: five numbers, and bars that begin at zero in the colours of their controllers."""

import re

import pytest

from agents.ground.looks import LOOKS, colours, look, said
from agents.report.openings import OPENINGS, Opening, small_picture
from agents.report.questions import QUESTIONS


def test_every_question_has_an_opening_with_five_numbers():
    assert list(OPENINGS) == [question.name for question in QUESTIONS]
    assert {len(opening.numbers) for opening in OPENINGS.values()} == {5}
    assert all(2 <= len(opening.bars) <= 4 for opening in OPENINGS.values())
    assert small_picture("cup") == "small_cup.svg"


def test_bars_are_as_long_as_their_numbers():
    opening = Opening("{{ a }}", [("{{ a }}", "b")], "mm", [("analytic", "{{ a }} mm"), ("mine", "+1.5 % (1.0..2.0)")])
    drawn = opening.filled({"a": 3}).picture()
    bars = re.findall(r'width="([\d.]+)" height="16" fill="(#\w+)"', drawn)
    assert [float(width) for width, _ in bars] == pytest.approx([104.0, 52.0])
    assert bars[0][1] == LOOKS["analytic"].colour != bars[1][1]
    assert ">planner<" in drawn
    assert opening.filled({"a": 3}).markdown() == "* **3** b"


def test_a_controller_has_one_colour_whatever_it_learned_from():
    assert {colours([name])[name] for name in ("sac", "SAC", "SAC (10,000)", "sac, 40")} == {LOOKS["sac"].colour}
    assert look("mine") is None
    assert said("kalman") == "kalman: Kalman filter"
    assert said("mine") == "mine"
    together = colours(["analytic", "ridge", "mlp", "sac", "oracle", "mine", "yours"])
    assert len({*together.values()}) == len(together)

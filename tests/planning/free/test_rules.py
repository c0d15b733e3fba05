"""Rules that bind the hand: impossible numbers are refused."""

import numpy as np
import pytest

from pnt_gym.planning.free.rules import HandRules


def test_an_approach_of_no_height_is_refused() -> None:
    with pytest.raises(ValueError, match=r"approach must be finite and above 0 \[m\], got 0"):
        HandRules(approach=0.0)


@pytest.mark.parametrize("name", ["approach", "window", "clear_distance", "hand_cap", "margin"])
@pytest.mark.parametrize("value", [-0.01, np.nan, np.inf])
def test_bad_rules_are_refused(name: str, value: float) -> None:
    if name == "hand_cap" and value == np.inf:
        assert HandRules(hand_cap=np.inf).hand_cap == np.inf
        return
    with pytest.raises(ValueError, match=f"{name} must") as caught:
        HandRules(**{name: value})
    assert str(value) in str(caught.value)


def test_a_margin_of_one_is_refused() -> None:
    with pytest.raises(ValueError, match=r"margin must lie in \[0, 1\), got 1.0"):
        HandRules(margin=1.0)

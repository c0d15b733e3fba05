"""Settings of controllers as `agents.evaluate --option` reads them."""

from contextlib import closing

import pytest

from agents.ground.cli import UsageError, read_settings
from agents.judging import trials
from agents.judging.trials import open_trial


def test_values_are_numbers_lists_and_words() -> None:
    texts = ("gain=0.1", "diagonal=[0.1, 0.5]", "name=word", "empty=null", "equation=a=b")
    values = {"gain": 0.1, "diagonal": [0.1, 0.5], "name": "word", "empty": None, "equation": "a=b"}
    assert read_settings(texts) == values


@pytest.mark.parametrize("text", ["gain", "=0.1", "gain=", "a b=1", ""])
def test_what_is_no_setting_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match=r"is no NAME=VALUE, such as gain=0\.1"):
        read_settings([text])


def test_a_controller_takes_its_settings_and_refuses_others() -> None:
    with closing(open_trial("PnTRelease-v0", "ideal", 1, 1)) as trial:
        trials.controller(trial, "virtual_goal", read_settings(["gain=0.1"]))
        for name, option in (("virtual_goal", "width=3"), ("analytic", "gain=0.1")):
            with pytest.raises(UsageError, match=f"controller '{name}': unknown setting '{option.split('=')[0]}'"):
                trials.controller(trial, name, read_settings([option]))
        with pytest.raises(UsageError, match="controller 'virtual_goal' cannot have gain='fast': "):
            trials.controller(trial, "virtual_goal", read_settings(["gain=fast"]))

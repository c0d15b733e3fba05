"""The sentence about an unknown name, and the functions of the package that take names from Python."""

import pytest

import pnt_gym
from pnt_gym.errors import PntGymError
from pnt_gym.names import closest_name, unknown_name, unknown_names

MANY = [f"level_{letter}{other}" for letter in "abcdefghij" for other in "klmnopqrst"]


@pytest.mark.parametrize(
    ("name", "known", "meant"),
    [
        ("levle", ("level", "mismatch"), "level"),
        ("LEVEL", ("level",), "level"),
        ("release-point", ("release_point", "release_xyz"), "release_point"),
        ("wast", ("PnT/waste", "PnT/fast"), "PnT/waste"),
        ("waste-sak", ("shipped:waste-sac", "shipped:line/value"), "shipped:waste-sac"),
        ("pallet_4", ("pallet_1", "pallet_2"), None),  # as much the one as the other
        ("", ("level",), None),
        (5, ("level",), None),
        ("level", (), None),
    ],
)
def test_what_was_perhaps_meant(name: object, known: tuple[str, ...], meant: str | None) -> None:
    assert closest_name(name, known) == meant


def test_all_names_are_told_where_there_is_room_and_the_closest_otherwise() -> None:
    assert (
        unknown_name("bin", "lft", ("left", "right")) == "unknown bin 'lft'; did you mean 'left'? known are left, right"
    )
    assert (
        unknown_name("bin", 3, ("left", "right"), ", or a number")
        == "unknown bin 3; known are left, right, or a number"
    )
    assert unknown_name("bin", "left", ()) == "unknown bin 'left'; there is none"
    assert (
        unknown_names("bin", ["lft", "up"], ["left"])
        == "unknown bins 'lft' and 'up'; did you mean 'left'? known are left"
    )
    sentence = unknown_name("level", "level_gpx", MANY)
    assert len(sentence) < 300
    assert " known are level_gp, " in sentence
    listed, more = sentence.partition("known are ")[2].removesuffix(" more").split(" and ")
    assert len(listed.split(", ")) + int(more) == len(MANY)
    assert len(unknown_name("level", "x" * 9999, MANY, room=40)) < 200


def policy(observations):
    return observations[:, :2]


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda: pnt_gym.evaluate(policy, "PnTRelease-v0", levle="waste"),
            "unknown argument 'levle'; did you mean 'level'?",
        ),
        (lambda: pnt_gym.evaluate(policy, "PnTRelease-v0", practise=4), "'practise'; did you mean 'practice'?"),
        (lambda: pnt_gym.compare("analytic", "mlp", "PnTRelease-v0", figure=["success"]), "did you mean 'figures'?"),
        (
            lambda: pnt_gym.compare("analytic", "mlp", "PnTRelease-v0", figures=["success", "success"]),
            "figures: 'success' is given 2 times; give it once",
        ),
        (lambda: pnt_gym.compare("analytic", "analytic", "PnTRelease-v0"), "'analytic'"),
        (lambda: pnt_gym.fit("log.csv", "waste", fre=["drag"]), "unknown argument 'fre'; did you mean 'free'?"),
        (lambda: pnt_gym.fit("log.csv", "waste", free=["drg"]), "free: unknown parameter 'drg'; did you mean 'drag'?"),
        (lambda: pnt_gym.fit("log.csv", "waste", free=["drag", "drag"]), "free: 'drag' is given 2 times"),
        (lambda: pnt_gym.plan_line("skills3", robot=2), "unknown argument 'robot'; did you mean 'robots'?"),
        (lambda: pnt_gym.plan_line("skills3", robots=(2, 2)), "robots: 2 is given 2 times"),
        (lambda: pnt_gym.plan_line("skills3", down="secnd:1"), "--down: unknown robot 'secnd'; did you mean 'second'?"),
        (lambda: pnt_gym.shipped_policy("waste-sak"), "did you mean 'shipped:waste-sac'?"),
    ],
)
def test_functions_of_the_package_refuse_what_they_do_not_know(call, said) -> None:
    with pytest.raises(PntGymError) as caught:
        call()
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)

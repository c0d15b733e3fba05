"""How controllers of a line are judged: by command, from Python, and on the same streams."""

from __future__ import annotations

import numpy as np
import pytest

from agents.environments import make_vector
from agents.evaluation import evaluate
from agents.line.evaluation import judged, worked
from agents.line.looking import Beam
from agents.line.making import line_controller, line_of
from agents.line.rules import Index
from pnt_gym.cells.line.observation import decoded
from tests.tools.commands import answer, call, call_here

LEVEL = {"base": "value", "duration": 10.0}
CONTRACT = {
    "env", "controller", "level", "seed", "picks", "picks_per_min", "sorted_per_min", "success_rate", "success_low",
    "success_high", "cycle_time_mean_s", "dwell_s", "throws", "recovery", "purity", "pick_rate", "value_per_min",
    "utilisation",
}  # fmt: skip


def lines(level=LEVEL, rows=4):
    env = make_vector("PnTLine-v0", level, rows, 1)
    return env, line_of(env)


def test_the_command_writes_the_contract_and_a_picture(tmp_path):
    (tmp_path / "short.yaml").write_text("base: skills3\nduration: 6.0\n")
    given = (
        "--env",
        "PnTLine-v0",
        "--level",
        "short.yaml",
        "--controller",
        "price",
        "--shifts",
        "3",
        "--num-envs",
        "2",
    )
    run = call("agents.evaluate", *given, "--json", "out.json", "--picture", "who.svg", folder=tmp_path)
    told = answer(run, tmp_path / "out.json")
    assert set(told) >= CONTRACT
    assert told["shifts"] == len(told["by_shift"]["value_per_min"]) == 3
    assert len(told["throws"]) == told["picks"]
    assert {one["shift"] for one in told["throws"]} == {0, 1, 2}
    assert len(told["utilisation"]) == len(told["robots"]) == 3
    sorted_ = sum(one["sorted"] and one["start"] + one["cycle_time"] <= 6.0 for one in told["throws"])
    assert sorted_ == sum(told["by_shift"]["sorted"])
    assert (tmp_path / "who.svg").read_text().startswith("<?xml")


def test_the_first_shifts_of_many_are_those_of_few():
    few, many = (worked(Index("atc", "atc"), lines()[0], count, 5) for count in (4, 9))
    np.testing.assert_array_equal(few.value, many.value[:4])
    assert len(many.value) == 9


def test_whoever_decides_meets_the_same_objects():
    seen = []
    for name in ("fifo", "atc"):
        env, core = lines()
        worked(line_controller(name, core), env, 4, 5)
        env.reset(seed=5)
        seen.append((core.cell.stream.x, core.cell.stream.worth, core.cell.stream.objects.kind))
    for one, other in zip(*seen, strict=True):
        np.testing.assert_array_equal(one, other)


def test_value_is_what_was_brought_in():
    env, core = lines()
    told = judged(line_controller("atc", core), env, 4, 0)
    gained = np.bincount([one["shift"] for one in told["throws"]], [one["value"] for one in told["throws"]])
    np.testing.assert_allclose(60.0 * gained / 10.0, told["by_shift"]["value_per_min"])
    assert told["value_per_min"] == pytest.approx(np.mean(told["by_shift"]["value_per_min"]))


def test_rules_take_what_their_name_says():
    env, core = lines()
    features, _ = env.reset(seed=2)
    own = decoded(features).choices
    there = own["real"] > 0.5
    for name, key in (("fifo", own["lift"] + own["slack"]), ("spt", own["cycle"]), ("value_rate", -own["ln_rate"])):
        found = line_controller(name, core).act(type("Seen", (), {"features": features}))
        np.testing.assert_array_equal(found, np.where(there, key, np.inf).argmin(axis=1))


def test_price_leaves_to_others_what_they_can_take():
    env, _ = lines({"base": "skills3", "duration": 10.0})
    features, _ = env.reset(seed=2)
    own = decoded(features)
    plain, leaving = (Index("price", "atc", 1.0, share).worth(own) for share in (0.0, 0.5))
    shared = (own.choices["heirs"] > 0.5) & (own.choices["real"] > 0.5)
    assert shared.any()
    np.testing.assert_allclose(leaving[shared], 0.5 * plain[shared])
    np.testing.assert_array_equal(leaving[~shared], plain[~shared])


def test_a_beam_of_one_decision_takes_the_first_choice():
    env, core = lines()
    env.reset(seed=3)
    beam = Beam("beam", core, price=core.config.price_of_time, depth=0)
    assert (beam.act(None) == 0).all()  # choices stand in the order of value less the price of their time


def test_a_beam_that_leaves_to_others_counts_their_objects_for_less():
    # Robots that are alike: whatever the first two can take somebody can after them, and nobody comes after the third.
    env, core = lines({"base": "line3", "duration": 10.0})
    env.reset(seed=4)
    leaving, cheaper = Beam("price_beam", core, price=1.0, share=0.6), Beam("beam", core, price=2.5)
    plain, whose = Beam("beam", core, price=1.0), []
    for _ in range(30):
        robot, action = core.cell.state.robot.copy(), leaving.act(None)
        expected = np.where(robot < 2, cheaper.act(None), plain.act(None))
        np.testing.assert_array_equal(action, expected)
        whose.append(robot)
        env.step(action)
    assert {0, 1, 2} == set(np.concatenate(whose).tolist())


def test_a_beam_knows_nothing_that_is_hidden():
    env, core = lines({"base": "skills3", "duration": 10.0})
    env.reset(seed=3)
    beams = [Beam("beam", core), Beam("joint_beam", core, joint=True)]
    before = [beam.act(None) for beam in beams]
    stream = core.cell.stream
    stream.luck[:] = 1.0 - stream.luck
    for hidden in ("pick_draw", "mass", "seal", "delay", "kind"):
        values = getattr(stream.objects, hidden)
        values[:] = np.roll(values, 1, axis=1)
    for beam, choice in zip(beams, before, strict=True):
        np.testing.assert_array_equal(beam.act(None), choice)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("--controller", "mlp"), "is no controller of a line"),
        (("--controller", "atc", "--picks", "9"), "--picks goes with throws"),
        (("--controller", "atc", "--release", "ridge"), "set `throws` to 'flight' or 'full'"),
        (("--controller", "atc", "--shifts", "0"), "--shifts is 0"),
        (("--controller", "atc", "--level", "waste"), "unknown level 'waste'"),
        (("--controller", "atc", "--throws", "flight", "--release", "atc"), "'atc' is neither a controller"),
    ],
)
def test_bad_usage_is_one_sentence(given, said, tmp_path):
    run = call_here("agents.evaluate", "--env", "PnTLine-v0", *given, folder=tmp_path)
    assert run.returncode == 2
    assert said in run.stderr
    assert len(run.stderr.strip().splitlines()) == 1


def test_shifts_are_not_for_throws(tmp_path):
    run = call_here(
        "agents.evaluate", "--env", "PnTRelease-v0", "--controller", "analytic", "--shifts", "2", folder=tmp_path
    )
    assert (run.returncode, "--shifts goes with a line" in run.stderr) == (2, True)


def test_a_learned_release_goes_on_the_line(tmp_path):
    (tmp_path / "short.yaml").write_text("base: single\nduration: 5.0\n")
    given = ("--env", "PnTLine-v0", "--level", "short.yaml", "--controller", "atc", "--shifts", "1", "--num-envs", "1")
    told = []
    for release in ("analytic", "analytic_height"):
        more = ("--throws", "flight", "--release", release, "--json", f"{release}.json")
        run = call_here("agents.evaluate", *given, *more, folder=tmp_path)
        told.append(answer(run, tmp_path / f"{release}.json"))
    assert [one["release"] for one in told] == ["analytic", "analytic_height"]
    assert told[0]["throws"][0]["start"] == told[1]["throws"][0]["start"]


def test_from_python_by_name_and_by_function():
    how = {"level": {"base": "single", "duration": 5.0}, "num_envs": 2}
    told = evaluate("atc", "PnTLine-v0", 3, **how)
    assert (told["env"], told["controller"], told["shifts"]) == ("PnTLine-v0", "atc", 3)
    first = evaluate(lambda observations: np.zeros(len(observations)), "PnTLine-v0", 3, **how)
    assert first["controller"] == "function"
    assert first["invalid_actions"] == 0

"""Looking ahead at a line: what planners take, alone and beside a scorer."""

import numpy as np
import pytest

from agents.dispatchers import decisions, lookahead, registry
from agents.dispatchers.lookahead import Beam, GuidedBeam
from agents.dispatchers.rules import ScoreController
from agents.dispatchers.settings import settings
from agents.ground.cli import UsageError
from pnt_gym.arrays import take
from pnt_gym.cells.line.observation import decoded
from pnt_gym.cells.line.rows import CHOICES
from tests.tools.line import vector_lines

LEVEL = {"base": "value", "duration": 10.0}
THREE = {"base": "skills3", "duration": 10.0}
WHOLE = {"price": 1.0, "depth": 1, "width": 10**6, "horizon": 4.0}
"""Every plan of two decisions."""


def test_a_beam_of_one_decision_takes_the_first_choice():
    env, core = vector_lines(LEVEL)
    env.reset(seed=3)
    beam = Beam("beam", core, price=core.config.price_of_time, depth=0)
    assert (beam.act(None) == 0).all()  # choices stand in the order of value less the price of their time


def test_a_beam_that_leaves_to_others_counts_their_objects_for_less():
    # Robots that are alike: whatever the first two can take in these shifts somebody can after them, and nobody comes
    # after the third.
    env, core = vector_lines({"base": "line3", "duration": 10.0})
    env.reset(seed=6)
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
    env, core = vector_lines(THREE)
    env.reset(seed=3)
    beams = [Beam("beam", core), Beam("price_beam", core, share=0.5)]
    before = [beam.act(None) for beam in beams]
    riders = core.cell.stream.riders
    riders["luck"] = 1.0 - riders["luck"]
    for hidden in ("seal", "kind", "height"):
        riders[hidden] = np.roll(riders[hidden], 1, axis=1)
    for beam, choice in zip(beams, before, strict=True):
        np.testing.assert_array_equal(beam.act(None), choice)


def test_an_outlook_holds_what_sensors_report_and_no_truth():
    env, core = vector_lines(THREE)
    env.reset(seed=3)
    known = lookahead.observe(core)
    riders, seen = known.riders, known.sight.seen
    assert np.isnan([riders["seal"], riders["luck"]]).all()
    assert (riders["kind"] == -1).all()
    true = take(core.cell.stream.objects, (np.arange(4)[:, None], seen["index"]))
    np.testing.assert_array_equal(riders["height"], true.measured.size[..., 2])
    np.testing.assert_array_equal(seen["kind"], true.measured.kind)


def met(env, seed, steps=12):
    """What is seen on the way of the first choice."""
    features, _ = env.reset(seed=seed)
    for _ in range(steps):
        yield decisions.observe(features)
        features = env.step(np.zeros(env.num_envs, dtype=np.int64))[0]


def indifferent():
    return ScoreController("same", lambda seen: np.zeros((len(seen), CHOICES)))


@pytest.mark.parametrize("level", [LEVEL, THREE])
def test_without_trust_or_with_one_choice_the_guide_decides(level):
    env, core = vector_lines(level)
    own = registry.make("index", core, weights={"pick_x": 0.7, "cycle": -0.4})
    for changes in ({"trust": 0.0}, {"few": 1}):
        guided = GuidedBeam("guided_beam", core, own, **changes)
        for seen in met(env, 2):
            np.testing.assert_array_equal(guided.act(seen), own.act(seen))


def test_without_a_guide_of_any_opinion_the_best_plan_decides():
    env, core = vector_lines(LEVEL)
    beam, guided = Beam("beam", core, **WHOLE), GuidedBeam("guided_beam", core, indifferent(), few=CHOICES, **WHOLE)
    differs = 0
    for seen in met(env, 3):
        np.testing.assert_array_equal(guided.act(seen), beam.act(seen))
        differs += int((beam.act(seen) != 0).sum())
    assert differs > 0


def test_what_is_added_to_the_scores_is_what_plans_are_worth():
    """Plans of one decision are worth value x chance less the price of their time."""
    env, core = vector_lines(THREE)
    own = registry.make("index", core, weights={"pick_x": 3.0})
    guided = GuidedBeam("guided_beam", core, own, few=3, trust=8.0, price=0.5, depth=0)
    moved = 0
    for seen in met(env, 5):
        choices, there = core.cell.state.choices, decoded(seen.features).choices["real"] > 0.5
        scores = np.where(there, own.scores(seen.features), -np.inf)
        least = np.sort(scores, axis=1)[:, -3][:, None]
        worth = choices["value"] * choices["chance"] - 0.5 * choices["cycle"]
        wanted = np.where((scores >= least) & there, scores + 8.0 * worth, -np.inf).argmax(axis=1)
        np.testing.assert_array_equal(guided.act(seen), wanted)
        moved += int((wanted != own.act(seen)).sum())
    assert moved > 0


def test_it_has_the_price_and_share_of_the_beam_that_leaves_to_others():
    mine, its = (settings("skills3", name, 3) for name in ("guided_beam", "price_beam"))
    assert mine.items() >= its.items()
    assert set(its) == {"price", "share"}


@pytest.mark.parametrize(
    ("guide", "said"),
    [
        *[(name, f"guided_beam has guide '{name}'; guides are index") for name in ("atc", "beam", "random")],
        ("nowhere", "unknown controller of a line 'nowhere'"),
    ],
)
def test_only_what_scores_choices_can_guide(guide, said):
    _, core = vector_lines(LEVEL)
    with pytest.raises(UsageError, match=said):
        registry.make("guided_beam", core, guide=guide)

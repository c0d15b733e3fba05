"""Pictures of shifts at a line."""

import numpy as np

from agents.environments import make_vector
from agents.line.evaluation import judged
from agents.line.film import acts, frames
from agents.line.gantt import gantt
from agents.line.making import line_controller, line_of

LEVEL = {"base": "skills3", "duration": 8.0}


def test_who_took_what_has_a_row_for_each_robot():
    env = make_vector("PnTLine-v0", LEVEL, 2, 1)
    told = judged(line_controller("price", line_of(env)), env, 2, 0)
    drawn = gantt(told, shift=1, span=(0.0, 8.0))
    assert drawn.startswith("<?xml")
    assert drawn == gantt(told, shift=1, span=(0.0, 8.0))


def test_a_film_shows_every_throw_from_where_it_was_lifted_to_its_bin():
    env = make_vector("PnTLine-v0", LEVEL, 1, 1)
    core = line_of(env)
    made = acts(line_controller("price", core), env, core, 5.0, 3)
    held = [act for act in made if act.picked]
    assert held
    for act in held:
        np.testing.assert_allclose(act.thing(act.lift), act.pick, atol=1e-12)
        np.testing.assert_allclose(act.thing(act.landing), act.target, atol=1e-12)
        assert act.start < act.lift < act.release < act.landing
        assert act.thing(act.lift - 0.01) is None
    pictures = list(frames(core, made, 1.0, 4.0))
    assert len(pictures) == 4
    assert (pictures[0] != pictures[-1]).any()

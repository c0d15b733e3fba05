"""Index rules: what each prefers, its limits, and that nothing impossible is ever taken."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pnt_gym.errors import PlanningError
from pnt_gym.planning.dispatch import RULES, Candidates, index

TIMES = st.lists(st.tuples(st.floats(0.2, 3.0), st.floats(0.0, 2.0), st.floats(0.1, 5.0)), min_size=1, max_size=8)


def candidates(rows, possible=None):
    """From (time, slack, value) of each; it is taken 0.2 s before the robot is free again."""
    time, slack, value = np.array(rows).T
    good = np.ones(len(rows), dtype=bool) if possible is None else np.array(possible)
    return Candidates(value=value, time=time, start=time - 0.2, leave=time - 0.2 + slack, possible=good)


def taken(rule, among, patience=1.0):
    """The candidate of the greatest index."""
    return int(index(rule, among, patience).argmax())


def test_each_rule_takes_what_its_words_say():
    among = candidates([(0.8, 0.5, 1.0), (0.7, 0.9, 1.0), (1.2, 0.0, 2.0)])
    assert among.leave - among.start == pytest.approx([0.5, 0.9, 0.0])
    assert taken("first", among) == 2  # leaves after 1.0 s, the others after 1.1 and 1.4 s
    assert taken("soonest", among) == 1
    assert taken("value_rate", among) == 2
    assert index("atc", among, 2.0) == pytest.approx([np.exp(-0.25) / 0.8, np.exp(-0.45) / 0.7, 2.0 / 1.2], rel=1e-12)


@given(TIMES)
def test_limits_of_the_tardiness_rule(rows):
    """With endless patience it is the value per time, without any it is the one that can wait least."""
    among = candidates(rows)
    np.testing.assert_allclose(index("atc", among, 1e12), index("value_rate", among, 1.0), rtol=1e-9)
    # The patience must be long enough for exp not to vanish, so values and times may still decide within 0.1 s.
    slack = among.leave - among.start
    assert slack[taken("atc", among, 0.01)] <= slack.min() + 0.1


@given(TIMES)
def test_equal_values_leave_the_shortest_cycle(rows):
    among = candidates([(time, slack, 1.0) for time, slack, _ in rows])
    assert taken("value_rate", among) == taken("soonest", among) == np.argmin(among.time)


@given(TIMES, st.data())
@pytest.mark.parametrize("rule", RULES)
def test_only_what_is_possible_is_taken_and_the_rest_makes_no_difference(rule, rows, data):
    possible = data.draw(st.lists(st.booleans(), min_size=len(rows), max_size=len(rows)))
    among = candidates(rows, possible)
    found = index(rule, among, 0.7)
    assert np.isfinite(found).tolist() == possible
    if any(possible):
        kept = candidates([row for row, good in zip(rows, possible, strict=True) if good])
        assert np.flatnonzero(possible)[taken(rule, kept, 0.7)] == taken(rule, among, 0.7)


@pytest.mark.parametrize("rule", RULES)
def test_a_row_of_many_decides_as_it_does_alone(rule):
    random = np.random.default_rng(0)
    rows = random.uniform(0.2, 2.0, (5, 4, 3))
    each = [candidates(row) for row in rows]
    stacked = Candidates(*(np.stack([getattr(one, name) for one in each]) for name in Candidates.__annotations__))
    assert index(rule, stacked, 0.5).argmax(axis=-1).tolist() == [taken(rule, one, 0.5) for one in each]


def test_numbers_of_the_impossible_may_be_none():
    among = candidates([(np.nan, np.nan, 1.0), (0.8, 0.1, 1.0)], [False, True])
    for rule in RULES:
        assert taken(rule, among) == 1


def test_an_unknown_rule_is_one_sentence():
    with pytest.raises(PlanningError, match="unknown rule 'dearest'; known are first, soonest, value_rate, atc"):
        index("dearest", candidates([(1.0, 1.0, 1.0)]), 1.0)

import numpy as np
from scipy.optimize import elementwise

from pnt_gym.planning.motion.roots import bisect

LOW, HIGH = np.full(50, -1.0), np.linspace(2.0, 4.0, 50)
SHIFT = np.linspace(-0.9, 1.9, 50)


def test_bisection_closes_in_on_the_border_from_both_ends():
    inside, outside = bisect(lambda x: x**3 < SHIFT, LOW, HIGH, 60)
    np.testing.assert_allclose(inside, np.cbrt(SHIFT), atol=1e-15)
    assert (inside**3 < SHIFT).all() and not (outside**3 < SHIFT).any()
    reference = elementwise.find_root(lambda x, s: x**3 - s, (LOW, HIGH), args=(SHIFT,))
    np.testing.assert_allclose(inside, reference.x, atol=1e-12)


def test_the_end_that_holds_may_be_the_greater_one():
    inside, outside = bisect(lambda x: x > SHIFT, HIGH, LOW, 60)
    np.testing.assert_allclose(inside, SHIFT, atol=1e-15)
    assert (outside <= SHIFT).all()

"""Estimated flights and arrivals."""

import numpy as np
import pytest

from pnt_gym.planning.one_joint import FittedFlight, arrival, fit_flight

G = 9.81


def some_flights(count, seed):
    rng = np.random.default_rng(seed)
    return FittedFlight(*(scale * rng.normal(size=count) for scale in (0.5, 0.5, 2.0, 1.0, 3.0, 8.0))), rng


def watched(flight, times):
    columns = flight.x[:, None] + flight.vx[:, None] * times, flight.phi[:, None] + flight.spin[:, None] * times
    return columns[0], flight.y[:, None] + flight.vy[:, None] * times - 0.5 * G * times**2, columns[1]


def test_the_fit_finds_a_clean_flight_through_gaps():
    flight, rng = some_flights(20, 0)
    times = np.linspace(0.02, 0.3, 40)
    x, y, phi = watched(flight, times)
    seen = rng.random(x.shape) < 0.5
    x[~seen] = np.nan
    fit = fit_flight(times, x, y, phi, seen)
    for got, true in zip(fit, flight, strict=True):
        assert got == pytest.approx(true, abs=1e-11)
    one = fit_flight(times, x[7:8], y[7:8], phi[7:8], seen[7:8])
    assert all(a[0] == b[7] for a, b in zip(one, fit, strict=True))


def test_the_fit_is_the_least_squares_one():
    flight, rng = some_flights(4, 1)
    times = np.linspace(0.0, 0.25, 30)
    x, y, phi = (column + 1e-2 * rng.normal(size=column.shape) for column in watched(flight, times))
    fit = fit_flight(times, x, y, phi)
    for row in range(4):
        slope, start = np.polyfit(times, y[row] + 0.5 * G * times**2, 1)
        assert (fit.vy[row], fit.y[row]) == pytest.approx((slope, start), abs=1e-10)
        slope, start = np.polyfit(times, phi[row], 1)
        assert (fit.spin[row], fit.phi[row]) == pytest.approx((slope, start), abs=1e-10)


@pytest.mark.parametrize("scales", [(1.0, 1.0, 0.1, 0.1), (1.0, 1.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.3, 1.0, 0, 0)])
def test_no_point_of_the_flight_is_nearer_than_the_arrival(scales):
    flight, rng = some_flights(400, 2)
    goal = flight.state(rng.uniform(0.0, 0.6, 400)) + rng.normal(size=(400, 4)) * rng.choice([0.01, 0.3, 3.0], (400, 1))
    found = arrival(flight, goal, scales)

    def distance(z):
        return (np.array(scales) ** 2 * (z - goal) ** 2).sum(axis=1)

    best = np.min([distance(flight.state(np.full(400, t))) for t in np.linspace(-5.0, 5.0, 2001)], axis=0)
    assert (distance(found.z) <= best + 1e-9).all()
    assert found.z == pytest.approx(flight.state(found.time))


def test_three_real_roots_occur_and_the_nearest_is_taken():
    flight = FittedFlight(*(np.array([v]) for v in (0.0, 0.0, 0.0, 0.5, 3.0, 5.0)))
    goal = np.array([[0.18, 0.1, 0.0, 0.0]])
    found = arrival(flight, goal, (1.0, 1.0, 0.0, 0.0))
    crossings = np.roots([-0.5 * G, 3.0, -0.1])
    assert found.time[0] == pytest.approx(crossings.max(), abs=0.05)


def test_nothing_before_the_earliest_time_counts():
    flight, rng = some_flights(50, 3)
    goal = flight.state(rng.uniform(-0.4, 0.4, 50))
    found = arrival(flight, goal, earliest=np.zeros(50))
    assert (found.time >= 0.0).all() and (found.time == 0.0).any()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda f: arrival(f, np.zeros((1, 4)), (1.0, 0.0, 1.0, 1.0)), "scale of y"),
        (lambda f: arrival(f, np.zeros((1, 4)), (1.0, -1.0, 1.0, 1.0)), "at least 0"),
        (lambda f: arrival(f, np.zeros(4)), "shape"),
        (lambda f: fit_flight([0.0, 0.1], np.zeros((1, 3)), np.zeros((1, 3)), np.zeros((1, 3))), "times"),
        (lambda f: fit_flight([0.1, 0.1], *np.zeros((3, 1, 2))), "two distinct"),
        (lambda f: fit_flight([0.1, 0.2], *np.full((3, 1, 2), np.nan)), "finite"),
    ],
)
def test_bad_measurements_are_refused(call, words):
    flight, _ = some_flights(1, 4)
    with pytest.raises(ValueError, match=words):
        call(flight)

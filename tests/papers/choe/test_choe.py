"""The reproduction of Choe et al. 2023: the published example, its misprints, and the times of Fig. 8."""

import math
from functools import cache

import numpy as np
import pytest

from agents.reproduce.finding import Row
from papers.choe import PARTS, cases, ellipse, speed
from papers.choe.claims import random_pairs
from pnt_gym.planning.paths import EllipsePath
from tests.tools.nightly import with_nightly
from tests.tools.reproduced import assert_plain

FIGURES = {
    "example": {"choe_ellipse.svg"},
    "length": {"choe_length.svg"},
    "curvature": {"choe_curvature.svg", "choe_profile.svg"},
    "speed": {"choe_nodes.svg"},
    "joints": {"choe_joints.svg"},
    "claims": set(),
    "lengths": {"choe_lengths.svg"},
    "fig-8-times": set(),
}


LONG = "fig-8-times"
"""Part that takes seconds; `papers.choe.planning` has daily tests of what it times paths with."""
DAILY = [name for name in FIGURES if name != LONG]
COARSE = 120
"""Intervals of a timed run: half of those of the figures, for half of the time; up to 2 ms slower."""


@pytest.fixture(scope="module", autouse=True)
def coarse():
    """Times paths on fewer intervals, and forgets them in the end."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cases, "INTERVALS", COARSE)
        cases.motion.cache_clear()
        yield
    cases.motion.cache_clear()


@cache
def findings(name):
    return PARTS[name]()


def row(name: str, quantity: str) -> Row:
    return next(r for r in findings(name).rows if r.quantity == f"choe/{quantity}")


@pytest.mark.nightly
def test_the_parts_are_the_known_ones_and_no_row_has_two_meanings():
    assert list(PARTS) == list(FIGURES)
    quantities = [r.quantity for part in PARTS for r in findings(part).rows]
    assert len(set(quantities)) == len(quantities)


@pytest.mark.parametrize("name", with_nightly(FIGURES, DAILY))
def test_rows_and_data_are_plain_json_and_figures_are_drawings(name):
    found = findings(name)
    assert_plain(found, "choe")
    assert set(found.figures) == FIGURES[name]
    for r in found.rows:
        assert r.reproduced is not None, r.quantity
        assert r.note or r.verdict in ("reproduced", "ours"), r.quantity
    assert found.grids
    assert all(grid.rows and len(line) == len(grid.header) for grid in found.grids for line in grid.rows)


def test_a_wrong_semi_axis_shows_in_the_verdicts(monkeypatch):
    known = EllipsePath.semi_major
    before = {r.quantity: r.verdict for r in ellipse.example_findings().rows}
    monkeypatch.setattr(EllipsePath, "semi_major", property(lambda e: 1.2 * known.fget(e)))
    after = {r.quantity: r.verdict for r in ellipse.example_findings().rows}
    for name in ("semi-major", "length-eq-27"):
        assert before[f"choe/example/{name}"] == "reproduced"
        assert after[f"choe/example/{name}"] == "differs"
    assert before["choe/example/length"] == "misprint"
    assert after["choe/example/length"] == "differs"
    assert after["choe/claim/vertical-tangents"] == "differs"


def test_only_what_the_paper_states_under_its_own_conditions_is_judged():
    ours = {
        "joints": [f"joints/arm-{k}-swing" for k in (1, 2, 3, 4)],
        "speed": ["claim/shorter-cycle", "statement/step-6-units"],
    }
    for part, quantities in ours.items():
        assert {row(part, quantity).verdict for quantity in quantities} == {"ours"}


@pytest.mark.parametrize(
    ("quantity", "published", "value", "tolerance"),
    [
        ("example/theta-t1", -2.329, 177.6706, 1e-4),
        ("example/theta-t2", 177.671, -2.3294, 1e-4),
        ("example/length", 0.32058, 0.323730, 5e-7),
        ("misprint/eq-38", 0.06852, 0.043519, 5e-7),
        ("claim/continuous-at-the-tangent-points", "continuous", 118.2, 0.05),
    ],
)
def test_what_is_wrong_in_the_example_is_corrected(quantity, published, value, tolerance):
    r = row("example", quantity)
    assert r.published == published
    assert r.reproduced == pytest.approx(value, abs=tolerance)
    assert r.verdict == ("differs" if quantity.startswith("claim") else "misprint")


def test_half_the_circumference_lies_between_the_bounds_except_for_circles():
    bounds = row("length", "eq-26/bounds")
    assert bounds.verdict == "reproduced"
    assert bounds.reproduced == "in 288 of 288 pairs with a and b different"
    assert 0.0 < bounds.details["largest_difference_of_circles"] < 1e-13
    assert bounds.note.endswith("too short in 288 of the 288 others")


def test_the_approximation_and_the_rule_of_whole_degrees():
    assert row("length", "eq-27/mean-absolute-error").reproduced == pytest.approx(0.0786, abs=5e-5)
    assert row("length", "eq-27/mean-relative-error").reproduced == pytest.approx(0.2315, abs=5e-5)
    assert row("length", "eq-27/largest-relative-error").reproduced == pytest.approx(2.55, abs=5e-3)
    optimum = row("length", "claim/optimal-angle")
    assert optimum.reproduced == pytest.approx(math.degrees(math.atan(1.0 / 6.0)))
    assert optimum.details["lengths_m"]["9.6 deg"] == pytest.approx(0.31074, abs=5e-6)
    assert optimum.details["lengths_m"]["9.5 deg"] == pytest.approx(0.30634, abs=5e-6)
    assert row("length", "eq-27/shorter-than-the-chord-below").reproduced == pytest.approx(9.605, abs=5e-4)
    clearances = [row("length", f"whole-degrees/clearance-h-{h}mm").reproduced for h in ("26.4", "26.5", "1")]
    assert clearances == pytest.approx([0.0008, 0.0266, 0.117], rel=0.01)
    for name in ("level", "falling", "whole-degree"):
        r = row("length", f"whole-degrees/{name}")
        assert (r.reproduced, r.verdict) == ("no ellipse", "ours")
        assert "with_top" in r.note


def test_the_speed_law():
    assert row("speed", "nodes/count").reproduced == 80.0
    assert row("speed", "nodes/last-angle").reproduced == pytest.approx(-2.530, abs=5e-4)
    assert row("speed", "speed-law/ratio").reproduced == pytest.approx(353.0, abs=0.1)
    assert row("speed", "claim/speed-peaks-at-the-top").reproduced == pytest.approx(-0.006, abs=2e-4)
    units = row("speed", "statement/step-6-units").details["nodes_by_units"]
    assert units["m and rad"] == 80
    assert units["mm and rad"] == 2
    slow = row("speed", "claim/shorter-cycle")
    assert slow.reproduced == pytest.approx(3.26, abs=5e-3)
    assert slow.details["times_slower"] == pytest.approx(11.3, abs=0.1)


def test_the_claim_of_the_shortest_curve_holds_under_some_readings_only():
    lengths = {
        "same-ends/symmetric-ellipse": 0.3613,
        "same-ends/lame-d50mm": 0.3786,
        "same-ends/lame-d150mm": 0.3698,
        "same-ends-and-top/symmetric-ellipse": 0.3568,
        "same-ends-and-top/lame-d50mm": 0.3694,
        "same-ends-and-top/lame-d150mm": 0.3631,
        "curves-only/symmetric-ellipse": 0.3341,
        "curves-only/lame-d50mm": 0.3286,
        "curves-only/lame-d150mm": 0.3198,
    }
    for name, value in lengths.items():
        assert row("lengths", f"fig-8/{name}").reproduced == pytest.approx(value, abs=5.1e-5), name
    verdicts = {name: row("lengths", f"fig-8/{name}/proposed").verdict for name in ("same-ends", "curves-only")}
    assert verdicts == {"same-ends": "reproduced", "curves-only": "differs"}


def test_derivatives_of_the_curvature_are_those_of_differences():
    theta, small = np.linspace(0.1, 3.0, 50), 1e-5
    around = [speed.FIG_3.radius_of_curvature(theta + k * small) for k in (-1, 0, 1)]
    value, slope, bend = speed.radius_derivatives(speed.FIG_3, theta)
    np.testing.assert_allclose(value, around[1])
    np.testing.assert_allclose(slope, (around[2] - around[0]) / (2.0 * small), atol=1e-6)
    np.testing.assert_allclose(bend, (around[2] - 2.0 * around[1] + around[0]) / small**2, atol=1e-4)


def test_the_profile_adds_up_to_the_way():
    nodes = cases.example().nodes(cases.RATE, clip=False)
    found = speed.Profile.of(cases.example(), nodes)
    assert [len(v) for v in (found.curvature, found.velocity, found.acceleration, found.jerk)] == [80, 79, 78, 77]
    assert found.displacement[-1] == pytest.approx(nodes.steps.sum())
    assert found.velocity[0] + found.acceleration.sum() == pytest.approx(found.velocity[-1])
    assert row("curvature", "fig-5/way-of-the-busiest-periods").reproduced > 0.5


FIG_8 = {
    "proposed-strict": 0.482, "proposed-relaxed": 0.358,
    "equal-tops/symmetric-ellipse-strict": 0.511, "equal-tops/symmetric-ellipse-relaxed": 0.423,
    "equal-tops/lame-d50mm-strict": 0.462, "equal-tops/lame-d150mm-strict": 0.463,
    "equal-crests/lame-d50mm-strict": 0.460, "equal-crests/lame-d150mm-strict": 0.455,
}  # fmt: skip
"""Times of the curves of Fig. 8 [s], computed anew without this code."""


@pytest.mark.nightly
def test_the_proposed_curve_beats_the_lame_curves_only_if_the_acceleration_steps():
    times = {name: row(LONG, f"time/fig-8/{name}").reproduced for name in FIG_8}
    assert times == pytest.approx(FIG_8, abs=0.003)
    for reading in ("equal-tops", "equal-crests"):
        claims = {
            (rival, rule): row(LONG, f"claim/shorter-cycle-than-{rival}/{reading}-{rule}").verdict
            for rival in ("symmetric-ellipse", "lame")
            for rule in ("strict", "relaxed")
        }
        # A path whose acceleration steps is no reading of a paper that claims a continuous acceleration.
        assert claims == {
            ("symmetric-ellipse", "strict"): "reproduced",
            ("symmetric-ellipse", "relaxed"): "ours",
            ("lame", "strict"): "differs",
            ("lame", "relaxed"): "ours",
        }
    for rule, coarse in (("strict", 0.4818), ("relaxed", 0.3582)):
        proposed = row(LONG, f"time/fig-8/proposed-{rule}")
        assert proposed.details["with_half_the_intervals"] == pytest.approx(coarse, abs=1e-4)


def test_claims_on_height_acceleration_and_real_time():
    heights = row("claims", "claim/smallest-height/own-family").details["heights_mm"]
    assert heights == pytest.approx({"9.5 deg": 1.8, "9.6 deg": 6.0}, abs=0.05)
    assert row("claims", "claim/smallest-height/fig-8").reproduced == pytest.approx(18.5, abs=0.05)
    assert row("claims", "claim/larger-radius-larger-acceleration").reproduced == pytest.approx(46.0, abs=0.5)
    assert row("claims", "claim/real-time").verdict == "reproduced"


def test_random_points_have_a_path_if_it_may_run_backwards_and_the_rate_may_grow():
    printed, backwards, any_rate = (
        row("claims", f"claim/random-points/{name}") for name in ("as-printed", "falling-reversed", "any-rate")
    )
    assert {r.statement for r in (printed, backwards, any_rate)} == {"choe/claim/random-points"}
    # Half of the random paths fall, and the rule of whole degrees has no ellipse for these.
    half_rise = random_pairs()[1]
    assert printed.reproduced <= 100.0 * (half_rise > 0.0).mean() < 60.0
    assert printed.reproduced < backwards.reproduced < any_rate.reproduced == 100.0
    assert [r.verdict for r in (printed, backwards, any_rate)] == ["differs", "differs", "reproduced"]

"""What a fit says of cells and logs that its model leaves out: which cause it names, and which ones act alike."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from agents.fit import misfit, twins
from agents.fit.density import Density, Mode
from agents.fit.effects import Effect, readings
from agents.fit.fitted import Fitted, fit_log
from agents.fit.log import ThrowLog
from agents.fit.misfit import Finding, Residuals, name_causes
from agents.fit.model import ThrowModel
from agents.fit.parameters import priors
from agents.fit.words import sentences
from pnt_gym.arrays import Floats
from tests.tools.fitting import QUIET, WASTE, level, throw, usual_log
from tests.tools.nightly import with_nightly

SOME = ("valve", "tau", "drag", "camera_x", "camera_y", "encoder")
"""Parameters of quick fits, without blow-off and without the profile over the stiffness."""


@cache
def quick_mode() -> Mode:
    """The maximum for the usual log."""
    return Density(ThrowModel(usual_log(), WASTE), priors(WASTE, SOME)).search(np.zeros(len(SOME)))


def findings(log: ThrowLog) -> dict[str, Finding]:
    """Results of all tests of a log much like the usual one."""
    density = Density(ThrowModel(log, WASTE), priors(WASTE, SOME))
    return {finding.name: finding for finding in misfit.find(density, density.search(quick_mode().z))}


@cache
def blown_fit(*free: str) -> Fitted:
    """A fit of a cell whose cup blows its objects off."""
    twin = twins.make(WASTE, 3, 40, hidden={"cup": {"blow_off": 0.3}})
    return fit_log(twin.log, WASTE, priors(WASTE, free))


def test_the_usual_log_raises_no_alarm() -> None:
    assert not any(finding.alarms for finding in findings(usual_log()).values())


def test_a_blow_off_is_named_and_is_no_draught() -> None:
    fitted = blown_fit(*SOME, "blow_off")
    samples = fitted.posterior.samples()
    part = fitted.estimates(samples)["blow_off"]
    assert part.low < 0.3 < part.high
    assert fitted.blows
    assert any("The cup blows its objects off" in sentence for sentence in sentences(fitted, samples))
    assert not next(finding for finding in fitted.misfit if finding.name == "draught").alarms
    assert fitted.level.cup.blow_off == pytest.approx(part.value)


def test_a_blow_off_that_is_not_free_is_suspected() -> None:
    fitted = blown_fit(*SOME)
    found = {finding.name: finding for finding in fitted.misfit}
    assert found["blow_off"].alarms
    assert "a cup that blows objects off" in sentences(fitted, fitted.posterior.samples())[-1]
    assert found["blow_off"].chance < found["draught"].chance


def test_no_sample_of_a_blow_off_lies_below_zero() -> None:
    """Its posterior is that without an end, cut off at 0: as if draws below 0 were thrown away."""
    found = blown_fit(*SOME, "blow_off").posterior
    names = [parameter.name for parameter in found.parameters]
    index = names.index("blow_off")
    width = np.sqrt(found.best.covariance[index, index])
    z = found.best.z.copy()
    z[index] = -0.7 * width
    low = replace(found, best=replace(found.best, z=z))
    samples = low.samples(20_000)
    assert samples[:, index].min() >= 0.0
    drawn = np.random.default_rng(0).multivariate_normal(z, found.best.covariance * found.inflation, 200_000)
    kept = drawn[drawn[:, index] >= 0.0]
    np.testing.assert_allclose(samples.mean(axis=0), kept.mean(axis=0), atol=0.02)
    np.testing.assert_allclose(np.cov(samples.T), np.cov(kept.T), atol=0.02)
    assert low.values["blow_off"] == 0.0
    assert low.z[names.index("valve")] != z[names.index("valve")]  # it goes with the blow-off


@pytest.mark.parametrize(("scale", "degrees"), with_nightly([(1.05, 0.0), (1.0, 3.0)], [(1.05, 0.0)]))
def test_a_camera_over_the_bins_that_is_scaled_or_turned_is_named(scale: float, degrees: float) -> None:
    log = usual_log()
    middle, angle = np.nanmean(log.landing, axis=0), np.deg2rad(degrees)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    found = findings(replace(log, landing=middle + scale * (log.landing - middle) @ turn.T))
    assert found["bin_camera"].alarms
    assert found["bin_camera"].is_told
    assert "lean as with a camera over the bins that is" in found["bin_camera"].text
    assert found["bin_camera"].chance < found["draught"].chance


@pytest.mark.parametrize(("gauge", "factor"), [("mass", 0.75), ("mass", 1.3), ("seal", 0.7)])
def test_scales_that_read_wrong_are_named(gauge: str, factor: float) -> None:
    log = usual_log()
    wrong = {
        reading.gauge: reading for reading in readings(replace(log, **{gauge: factor * getattr(log, gauge)}), WASTE)
    }
    right = {reading.gauge: reading for reading in readings(log, WASTE)}
    assert wrong[gauge].factor / right[gauge].factor == pytest.approx(factor, rel=1e-6)
    assert wrong[gauge].chance < 1e-3
    assert right[gauge].chance > 0.02
    assert wrong["length"] == right["length"]


def test_the_catalogues_readings_are_as_likely_as_they_should_be() -> None:
    """Over many logs the probabilities of true gauges are spread evenly, residues of containers included."""
    log, _ = throw(WASTE, 400, seed=5)
    chances = np.array(
        [[reading.chance for reading in readings(log_part, WASTE)] for log_part in _parts(log, 20)]
    )  # fmt: skip
    assert chances.shape == (20, 5)
    assert 0.35 < chances.mean() < 0.65
    assert chances.min() > 1e-3


def _parts(log: ThrowLog, size: int) -> list[ThrowLog]:
    fields = vars(log)
    return [
        ThrowLog(**{name: values[start : start + size] for name, values in fields.items()})
        for start in range(0, len(log), size)
    ]


def test_gauges_of_what_never_differs_say_nothing() -> None:
    quiet = level(**QUIET)
    assert readings(throw(quiet, 12)[0], quiet) == []


def made_up(columns: Floats, size: float, seed: int = 0) -> tuple[list[Effect], list[Floats], Residuals]:
    """Effects with columns (R, Q), one each, and residuals in which the first has a size."""
    rows = len(columns)
    residual = size * columns[:, 0] + np.random.default_rng(seed).standard_normal(rows)
    nothing = Residuals(residual, np.zeros((rows, 0)), np.zeros((0, 0)))
    effects = [Effect(f"test {k}", np.zeros((1, 2, 1)), lambda v, k=k: f"cause {k}") for k in range(columns.shape[1])]
    return effects, [columns[:, k : k + 1] for k in range(columns.shape[1])], nothing


def test_causes_that_act_alike_are_named_together_and_others_apart() -> None:
    random = np.random.default_rng(1)
    first, third = random.standard_normal((2, 80))
    twin = first + 0.05 * random.standard_normal(80)
    effects, columns, residuals = made_up(np.stack([first, twin, third], axis=1), 2.0)
    found = name_causes(effects, columns, residuals)
    assert found["test 0"].alarms
    assert found["test 1"].alarms
    told = [finding.text for finding in found.values() if finding.alarms and finding.is_told]
    assert len(told) == 1
    assert "cause 0" in told[0]
    assert "cause 1" in told[0]
    assert "cause 2" not in told[0]
    assert "act alike" in told[0]
    both = replace(residuals, residual=residuals.residual + 1.5 * third)
    found = name_causes(effects, columns, both)
    assert found["test 2"].is_told
    assert "cause 0" not in found["test 2"].text


def test_scores_are_chi_square_where_the_model_is_right() -> None:
    """Also of an effect that a free parameter explains in part."""
    random = np.random.default_rng(2)
    jacobian, column = random.standard_normal((60, 2)), random.standard_normal((60, 2))
    column += jacobian
    covariance = np.asarray(np.linalg.inv(np.eye(2) + jacobian.T @ jacobian), dtype=np.float64)
    squares = list[float]()
    for _ in range(2000):
        truth = random.standard_normal(2)
        drawn = jacobian @ truth + random.standard_normal(60)
        left = Residuals(drawn - jacobian @ covariance @ jacobian.T @ drawn, jacobian, covariance)
        effect = Effect("it", np.zeros((1, 2, 2)), lambda _: "it")
        squares.append(left.suspect(effect, column, 1).square)
        assert left.given(column).suspect(effect, column, 1).square < 1e-6
    assert np.mean(squares) == pytest.approx(2.0, abs=0.15)
    assert np.mean(np.array(squares) > 5.99) == pytest.approx(0.05, abs=0.015)

"""Fits of twins whose hidden values are known, and what a fit says of them."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml

import pnt_gym
from agents.fit import design, misfit, twins, writing
from agents.fit.density import Density
from agents.fit.design import DesignPool, information
from agents.fit.fitted import Fitted, fit_log
from agents.fit.log import ThrowLog
from agents.fit.misfit import DEVIATION, EXPECTED, WINSOR
from agents.fit.model import ThrowModel
from agents.fit.parameters import priors, values_at
from agents.fit.posterior import posterior, seal_chances
from agents.fit.report import report
from agents.fit.twins import Twin, judge
from agents.fit.words import sentences
from agents.fit.writing import page
from agents.ground.cli import UsageError
from pnt_gym.arrays import take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from tests.tools.commands import call_here, output_of, refused
from tests.tools.fitting import WASTE, throw, usual_log

SOME = ("valve", "tau", "camera_x", "camera_y", "encoder")
"""Parameters of quick fits, without the profile over the stiffness."""
LANDINGS = 24
"""Landings of twins."""


@cache
def twin_and_fit(seed: int = 1) -> tuple[Twin, Fitted]:
    twin = twins.make(WASTE, seed, LANDINGS)
    return twin, fit_log(twin.log, WASTE, priors(WASTE))


@pytest.fixture
def small_pool(monkeypatch: pytest.MonkeyPatch) -> None:
    """Plans choose among a quarter of the releases."""
    monkeypatch.setattr("agents.fit.design.POOL", 200)


def few_throws() -> ThrowLog:
    """The first throws of the usual log."""
    return take(usual_log(), slice(24))


def quick_fit(**changes: object) -> Fitted:
    return fit_log(replace(usual_log(), **changes), WASTE, priors(WASTE, SOME))


@pytest.fixture(scope="module")
def usual_fit() -> Fitted:
    """The quick fit of the usual log."""
    return quick_fit()


def test_a_fit_finds_what_was_hidden() -> None:
    twin, fitted = twin_and_fit()
    assert twin.log.has_landing.sum() == LANDINGS
    judged = judge(twin, fitted)
    held = [part["holds"] for part in judged.values()]
    assert np.mean(held) > 0.85
    delays = [part["error"] for name, part in judged.items() if name.startswith("delay_")]
    assert np.median(delays) < 1.5
    assert judged["camera_at_picks"]["error"] < 3.0
    samples = fitted.posterior.samples()
    spread = {name: part.share for name, part in fitted.estimates(samples).items()}
    assert spread["tau"] < 0.3  # a log tells the decay of the vacuum best
    assert fitted.combinations(samples)["camera_at_picks"].share < 0.3 < spread["encoder"]


@pytest.mark.nightly
def test_a_vacuum_that_is_far_off_is_found() -> None:
    """Its vacuum decays 2.9 deviations slower; a search with narrow covariances takes that for accidents."""
    twin = twins.make(WASTE, 500_122, 40)
    found, _ = posterior(twin.log, WASTE, priors(WASTE, (*SOME, "blow_off", "drag")))
    assert twin.scores[1] > 2.5
    assert found.best.z[1] == pytest.approx(twin.scores[1], abs=0.5)
    assert (found.best.regular > 0.5).mean() > 0.6  # cups touch some of the objects that leave so late


def test_a_value_at_its_least_is_not_a_last_digit_below() -> None:
    """A blow-off of -4e-18 m/s once made a level that was refused."""
    found = fit_log(few_throws(), WASTE, priors(WASTE, ("tau", "blow_off"))).posterior
    scores = np.column_stack([np.linspace(-1.0, 1.0, 50), np.linspace(-3.0, -0.1, 50)])
    moved = [replace(found, best=replace(found.best, z=z)) for z in scores]
    below = [values_at(each.parameters, each.z)["blow_off"] for each in moved]
    assert min(below) < 0.0  # what arithmetic gives
    assert all(0.0 <= each.values["blow_off"] < 1e-12 for each in moved)


def test_a_fit_is_the_same_again_and_reads_nothing_hidden() -> None:
    """Trap: a log is all that a fit has; what the simulation hides is not in it."""
    log, free = few_throws(), priors(WASTE, SOME[:2])
    first, again = (fit_log(log, WASTE, free).posterior.best.z for _ in range(2))
    np.testing.assert_array_equal(first, again)
    with np.errstate(all="ignore"):
        other = fit_log(log, WASTE.model_copy(update={"mix": None}), free)
    np.testing.assert_allclose(other.posterior.best.z, first, atol=1e-9)


def test_the_residuals_lead_to_the_least_cost() -> None:
    density = Density(ThrowModel(usual_log(), WASTE, 16), priors(WASTE, SOME))
    mode = density.search(np.zeros(len(SOME)))
    at_best = float((density.residuals(mode.z, mode.scatter) ** 2).sum())
    for step in 0.4 * np.eye(len(SOME)):
        for z in (mode.z + step, mode.z - step):
            assert float((density.residuals(z, mode.scatter) ** 2).sum()) > at_best - 1e-2


def test_far_landings_hardly_move_a_fit(usual_fit: Fitted) -> None:
    landing = usual_log().landing.copy()
    rows = np.flatnonzero(usual_log().has_landing)[:3]
    landing[rows] += [0.0, -0.15]
    moved = quick_fit(landing=landing).posterior.best.z - usual_fit.posterior.best.z
    assert np.abs(moved).max() < 0.5


def test_throws_that_failed_count() -> None:
    """More failed picks lower the chance of a seal, and where the cup misses tells of the camera."""
    log = usual_log()
    model = ThrowModel(log, WASTE, 8)
    usual = {seal.item: seal for seal in seal_chances(model, WASTE)}
    failed = replace(log, sealed=np.zeros(len(log)), landing=np.full_like(log.landing, np.nan))
    low = {seal.item: seal for seal in seal_chances(ThrowModel(failed, WASTE, 8), WASTE)}
    assert all(low[item].mean < usual[item].mean for item in usual)
    assert all(seal.low < seal.mean < seal.high for seal in usual.values())
    density = Density(ThrowModel(log, WASTE, 16), priors(WASTE, SOME))
    z = np.zeros(len(SOME))
    scatter = density.scatter(z)
    off = np.array([0.0, 0.0, 4.0, 0.0, 0.0])
    near, far = (density.chances(score, scatter, density.landings(score, scatter)) for score in (z, off))
    sealed = log.has_landing
    assert near[: len(log)][sealed].mean() > far[: len(log)][sealed].mean()


def test_samples_have_the_posteriors_moments(usual_fit: Fitted) -> None:
    found = usual_fit.posterior
    samples = found.samples(20_000)
    np.testing.assert_allclose(samples.mean(axis=0), found.best.z, atol=0.02)
    np.testing.assert_allclose(np.cov(samples.T), found.best.covariance, atol=0.02)
    wide = replace(found, inflation=4.0).samples(20_000)
    np.testing.assert_allclose(wide.std(axis=0), 2.0 * samples.std(axis=0), rtol=0.03)


def test_a_profile_has_the_stiffnesses_between_which_a_log_does_not_tell() -> None:
    _, fitted = twin_and_fit()
    scores = [node.z[-1] for node in fitted.posterior.nodes]
    assert scores == sorted(scores)
    assert len(scores) > 12
    samples = fitted.posterior.samples(2000)
    assert scores[0] <= samples[:, -1].min()
    assert samples[:, -1].max() <= scores[-1]
    assert abs(np.median(samples[:, -1]) - fitted.posterior.best.z[-1]) < 1.5


def test_the_moments_of_winsorised_residuals() -> None:
    square = np.random.default_rng(0).chisquare(2, 400_000)
    cut = np.minimum(square, WINSOR**2)
    assert cut.mean() == pytest.approx(EXPECTED, abs=0.01)
    assert cut.std() == pytest.approx(DEVIATION, abs=0.01)


def test_a_draught_is_told() -> None:
    windy = twins.make(WASTE, 2, LANDINGS, draught=0.8)
    fitted = fit_log(windy.log, WASTE, priors(WASTE, SOME))
    assert next(f for f in fitted.misfit if f.name == "draught").alarms
    said = sentences(fitted, fitted.posterior.samples())[-1]
    assert "THE MODEL DOES NOT FIT: landings lean as with air that moves" in said


@pytest.mark.nightly
def test_more_scatter_of_a_twin_is_told() -> None:
    hidden = {"suction": {"jitter": 0.006}, "spread": {"grasp": 0.02}, "feedback": {"noise": 0.015}}
    rough = twins.make(WASTE, 2, LANDINGS, hidden=hidden)
    fitted = fit_log(rough.log, WASTE, priors(WASTE, SOME))
    assert next(f for f in fitted.misfit if f.name == "scatter").alarms
    assert fitted.scatter > 1.2
    assert "throws scatter" in sentences(fitted, fitted.posterior.samples())[-1]


def test_one_item_of_another_drag_is_named(usual_fit: Fitted) -> None:
    log, found = usual_log(), usual_fit.posterior
    kind = int(np.bincount(log.kind[log.has_landing]).argmax())
    push = np.where((log.kind == kind)[:, None], 0.05 * (log.target - log.pick[:, :2]), 0.0)
    density = Density(ThrowModel(replace(log, landing=log.landing + push), WASTE), priors(WASTE, SOME))
    moved = {finding.name: finding for finding in misfit.find(density, density.search(found.best.z))}
    least = min(moved["drag"], moved["delay"], key=lambda finding: finding.chance)
    assert WASTE.items[kind] in least.text
    assert least.chance < 0.2


@pytest.mark.usefixtures("small_pool")
def test_a_plan_tells_more_than_throws_that_come() -> None:
    parameters = priors(WASTE, SOME)
    pool = DesignPool(WASTE, 3)
    log = pool.log
    slopes = information(log, WASTE, parameters, np.zeros(len(SOME))).slopes
    choice = design.choose(slopes, 12)
    chosen = choice.rows
    assert len({*chosen}) == 12
    assert (np.diff(choice.gains) <= 1e-9).all()
    assert choice.gains[-1] >= choice.left.max() - 1e-9

    def gain(rows: np.ndarray) -> float:
        whole = slopes[rows].reshape(-1, len(SOME))
        return float(np.linalg.slogdet(np.eye(len(SOME)) + whole.T @ whole)[1])

    random = np.random.default_rng(0)
    assert gain(chosen) > max(gain(random.choice(len(log), 12, replace=False)) for _ in range(20))
    assert min(log.percent) < min(WASTE.limits.percent)
    thrown = pool.throw(0)
    pool.close()
    assert thrown.has_landing.sum() > 50


def test_words_name_what_a_log_does_not_tell() -> None:
    _, fitted = twin_and_fit()
    text = " ".join(sentences(fitted, fitted.posterior.samples()))
    assert "camera along the belt and belt speed over the encoder's only together" in text
    assert "camera along the belt + " in text
    assert "the camera over the bins would be taken for one of the belt camera" in text
    few = take(usual_log(), np.flatnonzero(usual_log().has_landing)[:10])
    vague = fit_log(few, WASTE, priors(WASTE, ("valve", "encoder")))
    vague = replace(vague, posterior=replace(vague.posterior, inflation=9.0))
    assert "This log does not tell" in " ".join(sentences(vague, vague.posterior.samples()))


def test_the_level_loads_and_says_what_was_fitted(tmp_path: Path) -> None:
    _, fitted = twin_and_fit()
    samples = fitted.posterior.samples()
    path = tmp_path / "fitted.yaml"
    path.write_text(writing.text(fitted, samples, "waste", path, "pnt-gym fit log.csv"))
    loaded = ConveyorConfig.load(path)
    level = fitted.level
    assert loaded.suction.tau == pytest.approx(level.suction.tau, rel=1e-5)
    assert loaded.bias.camera == pytest.approx(level.bias.camera, rel=1e-4)
    assert loaded.cup.stiffness == pytest.approx(level.cup.stiffness, rel=1e-5)
    assert loaded.items == WASTE.items
    assert loaded.cup.blow_off == pytest.approx(level.cup.blow_off, rel=1e-5)
    assert loaded.assumed() == {}
    chances = {item.name: item.pick_chance for item in loaded.item_list()}
    assert {seal.item: chances[seal.item] for seal in fitted.seals} == pytest.approx(
        {seal.item: seal.mean for seal in fitted.seals}, rel=1e-5
    )
    text = path.read_text()
    assert f"{LANDINGS} landings of" in text
    assert "pick_chance" in text
    figures = report(fitted, samples)
    same = ConveyorConfig.load({"base": "waste", **figures["differences"]})
    assert same.bias.camera == pytest.approx(loaded.bias.camera, rel=1e-4)
    assert same.extra_items == loaded.extra_items
    drawn = page(fitted, samples, "A fit")
    assert drawn.count("<circle") == LANDINGS
    assert "<figcaption>Landings from above, relative to their targets" in drawn
    assert "<table>" in drawn


@pytest.mark.usefixtures("small_pool")
def test_the_command_writes_everything(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(usual_log().text(WASTE.items))
    line = "fit log.csv --level waste --free valve tau --out f.yaml --page f.html --json f.json --design 3 --plan p.csv"
    said = output_of(line, tmp_path)
    assert "The model fits" in said
    assert "The next 3 throws" in said
    assert yaml.safe_load((tmp_path / "f.yaml").read_text())["base"] == "waste"
    assert len((tmp_path / "p.csv").read_text().splitlines()) == 4
    found = pnt_gym.fit(tmp_path / "log.csv", free=["valve", "tau"])
    assert found["fits"]
    assert set(found["parameters"]) == {"valve", "tau"}
    output_of("evaluate --controller analytic --env PnTRelease-v0 --level f.yaml --picks 8 --log l.csv", tmp_path)
    assert len((tmp_path / "l.csv").read_text().splitlines()) == 9


def test_a_misfit_ends_with_exit_code_1(tmp_path: Path) -> None:
    log = few_throws()
    noise = np.random.default_rng(0).normal(0.0, 0.05, log.landing.shape)
    (tmp_path / "log.csv").write_text(replace(log, landing=log.landing + noise).text(WASTE.items))
    done = call_here("agents.fit", "log.csv", "--level", "waste", "--free", "valve", "tau", folder=tmp_path)
    assert done.returncode == 1
    assert "THE MODEL DOES NOT FIT: " in done.stdout
    assert "throws scatter" in done.stdout


def raising(error: Exception) -> object:
    def call(*_: object, **__: object) -> None:
        raise error

    return call


def test_only_a_misfit_ends_with_exit_code_1(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "log.csv").write_text(usual_log().text(WASTE.items))

    def code() -> tuple[int, str]:
        done = call_here("agents.fit", "log.csv", "--level", "waste", "--free", "valve", folder=tmp_path)
        return done.returncode, done.stderr

    assert code()[0] == 0
    for error in (
        MemoryError("x"),
        np.linalg.LinAlgError("x"),
        ValueError("Not finite"),
        OSError(5, "x"),
    ):
        monkeypatch.setattr("agents.fit.density.least_squares", raising(error))
        number, said = code()
        assert number == 2, said
        assert said.startswith("error: ")
        assert said.count("\n") == 1
    monkeypatch.setattr("agents.fit.density.least_squares", raising(KeyError("a fault of the program")))
    number, said = code()
    assert number == 70
    assert said.endswith("KeyError: 'a fault of the program'\n")


@pytest.mark.parametrize("place", ["landings", "outcomes"])
def test_a_fit_whose_numbers_are_not_finite_is_refused(place: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Here the simulation itself goes wrong, as with values that no cell has."""
    simulate = getattr(ThrowModel, "_fly_part")  # noqa: B009 - a private name

    def fly(self: ThrowModel, *given: object) -> object:
        landing, touched = simulate(self, *given)
        is_drawn = len(landing) > len(self.log)
        return (np.full_like(landing, np.nan) if is_drawn == (place == "outcomes") else landing), touched

    monkeypatch.setattr(ThrowModel, "_fly_part", fly)
    with np.errstate(all="ignore"), pytest.raises(UsageError, match="no fit follows from these throws and this level"):
        quick_fit()


def test_landings_that_the_level_does_not_explain_are_no_fit() -> None:
    log = few_throws()
    far = replace(log, landing=log.landing + np.array([0.0, 3.0]))
    with pytest.raises(UsageError, match="no landing lies where this level lets its throw land"):
        fit_log(far, WASTE, priors(WASTE, SOME[:2]))


HOSTILE = {
    "--design": ("0", "801", "99999999999", "1.5", "nan", "-1"), "--twins": ("0", "10001", "1e3"),
    "--twins 1 --landings": ("9", "401", "99999999999"), "--twins 1 --seed": ("-1", "x"),
    "--twins 1 --free": ("nothing", "valve,tau"), "--twins 1 --prior": ("valve=1e300", "valve", "=", "valve=nan"),
}  # fmt: skip


@pytest.mark.parametrize(("option", "value"), [(option, value) for option in HOSTILE for value in HOSTILE[option]])
def test_options_have_ranges(option: str, value: str) -> None:
    refused("agents.fit", "--level", "waste", *option.split(), value)


@pytest.mark.nightly
def test_twins_of_a_users_level(tmp_path: Path) -> None:
    output_of("fit --level waste --twins 1 --landings 12 --free valve --seed 99999999999999999999", tmp_path)
    said = output_of("fit --level waste --twins 1 --landings 12 --free valve tau stiffness", tmp_path)
    assert "1 twins" in said
    assert "delays of items" in said


@pytest.mark.nightly
@pytest.mark.usefixtures("small_pool")
def test_a_twin_lands_as_many_throws_as_asked() -> None:
    twin = twins.make(WASTE, 5, 15, planned=True)
    assert twin.log.has_landing.sum() == 15
    assert len({*twin.log.percent}) > 1
    log, _ = throw(twin.truth, 8)
    assert len(log) == 8

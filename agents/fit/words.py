"""What a fit tells, in words: what is known, what only together, what not, and whether the model fits."""

from __future__ import annotations

from typing import Final

import numpy as np

from pnt_gym.arrays import Floats

from ..ground.tables import Grid
from .fitted import Estimate, Fitted
from .misfit import LEVEL

VAGUE: Final = 0.8
"""Share of the prior's standard deviation above which a log tells nothing of a parameter."""
TOGETHER: Final = 0.6
"""Correlation beyond which two parameters are told together."""
TOLD: Final = {
    frozenset({"camera_x", "encoder"}): "camera_at_picks",
    frozenset({"valve", "tau"}): "delay_",
}
"""Combination that is known where two parameters are not told apart."""
BIN_CAMERA: Final = (
    "An offset of the camera over the bins would be taken for one of the belt camera, and the reverse: measure one of "
    "them by hand."
)


BLOWN: Final = "The cup blows its objects off: they leave {} faster downwards than it."
FREE_MOTION: Final = (
    "Releases are taken as logged: nothing is said of the swing and the lip's stiffness, of grips that were lost, or "
    "of cups that touch their objects again."
)


def tables(fitted: Fitted, samples: Floats) -> list[Grid]:
    """Tables of the parameters, of what is known together, and of the seals."""
    priors = {p.name: p.scale * p.value(np.array([-1.96, 0.0, 1.96])) for p in fitted.posterior.parameters}
    rows = [
        (part.label, part.text, _text(priors[name]), f"{part.share:.2f}")
        for name, part in fitted.estimates(samples).items()
    ]
    head = f"{int(fitted.log.has_landing.sum())} landings of {len(fitted.log)} throws on level {fitted.config.name}"
    grids = [Grid(head, ("parameter", "fitted (95 %)", "prior (95 %)", "of the prior's width"), rows)]
    together = [(part.label, part.text, f"{part.share:.2f}") for part in fitted.combinations(samples).values()]
    if together:
        grids.append(Grid("Known together", ("combination", "fitted (95 %)", "of the prior's width"), together))
    if fitted.seals:
        seals = [
            (s.item, f"{s.sealed} of {s.tries}", f"{s.mean:.2f} ({s.low:.2f}..{s.high:.2f})") for s in fitted.seals
        ]
        grids.append(Grid("Chance that a cup seals", ("item", "sealed", "chance (95 %)"), seals))
    return grids


def _text(values: Floats) -> str:
    low, middle, high = values
    return f"{middle:.3g} ({low:.3g}..{high:.3g})"


def sentences(fitted: Fitted, samples: Floats) -> list[str]:
    """Sentences for people, the verdict on the model last."""
    estimates = fitted.estimates(samples)
    vague = [part.label for part in estimates.values() if part.share > VAGUE]
    names = {parameter.name for parameter in fitted.posterior.parameters}
    return [
        *([FREE_MOTION] if fitted.log.has_free_motion else []),
        *(f"This log does not tell {label}: the interval is hardly narrower than the prior." for label in vague),
        *([BLOWN.format(estimates["blow_off"].text)] if fitted.blows else []),
        *_pairs(fitted, samples),
        *([BIN_CAMERA] if names & {"camera_x", "camera_y"} else []),
        *_modes(fitted, samples),
        *verdict(fitted),
    ]


def _pairs(fitted: Fitted, samples: Floats) -> list[str]:
    """A sentence on each pair of parameters that are told together, with the combination that is known."""
    parameters, combinations = fitted.posterior.parameters, fitted.combinations(samples)
    if len(parameters) < 2:
        return []
    correlation, texts = np.atleast_2d(np.corrcoef(samples.T)), list[str]()
    for i, first in enumerate(parameters):
        for j, second in enumerate(parameters[:i]):
            if abs(correlation[i, j]) > TOGETHER:
                begin = TOLD.get(frozenset({first.name, second.name}), "-")
                parts = [part for name, part in combinations.items() if name.startswith(begin)]
                hint = f" Known: {_best(parts)}." if parts else ""
                texts.append(
                    f"This log tells {second.label} and {first.label} only together (correlation "
                    f"{correlation[i, j]:.2f}).{hint}"
                )
    return texts


def _best(parts: list[Estimate]) -> str:
    best = min(parts, key=lambda part: part.share)
    return f"{best.label} = {best.text}"


def _modes(fitted: Fitted, samples: Floats) -> list[str]:
    """A sentence where quite different stiffnesses explain the log."""
    names = [parameter.name for parameter in fitted.posterior.parameters]
    if "stiffness" not in names:
        return []
    far = np.abs(samples[:, names.index("stiffness")] - fitted.posterior.best.z[names.index("stiffness")]) > 1.0
    share = float(far.mean())
    text = f"Another stiffness of the lip explains the log nearly as well, with a probability of {share:.0%}."
    return [text] if share > 0.1 else []


def verdict(fitted: Fitted) -> list[str]:
    """Whether the model fits, and if not, what speaks against it."""
    alarms = [finding for finding in fitted.misfit if finding.alarms and finding.is_told]
    if fitted.fits:
        return [f"The model fits: none of {len(fitted.misfit)} tests speaks against it (at {LEVEL:.0%} in all)."]
    reasons = "; ".join(f"{finding.text} (p = {finding.chance:.1g})" for finding in alarms)
    wide = f" Intervals are {fitted.scatter:.2f} times as wide." if fitted.scatter > 1.05 else ""
    return [f"THE MODEL DOES NOT FIT: {reasons}.{wide}"]

"""The one way a controller is judged: by training, the command line, the benchmark and the report alike.

The number of parallel environments is fixed and independent of the machine, so the same seed always means
the same objects; on PnTRelease-v0 they do not depend on the actions either, which pairs the throws of
different controllers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Self, final

import numpy as np
from gymnasium.vector import VectorEnv

from agents.controllers.protocol import Actions, Controller, Learner, Observation, Outcome
from agents.environments import correction_of, stream_seed
from pnt_gym import metrics
from pnt_gym.correction import Correction
from pnt_gym.planning.arrays import Bools, Floats, Ints

NUM_ENVS = 16
PRACTICE = 120

Progress = Callable[[int], None]
"""Called with the number of throws just done."""
Env = VectorEnv[Any, Any, Any]


@final
@dataclass(frozen=True)
class Throws:
    """N throws in the order they are counted, one array entry each."""

    item: Ints
    """Index into the core's `item_names`."""
    target: Floats
    """x, y of the place thrown to, e.g. of the bin's opening (N, 2) [m]."""
    landing_error: Floats
    landing_along: Floats
    landing_across: Floats
    error: Floats
    """Errors in the coordinates that actions shift (N, E), in the order of the core's correction."""
    is_success: Bools
    cycle_time: Floats
    recontact: Bools
    rim: Bools
    clipped: Bools
    reward: Floats

    def __len__(self) -> int:
        return len(self.item)

    def head(self, count: int) -> Self:
        """The first `count` throws."""
        return type(self)(**{f.name: getattr(self, f.name)[:count] for f in fields(self)})

    @classmethod
    def concatenate(cls, parts: list[Throws]) -> Throws:
        """Throws one after another."""
        return cls(**{f.name: np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(cls)})


def evaluate(
    controller: Controller,
    env: Env,
    picks: int,
    seed: int,
    *,
    online: bool = False,
    progress: Progress | None = None,
) -> Throws:
    """Let a controller throw `picks` held-out objects.

    Args:
        controller: as it is; call `practise` first for one that learns.
        env: a vector environment; its number of rows is part of what the seed means.
        picks: throws to count, at least 1.
        seed: names the objects; no training or practice with any seed sees them.
        online: let it learn from these throws too.
        progress: told after each batch.
    """
    return _collect(thrown(controller, env, picks, stream_seed("evaluate", seed), learn=online), progress)


def practise(
    controller: Controller, env: Env, throws: int, seed: int, *, start: int = 0, progress: Progress | None = None
) -> None:
    """Let a controller that learns throw `throws` objects first; others, and 0 throws, do nothing.

    Args:
        controller: as it is.
        env: a vector environment; its number of rows is part of what the seed means.
        throws: to learn from.
        seed: names the objects.
        start: throws with this seed that are already behind it, so that others follow.
        progress: told after each batch.
    """
    if not isinstance(controller, Learner) or throws == 0:
        return
    controller.begin_practice(throws)
    _collect(thrown(controller, env, throws, stream_seed("practice", seed, start), learn=True), progress)
    controller.end_practice()


def thrown(controller: Controller, env: Env, picks: int, env_seed: int, *, learn: bool = False) -> Iterator[Throws]:
    """Carry out throws and yield each batch of them; the last batch is cut to `picks` in all."""
    correction = correction_of(env)
    features, info = env.reset(seed=env_seed)
    done = 0
    while done < picks:
        seen = Observation(np.array(features, dtype=np.float32), _kinds(info, env.num_envs))
        action = controller.act(seen)
        features, reward, _, _, info = env.step(action)
        part = _throws(info, np.asarray(reward), correction).head(picks - done)
        if learn:
            controller.learn(_outcome(seen, action, part))
        done += len(part)
        yield part


def _collect(batches: Iterable[Throws], progress: Progress | None) -> Throws:
    parts: list[Throws] = []
    for part in batches:
        parts.append(part)
        if progress is not None:
            progress(len(part))
    return Throws.concatenate(parts)


def _kinds(info: Mapping[str, Any], count: int) -> Ints:
    return np.array(info.get("kind", np.zeros(count)), dtype=np.int64)


def _throws(info: Mapping[str, Any], reward: Floats, correction: Correction | None) -> Throws:
    errors = [] if correction is None else [np.array(info[name], dtype=np.float64) for name in correction.errors]
    return Throws(
        item=np.array(info["item"], dtype=np.int64),
        target=np.stack([info["target_x"], info["target_y"]], axis=-1).astype(np.float64),
        landing_error=np.array(info["landing_error"], dtype=np.float64),
        landing_along=np.array(info["landing_along"], dtype=np.float64),
        landing_across=np.array(info["landing_across"], dtype=np.float64),
        error=np.stack(errors, axis=-1) if errors else np.zeros((len(reward), 0)),
        is_success=np.array(info["is_success"], dtype=np.bool_),
        cycle_time=np.array(info["cycle_time"], dtype=np.float64),
        recontact=np.array(info["recontact"], dtype=np.bool_),
        rim=np.array(info["rim"], dtype=np.bool_),
        clipped=np.array(info["residual_clipped"], dtype=np.bool_),
        reward=np.array(reward, dtype=np.float64),
    )


def _outcome(seen: Observation, action: Actions, part: Throws) -> Outcome:
    count = len(part)  # the last batch may hold more rows than were asked for
    return Outcome(
        observation=Observation(seen.features[:count], seen.kind[:count]),
        action=action[:count],
        error=part.error,
        is_success=part.is_success,
        cycle_time=part.cycle_time,
        clipped=part.clipped,
    )


def summary(throws: Throws) -> dict[str, float | int]:
    """Figures of an evaluation, by the names of the JSON contract."""
    rate = metrics.wilson(int(throws.is_success.sum()), len(throws))
    pace = metrics.throughput(throws.is_success, throws.cycle_time)
    where = metrics.landing(throws.landing_along, throws.landing_across)
    return {
        "picks": len(throws),
        "picks_per_min": pace.attempted,
        "sorted_per_min": pace.sorted,
        "success_rate": rate.value,
        "success_low": rate.low,
        "success_high": rate.high,
        "landing_error_mean_m": where.mean,
        "landing_error_p95_m": where.p95,
        "landing_error_iqm_m": where.iqm,
        "bias_along_m": where.bias_along,
        "bias_across_m": where.bias_across,
        "spread_along_m": where.spread_along,
        "spread_across_m": where.spread_across,
        "cycle_time_mean_s": pace.cycle_time,
        "recontact_rate": float(throws.recontact.mean()),
        "clipped_rate": float(throws.clipped.mean()),
        "reward_mean": float(throws.reward.mean()),
        "unmeasured": where.unmeasured,
        **failures(throws),
    }


def failures(throws: Throws) -> dict[str, float]:
    """Share of all throws that failed, by what stood between; the three sum to the failure rate.

    A touched object is counted as touched whatever it did then; the rest either missed the target
    (opening or pose) or reached it without staying there.
    """
    failed = ~throws.is_success
    touched = failed & throws.recontact
    rim = failed & ~throws.recontact & throws.rim
    return {
        "failed_recontact": float(touched.mean()),
        "failed_rim": float(rim.mean()),
        "failed_missed": float((failed & ~touched & ~rim).mean()),
    }


RECORDED = ("landing_along", "landing_across")
"""Errors that every record has under names of its own."""


def throw_records(
    throws: Throws, item_names: Sequence[str], correction: Correction | None = None
) -> list[dict[str, Any]]:
    """One JSON object per throw.

    Args:
        throws: as evaluated.
        item_names: of the core.
        correction: of the core; errors it has beyond the landing are recorded by their names.
    """
    names = () if correction is None else correction.errors
    more = [(name, column) for column, name in enumerate(names) if name not in RECORDED]
    return [
        {
            "item": item_names[throws.item[i]],
            "target": [float(v) for v in throws.target[i]],
            "landing_error_m": _number(throws.landing_error[i]),
            "landing_along_m": _number(throws.landing_along[i]),
            "landing_across_m": _number(throws.landing_across[i]),
            "success": bool(throws.is_success[i]),
            "cycle_time_s": float(throws.cycle_time[i]),
            "recontact": bool(throws.recontact[i]),
            "rim": bool(throws.rim[i]),
            "clipped": bool(throws.clipped[i]),
            **{name: _number(throws.error[i, column]) for name, column in more},
        }
        for i in range(len(throws))
    ]


def _number(value: float) -> float | None:
    """JSON has no NaN."""
    return float(value) if np.isfinite(value) else None

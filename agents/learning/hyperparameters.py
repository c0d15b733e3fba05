"""The learning algorithms by name, and their hyperparameters in RL-Zoo syntax."""

from __future__ import annotations

import ast
import math
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any, Final, Literal, get_args

from pnt_gym.cells.base.config import quotes_hint
from pnt_gym.errors import one_sentence
from pnt_gym.names import join_names

from ..ground.cli import UsageError
from ..ground.files import read_yaml
from ..ground.places import SHIPPED, at

Residual = Literal["sac", "td3", "ppo", "tqc", "recurrent_ppo"]
Masked = Literal["maskable_ppo", "residual_ppo"]
Algorithm = Literal[Residual, Masked]
RESIDUAL: tuple[Residual, ...] = get_args(Residual)
"""Algorithms that learn a residual: they correct throws."""
MASKED: tuple[Masked, ...] = get_args(Masked)
"""Algorithms for masked discrete actions: they choose the next object on a line."""
SCORING: tuple[Algorithm, ...] = ("residual_ppo",)
"""Algorithms whose policies are scorers: one network scores each choice."""
ON_POLICY: tuple[Algorithm, ...] = ("ppo", "recurrent_ppo")
"""Algorithms that learn from every step once, and have no replay buffer."""
RECURRENT: tuple[Algorithm, ...] = ("recurrent_ppo",)
"""Algorithms with recurrent policies, which remember earlier observations of a shift."""
SEEING: tuple[Algorithm, ...] = ("sac", "ppo")
"""Algorithms that learn from pictures beside vectors."""
MAX_STACK: Final = 100
"""Observations that a policy sees at once, at most."""
MOST_MODEL: Final = 2**28
"""Largest size of a model file, compressed or not [bytes]."""


DEFAULT: Final = "default"
"""Name of the entry for environments without an entry of their own."""


SIZES: Final = {"steps": "n_timesteps", "num_envs": "n_envs"}
"""Hyperparameters of the training, not of an algorithm, by the training's argument."""
WHOLE: Final = {
    "n_timesteps": (1, 10**9),
    "n_envs": (1, 10**5),
    "buffer_size": (1, 10**9),
    "batch_size": (1, 10**6),
    "learning_starts": (0, 10**9),
    "train_freq": (1, 10**6),
    "gradient_steps": (-1, 10**6),
    "policy_delay": (1, 10**6),
    "target_update_interval": (1, 10**6),
    "n_steps": (1, 10**6),
    "n_epochs": (1, 10**6),
    "sde_sample_freq": (-1, 10**6),
    "stats_window_size": (1, 10**6),
    "top_quantiles_to_drop_per_net": (0, 1000),
    "n_critics": (1, 100),
    "n_quantiles": (1, 10**4),
    "lstm_hidden_size": (1, 10**4),
    "n_lstm_layers": (1, 1),
}
REAL: Final = {
    "learning_rate": (0.0, 1.0),
    "gamma": (0.0, 1.0),
    "tau": (0.0, 1.0),
    "gae_lambda": (0.0, 1.0),
    "clip_range": (0.0, 1e6),
    "clip_range_vf": (0.0, 1e6),
    "vf_coef": (0.0, 1e6),
    "max_grad_norm": (0.0, 1e6),
    "target_kl": (0.0, 1e6),
    "target_policy_noise": (0.0, 1e6),
    "target_noise_clip": (0.0, 1e6),
    "log_std_init": (-20.0, 20.0),
    "patience": (0.01, 1000.0),
    "sharpness": (0.01, 1000.0),
    "price_of_time": (0.0, 1e6),
}
FALLING: Final = "learning_rate"
"""Hyperparameter that may fall linearly to 0 over the training: `lin_0.001` begins at 0.001."""
LINE: Final = "lin_"
SWITCHES: Final = (
    "use_sde", "use_sde_at_warmup", "normalize_advantage", "optimize_memory_usage", "shared_lstm", "enable_critic_lstm",
)  # fmt: skip
OPTIONAL: Final = ("clip_range_vf", "target_kl", "action_noise")
"""Hyperparameters that may also be null."""
WIDEST: Final = 10**5
"""Largest width of a network's layer."""
MOST_WEIGHTS: Final = 10**7
"""Largest number of weights between the layers of a network."""


def hyperparameters(algo: str, env_id: str, file: Path | None = None) -> dict[str, Any]:
    """Hyperparameters of an algorithm for an environment, from a file in RL-Zoo syntax.

    Args:
        algo: name of the algorithm, whose shipped file is read if `file` is None.
        env_id: id of the environment, or MODULE:ID; the entry `DEFAULT` is for environments without an entry.
        file: a user's file, or another shipped file.

    Raises:
        UsageError: the file is missing or damaged, or has no entry for the environment.
    """
    path = SHIPPED / "configs" / "rl" / f"{algo}.yml" if file is None else at(file)
    entries = read_yaml(path, "hyperparameters")
    entries = entries if isinstance(entries, dict) else {}
    for name in (env_id, env_id.rpartition(":")[2], DEFAULT):
        if name in entries:
            return _settings(path, name, entries[name])
    entry_names = join_names([env_id], [*map(str, entries)]) or "none"
    raise UsageError(f"hyperparameters {str(path)!r} have no entry for {env_id!r}; entries are {entry_names}")


def _settings(path: Path, name: str, entry: Any) -> dict[str, Any]:
    if not isinstance(entry, dict):
        reason = f"entry {name!r} is {one_sentence(repr(entry), 80)}; it must be a mapping, {{}} for none"
        raise UsageError(f"hyperparameters {str(path)!r}: {reason}")
    return dict(entry)


def training_size(algo: str, env_id: str, settings: Mapping[str, Any]) -> dict[str, int]:
    """Number of steps and of cells of a training, by its hyperparameters.

    Args:
        algo: name of the algorithm, whose shipped settings are the defaults.
        env_id: id of the environment.
        settings: hyperparameters.

    Raises:
        UsageError: a number is out of its range.
    """
    usual = {**hyperparameters(algo, env_id), **settings}
    for key in SIZES.values():
        _check(key, usual[key])
    return {name: _whole(usual[key]) for name, key in SIZES.items()}


def algorithm_arguments(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of an algorithm's constructor, from hyperparameters in RL-Zoo syntax.

    The libraries would report some wrong values only after thousands of throws, or never.

    Raises:
        UsageError: a value is out of its range, or of the wrong type.
    """
    chosen = {name: value for name, value in settings.items() if name not in SIZES.values()}
    kwargs = chosen["policy_kwargs"] = policy_arguments(chosen.get("policy_kwargs", {}))
    for name, value in {**chosen, **kwargs}.items():
        _check(name, value)
    for values in (chosen, kwargs):
        values |= {name: _whole(value) for name, value in values.items() if name in WHOLE}
    chosen.pop("price_of_time", None)  # part of the reward, not of the algorithm
    if "patience" in chosen:
        kwargs["patience"] = chosen.pop("patience")
    return chosen


def _check(name: str, value: Any) -> None:
    """Make sure that the value of a hyperparameter is in its range.

    Raises:
        UsageError: the value is not in its range.
    """
    if not _fits(name, value):
        hint = quotes_hint(value) if isinstance(value, str) else ""
        raise UsageError(f"hyperparameter {name} is {one_sentence(repr(value), 80)}; it must be {_text(name)}{hint}")
    weights = max(map(_count, _layers(value)), default=0) if name == "net_arch" else 0
    if weights > MOST_WEIGHTS:
        raise UsageError(f"hyperparameter net_arch asks for {weights:,} weights; it must be at most {MOST_WEIGHTS:,}")


def _whole(value: Any) -> Any:
    """A float without a fraction, such as `1e5`, as an integer; other values unchanged."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _layers(value: Any) -> list[Any]:
    """Sizes of the layers of each network in a `net_arch`."""
    return list(value.values()) if isinstance(value, dict) else [value]


def _count(sizes: list[int]) -> int:
    return sum(before * after for before, after in pairwise(sizes))


def _fits(name: str, value: Any) -> bool:
    if value is None and name in OPTIONAL:
        return True
    if name in SWITCHES or isinstance(value, bool):
        return isinstance(value, bool) and name not in {*WHOLE, *REAL, "net_arch"}
    if name in WHOLE:
        value = _whole(value)
        return isinstance(value, int) and WHOLE[name][0] <= value <= WHOLE[name][1]
    if name in REAL:
        value = initial_value(value) if name == FALLING else value
        return isinstance(value, int | float) and REAL[name][0] <= value <= REAL[name][1]
    if name == "net_arch":
        return all(
            isinstance(sizes, list)
            and all(isinstance(size, int) and not isinstance(size, bool) and 1 <= size <= WIDEST for size in sizes)
            for sizes in _layers(value)
        )
    return name != "action_noise" and not (isinstance(value, float) and not math.isfinite(value))


def initial_value(value: Any) -> Any:
    """First value of a linearly falling hyperparameter; other values, and text without a number, unchanged."""
    try:
        return float(value.removeprefix(LINE)) if isinstance(value, str) and value.startswith(LINE) else value
    except ValueError:
        return value


def _text(name: str) -> str:
    """Range of a hyperparameter as text for an error."""
    if name in WHOLE:
        return "a whole number from {} to {}".format(*WHOLE[name])
    if name in REAL:
        number = "a number from {:g} to {:g}".format(*REAL[name])
        return f"{number}, or {LINE} and such a number" if name == FALLING else number
    if name in SWITCHES:
        return "true or false"
    if name == "net_arch":
        return f"a list of whole numbers from 1 to {WIDEST}, or lists of them by name (pi, qf, vf)"
    return "left out or null" if name == "action_noise" else "a finite number, or what its documentation says"


def policy_arguments(value: Any) -> dict[str, Any]:
    """The `policy_kwargs` of an algorithm, from a mapping or from RL-Zoo's text, which can name an activation.

    The text, such as `dict(net_arch=[64, 64], activation_fn=nn.SiLU)`, is parsed and never run.

    Raises:
        UsageError: the text is no call of dict with literals and names of torch.nn.
    """
    if isinstance(value, dict):
        return dict(value)
    try:
        if not isinstance(value, str):
            raise ValueError("not text")
        call = ast.parse(value.strip(), mode="eval").body
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "dict"):
            raise ValueError("not a call of dict")
        return {str(word.arg): _value(word.value) for word in call.keywords}
    except (ValueError, SyntaxError, AttributeError):
        raise UsageError(
            f"policy_kwargs is {value!r}; it must be a mapping, "
            "or look like dict(net_arch=[64, 64], activation_fn=nn.SiLU)"
        ) from None


def _value(node: ast.expr) -> Any:
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "nn":
        from torch import nn  # noqa: PLC0415 - a second to import

        kind = getattr(nn, node.attr)
        if not (isinstance(kind, type) and issubclass(kind, nn.Module)):
            raise ValueError("no kind of layer")
        return kind
    return ast.literal_eval(node)

"""Hyperparameters of the learning algorithms, in RL-Zoo syntax."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any, Final

from .cli import UsageError
from .files import read_yaml
from .places import SHIPPED

DEFAULT: Final = "default"
"""Entry for environments that have none of their own."""


def hyperparameters(algo: str, env_id: str, file: Path | None = None) -> dict[str, Any]:
    """Settings of an algorithm for an environment, from a file in RL-Zoo syntax.

    Args:
        algo: name of the algorithm, whose shipped file is read unless there is another.
        env_id: id of the environment, or MODULE:ID; one without an entry has that of `DEFAULT`.
        file: of the user's.

    Raises:
        UsageError: the file is missing or damaged, or has no entry for the environment.
    """
    path = file if file is not None else SHIPPED / "configs" / "rl" / f"{algo}.yml"
    entries = read_yaml(path, "hyperparameters")
    entries = entries if isinstance(entries, dict) else {}
    for name in (env_id, env_id.rpartition(":")[2], DEFAULT):
        if isinstance(entries.get(name), dict):
            return dict(entries[name])
    known = ", ".join(map(str, entries)) or "none"
    raise UsageError(f"hyperparameters {str(path)!r} have no entry for {env_id!r}; entries are {known}")


def policy_arguments(given: Any) -> dict[str, Any]:
    """The `policy_kwargs` of an algorithm: a mapping as it is, or RL-Zoo's text that can name an activation.

    The text, `dict(net_arch=[64, 64], activation_fn=nn.SiLU)`, is read and never run.

    Raises:
        UsageError: the text is not such a call of dict with literals and names of torch.nn.
    """
    if not isinstance(given, str):
        return dict(given)
    try:
        call = ast.parse(given.strip(), mode="eval").body
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "dict"):
            raise ValueError("not a call of dict")
        return {str(word.arg): _value(word.value) for word in call.keywords}
    except (ValueError, SyntaxError, AttributeError):
        raise UsageError(
            f"policy_kwargs is {given!r}; it must be a mapping, "
            "or look like dict(net_arch=[64, 64], activation_fn=nn.SiLU)"
        ) from None


def _value(node: ast.expr) -> Any:
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "nn":
        from torch import nn  # noqa: PLC0415 - a second to import

        return getattr(nn, node.attr)
    return ast.literal_eval(node)

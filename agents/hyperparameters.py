"""Hyperparameters of the learning algorithms, in RL-Zoo syntax."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import yaml

from agents.cli import UsageError
from agents.versions import ROOT


def hyperparameters(algo: str, env_id: str, file: Path | None = None) -> dict[str, Any]:
    """Settings of an algorithm for an environment, from a file in RL-Zoo syntax.

    Raises:
        UsageError: the file is missing or damaged, or has no entry for the environment.
    """
    path = file if file is not None else ROOT / "configs" / "rl" / f"{algo}.yml"
    try:
        entries = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"cannot read hyperparameters {str(path)!r}: {error.strerror}") from None
    except yaml.YAMLError as error:
        raise UsageError(f"hyperparameters {str(path)!r} are not valid YAML: {str(error).splitlines()[0]}") from None
    if not isinstance(entries, dict) or not isinstance(entries.get(env_id), dict):
        known = ", ".join(entries) if isinstance(entries, dict) else "none"
        raise UsageError(f"hyperparameters {str(path)!r} have no entry for {env_id!r}; entries are {known}")
    return dict(entries[env_id])


def policy_arguments(given: Any) -> dict[str, Any]:
    """The `policy_kwargs` of an algorithm: a mapping as it is, or RL-Zoo's text that can name an activation.

    The text, `dict(net_arch=[64, 64], activation_fn=nn.SiLU)`, is read and never run.

    Raises:
        UsageError: the text is not such a call of dict with literals and names of torch.nn.
    """
    if not isinstance(given, str):
        return dict(given)
    text = given
    try:
        call = ast.parse(text.strip(), mode="eval").body
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "dict"):
            raise ValueError("not a call of dict")
        return {str(word.arg): _value(word.value) for word in call.keywords}
    except (ValueError, SyntaxError, AttributeError):
        raise UsageError(
            f"policy_kwargs is {text!r}; it must be a mapping, "
            "or look like dict(net_arch=[64, 64], activation_fn=nn.SiLU)"
        ) from None


def _value(node: ast.expr) -> Any:
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "nn":
        from torch import nn  # noqa: PLC0415 - a second to import

        return getattr(nn, node.attr)
    return ast.literal_eval(node)

"""Hyperparameters of the learning algorithms, in RL-Zoo syntax."""

from __future__ import annotations

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

"""Versions of the code and the packages behind a result."""

from __future__ import annotations

import platform
import subprocess
from functools import cache
from importlib import metadata

from .places import CHECKOUT, SHIPPED

PACKAGES = (
    "pnt_gym",
    "mujoco",
    "gymnasium",
    "numpy",
    "numba",
    "scipy",
    "casadi",
    "torch",
    "stable_baselines3",
    "sb3_contrib",
)


@cache
def versions() -> dict[str, str]:
    """Versions of Python and of the packages a result depends on."""
    package_versions = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            package_versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            package_versions[package] = "not installed"
    return package_versions


def git_state() -> str | None:
    """Commit and changed files of the checkout, or None outside of one or before the first commit."""
    if not CHECKOUT:
        return None
    commit = _git("rev-parse", "HEAD")
    if commit is None:
        return None
    return f"commit {commit.strip()}\n{_git('status', '--short') or ''}"


def _git(*arguments: str) -> str | None:
    try:
        process = subprocess.run(
            ["git", *arguments], cwd=SHIPPED, capture_output=True, text=True, check=False, timeout=10
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return process.stdout if process.returncode == 0 else None

"""Versions and digests of the code, and versions of the packages, behind a result."""

from __future__ import annotations

import hashlib
import platform
import re
import subprocess
from collections.abc import Iterable, Mapping
from functools import cache
from importlib import metadata
from modulefinder import ModuleFinder
from pathlib import Path
from typing import Any, Final, final

from pnt_gym.constants import WORLD
from pnt_gym.errors import one_sentence

from .cli import UsageError
from .places import CHECKOUT, CODE, SHIPPED, module_name

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
    """Versions of Python and of the packages a result depends on, and the world that these simulate."""
    package_versions = {"world": str(WORLD), "python": platform.python_version()}
    for package in PACKAGES:
        try:
            package_versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            package_versions[package] = "not installed"
    return package_versions


def world_of(head: Mapping[str, Any]) -> int:
    """World in which a result was measured, by the head of its file; files of earlier versions do not name it.

    Raises:
        UsageError: the world is no whole number.
    """
    world = str(head.get("world", head.get("versions", {}).get("world", 1)))
    if not re.fullmatch(r"[1-9]\d{0,5}", world):
        raise UsageError(
            f"a file of results is of world {one_sentence(repr(world), 40)}; worlds are whole numbers from 1 on"
        )
    return int(world)


def git_state() -> str | None:
    """Commit and changed files of the checkout, or None outside of one or before the first commit."""
    if not CHECKOUT:
        return None
    commit = commit_of(SHIPPED)
    return None if commit is None else f"commit {commit}\n{_git(SHIPPED, 'status', '--short') or ''}"


def commit_of(folder: Path) -> str | None:
    """Commit of the checkout in which a folder lies, or None outside of one or before the first commit."""
    commit = _git(folder, "rev-parse", "HEAD")
    return None if commit is None else commit.strip()


def _git(folder: Path, *arguments: str) -> str | None:
    try:
        process = subprocess.run(
            ["git", *arguments], cwd=folder, capture_output=True, text=True, check=False, timeout=10
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return process.stdout if process.returncode == 0 else None


DRAWS_ONLY: Final = ("view.py", "canvas.py")
"""Files of code that only draws and changes no result."""
ROOTS: Final = ("pnt_gym", "agents", "papers")
"""Packages whose imports are followed."""


def code_digest(patterns: Iterable[str], modules: Iterable[str] = (), root: Path = CODE) -> str:
    """Digest of the files that match any pattern and of modules with their imports, without `DRAWS_ONLY`.

    Args:
        patterns: globs below `root`.
        modules: names of modules below `root`; a package stands for all its modules.
        root: folder of the code.
    """
    # Installed, `agents` lies in the package.
    globs = (glob if CHECKOUT or not glob.startswith("agents/") else f"pnt_gym/{glob}" for glob in patterns)
    files = {path for glob in globs for path in root.glob(glob)}
    files |= {path for name in modules for path in module_files(module_name(name), root)}
    digest = hashlib.sha256()
    for path in sorted(files):
        if not any(path.match(pattern) for pattern in DRAWS_ONLY):
            digest.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()


@cache
def module_files(name: str, root: Path) -> frozenset[Path]:
    """Files of a module, or of all modules of a package, and of the modules of `ROOTS` that they import.

    The code is read and not run. An import within a function counts; an import by a string does not.

    Args:
        name: name of the module.
        root: folder of the module's top-level package.
    """
    finder = _Finder(path=[str(root)])
    finder.import_hook(name)
    for file in sorted((root / name.replace(".", "/")).glob("**/*.py")):
        finder.import_hook(".".join(file.relative_to(root).with_suffix("").parts).removesuffix(".__init__"))
    files = (getattr(module, "__file__", None) for module in finder.modules.values())
    return frozenset(Path(file) for file in files if file)


@final
class _Finder(ModuleFinder):
    """Follows imports within `ROOTS` alone; other packages count by their versions."""

    def find_module(self, name: str, path: Any, parent: Any = None) -> Any:
        if path is None and name not in ROOTS:
            raise ImportError(name)
        return super().find_module(name, path, parent)

"""Digests of the code that a result depends on: of files, and of modules with all that they import."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from functools import cache
from modulefinder import ModuleFinder
from pathlib import Path
from typing import Any, Final, final

from ..ground.places import CODE, code_pattern, module_name

DRAWS_ONLY: Final = ("view.py", "canvas.py")
"""Files of code that only draws and changes no result."""
PACKAGES: Final = ("pnt_gym", "agents", "papers")
"""Packages whose imports are followed."""


def code_digest(patterns: Iterable[str], modules: Iterable[str] = (), root: Path = CODE) -> str:
    """Digest of the files that match any pattern and of modules with their imports, without `DRAWS_ONLY`.

    Args:
        patterns: globs below `root`.
        modules: names of modules below `root`; a package stands for all its modules.
        root: folder of the code.
    """
    files = {path for pattern in patterns for path in root.glob(code_pattern(pattern))}
    files |= {path for name in modules for path in module_files(module_name(name), root)}
    digest = hashlib.sha256()
    for path in sorted(files):
        if not any(path.match(pattern) for pattern in DRAWS_ONLY):
            digest.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()


@cache
def module_files(name: str, root: Path) -> frozenset[Path]:
    """Files of a module, or of all modules of a package, and of the modules of `PACKAGES` that they import.

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
    """Follows imports within `PACKAGES` alone; other packages count by their versions."""

    def find_module(self, name: str, path: Any, parent: Any = None) -> Any:
        if path is None and name not in PACKAGES:
            raise ImportError(name)
        return super().find_module(name, path, parent)

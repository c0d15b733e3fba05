"""Modules that are imported when they are first needed: those of compiled functions, because numba loads slowly."""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import Any


class Deferred(ModuleType):
    """Stand-in for a module, which it imports at the first use of each name.

    An import statement in a function does the same, and takes ten times as long as a name at every call.
    """

    def __getattr__(self, name: str) -> Any:
        value = getattr(import_module(self.__name__), name)
        setattr(self, name, value)
        return value


def defer(package: str, *modules: str) -> None:
    """Let `from package import module` give a stand-in for each of these modules until the module is imported."""
    for module in modules:
        setattr(sys.modules[package], module, Deferred(f"{package}.{module}"))

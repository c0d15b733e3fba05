"""Controllers, training and evaluation on `pnt_gym`: modules at the top are commands, folders hold their parts."""

from pathlib import Path

__path__.append(str(Path(__path__[0]) / "former"))
"""Modules that have moved can still be imported by their former names: `former/` has one file for each."""

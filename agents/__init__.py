"""Controllers, training, evaluation and all else that uses `pnt_gym`: at the top what one types, then rooms."""

from pathlib import Path

__path__.append(str(Path(__path__[0]) / "former"))
"""Modules that have moved keep their former names: `former/` has one file for each."""

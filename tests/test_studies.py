"""Studies and benchmarks take hours and are run by hand; what is held here is that all they import is still there."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

SCRIPTS = sorted((Path(__file__).resolve().parents[1] / "benchmarks").rglob("*.py"))


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_a_script_loads_and_says_what_it_is_for(path):
    assert runpy.run_path(str(path), run_name="loaded")["__doc__"]

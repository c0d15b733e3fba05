"""Digests of the code that a result depends on."""

from collections.abc import Callable
from pathlib import Path

import pytest

from agents.ground.places import CODE
from agents.ground.versions import code_digest, module_files

Write = Callable[[str, str], None]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Writes a file below an empty folder."""

    def write(name: str, text: str) -> None:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)

    return write


def test_digests_change_with_files_but_not_with_what_only_draws(write: Write, tmp_path: Path) -> None:
    def digest() -> str:
        return code_digest(("cells/**/*.py", "top.py", "*.py"), root=tmp_path)

    for name in ("cells/one/plant.py", "cells/one/view.py", "top.py", "other/none.py"):
        write(name, "1")
    first = digest()
    for name in ("cells/one/view.py", "cells/base/canvas.py", "other/none.py"):
        write(name, "2")
        assert digest() == first
    seen = {first}
    for name in ("cells/one/plant.py", "top.py", "cells/two/plant.py"):
        write(name, "3")
        assert digest() not in seen
        seen.add(digest())
    (tmp_path / "top.py").rename(tmp_path / "bottom.py")
    assert digest() not in seen


def test_digests_change_with_every_module_that_is_imported_and_with_no_other(write: Write, tmp_path: Path) -> None:
    sources = {
        "agents/__init__.py": "",
        "agents/run.py": "from .room import near\nimport pnt_gym.cell\nimport numpy, nowhere",
        "agents/room/__init__.py": "",
        "agents/room/near.py": "def late():\n    from . import far",
        "agents/room/far.py": "",
        "agents/room/other.py": "",
        "pnt_gym/__init__.py": "",
        "pnt_gym/cell.py": "",
        "numpy/__init__.py": "",
    }
    for name, text in sources.items():
        write(name, text)
    apart = {"agents/room/other.py", "numpy/__init__.py"}
    first = code_digest([], ["agents.run"], tmp_path)
    for name, text in sources.items():
        write(name, f"{text}\n# changed")
        assert (code_digest([], ["agents.run"], tmp_path) == first) == (name in apart), name
        write(name, text)


def test_a_benchmark_depends_on_all_that_trains() -> None:
    files = {path.relative_to(CODE).as_posix() for path in module_files("agents.benchmark.run", CODE)}
    for name in ("runs", "hyperparameters", "progress", "sb3", "vec_env", "residual"):
        assert f"agents/learning/{name}.py" in files
    assert "agents/training/session.py" in files

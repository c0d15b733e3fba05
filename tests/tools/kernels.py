"""Machine code of all kernels, made by several processes side by side."""

import importlib
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pnt_gym


def kernel_modules() -> list[str]:
    """Names of the modules of the suite and of its agents that hold kernels."""
    root = Path(pnt_gym.__file__).parents[1]
    files = sorted(file for room in ("pnt_gym", "agents") for file in (root / room).rglob("*.py"))
    kernels = [file for file in files if "\n@kernel\n" in file.read_text(encoding="utf-8")]
    return [".".join(file.relative_to(root).with_suffix("").parts) for file in kernels]


def load(module: str) -> None:
    """Import a module, whose kernels are compiled then unless their machine code is kept."""
    importlib.import_module(module)


def compile_kernels(processes: int) -> None:
    """Compile the kernels that are not kept yet."""
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        list(pool.map(load, kernel_modules()))


if __name__ == "__main__":
    compile_kernels(1)

"""What the long checks share: their command line, choices at random, the memory of the process, and how they end."""

from __future__ import annotations

import argparse
import ctypes
import gc
import resource
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pnt_gym.arrays import Bools, Ints


def check_parser(doc: str | None) -> argparse.ArgumentParser:
    """A command line whose help is the text of the script."""
    return argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)


def choices(mask: Bools, random: np.random.Generator, ruled_out: float = 0.0) -> Ints:
    """Choices at random for N lines.

    Args:
        mask: what there is to choose (N, C).
        random: generator.
        ruled_out: share of lines that choose what the mask rules out.

    Returns:
        Choices (N,).
    """
    score = random.random(mask.shape) + mask
    if ruled_out > 0.0:
        score = np.where(random.random((len(mask), 1)) < ruled_out, -score, score)
    return score.argmax(axis=1)


def random_action(env: Any, info: Mapping[str, Any], random: np.random.Generator, scale: float) -> Any:
    """Random corrections up to a scale; on a line random choices that exist."""
    if "action_mask" in info:
        mask = np.asarray(info["action_mask"])
        return choices(np.atleast_2d(mask), random).reshape(mask.shape[:-1])[()]
    return (scale * random.uniform(-1.0, 1.0, env.action_space.shape)).astype(np.float32)


def memory() -> float:
    """Memory of this process, without garbage and without freed pieces of the heap [MB]."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[1])
    return pages * resource.getpagesize() / 1e6


def growth(used: Sequence[float], settled: int) -> float:
    """Growth of memory over the rounds [MB]: a leak stays, and a single round may leave the heap in larger pieces."""
    return min(used[-settled:]) - used[settled - 1] if len(used) >= settled else 0.0


def show(progress: str) -> None:
    """Print how far a check is over what it printed before."""
    print(f"\r{progress}", end="", flush=True)


def end(finds: Sequence[str], summary: str) -> int:
    """Print what a check found, and its summary; exit code 1 at a find."""
    for find in finds:
        print(f"FIND {find}")
    print(summary)
    return int(bool(finds))

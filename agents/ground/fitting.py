"""The circumstances in which controllers learn and act, the same everywhere: one thread, and for networks a seed."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

Inputs = ParamSpec("Inputs")
Result = TypeVar("Result")


def on_one_thread(function: Callable[Inputs, Result]) -> Callable[Inputs, Result]:
    """Let a function do its linear algebra on one thread: on several, sums end in other digits."""

    @wraps(function)
    def call(*args: Inputs.args, **options: Inputs.kwargs) -> Result:
        with threadpool_limits(1, user_api="blas"):
            return function(*args, **options)

    return call


@contextmanager
def fit_from(seed: int) -> Generator[None]:
    """Context in which torch draws from a seed and computes on one thread; at its end torch is as before.

    Small networks are fitted up to ten times more slowly on several threads where something else uses the cores.
    """
    import torch  # noqa: PLC0415 - a second to import, needed for fitting only

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            yield
    finally:
        torch.set_num_threads(threads)

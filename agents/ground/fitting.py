"""The circumstances in which a network is fitted, the same for all networks."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager


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

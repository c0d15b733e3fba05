"""A process that does one call after the other, each within a limited time."""

import os
import time

import pytest

from agents.ground.cli import UsageError
from agents.ground.work import UnfinishedError, limited_worker


def refuse() -> None:
    raise UsageError("no")


def test_calls_that_take_too_long_die_or_fail_leave_a_worker_that_goes_on() -> None:
    with limited_worker(5.0) as worker:
        first = worker.call(os.getpid)
        assert first == worker.call(os.getpid) != os.getpid()
        with pytest.raises(UsageError, match="no"):
            worker.call(refuse)
        with pytest.raises(UnfinishedError, match="its process died"):
            worker.call(os._exit, 3)
        second = worker.call(os.getpid)
        worker.seconds = 0.3
        with pytest.raises(UnfinishedError, match=r"not done after 0\.3 s"):
            worker.call(time.sleep, 600)
        worker.seconds = 60.0
        assert worker.call(os.getpid) != second
    for number in (first, second):
        with pytest.raises(ProcessLookupError):
            os.kill(number, 0)

"""One thread that computes for a session: of jobs that wait only the newest is done."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable
from typing import Final, final

Job = Callable[[Callable[[], bool]], None]
"""Work of some seconds; its argument says whether newer work waits, at which the job returns early."""
PATIENCE: Final = 0.1
"""Time for which the end of a page waits for a job [s]; the thread ends with the process."""


@final
class Worker:
    """A thread for jobs: a newer job takes the place of an older one that waits, and tells a running job to stop."""

    def __init__(self) -> None:
        self._change = threading.Condition()
        self._job: Job | None = None
        self._is_busy = self._is_closed = False
        self.faults = 0
        """Jobs that ended in a fault of the program."""
        self._thread = threading.Thread(target=self._work, name="design", daemon=True)
        self._thread.start()

    def ask(self, job: Job) -> None:
        """Do a job next, in place of any other that waits."""
        with self._change:
            self._job = job
            self._change.notify_all()

    def wait(self, seconds: float = 60.0) -> bool:
        """Wait until no job is left; whether none is."""
        with self._change:
            return self._change.wait_for(lambda: self._job is None and not self._is_busy, seconds)

    def close(self) -> None:
        """End the thread after its job, which is told to stop; safe to call twice."""
        with self._change:
            self._is_closed, self._job = True, None
            self._change.notify_all()
        self._thread.join(PATIENCE)

    def _is_stale(self) -> bool:
        """Whether the running job should return."""
        return self._job is not None or self._is_closed

    def _work(self) -> None:
        while True:
            with self._change:
                self._is_busy = False
                self._change.notify_all()
                self._change.wait_for(self._is_stale)
                job, self._job = self._job, None
                if job is None:
                    return
                self._is_busy = True
            try:
                job(self._is_stale)
            except Exception:
                # The page goes on: the fault is told where the command was started.
                self.faults += 1
                traceback.print_exc()

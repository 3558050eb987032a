"""Slots: jobs of one slot replace each other, those of different slots run side by side."""

import threading
from typing import Callable, Dict, List, Optional

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import REPLACED


class SlotJob(threading.Thread):
    """One job in its own thread."""

    def __init__(self, work: Callable[[Cancellation], None], previous: "Optional[SlotJob]") -> None:
        super().__init__(name="job", daemon=True)
        self.cancellation = Cancellation()
        self._work: Optional[Callable[[Cancellation], None]] = work
        self._previous = previous

    def run(self) -> None:
        # The job that was replaced answers first; here, because no callback may wait for it.
        if self._previous is not None:
            self._previous.join()
            self._previous = None
        # A slot keeps its last job, but not the data of that.
        work, self._work = self._work, None
        if work is not None:
            work(self.cancellation)


class ConcurrencySlots:
    """The jobs of all slots. Every method returns at once and may be called from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._jobs: Dict[int, SlotJob] = {}

    def start(self, slot: int, run: Callable[[Cancellation], None]) -> SlotJob:
        """Run a job in a slot; the job that is there is canceled and ends first.

        Args:
            slot: number of the slot.
            run: does the job, in a thread of its own, until its `Cancellation` says stop.
        """
        with self._lock:
            previous = self._jobs.get(slot)
            job = self._jobs[slot] = SlotJob(run, previous)
            job.start()
        if previous is not None:
            previous.cancellation.cancel(f"{REPLACED} {slot}")
        return job

    def cancel_all(self, reason: str) -> List[SlotJob]:
        """Cancel the jobs of all slots; returns them."""
        with self._lock:
            jobs = list(self._jobs.values())
        for job in jobs:
            job.cancellation.cancel(reason)
        return jobs

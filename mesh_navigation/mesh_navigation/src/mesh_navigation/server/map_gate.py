"""The map arrives while goals may already be there: they wait for it, or are told why not."""

import threading
import time
from typing import Callable, NamedTuple, Optional

from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Deadline
from mesh_navigation.base.outcomes import NotReady
from mesh_navigation.plugins.plugin_list import Prepared

REPLACED = "the map is loaded anew"
POLL = 0.05  # s between two looks for what sensors see


class Ready(NamedTuple):
    """A map, and the plugins that work on it."""

    map: MeshMap
    planners: Prepared
    controllers: Prepared
    behaviors: Prepared


class MapGate:
    """Loads a map in a thread; open once it is there, or shut with the reason why it is not."""

    def __init__(self, load: Callable[[], Ready], wait: bool = True) -> None:
        """
        Args:
            load: loads the map and makes all ready for it; any exception is the reason why not.
            wait: whether goals wait for the map.
        """
        self._load = load
        self._wait = wait
        self._changed = threading.Condition()
        self._loading = True  # Goals may come before the start.
        self._running = False
        self._again = False
        self._ready: Optional[Ready] = None
        self._fault = ""
        self._replaced = Cancellation()
        self._begin = time.monotonic()

    def reload(self) -> None:
        """Load, first or once more, in a thread; meanwhile goals wait, and what works on the map
        before ends.

        While a map is being loaded, what comes of that does not count: it is loaded once more.
        """
        with self._changed:
            replaced, self._replaced = self._replaced, Cancellation()
            self._ready = None
            self._begin = time.monotonic()
            begin, self._again = not self._running, self._running
            self._loading = self._running = True
        replaced.cancel(REPLACED)
        if begin:
            threading.Thread(target=self._run, name="map", daemon=True).start()

    def _run(self) -> None:
        again = True
        while again:
            ready, fault = None, ""
            try:
                ready = self._load()
            except (Exception, SystemExit) as error:  # Goals must hear of it and not wait on.
                fault = str(error) or type(error).__name__
            with self._changed:
                again, self._again = self._again, False
                if not again:
                    self._ready, self._fault = ready, fault
                    self._loading = self._running = False
                    self._changed.notify_all()

    def _notify(self) -> None:
        with self._changed:
            self._changed.notify_all()

    def wait(self, cancellation: Cancellation, patient: bool = False, whole: bool = True) -> Ready:
        """The map and its plugins, as soon as they are there, whether it has what sensors see or
        not.

        Args:
            cancellation: ends the waiting.
            patient: wait, even if goals shall not.
            whole: refuse a map of which a required layer does not stand otherwise.

        Raises:
            NotReady: there is none. CANCELED, NOT_INITIALIZED (it is not there yet, and nobody
                shall wait), or MAP_ERROR (it could not be loaded, or is not whole).
        """
        with cancellation.calling(self._notify), self._changed:
            if self._wait or patient:
                self._changed.wait_for(lambda: not self._loading or cancellation.canceled)
                if cancellation.canceled:
                    raise NotReady(
                        "CANCELED", f"stopped while waiting for the map: {cancellation.reason}"
                    )
            ready = self._present("; goals wait for it if the parameter wait_for_map is true")
        if whole and ready.map.lasting_fault:
            raise NotReady("MAP_ERROR", ready.map.lasting_fault)
        return ready

    def wait_for_data(self, cancellation: Cancellation, patience: float, name: str) -> Ready:
        """As `wait`, and until the map has what sensors see.

        Args:
            cancellation: ends the waiting.
            patience: with a gap in that (s, of the computer's time); 0: no limit.
            name: of the parameter that says so.

        Raises:
            NotReady: as `wait`; MAP_ERROR also for a gap that takes too long.
        """
        deadline = Deadline(patience or None)
        while True:
            ready = self.wait(cancellation)
            gap = ready.map.gap
            if not gap:
                return ready
            if deadline.left == 0.0:
                raise NotReady("MAP_ERROR", f"{gap}; waited for {patience:.1f} s ({name})")
            if cancellation.wait(POLL):
                raise NotReady("CANCELED", f"stopped while waiting: {gap}; {cancellation.reason}")

    def now(self, whole: bool = True) -> Ready:
        """The map and its plugins of this moment, for who never waits.

        Args:
            whole: as for `wait`.

        Raises:
            NotReady: there is none, it is being replaced, or it is not whole.
        """
        with self._changed:
            ready = self._present("")
        if whole and ready.map.fault:
            raise NotReady("MAP_ERROR", ready.map.fault)
        return ready

    def _present(self, remark: str) -> Ready:
        if self._loading:
            seconds = time.monotonic() - self._begin
            raise NotReady(
                "NOT_INITIALIZED",
                f"the map is still being loaded, for {seconds:.0f} s now{remark}",
            )
        if self._ready is None:
            raise NotReady("MAP_ERROR", f"there is no map: {self._fault}")
        return self._ready

    def fault(self, ready: Ready) -> str:
        """Why nobody may drive on that map any longer: it is replaced, or a required layer does not
        stand; or empty, also where there is a gap in what sensors see."""
        if not self.is_current(ready):
            return "the map was replaced while the robot drove on it"
        return ready.map.lasting_fault

    def is_current(self, ready: Ready) -> bool:
        """Whether that is the map of now; False from the moment a reload begins."""
        return self._ready is ready

    def replaced(self, ready: Ready) -> Cancellation:
        """Is canceled as soon as that is no longer the map of now."""
        with self._changed:
            if self._ready is ready:
                return self._replaced
        gone = Cancellation()
        gone.cancel(REPLACED)
        return gone

"""The map arrives while goals may already be there: they wait for it, or are told why not."""

import threading
import time
from typing import Callable, Optional

from mesh_map.mesh_map import MeshMap

from mesh_navigation.cancellation import Cancellation
from mesh_navigation.outcomes import GetPathOutcome
from mesh_navigation.planner import PlanFailure, stop_if_canceled


class MapGate:
    """Loads a map in a thread; open once it is there, or shut with the reason why it is not."""

    def __init__(self, load: Callable[[], MeshMap], wait: bool = True) -> None:
        """
        Args:
            load: loads the map and makes all ready for it; any exception is the reason why not.
            wait: whether goals wait for the map.
        """
        self._load = load
        self._wait = wait
        self._changed = threading.Condition()
        self._ended = False
        self._map: Optional[MeshMap] = None
        self._fault = ""
        self._begin = time.monotonic()

    def start(self) -> None:
        """Begin to load."""
        threading.Thread(target=self._run, name="map", daemon=True).start()

    def _run(self) -> None:
        mesh_map, fault = None, ""
        try:
            mesh_map = self._load()
        except Exception as error:  # Whatever it is, goals must hear of it instead of waiting on.
            fault = str(error) or type(error).__name__
        with self._changed:
            self._map, self._fault, self._ended = mesh_map, fault, True
            self._changed.notify_all()

    def _notify(self) -> None:
        with self._changed:
            self._changed.notify_all()

    def wait_for_map(self, cancellation: Cancellation) -> MeshMap:
        """The map, as soon as it is there.

        Raises:
            PlanFailure: MAP_ERROR if it could not be loaded, NOT_INITIALIZED if it is not there yet
                and goals shall not wait, CANCELED if the goal was canceled meanwhile.
        """
        with cancellation.calling(self._notify), self._changed:
            if self._wait:
                self._changed.wait_for(lambda: self._ended or cancellation.canceled)
                stop_if_canceled(cancellation)
            if not self._ended:
                seconds = time.monotonic() - self._begin
                raise PlanFailure(
                    GetPathOutcome.NOT_INITIALIZED,
                    f"the map is still being loaded, for {seconds:.0f} s now; "
                    "goals wait for it if the parameter wait_for_map is true",
                )
            if self._map is None:
                raise PlanFailure(GetPathOutcome.MAP_ERROR, f"there is no map: {self._fault}")
            return self._map

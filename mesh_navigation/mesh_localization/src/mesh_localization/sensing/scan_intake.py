"""Messages of sensors on their way to the thread that uses them."""

import threading
import time
from collections import Counter
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Tuple, Union

from mesh_map.base.errors import MeshMapError, error_line

from mesh_localization.sensing.placed_scan import PlacedScan
from mesh_localization.sensing.sensor_scan import SensorScan


class NotYet(MeshMapError):
    """A scan cannot be placed now, but perhaps later: transforms may come after it."""


class Unusable(NamedTuple):
    """Why a scan is not used, and its message."""

    reason: str
    message: Any


Result = Union[PlacedScan, Unusable]


class ScanIntake:
    """Keeps the newest message of each sensor. One that waits for its transforms is not replaced by
    newer ones: where transforms are slower than scans, none would ever be used.

    `put` is for any thread, all else for the one that uses scans.

    Attributes:
        patience: s of the computer's time that a scan waits for its transforms.
        dropped: sensor -> messages that a newer one replaced.
    """

    def __init__(
        self,
        decode: Callable[[str, Any], SensorScan],
        place: Callable[[SensorScan], PlacedScan],
        patience: float,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        """
        Args:
            decode: sensor, message -> scan; what it raises: unusable.
            place: NotYet: it is asked again; whatever else it raises: unusable.
            patience: see there.
            now: the computer's time (s).
        """
        self.patience = patience
        self.dropped: "Counter[str]" = Counter()
        self._decode, self._place, self._now = decode, place, now
        self._newest: Dict[str, Any] = {}
        self._waiting: Dict[str, Tuple[SensorScan, Any, float]] = {}
        self._condition = threading.Condition()

    def put(self, sensor: str, message: Any) -> None:
        """Leave a message."""
        with self._condition:
            if sensor in self._newest:
                self.dropped[sensor] += 1
            self._newest[sensor] = message
            self._condition.notify()

    def wait(self, seconds: float) -> None:
        """Until there is a message, or so long."""
        with self._condition:
            if not self._newest:
                self._condition.wait(seconds)

    def clear(self) -> None:
        """Forget all that waits."""
        with self._condition:
            self._newest.clear()
        self._waiting.clear()

    def next(self) -> List[Tuple[str, Result]]:
        """What can be said of scans now: (sensor, result) by their stamps; at most one of each
        sensor."""
        found = self._decoded()
        order = sorted(self._waiting, key=lambda name: self._waiting[name][0].stamp.to_sec())
        for sensor in order:
            result = self._placed(*self._waiting[sensor])
            if result is not None:
                del self._waiting[sensor]
                found.append((sensor, result))
        return found

    def _decoded(self) -> List[Tuple[str, Result]]:
        """Decode what waits for nothing else; those that cannot be."""
        with self._condition:
            free = [name for name in self._newest if name not in self._waiting]
            messages = [(name, self._newest.pop(name)) for name in free]
        refused: List[Tuple[str, Result]] = []
        for sensor, message in messages:
            try:
                self._waiting[sensor] = self._decode(sensor, message), message, self._now()
            except Exception as error:  # of whatever is published there; the node goes on
                refused.append((sensor, Unusable(error_line(error), message)))
        return refused

    def _placed(self, scan: SensorScan, message: Any, since: float) -> Optional[Result]:
        try:
            return self._place(scan)
        except NotYet as error:
            late = self._now() - since > self.patience
            return Unusable(str(error), message) if late else None
        except Exception as error:  # as above
            return Unusable(error_line(error), message)

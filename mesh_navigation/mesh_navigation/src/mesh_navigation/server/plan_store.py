"""The fields of the last plans, found again by their paths."""

import hashlib
import threading
from collections import OrderedDict
from typing import Optional

import numpy as np

from mesh_navigation.plugins.planner import PlanField


class PlanStore:
    """Remembers which field a path was made from.

    A client gets a path from the action get_path and passes it on to exe_path, in a message that
    has no place for a field. Numbers of messages are the same bits on both ways, so the path itself
    is the key. From any thread.
    """

    def __init__(self, size: int = 8) -> None:
        """
        Args:
            size: how many plans are remembered, those that were used last; each keeps its field.
        """
        self._size = size
        self._lock = threading.Lock()
        self._fields: "OrderedDict[bytes, PlanField]" = OrderedDict()

    def put(self, poses: np.ndarray, field: Optional[PlanField]) -> None:
        """Remember the field of (N,7) poses; None forgets one of the same poses."""
        key = _key(poses)
        with self._lock:
            self._fields.pop(key, None)
            if field is not None:
                self._fields[key] = field
            while len(self._fields) > self._size:
                self._fields.popitem(last=False)

    def find(self, poses: np.ndarray) -> Optional[PlanField]:
        """The field of exactly these (N,7) poses, None if it is not known."""
        key = _key(poses)
        with self._lock:
            if key in self._fields:
                self._fields.move_to_end(key)
            return self._fields.get(key)

    def clear(self) -> None:
        """Forget all: there is another map."""
        with self._lock:
            self._fields.clear()


def _key(poses: np.ndarray) -> bytes:
    return hashlib.blake2b(np.ascontiguousarray(poses, np.float64), digest_size=16).digest()

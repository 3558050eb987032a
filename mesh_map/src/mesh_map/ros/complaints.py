"""Warnings that would be said too often."""

import logging
import math
import threading
import time
from typing import Any, Dict

from mesh_msgs.text import one_line


_LOG = logging.getLogger("mesh_map")
_PERIOD = 10.0  # seconds


class ThrottledWarnings:
    """One warning of a kind at most in ten seconds, with how often it would have been said."""

    def __init__(self, layer: str) -> None:
        self._layer = layer
        self._lock = threading.Lock()
        self._counts: Dict[str, int] = {}
        self._said: Dict[str, float] = {}

    def add(self, kind: str, reason: Any) -> None:
        """Says it, or counts it; for any thread. kind: what cannot be done; reason: this time."""
        now = time.monotonic()
        with self._lock:
            self._counts[kind] = count = self._counts.get(kind, 0) + 1
            if now - self._said.get(kind, -math.inf) < _PERIOD:
                return
            self._said[kind], self._counts[kind] = now, 0
        _LOG.warning("layer %s: %s (%d): %s", self._layer, kind, count, one_line(reason))

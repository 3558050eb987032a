"""The transforms of a running ROS, for all parts of a process that need them."""

import threading
from typing import ClassVar, Optional

import tf2_ros


class SharedTransforms:
    """One listener to /tf for all adapters of a process."""

    _shared: ClassVar[Optional["SharedTransforms"]] = None
    _users: ClassVar[int] = 0
    _lock: ClassVar[threading.Lock] = threading.Lock()

    def __init__(self) -> None:
        self.buffer = tf2_ros.Buffer(debug=False)
        self._listener = tf2_ros.TransformListener(self.buffer)

    @classmethod
    def acquired(cls) -> "SharedTransforms":
        with cls._lock:
            if cls._shared is None:
                cls._shared = cls()
            cls._users += 1
            return cls._shared

    def release(self) -> None:
        with self._lock:
            cls = type(self)
            cls._users -= 1
            if not cls._users:
                self._listener.unregister()
                cls._shared = None

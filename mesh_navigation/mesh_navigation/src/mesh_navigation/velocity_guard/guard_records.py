"""What the server tells the guard, in packets of a socket: settings, then records of drives."""

import json
import struct
from typing import Any, Dict, NamedTuple

from mesh_navigation.base.robot import STOP, Velocity

READY = b"ready"
"""From the guard: it has taken over the topic."""
BEAT = b"."
"""From the guard, every `BEAT_PERIOD`: it is alive."""
BEAT_PERIOD = 0.1  # s
BEAT_PATIENCE = 0.3  # s without a beat, after which a guard counts as stuck
LARGEST = 65536  # bytes of one packet

_FORMAT = struct.Struct("<q6d?")


class DriveRecord(NamedTuple):
    """A command of a drive, or its end."""

    drive: int
    """Its number; newer ones have greater numbers."""
    velocity: Velocity = STOP
    period: float = 0.0
    """In which commands come (s)."""
    due: float = 0.0
    """When the next one comes, by the time of ROS (s)."""
    sent: float = 0.0
    """When this one was sent, by the computer's time: `time.monotonic` (s)."""
    ends: bool = False

    def age(self, time: float, wall: float) -> float:
        """How old the command is by both clocks (s, >= 0): simulated time may wait for it, and
        that of a server that lags behind in it says nothing.

        Args:
            time: of ROS, now (s).
            wall: `time.monotonic`, now (s).
        """
        return max(0.0, min(time - (self.due - self.period), wall - self.sent))

    def packed(self) -> bytes:
        """As one packet."""
        return _FORMAT.pack(self.drive, *self.velocity, *self[2:])

    @classmethod
    def unpacked(cls, packet: bytes) -> "DriveRecord":
        """From one packet. Raises struct.error."""
        drive, x, y, yaw, *others = _FORMAT.unpack(packet)
        return cls(drive, Velocity(x, y, yaw), *others)


def packed_settings(settings: Dict[str, Any]) -> bytes:
    """The first packet."""
    return json.dumps(settings).encode()


def unpacked_settings(packet: bytes) -> Dict[str, Any]:
    """What it says."""
    return dict(json.loads(packet))

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
LARGEST = 65536  # bytes of one packet

_FORMAT = struct.Struct("<q5d?")


class DriveRecord(NamedTuple):
    """A command of a drive, or its end."""

    drive: int
    """Its number; newer ones have greater numbers."""
    velocity: Velocity = STOP
    period: float = 0.0
    """In which commands come (s)."""
    due: float = 0.0
    """When the next one comes, by the time of ROS (s)."""
    ends: bool = False

    def packed(self) -> bytes:
        """As one packet."""
        return _FORMAT.pack(self.drive, *self.velocity, self.period, self.due, self.ends)

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

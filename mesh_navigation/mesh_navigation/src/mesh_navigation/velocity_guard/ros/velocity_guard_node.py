"""The process of the guard: owns the topic of velocities, and obeys the server that started it."""

import os
import socket
import sys
import threading
import time
from typing import Any, Dict, Optional

import rosgraph
import rospy
from geometry_msgs.msg import Twist

from mesh_msgs.diagnostics_ros import OK, WARN, Diagnostics, Status
from mesh_msgs.init_node import init_node, until_shutdown

from mesh_navigation.base.clock_limit_ros import ClockLimit
from mesh_navigation.base.messages import twist_message
from mesh_navigation.base.robot import Velocity
from mesh_navigation.velocity_guard.guard_records import (
    BEAT,
    BEAT_PERIOD,
    LARGEST,
    READY,
    DriveRecord,
    unpacked_settings,
)
from mesh_navigation.velocity_guard.velocity_bounds import VelocityLimits
from mesh_navigation.velocity_guard.velocity_guard import Moment, VelocityGuard

TICK = 0.02  # s, between two looks at a drive
# s, for subscribers to connect before it takes over: what is sent earlier, they do not get.
CONNECTING = 1.0


class VelocityGuardNode:
    """Publishes what `VelocityGuard` says, until the server's end."""

    def __init__(self, server: socket.socket, settings: Dict[str, Any]) -> None:
        """
        Args:
            server: packets from there (see `guard_records`).
            settings: what the first one said.
        """
        self._server = server
        self._server_pid = settings["server_pid"]
        self._simulated = rospy.rostime.is_wallclock() is False
        limits = VelocityLimits(*(settings[name] for name in VelocityLimits._fields))
        self._guard = VelocityGuard(limits, self._now())
        self._publisher = rospy.Publisher(settings["topic"], Twist, queue_size=1)
        self._zone = _cloud_watch(settings) if settings["zone_topic"] else None
        self._complaint, self._beaten = "", 0.0
        self._diagnostics = Diagnostics("velocity", self._status)

    def run(self) -> None:
        """Take over and do so until the server has ended, or this node is shut down."""
        self._wait_for_subscribers()
        self._clock_limit = ClockLimit()
        self._tell(READY)
        while not (rospy.is_shutdown() or self._guard.is_over(self._now())):
            packet = self._packet()
            if self._zone is not None:
                self._guard.obstruction = self._zone.obstruction()
            self._send(self._obey(packet))
            now = self._now()
            self._send(self._guard.tick(now))
            self._complain(self._guard.why_stopped(now))
            if now.wall - self._beaten >= BEAT_PERIOD:
                self._beaten = now.wall
                self._tell(BEAT)

    def _status(self) -> Status:
        """For /diagnostics."""
        if self._complaint:
            return Status(WARN, f"the robot is stopped: {self._complaint}")
        return Status(OK, "velocities of a drive pass" if self._guard.is_driving else "no drive")

    def _wait_for_subscribers(self) -> None:
        end = time.monotonic() + CONNECTING
        try:
            subscribers = dict(rosgraph.Master(rospy.get_name()).getSystemState()[1])
        except (OSError, rosgraph.MasterException):  # it has ended meanwhile: so will this node
            return
        expected = len(subscribers.get(self._publisher.resolved_name, ()))
        while self._publisher.get_num_connections() < expected and time.monotonic() < end:
            time.sleep(TICK)

    def _now(self) -> Moment:
        wall = time.monotonic()
        return Moment(rospy.get_time() if self._simulated else wall, wall)

    def _packet(self) -> Optional[bytes]:
        """The next one; empty at the server's end, None if there is none for a moment."""
        self._server.settimeout(TICK if self._guard.is_driving else BEAT_PERIOD / 2)
        try:
            return self._server.recv(LARGEST)
        except socket.timeout:
            # Who was forked from the server may keep the socket open.
            return None if os.getppid() == self._server_pid else b""
        except OSError:
            return b""

    def _obey(self, packet: Optional[bytes]) -> Optional[Velocity]:
        if packet is None:
            return None
        now = self._now()
        if not packet:
            time.sleep(TICK)  # There is no other packet to wait for.
            self._clock_limit.end_all()
            return self._guard.server_ended(now)
        record = DriveRecord.unpacked(packet)
        if record.ends:
            self._clock_limit.end(record.drive)
            return self._guard.end(record.drive, now)
        self._clock_limit.command(record.drive, record.velocity, record.due)
        age = record.age(rospy.get_time(), now.wall)
        return self._guard.command(record.drive, record.velocity, record.period, now, age)

    def _send(self, velocity: Optional[Velocity]) -> None:
        if velocity is None:
            return
        with until_shutdown():
            self._publisher.publish(twist_message(velocity))

    def _complain(self, complaint: str) -> None:
        if complaint and not self._complaint:
            rospy.logwarn("%s: the robot is stopped: %s", rospy.get_name(), complaint)
        self._complaint = complaint

    def _tell(self, packet: bytes) -> None:
        try:
            self._server.send(packet, socket.MSG_DONTWAIT)
        except OSError:
            pass  # It has ended, or does not listen.


def _cloud_watch(settings: Dict[str, Any]) -> Any:
    # Its libraries are loaded only where there is a zone.
    from mesh_navigation.velocity_guard.ros.cloud_watch_ros import CloudWatch

    return CloudWatch(settings)


def main() -> None:
    """Run the node; the first argument is the descriptor of the socket to the server."""
    server = socket.socket(fileno=int(sys.argv.pop(1)))
    first = server.recv(LARGEST)
    if not first:
        return
    settings = unpacked_settings(first)
    # It ends with the server, also where there is no roscore.
    started = threading.Event()
    early = threading.Thread(target=_end_early, args=(settings["server_pid"], started), daemon=True)
    early.start()
    init_node("velocity_guard")
    started.set()
    with until_shutdown():
        VelocityGuardNode(server, settings).run()
    rospy.signal_shutdown("the server has ended")


def _end_early(server_pid: int, started: threading.Event) -> None:
    """End the process if the server ends before the node is there."""
    while not started.wait(BEAT_PERIOD):
        if os.getppid() != server_pid:
            os._exit(0)

"""Where velocities go: through the guard, or straight to the base."""

import abc
import contextlib
import os
import socket
import subprocess
import sys
import threading
import time
from typing import Any, Dict, Optional, Set

import rosgraph
import rospy
from geometry_msgs.msg import Twist
from mesh_msgs.init_node import until_shutdown

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock_limit_ros import ClockLimit
from mesh_navigation.base.messages import twist_message
from mesh_navigation.base.outcomes import NotReady
from mesh_navigation.base.robot import STOP, Velocity
from mesh_navigation.velocity_guard.guard_records import (
    BEAT_PATIENCE,
    READY,
    DriveRecord,
    packed_settings,
)
from mesh_navigation.velocity_guard.velocity_guard import LAST_ZEROS, ZERO_PERIOD

TOPIC = "cmd_vel"
# s: from the start of a guard until it has taken over, without a beat of one that has until it is
# ended, until a drive is refused for want of one, and from one that could not start to the next.
START_PATIENCE, PATIENCE, DRIVE_PATIENCE, PAUSE = 60.0, 1.0, 30.0, 1.0
# The first place of the search is the current folder, whatever is there.
_PROGRAM = (
    "import sys; del sys.path[0]; "
    "from mesh_navigation.velocity_guard.ros.velocity_guard_node import main; main()"
)


class VelocityCommands(abc.ABC):
    """From any thread; nothing but `wait` waits."""

    @abc.abstractmethod
    def wait(self, cancellation: Cancellation) -> None:
        """Until the robot can be driven.

        Raises:
            NotReady: it cannot, NOT_INITIALIZED; or CANCELED.
        """

    @abc.abstractmethod
    def send(self, drive: int, velocity: Velocity, period: float) -> Velocity:
        """A command; returns what goes out.

        Args:
            drive: number of the drive: newer ones have greater numbers.
            velocity: finite.
            period: in which its commands come (s).
        """

    @abc.abstractmethod
    def end(self, drive: int) -> None:
        """No more commands of that drive come."""


class DirectCommands(VelocityCommands):
    """All of them, as they are, to the base's topic."""

    def __init__(self) -> None:
        self._publisher = rospy.Publisher(TOPIC, Twist, queue_size=1)
        self._clock_limit = ClockLimit()

    def wait(self, cancellation: Cancellation) -> None:
        pass

    def send(self, drive: int, velocity: Velocity, period: float) -> Velocity:
        _publish(self._publisher, velocity)
        self._clock_limit.command(drive, velocity, rospy.get_time() + period)
        return velocity

    def end(self, drive: int) -> None:
        self._clock_limit.end(drive)


class GuardedCommands(VelocityCommands):
    """Through a guard that is started here, and anew whenever it has ended.

    While there is none, or the one there is gives no sign of life, this process sends zeros during
    drives, and never anything else.
    """

    def __init__(self, settings: Dict[str, Any]) -> None:
        """``settings``: robot_frame, and the guard's parameters."""
        own = {"topic": rospy.resolve_name(TOPIC), "server_pid": os.getpid()}
        if settings.get("zone_topic"):  # The guard remaps it: see `_remappings`.
            own["zone_topic"] = rosgraph.names.resolve_name(
                settings["zone_topic"], rospy.get_name()
            )
        self._settings = {**settings, **own}
        self._zeros = rospy.Publisher(TOPIC, Twist, queue_size=1)
        self._changed = threading.Condition()
        self._guard: Optional[socket.socket] = None
        """Of the one that has taken over."""
        self._is_stuck = False
        """Whether that one has not beaten for some time. It gets commands nevertheless: they make
        simulated time go on once it is back, and what is too old then is a stop for it."""
        self._fault = "it is still being started"
        self._drives: Set[int] = set()
        self._last_end = self._zeros_end = 0.0
        threading.Thread(target=self._supervise, name="velocity guard", daemon=True).start()

    def wait(self, cancellation: Cancellation) -> None:
        with cancellation.calling(self._notify), self._changed:
            self._changed.wait_for(lambda: self._guard or cancellation.canceled, DRIVE_PATIENCE)
            if cancellation.canceled:
                raise NotReady(
                    "CANCELED", f"stopped while waiting for velocity_guard: {cancellation.reason}"
                )
            if self._guard is None:
                text = f"the robot cannot be driven, there is no velocity_guard: {self._fault}"
                raise NotReady("NOT_INITIALIZED", text)

    def send(self, drive: int, velocity: Velocity, period: float) -> Velocity:
        with self._changed:
            if velocity != STOP:
                self._drives.add(drive)
            due, sent = rospy.get_time() + period, time.monotonic()
            told = self._tell(DriveRecord(drive, velocity, period, due, sent))
            if told and not self._is_stuck:
                return velocity
            _publish(self._zeros, STOP)
            return STOP

    def end(self, drive: int) -> None:
        with self._changed:
            if drive in self._drives:
                self._drives.remove(drive)
                self._last_end = time.monotonic()
                if not self._obeys():
                    self._zeros_end = self._last_end + LAST_ZEROS
            self._tell(DriveRecord(drive, ends=True))

    def _obeys(self) -> bool:
        """Whether there is a guard that passes commands on, as far as it is known."""
        return self._guard is not None and not self._is_stuck

    def _tell(self, record: DriveRecord) -> bool:
        """Whether the guard gets it."""
        if self._guard is None:
            return False
        try:
            self._guard.send(record.packed())
            return True
        except OSError:  # It has ended, or is stuck: it would miss this, and the next one begins.
            with contextlib.suppress(OSError):
                self._guard.shutdown(socket.SHUT_RDWR)
            self._lose_guard()
            return False

    def _notify(self) -> None:
        with self._changed:
            self._changed.notify_all()

    # In the thread of the supervision

    def _supervise(self) -> None:
        while True:
            end = time.monotonic() + PAUSE
            try:
                fault = self._follow_guard()
            except OSError as error:
                fault = f"it cannot be started: {error}"
            if rospy.core.is_shutdown_requested():
                return
            rospy.logerr("velocity_guard: %s; the robot stands until there is another one", fault)
            self._fault = fault
            while time.monotonic() < end:
                self._stop_robot()
                time.sleep(ZERO_PERIOD)

    def _follow_guard(self) -> str:
        """Start one and look after it until its end; returns how that was."""
        guard, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with guard:
            with its:
                process = _started(its)
            stuck = ""
            try:
                guard.send(packed_settings(self._settings))
                stuck = self._listen(guard)
            except OSError:
                pass  # It has ended.
            self._lose_guard()
            if stuck:
                process.kill()
            end = time.monotonic() + PAUSE
            while process.poll() is None and time.monotonic() < end:
                self._stop_robot()
                time.sleep(ZERO_PERIOD)
            process.kill()
            return stuck or f"it ended with status {process.wait()}"

    def _listen(self, guard: socket.socket) -> str:
        """Until its end; or why it has to be ended."""
        heard, patience = time.monotonic(), START_PATIENCE
        while True:
            guard.settimeout(BEAT_PATIENCE if self._obeys() else ZERO_PERIOD)
            try:
                packet = guard.recv(len(READY))
            except socket.timeout:
                silent, sudden = time.monotonic() - heard, self._obeys()
                if sudden:
                    self._suspend_guard()
                if self._stop_robot() and sudden:
                    rospy.logwarn(
                        "velocity_guard: no sign of life for %.1f s; the robot stands", silent
                    )
                if silent >= patience:
                    return f"it did not answer for {silent:.1f} s"
                continue
            if not packet:
                return ""
            heard = time.monotonic()
            self._is_stuck = False
            if packet == READY:
                patience = PATIENCE
                self._hand_over(guard)

    def _hand_over(self, guard: socket.socket) -> None:
        with self._changed:
            self._guard, self._is_stuck = guard.dup(), False
            self._guard.setblocking(False)
            self._changed.notify_all()

    def _lose_guard(self) -> None:
        with self._changed:
            if self._guard is not None:
                self._guard.close()
                self._guard = None
            self._owe_zeros()

    def _suspend_guard(self) -> None:
        """Until its next sign of life."""
        with self._changed:
            self._is_stuck = True
            self._owe_zeros()

    def _owe_zeros(self) -> None:
        now = time.monotonic()
        # The guard's last zeros may not have been sent.
        if now - self._last_end < LAST_ZEROS:
            self._zeros_end = now + LAST_ZEROS

    def _stop_robot(self) -> bool:
        """Send a zero where one is due; whether it was."""
        with self._changed:
            driven = self._drives or time.monotonic() < self._zeros_end
            if self._obeys() or not driven:
                return False
            _publish(self._zeros, STOP)
            return True


def _started(its: socket.socket) -> subprocess.Popen:
    """The process of the guard, with its end of the socket."""
    namespace, name = rosgraph.names.canonicalize_name(rospy.get_name()).rsplit("/", 1)
    return subprocess.Popen(
        [sys.executable or "/usr/bin/python3", "-c", _PROGRAM]
        + [str(its.fileno()), f"__name:={name}_velocity_guard"]
        + [f"{name}:={other}" for name, other in _remappings().items()],
        stdin=subprocess.DEVNULL,
        pass_fds=[its.fileno()],
        env={**os.environ, "ROS_NAMESPACE": namespace or "/"},
        # Signals for the server and its group are not for the guard, which ends after it.
        start_new_session=True,
    )


def _remappings() -> Dict[str, str]:
    """What holds for the names of the server, as absolute names, and for the guard, too.

    Not its own name, and not its topic, which it is told as it has to be.
    """
    topics = rosgraph.names.resolve_name(TOPIC, rospy.get_name()), rospy.resolve_name(TOPIC)
    others = ("__name", "__ns", "__log", *topics)
    return {
        name: other
        for name, other in rospy.names.get_resolved_mappings().items()
        if name not in others
    }


def _publish(publisher: rospy.Publisher, velocity: Velocity) -> None:
    with until_shutdown():
        publisher.publish(twist_message(velocity))

"""What the server sends itself while its guard is stuck; without a roscore or processes."""

import threading
import time

import pytest
import rospy
from rosgraph.names import load_mappings

from mesh_msgs.testing import wait_until
from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.robot import STOP, Velocity
from mesh_navigation.server.ros import velocity_commands_ros as commands_ros
from mesh_navigation.server.ros.velocity_commands_ros import GuardedCommands
from mesh_navigation.velocity_guard.guard_records import (
    BEAT,
    BEAT_PATIENCE,
    BEAT_PERIOD,
    LARGEST,
    READY,
    DriveRecord,
)

FORWARD, PERIOD = Velocity(1.0), 0.05
NEVER, SOON = 600.0, 0.01  # s
ZERO, KILLED, STARTED = "zero", "guard killed", "guard started"


class Guards:
    """In place of processes: the newest one's end of the socket, and what happened, in order."""

    def __init__(self, patch, patience):
        """``patience``: s until a stuck one is ended."""
        self.events, self.over, self._patch = [], False, patch
        self._ends = []
        patch.setattr(commands_ros, "_started", self._start)
        patch.setattr(rospy, "Publisher", lambda *_, **__: self)
        patch.setattr(rospy, "get_time", time.monotonic)
        patch.setattr(rospy.core, "is_shutdown_requested", lambda: self.over)
        patch.setattr(commands_ros, "PATIENCE", patience)
        self.wait_for_beats(NEVER)
        self.commands = GuardedCommands({})
        wait_until(lambda: STARTED in self.events, "the first guard")
        self.beat(READY)
        self.commands.wait(Cancellation())

    def wait_for_beats(self, seconds):
        """How long the server does so from the next one on, before it sends zeros."""
        self._patch.setattr(commands_ros, "BEAT_PATIENCE", seconds)

    def beat(self, packet=BEAT):
        self._end.send(packet)

    def fall_silent(self):
        self.wait_for_beats(SOON)
        self.beat()

    def heard(self):
        """The next record of a drive that the guard gets."""
        return DriveRecord.unpacked(self._end.recv(LARGEST))

    def publish(self, twist):
        assert (twist.linear.x, twist.linear.y, twist.angular.z) == (0.0, 0.0, 0.0)
        self.events.append(ZERO)

    def zeros(self):
        return self.events.count(ZERO)

    def _start(self, its):
        self._end = its.dup()
        self._ends.append(self._end)
        self._end.settimeout(60)
        self.events.append(STARTED)
        return self

    def poll(self):
        return -9 if self.over else None

    def kill(self):
        self.events.append(KILLED)

    def wait(self):
        return -9

    def close(self):
        self.over = True
        for end in self._ends:
            end.close()
        for thread in threading.enumerate():
            if thread.name == "velocity guard":
                thread.join(60)


@pytest.fixture
def guards(monkeypatch, request):
    guards = Guards(monkeypatch, getattr(request, "param", NEVER))
    assert guards._end.recv(LARGEST).startswith(b"{")  # the settings
    yield guards
    guards.close()


def test_how_long_beats_are_waited_for():
    assert 2 * BEAT_PERIOD <= BEAT_PATIENCE <= 0.3 < commands_ros.PATIENCE


def test_zeros_while_it_is_stuck(guards):
    """They begin before its end, and end with its next sign of life."""
    assert guards.commands.send(1, FORWARD, PERIOD) == FORWARD
    assert guards.heard().velocity == FORWARD
    guards.beat()
    assert guards.zeros() == 0
    guards.fall_silent()
    wait_until(lambda: guards.zeros() > 3, "zeros")
    assert guards.commands.send(1, FORWARD, PERIOD) == STOP
    record = guards.heard()  # nevertheless, with what says how old it is
    assert record.velocity == FORWARD and 0.0 < record.sent <= time.monotonic()
    guards.wait_for_beats(NEVER)
    guards.beat()
    wait_until(lambda: guards.commands.send(1, FORWARD, PERIOD) == FORWARD, "the drive")
    count = guards.zeros()
    time.sleep(0.3)
    assert guards.zeros() == count
    assert KILLED not in guards.events


def test_quiet_while_nothing_drives(guards):
    guards.fall_silent()
    time.sleep(0.3)
    assert guards.zeros() == 0
    guards.commands.send(1, FORWARD, PERIOD)
    wait_until(guards.zeros, "zeros")


def test_a_drive_that_ends_meanwhile(guards):
    """Its last zeros come from here."""
    guards.commands.send(1, FORWARD, PERIOD)
    guards.fall_silent()
    wait_until(guards.zeros, "zeros")
    guards.commands.end(1)
    count = guards.zeros()
    wait_until(lambda: guards.zeros() > count + 5, "the last zeros")

    def quiet():
        count = guards.zeros()
        time.sleep(0.5)
        return guards.zeros() == count

    wait_until(quiet, "silence")


def test_a_drive_that_has_just_ended(guards):
    """Who was to send its last zeros is stuck."""
    guards.commands.send(1, FORWARD, PERIOD)
    guards.commands.end(1)
    guards.commands._last_end = time.monotonic() + NEVER  # however busy the machine is
    guards.fall_silent()
    wait_until(guards.zeros, "zeros")


@pytest.mark.parametrize("guards", [0.3], indirect=True)
def test_it_is_replaced(guards):
    guards.commands.send(1, FORWARD, PERIOD)
    guards.fall_silent()
    wait_until(lambda: guards.events.count(STARTED) > 1, "the next one")
    events = guards.events[: guards.events.index(KILLED)]
    assert events[0] == STARTED and ZERO in events
    assert guards.commands.send(1, FORWARD, PERIOD) == STOP
    guards.wait_for_beats(NEVER)
    guards.beat(READY)
    guards.commands.wait(Cancellation())
    assert guards.commands.send(1, FORWARD, PERIOD) == FORWARD


def test_what_is_remapped_for_the_server(monkeypatch):
    """Holds for the guard, by absolute names, as its own ones are others."""
    words = "__name:=server __ns:=/robot __log:=/tmp/log __ip:=127.0.0.1 _speed:=1.0 tf:=robot/tf"
    words += " /tf_static:=links ~zone:=points cmd_vel:=base /robot/base:=/elsewhere clock:=/time"
    monkeypatch.setattr(rospy.names, "_mappings", load_mappings(words.split()))
    monkeypatch.setattr(rospy.names, "_resolved_mappings", {})
    monkeypatch.setattr(rospy, "get_name", lambda: "/robot/server")
    monkeypatch.setattr(rospy.names, "get_name", rospy.get_name)
    rospy.names.initialize_mappings(rospy.get_name())
    assert rospy.resolve_name("cmd_vel") == "/robot/base"
    assert commands_ros._remappings() == {
        "__ip": "127.0.0.1",
        "/robot/tf": "/robot/robot/tf",
        "/tf_static": "/robot/links",
        "/robot/server/zone": "/robot/points",
        "/robot/clock": "/time",
    }

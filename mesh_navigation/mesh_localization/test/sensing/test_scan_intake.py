"""Scans that wait for their transforms, and those that come too fast."""

import pytest
from genpy import Time
from mesh_map.base.errors import MeshMapError

from mesh_localization.sensing.scan_intake import NotYet, ScanIntake, Unusable
from mesh_localization.sensing.sensor_scan import SensorScan

ODD, STRANGE = "odd", "strange"


class World:
    """Transforms that are known up to a time, and a clock."""

    def __init__(self):
        self.known, self.time = 0.0, 0.0
        self.intake = ScanIntake(self.decode, self.place, 0.3, lambda: self.time)

    def decode(self, sensor, message):
        if message == ODD:
            raise MeshMapError("it is odd")
        if message == STRANGE:
            raise ValueError("never thought of")
        return SensorScan(sensor, Time.from_sec(message), None, None)

    def place(self, scan):
        if scan.stamp.to_sec() > self.known:
            raise NotYet("no transform")
        if scan.frame == "broken":
            raise MeshMapError("it is broken")
        return scan.frame, scan.stamp.to_sec()

    def next(self):
        return [result for _, result in self.intake.next()]


@pytest.fixture
def world():
    return World()


def test_the_newest_message_of_each_sensor_counts(world):
    world.known = 9.0
    for stamp in (1.0, 2.0, 3.0):
        world.intake.put("front", stamp)
    world.intake.put("back", 2.5)
    assert world.next() == [("back", 2.5), ("front", 3.0)]
    assert world.intake.dropped == {"front": 2}
    assert world.next() == []


def test_a_scan_waits_for_its_transforms_and_is_not_replaced_meanwhile(world):
    world.intake.put("front", 1.0)
    assert world.next() == []
    world.intake.put("front", 1.125)
    world.intake.put("front", 1.25)
    world.known = 1.0
    assert world.next() == [("front", 1.0)]
    assert world.next() == []
    world.known = 1.25
    assert world.next() == [("front", 1.25)]


def test_one_that_waits_holds_up_no_other_sensor(world):
    world.known = 2.0
    world.intake.put("front", 5.0)
    world.intake.put("back", 2.0)
    assert world.next() == [("back", 2.0)]


def test_patience_ends(world):
    world.intake.put("front", 1.0)
    assert world.next() == []
    world.time = 0.31
    assert world.next() == [Unusable("no transform", 1.0)]
    assert world.next() == []


def test_what_cannot_be_used_says_why(world):
    world.known = 9.0
    world.intake.put("front", ODD)
    world.intake.put("broken", 1.0)
    assert world.next() == [Unusable("it is odd", ODD), Unusable("it is broken", 1.0)]
    world.intake.put("front", STRANGE)
    assert world.next() == [Unusable("ValueError: never thought of", STRANGE)]


def test_nothing_is_left_after_clear(world):
    world.intake.put("front", 1.0)
    world.next()
    world.intake.put("front", 2.0)
    world.intake.clear()
    world.known = 9.0
    assert world.next() == []

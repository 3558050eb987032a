"""Which velocity reaches the base at which moment."""

import math

import pytest

from mesh_navigation.base.robot import STOP, Velocity
from mesh_navigation.velocity_guard.velocity_bounds import VelocityLimits
from mesh_navigation.velocity_guard.velocity_guard import LAST_ZEROS, Moment, VelocityGuard

LIMITS = VelocityLimits(5.0, 5.0, 1e9, 1e9)
PERIOD = 0.05
FORWARD, LEFT = Velocity(0.5), Velocity(yaw=0.5)


class World:
    """A guard, both clocks, and what it has sent."""

    def __init__(self, limits=LIMITS):
        self.time, self.wall, self.sent = 1000.0, 0.0, []
        self.guard = VelocityGuard(limits, self.now)

    @property
    def now(self):
        return Moment(self.time, self.wall)

    def command(self, drive, velocity=FORWARD, period=PERIOD, age=0.0):
        self._note(self.guard.command(drive, velocity, period, self.now, age))

    def end(self, drive):
        self._note(self.guard.end(drive, self.now))

    def server_ended(self):
        self._note(self.guard.server_ended(self.now))

    def wait(self, seconds, speed=1.0):
        """Time passes; that of ROS by so much for each second."""
        for _ in range(round(seconds / 0.01)):
            self.wall += 0.01
            self.time += 0.01 * speed
            self._note(self.guard.tick(self.now))

    def _note(self, velocity):
        if velocity is not None:
            self.sent.append(velocity)

    def taken(self):
        sent, self.sent = self.sent, []
        return sent


@pytest.fixture
def world():
    return World()


def drive(world, seconds=0.5, number=1, velocity=FORWARD, speed=1.0):
    for _ in range(round(seconds / PERIOD)):
        world.command(number, velocity)
        world.wait(PERIOD / speed, speed)


def test_a_drive_passes_as_it_is(world):
    drive(world)
    assert world.taken() == [FORWARD] * 10


def test_quiet_before_and_after(world):
    world.wait(5.0)
    assert world.taken() == []
    drive(world)
    world.taken()
    world.command(1, STOP)
    world.end(1)
    world.wait(LAST_ZEROS)
    sent = world.taken()
    assert set(sent) == {STOP} and 15 < len(sent) < 25
    world.wait(5.0)
    assert world.taken() == []


def test_a_new_drive_ends_the_zeros_of_the_last(world):
    drive(world)
    world.end(1)
    world.wait(0.2)
    world.taken()
    drive(world, number=2)
    assert world.taken() == [FORWARD] * 10


def test_who_never_moves_the_robot_is_no_drive(world):
    """Its one zero passes, as long as nobody drives."""
    world.command(1, STOP)
    world.end(1)
    world.wait(5.0)
    assert world.taken() == [STOP]
    drive(world, number=2)
    world.command(3, STOP)
    world.end(3)
    assert set(world.taken()) == {FORWARD}


@pytest.mark.parametrize("period, patience", [(0.01, 0.2), (0.05, 0.2), (0.1, 0.3), (1.0, 3.0)])
@pytest.mark.parametrize("speed", [0.5, 1.0, 5.0])
def test_silence(world, period, patience, speed):
    """Of ROS time, as long as that goes on."""
    world.command(1, period=period)
    world.wait((patience - 0.001) / speed, speed)
    assert world.taken() == [FORWARD]
    world.wait(2.0, speed)
    sent = world.taken()
    assert set(sent) == {STOP} and 30 < len(sent) < 45
    assert "no command for" in world.guard.why_stopped(world.now)
    world.command(1)
    assert world.taken() == [FORWARD]
    assert world.guard.why_stopped(world.now) == ""


@pytest.mark.parametrize("period, patience", [(0.05, 0.2), (1.0, 3.0)])
def test_a_guard_that_stood_still(world, period, patience):
    """What it finds then passes as long as it would have held without the next command."""
    for age in (4.0, patience + 0.01):
        world.command(1, period=period, age=age)
        world.wait(0.01)
        assert set(world.taken()) == {STOP}
        assert "no command for" in world.guard.why_stopped(world.now)
    world.command(1, period=period, age=patience - 0.03)
    world.wait(0.02)
    assert world.taken() == [FORWARD]
    world.wait(0.02)
    assert world.taken() == [STOP]


def test_what_stood_still_begins_slowly_again():
    world = World(LIMITS._replace(max_lin_acceleration=1.0))
    drive(world, 2.0)
    assert world.taken()[-1] == FORWARD
    world.command(1, age=4.0)
    world.command(1)
    assert world.taken() == [STOP, Velocity(0.1)]


def test_a_clock_that_has_not_begun(world):
    """The guard took over before it heard of the time."""
    world.time = 0.0
    world.guard = VelocityGuard(LIMITS, world.now)
    world.command(1)
    world.time = 1795477071.0
    world.wait(0.1)
    assert world.guard.why_stopped(world.now) == ""
    world.wait(0.2)
    assert world.guard.why_stopped(world.now).startswith("no command for 0.2")
    assert world.taken()[-1] == STOP


def test_a_clock_that_stands(world):
    """By the computer's time; a clock that was set back stands no longer."""
    drive(world)
    world.taken()
    world.wait(0.1, speed=0.0)
    assert world.taken() == []
    world.wait(0.5, speed=0.0)
    assert set(world.taken()) == {STOP}
    assert "/clock stands" in world.guard.why_stopped(world.now)
    world.time = 3.0
    world.wait(0.05)
    world.command(1)
    world.wait(0.1)
    assert world.taken()[-1] == FORWARD


def test_commands_while_the_clock_stands(world):
    """Who commands is not silent."""
    for _ in range(20):
        world.command(1)
        world.wait(0.1, speed=0.0)
    assert set(world.taken()) == {FORWARD}


def test_the_newest_drive_has_the_robot(world):
    drive(world, number=1)
    world.taken()
    for _ in range(10):
        world.command(2, LEFT)
        world.command(1, FORWARD)
        world.wait(PERIOD)
    assert world.taken() == [LEFT] * 10
    world.command(2, STOP)
    world.end(2)
    drive(world, number=1)
    assert world.taken() == [STOP] + [FORWARD] * 10
    world.end(1)
    assert world.taken() == [STOP]


def test_the_newest_drive_when_it_is_silent(world):
    """Nobody takes its place while it lasts."""
    drive(world, number=2)
    world.taken()
    for _ in range(40):
        world.command(1, LEFT)
        world.wait(PERIOD)
    assert set(world.taken()) == {STOP}


def test_an_older_drive_that_ends(world):
    drive(world, number=1)
    drive(world, number=2, velocity=LEFT)
    world.taken()
    world.command(1, STOP)
    world.end(1)
    drive(world, number=2, velocity=LEFT)
    assert set(world.taken()) == {LEFT}


def test_the_servers_end(world):
    drive(world)
    world.taken()
    world.server_ended()
    assert not world.guard.is_over(world.now)
    for _ in range(11):
        world.wait(0.1)
        world.server_ended()  # heard again and again
    assert set(world.taken()) == {STOP}
    assert world.guard.is_over(world.now)


def test_the_servers_end_while_nothing_drives(world):
    world.server_ended()
    world.wait(0.5)
    assert set(world.taken()) == {STOP}


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_what_is_not_finite(world, number):
    drive(world)
    world.taken()
    world.command(1, Velocity(number))
    assert world.taken() == [STOP]
    world.end(1)
    world.wait(2.0)
    world.taken()
    world.command(2, Velocity(number))
    world.wait(5.0)
    assert world.taken() == [STOP]


def test_an_obstruction(world):
    world.guard.obstruction = "somebody stands there"
    world.wait(5.0)
    assert world.taken() == []
    drive(world)
    assert set(world.taken()) == {STOP}
    assert world.guard.why_stopped(world.now) == "somebody stands there"
    world.guard.obstruction = ""
    drive(world)
    assert set(world.taken()) == {FORWARD}
    world.guard.obstruction = "again"  # with no command in between
    world.wait(0.01)
    assert world.taken() == [STOP]

"""The time of ROS, without a master: of the computer, and as a simulation sets it."""

import threading
import time

import pytest
import rospy
from rospy.rostime import _set_rostime, set_rostime_initialized, switch_to_wallclock

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock_ros import RosClock

# What rospy calls on every tick is deprecated.
pytestmark = pytest.mark.filterwarnings("ignore:notifyAll")


@pytest.fixture
def simulated():
    """Lets the test say what time it is."""
    set_rostime_initialized(True)

    def say(seconds):
        _set_rostime(rospy.Time.from_sec(seconds))

    say(0.0)
    yield say
    switch_to_wallclock()


@pytest.fixture
def real():
    set_rostime_initialized(True)
    switch_to_wallclock()


def waiting(clock, moment, cancellation):
    """A thread that waits; its join says whether it has ended."""
    thread = threading.Thread(
        target=clock.wait_until, args=(moment, cancellation), daemon=True, name="waiting"
    )
    thread.start()
    time.sleep(0.05)
    assert thread.is_alive()
    return thread


def ends(thread):
    thread.join(30)
    return not thread.is_alive()


def test_waits_for_the_time_of_a_simulation(simulated):
    clock = RosClock()
    assert clock.now() == 0.0
    thread = waiting(clock, 5.0, Cancellation())
    for second in (1.0, 3.0, 4.99):
        simulated(second)
        time.sleep(0.02)
        assert thread.is_alive() and clock.now() == second
    simulated(7.0)
    assert ends(thread)
    clock.wait_until(6.0, Cancellation())


def test_time_that_jumps_back(simulated):
    simulated(100.0)
    thread = waiting(RosClock(), 105.0, Cancellation())
    simulated(2.0)
    assert ends(thread)


@pytest.mark.parametrize("now", [0.0, 50.0])
def test_cancel_while_no_time_passes(simulated, now):
    simulated(now)
    cancellation = Cancellation()
    thread = waiting(RosClock(), 105.0, cancellation)
    cancellation.cancel()
    assert ends(thread)
    RosClock().wait_until(1e9, cancellation)


def test_the_computers_time(real):
    clock, begin = RosClock(), time.time()
    assert abs(clock.now() - begin) < 30.0
    clock.wait_until(clock.now() + 0.2, Cancellation())
    assert time.time() - begin >= 0.2
    clock.wait_until(clock.now() - 5.0, Cancellation())
    cancellation = Cancellation()
    thread = waiting(clock, clock.now() + 1e6, cancellation)
    cancellation.cancel()
    assert ends(thread)

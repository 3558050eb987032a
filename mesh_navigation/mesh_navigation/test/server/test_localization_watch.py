"""What localizers say, and when it counts."""

import pytest

from mesh_navigation.server.localization_watch import LocalizationWatch

LOST, UNCERTAIN, OK = 0, 1, 2


class Heard:
    """A watch, and the time (s)."""

    def __init__(self, timeout=1.0):
        self.watch, self.now = LocalizationWatch("/state", timeout), 100.0

    def say(self, state, reason="", by="/localizer", ahead=0.0):
        self.watch.hear(by, state, reason, self.now + ahead, self.now)

    def at(self, moment):
        self.now = moment
        return self.watch.look(moment)


def test_nobody_has_ever_spoken():
    heard = Heard()
    for moment in (0.0, 100.0, 101.5, 3.0):
        found = heard.at(moment)
        assert "nothing has come on /state yet" in found.lost and "localization_topic" in found.lost
        assert (found.doubt, found.has_spoken, found.times) == ("", False, 0)


def test_a_localizer_that_knows():
    heard = Heard()
    heard.say(OK)
    for moment in (100.0, 100.7, 101.0):
        assert heard.at(moment) == ("", "", True, 1)


def test_a_localizer_that_falls_silent():
    heard = Heard(timeout=2.0)
    heard.say(OK)
    assert not heard.at(102.0).lost
    lost = heard.at(102.5).lost
    for words in ("/localizer", "silent on /state for 2.50 s", "2.00 s (localization_timeout)"):
        assert words in lost
    heard.say(OK)
    assert heard.at(102.5) == ("", "", True, 2)


def test_a_localizer_that_is_lost():
    heard = Heard()
    heard.say(OK)
    heard.say(LOST, "12 % of the rays\nare explained")
    found = heard.at(100.1)
    assert found.lost == (
        "the robot is not localized, says /localizer: 12 % of the rays are explained"
    )
    assert found.has_spoken and found.times == 1
    heard.say(LOST)
    assert heard.at(100.2).lost.endswith(": no reason is given")


def test_a_localizer_that_is_uncertain_drives_on():
    heard = Heard()
    heard.say(UNCERTAIN, "a corridor")
    found = heard.at(100.5)
    assert (found.lost, found.times) == ("", 1)
    assert found.doubt == "the localization is uncertain, says /localizer: a corridor"


@pytest.mark.parametrize("state", [3, 7, 255])
def test_a_state_that_is_none_is_lost(state):
    heard = Heard()
    heard.say(OK)
    heard.say(state)
    assert f"/localizer gives the state {state}, which is none" in heard.at(100.0).lost


def test_a_state_of_the_future_is_lost_until_then():
    heard = Heard()
    heard.say(OK, ahead=5.0)
    assert "/localizer says is stamped 5.00 s ahead of time" in heard.at(100.0).lost
    heard.say(OK, ahead=0.9)  # clocks of two computers, or of a simulation
    assert not heard.at(100.0).lost
    heard.say(OK, ahead=-50.0)  # a scan of long ago, of a robot that has not moved since
    assert not heard.at(100.0).lost


@pytest.mark.parametrize("order", [(LOST, OK), (OK, LOST)])
def test_of_two_the_worst_counts(order):
    heard = Heard()
    for name, state in zip(("/a", "/b"), order):
        heard.say(state, "why" if state == LOST else "", name)
    found = heard.at(100.0)
    assert (
        found.lost == f"the robot is not localized, says {'/ab'[0]}{'ab'[order.index(LOST)]}: why"
    )
    assert "several nodes say on /state" in found.doubt and "/a, /b" in found.doubt


def test_of_two_the_one_that_speaks_counts():
    heard = Heard()
    heard.say(LOST, "why", "/a")
    heard.say(OK, by="/b")
    assert heard.at(100.9).lost
    heard.say(OK, by="/b")
    found = heard.at(101.5)  # /a is silent
    assert (found.lost, found.doubt, found.times) == ("", "", 1)
    assert "/b has been silent" in heard.at(110.0).lost


def test_localizers_of_before_are_forgotten():
    heard = Heard()
    for number in range(1000):
        heard.now += 0.5
        heard.say(OK, by=f"/anonymous_{number}")
    assert len(heard.watch._words) <= 4


@pytest.mark.parametrize("silent", [0.4, 3.0])
def test_time_that_jumps_back_changes_nothing(silent):
    heard = Heard()
    heard.say(OK, ahead=-1000.0)
    before = heard.at(100.0 + silent)
    after = heard.at(50.0)
    assert bool(before.lost) == bool(after.lost) == (silent > 1.0)
    assert bool(heard.at(50.7).lost)
    heard.say(OK, ahead=-1000.0)
    assert not heard.at(51.0).lost


def test_a_state_of_before_time_jumped_back_is_of_the_future():
    heard = Heard()
    heard.say(OK)
    assert "ahead of time" in heard.at(20.0).lost


def test_how_often_it_was_localized():
    heard = Heard()
    states = [LOST, OK, UNCERTAIN, LOST, LOST, UNCERTAIN, LOST, OK]
    times = [0, 1, 1, 1, 1, 2, 2, 3]
    for state, expected in zip(states, times):
        heard.say(state)
        assert heard.at(heard.now).times == expected
    heard.at(105.0)
    heard.say(OK)
    assert heard.at(105.0).times == 4

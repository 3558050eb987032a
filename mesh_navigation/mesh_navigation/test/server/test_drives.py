"""What becomes of drives when another one begins."""

import pytest

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import NotReady
from mesh_navigation.server.drives import Drives


def test_the_newest():
    drives, first, second = Drives("newest"), Cancellation(), Cancellation()
    with drives.running(0, first), drives.running(1, second):
        assert not first.canceled and not second.canceled


def test_refuse():
    drives = Drives("refuse")
    for _ in range(2):  # a drive that has ended is none
        with drives.running(3, Cancellation()) as _, pytest.raises(NotReady) as refusal:
            with drives.running(1, Cancellation()):
                raise AssertionError("it began")
        assert refusal.value.kind == "FAILURE"
        assert "slot 3" in refusal.value.message and "concurrent_drives" in refusal.value.message


def test_preempt():
    drives, first, second = Drives("preempt"), Cancellation(), Cancellation()
    with drives.running(0, first), drives.running(7, second):
        assert "slot 7" in first.reason and "concurrent_drives" in first.reason
        assert not second.canceled


def test_a_drive_that_fails_is_over():
    drives = Drives("refuse")
    with pytest.raises(ZeroDivisionError), drives.running(0, Cancellation()):
        raise ZeroDivisionError
    with drives.running(1, Cancellation()):
        pass

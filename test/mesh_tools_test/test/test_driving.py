"""Random trips in the open: the robot arrives, rightly headed, never on lethal ground."""

import pytest
from mesh_tools_test.driving import worlds
from mesh_tools_test.driving.checks import COUNT, check_drives


def test_outdoors():
    found = check_drives(worlds.outdoor(20_000))
    assert len(found.verdicts) == COUNT == 20


def test_on_the_tray():
    path = worlds.tray_file()
    if path is None:
        pytest.skip("tray.ply is not there (environment variable MESH_TOOLS_DATA)")
    check_drives(worlds.tray(path))

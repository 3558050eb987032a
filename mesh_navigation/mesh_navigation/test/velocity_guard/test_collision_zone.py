"""The box in which nothing may be."""

import math

import numpy as np
import pytest

from mesh_navigation.velocity_guard.collision_zone import CollisionZone

BOX = (0.0, 1.0, -0.5, 0.5, 0.1, 2.0)
NONE = np.zeros((0, 3))
INSIDE = [0.5, 0.0, 1.0]


def zone_with(points, stamp=100.0, box=BOX):
    zone = CollisionZone(box, 3, 0.5)
    zone.see(np.array(points).reshape(-1, 3), stamp)
    return zone


def test_points():
    assert zone_with(NONE).obstruction(100.0) == ""
    assert zone_with([INSIDE] * 2).obstruction(100.0) == ""
    assert "3 points" in zone_with([INSIDE] * 3).obstruction(100.0)
    outside = [[x, y, z] for x in (-0.1, 1.1) for y in (-0.6, 0.6) for z in (0.0, 2.1)]
    assert zone_with(outside + [[0.5, 0.0, 0.05]] * 5).obstruction(100.0) == ""
    assert zone_with([[math.nan, 0.0, 1.0], [0.5, math.inf, 1.0]] * 9).obstruction(100.0) == ""
    borders = [[x, y, z] for x in (0.0, 1.0) for y in (-0.5, 0.5) for z in (0.1, 2.0)]
    assert "8 points" in zone_with(borders).obstruction(100.0)


@pytest.mark.parametrize("now, fine", [(100.5, True), (100.6, False), (99.5, True), (99.4, False)])
def test_a_cloud_of_another_time(now, fine):
    found = zone_with(NONE).obstruction(now)
    assert (found == "") is fine and ("zone_timeout" in found) is not fine


def test_before_the_first_cloud():
    assert "none has come yet" in CollisionZone(BOX, 3, 0.5).obstruction(100.0)


def test_a_cloud_that_cannot_be_used():
    zone = zone_with(NONE)
    zone.miss("no transform")
    assert "no transform" in zone.obstruction(100.0)
    zone.see(NONE, 100.0)
    assert zone.obstruction(100.0) == ""


@pytest.mark.parametrize(
    "box", [(), BOX[:5], (1.0, 0.0, *BOX[2:]), (math.nan, *BOX[1:]), ("a", *BOX[1:])]
)
def test_a_box_that_is_none_closes_the_way(box):
    assert "zone_box has to be" in zone_with(NONE, box=box).obstruction(100.0)

"""What a view of a cloud clears."""

import math

import numpy as np
import pytest
from mesh_map.layers.cloud_view import CloudView
from obstacle_oracles import seen_past, view_cell, view_of

DEGREE = math.radians(1.0)


@pytest.mark.parametrize("degrees", [0.5, 1.0, 7.0, 100.0, 400.0])
def test_views_equal_brute_force(degrees):
    random, angle = np.random.default_rng(5), math.radians(degrees)
    size = 3 * angle
    directions = np.array([[1, 0, 0], [-1, 1e-9, 0], [0, 0, 1], [0, -1e-9, -1], [1, 2, -3]])
    past = total = 0
    for direction in directions:
        near = direction + random.uniform(-size, size, (40, 3))
        offsets = near * random.uniform(0.5, 4.0, (40, 1))
        offsets[0] = 0
        ground = random.random(40) < 0.5
        asked = (direction + random.uniform(-size, size, (40, 3))) * random.uniform(0.5, 3, (40, 1))
        asked[0] = 0
        answers = CloudView(offsets, ground, angle).sees_past(asked, 0.3)
        view = view_of(offsets, ground, angle)
        expected = [seen_past(tuple(a), view, angle, 0.3) for a in asked]
        assert answers.tolist() == expected
        past, total = past + sum(expected), total + len(expected)
    assert degrees > 10 or 0 < past < total


def test_cells_are_about_as_wide_as_high():
    for degrees in (-79.6, -45.3, 0.4, 30.3, 60.7):
        height, turns = math.radians(degrees), np.arange(0, 2 * math.pi, 1e-3)
        ring = np.cos(height) * np.array([np.cos(turns), np.sin(turns)])
        cells = {view_cell((x, y, math.sin(height)), DEGREE) for x, y in ring.T}
        assert 0.9 * DEGREE < 2 * math.pi * math.cos(height) / len(cells) < 1.01 * DEGREE


def wall(distance, y_from=-1.0, y_to=1.0, step=0.01):
    """A dense picture of a wall across the x axis, as offsets from the sensor."""
    y, z = np.meshgrid(np.arange(y_from, y_to, step), np.arange(-0.3, 0.3, step))
    return np.column_stack([np.full(y.size, distance), y.ravel(), z.ravel()])


def test_what_stood_before_a_wall_is_gone_when_the_wall_is_seen():
    mark = np.array([[2.0, 0.1, 0.05]])
    seen = wall(4.0)
    hiding = np.zeros(len(seen), bool)
    view = CloudView(seen, hiding, DEGREE)
    assert view.sees_past(mark, 0.2).all()
    assert not view.sees_past(mark * 1.95, 0.2).any()  # at the wall, within the margin
    assert not view.sees_past(mark * 3, 0.2).any()  # behind it
    assert not view.sees_past(-mark, 0.2).any()  # where nothing was measured
    assert not view.sees_past(np.zeros((1, 3)), 0.2).any()


def test_what_is_hidden_stays_and_what_is_hit_stays():
    seen = np.concatenate([wall(6.0), wall(1.5, 0.0, 0.06)])
    view = CloudView(seen, np.zeros(len(seen), bool), DEGREE)
    asked = np.array([[3.0, y, 0.0] for y in (-0.4, 0.06, 0.4)])
    assert view.sees_past(asked, 0.2).tolist() == [True, False, True]
    still_there = np.concatenate([wall(6.0), np.array([[3.0, 0.4, 0.0]])])
    view = CloudView(still_there, np.zeros(len(still_there), bool), DEGREE)
    assert view.sees_past(asked, 0.2).tolist() == [True, True, False]


def test_ground_in_front_hides_nothing():
    """A low obstacle on flat ground, seen at a grazing angle: in its cell, the ground begins
    before it; without knowing that this is ground, it would never be cleared."""
    x, y = np.meshgrid(np.arange(2.0, 6.0, 0.005), np.arange(-0.1, 0.1, 0.01))
    seen = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, -0.5)])
    mark = np.array([[3.0, 0.0, -0.48]])
    for ground, expected in ((True, True), (False, False)):
        view = CloudView(seen, np.full(len(seen), ground), 3 * DEGREE)
        assert view.sees_past(mark, 0.05).tolist() == [expected]


def test_a_view_of_nothing_clears_nothing():
    view = CloudView(np.zeros((0, 3)), np.zeros(0, bool), DEGREE)
    assert view.sees_past(np.ones((2, 3)), 0.1).tolist() == [False, False]
    assert view.sees_past(np.zeros((0, 3)), 0.1).shape == (0,)

"""What the page of one's own robot says of its pictures is to be seen in them."""
import math

import numpy as np
import pytest
from mesh_navigation.velocity_guard.velocity_bounds import VelocityLimits

from mesh_tools_test.tutorials import panels
from mesh_tools_test.tutorials.guard_pictures import passed
from mesh_tools_test.tutorials.layer_pictures import EDGE, computed
from mesh_tools_test.tutorials.parameter_worlds import (
    SLOPES,
    STEPS,
    THINGS,
    coarse_steps,
    layer,
    room,
    steps_and_slopes,
    track,
)

UNBOUNDED = VelocityLimits(5.0, 5.0, 100.0, 100.0)


def closed_features(kind, **params):
    """Which of STEPS and SLOPES have something lethal on them."""
    corners, names = steps_and_slopes()
    ground = track(corners, EDGE)
    _, lethal = computed(ground.mesh_map, layer("one", kind, **params))
    x, on_ground = ground.profile[:, 0], lethal[ground.middle]
    found = [on_ground[np.abs(x - place) < 0.1].any() for place, _, _ in names]
    return [each for each, is_closed in zip((*STEPS, *SLOPES), found) if is_closed]


@pytest.mark.parametrize(
    "threshold, radius, closed",
    [
        (0.15, 0.2, [0.2, 0.3, 30, 40]),
        (0.25, 0.2, [0.3, 40]),
        (0.35, 0.2, []),
        (0.25, 0.1, []),
        (0.25, 0.4, [0.3, 20, 30, 40]),
    ],
)
def test_height_differences_close_what_the_rule_says(threshold, radius, closed):
    assert closed_features("HeightDiff", threshold=threshold, radius=radius) == closed
    for slope in SLOPES:  # of the rule, but for an edge at both ends
        rises = 2 * radius * math.sin(math.radians(slope))
        if abs(rises - threshold) > 2 * EDGE * math.sin(math.radians(slope)):
            assert (slope in closed) == (rises > threshold)


@pytest.mark.parametrize("threshold, slopes", [(0.3, [20, 30, 40]), (0.5, [30, 40]), (0.75, [])])
def test_steepness_closes_slopes_above_its_threshold(threshold, slopes):
    found = closed_features("Steepness", threshold=threshold)
    assert [each for each in found if each in SLOPES] == slopes


def test_steps_between_far_vertices_are_not_lethal():
    closed = []
    for max_edge_length in (0.0, 0.2, 0.1):
        ground = coarse_steps(max_edge_length)
        height_diff = layer("height_diff", "HeightDiff", threshold=0.25, radius=0.2)
        lethal = computed(ground.mesh_map, height_diff)[1]
        closed.append(bool(lethal[ground.middle].any()))
        assert closed[-1] == lethal.any()
    assert closed == [False, True, True]


@pytest.mark.parametrize(
    "step_height, robot_height, closed",
    [
        (0.1, 1.2, [0, 1, 2, 3, 4]),
        (0.25, 1.2, [1, 2, 3, 4]),
        (0.5, 1.2, [2, 3, 4]),
        (0.25, 0.5, [1, 2]),
        (0.25, 1.0, [1, 2, 3]),
    ],
)
def test_the_body_meets_what_is_between_its_heights(step_height, robot_height, closed):
    ground = track([(0.0, 0.0), (12.0, 0.0)], EDGE, THINGS)
    collision = layer("one", "Collision", step_height=step_height, robot_height=robot_height)
    _, lethal = computed(ground.mesh_map, collision)
    x, on_ground = ground.profile[:, 0], lethal[ground.middle]
    inside = [on_ground[(x > each.begin) & (x < each.end)].all() for each in THINGS]
    assert [number for number, is_closed in enumerate(inside) if is_closed] == closed
    assert not on_ground[x < THINGS[0].begin - EDGE].any()


@pytest.mark.parametrize("frequency, patience", [(20.0, 0.2), (10.0, 0.3), (5.0, 0.6)])
def test_the_guard_stops_what_is_silent(frequency, patience):
    times, _, sent_times, sent = passed(UNBOUNDED, frequency, [(0.0, 0.6), (1.0, math.nan)], 2.4)
    stop = sent_times[np.flatnonzero(sent > 0)[-1] + 1]
    assert sent[-1] == 0.0
    assert patience - 1e-6 < stop - times[-1] < patience + 0.1


def test_the_guard_slows_down_and_never_delays_a_stop():
    limits = VelocityLimits(0.8, 5.0, 1.0, 50.0)
    _, _, times, speeds = passed(limits, 20.0, [(0.0, 1.2), (1.5, 0.0)], 2.0)
    assert speeds.max() == pytest.approx(0.8)
    assert speeds[np.searchsorted(times, 0.5)] < 0.7
    assert (speeds[times >= 1.5] == 0.0).all()


def test_cells_of_all_vertices_are_the_whole_floor():
    hall = room((3.0, 2.0), [], 0.5)
    vertices, faces = hall.mesh_map.vertices, hall.mesh_map.faces
    everything = panels._cells(vertices, faces, np.ones(len(vertices), bool))
    x, y = np.moveaxis(everything, 2, 0)
    areas = np.abs((x * np.roll(y, -1, 1) - np.roll(x, -1, 1) * y).sum(axis=1)) / 2
    assert areas.sum() == pytest.approx(6.0)
    corner = np.flatnonzero((vertices[:, :2] == 0.0).all(axis=1))
    one = panels._cells(vertices, faces, np.isin(np.arange(len(vertices)), corner))
    assert one.max() == pytest.approx(0.5 * 2 / 3)  # the middle of a face


def test_lethal_vertices_take_the_costs_around_them():
    faces = np.array([[0, 1, 2], [1, 3, 2]])
    costs = np.array([0.2, 0.4, np.inf, 0.6])
    shown = panels._without_lethal(faces, costs, ~np.isfinite(costs))
    assert shown == pytest.approx([0.2, 0.4, (0.2 + 0.4 + 0.4 + 0.6) / 4, 0.6])

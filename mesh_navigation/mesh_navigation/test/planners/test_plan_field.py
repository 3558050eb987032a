"""The field that a plan carries: what led to the path, and what nobody changes any more."""

import numpy as np
import pytest

from mesh_msgs import zoo
from navigation_test_maps import ALL_PLANNERS, MapWithCosts, planner_on

from mesh_map.distance.surface_path import FieldTracer
from mesh_navigation.base.pose import Pose
from mesh_navigation.planners.dijkstra import DijkstraMeshPlanner

pytestmark = pytest.mark.parametrize("cls", ALL_PLANNERS, ids=lambda cls: cls.__name__)

MESH = zoo.jittered_plane(cells=30, size=30.0)
START, GOAL = Pose.at([3.2, 4.1, 0]), Pose.at([25.3, 22.4, 0])


def plan_on(mesh_map, cls):
    planner = planner_on(mesh_map, cls)
    result = planner.make_plan(START, GOAL)
    assert result.succeeded, result.message
    return planner, result


def down(mesh_map, result, start):
    """The way down the field of a plan."""
    point = mesh_map.closest_face(start.position, 0.1)
    return FieldTracer.of(mesh_map.geometry).path(result.plan_field, point)


def test_it_leads_to_the_goal_as_long_as_the_plan_says(cls):
    mesh_map = MapWithCosts(MESH)
    _, result = plan_on(mesh_map, cls)
    path = down(mesh_map, result, START)
    np.testing.assert_allclose(path.points[[0, -1]], [START.position, GOAL.position], atol=1e-9)
    # Across the faces the way down Dijkstra's labels is shorter than along edges.
    if cls is DijkstraMeshPlanner:
        assert np.linalg.norm(GOAL.position - START.position) <= path.length <= result.cost + 1e-6
    else:
        assert path.length == pytest.approx(result.cost, rel=1e-3)


def test_around_what_is_lethal(cls):
    costs = np.zeros(len(MESH.vertices), np.float32)
    costs[np.linalg.norm(MESH.vertices[:, :2] - [14, 13], axis=1) < 5] = np.inf
    mesh_map = MapWithCosts(MESH, costs)
    _, result = plan_on(mesh_map, cls)
    path = down(mesh_map, result, START)
    lethal = np.isinf(costs)[MESH.faces[path.faces]]
    inside = [
        face
        for face, corners, begin, end in zip(path.faces, lethal, path.points, path.points[1:])
        if corners.all() and np.linalg.norm(end - begin) > 1e-9
    ]
    assert inside == []


def test_nothing_changes_it(cls):
    mesh_map = MapWithCosts(MESH)
    planner, result = plan_on(mesh_map, cls)
    field = result.plan_field
    before = field.labels.copy()
    assert not field.labels.flags.writeable
    mesh_map.costs = mesh_map.costs + np.float32(0.5)
    mesh_map.costs[:40] = np.inf
    planner.make_plan(START, GOAL)
    planner.make_plan(Pose.at([29, 1, 0]), GOAL)
    np.testing.assert_array_equal(field.labels, before)
    assert field.goal_face == result.plan_field.goal_face


def test_a_plan_that_fails_has_none(cls):
    mesh_map = MapWithCosts(MESH)
    result = planner_on(mesh_map, cls).make_plan(START, Pose.at([100, 0, 0]))
    assert not result.succeeded and result.plan_field is None

"""Parts of the mesh controller by themselves: steering, arcs ahead, places on a path."""

import math

import numpy as np
import pytest

from mesh_map.geometry.surface import barycentric_coordinates
from mesh_msgs import zoo

from mesh_navigation.base.pose import Pose
from mesh_navigation.controllers.carrot import Carrot
from mesh_navigation.controllers.guide import Guide
from mesh_navigation.controllers.sight import Sight
from mesh_navigation.controllers.local_costs import ESCAPE, LocalCosts
from mesh_navigation.controllers.surface_pose import Locator
from mesh_navigation.controllers.steering import Ahead, steer
from mesh_navigation.controllers.vector3 import inside
from mesh_navigation.plugins.controller import ControllerPlan
from controller_drives import controller_on
from navigation_test_maps import MapWithCosts

GRID = MapWithCosts(zoo.grid(cells=50))
FAR = Ahead(math.inf, math.inf)


def surface_pose_at(place, yaw=0.0, mesh_map=GRID):
    return Locator(mesh_map.geometry).stand(Pose.at(place, yaw), None, 0.4, 0.4)


def snapshot_of(mesh_map=GRID, goal=(9.0, 9.0, 0.0)):
    face = mesh_map.closest_face(np.array(goal), 1.0).face
    return LocalCosts(mesh_map.geometry, mesh_map.costs, face, np.array(goal))


def sight(surface_pose, mesh_map=GRID):
    return Sight(mesh_map.geometry, snapshot_of(mesh_map), surface_pose)


def guide(points, costs, distance, clearance):
    poses = np.pad(points, ((0, 0), (0, 4)))
    return Guide(GRID.geometry, ControllerPlan(poses), costs, distance, clearance)


@pytest.mark.parametrize("angle", [0.02, -0.1, 0.3])
@pytest.mark.parametrize("factor", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("distance", [0.1, 0.6])
def test_turns_are_never_slower_than_the_arc_to_the_carrot(angle, factor, distance):
    values = controller_on(GRID, ang_vel_factor=factor).values
    velocity = steer(Carrot(distance, angle, False), FAR, values, 0.05)
    needed = 2 * velocity.x * math.sin(angle) / distance
    assert velocity.x > 0.0 and velocity.yaw * angle > 0.0
    assert abs(needed) - 1e-9 <= abs(velocity.yaw) <= values["max_ang_velocity"]


def test_speeds_fade_towards_the_goal_and_before_what_is_blocked():
    values = controller_on(GRID).values
    straight = Carrot(0.6, 0.0, False)
    speeds = [steer(straight, Ahead(d, math.inf), values, 0.05).x for d in (0.05, 0.25, 0.5, 9.0)]
    assert speeds == pytest.approx([0.1, 0.5, 0.97, 1.0], abs=0.03)
    stops = [steer(straight, Ahead(math.inf, d), values, 0.05).x for d in (0.0, 0.01, 9.0)]
    assert stops == pytest.approx([0.0, 0.0, 1.0], abs=0.2) and stops[0] == 0.0 < stops[1]


def test_arcs_end_at_the_border_and_at_blocked_ground():
    at_border = surface_pose_at([9.5, 5.0, 0.0])
    assert sight(at_border).free_arc(0.0, 0.4) is None
    assert sight(at_border).free_arc(0.0, 0.8) == pytest.approx(0.5)
    # A circle of radius 0.4 m to the left stays on the map, one of 1 m does not.
    assert sight(at_border).free_arc(1 / 0.4, 0.8) is None
    assert sight(at_border).free_arc(1.0, 1.2) == pytest.approx(np.pi / 6, abs=0.06)
    mesh = zoo.grid(cells=50)
    wall = MapWithCosts(mesh, np.where(np.abs(mesh.vertices[:, 0] - 6.0) < 0.15, np.inf, 0.0))
    here = surface_pose_at([5.0, 5.1, 0.0], mesh_map=wall)
    found = sight(here, wall).free_arc(0.0, 2.0)
    assert found == pytest.approx(0.9, abs=0.07)


def test_blocked_ground_may_be_left_where_that_is_near():
    mesh = zoo.grid(cells=50)
    spot = MapWithCosts(mesh, np.where(np.hypot(*(mesh.vertices[:, :2] - 5.0).T) < 0.1, np.inf, 0))
    within = surface_pose_at([5.05, 5.0, 0.0], mesh_map=spot)
    assert sight(within, spot).free_arc(0.0, 1.0) is None
    wide = MapWithCosts(mesh, np.where(np.hypot(*(mesh.vertices[:, :2] - 5.0).T) < 1.0, np.inf, 0))
    within = surface_pose_at([5.0, 5.0, 0.0], mesh_map=wide)
    assert sight(within, wide).free_arc(0.0, 1.0) == 0.0
    assert ESCAPE < 1.0


def test_where_a_path_crosses_itself_the_robot_stays_on_its_part():
    corners = np.array([[2, 5, 0], [8, 5, 0], [8, 8, 0], [5, 8, 0], [5, 2, 0.0]])
    parts = [np.linspace(a, b, 21)[:-1] for a, b in zip(corners, corners[1:])]
    points = np.concatenate(parts + [corners[-1:]])
    path = guide(points, GRID.costs, 0.4, 0.0)
    travelled = [
        path.nearest(np.array([x, 5.0, 0.0]), 1.0).travelled for x in np.arange(2.0, 8.0, 0.25)
    ]
    assert travelled == pytest.approx(np.arange(0.0, 6.0, 0.25), abs=1e-6)
    for place in ([8, 6.5, 0], [8, 8, 0], [6.5, 8, 0], [5, 8, 0], [5, 6.5, 0], [5, 5.2, 0]):
        found = path.nearest(np.array(place, float), 1.0)
    assert found.travelled == pytest.approx(6 + 3 + 3 + 2.8)
    assert path.nearest(np.array([5.05, 5.0, 0.0]), 1.0).travelled == pytest.approx(15.0, abs=0.01)
    # Put elsewhere by someone, it is on the part that is there.
    assert path.nearest(np.array([2.5, 5.0, 0.0]), 1.0).travelled == pytest.approx(0.5)


def test_corners_of_paths_are_rounded_but_not_onto_blocked_ground():
    points = np.concatenate(
        [np.linspace([2, 5, 0], [5, 5, 0], 16), np.linspace([5, 5.2, 0], [5, 8, 0], 15)]
    )
    corner = np.array([5.0, 5.0, 0.0])
    rounded = guide(points, GRID.costs, 0.4, 0.1)
    assert 0.05 < rounded.nearest(corner, 1.0).distance <= 0.1
    outside = np.array([5.07, 4.93, 0.0])
    assert rounded.nearest(outside, 1.0).distance < 0.05
    beside = np.hypot(*(GRID.vertices[:, :2] - [5.2, 4.8]).T) < 0.25
    on_path = (np.abs(GRID.vertices[:, :2] - 5.0) < 0.01).any(axis=1)
    costs = np.float32(np.where(beside & ~on_path, np.inf, 0.0))
    assert np.isinf(costs).any()
    kept = guide(points, costs, 0.4, 0.3)
    assert kept.nearest(corner, 1.0).distance == pytest.approx(0.0, abs=1e-6)


def test_weights_at_one_point_are_moved_into_the_face():
    rng = np.random.default_rng(0)
    for corners in rng.normal(size=(50, 3, 3)):
        weights = rng.dirichlet((1.0, 1.0, 1.0))
        assert inside(corners, weights @ corners) == pytest.approx(weights, abs=1e-9)
        point = rng.normal(size=3)  # of its plane, the nearest to this counts
        expected = barycentric_coordinates(point, *corners).clip(0.0, 1.0)
        assert inside(corners, point) == pytest.approx(expected / expected.sum(), abs=1e-9)
    assert np.isnan(inside(np.outer([0.0, 1.0, 3.0], [1.0, 2.0, 0.5]), np.zeros(3))).all()

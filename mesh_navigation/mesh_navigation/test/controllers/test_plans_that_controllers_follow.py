"""Where planners lead a body past lethal ground, the controller drives."""

import numpy as np
import pytest

from mesh_msgs import zoo
from mesh_msgs.world.solids import joined
from mesh_msgs.world.zoo_mesh import grid_faces

from mesh_navigation.base.pose import Pose
from mesh_navigation.body.body import Body
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.controllers.mesh_controller import MeshController
from mesh_navigation.execution.planning import make_planner
from mesh_navigation.simulation.driving import drive
from navigation_test_maps import MapWithCosts

RADIUS = 0.25
SHIPPED = {"max_ang_velocity": 0.8}  # where it differs from the defaults


class Arrays:
    """What MapWithCosts takes."""

    def __init__(self, vertices, faces):
        self.vertices, self.faces = vertices.astype(np.float32), faces.astype(np.uint32)


def driven(mesh_map, start, goal, values={}, **body):
    """A drive of a round robot, with the map's own plan."""
    has = Body(mesh_map.geometry, RobotShape(radius=RADIUS))
    controller = MeshController()
    controller.body = has
    assert controller.initialize("controller", mesh_map, SHIPPED) == []
    planner = make_planner(mesh_map, body=has)
    ends = {"start": start, "goal": goal, "max_time": 200.0}
    return drive(mesh_map, planner, controller, values=values, **ends, **body)


def sheet_map():
    """A floor, and 0.12 m above it a sheet of another part whose rim is lethal, as sides of a
    pallet are too steep; the floor below it is free."""
    floor, sheet = zoo.grid(cells=40, size=6.0), zoo.grid(cells=4, size=0.8)
    above = sheet.vertices + np.array([2.5, 2.1, 0.12])
    mesh = Arrays(*joined((floor.vertices, floor.faces), (above, sheet.faces)))
    costs = np.zeros(len(mesh.vertices))
    inner = (np.abs(sheet.vertices[:, :2] - 0.4) < 0.3).all(axis=1)
    costs[len(floor.vertices) :] = np.where(inner, 0.0, np.inf)
    return MapWithCosts(mesh, costs)


def test_past_a_low_thing_of_another_part():
    went = driven(sheet_map(), Pose.at([1.0, 3.05, 0.0]), Pose.at([5.0, 3.05, 0.0]))
    assert went.arrived, went.result.message
    assert np.abs(went.track[:, 1] - 3.05).max() < 0.1  # not around


def test_to_a_goal_beside_a_low_thing_of_another_part():
    went = driven(sheet_map(), Pose.at([1.0, 3.0, 0.0]), Pose.at([2.9, 3.0, 0.0]))
    assert went.arrived, went.result.message


def behind_a_ridge():
    """A lane of 2 cm between what is lethal, 0.28 m from it on its left, and 0.28 m on its right:
    over a ridge 0.1 m high. Straight through the ridge that is 0.2 m."""
    x = np.array([-2.0, -1.5, -1.0, -0.5, 0.0, 0.1, 0.2, 0.28, 0.3, 0.4, 0.5, 1.0, 1.5, 2.0])
    y = np.linspace(0.0, 6.0, 61)
    across, along = np.meshgrid(x, y, indexing="ij")
    height = np.where(np.isclose(across, 0.4), 0.1, 0.0)
    vertices = np.stack([across.ravel(), along.ravel(), height.ravel()], axis=1)
    faces = grid_faces(np.arange(across.size).reshape(across.shape))
    costs = np.where((across <= 0.0) | (across >= 0.5), np.inf, 0.0)
    costs[(along < 2.0) | (along > 4.0)] = 0.0
    return MapWithCosts(Arrays(vertices, faces), costs.ravel())


def test_along_the_surface_it_is_far_enough():
    went = driven(behind_a_ridge(), Pose.at([0.1, 1.0, 0.0], 1.57), Pose.at([0.1, 5.0, 0.0], 1.57))
    assert went.plan.succeeded, went.plan.message
    assert went.arrived, went.result.message
    inside = (went.track[:, 1] > 2.1) & (went.track[:, 1] < 3.9)
    assert went.track[inside, 0].min() > 0.26 and went.track[inside, 0].max() < 0.32


def standing_map():
    """A floor, and on it the lethal bottom of a low thing, which comes first in the mesh, so that
    it is found where somebody looks for the nearest face."""
    bottom, floor = zoo.grid(cells=4, size=1.0), zoo.grid(cells=40, size=6.0)
    below = bottom.vertices + np.array([2.5, 2.5, 0.0])
    mesh = Arrays(*joined((below, bottom.faces[:, ::-1]), (floor.vertices, floor.faces)))
    costs = np.zeros(len(mesh.vertices))
    costs[: len(below)] = np.inf
    return MapWithCosts(mesh, costs)


@pytest.mark.parametrize(
    "start, goal",
    [((1.0, 3.0), (5.0, 3.03)), ((3.0, 3.0), (5.0, 3.0)), ((1.0, 3.0), (3.03, 3.02))],
    ids=["across", "from there", "to there"],
)
def test_over_the_bottom_of_a_thing_that_is_driven_over(start, goal):
    """Of two surfaces at one place the one that is open counts, for plans also while it drives."""
    mesh_map = standing_map()
    bottom = mesh_map.closest_face((3.0, 3.0, 0.0), max_distance=0.1)
    assert bottom.face < 32
    went = driven(
        mesh_map,
        Pose.at([*start, 0.0]),
        Pose.at([*goal, 0.0]),
        values={"planner_frequency": 2.0},
    )
    assert went.arrived, went.result.message
    assert np.abs(went.track[:, 1] - 3.0).max() < 0.1 and (went.faces >= 32).all()

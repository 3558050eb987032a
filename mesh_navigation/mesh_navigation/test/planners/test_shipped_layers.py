"""The shipped layers and planners, in a building that nobody has prepared for a robot."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from mesh_map.costs.settings import SETTINGS
from mesh_map.geometry.refinement import refine
from mesh_map.io.map_parameters import map_parameters
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs.world.solids import box, floor, joined, turned

from mesh_navigation.base.pose import Pose
from mesh_navigation.body.body import Body
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.execution.planning import make_planner

CONFIG = Path(__file__).parents[2] / "config"
PLANNERS = yaml.safe_load((CONFIG / "planners.yaml").read_text(encoding="utf-8"))
RADIUS = PLANNERS["robot_radius"]
EDGE = 0.15  # m, of the floor
SIZE = np.array([12.0, 9.0])
HIGH = 2.4
# (x, y) of two corners: walls with doors of 1.3 m, pillars, a shelf, a table too low to go under
THINGS = [
    ((5.9, 0.0), (6.1, 3.0), HIGH),
    ((5.9, 4.3), (6.1, 9.0), HIGH),
    ((6.1, 4.9), (8.5, 5.1), HIGH),
    ((9.8, 4.9), (12.0, 5.1), HIGH),
    ((2.0, 2.0), (2.4, 2.4), HIGH),
    ((3.5, 6.0), (3.9, 6.4), HIGH),
    ((0.5, 4.0), (2.5, 4.4), 1.8),
    ((8.5, 1.5), (10.0, 2.7), 0.7),
]


@pytest.fixture(scope="module", params=["mesh_map.yaml", "simulation_map.yaml"])
def building(request):
    """The map of the building, with the layers of a file; no sensor says anything."""
    things = [box((*low, 0.0), (*high, top)) for low, high, top in THINGS]
    return with_layers(MeshMap(*joined(floor((0.0, 0.0), SIZE, EDGE), *things)), request.param)


def with_layers(mesh_map, file):
    content = yaml.safe_load((CONFIG / file).read_text(encoding="utf-8"))
    mesh_map.set_settings(
        **{one.name: content[one.name] for one in SETTINGS if one.name in content}
    )
    mesh_map.compute_layers(map_parameters({**content, "mesh_file": "/none"}).layers)
    assert not mesh_map.fault
    return mesh_map


def gaps(points):
    """(N,) m from points (N, 2) to the nearest thing, or edge of the floor."""
    found = [points[:, 0], points[:, 1], SIZE[0] - points[:, 0], SIZE[1] - points[:, 1]]
    for low, high, _ in THINGS:
        beyond = np.maximum(np.maximum(np.subtract(low, points), points - high), 0.0)
        found.append(np.linalg.norm(beyond, axis=1))
    return np.min(found, axis=0)


def ends_of(count):
    """(count, 2, 2) pairs of places with room for the robot."""
    random = np.random.default_rng(1)
    places = random.uniform(0.0, SIZE, (20 * count, 2))
    places = places[gaps(places) > RADIUS + 2 * EDGE]
    pairs = places[: 2 * count].reshape(-1, 2, 2)
    assert len(pairs) == count
    return pairs


def test_the_first_planner_avoids_costs():
    assert PLANNERS["planners"][0]["type"] == "wave_front_planner/WaveFrontPlanner"


def test_what_is_not_lethal_is_open(building):
    """But for the robot's radius: cost_limit closes nothing else, not in the ring of inflation."""
    costs = building.costs
    assert (costs[np.isfinite(costs)] <= PLANNERS["wave_front_planner"]["cost_limit"]).all()


@pytest.mark.parametrize("listed", PLANNERS["planners"], ids=lambda one: one["name"])
def test_paths_keep_off_edges_and_walls(building, listed):
    """By the radius everywhere, less what a vertex stands for; those that look at costs by more,
    wherever there is as much room."""
    body = Body(building.geometry, RobotShape(radius=RADIUS))
    parameters = PLANNERS.get(listed["name"], {})
    planner = make_planner(building, listed["type"], parameters, body=body)
    middle = []
    for start, goal in ends_of(40):
        found = planner.make_plan(Pose.at([*start, 0.0]), Pose.at([*goal, 0.0]))
        assert found.succeeded, found.message
        points = found.poses[:, :2]
        shares = np.linspace(0.0, 1.0, 20)[:, None, None]
        apart = gaps((points[:-1] + shares * np.diff(points, axis=0)).reshape(-1, 2))
        assert np.abs(found.poses[:, 2]).max() < 1e-6
        assert apart.min() > RADIUS - 0.6 * EDGE, (start, goal)
        middle.append(np.median(apart))
    if "mmp" not in listed["name"]:
        assert np.quantile(middle, 0.1) > 0.5


def passage(width, angle, shift, longest):
    """Two large faces with a wall across, of this width (m) in it; turned by an angle."""
    corners = [[-4, -4, 0], [4, -4, 0], [4, 4, 0], [-4, 4, 0]]
    ground = np.array(corners, np.float64), np.array([[0, 1, 2], [0, 2, 3]])
    walls = [
        box((-0.1, -8.0, 0.0), (0.1, shift - width / 2, HIGH)),
        box((-0.1, shift + width / 2, 0.0), (0.1, 8.0, HIGH)),
    ]
    vertices, faces = joined(ground, *(turned(wall, angle, 2, (0, 0, 0)) for wall in walls))
    made = refine(vertices, faces, longest)
    return with_layers(MeshMap(made.vertices, made.faces), "mesh_map.yaml")


@pytest.mark.parametrize("longest", [RADIUS, RADIUS / 2])
def test_walls_are_known_to_half_an_edge(longest):
    """Walls that share nothing with the floor, at any angle: how near paths come to them, which
    passages are never taken, and which are always found."""
    random = np.random.default_rng(7)
    never, always = 2 * RADIUS - longest, 2 * RADIUS + 2 * longest
    for width in (never, 2 * RADIUS, always):
        for _ in range(3):
            angle, shift = random.uniform(0.0, np.pi), random.uniform(-0.3, 0.3)
            mesh_map = passage(width, angle, shift, longest)
            body = Body(mesh_map.geometry, RobotShape(radius=RADIUS))
            planner = make_planner(mesh_map, "mmp_planner/MMPPlanner", body=body)
            turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            ends = [[*(turn @ place), 0.0] for place in ((-2.0, 0.5), (2.0, -0.5))]
            found = planner.make_plan(Pose.at(ends[0]), Pose.at(ends[1]))
            assert found.succeeded or width < always, found.message
            assert not (found.succeeded and width == never)
            if found.succeeded:
                points = found.poses[:, :2] @ turn
                shares = np.linspace(0.0, 1.0, 20)[:, None, None]
                points = (points[:-1] + shares * np.diff(points, axis=0)).reshape(-1, 2)
                beside = np.maximum(np.abs(points[:, 0]) - 0.1, 0.0)
                along = np.maximum(width / 2 - np.abs(points[:, 1] - shift), 0.0)
                assert np.hypot(beside, along).min() > RADIUS - longest / 2

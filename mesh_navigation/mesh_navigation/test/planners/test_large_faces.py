"""Plans on a building of few large faces, as it is and refined: what paths cost is no promise."""

import numpy as np
import pytest

from mesh_map.distance.surface_path import FieldTracer
from mesh_map.geometry.refinement import refine
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs.world.building import HEIGHT, building
from navigation_test_maps import MapWithCosts, planner_on

from mesh_navigation.base.path import path_length
from mesh_navigation.base.pose import Pose
from mesh_navigation.planners.dijkstra import DijkstraMeshPlanner
from mesh_navigation.planners.mmp import MMPPlanner
from mesh_navigation.planners.wave_front import CVPMeshPlanner, WaveFrontPlanner
from mesh_navigation.surface.face_points import find_face_point

LARGE, SHORT = "faces here are too large for it (max_edge_length", 0.5


class Arrays:
    """What MapWithCosts takes."""

    def __init__(self, vertices, faces):
        self.vertices, self.faces = vertices, faces


@pytest.fixture(scope="module")
def maps():
    """The building as it is, and refined: vertices and faces of both."""
    vertices, faces = building()
    whole = Arrays(vertices.astype(np.float32), faces.astype(np.uint32))
    made = refine(whole.vertices, whole.faces, SHORT)
    return whole, Arrays(made.vertices, made.faces)


def places(mesh, count, seed):
    """(count, 3) anywhere on the surface, each square meter as likely as the others."""
    rng = np.random.default_rng(seed)
    a, b, c = mesh.vertices[mesh.faces].astype(float).transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    chosen = rng.choice(len(areas), count, p=areas / areas.sum())
    weights = rng.dirichlet((1, 1, 1), count)
    corners = np.stack([a, b, c], 1)[chosen]
    return np.einsum("ij,ijk->ik", weights, corners)


def pairs(mesh, goals, starts, seed=0):
    """Starts to each goal, so that fields are used again."""
    for goal in places(mesh, goals, seed):
        for start in places(mesh, starts, seed + 1 + int(1e6 * goal[0])):
            if np.linalg.norm(goal - start) > 1.0:
                yield start, goal


def plans(planner, mesh, goals, starts):
    for start, goal in pairs(mesh, goals, starts):
        result = planner.make_plan(Pose.at(start), Pose.at(goal))
        assert result.succeeded, result.message
        yield start, result


def promised(mesh_map, start, result):
    """The potential at the start, by the field itself."""
    place = find_face_point(mesh_map, start, "start", 0)
    return FieldTracer.of(mesh_map.geometry).value(result.plan_field, place)


@pytest.mark.parametrize("cls", [WaveFrontPlanner, CVPMeshPlanner, MMPPlanner, DijkstraMeshPlanner])
def test_no_path_costs_less_than_its_length(maps, cls):
    """On large faces a potential may promise what there is no path for."""
    whole, _ = maps
    mesh_map = MapWithCosts(whole)
    planner = planner_on(mesh_map, cls)
    less = 0
    for start, result in plans(planner, whole, 10, 20):
        assert result.cost >= path_length(result.poses[:, :3])
        if cls in (WaveFrontPlanner, CVPMeshPlanner):
            promise = promised(mesh_map, start, result)
            assert (LARGE in result.message) == (result.cost > 1.01 * promise)
            less += result.cost > 1.01 * promise
    assert less > 10 or cls in (MMPPlanner, DijkstraMeshPlanner)


def test_a_path_that_the_potential_does_not_promise_is_pulled_taut(maps):
    """It is not longer than the locally shortest one near it."""
    whole, _ = maps
    mesh_map = MapWithCosts(whole)
    front, exact = planner_on(mesh_map, WaveFrontPlanner), planner_on(mesh_map, MMPPlanner)
    seen = 0
    for start, goal in pairs(whole, 10, 20):
        ends = Pose.at(start), Pose.at(goal)
        result = front.make_plan(*ends)
        if LARGE not in result.message:
            continue
        seen += 1
        shortest = path_length(exact.make_plan(*ends).poses[:, :3])
        length = path_length(result.poses[:, :3])
        # MMPPlanner may take what is pulled taut from the way over edges.
        assert length >= shortest * (1 - 1e-9)
        assert result.cost == pytest.approx(length, rel=1e-9)
    assert seen > 10


def test_with_costs_a_path_costs_what_it_does_along_it(maps):
    """The integral by another implementation, that of MeshMap's queries."""
    whole, _ = maps
    rng = np.random.default_rng(4)
    mesh_map = MapWithCosts(whole, rng.random(len(whole.vertices)).astype(np.float32))
    planner = planner_on(mesh_map, WaveFrontPlanner, cost_factor=2.0, step_width=1.0)
    queries = MeshMap.of(mesh_map.geometry).queries
    said = 0
    for _, result in plans(planner, whole, 8, 15):
        along = queries.path_cost(result.poses[:, :3], costs=mesh_map.costs)
        cost = along.length + 2.0 * along.integral
        assert result.cost >= cost * (1 - 1e-6)
        said += LARGE in result.message
        if LARGE in result.message:
            assert result.cost == pytest.approx(cost, rel=1e-6)
    assert said > 10


def test_refined_potentials_are_those_of_their_paths(maps):
    """Of 1,000 random pairs at most 1 % of paths over 1.01 of their potential, none over 1.03."""
    whole, refined = maps
    mesh_map = MapWithCosts(refined)
    planner = planner_on(mesh_map, WaveFrontPlanner)
    ratios = []
    for start, result in plans(planner, whole, 25, 41):
        length = path_length(result.poses[:, :3])
        ratios.append(length / promised(mesh_map, start, result))
        assert LARGE not in result.message or ratios[-1] > 1.01
    ratios = np.array(ratios)
    assert len(ratios) >= 1000
    assert (ratios > 1.01).mean() <= 0.01
    assert ratios.max() <= 1.03 and ratios.min() > 0.97


def test_between_storeys(maps):
    """Up the ramp: as long on the refined building, and not shorter than over the ramp."""
    start, goal = (2.0, 3.0, 0.0), (34.0, 20.0, HEIGHT)
    lengths = []
    for mesh in maps:
        result = planner_on(MapWithCosts(mesh), MMPPlanner).make_plan(Pose.at(start), Pose.at(goal))
        lengths.append(path_length(result.poses[:, :3]))
    assert lengths[1] == pytest.approx(lengths[0], rel=1e-6)
    assert lengths[0] > np.hypot(12.0, HEIGHT) + 12.0

"""Paths against exact geodesics: the oracle, what is counted, and what planners must never do."""

import numpy as np
import pytest
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import zoo
from mesh_tools_test.driving import worlds
from mesh_tools_test.driving.geodesics import (
    Excess,
    exact_distances,
    excess,
    excess_table,
    open_ground,
)
from mesh_tools_test.driving.worlds import DrivingWorld


def plane():
    mesh = zoo.jittered_plane(cells=20, size=10.0)
    return DrivingWorld("plane", MeshMap(mesh.vertices, mesh.faces))


def test_the_oracle_on_a_plane_is_the_straight_line():
    ground = open_ground(plane())
    found = exact_distances(ground, 33)
    expected = np.linalg.norm(ground.vertices - ground.vertices[33], axis=1)
    np.testing.assert_allclose(found, expected, rtol=2e-6, atol=1e-6)


def test_the_oracle_around_a_hole_goes_by_its_corners():
    mesh = zoo.hole(cells=9, size=9.0)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    start, end = (
        int(np.argmin(np.linalg.norm(mesh_map.vertices - [x, 4.0, 0.0], axis=1)))
        for x in (0.0, 9.0)
    )
    found = exact_distances(mesh_map, start)[end]
    assert found == pytest.approx(2.0 * np.hypot(3.0, 1.0) + 3.0, rel=1e-6)


def test_open_ground_is_what_is_not_closed():
    mesh = zoo.grid(cells=10, size=10.0)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    costs = np.where(mesh.vertices[:, 0] == 7, np.inf, 0.0).astype(np.float32)
    world = plane()
    world.mesh_map = mesh_map
    world.faces = np.flatnonzero((mesh.vertices[mesh.faces][:, :, 0] <= 6).all(axis=1))
    ground = open_ground(world)
    assert len(ground.faces) == 2 * 6 * 10 and ground.vertices[:, 0].max() == 6.0
    assert costs[mesh.vertices[:, 0] == 7].min() == np.inf


def test_planners_are_compared_with_it():
    """On a plane paths are straight; a wrong oracle is seen."""
    front, exact = excess(plane(), 45)
    for each in (front, exact):
        assert len(each.ratios) == 45 and not each.failed
        assert each.ratios.max() < 1.01 and each.ratios.min() > 1.0 - 1e-5
    assert exact.ratios.max() < 1.0 + 1e-5

    def too_long(ground, vertex):
        return 1.001 * exact_distances(ground, vertex)

    (spoiled,) = excess(plane(), 10, ("mmp_planner",), distances=too_long)
    assert spoiled.impossible == 10 and spoiled.failed


def test_what_poses_leave_out_is_no_shorter_path():
    """A ridge of less than 0.1 mm: poses need none on it, the path goes over it all the same."""
    x, z = np.array([0.0, 0.6, 0.60002, 0.60004, 1.2]), np.array([0.0, 0.0, 9e-5, 0.0, 0.0])
    vertices = np.stack([np.tile(x, 2), np.repeat([0.0, 1.0], 5), np.tile(z, 2)], axis=1)
    faces = [[i, i + 1, i + 5] for i in range(4)] + [[i + 1, i + 6, i + 5] for i in range(4)]
    ridge = MeshMap(vertices.astype(np.float32), np.array(faces, np.uint32))
    for each in excess(DrivingWorld("ridge", ridge), 40):
        assert each.ratios.min() < 1.0 - 2e-5 and not each.failed


@pytest.mark.parametrize("make", [worlds.car_park, worlds.rough, worlds.building])
def test_no_path_is_shorter_than_the_shortest_and_all_are_found(make):
    given = {"size": 12.0} if make is not worlds.building else {}
    front, exact = excess(make(**given), 40)
    assert not front.failed and not exact.failed
    assert front.ratios.max() < 1.03 and exact.ratios.max() < 1.01


def test_the_table():
    some = [
        Excess("sea", "mmp", np.array([1.0, 1.02, 1.04, 0.9]), 2, 1),
        Excess("lake", "mmp", np.zeros(0), 1),
    ]
    lines = excess_table(some).splitlines()
    assert lines[1].split() == "sea mmp 6 1.0100 50.0 % 25.0 % 1.0400 1 2".split()
    assert lines[2].split()[:3] == ["lake", "mmp", "1"] and some[1].failed

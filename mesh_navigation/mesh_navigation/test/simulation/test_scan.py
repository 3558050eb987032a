"""Simulated scans, against every face by brute force."""

import math

import numpy as np
import pytest

from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import zoo
from mesh_navigation.base.pose import Pose, rotate
from mesh_navigation.simulation.obstacles import Obstacle
from mesh_navigation.simulation.scan import SimulatedScan


def brute_force(mesh, origin, direction):
    """The distance along a ray to the first face, by Cramer's rule for each of them."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]].astype(np.float64) for corner in range(3))
    normals = np.cross(b - a, c - a)
    below = normals @ direction
    with np.errstate(all="ignore"):
        t = np.sum((a - origin) * normals, axis=1) / below
        points = origin + t[:, None] * direction
        inside = np.ones(len(t), bool)
        for first, second in ((a, b), (b, c), (c, a)):
            inside &= np.sum(np.cross(second - first, points - first) * normals, axis=1) >= -1e-9
    hits = t[inside & (t >= 0) & (below != 0)]
    return hits.min() if len(hits) else math.inf


@pytest.mark.parametrize("name", ["two_storeys", "jittered_plane", "torus"])
def test_ranges_are_those_of_brute_force(name):
    mesh = next(mesh for mesh in zoo.all_meshes() if mesh.name == name)
    surface = MeshMap(mesh.vertices, mesh.faces)
    scan = SimulatedScan(surface, rings=5, columns=24)
    place = mesh.vertices.astype(np.float64).mean(axis=0) + [0.123, 0.077, 0.3]
    pose = Pose(place, np.array([0.1, -0.05, 0.3, 0.9])).normalized()
    expected = [
        brute_force(mesh, place, rotate(pose.orientation, direction))
        for direction in scan.directions
    ]
    ranges = scan.ranges(pose)
    assert ranges == pytest.approx(expected, abs=1e-6)
    assert np.isfinite(ranges).any()


def test_obstacles_hide_what_is_behind_them():
    grid = zoo.grid()
    surface = MeshMap(grid.vertices, grid.faces)
    scan = SimulatedScan(surface, rings=31, columns=180)
    box = Obstacle.checked("box", Pose.at((7, 5, 0.5)), (1, 1, 1))
    pose = Pose.at((5, 5, 0.8), 0.5)
    bare, seen = scan.ranges(pose), scan.ranges(pose, [box])
    alone = box.ray_distances(
        pose.position, np.array([rotate(pose.orientation, ray) for ray in scan.directions])
    )
    assert seen == pytest.approx(np.minimum(bare, alone), rel=1e-12)
    assert (seen < bare).sum() > 100
    cloud = (
        np.array([rotate(pose.orientation, point) for point in scan.cloud(pose, [box])])
        + pose.position
    )
    on_ground = abs(cloud[:, 2]) < 1e-5
    hull = abs(abs((cloud - box.pose.position) / 0.5).max(axis=1) - 1) < 1e-5
    assert (on_ground | hull).all() and hull.sum() > 100


def test_clouds_have_points_within_the_ranges_only():
    grid = zoo.grid()
    scan = SimulatedScan(MeshMap(grid.vertices, grid.faces), min_range=2.0, max_range=4.0)
    cloud = scan.cloud(Pose.at((5, 5, 1.0)))
    distances = np.linalg.norm(cloud, axis=1)
    assert cloud.dtype == np.float32 and len(cloud) > 100
    assert distances.min() >= 1.9999 and distances.max() <= 4.0001
    assert scan.cloud(Pose.at((500, 5, 1.0))).shape == (0, 3)


def test_noise_is_along_the_rays_and_repeatable():
    grid = zoo.grid()
    surface = MeshMap(grid.vertices, grid.faces)

    def clouds(seed):
        scan = SimulatedScan(surface, rings=8, columns=90, noise=0.02, seed=seed, max_range=5)
        return [scan.cloud(Pose.at((5, 5, 1.0))) for _ in range(2)]

    first, again, other = clouds(1), clouds(1), clouds(2)
    assert all(a.tolist() == b.tolist() for a, b in zip(first, again))
    assert first[0].tolist() != first[1].tolist() != other[1].tolist()
    exact = SimulatedScan(surface, rings=8, columns=90)
    ranges = exact.ranges(Pose.at((5, 5, 1.0)))
    rays = exact.directions[ranges < 4.5]
    units = first[0] / np.linalg.norm(first[0], axis=1)[:, None]
    errors = []
    for ray, length in zip(rays, ranges[ranges < 4.5]):
        index = int(np.argmax(units @ ray))
        assert units[index] == pytest.approx(ray, abs=1e-6)
        errors.append(np.linalg.norm(first[0][index]) - length)
    assert np.std(errors) == pytest.approx(0.02, rel=0.2)
    assert abs(np.mean(errors)) < 0.004


def test_rays_begin_ahead_and_turn_left_from_below():
    grid = zoo.grid()
    scan = SimulatedScan(
        MeshMap(grid.vertices, grid.faces), rings=3, columns=4, lowest=-0.5, highest=0.5
    )
    assert scan.directions[0] == pytest.approx([math.cos(0.5), 0, -math.sin(0.5)])
    assert scan.directions[5] == pytest.approx([0, 1, 0])
    one = SimulatedScan(
        MeshMap(grid.vertices, grid.faces), rings=1, columns=4, lowest=-0.5, highest=0.1
    )
    assert one.directions[0] == pytest.approx([math.cos(0.2), 0, -math.sin(0.2)])


@pytest.mark.parametrize(
    "wrong",
    [
        {"rings": 0},
        {"columns": 0},
        {"lowest": 1.0, "highest": 0.5},
        {"lowest": math.nan},
        {"min_range": 5, "max_range": 5},
        {"min_range": math.nan},
        {"noise": -1},
        {"noise": math.inf},
    ],
)
def test_impossible_scans_are_refused(wrong):
    grid = zoo.grid()
    with pytest.raises(ValueError):
        SimulatedScan(MeshMap(grid.vertices, grid.faces), **wrong)

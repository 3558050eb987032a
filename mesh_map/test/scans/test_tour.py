"""Drives over a world: they stay where a robot can be."""

import numpy as np
import pytest

from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.scans.tour import drivable_vertices, drive, route, tour, tour_waypoints
from mesh_map.scans.trajectory import rotations_of
from mesh_msgs import zoo
from mesh_msgs.outdoor_world import outdoor_world

WORLD = outdoor_world(60_000, 2, size=40.0, trees=False, stairs=True)
MESH = MeshGeometry(WORLD.vertices, WORLD.faces)
PLACES = ("start", "bridge_deck", "goal", "under_bridge", "landing")


@pytest.fixture(scope="module")
def drivable():
    return drivable_vertices(MESH)


def test_a_tour_leads_over_and_under_the_bridge_and_up_to_the_landing(drivable):
    waypoints = np.array([WORLD.places[name] for name in PLACES])
    path = route(MESH, waypoints, drivable)
    # Each point of it is on a face whose corners are drivable.
    on_mesh = MESH.spatial_index.closest_batch(points=path)
    assert on_mesh.distances.max() < 1e-5
    free = drivable[MESH.faces].all(axis=1)
    near = MESH.spatial_index.closest_batch(points=path, mask=free)
    assert near.distances.max() < 1e-5
    for place in waypoints:
        assert np.linalg.norm(path - place, axis=1).min() < 1.0
    poses = drive(MESH, path, speed=0.8, turn_speed=0.5, begin=7.0)
    assert poses.times[0] == 7.0
    assert poses.positions[[0, -1]] == pytest.approx(path[[0, -1]], abs=1e-9)
    assert MESH.spatial_index.closest_batch(points=poses.positions).distances.max() < 0.3
    rotations, seconds = rotations_of(poses.orientations), np.diff(poses.times)
    steps = np.diff(poses.positions, axis=0)
    speeds = np.linalg.norm(steps, axis=1) / seconds
    assert speeds.max() < 0.8001 and np.median(speeds) == pytest.approx(0.8)
    cosines = np.einsum("nij,nij->n", rotations[1:], rotations[:-1])
    turned = np.arccos(np.clip((cosines - 1) / 2, -1, 1))
    assert (turned / seconds).max() < 0.501
    # x is ahead, z away from the ground.
    moving = np.linalg.norm(steps, axis=1) > 0.02
    ahead = np.einsum("ni,ni->n", rotations[:-1, :, 0], steps)[moving]
    assert (ahead > 0.5 * np.linalg.norm(steps[moving], axis=1)).mean() > 0.97
    assert rotations[:, 2, 2].min() > np.cos(0.7)


def test_the_robot_keeps_away_from_what_is_steep_and_low(drivable):
    assert 0.3 < drivable.mean() < 0.9
    corners = MESH.vertices[drivable]
    away = MESH.vertices[~drivable]
    up = MESH.spatial_index.any_hit_batch(
        origins=corners + [0, 0, 0.2],
        directions=np.tile([0.0, 0, 1], (len(corners), 1)),
        max_distance=1.3,
    )
    assert not up.any() and len(away) > 1000
    steep = np.degrees(np.arccos(np.clip(MESH.face_normals[:, 2], -1, 1))) > 80
    walls = MESH.vertices[MESH.faces[steep]].mean(axis=1)
    shares = [np.linalg.norm(corners - wall, axis=1).min() for wall in walls[::50]]
    assert min(shares) > 0.15


def test_the_same_seed_makes_the_same_tour(drivable):
    first, again, other = (tour(MESH, count=4, seed=seed) for seed in (3, 3, 4))
    assert first.positions.tobytes() == again.positions.tobytes() != other.positions.tobytes()
    assert first.orientations.tobytes() == again.orientations.tobytes()
    assert first.positions[0] == pytest.approx(first.positions[-1], abs=1e-9)
    places = tour_waypoints(MESH, drivable, 12, 1)
    apart = np.linalg.norm(places[:, None] - places[None], axis=2) + 99 * np.eye(12)
    assert apart.min() > 4.0


def test_where_nothing_can_drive_is_told():
    steep = zoo.grid().vertices @ np.float32([[0, 0, 1], [0, 1, 0], [1, 0, 0]])
    with pytest.raises(MeshMapError, match="a robot can be nowhere on this mesh of 200 faces"):
        tour(MeshGeometry(steep, zoo.grid().faces))


def test_waypoints_that_cannot_be_reached_are_told(drivable):
    high = [WORLD.places["start"], (0, 0, 30)]
    with pytest.raises(MeshMapError, match=r"the waypoint \[0.0, 0.0, 30.0\] is .* m from where"):
        route(MESH, high, drivable)
    with pytest.raises(MeshMapError, match="at least two of three finite numbers"):
        route(MESH, high[:1], drivable)
    cut = drivable & (abs(MESH.vertices[:, 0] + 10) > 0.5)
    there = [WORLD.places["start"], WORLD.places["goal"]]
    with pytest.raises(MeshMapError, match="no path over drivable ground to waypoint 1 at"):
        route(MESH, there, cut)


@pytest.mark.parametrize(
    "points, speed, text",
    [
        ([[0, 0, 0], [1, 0, 0]], 0.0, "a drive with 0.0 m/s"),
        ([[0, 0, 0], [0, 0, 0]], 1.0, "a path of 0.0 m"),
        ([[0, 0, 0]], 1.0, r"a path of the shape \(1, 3\)"),
        ([[0, 0, 0], [0, 0, 5]], 1.0, "leads nowhere but up or down"),
    ],
)
def test_what_is_no_path_is_refused(points, speed, text):
    grid = zoo.grid()
    with pytest.raises(MeshMapError, match=text):
        drive(MeshGeometry(grid.vertices, grid.faces), points, speed=speed)

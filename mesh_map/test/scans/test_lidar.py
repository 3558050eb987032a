"""What a lidar measures, against every face by brute force, and ray by ray."""

import math

import numpy as np
import pytest

from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.scans.cloud_message import cloud_message
from mesh_map.scans.lidar import Lidar, LidarModel
from mesh_map.scans.trajectory import Trajectory
from mesh_map.spatial.hits import NO_FACE
from mesh_map.spatial.spatial_index import SpatialIndex
from mesh_msgs import zoo
from mesh_msgs.point_cloud import cloud_points

GRID = zoo.grid()  # 10 m x 10 m, at the height 0
FLOOR = MeshGeometry(GRID.vertices, GRID.faces)


def at(x, y, z, yaw=0.0):
    pose = np.eye(4)
    pose[:2, :2] = [[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]]
    pose[:3, 3] = x, y, z
    return pose


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
    lidar = Lidar(MeshGeometry(mesh.vertices, mesh.faces), LidarModel(rings=5, columns=24))
    place = mesh.vertices.astype(np.float64).mean(axis=0) + [0.123, 0.077, 0.3]
    tilted = Trajectory([0.0], [place], np.array([[0.1, -0.05, 0.3, 0.9]]) / math.sqrt(0.9125))
    pose = tilted.poses([0.0])[0]
    expected = [brute_force(mesh, place, pose[:3, :3] @ ray) for ray in lidar.directions]
    ranges = lidar.ranges(pose)
    assert ranges == pytest.approx(expected, abs=1e-6)
    assert np.isfinite(ranges).any()


def test_motion_in_a_scan_is_that_of_single_rays():
    world = next(mesh for mesh in zoo.all_meshes() if mesh.name == "two_storeys")
    mesh = MeshGeometry(world.vertices, world.faces)
    middle = world.vertices.astype(np.float64).mean(axis=0) + [0.1, 0.2, 0.4]
    turns = np.array([[0, 0, 0, 1.0], [0.1, 0, 0.5, 0.8], [0.1, 0.1, 0.9, -0.4]])
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    moving = Trajectory([9.9, 10.04, 10.2], [middle, middle + [0.2, 0.1, 0], middle + 0.3], turns)
    model = LidarModel(rings=6, columns=40, lowest=-0.9, highest=0.6, duration=0.1)
    lidar = Lidar(mesh, model)
    scan = lidar.measure(moving, 10.0)
    found = iter(zip(scan.points, scan.times, scan.rings, scan.faces))
    count = 0
    for number, ray in enumerate(lidar.directions):
        ring, column = divmod(number, 40)
        moment = np.float32(column / 40 * 0.1)
        pose = moving.poses([10.0 + float(moment)])[0]
        hit = mesh.spatial_index.cast(origin=pose[:3, 3], direction=pose[:3, :3] @ ray)
        if hit is None or not 0.3 <= hit.distance <= 30:
            continue
        point, time, of_ring, face = next(found)
        assert point == pytest.approx(hit.distance * ray, abs=1e-6)
        assert (time, of_ring, face) == (moment, ring, hit.face)
        count += 1
    assert next(found, None) is None and count > 100
    # With the true motion undone, all points are on the mesh again, as seen from where it was.
    undone = scan.undistorted(moving)
    on_mesh = mesh.spatial_index.closest_batch(points=undone.in_map())
    assert on_mesh.distances.max() < 1e-5
    lengths = np.linalg.norm(undone.in_map() - undone.origins_in_map(), axis=1)
    assert lengths == pytest.approx(np.linalg.norm(scan.points, axis=1), abs=1e-5)
    assert (undone.pose == moving.poses([10.0])[0]).all() and undone.time == 10.0
    # A robot that stands measures in a revolution what it measures at once.
    pose = moving.poses([10.0])[0]
    still = Trajectory.of_matrices(np.stack([pose, pose]), [9.0, 11.0])
    points = lidar.measure(still, 10.0).points
    assert points == pytest.approx(lidar.measure(pose).points, abs=1e-6)


def test_what_hides_the_mesh_is_measured():
    lidar = Lidar(FLOOR, LidarModel(rings=31, columns=180))
    pose = at(5, 5, 0.8, 0.5)
    bare = lidar.measure(pose)
    assert not (bare.faces == NO_FACE).any()

    def hidden(origins, directions):
        assert (origins == pose[:3, 3]).all() and directions.shape == lidar.directions.shape
        return np.where(directions[:, 0] > 0.5, 1.0, np.inf)

    seen = lidar.measure(pose, 0.0, hidden)
    met = seen.faces == NO_FACE
    assert np.linalg.norm(seen.points[met], axis=1) == pytest.approx(1.0)
    ahead = (lidar.directions @ pose[:3, :3].T)[:, 0] > 0.5
    ranges = lidar.ranges(pose)
    assert met.sum() == (ahead & (ranges > 1.0)).sum() > 100
    assert (lidar.ranges(pose, hidden) == np.where(ahead, np.minimum(ranges, 1.0), ranges)).all()
    assert (seen.intensities[met] == 255).all()


def test_points_are_within_the_ranges_only():
    lidar = Lidar(FLOOR, LidarModel(min_range=2.0, max_range=4.0))
    distances = np.linalg.norm(lidar.measure(at(5, 5, 1.0)).points, axis=1)
    assert len(distances) > 100 and distances.min() >= 1.9999 and distances.max() <= 4.0001
    nothing = lidar.measure(at(500, 5, 1.0))
    assert (
        nothing.points.shape == (0, 3) and len(cloud_points(cloud_message(nothing, "l", None))) == 0
    )


def test_noise_is_along_the_rays():
    exact = Lidar(FLOOR, LidarModel(rings=8, columns=90))
    ranges = exact.ranges(at(5, 5, 1.0))
    model = LidarModel(rings=8, columns=90, noise=0.02, max_range=1000)
    noise = 0.02 * np.random.default_rng(3).standard_normal(720)
    met = np.isfinite(ranges)
    expected = np.float32((ranges + noise)[met, None] * exact.directions[met])
    assert Lidar(FLOOR, model, seed=3).measure(at(5, 5, 1.0)).points.tolist() == expected.tolist()
    assert np.std(noise[met]) == pytest.approx(0.02, rel=0.1)


def test_the_same_seed_measures_the_same():
    model = LidarModel(noise=0.02, dropout=0.3, duration=0.1)
    moving = Trajectory([0, 1], [[4, 5, 1], [6, 5, 1]], [[0, 0, 0, 1], [0, 0, 0.6, 0.8]])

    def content(seed):
        lidar = Lidar(FLOOR, model, seed=seed)
        scans = [lidar.measure(moving, time) for time in (0.0, 0.5)]
        return [scan.points.tobytes() + scan.intensities.tobytes() for scan in scans]

    first, again, other = content(1), content(1), content(2)
    assert first == again and len({*first, *other}) == 4


def test_the_share_of_dropouts_is_theirs_and_nothing_else_changes():
    model = {"rings": 32, "columns": 720, "noise": 0.01}
    whole = Lidar(FLOOR, LidarModel(**model)).measure(at(5, 5, 1.0)).points
    part = Lidar(FLOOR, LidarModel(dropout=0.2, **model)).measure(at(5, 5, 1.0)).points
    # Five standard deviations of a binomial distribution.
    expected, scatter = 0.8 * len(whole), math.sqrt(0.16 * len(whole))
    assert abs(len(part) - expected) < 5 * scatter and len(whole) > 5000
    assert {row.tobytes() for row in part} < {row.tobytes() for row in whole}
    none = Lidar(FLOOR, LidarModel(dropout=1.0, **model)).measure(at(5, 5, 1.0))
    assert len(none.points) == 0


def test_grazing_and_far_rays_are_lost_first():
    model = LidarModel(rings=30, columns=36, reflect_range=4.0)
    exact = Lidar(FLOOR, LidarModel(rings=30, columns=36))
    ranges = exact.ranges(at(5, 5, 1.0))
    # On a floor the cosine of the incidence is height / range.
    seen = ranges <= 4.0 * np.sqrt(1.0 / ranges)
    points = Lidar(FLOOR, model).measure(at(5, 5, 1.0)).points
    assert points.tolist() == np.float32(ranges[seen, None] * exact.directions[seen]).tolist()
    assert 0 < seen.sum() < np.isfinite(ranges).sum()
    dark = np.full(len(GRID.vertices), 0.25)
    points = Lidar(FLOOR, model, reflectances=dark).measure(at(5, 5, 1.0)).points
    assert len(points) == (ranges <= 2.0 * np.sqrt(1.0 / ranges)).sum()


def test_intensities_are_lambertian():
    large = zoo.grid(cells=20, size=100.0)
    mesh = MeshGeometry(large.vertices, large.faces)
    of_faces = np.random.default_rng(0).random(len(large.faces))
    model = LidarModel(rings=16, columns=90, max_range=60)
    scan = Lidar(mesh, model, reflectances=of_faces).measure(at(50, 50, 2.0))
    ranges = np.linalg.norm(scan.points.astype(np.float64), axis=1)
    falloff = np.minimum(1.0, (10.0 / ranges) ** 2)
    expected = 255 * of_faces[scan.faces] * (2.0 / ranges) * falloff
    assert scan.intensities == pytest.approx(expected, rel=1e-4)
    assert ranges.max() > 15
    # Those of vertices are linear on faces: here along x.
    along = large.vertices[:, 0] / 100
    scan = Lidar(mesh, model, reflectances=along).measure(at(50, 50, 2.0))
    ranges = np.linalg.norm(scan.points.astype(np.float64), axis=1)
    expected = 255 * (50 + scan.points[:, 0]) / 100 * (2.0 / ranges)
    expected *= np.minimum(1.0, (10.0 / ranges) ** 2)
    assert scan.intensities == pytest.approx(expected, rel=1e-4)


def test_colors_are_those_of_the_surface():
    colors = np.zeros((len(GRID.vertices), 3), np.uint8)
    colors[:, 0], colors[:, 2] = np.rint(20 * GRID.vertices[:, 0]), 7
    scan = Lidar(FLOOR, LidarModel(), colors=colors).measure(at(5, 5, 1.0))
    assert abs(scan.colors[:, 0] - 20 * (5 + scan.points[:, 0])).max() <= 1.0
    assert (scan.colors[:, 1] == 0).all() and (scan.colors[:, 2] == 7).all()
    assert Lidar(FLOOR).measure(at(5, 5, 1.0)).colors is None


def test_messages_have_the_fields_of_drivers():
    colors = np.tile(np.uint8([[1, 2, 3]]), (len(GRID.vertices), 1))
    moving = Trajectory([0, 1], [[4, 5, 1], [6, 5, 1]], [[0, 0, 0, 1], [0, 0, 0.6, 0.8]])
    scan = Lidar(FLOOR, LidarModel(duration=0.1), colors=colors).measure(moving, 0.5)
    message = cloud_message(scan, "laser", None)
    assert message.header.frame_id == "laser" and message.width == len(scan.points)
    assert [(f.name, f.offset, f.datatype, f.count) for f in message.fields] == [
        ("x", 0, 7, 1),
        ("y", 4, 7, 1),
        ("z", 8, 7, 1),
        ("intensity", 12, 7, 1),
        ("ring", 16, 4, 1),
        ("time", 18, 7, 1),
        ("rgb", 22, 7, 1),
    ]
    assert cloud_points(message).tolist() == scan.points.tolist()
    kinds = [("xyz", "<f4", 3), ("intensity", "<f4"), ("ring", "<u2"), ("time", "<f4")]
    rows = np.frombuffer(message.data, kinds + [("rgb", "<u4")])
    assert rows["ring"].tolist() == scan.rings.tolist() and rows["ring"].max() < 16
    assert rows["time"].tolist() == scan.times.tolist()
    assert 0 <= rows["time"].min() < rows["time"].max() < 0.1
    assert rows["intensity"].tolist() == scan.intensities.tolist()
    assert set(rows["rgb"]) == {0x010203}
    plain = Lidar(FLOOR).measure(at(5, 5, 1.0))
    assert cloud_message(plain, "laser", None).point_step == 22


def test_rays_begin_ahead_and_turn_left_from_below():
    directions = LidarModel(rings=3, columns=4, lowest=-0.5, highest=0.5).directions()
    assert directions[0] == pytest.approx([math.cos(0.5), 0, -math.sin(0.5)])
    assert directions[5] == pytest.approx([0, 1, 0])
    one = LidarModel(rings=1, columns=4, lowest=-0.5, highest=0.1).directions()
    assert one[0] == pytest.approx([math.cos(0.2), 0, -math.sin(0.2)])


def test_a_bare_index_measures_the_same_points():
    index = SpatialIndex(GRID.vertices, GRID.faces)
    bare, whole = (Lidar(surface).measure(at(5, 5, 1.0)) for surface in (index, FLOOR))
    assert bare.points.tolist() == whole.points.tolist()
    assert bare.intensities.max() == 255


@pytest.mark.parametrize(
    "wrong, text",
    [
        ({"rings": 0}, "a lidar of 0 rings"),
        ({"rings": 1 << 17}, "a lidar of 131072 rings"),
        ({"columns": 0}, "and 0 columns"),
        ({"lowest": 1.0, "highest": 0.5}, "with rings from 1.0 to 0.5 rad"),
        ({"lowest": math.nan}, "with rings from nan"),
        ({"min_range": 5, "max_range": 5}, "with ranges from 5 to 5 m"),
        ({"min_range": math.nan}, "with ranges from nan"),
        ({"noise": -1}, "the noise of a lidar is -1"),
        ({"noise": math.inf}, "the noise of a lidar is inf"),
        ({"dropout": 1.5}, "the dropout of a lidar is 1.5 .*from 0 to 1"),
        ({"duration": math.nan}, "the duration of a lidar is nan"),
        ({"reflect_range": 0.0}, "the reflect_range of a lidar is 0.0 m"),
    ],
)
def test_impossible_lidars_are_refused(wrong, text):
    with pytest.raises(MeshMapError, match=text):
        LidarModel(**wrong)


@pytest.mark.parametrize(
    "wrong, text",
    [
        ({"colors": np.zeros((3, 3), np.uint8)}, "colors of the shape .*for a mesh of"),
        ({"colors": np.zeros((len(GRID.vertices), 3))}, "type float64"),
        ({"reflectances": np.ones(5)}, "reflectances of the shape"),
        (
            {"reflectances": np.full(len(GRID.faces), 1.5)},
            "200 of 200 reflectances are not between",
        ),
    ],
)
def test_arrays_of_another_mesh_are_refused(wrong, text):
    with pytest.raises(MeshMapError, match=text):
        Lidar(FLOOR, **wrong)

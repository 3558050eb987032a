"""Costs under footprints, against cutting each face in NumPy."""

import numpy as np
import pytest
from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled, MeshMapError
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.map.footprint import Footprint
from mesh_map.map.queries import SurfaceQueries
from meshes import TestMesh, soup, terrain
from oracles import clipped, in_planes
from scipy.spatial.transform import Rotation

SQUARE = [(0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.3, -0.2)]


def queries_of(mesh):
    return SurfaceQueries(MeshGeometry(mesh.vertices, mesh.faces))


def planes_of(footprint, pose):
    """(P, 4): >= 0 over the polygon and within the heights, in the frame of the mesh."""
    after = np.roll(footprint.polygon, -1, 0)
    side = after - footprint.polygon
    rows = [(-y, x, 0, y * a - x * b) for (x, y), (a, b) in zip(side, footprint.polygon)]
    rows += [(0, 0, 1, footprint.below), (0, 0, -1, footprint.above)]
    return np.array(rows, np.float64) @ np.linalg.inv(pose)


def random_pose(random, low, high):
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(random_state=random.integers(1 << 30)).as_matrix()
    pose[:3, 3] = random.uniform(low, high)
    return pose


@pytest.mark.parametrize("mesh", [terrain(12), soup(6, 60, 300)], ids=lambda mesh: mesh.name)
def test_costs_equal_those_of_the_faces_cut_in_numpy(mesh):
    random = np.random.default_rng(0)
    queries = queries_of(mesh)
    corners = mesh.vertices.astype(np.float64)[mesh.faces]
    sides = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)
    to_weights = np.linalg.pinv(sides, rcond=1e-15)  # of the second and third corner
    costs = random.uniform(0, 1, len(mesh.vertices)).astype(np.float32)
    costs[random.random(len(costs)) < 0.02] = np.inf
    costs[random.random(len(costs)) < 0.02] = np.nan
    footprints = [Footprint(SQUARE), Footprint.circle(0.3, 40, below=0.1, above=0.5)]
    poses = np.array(
        [random_pose(random, corners.min((0, 1)), corners.max((0, 1))) for _ in range(40)]
    )
    touched = 0
    for footprint in footprints:
        many = queries.footprint_costs(footprint, poses, costs=costs)
        for i, pose in enumerate(poses):
            found = queries.footprint_cost(footprint, pose, costs=costs)
            assert found == many.cost(i)
            planes = planes_of(footprint, pose)
            touching = in_planes(mesh, planes)
            assert touching.surely.sum() <= found.face_count <= touching.perhaps.sum()
            touched += found.face_count > 0
            surely, perhaps = (costs[mesh.faces[faces]] for faces in touching)
            assert np.isinf(surely).any() <= found.lethal <= np.isinf(perhaps).any()
            assert np.isnan(surely).any() <= found.unknown <= np.isnan(perhaps).any()
            largest = 0.0
            faces = np.flatnonzero(touching.surely)
            for face, part, count in zip(faces, *clipped(corners[faces], planes)):
                field = costs[mesh.faces[face]].astype(np.float64)
                if count and np.isfinite(field).all():
                    weights = to_weights[face] @ (part[:count] - corners[face, 0]).T
                    largest = max(largest, (field[0] + (field[1:] - field[0]) @ weights).max())
            assert abs(found.maximum - largest) < 1e-5
            expected = np.inf if found.lethal else found.maximum
            if not found.lethal and (found.unknown or not found.face_count):
                expected = np.nan
            assert np.array_equal(found.cost, expected, equal_nan=True)
            assert np.array_equal(many.costs()[i], np.float32(expected), equal_nan=True)
    assert touched > 20


def test_ground_is_what_lies_within_the_heights():
    """The share of sample points with ground equals that of rays; twice the ground is no more."""
    mesh = terrain(30)
    keep = np.random.default_rng(1).random(len(mesh.faces)) < 0.7
    faces = np.concatenate([mesh.faces[keep], mesh.faces[keep][::2]])
    queries = queries_of(TestMesh("holes", mesh.vertices, faces))
    costs = np.zeros(len(mesh.vertices), np.float32)
    footprint = Footprint.circle(0.5, below=0.2, above=0.2)
    random = np.random.default_rng(2)
    points = random.uniform(-0.5, 0.5, (20_000, 2))
    points = points[np.linalg.norm(points, axis=1) < 0.5]
    for _ in range(10):
        pose = np.eye(4)
        pose[:3, 3] = *random.uniform(0.6, 2.3, 2), random.uniform(-0.2, 0.2)
        found = queries.footprint_cost(footprint, pose, costs=costs)
        down = queries.geometry.spatial_index.any_hit_batch(
            origins=np.c_[points, np.full(len(points), 0.2)] + pose[:3, 3],
            directions=np.broadcast_to((0.0, 0.0, -1.0), (len(points), 3)),
            max_distance=0.4,
        )
        assert abs(found.ground - down.mean()) < 0.03


def test_a_footprint_over_flat_ground():
    x, y = np.meshgrid(np.arange(11.0), np.arange(11.0), indexing="ij")
    mesh = terrain(11)
    flat = TestMesh("flat", np.stack([x, y, 0 * x], -1).reshape(-1, 3), mesh.faces)
    queries = queries_of(flat)
    costs = flat.vertices[:, 0]
    pose = np.eye(4)
    pose[:3, 3] = 5.15, 5.1, 0.1
    found = queries.footprint_cost(Footprint(SQUARE), pose, costs=costs)
    assert abs(found.maximum - 5.45) < 1e-6 and found.ground == 1.0 and not found.lethal
    start = queries.carrying_face((5.15, 5.1, 0.1))
    walk = queries.walker.walk(start=start, direction=(0, 1, 0), length=0)
    across = queries.footprint_cost(Footprint(SQUARE), walk.matrix(), costs=costs)
    assert abs(across.maximum - 5.35) < 1e-6
    pose[2, 3] = 0.5
    off = queries.footprint_cost(Footprint(SQUARE), pose, costs=costs)
    assert off.face_count == 0 and off.ground == 0 and np.isnan(off.cost)
    pose[0, 3] = np.nan
    assert queries.footprint_cost(Footprint(SQUARE), pose, costs=costs).face_count == 0


@pytest.mark.parametrize("width", [1e-6, 1e-11])
def test_a_footprint_may_be_thin(width):
    mesh = terrain(5)
    flat = TestMesh("flat", mesh.vertices * (1, 1, 0), mesh.faces)
    pose = np.eye(4)
    pose[:3, 3] = 0.15, 0.2, 0
    for polygon in (
        [(0, 0), (0.1, 0), (0.1, width), (0, width)],
        [(0, 0), (width, 0), (width, 0.1), (0, 0.1)],
    ):
        found = queries_of(flat).footprint_cost(Footprint(polygon), pose, costs=np.ones(25))
        assert found.ground == 1.0 and found.maximum == pytest.approx(1) and found.face_count


def test_a_clockwise_polygon_is_turned():
    assert np.array_equal(Footprint(SQUARE[::-1]).polygon, Footprint(SQUARE).polygon[[0, 1, 2, 3]])


@pytest.mark.parametrize(
    "polygon, match",
    [
        ([(0, 0), (1, 0)], "3 corners or more"),
        ([(0, 0), (1, 0), (np.nan, 1)], "finite"),
        ([(0, 0), (1, 0), (0.2, 0.2), (0, 1)], "not convex at corner 2"),
        ([(0, 0), (0, 1), (0.2, 0.2), (1, 0)], "not convex at corner 2"),
        ([(0, 0), (1, 0), (1, 0), (0, 1)], "corner 1 .* the same"),
        ([(0, 0), (1, 0), (2, 0)], "not convex"),
        (SQUARE * 2, "not convex"),
        ([(0, 0, 0)], "shape"),
        ("square", "numbers"),
    ],
)
def test_polygons_that_are_no_footprint_are_refused(polygon, match):
    with pytest.raises(MeshMapError, match=match):
        Footprint(polygon)


def test_other_bad_arguments_are_refused():
    for heights in ({"below": -1}, {"above": np.nan}, {"above": np.inf}, {"below": "deep"}):
        with pytest.raises(MeshMapError, match="below|above"):
            Footprint(SQUARE, **heights)
    for radius, corners in ((0, 16), (np.nan, 16), (np.inf, 16), ("1", 16), (1, 2), (1, 3.5)):
        with pytest.raises(MeshMapError, match="no circle"):
            Footprint.circle(radius, corners)
    mesh = terrain(5)
    queries = queries_of(mesh)
    costs = np.zeros(len(mesh.vertices), np.float32)
    scaled = np.stack([np.eye(4), np.diag([2.0, 1, 1, 1]), np.diag([1.0, 1, -1, 1])])
    with pytest.raises(ValueError, match=r"pose 1 does more than turn and shift.*2 such"):
        queries.footprint_costs(Footprint(SQUARE), scaled, costs=costs)
    with pytest.raises(ValueError, match="poses has to have the shape"):
        queries.footprint_cost(Footprint(SQUARE), np.eye(3), costs=costs)
    with pytest.raises(ValueError, match="one for each vertex"):
        queries.footprint_cost(Footprint(SQUARE), np.eye(4), costs=costs[1:])
    with pytest.raises(MeshMapError, match="has no costs"):
        queries.footprint_cost(Footprint(SQUARE), np.eye(4))
    flag = CancelFlag()
    flag.set()
    with pytest.raises(Canceled):
        queries.footprint_costs(Footprint(SQUARE), scaled[:1], costs=costs, cancel=flag)

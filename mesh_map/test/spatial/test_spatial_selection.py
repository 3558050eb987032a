"""Faces in regions against NumPy, face by face; native and OpenCL alike."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from mesh_map.spatial.hits import NO_FACE
from mesh_map.spatial.spatial_index import SpatialIndex, query_counts
from meshes import data_mesh, real, terrain
from oracles import (
    distances_to_outline,
    in_ball,
    in_lasso,
    in_planes,
    points_in_polygon,
    ray_times,
    seen_from,
    unit_planes,
)
from spatial_samples import (
    ADVERSARIAL,
    BACK_ENDS,
    TERRAIN,
    adversarial,
    camera,
    index_of,
    same,
    some_points,
)

STAR = np.array([[0.8, 0.0], [-0.6, 0.5], [0.3, -0.8], [0.3, 0.8], [-0.6, -0.5]])  # crosses itself


def some_box(mesh, random):
    """center, axes, half_size of a box near the mesh, along the axes of space or not."""
    size = np.ptp(mesh.vertices[mesh.faces], axis=(0, 1)).astype(np.float64) + 0.1
    axes = np.eye(3) if random.random() < 0.4 else np.linalg.qr(random.normal(size=(3, 3)))[0]
    half = size.max() * random.uniform(0.01, 0.5, 3)
    return some_points(mesh, random, 4)[random.integers(0, 8)], axes, half


def planes_of(center, axes, half):
    rows = [
        np.append(sign * axis, length - sign * axis @ center)
        for axis, length in zip(axes, half)
        for sign in (1, -1)
    ]
    return np.array(rows)


def check_regions(mesh, index, random, back_end):
    """A ball, a box, and the same box as planes, touching and inside, with and without a mask."""
    mask = random.random(len(mesh.faces)) < 0.6
    center = some_points(mesh, random, 4)[random.integers(0, 8)]
    size = np.linalg.norm(np.ptp(mesh.vertices[mesh.faces], axis=(0, 1)))
    radius = random.choice([0.0, 0.05, 0.2, 0.6]) * size
    box = some_box(mesh, random)
    planes = planes_of(*box) * random.uniform(0.1, 10, (6, 1))
    for mode in ("touching", "inside"):
        inside = mode == "inside"
        ball = in_ball(mesh, center, radius, inside)
        cut = in_planes(mesh, planes, inside)
        for count in (None, mask):
            asked = {"mode": mode, "mask": count, "back_end": back_end}
            ball.check(index.in_sphere(center=center, radius=radius, **asked), count)
            cut.check(index.in_frustum(planes=planes, **asked), count)
            cut.check(index.in_box(center=box[0], axes=box[1], half_size=box[2], **asked), count)


@BACK_ENDS
@adversarial
def test_regions_equal_numpy(mesh, back_end):
    check_regions(mesh, index_of(mesh, back_end), np.random.default_rng(4), back_end)


@settings(max_examples=60)
@given(st.sampled_from(ADVERSARIAL), st.integers(0, 2**32 - 1))
def test_random_regions_equal_numpy(mesh, seed):
    check_regions(mesh, index_of(mesh), np.random.default_rng(seed), "native")


@BACK_ENDS
@real
def test_regions_on_real_meshes(name, back_end):
    mesh = data_mesh(name)
    index = index_of(mesh, back_end)
    for seed in range(3):
        check_regions(mesh, index, np.random.default_rng(seed), back_end)


@settings(max_examples=40)
@given(st.sampled_from(ADVERSARIAL), st.integers(0, 2**32 - 1))
def test_opencl_is_native_to_the_last_bit(mesh, seed):
    index = index_of(mesh, "opencl")
    random = np.random.default_rng(seed)
    center, axes, half = some_box(mesh, random)
    radius = half[0]
    for mode in ("touching", "inside"):
        for mask in (None, random.random(len(mesh.faces)) < 0.5):
            asked = {"mode": mode, "mask": mask}
            ball = dict(center=center, radius=radius, **asked)
            box = dict(center=center, axes=axes, half_size=half, **asked)
            for query, arguments in ((index.in_sphere, ball), (index.in_box, box)):
                native = query(**arguments, back_end="native")
                assert same(query(**arguments, back_end="opencl"), native)


def test_the_device_selects():
    index = index_of(TERRAIN, "opencl")
    before = query_counts()["opencl"]
    index.in_sphere(center=(1, 1, 0), radius=0.5, back_end="opencl")
    index.in_box(center=(1, 1, 0), axes=np.eye(3), half_size=(0.5, 0.5, 0.5), back_end="opencl")
    after = query_counts()["opencl"]
    assert [after[query] - before[query] for query in ("sphere", "frustum")] == [1, 1]


def test_big_triangles_are_touched():
    """No corner of the face is in the region, nor in sight."""
    index = SpatialIndex([[-9, -9, 0], [9, -9, 0], [0, 9, 0]], [[0, 1, 2]])
    matrix, planes = camera((0.1, 0.2, 1.0), (0.1, 0.2, 0.0))
    square = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]]
    for found in (
        index.in_sphere(center=(0.1, 0.2, 0.5), radius=0.5),
        index.in_frustum(planes=planes),
        index.in_box(center=(0, 0, 0), axes=np.eye(3), half_size=(0.1, 0.1, 0.1)),
        index.in_polygon(polygon=square, view_projection=matrix),
    ):
        assert found.tolist() == [0]
    assert not len(index.in_sphere(center=(0.1, 0.2, 0.5), radius=np.nextafter(0.5, 0)))
    assert not len(index.in_sphere(center=(0.1, 0.2, 0.5), radius=0.6, mode="inside"))


@BACK_ENDS
def test_borders_belong_to_regions(back_end):
    """Corners at exactly the radius, and on the sides of a box: 3, 4 and 5 have no rounding."""
    index = SpatialIndex([[3, 4, 0], [-4, 3, 0], [0, -5, 0]], [[0, 1, 2]])
    for mode in ("touching", "inside"):
        asked = {"mode": mode, "back_end": back_end}
        ball, less = (
            index.in_sphere(center=(0, 0, 0), radius=radius, **asked)
            for radius in (5.0, np.nextafter(5.0, 0))
        )
        box, smaller = (
            index.in_box(center=(0, 0, 0), axes=np.eye(3), half_size=(half, 5, 0), **asked)
            for half in (4.0, np.nextafter(4.0, 0))
        )
        assert ball.tolist() == box.tolist() == [0]
        assert less.tolist() == smaller.tolist() == ([0] if mode == "touching" else [])


@adversarial
def test_a_lasso_equals_numpy(mesh):
    index = SpatialIndex(mesh.vertices, mesh.faces)
    used = mesh.vertices[mesh.faces].astype(np.float64)
    middle = np.median(used, axis=(0, 1))
    size = np.median(np.abs(used - middle)) + 0.05
    for eye in ((0.3, -2.0, 3.0), (0.2, 0.3, 0.5)):  # beside the mesh, and within it
        start = middle + size * np.array(eye)
        matrix, planes = camera(start, middle, near=0.01 * size, far=20 * size)
        for polygon in (STAR, 0.4 * STAR + 0.1):
            expected = in_lasso(mesh, polygon, matrix)
            found = index.in_polygon(polygon=polygon, view_projection=matrix)
            expected.check(found)
            pixels = (polygon * [1, -1] + 1) / 2 * [640, 480]
            asked = {"view_projection": matrix, "viewport": (640, 480)}
            expected.check(index.in_polygon(polygon=pixels, **asked))
        whole = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        in_planes(mesh, planes).check(index.in_polygon(polygon=whole, view_projection=matrix))
        inside = index.in_polygon(polygon=whole, view_projection=matrix, mode="inside")
        in_planes(mesh, planes, inside=True).check(inside)


@BACK_ENDS
@adversarial
def test_what_is_seen_equals_numpy(mesh, back_end):
    index = index_of(mesh, back_end)
    random = np.random.default_rng(5)
    used = mesh.vertices[mesh.faces].astype(np.float64)
    middle = np.median(used, axis=(0, 1))
    size = 3 * np.median(np.abs(used - middle)) + 0.05
    center = used[random.integers(0, len(used))].mean(0)
    eye = middle + size * np.array([0.4, -0.5, 0.7])
    asked = {"mode": "visible", "eye": eye, "back_end": back_end}
    radius = 0.12 * size
    touching = index.in_sphere(center=center, radius=radius)

    def in_sphere(points):
        return np.linalg.norm(points - center, axis=1) <= radius

    found = index.in_sphere(center=center, radius=radius, **asked)
    seen_from(mesh, eye, touching, in_sphere).check(found)
    mask = random.random(len(mesh.faces)) < 0.5
    masked = index.in_sphere(center=center, radius=radius, mask=mask, **asked)
    assert np.array_equal(masked, found[mask[found]])  # what does not count still hides

    box = {"center": center, "axes": np.eye(3), "half_size": np.full(3, radius)}
    planes = unit_planes(planes_of(center, np.eye(3), np.full(3, radius)))

    def in_box(points):
        return (points @ planes[:, :3].T + planes[:, 3] >= 0).all(1)

    expected = seen_from(mesh, eye, index.in_box(**box), in_box)
    expected.check(index.in_box(**box, **asked))
    expected.check(index.in_frustum(planes=planes, **asked))


def pixel_hits(mesh, eye, matrix, columns, rows):
    """(rows, columns) of the face that each pixel surely shows, or NO_FACE, or -1 for a doubt, by
    rays from the eye; and the centers of the pixels (rows, columns, 2)."""
    x = 2 * (np.arange(columns) + 0.5) / columns - 1
    y = 1 - 2 * (np.arange(rows) + 0.5) / rows
    centers = np.stack(np.meshgrid(x, y), -1)
    ends = np.concatenate([centers.reshape(-1, 2), np.tile([0.0, 1.0], (columns * rows, 1))], 1)
    ends = ends @ np.linalg.inv(matrix).T
    ways = ends[:, :3] / ends[:, 3:] - eye
    times = ray_times(mesh, np.broadcast_to(eye, ways.shape), ways, np.full(len(ways), np.inf))
    number = np.arange(len(ways))
    nearest = np.argmin(np.where(times.perhaps, times.distance, np.inf), 1)
    limit = times.distance[number, nearest] + 1e-9
    others = (times.perhaps & (times.distance <= limit[:, None])).sum(1)
    faces = np.where(times.surely[number, nearest] & (others == 1), nearest, -1)
    faces[~times.perhaps.any(1)] = NO_FACE
    faces = faces.reshape(rows, columns)
    return faces, centers


@pytest.mark.parametrize("back_end", ["native", "opencl"])
def test_what_shows_in_pixels_equals_numpy(back_end):
    index = index_of(TERRAIN, back_end)
    eye, columns, rows = np.array([1.3, -0.4, 0.8]), 40, 30
    matrix, planes = camera(eye, (1.2, 1.3, 0.0), columns, rows, near=0.01)
    faces, centers = pixel_hits(TERRAIN, eye, matrix, columns, rows)
    assert (faces >= 0).mean() > 0.5 and (faces == -1).mean() < 0.01
    asked = {"mode": "visible", "back_end": back_end}
    found = index.in_frustum(planes=planes, eye=eye, pixels=(columns, rows), **asked)
    expected = np.unique(faces[(faces >= 0) & (faces != NO_FACE)])
    assert set(expected) <= set(found) and len(found) <= len(expected) + (faces == -1).sum()
    polygon = (STAR * [1, -1] + 1) / 2 * [columns, rows]
    lasso = {"polygon": polygon, "view_projection": matrix, "viewport": (columns, rows)}
    found = index.in_polygon(**lasso, **asked)
    flat = centers.reshape(-1, 2)
    inside = points_in_polygon(flat, STAR) & (distances_to_outline(flat, STAR) > 1e-9)
    expected = np.unique(faces.ravel()[inside & (faces.ravel() >= 0)])
    assert set(expected[expected != NO_FACE]) <= set(found)
    assert len(found) <= len(expected) + (faces == -1).sum() and 20 < len(found) < len(faces.flat)
    mask = np.zeros(len(TERRAIN.faces), bool)
    mask[found[::2]] = True
    assert np.array_equal(index.in_polygon(**lasso, mask=mask, **asked), found[::2])


def test_visible_pictures_go_to_the_device():
    mesh = terrain(60)
    index = index_of(mesh, "opencl")
    eye = (3.0, -2.0, 3.0)
    _, planes = camera(eye, (3.0, 3.0, 0.0))
    before = query_counts()["opencl"]["ray"]
    asked = {"planes": planes, "mode": "visible", "eye": eye, "pixels": (100, 80)}
    found = index.in_frustum(**asked, back_end="opencl")
    assert query_counts()["opencl"]["ray"] - before == 8000
    assert same(found, index.in_frustum(**asked, back_end="native")) and len(found) > 1000


@pytest.mark.parametrize("odd", [np.nan, np.inf, -np.inf])
def test_nothing_is_in_odd_regions(odd):
    index = SpatialIndex(TERRAIN.vertices, TERRAIN.faces)
    matrix, planes = camera((1, -1, 1), (1, 1, 0))
    box = {"center": (1, 1, 0), "axes": np.eye(3), "half_size": (1, 1, 1)}
    eye = {"mode": "visible", "eye": (1, -1, 1)}
    odd_planes, odd_matrix = planes.copy(), matrix.copy()
    odd_planes[2, 1] = odd_matrix[1, 2] = odd
    for found in (
        index.in_sphere(center=(0, odd, 0), radius=1),
        index.in_sphere(center=(1, 1, 0), radius=-1),
        index.in_sphere(center=(1, 1, 0), radius=np.nan),
        index.in_frustum(planes=odd_planes),
        index.in_frustum(planes=odd_planes, pixels=(9, 9), **eye),
        index.in_frustum(planes=planes, mode="visible", eye=(odd, 0, 0)),
        index.in_frustum(planes=planes, mode="visible", eye=(odd, 0, 0), pixels=(9, 9)),
        index.in_box(**dict(box, center=(odd, 0, 0))),
        index.in_box(**dict(box, axes=np.full((3, 3), odd))),
        index.in_box(**dict(box, half_size=(1, -1, 1))),
        index.in_polygon(polygon=np.full((5, 2), odd), view_projection=matrix),
        index.in_polygon(polygon=STAR, view_projection=odd_matrix),
        index.in_polygon(polygon=STAR[:2], view_projection=matrix),
        index.in_polygon(polygon=[], view_projection=matrix),
        index.in_polygon(polygon=STAR, view_projection=odd_matrix, viewport=(9, 9), mode="visible"),
    ):
        assert found.dtype == np.uint32 and not len(found)

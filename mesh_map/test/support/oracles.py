"""Geometry in NumPy, double precision, face by face: what the spatial index has to find.

Rounding leaves a doubt where a query just touches something. So predicates come in pairs: what is
surely true, and what may be true. What is found has to lie between.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

# Pairs of a face and a ray or point that are computed in one step, in arrays that fit into a cache.
PAIRS = 30_000


class Maybe(NamedTuple):
    """surely, perhaps: bool arrays; the first implies the second."""

    surely: np.ndarray
    perhaps: np.ndarray

    def check(self, found, mask=None):
        """Asserts that these indices are all that surely are, and only such that perhaps are."""
        assert found.dtype == np.uint32 and (np.diff(found.astype(np.int64)) > 0).all()
        chosen = np.zeros(len(self.surely), bool)
        chosen[found] = True
        counts = np.ones(len(chosen), bool) if mask is None else mask
        missed = np.flatnonzero(self.surely & counts & ~chosen)
        wrong = np.flatnonzero(chosen & ~(self.perhaps & counts))
        assert not len(missed) and not len(wrong), (missed[:5], wrong[:5])


def corners_of(mesh):
    """Three arrays (F, 3) float64."""
    return tuple(mesh.vertices.astype(np.float64)[mesh.faces[:, k]] for k in range(3))


def cross(a, b):
    """Of vectors (3, ...)."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def dot(a, b):
    """Of vectors (3, ...)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def length(a):
    """Of vectors (3, ...)."""
    return np.sqrt(dot(a, a))


def in_steps(mesh, function, *rows):
    """What a function makes of parts of these arrays, one after the other."""
    step = max(1, PAIRS // len(mesh.faces))
    firsts = range(0, max(len(rows[0]), 1), step)
    return [function(*(array[first : first + step] for array in rows)) for first in firsts]


class RayTimes(NamedTuple):
    """Distances to the faces, how wrong they may be, and whether the ray hits them."""

    distance: np.ndarray
    error: np.ndarray
    surely: np.ndarray
    perhaps: np.ndarray


class RaySides(NamedTuple):
    """What every ray has to know of the faces: vectors (3, F) and numbers (F,)."""

    start: np.ndarray
    u_edge: np.ndarray
    v_edge: np.ndarray
    u_length: np.ndarray
    v_length: np.ndarray
    scale: np.ndarray


@lru_cache(maxsize=100)
def ray_sides(mesh):
    a, b, c = (np.ascontiguousarray(corner.T) for corner in corners_of(mesh))
    scale = np.abs(a).max(0) + np.abs(b).max(0) + np.abs(c).max(0)
    return RaySides(a, b - a, c - a, length(b - a), length(c - a), scale)


def ray_times(mesh, origins, directions, max_distances, cull_back_faces=False):
    """RayTimes (R, F) of rays: (R, 3), (R, 3) and (R,)."""
    rays = [np.asarray(rows, np.float64) for rows in (origins, directions, max_distances)]
    sides = ray_sides(mesh)
    parts = in_steps(mesh, lambda *rows: _ray_times(sides, *rows, cull_back_faces), *rays)
    return RayTimes(*map(np.concatenate, zip(*parts)))


@np.errstate(all="ignore")
def _ray_times(faces, origins, directions, max_distances, cull_back_faces):
    """By Moeller and Trumbore: Fast, Minimum Storage Ray/Triangle Intersection, 1997.

    From so far away that squares overflow, nothing is sure.
    """
    largest, farthest = np.abs(directions).max(1), np.abs(origins).max(1)
    nowhere = ~(np.isfinite(origins).all(1) & np.isfinite(directions).all(1) & (largest > 0))
    nowhere |= ~(max_distances >= 0)
    anywhere = ~nowhere & (farthest > 1e100)
    way = (directions / largest[:, None]).T[:, :, None]
    way = way / length(way)
    start = origins.T[:, :, None] - faces.start[:, None]
    cross_v, cross_u = cross(way, faces.v_edge[:, None]), cross(start, faces.u_edge[:, None])
    determinant = dot(faces.u_edge[:, None], cross_v)
    away = length(start)
    rounding = 1e-14 * (faces.scale + farthest[:, None] + away)
    size = np.maximum(faces.u_length, faces.v_length)
    flat = np.abs(determinant) <= 1e-13 * faces.u_length * faces.v_length
    divisor = np.where(flat, 1.0, determinant)
    u = dot(start, cross_v) / divisor
    v = dot(way, cross_u) / divisor
    distance = dot(faces.v_edge[:, None], cross_u) / divisor
    # weights are areas seen along the ray, divided by that of the face
    doubt = (1e-13 * away * size + rounding * (size + away)) / np.abs(divisor) + 1e-13
    margin = np.minimum(np.minimum(u, v), 1 - u - v)
    error = 10 * doubt * size + rounding
    side = determinant > 0 if cull_back_faces else ~flat
    limit = max_distances[:, None]
    reach = (distance >= -error) & (distance <= limit + error)
    inner = (distance >= error) & (distance <= limit - error)
    surely = ~flat & side & (margin > doubt) & inner
    perhaps = np.where(flat, faces.u_length + faces.v_length > 0, side & (margin >= -doubt) & reach)
    error[flat] = np.inf
    distance[nowhere], error[nowhere], perhaps[nowhere] = np.inf, 0, False
    distance[anywhere], error[anywhere], perhaps[anywhere] = 0, np.inf, True
    surely[nowhere | anywhere] = False
    return RayTimes(distance, error, surely, perhaps)


def check_hit(times, face, distance, barycentric, limit=np.inf, mask=None, none=0xFFFFFFFF):
    """Asserts that this is where a ray first meets the mesh; times: its RayTimes (F,)."""
    counts = np.ones(len(times.surely), bool) if mask is None else mask
    surely = times.surely & counts
    if face == none:
        assert not surely.any(), "the ray meets face %d" % np.flatnonzero(surely)[0]
        assert distance == np.inf and not np.any(barycentric)
        return
    assert counts[face] and times.perhaps[face]
    assert 0 <= distance <= limit
    assert np.isinf(times.error[face]) or abs(times.distance[face] - distance) <= times.error[face]
    nearer = surely & (times.distance + times.error < distance)
    assert not nearer.any(), "face %d is nearer" % np.flatnonzero(nearer)[0]
    assert np.min(barycentric) >= 0 and abs(np.sum(barycentric) - 1) < 1e-9


class PointSides(NamedTuple):
    """What every point has to know of the faces: lists of vectors (3, F), and (F,)."""

    corners: list
    sides: list
    squares: list
    inwards: list
    unit: np.ndarray
    has_normal: np.ndarray


@lru_cache(maxsize=100)
def point_sides(mesh):
    a, b, c = (np.ascontiguousarray(corner.T) for corner in corners_of(mesh))
    sides = [b - a, c - b, a - c]
    squares = [dot(side, side) for side in sides]
    normal = cross(b - a, c - a)
    norm = length(normal)
    unit = normal / np.where(norm > 0, norm, 1)
    return PointSides(
        corners=[a, b, c],
        sides=sides,
        squares=[np.where(square > 0, square, 1) for square in squares],
        inwards=[cross(unit, side) for side in sides],
        unit=unit,
        has_normal=norm > 0,
    )


def distances_to_faces(mesh, points):
    """(N, F) distances of points (N, 3) to every face, by the regions of the triangle; another way
    than the kernel's.
    """
    sides = point_sides(mesh)
    points = np.asarray(points, np.float64)
    return np.concatenate(in_steps(mesh, lambda rows: _distances_to_faces(sides, rows), points))


def _distances_to_faces(faces, points):
    points = points.T[:, :, None]
    best, above = np.inf, faces.has_normal
    for k, corner in enumerate(faces.corners):
        away, side = points - corner[:, None], faces.sides[k][:, None]
        t = np.clip(dot(away, side) / faces.squares[k], 0, 1)
        best = np.minimum(best, length(away - t * side))
        above = above & (dot(away, faces.inwards[k][:, None]) >= 0)
    height = np.abs(dot(points - faces.corners[0][:, None], faces.unit[:, None]))
    return np.where(above, np.minimum(best, height), best)


def needle_doubts(mesh):
    """How far the foot on a face may be wrong: on a needle, whose normal is rounded away, by up to
    its width.
    """
    a, b, c = corners_of(mesh)
    longest = np.max([np.linalg.norm(q - p, axis=1) for p, q in ((a, b), (b, c), (c, a))], 0)
    twice_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    width = twice_area / np.where(longest > 0, longest, 1)
    return np.minimum(width, 1e-14 * longest**2 / np.where(width > 0, width, 1))


def normals_within(mesh, direction, max_angle):
    """Faces whose normal is within an angle of a direction."""
    a, b, c = corners_of(mesh)
    normal = np.cross(b - a, c - a)
    norm = np.linalg.norm(normal, axis=1)
    size = np.linalg.norm(b - a, axis=1) * np.linalg.norm(c - a, axis=1)
    has_normal = norm > 1e-12 * size
    cosine = normal @ (direction / np.linalg.norm(direction)) / np.where(has_normal, norm, 1)
    angle = np.arccos(np.clip(cosine, -1, 1))
    doubt = 1e-6
    return Maybe(
        has_normal & (angle < max_angle - doubt), ~has_normal | (angle <= max_angle + doubt)
    )


def _scale(mesh):
    return 1e-12 * (1 + np.abs(mesh.vertices[mesh.faces]).max())


def in_ball(mesh, center, radius, inside=False):
    """Faces that touch a ball, or are in it."""
    doubt = 10 * _scale(mesh) + 1e-12 * np.abs(center).max()
    if inside:
        corners = np.stack(corners_of(mesh), 1)
        reach = np.linalg.norm(corners - center, axis=2).max(1)
    else:
        reach = distances_to_faces(mesh, [center])[0]
    return Maybe(reach < radius - doubt, reach <= radius + doubt)


def clipped(polygons, planes):
    """What half-spaces leave of convex polygons (M, N, D); planes (P, D + 1), or (M, P, D + 1) for
    each its own.

    Returns corners (M, K, D), of which the first counts (M,) are meant.
    """
    polygons = np.asarray(polygons, np.float64)
    planes = np.broadcast_to(planes, (len(polygons), *np.shape(planes)[-2:]))
    counts = np.full(len(polygons), polygons.shape[1])
    for k in range(planes.shape[1]):
        some = np.flatnonzero(counts)
        if not len(some):
            break
        left, left_counts = _clipped_once(polygons[some], counts[some], planes[some, k])
        polygons = np.zeros((len(polygons), *left.shape[1:]))
        polygons[some], counts[some] = left, left_counts
    return polygons, counts


def _clipped_once(polygons, counts, planes):
    """The same by one plane for each polygon."""
    sides = np.einsum("mnd,md->mn", polygons, planes[:, :-1]) + planes[:, -1:]
    number = np.arange(polygons.shape[1])
    there = number < counts[:, None]
    following = np.where(number + 1 < counts[:, None], number + 1, 0)
    after = np.take_along_axis(polygons, following[:, :, None], 1)
    sides_after = np.take_along_axis(sides, following, 1)
    keeps, cuts = there & (sides >= 0), there & ((sides < 0) != (sides_after < 0))
    share = sides / np.where(cuts, sides - sides_after, 1)
    points = np.stack([polygons, polygons + (after - polygons) * share[:, :, None]], 2)
    points = points.reshape(len(polygons), -1, polygons.shape[2])
    chosen = np.stack([keeps, cuts], 2).reshape(len(polygons), -1)
    order = np.argsort(~chosen, 1, kind="stable")[:, : chosen.sum(1).max(initial=0)]
    return np.take_along_axis(points, order[:, :, None], 1), chosen.sum(1)


def unit_planes(planes):
    planes = np.asarray(planes, np.float64)
    return planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)


def in_planes(mesh, planes, inside=False):
    """Faces that touch the inner side of all planes, or are there."""
    planes = unit_planes(planes)
    corners = np.stack(corners_of(mesh), 1)
    sides = corners @ planes[:, :3].T + planes[:, 3]
    doubt = 10 * _scale(mesh) + 1e-12 * np.abs(planes[:, 3]).max()
    if inside:
        return Maybe((sides > doubt).all((1, 2)), (sides >= -doubt).all((1, 2)))
    result = []
    for shift in (-doubt, doubt):
        moved = planes + [0, 0, 0, shift]
        touching = (sides + shift >= 0).all(2).any(1)
        possible = (sides + shift >= 0).any(1).all(1) & ~touching
        touching[possible] = clipped(corners[possible], moved)[1] > 0
        result.append(touching)
    return Maybe(*result)


def outline_of(polygon):
    """Beginnings and ends (..., 1, K) of the sides of polygons (..., K, 2): x, y, and again."""
    ends = np.roll(polygon, -1, -2)
    return (array[..., None, :, k] for array in (polygon, ends) for k in range(2))


def points_in_polygon(points, polygon):
    """Even-odd rule, for points (..., N, 2) and polygons (..., K, 2)."""
    ax, ay, bx, by = outline_of(np.asarray(polygon, np.float64))
    x, y = (np.asarray(points, np.float64)[..., None, k] for k in range(2))
    crosses = (ay > y) != (by > y)
    at = ax + (y - ay) / np.where(by == ay, 1, by - ay) * (bx - ax)
    return (crosses & (x < at)).sum(-1) % 2 == 1


def distances_to_outline(points, polygon):
    """Distances of points (..., N, 2) to the sides of polygons (..., K, 2)."""
    ax, ay, bx, by = outline_of(polygon)
    x, y, dx, dy = points[..., None, 0] - ax, points[..., None, 1] - ay, bx - ax, by - ay
    t = np.clip((x * dx + y * dy) / np.maximum(dx * dx + dy * dy, 1e-300), 0, 1)
    return np.sqrt((x - t * dx) ** 2 + (y - t * dy) ** 2).min(-1)


def _cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _outlines_cross(shapes, polygon):
    """(G,) whether sides of polygons (G, N, 2) and of another (K, 2) surely cross."""
    p, r = shapes[:, :, None], (np.roll(shapes, -1, 1) - shapes)[:, :, None]
    q, s = polygon, np.roll(polygon, -1, 0) - polygon
    cross_rs = _cross(r, s)
    with np.errstate(all="ignore"):
        t, u = _cross(q - p, s) / cross_rs, _cross(q - p, r) / cross_rs
    lengths = np.linalg.norm(r, axis=-1) * np.linalg.norm(s, axis=-1)
    proper = np.abs(cross_rs) > 1e-6 * lengths
    inner = (np.minimum(t, u) > 1e-6) & (np.maximum(t, u) < 1 - 1e-6)
    return (proper & inner).any((1, 2))


def _gap(shapes, polygon):
    """(G,) distances of the outlines of polygons (G, N, 2), (K, 2) that do not cross."""
    return np.minimum(
        distances_to_outline(shapes, polygon).min(-1), distances_to_outline(polygon, shapes).min(-1)
    )


@lru_cache(maxsize=None)
def _sample_weights(face, count):
    """40 random points of a polygon with so many corners, and its middle."""
    weights = np.random.default_rng(face).dirichlet(np.ones(count), 40)
    return np.concatenate([weights, np.full((1, count), 1 / count)])


def in_lasso(mesh, polygon, view_projection):
    """Faces that touch what a camera sees within a polygon (normalized device coordinates)."""
    polygon = np.asarray(polygon, np.float64)
    corners = np.stack(corners_of(mesh), 1)
    clip = np.concatenate([corners, np.ones((*corners.shape[:2], 1))], 2) @ view_projection.T
    near_and_far = np.array([[0, 0, 1, 1, 0], [0, 0, -1, 1, 0]], np.float64)
    left, counts = clipped(clip, near_and_far)
    there = np.arange(left.shape[1]) < counts[:, None]
    seen = (counts > 0) & ~((left[:, :, 3] <= 1e-9) & there).any(1)
    sides = np.abs(clip[:, :, 2:3] + np.array([1, -1]) * clip[:, :, 3:4]).min((1, 2))
    surely, perhaps = np.zeros(len(clip), bool), ~seen & ((counts > 0) | (sides < 1e-9))
    for count in np.unique(counts[seen]):
        faces = np.flatnonzero(seen & (counts == count))
        surely[faces], perhaps[faces] = _shapes_in_polygon(faces, left[faces, :count], polygon)
    return Maybe(surely, perhaps)


def _shapes_in_polygon(faces, left, polygon):
    """What is sure and what may be of faces of which a camera sees this (G, N, 4)."""
    shapes, depths = left[:, :, :2] / left[:, :, 3:], left[:, :, 2] / left[:, :, 3]
    samples = np.stack([_sample_weights(face, left.shape[1]) for face in faces.tolist()]) @ shapes
    deep = distances_to_outline(samples, polygon) > 1e-9
    thick = np.ptp(depths, axis=1) > 1e-9
    thick |= np.abs(np.abs(depths) - 1).min(1) > 1e-9
    inner = (points_in_polygon(samples, polygon) & deep).any(1)
    crossing = _outlines_cross(shapes, polygon)
    within = points_in_polygon(shapes, polygon).any(1) | points_in_polygon(polygon, shapes).any(1)
    surely = thick & (inner | crossing)
    return surely, surely | within | crossing | (_gap(shapes, polygon) < 1e-9)


def sample_points(corners):
    """The four points of faces (3 corners, ...) that tell whether a face is seen."""
    a, b, c = corners
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    return [(a + b + c) / 3, (a + ab + ca) / 3, (b + bc + ab) / 3, (c + ca + bc) / 3]


def seen_from(mesh, eye, touching, contains):
    """Of some faces, those that are seen; contains(points) tells which points are in the region.

    Where no sample point is in the region, nothing is sure.
    """
    surely, perhaps = np.zeros((2, len(mesh.faces)), bool)
    corners = np.stack(corners_of(mesh), 1)[touching]
    if not len(corners):
        return Maybe(surely, perhaps)
    points = np.stack(sample_points(np.moveaxis(corners, 1, 0)), 1).reshape(-1, 3)
    own, chosen = np.repeat(touching, 4), contains(points)
    perhaps[touching] = ~chosen.reshape(-1, 4).any(1)
    points, own = points[chosen], own[chosen]
    gap = np.linalg.norm(points - eye, axis=1)
    times = ray_times(
        mesh, np.broadcast_to(eye, points.shape), points - eye, np.full(len(gap), np.inf)
    )
    doubt = (1e-6 * (1 + gap) + 3e-7 * np.abs(points).max(1, initial=0))[
        :, None
    ]  # neighboring floats
    before, behind = times.distance < gap[:, None] - doubt, times.distance > gap[:, None] + doubt
    others = times.perhaps & ~behind
    others[np.arange(len(own)), own] = False
    surely[own[~others.any(1)]] = True
    perhaps[own[~(times.surely & before).any(1)]] = True
    return Maybe(surely, surely | perhaps)

"""Geometry in NumPy, double precision, face by face: what the spatial index has to find.

Rounding leaves a doubt where a query just touches something. So predicates come in pairs: what is
surely true, and what may be true. What is found has to lie between.
"""

from typing import NamedTuple

import numpy as np


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


class RayTimes(NamedTuple):
    """Distances to the faces, how wrong they may be, and whether the ray hits them."""

    distance: np.ndarray
    error: np.ndarray
    surely: np.ndarray
    perhaps: np.ndarray


@np.errstate(all="ignore")
def ray_times(mesh, origin, direction, max_distance=np.inf, cull_back_faces=False):
    """By Moeller and Trumbore: Fast, Minimum Storage Ray/Triangle Intersection, 1997.

    From so far away that squares overflow, nothing is sure.
    """
    a, b, c = corners_of(mesh)
    count = len(a)
    largest = np.abs(direction).max()
    nothing = np.zeros(count, bool)
    if not (np.isfinite(origin).all() and np.isfinite(direction).all() and largest > 0):
        return RayTimes(np.full(count, np.inf), np.zeros(count), nothing, nothing)
    if not max_distance >= 0:
        return RayTimes(np.full(count, np.inf), np.zeros(count), nothing, nothing)
    if np.abs(origin).max() > 1e100:
        return RayTimes(np.zeros(count), np.full(count, np.inf), nothing, ~nothing)
    way = np.asarray(direction) / largest
    way = way / np.linalg.norm(way)
    u_edge, v_edge, start = b - a, c - a, origin - a
    cross_v, cross_u = np.cross(way, v_edge), np.cross(start, u_edge)
    determinant = np.sum(u_edge * cross_v, 1)
    lengths = [np.linalg.norm(side, axis=1) for side in (u_edge, v_edge, start)]
    scale = np.abs(a).max(1) + np.abs(b).max(1) + np.abs(c).max(1) + np.abs(origin).max()
    rounding = 1e-14 * (scale + lengths[2])
    size = np.maximum(lengths[0], lengths[1])
    flat = np.abs(determinant) <= 1e-13 * lengths[0] * lengths[1]
    divisor = np.where(flat, 1.0, determinant)
    u = np.sum(start * cross_v, 1) / divisor
    v = np.sum(way * cross_u, 1) / divisor
    distance = np.sum(v_edge * cross_u, 1) / divisor
    # weights are areas seen along the ray, divided by that of the face
    doubt = (1e-13 * lengths[2] * size + rounding * (size + lengths[2])) / np.abs(divisor) + 1e-13
    margin = np.minimum(np.minimum(u, v), 1 - u - v)
    error = 10 * doubt * size + rounding
    front = determinant > 0
    side = front if cull_back_faces else ~flat
    reach = (distance >= -error) & (distance <= max_distance + error)
    inner = (distance >= error) & (distance <= max_distance - error)
    surely = ~flat & side & (margin > doubt) & inner
    perhaps = flat & (np.linalg.norm(u_edge, axis=1) + lengths[1] > 0)
    perhaps = np.where(flat, perhaps, side & (margin >= -doubt) & reach)
    return RayTimes(distance, np.where(flat, np.inf, error), surely, perhaps)


def check_hit(mesh, ray, face, distance, barycentric, mask=None, none=0xFFFFFFFF):
    """Asserts that this is where a ray (arguments of ray_times()) first meets the mesh."""
    times = ray_times(mesh, *ray)
    counts = np.ones(len(mesh.faces), bool) if mask is None else mask
    surely = times.surely & counts
    if face == none:
        assert not surely.any(), "the ray meets face %d" % np.flatnonzero(surely)[0]
        assert distance == np.inf and not np.any(barycentric)
        return
    assert counts[face] and times.perhaps[face]
    assert 0 <= distance <= (ray[2] if len(ray) > 2 else np.inf)
    assert np.isinf(times.error[face]) or abs(times.distance[face] - distance) <= times.error[face]
    nearer = surely & (times.distance + times.error < distance)
    assert not nearer.any(), "face %d is nearer" % np.flatnonzero(nearer)[0]
    assert np.min(barycentric) >= 0 and abs(np.sum(barycentric) - 1) < 1e-9


def distances_to_faces(mesh, point):
    """Distance to every face, by the regions of the triangle; another way than the kernel's."""
    a, b, c = corners_of(mesh)
    best = np.full(len(mesh.faces), np.inf)
    for p, q in ((a, b), (b, c), (c, a)):
        side = q - p
        length = np.sum(side * side, 1)
        t = np.sum((point - p) * side, 1) / np.where(length > 0, length, 1)
        foot = p + np.clip(t, 0, 1)[:, None] * side
        best = np.minimum(best, np.linalg.norm(point - foot, axis=1))
    normal = np.cross(b - a, c - a)
    norm = np.linalg.norm(normal, axis=1)
    unit = normal / np.where(norm > 0, norm, 1)[:, None]
    height = np.sum((point - a) * unit, 1)
    foot = point - height[:, None] * unit
    turns = [np.sum(np.cross(q - p, foot - p) * unit, 1) for p, q in ((a, b), (b, c), (c, a))]
    above = (norm > 0) & (np.min(turns, 0) >= 0)
    return np.where(above, np.minimum(best, np.abs(height)), best)


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
        reach = distances_to_faces(mesh, np.asarray(center, np.float64))
    return Maybe(reach < radius - doubt, reach <= radius + doubt)


def clipped(polygon, planes):
    """What half-spaces leave of a convex polygon (N, D); planes (P, D + 1)."""
    for plane in planes:
        if not len(polygon):
            break
        side = polygon @ plane[:-1] + plane[-1]
        after, side_after = np.roll(polygon, -1, 0), np.roll(side, -1)
        parts = []
        for p, q, s, t in zip(polygon, after, side, side_after):
            if s >= 0:
                parts.append(p)
            if (s < 0) != (t < 0):
                parts.append(p + (q - p) * (s / (s - t)))
        polygon = np.array(parts).reshape(-1, polygon.shape[1])
    return polygon


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
        for face in np.flatnonzero(possible):
            touching[face] = len(clipped(corners[face], moved)) > 0
        result.append(touching)
    return Maybe(*result)


def points_in_polygon(points, polygon):
    """Even-odd rule, for points (N, 2)."""
    x, y = np.asarray(points, np.float64).T
    inside = np.zeros(len(x), bool)
    for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, 0)):
        crosses = (ay > y) != (by > y)
        at = ax + (y - ay) / np.where(by == ay, 1, by - ay) * (bx - ax)
        inside ^= crosses & (x < at)
    return inside


def distances_to_outline(points, polygon):
    """Distances of points (N, 2) to the sides of a polygon."""
    best = np.full(len(points), np.inf)
    for a, b in zip(polygon, np.roll(polygon, -1, 0)):
        side = b - a
        t = np.clip((points - a) @ side / max(side @ side, 1e-300), 0, 1)
        best = np.minimum(best, np.linalg.norm(points - a - t[:, None] * side, axis=1))
    return best


def _cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _outlines_cross(one, other):
    """Whether sides of two polygons surely cross."""
    p, r = one[:, None], (np.roll(one, -1, 0) - one)[:, None]
    q, s = other[None], (np.roll(other, -1, 0) - other)[None]
    cross = _cross(r, s)
    with np.errstate(all="ignore"):
        t, u = _cross(q - p, s) / cross, _cross(q - p, r) / cross
    lengths = np.linalg.norm(r, axis=2) * np.linalg.norm(s, axis=2)
    proper = np.abs(cross) > 1e-6 * lengths
    return bool(np.any(proper & (np.minimum(t, u) > 1e-6) & (np.maximum(t, u) < 1 - 1e-6)))


def _gap(one, other):
    """Distance of the outlines of two polygons that do not cross."""
    return min(distances_to_outline(one, other).min(), distances_to_outline(other, one).min())


def in_lasso(mesh, polygon, view_projection):
    """Faces that touch what a camera sees within a polygon (normalized device coordinates)."""
    polygon = np.asarray(polygon, np.float64)
    corners = np.stack(corners_of(mesh), 1)
    clip = np.concatenate([corners, np.ones((*corners.shape[:2], 1))], 2) @ view_projection.T
    near_and_far = np.array([[0, 0, 1, 1, 0], [0, 0, -1, 1, 0]], np.float64)
    surely, perhaps = np.zeros((2, len(corners)), bool)
    for face, triangle in enumerate(clip):
        left = clipped(triangle, near_and_far)
        if not len(left) or (left[:, 3] <= 1e-9).any():
            sides = triangle[:, 2] + np.array([[1], [-1]]) * triangle[:, 3]
            perhaps[face] = len(left) > 0 or np.abs(sides).min() < 1e-9
            continue
        shape = left[:, :2] / left[:, 3:]
        weights = np.random.default_rng(face).dirichlet(np.ones(len(shape)), 40)
        samples = np.concatenate([weights @ shape, shape.mean(0, keepdims=True)])
        deep = distances_to_outline(samples, polygon) > 1e-9
        depth = np.abs(np.abs(left[:, 2] / left[:, 3]) - 1)
        thick = np.ptp(left[:, 2] / left[:, 3]) > 1e-9 or depth.min() > 1e-9
        inner = (points_in_polygon(samples, polygon) & deep).any()
        surely[face] = thick and (inner or _outlines_cross(shape, polygon))
        within = points_in_polygon(shape, polygon).any() or points_in_polygon(polygon, shape).any()
        perhaps[face] = surely[face] or within or _gap(shape, polygon) < 1e-9
        perhaps[face] |= _outlines_cross(shape, polygon)
    return Maybe(surely, perhaps)


def sample_points(corners):
    """The points of a face that are looked at to tell whether it is seen."""
    a, b, c = corners
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    return np.array([corners.mean(0), (a + ab + ca) / 3, (b + bc + ab) / 3, (c + ca + bc) / 3])


def seen_from(mesh, eye, touching, contains):
    """Of some faces, those that are seen; contains(points) tells which points are in the region.

    Where no sample point is in the region, nothing is sure.
    """
    surely, perhaps = np.zeros((2, len(mesh.faces)), bool)
    corners = np.stack(corners_of(mesh), 1)
    for face in touching:
        points = sample_points(corners[face])
        points = points[contains(points)]
        if not len(points):
            perhaps[face] = True
        for point in points:
            gap = np.linalg.norm(point - eye)
            times = ray_times(mesh, eye, point - eye)
            doubt = 1e-6 * (1 + gap) + 3e-7 * np.abs(point).max()  # neighboring floats
            before, behind = times.distance < gap - doubt, times.distance > gap + doubt
            own = np.arange(len(corners)) == face
            surely[face] |= not (times.perhaps & ~behind & ~own).any()
            perhaps[face] |= not (times.surely & before).any()
    return Maybe(surely, surely | perhaps)

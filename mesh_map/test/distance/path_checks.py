"""What has to be true of every way down a potential."""

from typing import Any, NamedTuple

import numpy as np
from mesh_map.geometry.mesh_geometry import MeshGeometry
from meshes import TestMesh
from oracles import cross, dot, length


class FacePoint(NamedTuple):
    """A point of a surface, as planners have it."""

    face: int
    position: np.ndarray


class Field(NamedTuple):
    """A potential that no solver made."""

    labels: np.ndarray
    limit: float = np.inf
    slowness: Any = None
    goal_face: Any = None
    goal_position: Any = None


def geometry_of(mesh: TestMesh) -> MeshGeometry:
    return MeshGeometry(mesh.vertices, mesh.faces)


def with_noise(mesh: Any, noise: float, seed: int = 1) -> MeshGeometry:
    """A mesh with normally distributed errors (m) of all heights."""
    vertices = mesh.vertices.astype(np.float64)
    vertices[:, 2] += np.random.default_rng(seed).normal(0, noise, len(vertices))
    return MeshGeometry(vertices, mesh.faces)


def point_in(geometry: MeshGeometry, face: int, weights: Any) -> FacePoint:
    corners = geometry.vertices[geometry.faces[face]].astype(np.float64)
    return FacePoint(int(face), np.asarray(weights) @ corners)


def random_points(geometry: MeshGeometry, rng: Any, count: int, eligible: Any = None):
    """Points in faces of the largest component, of which all corners are eligible ((V,) bool)."""
    components = geometry.topology.components[geometry.faces[:, 0]]
    allowed = components == np.bincount(components).argmax()
    if eligible is not None:
        allowed &= eligible[geometry.faces].all(axis=1)
    faces = rng.choice(np.flatnonzero(allowed), count)
    weights = rng.dirichlet([1, 1, 1], count)
    return [point_in(geometry, face, w) for face, w in zip(faces, weights)]


def off_surface(geometry: MeshGeometry, path: Any) -> float:
    """The most by which an end of a segment is off its face, in the plane or out of it (m)."""
    corners = geometry.vertices[geometry.faces[path.faces]].astype(np.float64)
    a, b, c = np.moveaxis(corners, (1, 2), (0, 1))
    normal = cross(b - a, c - a)
    size = length(normal)
    has_area = size > 1e-9
    a, b, c = a[:, has_area], b[:, has_area], c[:, has_area]
    normal = normal[:, has_area] / size[has_area]
    ends = np.stack([path.points[:-1][has_area].T, path.points[1:][has_area].T], 1)
    worst = np.abs(dot(ends - a[:, None], normal)).max(initial=0.0)
    for p, q in ((a, b), (b, c), (c, a)):
        inwards = cross(normal, q - p)
        beyond = -dot(ends - p[:, None], inwards) / length(inwards)
        worst = max(worst, beyond.max(initial=0.0))
    return worst


def check_path(geometry: MeshGeometry, field: Any, start: Any, path: Any) -> None:
    """It starts and ends exactly, stays on the surface, falls, and enters no closed face."""
    assert len(path.points) == len(path.potentials) == len(path.faces) + 1
    assert np.array_equal(path.points[0], start.position) or len(path.points) == 1
    if field.goal_face is not None:
        assert np.array_equal(path.points[-1], field.goal_position)
        assert path.potentials[-1] == 0.0
    assert (np.diff(path.potentials) < 0.0).all()
    assert off_surface(geometry, path) < 1e-8
    if field.slowness is not None:
        closed = ~np.isfinite(field.slowness)
        middles = 0.5 * (path.points[1:] + path.points[:-1])
        for i in np.flatnonzero(closed[geometry.faces[path.faces]].any(axis=1)):
            corners = geometry.faces[path.faces[i]]
            ends = geometry.vertices[corners[~closed[corners]]].astype(np.float64)
            assert len(ends) == 2 and path.faces[i] not in (start.face, field.goal_face)
            side = ends[1] - ends[0]
            off = np.cross(middles[i] - ends[0], side) / np.linalg.norm(side)
            assert np.linalg.norm(off) < 1e-6

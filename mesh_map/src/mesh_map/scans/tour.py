"""Drives over a mesh: where a robot can be, a tour over it, and its poses on the way."""

from typing import Any, List, Optional

import numpy as np

from mesh_map.base.array_checks import read_only
from mesh_map.base.errors import MeshMapError
from mesh_map.distance.obstacle_distance import ObstacleDistance, SurfaceFront
from mesh_map.distance.surface_path import FieldTracer
from mesh_map.distance.wave_front import WaveFrontSolver
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.topology import Topology
from mesh_map.scans.trajectory import Trajectory, quaternions_of

MAX_SLOPE = 0.6  # rad
RADIUS = 0.4  # m, of the robot
HEADROOM = 1.5  # m
MAX_OFFSET = 1.0  # m from a waypoint to where a robot can be
_ABOVE = 0.2  # m: what is lower over the ground than this is ground, too
_STEP = 0.05  # m between poses of a drive
_WHEELBASE = 0.3  # m, standard deviation of the Gaussian that takes bumps out of a drive
_TRIES = 64  # vertices among which a waypoint is chosen


def drivable_vertices(
    geometry: MeshGeometry,
    *,
    max_slope: float = MAX_SLOPE,
    radius: float = RADIUS,
    headroom: float = HEADROOM,
) -> np.ndarray:
    """(V,) bool: the largest connected region where a robot can be.

    The ground is as steep there as `max_slope` (rad) at most, its normals smoothed over half of
    `radius`; nothing is above it up to `headroom` (m); and what is otherwise, as the border of the
    mesh, is `radius` (m) away, measured over the surface. Faces have to look up.

    Raises:
        MeshMapError: there is no such place.
    """
    topology, up = geometry.topology, geometry.up
    steep = _smoothed_normals(geometry, radius / 2) @ up < np.cos(max_slope)
    low = geometry.spatial_index.any_hit_batch(
        origins=geometry.vertices + _ABOVE * up,
        directions=np.broadcast_to(up, geometry.vertices.shape),
        max_distance=max(headroom - _ABOVE, 0.0),
        back_end="native",
    )
    closed = steep | low
    closed[topology.edges[topology.border_edges].ravel()] = True
    distance = ObstacleDistance(front=SurfaceFront.of(geometry), max_distance=radius)
    distance.compute(closed)
    free = ~(distance.distances() <= radius)
    faces = geometry.faces[free[geometry.faces].all(axis=1)]
    if not len(faces):
        text = "a robot can be nowhere on this mesh of %d faces" % len(geometry.faces)
        hint = "a smaller radius, a higher max_slope, or faces that look up: orient=True"
        raise MeshMapError(text, hint)
    components = Topology(faces=faces, vertex_count=len(free)).components
    used = np.unique(faces)
    largest = np.bincount(components[used]).argmax()
    result = np.zeros(len(free), bool)
    result[used[components[used] == largest]] = True
    return result


def _smoothed_normals(geometry: MeshGeometry, radius: float) -> np.ndarray:
    """(V, 3) of length 1: means over neighbors, again and again, until they reach that far."""
    edges, normals = geometry.topology.edges, geometry.vertex_normals.astype(np.float64)
    length = float(np.median(geometry.edge_lengths))
    # As a random walk: `rounds` steps of an edge lead sqrt(rounds) edges away.
    rounds = min(int((radius / length) ** 2), 50) if length > 0 else 0
    for _ in range(rounds):
        sums = normals.copy()
        for first, second in (edges.T, edges.T[::-1]):
            for axis in range(3):
                sums[:, axis] += np.bincount(first, normals[second, axis], len(normals))
        lengths = np.linalg.norm(sums, axis=1, keepdims=True)
        normals = np.where(lengths > 0, sums / np.where(lengths > 0, lengths, 1.0), normals)
    return normals


def tour_waypoints(
    geometry: MeshGeometry, drivable: np.ndarray, count: int, seed: int = 0
) -> np.ndarray:
    """(count, 3) m: vertices far from each other, in an order that makes a short round.

    Args:
        geometry: the mesh.
        drivable: (V,) bool, the vertices among which they are.
        count: of them, at least 2.
        seed: of the choice.
    """
    random = np.random.default_rng(seed)
    places = geometry.vertices[drivable].astype(np.float64)
    chosen = places[random.integers(len(places), size=1)]
    while len(chosen) < max(count, 2):
        tries = places[random.integers(len(places), size=_TRIES)]
        away = np.linalg.norm(tries[:, None] - chosen[None], axis=2).min(axis=1)
        chosen = np.concatenate([chosen, tries[away.argmax()][None]])
    return chosen[_short_round(chosen)]


def _short_round(points: np.ndarray) -> np.ndarray:
    """The order of a round through points that no exchange of two of its legs makes shorter
    (2-opt; Croes, A method for solving traveling-salesman problems, 1958)."""
    away = np.linalg.norm(points[:, None] - points[None], axis=2)
    order, count = np.arange(len(points)), len(points)
    shorter = True
    while shorter:
        shorter = False
        for i in range(count - 1):
            for j in range(i + 2, count - (i == 0)):
                a, b, c, d = order[i], order[i + 1], order[j], order[(j + 1) % count]
                if away[a, c] + away[b, d] < away[a, b] + away[c, d] - 1e-9:
                    order[i + 1 : j + 1] = order[i + 1 : j + 1][::-1]
                    shorter = True
    return order


def route(
    geometry: MeshGeometry, waypoints: Any, drivable: np.ndarray, *, back: bool = False
) -> np.ndarray:
    """(N, 3) float64 m: the shortest path over drivable ground through waypoints, in their order.

    Args:
        geometry: the mesh.
        waypoints: (K, 3) m, K >= 2; each stands for the drivable vertex that is nearest.
        drivable: (V,) bool.
        back: whether it ends where it begins.

    Raises:
        MeshMapError: a waypoint with no drivable vertex within 1 m, or no path to it.
    """
    places = np.asarray(waypoints, np.float64)
    if places.ndim != 2 or places.shape[1] != 3 or len(places) < 2 or not np.isfinite(places).all():
        text = "waypoints of the shape %s" % (places.shape,)
        raise MeshMapError(text, "at least two of three finite numbers x, y, z (m) are needed")
    vertices = [_nearest(geometry, place, drivable) for place in places]
    if back:
        vertices.append(vertices[0])
    slowness = read_only(np.where(drivable, 1.0, np.inf).astype(np.float32))
    solver, tracer = WaveFrontSolver.of(geometry), FieldTracer.of(geometry)
    points: List[np.ndarray] = [geometry.vertices[vertices[:1]].astype(np.float64)]
    for number, (start, goal) in enumerate(zip(vertices, vertices[1:]), 1):
        if start == goal:
            continue
        field = solver.solve(goal, slowness=slowness, targets=[start], offset=1.0)
        path = tracer.path(field, _Place(geometry, start, drivable))
        if path is None:
            text = "there is no path over drivable ground to waypoint %d at %s m"
            place = geometry.vertices[goal].round(2).tolist()
            hint = "leave it out, or allow a higher max_slope or a smaller radius"
            raise MeshMapError(text % (number, place), hint)
        points.append(path.points[1:])
    return np.concatenate(points)


def _nearest(geometry: MeshGeometry, place: np.ndarray, drivable: np.ndarray) -> int:
    candidates = np.flatnonzero(drivable)
    away = np.linalg.norm(geometry.vertices[candidates] - place, axis=1)
    best = away.argmin()
    if away[best] > MAX_OFFSET:
        text = "the waypoint %s is %.2f m from where a robot can be" % (
            place.round(2).tolist(),
            away[best],
        )
        raise MeshMapError(text, "at most %g m are allowed: move it" % MAX_OFFSET)
    return int(candidates[best])


class _Place:
    """A vertex as a point of a face whose corners are drivable."""

    def __init__(self, geometry: MeshGeometry, vertex: int, drivable: np.ndarray) -> None:
        faces = geometry.topology.faces_of(vertex)
        is_open = drivable[geometry.faces[faces]].all(axis=1)
        self.face = int(faces[is_open.argmax()])
        self.position = geometry.vertices[vertex].astype(np.float64)


def drive(
    geometry: MeshGeometry,
    points: Any,
    *,
    speed: float = 1.0,
    turn_speed: float = 1.0,
    begin: float = 0.0,
) -> Trajectory:
    """Poses of a robot that drives along a path: x ahead, z along the normal of the ground.

    Bumps and corners that are small against the robot are smoothed away.

    Args:
        geometry: the mesh.
        points: (N, 3) m on it, N >= 2, from waypoint to waypoint of a path.
        speed: m/s; turn_speed: rad/s. Whichever of the two takes longer counts.
        begin: s of the first pose.

    Raises:
        MeshMapError: a path without length, or speeds that are not above 0.
    """
    if not (0 < speed < np.inf and 0 < turn_speed < np.inf):
        text = "a drive with %s m/s and %s rad/s" % (speed, turn_speed)
        raise MeshMapError(text, "finite numbers above 0 are needed")
    places = _resampled(np.asarray(points, np.float64))
    found = geometry.spatial_index.closest_batch(points=places, back_end="native")
    up = _smoothed(geometry.face_normals[found.faces].astype(np.float64), pinned=False)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    places = _smoothed(places, pinned=True)
    ahead = np.gradient(places, axis=0)
    left = np.cross(up, ahead)
    lengths = np.linalg.norm(left, axis=1)
    # Where a drive turns round on the spot, it has no direction: it keeps the one before.
    good = np.flatnonzero(lengths > 1e-3 * _STEP)
    if not len(good):
        raise MeshMapError("a path that leads nowhere but up or down", "give other waypoints")
    last = good[np.maximum(np.searchsorted(good, np.arange(len(left)), "right") - 1, 0)]
    left = left[last] - np.sum(left[last] * up, axis=1)[:, None] * up
    left /= np.linalg.norm(left, axis=1, keepdims=True)
    turns = np.stack([np.cross(left, up), left, up], axis=2)
    orientations = quaternions_of(turns)
    moved = np.linalg.norm(np.diff(places, axis=0), axis=1)
    cosine = abs(np.sum(orientations[1:] * orientations[:-1], axis=1))
    turned = 2 * np.arccos(np.minimum(cosine, 1.0))
    seconds = np.maximum(np.maximum(moved / speed, turned / turn_speed), 1e-6)
    times = begin + np.concatenate([[0.0], np.cumsum(seconds)])
    return Trajectory(times, places, orientations)


def _resampled(points: np.ndarray) -> np.ndarray:
    """Points along a polyline, its ends among them, about _STEP apart."""
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2:
        raise MeshMapError("a path of the shape %s" % (points.shape,), "(N, 3), N >= 2, is needed")
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    if not 0 < along[-1] < np.inf:
        raise MeshMapError("a path of %s m" % along[-1], "give waypoints that are apart")
    wanted = np.linspace(0.0, along[-1], max(2, int(round(along[-1] / _STEP))) + 1)
    return np.stack([np.interp(wanted, along, points[:, axis]) for axis in range(3)], axis=1)


def _smoothed(rows: np.ndarray, pinned: bool) -> np.ndarray:
    """(N, 3) rows smoothed along the drive; pinned: the first and the last one stay."""
    reach = min(int(3 * _WHEELBASE / _STEP), len(rows) - 1)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) * _STEP / _WHEELBASE) ** 2)
    before, after = rows[reach:0:-1], rows[-2 : -reach - 2 : -1]
    if pinned:  # mirrored at the ends, which so are the mean of what is around them
        before, after = 2 * rows[0] - before, 2 * rows[-1] - after
    padded = np.concatenate([before, rows, after])
    weights /= weights.sum()
    columns = [np.convolve(padded[:, axis], weights, "valid") for axis in range(rows.shape[1])]
    return np.stack(columns, axis=1)


def tour(
    geometry: MeshGeometry,
    *,
    waypoints: Optional[Any] = None,
    count: int = 8,
    seed: int = 0,
    speed: float = 1.0,
    begin: float = 0.0,
    max_slope: float = MAX_SLOPE,
    radius: float = RADIUS,
    headroom: float = HEADROOM,
) -> Trajectory:
    """Poses of a robot that drives over a mesh, ever forwards; the same arguments, the same drive.

    Args:
        geometry: the mesh.
        waypoints: (K, 3) m that it drives through; None: `count` of its own, and back to the first.
        count, seed: see tour_waypoints().
        speed, begin: see drive().
        max_slope, radius, headroom: see drivable_vertices().

    Raises:
        MeshMapError: nowhere to drive, waypoints that cannot be reached.
    """
    drivable = drivable_vertices(geometry, max_slope=max_slope, radius=radius, headroom=headroom)
    own = waypoints is None
    places = tour_waypoints(geometry, drivable, count, seed) if own else waypoints
    return drive(geometry, route(geometry, places, drivable, back=own), speed=speed, begin=begin)

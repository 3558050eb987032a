"""Corners of paths, driven around at a distance."""

import numpy as np

from mesh_map.geometry import MeshGeometry
from mesh_map.hits import SurfacePoints

_REACH = 0.3  # m before and behind a place, between which the path bends there


def rounded(geometry: MeshGeometry, places: SurfacePoints, clearance: float) -> SurfacePoints:
    """Places of a path, those at bends moved outwards.

    Shortest paths touch what they go around, at the inner side of their bends: a hole, a slit, or
    where the next storey begins. Each place moves by the clearance times 2 sin(bend / 2), as far as
    there is surface; the first and the last stay.

    Args:
        geometry: of the map.
        places: (N) of the path, all on the map.
        clearance: m.
    """
    points = places.positions
    if len(points) < 3 or not clearance > 0.0:
        return places
    before, behind = _directions(points)
    outwards = before - behind
    bends = np.minimum(np.linalg.norm(outwards, axis=1), 1.0)
    bends[~(before.any(axis=1) & behind.any(axis=1))] = 0.0  # the ends, also where they repeat
    usable = np.flatnonzero(bends > 0.1)
    if not len(usable):
        return places
    walks = geometry.walker.walk_batch(
        starts=SurfacePoints(*(column[usable] for column in places)),
        lengths=clearance * bends[usable],
        directions=outwards[usable],
    )
    columns = [column.copy() for column in places[:3]]
    for column, moved in zip(columns, (walks.faces, walks.positions, walks.barycentric)):
        column[usable] = moved
    return SurfacePoints(*columns, places.distances)


def _directions(points: np.ndarray) -> tuple:
    """(N,3) unit vectors to each point from `_REACH` before it, and from it to as far behind."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    travelled = np.append(0.0, np.cumsum(steps))

    def at(lengths: np.ndarray) -> np.ndarray:
        return np.stack([np.interp(lengths, travelled, points[:, axis]) for axis in range(3)], 1)

    chords = points - at(travelled - _REACH), at(travelled + _REACH) - points
    return tuple(
        chord / np.maximum(np.linalg.norm(chord, axis=1, keepdims=True), 1e-9) for chord in chords
    )

"""Floors with things on them, each a surface of its own, as CAD, BIM and simulators have them.

Parts are pairs of vertices (V, 3) float64 in meters, z up, and faces (F, 3) that count these.
"""

from typing import Sequence, Tuple

import numpy as np

from mesh_msgs.world.zoo_mesh import grid_faces

Part = Tuple[np.ndarray, np.ndarray]


def floor(lower: Sequence[float], upper: Sequence[float], edge: float, level: float = 0.0) -> Part:
    """A level rectangle from `lower` to `upper` (x, y) of squares about `edge` long, cut in two."""
    ticks = [
        np.linspace(low, high, max(1, int(round((high - low) / edge))) + 1)
        for low, high in zip(lower, upper)
    ]
    x, y = np.meshgrid(*ticks, indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.full(x.size, float(level))], axis=1)
    return vertices, grid_faces(np.arange(x.size).reshape(x.shape))


def box(lower: Sequence[float], upper: Sequence[float], separate_sides: bool = False) -> Part:
    """A closed box of 12 faces that look outwards.

    Its sides share vertices, or have 24 of their own where they are separate.
    """
    bits = (np.arange(8)[:, None] >> np.arange(3)) & 1
    vertices = np.where(bits, np.asarray(upper, np.float64), np.asarray(lower, np.float64))
    sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    quads = np.array(sides)
    faces = np.stack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]], axis=1).reshape(-1, 3)
    return as_soup((vertices, faces), 2) if separate_sides else (vertices, faces)


def as_soup(part: Part, together: int = 1) -> Part:
    """The part where every `together` faces that follow each other have vertices of their own."""
    vertices, faces = part
    pieces = [
        (vertices[used], where.reshape(-1, 3))
        for used, where in (
            np.unique(faces[first : first + together], return_inverse=True)
            for first in range(0, len(faces), together)
        )
    ]
    return joined(*pieces)


def sheet(start: Sequence[float], end: Sequence[float], low: float, high: float) -> Part:
    """An upright rectangle of two faces above the line from `start` to `end` (x, y)."""
    vertices = [[*start, low], [*end, low], [*end, high], [*start, high]]
    return np.array(vertices, np.float64), np.array([[0, 1, 2], [0, 2, 3]])


def stairs(
    start: Sequence[float], width: float, tread: float, rise: float, count: int, edge: float
) -> Part:
    """A surface along +x from `start` (x, y, z): `count` steps, each a riser and a level tread.

    The treads are of squares about `edge` long; the risers are one quadrilateral high.
    """
    across = np.linspace(0.0, width, max(1, int(round(width / edge))) + 1)
    along = np.linspace(0.0, tread, max(1, int(round(tread / edge))) + 1)
    profile = [(0.0, 0.0)]
    for step in range(count):
        profile += [(step * tread + x, (step + 1) * rise) for x in along]
    x, z = np.array(profile).T
    vertices = np.stack(np.broadcast_arrays(x[:, None], across[None], z[:, None]), axis=2)
    index = np.arange(vertices.shape[0] * vertices.shape[1]).reshape(vertices.shape[:2])
    return vertices.reshape(-1, 3) + np.asarray(start, np.float64), grid_faces(index)


def flipped(part: Part) -> Part:
    """The part with faces that look the other way."""
    return part[0], part[1][:, ::-1]


def turned(part: Part, angle: float, axis: int, center: Sequence[float]) -> Part:
    """The part turned by `angle` radians about a line along an axis (0 to 2) through `center`."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    rotation = np.eye(3)
    rotation[[first, second], [first, second]] = np.cos(angle)
    rotation[first, second], rotation[second, first] = -np.sin(angle), np.sin(angle)
    return (part[0] - center) @ rotation.T + center, part[1]


def joined(*parts: Part) -> Part:
    """All parts as one mesh; none of their vertices become one."""
    counts = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    faces = [faces + count for (_, faces), count in zip(parts, counts)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces)


def welded(part: Part) -> Part:
    """The part with vertices at the same place (as float32) made one."""
    places, where = np.unique(part[0].astype(np.float32), axis=0, return_inverse=True)
    return places.astype(np.float64), where.reshape(-1)[part[1]]

"""A building as CAD exports it: two storeys with a ramp between them, of few large faces.

Only what can be stood on is there; where walls and pillars stand, and around the building, the
surface ends.
"""

from typing import List, Sequence, Tuple

import numpy as np

from mesh_msgs.world.solids import Part, joined, welded

Rectangle = Tuple[float, float, float, float]  # x, y from; x, y to (m)

LENGTH, WIDTH, HEIGHT = 36.0, 24.0, 3.2  # m
_WALL = 0.2  # m thick
RAMP: Rectangle = (10.0, 10.6, 22.0, 12.4)  # rises along x


def building() -> Part:
    """Vertices (V, 3) float64 in meters, z up, and faces (F, 3): about 300 of 1,700 m2."""
    lower, upper = walls()
    return welded(joined(storey(lower + [RAMP], 0.0), storey(upper + [RAMP], HEIGHT), ramp()))


def walls() -> Tuple[List[Rectangle], List[Rectangle]]:
    """Where walls and pillars stand, on the lower floor and on the upper one."""
    pillars = [(x, y, x + 0.5, y + 0.5) for x in (26.0, 29.5, 33.0) for y in (3.0, 9.5, 16.0, 21.5)]
    rooms = _walls_x(8.0, LENGTH - 12.0, 9.0, (3.4, 11.0, 17.3, 22.1)) + _walls_x(
        0.0, 24.0, 14.0, (4.0, 12.2, 20.0)
    )
    lower = rooms + pillars + _walls_y(8.0, 0.0, 9.0, (5.5,)) + _walls_y(24.0, 14.0, 24.0, (20.5,))
    lower += _walls_y(16.0, 14.0, 24.0, (22.6,))
    upper = (
        pillars + _walls_y(24.0, 0.0, 24.0, (2.2, 18.0)) + _walls_x(0.0, 24.0, 17.0, (7.0, 21.0))
    )
    return lower, upper


def ramp() -> Part:
    """From floor to floor: the lower one ends where it begins, the upper one is open above it."""
    x0, y0, x1, y1 = RAMP
    vertices = np.array([[x0, y0, 0.0], [x1, y0, HEIGHT], [x1, y1, HEIGHT], [x0, y1, 0.0]])
    return vertices, np.array([[0, 1, 2], [0, 2, 3]])


def storey(holes: Sequence[Rectangle], level: float) -> Part:
    """A level rectangle of LENGTH by WIDTH with holes, as few triangles as slabs between their
    sides need; neighbors share their vertices."""
    ticks = sorted({0.0, LENGTH, *(x for hole in holes for x in (hole[0], hole[2]))})
    slabs = [_free(holes, low, high) for low, high in zip(ticks, ticks[1:])]
    breaks = [
        sorted({y for slab in slabs[max(i - 1, 0) : i + 1] for span in slab for y in span})
        for i in range(len(ticks))
    ]
    points: List[Tuple[float, float]] = []
    number = {}
    for x, values in zip(ticks, breaks):
        for y in values:
            number[x, y] = len(points)
            points.append((x, y))
    faces = []
    for i, slab in enumerate(slabs):
        for low, high in slab:
            left = [number[ticks[i], y] for y in breaks[i] if low <= y <= high]
            right = [number[ticks[i + 1], y] for y in breaks[i + 1] if low <= y <= high]
            while len(left) > 1 or len(right) > 1:
                if len(left) == 1 or (len(right) > 1 and points[right[1]][1] <= points[left[1]][1]):
                    faces.append([left[0], right[0], right[1]])
                    right.pop(0)
                else:
                    faces.append([left[0], right[0], left[1]])
                    left.pop(0)
    vertices = np.array([(x, y, level) for x, y in points], np.float64)
    return vertices, np.array(faces)


def _free(holes: Sequence[Rectangle], low: float, high: float) -> List[Tuple[float, float]]:
    """What is free of holes between two x, as spans of y."""
    spans, y = [], 0.0
    for _, begin, _, end in sorted(
        (hole for hole in holes if hole[0] < high and hole[2] > low), key=lambda hole: hole[1]
    ):
        if begin > y:
            spans.append((y, begin))
        y = max(y, end)
    if y < WIDTH:
        spans.append((y, WIDTH))
    return spans


def _walls_x(begin: float, end: float, y: float, doors: Sequence[float]) -> List[Rectangle]:
    """A wall along x with doors of a meter that begin there."""
    ends = [begin, *(place for door in doors for place in (door, door + 1.0)), end]
    return [(low, y, high, y + _WALL) for low, high in zip(ends[::2], ends[1::2]) if high > low]


def _walls_y(x: float, begin: float, end: float, doors: Sequence[float]) -> List[Rectangle]:
    """The same along y."""
    return [(b, a, d, c) for a, b, c, d in _walls_x(begin, end, x, doors)]

"""The generated building with walls, pillars, furniture and a ramp that are surfaces of their own,
as CAD and BIM programs export them: few large faces, standing on the floors, sunk, or afloat."""

from typing import List, NamedTuple, Tuple

import numpy as np
from mesh_msgs.world.building import HEIGHT, RAMP, Rectangle, ramp, storey, walls
from mesh_msgs.world.solids import Part, box, joined, welded

SLAB = 0.3  # m between the ceiling of the lower storey and the upper floor
_SUNK, _AFLOAT = 0.05, 0.03  # m
_TABLE = 0.72, 0.04, 0.06  # m: the height of the top and its thickness, and the legs'
_TABLES: List[Rectangle] = [(2.0, 2.0, 3.6, 2.8), (12.0, 3.0, 13.6, 5.0), (3.0, 18.0, 4.6, 18.8)]
# On either storey: shelves, cabinets and beds with their heights, and one thing to be driven over.
_LOWER = [
    ((8.6, 0.0, 10.6, 0.4), 1.8),
    ((18.0, 2.0, 18.4, 4.4), 1.8),
    ((10.0, 20.0, 12.0, 21.6), 0.5),
    ((18.0, 16.0, 20.0, 16.6), 0.8),
    ((28.0, 12.0, 29.2, 12.8), 0.12),
]
_UPPER = [
    ((14.0, 3.0, 16.0, 3.4), 1.8),
    ((4.0, 20.0, 6.0, 21.6), 0.5),
    ((30.0, 6.0, 31.0, 7.0), 1.0),
]
_WEDGE: Rectangle = (28.0, 18.5, 31.0, 20.0)  # a ramp that leads nowhere; rises along x
_WEDGE_HEIGHT = 0.6  # m


class Thing(NamedTuple):
    """What stands there, as an upright block."""

    place: Rectangle
    """x, y from; x, y to (m)."""
    low: float
    high: float
    """z (m)."""

    def distances(self, points: np.ndarray, step_height: float, robot_height: float) -> np.ndarray:
        """(N,) m in plan to a robot whose wheels are at points (N, 3); inf where it is not as high
        as the body, which is what is between both heights above them."""
        x0, y0, x1, y1 = self.place
        x, y, z = points.T
        aside = np.maximum(np.maximum(x0 - x, x - x1), 0.0)
        ahead = np.maximum(np.maximum(y0 - y, y - y1), 0.0)
        meets = (z + step_height < self.high) & (z + robot_height > self.low)
        return np.where(meets, np.hypot(aside, ahead), np.inf)


class FurnishedBuilding(NamedTuple):
    """A mesh, and what is in it."""

    vertices: np.ndarray
    """(V, 3) float32 m, z up."""
    faces: np.ndarray
    """(F, 3) uint32."""
    things: List[Thing]
    """All that the robot has to drive around, but for the wedge."""


def furnished_building() -> FurnishedBuilding:
    """Two floors of few faces, open for the ramp alone, and solids that share nothing with them."""
    floors = welded(joined(storey([RAMP], 0.0), storey([RAMP], HEIGHT), ramp()))
    lower, upper = walls()
    things = [Thing(place, 0.0, HEIGHT - SLAB) for place in lower]
    things += [Thing(place, HEIGHT, HEIGHT + 2.6) for place in upper]
    things += [Thing(place, 0.0, high) for place, high in _LOWER]
    things += [Thing(place, HEIGHT, HEIGHT + high) for place, high in _UPPER]
    solids = [_solid(number, thing) for number, thing in enumerate(things)]
    for table in _TABLES:
        parts, top = _table(table)
        solids += parts
        things.append(top)
    vertices, faces = joined(floors, *solids, _wedge())
    kept = [each for each in things if each.high - each.low > 0.2]
    return FurnishedBuilding(
        np.ascontiguousarray(vertices, np.float32), np.ascontiguousarray(faces, np.uint32), kept
    )


def _solid(number: int, thing: Thing) -> Part:
    """Every third one is sunk into the floor, floats above it, or stands on it; sides of every
    other one share no vertices."""
    x0, y0, x1, y1 = thing.place
    low = thing.low + (-_SUNK, _AFLOAT, 0.0)[number % 3]
    return box((x0, y0, low), (x1, y1, thing.high), separate_sides=number % 2 == 1)


def _table(place: Rectangle) -> Tuple[List[Part], Thing]:
    """Too low to drive under: a top on four legs."""
    x0, y0, x1, y1 = place
    height, thick, leg = _TABLE
    under = height - thick
    parts = [box((x0, y0, under), (x1, y1, height))]
    for x in (x0, x1 - leg):
        for y in (y0, y1 - leg):
            parts.append(box((x, y, 0.0), (x + leg, y + leg, under)))
    return parts, Thing(place, 0.0, height)


def _wedge() -> Part:
    x0, y0, x1, y1 = _WEDGE
    corners = [(x0, y0, 0), (x1, y0, 0), (x1, y1, 0), (x0, y1, 0)]
    tops = [(x1, y0, _WEDGE_HEIGHT), (x1, y1, _WEDGE_HEIGHT)]
    faces = [[0, 2, 1], [0, 3, 2], [0, 4, 5], [0, 5, 3], [1, 2, 5], [1, 5, 4], [0, 1, 4], [3, 5, 2]]
    return np.array(corners + tops, np.float64), np.array(faces)

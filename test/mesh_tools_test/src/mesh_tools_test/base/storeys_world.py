"""A generated building of two storeys: rooms of all sizes, pillars, furniture and a ramp."""

from typing import List, NamedTuple, Tuple

import numpy as np
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_msgs.world.building import Rectangle
from mesh_msgs.world.solids import Part, box, floor, joined, welded

HEIGHT = 3.2  # m from floor to floor
_WALL, _DOOR = 0.2, 1.4  # m: thickness and width
_WALL_HEIGHT = 3.0  # m, so that there is a gap below the upper floor
_LEAST_ROOM, _MOST_ROOM = 5.0, 18.0  # m
_RAMP = 2.0, 12.0  # m wide and long
_CLEARANCE = 0.5  # m, of a robot's middle from what stands there


class StoreysWorld(NamedTuple):
    """mesh: z up; size: m, of its square floors; standing: what stands on each storey, (N, 4) m, x
    and y from, then to; the ramp is among it."""

    mesh: MeshGeometry
    size: float
    standing: Tuple[np.ndarray, np.ndarray]

    def poses(self, count: int, seed: int = 0) -> np.ndarray:
        """(count, 4, 4) of a robot on the floors, every second one upstairs; any heading."""
        random = np.random.default_rng([seed, 1])
        poses = np.tile(np.eye(4), (count, 1, 1))
        for number, pose in enumerate(poses):
            storey = number % 2
            x0, y0, x1, y1 = self.standing[storey].T
            while True:
                x, y = random.uniform(_CLEARANCE, self.size - _CLEARANCE, 2)
                aside = np.maximum(np.maximum(x0 - x, x - x1), 0)
                ahead = np.maximum(np.maximum(y0 - y, y - y1), 0)
                if np.hypot(aside, ahead).min() > _CLEARANCE:
                    break
            heading = random.uniform(-np.pi, np.pi)
            sine, cosine = np.sin(heading), np.cos(heading)
            pose[:2, :2] = [[cosine, -sine], [sine, cosine]]
            pose[:3, 3] = x, y, storey * HEIGHT
        return poses


def storeys_world(size: float = 100.0, edge: float = 0.38, seed: int = 0) -> StoreysWorld:
    """The world; the same arguments give the same one.

    Args:
        size: m, of its sides, at least 30.
        edge: m, of the squares of two faces that the floors are made of.
    """
    random = np.random.default_rng([seed, 0])
    ticks = max(1, int(round(size / edge)))
    step = size / ticks
    # The ramp's sides lie on lines of the floors' squares, so that it is joined to them.
    corner = np.floor(np.array([0.4, 0.45]) * size / step) * step
    end = corner + np.ceil(np.array(_RAMP[::-1]) / step) * step
    ramp = (*corner, *end)
    parts, standing = [_ramp(ramp, step)], []
    for storey in range(2):
        level = storey * HEIGHT
        rooms = _rooms((0.0, 0.0, size, size), random)
        walls = _outer_walls(size) + [wall for room in rooms for wall in room.walls]
        things = [thing for room in rooms for thing in room.things]
        apart = [each for each in walls + things if not _meets(each, ramp, _DOOR)]
        heights = random.uniform(0.5, 2.0, len(apart))
        heights[[each in walls or each[2] - each[0] < 0.7 for each in apart]] = _WALL_HEIGHT
        for each, height in zip(apart, heights):
            x0, y0, x1, y1 = each
            parts.append(box((x0, y0, level - 0.01), (x1, y1, level + height)))
        parts.append(_without(floor((0, 0), (size, size), step, level), ramp))
        standing.append(np.array([*apart, ramp]))
    vertices, faces = welded(joined(*parts))
    return StoreysWorld(MeshGeometry(vertices, faces), size, (standing[0], standing[1]))


class _Room(NamedTuple):
    walls: List[Rectangle]
    things: List[Rectangle]


def _outer_walls(size: float) -> List[Rectangle]:
    return [
        (0.0, 0.0, size, _WALL),
        (0.0, size - _WALL, size, size),
        (0.0, 0.0, _WALL, size),
        (size - _WALL, 0.0, size, size),
    ]


def _rooms(area: Rectangle, random: np.random.Generator) -> List[_Room]:
    """An area cut in two by a wall with doors, again and again, until rooms are small enough."""
    x0, y0, x1, y1 = area
    sides = np.array([x1 - x0, y1 - y0])
    along = int(sides.argmax())
    if sides[along] < random.uniform(2 * _LEAST_ROOM, _MOST_ROOM + _LEAST_ROOM):
        return [_Room([], _things(area, random))]
    low, high = area[along], area[along + 2]
    cut = float(random.uniform(low + 0.3 * sides[along], high - 0.3 * sides[along]))
    across = 1 - along
    begin, stop = area[across], area[across + 2]
    doors = sorted(random.uniform(begin + 0.5, stop - _DOOR - 0.5, 1 + int(sides[across] // 15)))
    walls = []
    for door in [*doors, stop]:
        if door > begin:
            lower, upper = [0.0, 0.0], [0.0, 0.0]
            lower[along], upper[along] = cut - _WALL / 2, cut + _WALL / 2
            lower[across], upper[across] = begin, float(door)
            walls.append((*lower, *upper))
        begin = max(begin, float(door) + _DOOR)
    first, second = list(area), list(area)
    first[along + 2] = second[along] = cut
    found = [_Room(walls, [])]
    return found + _rooms(tuple(first), random) + _rooms(tuple(second), random)


def _things(area: Rectangle, random: np.random.Generator) -> List[Rectangle]:
    """Furniture and pillars of a room."""
    x0, y0, x1, y1 = area
    things = []
    for _ in range(int(random.integers(1, 2 + (x1 - x0) * (y1 - y0) / 40))):
        size = random.uniform(0.4, 1.8, 2)
        low = random.uniform([x0 + 0.2, y0 + 0.2], [x1 - size[0] - 0.2, y1 - size[1] - 0.2])
        things.append((*low, *(low + size)))
    return things


def _meets(one: Rectangle, other: Rectangle, margin: float) -> bool:
    return (
        one[0] < other[2] + margin
        and other[0] < one[2] + margin
        and one[1] < other[3] + margin
        and other[1] < one[3] + margin
    )


def _without(part: Part, hole: Rectangle) -> Part:
    """A floor with a rectangular hole in it."""
    vertices, faces = part
    x, y = vertices[faces].mean(axis=1)[:, :2].T
    inside = (x > hole[0]) & (x < hole[2]) & (y > hole[1]) & (y < hole[3])
    return vertices, faces[~inside]


def _ramp(area: Rectangle, edge: float) -> Part:
    """Rises along x from the lower floor to the upper one."""
    vertices, faces = floor(area[:2], area[2:], edge)
    vertices[:, 2] = (vertices[:, 0] - area[0]) / (area[2] - area[0]) * HEIGHT
    return vertices, faces

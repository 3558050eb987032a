"""Where things are in the generated outdoor world: the plan of it, without heights.

Seen from above, with the side S of the square world: a road runs from south to north and a path
from west to east; they cross at the origin, the path on a bridge over the road. The start lies in
the south-west, the goal in the north-east inside a walled garden whose gate looks east.
"""

from typing import List, NamedTuple, Tuple

import numpy as np

# The bridge and the cutting below it, in meters. The road lies ROAD_HALF_WIDTH to both sides of its
# middle, then the banks rise over BANK_WIDTH from ROAD_LEVEL to PATH_LEVEL, where the bridge's deck
# begins.
ROAD_HALF_WIDTH, BANK_WIDTH = 2.3, 3.4
ROAD_LEVEL, PATH_LEVEL = -2.4, 1.3
PATH_HALF_WIDTH = 1.1
BRIDGE_HALF_WIDTH = 1.7
# The deck's ends: holes in the ground between these distances from the middle of the road.
BRIDGE_FRONT, BRIDGE_BACK = 5.2, 6.2
# The plateaus of the path at the bridge's ends reach from there to here.
PLATEAU_END = 7.5
WALL_THICKNESS = 0.4


class Wall(NamedTuple):
    """A wall along a polyline (N, 2) of its middle; height in meters."""

    line: np.ndarray
    height: float


class Stairs(NamedTuple):
    """Steps up along x to a landing, and a ramp down behind it; all lengths in meters."""

    position: np.ndarray  # where the first step begins, in the middle of it
    width: float = 2.0
    steps: int = 6
    tread: float = 0.3
    rise: float = 0.17
    landing: float = 2.0
    ramp: float = 4.2

    @property
    def length(self) -> float:
        """From the first step to the end of the ramp."""
        return self.steps * self.tread + self.landing + self.ramp

    @property
    def middle(self) -> np.ndarray:
        """(2,) of all of it."""
        return self.position + [self.length / 2, 0.0]

    @property
    def landing_middle(self) -> np.ndarray:
        """(2,) of the landing."""
        return self.position + [self.steps * self.tread + self.landing / 2, 0.0]


class Tree(NamedTuple):
    """A tree; all lengths in meters."""

    position: np.ndarray
    trunk_radius: float
    trunk_height: float
    crown_radius: float
    crown_height: float
    conifer: bool


class Hill(NamedTuple):
    """A round hill; all lengths in meters."""

    position: np.ndarray
    radius: float
    height: float


class WorldLayout:
    """The plan of a world of the given side (meters) and seed."""

    def __init__(self, size: float, seed: int, trees: bool = True, stairs: bool = False):
        self.size = size
        rng = np.random.default_rng([seed, 1])
        self.start = np.array([-0.37, -0.22]) * size
        self.goal = np.array([0.27, 0.27]) * size
        self.garden_half = 0.085 * size
        self.stairs = Stairs(np.array([-0.385, 0.25]) * size) if stairs else None
        self.hills = self._hills(rng)
        self.walls = self._walls(rng)
        self.trees = self._trees(rng) if trees else []

    def road_x(self, y: np.ndarray) -> np.ndarray:
        """Return the x of the road's middle at y; straight along y at the bridge."""
        return 0.12 * self.size * (2.0 * y / self.size) ** 3

    def path_y(self, x: np.ndarray) -> np.ndarray:
        """Return the y of the path's middle at x; straight along x at the bridge."""
        return 0.22 * self.size * (2.0 * x / self.size) ** 3

    def road_distance(self, xy: np.ndarray) -> np.ndarray:
        """Return the distance of points (N, 2) from the middle of the road, to first order."""
        x, y = xy.T
        slope = 0.72 * (2.0 * y / self.size) ** 2
        return np.abs(x - self.road_x(y)) / np.sqrt(1.0 + slope * slope)

    def path_distance(self, xy: np.ndarray) -> np.ndarray:
        """Return the distance of points (N, 2) from the middle of the path, to first order."""
        x, y = xy.T
        slope = 1.32 * (2.0 * x / self.size) ** 2
        return np.abs(y - self.path_y(x)) / np.sqrt(1.0 + slope * slope)

    def trails(self) -> List[np.ndarray]:
        """Return the trodden ways: from the start to the path, and from there to the goal."""
        u, a = self.size, self.garden_half
        gx, gy = self.goal
        join = np.array([-0.26 * u, self.path_y(-0.26 * u)])
        leave = np.array([0.34 * u, self.path_y(0.34 * u)])
        gate = [gx + 1.55 * a, gy + 0.1 * a]
        around = [leave, [gx + 1.7 * a, gy - 0.8 * a], gate, self.goal]
        return [np.array([self.start, join]), _smooth(np.array(around))]

    def _hills(self, rng: np.random.Generator) -> List[Hill]:
        # x, y and radius in sides of the world, height in meters for a world of 60 m
        table = [
            (-0.36, 0.40, 0.24, 8.5),
            (-0.14, 0.33, 0.13, 3.4),
            (0.38, -0.40, 0.24, 7.5),
            (0.20, -0.30, 0.13, 3.0),
            (0.49, 0.49, 0.17, 4.5),
            (-0.16, -0.50, 0.15, 3.5),
            (-0.50, 0.02, 0.13, 2.5),
        ]
        scale = (self.size / 60.0) ** 0.8
        hills = []
        for x, y, radius, height in table:
            shift = (rng.random(2) - 0.5) * 0.05
            factor = 0.85 + 0.3 * rng.random()
            top = (np.array([x, y]) + shift) * self.size
            hills.append(Hill(top, radius * self.size, height * scale * factor))
        return hills

    def _walls(self, rng: np.random.Generator) -> List[Wall]:
        (x, y), a = self.goal, self.garden_half
        gate = min(1.3, 0.5 * a)
        corners = [(a, gate), (a, a), (-a, a), (-a, -a), (a, -a), (a, -gate)]
        walls = [Wall(_rounded(np.array(corners) + [x, y], 0.9), 1.9)]
        # Walls along the path, each with a gap in it.
        inner, outer = max(0.16 * self.size, PLATEAU_END + 1.0), 0.45 * self.size
        for direction, side in ((-1.0, 1.0), (1.0, -1.0)):
            gap = inner + (0.4 + 0.2 * rng.random()) * (outer - inner)
            for begin, end in ((inner, gap - 1.1), (gap + 1.1, outer)):
                if end - begin < 1.2:
                    continue
                along = direction * np.linspace(begin, end, 12)
                line = np.stack([along, self.path_y(along) + side * 3.4], axis=1)
                walls.append(Wall(line, 1.1 + 0.3 * rng.random()))
        return walls

    def _trees(self, rng: np.random.Generator) -> List[Tree]:
        """Scatter trees in groups, away from everything that is driven on."""
        half = self.size / 2
        wanted = int(max(4, round(self.size**2 / 110.0)))
        groves = (rng.random((max(4, wanted // 6), 2)) - 0.5) * self.size
        places = [self.start, self.goal]
        trails = np.concatenate([resample(line, 0.3)[0] for line in self.trails()])
        walls = np.concatenate([resample(wall.line, 0.3)[0] for wall in self.walls])
        trees: List[Tree] = []
        for attempt in range(200 * wanted):
            spot = (rng.random(2) - 0.5) * self.size
            shape = rng.random(6)
            # At the end of a long search lone trees are welcome as well.
            alone = np.linalg.norm(groves - spot, axis=1).min() > 0.10 * self.size
            if alone and shape[5] > 0.15 + attempt / (100.0 * wanted):
                continue
            xy = spot[None]
            standing = np.array([tree.position for tree in trees]).reshape(-1, 2)
            clear = (
                np.abs(spot).max() < half - 1.2
                and self.road_distance(xy)[0] > ROAD_HALF_WIDTH + 2.0
                and self.path_distance(xy)[0] > 2.2
                and np.linalg.norm(spot) > BRIDGE_BACK + 2.0
                and np.linalg.norm(walls - spot, axis=1).min() > 1.3
                and np.linalg.norm(trails - spot, axis=1).min() > 1.3
                and np.linalg.norm(np.array(places) - spot, axis=1).min() > 2.2
                and (np.linalg.norm(standing - spot, axis=1) > 1.9).all()
                and not self._is_at_stairs(spot)
            )
            if not clear:
                continue
            trees.append(_tree(spot, shape))
            if len(trees) == wanted:
                break
        return trees

    def _is_at_stairs(self, spot: np.ndarray) -> bool:
        if self.stairs is None:
            return False
        reach = np.array([self.stairs.length, self.stairs.width]) / 2 + 2.2
        return bool((np.abs(spot - self.stairs.middle) < reach).all())


def _tree(position: np.ndarray, shape: np.ndarray) -> Tree:
    """A conifer or a broadleaf tree, its measures from random numbers (6,) in 0 .. 1."""
    if shape[0] < 0.5:
        crown_radius, crown_height = 0.9 + 0.5 * shape[2], 3.2 + 2.2 * shape[3]
        return Tree(position, 0.14 + 0.05 * shape[1], 1.0, crown_radius, crown_height, True)
    crown_radius = 1.0 + 0.6 * shape[2]
    crown_height = crown_radius * (1.7 + 0.4 * shape[3])
    trunk_radius, trunk_height = 0.15 + 0.07 * shape[1], 1.5 + 0.6 * shape[4]
    return Tree(position, trunk_radius, trunk_height, crown_radius, crown_height, False)


def _smooth(line: np.ndarray) -> np.ndarray:
    """Cut the corners of a polyline (Chaikin's scheme), its ends kept."""
    for _ in range(3):
        quarter = 0.75 * line[:-1] + 0.25 * line[1:]
        three = 0.25 * line[:-1] + 0.75 * line[1:]
        line = np.concatenate(
            [line[:1], np.stack([quarter, three], axis=1).reshape(-1, 2), line[-1:]]
        )
    return line


def _rounded(line: np.ndarray, reach: float) -> np.ndarray:
    """Replace the inner corners of a polyline by parabolas that begin and end `reach` from the
    corner.
    """
    t = np.linspace(0.0, 1.0, 9)[:, None]
    pieces = [line[:1]]
    for before, corner, after in zip(line[:-2], line[1:-1], line[2:]):
        begin = corner + (before - corner) * (reach / np.linalg.norm(before - corner))
        end = corner + (after - corner) * (reach / np.linalg.norm(after - corner))
        pieces.append((1.0 - t) ** 2 * begin + 2.0 * t * (1.0 - t) * corner + t**2 * end)
    return np.concatenate(pieces + [line[-1:]])


def resample(line: np.ndarray, step: float) -> Tuple[np.ndarray, np.ndarray]:
    """Return points along a polyline (its ends among them), about `step` apart, and their miter
    normals.

    The normals (N, 2) point to the left and are so long that an offset by `d * normal` runs at
    distance d.
    """
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    wanted = np.linspace(0.0, along[-1], max(1, int(round(along[-1] / step))) + 1)
    points = np.stack([np.interp(wanted, along, line[:, axis]) for axis in range(2)], axis=1)
    direction = np.diff(points, axis=0)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    left = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    before, after = np.concatenate([left[:1], left]), np.concatenate([left, left[-1:]])
    middle = before + after
    return points, 2.0 * middle / (middle * middle).sum(axis=1, keepdims=True)

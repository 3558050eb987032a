"""Times of what follows from a change on a map in use."""

import collections
import itertools
import threading
import time
from statistics import median
from typing import Any, Callable, Deque, Dict, List, Tuple

import numpy as np
from mesh_map.costs.layer import LayerInput
from mesh_map.map.mesh_map import MeshMap

from mesh_tools_test.base.figures import Figure, timed
from mesh_tools_test.base.noisy_world import STEP, World, layer, map_with

POINTS = 100_000
SENSOR = 1.2  # meters above the ground
OBSTACLES = 40
PERIOD = 0.1  # seconds between two clouds


def changes(world: World, repeats: int) -> List[Figure]:
    """Parameters of layers and of the map, beside computing all layers anew."""
    config = [
        layer("height_diff", "HeightDiff", threshold=STEP),
        layer("roughness", "Roughness", threshold=1.2),
        layer("inflation", "Inflation", inscribed_radius=0.3, inflation_radius=0.8),
    ]
    geometry = world.fresh_geometry()
    mesh_map = map_with(geometry, config)
    fresh = world.fresh_geometry()
    anew, other = timed(lambda: map_with(fresh, config), 1)
    peer = "all layers anew"

    def each(name: str, parameter: str, *values: Any) -> Callable[[], Any]:
        """Sets one value after the other, and begins again."""
        rest = itertools.cycle(values)
        return lambda: mesh_map.set_layer_parameters(name, {parameter: next(rest)})

    radii = [0.3 + 0.001 * number for number in range(1, 100)]  # no pass is known from before
    found = []
    for text, change in (
        ("factor of a layer", each("roughness", "factor", 0.5, 0.6)),
        ("threshold below inflation, by 1 cm", each("height_diff", "threshold", 0.41, STEP)),
        ("inflation_radius", each("inflation", "inflation_radius", 0.9, 0.8)),
        ("radius of roughness", each("roughness", "radius", *radii)),
    ):
        own, _ = timed(change, max(repeats, 2))
        found.append(Figure(text, own, "ms", peer, anew))
    return found + patches(mesh_map, other, repeats)


def patches(mesh_map: MeshMap, other: MeshMap, repeats: int) -> List[Figure]:
    """Inflation after about a thousand vertices became lethal or free, beside all of it.

    `other` has the same mesh: the layer forgets what it knows when it is asked about another map.
    """
    one = mesh_map.layers["inflation"]
    before = mesh_map.layers["height_diff"].result
    start = int(np.argmin(np.abs(mesh_map.vertices[:, :2]).sum(axis=1)))
    center = mesh_map.vertices[start]
    near = np.argsort(((mesh_map.vertices - center) ** 2).sum(axis=1))[:1000]
    changed = np.sort(near).astype(np.uint32)
    lethal = before.lethal.copy()
    lethal[changed] ^= True
    inputs = [
        {"height_diff": LayerInput(before.costs, mask, None, 1.0)}
        for mask in (before.lethal, lethal)
    ]
    maps = itertools.cycle((other, mesh_map))
    whole, expected = timed(lambda: one.evaluate(next(maps), inputs[1]), repeats)
    turns = itertools.cycle((1, 0))
    result = one.evaluate(mesh_map, inputs[0])

    def flip() -> None:  # as in a map, no result but the last is kept
        nonlocal result
        result = one.update(mesh_map, inputs[next(turns)], changed, result)

    flip()
    if not np.array_equal(result.costs, expected.costs):
        raise RuntimeError("an update of the inflation differs from computing it")
    own, _ = timed(flip, max(repeats, 4))
    return [Figure("inflation, 1000 vertices changed", own, "ms", "all of it", whole)]


def clouds(mesh_map: MeshMap, seed: int = 0) -> Tuple[List[np.ndarray], np.ndarray]:
    """Two clouds of a scanner in the middle of the map, and its position.

    Most points are on the ground, some stand on it in clusters that differ between the clouds.
    """
    random = np.random.default_rng(seed)
    start = int(np.argmin(np.abs(mesh_map.vertices[:, :2]).sum(axis=1)))
    origin = mesh_map.vertices[start].astype(np.float64) + [0, 0, SENSOR]
    found = []
    for _ in range(2):
        angle = random.uniform(-np.pi, np.pi, POINTS)
        pitch = random.uniform(-0.6, 0.05, POINTS)
        rays = np.stack([np.cos(angle), np.sin(angle), pitch], axis=1)
        starts = np.tile(origin, (POINTS, 1))
        hits = mesh_map.spatial_index.cast_batch(origins=starts, directions=rays, max_distance=30.0)
        points = hits.positions(origins=starts, directions=rays)
        points = points[np.isfinite(points).all(axis=1)]
        centers = points[random.integers(0, len(points), OBSTACLES)]
        standing = np.repeat(centers, 100, axis=0)
        standing = standing + random.uniform((-0.3, -0.3, 0.2), (0.3, 0.3, 1.0), standing.shape)
        points = points[random.integers(0, len(points), POINTS - len(standing))]
        found.append(np.concatenate([points, standing]).astype(np.float32))
    return found, origin


def obstacles(world: World, repeats: int) -> List[Figure]:
    """Clouds of an obstacle layer, alone and with an inflation over it and a map around."""
    geometry = world.fresh_geometry()
    geometry.spatial_index.wait_for_device()
    obstacle = layer("obstacle", "Obstacle", robot_height=1.5, topic="points")
    inflation = layer("inflation", "Inflation", inscribed_radius=0.3, inflation_radius=0.8)
    step = layer("height_diff", "HeightDiff", threshold=STEP)
    found = []
    for text, config, floor in (
        ("cloud of 100,000 points", [obstacle], 100.0),
        ("  with height_diff and inflation", [step, obstacle, inflation], None),
    ):
        mesh_map = map_with(geometry, config)
        both, origin = clouds(mesh_map)
        stamp = [0.0]

        def insert() -> int:
            stamp[0] += 1.0
            one = mesh_map.layers["obstacle"]
            marked = one.insert_cloud(mesh_map, both[int(stamp[0]) % 2], origin, stamp[0])
            mesh_map.refresh_layer("obstacle")
            return marked

        insert()
        own, marked = timed(insert, max(repeats, 4))
        if not marked:
            raise RuntimeError("the cloud marks nothing")
        found.append(Figure(text, own, "ms", floor=floor))
    return found


def meanwhile(world: World, repeats: int) -> List[Figure]:
    """Clouds at 10 Hz while roughness at 1 m is computed anew, and what reads both: from when one
    comes until its marks are in the costs, the median and the longest, beside the same without
    that. As for a sensor, the next one comes whether the one before is done or not."""
    geometry = world.fresh_geometry()
    geometry.spatial_index.wait_for_device()
    config = [
        layer("roughness", "Roughness", radius=0.9, threshold=1.2),
        layer("obstacle", "Obstacle", robot_height=1.5, topic="points"),
        layer("inflation", "Inflation", inscribed_radius=0.3, inflation_radius=0.8),
    ]
    mesh_map = map_with(geometry, config)
    sensor = _Sensor(mesh_map)
    sensor.see(lambda: len(sensor.delays) < 2)
    mesh_map.catch_up()
    sensor.delays.clear()
    sensor.see(lambda: len(sensor.delays) < max(repeats, 4))
    alone = list(sensor.delays)
    mesh_map.catch_up()
    sensor.delays.clear()
    change = threading.Thread(
        target=mesh_map.set_layer_parameters, args=("roughness", {"radius": 1.0})
    )
    change.start()
    sensor.see(lambda: change.is_alive() or not sensor.delays)
    during = list(sensor.delays)
    peer = "without that"
    return [
        Figure(
            "cloud while roughness is computed", median(during), "ms", peer, median(alone), 150.0
        ),
        Figure("  the longest of %d" % len(during), max(during), "ms", peer, max(alone)),
    ]


class _Sensor:
    """Clouds for the layer "obstacle", one after the other, and the newest of those that wait, as
    its adapter takes them.

    Attributes:
        delays: of each cloud, ms from when it came until it, or a newer one, was in the costs.
    """

    def __init__(self, mesh_map: MeshMap) -> None:
        self.delays: List[float] = []
        self._map, self._taking = mesh_map, threading.Lock()
        self._clouds, self._origin = clouds(mesh_map)
        self._stamps = itertools.count(1.0)
        self._waiting: Deque[float] = collections.deque()  # when they came

    def see(self, goes_on: Callable[[], bool]) -> None:
        """Clouds come, until the last that came is in the costs."""
        threads, due = [], time.perf_counter()
        while goes_on():
            self._waiting.append(due)
            threads.append(threading.Thread(target=self._take))
            threads[-1].start()
            due += PERIOD
            time.sleep(max(0.0, due - time.perf_counter()))
        for thread in threads:
            thread.join()

    def _take(self) -> None:
        with self._taking:
            came = [self._waiting.popleft() for _ in range(len(self._waiting))]
            if not came:
                return
            stamp, before = next(self._stamps), self._map.costs
            obstacle, cloud = self._map.layers["obstacle"], self._clouds[int(stamp) % 2]
            obstacle.insert_cloud(self._map, cloud, self._origin, stamp)
            self._map.refresh_layer("obstacle", wait=False)
            now = time.perf_counter()
            if self._map.costs is before:
                raise RuntimeError("a cloud is not in the costs")
            self.delays += [1000.0 * (now - one) for one in came]


PARTS: Dict[str, Callable[[World, int], List[Figure]]] = {
    "changes": changes,
    "obstacles": obstacles,
    "meanwhile": meanwhile,
}

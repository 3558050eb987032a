"""Times of what is computed when a map is loaded."""

import statistics
import time
from typing import Any, Callable, Dict, List, Optional

import numpy as np
from mesh_map.costs.combination import Combination
from mesh_map.costs.layer import Layer, LayerInput, checked
from mesh_map.costs.layer_set import make_layers
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.normals import face_normals, vertex_normals
from mesh_map.geometry.topology import Topology
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs.world import solids

from mesh_tools_test.base.figures import Figure, timed
from mesh_tools_test.base.noisy_world import STEP, World, layer, map_with
from mesh_tools_test.layers import peers

SHARE = 50  # every so-manieth vertex by cKDTree, whose time is multiplied
STATISTICS = ("height_difference", "roughness")


def geometry(world: World, repeats: int) -> List[Figure]:
    """Topology and normals."""
    faces, count = world.faces, len(world.vertices)
    own, topology = timed(lambda: Topology(faces=faces, vertex_count=count), repeats)
    other, _ = timed(lambda: peers.numpy_edges(faces), 1)
    found = [Figure("topology", own, "ms", "np.unique (edges alone)", other, 300.0)]
    own, normals = timed(
        lambda: vertex_normals(topology, *face_normals(world.vertices, faces)), repeats
    )
    other, expected = timed(lambda: peers.numpy_normals(world.vertices, faces), 1)
    if np.abs(normals - expected).max() > 1e-2:
        raise RuntimeError("the normals differ from NumPy's")
    return found + [Figure("normals of faces and vertices", own, "ms", "NumPy", other, 60.0)]


def fresh(world: World, repeats: int, action: Callable[[MeshGeometry], Any]) -> Any:
    """Median time of an action with geometries for which no layer was computed, and its result."""
    times, result = [], None
    for _ in range(repeats):
        made = world.fresh_geometry()
        start = time.perf_counter()
        result = action(made)
        times.append(time.perf_counter() - start)
    return 1000.0 * statistics.median(times), result


def evaluated(geometry: MeshGeometry, layers: Dict[str, Layer]) -> MeshMap:
    """A map with what layers that need no others compute; plugins are found before."""
    mesh_map = MeshMap.of(geometry)
    for one in layers.values():
        one.announce(geometry)
    for one in layers.values():
        one.result = one.evaluate(mesh_map, {})
    return mesh_map


def radius_layers(world: World, repeats: int, radius: float, floor: float) -> List[Figure]:
    """Roughness and height difference together."""
    config = [
        layer("height_diff", "HeightDiff", radius=radius),
        layer("roughness", "Roughness", radius=radius),
    ]
    layers = make_layers(config).layers
    own, mesh_map = fresh(world, repeats, lambda made: evaluated(made, layers))
    results = [one.result.costs for one in layers.values()]
    angles = peers.numpy_mean_angles(mesh_map.vertex_normals, mesh_map.topology.edges)
    share = SHARE * (1 if radius < 0.5 else 4)
    other, expected = timed(
        lambda: peers.kdtree_statistics(mesh_map.vertices, angles, radius, share), 1
    )
    # The tree knows vertices alone; of large faces, the layer knows the surface, too.
    heights = mesh_map.geometry.radius_pass(radius).height_difference()
    connected = np.isclose(heights[::share], expected[0], atol=1e-5)
    if connected.mean() < 0.8:
        raise RuntimeError("%g m: most differs from the tree" % radius)
    name = "roughness + height_diff %g m" % radius
    found = [
        Figure(
            name, own, "ms", "cKDTree + NumPy (1/%d, extrapolated)" % share, share * other, floor
        )
    ]
    return found + numba_peer(name, own, mesh_map, angles, radius, results)


def numba_peer(
    name: str,
    own: float,
    mesh_map: MeshMap,
    angles: np.ndarray,
    radius: float,
    results: List[np.ndarray],
) -> List[Figure]:
    """The same by numba, compiled before; nothing where numba is not installed."""
    compiled = peers.numba_statistics()
    if compiled is None:
        return []
    topology = mesh_map.topology
    arrays = (mesh_map.vertices, topology.neighbor_offsets, topology.neighbors, angles)
    arrays = tuple(np.array(array) for array in arrays)  # what cannot be written is another type
    few = (arrays[0][:1], np.zeros_like(arrays[1][:2]), arrays[2][:0], arrays[3][:1])
    compiled(*few, radius, 2)
    other, expected = timed(lambda: compiled(*arrays, radius, 2), 1)
    same = [
        np.isclose(own_costs, costs, atol=1e-3).mean() > 0.999
        for own_costs, costs in zip(results, expected)
    ]
    if not all(same):
        raise RuntimeError("%g m: numba computes something else" % radius)
    return [Figure(name, own, "ms", "numba (2 threads, compiled)", other)]


def other_layers(world: World, repeats: int) -> List[Figure]:
    """The other released layers that measure the geometry, together; clearance on its own."""
    config = [
        layer("steepness", "Steepness"),
        layer("ridge", "Ridge"),
        layer("border", "Border"),
    ]
    find, layers = timed(lambda: make_layers(config).layers, repeats)
    own, _ = fresh(world, repeats, lambda made: evaluated(made, layers))
    found = [
        Figure("finding and making 3 layers", find, "ms"),
        Figure("steepness + ridge + border", own, "ms", floor=200.0),
    ]
    for name, one in layers.items():
        own, mesh_map = fresh(
            world, repeats, lambda made, name=name, one=one: evaluated(made, {name: one})
        )
        other, expected = timed(lambda name=name: numpy_costs(name, mesh_map), 1)
        peer, value = ("NumPy", other) if expected is not None else ("", None)
        if expected is not None:
            np.testing.assert_allclose(one.result.costs, expected, atol=2e-3)
        found.append(Figure("  " + name, own, "ms", peer, value))

    clearance = indexed(world, repeats, layer("clearance", "Clearance"))
    return found + [Figure("clearance (after the index)", clearance, "ms")]


def indexed(world: World, repeats: int, entry: Dict[str, Any]) -> float:
    """Median time in milliseconds of a map of one layer, where the index is there."""
    times = []
    for _ in range(repeats):
        made = world.fresh_geometry()
        made.spatial_index.wait_for_device()
        start = time.perf_counter()
        map_with(made, [entry])
        times.append(1000.0 * (time.perf_counter() - start))
    return statistics.median(times)


def collision(world: World, repeats: int) -> List[Figure]:
    """Without a radius and with two, outdoors and in a hall of as many faces, beside clearance: one
    ray for each vertex."""
    found = []
    for text, one in (("outdoors", world), ("hall", hall(len(world.faces)))):
        rays = indexed(one, repeats, layer("clearance", "Clearance"))
        for radius in (0.0, 0.25, 0.5):
            entry = layer("collision", "Collision", robot_radius=radius)
            own = indexed(one, repeats, entry)
            name = "collision, %s, radius %g m" % (text, radius)
            found.append(Figure(name, own, "ms", "clearance", rays, 4000.0))
    return found


def hall(faces: int, seed: int = 0) -> World:
    """A floor of about that many faces with edges of 0.1 m, and a thing on each 12 square meters of
    it: a closed surface with its own vertices for each side, turned, and sunk by a centimeter."""
    random = np.random.default_rng(seed)
    side = 0.1 * np.sqrt(faces / 2)
    parts = [solids.floor((0, 0), (side, side), 0.1)]
    for _ in range(int(side * side / 12)):
        size = random.uniform((0.1, 0.1, 0.2), (4.0, 1.0, 3.0))
        lower = np.append(random.uniform(0.0, side - 1.0, 2), -0.01)
        thing = solids.box(lower, lower + size, separate_sides=True)
        parts.append(solids.turned(thing, random.uniform(0.0, 2 * np.pi), 2, lower))
    vertices, faces_of_all = solids.joined(*parts)
    return World(vertices.astype(np.float32), faces_of_all.astype(np.uint32), np.zeros((0, 3)))


def numpy_costs(name: str, mesh_map: MeshMap) -> Optional[np.ndarray]:
    """The costs of one layer, where NumPy has a short way; else None."""
    if name == "steepness":
        return np.arccos(np.clip(mesh_map.vertex_normals[:, 2], -1.0, 1.0))
    if name == "border":
        edges, number = peers.numpy_edges(mesh_map.faces)
        costs = np.zeros(len(mesh_map.vertices))
        costs[edges[number == 1]] = 1.0
        return costs
    return None


def inflation(world: World, repeats: int) -> List[Figure]:
    """Of lethal steps, at the released radii and at larger ones."""
    base = layer("height_diff", "HeightDiff", threshold=STEP)
    made = world.fresh_geometry()
    alone = map_with(made, [base])
    lethal = alone.layers["height_diff"].result.lethal
    found = []
    for inscribed, inflated in ((0.25, 0.4), (0.4, 1.0), (0.4, 3.0)):
        entry = layer(
            "inflation", "Inflation", inscribed_radius=inscribed, inflation_radius=inflated
        )
        mesh_map = map_with(made, [base, entry])
        inputs = {"height_diff": layer_input(mesh_map, "height_diff")}
        # Each has to begin anew: a layer looks at nothing but changes the next time.
        rest = iter([make_layers([entry]).layers["inflation"] for _ in range(repeats)])
        own, _ = timed(lambda: next(rest).evaluate(mesh_map, inputs), repeats)
        other, _ = timed(
            lambda: peers.scipy_distances(made.topology, made.edge_lengths, lethal, inflated), 1
        )
        floor = 250.0 if inflated <= 1.0 else None
        name = "inflation %g/%g m" % (inscribed, inflated)
        found.append(Figure(name, own, "ms", "SciPy dijkstra (along edges)", other, floor))
    return found


def layer_input(mesh_map: MeshMap, name: str) -> Any:
    """What a layer that reads this one gets."""
    return LayerInput(*mesh_map.layers[name].result, 1.0)


def combinations(world: World, repeats: int) -> List[Figure]:
    """Five layers into one, in each mode; weights of all edges."""
    random = np.random.default_rng(0)
    count = len(world.vertices)
    results: List[Any] = []
    for _ in range(5):
        costs = random.random(count).astype(np.float32)
        results.append((checked((costs, costs > 0.97), count), 0.7))
    layers = [(result.costs, result.lethal, factor) for result, factor in results]
    other, expected = timed(lambda: peers.numpy_combination(layers), repeats)
    found = []
    for mode in ("sum", "normalized", "max"):
        own, costs = timed(lambda mode=mode: Combination(results, count, mode).costs, repeats)
        if mode == "sum":
            np.testing.assert_allclose(costs, expected, rtol=1e-5)
        peer, value = ("NumPy", other) if mode == "sum" else ("", None)
        found.append(Figure("combination of 5 layers, %s" % mode, own, "ms", peer, value))
    return found


PARTS: Dict[str, Callable[[World, int], List[Figure]]] = {
    "geometry": geometry,
    "near": lambda world, repeats: radius_layers(world, repeats, 0.3, 600.0),
    "far": lambda world, repeats: radius_layers(world, min(repeats, 3), 1.0, 2000.0),
    "others": other_layers,
    "collision": collision,
    "inflation": inflation,
    "combination": combinations,
}

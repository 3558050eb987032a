#!/usr/bin/python3
"""Times of the kernels of mesh_map on a large mesh, beside NumPy and SciPy in the same run.

    topology_and_dijkstra.py [--faces 2000000] [--repeats 5] [--json FILE]

Prints the median of each and how much longer NumPy or SciPy takes. The mesh is the generated
outdoor world, of about half as many vertices as faces.
"""

import argparse
import json
import statistics
import sys
import time
from typing import Any, Callable, List, NamedTuple, Tuple

import numpy as np
from mesh_map.distance.dijkstra import DijkstraSolver
from mesh_map.geometry.topology import Topology, edge_lengths
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs.outdoor_world import outdoor_world
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components, dijkstra


class Row(NamedTuple):
    """A line of the table; reference and its time are of another library, None for none."""

    name: str
    milliseconds: float
    reference: str = ""
    reference_milliseconds: float = 0.0


def timed(action: Callable[[], Any], repeats: int) -> Tuple[float, Any]:
    """Median time of an action in milliseconds, and what it returned."""
    times, result = [], None
    for _ in range(repeats):
        start = time.perf_counter()
        result = action()
        times.append(time.perf_counter() - start)
    return 1000.0 * statistics.median(times), result


def numpy_edges(faces: np.ndarray) -> np.ndarray:
    """Unique edges by sorting pairs as 64-bit numbers."""
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    sides = np.sort(sides, axis=1).astype(np.uint64)
    keys = np.unique(sides[:, 0] << np.uint64(32) | sides[:, 1])
    return np.stack([keys >> np.uint64(32), keys & np.uint64(0xFFFFFFFF)], 1).astype(np.uint32)


def measure_mesh(vertices: np.ndarray, faces: np.ndarray, repeats: int) -> List[Row]:
    """Topology and lengths of edges."""
    count = len(vertices)
    time_one, _ = timed(lambda: Topology(faces=faces, vertex_count=count, threads=1), repeats)
    time_all, topology = timed(lambda: Topology(faces=faces, vertex_count=count), repeats)
    time_edges, edges = timed(lambda: numpy_edges(faces), 1)
    if not np.array_equal(edges, topology.edges):
        raise SystemExit("the edges differ from NumPy's")
    graph = csr_matrix(
        (np.ones(2 * topology.edge_count, np.int8), topology.neighbors, topology.neighbor_offsets),
        (count, count),
    )
    time_components, _ = timed(lambda: connected_components(graph, False), 1)
    reference = time_edges + time_components
    rows = [
        Row("topology", time_all, "np.unique + SciPy components", reference),
        Row("topology, one thread", time_one, "np.unique + SciPy components", reference),
    ]
    time_lengths, _ = timed(lambda: edge_lengths(vertices, topology.edges), repeats)
    time_reference, _ = timed(
        lambda: np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1), 1
    )
    rows.append(Row("edge lengths", time_lengths, "NumPy", time_reference))
    return rows


def measure_dijkstra(mesh_map: MeshMap, repeats: int) -> List[Row]:
    """The field from the vertex in the middle, and its beginning."""
    topology = mesh_map.topology
    lengths = edge_lengths(mesh_map.vertices, topology.edges)
    center = mesh_map.vertices.mean(axis=0, dtype=np.float64)
    source = mesh_map.nearest_vertex(center, np.inf)[0]
    time_graph, solver = timed(
        lambda: DijkstraSolver(topology=topology, edge_lengths=lengths), repeats
    )
    time_full, field = timed(lambda: solver.solve(source), repeats)
    near = np.abs(field.potential - 17.0)
    target = int(np.argmin(near))
    time_near, _ = timed(lambda: solver.solve(source, targets=[target], offset=0.3), repeats)
    costs = np.zeros(topology.vertex_count, np.float32)
    time_costs, _ = timed(lambda: solver.solve(source, costs, 1.0), repeats)

    updates = measure_updates(mesh_map, solver, source, repeats)

    weights = lengths[topology.neighbor_edges].astype(np.float64)
    shape = (topology.vertex_count, topology.vertex_count)
    matrix = csr_matrix((weights, topology.neighbors, topology.neighbor_offsets), shape)
    time_scipy, expected = timed(lambda: dijkstra(matrix, indices=source), min(repeats, 3))
    if not np.allclose(field.potential, expected, rtol=1e-4):
        raise SystemExit("the distances differ from SciPy's")
    scipy = "SciPy dijkstra"
    return [
        Row("Dijkstra, whole field", time_full, scipy, time_scipy),
        Row("Dijkstra, whole field with costs", time_costs, scipy, time_scipy),
        Row("Dijkstra, to a goal 17 m away", time_near, scipy, time_scipy),
        Row("Dijkstra, preparing the graph", time_graph),
    ] + updates


def measure_updates(
    mesh_map: MeshMap, solver: DijkstraSolver, source: int, repeats: int
) -> List[Row]:
    """A whole field follows obstacles of several sizes that come and go, beside a new one."""
    vertices = mesh_map.vertices
    free = np.zeros(len(vertices), np.float32)
    field = solver.solve(source, free, 1.0)
    time_new, _ = timed(lambda: solver.solve(source, free, 1.0), repeats)
    spread = np.where(np.isfinite(field.potential), field.potential, 0)
    center = vertices[np.argmin(np.abs(spread - spread.max() / 2))]
    distances = np.square(vertices - center).sum(axis=1)
    rows = []
    for count in (10, 100, 1_000, 10_000, 100_000):
        if count >= len(vertices):
            break
        changed = np.sort(np.argpartition(distances, count)[:count])
        blocked = free.copy()
        blocked[changed] = np.inf
        for costs in (free, blocked):
            costs.flags.writeable = False
        times = [
            timed(lambda costs=costs: field.update(costs, changed), 1)[0]
            for _ in range(repeats)
            for costs in (blocked, free)
        ]
        field.update(blocked, changed)
        if field.potential.tobytes() != solver.solve(source, blocked, 1.0).potential.tobytes():
            raise SystemExit("an update and a new field differ")
        field.update(free, changed)
        name = "Dijkstra, update at %d vertices" % count
        rows.append(Row(name, statistics.median(times), "new field", time_new))
    lengths = solver.edge_lengths.copy()
    lengths[:1000] *= 2
    time_weights, _ = timed(lambda: solver.with_weights(lengths), repeats)
    rows.append(Row("Dijkstra, 1000 other weights", time_weights))
    return rows


def table(rows: List[Row]) -> str:
    """The rows for people."""
    lines = ["%-36s %10s %10s  %s" % ("", "ms", "ratio", "beside")]
    for row in rows:
        ratio = "%.1f x" % (row.reference_milliseconds / row.milliseconds) if row.reference else ""
        beside = "%s: %.0f ms" % (row.reference, row.reference_milliseconds)
        line = (row.name, row.milliseconds, ratio, beside if row.reference else "")
        lines.append(("%-36s %10.1f %10s  %s" % line).rstrip())
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--faces", type=int, default=2_000_000, help="size of the mesh")
    parser.add_argument("--repeats", type=int, default=5, help="of which the median is taken")
    parser.add_argument("--json", help="file for the rows")
    arguments = parser.parse_args()
    if arguments.faces < 100 or arguments.repeats < 1:
        parser.error("at least 100 faces and 1 repeat")
    world = outdoor_world(faces=arguments.faces)
    mesh_map = MeshMap(world.vertices, world.faces)
    print("%s: %s" % (world.name, mesh_map.report()))
    rows = measure_mesh(mesh_map.vertices, mesh_map.faces, arguments.repeats)
    rows += measure_dijkstra(mesh_map, arguments.repeats)
    print(table(rows))
    if arguments.json:
        with open(arguments.json, "w", encoding="utf-8") as file:
            json.dump([row._asdict() for row in rows], file, indent=2)
    return 0


if __name__ == "__main__":
    sys.exit(main())

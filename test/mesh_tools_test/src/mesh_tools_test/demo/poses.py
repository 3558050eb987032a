"""Two poses on a map, far apart, with a way between them."""
import numpy as np

from mesh_map.dijkstra import DijkstraSolver
from mesh_map.topology import edge_lengths

FAR = 0.85  # of the longest way: its very ends lie in corners of the map


def free_components(topology, costs, cost_limit):
    """Vertices that can be driven on, grouped by the connected component of the mesh they lie in.

    :param costs: (V,) float32, combined costs; lethal, unknown and above cost_limit is not free
    :returns: free: (V,) bool; sizes: number of free vertices in each component
    """
    free = np.isfinite(costs) & (costs <= cost_limit)
    sizes = np.bincount(topology.components[free], minlength=topology.component_count)
    return free, sizes


def reachable_pair(mesh_map, cost_limit, attempts=12, seed=0):
    """Start and goal vertex, far apart and connected by free vertices, deterministic.

    Two sweeps of Dijkstra, as one finds the diameter of a tree, from several vertices of the
    component with most free vertices; the best pair is taken.

    :returns: (start, goal, length [m]) or None when no free vertex has a free neighbor
    """
    topology = mesh_map.topology
    free, sizes = free_components(topology, mesh_map.costs, cost_limit)
    if not free.any():
        return None
    candidates = np.flatnonzero(free & (topology.components == sizes.argmax()))
    lengths = edge_lengths(mesh_map.vertices, topology.edges)
    solver = DijkstraSolver(topology=topology, edge_lengths=lengths)
    random = np.random.default_rng(seed)
    best = None
    for vertex in random.choice(candidates, size=min(attempts, len(candidates)), replace=False):
        far, _ = farthest(solver, vertex, mesh_map.costs, cost_limit, 1.0)
        start, length = farthest(solver, far, mesh_map.costs, cost_limit, FAR)
        if start != far and (best is None or length > best[2]):
            best = int(start), int(far), length
    return best


def farthest(solver, source, costs, cost_limit, fraction):
    """The vertex at that fraction of the longest distance from source, and its distance [m]."""
    potential = solver.solve(
        source=int(source), vertex_costs=costs, cost_limit=cost_limit
    ).potential
    reached = np.flatnonzero(np.isfinite(potential))
    wanted = fraction * potential[reached].max()
    vertex = reached[np.abs(potential[reached] - wanted).argmin()]
    return int(vertex), float(potential[vertex])

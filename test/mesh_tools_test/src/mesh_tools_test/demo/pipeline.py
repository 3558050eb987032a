"""The steps of the demo before ROS, each a function; `prepare` puts them in order."""
import fcntl
import os
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import meshio
import numpy as np

from mesh_map.distance.dijkstra import DijkstraSolver
from mesh_map.geometry.topology import edge_lengths
from mesh_map.io.map_source import MapSource
from mesh_msgs.zoo import outdoor_world
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.map_file import MapFile

from mesh_tools_test.demo.layers import (
    EDGE_COST_FACTOR,
    FLOWER_BED,
    FOR_FILES,
    FOR_SCANS,
    FOR_WORLD,
    MAX_EDGE_LENGTH,
    flower_bed,
)
from mesh_tools_test.demo.processes import DemoError
from mesh_tools_test.demo.results import SUCCESS
from mesh_tools_test.demo.scans import are_scans, reconstruct

COST_LIMIT = 1.0  # default of the released planners
FAR = 0.85  # of the longest way: its very ends lie in corners of the map


class Prepared(NamedTuple):
    """What the steps before ROS have made; start and goal: (3,) meters, as max_edge_length."""

    path: Path
    mesh_map: Any
    layers: Any
    max_edge_length: float
    start: np.ndarray
    goal: np.ndarray


def generate_world(report, path, faces, seed):
    """Write the generated outdoor world as a PLY file; returns its places, name -> (x, y, z)."""
    with report.step("generate a world") as notes:
        world = outdoor_world(faces=faces, seed=seed)
        colors = dict(zip(("red", "green", "blue"), np.ascontiguousarray(world.colors.T)))
        meshio.write_points_cells(
            path, world.vertices, [("triangle", world.faces.astype(np.int32))], point_data=colors
        )
        notes.append(f"{path.name}, seed {seed}")
    return world.places


def import_file(report, file):
    """A mesh file of any format that mesh_tool imports, as a Mesh."""
    with report.step("import") as notes:
        mesh, found = read_mesh(file)
        notes.append(f"{file.name}: {len(mesh.vertices):,} vertices, {len(mesh.faces):,} triangles")
        notes += found.notes
    return mesh


def save_geometry(report, mesh, path):
    """Write geometry, colors and labels to one HDF5 file, and open it."""
    with report.step("save the mesh") as notes:
        MapFile.write(path, mesh)
        source = MapSource(str(path))
        notes.append(f"{path.name}, {path.stat().st_size / 1e6:.1f} MB")
    return source


def compute_layers(report, source, layers, max_edge_length):
    """The layered map of a file; what is unusual in its mesh is reported, nothing is repaired."""
    with report.step("topology") as notes:
        mesh_map = source.make_map(max_edge_length=max_edge_length)
        notes.append(mesh_map.report())
    with report.step("layers") as notes:
        mesh_map.set_settings(edge_cost_factor=EDGE_COST_FACTOR)
        mesh_map.compute_layers(layers)
        if mesh_map.layer_errors:
            name, reason = next(iter(mesh_map.layer_errors.items()))
            raise DemoError(f"layer {name} cannot be computed: {reason}")
        count = len(mesh_map.vertices)
        for name, layer in mesh_map.layers.items():
            lethal = 100.0 * np.count_nonzero(layer.result.lethal) / count
            notes.append(f"{name} {lethal:.1f} %")
        lethal = 100.0 * np.count_nonzero(np.isposinf(mesh_map.costs)) / count
        notes.append(f"together {lethal:.1f} % of the vertices lethal")
    return mesh_map


def index_faces(report, mesh_map):
    """Build the spatial index, and say which back end answers batches of queries."""
    with report.step("spatial index") as notes:
        index = mesh_map.spatial_index
        index.wait_for_device()
        notes.append(f"{index.memory / 1e6:.1f} MB; {index.device}")


def save_layers(report, source, mesh_map):
    """Add the layers with their parameters to the map file, where the server finds them."""
    with report.step("save the layers") as notes:
        names = source.save_layers(mesh_map.layers)
        notes.append(f"{len(names)}; {os.path.getsize(source.path) / 1e6:.1f} MB")


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


def choose_poses(report, mesh_map, places):
    """Start and goal [m]: the places of the generated world, or two far but connected vertices."""
    with report.step("choose poses") as notes:
        if places:
            start, goal = np.asarray(places["start"]), np.asarray(places["goal"])
            notes.append("the generated world's own")
        else:
            pair = reachable_pair(mesh_map, COST_LIMIT)
            if pair is None:
                raise DemoError(
                    "no way to plan: no edge of the map has two free ends; the layers find every "
                    "vertex lethal (is the mesh in meters, with z up?)"
                )
            start, goal = mesh_map.vertices[pair[0]], mesh_map.vertices[pair[1]]
            component = mesh_map.topology.components[pair[0]]
            notes.append(
                f"component {component} of {mesh_map.geometry.topology.component_count}, "
                f"{pair[2]:.1f} m apart along the edges"
            )
        notes.append(f"from {format_point(start)} to {format_point(goal)}")
    return start, goal


def format_point(point):
    """(x, y, z) with centimeters."""
    return "({:.2f}, {:.2f}, {:.2f})".format(*point)


@contextmanager
def output_folder(output):
    """The folder for all results, made if need be; no other demo writes there meanwhile.

    What an earlier run says of its success is removed.
    """
    try:
        (output / "logs").mkdir(parents=True, exist_ok=True)
        # not the folder of the map: MapFile locks that one itself while it saves
        folder = os.open(output / "logs", os.O_RDONLY | os.O_DIRECTORY)
    except OSError as error:
        reason = error.strerror.lower()
        raise DemoError(
            f"{output}: not usable as folder ({reason}); choose another --output"
        ) from error
    try:
        try:
            fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise DemoError(f"another demo is writing to {output}; choose another --output")
        for name in SUCCESS:
            (output / name).unlink(missing_ok=True)
        yield
    finally:
        os.close(folder)


def prepare(report, output, file, faces, seed):
    """Everything before ROS: mesh, layers, map file, poses."""
    places, layers, max_edge_length = None, FOR_FILES, 0.0
    if file is None:
        file = output / "outdoor_world.ply"
        places = generate_world(report, file, faces, seed)
        layers, max_edge_length = FOR_WORLD, MAX_EDGE_LENGTH
    path = output / (file.stem + ".h5")
    if path.exists() and file.exists() and path.samefile(file):
        raise DemoError(f"{file} is the demo's own output; choose another --output folder")
    if are_scans(file):
        mesh, layers = reconstruct(report, file, path), FOR_SCANS
    else:
        mesh = import_file(report, file)
    if places:
        mesh.labels[FLOWER_BED] = flower_bed(mesh, places["start"], places["goal"])
    source = save_geometry(report, mesh, path)
    mesh_map = compute_layers(report, source, layers, max_edge_length)
    index_faces(report, mesh_map)
    save_layers(report, source, mesh_map)
    start, goal = choose_poses(report, mesh_map, places)
    return Prepared(path, mesh_map, layers, max_edge_length, start, goal)

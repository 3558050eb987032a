"""The steps of the demo before ROS, each a function; `prepare` puts them in order."""
import fcntl
import os
from contextlib import contextmanager

import meshio
import numpy as np

from mesh_map import MeshMap
from mesh_msgs.zoo import outdoor_world
from mesh_msgs_hdf5.importer import read_mesh
from mesh_msgs_hdf5.map_file import MapFile

from mesh_tools_test.demo.poses import reachable_pair
from mesh_tools_test.demo.processes import DemoError

COST_LIMIT = 1.0  # default of the released planners
LAYERS = [{"name": "height_diff", "type": "mesh_layers/HeightDiffLayer", "params": {}}]


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


def compute_layers(report, mesh):
    """The layered map of a mesh; what is unusual in it is reported, nothing is repaired."""
    with report.step("topology") as notes:
        mesh_map = MeshMap(
            mesh.vertices, mesh.faces, vertex_normals=mesh.vertex_normals, frame_id=mesh.frame_id
        )
        notes.append(mesh_map.report())
    with report.step("layers") as notes:
        mesh_map.compute_layers(LAYERS)
        for name, layer in mesh_map.layers.items():
            lethal = np.count_nonzero(layer.result.lethal)
            notes.append(
                f"{name}: {100.0 * lethal / len(mesh.vertices):.1f} % of the vertices lethal"
            )
    return mesh_map


def index_faces(report, mesh_map):
    """Build the spatial index, and say which back end answers batches of queries."""
    with report.step("spatial index") as notes:
        index = mesh_map.spatial_index
        index.wait_for_device()
        notes.append(f"{index.memory / 1e6:.1f} MB; {index.device}")


def save_map(report, mesh, mesh_map, path):
    """Write geometry, colors and layers with their parameters to one HDF5 file."""
    with report.step("save") as notes:
        MapFile.write(path, mesh)
        layers = {
            name: (layer.result.costs, layer.identity)
            for name, layer in mesh_map.layers.items()
        }
        MapFile(path).write_layers(layers)
        notes.append(f"{path.name}, {path.stat().st_size / 1e6:.1f} MB")


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
                f"component {component} of {mesh_map.topology.component_count}, "
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
        for name in ("rviz.png", "report.md"):
            (output / name).unlink(missing_ok=True)
        yield
    finally:
        os.close(folder)


def prepare(report, output, file, faces, seed):
    """Everything before ROS: mesh, layers, map file, poses.

    :returns: map file, mesh map, start (3,), goal (3,)
    """
    places = None
    if file is None:
        file = output / "outdoor_world.ply"
        places = generate_world(report, file, faces, seed)
    path = output / (file.stem + ".h5")
    if path.exists() and file.exists() and path.samefile(file):
        raise DemoError(f"{file} is the demo's own output; choose another --output folder")
    mesh = import_file(report, file)
    mesh_map = compute_layers(report, mesh)
    index_faces(report, mesh_map)
    save_map(report, mesh, mesh_map, path)
    start, goal = choose_poses(report, mesh_map, places)
    return path, mesh_map, start, goal

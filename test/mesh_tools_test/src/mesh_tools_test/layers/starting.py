"""Start of the node from a file with stored layers, and memory."""

import json
import os
import subprocess
import sys
import tempfile
from typing import Any, Callable, Dict, List

from mesh_map.io.map_source import MapSource
from mesh_msgs import arrays
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh

from mesh_tools_test.base.figures import Figure, timed
from mesh_tools_test.base.noisy_world import STEP, World, layer
from mesh_tools_test.base.server_start import arrivals, executable

CONFIG = [
    layer("height_diff", "HeightDiff", threshold=STEP),
    layer("roughness", "Roughness", threshold=1.2),
    layer("steepness", "Steepness", threshold=1.2),
    layer("border", "Border"),
    layer("inflation", "Inflation", inscribed_radius=0.3, inflation_radius=0.8),
]
MIB = 1 << 20

# A process that loads a map and keeps it; prints its memory before and after, in bytes.
_LOADING = """
import json, sys
import numpy, mesh_map.io.map_source
def memory(name):
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith(name)) * 1024
before = memory("VmRSS")
source = mesh_map.io.map_source.MapSource(sys.argv[1])
made = source.make_map()
made.compute_layers(json.loads(sys.argv[2]), None, source.stored_costs)
made.planning_costs().edge_weights
assert not made.layer_errors
print(json.dumps([memory("VmRSS") - before, memory("VmHWM") - before]))
"""


def stored_map(world: World, path: str) -> None:
    """A map file with all layers of CONFIG."""
    MapFile.write(
        path, Mesh(vertices=world.vertices, faces=world.faces, vertex_colors=world.colors)
    )
    source = MapSource(path)
    mesh_map = source.make_map()
    mesh_map.compute_layers(CONFIG)
    if mesh_map.layer_errors:
        raise RuntimeError("layers are left out: %s" % mesh_map.layer_errors)
    source.save_layers(mesh_map.layers)


def node_start(path: str) -> List[float]:
    """Seconds until each message has arrived, of the node mesh_map; once in a process."""
    names: List[str] = [str(entry["name"]) for entry in CONFIG]
    entries = [{"name": entry["name"], "type": entry["type"]} for entry in CONFIG]
    command = [executable("mesh_map", "mesh_map"), "_mesh_file:=" + path]
    command.append("_layers:=" + json.dumps(entries))
    for entry in CONFIG:
        for key, value in entry["params"].items():
            command.append("_%s/%s:=%s" % (entry["name"], key, value))
    return arrivals(
        command,
        [
            ("mesh_map/mesh", arrays.MeshGeometryStamped, 1),
            ("mesh_map/vertex_colors", arrays.MeshVertexColorsStamped, 1),
            ("mesh_map/vertex_costs", arrays.MeshVertexCostsStamped, len(names) + 1),
        ],
    )


def start(world: World, repeats: int) -> List[Figure]:
    """The node with stored layers, and a map without a node; memory."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "map.h5")
        stored_map(world, path)
        runs = []
        for _ in range(repeats):
            command = [sys.executable, "-m", "mesh_tools_test.layers.starting", path]
            output = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout
            runs.append(json.loads(output.decode().splitlines()[-1]))

        def loaded(stored: bool) -> Any:
            source = MapSource(path)
            made = source.make_map()
            made.compute_layers(CONFIG, None, source.stored_costs if stored else None)
            return made

        anew, _ = timed(lambda: loaded(False), 1)
        again, _ = timed(lambda: loaded(True), repeats)
        command = [sys.executable, "-c", _LOADING, path, json.dumps(CONFIG)]
        output = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout
        kept, peak = json.loads(output.decode())
    last = 1000 * sorted(run[-1] for run in runs)[len(runs) // 2]
    first = 1000 * sorted(run[0] for run in runs)[len(runs) // 2]
    return [
        Figure("node: start to the mesh", first, "ms"),
        Figure("node: start to all topics", last, "ms", floor=1500.0),
        Figure("map with stored layers", again, "ms", "layers computed", anew),
        Figure("memory of a map with 5 layers", kept / MIB, "MiB"),
        Figure("  at most while loading", peak / MIB, "MiB"),
    ]


PARTS: Dict[str, Callable[[World, int], List[Figure]]] = {"start": start}

if __name__ == "__main__":
    print(json.dumps(node_start(sys.argv[1])))

#!/usr/bin/python3
"""Times and sizes of the map file, beside plain h5py and meshio in the same run.

    map_file.py [--faces 2000000] [--repeats 3] [--only PART ...] [--folder DIR] [--json FILE]

Prints for each figure the reference beside it and how many times better ours is. Parts: storage,
map, isolation, import, memory, server. The mesh is generated: half as many vertices as faces, with
normals, colors and five layers. What is read is compared with what was written.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Tuple

import h5py
import numpy as np
from mesh_msgs_hdf5.map_file.hdf5 import chunks
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.isolation import IsolatedMapFile
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_tools_test.base.large_map import large_map, write_ply
from mesh_tools_test.base.server_start import start_to_messages

LAYER = "height_diff"
SLICE = 10_000
ISOLATED_FACES = 200_000  # of the map that is read in a process of its own: 100,000 vertices
Arrays = Dict[str, np.ndarray]


class Row(NamedTuple):
    """A line of the table; ratio: how many times better than the reference, None for none."""

    name: str
    value: float
    unit: str
    reference: str = ""
    ratio: Optional[float] = None
    target: str = ""


def timed(action: Callable[[], Any], repeats: int) -> Tuple[float, Any]:
    """Median time of an action in seconds, and what it returned."""
    times, result = [], None
    for _ in range(repeats):
        start = time.perf_counter()
        result = action()
        times.append(time.perf_counter() - start)
    return statistics.median(times), result


def timed_beside(
    action: Callable[[], Any], reference: Callable[[], Any], repeats: int
) -> Tuple[float, float]:
    """Median times in seconds of two actions, by turns.

    Each is run once before: who comes first would pay for memory that the other finds ready.
    """
    action(), reference()
    pairs = [(timed(action, 1)[0], timed(reference, 1)[0]) for _ in range(repeats)]
    ours, theirs = zip(*pairs)
    return statistics.median(ours), statistics.median(theirs)


def arrays_of(mesh: Mesh) -> Arrays:
    """The arrays of a mesh by name."""
    arrays = {"vertices": mesh.vertices, "faces": mesh.faces}
    arrays.update({"normals": mesh.vertex_normals, "colors": mesh.vertex_colors})
    arrays.update(mesh.vertex_costs)
    return arrays


def size_of(arrays: Arrays) -> int:
    return sum(array.nbytes for array in arrays.values())


def require_same(found: Arrays, expected: Arrays) -> None:
    """Ends the benchmark unless all are the same bytes."""
    for name, array in expected.items():
        if found[name].dtype != array.dtype or found[name].tobytes() != array.tobytes():
            sys.exit("error: %s is not what was written" % name)


def write(path: str, arrays: Arrays, store: Callable[[h5py.File, str, np.ndarray], Any]) -> int:
    """A file with all arrays; returns its size."""
    with h5py.File(path, "w") as file:
        for name, array in arrays.items():
            store(file, name, array)
    return os.path.getsize(path)


def read(path: str, load: Callable[[h5py.Dataset], np.ndarray], only: str = "") -> Arrays:
    with h5py.File(path, "r") as file:
        return {name: load(file[name]) for name in ([only] if only else file)}


def plain(dataset: h5py.Dataset) -> np.ndarray:
    return dataset[()]


def shuffled(level: int) -> Dict[str, Any]:
    return {"compression": "gzip", "compression_opts": level, "shuffle": True}


def rows_of_chunk(array: np.ndarray) -> Tuple[int, ...]:
    return (min(len(array), chunks.CHUNK_ROWS),) + array.shape[1:]


def measure_writing(arrays: Arrays, folder: str, repeats: int) -> List[Row]:
    """Files that are left in the folder: ours.h5, none.h5, h5py.h5, lvr2.h5."""
    writers = {
        "ours": lambda f, n, a: chunks.store(f, n, a),
        "none": lambda f, n, a: chunks.store(f, n, a, compression="none"),
        "h5py": lambda f, n, a: f.create_dataset(n, data=a, chunks=rows_of_chunk(a), **shuffled(1)),
        "lvr2": lambda f, n, a: f.create_dataset(
            n, data=a, chunks=a.shape, compression="gzip", compression_opts=9
        ),
    }
    seconds, sizes = {}, {}
    for name, store in writers.items():
        path = os.path.join(folder, name + ".h5")
        often = repeats if name in ("ours", "none") else 1
        seconds[name], sizes[name] = timed(lambda p=path, s=store: write(p, arrays, s), often)
    whole = size_of(arrays)
    speed = {name: whole / 1e6 / value for name, value in seconds.items()}
    ratio = {name: whole / value for name, value in sizes.items()}
    gzip_1, gzip_9 = "h5py gzip 1 + shuffle", "h5py gzip 9, one chunk, as LVR2"
    return [
        Row("write", speed["ours"], "MB/s", gzip_1, speed["ours"] / speed["h5py"], ">= 250, 3 x"),
        Row("write", speed["ours"], "MB/s", gzip_9, speed["ours"] / speed["lvr2"], "12 x"),
        Row("write, compression none", speed["none"], "MB/s"),
        Row("ratio", ratio["ours"], "", gzip_1, ratio["ours"] / ratio["h5py"], ">= 1.55"),
        Row("ratio", ratio["ours"], "", gzip_9, ratio["ours"] / ratio["lvr2"]),
    ]


def measure_reading(arrays: Arrays, folder: str, repeats: int) -> List[Row]:
    """The files of measure_writing."""
    rows = []
    for name, target in (("ours", "<= 250"), ("none", ""), ("lvr2", "")):
        path = os.path.join(folder, name + ".h5")
        require_same(read(path, chunks.load), arrays)
        ours, h5py_alone = timed_beside(
            lambda p=path: read(p, chunks.load), lambda p=path: read(p, plain), repeats
        )
        what = "read all, file of " + name
        rows.append(Row(what, 1e3 * ours, "ms", "h5py", h5py_alone / ours, target))
    path = os.path.join(folder, "ours.h5")
    ours, h5py_alone = timed_beside(
        lambda: read(path, chunks.load, LAYER), lambda: read(path, plain, LAYER), 3 * repeats
    )
    rows.append(Row("read one layer", 1e3 * ours, "ms", "h5py", h5py_alone / ours, "<= 15"))
    none, _ = timed(lambda: read(os.path.join(folder, "none.h5"), chunks.load, LAYER), 3 * repeats)
    rows.append(Row("read one layer, compression none", 1e3 * none, "ms", target="<= 2"))
    first = arrays[LAYER].shape[0] // 2
    part, found = timed(lambda: read(path, lambda d: d[first : first + SLICE], LAYER), 3 * repeats)
    require_same(found, {LAYER: arrays[LAYER][first : first + SLICE]})
    rows.append(Row("read %d of a layer" % SLICE, 1e3 * part, "ms", "all of it", ours / part))
    return rows


def measure_map(mesh: Mesh, folder: str, repeats: int) -> List[Row]:
    """MapFile, which also checks, verifies and syncs what it saves."""
    arrays = arrays_of(mesh)
    path = os.path.join(folder, "map.h5")
    writing, file = timed(lambda: MapFile.write(path, mesh), repeats)
    speed = size_of(arrays) / 1e6 / writing
    opening, _ = timed(lambda: MapFile(path), 3 * repeats)
    reading, found = timed(lambda: MapFile(path).read(), repeats)
    require_same(arrays_of(found), arrays)
    one, _ = timed(lambda: file.vertex_costs(LAYER), 3 * repeats)
    edit, _ = timed(lambda: file.write_layers({"edited": (mesh.vertex_costs[LAYER], {})}), repeats)
    MapFile.write(path, mesh)
    return [
        Row("MapFile.write: check, save, verify, sync", speed, "MB/s"),
        Row("MapFile(path)", 1e3 * opening, "ms"),
        Row("MapFile.read: all, checked", 1e3 * reading, "ms", target="<= 250"),
        Row("MapFile.vertex_costs", 1e3 * one, "ms", "MapFile.read", reading / one, "<= 15"),
        Row("MapFile.write_layers", 1e3 * edit, "ms", "MapFile.write", writing / edit),
    ]


def measure_isolation(folder: str, repeats: int) -> List[Row]:
    """A map of 100,000 vertices read in a process of its own, beside reading it here."""
    path = os.path.join(folder, "small.h5")
    MapFile.write(path, large_map(ISOLATED_FACES))
    apart, here = timed_beside(
        lambda: IsolatedMapFile(path).read(), lambda: MapFile(path).read(), 5 * repeats
    )
    what, target = "IsolatedMapFile.read, 100,000 vertices", ">= 0.5 x"
    rows = [Row(what, 1e3 * apart, "ms", "MapFile.read", here / apart, target)]

    def one_by_one(file):
        return file.vertices, file.faces, file.vertex_normals, file.vertex_costs(LAYER)

    def apart_one_by_one():
        with IsolatedMapFile(path) as file:
            return one_by_one(file)

    apart, here = timed_beside(apart_one_by_one, lambda: one_by_one(MapFile(path)), 5 * repeats)
    what = "IsolatedMapFile: four members, one process"
    return rows + [Row(what, 1e3 * apart, "ms", "MapFile", here / apart)]


def measure_import(mesh: Mesh, folder: str, repeats: int) -> List[Row]:
    """A binary PLY, beside meshio."""
    import meshio  # slow to import

    path = os.path.join(folder, "mesh.ply")
    write_ply(path, mesh)
    ours, (found, _) = timed(lambda: read_mesh(path), repeats)
    require_same(arrays_of(found), {"vertices": mesh.vertices, "faces": mesh.faces})
    theirs, other = timed(lambda: meshio.read(path), repeats)
    if not np.array_equal(other.points, mesh.vertices):
        sys.exit("error: meshio reads other vertices")
    return [Row("import of a binary PLY", 1e3 * ours, "ms", "meshio", theirs / ours, ">= 2 x")]


def resident_bytes(what: str) -> int:
    """Memory of this process: VmRSS now, VmHWM at most."""
    with open("/proc/self/status", encoding="ascii") as file:
        return next(1024 * int(line.split()[1]) for line in file if line.startswith(what + ":"))


def print_peak(action: str, path: str) -> None:
    """In a process of its own: prints the peak of reading or writing a map, over all arrays."""
    before = resident_bytes("VmRSS")
    mesh = MapFile(path).read()
    if action == "write":
        with open("/proc/self/clear_refs", "w", encoding="ascii") as file:
            file.write("5")  # the peak begins anew
        MapFile.write(path + ".copy", mesh)
    print((resident_bytes("VmHWM") - before) / size_of(arrays_of(mesh)))


def measure_memory(mesh: Mesh, folder: str) -> List[Row]:
    """Peaks of child processes, the arrays themselves included."""
    path = os.path.join(folder, "map.h5")
    MapFile.write(path, mesh)
    rows = []
    for action in ("read", "write"):
        command = [sys.executable, os.path.abspath(__file__), "--peak", action, path]
        printed = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout
        what = "peak memory of MapFile.%s" % action
        rows.append(Row(what, float(printed), "x", "the arrays", target="<= 2.5 x"))
    return rows


def measure_server(mesh: Mesh, folder: str) -> List[Row]:
    """From the start of the node to its first and last latched message."""
    path = os.path.join(folder, "map.h5")
    MapFile.write(path, mesh)
    imports = [sys.executable, "-c", "import rospy, h5py, mesh_msgs.arrays"]
    python, _ = timed(lambda: subprocess.run(imports, check=True), 3)
    first, last = start_to_messages(path, True, len(mesh.vertex_costs))
    beside = "Python importing rospy and h5py"
    return [
        Row("hdf5_map_server: first message", 1e3 * first, "ms", beside, python / first),
        Row("hdf5_map_server: last message", 1e3 * last, "ms", beside, python / last),
    ]


def table(rows: List[Row]) -> str:
    """The rows for people."""
    lines = ["%-42s %10s %-5s %8s  %s" % ("", "", "", "better", "than")]
    for row in rows:
        ratio = "%.2f x" % row.ratio if row.ratio is not None else ""
        target = "(target %s)" % row.target if row.target else ""
        line = "%-42s %10.2f %-5s %8s  %s " % (row.name, row.value, row.unit, ratio, row.reference)
        lines.append((line + target).rstrip())
    return "\n".join(lines)


def main() -> int:
    """Command line."""
    parts = ("storage", "map", "isolation", "import", "memory", "server")
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--faces", type=int, default=2_000_000, help="size of the mesh")
    parser.add_argument("--repeats", type=int, default=3, help="of which the median is taken")
    parser.add_argument("--only", nargs="+", choices=parts, default=parts, metavar="PART")
    parser.add_argument("--folder", help="where the files are written; default: a temporary one")
    parser.add_argument("--json", metavar="FILE", help="also write the figures there")
    parser.add_argument("--peak", nargs=2, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.peak:
        print_peak(*options.peak)
        return 0
    mesh = large_map(options.faces)
    arrays = arrays_of(mesh)
    print(
        "%d vertices, %d faces, %d layers: %.1f MB; medians of %d"
        % (
            len(mesh.vertices),
            len(mesh.faces),
            len(mesh.vertex_costs),
            size_of(arrays) / 1e6,
            options.repeats,
        )
    )
    rows: List[Row] = []
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        if "storage" in options.only:
            rows += measure_writing(arrays, folder, options.repeats)
            rows += measure_reading(arrays, folder, options.repeats)
        if "map" in options.only:
            rows += measure_map(mesh, folder, options.repeats)
        if "isolation" in options.only:
            rows += measure_isolation(folder, options.repeats)
        if "import" in options.only:
            rows += measure_import(mesh, folder, options.repeats)
        if "memory" in options.only:
            rows += measure_memory(mesh, folder)
        if "server" in options.only:
            rows += measure_server(mesh, folder)
    print(table(rows))
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump([row._asdict() for row in rows], file, indent=2)
    return 0


if __name__ == "__main__":
    sys.exit(main())

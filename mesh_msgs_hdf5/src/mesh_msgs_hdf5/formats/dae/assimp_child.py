"""Runs assimp in a process of its own, so that a file that makes it crash is an error like any."""
import contextlib
import json
import os
import resource
import signal
import subprocess
import sys
from typing import Any, Dict, List, Tuple

import numpy as np

from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.base.scene import Scene
from mesh_msgs_hdf5.formats.dae.assimp import Material, read_scene
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

# -I: not the modules of the current folder, but those of this process
_PROGRAM = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from mesh_msgs_hdf5.formats.dae.assimp_child import answer
answer(sys.argv[2])
"""
_CONVERT = "convert it to PLY or OBJ where it was made"
_ARRAYS = ("positions", "faces", "face_materials", "normals", "colors", "coordinates", "known")
# what the child may use: for any file, and for each byte of it
SECONDS, SECONDS_PER_BYTE = 60, 5e-6
_MEMORY, _MEMORY_PER_BYTE = 2 << 30, 100


def scene_of(path: PathLike, report: ImportReport) -> Tuple[Scene, List[Material]]:
    """What assimp.read_scene returns, notes and refuses, read in a child process.

    The child may use an amount of time and memory that goes with the size of the file.
    """
    path = os.fsdecode(path)
    search = json.dumps([place for place in sys.path if place])
    seconds = SECONDS + SECONDS_PER_BYTE * os.stat(path).st_size
    try:
        result = subprocess.run(
            [sys.executable, "-I", "-c", _PROGRAM, search, path],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            check=False,
            timeout=seconds,
        )
    except subprocess.TimeoutExpired as error:
        reason = "assimp did not read it in %d seconds" % seconds
        raise MapFileError("size", path, reason, _CONVERT) from error
    if result.returncode < 0:
        reason = "assimp crashed while reading it (%s)" % _signal_name(-result.returncode)
        raise MapFileError("damaged", path, reason, _CONVERT)
    if result.returncode:
        reason = result.stderr.decode("utf-8", "replace").strip().rpartition("\n")[2]
        raise MapFileError("format", path, "assimp cannot read it: %s" % reason, _CONVERT)
    line, _, data = result.stdout.partition(b"\n")
    head = json.loads(line)
    if "error" in head:
        raise MapFileError(head["error"][0], path, *head["error"][1:])
    report.notes += head["notes"]
    return Scene(**_arrays(head["arrays"], data)), head["materials"]


def _arrays(shapes: Dict[str, Any], data: bytes) -> Dict[str, np.ndarray]:
    found, at = {}, 0
    for name, (kind, shape) in shapes.items():
        count = int(np.prod(shape))
        found[name] = np.frombuffer(data, kind, count, at).reshape(shape)
        at += found[name].nbytes
    return found


def answer(path: str) -> None:
    """The child: one line of JSON on standard output, behind it the bytes of the arrays."""
    _limit_memory(path)
    report = ImportReport(path, "DAE")
    arrays: Dict[str, np.ndarray] = {}
    try:
        scene, materials = read_scene(path, report)
        for name in _ARRAYS:
            if getattr(scene, name) is not None:
                arrays[name] = np.ascontiguousarray(getattr(scene, name))
        head = {
            "notes": report.notes,
            "materials": materials,
            "arrays": {name: (a.dtype.str, a.shape) for name, a in arrays.items()},
        }
    except MapFileError as error:
        head = {"error": [error.code, error.message, error.hint]}
    sys.stdout.buffer.write(json.dumps(head).encode() + b"\n")
    for array in arrays.values():
        sys.stdout.buffer.write(array.data if array.size else b"")
    sys.stdout.buffer.flush()


def _limit_memory(path):
    """Above what the process has now; a system that does not tell has no limit."""
    with contextlib.suppress(OSError, ValueError):
        with open("/proc/self/statm", "rb") as stream:
            now = int(stream.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
        most = now + _MEMORY + _MEMORY_PER_BYTE * os.stat(path).st_size
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        if hard == resource.RLIM_INFINITY or most < hard:
            resource.setrlimit(resource.RLIMIT_AS, (most, hard))


def _signal_name(number):
    try:
        return signal.Signals(number).name
    except ValueError:
        return "signal %d" % number

"""Runs assimp in a process of its own, so that a file that makes it crash is an error like any."""
import json
import os
import signal
import subprocess
import sys

import numpy as np

from mesh_msgs_hdf5.formats.assimp import read_corners
from mesh_msgs_hdf5.errors import MapFileError, PathLike
from mesh_msgs_hdf5.report import ImportReport

# -I: not the modules of the current folder, but those of this process
_PROGRAM = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from mesh_msgs_hdf5.formats.assimp_child import answer
answer(sys.argv[2])
"""
_CONVERT = "convert it to PLY or OBJ where it was made"


def corners_of_scene(path: PathLike, report: ImportReport) -> np.ndarray:
    """What assimp.read_corners returns, notes and refuses, read in a child process."""
    path = os.fsdecode(path)
    search = json.dumps([place for place in sys.path if place])
    result = subprocess.run(
        [sys.executable, "-I", "-c", _PROGRAM, search, path],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        check=False,
    )
    if result.returncode < 0:
        reason = "assimp crashed while reading it (%s)" % _signal_name(-result.returncode)
        raise MapFileError("damaged", path, reason, _CONVERT)
    if result.returncode:
        reason = result.stderr.decode("utf-8", "replace").strip().rpartition("\n")[2]
        raise MapFileError("format", path, "assimp cannot read it: %s" % reason, _CONVERT)
    line, _, corners = result.stdout.partition(b"\n")
    head = json.loads(line)
    if "error" in head:
        raise MapFileError(head["error"][0], path, *head["error"][1:])
    report.notes += head["notes"]
    return np.frombuffer(corners, np.float64).reshape(-1, 3)


def answer(path: str) -> None:
    """The child: one line of JSON on standard output, behind it the corners' bytes."""
    report = ImportReport(path, "DAE")
    corners = np.zeros((0, 3))
    try:
        corners = read_corners(path, report)
        head = {"notes": report.notes}
    except MapFileError as error:
        head = {"error": [error.code, error.message, error.hint]}
    sys.stdout.buffer.write(json.dumps(head).encode() + b"\n")
    sys.stdout.buffer.write(np.ascontiguousarray(corners, np.float64))
    sys.stdout.buffer.flush()


def _signal_name(number):
    try:
        return signal.Signals(number).name
    except ValueError:
        return "signal %d" % number

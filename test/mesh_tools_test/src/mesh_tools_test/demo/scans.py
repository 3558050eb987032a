"""Scans as what the demo begins with: the map is made of them by the command that users have."""
import argparse
import contextlib
import io
import json
import sys

from mesh_map.commands import reconstruct as command
from mesh_map.scans.cloud_files import SUFFIXES
from mesh_msgs_hdf5.labels.map_contents import open_map
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_navigation.simulation.parameters import PARAMETERS

from mesh_tools_test.demo.processes import DemoError

# A .ply may be a mesh: it is imported, or refused with the way to reconstruct it.
SCANS = (".bag", *(suffix for suffix in SUFFIXES if suffix != ".ply"))
# The simulated robot needs these for itself.
_ROBOT_FRAMES = {each.default for each in PARAMETERS if each.name.endswith("_frame")}
_STOPPED = 128  # exit codes above: by a signal


def are_scans(file):
    """Whether a file, or a folder of clouds, has to be reconstructed."""
    return file.is_dir() or file.name.lower().endswith(SCANS)


def reconstruct(report, file, path):
    """Make a map file of scans, and return its Mesh, in a frame that the robot has no use for.

    :raises DemoError: with the reason and the way out, where the command makes no map of it
    :raises SystemExit: it was stopped by a signal
    """
    with report.step("reconstruct") as notes:
        made = _run(file, path)
        said = "{}: {scans} scans, {points:,} points, {faces:,} triangles"
        notes += [said.format(file.name, **made), *made["notes"]]
        mesh = open_map(made["output"]).members.read()
        if mesh.frame_id in _ROBOT_FRAMES:
            notes.append(f"frame {mesh.frame_id}, which the simulated robot has, became map")
            mesh.frame_id = "map"
    return mesh


def _run(file, path):
    """What the command says of its work, as JSON has it."""
    parser = argparse.ArgumentParser(prog="reconstruct")
    command.add_arguments(parser)
    words = ["--force", "--no-state", "--json", "--", str(file), str(path)]
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said):
            code = command.run(parser.parse_args(words))
    except MapFileError as error:
        way = f"rosrun mesh_map reconstruct {file} {path.name} ..., then ./run demo {path.name}"
        raise DemoError(f"{error}; with options: {way}") from error
    except KeyboardInterrupt:
        sys.exit(_STOPPED + 2)
    if code > _STOPPED:
        sys.exit(code)
    return json.loads(said.getvalue())

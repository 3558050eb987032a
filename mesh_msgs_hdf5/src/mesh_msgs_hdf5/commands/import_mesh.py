"""mesh_tool import: any mesh file to a map file."""
import argparse
import os

from mesh_msgs_hdf5.commands._common import (
    add_output_options,
    add_part,
    check_output,
    file_bytes,
    say,
)
from mesh_msgs_hdf5.commands.part_changes import put
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.commands.replaced_output import check_replaced
from mesh_msgs_hdf5.formats.any_mesh import is_map_file
from mesh_msgs_hdf5.formats.base.options import AUTO, NEEDED
from mesh_msgs_hdf5.labels.map_contents import read_map
from mesh_msgs_hdf5.labels.replaced_maps import check_journals, save_journals
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.schema import check_frame_id

NAME = "import"
HELP = "make a map file (.h5) of a mesh (.ply .obj .stl .off .dae .glb .gltf .h5)"
EXAMPLE = "mesh_tool import garden.ply garden.h5 --frame map --origin auto"
_EXACT = 0.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("input", metavar="IN", help="the mesh")
    add("output", metavar="OUT.h5", help="the map file to make")
    add("--frame", help="coordinate frame (default: that of IN if it is a map, else map)")
    add("--force", action="store_true", help="replace OUT.h5, or the mesh --to-part of it")
    text = "move the mesh near zero and store where it was: the middle of the mesh, or a place in m"
    more = " (default: auto where float32 would round by more than a tenth of the median edge)"
    add("--origin", metavar="auto|X,Y,Z", type=_origin, help=text + more)
    add("--crs", metavar="NAME", help="coordinate reference system of IN, for example EPSG:25832")
    text = "give vertices with several texture coordinates or normals a copy for each"
    add("--split-seams", action="store_true", help=text)
    add(
        "--merge-vertices",
        metavar="TOL",
        type=_tolerance,
        nargs="?",
        const=_EXACT,
        help="make one vertex of those that are within TOL meters (default: at the same place)",
    )
    text = "remove faces without area, double faces and unused vertices, turn faces the same way"
    add("--repair", action="store_true", help=text + "; the report says what was changed")
    text = "gzip (default), or none: larger and faster"
    add("--compression", choices=("gzip", "none"), default="gzip", help=text)
    add_part(parser, "IN, if it is a map with several")
    text = "make or (--force) replace this mesh of OUT.h5, and keep all else that is in it"
    add("--to-part", metavar="NAME", help=text + " (--part means it, too, if IN is no map)")
    add_output_options(parser, "say nothing")


def _origin(text):
    if text == AUTO:
        return text
    values = [float(value) for value in text.split(",")]
    if len(values) != 3 or not all(abs(value) < 1e12 for value in values):
        raise ValueError(text)
    return tuple(values)


def _tolerance(text):
    value = float(text)
    if not 0 <= value < 1e12:
        raise ValueError(text)
    return value


_origin.__name__, _tolerance.__name__ = "origin (auto, or X,Y,Z)", "tolerance in meters"


def run(arguments: argparse.Namespace) -> int:
    if arguments.frame is not None:
        check_frame_id(arguments.output, arguments.frame)
    to_part = _target_part(arguments)
    into = to_part is not None and os.path.exists(arguments.output)
    check_output(arguments.input, arguments.output, arguments.force or into)
    if not into:
        check_replaced(arguments.output)
    with ProgressLine(arguments.quiet) as progress:
        progress.stage("reading " + arguments.input)
        mesh, report = read_map(
            arguments.input,
            arguments.part,
            origin=arguments.origin or NEEDED,
            split_seams=arguments.split_seams,
            merge_vertices=arguments.merge_vertices,
            repair=arguments.repair,
        )
        mesh.frame_id = arguments.frame or mesh.frame_id
        mesh.crs = mesh.crs if arguments.crs is None else arguments.crs
        progress.stage("saving " + arguments.output)
        notes = report.notes + _saved(arguments, mesh, to_part, into)
    size, uuid = file_bytes(arguments.output), mesh.uuid
    value = {
        "input": arguments.input,
        "output": arguments.output,
        "format": report.format,
        "vertices": report.vertices,
        "faces": report.faces,
        "notes": notes,
        "file_bytes": size,
        "frame_id": mesh.frame_id,
        "origin": mesh.origin,
        "crs": mesh.crs,
        "uuid": uuid,
    }
    saved = "%s: saved, %d bytes, frame %s, uuid %s"
    lines = report.lines()
    lines += ["  note: " + note for note in notes[len(report.notes) :]]
    lines += [saved % (arguments.output, size, mesh.frame_id, uuid)]
    say(arguments, value, lines)
    return 0


def _target_part(arguments):
    """The mesh of OUT.h5 that is named; None where the whole file is meant."""
    if arguments.to_part is None and arguments.part is not None:
        if not is_map_file(arguments.input):
            arguments.to_part, arguments.part = arguments.part, None
    if arguments.to_part is not None and not arguments.to_part.strip("/"):
        raise MapFileError("part", arguments.output, "a part needs a name", "--to-part floor2")
    return arguments.to_part


def _saved(arguments, mesh, to_part, into):
    """Save the mesh; returns notes."""
    output, compression = arguments.output, arguments.compression
    if into:
        return put(output, mesh, to_part, arguments.force, compression)[0]
    part = "mesh" if to_part is None else "/".join(filter(None, to_part.split("/")))
    check_journals(output, lambda: {part: mesh.uuid})
    MapFile.write(output, mesh, part, overwrite=arguments.force, compression=compression)
    return save_journals(output)

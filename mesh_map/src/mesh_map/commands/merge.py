"""mesh_tool merge: several maps, or meshes of a map, as one mesh."""

import argparse
import os
from typing import List

from mesh_msgs_hdf5.commands.map_output import (
    add_map_output,
    check_map_output,
    save_map,
    saved_line,
    saved_value,
)
from mesh_msgs_hdf5.commands._common import say
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.formats.any_mesh import is_map_file
from mesh_msgs_hdf5.formats.base.options import NEEDED
from mesh_msgs_hdf5.formats.merge import merge_vertices
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.isolation import isolated
from mesh_msgs_hdf5.labels.map_contents import read_map
from mesh_msgs_hdf5.model.errors import MapFileError

from mesh_map.commands.map_errors import as_map_errors
from mesh_map.io.merged_mesh import NamedMesh, merged

NAME = "merge"
HELP = "make one mesh of several maps, or of several meshes of a map; origins are respected"
EXAMPLE = "mesh_tool merge hall.h5 yard.h5 site.h5"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    text = "map files, or any meshes that import reads; of a map all its meshes (see --parts)"
    parser.add_argument("files", metavar="IN", nargs="+", help=text)
    parser.add_argument("output", metavar="OUT.h5", help="the map file to make")
    text = "which meshes of the maps, in this order (default: all)"
    parser.add_argument("--parts", metavar="NAME,NAME", type=_names, help=text)
    text = "make one vertex of those that are within TOL meters (default: at the same place)"
    add = parser.add_argument
    add("--merge-vertices", metavar="TOL", type=_tolerance, nargs="?", const=0.0, help=text)
    add_map_output(parser)


def _names(text: str) -> List[str]:
    names = ["/".join(filter(None, name.split("/"))) for name in text.split(",")]
    if len(set(names)) < len(names):
        raise ValueError(text)
    return names


def _tolerance(text: str) -> float:
    value = float(text)
    if not 0 <= value < 1e12:
        raise ValueError(text)
    return value


_names.__name__, _tolerance.__name__ = "parts (each once)", "tolerance in meters"


def run(arguments: argparse.Namespace) -> int:
    output = arguments.output
    if arguments.to_part is None and output in arguments.files:
        text = "it would be replaced by what is made of it"
        raise MapFileError("exists", output, text, "choose another name, or --to-part NAME")
    check_map_output(arguments, None)
    with ProgressLine(arguments.quiet) as progress, as_map_errors(output):
        meshes, notes = [], []
        for path, part in _sources(arguments):
            progress.stage("reading " + path)
            mesh, report = read_map(path, part, origin=NEEDED)
            name = os.path.basename(path) + (":%s" % (part or "/") if part is not None else "")
            meshes.append(NamedMesh(name, mesh))
            notes += ["%s: %s" % (name, note) for note in report.notes]
        if len(meshes) < 2:
            text = "there is one mesh alone, %s" % meshes[0].name
            raise MapFileError("part", output, text, "name several files, or a map with several")
        progress.stage("merging")
        mesh, more = merged(meshes)
        report = ImportReport(output, "HDF5")
        if arguments.merge_vertices is not None:
            mesh = merge_vertices(output, mesh, arguments.merge_vertices, report)
        notes += more + report.notes
        progress.stage("saving " + output)
        notes += save_map(arguments, mesh)
    names = [each.name for each in meshes]
    value = {"merged": names, "notes": notes, **saved_value(arguments, mesh)}
    head = "%s: %d vertices, %d faces" % (", ".join(names), len(mesh.vertices), len(mesh.faces))
    say(arguments, value, [head, *("  note: " + note for note in notes), saved_line(value)])
    return 0


def _sources(arguments: argparse.Namespace):
    """(file, part) of all meshes; part None for what is no map, or has one mesh alone."""
    wanted, found = arguments.parts, []
    for path in arguments.files:
        parts = isolated("parts", path) if is_map_file(path) else []
        if wanted is not None:
            parts = [part for part in wanted if part in parts]
            found += [(path, part) for part in parts]
        elif len(parts) > 1:
            found += [(path, part) for part in parts]
        else:
            found.append((path, None))
    missing = [part for part in wanted or [] if part not in {name for _, name in found}]
    if missing:
        text = "there is no part %s" % ", ".join(missing)
        raise MapFileError("part", arguments.files[0], text, "mesh_tool parts lists them")
    return found

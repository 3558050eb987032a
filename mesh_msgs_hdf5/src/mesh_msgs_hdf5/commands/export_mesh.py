"""mesh_tool export: a map (or any mesh) to a file for other programs."""
import argparse

from mesh_msgs_hdf5.commands._common import (
    add_output_options,
    add_part,
    check_output,
    file_bytes,
    say,
)
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.formats.exporter import WRITERS, check_georeferenced, write_mesh
from mesh_msgs_hdf5.labels.map_contents import read_map

NAME = "export"
HELP = "write a mesh for other programs (.ply .obj .stl .dae .glb .gltf); says what the format cannot hold"
EXAMPLE = "mesh_tool export garden.h5 garden.ply"
SUFFIXES = tuple(WRITERS)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("input", metavar="IN", help="a map file, or any mesh that import reads")
    parser.add_argument(
        "output", metavar="OUT", help="the suffix is the format: " + " ".join(SUFFIXES)
    )
    text = "paint this layer into the colors of the vertices"
    parser.add_argument("--layer", metavar="NAME", help=text)
    text = "coordinates with the map's origin added, as CloudCompare and QGIS want them (.ply .obj)"
    parser.add_argument("--georeferenced", action="store_true", help=text)
    parser.add_argument("--force", action="store_true", help="replace OUT if it exists")
    add_part(parser, "IN, if it is a map with several")
    add_output_options(parser, "say nothing")


def run(arguments: argparse.Namespace) -> int:
    check_output(arguments.input, arguments.output, arguments.force, SUFFIXES)
    if arguments.georeferenced:
        check_georeferenced(arguments.output)
    with ProgressLine(arguments.quiet) as progress:
        progress.stage("reading " + arguments.input)
        mesh, report = read_map(arguments.input, arguments.part)
        progress.stage("writing " + arguments.output)
        notes = write_mesh(
            arguments.output, mesh, arguments.force, arguments.layer, arguments.georeferenced
        )
    notes = report.notes + notes
    value = {
        "input": arguments.input,
        "output": arguments.output,
        "vertices": len(mesh.vertices),
        "faces": len(mesh.faces),
        "notes": notes,
        "file_bytes": file_bytes(arguments.output),
    }
    lines = ["  note: " + note for note in notes]
    saved = "{output}: written, {vertices} vertices, {faces} faces, {file_bytes} bytes"
    say(arguments, value, lines + [saved.format(**value)])
    return 0

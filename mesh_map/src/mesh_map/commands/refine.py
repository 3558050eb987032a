"""mesh_tool refine: the same surface without long edges."""

import argparse
from functools import partial

from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.formats.base.options import NEEDED
from mesh_msgs_hdf5.labels.map_contents import read_map

from mesh_map.commands.derived_output import (
    add_in_and_out,
    carried,
    check_in_and_out,
    interpolated_layers,
    saved,
)
from mesh_map.commands.map_errors import as_map_errors
from mesh_map.geometry.refinement import refine

NAME = "refine"
HELP = "halve edges that are too long, with the faces around them; the surface stays as it is"
EXAMPLE = "mesh_tool refine hall.h5 hall_fine.h5 --max-edge-length 0.25"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_in_and_out(parser)
    text = "meters; no edge of OUT.h5 is longer"
    parser.add_argument("--max-edge-length", type=float, required=True, metavar="M", help=text)


def run(arguments: argparse.Namespace) -> int:
    check_in_and_out(arguments)
    with ProgressLine(arguments.quiet) as progress, as_map_errors(arguments.input):
        progress.stage("reading " + arguments.input)
        mesh, report = read_map(arguments.input, arguments.part, origin=NEEDED)
        notes, before = list(report.notes), len(mesh.faces)
        progress.stage("refining")
        length = arguments.max_edge_length
        refined = partial(refine, max_edge_length=length)
        result = carried(mesh, refined, "refinement", {"max_edge_length": length})
        if result is None:
            notes.append("no edge is longer than %g m: the mesh is as it was" % length)
        else:
            mesh = result
            notes += interpolated_layers(mesh)
        progress.stage("saving " + arguments.output)
        head = "%s: %d faces became %d" % (arguments.input, before, len(mesh.faces))
        return saved(arguments, mesh, notes, head)

"""mesh_tool repair: a map file without what is bad in it."""
import argparse
import os

from mesh_msgs_hdf5.commands._common import (
    add_output_options,
    add_part,
    file_bytes,
    own_output,
    say,
)
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.commands.replaced_output import check_replaced, kept_parts
from mesh_msgs_hdf5.isolation import isolated
from mesh_msgs_hdf5.labels.map_contents import all_label_changes
from mesh_msgs_hdf5.labels.replaced_maps import check_journals, save_journals, uuids_of

NAME = "repair"
HELP = "write a map file without what is bad in it; says what was mended, and what was left out"
EXAMPLE = "mesh_tool repair garden.h5 mended.h5"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("input", metavar="FILE", help="the map file")
    text = "where to (default: FILE itself, replaced in one step)"
    parser.add_argument("output", metavar="OUT.h5", nargs="?", help=text)
    parser.add_argument("--force", action="store_true", help="replace OUT.h5 if it exists")
    add_part(parser, "FILE, if it has several")
    add_output_options(parser, "say nothing")


def run(arguments: argparse.Namespace) -> int:
    output = own_output(arguments)
    with ProgressLine(arguments.quiet) as progress:
        progress.stage("repairing " + arguments.input)
        options = {"part": arguments.part, "overwrite": arguments.force}
        if os.path.exists(output) and os.path.samefile(arguments.input, output):
            notes = isolated("repair", arguments.input, output, **options)
        else:
            changes, notes = all_label_changes(arguments.input)
            check_replaced(output, kept_parts(arguments.input))
            check_journals(output, lambda: uuids_of(arguments.input))
            notes += isolated("repair", arguments.input, output, label_changes=changes, **options)
            notes += save_journals(output)
    size = file_bytes(output)
    value = {"input": arguments.input, "output": output, "notes": notes, "file_bytes": size}
    lines = ["  note: " + note for note in notes] or ["  note: nothing is wrong with it"]
    untouched = arguments.output is None and not notes
    last = "%s: not changed, %d bytes" if untouched else "%s: saved, %d bytes"
    say(arguments, value, lines + [last % (output, size)])
    return 0

"""mesh_tool repack: the same map file, written anew."""
import argparse
import os

from mesh_msgs_hdf5.commands._common import add_output_options, file_bytes, own_output, say
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.commands.replaced_output import check_replaced, kept_parts
from mesh_msgs_hdf5.isolation import isolated
from mesh_msgs_hdf5.labels.map_contents import all_label_changes
from mesh_msgs_hdf5.labels.replaced_maps import check_journals, save_journals, uuids_of

NAME = "repack"
HELP = "write a map file anew: without the gaps that other programs left, compressed or not"
EXAMPLE = "mesh_tool repack garden.h5 --compression none"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("input", metavar="FILE", help="the map file")
    text = "where to (default: FILE itself, replaced in one step)"
    parser.add_argument("output", metavar="OUT.h5", nargs="?", help=text)
    text = "gzip (default), or none: larger and faster"
    parser.add_argument("--compression", choices=("gzip", "none"), default="gzip", help=text)
    parser.add_argument("--force", action="store_true", help="replace OUT.h5 if it exists")
    add_output_options(parser, "say nothing")


def run(arguments: argparse.Namespace) -> int:
    output = own_output(arguments)
    before = file_bytes(arguments.input)
    with ProgressLine(arguments.quiet) as progress:
        progress.stage("repacking " + arguments.input)
        options = [output, arguments.compression, arguments.force]
        if os.path.exists(output) and os.path.samefile(arguments.input, output):
            notes = save_journals(output)
            isolated("repack", arguments.input, *options)
        else:
            changes, notes = all_label_changes(arguments.input)
            check_replaced(output, kept_parts(arguments.input))
            check_journals(output, lambda: uuids_of(arguments.input))
            isolated("repack", arguments.input, *options, label_changes=changes)
            notes += save_journals(output)
    after = file_bytes(output)
    value = {"input": arguments.input, "output": output, "compression": arguments.compression}
    value.update(bytes_before=before, file_bytes=after, notes=notes)
    lines = ["  note: " + note for note in notes]
    say(arguments, value, lines + ["%s: saved, %d bytes (before: %d)" % (output, after, before)])
    return 0

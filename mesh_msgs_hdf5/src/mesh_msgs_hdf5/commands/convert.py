"""mesh_tool convert: a map file of any schema to schema S1, or to what LVR2 or ROS 2 reads."""
import argparse

from mesh_msgs_hdf5.commands._common import (
    add_output_options,
    add_part,
    check_output,
    file_bytes,
    say,
)
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.commands.replaced_output import check_replaced, kept_parts
from mesh_msgs_hdf5.isolation import isolated
from mesh_msgs_hdf5.labels.map_contents import all_label_changes
from mesh_msgs_hdf5.labels.replaced_maps import check_journals, save_journals, uuids_of
from mesh_msgs_hdf5.map_file.convert import PROFILES

NAME = "convert"
HELP = "make a map file of schema S1 of one of any schema (S0, S1, S2, LVR2's); keeps all groups"
EXAMPLE = "mesh_tool convert old.h5 new.h5 --for lvr2"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("input", metavar="IN.h5", help="the map file to read")
    parser.add_argument("output", metavar="OUT.h5", help="the map file to make")
    text = "lvr2: textures and materials as LVR2's MeshIO reads them; both: with a second part for "
    text += "LVR2; ros2: for LVR2 25 and the mesh tools of ROS 2 (default: s1)"
    parser.add_argument("--for", dest="profile", choices=PROFILES, default="s1", help=text)
    parser.add_argument("--force", action="store_true", help="replace OUT.h5 if it exists")
    add_part(parser, "IN.h5, if it has several")
    add_output_options(parser, "say nothing")


def run(arguments: argparse.Namespace) -> int:
    check_output(arguments.input, arguments.output, arguments.force)
    with ProgressLine(arguments.quiet) as progress:
        progress.stage("converting " + arguments.input)
        changes, notes = all_label_changes(arguments.input)
        check_replaced(arguments.output, kept_parts(arguments.input))
        check_journals(arguments.output, lambda: _new_uuids(arguments.input))
        notes += isolated(
            "convert",
            arguments.input,
            arguments.output,
            part=arguments.part,
            profile=arguments.profile,
            overwrite=arguments.force,
            label_changes=changes,
        )
        notes += save_journals(arguments.output)
    size = file_bytes(arguments.output)
    value = {"input": arguments.input, "output": arguments.output, "profile": arguments.profile}
    value.update(notes=notes, file_bytes=size)
    lines = ["  note: " + note for note in notes]
    say(arguments, value, lines + ["%s: saved, %d bytes" % (arguments.output, size)])
    return 0


def _new_uuids(path):
    uuids = uuids_of(path)
    return {"mesh": uuids.get(""), **uuids}  # the root becomes mesh

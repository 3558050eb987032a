"""mesh_tool diff: what differs between two meshes."""
import argparse
import contextlib

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.commands._common import add_output_options, say
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.comparison.diff import MEMBERS, compare
from mesh_msgs_hdf5.labels.map_contents import open_map

NAME = "diff"
HELP = "say what differs between two meshes (exit code 0: nothing, 1: something, 2: trouble)"
EXAMPLE = "mesh_tool diff old.h5 new.h5 --tolerance 1e-6 --ignore source"
TROUBLE = 2  # as cmp and diff


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("one", metavar="A", help="a map file, or any mesh that import reads")
    parser.add_argument("other", metavar="B", help="the other one")
    text = "numbers that differ by no more (meters for coordinates) are the same (default: 0)"
    parser.add_argument("--tolerance", type=_tolerance, default=0.0, metavar="X", help=text)
    parser.add_argument(
        "--ignore",
        metavar="MEMBER",
        action="append",
        default=[],
        choices=MEMBERS,
        help="may be given several times: %s" % " ".join(MEMBERS),
    )
    parser.add_argument("--part", metavar="NAME", help="which mesh of A, if it has several")
    parser.add_argument("--other-part", metavar="NAME", help="that of B (default: as --part)")
    add_output_options(parser, "say nothing: the exit code tells")


def _tolerance(text):
    value = float(text)
    if not 0 <= value < float("inf"):
        raise ValueError(text)
    return value


_tolerance.__name__ = "tolerance"


def run(arguments: argparse.Namespace) -> int:
    with contextlib.ExitStack() as opened:  # each file is read in one process
        progress = opened.enter_context(ProgressLine(arguments.quiet))
        progress.stage("reading " + arguments.one)
        one = opened.enter_context(open_map(arguments.one, arguments.part).members)
        progress.stage("reading " + arguments.other)
        other_part = arguments.other_part or arguments.part
        other = opened.enter_context(open_map(arguments.other, other_part).members)
        found = compare(
            one,
            other,
            arguments.tolerance,
            arguments.ignore,
            lambda member: progress.stage("comparing " + member),
        )
        label_notes = []
        if "labels" not in arguments.ignore:
            label_notes = one.label_notes + other.label_notes
            for note in () if arguments.quiet or arguments.json else label_notes:
                progress.write("  note: " + one_line(note))
        notes = ["A: " + note for note in one.notes] + ["B: " + note for note in other.notes]
    value = {
        "one": arguments.one,
        "other": arguments.other,
        "tolerance": arguments.tolerance,
        "same": not found,
        "notes": label_notes + notes,
        "differences": [difference._asdict() for difference in found],
    }
    lines = ["  note: " + note for note in notes]
    say(arguments, value, lines + [difference.line() for difference in found])
    return 1 if found else 0

"""mesh_tool layers: the cost layers (or, with --vertex or --face, the attributes) of a map file."""
import argparse
from typing import List

from mesh_msgs_hdf5.commands._common import add_actions, say
from mesh_msgs_hdf5.commands.info import values_text
from mesh_msgs_hdf5.commands.layer_changes import copied, deleted, names_of, renamed, what
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.commands.summary import (
    face_attribute_summary,
    layer_summary,
    readable,
    vertex_attribute_summary,
)
from mesh_msgs_hdf5.formats.any_mesh import open_members
from mesh_msgs_hdf5.isolation import IsolatedMapFile
from mesh_msgs_hdf5.model.errors import MapFileError

NAME = "layers"
HELP = "list, copy, delete and rename the layers of a map file"
EXAMPLE = "mesh_tool layers copy garden.h5 slope --from other.h5"
_ACTIONS = {
    "list": ("the layers with their ranges (meant if no action is given)", "garden.h5"),
    "copy": ("copy a layer and its parameters, from another map too", "garden.h5 slope slope_old"),
    "delete": ("delete layers", "garden.h5 slope steepness"),
    "rename": ("rename a layer", "garden.h5 slope slope_old"),
}
ACTIONS = tuple(_ACTIONS)
_SUMMARIES = {
    None: layer_summary,
    "vertex": vertex_attribute_summary,
    "face": face_attribute_summary,
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add = add_actions(parser, NAME, _ACTIONS)
    for action in add.values():
        kinds = action.add_mutually_exclusive_group()
        text = "attributes of the vertices instead of layers: any numbers, in any number of columns"
        kinds.add_argument(
            "--vertex", dest="place", action="store_const", const="vertex", help=text
        )
        text = "attributes of the faces instead of layers"
        kinds.add_argument("--face", dest="place", action="store_const", const="face", help=text)
    add["copy"].add_argument("name", metavar="NAME")
    add["copy"].add_argument("new", metavar="NEW", nargs="?", help="default with --from: NAME")
    add["copy"].add_argument("--from", dest="origin", metavar="OTHER", help="the mesh that has it")
    text = "which mesh of OTHER, if it has several"
    add["copy"].add_argument("--from-part", metavar="PART", help=text)
    add["copy"].add_argument("--force", action="store_true", help="replace the layer NEW")
    add["delete"].add_argument("names", metavar="NAME", nargs="+")
    add["rename"].add_argument("name", metavar="OLD")
    add["rename"].add_argument("new", metavar="NEW")


def run(arguments: argparse.Namespace) -> int:
    with ProgressLine(arguments.quiet) as progress:
        progress.stage("reading " + arguments.file)
        if arguments.action == "list":
            value, lines = _list(arguments)
            arguments.quiet = False  # what was asked for
        else:
            file = IsolatedMapFile(arguments.file, arguments.part)
            edit, text = _CHANGES[arguments.action](file, arguments)
            progress.stage("saving " + arguments.file)
            file.update(edit)
            value = {"path": arguments.file, "action": arguments.action, "done": text}
            lines = ["%s: %s" % (arguments.file, text)]
    say(arguments, value, lines)
    return 0


def _list(arguments):
    summary = _SUMMARIES[arguments.place]
    notes: List[str] = []
    with open_members(arguments.file, arguments.part).members as file:
        names = names_of(file, arguments.place)
        entries = readable(names, lambda name: summary(file, name), notes)
        notes += file.notes
    key = arguments.place + "_attributes" if arguments.place else "layers"
    lines = [values_text(entry) for entry in entries]
    none = ["%s: no %ss" % (arguments.file, what(arguments.place))]
    value = {"path": arguments.file, key: entries, "notes": notes}
    return value, (lines or none) + ["  note: " + note for note in notes]


def _copy(file, arguments):
    source, new = file, arguments.new
    if arguments.origin is not None:
        source = open_members(arguments.origin, arguments.from_part).members
        new = arguments.name if new is None else new
    if new is None or (source is file and new == arguments.name):
        raise MapFileError("layer", file.path, "the copy needs a name of its own", "NAME NEW")
    edit = copied(file, source, arguments.name, new, arguments.place, arguments.force)
    return edit, "%s %s copied to %s" % (what(arguments.place), arguments.name, new)


def _delete(file, arguments):
    names = list(dict.fromkeys(arguments.names))
    text = "deleted %s %s" % (what(arguments.place), ", ".join(names))
    return deleted(file, names, arguments.place), text


def _rename(file, arguments):
    edit = renamed(file, arguments.name, arguments.new, arguments.place)
    return edit, "%s %s renamed to %s" % (what(arguments.place), arguments.name, arguments.new)


_CHANGES = {"copy": _copy, "delete": _delete, "rename": _rename}

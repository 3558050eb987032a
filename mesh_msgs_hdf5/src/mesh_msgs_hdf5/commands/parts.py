"""mesh_tool parts: the meshes of a map file, each of which is a part of it."""
import argparse

from mesh_msgs_hdf5.commands._common import add_actions, say
from mesh_msgs_hdf5.commands.part_changes import (
    copied,
    deleted,
    part_summaries,
    put,
    renamed,
)
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.formats.base.options import NEEDED
from mesh_msgs_hdf5.labels.map_contents import read_map

NAME = "parts"
HELP = "list, add, replace, rename, delete and copy the meshes of a map file"
EXAMPLE = "mesh_tool parts add garden.h5 floor2 floor2.ply"
_ACTIONS = {
    "list": ("the meshes (meant if no action is given)", "garden.h5"),
    "add": ("add a mesh; with --force it may replace one", "garden.h5 floor2 floor2.ply"),
    "rename": ("rename a mesh", "garden.h5 floor2 cellar"),
    "delete": ("delete meshes", "garden.h5 floor2 floor3"),
    "copy": ("copy a mesh with all it has, from another map too", "garden.h5 floor2 floor2_old"),
}
ACTIONS = tuple(_ACTIONS)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add = add_actions(parser, NAME, _ACTIONS, of_a_part=False)
    add["add"].add_argument("name", metavar="NAME")
    add["add"].add_argument("input", metavar="IN", help="a map file, or any mesh that import reads")
    text = "which mesh of IN, if it is a map with several"
    add["add"].add_argument("--from-part", metavar="PART", help=text)
    text = "replace the mesh NAME; what else is in its group stays"
    add["add"].add_argument("--force", action="store_true", help=text)
    add["rename"].add_argument("name", metavar="OLD")
    add["rename"].add_argument("new", metavar="NEW")
    add["delete"].add_argument("names", metavar="NAME", nargs="+")
    text = "also if no mesh is left then"
    add["delete"].add_argument("--force", action="store_true", help=text)
    add["copy"].add_argument("name", metavar="NAME")
    add["copy"].add_argument("new", metavar="NEW", nargs="?", help="default with --from: NAME")
    add["copy"].add_argument("--from", dest="origin", metavar="OTHER", help="the map that has it")


def run(arguments: argparse.Namespace) -> int:
    with ProgressLine(arguments.quiet) as progress:
        progress.stage("reading " + arguments.file)
        if arguments.action == "list":
            value, lines = _list(arguments)
            arguments.quiet = False  # what was asked for
        else:
            text, notes = _CHANGES[arguments.action](arguments)
            value = {"path": arguments.file, "action": arguments.action, "done": text}
            value["notes"] = notes
            lines = ["  note: " + note for note in notes]
            lines.append("%s: %s" % (arguments.file, text))
    say(arguments, value, lines)
    return 0


def _list(arguments):
    entries = part_summaries(arguments.file)
    lines = []
    for entry in entries:
        text = "{vertices} vertices, {faces} faces, {labels} labels, frame {frame_id}"
        text = "%s: %s" % (entry["part"] or "/", text.format(**entry))
        if entry["unsaved_labels"]:
            text += ", %d label edits in the journal" % entry["unsaved_labels"]
        if entry["schema"] != "S1":
            text += ", schema %s" % entry["schema"]
        lines.append(text)
    return {"path": arguments.file, "parts": entries}, lines or ["%s: no meshes" % arguments.file]


def _add(arguments):
    mesh, report = read_map(arguments.input, arguments.from_part, origin=NEEDED)
    notes, replaced = put(arguments.file, mesh, arguments.name, arguments.force)
    text = "replaced part %s" if replaced else "added part %s"
    return text % arguments.name, report.notes + notes


def _rename(arguments):
    renamed(arguments.file, arguments.name, arguments.new)
    return "part %s renamed to %s" % (arguments.name, arguments.new), []


def _delete(arguments):
    notes = deleted(arguments.file, arguments.names, arguments.force)
    return "deleted part %s" % ", ".join(dict.fromkeys(arguments.names)), notes


def _copy(arguments):
    origin = arguments.file if arguments.origin is None else arguments.origin
    new, notes = copied(arguments.file, origin, arguments.name, arguments.new)
    return "part %s copied to %s" % (arguments.name, new), notes


_CHANGES = {"add": _add, "rename": _rename, "delete": _delete, "copy": _copy}

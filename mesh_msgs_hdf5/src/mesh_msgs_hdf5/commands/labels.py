"""mesh_tool labels: the labels of a map file."""
import argparse

from mesh_msgs_hdf5.commands._common import (
    add_actions,
    add_classes,
    check_output,
    class_table,
    file_bytes,
    known_classes,
    say,
)
from mesh_msgs_hdf5.commands.label_changes import (
    changing,
    colored,
    deleted,
    present_labels,
    renamed,
)
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.files.save import check_target, save_file
from mesh_msgs_hdf5.labels.label_ids import ids_to_csv, label_ids, overlap_note, table_text
from mesh_msgs_hdf5.labels.label_tables import (
    color_text,
    labels_to_csv,
    labels_to_json,
    parse_color,
    read_labels,
)
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.label_names import split_label

NAME = "labels"
HELP = "list, export, import, delete, rename and color the labels of a map file"
EXAMPLE = "mesh_tool labels export garden.h5 labels.csv"
_ACTIONS = {
    "list": ("the labels (meant if no action is given)", "garden.h5"),
    "export": ("write the labels to a JSON or CSV file", "garden.h5 labels.csv"),
    "import": ("take labels from a JSON or CSV file", "garden.h5 labels.csv --replace"),
    "delete": ("delete labels", "garden.h5 tree_1 tree_2"),
    "rename": ("give a label another text", "garden.h5 tree_1 bush_1"),
    "color": ("give labels a color", "garden.h5 #00ff00 tree_1 tree_2"),
}
ACTIONS = tuple(_ACTIONS)
SUFFIXES = (".json", ".csv")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add = add_actions(parser, NAME, _ACTIONS)
    add["export"].add_argument("output", metavar="OUT.json|OUT.csv")
    text = "a line for each face instead: face,class_id,instance_id; beside it OUT_classes.json, "
    text += "which says what the numbers mean"
    add["export"].add_argument("--ids", action="store_true", help=text)
    add_classes(add["export"])
    add["export"].add_argument("--force", action="store_true", help="replace the output")
    add["import"].add_argument("input", metavar="IN.json|IN.csv")
    text = "delete all other labels (default: they stay; one of the same text is replaced)"
    add["import"].add_argument("--replace", action="store_true", help=text)
    text = "take labels that were made for another geometry with as many faces"
    add["import"].add_argument("--force", action="store_true", help=text)
    add["delete"].add_argument("names", metavar="LABEL", nargs="+")
    text = "the names are classes: delete all their labels"
    add["delete"].add_argument("--class", dest="whole_class", action="store_true", help=text)
    add["rename"].add_argument("old", metavar="OLD")
    add["rename"].add_argument("new", metavar="NEW")
    text = "#rrggbb, red,green,blue (0 to 255), or none"
    add["color"].add_argument("color", metavar="COLOR", type=_color, help=text)
    add["color"].add_argument("names", metavar="LABEL", nargs="+")


def _color(text):
    return parse_color(text)


_color.__name__ = "color (#rrggbb, red,green,blue or none)"


def run(arguments: argparse.Namespace) -> int:
    with ProgressLine(arguments.quiet) as progress:
        progress.stage("reading " + arguments.file)
        if arguments.action == "list":
            value, lines = _list(arguments)
            arguments.quiet = False  # what was asked for
        elif arguments.action == "export":
            value, lines = _export(arguments)
        else:
            with changing(arguments.file, arguments.part) as (labels, file):
                progress.stage("saving " + arguments.file)
                changes = _CHANGES[arguments.action](labels, file, arguments)
                if changes:
                    file.update(Edit(labels=changes))
            value = {"path": arguments.file, "action": arguments.action}
            value["set"] = [text for text, label in changes.items() if label is not None]
            value["deleted"] = [text for text, label in changes.items() if label is None]
            text = "%s: %d labels set, %d deleted"
            lines = [text % (arguments.file, len(value["set"]), len(value["deleted"]))]
    say(arguments, value, lines)
    return 0


def _list(arguments):
    labels, uuid, face_count, notes = present_labels(arguments.file, arguments.part)
    entries = []
    for text, label in labels.items():
        class_name, instance = split_label(text)
        entry = {"label": text, "class": class_name, "instance": instance}
        entries.append(dict(entry, color=label.color, faces=len(label.faces)))
    value = {"path": arguments.file, "uuid": uuid, "faces": face_count, "labels": entries}
    lines = ["%s: %d faces" % (entry["label"], entry["faces"]) for entry in entries]
    colors = [color_text(label.color) for label in labels.values()]
    lines = [line + (", " + color if color else "") for line, color in zip(lines, colors)]
    lines = lines or ["%s: no labels" % arguments.file]
    return dict(value, notes=notes), lines + ["  note: " + note for note in notes]


def _export(arguments):
    if arguments.ids:
        return _export_ids(arguments)
    check_output(arguments.file, arguments.output, arguments.force, SUFFIXES)
    labels, uuid, face_count, notes = present_labels(arguments.file, arguments.part)
    as_csv = arguments.output.lower().endswith(".csv")
    text = labels_to_csv(labels) if as_csv else labels_to_json(labels, uuid, face_count)
    save_file(arguments.output, text.encode("utf-8"), overwrite=arguments.force)
    value = {"path": arguments.file, "output": arguments.output, "labels": len(labels)}
    value.update(notes=notes, file_bytes=file_bytes(arguments.output))
    lines = ["%s: written, %d labels" % (arguments.output, len(labels))]
    return value, ["  note: " + note for note in notes] + lines


def _export_ids(arguments):
    table = class_table(arguments.output)
    check_output(arguments.file, arguments.output, arguments.force, (".csv",))
    check_target(table, arguments.force)
    labels, uuid, face_count, notes = present_labels(arguments.file, arguments.part)
    known = known_classes(arguments)
    ids = label_ids(arguments.file, labels, uuid, face_count, known)
    notes = [*notes, *overlap_note(ids)]
    save_file(table, table_text(ids.table), overwrite=arguments.force)
    save_file(arguments.output, ids_to_csv(ids), overwrite=arguments.force)
    value = {"path": arguments.file, "output": arguments.output, "table": table}
    value.update(labels=len(labels), classes=ids.table["classes"], notes=notes)
    value.update(file_bytes=file_bytes(arguments.output))
    text = "%s: written, %d faces, %d classes (%s)"
    lines = [text % (arguments.output, face_count, len(ids.table["classes"]), table)]
    return value, ["  note: " + note for note in notes] + lines


def _import(labels, file, arguments):
    uuid, new = read_labels(arguments.input, file.face_count)
    # the faces of a mesh with copies along seams are those of its parent
    if uuid not in (None, file.uuid, file.parent_uuid or None) and not arguments.force:
        message = "its labels are for the geometry %s, that of the map is %s" % (uuid, file.uuid)
        raise MapFileError("uuid", arguments.input, message, "--force takes them all the same")
    return {**dict.fromkeys(labels if arguments.replace else ()), **new}


_CHANGES = {
    "import": _import,
    "delete": lambda labels, file, a: deleted(file.path, labels, a.names, a.whole_class),
    "rename": lambda labels, file, a: renamed(file.path, labels, a.old, a.new),
    "color": lambda labels, file, a: colored(file.path, labels, a.names, a.color),
}

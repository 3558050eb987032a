"""mesh_tool info: what is in a mesh file."""
import argparse
import json

from mesh_msgs_hdf5.errors import one_line
from mesh_msgs_hdf5.summary import summarize

NAME = "info"
HELP = "say what is in a mesh file"
EXAMPLE = "mesh_tool info garden.h5"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="a map file, or .ply .obj .stl .dae")
    parser.add_argument("--part", default="mesh", help="which mesh of a map file (default: mesh)")
    parser.add_argument("--json", action="store_true", help="for programs")


def run(arguments: argparse.Namespace) -> int:
    summary = summarize(arguments.file, arguments.part)
    if arguments.json:
        # parameters in a file may hold NaN and Infinity, which JSON has no numbers for
        text = json.dumps(json.loads(json.dumps(summary), parse_constant=str), indent=2)
        print(text)
    else:
        print("\n".join(_lines(summary)))
    return 0


def _lines(summary):
    head = "%s: %s, %d bytes"
    yield one_line(head % (summary["path"], _format(summary), summary["file_bytes"]))
    for name, value in _rows(summary):
        yield "  %-10s %s" % (name, one_line(str(value)))


def _rows(summary):
    yield "vertices", summary["vertices"]
    yield "faces", summary["faces"]
    low, high = summary["bounds"]["min"], summary["bounds"]["max"]
    for axis, start, end in zip("xyz", low, high):
        yield axis, "%g .. %g m" % (start, end)
    yield "normals", "yes" if summary["normals"] else "no"
    yield "colors", "yes" if summary["colors"] else "no"
    yield "frame", summary["frame_id"]
    yield "uuid", summary["uuid"]
    if "parts" in summary:
        yield "parts", ", ".join(summary["parts"])
    for layer in summary["layers"]:
        yield "layer", _layer(layer)
    if not summary["layers"]:
        yield "layers", "none"
    for other in summary.get("other_contents", ()):
        yield "also", other
    source = dict(summary["source"])
    notes = source.pop("notes", [])
    if source:
        yield "source", json.dumps(source, sort_keys=True)
    for note in notes if isinstance(notes, list) else [notes]:
        yield "note", note


def _format(summary):
    if "schema" not in summary:
        return summary["format"]
    version = summary["schema_version"]
    return "HDF5 map, schema %s%s" % (summary["schema"], " version %d" % version if version else "")


def _layer(layer):
    if layer["min"] is None:
        text = "%s: no finite cost" % layer["name"]
    else:
        text = "%s: %g .. %g" % (layer["name"], layer["min"], layer["max"])
    text += "".join(
        ", %d %s" % (layer[key], key) for key in ("lethal", "unknown", "negative") if layer[key]
    )
    if layer["parameters"]:
        text += ", " + json.dumps(layer["parameters"], sort_keys=True)
    return text

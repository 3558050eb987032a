"""mesh_tool info: what is in a mesh file."""
import argparse
import json
from typing import Any, Dict

from mesh_msgs_hdf5.commands._common import add_output_options, add_part, say
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.commands.summary import summarize
from mesh_msgs_hdf5.model.carried_mesh import CARRIED_BY

NAME = "info"
HELP = "say what is in a mesh file"
EXAMPLE = "mesh_tool info garden.h5"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="a map file, or any mesh that import reads")
    text = "of a map read names, shapes and parameters only, no arrays"
    parser.add_argument("--fast", action="store_true", help=text)
    add_part(parser)
    add_output_options(parser)


def run(arguments: argparse.Namespace) -> int:
    with ProgressLine(arguments.quiet) as progress:
        progress.stage("reading " + arguments.file)
        summary = summarize(arguments.file, arguments.part, arguments.fast)
    arguments.quiet = False  # what was asked for
    say(arguments, summary, _lines(summary))
    return 0


def _lines(summary):
    yield "%s: %s, %d bytes" % (summary["path"], _format(summary), summary["file_bytes"])
    for name, value in _rows(summary):
        yield "  %-10s %s" % (name, value)


def _rows(summary):
    yield "vertices", summary["vertices"]
    yield "faces", summary["faces"]
    yield from _places(summary)
    for name in ("normals", "colors"):
        yield name, "yes" if summary[name] else "no"
    yield "frame", summary["frame_id"]
    yield "uuid", summary["uuid"] or "not in the file"
    if summary["parts"]:
        names = (name or "/" for name in summary["parts"])
        yield "parts", ", ".join(names) + " (this is %s)" % (summary["part"] or "/")
    for layer in summary["layers"]:
        yield "layer", values_text(layer)
    if not summary["layers"]:
        yield "layers", "none"
    for place in ("vertex", "face"):
        for attribute in summary[place + "_attributes"]:
            yield place, values_text(attribute)
    for texture in summary["textures"]:
        size = "" if "width" not in texture else ": {width} x {height} pixels, {channels} channels"
        yield "texture", ("{index}" + size).format(**texture)
    if summary["texture_coordinates"]:
        yield "uv", "texture coordinates of the vertices"
    if summary["seams"]:
        text = "of textures at {vertices} vertices: {copies} copies of them"
        yield "seams", (text + ", of the mesh {parent_uuid}").format(**summary["seams"])
    if summary["materials"]:
        yield "materials", "{count}, {textured} with a texture".format(**summary["materials"])
    if summary["labels"]["count"]:
        classes = summary["labels"]["classes"].items()
        shown = ", ".join("%s (%s)" % (name, _labels(entry)) for name, entry in classes)
        yield "labels", "%d: %s" % (summary["labels"]["count"], shown)
    if summary["unsaved_labels"]:
        text = "%d label edits that are not in the file yet (shown; mesh_tool repack saves them)"
        yield "journal", text % summary["unsaved_labels"]
    if summary["features"]:
        yield "features", "{count} with {dimensions} numbers each".format(**summary["features"])
    if summary["scans"]["count"]:
        yield "scans", "{count} with {points} points and {images} images".format(**summary["scans"])
    for other in summary["other_contents"]:
        yield "also", other
    source = dict(summary["source"])
    notes = list(summary["notes"])
    if summary["parts"]:  # those of the import
        made = source.pop("notes", [])
        notes = (made if isinstance(made, list) else [made]) + notes
    if source:
        yield "source", json.dumps(source, sort_keys=True, ensure_ascii=False)
    for note in notes:
        yield "note", note
    if summary["arrays_read"] is not None:
        yield "read", ", ".join(summary["arrays_read"]) or "no arrays"


def _places(summary):
    if summary["bounds"]:
        low, high = summary["bounds"]["min"], summary["bounds"]["max"]
        for axis, start, end in zip("xyz", low, high):
            yield axis, "%g .. %g m" % (start, end)
    if summary["crs"] or any(summary["origin"]):
        origin = " ".join("%.12g" % value for value in summary["origin"])
        yield "origin", "%s m (%s)" % (origin, summary["crs"] or "no crs")
    if summary["georeferenced"]:
        corners = (summary["georeferenced"][key] for key in ("min", "max"))
        texts = (" ".join("%.10g" % value for value in corner) for corner in corners)
        yield "in crs", "%s .. %s m" % tuple(texts)


def _labels(entry):
    labels = "%d label%s" % (entry["labels"], "" if entry["labels"] == 1 else "s")
    return labels if entry["faces"] is None else "%s, %d faces" % (labels, entry["faces"])


def _format(summary):
    if not summary["schema"]:
        return summary["format"]
    version = summary["schema_version"]
    return "HDF5 map, schema %s%s" % (summary["schema"], " version %d" % version if version else "")


def values_text(entry: Dict[str, Any]) -> str:
    """One line about a layer or attribute (see summary.layer_summary)."""
    text = entry["name"]
    if "min" in entry:
        finite = "no finite value" if entry["min"] is None else "{min:g} .. {max:g}".format(**entry)
        text += ": " + finite + (" " + entry["unit"] if entry.get("unit") else "")
    if "type" in entry:
        text += ", {type}".format(**entry)
    rule = entry.get("rule")
    if rule and "lethal" in entry:
        text += ", %d lethal (%s)" % (entry["lethal"], rule)
    elif rule:
        text += ", lethal " + rule
    elif entry.get("lethal"):
        text += ", %d lethal" % entry["lethal"]
    for key in ("unknown", "negative"):
        if entry.get(key):
            text += ", %d %s" % (entry[key], key)
    if CARRIED_BY in entry["parameters"]:
        text += ", parameters unknown (carried by %s)" % (entry["parameters"][CARRIED_BY],)
    elif entry["parameters"]:
        parameters = json.dumps(entry["parameters"], sort_keys=True, ensure_ascii=False)
        text += ", computed with " + parameters
    elif "type" not in entry:
        text += ", parameters unknown"
    return text

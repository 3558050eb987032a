"""mesh_tool import: any mesh file to a map file."""
import argparse

from mesh_msgs_hdf5.commands._common import add_part, say
from mesh_msgs_hdf5.commands.map_output import (
    add_map_output,
    check_map_output,
    save_map,
    saved_line,
    saved_value,
)
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.formats.any_mesh import is_map_file
from mesh_msgs_hdf5.formats.base.foreign_labels import ClassNames, read_class_names
from mesh_msgs_hdf5.formats.base.movement import parsed_matrix
from mesh_msgs_hdf5.formats.base.options import AUTO, NEEDED
from mesh_msgs_hdf5.labels.map_contents import read_map
from mesh_msgs_hdf5.model.schema import check_frame_id

NAME = "import"
HELP = "make a map file (.h5) of a mesh (.ply .obj .stl .off .dae .zae .fbx .3ds .glb .gltf .h5)"
EXAMPLE = "mesh_tool import garden.ply garden.h5 --frame map --origin auto"
_EXACT = 0.0
_MOST_TEXT = 1 << 16  # of a file with a matrix


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("input", metavar="IN", help="the mesh")
    add("output", metavar="OUT.h5", help="the map file to make")
    add("--frame", help="coordinate frame (default: that of IN if it is a map, else map)")
    text = "move the mesh near zero and store where it was: the middle of the mesh, or a place in m"
    more = " (default: auto where float32 would round by more than a tenth of the median edge)"
    add("--origin", metavar="auto|X,Y,Z", type=_origin, help=text + more)
    add("--crs", metavar="NAME", help="coordinate reference system of IN, for example EPSG:25832")
    text = "the axis that points up in IN (default: what its format says, else z)"
    add("--up", choices=("y", "z"), help=text)
    text = "what the unit of IN is in meters, such as 0.001, where its format does not say it"
    add("--scale", type=_scale, metavar="S", help=text)
    text = "move the mesh, after that, by a matrix: 16 numbers, or a file with them, row by row"
    add("--transform", metavar="4x4", type=_matrix, help=text)
    text = "make labels of the class numbers (and instance numbers) that faces or vertices have in "
    text += "these properties, such as category_id; of OBJ: groups, objects or materials"
    add("--labels-from", metavar="CLASS[,INSTANCE]", type=_words, help=text)
    text = "names of the class numbers: a table as JSON (as of labels export --ids) or CSV (1,tree)"
    add("--label-names", metavar="FILE", help=text)
    seams = parser.add_mutually_exclusive_group()
    text = "give vertices with several texture coordinates a copy for each (default: where there"
    more = " are textures)"
    seams.add_argument("--split-seams", action="store_true", default=None, help=text + more)
    text = "leave textures out where they need such copies"
    seams.add_argument("--no-split-seams", dest="split_seams", action="store_false", help=text)
    add(
        "--merge-vertices",
        metavar="TOL",
        type=_tolerance,
        nargs="?",
        const=_EXACT,
        help="make one vertex of those that are within TOL meters (default: at the same place)",
    )
    text = "remove faces without area, double faces and unused vertices, turn faces the same way"
    add("--repair", action="store_true", help=text + "; the report says what was changed")
    add_part(parser, "IN, if it is a map with several")
    add_map_output(parser, " (--part means it, too, if IN is no map)")


def _origin(text):
    if text == AUTO:
        return text
    values = [float(value) for value in text.split(",")]
    if len(values) != 3 or not all(abs(value) < 1e12 for value in values):
        raise ValueError(text)
    return tuple(values)


def _tolerance(text):
    value = float(text)
    if not 0 <= value < 1e12:
        raise ValueError(text)
    return value


def _words(text):
    words = tuple(word.strip() for word in text.split(","))
    if not 1 <= len(words) <= 2 or not all(words):
        raise ValueError(text)
    return words


def _scale(text):
    value = float(text)
    if not 0 < value < 1e12:
        raise ValueError(text)
    return value


def _matrix(text):
    matrix = parsed_matrix(text)
    if matrix is None:
        try:
            with open(text, encoding="utf-8") as stream:
                matrix = parsed_matrix(stream.read(_MOST_TEXT))
        except (OSError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or "it is no text"
            raise argparse.ArgumentTypeError("%s: %s" % (text, reason)) from error
    if matrix is None:
        raise argparse.ArgumentTypeError("%s: it has not 16 numbers and nothing else" % text)
    return tuple(matrix.reshape(-1).tolist())


_words.__name__ = "property, or two"
_scale.__name__, _matrix.__name__ = "scale", "matrix (16 numbers)"
_origin.__name__, _tolerance.__name__ = "origin (auto, or X,Y,Z)", "tolerance in meters"


def run(arguments: argparse.Namespace) -> int:
    if arguments.frame is not None:
        check_frame_id(arguments.output, arguments.frame)
    if arguments.to_part is None and arguments.part is not None:
        if not is_map_file(arguments.input):
            arguments.to_part, arguments.part = arguments.part, None
    check_map_output(arguments, arguments.input)
    names = ClassNames({}, {})
    if arguments.label_names is not None:
        names = read_class_names(arguments.label_names)
    with ProgressLine(arguments.quiet) as progress:
        progress.stage("reading " + arguments.input)
        mesh, report = read_map(
            arguments.input,
            arguments.part,
            origin=arguments.origin or NEEDED,
            split_seams=arguments.split_seams,
            merge_vertices=arguments.merge_vertices,
            repair=arguments.repair,
            up=arguments.up,
            scale=arguments.scale,
            transform=arguments.transform,
            labels_from=arguments.labels_from,
            label_names=names.classes,
            label_texts=names.labels,
            label_colors=names.colors,
        )
        mesh.frame_id = arguments.frame or mesh.frame_id
        mesh.crs = mesh.crs if arguments.crs is None else arguments.crs
        progress.stage("saving " + arguments.output)
        notes = report.notes + save_map(arguments, mesh)
    value = {"input": arguments.input, "format": report.format, "notes": notes}
    value.update(saved_value(arguments, mesh))
    lines = report.lines() + ["  note: " + note for note in notes[len(report.notes) :]]
    say(arguments, value, lines + [saved_line(value)])
    return 0

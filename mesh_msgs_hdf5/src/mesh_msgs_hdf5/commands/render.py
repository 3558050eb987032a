"""mesh_tool render: a picture of a mesh."""
import argparse
import os
from typing import List

from mesh_msgs_hdf5.commands._common import (
    add_classes,
    add_output_options,
    add_part,
    check_output,
    class_table,
    file_bytes,
    known_classes,
    say,
)
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.files.save import check_target, save_file
from mesh_msgs_hdf5.labels.label_ids import label_ids, overlap_note, table_text
from mesh_msgs_hdf5.labels.map_contents import open_map
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.rendering.render import choose_paint, paint_mesh
from mesh_msgs_hdf5.rendering.render_camera import VIEWS, look_at, parsed_view, usual_view
from mesh_msgs_hdf5.rendering.render_figure import LARGEST, SMALLEST, picture_png
from mesh_msgs_hdf5.rendering.render_ids import bare_png, camera_table, gray_png, id_picture
from mesh_msgs_hdf5.rendering.render_scale import SCALES

NAME = "render"
HELP = "draw a mesh into a PNG, with scale, color bar and legend; needs no display"
EXAMPLE = "mesh_tool render garden.h5 garden.png --layer height_diff --limits 0,0.5 --view iso"
# what is read for each way to color, besides vertices and faces
_NEEDED = {
    "labels": ("labels",),
    "colors": ("vertex_colors",),
    "textures": ("textures", "materials", "texture_coordinates"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="a map file, or any mesh that import reads")
    parser.add_argument("output", metavar="OUT.png")
    what = parser.add_mutually_exclusive_group()
    text = "color by a cost layer (or face attribute); default: textures, else colors, else height"
    what.add_argument("--layer", metavar="NAME", help=text)
    what.add_argument("--face", metavar="NAME", help="color by an attribute of the faces")
    for name in ("labels", "colors", "textures", "height"):
        what.add_argument("--" + name, dest="what", action="store_const", const=name)
    text = (
        "of the labels: no colors, but 16 bits of gray with the number of the class (or instance) "
    )
    text += (
        "that each pixel shows; beside OUT.png OUT_classes.json, with what they mean and the camera"
    )
    add = parser.add_argument
    add("--ids", nargs="?", choices=("class", "instance"), const="class", help=text)
    add_classes(parser)
    text = "the mesh alone, over the whole picture, pixel for pixel as --ids has it"
    parser.add_argument("--bare", action="store_true", help=text)
    text = "%s, or AZIMUTH,ELEVATION in degrees of the place to look from (default: top, or iso "
    text = (text + "where storeys lie over each other)") % ", ".join(VIEWS)
    parser.add_argument("--view", type=parsed_view, help=text)
    text = "of the picture in pixels (default: 1200x900)"
    parser.add_argument("--size", type=_size, default="1200x900", metavar="WxH", help=text)
    text = "of the color bar (default: the least and greatest finite value)"
    parser.add_argument("--limits", type=_limits, metavar="LO,HI", help=text)
    parser.add_argument("--scale", choices=sorted(SCALES), default="rainbow", help="as in RViz")
    text = "of a layer: color lethal values by the scale, too (default: as lethal, where known)"
    parser.add_argument("--values", action="store_true", help=text)
    parser.add_argument("--title", help="default: the name of FILE, and what is shown")
    parser.add_argument("--force", action="store_true", help="replace OUT.png if it exists")
    add_part(parser)
    add_output_options(parser, "say nothing")


def _size(text):
    width, height = (int(value) for value in text.lower().split("x"))
    if not all(SMALLEST <= side <= LARGEST for side in (width, height)):
        text = "%s: each side has %d to %d pixels" % (text, SMALLEST, LARGEST)
        raise argparse.ArgumentTypeError(text)
    return width, height


def _limits(text):
    low, high = (float(value) for value in text.split(","))
    if not -1e38 < low < high < 1e38:
        raise ValueError(text)
    return low, high


_size.__name__, _limits.__name__ = "size (WxH)", "limits (LO,HI)"


def run(arguments: argparse.Namespace) -> int:
    check_output(arguments.file, arguments.output, arguments.force, (".png",))
    if arguments.ids:
        _check_ids(arguments)
    with ProgressLine(arguments.quiet) as progress:
        progress.stage("reading " + arguments.file)
        file = open_map(arguments.file, arguments.part).members
        if not file.face_count:
            raise MapFileError(
                "no_faces",
                arguments.file,
                "the mesh has no faces to draw",
                "mesh_tool info says what it has",
            )
        mesh, what, name = _mesh(file, arguments)
        paint = None
        if not arguments.ids:
            scale = arguments.limits, arguments.scale, not arguments.values
            paint = choose_paint(arguments.file, mesh, what, name, *scale)
        progress.stage("drawing")
        view = arguments.view or usual_view(mesh.vertices, mesh.faces)
        more: List[str] = []
        if arguments.ids:
            png, more = _ids_png(mesh, view, arguments)
        elif arguments.bare:
            camera = look_at(mesh.vertices, view, *arguments.size)
            png = bare_png(paint_mesh(mesh, camera, paint, progress.part))
        else:
            shown = what if name is None else name
            title = os.path.basename(arguments.file) + (": " + shown if shown else "")
            title = title if arguments.title is None else arguments.title
            png = picture_png(mesh, paint, view, arguments.size, title, progress.part)
        save_file(arguments.output, png, overwrite=arguments.force)
    width, height = arguments.size
    value = {"input": arguments.file, "output": arguments.output, "width": width, "height": height}
    notes = list(file.notes) + (file.label_notes if what == "labels" else []) + more
    value.update(file_bytes=file_bytes(arguments.output), notes=notes)
    lines = ["  note: " + note for note in notes]
    text = "{output}: written, {width} x {height} pixels, {file_bytes} bytes"
    say(arguments, value, lines + [text.format(**value)])
    return 0


def _check_ids(arguments):
    if arguments.what not in (None, "labels") or arguments.layer or arguments.face:
        text = "--ids are those of the labels, and no other thing is drawn with them"
        raise MapFileError("value", arguments.output, text, "--labels --ids")
    arguments.what = "labels"
    check_target(class_table(arguments.output), arguments.force)


def _ids_png(mesh, view, arguments):
    """(the picture, notes); the table is written."""
    known = known_classes(arguments)
    ids = label_ids(arguments.file, mesh.labels, mesh.uuid, len(mesh.faces), known)
    of_faces = ids.classes if arguments.ids == "class" else ids.instances
    camera = look_at(mesh.vertices, view, *arguments.size)
    picture = id_picture(mesh.vertices, mesh.faces, of_faces, camera)
    shown = {"pixels": arguments.ids + "_id", "camera": camera_table(camera)}
    table = class_table(arguments.output)
    save_file(table, table_text({**ids.table, **shown}), overwrite=arguments.force)
    return gray_png(picture), list(overlap_note(ids))


def _mesh(file, arguments):
    """A mesh with what is to be drawn, which kind that is, and the name of the values."""
    for what in ("layer", "face"):
        name = getattr(arguments, what)
        if name is not None:
            mesh = file.read(())
            if what == "layer" and name not in file.layer_names():
                if name in file.face_attribute_names():
                    what = "face"
            if what == "layer":
                mesh.vertex_costs[name] = file.vertex_costs(name)
                mesh.layer_parameters[name] = file.layer_parameters(name)
            else:
                mesh.face_attributes[name] = file.face_attribute(name)
            return mesh, what, name
    what = arguments.what
    if what is None:
        # colors of materials alone say less than those of the vertices
        shown = file.materials is not None and (file.texture_indices() or not file.has_colors)
        what = "textures" if shown else "colors" if file.has_colors else "height"
    return file.read(_NEEDED.get(what, ())), what, None

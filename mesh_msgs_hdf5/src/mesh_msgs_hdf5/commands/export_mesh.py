"""mesh_tool export: a map (or any mesh) to a file for other programs."""
import argparse
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
from mesh_msgs_hdf5.formats.exporter import WRITERS, check_georeferenced, write_mesh
from mesh_msgs_hdf5.files.save import check_target, save_file
from mesh_msgs_hdf5.labels.label_ids import label_ids, overlap_note, table_text
from mesh_msgs_hdf5.labels.map_contents import read_map
from mesh_msgs_hdf5.model.mesh import Mesh

NAME = "export"
HELP = "write a mesh for other programs (.ply .obj .stl .dae .glb .gltf); says what does not fit"
EXAMPLE = "mesh_tool export garden.h5 garden.ply"
SUFFIXES = tuple(WRITERS)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("input", metavar="IN", help="a map file, or any mesh that import reads")
    parser.add_argument(
        "output", metavar="OUT", help="the suffix is the format: " + " ".join(SUFFIXES)
    )
    text = "paint this layer into the colors of the vertices"
    parser.add_argument("--layer", metavar="NAME", help=text)
    text = "coordinates with the map's origin added, as CloudCompare and QGIS want them (.ply .obj)"
    parser.add_argument("--georeferenced", action="store_true", help=text)
    text = "faces have class_id and instance_id of their labels; beside OUT.ply OUT_classes.json, "
    parser.add_argument("--ids", action="store_true", help=text + "which says what they mean")
    add_classes(parser)
    parser.add_argument("--force", action="store_true", help="replace OUT if it exists")
    add_part(parser, "IN, if it is a map with several")
    add_output_options(parser, "say nothing")


def run(arguments: argparse.Namespace) -> int:
    check_output(arguments.input, arguments.output, arguments.force, SUFFIXES)
    if arguments.ids:
        check_output(None, arguments.output, arguments.force, (".ply",))
        check_target(class_table(arguments.output), arguments.force)
    if arguments.georeferenced:
        check_georeferenced(arguments.output)
    with ProgressLine(arguments.quiet) as progress:
        progress.stage("reading " + arguments.input)
        mesh, report = read_map(arguments.input, arguments.part)
        more = _with_ids(arguments, mesh) if arguments.ids else []
        progress.stage("writing " + arguments.output)
        notes = write_mesh(
            arguments.output, mesh, arguments.force, arguments.layer, arguments.georeferenced
        )
    notes = report.notes + more + notes
    value = {
        "input": arguments.input,
        "output": arguments.output,
        "vertices": len(mesh.vertices),
        "faces": len(mesh.faces),
        "notes": notes,
        "file_bytes": file_bytes(arguments.output),
    }
    lines = ["  note: " + note for note in notes]
    saved = "{output}: written, {vertices} vertices, {faces} faces, {file_bytes} bytes"
    say(arguments, value, lines + [saved.format(**value)])
    return 0


def _with_ids(arguments: argparse.Namespace, mesh: Mesh) -> List[str]:
    """Give the faces the numbers of their labels, and write what they mean; returns notes."""
    known = known_classes(arguments)
    ids = label_ids(arguments.input, mesh.labels, mesh.uuid, len(mesh.faces), known)
    notes = list(overlap_note(ids))
    for name, values in (("class_id", ids.classes), ("instance_id", ids.instances)):
        if name in mesh.face_attributes:
            notes.append("face attribute %s is that of the labels, not of the mesh" % name)
        mesh.face_attributes[name] = values
        mesh.face_parameters.pop(name, None)
    table = class_table(arguments.output)
    save_file(table, table_text(ids.table), overwrite=arguments.force)
    return notes

"""mesh_tool import: any mesh file to a map file."""
import argparse
import os

from mesh_msgs_hdf5.errors import MapFileError, one_line
from mesh_msgs_hdf5.importer import read_mesh
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.save import check_target
from mesh_msgs_hdf5.schema import check_frame_id

NAME = "import"
HELP = "make a map file (.h5) of a mesh (.ply .obj .stl .dae .h5)"
EXAMPLE = "mesh_tool import garden.ply garden.h5 --frame map"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("input", metavar="IN", help="the mesh")
    parser.add_argument("output", metavar="OUT.h5", help="the map file to make")
    parser.add_argument(
        "--frame", help="coordinate frame (default: that of IN if it is a map, else map)"
    )
    parser.add_argument(
        "--part", default="mesh", help="which mesh of IN, if it is a map (default: mesh)"
    )
    parser.add_argument("--force", action="store_true", help="replace OUT.h5 if it exists")


def run(arguments: argparse.Namespace) -> int:
    if not arguments.output.endswith((".h5", ".hdf5")):
        raise MapFileError(
            "name",
            arguments.output,
            "the name of a map file ends with .h5",
            "IN OUT.h5, in this order",
        )
    if arguments.frame is not None:
        check_frame_id(arguments.output, arguments.frame)
    check_target(arguments.output, arguments.force)
    if os.path.exists(arguments.output) and os.path.samefile(*_paths(arguments)):
        raise MapFileError("exists", arguments.output, "IN and OUT are the same file", "")
    mesh, report = read_mesh(arguments.input, arguments.part)
    if arguments.frame is not None:
        mesh.frame_id = arguments.frame
    MapFile.write(arguments.output, mesh, overwrite=arguments.force)
    print("\n".join(report.lines()))
    size = os.stat(arguments.output).st_size
    saved = "%s: saved, %d bytes, frame %s, uuid %s"
    print(one_line(saved % (arguments.output, size, mesh.frame_id, mesh.uuid)))
    return 0


def _paths(arguments):
    if not os.path.exists(arguments.input):
        raise MapFileError("missing", arguments.input, "there is no such file", "check the path")
    return arguments.input, arguments.output

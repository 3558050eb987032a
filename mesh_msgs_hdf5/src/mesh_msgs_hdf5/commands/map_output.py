"""The map file that a verb makes of a mesh, or the one mesh of it that it makes or replaces."""
import argparse
import os
from typing import Any, Dict, List, Optional

from mesh_msgs_hdf5.commands._common import add_output_options, check_output, file_bytes
from mesh_msgs_hdf5.commands.part_changes import put
from mesh_msgs_hdf5.commands.replaced_output import check_replaced, lost_with
from mesh_msgs_hdf5.labels.replaced_maps import check_journals, save_journals
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh


def add_map_output(parser: argparse.ArgumentParser, more: str = "") -> None:
    """The options --force, --compression, --to-part, --json and --quiet.

    more: what else is to be said of --to-part.
    """
    add = parser.add_argument
    add("--force", action="store_true", help="replace OUT.h5, or the mesh --to-part of it")
    text = "gzip (default), or none: larger and faster"
    add("--compression", choices=("gzip", "none"), default="gzip", help=text)
    text = "make or (--force) replace this mesh of OUT.h5, and keep all else that is in it"
    add("--to-part", metavar="NAME", help=text + more)
    add_output_options(parser, "say nothing")


def check_map_output(arguments: argparse.Namespace, source: Optional[str]) -> None:
    """Refuse early what cannot be saved; source: the file that is read, and must not be OUT.h5."""
    part = arguments.to_part
    if part is not None and not part.strip("/"):
        raise MapFileError("part", arguments.output, "a part needs a name", "--to-part floor2")
    into = _is_into(arguments)
    check_output(source, arguments.output, arguments.force or into)
    if not into:
        check_replaced(arguments.output)


def save_map(arguments: argparse.Namespace, mesh: Mesh) -> List[str]:
    """Save the mesh as OUT.h5, or in it; returns notes. Raises MapFileError."""
    output, part, compression = arguments.output, arguments.to_part, arguments.compression
    if _is_into(arguments):
        return put(output, mesh, part, arguments.force, compression)[0]
    part = "mesh" if part is None else "/".join(filter(None, part.split("/")))
    check_journals(output, lambda: {part: mesh.uuid})
    lost = lost_with(output, mesh) if arguments.force else []
    MapFile.write(output, mesh, part, overwrite=arguments.force, compression=compression)
    return lost + save_journals(output)


def saved_value(arguments: argparse.Namespace, mesh: Mesh) -> Dict[str, Any]:
    """What is to be said for programs of a mesh that was saved."""
    return {
        "output": arguments.output,
        "vertices": len(mesh.vertices),
        "faces": len(mesh.faces),
        "file_bytes": file_bytes(arguments.output),
        "frame_id": mesh.frame_id,
        "origin": mesh.origin,
        "crs": mesh.crs,
        "uuid": mesh.uuid,
    }


def saved_line(value: Dict[str, Any]) -> str:
    """The same for people."""
    return "{output}: saved, {file_bytes} bytes, frame {frame_id}, uuid {uuid}".format(**value)


def _is_into(arguments):
    return arguments.to_part is not None and os.path.exists(arguments.output)

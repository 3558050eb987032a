"""What would be lost with a map file that a command replaces as a whole."""
import os
from typing import Iterable, List, Optional

from mesh_msgs_hdf5.formats.any_mesh import is_map_file
from mesh_msgs_hdf5.isolation import IsolatedMapFile, isolated
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh

_SHOWN = 10
_FEW = 3


def check_replaced(path: str, kept: Optional[Iterable[str]] = None) -> None:
    """Refuse to replace a map file that has more than the one mesh that FILE stands for.

    kept: parts that the new file has; None: it has one mesh alone, so nothing else may be in the
    old one. A file that cannot be read may be replaced. Raises MapFileError (exists, locked).
    """
    if not os.path.exists(path):
        return
    try:
        if not is_map_file(path):
            return
        parts = isolated("parts", path)
        meant = "mesh" if "mesh" in parts else parts[0] if len(parts) == 1 else None
        lost = [part or "/" for part in parts if part not in {meant, *(kept or ())}]
        others = []
        if kept is None and meant is not None:
            others = IsolatedMapFile(path, meant or "/").other_contents()
    except MapFileError as error:
        if error.code == "locked":
            raise
        return
    if lost or others:
        texts = [_counted(names, what) for names, what in ((lost, "part"), (others, "object"))]
        raise MapFileError(
            "exists",
            path,
            "it holds %s, which would be lost" % " and ".join(filter(None, texts)),
            "mesh_tool import --to-part, or mesh_tool parts, changes one mesh and keeps all else; "
            "or remove the file",
        )


def lost_with(path: str, mesh: Mesh, part: Optional[str] = None) -> List[str]:
    """A note on what the mesh in a map file has that the one that replaces it has not; none where
    there is nothing, or the file cannot be read.

    part: the one that is replaced; None for the one that is meant where none is named.
    """
    gone = []
    try:
        if not os.path.exists(path) or not is_map_file(path):
            return []
        with IsolatedMapFile(path, part) as file:
            attributes = {*file.vertex_attribute_names(), *file.face_attribute_names()}
            for what, names, others in (
                ("label", file.label_names(), mesh.labels),
                ("layer", file.layer_names(), mesh.vertex_costs),
                ("attribute", attributes, {**mesh.vertex_attributes, **mesh.face_attributes}),
            ):
                lost = sorted(set(names).difference(others))
                if lost:
                    gone.append(_few(lost, what))
    except MapFileError:
        return []
    return ["gone with the mesh that was replaced: " + ", ".join(gone)] if gone else []


def _few(names, what):
    shown = ", ".join(names[:_FEW]) + (", ..." if len(names) > _FEW else "")
    return "%d %s%s (%s)" % (len(names), what, "" if len(names) == 1 else "s", shown)


def _counted(names, what):
    if not names:
        return ""
    shown = ", ".join(names[:_SHOWN]) + (", ..." if len(names) > _SHOWN else "")
    return "%d other %s%s (%s)" % (len(names), what, "" if len(names) == 1 else "s", shown)


def kept_parts(source: str) -> Iterable[str]:
    """The parts of a map file that is written anew; one at the root may get the name mesh."""
    return ["mesh", *isolated("parts", source)]

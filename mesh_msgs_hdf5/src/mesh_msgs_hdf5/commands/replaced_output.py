"""What would be lost with a map file that a command replaces as a whole."""
import os
from typing import Iterable, Optional

from mesh_msgs_hdf5.formats.any_mesh import is_map_file
from mesh_msgs_hdf5.isolation import IsolatedMapFile, isolated
from mesh_msgs_hdf5.model.errors import MapFileError

_SHOWN = 10


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


def _counted(names, what):
    if not names:
        return ""
    shown = ", ".join(names[:_SHOWN]) + (", ..." if len(names) > _SHOWN else "")
    return "%d other %s%s (%s)" % (len(names), what, "" if len(names) == 1 else "s", shown)


def kept_parts(source: str) -> Iterable[str]:
    """The parts of a map file that is written anew; one at the root may get the name mesh."""
    return ["mesh", *isolated("parts", source)]

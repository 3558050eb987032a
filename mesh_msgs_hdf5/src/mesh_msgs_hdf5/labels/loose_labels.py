"""Labels of a geometry of which nothing but the UUID is known."""
import contextlib
import os
from typing import Any, Dict, FrozenSet, List, Mapping, Optional
from urllib.parse import quote, unquote

from mesh_msgs_hdf5.errors import MapFileError, PathLike, one_line
from mesh_msgs_hdf5.labels.label_edits import LabelEdits
from mesh_msgs_hdf5.mesh import Label

_SUFFIX = ".labels.journal"
_MAX_NAME = 200  # bytes; other names are made of it


class _NoMap:
    """A base without labels (see LabelBase)."""

    part: Optional[str] = None
    face_count: Optional[int] = None
    names: FrozenSet[str] = frozenset()

    def __init__(self, path: str, uuid: str) -> None:
        self.path, self.uuid = path, uuid

    def refresh(self) -> bool:
        return False

    def get(self, _text: str) -> Optional[Label]:
        return None

    def all(self) -> Dict[str, Label]:
        return {}


class LooseLabels(LabelEdits):
    """The interface of LabelStore for a UUID without a map.

    All labels are in a journal <uuid>.labels.journal in a folder, which stays. Face indices are not
    checked against a mesh. dirty is False, save() does nothing.
    """

    def __init__(
        self, folder: PathLike, uuid: str, owner_info: Optional[Mapping[str, Any]] = None
    ) -> None:
        """Make the folder if it is not there. Raises MapFileError."""
        folder = os.path.abspath(os.fsdecode(folder))
        path = os.path.join(folder, _file_name(folder, uuid))
        try:
            os.makedirs(folder, exist_ok=True)
        except OSError as error:
            raise MapFileError(
                "save", folder, "the folder cannot be made: %s" % error.strerror, "name another one"
            ) from error
        super().__init__(_NoMap(path, uuid), path, owner_info)

    @property
    def dirty(self) -> bool:
        """Nothing is waiting for a map file."""
        return False

    def save(self) -> int:
        """Nothing to do: every edit is where it stays."""
        return 0


def loose_uuids(folder: PathLike) -> List[str]:
    """The UUIDs that have such labels in a folder, sorted; none if it cannot be read."""
    found = []
    with contextlib.suppress(OSError):
        for name in os.listdir(folder):
            uuid = unquote(name[: -len(_SUFFIX)])
            if name.endswith(_SUFFIX) and quote(uuid, safe="") + _SUFFIX == name:
                found.append(uuid)
    return sorted(found)


def _file_name(folder, uuid):
    """A UUID may be any text: what is no plain character is escaped."""
    try:
        name = quote(uuid, safe="")
    except UnicodeEncodeError:
        name = ""
    if not 0 < len(name) <= _MAX_NAME:
        raise MapFileError(
            "uuid", folder, "a mesh has the uuid %r" % one_line(uuid)[:80], "give it a short one"
        )
    return name + _SUFFIX

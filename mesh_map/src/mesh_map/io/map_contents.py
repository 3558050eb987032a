"""What else is in the file of a map: stored layers, face attributes, labels."""

import threading
from typing import Any, Dict, List, Optional

from mesh_msgs_hdf5.formats.any_mesh import Members
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.model.mesh import Label
from mesh_msgs_hdf5.files.save import stamp


class MapContents:
    """The members of a map file (see mesh_msgs_hdf5), read when they are asked for.

    Its labels are those of the file with the edits that the owner of its journal has made since,
    so that an area that was drawn in RViz a moment ago is there. All raise MapFileError. Safe for
    threads.
    """

    def __init__(self, members: Members, is_map_file: bool) -> None:
        """Args: members of the map; False for a mesh in memory, whose labels are its own."""
        self._members = members
        self._is_map_file = is_map_file
        self._store: Optional[LabelStore] = None
        self._lock = threading.Lock()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self._members, name)

    def label_names(self) -> List[str]:
        """The texts of all labels, tree_2 before tree_10."""
        return self._labels().names() if self._is_map_file else self._members.label_names()

    def label(self, text: str) -> Label:
        """One label."""
        return self._labels().get(text) if self._is_map_file else self._members.label(text)

    def labels(self) -> Dict[str, Label]:
        """Text -> label, of all: quicker than several of them one by one."""
        return self._labels().all() if self._is_map_file else self._members.labels()

    def labels_version(self) -> Any:
        """Something that is not equal to what it was when labels may have changed since.

        Looks at the time stamps of files, at the contents of none.
        """
        if not self._is_map_file:
            return 0
        store = self._labels()
        return stamp(store.path), stamp(store.journal_path)

    def _labels(self) -> LabelStore:
        with self._lock:
            if self._store is None:
                members = self._members
                store = LabelStore(members.path, members.part, read_only=True)
                if (store.uuid, store.face_count) != (members.uuid, members.face_count):
                    reason = "another program has replaced the mesh"
                    raise MapFileError("changed", members.path, reason, "open it again")
                self._store = store
            return self._store

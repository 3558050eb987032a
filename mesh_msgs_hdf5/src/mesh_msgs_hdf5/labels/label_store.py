"""The labels of a map: those in its file, with the edits of its journal."""
import os
from typing import Any, Dict, FrozenSet, List, Mapping, Optional, Tuple
from urllib.parse import quote

from mesh_msgs_hdf5.files.probe import kind_of, read_head
from mesh_msgs_hdf5.files.save import stamp
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.isolation import IsolatedMapFile, isolated
from mesh_msgs_hdf5.labels.label_edits import LabelEdits, frozen
from mesh_msgs_hdf5.labels.labelled_mesh import read_labelled_mesh
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Label, Mesh

Identity = Tuple[str, int]
_SINGLE_READS = 8  # of one label each, after which all are read at once
__all__ = ["LabelStore", "journal_path", "label_target", "source_mesh"]


def label_target(path: PathLike, part: Optional[str] = None) -> str:
    """The map file that keeps the labels of a map or mesh; links are followed.

    A map of schema S1 keeps its own. Those of a map of another schema go to garden_s1.h5 beside
    garden.h5, those of a mesh to garden.h5 beside garden.ply. Raises MapFileError.
    """
    path = os.path.realpath(os.fsdecode(path))
    if kind_of(path, read_head(path)) != "h5":
        return os.path.splitext(path)[0] + ".h5"
    return label_file(path, IsolatedMapFile(path, part).schema)


def label_file(path: PathLike, schema: str) -> str:
    """label_target() of a map file whose schema is known."""
    path = os.path.realpath(os.fsdecode(path))
    return path if schema == "S1" else os.path.splitext(path)[0] + "_s1.h5"


def source_mesh(path: PathLike) -> Tuple[Mesh, ImportReport]:
    """The mesh of a file that is no map, as its labels know it. Raises MapFileError."""
    target = label_target(path)
    return read_labelled_mesh(path, target, journal_path(target))


class LabelBase:
    """The labels in the map file of label_target(), or in the given one while that is not there.

    Not for several threads at once, except fold(). Attributes: path (the target), source (the map
    or mesh as given, links followed), part, uuid, face_count.
    """

    def __init__(
        self,
        source: PathLike,
        part: Optional[str] = None,
        identity: Optional[Identity] = None,
    ) -> None:
        """identity: (UUID, number of faces) of a mesh, where the caller knows them: saves reading.

        Raises MapFileError (exists: the target holds another mesh; whatever reading raises).
        """
        self.source = os.path.realpath(os.fsdecode(source))
        self._is_map = kind_of(self.source, read_head(self.source)) == "h5"
        self.path = label_target(self.source, part)
        if self._is_map:
            file = IsolatedMapFile(self.source, part)
            identity, part = (file.uuid, file.face_count), file.part
        elif identity is None:
            mesh, _ = source_mesh(self.source)
            identity = mesh.uuid, len(mesh.faces)
        self.part = part if self._is_map else "mesh"
        self.uuid, self.face_count = identity
        self._stamp: Any = ()
        self.refresh()

    def refresh(self) -> bool:
        """True if the file is another one than at the last call: all labels may have changed.

        Raises MapFileError (changed: its mesh is not the same any more).
        """
        now = stamp(self.path)
        if now == self._stamp and now is not None:
            return False
        if now is None and self.path != self.source:
            now = (None, stamp(self.source))  # not made yet
            if now == self._stamp:
                return False
        self._file = self._open()
        self.names: FrozenSet[str] = frozenset(self._file.label_names() if self._file else ())
        self._labels: Dict[str, Label] = {}
        self._has_all = False
        self._reads = 0
        self._stamp = now
        return True

    def get(self, text: str) -> Optional[Label]:
        """A label; None if there is none of that text. Raises MapFileError if it cannot be read."""
        if text not in self.names:
            return None
        if text not in self._labels:
            self._reads += 1
            if self._reads > _SINGLE_READS:
                self.all()
        if text not in self._labels:
            self._labels[text] = frozen(self._file.label(text))
        return self._labels[text]

    def all(self) -> Dict[str, Label]:
        """All labels that can be read; the dict may be changed, the labels not."""
        if not self._has_all and len(self._labels) < len(self.names):
            self._labels = {text: frozen(label) for text, label in self._file.labels().items()}
            self._has_all = True
        return dict(self._labels)

    @property
    def notes(self) -> List[str]:
        """What is wrong with labels that were read, and was mended or left out."""
        return list(self._file.notes) if self._file else []

    def fold(self, edits: Mapping[str, Optional[Label]]) -> None:
        """Put edits into the map file in one step; the file is made first if it is not there.

        May be called while other threads use the object. Raises MapFileError; then the file is as
        it was.
        """
        if self.path != self.source and not os.path.exists(self.path):
            self._make_target()
        file = IsolatedMapFile(self.path, self._part_in_target())
        self._check_geometry(file)
        file.update(Edit(labels=dict(edits)))

    def _open(self):
        """The file that has the labels now; None if that is a mesh of another format."""
        if self.path == self.source or os.path.exists(self.path):
            file = IsolatedMapFile(self.path, self._part_in_target())
        elif self._is_map:
            file = IsolatedMapFile(self.source, self.part)
        else:
            return None
        self._check_geometry(file)
        return file

    def _part_in_target(self):
        return self.part if self.path == self.source else None

    def _check_geometry(self, file):
        if (file.uuid, file.face_count) == (self.uuid, self.face_count):
            return
        if file.path == self.source:
            raise MapFileError(
                "changed",
                self.source,
                "another program has replaced the mesh (UUID %s, now %s)" % (self.uuid, file.uuid),
                "put the old file back; to edit the new one, open it again (start a node again)",
            )
        raise MapFileError(
            "exists",
            self.path,
            "the labels of %s belong here, but it holds another mesh" % self.source,
            "rename one of them",
        )

    def _make_target(self):
        if self._is_map:
            isolated("convert", self.source, self.path, part=self.part)
            return
        mesh, _ = source_mesh(self.source)
        if mesh.uuid != self.uuid:
            raise MapFileError(
                "changed", self.source, "another program has replaced the mesh", "open it again"
            )
        MapFile.write(self.path, mesh, overwrite=False)


def journal_path(path: PathLike, part: str = "mesh") -> str:
    """The journal of a part of a map file: garden.h5.journal, or garden.h5.<part>.journal."""
    path = os.path.realpath(os.fsdecode(path))
    return path + ("" if part == "mesh" else "." + quote(part or "/", safe="")) + ".journal"


class LabelStore(LabelEdits):
    """The labels of a map or mesh, of which one process at a time is the owner.

    What an edit returns is on the disk: in the journal at once, in the map file after save(). Who
    is not the owner sees the owner's edits, and becomes the owner with its next edit once that
    process has ended. Safe for threads. Two parts of a file have two stores.

    map_path: a map file of any schema, or a mesh; labels of what is no map of schema S1 go to the
    file of label_target(), which save() makes. part: as in MapFile. owner_info: what others shall
    know of this process. read_only: never the owner; no file is made. identity: (UUID, number of
    faces) of a mesh, where known: saves reading it.

    Raises MapFileError, for example journal: there are edits of another mesh in its journal. Why
    labels cannot be changed otherwise (read-only folder, other owner) is in refusal; notes has
    sentences for the user. Attributes: path (the map file that save() changes), part, uuid,
    face_count, journal_path, is_owner, owner, refusal, notes, read_only, dirty.
    """

    def __init__(
        self,
        map_path: PathLike,
        part: Optional[str] = None,
        owner_info: Optional[Mapping[str, Any]] = None,
        read_only: bool = False,
        identity: Optional[Identity] = None,
    ) -> None:
        base = LabelBase(map_path, part, identity)
        journal = journal_path(base.path, base.part)
        super().__init__(base, journal, owner_info, read_only)

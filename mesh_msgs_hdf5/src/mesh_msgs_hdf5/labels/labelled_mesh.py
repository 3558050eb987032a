"""A mesh of another format, as those know it who have labelled it."""
import os
from typing import Tuple

from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.importer import read_unharmed_mesh
from mesh_msgs_hdf5.isolation import IsolatedMapFile
from mesh_msgs_hdf5.labels.journal_reading import read_journal
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Mesh


def read_labelled_mesh(path: PathLike, target: str, journal: str) -> Tuple[Mesh, ImportReport]:
    """read_unharmed_mesh(path); without textures, with a note, where the map file of its labels, or
    their journal, is of the mesh without them: versions of before left them out at seams.

    Raises MapFileError.
    """
    mesh, report = read_unharmed_mesh(path)
    if mesh.seam_originals is None:
        return mesh, report
    parent, faces = mesh.parent_uuid, len(mesh.faces)
    kept = target if os.path.exists(target) else journal
    if not (_is_map_of(target, parent) if kept == target else _is_journal_of(kept, parent, faces)):
        return mesh, report
    mesh, report = read_unharmed_mesh(path, split_seams=False)
    report.note("%s is of the mesh without textures: import it again for these", kept)
    return mesh, report


def _is_map_of(path: str, uuid: str) -> bool:
    try:
        return IsolatedMapFile(path).uuid == uuid
    except MapFileError:
        return False


def _is_journal_of(path: str, uuid: str, face_count: int) -> bool:
    try:
        return bool(read_journal(path, uuid, face_count).edits)
    except MapFileError:
        return False

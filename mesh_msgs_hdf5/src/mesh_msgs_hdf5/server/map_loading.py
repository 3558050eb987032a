"""Opens the maps that a server was asked for."""
import os
from typing import Any, Dict, List, Tuple

import genpy
import numpy as np
from mesh_msgs.checks.rounding import is_too_much

from mesh_msgs_hdf5.files.probe import check_node_path, kind_of, read_head
from mesh_msgs_hdf5.files.save import stamp as file_stamp
from mesh_msgs_hdf5.formats.any_mesh import Members, MeshMembers
from mesh_msgs_hdf5.formats.importer import too_much_rounded
from mesh_msgs_hdf5.isolation import IsolatedMapFile, isolated
from mesh_msgs_hdf5.labels.fixed_labels import FixedLabels
from mesh_msgs_hdf5.labels.journal_reading import owner_text
from mesh_msgs_hdf5.labels.label_store import LabelStore, label_target, source_mesh
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.server.map_overlay import MapOverlay
from mesh_msgs_hdf5.server.served_map import ServedMap
from mesh_msgs_hdf5.server.server_options import ALL_PARTS, ROOT, MapRequest


def load(
    request: MapRequest, stamp: genpy.Time, owner_info: Dict[str, Any], read_only: bool
) -> Tuple[List[ServedMap], List[str]]:
    """The maps of one request, without their arrays, and sentences about them for the log.

    An imported mesh, or a map of another schema than ours, is taken from the map file beside it if
    changes of it were stored there before. owner_info: what other servers shall know of this one.
    Raises MapFileError.
    """
    path = request.path
    check_node_path(request.given)
    before = file_stamp(path)
    if kind_of(path, read_head(path)) != "h5":
        mesh, report = source_mesh(path)
        asked, sources = [request], [MeshMembers(path, mesh)]
        notes = ["%s: %s" % (path, note) for note in report.notes]
    else:
        parts: List[Any] = isolated("parts", path) if request.part == ALL_PARTS else []
        parts = [part or ROOT for part in parts] or [request.part or None]
        asked = [MapRequest(path, part) for part in parts]
        sources = [_map_source(path, one.part) for one in asked]
        notes = []
    found = [_served(*pair, stamp, owner_info, read_only) for pair in zip(asked, sources)]
    for served in found:
        served.loaded_stamp = before
        if served.overlay.path != path:
            notes.append("%s is served from %s, with what was stored there" % (path, served.target))
        notes += ["%s: %s" % (served.name, note) for note in served.labels.notes]
    return found, notes


def owner_notes(found: List[ServedMap], read_only: bool) -> List[str]:
    """Sentences for the log about maps whose labels another process edits."""
    owners = [(served.name, served.labels.owner) for served in found if not read_only]
    return [
        "%s: its labels belong to %s; edits of labels are sent there" % (name, owner_text(owner))
        for name, owner in owners
        if owner is not None
    ]


def source_now(request: MapRequest) -> Members:
    """What would be loaded, of a request for one part. Raises MapFileError."""
    if kind_of(request.path, read_head(request.path)) != "h5":
        return MeshMembers(request.path, source_mesh(request.path)[0])
    return _map_source(request.path, request.part)


def _map_source(path, part):
    source = IsolatedMapFile(path, part)
    rounding = source.vertex_rounding
    if is_too_much(rounding, source.vertices if rounding else np.zeros((1, 3), np.float32)):
        raise too_much_rounded(path, rounding)
    return source


def _served(request, source, stamp, owner_info, read_only):
    path = request.path
    locked = "nothing is stored: the server was started with ~read_only" if read_only else ""
    overlay = MapOverlay(source)
    identity = (overlay.uuid, overlay.face_count)
    part = None if isinstance(source, MeshMembers) else source.part
    target = label_target(path, part)
    if target != os.path.realpath(path) and os.path.exists(target):
        try:
            stored = IsolatedMapFile(target)
            if stored.uuid != overlay.uuid:
                text = "it holds another mesh than %s" % path
                raise MapFileError("exists", target, text, "rename one of them to store changes")
            overlay = MapOverlay(stored)
        except MapFileError as error:  # the mesh can be looked at all the same
            locked = "nothing is stored: %s" % error
            return ServedMap(request, overlay, FixedLabels(overlay, target, error), stamp, locked)
    try:
        labels: Any = LabelStore(path, part, owner_info, read_only, identity)
    except MapFileError as error:
        labels = FixedLabels(overlay, target, error)
    return ServedMap(request, overlay, labels, stamp, locked)

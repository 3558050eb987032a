"""Groups of faces in OBJ files as labels: ours by the remarks of our export, others where that is
asked for."""
from typing import Dict, List

import numpy as np

from mesh_msgs_hdf5.formats.base.beside import shown
from mesh_msgs_hdf5.formats.base.foreign_labels import (
    GROUPS,
    check_group_sources,
    take_grouped_labels,
)
from mesh_msgs_hdf5.formats.base.options import Options
from mesh_msgs_hdf5.formats.base.polygons import Triangles
from mesh_msgs_hdf5.formats.base.remarks import Remark, about, add_label
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.obj.obj_lines import ObjLines
from mesh_msgs_hdf5.model.errors import PathLike
from mesh_msgs_hdf5.model.mesh import Mesh

_NO_GROUPS = (b"default", b"off")
_MOST_NAMES = 5  # in a note


def take_groups(
    path: PathLike,
    lines: ObjLines,
    mesh: Mesh,
    triangles: Triangles,
    remarks: List[Remark],
    options: Options,
    report: ImportReport,
) -> None:
    """Labels of groups, objects or materials. Raises MapFileError (label)."""
    groups = _faces_of(lines, "groups", triangles)
    own = {
        remark["group"].encode(): remark
        for remark in about(remarks, "label")
        if isinstance(remark.get("group"), str)
    }
    for group, remark in own.items():
        add_label(path, mesh, remark, groups.get(group, np.zeros(0, np.int64)), report)
    if own:
        _note_edits(mesh, groups, own, options, report)
    if not mesh.labels and not options.labels_from and len(groups) > 1:
        report.note("--labels-from groups makes labels of its %d groups", len(groups))
    for source in check_group_sources(path, options.labels_from):
        found = groups if source == "groups" else _faces_of(lines, source, triangles)
        texts = {
            name.decode("utf-8", "replace"): faces
            for name, faces in found.items()
            if source != "groups" or name not in own  # those are labels already
        }
        if texts or not own:
            take_grouped_labels(path, mesh, texts, source, report)


def _note_edits(mesh, groups, own, options, report):
    """Say where the groups are not those that the remarks of our export tell of: they count."""
    new = [name for name, faces in groups.items() if name not in own and len(faces)]
    if new and "groups" not in options.labels_from:
        report.note(
            "%d faces are in groups that its comments do not name (%s): --labels-from groups makes "
            "labels of these, too",
            sum(len(groups[name]) for name in new),
            _some([shown(name) for name in new]),
        )
    changed = []
    for remark in own.values():
        label, before = mesh.labels.get(remark["label"]), remark.get("faces")
        if label is not None and type(before) is int and before != len(label.faces):
            changed.append("%s: %d, not %d" % (remark["label"], len(label.faces), before))
    if changed:
        text = "%d labels have another number of faces than its comments say: the groups count (%s)"
        report.note(text, len(changed), _some(changed))


def _some(names):
    return ", ".join(names[:_MOST_NAMES]) + (", ..." if len(names) > _MOST_NAMES else "")


def _faces_of(lines: ObjLines, source: str, triangles: Triangles) -> Dict[bytes, np.ndarray]:
    """name -> the triangles of all faces that stand below a line with it."""
    ranges: Dict[bytes, List[np.ndarray]] = {}
    key, one_name = GROUPS[source], source != "groups"
    found = [(face, text) for face, each, text in lines.names if each == key]
    for i, (start, text) in enumerate(found):
        end = found[i + 1][0] if i + 1 < len(found) else lines.faces.rows
        for name in [text.strip()] if one_name else text.split():
            if one_name or name not in _NO_GROUPS:
                ranges.setdefault(name, []).append(np.arange(start, end))
    return {name: _triangles_of(np.concatenate(parts), triangles) for name, parts in ranges.items()}


def _triangles_of(faces: np.ndarray, triangles: Triangles) -> np.ndarray:
    if triangles.polygons is None:
        return faces
    return np.flatnonzero(np.isin(triangles.polygons, faces))

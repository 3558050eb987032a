"""Mesh to Wavefront OBJ, with materials and textures beside it, colors behind the positions, and
labels as groups.

float32 is written with nine digits, from which it can be read again bit for bit.
"""
from typing import Dict, FrozenSet, List, Tuple

import numpy as np

from mesh_msgs_hdf5 import __version__
from mesh_msgs_hdf5.formats.base.export_parts import (
    Export,
    file_stem,
    lines,
    safe_name,
    text_rows,
    texture_files,
)
from mesh_msgs_hdf5.formats.base.remarks import Remark, color_list, mesh_remark, remark_texts
from mesh_msgs_hdf5.formats.obj.obj_seams import is_one_line_enough, seams_remark
from mesh_msgs_hdf5.model.errors import PathLike
from mesh_msgs_hdf5.model.mesh import Label, Mesh

_EXACT = "%.9g"
# of bytes; with ten digits they are right for those, too, who cut off the fraction of 255 times it
_LEVELS, _COLOR = (np.arange(256) / 255).astype(np.float32), "%.10g"


def obj_of(path: PathLike, mesh: Mesh) -> Export:
    """The OBJ file, its MTL file and the textures."""
    export = Export()
    remarks = mesh_remark(mesh)
    one_line = is_one_line_enough(mesh)
    remarks += [seams_remark(mesh)] if one_line else []
    groups = _groups(mesh, remarks)
    head: List[str] = []
    if mesh.materials is not None or mesh.textures:
        _write_materials(path, mesh, export, remarks)
        head = ["mtllib %s.mtl" % file_stem(path)]
    comments = ["mesh_msgs_hdf5 " + __version__] + remark_texts(path, remarks)
    parts = [lines(["# " + text for text in comments] + head)]
    parts.append(_vertices(mesh, len(mesh.parent_vertices if one_line else mesh.vertices)))
    if mesh.texture_coordinates is not None:
        parts.append(text_rows("vt %s %s\n" % (_EXACT, _EXACT), mesh.texture_coordinates))
    if mesh.vertex_normals is not None:
        parts.append(text_rows("vn %s\n" % " ".join([_EXACT] * 3), mesh.vertex_normals))
    parts += _faces(mesh, groups, mesh.parent_faces if one_line else mesh.faces)
    export.content = b"".join(parts)
    export.leave_out(
        mesh, "OBJ", "vertex_costs", "vertex_attributes", "face_attributes", "features"
    )
    return export


def _vertices(mesh: Mesh, count: int) -> bytes:
    """The first ones; the others are copies of them."""
    vertices = mesh.vertices[:count]
    # the fewest digits from which float64 can be read again, where the vertices are georeferenced
    pattern = "v " + " ".join([_EXACT if mesh.vertices.dtype == np.float32 else "%r"] * 3)
    if mesh.vertex_colors is None:
        return text_rows(pattern + "\n", vertices)
    table = np.concatenate([vertices, _LEVELS[mesh.vertex_colors[:count]]], axis=1)
    return text_rows(pattern + " %s %s %s\n" % ((_COLOR,) * 3), table)


def _faces(mesh: Mesh, groups: Dict[str, str], corners: np.ndarray) -> List[bytes]:
    """f lines, with usemtl and g lines where material or labels change.

    corners: (F, 3) the v lines of the faces; vt and vn lines are the vertices of the mesh.
    """
    texture, normal = mesh.texture_coordinates is not None, mesh.vertex_normals is not None
    corner = {
        (False, False): "%d",
        (True, False): "%d/%d",
        (False, True): "%d//%d",
        (True, True): "%d/%d/%d",
    }[texture, normal]
    pattern = "f %s\n" % " ".join([corner] * 3)
    table = np.repeat(mesh.faces.astype(np.int64) + 1, corner.count("%"), axis=1)
    table[:, :: corner.count("%")] = corners.astype(np.int64) + 1
    material = np.zeros(len(table), np.int64)
    if mesh.materials is not None:
        material = mesh.materials.face_materials.astype(np.int64)
    state, sets = _label_sets(mesh.labels, len(table))
    change = np.ones(len(table), bool)
    change[1:] = (material[1:] != material[:-1]) | (state[1:] != state[:-1])
    starts = np.flatnonzero(change).tolist() + [len(table)]
    parts: List[bytes] = []
    now = (-1, -1)
    for start, end in zip(starts[:-1], starts[1:]):
        new = int(material[start]), int(state[start])
        if mesh.materials is not None and new[0] != now[0]:
            parts.append(b"usemtl material_%d\n" % new[0])
        if groups and new[1] != now[1]:
            names = " ".join(groups[text] for text in mesh.labels if text in sets[new[1]])
            parts.append(("g %s\n" % names).encode("ascii"))
        parts.append(text_rows(pattern, table[start:end]))
        now = new
    return parts


def _label_sets(
    labels: Dict[str, Label], face_count: int
) -> Tuple[np.ndarray, List[FrozenSet[str]]]:
    """(for each face (F,) the number of the set of its labels, the sets)."""
    state = np.zeros(face_count, np.int64)
    sets: List[FrozenSet[str]] = [frozenset()]
    for text, label in labels.items():
        before, place = np.unique(state[label.faces], return_inverse=True)
        state[label.faces] = (len(sets) + np.arange(len(before)))[place]
        sets += [sets[number] | {text} for number in before.tolist()]
    return state, sets


def _groups(mesh: Mesh, remarks: List[Remark]) -> Dict[str, str]:
    """label -> name of its group: its text, where that is a word that every program reads."""
    groups: Dict[str, str] = {}
    taken = {"default", "off"}
    for text, label in mesh.labels.items():
        groups[text] = safe_name(text, taken)
        taken.add(groups[text])
        remark = {"label": text, "group": groups[text], "faces": len(label.faces)}
        remarks.append(dict(remark, color=color_list(label.color)) if label.color else remark)
    return groups


def _write_materials(path: PathLike, mesh: Mesh, export: Export, remarks: List[Remark]) -> None:
    files = texture_files(path, mesh, export)
    remarks += [{"texture": index, "file": name} for index, name in files.items()]
    text = ["# mesh_msgs_hdf5 " + __version__]
    materials = mesh.materials
    count = 0 if materials is None else len(materials.colors)
    remarks.append({"materials": count})
    if materials is not None:
        for i, (color, index) in enumerate(zip(materials.colors, materials.texture_indices)):
            text += [
                "newmtl material_%d" % i,
                " ".join(["Kd"] + [_COLOR % level for level in _LEVELS[color]]),
            ]
            if index >= 0:
                text.append("map_Kd %s" % files[int(index)])
    export.beside[file_stem(path) + ".mtl"] = lines(text)

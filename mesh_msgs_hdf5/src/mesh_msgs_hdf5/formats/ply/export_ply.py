"""Mesh to PLY (binary, little endian) with everything but texture features.

Layers and vertex attributes are properties of the vertices, face attributes, materials and labels
of the faces. What PLY
has no place for stands in comments (see remarks), from which our import brings it back.
"""
from typing import Any, Dict, List, Set, Tuple

import numpy as np

from mesh_msgs_hdf5 import __version__
from mesh_msgs_hdf5.formats.base.export_parts import Export, lines, safe_name, texture_files
from mesh_msgs_hdf5.formats.base.remarks import Remark, color_list, mesh_remark, remark_texts
from mesh_msgs_hdf5.formats.ply.import_ply import COLORS, NORMAL, NO_LAYERS, POSITION
from mesh_msgs_hdf5.formats.ply.ply_faces import CORNERS, FACE_COLORS, SEAMS, TEXTURE_FILE
from mesh_msgs_hdf5.formats.ply.ply_file import TYPES
from mesh_msgs_hdf5.model.errors import PathLike
from mesh_msgs_hdf5.model.mesh import Mesh

_NAMES = {kind: name for name, kind in reversed(TYPES.items())}  # the first one of each
_OF_FACES = frozenset(CORNERS).union(
    COLORS[0], ["alpha", "flags", "label", "material", "texcoord", "texnumber"]
)
Column = Tuple[str, np.ndarray]


def ply_of(path: PathLike, mesh: Mesh) -> Export:
    """The PLY file and the textures beside it."""
    export = Export()
    remarks = mesh_remark(mesh)
    vertices = _vertex_columns(mesh, remarks)
    files = texture_files(path, mesh, export)
    faces = _face_columns(mesh, remarks, sorted(files), export)
    remarks += [{"texture": index, "file": name} for index, name in files.items()]
    head = ["ply", "format binary_little_endian 1.0", "comment mesh_msgs_hdf5 " + __version__]
    head += ["comment " + TEXTURE_FILE + name for name in files.values()]
    head += ["comment " + text for text in remark_texts(path, remarks)]
    head += ["element vertex %d" % len(mesh.vertices)]
    head += ["property %s %s" % (_type(values), name) for name, values in vertices]
    head += ["element face %d" % len(mesh.faces)]
    kind = "i4" if len(mesh.vertices) < 1 << 31 else "u4"
    head += ["property list uchar %s vertex_indices" % _NAMES[kind]]
    head += ["property %s %s" % (_type(values), name) for name, values in faces]
    seams: List[Column] = []
    if mesh.seam_originals is not None:  # behind all that other programs read
        seams = [(SEAMS[1], mesh.seam_originals)]
        head += ["element %s %d" % (SEAMS[0], len(mesh.seam_originals))]
        head += ["property %s %s" % (_type(values), name) for name, values in seams]
    table = [("count", np.full(len(mesh.faces), 3, np.uint8)), ("corners", mesh.faces.astype(kind))]
    export.content = b"".join(
        [lines(head + ["end_header"]), _table(vertices), _table(table + faces)]
        + [_table(seams) for _ in seams]
    )
    export.leave_out(mesh, "PLY", "features")
    return export


def _type(values: np.ndarray) -> str:
    return _NAMES[values.dtype.str[1:]]


def _table(columns: List[Column]) -> bytes:
    """The rows of the columns, packed, little endian."""
    fields = [(name, "<" + v.dtype.str[1:], v.shape[1:]) for name, v in columns]
    rows = np.zeros(len(columns[0][1]), np.dtype(fields))
    for name, values in columns:
        rows[name] = values
    return rows.tobytes()


def _named(names, values) -> List[Column]:
    return [(name, values[:, i]) for i, name in enumerate(names)]


def _vertex_columns(mesh: Mesh, remarks: List[Remark]) -> List[Column]:
    columns = _named(POSITION, mesh.vertices)
    if mesh.vertex_normals is not None:
        columns += _named(NORMAL, mesh.vertex_normals)
    if mesh.vertex_colors is not None:
        columns += _named(COLORS[0], mesh.vertex_colors)
    if mesh.texture_coordinates is not None:
        columns += _named(("s", "t"), mesh.texture_coordinates)
    taken = set(NO_LAYERS).union(POSITION)
    for name, costs in mesh.vertex_costs.items():
        stored = safe_name(name, taken, "layer_")
        taken.add(stored)
        columns.append((stored, costs))
        parameters = mesh.layer_parameters.get(name)
        remark: Remark = {"layer": name, "property": stored}
        remarks.append(dict(remark, parameters=parameters) if parameters else remark)
    for name, values in mesh.vertex_attributes.items():
        found = _attribute_columns(name, values, taken, "vertex_")
        columns += found
        # always with a remark: without one it would be a layer
        remark = _attribute_remark("vertex_attribute", name, found, values)
        parameters = mesh.vertex_parameters.get(name)
        remarks.append(dict(remark, parameters=parameters) if parameters else remark)
    return columns


def _attribute_remark(key: str, name: str, found: List[Column], values: np.ndarray) -> Remark:
    return {
        key: name,
        "properties": [stored for stored, _ in found],
        "type": values.dtype.str[1:],
        "rank": values.ndim,
    }


def _face_columns(
    mesh: Mesh, remarks: List[Remark], textures: List[int], export: Export
) -> List[Column]:
    columns: List[Column] = []
    taken = set(_OF_FACES)
    materials = mesh.materials
    if materials is not None:
        columns.append(("material", materials.face_materials))
        for i, (color, index) in enumerate(zip(materials.colors, materials.texture_indices)):
            remark = {"material": i, "color": color_list(color)}
            remarks.append(dict(remark, texture=int(index)) if index >= 0 else remark)
        if textures:  # the place among the files, for other programs
            place = {index: i for i, index in enumerate(textures)}
            numbers = [place.get(index, -1) for index in materials.texture_indices.tolist()]
            columns.append(("texnumber", np.array(numbers, np.int32)[materials.face_materials]))
    columns += _label_columns(mesh, taken, remarks)
    for name, values in mesh.face_attributes.items():
        parameters = mesh.face_parameters.get(name)
        is_color = name == FACE_COLORS and values.dtype == np.uint8 and values.shape[1:] == (3,)
        if is_color:
            found = _named(COLORS[0], values)
        else:
            found = _attribute_columns(name, values, taken, "face_")
        columns += found
        plain = is_color or [name] == [stored for stored, _ in found] and values.ndim == 1
        if not plain or parameters or found[0][1].dtype != values.dtype:
            remark = _attribute_remark("face_attribute", name, found, values)
            remarks.append(dict(remark, parameters=parameters) if parameters else remark)
    return columns


def _attribute_columns(name: str, values: np.ndarray, taken: Set[str], prefix: str) -> List[Column]:
    """A property for each column; two, the lower half first, for whole numbers of 64 bits."""
    stored = safe_name(name, taken, prefix)
    values = values.reshape(len(values), -1)
    if values.dtype.str[1:] == "f2":
        values = values.astype(np.float32)
    elif values.dtype.itemsize == 8 and values.dtype.kind in "iu":
        values = np.ascontiguousarray(values, "<" + values.dtype.str[1:]).view("<u4")
    taken.add(stored)
    if values.shape[1] == 1:
        return [(stored, values[:, 0])]
    names = []
    for i in range(values.shape[1]):
        names.append(safe_name("%s_%d" % (stored, i), taken))
        taken.add(names[-1])
    return _named(names, values)


def _label_columns(mesh: Mesh, taken: Set[str], remarks: List[Remark]) -> List[Column]:
    """Properties with numbers of labels (0: none); labels that overlap are in different ones."""
    columns: List[Tuple[str, np.ndarray]] = []
    numbers: Dict[str, Any] = {}
    for text, label in mesh.labels.items():
        free = [c for c in columns if not c[1][label.faces].any()]
        if not free:
            name = "label" if not columns else safe_name("label_%d" % (len(columns) + 1), taken)
            taken.add(name)
            columns.append((name, np.zeros(len(mesh.faces), np.int32)))
            free = columns[-1:]
        name, values = free[0]
        numbers[name] = numbers.get(name, 0) + 1
        values[label.faces] = numbers[name]
        remark = {"label": text, "property": name, "value": numbers[name]}
        remarks.append(dict(remark, color=color_list(label.color)) if label.color else remark)
    return columns

"""Mesh to glTF 2.0, in one file (GLB) or with binary data and textures beside it: a primitive for
each material, y up.

Format: Khronos Group, glTF 2.0 Specification, 2021. Layers and vertex attributes are attributes of
our own (_NAME), which viewers skip; labels, face attributes and numbers that glTF has no accessors
for are buffer views that remarks in the extras of the asset explain.
"""
import json
import struct
import types
from typing import Any, Dict, List, Mapping, Optional

import numpy as np

from mesh_msgs_hdf5 import __version__
from mesh_msgs_hdf5.checks.check import identical
from mesh_msgs_hdf5.formats.base.export_parts import (
    Export,
    check_size,
    file_stem,
    safe_name,
    texture_files,
)
from mesh_msgs_hdf5.formats.base.images import png
from mesh_msgs_hdf5.formats.base.remarks import Remark, color_list, mesh_remark, remark_texts
from mesh_msgs_hdf5.formats.gltf.gltf_file import BINARY_CHUNK, COMPONENTS, JSON_CHUNK, MAGIC
from mesh_msgs_hdf5.formats.gltf.gltf_order import order_remark
from mesh_msgs_hdf5.formats.gltf.gltf_scene import TEXTURE_V, VERTEX_COLOR
from mesh_msgs_hdf5.model.errors import PathLike
from mesh_msgs_hdf5.model.mesh import Mesh

_CODES = {kind.lstrip("<"): code for code, kind in COMPONENTS.items()}
_CODES_OF_VERTICES = set(_CODES) - {"u4"}  # glTF 2.0, 3.7.2.1: of the others indices alone
_SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
_OF_VERTICES, _OF_INDICES = 34962, 34963  # targets of buffer views


def glb_of(path: PathLike, mesh: Mesh) -> Export:
    """The GLB file."""
    export = Export()
    builder = _Builder()
    document = _document(path, mesh, builder, export)
    export.content = _packed(path, document, builder)
    export.leave_out(mesh, "GLB", "features")
    return export


def gltf_of(path: PathLike, mesh: Mesh) -> Export:
    """The glTF file, a file with its binary data and the textures."""
    export = Export()
    builder = _Builder(texture_files(path, mesh, export))
    document = _document(path, mesh, builder, export)
    check_size(path, builder.size, "glTF's binary")
    name = file_stem(path) + ".bin"
    document["buffers"][0]["uri"] = name
    export.beside[name] = b"".join(builder.parts)
    export.content = json.dumps(document, allow_nan=False, indent=1).encode("ascii") + b"\n"
    export.leave_out(mesh, "glTF", "features")
    return export


def _document(path: PathLike, mesh: Mesh, builder: "_Builder", export: Export) -> Dict[str, Any]:
    remarks: List[Remark] = [{"vertices": len(mesh.vertices)}] + mesh_remark(mesh)
    attributes = _attributes(mesh, builder, remarks, export)
    primitives = _primitives(mesh, builder, attributes, remarks)
    _add_images(mesh, builder, remarks)
    _add_face_values(mesh, builder, remarks)
    if mesh.seam_originals is not None:
        remarks.append({"seams": builder.view(mesh.seam_originals.astype("<u4").tobytes())})
    extras = {"mesh_tools": remark_texts(path, remarks)}
    document: Dict[str, Any] = {
        "asset": {
            "version": "2.0",
            "generator": "mesh_msgs_hdf5 " + __version__,
            "extras": extras,
        },
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": primitives}],
        "buffers": [{"byteLength": builder.size}],
    }
    document.update({name: items for name, items in builder.items.items() if items})
    return document


class _Builder:
    """The binary data, and the JSON objects that describe it.

    files: texture index -> name of a file beside the document; {} where images are in the data.
    """

    def __init__(self, files: Mapping[int, str] = types.MappingProxyType({})):
        self.files = files
        self.parts: List[bytes] = []
        self.size = 0
        names = ("accessors", "bufferViews", "images", "textures", "materials")
        self.items: Dict[str, List[Any]] = {name: [] for name in names}

    def add(self, name: str, item: Dict[str, Any]) -> int:
        """The index of a new object."""
        self.items[name].append(item)
        return len(self.items[name]) - 1

    def view(self, data: bytes, target: Optional[int] = None) -> int:
        """A buffer view of these bytes, which begins at a multiple of four."""
        item = {"buffer": 0, "byteOffset": self.size, "byteLength": len(data)}
        if target is not None:
            item["target"] = target
        padding = -len(data) % 4
        self.parts += [data, bytes(padding)]
        self.size += len(data) + padding
        return self.add("bufferViews", item)

    def accessor(self, values: np.ndarray, target: int, **more: Any) -> int:
        """An accessor of (N, C), rows of vertices at multiples of four bytes; more: properties."""
        values = np.ascontiguousarray(values, values.dtype.newbyteorder("<"))
        size = values.dtype.itemsize * values.shape[1]
        rows = np.zeros((len(values), size + -size % 4), np.uint8)
        rows[:, :size] = values.view(np.uint8).reshape(len(values), size)
        view = self.view(rows.tobytes(), target)
        if size % 4 and target == _OF_VERTICES:
            self.items["bufferViews"][view]["byteStride"] = rows.shape[1]
        item = {
            "bufferView": view,
            "componentType": _CODES[values.dtype.str[1:]],
            "count": len(values),
            "type": _SHAPES[values.shape[1]],
        }
        return self.add("accessors", dict(item, **more))


def y_up(vectors: np.ndarray) -> np.ndarray:
    """(N, 3) of axes x, y, z (z up) as x, z, -y."""
    return np.stack([vectors[:, 0], vectors[:, 2], -vectors[:, 1]], axis=1)


def to_linear(colors: np.ndarray) -> np.ndarray:
    """Light from 0 to 1 of uint8 as screens have it (IEC 61966-2-1)."""
    value = colors / 255.0
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def _attributes(mesh: Mesh, builder: _Builder, remarks: List[Remark], export: Export):
    """name -> accessor of everything that vertices have."""

    def add(values: np.ndarray, **more: Any) -> int:
        return builder.accessor(values, _OF_VERTICES, **more)

    positions = y_up(mesh.vertices)
    low, high = (f(axis=0).astype(np.float64).tolist() for f in (positions.min, positions.max))
    found = {"POSITION": add(positions, min=low, max=high)}
    if mesh.vertex_normals is not None:
        found["NORMAL"] = add(y_up(mesh.vertex_normals))
    if mesh.texture_coordinates is not None:
        uv = mesh.texture_coordinates.astype(np.float64)
        uv[:, 1] = 1 - uv[:, 1]  # glTF counts v downwards
        found["TEXCOORD_0"] = add(uv.astype(np.float32))
        upwards = mesh.texture_coordinates[:, 1:]
        back = (1 - uv[:, 1:].astype(np.float32).astype(np.float64)).astype(np.float32)
        if not identical(back, upwards):
            found[TEXTURE_V] = add(upwards)
    if mesh.vertex_colors is not None:
        if mesh.materials is None:
            # eight bits of light are fewer than eight of a screen, and of sixteen some programs
            # (MeshLab, trimesh) read the lower eight
            found["COLOR_0"] = add(to_linear(mesh.vertex_colors).astype(np.float32))
        else:
            # viewers would multiply them with the colors of the materials
            rows = np.full((len(mesh.vertices), 4), 255, np.uint8)
            rows[:, :3] = mesh.vertex_colors
            found[VERTEX_COLOR] = add(rows, normalized=True)
            export.note("vertex colors are attribute %s: viewers show the materials", VERTEX_COLOR)
    taken = {VERTEX_COLOR, TEXTURE_V}
    for name, costs in mesh.vertex_costs.items():
        attribute = safe_name("_" + name.upper(), taken)
        taken.add(attribute)
        remark: Remark = {"layer": name, "attribute": attribute}
        if mesh.layer_parameters.get(name):
            remark["parameters"] = mesh.layer_parameters[name]
        costs = _finite(costs, remark)
        if len(remark) > 2 and ("lethal" in remark or "unknown" in remark):
            export.note(
                "layer %s: glTF allows finite numbers only; ours in the file stand for "
                "lethal and unknown",
                name,
            )
        found[attribute] = add(costs[:, None])
        remarks.append(remark)
    for name, values in mesh.vertex_attributes.items():
        remark = {"vertex_attribute": name}
        rows = values.reshape(len(values), -1)
        if values.dtype.str[1:] in _CODES_OF_VERTICES and rows.shape[1] in _SHAPES:
            if values.dtype.kind != "f" or np.isfinite(values).all():
                remark["attribute"] = safe_name("_" + name.upper(), taken)
                taken.add(remark["attribute"])
                found[remark["attribute"]] = add(rows)
        if "attribute" not in remark:
            remark.update(_in_view(builder, values))
        if mesh.vertex_parameters.get(name):
            remark["parameters"] = mesh.vertex_parameters[name]
        remarks.append(remark)
    return found


def _in_view(builder: _Builder, values: np.ndarray) -> Remark:
    """Puts (N,) or (N, C) of any type into a view; what a remark says of it."""
    kind = values.dtype.str[1:]
    return {
        "view": builder.view(np.ascontiguousarray(values, "<" + kind).tobytes()),
        "type": kind,
        "columns": 1 if values.ndim == 1 else values.shape[1],
        "rank": values.ndim,
    }


def _finite(costs: np.ndarray, remark: Remark) -> np.ndarray:
    """The costs with numbers that no other vertex has for +inf and NaN; the remark says which."""
    result = costs.copy()
    for key, places, number in (
        ("lethal", costs == np.inf, np.finfo(np.float32).max),
        ("unknown", np.isnan(costs), np.finfo(np.float32).min),
    ):
        if places.any():
            while (result == number).any():
                number = np.nextafter(number, np.float32(0))
            result[places] = number
            remark[key] = float(number)
    return result


def _primitives(mesh: Mesh, builder: _Builder, attributes, remarks: List[Remark]):
    materials = mesh.materials
    faces = mesh.faces.astype("<u4")
    if materials is None:
        index = builder.accessor(faces.reshape(-1, 1), _OF_INDICES)
        remarks.append(order_remark(y_up(mesh.vertices), [faces]))
        return [{"attributes": attributes, "indices": index}]
    order = np.argsort(materials.face_materials, kind="stable")
    ordered = materials.face_materials[order]
    primitives = []
    for material in np.unique(ordered).tolist():
        start, end = np.searchsorted(ordered, [material, material + 1])
        index = builder.accessor(faces[order[start:end]].reshape(-1, 1), _OF_INDICES)
        primitives.append({"attributes": attributes, "indices": index, "material": material})
    remarks.append(order_remark(y_up(mesh.vertices), [faces[order]]))
    if len(primitives) > 1:
        view = builder.view(order.astype("<u4").tobytes())
        remarks.append({"face_order": view})
    return primitives


def _add_images(mesh: Mesh, builder: _Builder, remarks: List[Remark]) -> None:
    place = {}
    for index in sorted(mesh.textures):
        item: Dict[str, Any] = {"mimeType": "image/png"}
        if index in builder.files:
            item["uri"] = builder.files[index]
        else:
            item["bufferView"] = builder.view(png(mesh.textures[index]))
        image = builder.add("images", item)
        place[index] = builder.add("textures", {"source": image})
        remarks.append({"texture": index, "image": image})
    if mesh.materials is None:
        return
    for color, index in zip(mesh.materials.colors, mesh.materials.texture_indices.tolist()):
        shading: Dict[str, Any] = {
            "baseColorFactor": to_linear(color).tolist() + [1.0],
            "metallicFactor": 0.0,
        }
        if index >= 0:
            shading["baseColorTexture"] = {"index": place[index]}
        builder.add("materials", {"pbrMetallicRoughness": shading, "doubleSided": True})


def _add_face_values(mesh: Mesh, builder: _Builder, remarks: List[Remark]) -> None:
    for name, values in mesh.face_attributes.items():
        remark: Remark = dict({"face_attribute": name}, **_in_view(builder, values))
        if mesh.face_parameters.get(name):
            remark["parameters"] = mesh.face_parameters[name]
        remarks.append(remark)
    for text, label in mesh.labels.items():
        remark = {"label": text, "count": len(label.faces)}
        if len(label.faces):  # a buffer view is never empty
            remark["view"] = builder.view(label.faces.astype("<u4").tobytes())
        if label.color:
            remark["color"] = color_list(label.color)
        remarks.append(remark)


def _packed(path: PathLike, document: Dict[str, Any], builder: _Builder) -> bytes:
    text = json.dumps(document, allow_nan=False, separators=(",", ":")).encode("ascii")
    text += b" " * (-len(text) % 4)
    size = 12 + 8 + len(text) + 8 + builder.size
    check_size(path, size, "GLB")
    head = MAGIC + struct.pack("<2I", 2, size) + struct.pack("<2I", len(text), JSON_CHUNK)
    chunk = struct.pack("<2I", builder.size, BINARY_CHUNK)
    return b"".join([head, text, chunk] + builder.parts)

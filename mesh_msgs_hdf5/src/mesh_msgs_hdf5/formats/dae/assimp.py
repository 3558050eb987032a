"""A scene as assimp reads it, through its C interface.

Only the leading fields of its structures are named here, which have stayed the same since assimp 3;
pyassimp, which names them all, does not fit the library that it is shipped with (Debian 12) and
crashes.
"""
import ctypes
import ctypes.util
import os
from typing import Any, Dict, List, Optional, Tuple

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.formats.base.material_list import byte_color
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.base.scene import Scene, ScenePart, check_scene_size, joined
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

_TRIANGULATE, _SORT_BY_KIND = 0x8, 0x8000
_TRIANGLES = 0x4
_INCOMPLETE = 0x1  # there was no mesh: assimp has put a drawing of the joints in its place
_NAMES = ("libassimp.so.5", "libassimp.so.6", "libassimp.so.4", "libassimp.so")
_FACE = np.dtype(
    {"names": ["count", "corners"], "formats": ["u4", "u8"], "offsets": [0, 8], "itemsize": 16}
)
_DIFFUSE = 1  # the kind of texture that gives surfaces their color
_HOLES = "polygons with holes are not read: export it as triangles where it was made"
Material = Dict[str, Any]


class _Text(ctypes.Structure):
    _fields_ = [("length", ctypes.c_uint), ("data", ctypes.c_char * 1024)]


class _Mesh(ctypes.Structure):
    _fields_ = [
        ("kinds", ctypes.c_uint),
        ("vertex_count", ctypes.c_uint),
        ("face_count", ctypes.c_uint),
        ("vertices", ctypes.POINTER(ctypes.c_float)),
        ("normals", ctypes.POINTER(ctypes.c_float)),
        ("tangents", ctypes.c_void_p),
        ("bitangents", ctypes.c_void_p),
        ("colors", ctypes.POINTER(ctypes.c_float) * 8),
        ("texture_coordinates", ctypes.POINTER(ctypes.c_float) * 8),
        ("texture_sizes", ctypes.c_uint * 8),
        ("faces", ctypes.c_void_p),
        ("bone_count", ctypes.c_uint),
        ("bones", ctypes.c_void_p),
        ("material", ctypes.c_uint),
    ]


class _Node(ctypes.Structure):
    pass


_Node._fields_ = [
    ("name_length", ctypes.c_uint),
    ("name", ctypes.c_char * 1024),
    ("transform", ctypes.c_float * 16),
    ("parent", ctypes.c_void_p),
    ("child_count", ctypes.c_uint),
    ("children", ctypes.POINTER(ctypes.POINTER(_Node))),
    ("mesh_count", ctypes.c_uint),
    ("meshes", ctypes.POINTER(ctypes.c_uint)),
]


class _Texture(ctypes.Structure):
    _fields_ = [
        ("width", ctypes.c_uint),  # bytes, where height is 0: a file of images
        ("height", ctypes.c_uint),
        ("hint", ctypes.c_char * 9),
        ("data", ctypes.c_void_p),
        ("name", _Text),
    ]


class _Scene(ctypes.Structure):
    _fields_ = [
        ("flags", ctypes.c_uint),
        ("root", ctypes.POINTER(_Node)),
        ("mesh_count", ctypes.c_uint),
        ("meshes", ctypes.POINTER(ctypes.POINTER(_Mesh))),
        ("material_count", ctypes.c_uint),
        ("materials", ctypes.POINTER(ctypes.c_void_p)),
        ("animation_count", ctypes.c_uint),
        ("animations", ctypes.c_void_p),
        ("texture_count", ctypes.c_uint),
        ("textures", ctypes.POINTER(ctypes.POINTER(_Texture))),
    ]


def _library(path):
    for name in _NAMES + (ctypes.util.find_library("assimp"),):
        try:
            library = ctypes.CDLL(name) if name else None
        except OSError:
            continue
        if library is not None:
            break
    else:
        raise MapFileError(
            "format", path, "reading it needs the library assimp", "apt install libassimp5"
        )
    library.aiImportFile.restype = ctypes.POINTER(_Scene)
    library.aiImportFile.argtypes = [ctypes.c_char_p, ctypes.c_uint]
    library.aiGetErrorString.restype = ctypes.c_char_p
    library.aiGetErrorString.argtypes = []
    library.aiReleaseImport.restype = None
    library.aiReleaseImport.argtypes = [ctypes.POINTER(_Scene)]
    material = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_uint, ctypes.c_uint]
    library.aiGetMaterialColor.argtypes = material + [ctypes.POINTER(ctypes.c_float * 4)]
    library.aiGetMaterialString.argtypes = material + [ctypes.POINTER(_Text)]
    return library


def scene_arrays(path: str) -> Tuple[Dict[str, Any], List[Material], List[np.ndarray], List[str]]:
    """What read_scene returns and notes, as values that go from one process to another."""
    report = ImportReport(path, "DAE")
    images: List[np.ndarray] = []
    scene, materials = read_scene(path, report, images)
    return vars(scene), materials, images, report.notes


def read_scene(
    path: PathLike, report: ImportReport, images: Optional[List[np.ndarray]] = None
) -> Tuple[Scene, List[Material]]:
    """Every instance of every mesh, moved by the transforms above it, and the materials.

    Axes: x right, y up, z to the viewer; meters (of FBX neither is applied). A material has "color"
    [red, green, blue] from 0 to 255 and "texture", the name of a file, or None; "*2" is the third
    of the images in the file itself, whose bytes images gets; and "name".
    """
    library = _library(path)
    scene = library.aiImportFile(os.fsencode(path), _TRIANGULATE | _SORT_BY_KIND)
    if not scene:
        reason = one_line(library.aiGetErrorString().decode("utf-8", "replace"))
        hint = _HOLES if "<h>" in reason else ""
        raise MapFileError("format", path, "assimp cannot read it: %s" % reason, hint)
    try:
        if scene.contents.flags & _INCOMPLETE:
            return joined([], report), []
        parts = _instances(path, scene.contents, report)
        materials = [
            _material(library, scene.contents.materials[i])
            for i in range(scene.contents.material_count)
        ]
        if images is not None:
            images += _images(scene.contents, materials)
        return joined(parts, report), materials
    finally:
        library.aiReleaseImport(scene)


def _images(scene, materials: List[Material]) -> List[np.ndarray]:
    """The bytes of the images in the file; none of one that is not compressed. Materials that name
    one by its file refer to it by its number then.
    """
    found = []
    for index in range(scene.texture_count):
        texture = scene.textures[index].contents
        name = os.fsdecode(texture.name.data) if texture.name.length else None
        for material in materials:
            if name is not None and material["texture"] == name:
                material["texture"] = "*%d" % index
        count = texture.width if not texture.height and texture.data else 0
        found.append(np.frombuffer(ctypes.string_at(texture.data, count), np.uint8))
    return found


def _material(library, material) -> Material:
    color, name = (ctypes.c_float * 4)(1, 1, 1, 1), _Text()
    if library.aiGetMaterialColor(material, b"$clr.diffuse", 0, 0, ctypes.byref(color)):
        color[:3] = (1, 1, 1)
    found = library.aiGetMaterialString(material, b"$tex.file", _DIFFUSE, 0, ctypes.byref(name))
    text = os.fsdecode(name.data) if found == 0 and name.length else None
    known = library.aiGetMaterialString(material, b"?mat.name", 0, 0, ctypes.byref(name)) == 0
    own = os.fsdecode(name.data) if known and name.length else ""
    return {"color": byte_color(list(color)), "texture": text, "name": own}


def _instances(path, scene, report) -> List[ScenePart]:
    parts = [_part(scene.meshes[i].contents, report) for i in range(scene.mesh_count)]
    found, total = [], 0
    todo = [(scene.root.contents, np.eye(4))] if scene.root else []
    while todo:
        node, above = todo.pop()
        transform = above @ np.array(node.transform, dtype=np.float64).reshape(4, 4)
        for i in range(node.mesh_count):
            part = parts[node.meshes[i]]
            total += len(part.positions) + len(part.faces)
            check_scene_size(path, total)
            if len(part.faces):
                found.append(part.moved(transform))
        todo += [(node.children[i].contents, transform) for i in reversed(range(node.child_count))]
    return found


def _part(mesh, report) -> ScenePart:
    """A mesh in its own frame."""
    none = np.zeros((0, 3), np.int64)
    if not mesh.kinds & _TRIANGLES:
        report.note("left out: %d points or lines", mesh.face_count)
        return ScenePart(none.astype(np.float64), none, none[:, 0])
    rows = mesh.vertex_count

    def floats(pointer, width) -> Optional[np.ndarray]:
        return np.ctypeslib.as_array(pointer, (rows, width)).copy() if pointer and rows else None

    positions = floats(mesh.vertices, 3)
    raw = ctypes.string_at(mesh.faces, mesh.face_count * _FACE.itemsize)
    faces = np.frombuffer(raw, _FACE)
    faces = faces[faces["count"] == 3]
    corners = b"".join([ctypes.string_at(place, 12) for place in faces["corners"].tolist()])
    faces = np.frombuffer(corners, np.uint32).reshape(-1, 3).astype(np.int64)
    part = ScenePart(positions, faces, np.full(len(faces), mesh.material))
    part.normals = floats(mesh.normals, 3)
    colors = floats(mesh.colors[0], 4)
    if colors is not None:
        part.colors = np.rint(np.clip(np.nan_to_num(colors[:, :3]), 0, 1) * 255).astype(np.uint8)
    coordinates = floats(mesh.texture_coordinates[0], 3)
    if coordinates is not None:
        part.coordinates = np.ascontiguousarray(coordinates[:, :2])
    for what, given in (("colors", mesh.colors[1]), ("coordinates", mesh.texture_coordinates[1])):
        if given:
            report.note("left out: further %s of a part with %d triangles", what, len(faces))
    return part

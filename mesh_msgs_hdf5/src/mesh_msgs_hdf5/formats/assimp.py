"""The triangles of a scene as assimp reads it, through its C interface.

Only the leading fields of its structures are named here, which have stayed the same since assimp 3;
pyassimp, which names them all, does not fit the library that it is shipped with (Debian 12) and
crashes.
"""
import ctypes
import ctypes.util
import os

import numpy as np

from mesh_msgs_hdf5.errors import MapFileError, PathLike, one_line
from mesh_msgs_hdf5.report import ImportReport

_TRIANGULATE, _SORT_BY_KIND = 0x8, 0x8000
_TRIANGLES = 0x4
_INCOMPLETE = 0x1  # there was no mesh: assimp has put a drawing of the joints in its place
_NAMES = ("libassimp.so.5", "libassimp.so.6", "libassimp.so.4", "libassimp.so")
_FACE = np.dtype(
    {"names": ["count", "corners"], "formats": ["u4", "u8"], "offsets": [0, 8], "itemsize": 16}
)


class _Mesh(ctypes.Structure):
    _fields_ = [
        ("kinds", ctypes.c_uint),
        ("vertex_count", ctypes.c_uint),
        ("face_count", ctypes.c_uint),
        ("vertices", ctypes.POINTER(ctypes.c_float)),
        ("normals", ctypes.c_void_p),
        ("tangents", ctypes.c_void_p),
        ("bitangents", ctypes.c_void_p),
        ("colors", ctypes.c_void_p * 8),
        ("texture_coordinates", ctypes.c_void_p * 8),
        ("texture_sizes", ctypes.c_uint * 8),
        ("faces", ctypes.c_void_p),
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


class _Scene(ctypes.Structure):
    _fields_ = [
        ("flags", ctypes.c_uint),
        ("root", ctypes.POINTER(_Node)),
        ("mesh_count", ctypes.c_uint),
        ("meshes", ctypes.POINTER(ctypes.POINTER(_Mesh))),
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
    return library


def read_corners(path: PathLike, report: ImportReport) -> np.ndarray:
    """(N, 3) float64 positions of the corners of all triangles of a scene, three after three.

    Every instance of a mesh counts, moved by the transforms above it; where they mirror, the
    corners' order is turned so that outside stays outside. Axes: x right, y up, z to the viewer;
    meters.
    """
    library = _library(path)
    scene = library.aiImportFile(os.fsencode(path), _TRIANGULATE | _SORT_BY_KIND)
    if not scene:
        reason = one_line(library.aiGetErrorString().decode("utf-8", "replace"))
        raise MapFileError("format", path, "assimp cannot read it: %s" % reason, "")
    try:
        if scene.contents.flags & _INCOMPLETE:
            return np.zeros((0, 3))
        return _scene_corners(scene.contents, report)
    finally:
        library.aiReleaseImport(scene)


def _scene_corners(scene, report):
    meshes = [_triangles(scene.meshes[i].contents, report) for i in range(scene.mesh_count)]
    found, todo = [np.zeros((0, 3))], [(scene.root.contents, np.eye(4))] if scene.root else []
    while todo:
        node, above = todo.pop()
        transform = above @ np.array(node.transform, dtype=np.float64).reshape(4, 4)
        for i in range(node.mesh_count):
            with np.errstate(invalid="ignore", over="ignore"):  # the caller looks for these
                corners = meshes[node.meshes[i]] @ transform[:3, :3].T + transform[:3, 3]
            if np.linalg.det(transform[:3, :3]) < 0:
                corners = corners.reshape(-1, 3, 3)[:, ::-1].reshape(-1, 3)
            found.append(corners)
        todo += [(node.children[i].contents, transform) for i in reversed(range(node.child_count))]
    return np.concatenate(found)


def _triangles(mesh, report):
    """(3 F, 3) float64 corner positions in the mesh's own frame."""
    if not mesh.kinds & _TRIANGLES:
        report.note("left out: %d points or lines", mesh.face_count)
        return np.zeros((0, 3))
    for name, given in (
        ("normals", mesh.normals),
        ("colors", mesh.colors[0]),
        ("texture coordinates", mesh.texture_coordinates[0]),
    ):
        if given:
            report.note("left out: %s of a part with %d triangles", name, mesh.face_count)
    vertices = np.ctypeslib.as_array(mesh.vertices, (mesh.vertex_count, 3)).astype(np.float64)
    raw = ctypes.string_at(mesh.faces, mesh.face_count * _FACE.itemsize)
    faces = np.frombuffer(raw, _FACE)
    faces = faces[faces["count"] == 3]
    corners = b"".join([ctypes.string_at(place, 12) for place in faces["corners"].tolist()])
    return vertices[np.frombuffer(corners, np.uint32)]

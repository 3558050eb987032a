"""Files of formats that assimp reads: written by it, or byte by byte."""
import ctypes
import io
import struct
import zipfile

import numpy as np

from mesh_msgs_hdf5.formats.exporter import write_mesh
from mesh_msgs_hdf5.model.mesh import Mesh


def exported(folder, form, vertices, faces):
    """The bytes that assimp writes in one of its formats (fbxa, 3ds)."""
    library = ctypes.CDLL("libassimp.so.5")
    library.aiImportFile.restype = ctypes.c_void_p
    library.aiImportFile.argtypes = [ctypes.c_char_p, ctypes.c_uint]
    library.aiExportScene.argtypes = [ctypes.c_void_p, *[ctypes.c_char_p] * 2, ctypes.c_uint]
    write_mesh(folder / "source.ply", Mesh(vertices, faces), overwrite=True)
    scene = library.aiImportFile(str(folder / "source.ply").encode(), 0)
    path = folder / "exported"
    assert library.aiExportScene(scene, form.encode(), str(path).encode(), 0) == 0
    return path.read_bytes()


def archive(document, images=()):
    """A ZAE file: COLLADA with its images in a zip archive."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as made:
        root = '<?xml version="1.0"?><dae_root xmlns="http://www.collada.org">./a.dae</dae_root>'
        made.writestr("manifest.xml", root)
        made.writestr("a.dae", document)
        for name, data in images:
            made.writestr(name, data)
    return stream.getvalue()


class Raw(bytes):
    """A property of bytes that are no text."""


def _property(value):
    if isinstance(value, Raw):
        return b"R" + struct.pack("<I", len(value)) + value
    if isinstance(value, bytes):
        return b"S" + struct.pack("<I", len(value)) + value
    if isinstance(value, np.int64):
        return b"L" + struct.pack("<q", value)
    if isinstance(value, int):
        return b"I" + struct.pack("<i", value)
    if isinstance(value, float):
        return b"D" + struct.pack("<d", value)
    kind, numbers = value  # an array: d or i
    data = struct.pack("<%d%s" % (len(numbers), kind), *numbers)
    return kind.encode() + struct.pack("<3I", len(numbers), 0, len(data)) + data


def _node(start, name, properties=(), nodes=()):
    """A record of binary FBX 7.4 that begins at a place in the file."""
    body = b"".join(map(_property, properties))
    head = 13 + len(name)
    inner = b""
    for node in nodes:
        inner += _node(start + head + len(body) + len(inner), *node)
    if nodes:
        inner += bytes(13)
    end = start + head + len(body) + len(inner)
    counts = struct.pack("<3IB", end, len(properties), len(body), len(name))
    return counts + name.encode() + body + inner


def fbx(vertices, polygons, up=1, unit=1.0, image=None, coordinates=()):
    """Binary FBX 7.4 with one mesh; up: 1 for y, 2 for z; unit: in centimeters; image: the bytes of
    its texture, which is in the file, for coordinates (V, 2).
    """
    corners = [i for polygon in polygons for i in (*polygon[:-1], ~polygon[-1])]
    settings = [
        ("P", (b"UpAxis", b"int", b"Integer", b"", up)),
        ("P", (b"UpAxisSign", b"int", b"Integer", b"", 1)),
        ("P", (b"UnitScaleFactor", b"double", b"Number", b"", float(unit))),
    ]
    geometry = [
        ("Vertices", (("d", [float(x) for row in vertices for x in row]),)),
        ("PolygonVertexIndex", (("i", corners),)),
    ]
    shape, model, root = np.int64(7), np.int64(8), np.int64(0)
    objects = [
        ("Geometry", (shape, b"a\x00\x01Geometry", b"Mesh"), geometry),
        ("Model", (model, b"m\x00\x01Model", b"Mesh"), [("Version", (232,))]),
    ]
    links = [("C", (b"OO", model, root)), ("C", (b"OO", shape, model))]
    if image is not None:
        flat = [float(x) for row in coordinates for x in row]
        layer = [
            ("Name", (b"map",)),
            ("MappingInformationType", (b"ByPolygonVertex",)),
            ("ReferenceInformationType", (b"IndexToDirect",)),
            ("UV", (("d", flat),)),
            ("UVIndex", (("i", [i for polygon in polygons for i in polygon]),)),
        ]
        same = [
            ("MappingInformationType", (b"AllSame",)),
            ("ReferenceInformationType", (b"IndexToDirect",)),
            ("Materials", (("i", [0]),)),
        ]
        geometry += [("LayerElementUV", (0,), layer), ("LayerElementMaterial", (0,), same)]
        elements = [
            ("LayerElement", (), [("Type", (name,)), ("TypedIndex", (0,))])
            for name in (b"LayerElementUV", b"LayerElementMaterial")
        ]
        geometry.append(("Layer", (0,), elements))
        material, texture, video = np.int64(9), np.int64(10), np.int64(11)
        named = [("RelativeFilename", (b"no/such.png",)), ("FileName", (b"no/such.png",))]
        objects += [
            ("Material", (material, b"m\x00\x01Material", b""), [("ShadingModel", (b"phong",))]),
            ("Texture", (texture, b"t\x00\x01Texture", b""), [*named, ("Type", (b"Video",))]),
            ("Video", (video, b"v\x00\x01Video", b"Clip"), [*named, ("Content", (Raw(image),))]),
        ]
        links += [("C", (b"OO", material, model)), ("C", (b"OO", video, texture))]
        links.append(("C", (b"OP", texture, material, b"DiffuseColor")))
    nodes = [
        ("FBXHeaderExtension", (), [("FBXVersion", (7400,))]),
        ("GlobalSettings", (), [("Properties70", (), settings)]),
        ("Objects", (), objects),
        ("Connections", (), links),
    ]
    data = b"Kaydara FBX Binary  \x00\x1a\x00" + struct.pack("<I", 7400)
    for node in nodes:
        data += _node(len(data), *node)
    return data + bytes(13)

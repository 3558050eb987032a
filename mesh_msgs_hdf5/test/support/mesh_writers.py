"""Small writers of mesh files for the tests, written from the formats' descriptions and not from
our readers.
"""
import io
import json
import struct

import numpy as np
from PIL import Image

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 3]], dtype=np.float32)
TWO_FACES = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32)
_NAMES = {"f": "float", "d": "double", "B": "uchar", "b": "char", "h": "short", "H": "ushort"}
_NAMES.update({"i": "int", "I": "uint"})


def ply(columns, polygons, form="binary_little_endian", counts="B", index="i", tail=b"", after=()):
    """Bytes of a PLY file.

    columns: [(name, struct letter, values)] of the vertices; polygons: sequences of vertex indices;
    after: [(name, letter, values)] of the faces behind their list.
    """
    rows = len(columns[0][2])
    head = ["ply", "format %s 1.0" % form, "comment made for a test", "element vertex %d" % rows]
    head += ["property %s %s" % (_NAMES[letter], name) for name, letter, _ in columns]
    head += ["element face %d" % len(polygons)]
    head += ["property list %s %s vertex_indices" % (_NAMES[counts], _NAMES[index])]
    head += ["property %s %s" % (_NAMES[letter], name) for name, letter, _ in after]
    head += ["end_header", ""]
    out = ["\n".join(head).encode()]
    if form == "ascii":
        for i in range(rows):
            out.append(" ".join(repr(plain(c[2][i])) for c in columns).encode() + b"\n")
        for i, polygon in enumerate(polygons):
            words = [len(polygon), *polygon] + [c[2][i] for c in after]
            out.append(" ".join(repr(plain(word)) for word in words).encode() + b"\n")
    else:
        order = "<" if "little" in form else ">"
        for i in range(rows):
            out.append(b"".join(struct.pack(order + c[1], plain(c[2][i])) for c in columns))
        for i, polygon in enumerate(polygons):
            out.append(struct.pack(order + counts, len(polygon)))
            out.append(struct.pack(order + index * len(polygon), *map(int, polygon)))
            out.append(b"".join(struct.pack(order + c[1], plain(c[2][i])) for c in after))
    return b"".join(out) + tail


def plain(value):
    return value.item() if hasattr(value, "item") else value


def xyz(vertices, letter="f"):
    """The columns x, y and z for ply()."""
    vertices = np.asarray(vertices)
    return [(name, letter, vertices[:, i]) for i, name in enumerate("xyz")]


def obj(vertices, polygons, extra=""):
    lines = ["v %r %r %r" % tuple(map(float, v)) for v in vertices]
    lines += ["f " + " ".join(str(int(i) + 1) for i in polygon) for polygon in polygons]
    return ("\n".join(lines) + "\n" + extra).encode()


def stl(vertices, faces):
    """Binary."""
    out = [b"made for a test".ljust(80), struct.pack("<I", len(faces))]
    for face in faces:
        out.append(struct.pack("<12fH", 0, 0, 0, *np.asarray(vertices)[face].ravel(), 0))
    return b"".join(out)


def stl_text(vertices, faces):
    lines = ["solid made for a test"]
    for face in faces:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex %r %r %r" % tuple(map(float, vertices[i])) for i in face]
        lines += ["endloop", "endfacet"]
    return "\n".join(lines + ["endsolid made for a test", ""]).encode()


def dae(vertices, polygons, up="Z_UP", meters="1", matrices=("1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1",)):
    """COLLADA 1.4.1 with one geometry, shown once for each matrix (row by row)."""
    numbers = " ".join(repr(float(x)) for v in vertices for x in v)
    nodes = "".join(
        '<node id="n%d"><matrix>%s</matrix><instance_geometry url="#g"/></node>' % pair
        for pair in enumerate(matrices)
    )
    return """<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>
<created>2024-01-01T00:00:00</created><modified>2024-01-01T00:00:00</modified>
<unit name="u" meter="%s"/><up_axis>%s</up_axis></asset><library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="%d">%s</float_array><technique_common>
<accessor source="#a" count="%d" stride="3"><param name="X" type="float"/><param name="Y"
type="float"/> <param name="Z" type="float"/></accessor></technique_common></source> <vertices
id="v"><input semantic="POSITION" source="#p"/></vertices> <polylist count="%d"><input
semantic="VERTEX" source="#v" offset="0"/><vcount>%s</vcount><p>%s</p></polylist>
</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s">%s</visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>
""" % (
        meters,
        up,
        3 * len(vertices),
        numbers,
        len(vertices),
        len(polygons),
        " ".join(str(len(p)) for p in polygons),
        " ".join(str(int(i)) for p in polygons for i in p),
        nodes,
    )


def image_bytes(pixels, form="PNG"):
    """The bytes of an image file of (height, width, 3 or 4) uint8."""
    stream = io.BytesIO()
    Image.fromarray(np.asarray(pixels, np.uint8)).save(stream, form)
    return stream.getvalue()


def pixels(seed, height=3, width=2, bands=3):
    """A small image of noise."""
    return np.random.default_rng(seed).integers(0, 256, (height, width, bands)).astype(np.uint8)


class Gltf:
    """Puts a glTF document together; json may be changed before data() or files() are asked for."""

    CODES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
    SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}

    def __init__(self):
        self.binary = b""
        self.json = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [],
            "meshes": [],
            "accessors": [],
            "bufferViews": [],
        }

    def view(self, data, **more):
        self.binary += bytes(-len(self.binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        self.json["bufferViews"].append(dict(view, **more))
        self.binary += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, values, kind, **more):
        values = np.asarray(values, "<" + kind)
        values = values.reshape(len(values), -1)
        accessor = {
            "bufferView": self.view(values.tobytes()),
            "componentType": self.CODES[kind],
            "count": len(values),
            "type": self.SHAPES[values.shape[1]],
        }
        self.json["accessors"].append(dict(accessor, **more))
        return len(self.json["accessors"]) - 1

    def mesh(self, vertices, faces, kind="u2", attributes=(), **more):
        """A mesh of one primitive in a node of its own; returns the primitive."""
        primitive = {"attributes": {"POSITION": self.accessor(vertices, "f4")}}
        primitive["attributes"].update(attributes)
        if faces is not None:
            primitive["indices"] = self.accessor(np.asarray(faces).reshape(-1), kind)
        primitive.update(more)
        self.json["meshes"].append({"primitives": [primitive]})
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]))
        self.json["nodes"].append({"mesh": len(self.json["meshes"]) - 1})
        return primitive

    def data(self):
        """The bytes of a GLB file."""
        self.json["buffers"] = [{"byteLength": len(self.binary)}]
        return glb(json.dumps(self.json).encode(), self.binary)

    def files(self, buffer):
        """The bytes of a .gltf file, whose binary data is in the file of that name."""
        self.json["buffers"] = [{"byteLength": len(self.binary), "uri": buffer}]
        return json.dumps(self.json).encode()


def glb(text, binary):
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    size = 12 + 8 + len(text) + 8 + len(binary)
    return (
        struct.pack("<4s2I2I", b"glTF", 2, size, len(text), 0x4E4F534A)
        + text
        + struct.pack("<2I", len(binary), 0x004E4942)
        + binary
    )

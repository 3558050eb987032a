"""glTF that is refused, with one line that says what and where."""
import copy
import json
import struct

import numpy as np
import pytest
from mesh_writers import SQUARE, TWO_FACES, Gltf, dae, glb, image_bytes, pixels

from mesh_msgs_hdf5.formats import importer
from mesh_msgs_hdf5.formats.base import scene
from mesh_msgs_hdf5.formats.exporter import write_mesh
from mesh_msgs_hdf5.formats.gltf import gltf_file
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.isolation import FUNCTIONS
from mesh_msgs_hdf5.model.errors import MapFileError


def plain():
    gltf = Gltf()
    attributes = {"COLOR_0": gltf.accessor(np.ones((4, 3)), "f4")}
    gltf.mesh(SQUARE, TWO_FACES, attributes=attributes, material=0)
    gltf.json["images"] = [{"bufferView": gltf.view(image_bytes(pixels(1)))}]
    gltf.json["textures"] = [{"source": 0}]
    gltf.json["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    return gltf


def refusal(folder, data, name="a.glb"):
    path = folder / name
    path.write_bytes(data)
    with pytest.raises(MapFileError) as refused:
        read_mesh(path)
    assert "\n" not in str(refused.value) and str(path) in str(refused.value)
    return refused.value


def test_a_glb_cut_off_anywhere(tmp_path):
    data = plain().data()
    for length in range(4, len(data), 3):
        assert refusal(tmp_path, data[:length]).code == "truncated", length


def test_a_glb_that_lies_about_its_length(tmp_path):
    """Chunks that end behind the file, or before its parts."""
    data = bytearray(plain().data())
    struct.pack_into("<I", data, 12, 2**31)
    assert refusal(tmp_path, bytes(data)).code == "truncated"
    data = bytearray(plain().data())
    struct.pack_into("<I", data, 8, 30)
    assert refusal(tmp_path, bytes(data)).code == "truncated"
    struct.pack_into("<I", data, 4, 1)
    assert "GLB version 1" in refusal(tmp_path, bytes(data)).message
    assert "no JSON chunk" in refusal(tmp_path, struct.pack("<4s4I", b"glTF", 2, 20, 0, 7)).message


DEEP = 200_000
BAD_JSON = {
    "deep": b"[" * DEEP + b"]" * DEEP,
    "deep object": b'{"asset":' * DEEP + b"1" + b"}" * DEEP,
    "cut off": b'{"asset": {"version": "2.0"}',
    "no utf-8": b'{"asset": {"version": "2.0"}, "x": "\xff\xff"}',
    "list": b"[]",
    "number": b"7",
    "version 1": b'{"asset": {"version": "1.0"}}',
    "no version": b'{"asset": {}}',
    "asset of numbers": b'{"asset": 5}',
    "version of lists": b'{"asset": {"version": ["2.0"]}}',
    "many digits": b'{"asset": {"version": "2.0"}, "scene": ' + b"9" * 100_000 + b"}",
}


@pytest.mark.parametrize("name", BAD_JSON)
def test_json_that_is_none(tmp_path, name):
    for file, data in (("a.gltf", BAD_JSON[name]), ("a.glb", glb(BAD_JSON[name], b""))):
        assert refusal(tmp_path, data, file).code in ("format", "no_faces", "damaged")


def test_json_that_is_too_large(tmp_path, monkeypatch):
    monkeypatch.setattr(gltf_file, "_MAX_JSON", 100)
    assert refusal(tmp_path, plain().data()).code == "size"


def put(*path_and_value):
    """A change of the document: the last but one is the key of the value."""
    *path, value = path_and_value

    def change(document):
        for key in path[:-1]:
            document = document[key]
        document[path[-1]] = value

    return change


PRIMITIVE = ("meshes", 0, "primitives", 0)
CHANGES = {
    "count beyond the view": (put("accessors", 1, "count", 5), "damaged"),
    "huge count": (put("accessors", 1, "count", 10**15), "damaged"),
    "negative count": (put("accessors", 1, "count", -1), "damaged"),
    "count of text": (put("accessors", 1, "count", "4"), "damaged"),
    "count of truth": (put("accessors", 1, "count", True), "damaged"),
    "offset of an accessor": (put("accessors", 1, "byteOffset", 4), "damaged"),
    "negative offset": (put("accessors", 1, "byteOffset", -4), "damaged"),
    "fraction as offset": (put("accessors", 1, "byteOffset", 0.5), "damaged"),
    "stride": (put("bufferViews", 1, "byteStride", 252), "damaged"),
    "stride too small": (put("bufferViews", 1, "byteStride", 4), "damaged"),
    "length of a view": (put("bufferViews", 1, "byteLength", 10**9), "damaged"),
    "offset of a view": (put("bufferViews", 1, "byteOffset", 10**9), "damaged"),
    "length of the buffer": (put("buffers", 0, "byteLength", 10**9), "damaged"),
    "no such buffer": (put("bufferViews", 1, "buffer", 1), "damaged"),
    "no such view": (put("accessors", 1, "bufferView", 99), "damaged"),
    "negative view": (put("accessors", 1, "bufferView", -1), "damaged"),
    "no such accessor": (put(*PRIMITIVE, "attributes", "POSITION", 99), "damaged"),
    "accessor of a list": (put(*PRIMITIVE, "attributes", "POSITION", [1]), "damaged"),
    "kind of component": (put("accessors", 1, "componentType", 5130), "damaged"),
    "component of a list": (put("accessors", 1, "componentType", [5126]), "damaged"),
    "kind of accessor": (put("accessors", 1, "type", "MAT4"), "damaged"),
    "kind of a list": (put("accessors", 1, "type", ["VEC3"]), "damaged"),
    "positions in a plane": (put("accessors", 1, "type", "VEC2"), "damaged"),
    "indices of floats": (put("accessors", 2, "componentType", 5126), "damaged"),
    "indices of vectors": (put("accessors", 2, "type", "VEC2"), "damaged"),
    "indices of colors": (put(*PRIMITIVE, "indices", 0), "damaged"),
    "too few colors": (put("accessors", 0, "count", 3), "damaged"),
    "accessors that are no list": (put("accessors", {"0": {}}), "damaged"),
    "an accessor that is none": (put("accessors", 1, None), "damaged"),
    "a primitive that is none": (put(*PRIMITIVE, 5), "damaged"),
    "primitives that are no list": (put("meshes", 0, "primitives", 5), "damaged"),
    "no attributes": (put(*PRIMITIVE, "attributes", []), "damaged"),
    "no such mesh": (put("nodes", 0, "mesh", 7), "damaged"),
    "no such node": (put("scenes", 0, "nodes", [0, 7]), "damaged"),
    "no such scene": (put("scene", 7), "damaged"),
    "scene of truth": (put("scene", False), "damaged"),
    "a node in its own children": (put("nodes", 0, "children", [0]), "damaged"),
    "children that are no list": (put("nodes", 0, "children", 0), "damaged"),
    "the same node twice": (put("scenes", 0, "nodes", [0, 0]), "damaged"),
    "a short matrix": (put("nodes", 0, "matrix", [1] * 15), "damaged"),
    "a matrix of texts": (put("nodes", 0, "matrix", ["1"] * 16), "damaged"),
    "a translation of lists": (put("nodes", 0, "translation", [[0], [0], [0]]), "damaged"),
    "a translation that is huge": (put("nodes", 0, "translation", [10**400, 0, 0]), "damaged"),
    "a scale of 1e60": (put("nodes", 0, "scale", [1e60, 1, 1]), "not_finite"),
    "a translation of 1e60": (put("nodes", 0, "translation", [0, 1e60, 0]), "not_finite"),
    "sparse of numbers": (put("accessors", 1, "sparse", 5), "damaged"),
    "sparse without values": (put("accessors", 1, "sparse", {"count": 1}), "damaged"),
    "compression": (put("extensionsRequired", ["KHR_draco_mesh_compression"]), "format"),
    "an extension of numbers": (put("extensionsRequired", [5]), "format"),
    "no such material": (put(*PRIMITIVE, "material", 7), "damaged"),
    "a material that is none": (put("materials", 0, 7), "damaged"),
    "points": (put(*PRIMITIVE, "mode", 0), "no_faces"),
    "a mode that is none": (put(*PRIMITIVE, "mode", "4"), "no_faces"),
    "no nodes": (put("scenes", 0, "nodes", []), "no_faces"),
    "a short color": (
        put("materials", 0, "pbrMetallicRoughness", "baseColorFactor", [1, 1, 1]),
        "damaged",
    ),
    "a texture that is none": (
        put("materials", 0, "pbrMetallicRoughness", "baseColorTexture", 5),
        None,
    ),
    "no such image": (put("textures", 0, "source", 9), None),
}


@pytest.mark.parametrize("name", CHANGES)
def test_documents_that_are_wrong(tmp_path, name):
    change, code = CHANGES[name]
    gltf = plain()
    if code is None:  # it is looked at only where there are texture coordinates
        uv = gltf.accessor(np.ones((4, 2)), "f4")
        gltf.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = uv
        code = "damaged"
    gltf.data()
    document = copy.deepcopy(gltf.json)
    change(document)
    data = glb(json.dumps(document).encode(), gltf.binary)
    assert refusal(tmp_path, data).code == code


@pytest.mark.parametrize("index", [4, 65535])
def test_faces_that_refer_to_no_vertex(tmp_path, index):
    gltf = Gltf()
    gltf.mesh(SQUARE, [[0, 1, 2], [0, 2, index]])
    error = refusal(tmp_path, gltf.data())
    assert error.code == "index"
    assert error.message.startswith("face 1 of a primitive refers to vertex %d of 4; 1 " % index)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_positions_that_are_not_finite(tmp_path, value):
    vertices = SQUARE.copy()
    vertices[2, 1] = value
    gltf = Gltf()
    gltf.mesh(vertices, TWO_FACES)
    error = refusal(tmp_path, gltf.data())
    assert error.code == "not_finite" and error.message.startswith("corner 2 is not finite")


def test_other_values_that_are_not_finite_are_left_out(tmp_path):
    gltf = Gltf()
    wrong = np.full((4, 3), np.nan)
    attributes = {
        "NORMAL": gltf.accessor(wrong, "f4"),
        "COLOR_0": gltf.accessor(wrong, "f4"),
        "TEXCOORD_0": gltf.accessor(wrong[:, :2], "f4"),
    }
    gltf.mesh(SQUARE, TWO_FACES, attributes=attributes)
    (tmp_path / "a.glb").write_bytes(gltf.data())
    mesh, report = read_mesh(tmp_path / "a.glb")
    assert mesh.vertex_normals is None and mesh.texture_coordinates is None
    assert "normals left out: 4 of them are not finite, first at vertex 0" in report.notes
    assert any("those of all 4 corners are not finite" in note for note in report.notes)


def test_small_files_that_would_be_large(tmp_path, monkeypatch):
    """Accessors without bytes, and one part that is shown again and again."""
    gltf = plain()
    gltf.json["accessors"][1].pop("bufferView")
    gltf.json["accessors"][1]["count"] = 10**12
    assert refusal(tmp_path, gltf.data()).code == "size"
    monkeypatch.setattr(scene, "MAX_TOTAL", 59)
    gltf = plain()
    gltf.json["nodes"] = [{"mesh": 0}] * 10
    gltf.json["scenes"][0]["nodes"] = list(range(10))
    error = refusal(tmp_path, gltf.data())
    assert error.code == "size" and "more than 59 vertices and faces" in error.message


def test_deep_nodes_are_no_trouble(tmp_path):
    gltf = plain()
    gltf.json["nodes"] = [{"children": [i + 1]} for i in range(20_000)] + [{"mesh": 0}]
    (tmp_path / "a.glb").write_bytes(gltf.data())
    assert len(read_mesh(tmp_path / "a.glb")[0].faces) == 2


def test_changed_bytes_of_a_glb(tmp_path, rich_mesh):
    """Whatever is changed: a good mesh or one MapFileError."""
    path = tmp_path / "a.glb"
    write_mesh(path, rich_mesh)
    data = path.read_bytes()
    head = 20 + struct.unpack_from("<I", data, 12)[0]
    rng = np.random.default_rng(12)
    ends = {"mesh": 0, "error": 0}
    for i in range(300):
        changed = bytearray(data)
        for at in rng.integers(0, head if i % 2 else len(data), rng.integers(1, 4)):
            changed[at] = rng.integers(32, 127) if at < head else rng.integers(0, 256)
        path.write_bytes(changed)
        try:
            mesh, _ = read_mesh(path)
            assert len(mesh.faces) and (mesh.faces < len(mesh.vertices)).all()
            ends["mesh"] += 1
        except MapFileError as error:
            assert "\n" not in str(error)
            ends["error"] += 1
    assert min(ends.values()) > 20


def deep_dae(depth):
    text = dae(SQUARE, TWO_FACES)
    start, end = text.index('<node id="n0">'), text.index("</visual_scene>")
    node = text[start:end]
    nodes = "".join('<node id="d%d">' % i for i in range(depth)) + node + "</node>" * depth
    return text[:start] + nodes + text[end:]


def test_deep_collada(tmp_path):
    """It is read, or refused in one line: a stack that overflows ends the child alone."""
    (tmp_path / "a.dae").write_text(deep_dae(100))
    assert len(read_mesh(tmp_path / "a.dae")[0].faces) == 2
    error = refusal(tmp_path, deep_dae(300_000).encode(), "b.dae")
    assert error.code in ("damaged", "format")


def test_the_child_that_does_not_end(tmp_path, monkeypatch):
    monkeypatch.setitem(FUNCTIONS, "collada", ("victims", "sleep_long"))
    monkeypatch.setattr(importer, "DAE_SECONDS", 0.5)
    error = refusal(tmp_path, dae(SQUARE, TWO_FACES).encode(), "a.dae")
    assert error.code == "size" and "takes more than 0.5" in error.message
    assert "convert" in error.hint


def test_the_child_that_wants_all_memory(tmp_path, monkeypatch):
    monkeypatch.setitem(FUNCTIONS, "collada", ("victims", "swallow_8_gib"))
    error = refusal(tmp_path, dae(SQUARE, TWO_FACES).encode(), "a.dae")
    assert error.code == "size" and "more memory than the 2048 MiB allowed" in error.message

"""GLB files as the specification wants them, and as another program reads them."""
import json
import struct

import numpy as np
import pytest
from mesh_msgs import zoo
from mesh_writers import SQUARE, TWO_FACES, pixels

from mesh_msgs_hdf5.formats.base.images import decoded
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.base.scene import z_up
from mesh_msgs_hdf5.formats.dae import assimp
from mesh_msgs_hdf5.formats.exporter import write_mesh
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.model.mesh import Materials, Mesh

SIZES = {5121: 1, 5123: 2, 5125: 4, 5126: 4}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
KINDS = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}


def parsed(path):
    """(document, binary chunk) of a GLB file, whose frame is checked."""
    data = path.read_bytes()
    magic, version, size, length, kind = struct.unpack_from("<4s4I", data)
    assert (magic, version, size, kind) == (b"glTF", 2, len(data), 0x4E4F534A)
    assert length % 4 == 0 and size % 4 == 0
    document = json.loads(data[20 : 20 + length])
    binary, kind = struct.unpack_from("<2I", data, 20 + length)
    assert kind == 0x004E4942 and 28 + length + binary == size and binary % 4 == 0
    assert document["asset"]["version"] == "2.0"
    (buffer,) = document["buffers"]
    assert "uri" not in buffer and buffer["byteLength"] == binary
    return document, data[28 + length :]


def array(document, binary, index):
    accessor = document["accessors"][index]
    view = document["bufferViews"][accessor["bufferView"]]
    width = WIDTHS[accessor["type"]]
    kind, start = KINDS[accessor["componentType"]], view["byteOffset"]
    stride = view.get("byteStride", width * np.dtype(kind).itemsize)
    rows = np.frombuffer(binary, np.uint8, accessor["count"] * stride, start).reshape(-1, stride)
    return np.ascontiguousarray(rows[:, : width * np.dtype(kind).itemsize]).view(kind)


def check_structure(document, binary):
    """What the specification says of buffer views, accessors, primitives and materials."""
    end = 0
    for view in document["bufferViews"]:
        assert view["buffer"] == 0 and view["byteLength"] > 0 and view["byteOffset"] % 4 == 0
        assert end <= view["byteOffset"] < end + 4  # one after the other, padded
        end = view["byteOffset"] + view["byteLength"]
    assert end <= len(binary) < end + 4
    for i, accessor in enumerate(document["accessors"]):
        view = document["bufferViews"][accessor["bufferView"]]
        row = WIDTHS[accessor["type"]] * SIZES[accessor["componentType"]]
        stride = view.get("byteStride", row)
        assert stride - row in range(4) and "byteStride" in view or stride == row
        assert accessor["count"] * stride == view["byteLength"]
        assert view["target"] in (34962, 34963)
        assert stride % 4 == 0  # of vertex attributes; indices are of four bytes as well
        values = array(document, binary, i)
        assert np.isfinite(values).all()
        if "min" in accessor:
            assert values.min(axis=0).tolist() == accessor["min"]
            assert values.max(axis=0).tolist() == accessor["max"]
    for primitive in document["meshes"][0]["primitives"]:
        attributes = primitive["attributes"]
        position = document["accessors"][attributes["POSITION"]]
        assert position["type"] == "VEC3" and {"min", "max"} <= set(position)
        counts = {document["accessors"][i]["count"] for i in attributes.values()}
        assert counts == {position["count"]}
        assert all(name.startswith("_") or name in KNOWN for name in attributes)
        indices = array(document, binary, primitive["indices"])
        assert len(indices) % 3 == 0 and len(indices) and (indices < position["count"]).all()
        if "material" in primitive:
            assert primitive["material"] < len(document["materials"])
    for image in document.get("images", []):
        view = document["bufferViews"][image["bufferView"]]
        data = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        assert image["mimeType"] == "image/png" and data.startswith(b"\x89PNG")
    for texture in document.get("textures", []):
        assert texture["source"] < len(document["images"])
    for material in document.get("materials", []):
        shading = material["pbrMetallicRoughness"]
        assert len(shading["baseColorFactor"]) == 4
        assert all(0 <= value <= 1 for value in shading["baseColorFactor"])
        if "baseColorTexture" in shading:
            assert shading["baseColorTexture"]["index"] < len(document["textures"])


KNOWN = ("POSITION", "NORMAL", "TEXCOORD_0", "COLOR_0")


def test_the_file_is_as_the_specification_says(tmp_path, rich_mesh):
    path = tmp_path / "a.glb"
    write_mesh(path, rich_mesh)
    document, binary = parsed(path)
    check_structure(document, binary)
    primitives = document["meshes"][0]["primitives"]
    assert [p["material"] for p in primitives] == [0, 1, 2, 3]
    assert sum(document["accessors"][p["indices"]]["count"] for p in primitives) == 180
    assert {"_CLASS_ID", "_FLOW"} <= set(primitives[0]["attributes"])
    assert not {"_ID", "_INTENSITY", "_ECHO", "_SIFT"} & set(primitives[0]["attributes"])
    assert set(primitives[0]["attributes"]) >= {"_HEIGHT_DIFF", "_VERTEX_COLOR", "TEXCOORD_0"}
    images = []
    for image in document["images"]:
        view = document["bufferViews"][image["bufferView"]]
        images.append(decoded(binary[view["byteOffset"] :][: view["byteLength"]]))
    assert [i.tobytes() for i in images] == [
        rich_mesh.textures[key].tobytes() for key in (0, 2, 10)
    ]


def test_colors_are_light_and_v_counts_downwards(tmp_path):
    colors = np.array([[0, 0, 0], [255, 255, 255], [188, 188, 188], [10, 255, 1]], np.uint8)
    uv = np.array([[0, 0], [1, 0], [1, 1], [0.25, 0.75]], np.float32)
    mesh = Mesh(SQUARE, TWO_FACES, vertex_colors=colors, texture_coordinates=uv)
    write_mesh(tmp_path / "a.glb", mesh)
    document, binary = parsed(tmp_path / "a.glb")
    check_structure(document, binary)
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    assert set(attributes) == {"POSITION", "TEXCOORD_0", "COLOR_0"}
    positions = array(document, binary, attributes["POSITION"])
    assert positions.tolist() == [[0, 0, 0], [1, 0, 0], [1, 0, -2], [0, 3, -2]]
    assert array(document, binary, attributes["TEXCOORD_0"]).tolist() == [
        [0, 1],
        [1, 1],
        [1, 0],
        [0.25, 0.25],
    ]
    light = array(document, binary, attributes["COLOR_0"])
    assert light.dtype == np.float32 and light[:2].tolist() == [[0, 0, 0], [1, 1, 1]]
    # 188 of a screen is half of its light (IEC 61966-2-1)
    assert abs(light[2, 0] - 0.5) < 0.005


def test_programs_that_know_bytes_and_floats_alone_read_the_colors(tmp_path):
    """MeshLab and trimesh take 255 times a float, and of whole numbers the lowest byte."""
    colors = np.random.default_rng(3).integers(0, 256, (4, 3)).astype(np.uint8)
    write_mesh(tmp_path / "a.glb", Mesh(SQUARE, TWO_FACES, vertex_colors=colors))
    document, binary = parsed(tmp_path / "a.glb")
    check_structure(document, binary)
    accessor = document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"]
    assert document["accessors"][accessor]["componentType"] in (5121, 5126)
    found = array(document, binary, accessor)
    found = (found * 255 if found.dtype.kind == "f" else found).astype(np.uint8)
    value = colors / 255
    light = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    assert np.abs(found[:, :3] - 255 * light).max() <= 1


def test_every_color_comes_back(tmp_path):
    """All 256 values survive the way through light, in vertices and in materials."""
    rows = np.arange(256, dtype=np.uint8)
    vertices = np.random.default_rng(1).normal(size=(256, 3)).astype(np.float32)
    faces = np.arange(255, dtype=np.uint32).reshape(-1, 3)
    colors = np.stack([rows, rows[::-1], rows // 2], axis=1)
    mesh = Mesh(vertices, faces, vertex_colors=colors)
    write_mesh(tmp_path / "a.glb", mesh)
    assert np.array_equal(read_mesh(tmp_path / "a.glb")[0].vertex_colors, colors)
    mesh.materials = Materials(colors, np.full(256, -1, np.int32), np.zeros(85, np.uint32))
    write_mesh(tmp_path / "b.glb", mesh)
    assert np.array_equal(read_mesh(tmp_path / "b.glb")[0].materials.colors, colors)


def of_corners(positions, faces):
    """Sorted rows of nine numbers, one for each face: a surface, whatever its order."""
    rows = positions[faces].reshape(len(faces), 9)
    return rows[np.lexsort(rows.T)]


@pytest.mark.parametrize("suffix", [".glb", ".gltf", ".dae", ".ply", ".obj", ".stl"])
def test_assimp_reads_what_was_written(tmp_path, suffix):
    world = zoo.outdoor_world(faces=1500, seed=4)
    path = tmp_path / ("a" + suffix)
    write_mesh(path, Mesh(world.vertices, world.faces))
    scene, _ = assimp.read_scene(path, ImportReport("", ""))
    turned = z_up(scene.positions) if suffix in (".glb", ".gltf", ".dae") else scene.positions
    found = of_corners(turned.astype(np.float32), scene.faces)
    wanted = of_corners(world.vertices, world.faces.astype(np.int64))
    # assimp reads decimal numbers to the last bit but one
    assert np.allclose(found, wanted, rtol=3e-7, atol=0)


def test_assimp_reads_materials_and_coordinates(tmp_path):
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    mesh = Mesh(
        SQUARE,
        TWO_FACES,
        texture_coordinates=uv,
        textures={4: pixels(1)},
        materials=Materials(
            np.array([[255, 0, 0], [255, 255, 255]], np.uint8),
            np.array([-1, 4], np.int32),
            np.array([1, 0], np.uint32),
        ),
    )
    for name in ("a.glb", "a.gltf", "a.dae", "a.obj"):
        write_mesh(tmp_path / name, mesh)
        scene, materials = assimp.read_scene(tmp_path / name, ImportReport("", ""))
        assert len(scene.faces) == 2 and scene.known.all()
        places = scene.positions if name == "a.obj" else z_up(scene.positions)
        for face, number in zip(scene.faces, scene.face_materials):
            material = materials[number]
            textured = material["texture"] is not None
            assert tuple(material["color"]) == ((255, 255, 255) if textured else (255, 0, 0))
            row = int(not textured)
            assert np.array_equal(places[face], SQUARE[TWO_FACES[row]])
            assert np.array_equal(scene.coordinates[face], uv[TWO_FACES[row]])

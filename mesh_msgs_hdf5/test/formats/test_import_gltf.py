"""glTF of other programs: every way in which it may store a mesh."""
import base64

import numpy as np
import pytest
from mesh_writers import SQUARE, TWO_FACES, Gltf, image_bytes, pixels

from mesh_msgs_hdf5.formats.importer import read_mesh

IMAGE = pixels(1)
UV = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32)  # v downwards
# x right, y up, z to the viewer: so that the mesh is SQUARE with z up
UP = np.stack([SQUARE[:, 0], SQUARE[:, 2], -SQUARE[:, 1]], axis=1)
WELDED = "welded: %d corners at %d different positions; the order of vertices is that of the faces"


@pytest.fixture
def read(tmp_path):
    """Read a Gltf (as a GLB file) or bytes (as .gltf) beside files of these: (mesh, report)."""

    def read(gltf, files=(), name="a.glb", **options):
        data = gltf.data() if isinstance(gltf, Gltf) else gltf
        for other, content in dict(files, **{name: data}).items():
            (tmp_path / other).write_bytes(content)
        return read_mesh(tmp_path / name, **options)

    return read


def one(faces=TWO_FACES, kind="u2", attributes=(), **more):
    gltf = Gltf()
    gltf.mesh(UP, faces, kind, attributes, **more)
    return gltf


@pytest.mark.parametrize("kind", ["u1", "u2", "u4"])
def test_a_plain_mesh(read, kind):
    mesh, report = read(one(kind=kind))
    assert np.array_equal(mesh.vertices, SQUARE) and np.array_equal(mesh.faces, TWO_FACES)
    assert mesh.vertex_colors is None and mesh.materials is None and mesh.frame_id == "map"
    assert report.format == "GLB"
    assert report.notes == ["glTF's up axis was applied: z up", WELDED % (4, 4)]


def test_the_json_form_with_files_beside_it(read):
    gltf = one()
    mesh, report = read(gltf.files("my%20data.bin"), {"my data.bin": gltf.binary}, "a.gltf")
    assert np.array_equal(mesh.vertices, SQUARE) and report.format == "glTF"
    uri = "data:application/octet-stream;base64," + base64.b64encode(gltf.binary).decode()
    mesh, _ = read(gltf.files(uri), {}, "b.gltf")
    assert np.array_equal(mesh.vertices, SQUARE) and np.array_equal(mesh.faces, TWO_FACES)


@pytest.mark.parametrize(
    "mode,indices,expected",
    [
        (4, [0, 1, 2, 0, 2, 3, 1], [[0, 1, 2], [0, 2, 3]]),
        (5, [0, 1, 3, 2], [[0, 1, 3], [1, 2, 3]]),
        (5, [0, 1, 2, 2, 0, 3], [[0, 1, 2], [2, 0, 3]]),
        (6, [0, 1, 2, 3], [[1, 2, 0], [2, 3, 0]]),
    ],
)
def test_lists_strips_and_fans(read, mode, indices, expected):
    if mode == 5 and len(indices) == 6:  # the degenerate triangles between two strips are none
        expected = [[0, 1, 2], [2, 3, 0]]
    mesh, _ = read(one(indices, mode=mode))
    corners = mesh.vertices[mesh.faces]
    assert len(corners) == len(expected)
    for found, face in zip(corners, SQUARE[np.array(expected)]):
        assert any(np.array_equal(found, np.roll(face, i, axis=0)) for i in range(3))


def test_without_indices(read):
    gltf = Gltf()
    gltf.mesh(UP[TWO_FACES.reshape(-1)], None)
    mesh, report = read(gltf)
    assert np.array_equal(mesh.vertices[mesh.faces], SQUARE[TWO_FACES])
    assert len(mesh.vertices) == 4 and report.merged == 2


def test_interleaved_and_sparse_accessors(read):
    gltf = one()
    rows = np.zeros(4, [("position", "<f4", 3), ("color", "u1", 4), ("uv", "<u2", 2)])
    rows["position"], rows["color"], rows["uv"] = UP, [[255, 0, 0, 255]] * 4, (UV * 65535)
    view = gltf.view(rows.tobytes(), byteStride=rows.itemsize)
    accessors = gltf.json["accessors"]
    first = len(accessors)
    for start, code, kind, normalized in (
        (0, 5126, "VEC3", False),
        (12, 5121, "VEC4", True),
        (16, 5123, "VEC2", True),
    ):
        accessors.append(
            {"bufferView": view, "byteOffset": start, "componentType": code, "type": kind}
        )
        accessors[-1].update(count=4, normalized=normalized)
    attributes = {"POSITION": first, "COLOR_0": first + 1, "TEXCOORD_0": first + 2}
    gltf.json["meshes"][0]["primitives"][0]["attributes"] = attributes
    # the third position is moved by a sparse accessor
    index = gltf.view(np.array([2], "<u2").tobytes())
    values = gltf.view(np.array([[5, 6, 7]], "<f4").tobytes())
    accessors[first]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": index, "componentType": 5123},
        "values": {"bufferView": values},
    }
    mesh, _ = read(gltf)
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [5, -7, 6], [0, 2, 3]]
    assert mesh.vertex_colors.tolist() == [[255, 0, 0]] * 4
    assert np.allclose(mesh.texture_coordinates, [[0, 0], [1, 0], [1, 1], [0, 1]], atol=1e-7)


def test_an_accessor_without_bytes_is_zeros(read):
    gltf = one()
    accessors = gltf.json["accessors"]
    values = gltf.view(UP[1:].astype("<f4").tobytes())
    index = gltf.view(bytes([1, 2, 3]))
    accessors[0].pop("bufferView")
    accessors[0]["sparse"] = {
        "count": 3,
        "indices": {"bufferView": index, "componentType": 5121},
        "values": {"bufferView": values},
    }
    assert np.array_equal(read(gltf)[0].vertices, SQUARE)


def test_nodes_move_turn_scale_and_mirror(read):
    gltf = one()
    turn = [0, np.sqrt(0.5), 0, np.sqrt(0.5)]  # a quarter around y, which is up
    gltf.json["nodes"] = [
        {"children": [1, 2], "translation": [10, 0, 0]},
        {"mesh": 0, "rotation": turn, "scale": [2, 2, 2]},
        {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1]},
        {"mesh": 0},
    ]
    gltf.json["scenes"] = [{"nodes": []}, {"nodes": [0]}]
    gltf.json["scene"] = 1
    mesh, report = read(gltf)
    corners = mesh.vertices[mesh.faces]
    turned = 2 * np.stack([-SQUARE[:, 1], SQUARE[:, 0], SQUARE[:, 2]], axis=1) + [10, 0, 0]
    assert np.allclose(corners[:2], turned[TWO_FACES], atol=1e-6)
    mirrored = SQUARE * [1, -1, 1] + [10, 0, 0]
    assert np.allclose(corners[2:], mirrored[TWO_FACES[:, ::-1]], atol=1e-6)
    assert "left out: 1 other scenes" in report.notes


AXIS = np.array([1.0, -2.0, 3.0]) / np.sqrt(14)
ANGLE = 1.1


def rotation_about(axis, angle):
    """Rodrigues' formula: not symmetric, no entry 0 or 1."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def affine(linear, translation):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = linear, translation
    return matrix


TURN = rotation_about(AXIS, ANGLE)
QUATERNION = [*(AXIS * np.sin(ANGLE / 2)), np.cos(ANGLE / 2)]
# scale, then turn, then move (glTF 2.0, 3.5.3); a shear, which only a matrix can say, and which as
# its transpose would be another one
TRS = affine(TURN @ np.diag([2, 3, 0.5]), [10, -20, 30])
SHEAR = affine(np.array([[1, 0.5, 0], [0, 1, 0.25], [0.125, 0, 2]]), [-4, 5, 7])
AS_TRS = {"translation": [10, -20, 30], "rotation": QUATERNION, "scale": [2, 3, 0.5]}
AS_MATRIX = {"matrix": TRS.T.ravel().tolist()}  # column after column
AS_SHEAR = {"matrix": SHEAR.T.ravel().tolist()}


@pytest.mark.parametrize(
    "nodes,transform",
    [
        ([AS_TRS], TRS),
        ([AS_MATRIX], TRS),
        ([{"rotation": QUATERNION}], affine(TURN, [0, 0, 0])),
        ([AS_TRS, AS_SHEAR], TRS @ SHEAR),
        ([AS_SHEAR, AS_TRS], SHEAR @ TRS),
        ([AS_SHEAR, AS_MATRIX, AS_TRS], SHEAR @ TRS @ TRS),
    ],
    ids=["TRS", "matrix", "rotation", "matrix in TRS", "TRS in matrix", "three"],
)
def test_a_node_is_where_its_matrices_say(read, nodes, transform):
    gltf = Gltf()
    normals = np.array([[0, 0.6, 0.8], [0.48, 0.6, 0.64], [1, 0, 0], [0, 0, 1]], np.float32)
    gltf.mesh(UP, TWO_FACES, attributes={"NORMAL": gltf.accessor(normals, "f4")})
    gltf.json["nodes"] = [dict(node, children=[i + 1]) for i, node in enumerate(nodes)]
    gltf.json["nodes"] += [{"mesh": 0}]
    mesh, _ = read(gltf)
    to_z_up = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    expected = (UP @ transform[:3, :3].T + transform[:3, 3]) @ to_z_up.T
    corners, faces = mesh.vertices[mesh.faces], TWO_FACES
    if np.linalg.det(transform[:3, :3]) < 0:
        faces = faces[:, ::-1]
    assert np.allclose(corners, expected[faces], rtol=1e-6, atol=1e-5)
    normal = (normals @ np.linalg.inv(transform[:3, :3])) @ to_z_up.T
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    assert np.allclose(mesh.vertex_normals[mesh.faces], normal[faces], atol=1e-6)


def test_a_file_without_scenes_shows_the_roots(read):
    gltf = one()
    gltf.json["nodes"] = [{"mesh": 0}, {"children": [0], "translation": [0, 0, -1]}]
    del gltf.json["scene"], gltf.json["scenes"]
    assert np.array_equal(read(gltf)[0].vertices, SQUARE + np.float32([0, 1, 0]))


def test_normals_turn_with_their_node(read):
    gltf = Gltf()
    normals = np.array([[0, 1, 0]] * 3 + [[1, 1, 0]], np.float32)
    gltf.mesh(UP, TWO_FACES, attributes={"NORMAL": gltf.accessor(normals, "f4")})
    mesh, _ = read(gltf)
    assert mesh.vertex_normals.tolist() == [[0, 0, 1]] * 3 + [[1, 0, 1]]
    gltf.json["nodes"][0]["scale"] = [1, 3, 1]  # 45 degrees become flatter
    mesh, _ = read(gltf)
    assert np.allclose(mesh.vertex_normals[3], np.array([3, 0, 1]) / np.sqrt(10))
    gltf.json["nodes"][0]["scale"] = [-1, 1, 1]
    mesh, _ = read(gltf)
    assert np.allclose(mesh.vertex_normals[3], np.array([-1, 0, 1]) / np.sqrt(2))


def test_corners_that_differ(read):
    """Two triangles with vertices of their own: colors and normals differ, a layer agrees."""
    gltf = Gltf()
    corners = TWO_FACES.reshape(-1)
    colors = np.ones((6, 3), np.float32)
    colors[3] = 0
    height = np.array([5, 6, 7, 8], np.float32)[corners]
    attributes = {
        "NORMAL": gltf.accessor(np.repeat([[0, 1, 0], [1, 0, 0]], 3, axis=0), "f4"),
        "COLOR_0": gltf.accessor(colors, "f4"),
        "TEXCOORD_0": gltf.accessor(UV[corners], "f4"),
        "_HEIGHT": gltf.accessor(height, "f4"),
        "_ROW": gltf.accessor(np.arange(6), "f4"),
        "_PAIR": gltf.accessor(np.tile([0, 1], (6, 1)), "u1"),
        "_TURN": gltf.accessor(np.arange(12).reshape(6, 2), "u2"),
        "TEXCOORD_1": gltf.accessor(UV[corners], "f4"),
    }
    gltf.mesh(UP[corners], None, attributes=attributes)
    mesh, report = read(gltf)
    assert mesh.vertex_normals is None and mesh.vertex_colors is None
    assert mesh.texture_coordinates.tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert {k: v.tolist() for k, v in mesh.vertex_costs.items()} == {"HEIGHT": [5, 6, 7, 8]}
    assert {k: v.tolist() for k, v in mesh.vertex_attributes.items()} == {"PAIR": [[0, 1]] * 4}
    assert report.notes == [
        "left out: attribute TEXCOORD_1 of 1 primitives",
        "glTF's up axis was applied: z up",
        WELDED % (6, 4),
        "normals left out: corners that were welded have different ones",
        "colors left out: corners that were welded have different ones",
        "layer ROW left out: corners that were welded have different ones",
        "attribute TURN left out: corners that were welded have different ones",
    ]


def textured(seam=False):
    gltf = Gltf()
    corners = TWO_FACES.reshape(-1)
    uv = UV[corners].copy()
    if seam:
        uv[3] = 0.5, 0.5
    gltf.mesh(
        UP[corners],
        None,
        attributes={"TEXCOORD_0": gltf.accessor(uv, "f4")},
        material=1,
    )
    gltf.json["images"] = [
        {"uri": "gone.png"},
        {"bufferView": gltf.view(image_bytes(IMAGE)), "mimeType": "image/png"},
    ]
    gltf.json["textures"] = [{"source": 1}]
    gltf.json["materials"] = [
        {"name": "unused", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}},
        {
            "pbrMetallicRoughness": {
                "baseColorFactor": [1, 0.21586050011389926, 0, 1],
                "baseColorTexture": {"index": 0},
            }
        },
    ]
    return gltf


def test_embedded_textures(read):
    mesh, report = read(textured())
    assert np.array_equal(mesh.textures[0], IMAGE) and len(mesh.textures) == 1
    assert mesh.materials.colors.tolist() == [[255, 128, 0]]
    assert mesh.materials.texture_indices.tolist() == [0]
    assert mesh.materials.face_materials.tolist() == [0, 0]
    assert not any("left out" in note for note in report.notes)


def test_textures_beside_the_file_and_in_the_json(read):
    for uri, files in (
        ("my%20wall.png", {"my wall.png": image_bytes(IMAGE)}),
        ("data:image/png;base64," + base64.b64encode(image_bytes(IMAGE)).decode(), {}),
    ):
        gltf = textured()
        gltf.json["images"][1] = {"uri": uri}
        mesh, _ = read(gltf, files)
        assert np.array_equal(mesh.textures[0], IMAGE)
    gltf.json["images"][1] = {"uri": "gone.png"}
    mesh, report = read(gltf)
    assert not mesh.textures and mesh.materials.texture_indices.tolist() == [-1]
    assert "left out: image 1 is not there" in report.notes


def test_seams(read):
    mesh, report = read(textured(seam=True), split_seams=False)
    assert mesh.texture_coordinates is None and not mesh.textures and len(mesh.vertices) == 4
    assert mesh.materials.texture_indices.tolist() == [-1]
    assert (
        "texture coordinates left out: 1 vertices have several (seams); --split-seams keeps them"
        in report.notes
    )
    mesh, report = read(textured(seam=True))
    assert mesh.seam_originals.tolist() == [0]
    assert np.array_equal(mesh.vertices, SQUARE[[0, 1, 2, 3, 0]])
    assert mesh.faces.tolist() == [[0, 1, 2], [4, 2, 3]]
    assert mesh.texture_coordinates[4].tolist() == [0.5, 0.5] and len(mesh.textures) == 1
    assert report.split == 1


def test_parts_with_and_without_things(read):
    gltf = Gltf()
    gltf.mesh(
        UP,
        TWO_FACES[:1],
        attributes={
            "COLOR_0": gltf.accessor(np.zeros((4, 3)), "f4"),
            "_SLOPE": gltf.accessor(np.arange(4), "f4"),
            "NORMAL": gltf.accessor([[0, 1, 0]] * 4, "f4"),
        },
    )
    gltf.mesh(UP + np.float32([50, 0, 0]), TWO_FACES[:1], mode=4)
    gltf.mesh(UP, [0, 1], mode=1)
    gltf.json["animations"] = [{}]
    mesh, report = read(gltf)
    assert mesh.vertex_colors.tolist() == [[0, 0, 0]] * 3 + [[255, 255, 255]] * 3
    assert mesh.vertex_costs["SLOPE"][:3].tolist() == [0, 1, 2]
    assert np.isnan(mesh.vertex_costs["SLOPE"][3:]).all() and mesh.vertex_normals is None
    assert "left out: 2 vertices without faces" in report.notes
    assert report.notes[:4] == [
        "left out: points or lines of 1 primitives",
        "left out: 1 animations",
        "normals left out: 1 parts have none",
        "white where there is no color: 1 parts",
    ]


def test_quantized_positions(read):
    gltf = one()
    gltf.json["extensionsRequired"] = ["KHR_mesh_quantization"]
    small = gltf.accessor(np.concatenate([UP, UP[:, :1]], axis=1), "i2")
    gltf.json["accessors"][small]["type"] = "VEC3"
    gltf.json["bufferViews"][-1]["byteStride"] = 8
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = small
    assert np.array_equal(read(gltf)[0].vertices, SQUARE)


def test_large_translations_keep_their_digits(read):
    gltf = one()
    gltf.json["nodes"][0]["translation"] = [431234.5678, 52.25, -5791234.125]
    mesh, report = read(gltf, origin="auto")
    assert mesh.origin == (431235.0, 5791235.0, 54.0)
    exact = SQUARE.astype(float) + [431234.5678, 5791234.125, 52.25]
    assert np.abs(mesh.vertices + np.array(mesh.origin) - exact).max() < 1e-6
    _, report = read(gltf)
    assert any("--origin auto" in note for note in report.notes)


def test_a_glb_of_ours_that_another_program_changed_is_welded(read):
    """A remark that does not fit the file any more is not believed."""
    gltf = Gltf()
    gltf.mesh(UP[TWO_FACES.reshape(-1)], None)
    gltf.json["asset"]["extras"] = {"mesh_tools": ['mesh_tools {"vertices": 4}', "mesh_tools {"]}
    mesh, report = read(gltf)
    assert len(mesh.vertices) == 4 and np.array_equal(mesh.vertices, SQUARE)
    assert report.notes[0] == (
        "left out: 1 remarks (comments that begin with mesh_tools) are damaged"
    )


@pytest.mark.parametrize("kind, largest", [("u1", 255), ("u2", 65535)])
def test_colors_of_whole_numbers(read, kind, largest):
    """Light of all and of nothing, and the light of 188 (half of it)."""
    gltf = Gltf()
    light = np.array([[1, 1, 1, 1], [0, 0, 0, 1], [0.5, 0, 1, 1], [0, 0.5, 0, 1]]) * largest
    colors = gltf.accessor(np.rint(light), kind, normalized=True)
    gltf.mesh(UP, TWO_FACES, attributes={"COLOR_0": colors})
    mesh, _ = read(gltf)
    assert mesh.vertex_colors.tolist() == [[255] * 3, [0] * 3, [188, 0, 255], [0, 188, 0]]

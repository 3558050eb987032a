"""The corpus that the validators of all languages agree on, and the details of findings."""

import json
import pathlib

import numpy as np
import pytest
from samples import encoded, filled, stock_of

import mesh_msgs.msg
from mesh_msgs import arrays, validation
from mesh_msgs.validation import Finding

CORPUS = json.loads((pathlib.Path(__file__).parents[1] / "validation_corpus.json").read_text())
FUNCTIONS = {
    "MeshGeometryStamped": validation.mesh_geometry_stamped,
    "MeshVertexCostsStamped": validation.mesh_vertex_costs_stamped,
    "MeshVertexColorsStamped": validation.mesh_vertex_colors_stamped,
    "MeshFaceCostsStamped": validation.mesh_face_costs_stamped,
    "MeshVertexCostsSparseStamped": validation.mesh_vertex_costs_sparse_stamped,
    "MeshFaceCluster": validation.mesh_face_cluster,
    "MeshMaterialsStamped": validation.mesh_materials_stamped,
    "MeshTexture": validation.mesh_texture,
}
# What a validator may be told about the mesh at hand.
KNOWN = ("vertex_count", "face_count")


def rows(numbers):
    """Rows of a corpus entry; numbers that JSON does not know are strings."""
    return [[float(n) for n in row] for row in numbers]


def floats(numbers):
    return [float(n) for n in numbers]


def corpus_message(entry):
    """The message of a corpus entry: in the array class, or the stock one where there is none."""
    given = entry["message"]
    kind = getattr(arrays, entry["type"], None) or getattr(mesh_msgs.msg, entry["type"])
    message = kind()
    if "uuid" in given:
        message.uuid = given["uuid"]
    if "frame_id" in given:
        message.header.frame_id = given["frame_id"]
    FILL[entry["type"]](message, given)
    return message


def fill_geometry(message, given):
    message.mesh_geometry.vertices = rows(given["vertices"])
    message.mesh_geometry.vertex_normals = rows(given["vertex_normals"])
    message.mesh_geometry.faces = given["faces"]


def fill_vertex_costs(message, given):
    message.type = given["type"]
    message.mesh_vertex_costs.costs = floats(given["costs"])


def fill_face_costs(message, given):
    message.type = given["type"]
    message.mesh_face_costs.costs = floats(given["costs"])


def fill_sparse(message, given):
    message.type = given["type"]
    message.mesh_vertex_costs.vertices = given["vertices"]
    message.mesh_vertex_costs.costs = floats(given["costs"])
    message.mesh_vertex_costs.default_value = float(given["default_value"])


def fill_colors(message, given):
    message.mesh_vertex_colors.vertex_colors = rows(given["vertex_colors"])


def fill_cluster(message, given):
    message.face_indices = given["face_indices"]
    message.label = given["label"]


def fill_materials(message, given):
    materials = message.mesh_materials
    for cluster in given["clusters"]:
        materials.clusters.append(arrays.MeshFaceCluster())
        fill_cluster(materials.clusters[-1], cluster)
    for one in given["materials"]:
        material = mesh_msgs.msg.MeshMaterial(
            texture_index=one["texture_index"], has_texture=one["has_texture"]
        )
        for name, value in zip("rgba", floats(one["color"])):
            setattr(material.color, name, value)
        materials.materials.append(material)
    materials.cluster_materials = given["cluster_materials"]
    materials.vertex_tex_coords = rows(given["vertex_tex_coords"])


def fill_texture(message, given):
    message.texture_index = given["texture_index"]
    for name in ("encoding", "width", "height", "step"):
        setattr(message.image, name, given[name])
    message.image.data = bytes(given["bytes"])


FILL = {
    "MeshGeometryStamped": fill_geometry,
    "MeshVertexCostsStamped": fill_vertex_costs,
    "MeshVertexColorsStamped": fill_colors,
    "MeshFaceCostsStamped": fill_face_costs,
    "MeshVertexCostsSparseStamped": fill_sparse,
    "MeshFaceCluster": fill_cluster,
    "MeshMaterialsStamped": fill_materials,
    "MeshTexture": fill_texture,
}


def corpus_findings(entry, message):
    given = entry["message"]
    known = {name: given[name] for name in KNOWN if name in given}
    if "uuid" in given:
        known["uuid"] = given["expected_uuid"] or None
    return FUNCTIONS[entry["type"]](message, **known)


def names(findings):
    return sorted(finding.rule for finding in findings)


@pytest.mark.parametrize("entry", CORPUS, ids=[entry["name"] for entry in CORPUS])
def test_corpus(entry):
    message = corpus_message(entry)
    stock = stock_of(type(message))().deserialize(encoded(message))
    for form in (message, type(message)().deserialize(encoded(message)), stock):
        assert names(corpus_findings(entry, form)) == sorted(entry["rules"])


def test_corpus_names_are_unique():
    found = [entry["name"] for entry in CORPUS]
    assert len(set(found)) == len(found)


def test_finding_is_a_sentence_with_place_number_and_hint():
    finding = Finding("rule_name", "vertex 3 is wrong (5 in all)", 3, 5, "remove it")
    assert str(finding) == "vertex 3 is wrong (5 in all); remove it"


VERTICES = np.arange(30, dtype=float).reshape(10, 3)
FACES = np.array([[0, 1, 2], [3, 4, 5], [6, 7, 8]], np.uint32)


def test_findings_of_geometry_say_where_and_how_often():
    vertices, normals, faces = VERTICES.copy(), VERTICES.copy(), FACES.copy()
    vertices[4, 1] = 1e60
    vertices[7] = np.nan
    normals[9, 2] = -np.inf
    faces[1] = 10, 11, 0
    faces[2, 2] = 2**32 - 1
    found = validation.check_geometry(vertices, faces, normals)
    assert [f[:4] for f in found] == [
        (
            "vertex_not_finite",
            "vertex 4 is (12, 1e+60, 14), which is not finite as float32 (2 in all)",
            4,
            2,
        ),
        (
            "normal_not_finite",
            "vertex normal 9 is (27, 28, -inf), which is not finite as float32 (1 in all)",
            9,
            1,
        ),
        (
            "face_index_out_of_range",
            "face 1 refers to vertex 10, but the mesh has 10 vertices (2 in all)",
            1,
            2,
        ),
    ]
    assert validation.check_geometry(VERTICES, FACES, VERTICES) == []
    assert validation.check_geometry(VERTICES, FACES) == []


@pytest.mark.parametrize("dtype", [np.int8, np.int64, np.uint64, np.int32])
def test_indices_of_any_integer_type_are_compared_by_value(dtype):
    faces = FACES.astype(dtype)
    assert validation.check_geometry(VERTICES, faces) == []
    faces[2, 0] = -1 if np.iinfo(dtype).min else 2**63
    (finding,) = validation.check_geometry(VERTICES, faces)
    assert (finding.rule, finding.index, finding.count) == ("face_index_out_of_range", 2, 1)
    assert str(faces[2, 0]) in finding.what


@pytest.mark.parametrize(
    "vertices, faces",
    [
        (np.zeros((3, 2)), FACES),
        (VERTICES, np.zeros((3, 4), int)),
        ([[0, 1, 2], [3]], FACES),
        ("text", FACES),
        (None, FACES),
        ([[None, None, None]], FACES),
        (np.zeros((2, 3), complex), FACES),
    ],
)
def test_what_is_no_array_of_numbers_is_a_finding(vertices, faces):
    (finding,) = validation.check_geometry(vertices, faces)
    assert finding.rule == "array_shape" and "should be numbers of shape (N, 3)" in finding.what


def test_indices_that_are_floats_are_a_finding():
    (finding,) = validation.check_geometry(VERTICES, FACES.astype(float))
    assert finding.rule == "face_index_out_of_range" and finding.hint == "give integers"


def test_costs_beyond_float32_are_a_finding_and_infinities_are_told_apart():
    costs = np.array([0, 1e60, np.inf, -1e60, -np.inf, np.nan])
    found = validation.check_costs(costs, 6, "vertices")
    assert [(f.rule, f.index, f.count) for f in found] == [
        ("cost_negative_infinity", 4, 1),
        ("cost_overflow", 1, 2),
    ]


def test_colors_narrow_before_they_are_checked():
    assert validation.check_colors(np.full((2, 4), 1 + 1e-12), 2, "vertices") == []
    (finding,) = validation.check_colors(np.full((2, 4), 1 + 1e-6), 2, "vertices")
    assert (finding.rule, finding.count) == ("color_out_of_range", 2)


def test_foreign_text_is_shortened_and_cannot_break_the_line():
    message = arrays.MeshVertexCostsStamped(uuid="a\nb" + "x" * 10**6)
    message.header.frame_id = "map"
    (finding,) = validation.mesh_vertex_costs_stamped(message, uuid="mesh")
    assert "\n" not in str(finding) and len(str(finding)) < 300


def test_stock_and_array_messages_have_the_same_findings():
    stock = filled(mesh_msgs.msg.MeshGeometryStamped, 5)
    ours = arrays.MeshGeometryStamped.from_message(stock)
    found = validation.mesh_geometry_stamped(stock, uuid="x")
    assert found == validation.mesh_geometry_stamped(ours, uuid="x")
    assert names(found) == ["face_index_out_of_range", "uuid_mismatch"]

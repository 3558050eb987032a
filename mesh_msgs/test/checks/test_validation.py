"""Each rule of the validators has messages that break it and messages that do not."""

import copy
import inspect
import json
import pathlib
import re

import numpy as np
import pytest
from genpy.message import get_message_class

import mesh_msgs.msg
from mesh_msgs import arrays, validation


def test_every_message_type_has_a_validator():
    types = vars(mesh_msgs.msg).items()  # without names of old releases
    generated = [n for n, c in types if hasattr(c, "_md5sum") and c.__name__ == n]
    expected = {re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower() for name in generated}
    checks = {"check_geometry", "check_colors", "check_costs", "Finding"}
    assert {name for name in vars(validation) if name[0] != "_"} == expected | checks
    assert all(inspect.isfunction(getattr(validation, name)) for name in expected)


def stamped(message):
    message.header.frame_id = "map"
    return message


def cluster(indices=(0, 2), label="tree_1"):
    return arrays.MeshFaceClusterStamped(
        cluster=arrays.MeshFaceCluster(list(indices), label), uuid="mesh"
    )


def materials():
    message = mesh_msgs.msg.MeshMaterials()
    message.clusters = [mesh_msgs.msg.MeshFaceCluster([0, 1], ""), cluster([2]).cluster]
    message.materials = [mesh_msgs.msg.MeshMaterial(), mesh_msgs.msg.MeshMaterial()]
    message.cluster_materials = [1, 1]
    message.vertex_tex_coords = [mesh_msgs.msg.MeshVertexTexCoords(2.0, -1.0)] * 4
    return message


def texture(encoding="rgb8", width=3, height=2, step=9, size=18):
    message = mesh_msgs.msg.MeshTexture(uuid="mesh")
    image = message.image
    image.encoding, image.width, image.height, image.step = encoding, width, height, step
    image.data = bytes(size)
    return message


def point(x=0.0, y=0.0, z=0.0):
    return get_message_class("geometry_msgs/Point")(x, y, z)


def color(r=0.0, g=0.0, b=0.0, a=1.0):
    return get_message_class("std_msgs/ColorRGBA")(r, g, b, a)


def label_colors():
    message = mesh_msgs.msg.MeshLabelColors(uuid="mesh", labels=["tree_1", "wall"])
    message.colors = [color(1.0, 0.5), color()]
    return message


def layer_infos():
    info, array = mesh_msgs.msg.LayerInfo, mesh_msgs.msg.LayerInfoArray
    slope = info(name="slope", comparison=info.ABOVE, threshold=0.3, lethal=2, unknown=2)
    return array(uuid="mesh", layers=[slope, info(name="other", threshold=float("nan"))])


def store_result():
    result = mesh_msgs.msg.StoreResult
    return result(topic="store/texture", name="3", result=result.REFUSED, text="it is too large")


def localization_state():
    state = mesh_msgs.msg.LocalizationState
    figures = {"explained": NAN, "residual": 0.02, "position_deviation": INF}
    return state(state=state.UNCERTAIN, reason="a corridor without features", **figures)


def numbers(*values):
    return [get_message_class("std_msgs/Float32")(value) for value in values]


def features():
    feature = mesh_msgs.msg.Feature
    return mesh_msgs.msg.MeshFeatures("mesh", [feature(point(), numbers(1, 2)) for _ in range(3)])


def triangle_mesh():
    mesh = mesh_msgs.msg.TriangleMesh()
    mesh.vertices = [point(x) for x in range(4)]
    mesh.vertex_normals = [point(z=1)] * 4
    mesh.vertex_colors = [color()] * 4
    mesh.triangle_colors = [color(), color()]
    mesh.vertex_texture_coords = [point()] * 4
    faces = ([0, 1, 2], [1, 2, 3])
    mesh.triangles = [mesh_msgs.msg.MeshTriangleIndices(face) for face in faces]
    mesh.face_materials = [mesh_msgs.msg.MeshMaterial(0, color(), True)]
    mesh.textures = [texture().image]
    mesh.clusters = [mesh_msgs.msg.MeshFaceCluster([0, 1], "")]
    return mesh_msgs.msg.TriangleMeshStamped(mesh=mesh)


def sparse(vertices=(0, 3), costs=(1.0, np.inf), default_value=np.nan):
    inner = mesh_msgs.msg.MeshVertexCostsSparse(list(vertices), list(costs), default_value)
    return mesh_msgs.msg.MeshVertexCostsSparseStamped(mesh_vertex_costs=inner, uuid="mesh")


def edit(message, path, value):
    """A copy of the message with the member at `path` ("mesh.vertices.0.x") replaced."""
    message = copy.deepcopy(message)
    *parents, last = path.split(".")
    target = message
    for name in parents:
        target = target[int(name)] if name.isdigit() else getattr(target, name)
    if last.isdigit():
        target[int(last)] = value
    else:
        setattr(target, last, value)
    return message


INF, NAN = float("inf"), float("nan")
COUNTS = {"vertex_count": 4, "face_count": 3, "uuid": "mesh"}
VECTORS = arrays.VectorField(np.zeros((3, 3)), np.ones((3, 3)))
FACE_COSTS = arrays.MeshFaceCostsStamped(
    uuid="mesh", mesh_face_costs=arrays.MeshFaceCosts(costs=[0, NAN, INF])
)

VALID = {
    "mesh_triangle_indices": mesh_msgs.msg.MeshTriangleIndices([0, 3, 1]),
    "mesh_face_costs_stamped": stamped(FACE_COSTS),
    "mesh_vertex_costs_sparse_stamped": stamped(sparse()),
    "mesh_face_cluster_stamped": stamped(cluster()),
    "mesh_label_colors": label_colors(),
    "layer_info_array": stamped(layer_infos()),
    "store_result": store_result(),
    "localization_state": stamped(localization_state()),
    "mesh_material": mesh_msgs.msg.MeshMaterial(),
    "mesh_vertex_tex_coords": mesh_msgs.msg.MeshVertexTexCoords(-1.5, 7.0),
    "mesh_materials_stamped": stamped(
        mesh_msgs.msg.MeshMaterialsStamped(mesh_materials=materials(), uuid="mesh")
    ),
    "mesh_texture": texture(),
    "vector_field_stamped": stamped(arrays.VectorFieldStamped(vector_field=VECTORS)),
    "feature": mesh_msgs.msg.Feature(point(), numbers(1, 2)),
    "mesh_features": features(),
    "triangle_mesh_stamped": stamped(triangle_mesh()),
}

BROKEN = [  # validator, member, value, rule, first index, count
    ("mesh_triangle_indices", "vertex_indices", [0, 1, 4], "face_index_out_of_range", 0, 1),
    ("mesh_triangle_indices", "vertex_indices", [0, 1], "array_shape", None, 1),
    ("mesh_face_costs_stamped", "mesh_face_costs.costs", [0, 1], "cost_count", 2, 1),
    ("mesh_face_costs_stamped", "mesh_face_costs.costs.1", -INF, "cost_negative_infinity", 1, 1),
    ("mesh_face_costs_stamped", "uuid", "other", "uuid_mismatch", None, 1),
    ("mesh_face_costs_stamped", "header.frame_id", "", "frame_id_empty", None, 1),
    ("mesh_vertex_costs_sparse_stamped", "mesh_vertex_costs.costs", [1.0], "cost_count", 1, 1),
    ("mesh_vertex_costs_sparse_stamped", "mesh_vertex_costs.costs.0", 1e60, "cost_overflow", 0, 1),
    (
        "mesh_vertex_costs_sparse_stamped",
        "mesh_vertex_costs.costs",
        [-INF, -INF],
        "cost_negative_infinity",
        0,
        2,
    ),
    (
        "mesh_vertex_costs_sparse_stamped",
        "mesh_vertex_costs.default_value",
        -INF,
        "cost_negative_infinity",
        None,
        1,
    ),
    (
        "mesh_vertex_costs_sparse_stamped",
        "mesh_vertex_costs.default_value",
        1e60,
        "cost_overflow",
        None,
        1,
    ),
    (
        "mesh_vertex_costs_sparse_stamped",
        "mesh_vertex_costs.vertices.1",
        4,
        "vertex_index_out_of_range",
        1,
        1,
    ),
    ("mesh_vertex_costs_sparse_stamped", "uuid", "", "uuid_mismatch", None, 1),
    ("mesh_vertex_costs_sparse_stamped", "header.frame_id", "", "frame_id_empty", None, 1),
    ("store_result", "result", 3, "result_unknown", None, 1),
    ("store_result", "topic", "", "result_topic", None, 1),
    ("store_result", "text", "", "result_text", None, 1),
    ("localization_state", "state", 3, "localization_state_unknown", None, 1),
    ("localization_state", "reason", "", "localization_reason", None, 1),
    ("localization_state", "explained", 1.5, "localization_figure", None, 1),
    ("localization_state", "residual", -0.1, "localization_figure", None, 1),
    ("localization_state", "rotation_deviation", -INF, "localization_figure", None, 1),
    ("localization_state", "header.frame_id", "", "frame_id_empty", None, 1),
    ("layer_info_array", "layers.1.name", "", "layer_unnamed", 1, 1),
    ("layer_info_array", "layers.1.name", "slope", "layer_twice", 1, 1),
    ("layer_info_array", "layers.0.threshold", NAN, "layer_threshold", 0, 1),
    ("layer_info_array", "layers.1.comparison", 2, "layer_threshold", 1, 1),
    ("layer_info_array", "layers.0.comparison", 4, "layer_comparison", 0, 1),
    ("layer_info_array", "layers.0.lethal", 3, "layer_count", 0, 1),
    ("layer_info_array", "layers.1.unknown", 5, "layer_count", 1, 1),
    ("layer_info_array", "uuid", "other", "uuid_mismatch", None, 1),
    ("layer_info_array", "header.frame_id", "", "frame_id_empty", None, 1),
    ("mesh_label_colors", "colors", [color()], "color_count", 1, 1),
    ("mesh_label_colors", "colors", [], "color_count", 0, 2),
    ("mesh_label_colors", "colors.1.g", NAN, "color_not_finite", 1, 1),
    ("mesh_label_colors", "colors.0.r", 1.5, "color_out_of_range", 0, 1),
    ("mesh_label_colors", "labels.1", "", "label_empty", 1, 1),
    ("mesh_label_colors", "labels.1", "a/b", "label_unusable", 1, 1),
    ("mesh_label_colors", "uuid", "other", "uuid_mismatch", None, 1),
    (
        "mesh_face_cluster_stamped",
        "cluster.face_indices",
        [0, 3, 9],
        "cluster_face_out_of_range",
        1,
        2,
    ),
    ("mesh_face_cluster_stamped", "cluster.label", "", "label_empty", None, 1),
    ("mesh_face_cluster_stamped", "cluster.label", "a/b", "label_unusable", 1, 1),
    ("mesh_face_cluster_stamped", "cluster.label", ".", "label_unusable", 0, 1),
    ("mesh_face_cluster_stamped", "cluster.label", "..", "label_unusable", 0, 1),
    ("mesh_face_cluster_stamped", "cluster.label", "a\nb", "label_unusable", 1, 1),
    ("mesh_face_cluster_stamped", "cluster.label", "\x00", "label_unusable", 0, 1),
    ("mesh_face_cluster_stamped", "cluster.label", "\x7f", "label_unusable", 0, 1),
    ("mesh_face_cluster_stamped", "cluster.label", "ä" * 128, "label_unusable", 255, 1),
    ("mesh_face_cluster_stamped", "uuid", "other", "uuid_mismatch", None, 1),
    ("mesh_face_cluster_stamped", "header.frame_id", "", "frame_id_empty", None, 1),
    ("mesh_material", "color.g", 2.0, "color_out_of_range", 0, 1),
    ("mesh_material", "color.a", NAN, "color_not_finite", 0, 1),
    ("mesh_vertex_tex_coords", "u", INF, "texture_coordinate_not_finite", 0, 1),
    (
        "mesh_materials_stamped",
        "mesh_materials.clusters.1.face_indices",
        [5],
        "cluster_face_out_of_range",
        0,
        1,
    ),
    (
        "mesh_materials_stamped",
        "mesh_materials.clusters.0.label",
        "../x",
        "label_unusable",
        2,
        1,
    ),
    (
        "mesh_materials_stamped",
        "mesh_materials.cluster_materials",
        [0],
        "cluster_material_count",
        1,
        1,
    ),
    (
        "mesh_materials_stamped",
        "mesh_materials.cluster_materials.1",
        2,
        "material_index_out_of_range",
        1,
        1,
    ),
    (
        "mesh_materials_stamped",
        "mesh_materials.materials.1.color.r",
        -1,
        "color_out_of_range",
        1,
        1,
    ),
    (
        "mesh_materials_stamped",
        "mesh_materials.vertex_tex_coords",
        [mesh_msgs.msg.MeshVertexTexCoords()] * 3,
        "texture_coordinate_count",
        3,
        1,
    ),
    (
        "mesh_materials_stamped",
        "mesh_materials.vertex_tex_coords.2.v",
        NAN,
        "texture_coordinate_not_finite",
        0,
        4,
    ),
    ("mesh_materials_stamped", "uuid", "other", "uuid_mismatch", None, 1),
    ("mesh_materials_stamped", "header.frame_id", "", "frame_id_empty", None, 1),
    ("mesh_texture", "image.encoding", "jpeg", "image_encoding", None, 1),
    ("mesh_texture", "image.width", 0, "image_empty", None, 1),
    ("mesh_texture", "image.height", 0, "image_empty", None, 1),
    ("mesh_texture", "image.step", 8, "image_size", None, 1),
    ("mesh_texture", "image.width", 4, "image_size", None, 1),
    ("mesh_texture", "image.data", bytes(17), "image_size", None, 1),
    ("mesh_texture", "uuid", "other", "uuid_mismatch", None, 1),
    ("vector_field_stamped", "vector_field.vectors", np.ones((2, 3)), "vector_count", 2, 1),
    (
        "vector_field_stamped",
        "vector_field.positions",
        [[0, 0, 0], [0, 1e60, 0], [0, 0, NAN]],
        "position_not_finite",
        1,
        2,
    ),
    ("vector_field_stamped", "vector_field.vectors.2", INF, "vector_not_finite", 2, 1),
    ("vector_field_stamped", "header.frame_id", "", "frame_id_empty", None, 1),
    ("feature", "location.y", 1e60, "feature_not_finite", 0, 1),
    ("feature", "descriptor.1.data", NAN, "descriptor_not_finite", 1, 1),
    ("mesh_features", "features.2.location.x", NAN, "feature_not_finite", 2, 1),
    ("mesh_features", "features.1.descriptor", numbers(1), "descriptor_length", 1, 1),
    ("mesh_features", "map_uuid", "other", "uuid_mismatch", None, 1),
    ("triangle_mesh_stamped", "mesh.vertices.2.x", 1e60, "vertex_not_finite", 2, 1),
    ("triangle_mesh_stamped", "mesh.vertex_normals", [point()], "normal_count", 1, 3),
    (
        "triangle_mesh_stamped",
        "mesh.triangles.1.vertex_indices",
        [0, 1, 4],
        "face_index_out_of_range",
        1,
        1,
    ),
    ("triangle_mesh_stamped", "mesh.vertex_colors", [color()], "color_count", 1, 3),
    ("triangle_mesh_stamped", "mesh.triangle_colors", [color()] * 5, "color_count", 2, 3),
    (
        "triangle_mesh_stamped",
        "mesh.vertex_texture_coords",
        [point()],
        "texture_coordinate_count",
        1,
        3,
    ),
    (
        "triangle_mesh_stamped",
        "mesh.vertex_texture_coords",
        [point(), point(NAN), point(), point()],
        "texture_coordinate_not_finite",
        1,
        1,
    ),
    ("triangle_mesh_stamped", "mesh.face_materials", [], "cluster_material_count", 0, 1),
    (
        "triangle_mesh_stamped",
        "mesh.clusters.0.face_indices",
        [2],
        "cluster_face_out_of_range",
        0,
        1,
    ),
    ("triangle_mesh_stamped", "mesh.face_materials.0.color.b", 7, "color_out_of_range", 0, 1),
    ("triangle_mesh_stamped", "mesh.textures", [], "texture_index_out_of_range", 0, 1),
    ("triangle_mesh_stamped", "mesh.textures.0.encoding", "x", "image_encoding", 0, 1),
    ("triangle_mesh_stamped", "header.frame_id", "", "frame_id_empty", None, 1),
]


def run(name, message):
    """The validator with as much knowledge of the mesh as it takes."""
    function = getattr(validation, name)
    taken = inspect.signature(function).parameters
    return function(message, **{key: COUNTS[key] for key in COUNTS if key in taken})


@pytest.mark.parametrize("name", sorted(VALID))
def test_valid_message_has_no_findings(name):
    assert run(name, VALID[name]) == []
    assert getattr(validation, name)(VALID[name]) == []


@pytest.mark.parametrize("name, member, value, rule, index, count", BROKEN)
def test_broken_message_has_the_finding(name, member, value, rule, index, count):
    findings = run(name, edit(VALID[name], member, value))
    assert [(f.rule, f.index, f.count) for f in findings] == [(rule, index, count)]
    sentence = str(findings[0])
    assert "\n" not in sentence and "; " in sentence and findings[0].hint in sentence


def test_readme_lists_the_rules_and_each_is_tested():
    folder = pathlib.Path(__file__).parents[1]
    table = (folder.parent / "README.md").read_text().split("| rule |")[1].split("\n\n")[0]
    first_cells = "".join(line.split("|")[1] for line in table.splitlines() if "`" in line)
    corpus = json.loads((folder / "validation_corpus.json").read_text())
    broken = {row[3] for row in BROKEN} | {rule for entry in corpus for rule in entry["rules"]}
    assert set(re.findall("`([a-z_]+)`", first_cells)) == broken

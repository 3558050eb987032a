"""Members of array messages: what may be assigned, what is refused and with which words."""

import copy
import io
import pickle

import genpy
import numpy as np
import pytest
from samples import ARRAY_SERVICES, ARRAY_CLASSES, encoded, filled, stock_of

import mesh_msgs.msg
import mesh_msgs.srv
from mesh_msgs import array_services, arrays
from mesh_msgs.arrays import ArrayError

IDS = [cls.__name__ for cls in ARRAY_CLASSES]

REFUSED = [  # class, member, value, words of the error
    (arrays.MeshGeometry, "vertices", np.zeros((3, 2)), r"expected shape \(N, 3\), got \(3, 2\)"),
    (arrays.MeshGeometry, "vertices", np.zeros(6), r"expected shape \(N, 3\), got \(6,\)"),
    (arrays.MeshGeometry, "vertices", np.zeros((0, 4)), r"expected shape \(N, 3\), got \(0, 4\)"),
    (arrays.MeshGeometry, "vertices", [[0, 1, 2], [3, 4]], r"expected an array of shape \(N, 3\)"),
    (arrays.MeshGeometry, "vertices", "abc", r"expected shape \(N, 3\), got \(\)"),
    (arrays.MeshGeometry, "vertices", [["a", "b", "c"]], "expected numbers, got type <U1"),
    (arrays.MeshGeometry, "vertices", [[None, 1, 2]], "expected numbers, got type object"),
    (arrays.MeshGeometry, "vertices", np.ones((2, 3), bool), "expected numbers, got type bool"),
    (arrays.MeshGeometry, "vertices", np.ones((2, 3), complex), "got type complex128"),
    (arrays.MeshGeometry, "vertices", [mesh_msgs.msg.MeshFaceCluster()], "has no attribute 'x'"),
    (arrays.MeshGeometry, "vertex_normals", np.zeros((1, 3, 1)), r"got \(1, 3, 1\)"),
    (
        arrays.MeshGeometry,
        "faces",
        np.zeros((2, 4), "u4"),
        r"expected shape \(N, 3\), got \(2, 4\)",
    ),
    (arrays.MeshGeometry, "faces", np.zeros((2, 3)), "expected integers, got type float64"),
    (arrays.MeshGeometry, "faces", [[0, 1, 2], [3, -4, -5]], r"\[1, 1\] = -4 .*\(2 such"),
    (arrays.MeshGeometry, "faces", [[2**32, 1, 2]], r"\[0, 0\] = 4294967296 is not between"),
    (arrays.MeshGeometry, "faces", np.full((1, 3), 2**63, "u8"), r"\(3 such values\)"),
    (arrays.MeshFaceCluster, "face_indices", [5, -1], r"\[1\] = -1 is not between 0"),
    (arrays.MeshFaceCluster, "face_indices", [[5]], r"expected shape \(N,\), got \(1, 1\)"),
    (arrays.MeshVertexCosts, "costs", [0, 1e60, -1e60], r"\[1\] = 1e\+60 does not fit .*\(2"),
    (arrays.MeshVertexCosts, "costs", np.zeros((3, 1)), r"expected shape \(N,\), got \(3, 1\)"),
    (arrays.MeshVertexColors, "vertex_colors", np.zeros((3, 3)), r"\(N, 4\), got \(3, 3\)"),
    (arrays.MeshMaterials, "vertex_tex_coords", np.zeros((3, 3)), r"\(N, 2\), got \(3, 3\)"),
    (arrays.VectorField, "vectors", np.zeros((3, 2)), r"\(N, 3\), got \(3, 2\)"),
    (arrays.MeshGeometryStamped, "mesh_geometry", 5, "expected a mesh_msgs/MeshGeometry, got int"),
    (
        arrays.MeshGeometryStamped,
        "mesh_geometry",
        mesh_msgs.msg.MeshVertexCosts(),
        "expected a mesh_msgs/MeshGeometry, got mesh_msgs/MeshVertexCosts",
    ),
]


@pytest.mark.parametrize("cls, member, value, words", REFUSED)
def test_wrong_value_is_refused_when_assigned(cls, member, value, words):
    message = cls()
    with pytest.raises(ValueError, match=r"%s\.%s.*%s" % (cls._type, member, words)) as info:
        setattr(message, member, value)
    assert isinstance(info.value, genpy.SerializationError)
    assert message == cls()
    with pytest.raises(ArrayError, match=words):
        cls(**{member: value})


REFUSED_LATER = [
    (arrays.MeshGeometryStamped, "uuid", 5, "uuid: expected a str, got int"),
    (arrays.MeshGeometryStamped, "uuid", b"x", "uuid: expected a str, got bytes"),
    (arrays.MeshGeometryStamped, "uuid", "\ud800", "uuid: cannot be written as UTF-8"),
    (arrays.MeshGeometryStamped, "header", None, "header: expected a std_msgs/Header"),
    (arrays.MeshGeometryStamped, "mesh_geometry", None, "mesh_geometry: is None"),
    (arrays.MeshGeometry, "vertices", None, "vertices: is None, not an array"),
    (arrays.MeshVertexCostsSparse, "default_value", "a", r"default_value: cannot write \('a'\)"),
    (arrays.MeshVertexCostsSparse, "default_value", 1e60, "default_value: cannot write"),
    (arrays.MeshFaceClusterStamped, "override", None, r"override: cannot write \(None\)"),
    (arrays.MeshMaterials, "clusters", None, "clusters: expected a list, got None"),
    (
        arrays.MeshMaterials,
        "clusters",
        [5],
        r"clusters\[0\]: expected a mesh_msgs/MeshFaceCluster, got int",
    ),
    (arrays.MeshMaterials, "materials", [5], r"materials\[0\]: expected a MeshMaterial"),
    (arrays.MeshMaterials, "cluster_materials", [1, -1], "cluster_materials: cannot write"),
    (arrays.MeshMaterials, "cluster_materials", 3, "cluster_materials: expected a list, got 3"),
]


@pytest.mark.parametrize("cls, member, value, words", REFUSED_LATER)
def test_wrong_value_is_refused_when_written_and_nothing_is_written(cls, member, value, words):
    message = cls()
    setattr(message, member, value)
    buffer = io.BytesIO()
    with pytest.raises(ArrayError, match=words):
        message.serialize(buffer)
    assert buffer.getvalue() == b""
    with pytest.raises(genpy.SerializationError, match=words):
        message._check_types()


def test_header_with_numbers_that_do_not_fit_is_refused():
    message = arrays.VectorFieldStamped()
    message.header.seq = -1
    with pytest.raises(ArrayError, match=r"header \(seq, secs, nsecs\): cannot write \(-1, 0, 0\)"):
        encoded(message)


def test_array_reshaped_by_its_owner_is_refused_when_written():
    vertices = np.zeros((4, 3))
    message = arrays.MeshGeometry(vertices=vertices)
    vertices.shape = (3, 4)
    with pytest.raises(ArrayError, match=r"vertices: expected shape \(N, 3\), got \(3, 4\)"):
        encoded(message)


def test_misspelled_member_is_refused():
    with pytest.raises(AttributeError):
        arrays.MeshGeometry(vertexes=[])
    with pytest.raises(AttributeError):
        arrays.MeshGeometry().vertexes = []


def test_positional_arguments_follow_the_message():
    message = arrays.MeshFaceCluster(np.arange(3), "tree_1")
    assert message.face_indices.tolist() == [0, 1, 2] and message.label == "tree_1"
    with pytest.raises(TypeError):
        arrays.MeshFaceCluster(np.arange(3))


@pytest.mark.parametrize("dtype", ["<f4", "<f8"])
def test_floats_are_kept_and_not_copied(dtype):
    vertices = np.ones((4, 3), dtype)
    assert arrays.MeshGeometry(vertices=vertices).vertices is vertices


def test_uint32_is_kept_and_other_integers_are_converted():
    faces = np.zeros((4, 3), np.uint32)
    assert arrays.MeshGeometry(faces=faces).faces is faces
    limit = np.array([[0, 1, 2**32 - 1]])
    message = arrays.MeshGeometry(faces=limit)
    assert message.faces.dtype == np.uint32 and message.faces.tolist() == limit.tolist()


def test_infinite_and_unknown_costs_of_any_width_are_kept():
    costs = [np.inf, -np.inf, np.nan, 3.4e38, -0.0]
    for given in (costs, np.array(costs), np.array(costs, np.float32)):
        kept = arrays.MeshVertexCosts(costs=given).costs
        assert kept.dtype == np.float32 and kept.tobytes() == np.array(costs, "<f4").tobytes()


@pytest.mark.parametrize("empty", [[], (), np.zeros(0), np.zeros((0, 3)), None])
def test_nothing_becomes_an_empty_array(empty):
    message = arrays.MeshGeometry(vertices=empty, faces=empty)
    assert message.vertices.shape == (0, 3) and message.vertices.dtype == np.float64
    assert message.faces.shape == (0, 3) and message.faces.dtype == np.uint32


def test_members_of_a_new_message_are_arrays():
    message = arrays.MeshGeometryStamped()
    assert type(message.mesh_geometry) is arrays.MeshGeometry
    assert message.mesh_geometry.vertex_normals.shape == (0, 3)
    response = array_services.GetGeometryResponse()
    assert type(response.mesh_geometry_stamped.mesh_geometry) is arrays.MeshGeometry


def test_stock_message_becomes_arrays_when_assigned():
    stock = filled(mesh_msgs.msg.MeshGeometryStamped, 3)
    message = arrays.MeshGeometryStamped(header=stock.header, uuid=stock.uuid)
    message.mesh_geometry = stock.mesh_geometry
    assert type(message.mesh_geometry) is arrays.MeshGeometry and message == stock


def test_from_message_returns_what_is_already_right():
    message = arrays.MeshVertexCosts(costs=[1])
    assert arrays.MeshVertexCosts.from_message(message) is message
    with pytest.raises(ArrayError, match="expected a mesh_msgs/MeshVertexCosts, got str"):
        arrays.MeshVertexCosts.from_message("x")


@pytest.mark.parametrize("cls", ARRAY_CLASSES, ids=IDS)
def test_copies_and_pickles_are_equal_and_of_the_same_class(cls):
    message = cls.from_message(filled(stock_of(cls), 4))
    decoded = cls().deserialize(encoded(message))
    for original in (message, decoded):
        pickles = [pickle.loads(pickle.dumps(original, p)) for p in range(2, 5)]
        for other in [copy.copy(original), copy.deepcopy(original)] + pickles:
            assert type(other) is cls and other == original and not other != original
            assert encoded(other) == encoded(original)
    assert message != cls.from_message(filled(stock_of(cls), 4, seed=1))
    assert message != cls.from_message(filled(stock_of(cls), 5))
    assert message != filled(stock_of(cls), 4, seed=1) and message != 5 and message is not None


def test_deep_copy_does_not_share_arrays():
    message = arrays.MeshVertexCosts(costs=np.zeros(3, np.float32))
    other = copy.deepcopy(message)
    other.costs[0] = 1
    assert message.costs.tolist() == [0, 0, 0] and message != other


def test_nan_equals_nan_and_nothing_else():
    def costs(*values):
        return arrays.MeshVertexCostsSparse(np.arange(2), list(values), float("nan"))

    assert costs(np.nan, 1) == costs(np.nan, 1)
    assert costs(np.nan, 1) != costs(1, np.nan)
    assert costs(np.nan, 1) != costs(0, 1)
    assert costs(1, 1) != arrays.MeshVertexCostsSparse(np.arange(2), [1, 1], 0.0)


def test_message_that_no_array_can_hold_is_not_equal():
    assert arrays.MeshFaceCluster() != mesh_msgs.msg.MeshFaceCluster([-1], "")
    message = arrays.MeshVertexCosts()
    message.costs = None
    assert message != arrays.MeshVertexCosts() and message == copy.copy(message)


def test_text_is_short_however_large_the_message_is():
    geometry = arrays.MeshGeometry(np.zeros((10**6, 3), "f4"), None, np.zeros((10**6, 3), "u4"))
    message = arrays.MeshGeometryStamped(uuid="mesh", mesh_geometry=geometry)
    assert repr(message) == str(message)
    assert str(message) == (
        "mesh_msgs/MeshGeometryStamped(header=(seq 0, stamp 0.000000000, frame_id ''),"
        " uuid='mesh', mesh_geometry=mesh_msgs/MeshGeometry(vertices=float32 (1000000, 3),"
        " vertex_normals=float64 (0, 3), faces=uint32 (1000000, 3)))"
    )
    stock = filled(mesh_msgs.msg.MeshMaterials, 400)
    assert str(arrays.MeshMaterials.from_message(stock)) == (
        "mesh_msgs/MeshMaterials(clusters=400 x mesh_msgs/MeshFaceCluster, materials=400 materials,"
        " cluster_materials=400 x uint32, vertex_tex_coords=float32 (400, 2))"
    )
    message.mesh_geometry = message.header = None
    assert str(message) == (
        "mesh_msgs/MeshGeometryStamped(header=None, uuid='mesh', mesh_geometry=None)"
    )


@pytest.mark.parametrize("name", [service.__name__ for service in ARRAY_SERVICES])
def test_service_is_the_generated_one_with_an_array_response(name):
    ours, stock = getattr(array_services, name), getattr(mesh_msgs.srv, name)
    assert (ours._type, ours._md5sum) == (stock._type, stock._md5sum)
    assert ours._request_class is stock._request_class
    assert ours._response_class is getattr(array_services, name + "Response")
    assert issubclass(ours._response_class, stock._response_class)

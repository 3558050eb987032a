"""MeshMap: what it refuses, what it knows, and its list of layers."""

import math
import re
import subprocess
import sys

import numpy as np
import pytest
from mesh_map import MeshMap, MeshMapError
from mesh_map.geometry.normals import face_normals
from mesh_msgs.identity import geometry_uuid
from meshes import BOTANICAL, data_mesh, real, small, terrain

HEIGHT_DIFF = {"name": "height_diff", "type": "mesh_layers/HeightDiffLayer"}
CORNERS = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


@small
def test_any_mesh_is_a_map(mesh):
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    mesh_map.compute_layers([HEIGHT_DIFF])
    assert not mesh_map.layer_errors
    assert mesh_map.uuid == geometry_uuid(mesh.vertices, mesh.faces)
    assert np.isfinite(mesh_map.vertex_normals).all()
    assert len(mesh_map.costs) == len(mesh.vertices) and not np.isnan(mesh_map.costs).any()
    assert mesh_map.closest_face(mesh.vertices[mesh.faces[0, 0]], 0.0).distance == 0
    assert "%s faces" % format(len(mesh.faces), ",") in mesh_map.report()


@real
def test_costs_of_real_meshes(name):
    mesh = data_mesh(name)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    assert (mesh_map.costs == 0).all()
    mesh_map.compute_layers([dict(HEIGHT_DIFF, params={"factor": 0.5})])
    result = mesh_map.layers["height_diff"].result
    expected = np.where(result.lethal, np.inf, np.float32(0.5) * result.costs)
    assert np.array_equal(mesh_map.costs, expected.astype(np.float32))
    assert 0 < result.lethal.sum() < len(mesh.vertices)


def test_faces_without_area_are_reported():
    vertices = CORNERS + [[2, 0, 0]]
    mesh_map = MeshMap(vertices, [[0, 1, 2], [0, 1, 3]])
    assert mesh_map.faces_without_area.tolist() == [False, True]
    assert mesh_map.report().endswith("4 border edges, 1 inconsistent edge, 1 face without area")
    assert mesh_map.face_normals.tolist() == [[0, 0, 1], [0, 0, 1]]
    assert np.array_equal(mesh_map.face_normals, face_normals(vertices, [[0, 1, 2], [0, 1, 3]])[0])


def test_given_normals_and_identity_are_kept():
    normals = np.tile([0.0, 0.6, 0.8], (3, 1))
    mesh_map = MeshMap(CORNERS, [[0, 1, 2]], normals, "odom", "another's")
    assert np.array_equal(mesh_map.vertex_normals, normals.astype(np.float32))
    assert (mesh_map.frame_id, mesh_map.uuid) == ("odom", "another's")
    empty = MeshMap(CORNERS, [[0, 1, 2]], np.zeros((0, 3)))
    assert empty.vertex_normals.tolist() == [[0, 0, 1]] * 3


def test_arrays_cannot_be_changed():
    mesh_map = MeshMap(np.array(CORNERS, np.float32), [[0, 1, 2]])
    mesh_map.compute_layers([HEIGHT_DIFF])
    result = mesh_map.layers["height_diff"].result
    arrays = [mesh_map.vertices, mesh_map.faces, mesh_map.face_normals, mesh_map.vertex_normals]
    for array in arrays + [mesh_map.costs, result.costs, result.lethal]:
        with pytest.raises(ValueError):
            array[0] = 0


@pytest.mark.parametrize(
    "vertices, faces, normals, message",
    [
        (CORNERS, np.zeros((0, 3)), None, "no faces"),
        (np.zeros((0, 3)), np.zeros((0, 3)), None, "no vertices"),
        (CORNERS, [[0, 1, 2], [0, 1, 3]], None, "face 1"),
        (CORNERS[:2] + [[0, math.nan, 0]], [[0, 1, 2]], None, "vertex 2"),
        (CORNERS[:2] + [[0, 1e60, 0]], [[0, 1, 2]], None, "vertex 2"),
        (CORNERS, [[0, 1, 2]], CORNERS[:2], "normals"),
        (CORNERS, [[0, 1]], None, "faces"),
        ([[0, 0], [1, 1], [2, 2]], [[0, 1, 2]], None, "vertices"),
    ],
)
def test_what_is_no_map_is_refused_in_one_line(vertices, faces, normals, message):
    with pytest.raises(MeshMapError) as error:
        MeshMap(vertices, faces, normals)
    assert message in str(error.value) and "\n" not in str(error.value)


def test_an_unknown_layer_does_not_harm_the_others(caplog):
    mesh = terrain(20)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    inflation = {"name": "inflation", "type": "mesh_layers/NoSuchLayer"}
    mesh_map.compute_layers([inflation, HEIGHT_DIFF])
    assert list(mesh_map.layers) == ["height_diff"] and list(mesh_map.layer_errors) == ["inflation"]
    (said,) = [r.getMessage() for r in caplog.records if r.levelname == "ERROR"]
    assert said.startswith("layer inflation is left out: " + mesh_map.layer_errors["inflation"])
    assert "(known: " in said and "mesh_layers/HeightDiffLayer" in said
    assert "known: " in caplog.text and "mesh_layers/HeightDiffLayer" in caplog.text


@pytest.mark.parametrize(
    "entry, message",
    [
        (
            "height_diff",
            "an entry of the list of layers is 'height_diff' ({name: ..., type: ...} is needed)",
        ),
        (
            {"name": "a"},
            "an entry of the list of layers is {'name': 'a'} ({name: ..., type: ...} is needed)",
        ),
        ({"name": "a/b", "type": "t"}, "'a/b' is no name for a layer"),
        ({"name": 3, "type": "t"}, "3 is no name for a layer"),
        ({"name": "a", "type": 3}, "the type of layer a is 3"),
        (dict(HEIGHT_DIFF, name="a", params=[1]), "the parameters of layer a are [1]"),
        (dict(HEIGHT_DIFF, name="a", params={"radius": math.nan}), "radius is nan"),
        (HEIGHT_DIFF, "there are two layers of the name height_diff"),
    ],
)
def test_bad_entries_are_left_out(entry, message, caplog):
    mesh_map = MeshMap(CORNERS, [[0, 1, 2]])
    mesh_map.compute_layers([HEIGHT_DIFF, entry])
    assert list(mesh_map.layers) == ["height_diff"]
    ((name, error),) = mesh_map.layer_errors.items()
    assert error.startswith(message) and name in ("a", "layer 1")
    assert caplog.messages == ["layer %s is left out: %s" % (name.split()[-1], error)]


def test_a_list_of_layers_that_is_none(caplog):
    mesh_map = MeshMap(CORNERS, [[0, 1, 2]])
    mesh_map.compute_layers({"name": "height_diff"})
    assert mesh_map.layer_errors == {"layers": "the list of layers is a dict, not a list"}
    assert not mesh_map.layers and "not a list" in caplog.text


def test_layers_are_replaced():
    mesh = terrain(20)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    mesh_map.compute_layers([HEIGHT_DIFF, "bad"])
    first = mesh_map.costs
    strict = dict(HEIGHT_DIFF, name="strict", params={"threshold": 0.05})
    mesh_map.compute_layers([strict])
    assert list(mesh_map.layers) == ["strict"] and not mesh_map.layer_errors
    assert np.isinf(mesh_map.costs).sum() > np.isinf(first).sum()


def test_progress():
    mesh_map = MeshMap(CORNERS, [[0, 1, 2]])
    calls = []
    second = dict(HEIGHT_DIFF, name="second")
    mesh_map.compute_layers([HEIGHT_DIFF, second], progress=lambda *call: calls.append(call))
    assert calls == [(0.0, "layer height_diff"), (0.5, "layer second"), (1.0, "done")]


def test_progress_can_end_the_computation():
    mesh_map = MeshMap(CORNERS, [[0, 1, 2]])

    for last in (0.5, 1.0):

        def stop(share, _next):
            if share == last:
                raise MeshMapError("enough")

        with pytest.raises(MeshMapError, match="enough"):
            mesh_map.compute_layers([HEIGHT_DIFF, dict(HEIGHT_DIFF, name="b"), 3], progress=stop)
        assert not mesh_map.layers and not mesh_map.layer_errors


def test_stored_costs_are_taken(caplog):
    mesh_map = MeshMap(CORNERS, [[0, 1, 2]])
    costs = np.array([0.1, 0.5, np.nan], np.float32)
    asked = []

    def stored(name, fingerprint):
        asked.append((name, fingerprint))
        return costs if name == "height_diff" else None

    mesh_map.compute_layers([HEIGHT_DIFF, dict(HEIGHT_DIFF, name="other")], stored=stored)
    layer = mesh_map.layers["height_diff"]
    assert np.array_equal(layer.result.costs, costs, equal_nan=True)
    assert layer.result.lethal.tolist() == [False, True, False]
    assert mesh_map.layers["other"].result.costs.tolist() == [0, 0, 0]
    parameters = {"radius": 0.3, "include_vertex": True, "large_faces": True}
    fingerprint = {"type": HEIGHT_DIFF["type"], "geometry": mesh_map.uuid, **parameters}
    assert asked == [("height_diff", fingerprint), ("other", fingerprint)]
    assert layer.identity == fingerprint
    mesh_map.compute_layers([HEIGHT_DIFF], stored=lambda *_: costs[:2])
    assert not mesh_map.layer_errors and not mesh_map.costs.any()
    text = "layer height_diff is computed anew: the costs are of shape (2,)"
    assert caplog.messages[-1].startswith(text)


def test_queries_are_those_of_the_map():
    mesh_map = MeshMap(CORNERS, [[0, 1, 2]])
    assert mesh_map.queries is mesh_map.queries
    assert mesh_map.contents is None and MeshMap.of(mesh_map.geometry, "file").contents == "file"


def test_start_and_goal_of_the_botanical_garden():
    mesh = data_mesh(BOTANICAL)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    vertex, distance = mesh_map.nearest_vertex(mesh.vertices[77] + np.float32(1e-4), 0.1)
    assert vertex == 77 and distance == pytest.approx(1.7e-4, rel=0.05)


def test_libraries_do_not_import_ros():
    script = (
        "import importlib, pathlib, sys, mesh_map.base\n"
        "top = pathlib.Path(mesh_map.base.__file__).parents[1]\n"
        "found = [p.relative_to(top.parent).with_suffix('') for p in top.rglob('*.py')]\n"
        "at_the_rim = [path.parts[1] == 'ros' or path.name.endswith('_ros') for path in found]\n"
        "names = ['.'.join(path.parts) for path, is_ros in zip(found, at_the_rim) if not is_ros]\n"
        "for name in names:\n"
        "    importlib.import_module(name.replace('.__init__', ''))\n"
        "assert len(names) > 60 and 'mesh_map.layers.threshold_layer' in names, names\n"
        "assert 'rospy' not in sys.modules and 'h5py' in sys.modules\n"
    )
    subprocess.run([sys.executable, "-W", "error::RuntimeWarning", "-c", script], check=True)


UTM = np.array([565000.25, 5934000.125, 12.0])


def in_utm(dtype=np.float64):
    """A mesh of some meters in the coordinates of a UTM zone, and near its origin."""
    mesh = terrain(12)
    near = np.rint(mesh.vertices.astype(np.float64) * 1024) / 1024 + 0.0  # exact in both
    return (near + UTM).astype(dtype), near.astype(np.float32), mesh.faces


def test_coordinates_that_rounding_would_move_are_refused_with_an_origin_that_helps():
    far, _, faces = in_utm()
    with pytest.raises(MeshMapError, match=r"change its coordinates by up to 0\.\d+ m") as error:
        MeshMap(far, faces)
    helps = [float(text) for text in re.search(r"\[(.*)\]", str(error.value)).group(1).split(",")]
    assert np.abs(MeshMap(far, faces, origin=helps).vertices).max() < 20
    with pytest.raises(MeshMapError, match=r"origin near to it, such as \[5650\d\d.0, 59340\d\d.0"):
        MeshMap(far, faces, origin=[1.0, 2.0, 3.0])
    large = np.array(CORNERS) * 5000.7  # a millionth of it, and what is float32 already, may go
    assert MeshMap(large, [[0, 1, 2]]).origin.tolist() == [0, 0, 0]
    MeshMap(far.astype(np.float32), faces)


def test_the_origin_is_subtracted_before_rounding():
    far, near, faces = in_utm()
    mesh_map = MeshMap(far, faces, origin=UTM)
    assert mesh_map.vertices.dtype == np.float32 and np.array_equal(mesh_map.vertices, near)
    assert mesh_map.origin.dtype == np.float64 and np.array_equal(mesh_map.origin, UTM)
    assert np.array_equal(mesh_map.vertices + mesh_map.origin, far)
    assert mesh_map.uuid == geometry_uuid(near, faces)


@pytest.mark.parametrize("origin", [3.0, (1, 2), (1, 2, np.nan), "auto", None, [[1, 2, 3]]])
def test_no_origin(origin):
    with pytest.raises(MeshMapError, match="origin is .* x, y, z in meters"):
        MeshMap(CORNERS, [[0, 1, 2]], origin=origin)

"""Named attributes, and costs of faces."""

import numpy as np
import pytest
from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.topology import Topology
from mesh_map.map.attributes import Attributes, MeshAttributes, face_costs, vertex_costs
from meshes import small


@small
@pytest.mark.parametrize("how", ["max", "mean"])
def test_costs_of_faces_and_vertices_equal_loops(mesh, how):
    random = np.random.default_rng(0)
    costs = random.uniform(0, 5, len(mesh.vertices)).astype(np.float32)
    costs[random.random(len(costs)) < 0.1] = np.inf
    costs[random.random(len(costs)) < 0.1] = np.nan
    topology = Topology(faces=mesh.faces, vertex_count=len(mesh.vertices))
    take = max if how == "max" else np.mean

    def joined(values):
        if not len(values):
            return np.nan
        if np.inf in values:
            return np.inf
        return np.nan if np.isnan(values).any() else take(np.asarray(values, np.float64))

    of_faces = face_costs(costs, mesh.faces, how)
    assert of_faces.dtype == np.float32
    np.testing.assert_allclose(of_faces, [joined(costs[face]) for face in mesh.faces], rtol=1e-6)
    back = vertex_costs(of_faces, topology, how)
    expected = [joined(of_faces[topology.faces_of(v)]) for v in range(len(mesh.vertices))]
    assert back.dtype == np.float32
    np.testing.assert_allclose(back, expected, rtol=1e-6)


@pytest.mark.parametrize("how", ["max", "mean"])
def test_what_is_infinite_is_lethal_whatever_its_sign(how):
    faces = np.array([[0, 1, 2], [1, 2, 3]])
    topology = Topology(faces=faces, vertex_count=4)
    assert vertex_costs([-np.inf, 1.0], topology, how).tolist() == [np.inf, np.inf, np.inf, 1.0]
    assert face_costs([-np.inf, 1.0, 1.0, 1.0], faces, how).tolist() == [np.inf, 1.0]


def test_attributes_are_checked_and_cannot_be_written_through():
    attributes = Attributes(3, "faces")
    given = np.array([1.0, 2.0, 3.0])
    attributes["speed limit"] = given
    given[0] = 9
    assert attributes["speed limit"].tolist() == [1, 2, 3] and list(attributes) == ["speed limit"]
    with pytest.raises(ValueError):
        attributes["speed limit"][0] = 5
    attributes["colors"] = np.zeros((3, 4), np.uint8)
    assert attributes["colors"].dtype == np.uint8 and len(attributes) == 2
    for name, values, match in (
        ("short", [1, 2], r"shape \(2,\).*each of the 3 faces"),
        ("cube", np.zeros((3, 1, 1)), "shape"),
        ("text", ["a", "b", "c"], "not of numbers"),
        ("", [1, 2, 3], "no name"),
        ("a/b", [1, 2, 3], "no name"),
        ("a\nb", [1, 2, 3], "no name"),
        (5, [1, 2, 3], "no name"),
    ):
        with pytest.raises(MeshMapError, match=match):
            attributes[name] = values
    assert "short" not in attributes and attributes.get("short") is None
    del attributes["colors"]
    with pytest.raises(KeyError):
        attributes["colors"]


class Contents:
    """What is in a map file."""

    def __init__(self):
        self.read = []

    def layer_names(self):
        return ["roughness"]

    def vertex_costs(self, name):
        self.read.append(name)
        return np.arange(4.0)

    def face_attribute_names(self):
        return ["slope", "broken"]

    def face_attribute(self, name):
        self.read.append(name)
        return np.arange(2.0 if name == "slope" else 7.0)


def test_those_of_the_map_file_are_read_once_when_asked_for():
    contents = Contents()
    attributes = MeshAttributes(4, 2, contents)
    assert list(attributes.faces) == ["slope", "broken"] and not contents.read
    assert attributes.faces["slope"].tolist() == [0, 1] == attributes.faces["slope"].tolist()
    assert attributes.vertices["roughness"].tolist() == [0, 1, 2, 3]
    assert contents.read == ["slope", "roughness"]
    with pytest.raises(MeshMapError, match=r"broken has the shape \(7,\)"):
        attributes.faces["broken"]
    assert len(MeshAttributes(4, 2).faces) == 0


def test_bad_arguments_are_refused():
    topology = Topology(faces=[[0, 1, 2]], vertex_count=3)
    with pytest.raises(ValueError, match="max or mean"):
        face_costs([1, 2, 3], [[0, 1, 2]], "median")
    for costs in ([1, 2], [[1, 2, 3]] * 3):
        with pytest.raises(ValueError, match="one is needed for each vertex"):
            face_costs(costs, [[0, 1, 2]])
    with pytest.raises(MeshMapError, match="attribute uneven"):
        MeshAttributes(2, 1).vertices["uneven"] = [[1], [2, 3]]
    with pytest.raises(ValueError, match=r"shape \(1,\), one for each face"):
        vertex_costs([1, 2], topology)

"""Numbers of vertices that are no costs: of any type, in any number of columns."""
from pathlib import Path

import h5py
import numpy as np
import pytest
from mesh_msgs import zoo
from mesh_msgs.derived_mesh import DerivedMesh

from mesh_msgs_hdf5.checks.check import identical
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.isolation import IsolatedMapFile
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.carried_mesh import carried_mesh
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.validation.validate import validate

TYPES = ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f2", "f4", "f8")
GRID = zoo.grid(3)
ROWS = len(GRID.vertices)


def numbers(kind, columns):
    """(V,) or (V, C) with the largest and smallest of their type, NaN and inf."""
    rng = np.random.default_rng(columns)
    values = rng.integers(0, 100, (ROWS, columns)).astype(kind)
    limits = np.finfo(kind) if kind[0] == "f" else np.iinfo(kind)
    values[0], values[1] = limits.max, limits.min
    if kind[0] == "f":
        values[2], values[3], values[4] = np.nan, -np.inf, np.inf
    return values[:, 0] if columns == 1 else values


def same(one, other):
    return identical(one, other)


@pytest.fixture
def file(tmp_path):
    mesh = Mesh(GRID.vertices, GRID.faces, vertex_costs={"slope": np.ones(ROWS, np.float32)})
    return MapFile.write(tmp_path / "a.h5", mesh)


@pytest.mark.parametrize("columns", [1, 2, 64])
def test_every_type_is_kept_to_the_bit_and_is_no_layer(file, columns):
    values = {"x_" + kind: numbers(kind, columns) for kind in TYPES}
    file.update(Edit(vertex_attributes=values, vertex_parameters={"x_u1": {"net": "a"}}))
    assert file.layer_names() == ["slope"] and file.vertex_attribute_names() == sorted(values)
    for reader in (file, MapFile(file.path), IsolatedMapFile(file.path, strict=True)):
        assert all(same(reader.vertex_attribute(name), values[name]) for name in values)
        assert reader.vertex_parameters("x_u1") == {"net": "a"} and reader.notes == []
    assert all(same(file.read().vertex_attributes[name], values[name]) for name in values)
    with h5py.File(file.path, "r") as raw:  # as LVR2 has its channels
        channels = raw["mesh/channels"]
        assert all(channels[name].shape == (ROWS, columns) for name in values)
        assert all(channels[name].dtype == "<" + name[2:] for name in values)
    assert "other" not in {finding.where for finding in validate(file.path)}
    file.update(Edit(vertex_attributes={"x_u1": None}))
    assert "x_u1" not in file.vertex_attribute_names() and len(file.read().vertex_attributes) == 10


def test_channels_of_lvr2_are_attributes(file):
    with h5py.File(file.path, "r+") as raw:
        channels = raw["mesh/channels"]
        channels["class_id"] = numbers("i4", 1).reshape(-1, 1)
        channels["curvature"] = numbers("f8", 3)
        channels["flat"] = numbers("u2", 1)
        channels["roughness"] = np.ones((ROWS, 1))  # of float64: a layer, as before
        channels["face_normals"] = np.ones((ROWS, 3), np.float32)
        channels["of_edges"] = np.ones((ROWS + 7, 2), np.float32)
        channels["sparse"], channels["sparse_idx"] = numbers("u1", 1), numbers("u4", 1)
    file = MapFile(file.path)
    assert file.layer_names() == ["roughness", "slope"]
    assert file.vertex_attribute_names() == ["class_id", "curvature", "flat"]
    assert same(file.vertex_attribute("class_id"), numbers("i4", 1))
    assert same(file.vertex_attribute("curvature"), numbers("f8", 3))
    file.update(Edit(vertex_attributes={"curvature": numbers("f4", 2)}))
    assert same(file.vertex_attribute("curvature"), numbers("f4", 2))
    assert same(file.vertex_attribute("flat"), numbers("u2", 1))


@pytest.mark.parametrize(
    "edit",
    [
        Edit(vertex_attributes={"slope": np.ones(ROWS)}),
        Edit(vertex_costs={"ids": np.ones(ROWS, np.float32)}),
        Edit(vertex_costs={"slope": None}, vertex_attributes={"slope": np.ones(ROWS)}),
    ],
    ids=["as a layer", "as an attribute", "in one edit"],
)
def test_a_layer_and_an_attribute_have_different_names(file, edit):
    file.update(Edit(vertex_attributes={"ids": numbers("u4", 1)}))
    with pytest.raises(MapFileError, match="a layer and of a vertex attribute") as refused:
        file.update(edit)
    assert refused.value.code == "layer" and refused.value.hint.startswith("delete the other one")
    assert same(file.vertex_attribute("ids"), numbers("u4", 1))
    file.update(Edit(vertex_attributes={"ids": None}))
    file.update(Edit(vertex_costs={"ids": np.ones(ROWS, np.float32)}))
    assert file.layer_names() == ["ids", "slope"] and file.vertex_attribute_names() == []


@pytest.mark.parametrize(
    "values,code",
    [
        (np.ones(ROWS - 1), "shape"),
        (np.ones((ROWS, 2, 2)), "shape"),
        (np.ones((ROWS, 0)), "shape"),
        (np.ones(ROWS, complex), "dtype"),
        (np.ones(ROWS, bool), "dtype"),
        (np.ones(ROWS, np.longdouble), "dtype"),
    ],
)
def test_bad_values_are_refused(file, values, code):
    before = Path(file.path).read_bytes()
    with pytest.raises(MapFileError, match="vertex attribute x") as refused:
        file.update(Edit(vertex_attributes={"x": values}))
    assert refused.value.code == code and Path(file.path).read_bytes() == before


def test_names_of_things_are_not_mixed_on_a_derived_mesh():
    mesh = Mesh(GRID.vertices, GRID.faces)
    mesh.vertex_attributes = {
        "class_id": np.arange(ROWS, dtype=np.uint64) + np.uint64(2**63),
        "flow": np.arange(ROWS * 2, dtype=np.float64).reshape(-1, 2),
    }
    parents = np.uint32([[0, 1, 2], [3, 4, 5], [6, 7, 8]])
    weights = np.float32([[0.25, 0.5, 0.25], [1, 0, 0], [0, 0.25, 0.75]])
    derived = DerivedMesh(
        vertices=np.eye(3, dtype=np.float32),
        faces=np.uint32([[0, 1, 2]]),
        uuid="x",
        parent_uuid="y",
        parent_vertex_count=ROWS,
        parent_face_count=len(GRID.faces),
        face_parents=np.uint32([0]),
        vertex_parents=parents,
        vertex_weights=weights,
    )
    carried = carried_mesh(mesh, derived).vertex_attributes
    expected = mesh.vertex_attributes["class_id"][[1, 3, 8]]
    assert same(carried["class_id"], expected)
    assert carried["flow"].tolist() == [[2, 3], [6, 7], [15.5, 16.5]]


def test_whole_numbers_that_float32_cannot_hold_are_no_layer(tmp_path):
    lines = ["ply", "format ascii 1.0", "element vertex 3"]
    lines += ["property float " + axis for axis in "xyz"]
    lines += ["property uint point_id", "property uchar class"]
    lines += ["element face 1", "property list uchar int vertex_indices", "end_header"]
    lines += ["0 0 0 4294967295 1", "1 0 0 16777217 2", "0 1 0 3 3", "3 0 1 2"]
    (tmp_path / "a.ply").write_text("\n".join(lines) + "\n")
    mesh, report = read_mesh(tmp_path / "a.ply")
    assert same(mesh.vertex_attributes["point_id"], np.uint32([4294967295, 16777217, 3]))
    assert list(mesh.vertex_costs) == ["class"] and report.vertex_attributes == 1

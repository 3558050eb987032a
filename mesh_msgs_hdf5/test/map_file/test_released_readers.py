"""What the released programs find in our files, by readers that know their interfaces alone."""
import dataclasses

import h5py
import numpy as np
import pytest
from map_samples import assert_same_mesh, write_hdf5_map_io, write_lvr2_l1, write_s0, write_s2
from released_readers import (
    ReaderEnds,
    hdf5_map_io,
    labels_of_ros2,
    lvr2_mesh_io,
    map3d_of_ros2,
    mesh_map_of_ros2,
)

from mesh_msgs_hdf5.comparison.diff import compare
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.convert import convert
from mesh_msgs_hdf5.map_file.writing.lvr2_part import lvr2_part_name
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.validation.validate import validate


@pytest.fixture
def everything(rich_mesh):
    """A mesh with all that our files hold."""
    rich_mesh.face_attributes["zone"] = np.arange(len(rich_mesh.faces), dtype="<i2")
    rich_mesh.layer_parameters["height_diff"] = {"radius": 0.3}
    return rich_mesh


def test_ros2_reads_what_is_converted_for_it(tmp_path, everything):
    path, target = tmp_path / "a.h5", tmp_path / "b.h5"
    mesh = everything
    MapFile.write(path, mesh)
    with pytest.raises(ReaderEnds, match="NO MESH"):
        map3d_of_ros2(path)
    assert convert(path, target, profile="ros2") == []
    vertices, faces, colors, normals, layers = map3d_of_ros2(target)
    for found, expected in (
        (vertices, mesh.vertices),
        (faces, mesh.faces),
        (colors, mesh.vertex_colors),
        (normals, mesh.vertex_normals),
    ):
        np.testing.assert_array_equal(found, expected)
    # which takes any attribute of one column of float32 for a layer
    assert sorted(layers) == sorted([*mesh.vertex_costs, "echo"])
    vertices, faces, costs, normals = mesh_map_of_ros2(target, "mesh", mesh.vertex_costs)
    np.testing.assert_array_equal(vertices, mesh.vertices)
    np.testing.assert_array_equal(faces, mesh.faces)
    np.testing.assert_array_equal(normals, mesh.vertex_normals)
    for name, expected in mesh.vertex_costs.items():
        np.testing.assert_array_equal(costs[name], expected)
        np.testing.assert_array_equal(layers[name], expected)
    found = labels_of_ros2(target, "mesh")
    np.testing.assert_array_equal(found["tree_1"], mesh.labels["tree_1"].faces)
    assert len(found) == len(mesh.labels)
    channels, images, (handles, rgb) = lvr2_mesh_io(target, "mesh", "geometry")
    assert sorted(images) == sorted(mesh.textures)
    for index, image in mesh.textures.items():
        np.testing.assert_array_equal(images[index], image)
    np.testing.assert_array_equal(handles, mesh.materials.texture_indices)
    np.testing.assert_array_equal(rgb, mesh.materials.colors)
    face_materials = channels["face_material_indices"][:, 0]
    np.testing.assert_array_equal(face_materials, mesh.materials.face_materials)
    np.testing.assert_array_equal(channels["texture_coordinates"], mesh.texture_coordinates)
    with h5py.File(target, "r") as file:  # LVR2 asks each array for its second dimension
        attributes = file["mesh/face_attributes"]
        assert all(attributes[name].ndim == 2 for name in attributes) and "zone" in attributes


def test_there_and_back_nothing_is_lost(tmp_path, everything):
    path, there, back = (tmp_path / name for name in ("a.h5", "b.h5", "c.h5"))
    MapFile.write(path, everything)
    convert(path, there, profile="ros2")
    file = MapFile(there)
    assert (file.schema, file.parts, file.other_contents()) == ("S2", ["mesh"], [])
    assert file.uuid == everything.uuid
    assert_same_mesh(file.read(), everything)
    assert convert(there, back) == []
    file = MapFile(back)
    assert (file.schema, file.other_contents()) == ("S1", [])
    assert_same_mesh(file.read(), everything)
    assert compare(MapFile(path), file) == []
    with h5py.File(back, "r") as raw:
        assert sorted(raw["mesh"]) == sorted(h5py.File(path, "r")["mesh"])
    file.update(Edit(labels={"tree_1": None}))
    again = tmp_path / "d.h5"
    convert(there, again, profile="ros2")
    assert_same_mesh(MapFile(again).read(), everything)


@pytest.mark.parametrize("write", [write_s0, write_hdf5_map_io, write_lvr2_l1, write_s2])
def test_any_layout_goes_to_ros2(tmp_path, rich_mesh, write):
    path, target = tmp_path / "a.h5", tmp_path / "b.h5"
    mesh = write(path, rich_mesh)
    convert(path, target, profile="ros2")
    np.testing.assert_array_equal(map3d_of_ros2(target)[0], mesh.vertices)
    assert_same_mesh(MapFile(target).read(), mesh)


def test_a_bare_mesh_gets_normals_without_which_map3d_ends(tmp_path, rich_mesh):
    path, target = tmp_path / "a.h5", tmp_path / "b.h5"
    MapFile.write(path, Mesh(rich_mesh.vertices, rich_mesh.faces))
    (note,) = convert(path, target, profile="ros2")
    assert note.startswith("normals were added")
    normals = map3d_of_ros2(target)[3]
    lengths = np.linalg.norm(normals, axis=1)
    assert (np.isclose(lengths, 1, atol=1e-5) | (lengths == 0)).all() and lengths.any()


def test_map3d_of_ros2_shows_the_part_mesh_alone(tmp_path, rich_mesh):
    path, target = tmp_path / "a.h5", tmp_path / "b.h5"
    MapFile.write(path, rich_mesh, part="garden")
    (note,) = convert(path, target, profile="ros2")
    assert "shows the part mesh alone, and this one is garden" in note
    np.testing.assert_array_equal(mesh_map_of_ros2(target, "garden", ())[0], rich_mesh.vertices)


def test_one_file_for_hdf5_map_io_and_lvr2(tmp_path, rich_mesh):
    path, target = tmp_path / "a.h5", tmp_path / "b.h5"
    mesh = rich_mesh
    MapFile.write(path, mesh)
    with pytest.raises(ReaderEnds, match="images is no dataset"):
        lvr2_mesh_io(path, "mesh", "channels")
    (note,) = convert(path, target, profile="both")
    assert note.startswith("LVR2 reads the part mesh_lvr2, hdf5_map_io the part mesh")
    check_both(target, mesh)
    assert MapFile(target).parts == ["mesh", "mesh_lvr2"]
    with h5py.File(target, "r") as file:
        assert file["mesh/channels/vertices"] == file["mesh_lvr2/channels/vertices"]
    lvr2 = MapFile(target, "mesh_lvr2")
    assert lvr2.textures_form == "lvr2" and MapFile(target).textures_form == "hdf5_map_io"
    plain = dict(labels={}, face_attributes={}, face_parameters={}, features=None, source={})
    assert_same_mesh(lvr2.read(), dataclasses.replace(mesh, **plain))
    assert lvr2.stored_uuid == mesh.uuid
    assert not [f for f in validate(str(target)) if f.rule.startswith("uuid")]
    # edited, and made anew: one part for LVR2, of what is there now
    MapFile(target).update(Edit(textures={2: mesh.textures[2][::-1].copy()}))
    mesh.textures[2] = mesh.textures[2][::-1].copy()
    again = tmp_path / "c.h5"
    convert(target, again, profile="both")
    check_both(again, mesh)
    assert MapFile(again).parts == ["mesh", "mesh_lvr2"]


def check_both(path, mesh):
    assert_same_mesh(MapFile(path).read(), mesh)
    two, images, materials, faces = hdf5_map_io(path)
    np.testing.assert_array_equal(two["vertices"], mesh.vertices)
    np.testing.assert_array_equal(materials["textureIndex"], mesh.materials.texture_indices)
    np.testing.assert_array_equal(faces, mesh.materials.face_materials)
    channels, others, (handles, rgb) = lvr2_mesh_io(path, lvr2_part_name("mesh"), "channels")
    np.testing.assert_array_equal(channels["vertices"], mesh.vertices)
    np.testing.assert_array_equal(channels["face_indices"], mesh.faces)
    np.testing.assert_array_equal(handles, mesh.materials.texture_indices)
    np.testing.assert_array_equal(rgb, mesh.materials.colors)
    assert set(images) == set(others) == set(mesh.textures)
    for index, image in mesh.textures.items():
        np.testing.assert_array_equal(images[index], image)
        np.testing.assert_array_equal(others[index], image)


def test_a_part_of_somebody_keeps_its_name(tmp_path, rich_mesh):
    path, target = tmp_path / "a.h5", tmp_path / "b.h5"
    MapFile.write(path, rich_mesh)
    MapFile.write_part(path, Mesh(rich_mesh.vertices, rich_mesh.faces[:9]), "mesh_lvr2")
    (note,) = convert(path, target, profile="both")
    assert note.startswith("LVR2 reads the part mesh_lvr2 (2),")
    assert MapFile(target, "mesh_lvr2").face_count == 9

"""Meshes with seams of textures, served: with textures, and with the labels of versions before."""
import genpy
import numpy as np
import pytest
from seam_samples import closed_box, write_obj

from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Label
from mesh_msgs_hdf5.server.map_loading import load
from mesh_msgs_hdf5.server.server_options import MapRequest

OWNER = {"node": "/here"}


@pytest.fixture
def path(tmp_path):
    return str(write_obj(tmp_path, closed_box(), material=np.arange(12) % 3))


def served(path, read_only=False):
    (found,), notes = load(MapRequest(path, None), genpy.Time(1), OWNER, read_only)
    return found, notes


def test_a_mesh_file_is_served_with_its_textures(path):
    found, notes = served(path)
    messages = found.messages
    geometry = messages.geometry().mesh_geometry
    materials = messages.materials().mesh_materials
    assert len(materials.vertex_tex_coords) == len(geometry.vertices) > 8
    assert found.overlay.texture_indices() == [0, 1]
    assert [m.has_texture for m in materials.materials] == [True, True, False]
    assert (materials.materials[2].color.r, materials.materials[2].color.g) == (1.0, 0.0)
    assert any("seams" in note for note in notes)
    found.labels.close()


def test_labels_of_versions_before_are_kept(path, tmp_path):
    """They have stored them in a map of the mesh without textures, beside it."""
    plain, _ = read_mesh(path, split_seams=False)
    plain.labels = {"side_1": Label(np.arange(3, dtype=np.uint32))}
    MapFile.write(tmp_path / "model.h5", plain)
    found, notes = served(path)
    assert found.labels.names() == ["side_1"]
    assert any("is of the mesh without textures: import it again" in note for note in notes)
    found.labels.set("side_2", np.uint32([7]), override=True)
    found.labels.close()
    with LabelStore(path) as store:
        assert store.names() == ["side_1", "side_2"]


def test_edits_in_a_journal_of_versions_before_are_kept(path, tmp_path):
    plain, _ = read_mesh(path, split_seams=False)
    identity = plain.uuid, len(plain.faces)
    with LabelStore(path, identity=identity) as store:
        store.set("side_1", np.uint32([1, 2]), override=True)
    assert (tmp_path / "model.h5.journal").exists() and not (tmp_path / "model.h5").exists()
    found, _ = served(path)
    assert found.labels.get("side_1").faces.tolist() == [1, 2]
    found.labels.close()


def test_a_map_of_the_mesh_with_textures_is_taken(path, tmp_path):
    mesh, _ = read_mesh(path)
    mesh.labels = {"side_1": Label(np.arange(3, dtype=np.uint32))}
    MapFile.write(tmp_path / "model.h5", mesh)
    found, _ = served(path)
    assert found.labels.names() == ["side_1"] and len(found.overlay.texture_indices()) == 2
    found.labels.close()

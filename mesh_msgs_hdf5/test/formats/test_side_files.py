"""Files beside exports: their names, and whose they are."""
import hashlib
import os

import numpy as np
import pytest
from mesh_writers import SQUARE, TWO_FACES, pixels

from mesh_msgs_hdf5.checks.check import identical
from mesh_msgs_hdf5.formats.exporter import write_mesh
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Materials, Mesh


def assert_same_images(found, mesh):
    assert sorted(found.textures) == sorted(mesh.textures)
    assert all(identical(found.textures[index], image) for index, image in mesh.textures.items())
    for name, values in vars(mesh.materials).items():
        assert identical(getattr(found.materials, name), values), name


def test_files_beside_it_have_plain_names(tmp_path, rich_mesh):
    path = tmp_path / "my gärden\n.obj"
    write_mesh(path, rich_mesh)
    beside = sorted(name for name in os.listdir(tmp_path) if name != path.name)
    stem = "my_g_rden__" + hashlib.sha256("my gärden\n".encode()).hexdigest()[:8]
    assert beside == [stem + ".mtl"] + [stem + "_obj_texture_%d.png" % i for i in (0, 10, 2)]
    assert_same_images(read_mesh(path)[0], rich_mesh)


SAME_LETTERS = [
    ("日本", "中国"),
    ("tür", "tör"),
    ("a b", "a_b"),
    ("a#b", "a%b"),
    ("a" * 120, "a" * 121),
]


@pytest.mark.parametrize("stems", SAME_LETTERS, ids=lambda stems: stems[0][:3])
@pytest.mark.parametrize("suffix", [".ply", ".obj", ".gltf", ".dae"])
def test_files_beside_two_exports_are_not_the_same(tmp_path, suffix, stems):
    """Names that plain letters cannot tell apart, and other suffixes: each keeps its own images."""
    names = [stem + suffix for stem in stems] + [stems[0] + ".ply", stems[0] + ".obj"]
    meshes_ = {}
    for number, name in enumerate(dict.fromkeys(names)):
        mesh = Mesh(SQUARE, TWO_FACES, texture_coordinates=SQUARE[:, :2] / 2)
        mesh.textures = {0: pixels(number)}
        mesh.materials = Materials(
            np.full((1, 3), 255, np.uint8), np.zeros(1, np.int32), np.zeros(2, np.uint32)
        )
        write_mesh(tmp_path / name, mesh, overwrite=True)
        meshes_[name] = mesh
    for name, mesh in meshes_.items():
        found, _ = read_mesh(tmp_path / name)
        assert identical(found.textures[0], mesh.textures[0]), name


def test_files_of_another_export_are_never_overwritten(tmp_path, rich_mesh):
    """Also with overwrite: only what the file names that is replaced."""
    write_mesh(tmp_path / "a.obj", rich_mesh)
    os.rename(tmp_path / "a.obj", tmp_path / "b.obj")  # which names a.mtl now
    rich_mesh.materials.colors[0] += np.uint8(1)
    before = {name: (tmp_path / name).read_bytes() for name in os.listdir(tmp_path)}
    with pytest.raises(MapFileError, match="a.mtl: the file exists already, and b.obj names it"):
        write_mesh(tmp_path / "a.obj", rich_mesh, overwrite=True)
    (tmp_path / "b.obj").unlink()
    with pytest.raises(MapFileError, match="no mesh here names it"):
        write_mesh(tmp_path / "a.obj", rich_mesh, overwrite=True)
    assert {name: (tmp_path / name).read_bytes() for name in os.listdir(tmp_path)} == {
        name: data for name, data in before.items() if name != "b.obj"
    }
    (tmp_path / "a.obj").write_bytes(b"mtllib xa.mtl a.mtl.bak\n")  # other files
    with pytest.raises(MapFileError, match="a.mtl: the file exists already"):
        write_mesh(tmp_path / "a.obj", rich_mesh, overwrite=True)
    (tmp_path / "a.obj").write_bytes(b"mtllib a.mtl\n")
    write_mesh(tmp_path / "a.obj", rich_mesh, overwrite=True)
    assert_same_images(read_mesh(tmp_path / "a.obj")[0], rich_mesh)

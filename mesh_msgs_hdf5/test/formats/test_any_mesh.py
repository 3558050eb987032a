"""A mesh in memory has the same members as the map file of it."""
import subprocess
import sys

import numpy as np
import pytest
from every_member import ARGUMENTS, reading_members
from map_samples import assert_same

from mesh_msgs_hdf5.formats.any_mesh import MeshMembers
from mesh_msgs_hdf5.formats.exporter import write_mesh
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh

ABOUT_THE_FILE = {"path", "part", "parts", "schema", "schema_version", "stored_uuid", "strict"}
ABOUT_THE_FILE.add("textures_form")


def shuffled(mesh):
    """The same mesh, its names in another order."""
    for name in ("vertex_costs", "face_attributes", "textures", "labels"):
        setattr(mesh, name, dict(reversed(list(getattr(mesh, name).items()))))
    return mesh


def test_the_members_are_those_of_a_map_file(tmp_path, rich_mesh):
    file = MapFile.write(tmp_path / "a.h5", rich_mesh)
    members = MeshMembers("a.ply", shuffled(rich_mesh))
    for name, member in reading_members(file):
        if name in ABOUT_THE_FILE | {"read"}:
            continue
        found = getattr(members, name)
        found = found(*ARGUMENTS.get(name, [])) if callable(found) else found
        assert_same(found, member(), name)


@pytest.mark.parametrize("name", list(ARGUMENTS))
def test_what_is_not_there_is_the_same_error(tmp_path, full_mesh, name):
    file = MapFile.write(tmp_path / "a.h5", full_mesh)
    unknown = 99 if name == "texture" else "x"
    errors = []
    for members in (file, MeshMembers("a.ply", full_mesh)):
        with pytest.raises(MapFileError) as refused:
            getattr(members, name)(unknown)
        errors.append(refused.value)
    assert errors[0].code == errors[1].code
    assert errors[0].message == errors[1].message


def test_a_plain_mesh_has_nothing_else(full_mesh):
    mesh = Mesh(full_mesh.vertices, full_mesh.faces)
    members = MeshMembers("a.stl", mesh)
    assert not members.has_normals and members.other_contents() == [] and members.labels() == {}
    assert members.layer_names() == members.texture_indices() == members.label_names() == []
    assert np.array_equal(members.vertices, mesh.vertices) and members.read() is mesh


def test_a_map_file_is_read_without_importing_what_reads_other_formats(tmp_path, full_mesh):
    """Nodes start sooner; each format is imported with the first file of it."""
    MapFile.write(tmp_path / "a.h5", full_mesh)
    write_mesh(tmp_path / "a.ply", full_mesh)
    code = """if True:
        import sys
        from mesh_msgs_hdf5.formats.any_mesh import open_members

        def readers():
            names = [name for name in sys.modules if name.startswith("mesh_msgs_hdf5.formats.")]
            formats = {name.split(".")[2] for name in names}
            return formats & {"dae", "gltf", "obj", "ply", "stl"} | {"PIL"} & set(sys.modules)

        open_members(sys.argv[1]).members.read()
        assert readers() == set(), readers()
        open_members(sys.argv[2])
        assert readers() <= {"ply", "PIL"} and "ply" in readers(), readers()
    """
    files = [str(tmp_path / name) for name in ("a.h5", "a.ply")]
    done = subprocess.run([sys.executable, "-c", code, *files], stderr=subprocess.PIPE, timeout=120)
    assert done.returncode == 0, done.stderr.decode()

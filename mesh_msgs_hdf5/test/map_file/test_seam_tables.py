"""The table of copies along seams of textures: read, written, and carried by whatever saves."""
import re

import h5py
import numpy as np
import pytest
from seam_samples import closed_box, striped_terrain, write_obj

from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.isolation import IsolatedMapFile
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import geometry_uuid
from mesh_msgs_hdf5.validation.validate import validate

pytestmark = pytest.mark.usefixtures("read_here")


@pytest.fixture
def path(tmp_path):
    source = write_obj(tmp_path, closed_box())
    assert main(["import", str(source), str(tmp_path / "a.h5"), "-q"]) == 0
    return str(tmp_path / "a.h5")


def test_what_is_stored(path):
    vertices, faces, _ = closed_box()
    with h5py.File(path, "r") as file:
        found = file["mesh/seams/originals"]
        assert found.dtype == "<u4" and found.shape == (len(file["mesh/channels/vertices"]) - 8,)
        stored = file["mesh/channels/vertices"][()]
        assert np.array_equal(stored[8:], stored[found[()]])
        parent = found.attrs["parent_uuid"].decode()
    assert parent == geometry_uuid(vertices, faces.astype(np.uint32))
    for kind in (MapFile, IsolatedMapFile):
        file = kind(path)
        assert file.has_seams and file.parent_uuid == parent != file.uuid
        assert np.array_equal(file.read().parent_faces, faces)
        assert file.read(()).seam_originals is None
        assert np.array_equal(file.read(("seam_originals",)).seam_originals, file.seam_originals)


def test_whatever_saves_carries_it(path, tmp_path):
    mesh = MapFile(path).read()
    one = np.zeros(len(mesh.vertices), np.float32)

    def check(path, part=None):
        found = MapFile(path, part).read()
        assert np.array_equal(found.seam_originals, mesh.seam_originals)
        assert found.uuid == mesh.uuid and len(found.textures) == 2
        assert not [f for f in validate(path) if f.level == "error"]

    MapFile(path).update(Edit(vertex_costs={"a": one}))
    check(path)
    MapFile(path).update(Edit(remove=frozenset(["texture_coordinates"])))
    check(path)
    MapFile(path).update(Edit(texture_coordinates=mesh.texture_coordinates))
    out = str(tmp_path / "out.h5")
    for line in (
        "convert {f} {o}",
        "convert --for lvr2 {f} {o} --force",
        "repack {f} {o} --force",
        "repair {f} {o} --force",
        "import {f} {o} --force",
    ):
        assert main(line.format(f=path, o=out).split() + ["-q"]) == 0
        check(out)
    for line in ("copy {f} mesh other", "rename {f} other third", "copy {o} mesh more --from {f}"):
        assert main(("parts " + line).format(f=path, o=out).split() + ["-q"]) == 0
    check(path, "third")
    check(out, "more")
    source = str(tmp_path / "model.obj")
    assert main(["parts", "add", path, "again", source, "-q"]) == 0
    check(path, "again")


def test_a_part_that_is_replaced_loses_it(path, tmp_path):
    mesh = MapFile(path).read()
    MapFile.write_part(path, MapFile(path).read(()), "mesh", overwrite=True)
    file = MapFile(path)
    assert not file.has_seams and file.seam_originals is None and file.parent_uuid == ""
    assert file.uuid == mesh.uuid and file.other_contents() == []


def test_a_map_of_before_gets_its_table(path, tmp_path):
    """One that was imported with --split-seams, when copies were not known by anything."""
    mesh = MapFile(path).read()
    originals, mesh.seam_originals = mesh.seam_originals, None
    MapFile.write(path, mesh)
    assert not MapFile(path).has_seams
    out = str(tmp_path / "out.h5")
    assert main(["import", path, out, "--merge-vertices", "-q"]) == 0
    found = MapFile(out).read()
    assert len(found.seam_originals) == len(originals) and len(found.textures) == 2
    assert np.array_equal(found.vertices[found.faces], mesh.vertices[mesh.faces])
    uv = found.texture_coordinates[found.faces]
    assert np.array_equal(uv, mesh.texture_coordinates[mesh.faces])


def test_tables_that_do_not_fit_are_not_saved(path, tmp_path):
    mesh = MapFile(path).read()
    for originals, words in (
        ([99], "not among the first"),
        ([0.5], "is of type float64"),
        ([7], "is not where vertex 7 is"),
    ):
        mesh.seam_originals = np.array(originals)
        with pytest.raises(MapFileError, match=words):
            MapFile.write(tmp_path / "b.h5", mesh)
    assert not (tmp_path / "b.h5").exists()


def test_a_table_of_another_mesh_is_left_out(path):
    with h5py.File(path, "r+") as file:
        file["mesh/seams/originals"].attrs["parent_uuid"] = "00000000-0000-5000-8000-000000000000"
    file = MapFile(path)
    assert file.read().seam_originals is None and file.seam_originals is None
    assert file.parent_uuid == "" and len(file.notes) == 1
    assert "is of the mesh 00000000-0000-5000-8000-000000000000" in file.notes[0]
    with pytest.raises(MapFileError):
        MapFile(path, strict=True).read()
    assert [f.rule for f in validate(path) if f.level == "error"] == ["uuid"]


@pytest.mark.parametrize("itself", [True, False])
def test_repair_restores_a_table_whose_copies_lie_on_their_originals(path, tmp_path, itself):
    mesh = MapFile(path).read()
    with h5py.File(path, "r+") as file:
        file["mesh/seams/originals"].attrs["parent_uuid"] = "00000000-0000-5000-8000-000000000000"
    file = MapFile(path)
    assert file.read().seam_originals is None
    (note,) = file.notes
    assert "repair restores" in note and "import --merge-vertices" in note
    (error,) = [f for f in validate(path) if f.level == "error"]
    assert error.message.count("repair restores") == 1
    out = path if itself else str(tmp_path / "out.h5")
    assert main(["repair", path] + ([] if itself else [out]) + ["-q"]) == 0
    found = MapFile(out)
    assert np.array_equal(found.seam_originals, mesh.seam_originals) and not found.notes
    assert found.parent_uuid == mesh.parent_uuid
    assert not [f for f in validate(out) if f.level == "error"]


def test_a_table_that_cannot_be_read_is_one_error(path):
    before = validate(path)
    for spoil in (
        lambda found: found.attrs.modify("parent_uuid", "00000000-0000-5000-8000-000000000000"),
        lambda found: found.write_direct(found[()][::-1].copy()),
    ):
        with h5py.File(path, "r+") as file:
            spoil(file["mesh/seams/originals"])
        new = [finding for finding in validate(path) if finding not in before]
        assert [finding.where for finding in new] == ["seam_originals"]


def test_repair_restores_no_table_whose_copies_are_elsewhere(path, tmp_path):
    with h5py.File(path, "r+") as file:
        file["mesh/seams/originals"].attrs["parent_uuid"] = "00000000-0000-5000-8000-000000000000"
        file["mesh/seams/originals"][2] = (file["mesh/seams/originals"][2] + 1) % 8
    out = str(tmp_path / "out.h5")
    assert main(["repair", path, out, "-q"]) == 0
    assert MapFile(out).seam_originals is None


def test_info_and_diff_say_it(path, tmp_path, capsys):
    file = MapFile(path)
    assert main(["info", path]) == 0
    text = capsys.readouterr().out
    copies = len(file.seam_originals)
    said = r"seams +of textures at 8 vertices: %d copies of them, of the mesh %s"
    assert re.search(said % (copies, file.parent_uuid), text)
    out = str(tmp_path / "plain.h5")
    assert main(["import", path, out, "--no-split-seams", "-q"]) == 0
    assert MapFile(out).uuid == file.parent_uuid
    assert main(["diff", path, out]) == 1
    assert "seams: only in A" in capsys.readouterr().out
    assert main(["diff", path, path]) == 0


def test_validate_takes_copies_for_one_vertex(tmp_path):
    for model, boundary in ((closed_box(), False), (striped_terrain(), True)):
        source = write_obj(tmp_path, model)
        for name, options in (("a.h5", []), ("b.h5", ["--no-split-seams"])):
            line = ["import", str(source), str(tmp_path / name), "--force", "-q"]
            assert main(line + options) == 0
        with_seams, without = (
            [f for f in validate(str(tmp_path / name)) if f.rule != "lvr2_textures"]
            for name in ("a.h5", "b.h5")
        )
        assert with_seams == without
        assert ("boundary" in {f.rule for f in without}) == boundary


def test_options_of_the_verb(tmp_path, capsys):
    source = str(write_obj(tmp_path, closed_box()))
    answers = []
    for options in ([], ["--split-seams"], ["--no-split-seams"]):
        out = str(tmp_path / "o.h5")
        assert main(["import", source, out, "--force"] + options) == 0
        answers.append((capsys.readouterr().out, MapFile(out).read()))
    (text, default), (_, asked), (left_out, plain) = answers
    assert default.uuid == asked.uuid and len(default.textures) == len(asked.textures) == 2
    assert "textures have seams at 8 vertices" in text
    assert not plain.textures and plain.uuid == default.parent_uuid
    assert "seams" in left_out and "--split-seams keeps them" in left_out
    with pytest.raises(SystemExit):
        main(["import", source, out, "--split-seams", "--no-split-seams"])

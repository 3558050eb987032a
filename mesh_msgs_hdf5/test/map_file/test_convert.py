"""Any schema becomes S1 with everything in it, and back to LVR2's form; nothing is lost."""
import os

import h5py
import numpy as np
import pytest
from map_samples import (
    assert_same_mesh,
    write_hdf5_map_io,
    write_lvr2_l1,
    write_mesh_io,
    write_model_factory,
    write_s0,
    write_s2,
)
from raw_contents import add_strange_things, raw_contents

from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.convert import convert, repack
from mesh_msgs_hdf5.map_file.writing import map_saving
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh

# name -> (writer, part of the result)
LAYOUTS = {
    "s0": (write_s0, "mesh"),
    "hdf5_map_io": (write_hdf5_map_io, "mesh"),
    "lvr2": (write_lvr2_l1, "mesh"),
    "s2": (write_s2, "mesh"),
    "model factory": (write_model_factory, "garden"),
    "meshio": (write_mesh_io, "garden"),
}


BUDGETS = [1 << 40, 0]  # with which a file is built in memory, on disk


def set_budget(monkeypatch, value):
    monkeypatch.setattr(map_saving, "MEMORY_BUDGET", value)
    monkeypatch.setattr(map_saving, "_SLACK_BYTES", 1 << 16)


@pytest.fixture(params=BUDGETS, ids=["in memory", "on disk"])
def budget(request, monkeypatch):
    set_budget(monkeypatch, request.param)


@pytest.mark.parametrize("profile", ["s1", "lvr2"])
@pytest.mark.parametrize("name", LAYOUTS)
def test_every_layout_becomes_s1(tmp_path, rich_mesh, monkeypatch, name, profile):
    """One profile in memory, the other on disk."""
    turn = list(LAYOUTS).index(name) + (profile == "lvr2")
    set_budget(monkeypatch, BUDGETS[turn % 2])
    source, target = tmp_path / "a.h5", tmp_path / "b.h5"
    write, part = LAYOUTS[name]
    mesh = write(source, rich_mesh)
    before = source.read_bytes()
    others = unknown(source)
    notes = convert(source, target, profile=profile)
    assert source.read_bytes() == before and sorted(os.listdir(tmp_path)) == ["a.h5", "b.h5"]
    file = MapFile(target)
    assert (file.schema, file.schema_version, file.part) == ("S1", 1, part)
    assert_same_mesh(file.read(), mesh)
    assert file.uuid == mesh.uuid and file.parts == [part]
    assert unknown(target) == others and bool(others) == (name in ("lvr2", "s2", "meshio"))
    if name in ("s0", "model factory", "meshio"):
        assert notes[0].startswith("the part /") and notes[0].endswith("is now /" + part)
    with h5py.File(target, "r") as raw:
        assert sorted(raw[part].attrs)[:2] == ["CLASS", "IO"]
        if name in ("s0", "model factory"):
            assert list(raw) == [part]
    # and on: edited, and converted back and forth
    file.update(Edit(labels={"tree_1": None}, crs="EPSG:3"))
    mesh.labels.pop("tree_1", None)
    mesh.crs = "EPSG:3"
    for number, other in enumerate(("lvr2", "s1", "lvr2", "s1")):
        again = tmp_path / ("%d.h5" % number)
        assert not [note for note in convert(target, again, profile=other) if "left" in note]
        assert_same_mesh(MapFile(again).read(), mesh)
        target = again


def test_what_is_unknown_is_carried_over(tmp_path, rich_mesh, budget):
    """Through S2 -> S1 -> LVR2's form -> S1, as it is stored."""
    path = tmp_path / "0.h5"
    mesh = write_s2(path, rich_mesh)
    with h5py.File(path, "r+") as file:
        file.create_group("mesh/channels")
    add_strange_things(path)
    with h5py.File(path, "r+") as file:
        file["mesh/labels/tree"].attrs["kept"] = 5
        file["mesh/geometry/unknown"] = np.arange(7)
    assert_same_mesh(MapFile(path).read(), mesh)
    before, groups = unknown(path), raw_contents(path)
    assert {"/mesh/channels/edge_distances", "/mesh/geometry/unknown", "/raw/scans/z"} <= set(
        before
    )
    assert len(before) > 40
    for number, profile in enumerate(("s1", "lvr2", "s1"), 1):
        target = tmp_path / ("%d.h5" % number)
        convert(path, target, profile=profile)
        after = raw_contents(target)
        assert unknown(target) == before
        assert after["/mesh/labels/tree"] == groups["/mesh/labels/tree"]
        assert after["/"] == groups["/"]
        assert after["/mesh"][1]["operator"] == groups["/mesh"][1]["operator"]
        assert_same_mesh(MapFile(target).read(), mesh)
        path = target


def unknown(path):
    """What is in a file besides the mesh, as it is stored; without the groups."""
    others = MapFile(path).other_contents()
    return {
        place: what
        for place, what in raw_contents(path).items()
        if what[0] != "group"
        and any(place == other or place.startswith(other + "/") for other in others)
    }


def test_what_is_in_the_way_gets_another_name(tmp_path, rich_mesh):
    path, target = tmp_path / "a.h5", tmp_path / "b.h5"
    mesh = write_s2(path, rich_mesh)
    with h5py.File(path, "r+") as file:
        file["mesh/channels/vertices"] = np.arange(3)
        layer = sorted(mesh.vertex_costs)[0]
        file["mesh/channels/" + layer] = h5py.SoftLink("/x")
        file["mesh/clustersets"] = 5
    notes = convert(path, target)
    assert set(notes) == {
        "%s was renamed %s (2)" % (place, place)
        for place in ("/mesh/channels/vertices", "/mesh/clustersets", "/mesh/channels/" + layer)
    }
    assert_same_mesh(MapFile(target).read(), mesh)
    with h5py.File(target, "r") as file:
        assert file["mesh/channels/vertices (2)"][()].tolist() == [0, 1, 2]
        assert file["mesh/channels"].get(layer + " (2)", getlink=True).path == "/x"
        assert file["mesh/clustersets (2)"][()] == 5


def test_a_link_to_nowhere_in_the_way_gets_another_name(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    MapFile.write(path, rich_mesh)
    with h5py.File(path, "r+") as file:
        del file["mesh/clustersets"]
        file["mesh/clustersets"] = h5py.SoftLink("/nowhere")
    notes = convert(path, tmp_path / "b.h5")
    assert notes == ["/mesh/clustersets was renamed /mesh/clustersets (2)"]
    with h5py.File(tmp_path / "b.h5", "r") as file:
        assert isinstance(file["mesh/clustersets"], h5py.Group)
        assert file["mesh"].get("clustersets (2)", getlink=True).path == "/nowhere"
    assert_same_mesh(MapFile(tmp_path / "b.h5").read(), rich_mesh)


def test_nothing_but_images_is_in_textures_for_lvr2(tmp_path, rich_mesh):
    """Its MeshIO loads every child as an image, and no name but a number."""
    path, target = tmp_path / "a.h5", tmp_path / "b.h5"
    MapFile.write(path, rich_mesh)
    with h5py.File(path, "r+") as file:
        file["mesh/textures/notes"] = np.arange(3)
        file["mesh/textures/images/logo"] = np.zeros((2, 2, 3), "u1")
        file["mesh/textures/away"] = h5py.ExternalLink("x.h5", "/x")
    notes = convert(path, target, profile="lvr2")
    assert len(notes) == 3 and all("/mesh/not textures/" in note for note in notes)
    with h5py.File(target, "r") as file:
        assert sorted(file["mesh/textures"]) == ["0", "10", "2"]
        assert sorted(file["mesh/not textures"]) == ["away", "images", "notes"]
        assert list(file["mesh/not textures/images"]) == ["logo"]
    assert_same_mesh(MapFile(target).read(), rich_mesh)


def test_attributes_that_cannot_stay_are_noted(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    write_hdf5_map_io(path, rich_mesh)
    with h5py.File(path, "r+") as file:
        file["mesh/channels/vertices"].attrs["unit"] = "m"
        file["mesh"].attrs["uuid"] = "garden"
    notes = convert(path, tmp_path / "b.h5")
    assert notes[0] == "left out: 1 attributes of arrays, first unit of /mesh/channels/vertices"
    assert notes[1].startswith("the UUID garden is now that of the geometry, ")


def test_a_part_among_others(tmp_path, rich_mesh):
    """The other parts stay as they are; the new part's name is none of theirs."""
    path, target = tmp_path / "a.h5", tmp_path / "b.h5"
    MapFile.write(path, rich_mesh, part="garden")
    write_s2(tmp_path / "s2.h5", rich_mesh)
    write_model_factory(tmp_path / "old.h5", rich_mesh)
    with h5py.File(path, "r+") as file:
        for name, place in (("s2.h5", "mesh"), ("old.h5", "meshes")):
            with h5py.File(tmp_path / name, "r") as other:
                other.copy(place, file)
    assert MapFile(path).parts == ["garden", "mesh", "meshes/garden"]
    garden = raw_contents(path)
    notes = convert(path, target, part="meshes/garden")
    assert notes == ["the part /meshes/garden is now /garden (2)"]
    assert MapFile(target).parts == ["garden", "garden (2)", "mesh"]
    kept = {place: what for place, what in garden.items() if not place.startswith("/meshes")}
    after = raw_contents(target)
    assert {place: after[place] for place in kept} == kept
    assert_same_mesh(MapFile(target, "garden").read(), rich_mesh)


@pytest.mark.parametrize(
    "source,target,more,code",
    [
        ("a.h5", "a.h5", {"overwrite": True}, "exists"),
        ("a.h5", "link.h5", {"overwrite": True}, "exists"),
        ("a.h5", "taken.h5", {}, "exists"),
        ("a.h5", "b.h5", {"profile": "s3"}, "value"),
        ("a.h5", "b.h5", {"part": "none"}, "part"),
        ("a.h5", "no/b.h5", {}, "save"),
        ("gone.h5", "b.h5", {}, "missing"),
        ("taken.h5", "b.h5", {}, "format"),
        ("newer.h5", "b.h5", {}, "version"),
        ("bad.h5", "b.h5", {}, "not_finite"),
    ],
)
def test_what_cannot_be_converted(tmp_path, full_mesh, source, target, more, code):
    for name in ("a.h5", "newer.h5", "bad.h5"):
        MapFile.write(tmp_path / name, full_mesh)
    with h5py.File(tmp_path / "newer.h5", "r+") as file:
        file["mesh"].attrs["schema_version"] = 2
    with h5py.File(tmp_path / "bad.h5", "r+") as file:
        file["mesh/channels/vertices"][3] = np.nan
    (tmp_path / "taken.h5").write_text("x" * 5000)
    (tmp_path / "link.h5").symlink_to("a.h5")
    before = {name: (tmp_path / name).read_bytes() for name in os.listdir(tmp_path)}
    with pytest.raises(MapFileError) as refused:
        convert(tmp_path / source, tmp_path / target, **more)
    assert refused.value.code == code
    assert {name: (tmp_path / name).read_bytes() for name in os.listdir(tmp_path)} == before


def test_a_converted_file_has_no_unused_space(tmp_path, rich_mesh, budget):
    rich_mesh.textures[3] = np.random.default_rng(0).integers(0, 256, (900, 900, 3)).astype("u1")
    MapFile.write(tmp_path / "a.h5", rich_mesh)
    size = os.path.getsize(tmp_path / "a.h5")
    for profile in ("lvr2", "s1"):
        convert(tmp_path / "a.h5", tmp_path / "b.h5", profile=profile, overwrite=True)
        assert abs(os.path.getsize(tmp_path / "b.h5") - size) < 8192


@pytest.mark.parametrize("compression", ["gzip", "none"])
def test_repack(tmp_path, rich_mesh, budget, compression):
    """Unused space goes; the arrays of the meshes are stored anew; the rest is as it was."""
    path, target = tmp_path / "a.h5", tmp_path / "b.h5"
    rich_mesh.vertex_costs["flat"] = np.zeros(40, "f4")
    rich_mesh.textures[3] = np.zeros((90, 90, 3), "u1")
    MapFile.write(path, rich_mesh, compression="none" if compression == "gzip" else "gzip")
    add_strange_things(path)
    with h5py.File(path, "r+") as file:
        file["mesh/textures/images/3"].attrs["taken"] = "2026"
        file["hole"] = np.random.default_rng(0).random(1_000_000)
        file["mesh 2/after"] = np.arange(5)
    with h5py.File(path, "r+") as file:
        del file["hole"]
    before = path.read_bytes()
    repack(path, target, compression)
    assert path.read_bytes() == before and os.path.getsize(target) < len(before) - 7_000_000
    old, new = raw_contents(path), raw_contents(target)
    image = "/mesh/textures/images/3"
    assert [place for place in old if old[place] != new.get(place)] == [image]
    assert set(old) == set(new) and old[image][6] == new[image][6]  # its attributes
    with h5py.File(target, "r") as file:
        assert file[image].compression == (None if compression == "none" else "gzip")
        assert (file[image].chunks is None) == (compression == "none")
    assert_same_mesh(MapFile(target).read(), rich_mesh)
    MapFile(target).update(Edit(frame_id="odom"))


def test_repack_in_place(tmp_path, rich_mesh, budget):
    path = tmp_path / "a.h5"
    MapFile.write(path, rich_mesh)
    with pytest.raises(MapFileError) as refused:
        repack(path, path)
    assert refused.value.code == "exists"
    repack(path, path, overwrite=True)
    assert_same_mesh(MapFile(path).read(), rich_mesh)
    assert os.listdir(tmp_path) == ["a.h5"]
    with pytest.raises(MapFileError) as refused:
        repack(path, tmp_path / "b.h5", "lzf")
    assert refused.value.code == "value" and os.listdir(tmp_path) == ["a.h5"]


@pytest.mark.parametrize("compression", ["gzip", "none"])
def test_repack_keeps_what_has_several_names(tmp_path, compression):
    rng = np.random.default_rng(1)
    vertices = rng.normal(size=(3000, 3)).astype("f4")
    faces = rng.integers(0, 3000, (5000, 3)).astype("u4")
    mesh = Mesh(vertices, faces, vertex_costs={"height_diff": vertices[:, 0] ** 2})
    path = tmp_path / "a.h5"
    MapFile.write(path, mesh, compression="none" if compression == "gzip" else "gzip")
    with h5py.File(path, "r+") as raw:
        raw["a"] = raw["z/mesh"] = raw["mesh"]
        raw["mesh/channels/again"] = raw["mesh/channels/height_diff"]
    repack(path, path, compression, overwrite=True)
    with h5py.File(path, "r") as raw:
        assert raw["a"] == raw["z/mesh"] == raw["mesh"]
        assert raw["mesh/channels/again"] == raw["mesh/channels/height_diff"]
        assert bool(raw["mesh/channels/vertices"].chunks) == (compression == "gzip")
    mesh.vertex_costs["again"] = mesh.vertex_costs["height_diff"]
    assert_same_mesh(MapFile(path, "mesh").read(), mesh)


def test_repack_of_other_schemas_and_several_parts(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    mesh = write_s2(path, rich_mesh)
    with h5py.File(path, "r+") as file:
        file.copy("mesh", "two")
    repack(path, tmp_path / "b.h5", "none")
    for part in ("mesh", "two"):
        assert_same_mesh(MapFile(tmp_path / "b.h5", part).read(), mesh)
    assert MapFile(tmp_path / "b.h5", "two").schema == "S2"

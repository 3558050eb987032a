"""The command mesh_tool: labels and layers of a mesh with copies along seams, and of its parent."""
import numpy as np
import pytest
from seam_samples import closed_box, striped_terrain, write_obj

from mesh_msgs_hdf5.checks.check import identical
from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.mesh import Label

pytestmark = pytest.mark.usefixtures("read_here")


@pytest.fixture(params=[closed_box, striped_terrain])
def maps(tmp_path, request):
    """(the map with copies, the one of its parent)."""
    source = str(write_obj(tmp_path, request.param()))
    for name, option in (("split.h5", "--split-seams"), ("parent.h5", "--no-split-seams")):
        assert main(["import", source, str(tmp_path / name), option, "-q"]) == 0
    return tmp_path / "split.h5", tmp_path / "parent.h5"


def run(*words):
    return main([*map(str, words), "-q"])


def test_labels_of_the_parent_are_taken(maps, tmp_path, capsys):
    split, parent = maps
    assert MapFile(split).parent_uuid == MapFile(parent).uuid
    labels = {"tree_1": Label(np.uint32([3, 5]), (1, 2, 3))}
    MapFile(parent).update(Edit(labels=labels))
    assert run("labels", "export", parent, tmp_path / "l.json") == 0
    assert run("labels", "import", split, tmp_path / "l.json") == 0
    assert MapFile(split).labels()["tree_1"].faces.tolist() == [3, 5]
    text = (tmp_path / "l.json").read_text()
    for uuid in ("", "00000000-0000-5000-8000-000000000000"):  # of nobody
        (tmp_path / "l.json").write_text(text.replace(MapFile(parent).uuid, uuid))
        for path in (split, parent):
            assert run("labels", "import", path, tmp_path / "l.json") == 1
            assert "geometry" in capsys.readouterr().err


def test_layers_go_both_ways(maps):
    split, parent = maps
    originals = MapFile(split).seam_originals
    count, faces = MapFile(parent).vertex_count, MapFile(parent).face_count
    rng = np.random.default_rng(3)
    costs, features = rng.random(count).astype(np.float32), rng.integers(0, 99, (count, 2))
    costs[:2] = np.nan, np.inf
    info = {"radius": 0.5, "layer_info": {"unit": "m", "comparison": "none", "lethal": 1}}
    of_faces = rng.random(faces)
    MapFile(parent).update(
        Edit(
            vertex_costs={"slope": costs},
            layer_parameters={"slope": info},
            vertex_attributes={"feature": features},
            face_attributes={"area": of_faces},
        )
    )
    kinds = {"slope": [], "feature": ["--vertex"], "area": ["--face"]}
    for name, kind in kinds.items():
        assert run("layers", "copy", split, name, "--from", parent, *kind) == 0
    found, rows = MapFile(split), np.append(np.arange(count), originals)
    assert identical(found.vertex_costs("slope"), costs[rows])
    assert identical(found.vertex_attribute("feature"), features[rows])
    assert identical(found.face_attribute("area"), of_faces)
    meaning = {"unit": "m", "comparison": "none"}
    assert found.layer_parameters("slope") == {"radius": 0.5, "layer_info": meaning}
    # and back, under another name; of copies that differ the largest cost counts
    wider = costs[rows].copy()
    wider[count] = 7
    MapFile(split).update(Edit(vertex_costs={"slope": wider}))
    for name, kind in kinds.items():
        assert run("layers", "copy", parent, name, "my_" + name, "--from", split, *kind) == 0
    found, wanted = MapFile(parent), costs.copy()
    if not np.isnan(wanted[originals[0]]):
        wanted[originals[0]] = max(7, wanted[originals[0]])
    assert identical(found.vertex_costs("my_slope"), wanted)
    assert identical(found.vertex_attribute("my_feature"), features)
    assert identical(found.face_attribute("my_area"), of_faces)


def test_other_meshes_give_no_layers(maps, tmp_path, capsys):
    split, parent = maps
    mesh = MapFile(parent).read()
    mesh.vertices = mesh.vertices + np.float32(1)
    mesh.vertex_costs = {"slope": np.zeros(len(mesh.vertices), np.float32)}
    MapFile.write(tmp_path / "other.h5", mesh)
    MapFile.write_part(split, mesh, "other")
    for more in (["--from", tmp_path / "other.h5"], ["--from", split, "--from-part", "other"]):
        assert run("layers", "copy", split, "slope", *more, "--part", "mesh") == 1
        assert "its geometry is another" in capsys.readouterr().err

"""A map in which one thing is bad is served without it, which is said once."""
import genpy
import numpy as np
import pytest
from bad_values import BAD, noted, write_bad

from mesh_msgs_hdf5.formats.importer import read_unharmed_mesh
from mesh_msgs_hdf5.label_manager.label_maps import LabelMaps
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.server.map_loading import load, source_now
from mesh_msgs_hdf5.server.server_options import MapRequest

pytestmark = pytest.mark.usefixtures("read_here")


@pytest.fixture(params=BAD)
def served(request, tmp_path, rich_data):
    """(a served map in which one thing is bad, what)."""
    path = tmp_path / "a.h5"
    write_bad(path, rich_data, request.param)
    (found,), _ = load(MapRequest(str(path)), genpy.Time(1), {"node": "/here"}, False)
    yield found, request.param
    found.labels.close()


def test_all_messages_are_made(served):
    found, kind = served
    messages, overlay = found.messages, found.overlay
    assert len(messages.geometry().mesh_geometry.vertices) == 40
    normals = messages.geometry().mesh_geometry.vertex_normals
    assert len(normals) == (0 if kind == "no normals" else 40) and np.isfinite(normals).all()
    colors = messages.vertex_colors().mesh_vertex_colors.vertex_colors
    assert len(colors) == (0 if kind == "link" else 40)
    for name in overlay.layer_names():
        costs = messages.vertex_costs(name).mesh_vertex_costs.costs
        assert len(costs) == 40 and not (costs == -np.inf).any()
    messages.layer_info()
    for name in overlay.face_attribute_names():
        messages.face_costs(name)
    messages.materials()
    assert len(messages.features().features) in (11, 12)
    for index in overlay.texture_indices():
        if (kind, index) == ("texture", 10):
            with pytest.raises(MapFileError):
                messages.texture(index)
        else:
            messages.texture(index)
    labels = found.labels.all()
    assert set(labels) <= set(found.labels.names()) and "house_2_b" in labels
    for group in found.labels.groups():
        found.labels.group(group)
    # nobody looks at it; it is an error of the service
    if kind not in ("source", "seams", "texture"):
        assert noted(found.new_notes(), kind) == 1
    assert found.new_notes() == []


def test_labels_are_edited(served):
    found, kind = served
    for text in found.labels.names():
        found.labels.delete(text)
    assert found.labels.names() == []
    found.labels.set("tree_2", [4, 5])
    found.fold_labels()
    assert sorted(MapFile(found.path).labels()) == ["tree_2"]


@pytest.mark.parametrize("kind", [kind for kind in BAD if kind.startswith("label")])
def test_the_label_manager_says_it_once(tmp_path, rich_data, kind):
    write_bad(tmp_path / "a.h5", rich_data, kind)
    maps = LabelMaps(tmp_path / "labels")
    maps.add(tmp_path / "a.h5").all()
    assert noted(maps.taken_notes(), kind) == 1
    assert maps.taken_notes() == []
    maps.close()


def test_a_label_that_cannot_be_read_is_replaced_or_refused(tmp_path, rich_data):
    write_bad(tmp_path / "a.h5", rich_data, "label type")
    maps = LabelMaps(tmp_path / "labels")
    store = maps.add(tmp_path / "a.h5")
    with pytest.raises(MapFileError, match="tree_2 is of type"):
        store.set("tree_2", [1], override=False)  # its faces would be lost
    assert store.set("tree_2", [1]).faces.tolist() == [1]
    maps.close()


def test_vertices_far_away_are_not_rounded_silently(tmp_path, rich_mesh):
    """float32 knows half meters at 5,800 km: no node may drive by that."""
    import h5py

    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["mesh/channels/vertices"] = rich_mesh.vertices.astype("f8") + [4e5, 5.8e6, 0]
        file["mesh/channels/face_indices"] = rich_mesh.faces
    for look in (
        lambda: load(MapRequest(str(path)), genpy.Time(1), {}, True),
        lambda: source_now(MapRequest(str(path))),
        lambda: read_unharmed_mesh(path),
    ):
        with pytest.raises(MapFileError, match="would change its coordinates by up to 0.2"):
            look()
    file = MapFile(path)
    assert 0.1 < file.vertex_rounding < 0.5 and "rounded" in file.notes[0]

"""Updates of layers: of what the file has when they are saved, whoever has saved it meanwhile."""
import genpy
import h5py
import numpy as np
import pytest
from mesh_msgs import arrays
from server_samples import everything, layer_message

from mesh_msgs_hdf5.files.save import stamp
from mesh_msgs_hdf5.isolation import IsolatedMapFile
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.edit import CostsUpdate, Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.server import received
from mesh_msgs_hdf5.server.map_loading import load
from mesh_msgs_hdf5.server.server_options import MapRequest

pytestmark = pytest.mark.usefixtures("read_here")

STAMP = genpy.Time(1)
BEFORE = np.arange(12, dtype=np.float32)


@pytest.fixture
def path(tmp_path):
    path = str(tmp_path / "a.h5")
    MapFile.write(path, everything())
    save(path, BEFORE)
    return path


@pytest.fixture
def served(path):
    (found,), _ = load(MapRequest(path), STAMP, {"node": "/here"}, False)
    yield found
    found.labels.close()


def save(path, costs):
    """As another program does."""
    MapFile(path).update(Edit(vertex_costs={"slope": costs}))


def update(served, vertices, values, default=0.0):
    message = arrays.MeshVertexCostsSparseStamped(type="slope")
    message.mesh_vertex_costs = arrays.MeshVertexCostsSparse(vertices, values, default)
    served.store(received.vertex_costs_update, message, STAMP)


def replace(served, value):
    served.store(received.vertex_costs, layer_message("slope", value), STAMP)


def expect(served, path, costs):
    """This is served, and in the file."""
    np.testing.assert_array_equal(MapFile(path).vertex_costs("slope"), np.float32(costs))
    np.testing.assert_array_equal(served.overlay.vertex_costs("slope"), np.float32(costs))


def test_what_another_program_saved_meanwhile_stays(served, path):
    update(served, [3], [90.0])
    save(path, BEFORE + 100)
    update(served, [4, 5], [np.nan, np.inf])
    assert served.overlay.vertex_costs("slope")[3] == 90
    assert served.save() == ("1 layer", "")
    expect(served, path, [100, 101, 102, 90, np.nan, np.inf] + list(range(106, 112)))
    assert served.is_saved


def test_also_what_it_wrote_into_the_file(served, path):
    update(served, [3], [90.0])
    with h5py.File(path, "r+") as file:
        file["mesh/channels/slope"][5] = 70
    served.save()
    expect(served, path, [0, 1, 2, 90, 4, 70, 6, 7, 8, 9, 10, 11])


def test_a_layer_that_was_replaced_stays_whole(served, path):
    for order in ("the layer first", "the update first"):
        if order == "the update first":
            update(served, [7], [70.0])
        replace(served, 5.0)
        update(served, [3], [90.0])
        save(path, BEFORE)
        served.save()
        expect(served, path, [5, 5, 5, 90] + 8 * [5])


def test_a_layer_that_was_deleted_meanwhile_is_made_of_the_first_default(served, path):
    update(served, [3], [90.0], default=2.0)
    update(served, [4], [91.0], default=7.0)
    MapFile(path).update(Edit(vertex_costs={"slope": None}))
    served.save()
    expect(served, path, [2, 2, 2, 90, 91] + 7 * [2])


def test_what_is_updated_during_the_save_waits_for_the_next_one(served, path, monkeypatch):
    update(served, [3], [90.0])
    write = type(served)._write

    def write_slowly(self, edit):
        update(served, [4], [91.0])
        write(self, edit)

    with monkeypatch.context() as changed:
        changed.setattr(type(served), "_write", write_slowly)
        served.save()
    assert MapFile(path).vertex_costs("slope")[4] == 4
    save(path, BEFORE + 100)
    served.save()
    expect(served, path, [100, 101, 102, 90, 91] + list(range(105, 112)))


def test_while_it_waits_it_is_served_over_what_the_file_has_now(served, path):
    update(served, [3], [90.0])
    save(path, BEFORE + 100)
    served.overlay.follow_source()
    costs = served.overlay.vertex_costs("slope")
    assert costs.tolist() == [100, 101, 102, 90] + list(range(104, 112))
    served.save()
    assert served.is_saved


def test_what_another_program_saved_just_before_is_to_be_published(served, path):
    update(served, [3], [90.0])
    served.save()
    assert not served.is_changed(stamp(path))  # it is our own
    save(path, BEFORE + 100)
    update(served, [3], [91.0])
    served.save()
    assert served.is_changed(stamp(path))


@pytest.mark.parametrize("kind", [MapFile, IsolatedMapFile])
def test_an_update_of_a_file(path, kind):
    changed = BEFORE > 9
    kind(path).update(
        Edit(vertex_costs={"slope": BEFORE * 2}, costs_updates={"slope": CostsUpdate(changed, 1.0)})
    )
    expected = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 20, 22]
    assert MapFile(path).vertex_costs("slope").tolist() == expected
    for bad in (changed[1:], changed.astype(np.uint8)):
        with pytest.raises(MapFileError, match="no array of 12 bools"):
            edit = Edit(vertex_costs={"slope": BEFORE}, costs_updates={"slope": CostsUpdate(bad)})
            kind(path).update(edit)
    with pytest.raises(MapFileError, match="no values in vertex_costs"):
        kind(path).update(Edit(costs_updates={"slope": CostsUpdate(changed)}))

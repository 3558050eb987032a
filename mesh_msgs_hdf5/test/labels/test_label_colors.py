"""Colors of labels in a store: journaled, saved, taken away."""
import numpy as np
import pytest

from mesh_msgs_hdf5.labels.fixed_labels import FixedLabels
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label, Mesh


@pytest.fixture
def path(tmp_path):
    path = str(tmp_path / "a.h5")
    mesh = Mesh(
        np.eye(3, dtype=np.float32),
        np.uint32([[0, 1, 2]] * 4),
        labels={"a_1": Label(np.uint32([0, 1]), (1, 2, 3)), "b_1": Label(np.uint32([2]))},
    )
    MapFile.write(path, mesh)
    return path


def colors(labels):
    return {text: label.color for text, label in labels.items()}


def test_colors_are_in_the_journal_at_once_and_in_the_file_when_saved(path):
    with LabelStore(path) as store:
        changed = store.set_color("b_1", (9, 0, 255))
        assert (changed.color, changed.faces.tolist()) == ((9, 0, 255), [2])
        store.set_color("a_1", None)
        expected = {"a_1": None, "b_1": (9, 0, 255)}
        assert colors(store.all()) == expected
        assert colors(MapFile(path).labels()) == {"a_1": (1, 2, 3), "b_1": None}
        with LabelStore(path, read_only=True) as other:
            assert colors(other.all()) == expected
    with LabelStore(path) as store:  # the one before has not saved
        assert colors(store.all()) == expected
        assert store.save() == 2
    assert colors(MapFile(path).labels()) == expected


def test_the_same_color_is_no_edit(path):
    with LabelStore(path) as store:
        store.set_color("a_1", (1, 2, 3))
        store.set_color("b_1", None)
        assert not store.dirty


def test_faces_that_are_set_later_keep_the_color(path):
    with LabelStore(path) as store:
        store.set_color("b_1", (4, 5, 6))
        assert store.set("b_1", [3]).color == (4, 5, 6)


@pytest.mark.parametrize(
    "text, color, code, words",
    [
        ("b_2", (1, 2, 3), "label", "did you mean b_1"),
        ("b_1", (1, 2, 300), "value", "color of"),
        ("b_1", (1, 2), "value", "color of"),
    ],
)
def test_what_is_wrong_changes_nothing(path, text, color, code, words):
    with LabelStore(path) as store:
        with pytest.raises(MapFileError) as refused:
            store.set_color(text, color)
        assert refused.value.code == code
        assert words in str(refused.value)
        assert not store.dirty


def test_another_owner_is_named(path):
    with LabelStore(path, owner_info={"node": "/owner"}), LabelStore(path) as other:
        with pytest.raises(MapFileError) as refused:
            other.set_color("a_1", (7, 7, 7))
        assert refused.value.code == "owned"


def test_fixed_labels_say_why(path):
    why = MapFileError("save", path, "the folder is read-only", "")
    with pytest.raises(MapFileError) as refused:
        FixedLabels(MapFile(path), path, why).set_color("a_1", (1, 2, 3))
    assert refused.value is why

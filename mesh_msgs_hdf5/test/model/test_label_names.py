"""The texts of labels: what may be one, and its path in a map."""
import json
from pathlib import Path

import h5py
import numpy as np
import pytest

from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.label_names import check_label, label_path
from mesh_msgs_hdf5.model.mesh import Label, Mesh

# the cases that messages and RViz are held to as well
CASES = Path(__file__).resolve().parents[3] / "mesh_msgs/test/label_names.json"
CASES = {case["name"]: case for case in json.loads(CASES.read_text("utf-8"))}
USABLE = [case["label"] for case in CASES.values() if case["usable"]]


@pytest.mark.parametrize("name", CASES)
def test_what_may_name_a_label(name):
    text = CASES[name]["label"]
    if CASES[name]["usable"]:
        check_label("/a.h5", text)
        return
    with pytest.raises(MapFileError) as refused:
        check_label("/a.h5", text)
    assert refused.value.code == "label" and len(str(refused.value)) < 300
    assert str(refused.value).isprintable() and "name it like tree_1" in str(refused.value)


@pytest.mark.parametrize("text", ["", "a\udcff", "x" * 10_000_000], ids=["none", "bytes", "long"])
def test_texts_that_are_no_labels(text):
    with pytest.raises(MapFileError) as refused:
        check_label("/a.h5", text)
    assert refused.value.code == "label" and len(str(refused.value)) < 300


@pytest.mark.parametrize("text", USABLE + ["tree_..", "._", "_."])
def test_texts_of_labels_never_become_paths(text):
    group, dataset, _ = label_path(text)
    for name in (group, dataset):
        assert name and "/" not in name and name not in (".", "..")


def test_all_of_them_come_back_from_map_and_journal(tmp_path):
    path = tmp_path / "a.h5"
    mesh = Mesh(np.eye(3, dtype="f4"), np.array([[0, 1, 2]], "u4"))
    mesh.labels = {text: Label(np.array([0], "u4")) for text in USABLE[::2]}
    MapFile.write(path, mesh)
    with LabelStore(path) as store:
        for text in USABLE[1::2]:
            store.set(text, np.array([0], "u4"))
    with LabelStore(path) as store:
        assert set(store.names()) == set(USABLE)
    assert set(MapFile(path).label_names()) == set(USABLE[::2])
    assert MapFile(path).label(USABLE[0]).faces.tolist() == [0]


@pytest.mark.parametrize(
    "group, attribute, shown",
    [("tree\u202e", None, "'tree\\u202e_7'"), ("tree", "\ufefftree_7", "'\\ufefftree_7'")],
)
def test_a_label_of_others_that_is_none_is_named_with_its_place(tmp_path, group, attribute, shown):
    path = tmp_path / "a.h5"
    mesh = Mesh(np.eye(3, dtype="f4"), np.array([[0, 1, 2]], "u4"))
    mesh.labels = {"good_1": Label(np.array([0], "u4"))}
    MapFile.write(path, mesh)
    with h5py.File(path, "r+") as file:
        labels = file["mesh/labels"]
        labels[group + "/7"] = np.array([0], "u4")
        if attribute:
            labels[group + "/7"].attrs["label"] = attribute
    for ask in (MapFile.label_names, MapFile.read):
        with pytest.raises(MapFileError) as refused:
            ask(MapFile(path, strict=True))
        text = str(refused.value)
        assert refused.value.code == "label" and text.isprintable()
        assert "label " + shown in text and "in this file with h5py" in text
        assert "(of the dataset /mesh/labels/tree" in text and "/7) contains U+" in text
    assert MapFile(path).label("good_1").faces.tolist() == [0]
    # all but labels may be saved, and those stay as they are
    MapFile(path).update(Edit(vertex_costs={"a": np.ones(3)}))
    assert MapFile(path).vertex_costs("a").tolist() == [1, 1, 1]
    with h5py.File(path, "r") as file:
        there = file["mesh/labels/%s/7" % group]
        assert there[()].tolist() == [0] and there.attrs.get("label") == attribute
    # an edit of labels gives it the name that it is read by
    MapFile(path).update(Edit(labels={"new_1": Label(np.array([0], "u4")), "good_1": None}))
    for file in (MapFile(path), MapFile(path, strict=True)):
        assert sorted(file.labels()) == sorted(
            ["new_1", attribute.replace("\ufeff", "_")] if attribute else ["new_1", "tree__7"]
        )

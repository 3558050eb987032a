"""Labels as JSON and CSV: nothing is lost, and wrong files are refused with the place."""
import csv
import json
from pathlib import Path

import numpy as np
import pytest

from mesh_msgs_hdf5.labels.label_tables import (
    color_text,
    labels_to_csv,
    labels_to_json,
    parse_color,
    read_labels,
)
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label

FACES = 1000
TEXTS = [
    "tree_1",
    "Grün und_weich",
    'a,"b";c_2',
    "free text",
    "樹_木_3",
    "= SUM(A1)",
    "  blank ",
    "_",
]


def some_labels(seed=0):
    rng = np.random.default_rng(seed)
    labels = {}
    for i, text in enumerate(TEXTS):
        faces = rng.permutation(FACES)[: rng.integers(1, 400)]
        if i % 3 == 0:
            faces = np.sort(faces)
        color = None if i % 2 else tuple(int(c) for c in rng.integers(0, 256, 3))
        labels[text] = Label(faces.astype(np.uint32), color)
    labels["all_0"] = Label(np.arange(FACES, dtype=np.uint32))
    labels["none_0"] = Label(np.zeros(0, dtype=np.uint32), (1, 2, 3))
    return labels


def plain(labels):
    return [(text, label.faces.tolist(), label.color) for text, label in labels.items()]


@pytest.mark.parametrize("suffix", ["json", "csv"])
def test_a_round_trip_is_the_identity(tmp_path, suffix):
    labels = some_labels()
    path = tmp_path / ("labels." + suffix)
    text = labels_to_json(labels, "u-u", FACES) if suffix == "json" else labels_to_csv(labels)
    path.write_text(text, encoding="utf-8")
    uuid, back = read_labels(path, FACES)
    assert uuid == ("u-u" if suffix == "json" else None)
    assert plain(back) == plain(labels)
    assert all(label.faces.dtype == np.uint32 for label in back.values())
    path.write_text(text, encoding="utf-8-sig")  # as spreadsheets save it
    assert plain(read_labels(path, FACES)[1]) == plain(labels)
    assert plain(read_labels(path, FACES)[1]) == plain(read_labels(str(path), FACES)[1])


def test_the_json_is_what_the_documentation_says():
    content = json.loads(labels_to_json({"tree_1_b": Label(np.uint32([5, 2]), (1, 2, 3))}, "u", 9))
    assert content == {
        "format": "mesh_labels",
        "version": 1,
        "uuid": "u",
        "faces": 9,
        "labels": [
            {
                "label": "tree_1_b",
                "class": "tree",
                "instance": "1_b",
                "color": [1, 2, 3],
                "faces": [5, 2],
            }
        ],
    }
    assert json.loads(labels_to_json({}, "u", 9))["labels"] == []


def test_the_csv_is_what_the_documentation_says():
    labels = {"tree_1": Label(np.uint32([5, 6, 7, 2]), (255, 0, 16)), "x": Label(np.uint32([]))}
    rows = list(csv.reader(labels_to_csv(labels).splitlines()))
    assert rows == [
        ["label", "class", "instance", "color", "first_face", "last_face"],
        ["tree_1", "tree", "1", "#ff0010", "5", "7"],
        ["tree_1", "tree", "1", "#ff0010", "2", "2"],
        ["x", "x", "", "", "", ""],
    ]


@pytest.mark.parametrize(
    "text,expected",
    [
        ("label,first_face\na_1,3\na_1,1", {"a_1": ([3, 1], None)}),
        ("first_face;label;last_face\r\n3;a_1;4\r\n", {"a_1": ([3, 4], None)}),
        ("Label,Color,First_Face\na_1,,3\na_1,#0000ff,4\n\n", {"a_1": ([3, 4], (0, 0, 255))}),
        ("label,first_face,comment\nb,,x\n", {"b": ([], None)}),
    ],
)
def test_csv_of_other_programs(tmp_path, text, expected):
    (tmp_path / "a.csv").write_bytes(text.encode())
    found = read_labels(tmp_path / "a.csv", FACES)[1]
    assert {k: (v.faces.tolist(), v.color) for k, v in found.items()} == expected


HEAD = "label,color,first_face,last_face\n"
JSON = '{"format": "mesh_labels", "version": 1, "labels": %s}'


@pytest.mark.parametrize(
    "text,code,words",
    [
        ("", "empty", ""),
        ("x,y\n", "format", "line 1"),
        (HEAD + "a,,1,2\nb,,x,3", "format", "line 3"),
        (HEAD + "a,,1,1000", "index", "line 2: faces 1 to 1000"),
        (HEAD + "a,,7,6", "index", "line 2"),
        (HEAD + "a,,-1,6", "index", "line 2"),
        (HEAD + "a,,0,999\na,,0,999", "format", "line 3: label a has faces twice"),
        (HEAD + "a,red,1,2", "format", "line 2"),
        (HEAD + "a,#ff0000,1,2\na,#00ff00,3,4", "format", "two colors"),
        (HEAD + "a/b,,1,2", "label", "slash"),
        (HEAD + '"a,,1,2', "format", "line 2"),
        ("{", "format", "no JSON"),
        ("[]", "format", "mesh_labels"),
        ("[" * 100000, "format", "no JSON"),
        (JSON.replace("1", "2") % "[]", "format", "version 2"),
        (JSON % "3", "format", "labels[0]"),
        (JSON % '[{"label": "a", "faces": [1, true]}]', "index", "faces[1] is True"),
        (JSON % '[{"label": "a", "faces": [1.5]}]', "index", "faces[0]"),
        (JSON % '[{"label": "a", "faces": [1000]}]', "index", "1000"),
        (JSON % '[{"label": "a", "faces": [-1]}]', "index", "-1"),
        (JSON % '[{"label": "a", "faces": []}, {"label": "a", "faces": []}]', "format", "twice"),
        (JSON % '[{"label": "a", "faces": [], "color": [1, 2]}]', "format", "color"),
        (JSON % '[{"label": "a", "faces": [], "color": [1, 2, 256]}]', "value", "color"),
        (JSON % '[{"label": "", "faces": []}]', "label", ""),
        (JSON % "[]}" + '"faces": 3', "format", "no JSON"),
        (JSON[:-1] % "[]" + ', "faces": 999}', "index", "999"),
    ],
)
def test_wrong_files_are_refused(tmp_path, text, code, words):
    (tmp_path / "a.txt").write_bytes(text.encode())
    with pytest.raises(MapFileError) as error:
        read_labels(tmp_path / "a.txt", FACES)
    assert error.value.code == code and words in str(error.value), error.value


def test_a_file_that_is_no_text_is_refused(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"label,first_face\n\xff")
    with pytest.raises(MapFileError, match="byte 17 is no UTF-8"):
        read_labels(tmp_path / "a.csv", FACES)


def test_colors():
    for text, color in (
        ("#ff0080", (255, 0, 128)),
        ("FF0080", (255, 0, 128)),
        ("255, 0,128", (255, 0, 128)),
        ("none", None),
        ("", None),
    ):
        assert parse_color(text) == color
        assert color is None or parse_color(color_text(color)) == color
    for text in ("red", "#ff00", "1,2", "1,2,256", "-1,2,3", "#ff00zz"):
        with pytest.raises(ValueError):
            parse_color(text)


# Cases that RViz has to read in the same way: rviz_mesh_plugin/test/label_editing.
CORPUS = json.loads(
    (Path(__file__).resolve().parents[3] / "mesh_msgs/test/label_files.json").read_text("utf-8")
)


@pytest.mark.parametrize("case", CORPUS, ids=[case["name"] for case in CORPUS])
def test_the_files_that_rviz_reads_too(tmp_path, case):
    path = tmp_path / "labels"
    path.write_bytes(case["text"].encode(case.get("encoding", "utf-8")))
    if "refused" in case:
        with pytest.raises(MapFileError) as error:
            read_labels(path, 10)
        assert case["refused"] in str(error.value)
        return
    uuid, labels = read_labels(path, 10)
    assert uuid == case.get("uuid")
    found = {
        text: {"faces": sorted(label.faces.tolist()), "color": label.color and list(label.color)}
        for text, label in labels.items()
    }
    assert found == case["labels"]
    if case.get("written"):
        written = labels_to_json(labels, uuid, 10) if uuid else labels_to_csv(labels)
        assert written == case["text"]


@pytest.mark.parametrize(
    "run, words",
    [
        ("500,501", "faces 500 to 501, but the mesh has faces 0 to 9 (take the map that they"),
        ("4,3", "faces 4 to 3 run backwards (the first comes before the last)"),
    ],
)
def test_hints_about_runs_fit_what_is_wrong(tmp_path, run, words):
    (tmp_path / "a.csv").write_text("label,first_face,last_face\ntree_1,%s\n" % run)
    with pytest.raises(MapFileError) as refused:
        read_labels(tmp_path / "a.csv", 10)
    assert words in str(refused.value)

"""The labels of label_manager 1.x: read as they were meant, and nothing else is read."""
import os

import numpy as np
import pytest

from mesh_msgs_hdf5.label_manager.dat_files import dat_uuids, parsed, read_dat_folder
from mesh_msgs_hdf5.model.errors import MapFileError

UUID = "7f3c1f1e-1111-4222-8333-444455556666"


@pytest.fixture
def folder(tmp_path):
    """What the released program leaves, and a few things beside it."""
    first = tmp_path / UUID
    first.mkdir()
    (first / "tree_1.dat").write_bytes(b",5,3,9")  # appended to a new file
    (first / "tree_2.dat").write_bytes(b"0,1,2")
    (first / "free text.dat").write_bytes(b"7")
    (tmp_path / "mesh").mkdir()
    (tmp_path / "mesh" / "a_1.dat").write_bytes(b"1")
    (tmp_path / "empty").mkdir()
    (tmp_path / "loose.dat").write_bytes(b"1")
    return tmp_path


def test_the_labels_of_each_geometry(folder):
    assert dat_uuids(folder) == sorted([UUID, "mesh"])
    found = read_dat_folder(folder, UUID)
    assert found.uuid == UUID and found.problems == []
    labels = {text: faces.tolist() for text, faces in found.labels.items()}
    assert labels == {"free text": [7], "tree_1": [3, 5, 9], "tree_2": [0, 1, 2]}
    assert {faces.dtype for faces in found.labels.values()} == {np.dtype(np.uint32)}


def test_the_comma_that_the_released_program_puts_first_is_no_face():
    """Defect 8: its own reading makes face 0 of it."""
    assert parsed("x.dat", b",5,3").tolist() == [3, 5]
    assert parsed("x.dat", b",0,3").tolist() == [0, 3]


@pytest.mark.parametrize(
    "data,faces",
    [
        (b"", []),
        (b",", []),
        (b"\n", []),
        (b"5", [5]),
        (b",5", [5]),
        (b"5,5,1,5", [1, 5]),
        (b"007", [7]),
        (b"1,2\r\n", [1, 2]),
        (b"4294967295", [4294967295]),
    ],
)
def test_faces(data, faces):
    assert parsed("x.dat", data).tolist() == faces


@pytest.mark.parametrize(
    "data,words",
    [
        (b"1,,2", "',' at byte 2"),
        (b"1,2,", "',' at byte 4"),
        (b",,1", "',' at byte 2"),
        (b"1,-2", "',' at byte 2"),
        (b"-2", "'-' at byte 1"),
        (b"1, 2", "',' at byte 2"),
        (b"1 2", "'2' at byte 3"),
        (b"1\n2", "'2' at byte 3"),
        (b"1,2;3", "';' at byte 4"),
        (b"1,2.5", "'.' at byte 4"),
        (b"0x10", "'x' at byte 2"),
        (b"1,\xd9\xa3", "',' at byte 2"),
        (b"1,2\0", "'\\x00' at byte 4"),
        (b"1,4294967296", "face index 1, counted from 0, is 4294967296"),
        (b"1,2," + b"9" * 5000, "face index 2, counted from 0, is 99999999999999999999,"),
    ],
)
def test_what_is_no_face_is_named_with_its_place(data, words):
    with pytest.raises(MapFileError) as refused:
        parsed("a/x.dat", data)
    assert refused.value.path == "a/x.dat" and words in str(refused.value)


def test_a_large_file_is_read_fast_enough_to_be_read():
    faces = np.random.default_rng(1).permutation(300_000)
    text = ",".join(map(str, faces)).encode()
    np.testing.assert_array_equal(parsed("x.dat", b"," + text), np.arange(300_000))


def test_what_is_no_label_is_a_problem_and_the_rest_is_read(folder):
    place = folder / UUID
    (place / "bad.dat").write_bytes(b"1;2")
    (place / "notes.txt").write_bytes(b"1")
    (place / ".dat").write_bytes(b"1")
    (place / "..dat").write_bytes(b"1")
    os.mkdir(place / "inner.dat")
    os.mkfifo(place / "pipe_1.dat")
    with open(os.fsencode(place) + b"/\xff_1.dat", "wb") as stream:
        stream.write(b"1")
    found = read_dat_folder(folder, UUID)
    assert sorted(found.labels) == ["free text", "tree_1", "tree_2"]
    words = ["bad.dat: ';' at byte 2", "notes.txt: it is no .dat file", "/.dat: label ''"]
    words += ["..dat: label '.'", "inner.dat: it is no regular", "pipe_1.dat: it is no regular"]
    words += ["udcff_1.dat: label"]
    assert len(found.problems) == len(words)
    for word in words:
        assert sum(word in problem for problem in found.problems) == 1, word


def test_links_are_not_followed(folder, tmp_path_factory, monkeypatch):
    outside = tmp_path_factory.mktemp("outside")
    (outside / "secret_1.dat").write_bytes(b"42")
    os.symlink(outside, folder / "linked")
    os.symlink(outside / "secret_1.dat", folder / UUID / "secret_1.dat")
    assert dat_uuids(folder) == sorted([UUID, "mesh"])
    found = read_dat_folder(folder, UUID)
    assert "secret_1" not in found.labels
    assert len(found.problems) == 1 and "it is a link, which is not followed" in found.problems[0]
    with pytest.raises(MapFileError):
        read_dat_folder(folder, "linked")
    with monkeypatch.context() as patch:  # it has become a link after that look
        patch.setattr(
            "mesh_msgs_hdf5.label_manager.dat_files.dat_uuids", lambda _folder: ["linked"]
        )
        with pytest.raises(MapFileError):
            read_dat_folder(folder, "linked")
    os.symlink(folder, outside / "here")  # the folder itself is the user's choice
    assert dat_uuids(outside / "here") == sorted([UUID, "mesh"])


@pytest.mark.parametrize("uuid", ["..", ".", "", "/etc", "../mesh", "mesh/", "other", "a\0b"])
def test_a_uuid_is_never_a_path(folder, uuid):
    inner = folder / "mesh"
    (folder / "a_1.dat").write_bytes(b"1")
    with pytest.raises(MapFileError) as refused:
        read_dat_folder(inner, uuid)
    assert refused.value.code == "missing" and "there are labels of: none" in str(refused.value)


@pytest.mark.parametrize(
    "name,code", [("no", "missing"), ("loose.dat", "missing"), ("a\0", "name")]
)
def test_a_folder_that_cannot_be_read(folder, name, code):
    with pytest.raises(MapFileError) as refused:
        dat_uuids(os.path.join(str(folder), name))
    assert refused.value.code == code

"""File names that strangers give: inside the folder, or one error."""
import os

import pytest

from mesh_msgs_hdf5.files.confine import confined_path
from mesh_msgs_hdf5.model.errors import MapFileError


def short(text):
    """The name of a test; some texts are of 10 MB."""
    return ascii(text[:30]) if isinstance(text, str) else None


@pytest.fixture
def folder(tmp_path):
    """A folder with a map, a folder below and links of every kind; a secret beside it."""
    (tmp_path / "secret.h5").write_text("secret")
    (tmp_path / "maps_of_others").mkdir()
    (tmp_path / "maps_of_others" / "a.h5").write_text("secret")
    folder = tmp_path / "maps"
    (folder / "floor 2").mkdir(parents=True)
    (folder / "a.h5").write_text("a map")
    (folder / "floor 2" / "Büro.h5").write_text("a map")
    (folder / "notes.txt").write_text("no map")
    (folder / "inner.h5").symlink_to("a.h5")
    (folder / "out.h5").symlink_to("../secret.h5")
    (folder / "new_out.h5").symlink_to(tmp_path / "new.h5")
    (folder / "up").symlink_to("..")
    (folder / "loop.h5").symlink_to("loop.h5")
    (folder / "text.h5").symlink_to("notes.txt")
    (folder / "folder.h5").mkdir()
    os.mkfifo(folder / "pipe.h5")
    return folder


REFUSED = {
    "../../etc/passwd": "..",
    "../secret.h5": "..",
    "..": "..",
    "floor 2/../../secret.h5": "..",
    "floor 2/../a.h5": "..",
    "/etc/passwd": "does not end with .h5",
    "/etc/passwd.h5": "leads out of the folder",
    "//etc/passwd.h5": "leads out of the folder",
    "/": "names no file",
    "": "names no file",
    ".": "names no file",
    "a.h5/": "names no file",
    "floor 2": "does not end with .h5",
    ".h5": "does not end with .h5",
    "a": "does not end with .h5",
    "a.h5.txt": "does not end with .h5",
    "notes.txt": "does not end with .h5",
    ";id;": "does not end with .h5",
    "$(id).sh": "does not end with .h5",
    "out.h5": "leads out of the folder",
    "new_out.h5": "leads out of the folder",
    "up/secret.h5": "leads out of the folder",
    "up/maps_of_others/a.h5": "leads out of the folder",
    "text.h5": "leads to a file that does not end with .h5",
    "folder.h5": "no regular file",
    "pipe.h5": "no regular file",
    "loop.h5": "no regular file",
    "a.h5\0": "control character",
    "a\0.h5": "control character",
    "a\n.h5": "control character",
    "a\x1b[2J.h5": "control character",
    "a\u202e5h.h5": "control character",
    "a\udcff.h5": "UTF-8",
    "x" * 253 + ".h5": "too long",
    "ö" * 127 + ".h5": "too long",
    "x/" * 600 + "a.h5": "too long",
    "x" * 10_000_000: "too long",
}


@pytest.mark.parametrize("must_exist", [True, False, None])
@pytest.mark.parametrize("name", REFUSED, ids=short)
def test_names_that_are_refused(folder, name, must_exist):
    with pytest.raises(MapFileError) as refused:
        confined_path(folder, name, must_exist=must_exist)
    error = refused.value
    assert error.code == "name" and REFUSED[name] in error.message and error.hint
    assert error.path == str(folder) and len(str(error)) < 400 and str(error).isprintable()
    assert "secret" not in error.message.replace(repr(name), "")


@pytest.mark.parametrize("name", ["a.h5", "inner.h5", "./a.h5", "floor 2//Büro.h5", "up/maps/a.h5"])
def test_files_that_are_there(folder, name):
    path = confined_path(folder, name, must_exist=True)
    assert path == confined_path(folder, name) == os.path.realpath(path)
    assert os.path.samefile(path, folder / name)
    with pytest.raises(MapFileError) as refused:
        confined_path(folder, name, must_exist=False)
    assert refused.value.code == "exists" and refused.value.path == path


@pytest.mark.parametrize("name", ["new.h5", "floor 2/x.H5", ";id;.h5", "-rf *.h5", "😀.h5", "~.h5"])
def test_files_that_are_not_there(folder, name):
    path = confined_path(folder, name, must_exist=False)
    assert path == confined_path(folder, name) == str(folder / name)
    with pytest.raises(MapFileError) as refused:
        confined_path(folder, name, must_exist=True)
    assert refused.value.code == "missing"


def test_an_absolute_name_may_lead_into_the_folder(folder):
    assert confined_path(folder, str(folder / "a.h5")) == str(folder / "a.h5")
    assert confined_path("/", str(folder / "a.h5")) == str(folder / "a.h5")
    with pytest.raises(MapFileError):
        confined_path(folder, str(folder) + "_of_others/a.h5")


def test_the_folder_may_be_a_link_itself(folder, tmp_path):
    (tmp_path / "link").symlink_to(folder)
    assert confined_path(tmp_path / "link", "a.h5") == str(folder / "a.h5")
    with pytest.raises(MapFileError):
        confined_path(tmp_path / "link", "out.h5")


@pytest.mark.parametrize("name", ["nowhere/a.h5", "a.h5/b.h5"])
def test_the_folder_of_a_new_file_must_be_there(folder, name):
    with pytest.raises(MapFileError) as refused:
        confined_path(folder, name)
    assert refused.value.code == "missing"


def test_other_suffixes(folder):
    assert confined_path(folder, "notes.txt", (".h5", ".txt")) == str(folder / "notes.txt")
    with pytest.raises(MapFileError, match="does not end with .ply or .obj"):
        confined_path(folder, "a.h5", (".ply", ".obj"))

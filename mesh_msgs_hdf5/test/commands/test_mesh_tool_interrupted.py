"""The command mesh_tool, interrupted: what it says of files is what they are."""
import os
import shutil
import time

import pytest
from mesh_writers import SQUARE, ply, xyz

from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.processes.zygote import Child


@pytest.fixture
def square(tmp_path):
    (tmp_path / "square.ply").write_bytes(ply(xyz(SQUARE), [[0, 1, 2, 3]]))
    path = tmp_path / "square.h5"
    assert main(["import", str(tmp_path / "square.ply"), str(path), "-q"]) == 0
    return path


@pytest.fixture
def interrupt(monkeypatch):
    """A function of a path: as soon as it is another file, Ctrl+C reaches who waits for that."""

    def when_replaced(path):
        def number():
            return os.stat(path).st_ino if os.path.exists(path) else None

        before, wait = number(), Child.wait_for_answer

        def wait_for_answer(self, timeout):
            while not self._poll.poll(0):
                if number() != before:
                    raise KeyboardInterrupt
                time.sleep(0.0002)
            if number() != before:
                raise KeyboardInterrupt
            wait(self, timeout)

        monkeypatch.setattr(Child, "wait_for_answer", wait_for_answer)

    return when_replaced


@pytest.mark.parametrize(
    "words",
    [
        ["repack", "{}"],
        ["repack", "{}", "{out}"],
        ["parts", "add", "{}", "other", "{copy}"],
        ["scans", "delete", "{}", "position_00000"],
        ["labels", "rename", "{}", "a", "b"],
    ],
)
def test_after_the_file_was_replaced_it_says_so(square, tmp_path, interrupt, capsys, words):
    out, copy, table = (str(tmp_path / name) for name in ("out.h5", "copy.h5", "a.csv"))
    shutil.copy(square, copy)
    (tmp_path / "a.csv").write_text("label,first_face,last_face\na,0,1\n")
    (tmp_path / "a.pcd").write_text(
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
        "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3\n"
    )
    assert main(["labels", "import", str(square), table, "-q"]) == 0
    assert main(["scans", "add", str(square), str(tmp_path / "a.pcd"), "-q"]) == 0
    words = [word.format(square, out=out, copy=copy) for word in words]
    saved = out if out in words else str(square)
    interrupt(saved)
    capsys.readouterr()
    assert main(words) == 130
    text = "mesh_tool: error: interrupted, but saved already: %s\n" % saved
    assert capsys.readouterr().err == text


def test_before_that_nothing_was_saved(square, tmp_path, monkeypatch, capsys):
    """Also a process that was just going to do it does not: it has ended."""

    def wait_for_answer(self, timeout):
        raise KeyboardInterrupt

    before = square.stat()
    monkeypatch.setattr(Child, "wait_for_answer", wait_for_answer)
    assert main(["repack", str(square)]) == 130
    assert capsys.readouterr().err == "mesh_tool: error: interrupted, nothing was saved\n"
    time.sleep(0.3)
    assert square.stat().st_ino == before.st_ino

"""A crash in native code fails the test that it happens in, by its name, and no other."""
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[4]
EXTRAS = ROOT / "mesh_msgs/cmake/mesh_msgs-extras.cmake"
SUMMARY = ROOT / ".ci/summary.py"
pytestmark = pytest.mark.skipif(not SUMMARY.exists(), reason="not part of an installation")

CRASHES = """
import ctypes
import os
def test_before():
    pass
def test_crash():
    ctypes.string_at(0)
def test_between():
    pass
def test_exit():
    os._exit(0)
def test_after():
    pass
"""
GOOD = "def test_good():\n    pass\n"


def test_the_other_tests_run_and_the_summary_names_what_crashed(tmp_path):
    pytest.importorskip("xdist")
    (worker,) = re.findall(r'set\(worker "(-n .*)"\)', EXTRAS.read_text())
    for name, text in (("a/test_good.py", GOOD), ("b/test_bad.py", CRASHES), ("c/test_c.py", GOOD)):
        path = tmp_path / "tests" / name
        path.parent.mkdir(parents=True)
        path.write_text(text)
    results = tmp_path / "results/package/pytest-tests.xml"
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *worker.split()]
    command += ["-W", "error", "-W", "ignore::DeprecationWarning"]
    command += ["--rootdir", str(tmp_path), "--junit-xml", str(results), str(tmp_path / "tests")]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=60)
    assert done.returncode == 1, done.stdout.decode()
    told = subprocess.run([str(SUMMARY), str(results.parents[1])], stdout=subprocess.PIPE)
    lines = told.stdout.decode().splitlines()
    assert lines[-1] == "5 passed, 2 failed, 0 skipped"
    for name in ("test_crash", "test_exit"):
        assert any(re.match(rf"FAILED: package: .*test_bad\.{name}$", line) for line in lines)

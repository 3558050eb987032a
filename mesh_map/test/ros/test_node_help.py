"""The node mesh_map says what it does, whatever it is doing meanwhile."""

import os
import subprocess
import sys
from pathlib import Path

NODE = Path(__file__).resolve().parents[2] / "nodes" / "mesh_map"
# As on a busy machine: what is imported beside comes after the help was printed.
SLOW = """
import sys, time
class Slow:
    def find_spec(self, name, path=None, target=None):
        if name == "mesh_map.ros":
            time.sleep(2.0)
sys.meta_path.insert(0, Slow())
"""


def test_help_waits_for_modules_that_are_being_imported(tmp_path):
    (tmp_path / "sitecustomize.py").write_text(SLOW)
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, str(NODE), "--help"],
        env=dict(os.environ, PYTHONPATH=path),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
        timeout=60,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "Publishes a mesh map" in done.stdout
    assert "$(rospack find mesh_map)/README.md" in done.stdout

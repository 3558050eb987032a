"""A command that takes too long is told and ended, with all it has started."""
import os
import subprocess
import time
from pathlib import Path

import pytest

LIMITED = Path(__file__).resolve().parents[4] / ".ci/limited.py"

pytestmark = pytest.mark.skipif(not LIMITED.exists(), reason="not part of an installation")


def run(seconds, *command):
    return subprocess.run(
        [str(LIMITED), str(seconds), *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
        timeout=60,
    )


@pytest.mark.parametrize("status", [0, 3])
def test_the_exit_code_is_that_of_the_command(status):
    done = run(30, "sh", "-c", f"echo out; exit {status}")
    assert (done.returncode, done.stdout, done.stderr) == (status, "out\n", "")


def test_what_still_runs_is_told_and_ended(tmp_path):
    pids = tmp_path / "pids"
    script = f"sleep 61.25 & echo $! >{pids}; echo $$ >>{pids}; wait"
    done = run(1, "sh", "-c", script)
    assert done.returncode == 124
    assert "After 1 s these still ran:" in done.stderr and "sleep 61.25" in done.stderr
    end = time.monotonic() + 20.0
    left = [int(line) for line in pids.read_text().split()]
    while left and time.monotonic() < end:
        left = [pid for pid in left if os.path.exists(f"/proc/{pid}/cmdline")]
        left = [pid for pid in left if Path(f"/proc/{pid}/cmdline").read_bytes()]
        time.sleep(0.05)
    assert left == []

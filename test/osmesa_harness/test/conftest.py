"""What the Python tests share: the scripts, the programs built for them, and an environment."""

import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Callable, Dict, List, Optional

import pytest

from osmesa_harness.back_ends import shim_folder

_PACKAGE = Path(__file__).resolve().parent.parent
_SECONDS = 60.0

Script = Callable[..., List[str]]


@pytest.fixture
def script() -> Script:
    """Makes a command line of a script of this package and its arguments."""

    def command(name: str, *arguments: str) -> List[str]:
        return [sys.executable, str(_PACKAGE / "scripts" / name), *arguments]

    return command


@pytest.fixture
def program() -> Callable[[str], str]:
    """The path of a test program by name."""
    folder = os.environ.get(
        "OSMESA_HARNESS_PROGRAMS", os.path.join(shim_folder(os.environ), "osmesa_harness")
    )
    return lambda name: os.path.join(folder, name)


@pytest.fixture
def environment(tmp_path: Path) -> Dict[str, str]:
    """The present environment, with a home of its own and nothing left of a test run around it."""
    names = [name for name in os.environ if name.startswith(("OSMESA_", "LD_PRELOAD", "FAIL_BY"))]
    changed = {key: value for key, value in os.environ.items() if key not in names}
    changed["HOME"] = str(tmp_path)
    changed["ROS_LOG_DIR"] = str(tmp_path / "log")
    return changed


@pytest.fixture
def wait_for() -> Callable[..., None]:
    """Waits until something is true; fails after a minute, or where the process ends first."""

    def wait(done: Callable[[], bool], process: "Optional[subprocess.Popen[str]]" = None) -> None:
        deadline = time.monotonic() + _SECONDS
        while not done():
            assert time.monotonic() < deadline, "did not happen within a minute"
            assert process is None or process.poll() is None, f"ended early: {process.returncode}"
            time.sleep(0.02)

    return wait


def _status(pid: int) -> List[str]:
    """State letter and parent's id; empty where there is no such process."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[:2]
    except (FileNotFoundError, ProcessLookupError):
        return []


@pytest.fixture
def is_running() -> Callable[[int], bool]:
    """Whether a process is there and has not ended."""
    # A zombie is done; in a container nobody may ever collect it.
    return lambda pid: _status(pid)[:1] not in ([], ["Z"])


@pytest.fixture
def children() -> Callable[[int], List[int]]:
    """The processes that another one has started itself."""

    def of(parent: int) -> List[int]:
        everybody = [int(path.name) for path in Path("/proc").iterdir() if path.name.isdigit()]
        return [pid for pid in everybody if _status(pid)[1:] == [str(parent)]]

    return of

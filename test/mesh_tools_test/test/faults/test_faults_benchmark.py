"""The benchmark of faults sees what is wrong, and real processes pass it."""

import contextlib
import json
import math
import subprocess
from pathlib import Path

import numpy as np
import pytest
from mesh_tools_test.faults import cases_ros
from mesh_tools_test.faults.record import Record
from mesh_tools_test.faults.verdicts import Run, table

SCRIPT = Path(__file__).resolve().parents[2] / "benchmark/faults.py"
GOOD = Run(0.1, 0, 1.0, "SUCCESS")


def test_real_processes(tmp_path):
    output = tmp_path / "found.json"
    command = [str(SCRIPT), "--faults", "1", "--json", str(output)]
    command += ["--only", "guard", "stuck", "map"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    text = done.stdout.decode()
    found = {name: Run(**run) for name, (run,) in json.loads(output.read_text()).items()}
    assert {name: run.answer for name, run in found.items()} == {
        "guard killed": "SUCCESS",
        "guard stopped": "SUCCESS",
        "map reloaded": "MAP_ERROR",
    }, (
        text + done.stderr.decode()
    )
    assert all(run.stop_time < 60.0 and not run.moves and run.room > 0 for run in found.values())


@pytest.fixture
def record(tmp_path):
    """Commands (s, speed), after which the recorder goes on."""

    with contextlib.ExitStack() as stack:

        def recorded(*commands):
            path = tmp_path / "record"
            path.write_text("".join("command %r %r\n" % command for command in commands))
            found = Record(path)
            stack.callback(found.close)
            found.update()
            return found

        yield recorded


@pytest.mark.parametrize(
    ("commands", "stop"),
    (
        ([(0.9, 1.0), (1.3, 0.0), (1.4, 0.0)], 1.3),
        ([(0.9, 0.0), (1.3, 0.0)], 1.0),  # it stood already
        ([(0.9, 1.0), (1.1, 0.0), (1.2, 0.5), (1.3, 0.0)], 1.3),  # one came out of order
        ([(0.9, 1.0), (1.1, 0.0), (1.9, 0.5)], 1.1),  # it moves once more
        ([(0.9, 0.0), (1.1, 0.5), (1.3, 0.5)], math.inf),
        ([(0.9, 1.0)], math.inf),
        ([], math.inf),
    ),
)
def test_when_the_robot_was_told_to_stand(record, commands, stop):
    assert record(*commands).stop_after(1.0) == stop


def test_what_is_noted_half_is_read_whole(record, tmp_path):
    found = record((1.0, 0.5), (1.5, 0.0), (2.0, 0.25))
    assert found.moving
    assert [found.moves_between(1.2, end) for end in (2.0, 2.5)] == [0, 1]
    with open(tmp_path / "record", "a") as file:
        file.write("pose 2.5 3.0 4")
        file.flush()
        found.update()
        assert np.isnan(found.position()).all()
        file.write(".5\npose 3.5 5.0 6.0\n")
    found.update()
    np.testing.assert_array_equal(found.position(), (5.0, 6.0))
    np.testing.assert_array_equal(found.positions(3.0), [(5.0, 6.0)])
    found.close()


@pytest.mark.parametrize(
    "broken",
    (
        GOOD._replace(stop_time=0.501),
        GOOD._replace(stop_time=math.inf),
        GOOD._replace(moves=1),
        GOOD._replace(room=-0.001),
        GOOD._replace(answer=""),
        GOOD._replace(remark="the drive did not begin: no answer"),
    ),
)
def test_what_is_broken(broken):
    assert not GOOD.broken and broken.broken
    lines = table({"fine": [GOOD] * 3, "faulty": [GOOD, broken, GOOD]}).splitlines()
    assert "kept: SUCCESS 3" in lines[1] and "  0.20 x " in lines[1]
    assert "BROKEN in 1: SUCCESS" in lines[2]
    assert [broken.remark in line for line in lines[3:]] == [True] * bool(broken.remark)


@pytest.mark.parametrize("over, tries", [(0, 1), (2, 3), (9, 3)])
def test_a_drive_that_was_over_at_once_is_made_again(over, tries, monkeypatch):
    missed = GOOD._replace(remark="the drive did not begin: arrived")
    runs = [missed] * over + [GOOD]
    made = []

    def run_once(stage, case):
        made.append(case)
        return runs[len(made) - 1]

    monkeypatch.setattr(cases_ros, "_run_once", run_once)
    assert cases_ros.run(None, None) == (GOOD if over < 3 else missed)
    assert len(made) == tries

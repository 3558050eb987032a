"""The benchmark of long use measures what it says, and sees memory that grows."""
import json
import subprocess
from pathlib import Path

import pytest

from mesh_tools_test.base.figures import table
from mesh_tools_test.base.programs import find_program
from mesh_tools_test.display import endurance

SCRIPT = Path(__file__).resolve().parents[2] / "benchmark/endurance.py"
MB = 1e6


def missed(part, values):
    return [figure.name for figure in endurance.figures(part, values) if not figure.keeps_floor]


def test_growth_after_the_tenth_cycle_is_seen():
    resident = {0: 100 * MB, 1: 150 * MB, 10: 200 * MB, 1000: 249 * MB}
    assert missed("cycles", {"resident": resident}) == []
    resident[1000] = 251 * MB
    assert missed("cycles", {"resident": resident}) == ["growth after 10 cycles"]


def test_growth_under_a_stream_is_seen():
    names = ("frame_median", "frame_tail", "frame_longest", "frames")
    values = {name: dict.fromkeys(range(1, 31), 1.0) for name in names}
    values["resident"] = {step: (500 + 2 * (step > 10)) * MB for step in range(31)}
    assert missed("costs", values) == []
    values["resident"] = {step: (500 + 6 * step) * MB for step in range(31)}
    assert missed("costs", values) == ["growth, last third to second"]


def test_what_is_left_of_loads_is_seen():
    values = {"resident": {0: 100 * MB, 1: 200 * MB, 6: 290 * MB}, "left": {6: 199 * MB}}
    assert missed("loads", values) == []
    values["left"][6] = 201 * MB
    assert missed("loads", values) == ["left of 6, once displays are gone"]
    values["resident"][6] = 301 * MB
    assert missed("loads", values)[0] == "shown, after 6"


@pytest.mark.skipif(find_program(endurance.PROGRAM) is None, reason="libgtest-dev was not there")
def test_the_benchmark_runs(tmp_path):
    result = tmp_path / "values.json"
    command = [str(SCRIPT), "--cycles", "10", "--minutes", "0.1", "--loads", "2"]
    command += ["--faces", "5000", "--json", str(result)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=240)
    assert done.returncode == 0, done.stderr.decode()
    values = json.loads(result.read_text())
    assert set(values) == set(endurance.FACES)
    assert set(values["cycles"]["resident"]) == {"0", "1", "10"}
    assert 1 < len(values["costs"]["resident"]) <= 31  # fewer where the machine is busy
    assert set(values["loads"]["resident"]) == {"0", "1", "2"}
    assert "growth after 10 cycles" in done.stdout.decode()
    assert "MISSED" in table(
        endurance.figures("cycles", {"resident": {0: 0, 1: 0, 10: 0, 11: 1e9}})
    )

"""The benchmark of the RViz display measures what it says, and its floors are where they belong."""
import json
import subprocess
from pathlib import Path

import pytest

from mesh_tools_test.base.figures import table
from mesh_tools_test.base.programs import find_program
from mesh_tools_test.display import rviz_benchmark

SCRIPT = Path(__file__).resolve().parents[2] / "benchmark/rviz_display.py"
KEYS = [row[1] for row in rviz_benchmark.ROWS] + ["gpu"]


def values_of(number):
    return {name: dict.fromkeys(KEYS, number) for name in rviz_benchmark.SUBJECTS}


def test_floors_hold_for_two_sizes_and_stand_once_for_each_figure():
    for faces, complete in ((2_000_000, 1000.0), (10_000_000, 6000.0), (123, None)):
        figures = rviz_benchmark.figures(values_of(2.0), faces // 2, faces)
        floors = {}
        for figure in figures:
            floors.setdefault(figure.name, []).append(figure.floor)
        assert len(floors) == len(KEYS)
        assert all(len(found) == 2 and found[1] is None for found in floors.values())
        assert floors["message to complete picture"][0] == complete
        assert floors["layer switch, CPU without drawing"][0] == (
            complete and pytest.approx(100.0 * (faces // 2) / 1e6)
        )
        assert floors["GPU buffers"][0] == pytest.approx(1.5e-6 * (40 * (faces // 2) + 12 * faces))
    assert "MISSED" not in table(rviz_benchmark.figures(values_of(2.0), 1_000_000, 2_000_000))
    assert "MISSED" in table(rviz_benchmark.figures(values_of(51.0), 1_000_000, 2_000_000))


def test_a_peer_that_was_not_run_is_left_out():
    values = values_of(1.0)
    del values["marker"], values["manual_object"]["gpu"]
    figures = rviz_benchmark.figures(values, 10, 20)
    assert [f.peer for f in figures if f.name == "GPU buffers"] == [""]
    assert {f.peer for f in figures if f.name != "GPU buffers"} == {"ManualObject"}


@pytest.mark.skipif(
    find_program(rviz_benchmark.PROGRAM) is None, reason="libgtest-dev was not there"
)
def test_the_benchmark_runs(tmp_path):
    result = tmp_path / "values.json"
    command = [str(SCRIPT), "--faces", "20000", "--quiet", "0.5", "--json", str(result)]
    command += ["--pictures", str(tmp_path / "pictures")]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=240)
    assert done.returncode == 0, done.stderr.decode()
    values = json.loads(result.read_text())["20000"]
    assert set(values) == set(rviz_benchmark.SUBJECTS)
    for name, found in values.items():
        ours = () if name == "mesh" else ("gui_", "memory_texture")
        assert {key for key in KEYS if not ours or not key.startswith(ours)} <= set(found)
        assert 0.0 < found["show_first"] <= found["show_complete"]
        assert found["gpu"] > 20000 * 12
    assert values["manual_object"]["triangles_full"] == 20000
    # The peers draw everything from wherever; their pictures are there to be compared.
    assert len(list((tmp_path / "pictures").glob("*.png"))) == 4 * len(values)
    assert "outdoor world" in done.stdout.decode()

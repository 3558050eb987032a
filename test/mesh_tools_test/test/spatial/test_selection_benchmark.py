"""The benchmark of selection measures what it says, and its floors are where they belong."""
import importlib.util
import json
import subprocess
from pathlib import Path

import pytest

from mesh_tools_test.base.figures import table
from mesh_tools_test.base.programs import find_program

SCRIPT = Path(__file__).resolve().parents[2] / "benchmark/selection.py"


def load():
    """The script as a module."""
    spec = importlib.util.spec_from_file_location("selection_benchmark", str(SCRIPT))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


selection = load()


def values_of(milliseconds, rate):
    keys = [mode + end for mode in selection.FLOORS for end in ("", "_tail", "_faces")]
    values = dict.fromkeys(keys, milliseconds)
    values.update({"scan_" + mode: 10.0 * milliseconds for mode in selection.FLOORS})
    values.update({f"gui_{edit}{end}": 1.0 for edit in selection.EDITS for end in ("", "_all")})
    values.update(frame_plain=10.0, frame_all_selected=15.0, hide_until_drawn=400.0)
    values.update(hide_until_gone=40.0)
    return dict(values, stroke_rate=rate, stroke_longest=milliseconds)


def test_floors_stand_once_for_each_mode():
    paper = selection.TABLE[0][2]
    figures = selection.figures(values_of(0.5, 100.0), paper)
    floors = {figure.name: figure.floor for figure in figures if figure.floor is not None}
    assert sorted(floors.values()) == [1.0, 2.0, 10.0, 15.0] + 10 * [50.0] + [60.0]
    assert "MISSED" not in table(figures)
    assert table(selection.figures(values_of(1.5, 100.0), paper)).count("MISSED") == 1
    assert table(selection.figures(values_of(11.0, 59.0), paper)).count("MISSED") == 4
    ratios = [f.ratio for f in figures if f.peer == "linear OpenCL scan"]
    assert ratios == pytest.approx([10.0, 10.0, 10.0])


def test_peers_that_were_not_run_are_left_out():
    values = {key: value for key, value in values_of(0.5, 100.0).items() if "scan" not in key}
    figures = [each for each in selection.figures(values, {}) if each.ratio is not None]
    assert figures and "linear OpenCL scan" not in {each.peer for each in figures}


@pytest.mark.skipif(find_program(selection.PROGRAM) is None, reason="it was not built")
def test_the_benchmark_runs(tmp_path):
    result = tmp_path / "values.json"
    command = [str(SCRIPT), "--faces", "20000", "--repeats", "9", "--json", str(result)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=200)
    assert done.returncode == 0, done.stderr.decode()
    values = json.loads(result.read_text())["20000"]
    assert set(values_of(1.0, 1.0)) - {"scan_" + mode for mode in selection.FLOORS} <= set(values)
    assert values["single_faces"] == 1.0
    assert values["radius_faces"] > 1.0 and values["box_faces"] > 1.0
    assert values["stroke_faces"] > values["radius_faces"]
    assert all(value > 0.0 for value in values.values())
    assert "outdoor world" in done.stdout.decode()

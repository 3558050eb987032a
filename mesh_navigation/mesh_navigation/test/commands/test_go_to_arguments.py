"""The arguments of the command go_to."""

import os
import subprocess
from pathlib import Path

import pytest

from mesh_navigation.commands.go_to_node import make_parser, parsed

PROGRAM = Path(__file__).resolve().parents[2] / "nodes" / "go_to"


def parse(line):
    return parsed(make_parser(), line.split())


@pytest.mark.parametrize(
    "line, place, yaw",
    [
        ("1 2 3", (1, 2, 3), None),
        ("-1 -2.5 -.5", (-1, -2.5, -0.5), None),
        ("-1e-3 1e1 -1E+1", (-1e-3, 10, -10), None),
        ("1 2 3 90", (1, 2, 3), 90),
        ("1 2 3 -90", (1, 2, 3), -90),
        ("1 2 3 --yaw -4.5e1", (1, 2, 3), -45),
        ("--yaw 0 1 2 3", (1, 2, 3), 0),
    ],
)
def test_places(line, place, yaw):
    arguments = parse(line)
    assert (arguments.x, arguments.y, arguments.z) == place
    assert arguments.yaw == yaw


def test_options():
    line = "1 2 3 --planner p --controller c --recovery a --recovery b --timeout 2 --frame odom"
    arguments = parse(f"{line} --plan-only --json -q --server other")
    assert (arguments.planner, arguments.controller, arguments.frame) == ("p", "c", "odom")
    assert (arguments.recovery, arguments.timeout) == (["a", "b"], 2.0)
    assert arguments.plan_only and arguments.json and arguments.quiet
    assert arguments.server == "other"
    assert parse("1 2 3").server == "move_base_flex"


@pytest.mark.parametrize(
    "line, words",
    [
        ("", "the following arguments are required: X, Y, Z"),
        ("1 2", "required: Z"),
        ("1 2 three", "argument Z: invalid number value: 'three'"),
        ("1 2 nan", "argument Z: invalid number value: 'nan'"),
        ("1 2 -inf", "-inf"),
        ("1 2 3 4 5", "unrecognized arguments: 5"),
        ("1 2 3 4 --yaw 5", "YAW and --yaw say the same; give one"),
        ("1 2 3 --server a-b", "--server: invalid name of a node value: 'a-b'"),
        ("1 2 3 --timeout 0", "--timeout: invalid number of seconds value: '0'"),
        ("1 2 3 --timeout -1", "--timeout: invalid number of seconds value: '-1'"),
        ("1 2 3 --plan", "unrecognized arguments: --plan"),
    ],
)
def test_mistakes(line, words, capsys):
    with pytest.raises(SystemExit) as end:
        parse(line)
    out, err = capsys.readouterr()
    assert (end.value.code, out) == (2, "")
    assert err.startswith("go_to: error: ") and err.count("\n") == 1 and words in err


def test_no_roscore(tmp_path):
    environment = {**os.environ, "ROS_MASTER_URI": "http://localhost:1", "ROS_HOME": str(tmp_path)}
    command = [str(PROGRAM), "1", "2", "3", "--timeout", "0.3"]
    end = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60)
    assert (end.returncode, end.stdout) == (2, "")
    roscore = "roscore at http://localhost:1"
    error = f"go_to: error: there is no {roscore} within 0.3 s"
    assert end.stderr.splitlines() == [f"go_to: waiting for {roscore}", error]


def test_completion(tmp_path):
    script = subprocess.run([PROGRAM, "--completion"], capture_output=True, text=True, timeout=30)
    assert "mesh_navigation" in script.stdout and "go_to" in script.stdout
    checked = subprocess.run(["bash", "-n"], input=script.stdout, capture_output=True, text=True)
    assert (checked.returncode, checked.stderr) == (0, "")

"""The command plan."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mesh_msgs import zoo
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_navigation.commands.plan_command import main
from mesh_navigation.execution.planning import SHORT_NAMES

PACKAGE = Path(__file__).resolve().parents[2]
PROGRAM = PACKAGE / "nodes" / "plan"
THERE = "--start 1.2 2.1 --goal 8.3 7.4".split()
DIJKSTRA = [*THERE, "--planner", "dijkstra"]
LAYERS = "{layers: [{name: steps, type: mesh_layers/HeightDiffLayer}], steps: {radius: 1.0}}"

# A square of 10 m in the coordinates of a UTM zone.
UTM = """ply
format ascii 1.0
element vertex 4
property double x
property double y
property double z
element face 2
property list uchar int vertex_indices
end_header
500000.3 5800000.3 100.3
500010.3 5800000.3 100.3
500010.3 5800010.3 100.3
500000.3 5800010.3 100.3
3 0 1 2
3 0 2 3
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a flat map, one with a wall through it, and files that are none."""
    path = tmp_path_factory.mktemp("plan")
    grid = zoo.grid(cells=20)
    MapFile.write(str(path / "grid.h5"), Mesh(grid.vertices, grid.faces))
    vertices = grid.vertices.copy()
    vertices[vertices[:, 0] == 5, 2] = 0.6
    MapFile.write(str(path / "wall.h5"), Mesh(vertices, grid.faces))
    (path / "layers.yaml").write_text(LAYERS)
    (path / "utm.ply").write_text(UTM)
    (path / "empty.h5").write_bytes(b"")
    (path / "old.png").write_bytes(b"old")
    return path


@pytest.fixture
def run(folder, monkeypatch, capsys):
    """Runs the command in the folder: code, standard output, standard error."""
    monkeypatch.chdir(folder)

    def run_command(*words):
        try:
            code = main([str(word) for word in words])
        except SystemExit as end:
            code = end.code
        return (code, *capsys.readouterr())

    return run_command


@pytest.mark.parametrize("planner", SHORT_NAMES)
def test_a_path(run, planner):
    code, out, err = run("grid.h5", *THERE, "--planner", planner)
    assert (code, err) == (0, "")
    first, second, third = out.splitlines()
    assert first.startswith("SUCCESS (0): path of ")
    length = float(second.split()[1])
    assert 8.859 <= length < (9.5 if planner == "dijkstra" else 8.861)
    assert second.endswith(" ms") and "cost" in second
    assert third.startswith(f"{planner} on 441 vertices, layers: none, every vertex is free")


def test_json_is_complete_and_strict(run):
    code, out, err = run("grid.h5", *DIJKSTRA, "--json", "--yaw", "90")

    def no_constant(text):
        raise AssertionError(text)

    value = json.loads(out, parse_constant=no_constant)
    assert (code, err) == (0, "")
    assert (value["outcome"], value["outcome_name"]) == (0, "SUCCESS")
    poses = np.array(value["poses"])
    length = np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1).sum()
    assert poses.shape[1] == 7 and value["length"] == pytest.approx(length)
    assert value["cost"] == pytest.approx(length)
    np.testing.assert_allclose(poses[-1, 3:], [0, 0, np.sqrt(0.5), np.sqrt(0.5)], atol=1e-6)
    assert (value["start"], value["goal"]) == ([1.2, 2.1, 0.0], [8.3, 7.4, 0.0])
    assert set(value["seconds"]) == {"map", "preparation", "plan"}
    assert all(seconds >= 0 for seconds in value["seconds"].values())
    assert (value["frame_id"], value["layers"], value["planner"]) == ("map", [], "dijkstra")


def test_no_path(run):
    code, out, err = run("wall.h5", *DIJKSTRA, "--layers", "layers.yaml", "--json")
    value = json.loads(out)
    assert (code, value["outcome_name"], value["outcome"]) == (1, "NO_PATH_FOUND", 54)
    assert (value["poses"], value["length"], value["cost"]) == ([], None, None)
    assert value["layers"] == ["steps"] and err == ""
    code, out, _ = run("grid.h5", "--start", 1, 2, 3, "--goal", 8, 8, "--planner", "dijkstra")
    assert code == 1 and out.startswith("INVALID_START (52): start (1.00, 2.00, 3.00) is 3.00 m")
    assert len(out.splitlines()) == 2


def test_the_file_may_come_last_and_numbers_may_have_exponents(run):
    code, out, _ = run(
        *"--start -1e-3,2e0,0 --goal 8.3 7.4 -1e-3 --set cost_limit=0.5 goal_dist_offset=0".split(),
        *"--yaw -1e1 --planner dijkstra --json grid.h5".split(),
    )
    value = json.loads(out)
    assert (code, value["start"], value["goal"]) == (0, [-0.001, 2, 0], [8.3, 7.4, -0.001])


def test_an_origin(run):
    code, _, err = run("utm.ply", *DIJKSTRA)
    assert code == 2 and "utm.ply: float32 would change its coordinates" in err
    assert "give an origin near to it, such as [500005.0, 5800006.0, 100.0]" in err
    words = "--start 2 2 --goal 8 8 --planner exact --json --origin 500000.3 5.8000003e6".split()
    for height, z in (((), 100.3), ((100.3,), 0.0)):
        code, out, err = run("utm.ply", *words, *height)
        value = json.loads(out)
        assert (code, value["outcome_name"], err) == (0, "SUCCESS", "")
        assert value["origin"] == [500000.3, 5800000.3, *(height or (0.0,))]
        assert value["start"] == pytest.approx([2.0, 2.0, z], abs=1e-5)
        assert value["length"] == pytest.approx(72**0.5)


def test_a_robot_with_a_radius(run):
    words = "--start 1.2 2.1 --goal 8.3 7.4 --planner exact --json".split()
    point = json.loads(run("grid.h5", *words)[1])
    round_one = json.loads(run("grid.h5", *words, "--robot-radius", "0.25")[1])
    assert [value["robot_radius"] for value in (point, round_one)] == [0.0, 0.25]
    assert point["poses"] == round_one["poses"]  # there is nothing to keep it from
    beside = "wall.h5 --start 1 2 --goal 4.1 2 --layers layers.yaml".split()
    assert run(*beside)[0] == 0
    code, out, _ = run(*beside, "--robot-radius", 1)
    assert code == 1 and out.startswith("INVALID_GOAL (53): ")
    assert "is nearer than the robot's" in out


def test_a_mesh_of_few_large_faces(run, folder):
    """It is said once, with the way out, which helps."""
    words = "utm.ply --start 2 2 --goal 8 7 --json --origin 500000.3 5.8000003e6 100.3".split()

    def planned(*more):
        command = [sys.executable, str(PROGRAM), *words, *map(str, more)]
        done = subprocess.run(
            command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=True
        )
        return json.loads(done.stdout), done.stderr.decode()

    radius, way_out = ("--robot-radius", 0.25), ("--max-edge-length", 0.25)
    point, err = planned()
    assert point["faces"] == 2 and "edges" not in err
    large, err = planned(*radius)
    assert large["faces"] == 2
    assert err.count("edges longer than the robot's radius, 0.25 m (the longest has 14.1 m)") == 1
    assert "(max_edge_length: 0.12, half of" in err
    small, err = planned(*radius, *way_out)
    assert small["faces"] > 2000 and "edges" not in err
    assert small["uuid"] != large["uuid"] == point["uuid"]
    assert json.loads(run(*words, *way_out)[1])["uuid"] == small["uuid"]
    code, out, err = run(*words, "--max-edge-length", 0.0005)
    assert (code, out) == (2, "")
    assert "max_edge_length 0.0005 m makes at least" in err and "faces of 2, more than" in err


@pytest.mark.parametrize(
    "words, message",
    [
        ("", "the following arguments are required: FILE, --start, --goal (plan --help)"),
        ("grid.h5 --start 1 1", "required: --goal"),
        ("grid.h5 --start 1 --goal 2 2", "argument --start: invalid X Y [Z] value: '1'"),
        ("grid.h5 --start 1 a --goal 2 2", "argument --start: invalid X Y [Z] value"),
        ("grid.h5 --start 1 1 --goal 2 nan", "argument --goal: invalid X Y [Z] value"),
        (
            "grid.h5 --start 1 1 --goal 20 2",
            "goal: there is no surface at x = 20, y = 2 (the map has x",
        ),
        ("grid.h5 --start 1 1 --goal 2 2 --tolerance -1", "invalid distance value: '-1'"),
        ("grid.h5 --start 1 1 --goal 2 2 --origin 1", "invalid X Y [Z] value: '1'"),
        ("no.h5 --start 1 1 --goal 2 2 --robot-radius 101", "robot_radius is 101"),
        ("grid.h5 --start 1 1 --goal 2 2 --robot-radius -1", "invalid distance value: '-1'"),
        ("grid.h5 --start 1 1 --goal 2 2 --max-edge-length x", "invalid distance value: 'x'"),
        ("grid.h5 --start 1 1 --goal 2 2 --yaw x", "invalid number value: 'x'"),
        ("grid.h5 --start 1 1 --goal 2 2 --planner x", "no planner 'x' (known: dijkstra, wave"),
        ("grid.h5 --start 1 1 --goal 2 2 --planner a/b", "a/b"),
        ("grid.h5 --start 1 1 --goal 2 2 --nonsense", "unrecognized arguments: --nonsense"),
        ("grid.h5 --start 1 1 --goal 2 2 --set x", "--set x: it is no NAME=VALUE"),
        ("grid.h5 --start 1 1 --goal 2 2 --set x=[", "--set x=[: '[' is no value"),
        ("grid.h5 --start 1 1 --goal 2 2 --planner dijkstra --set x=1", "no parameter 'x'"),
        ("grid.h5 --start 1 1 --goal 2 2 --planner dijkstra --set cost_limit=a", "limit is 'a'"),
        ("grid.h5 --start 1 1 --goal 2 2 --layers no.yaml", "no.yaml: No such file"),
        ("grid.h5 --start 1 1 --goal 2 2 --layers grid.h5", "grid.h5 is no YAML"),
        ("grid.h5 --start 1 1 --goal 2 2 --part attic", "attic"),
        ("no.h5 --start 1 1 --goal 2 2", "no.h5: there is no such file"),
        ("no.h5 --start 1 1 --goal 2 2 --set x=1", "no parameter 'x'"),
        ("no.h5 --start 1 1 --goal 2 2 --planner a/b", "a/b"),
        ("empty.h5 --start 1 1 --goal 2 2", "empty.h5: "),
        ("grid.h5 --start 1 1 --goal 2 2 --png a.jpg", "a.jpg: the name of a picture ends with"),
        ("grid.h5 --start 1 1 --goal 2 2 --png old.png", "old.png: the file exists already"),
        ("grid.h5 --start 1 1 --goal 2 2 --png no/a.png", "the folder "),
    ],
)
def test_wrong_usage_and_files(run, folder, words, message):
    before = sorted(os.listdir(folder))
    code, out, err = run(*words.split())
    assert (code, out) == (2, ""), err
    assert err.startswith("plan: error: ") and message in err and err.count("\n") == 1
    assert sorted(os.listdir(folder)) == before


def test_a_picture(run, folder):
    Image = pytest.importorskip("PIL.Image")
    words = *DIJKSTRA, "--layers", "layers.yaml", "--png", "old.png"
    code, out, _ = run("wall.h5", *words, "--force")
    assert code == 1 and out.splitlines()[-1] == "old.png: written"
    with Image.open(folder / "old.png") as image:
        assert (image.format, image.size) == ("PNG", (1200, 900))


def process(folder, *command):
    odd = PACKAGE / "test" / "odd_planners"
    environment = dict(os.environ)
    environment["ROS_PACKAGE_PATH"] = f"{odd}:{environment['ROS_PACKAGE_PATH']}"
    environment["PYTHONPATH"] = f"{odd / 'src'}:{environment['PYTHONPATH']}"
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen([sys.executable, *command], cwd=folder, env=environment, **pipes)


def test_the_program(folder):
    running = process(folder, PROGRAM, "grid.h5", *DIJKSTRA)
    out, err = running.communicate(timeout=60)
    assert (running.returncode, err) == (0, b"") and out.startswith(b"SUCCESS (0): path of ")


def test_an_interrupt(folder):
    code = (
        "import os, signal, sys\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # as in a terminal
        "from mesh_navigation.commands import plan_command as command\n"
        "real = command.plan_interruptibly\n"
        "def begin(*arguments):\n"
        "    print('planning', flush=True)\n"
        "    return real(*arguments)\n"
        "command.plan_interruptibly = begin\n"
        "sys.exit(command.main(sys.argv[1:]))\n"
    )
    words = ["grid.h5", *THERE, "--planner", "odd/Slow", "--set", "seconds=1000"]
    running = process(folder, "-c", code, *words)
    assert running.stdout.readline() == b"planning\n"
    running.send_signal(signal.SIGINT)
    _, err = running.communicate(timeout=60)
    assert (running.returncode, err) == (130, b"plan: error: interrupted\n")


@pytest.mark.parametrize(
    "planner, words", [("Deaf", b"interrupted"), ("Holding", b"from its end on signal 2")]
)
def test_an_interrupt_of_a_planner_that_hangs(folder, planner, words):
    """It keeps nobody, not even where it holds Python's lock."""
    words_before = [*THERE, "--planner", f"odd/{planner}", "--set", "seconds=3600"]
    running = process(folder, PROGRAM, "grid.h5", *words_before)
    try:
        assert running.stdout.readline() == b"the planner is at work\n"
        running.send_signal(signal.SIGINT)
        out, err = running.communicate(timeout=60)
    finally:
        running.kill()
    assert (running.returncode, out) == (130, b"")
    assert words in err and err.count(b"\n") == 1


@pytest.mark.parametrize(
    "planner, words",
    [
        ("Throwing", b"by zero"),
        ("Lame", b"no legs"),
        ("Exiting", b"SystemExit: 0"),
        ("Exiting --set at_once=true", b"SystemExit: 0"),
    ],
)
def test_a_planner_that_breaks_is_no_missing_path(folder, planner, words):
    running = process(folder, PROGRAM, "grid.h5", *THERE, "--planner", *f"odd/{planner}".split())
    out, err = running.communicate(timeout=60)
    assert (running.returncode, out) == (2, b"")
    assert err.splitlines()[0] == b"Traceback (most recent call last):"
    last = err.splitlines()[-1]
    assert last.startswith(b"plan: error: ") and words in last


def test_a_full_disk(folder):
    if not os.path.exists("/dev/full"):
        pytest.skip("there is no /dev/full")
    with open("/dev/full", "wb") as full:
        command = [sys.executable, PROGRAM, "grid.h5", *DIJKSTRA]
        ended = subprocess.run(command, cwd=folder, stdout=full, stderr=subprocess.PIPE, timeout=60)
    assert (ended.returncode, ended.stderr) == (
        2,
        b"plan: error: cannot write the output: No space left on device\n",
    )


def test_output_that_nobody_reads(folder):
    running = process(folder, PROGRAM, "grid.h5", *DIJKSTRA, "--json")
    running.stdout.close()
    err = running.stderr.read()
    running.stderr.close()
    assert running.wait(60) == 2 and err == b""


COMPLETION = """
_roscomplete_exe() { COMPREPLY=(what rosbash says); }
complete -F _roscomplete_exe rosrun
eval "$("$0" --completion)"
eval "$("$0" --completion)"  # twice is once
compopt() { :; }  # only while bash completes
COMP_LINE=$1 COMP_POINT=${#1} COMP_TYPE=9
read -ra COMP_WORDS <<<"$COMP_LINE"
[[ $COMP_LINE == *" " ]] && COMP_WORDS+=("")
COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
_mesh_navigation_plan_rosrun
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.mark.parametrize(
    "line, expected",
    [
        ("rosrun mesh_navigation plan grid.h5 --st", ["--start"]),
        ("rosrun mesh_navigation plan grid.h5 --planner w", ["wave_front"]),
        ("rosrun other plan gr", ["rosbash", "says", "what"]),
    ],
)
def test_completion_in_bash(folder, line, expected):
    pytest.importorskip("argcomplete")
    result = subprocess.run(
        ["bash", "--norc", "-c", COMPLETION, str(PROGRAM), line],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        timeout=120,
        check=True,
    )
    found = [word.strip() for word in result.stdout.decode().split("\n") if word.strip()]
    assert sorted(found) == expected, result

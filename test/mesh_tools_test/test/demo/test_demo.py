"""Parts of the demo that need no ROS master."""
import itertools
import os
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from mesh_map.map.mesh_map import MeshMap
from mesh_msgs.testing import wait_until
from mesh_msgs.zoo import grid
from mesh_tools_test.demo import main, navigation_node, pipeline, screenshot
from mesh_tools_test.demo.layers import FOR_FILES
from mesh_tools_test.demo.processes import DemoError


def scene(share, rows=100, columns=200):
    """A picture whose first rows, that share of all, have another color."""
    picture = np.full((rows, columns, 3), (64, 66, 72), dtype=np.uint8)
    picture[: round(share * rows)] = (205, 0, 205)
    return picture


def test_a_flat_mesh_of_one_color_is_a_finished_picture():
    assert screenshot.drawn_share(scene(0.0)) == 0.0
    assert screenshot.drawn_share(scene(0.3)) == pytest.approx(0.3)
    assert screenshot.colored_share(scene(0.3)) > screenshot.COLORED > 0.0


def test_a_mesh_that_waits_for_its_costs_is_no_finished_picture():
    picture = scene(0.0)
    picture[:50] = np.random.default_rng(0).integers(60, 220, (50, 200, 1))  # lit and grey
    assert screenshot.drawn_share(picture) > 0.4 and screenshot.colored_share(picture) == 0.0
    picture[:2] = (255, 235, 0)  # an arrow
    assert screenshot.colored_share(picture) == pytest.approx(screenshot.COLORED)


def screens(drawn):
    """Pictures of a screen on which a smaller window has another frame rate in its status bar each
    time; `drawn`: what is in its scene."""
    for number in itertools.count():
        picture = np.zeros((300, 500, 3), np.uint8)
        picture[:200, :400] = 48
        picture[100:150, 250:350] = drawn
        picture[200 - screenshot.STATUS_BAR : 200, :400] = 240
        picture[190, 380 + number % 2] = 0
        yield Image.fromarray(picture)


def settled(monkeypatch, pictures, timeout=30.0):
    monkeypatch.setattr(screenshot, "grab", lambda environment: next(pictures))
    rviz = "rviz", SimpleNamespace(poll=lambda: None), "rviz.log"
    return screenshot.settled_picture({}, rviz, timeout, still=0.3, still_when_grey=0.3)


def test_the_frame_rate_in_a_window_smaller_than_the_screen_is_no_change_of_the_picture(
    monkeypatch,
):
    found = np.asarray(settled(monkeypatch, screens((255, 235, 0))))
    assert screenshot.window_of(found).shape == (200, 400, 3)
    assert screenshot.window_of(np.zeros((4, 5, 3), np.uint8)).size == 0


def test_a_status_bar_alone_is_no_finished_picture(monkeypatch):
    still = itertools.repeat(next(screens(48)))
    with pytest.raises(DemoError, match="a finished picture in RViz did not happen within"):
        settled(monkeypatch, still, timeout=1.0)


def test_colors_that_differ_in_one_channel_only_are_different():
    picture = scene(0.0)
    for channel in range(3):
        picture[channel, 0, channel] += 1
    assert screenshot.drawn_share(picture) == pytest.approx(3 / 20000)


@pytest.mark.parametrize(
    "goal, yaw", [((3, 0, 0), 0.0), ((0, 2, 5), np.pi / 2), ((-1, 0, 0), np.pi), ((0, 0, 4), 0.0)]
)
def test_the_heading_is_that_of_the_way(goal, yaw):
    assert navigation_node.heading((0, 0, 0), goal) == pytest.approx(yaw)


def test_two_demos_do_not_write_to_one_folder(tmp_path):
    output = tmp_path / "out"
    with pipeline.output_folder(output):
        with pytest.raises(DemoError, match="another demo is writing"):
            with pipeline.output_folder(output):
                pass
        with pipeline.output_folder(tmp_path / "other"):
            pass
    with pipeline.output_folder(output):
        pass


def test_results_of_an_earlier_run_do_not_stay_but_files_of_the_user_do(tmp_path):
    (tmp_path / "logs").mkdir()
    for name in ("rviz.png", "report.md", "forest.h5", "logs/mine.log"):
        (tmp_path / name).write_text("old")
    with pipeline.output_folder(tmp_path):
        left = sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*.*"))
    assert left == ["forest.h5", "logs/mine.log"]


def test_an_output_that_is_a_file_is_refused_in_one_line(tmp_path):
    (tmp_path / "out").write_text("")
    with pytest.raises(DemoError, match="choose another --output"):
        with pipeline.output_folder(tmp_path / "out"):
            pass


def test_a_failure_leaves_a_way_to_go_on(tmp_path, monkeypatch, capsys):
    ends = np.zeros(3), np.array([3, 4, 0])
    mesh = grid(cells=4)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    made = pipeline.Prepared(tmp_path / "forest.h5", mesh_map, FOR_FILES, 0.0, *ends)

    def fail(*_):
        raise DemoError("the robot did not arrive")

    monkeypatch.setattr(main.pipeline, "prepare", lambda *_: made)
    monkeypatch.setattr(main, "grid_map", fail)
    assert main.main(["--output", str(tmp_path)]) == 1
    said, failures = capsys.readouterr()
    assert "go_to 3.00 4.00 0.00" in said and str(made.path) in said
    assert failures == "demo: error: the robot did not arrive\n"


def test_what_it_says_is_in_a_file_at_once(tmp_path):
    program = (
        "import sys; from mesh_tools_test.demo import main\n"
        "main.demo = lambda *_: (print('a step'), sys.stdin.read())\n"
        f"main.main(['--output', {str(tmp_path)!r}])"
    )
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONUNBUFFERED"}
    command, log = [sys.executable, "-c", program], tmp_path / "log"
    with log.open("wb") as stream:
        demo = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=stream, env=environment)
    try:
        wait_until(lambda: log.read_text() == "a step\n", "what it says")
    finally:
        demo.communicate()

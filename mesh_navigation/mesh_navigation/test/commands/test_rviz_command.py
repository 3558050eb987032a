"""RViz is shown where it can be; where it cannot, one line says why and nothing fails."""

import os
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import rospkg
import yaml
from mesh_navigation.commands import rviz_command

PACKAGE = Path(__file__).resolve().parents[2]


class Packages:
    """As rospkg.RosPack, of these packages alone."""

    def __init__(self, *names):
        self.names = names

    def get_path(self, name):
        if name not in self.names:
            raise rospkg.ResourceNotFound(name)
        return str(PACKAGE) if name == "mesh_navigation" else "/opt/" + name


@pytest.fixture
def packages(monkeypatch, tmp_path):
    """Installs packages and the programs of a PATH; returns the environment."""

    def install(*names, screen=":7"):
        monkeypatch.setattr(rospkg, "RosPack", lambda: Packages("mesh_navigation", *names))
        if "rviz" in names:
            (tmp_path / "rviz").write_text("#!/bin/sh\n")
            (tmp_path / "rviz").chmod(0o755)
        monkeypatch.setenv("PATH", str(tmp_path))
        monkeypatch.setenv("DISPLAY", screen)
        monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)

    return install


@pytest.mark.parametrize(
    "names, screen, said",
    [
        ((), ":7", "the package rviz_mesh_plugin is not installed"),
        (("rviz_mesh_plugin",), ":7", "there is no program rviz on PATH"),
        (("rviz_mesh_plugin", "rviz"), "", "there is no screen: set DISPLAY"),
    ],
)
def test_what_is_missing_is_said_in_one_line(packages, monkeypatch, capsys, names, screen, said):
    packages(*names, screen=screen)
    monkeypatch.setattr(os, "execvp", lambda *arguments: pytest.fail("it was run"))
    assert rviz_command.main(["__name:=mesh_rviz"]) == 0
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1
    assert err.startswith("RViz is left out, all else goes on: ") and said in err


def test_rviz_gets_the_configuration_and_what_roslaunch_says(packages, monkeypatch):
    packages("rviz_mesh_plugin", "rviz")
    run = []
    monkeypatch.setattr(os, "execvp", lambda program, words: run.append((program, words)))
    rviz_command.main(["__name:=mesh_rviz", "__log:=/l"])
    rviz_command.main(["-d", "/mine.rviz", "__name:=x"])
    path = str(PACKAGE / "rviz" / "mesh_navigation.rviz")
    assert run == [
        ("rviz", ["rviz", "-d", path, "__name:=mesh_rviz", "__log:=/l"]),
        ("rviz", ["rviz", "-d", "/mine.rviz", "__name:=x"]),
    ]


def test_with_another_node_name_the_configuration_has_its_topics(packages, monkeypatch, tmp_path):
    packages("rviz_mesh_plugin", "rviz")
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)
    run = []
    monkeypatch.setattr(os, "execvp", lambda program, words: run.append(words))
    rviz_command.main(["_node_name:=/robot_2", "__name:=mesh_rviz"])
    ((program, option, path, rest),) = run
    assert (program, option, rest) == ("rviz", "-d", "__name:=mesh_rviz")
    shipped = (PACKAGE / "rviz" / "mesh_navigation.rviz").read_text(encoding="utf-8")
    text = Path(path).read_text(encoding="utf-8")
    assert "move_base_flex" not in text
    assert text.count("/robot_2/") == shipped.count("/move_base_flex/") > 5
    assert "Geometry Topic: /robot_2/mesh_map/mesh" in text
    assert yaml.safe_load(text).keys() == yaml.safe_load(shipped).keys()
    run.clear()
    rviz_command.main(["_node_name:=move_base_flex"])
    assert run[0][2] == str(PACKAGE / "rviz" / "mesh_navigation.rviz"), "its own"


def test_simulation_hands_the_node_name_on():
    launch = ElementTree.parse(PACKAGE / "launch" / "simulation.launch").getroot()
    assert launch.find("arg[@name='node_name']").get("default") == "move_base_flex"
    included = launch.find("include/arg[@name='node_name']")
    assert included.get("value") == "$(arg node_name)"
    for name, topic in (("mesh_topic", "mesh"), ("costs_topic", "vertex_costs")):
        parameter = launch.find(f"node/param[@name='{name}']")
        assert parameter.get("value") == f"/$(arg node_name)/mesh_map/{topic}"
    rviz = launch.find("group/node[@name='mesh_rviz']")
    assert rviz.get("args") == "_node_name:=$(arg node_name)"


def test_the_configuration_shows_what_the_server_and_the_robot_publish():
    text = (PACKAGE / "rviz" / "mesh_navigation.rviz").read_text(encoding="utf-8")
    config = yaml.safe_load(text)["Visualization Manager"]
    planners = yaml.safe_load((PACKAGE / "config" / "planners.yaml").read_text(encoding="utf-8"))
    topics = [display.get("Topic") for display in config["Displays"]]
    for planner in planners["planners"]:
        assert f"/move_base_flex/{planner['name']}/path" in topics
    tools = {tool["Class"]: tool for tool in config["Tools"]}
    assert tools["rviz_mesh_plugin/MeshGoal"]["Topic"] == "/goal", "where goal_bridge listens"


def test_the_model_has_the_frames_and_the_size_of_the_simulated_robot():
    robot = ElementTree.parse(PACKAGE / "urdf" / "surface_robot.urdf").getroot()
    links = {link.get("name") for link in robot.iter("link")}
    assert links == {"base_footprint", "base_link", "laser"}
    planners = yaml.safe_load((PACKAGE / "config" / "planners.yaml").read_text(encoding="utf-8"))
    radii = [float(cylinder.get("radius")) for cylinder in robot.iter("cylinder")]
    assert max(radii) == planners["robot_radius"]
    joints = {joint.find("child").get("link"): joint for joint in robot.iter("joint")}
    assert joints["laser"].find("origin").get("xyz") == "0 0 0.8", "sensor_height of surface_robot"


def test_help_needs_no_screen(monkeypatch, capsys):
    monkeypatch.delenv("DISPLAY", raising=False)
    assert rviz_command.main(["--help"]) == 0
    assert capsys.readouterr().out.startswith("usage: mesh_rviz")

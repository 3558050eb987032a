"""What simulation.launch starts, with and without a localization. Nothing is started."""

from pathlib import Path

import pytest
from roslaunch import substitution_args
from roslaunch.config import load_config_default

LAUNCH = Path(__file__).resolve().parents[2] / "launch"
STATE = "/mesh_localization/state"
PACKAGE = "<package><name>mesh_localization</name><version>0.0.0</version></package>"
NODE = """<launch>
  <arg name="mesh_topic"/>
  <node name="mesh_localization" pkg="mesh_localization" type="any">
    <param name="mesh_topic" value="$(arg mesh_topic)"/>
  </node>
</launch>"""


class Launched:
    """Parameters and nodes of a launch file."""

    def __init__(self, name, *arguments):
        files = [(str(LAUNCH / name), ["map_file:=/map.h5", *arguments])]
        config = load_config_default(files, None, verbose=False, assign_machines=False)
        self.values = {name: param.value for name, param in config.params.items()}
        self.nodes = {node.name: node for node in config.nodes}


@pytest.fixture(autouse=True)
def packages_are_looked_for_anew(monkeypatch):
    """Where roslaunch has found them before counts for no other test."""
    monkeypatch.setattr(substitution_args, "_rospack", None)


@pytest.fixture
def localization(tmp_path, monkeypatch):
    """A package mesh_localization that is found first."""
    folder = tmp_path / "mesh_localization"
    (folder / "launch").mkdir(parents=True)
    (folder / "package.xml").write_text(PACKAGE)
    (folder / "launch/localization.launch").write_text(NODE)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path), prepend=":")


def test_without_localization_no_package_of_it_is_needed(monkeypatch):
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(LAUNCH.parent))  # where no other package is
    launched = Launched("simulation.launch")
    assert set(launched.nodes) == {"move_base_flex", "goal_bridge", "surface_robot"}
    assert "/move_base_flex/localization_topic" not in launched.values
    assert launched.values["/surface_robot/localization"] is True
    assert launched.nodes["surface_robot"].remap_args == []


def test_with_localization_it_says_where_the_robot_is(localization):
    launched = Launched("simulation.launch", "localization:=true", "odometry_yaw_drift:=0.009")
    names = {"move_base_flex", "goal_bridge", "surface_robot", "mesh_localization"}
    assert set(launched.nodes) == names
    assert launched.values["/move_base_flex/localization_topic"] == STATE
    assert launched.values["/surface_robot/localization"] is False
    assert launched.values["/surface_robot/odometry_yaw_drift"] == 0.009
    # The pose that is told to the localization does not move the robot.
    remaps = launched.nodes["surface_robot"].remap_args
    assert remaps == [["initialpose", "surface_robot/initialpose"]]


def test_another_server_hears_it_too(localization):
    launched = Launched("simulation.launch", "localization:=true", "node_name:=robot_2")
    assert launched.values["/robot_2/localization_topic"] == STATE
    assert launched.values["/mesh_localization/mesh_topic"] == "/robot_2/mesh_map/mesh"


def test_a_server_hears_the_topic_of_its_configuration(tmp_path):
    config = tmp_path / "planners.yaml"
    config.write_text("localization_topic: /amcl/state\n")
    given = Launched("mesh_navigation.launch", f"planner_config:={config}")
    assert given.values["/move_base_flex/localization_topic"] == "/amcl/state"
    given = Launched(
        "mesh_navigation.launch", f"planner_config:={config}", "localization_topic:=/mine"
    )
    assert given.values["/move_base_flex/localization_topic"] == "/mine"

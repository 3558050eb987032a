"""The robot as RViz draws it: the shipped one, enlarged where it would be a dot in the picture."""
import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import rospkg
import rospy

from mesh_tools_test.demo.planners import RADIUS

PARAMETER = "/robot_description"
LEAST = 15  # pixels from side to side, so that one sees which way it faces


def shipped():
    """The URDF of mesh_navigation's simulated robot, as text."""
    folder = Path(rospkg.RosPack().get_path("mesh_navigation"))
    return (folder / "urdf/surface_robot.urdf").read_text(encoding="utf-8")


def times(meters_per_pixel):
    """By how much the robot must be enlarged, a whole number, where a pixel is so long [m]."""
    return max(1, math.ceil(LEAST * meters_per_pixel / (2 * RADIUS) - 1e-9))


def enlarged(urdf, factor):
    """A URDF whose links look so many times larger; its frames stay where TF has them.

    Only for fixed joints without rotation, as the shipped robot's.
    """
    robot = ElementTree.fromstring(urdf)
    for element in robot.findall("link/visual//*"):
        for name in {"xyz", "size", "radius", "length"} & set(element.keys()):
            element.set(name, _joined(factor * value for value in _numbers(element.get(name))))
    # RViz places a link by its frame in TF: what is drawn moves away from its parent instead.
    for joint in robot.findall("joint[origin]"):
        moved = [(factor - 1) * value for value in _numbers(joint.find("origin").get("xyz"))]
        name = joint.find("child").get("link")
        for visual in robot.findall(f"link[@name='{name}']/visual"):
            origin = visual.find("origin")
            if origin is None:
                origin = ElementTree.SubElement(visual, "origin", xyz="0 0 0")
            own = _numbers(origin.get("xyz"))
            origin.set("xyz", _joined(map(sum, zip(own, moved))))
    return ElementTree.tostring(robot, encoding="unicode")


def _numbers(text):
    return [float(word) for word in text.split()]


def _joined(values):
    return " ".join(f"{value:.9g}" for value in values)


def describe(factor):
    """Tell RViz how the robot looks."""
    rospy.set_param(PARAMETER, enlarged(shipped(), factor))

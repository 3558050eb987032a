"""Plugins that packages export, ours and those of others."""

import os
import sys
import textwrap

import pytest
import rospkg
from mesh_map.base.errors import PluginError
from mesh_map.base.plugins import find_class, scanned_once
from mesh_map.costs.layer import BASE_CLASS_TYPE
from mesh_map.layers.threshold_layer import HeightDiffLayer
from mesh_map.map.mesh_map import MeshMap

HEIGHT_DIFF = "mesh_layers/HeightDiffLayer"

MODULE = """
import numpy as np
from mesh_map.costs.layer import Layer
from mesh_map.base.parameter import Parameter


class AltitudeLayer(Layer):
    PARAMETERS = (Parameter("limit", 1.0, 0.0, 10.0, "lethal above, in meters"),)

    def compute(self, mesh_map, inputs):
        z = mesh_map.vertices[:, 2]
        return np.abs(z), np.flatnonzero(z > self.params["limit"])


class FailingLayer(Layer):
    def compute(self, mesh_map, inputs):
        raise RuntimeError("out\\nof order")


class ShortLayer(Layer):
    def compute(self, mesh_map, inputs):
        return np.zeros(1), []


class VandalLayer(Layer):
    def compute(self, mesh_map, inputs):
        mesh_map.vertices[0] = 0
        return np.zeros(len(mesh_map.vertices)), []


class CountingLayer(Layer):
    READS_LAYERS = True

    def compute(self, mesh_map, inputs):
        total = sum(result.lethal.astype(float) for result in inputs.values())
        return total + len(inputs), []


NO_CLASS = 3


class Stranger:
    def __init__(self, *args):
        pass
"""

CLASSES = ["AltitudeLayer", "FailingLayer", "ShortLayer", "VandalLayer", "CountingLayer"]
CLASSES += ["NO_CLASS", "Stranger", "Missing"]


def write_package(folder, name, xml, module=MODULE):
    """A package with plugins for mesh_map, as it is after catkin has installed or sourced it."""
    package = folder / name
    package.mkdir()
    (package / "package.xml").write_text(
        textwrap.dedent(
            """\
            <package format="3">
              <name>%s</name><version>1.0.0</version><description>Plugins.</description>
              <maintainer email="a@example.org">A</maintainer><license>BSD</license>
              <depend>mesh_map</depend>
              <export><mesh_map plugin="${prefix}/plugins.xml"/></export>
            </package>
            """
        )
        % name
    )
    (package / "plugins.xml").write_text(xml)
    python = folder / "python" / (name + "_plugins")
    python.mkdir(parents=True)
    (python / "__init__.py").write_text("")
    (python / "layers.py").write_text(module)
    return package


def entry(name, module, kind=None):
    return (
        '<class name="%s" type="%s" base_class_type="%s"><description>D</description></class>'
        % (
            name,
            module,
            kind or BASE_CLASS_TYPE,
        )
    )


@pytest.fixture
def packages(tmp_path, monkeypatch):
    """A folder of packages on ROS_PACKAGE_PATH, importable as a sourced workspace is."""
    monkeypatch.setenv(
        "ROS_PACKAGE_PATH", os.pathsep.join([str(tmp_path), os.environ["ROS_PACKAGE_PATH"]])
    )
    monkeypatch.syspath_prepend(str(tmp_path / "python"))
    yield tmp_path
    for name in [name for name in sys.modules if name.split(".")[0].endswith("_plugins")]:
        del sys.modules[name]


@pytest.fixture
def stranger(packages):
    """A package of someone else with several layers."""
    classes = "".join(
        entry("stranger/" + name, "stranger_plugins.layers." + name) for name in CLASSES
    )
    other = entry("stranger/Planner", "stranger_plugins.layers.Stranger", "mesh_map::Other")
    write_package(
        packages, "stranger", "<library path='stranger'>%s%s</library>" % (classes, other)
    )
    return packages


def refusal(base_class_type=BASE_CLASS_TYPE):
    """What is said where there is no such plugin: the known ones, and what was left out."""
    with pytest.raises(PluginError) as error:
        find_class("mesh_map", base_class_type, "no/Such")
    return str(error.value)


def test_our_own_layers_are_found():
    assert find_class("mesh_map", BASE_CLASS_TYPE, HEIGHT_DIFF) is HeightDiffLayer


def test_an_unknown_type_names_the_known_ones():
    with pytest.raises(PluginError) as error:
        find_class("mesh_map", BASE_CLASS_TYPE, "mesh_layers/NoLayer")
    text = str(error.value)
    assert text.startswith("there is no mesh_map::Layer of the type mesh_layers/NoLayer (known: ")
    assert HEIGHT_DIFF in text and "\n" not in text
    with pytest.raises(PluginError, match=r"\(known: none\)"):
        find_class("mesh_map", "mesh_map::Nothing", HEIGHT_DIFF)
    with pytest.raises(PluginError, match=r"\(known: none\)"):
        find_class("no_such_package", BASE_CLASS_TYPE, HEIGHT_DIFF)


def test_a_layer_of_another_package(stranger, triangle):
    found = find_class("mesh_map", BASE_CLASS_TYPE, "stranger/AltitudeLayer")
    assert found.__module__ == "stranger_plugins.layers"
    triangle.compute_layers(
        [
            {"name": "low", "type": "stranger/AltitudeLayer", "params": {"limit": 1.5}},
            {"name": "high", "type": "stranger/AltitudeLayer", "params": {"limit": 2.5}},
            {"name": "count", "type": "stranger/CountingLayer"},
        ]
    )
    assert triangle.layer_errors == {}
    lethal = {name: layer.result.lethal.tolist() for name, layer in triangle.layers.items()}
    assert lethal["low"] == [False, True, True] and lethal["high"] == [False, False, True]
    assert triangle.layers["count"].result.costs.tolist() == [2, 3, 4]
    assert triangle.costs.tolist() == [2, float("inf"), float("inf")]


def test_packages_are_looked_through_once_for_a_list_of_layers(packages, triangle, monkeypatch):
    looks = []
    find = rospkg.get_ros_paths
    monkeypatch.setattr(rospkg, "get_ros_paths", lambda: looks.append(1) or find())
    triangle.compute_layers([{"name": name, "type": HEIGHT_DIFF} for name in "abc"])
    assert len(triangle.layers) == 3 and len(looks) == 1
    with scanned_once():
        with scanned_once():
            assert "a/New" not in refusal()
        write_package(packages, "new", "<library>%s</library>" % entry("a/New", "x.Y"))
        assert "a/New" not in refusal()
        assert "(known: none)" in refusal("mesh_map::Other")
    assert "a/New" in refusal()
    assert len(looks) == 4


def test_a_layer_that_fails_does_not_harm_the_others(stranger, triangle, caplog):
    names = ["Failing", "Altitude", "Short", "Vandal", "Height", "Missing", "NO_CLASS", "Stranger"]
    config = [{"name": n, "type": "stranger/%sLayer" % n} for n in names[:4]]
    config += [{"name": "height", "type": HEIGHT_DIFF}]
    config += [{"name": n, "type": "stranger/" + n} for n in names[5:]]
    before = triangle.vertices.copy()
    triangle.compute_layers(config)
    assert list(triangle.layers) == ["Altitude", "height"]
    assert (triangle.vertices == before).all()
    errors = triangle.layer_errors
    assert errors["Failing"] == "RuntimeError: out of order"
    assert errors["Short"].startswith("the costs are of shape (1,)")
    assert errors["Vandal"] == "ValueError: assignment destination is read-only"
    assert "has no attribute 'Missing'" in errors["Missing"]
    assert "is the workspace with this package sourced?" in errors["Missing"]
    assert errors["NO_CLASS"] == "stranger/NO_CLASS: stranger_plugins.layers.NO_CLASS is no class"
    assert errors["Stranger"] == "Stranger is no mesh_map.costs.layer.Layer"
    logged = [record.getMessage() for record in caplog.records if record.levelname == "ERROR"]
    assert len(logged) == 6 and not any("\n" in line for line in logged)


def test_other_base_classes_are_not_mixed_up(stranger):
    assert "stranger/Planner" not in refusal()
    assert "(known: stranger/Planner)" in refusal("mesh_map::Other")


def test_several_libraries_in_one_file(packages):
    one = entry("a/One", "many_plugins.layers.AltitudeLayer")
    two = entry("a/Two", "many_plugins.layers.CountingLayer")
    xml = (
        "<!-- both --><class_libraries><library>%s</library><library>%s</library></class_libraries>"
    )
    write_package(packages, "many", xml % (one, two))
    assert "(known: a/One, a/Two, " in refusal()


@pytest.mark.parametrize(
    "xml, message",
    [
        ("<library><class", "is no XML"),
        ("", "is no XML"),
        ('<!DOCTYPE a [<!ENTITY b "c">]><library>&b;</library>', "which is not allowed"),
        ("<library>%s</library>" % entry("a/B", "Nothing"), "a/B needs a type of the form"),
        ("<library>" + " " * (1 << 20) + "</library>", "is larger than 1 MB"),
        (None, "No such file"),
    ],
)
def test_a_bad_description_is_named_and_left_out(packages, xml, message):
    package = write_package(packages, "bad", xml or "")
    if xml is None:
        (package / "plugins.xml").unlink()
    known, _, left_out = refusal().partition("; plugins of package %s are left out: " % package)
    assert HEIGHT_DIFF in known and message in left_out
    assert find_class("mesh_map", BASE_CLASS_TYPE, HEIGHT_DIFF) is HeightDiffLayer


@pytest.mark.parametrize(
    "old, new",
    [
        ('email="a@example.org"', 'email="nobody"'),
        ("<license>BSD</license>", ""),
        ("<version>1.0.0</version>", "<version>one</version>"),
        ("</package>", ""),
        ("<name>bad</name>", ""),
        ("Plugins.", "\xe4"),  # Latin-1 without saying so
        ('<package format="3">', '<package format="x">'),
    ],
)
def test_a_package_that_is_none_is_named_once_and_left_out(packages, caplog, old, new):
    package = write_package(packages, "bad", "<library>%s</library>" % entry("bad/B", "x.Y"))
    text = (package / "package.xml").read_text()
    assert old in text
    (package / "package.xml").write_bytes(text.replace(old, new).encode("latin-1"))
    unrelated = packages / "unrelated"
    unrelated.mkdir()
    (unrelated / "package.xml").write_text("<package><name>un")
    for _ in range(2):
        assert find_class("mesh_map", BASE_CLASS_TYPE, HEIGHT_DIFF) is HeightDiffLayer
    assert "bad/B" not in refusal() and str(package) in refusal()
    (logged,) = [record.getMessage() for record in caplog.records]
    assert logged.startswith("plugins of package %s are left out: " % package)
    assert "\n" not in logged and "unrelated" not in logged


def test_of_packages_of_one_name_the_first_on_the_path_counts(packages, monkeypatch):
    for folder in ("over", "under"):
        (packages / folder).mkdir()
        xml = "<library>%s</library>" % entry("same/" + folder.title(), "x.Y")
        write_package(packages / folder, "same", xml)
    before = os.environ["ROS_PACKAGE_PATH"].split(os.pathsep)[1:]
    path = [str(packages / "over"), str(packages / "under"), *before]
    monkeypatch.setenv("ROS_PACKAGE_PATH", os.pathsep.join(path))
    assert "same/Over" in refusal() and "same/Under" not in refusal()


def test_folders_that_are_to_be_ignored_hold_no_packages(packages):
    for name in ("CATKIN_IGNORE", ".hidden", "inside"):
        folder = packages / name
        folder.mkdir()
        xml = "<library>%s</library>" % entry(name + "/A", "x.Y")
        package = write_package(folder, "ignored", xml)
        package.rename(folder / "ignored")
    (packages / "CATKIN_IGNORE" / "CATKIN_IGNORE").write_text("")
    (packages / "inside" / "package.xml").write_text("<package><name>inside</name></package>")
    assert "/A," not in refusal()


def test_of_two_plugins_of_one_name_our_own_counts(packages):
    write_package(packages, "a_copy", "<library>%s</library>" % entry(HEIGHT_DIFF, "x.Y"))
    assert find_class("mesh_map", BASE_CLASS_TYPE, HEIGHT_DIFF) is HeightDiffLayer
    assert (
        "; plugin mesh_layers/HeightDiffLayer of package a_copy is left out: "
        "package mesh_map has one of this name)"
    ) in refusal()


@pytest.fixture
def triangle():
    return MeshMap([[0, 0, 0], [1, 0, 2], [0, 1, 3]], [[0, 1, 2]])

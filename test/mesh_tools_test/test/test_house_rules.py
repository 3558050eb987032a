"""Every rule of the house finds what breaks it, and leaves good code alone."""
import sys
from pathlib import Path

import pytest

CI = Path(__file__).resolve().parents[3] / ".ci"
sys.path.insert(0, str(CI))
house_rules = pytest.importorskip("house_rules", reason="the linter is not part of an installation")

LIBRARY = Path("mesh_map/src/mesh_map/part.py")


def findings(path, text):
    """The sentences of check_python."""
    return [text for _, _, text in house_rules.check_python(Path(path), text)]


@pytest.mark.parametrize(
    "path, text, word",
    [
        (LIBRARY, "import rospy\n", "rospy in a library"),
        (LIBRARY, "def f():\n    from tf2_ros import Buffer\n", "tf2_ros in a library"),
        (LIBRARY, "import h5py\n", "must not import h5py"),
        (LIBRARY, "from mesh_navigation.planner import X\n", "must not import mesh_navigation"),
        ("mesh_msgs/src/mesh_msgs/a.py", "import mesh_map\n", "must not import mesh_map"),
        (LIBRARY, "print(1)\n", "print in a library"),
        (LIBRARY, "x = np.empty(3)\n", "np.empty"),
        (LIBRARY, "try:\n    f()\nexcept:\n    pass\n", "bare except"),
        (LIBRARY, "run('a', shell=True)\n", "shell=True"),
        (LIBRARY, "import os\nos.system('a')\n", "no shell"),
        (LIBRARY, "eval('1')\n", "never evaluate"),
        (LIBRARY, "yaml.load(s)\n", "yaml.safe_load"),
        (LIBRARY, "match x:\n    case 1: pass\n", "not Python 3.8"),
        ("test/mesh_tools_test/nodes/x", "#!/usr/bin/env python3\n", "/usr/bin/python3"),
    ],
)
def test_each_rule_finds_what_breaks_it(path, text, word):
    assert any(word in finding for finding in findings(path, text))


@pytest.mark.parametrize(
    "path, text",
    [
        ("mesh_map/src/mesh_map/ros.py", "import rospy\n"),
        ("mesh_map/src/mesh_map/map_node.py", "import rospy\n"),
        ("mesh_msgs_hdf5/src/mesh_msgs_hdf5/map_file.py", "import h5py\nh5py.File('a')\n"),
        ("mesh_msgs_hdf5/src/mesh_msgs_hdf5/cli.py", "print(1)\n"),
        (LIBRARY, "import mesh_msgs_hdf5\nx = np.zeros(3)\n"),
        ("test/mesh_tools_test/nodes/x", "#!/usr/bin/python3\nprint(1)\n"),
    ],
)
def test_good_code_is_left_alone(path, text):
    assert findings(path, text) == []


@pytest.mark.parametrize(
    "line",
    [
        "scene->createManualObject(); ManualObject* m;",
        "#include <hdf5.h>",
        "exit(1);",
        'system("ls");',
    ],
)
def test_banned_cpp_is_found(line):
    assert list(house_rules.check_cpp(Path("rviz_mesh_plugin/src/a.cpp"), line + "\n"))
    assert not list(house_rules.check_cpp(Path("rviz_mesh_plugin/src/a.cpp"), "// " + line + "\n"))


def test_lengths_are_bounded():
    short = {Path(f"a{i}.py"): 100 for i in range(20)}
    assert not list(house_rules.check_lengths(short))
    assert list(house_rules.check_lengths({**short, Path("long.py"): 451}))
    assert not list(house_rules.check_lengths({**short, Path("test/test_long.py"): 600}))
    assert list(house_rules.check_lengths({Path(f"a{i}.py"): 131 for i in range(20)}))
    assert list(house_rules.check_lengths({Path(f"a{i}.py"): 90 + 15 * i for i in range(20)}))


def test_a_package_needs_its_papers(tmp_path):
    (tmp_path / "p").mkdir()
    (tmp_path / "p/package.xml").write_text('<package format="2"/>')
    texts = [text for _, _, text in house_rules.check_packages(tmp_path, {Path("p/package.xml")})]
    assert len(texts) == 4

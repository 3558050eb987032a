"""Every rule of the house finds what breaks it, and leaves good code alone."""
import sys
from pathlib import Path

import pytest

CI = Path(__file__).resolve().parents[4] / ".ci"
sys.path.insert(0, str(CI))
house_rules = pytest.importorskip("house_rules", reason="the linter is not part of an installation")
room_rules = house_rules.room_rules

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
        (
            LIBRARY,
            "from mesh_navigation.planner import X\n",
            "must not import mesh_navigation",
        ),
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
        ("mesh_map/src/mesh_map/ros/publishers.py", "import rospy\n"),
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
    limits = house_rules.MAX_LINES, house_rules.MAX_TEST_LINES
    assert limits == (700, 900)
    assert not list(house_rules.check_lengths({Path("p/a.py"): 700, Path("p/test/a.cpp"): 900}))
    (finding,) = house_rules.check_lengths({Path("p/a.py"): 701, Path("p/b.py"): 2})
    assert finding == ("p/a.py", 701, "over 700 lines: which second concept lives in it?")
    assert list(house_rules.check_lengths({Path("p/test/room/test_long.py"): 901}))


def folder_findings(count, suffix):
    files = [Path(f"p/src/room/file{number}{suffix}") for number in range(count)]
    others = [Path(f"p/src/other/file{number}.py") for number in range(25)]
    return list(room_rules.check_folders(files + others))


@pytest.mark.parametrize("suffix", [".py", ".cpp", ".h", ".cl"])
def test_a_folder_with_too_many_files_is_found(suffix):
    assert folder_findings(25, suffix) == []
    ((place, _, text),) = folder_findings(26, suffix)
    assert place == "p/src/room" and "26 files of code, more than 25" in text


@pytest.mark.parametrize("suffix", [".msg", ".srv", ".action", ".png"])
def test_what_is_no_code_is_not_counted(suffix):
    assert folder_findings(200, suffix) == []


CPP = {"p": [{"displays", "tools"}, {"rendering"}, {"rendering/lines"}, {""}]}
PYTHON = {"p": [{"server", "commands"}, {"map"}, {"base"}]}


def room_findings(files, cpp=CPP, python=PYTHON):
    """(place, sentence) of each finding; files: path below the package p -> text."""
    texts = {Path("p") / path: text for path, text in files.items()}
    found = room_rules.check_rooms(texts, [Path("p")], cpp, python)
    return [(place, text) for place, _, text in found]


CPP_FILES = {
    "src/displays/mesh.cpp": '#include "displays/mesh.h"\n#include <p/wire.h>\n#include <vector>\n',
    "src/displays/mesh.h": '#include "rendering/visual.h"\n',
    "src/rendering/visual.h": '#include "rendering/lines/line.h"\n',
    "src/rendering/lines/line.h": '#include "p/wire.h"\n',
    "src/tools/goal.cpp": '#include "goal.h"\n#include "rendering/lines/line.h"\n',
    "src/tools/goal.h": "",
    "include/p/wire.h": "",
    "test/anything_test.cpp": '#include "displays/mesh.h"\n',
}


@pytest.mark.parametrize(
    "path, text, place, word",
    [
        ("src/rendering/x.cpp", '#include "displays/mesh.h"', "src/rendering/x.cpp", "above it"),
        ("src/rendering/x.cpp", "#include <displays/mesh.h>", "src/rendering/x.cpp", "above it"),
        ("src/rendering/lines/x.h", '#include "../visual.h"', "src/rendering/lines/x.h", "above"),
        ("include/p/x.h", '#include "rendering/visual.h"', "include/p/x.h", "the top uses"),
        ("include/p/rendering/x.h", '#include "tools/goal.h"', "include/p/rendering/x.h", "above"),
        ("src/tools/x.cpp", '#include "displays/mesh.h"', "src/tools/x.cpp", "of the same layer"),
        ("src/attic/x.cpp", "", "src/attic", "which room is 'attic'? add it to CPP['p']"),
        ("src/rendering/new/x.h", "", "src/rendering/new", "which room is 'rendering/new'?"),
        ("src/tools/goal.h", '#include "tools/pose.h"', "src/tools/goal.h", "a circle of files"),
        ("src/tools/me.h", '#include "tools/me.h"', "src/tools/me.h", "a circle of files"),
    ],
)
def test_includes_run_downwards(path, text, place, word):
    files = {**CPP_FILES, "src/tools/pose.h": '#include "goal.h"\n'}
    assert room_findings(files) == []
    ((found, sentence),) = room_findings({**files, path: text + "\n"})
    assert found == "p/" + place and word in sentence


PYTHON_FILES = {
    "src/p/__init__.py": "from p.map.mesh_map import MeshMap\n",
    "src/p/server/__init__.py": "",
    "src/p/server/node.py": "from p.map import mesh_map, queries\nfrom p.msg import Mesh\n",
    "src/p/commands/__init__.py": "",
    "src/p/commands/tool.py": "def f():\n    import p.map.mesh_map\n    import p._kernels\n",
    "src/p/map/__init__.py": '"""Exports."""\nfrom p.map.queries import nearest\n',
    "src/p/map/mesh_map.py": "import numpy\nfrom p.map.queries import nearest\nimport p.base.a\n",
    "src/p/map/queries.py": (
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from p.map.mesh_map import A\n"
    ),
    "src/p/base/__init__.py": "",
    "src/p/base/a.py": "from p.base import b\nfrom . import b\nfrom .b import c\n",
    "src/p/base/b.py": "",
    "test/test_a.py": "import p\nfrom p import MeshMap\n",
}


@pytest.mark.parametrize(
    "path, text, place, word",
    [
        ("base/x.py", "from p.map.mesh_map import MeshMap", "base/x.py", "above it"),
        ("base/x.py", "from p.map import queries", "base/x.py", "p/map/queries.py"),
        ("base/x.py", "from ..map import queries", "base/x.py", "p/map/queries.py"),
        ("base/x.py", "def f():\n    import p.server.node", "base/x.py", "'server' above it"),
        ("base/x.py", "from p.map import nearest", "base/x.py", "p/map/__init__.py"),
        ("server/x.py", "from p.commands import tool", "server/x.py", "of the same layer"),
        ("server/x.py", "from p import MeshMap", "server/x.py", "MeshMap from the top of p"),
        ("server/x.py", "import p", "server/x.py", "imports all of p"),
        ("server/x.py", "from p.queries import nearest", "server/x.py", "no file for p.queries"),
        ("attic/x.py", "", "attic", "which room is 'attic'? add it to PYTHON['p']"),
        ("base/b.py", "from p.base.a import c", "base/a.py", "a.py -> p/src/p/base/b.py"),
        ("map/queries.py", "from p.map import mesh_map", "map/mesh_map.py", "a circle of files"),
        ("map/queries.py", "from p.map import other", "map/__init__.py", "a circle of files"),
    ],
)
def test_imports_run_downwards(path, text, place, word):
    assert room_findings(PYTHON_FILES) == []
    ((found, sentence),) = room_findings({**PYTHON_FILES, "src/p/" + path: text + "\n"})
    assert found == "p/src/p/" + place and word in sentence


def test_a_package_of_one_room_needs_no_table():
    files = {"src/q/__init__.py": "", "src/q/a.py": "from q import b\n", "src/q/b.py": ""}
    assert room_findings(files) == []
    files["src/q/room/c.py"] = ""
    assert len(room_findings(files)) == 2  # neither of the two rooms is in the table


def test_the_table_has_each_room_once():
    rooms = house_rules.rooms
    for layers in [*rooms.CPP.values(), *rooms.PYTHON.values()]:
        names = [room for layer in layers for room in layer]
        assert len(names) == len(set(names))


def test_pages_name_what_is_there():
    files = [Path("p/src/p/base/x.py"), Path("p/p.xml")]
    page = "`base/x.py` `p/base` `base/` `x.py` `p.xml` `./run` `/usr/bin/python3` `build/p` base/y"
    assert not list(house_rules.check_paths(Path("a.md"), page, files))
    for name in ("base/y.py", "y.py", "ase/x.py", "base/x", "q/base"):
        ((place, line, text),) = house_rules.check_paths(Path("a.md"), "\n`%s`" % name, files)
        assert (place, line) == ("a.md", 2) and name in text


def test_a_package_needs_its_papers(tmp_path):
    (tmp_path / "p").mkdir()
    (tmp_path / "p/package.xml").write_text('<package format="2"/>')
    texts = [text for _, _, text in house_rules.check_packages(tmp_path, {Path("p/package.xml")})]
    assert len(texts) == 4

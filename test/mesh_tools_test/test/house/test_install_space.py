"""All that a package brings is installed, and works without the source tree; rays go to the OpenCL
device."""
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from mesh_tools_test.spatial import opencl

ROOT = Path(__file__).resolve().parents[4]
OUTSIDE = ("build", "demo", "shared")
# Folder of a package -> where it is installed, below the prefix; others are for building or tests.
PLACES = {
    "action": "share/{name}/action",
    "config": "share/{name}/config",
    "icons": "share/{name}/icons",
    "include": "include",
    "launch": "share/{name}/launch",
    "msg": "share/{name}/msg",
    "nodes": "lib/{name}",
    "rviz": "share/{name}/rviz",
    "srv": "share/{name}/srv",
    "urdf": "share/{name}/urdf",
}
# Rooms of mesh_tools_test that make and check the site: on the source tree, with Sphinx.
OF_SITE = {"reference", "site", "troubleshooting", "tutorials"}
NOT_INSTALLED = {"benchmark", "cmake", "doc", "kernels", "scripts", "src", "test"}

# Notes every file that Python opens, from the start, and at the end every library that is mapped.
CHILD = """
import sys
opened = set()
sys.addaudithook(
    lambda event, arguments: opened.add(str(arguments[0])) if event == "open" else None
)
import numpy as np
import mesh_map._kernels
from mesh_map.spatial.spatial_index import SpatialIndex, query_counts

installed, forbidden, back_end = sys.argv[1:]
side = np.arange(101, dtype=np.float32)
x, y = np.meshgrid(side, side, indexing="ij")
vertices = np.stack([x, y, np.sin(x) + np.cos(y)], axis=-1).reshape(-1, 3)
corner = (np.arange(100) * 101 + np.arange(100)[:, None]).reshape(-1, 1)
faces = np.concatenate([corner + [0, 101, 1], corner + [1, 101, 102]]).astype(np.uint32)
index = SpatialIndex(vertices, faces)
assert index.wait_for_device() == (back_end == "opencl"), index.device

before = query_counts()  # a device may have been measured

rng = np.random.default_rng(0)
origins = np.column_stack([rng.uniform(-10.0, 110.0, (100_000, 2)), np.full(100_000, 9.0)])
directions = rng.normal([0.0, 0.0, -1.0], 0.3, (100_000, 3))
hits = index.cast_batch(origins=origins, directions=directions, back_end=back_end)
counts = query_counts()
counts = {name: {"ray": counts[name]["ray"] - before[name]["ray"]} for name in counts}
assert counts[back_end]["ray"] == 100_000, counts
assert counts["native" if back_end == "opencl" else "opencl"]["ray"] <= 5000, counts
expected = index.cast_batch(origins=origins, directions=directions, back_end="native")
assert all(np.array_equal(a, b) for a, b in zip(hits, expected))
assert 50_000 < np.isfinite(hits.distances).sum() < 100_000

with open("/proc/self/maps", encoding="utf-8") as maps:
    mapped = {line.split()[-1] for line in maps}
for module in (sys.modules[SpatialIndex.__module__], mesh_map._kernels):
    path = module.__file__
    assert path.startswith(installed), path
assert any(path.startswith(installed) and "libmesh_map_core" in path for path in mapped), mapped
assert any(path.startswith(installed) for path in opened)
strangers = sorted(path for path in opened | mapped if path.startswith(forbidden))
assert not strangers, strangers
print("installed")
"""


def package_folders():
    """The folders of our packages, relative to the tree, as catkin finds them."""
    for folder, inner, files in os.walk(str(ROOT)):
        if Path(folder) == ROOT:
            inner[:] = [name for name in inner if name not in OUTSIDE and name[0] != "."]
        if "package.xml" in files:
            inner.clear()
            yield Path(folder).relative_to(ROOT)


@pytest.fixture(scope="module")
def prefix(tmp_path_factory):
    """An installation of all packages."""
    builds = [ROOT / "build" / folder for folder in package_folders()]
    if not all((build / "cmake_install.cmake").exists() for build in builds):
        pytest.skip("built elsewhere, not by ./run build")
    destination = tmp_path_factory.mktemp("install")
    assert ROOT not in destination.parents
    for build in builds:
        subprocess.run(
            ["cmake", "--install", str(build)],
            env=dict(os.environ, DESTDIR=str(destination)),
            stdout=subprocess.DEVNULL,
            check=True,
            timeout=120,
        )
    (folder,) = destination.rglob("dist-packages")
    return folder.parents[2]


@pytest.fixture(scope="module")
def installed(prefix):
    """The Python folder of the installation."""
    return prefix / "lib/python3/dist-packages"


def files_below(folder):
    """All files below a folder, relative to it, but for what Python writes."""
    found = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder) for path in found if "__pycache__" not in path.parts}


@pytest.mark.parametrize("folder", package_folders(), ids=str)
def test_all_of_a_package_is_installed(prefix, folder):
    package = ROOT / folder
    expected = {prefix / "share" / folder.name / path.name for path in package.glob("*.xml")}
    for part in (path.name for path in package.iterdir() if path.is_dir()):
        if part in PLACES:
            place = prefix / PLACES[part].format(name=folder.name)
            expected |= {place / path for path in files_below(package / part)}
        elif not part.startswith("."):  # what tools leave behind
            assert part in NOT_INSTALLED, f"where is {folder / part} installed?"
    if (package / "setup.py").exists():
        place = prefix / "lib/python3/dist-packages"
        modules = files_below(package / "src" / folder.name)
        modules = {path for path in modules if path.suffix == ".py"}
        of_site = {path for path in modules if path.parts[0] in OF_SITE}
        assert of_site == set() or folder.name == "mesh_tools_test"
        assert not [path for path in of_site if (place / folder.name / path).exists()]
        expected |= {place / folder.name / path for path in modules - of_site}
    assert len(expected) > 1
    assert not sorted(str(path) for path in expected if not path.is_file())


def test_programs_are_executable(prefix):
    nodes = [ROOT / folder / "nodes" for folder in package_folders()]
    programs = [(nodes_.parent.name, path.name) for nodes_ in nodes for path in nodes_.glob("*")]
    assert len(programs) > 10
    for name, program in programs:
        assert os.access(str(prefix / "lib" / name / program), os.X_OK), (name, program)


PROGRAMS = [
    "mesh_map/mesh_map",
    "mesh_msgs_hdf5/hdf5_map_server",
    "mesh_msgs_hdf5/label_manager",
    "mesh_msgs_hdf5/mesh_tool",
    "mesh_navigation/go_to",
    "mesh_navigation/goal_bridge",
    "mesh_navigation/mbf_mesh_nav",
    "mesh_navigation/mesh_rviz",
    "mesh_navigation/plan",
    "mesh_navigation/surface_robot",
]


@pytest.mark.parametrize("program", PROGRAMS)
def test_help_leads_to_a_file_that_is_installed(prefix, program):
    environment = installed_environment(prefix / "lib/python3/dist-packages")
    environment["ROS_PACKAGE_PATH"] = str(prefix / "share")
    told = subprocess.run(
        [str(prefix / "lib" / program), "--help"],
        env=environment,
        stdout=subprocess.PIPE,
        universal_newlines=True,
        check=True,
        timeout=60,
    ).stdout
    (package, file) = re.search(r"^  \$\(rospack find (\w+)\)/(\S+)$", told, re.MULTILINE).groups()
    assert package == program.split("/")[0]
    assert (prefix / "share" / package / file).is_file() and (folder_of(package) / file).is_file()


def folder_of(package):
    """In the source tree, as rospack finds it there."""
    return next(ROOT / folder for folder in package_folders() if folder.name == package)


def test_commands_and_plugins_work_from_the_install_space(prefix, tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    (tmp_path / "face.obj").write_text(text)
    environment = installed_environment(prefix / "lib/python3/dist-packages")
    environment["ROS_PACKAGE_PATH"] = str(prefix / "share")

    def output(*command):
        done = subprocess.run(
            [str(word) for word in command],
            cwd=str(tmp_path),
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            universal_newlines=True,
            timeout=60,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    mesh_tool = prefix / "lib/mesh_msgs_hdf5/mesh_tool"
    output(mesh_tool, "import", "face.obj", "face.h5")
    output(mesh_tool, "render", "face.h5", "face.png")
    assert (tmp_path / "face.png").read_bytes()[1:4] == b"PNG"
    assert "refine" in output(mesh_tool, "--help")  # a verb that mesh_map exports
    finding = """
import mesh_map.base.plugins as plugins
for name in "mesh_layers/LabelLayer", "example_mesh_layer/SmoothLayer":
    found = plugins.find_class("mesh_map", "mesh_map::Layer", name)
    print(__import__(found.__module__).__file__)"""
    places = output(sys.executable, "-c", finding).split()
    assert len(places) == 2 and all(place.startswith(str(prefix)) for place in places)


def installed_environment(installed, **variables):
    """An environment with an installation, and nothing of the workspace, in it."""
    kept = ("PATH", "HOME", "LANG", "POCL_CACHE_DIR", "OCL_ICD_VENDORS", "MESH_TOOLS_OPENCL")
    environment = {name: os.environ[name] for name in kept if name in os.environ}
    environment.update(PYTHONPATH=str(installed), PYTHONDONTWRITEBYTECODE="1", **variables)
    return environment


def run_child(installed, tmp_path, back_end, **variables):
    """The script above, with nothing of the workspace in its environment."""
    environment = installed_environment(installed, **variables)
    arguments = [str(installed.parents[2]), str(ROOT) + "/", back_end]
    return subprocess.run(
        [sys.executable, "-c", CHILD, *arguments],
        cwd=str(tmp_path),
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
        timeout=60,
    )


@pytest.mark.skipif(opencl.device_name() is None, reason="no OpenCL device")
def test_opencl_answers_from_the_install_space_without_the_source_tree(installed, tmp_path):
    done = run_child(installed, tmp_path, "opencl", XDG_CACHE_HOME=str(tmp_path))
    assert done.returncode == 0, done.stderr
    assert done.stdout == "installed\n"


def test_native_code_answers_where_there_is_no_device(installed, tmp_path):
    done = run_child(installed, tmp_path, "native", MESH_TOOLS_OPENCL="off")
    assert done.returncode == 0, done.stderr
    assert done.stdout == "installed\n"

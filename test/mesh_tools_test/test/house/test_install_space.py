"""What is installed works without the source tree, and rays go to the OpenCL device."""
import os
import subprocess
import sys
from pathlib import Path

import pytest

from mesh_tools_test.spatial import opencl

ROOT = Path(__file__).resolve().parents[4]
PACKAGES = ("mesh_msgs", "mesh_map")

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


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The Python folder of an installation of mesh_msgs and mesh_map."""
    builds = [ROOT / "build" / package for package in PACKAGES]
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
    return folder


def run_child(installed, tmp_path, back_end, **variables):
    """The script above, with nothing of the workspace in its environment."""
    kept = ("PATH", "HOME", "LANG", "POCL_CACHE_DIR", "OCL_ICD_VENDORS", "MESH_TOOLS_OPENCL")
    environment = {name: os.environ[name] for name in kept if name in os.environ}
    environment.update(PYTHONPATH=str(installed), PYTHONDONTWRITEBYTECODE="1", **variables)
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

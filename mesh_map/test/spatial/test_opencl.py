"""The OpenCL device: which one, its program in the cache, and whatever can fail."""

import functools
import json
import logging
import os
import subprocess
import sys
import threading

import numpy as np
import pytest
from mesh_map import SpatialIndex, _kernels
from mesh_map.spatial.opencl import session as session_module
from mesh_map.spatial import back_end as back_end_module
from mesh_map.spatial.opencl import measurement
from mesh_map.spatial.opencl.device import DeviceInfo, choose_device, device_wish, list_devices
from mesh_map.spatial.opencl.program import DeviceProgram
from mesh_map.spatial.opencl.program_cache import ProgramCache, default_folder
from mesh_map.spatial.spatial_index import query_counts
from meshes import terrain
from spatial_samples import index_of, need_opencl, same, some_rays

TEST_MESH = terrain(60)
SMALLER_MESH = terrain(30)  # for an index that is built again and again
INFOS = [
    DeviceInfo("CPU", "pthread-EPYC", "Portable Computing Language", "3.1", "", ""),
    DeviceInfo("OTHER", "FPGA", "Vendor", "1", "", ""),
    DeviceInfo("GPU", "GeForce", "NVIDIA CUDA", "5", "", ""),
    DeviceInfo("GPU", "Radeon", "AMD", "6", "", ""),
]


@pytest.fixture
def sessions(monkeypatch):
    """Devices start anew, and whatever a test breaks is forgotten behind it."""
    monkeypatch.delenv("MESH_TOOLS_OPENCL", raising=False)
    monkeypatch.setattr(session_module, "_REGISTRY", session_module._Registry())


def warnings_of(caplog):
    return [r.getMessage() for r in caplog.records if r.levelno >= logging.WARNING]


@pytest.mark.parametrize(
    "wish, chosen",
    [("", 2), ("gpu", 2), ("cpu", 0), ("amd", 3), ("portable", 0), ("epyc", 0), ("fpga", 1)]
    + [("off", None), ("intel", None)],
)
def test_the_device_of_a_wish(wish, chosen):
    assert choose_device(INFOS, wish) == chosen
    assert choose_device([], wish) is None


def test_a_parameter_overrides_the_environment(monkeypatch):
    monkeypatch.setenv("MESH_TOOLS_OPENCL", " Off ")
    assert device_wish() == "off" and device_wish("auto") == "off" and device_wish("") == "off"
    assert device_wish("CPU ") == "cpu" and device_wish("Radeon") == "radeon"
    monkeypatch.setenv("MESH_TOOLS_OPENCL", "auto")
    assert device_wish() == ""
    monkeypatch.delenv("MESH_TOOLS_OPENCL")
    assert device_wish() == ""


def test_one_log_line_names_the_device(sessions, caplog):
    need_opencl()
    caplog.set_level(logging.INFO, "mesh_map")
    indices = [SpatialIndex(TEST_MESH.vertices, TEST_MESH.faces) for _ in range(2)]
    assert "not needed yet" in indices[0].device
    for index in indices:
        assert index.wait_for_device()
    _, infos = list_devices()
    lines = [record.getMessage() for record in caplog.records]
    assert len(lines) == 1 and lines[0] == indices[0].device
    assert infos[choose_device(infos, "")].text() in lines[0]


@pytest.mark.parametrize("wish", ["off", "no such device"])
def test_without_a_device_answers_are_native(sessions, caplog, wish):
    if wish != "off":
        need_opencl()
    index = SpatialIndex(TEST_MESH.vertices, TEST_MESH.faces, device=wish)
    before = query_counts()
    found = index.cast_batch(origins=(1, 1, 4), directions=-np.eye(3), back_end="opencl")
    assert found.faces[2] != 0xFFFFFFFF and not index.wait_for_device()
    after = query_counts()
    assert after["opencl"] == before["opencl"]
    assert after["native"]["ray"] - before["native"]["ray"] == 3
    warned = warnings_of(caplog)
    assert len(warned) == (0 if wish == "off" else 1) and "natively" in index.device
    assert wish == "off" or "no device fits the wish 'no such device'" in warned[0]


CODE = """
import logging, sys, warnings
import numpy as np
logging.basicConfig(format="%(levelname)s %(message)s", stream=sys.stdout)
from mesh_map.spatial.spatial_index import SpatialIndex, query_counts
assert not {{"rospy", "pyopencl"}} & set(sys.modules)
{more}
index = SpatialIndex(np.eye(3), [[0, 1, 2]])
for _ in range(2):
    directions = np.tile([-1.0, -1, -1], (5000, 1))
    found = index.cast_batch(origins=(1, 1, 1), directions=directions, back_end="opencl")
    assert (found.faces == 0).all()
    print(query_counts()["opencl"]["ray"], index.wait_for_device())
"""


def run_code(more="", **environment):
    env = {key: value for key, value in os.environ.items() if key != "MESH_TOOLS_OPENCL"}
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", CODE.format(more=more)],
        env=dict(env, **environment),
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0 and "Warning" not in done.stderr, done.stderr
    return done.stdout.splitlines()


def test_a_process_uses_the_device():
    need_opencl()
    assert run_code() == ["5000 True", "10000 True"]


@pytest.mark.parametrize(
    "more, environment",
    [
        ("", {"OCL_ICD_VENDORS": "/nonexistent"}),
        ("sys.modules['pyopencl'] = None", {}),
        ("from mesh_map import _kernels; _kernels._BVH_KERNELS = 'kernel void broken(;'", {}),
        ("from mesh_map import _kernels; _kernels._BVH_KERNELS = ''", {}),
    ],
)
def test_a_process_without_a_device_warns_once(more, environment, tmp_path):
    if not environment and "modules" not in more:
        need_opencl()
        environment = {"XDG_CACHE_HOME": str(tmp_path)}
    first, *rest = run_code(more, **environment)
    assert rest == ["0 False", "0 False"]
    assert first.startswith("WARNING OpenCL: ") and first.endswith("are answered natively")


def test_a_process_that_switches_opencl_off():
    assert run_code(MESH_TOOLS_OPENCL="off") == ["0 False", "0 False"]
    more = "import atexit; atexit.register(lambda: print('pyopencl' in sys.modules))"
    assert run_code(more, MESH_TOOLS_OPENCL="off")[-1] == "False"


def test_unusable_folders_do_no_harm(tmp_path):
    need_opencl()
    file = tmp_path / "file"
    file.write_text("no folder")
    folders = {"XDG_CACHE_HOME": str(file), "POCL_CACHE_DIR": str(tmp_path)}  # PoCL cannot without
    assert run_code(**folders) == ["5000 True", "10000 True"]


def test_a_forked_process_answers_natively():
    need_opencl()
    code = (
        "import os, multiprocessing\n"
        "import numpy as np\n"
        "from mesh_map.spatial.spatial_index import SpatialIndex, query_counts\n"
        "index = SpatialIndex(np.eye(3), [[0, 1, 2]])\n"
        "assert index.wait_for_device()\n"
        "def ask():\n"
        "    other = SpatialIndex(np.eye(3), [[0, 1, 2]])\n"
        "    for asked in (index, other):\n"
        "        rays = {'origins': (1, 1, 1), 'directions': -np.ones((5000, 3))}\n"
        "        assert (asked.cast_batch(**rays, back_end='opencl').faces == 0).all()\n"
        "        assert not asked.wait_for_device() and 'forked' in asked.device\n"
        "    os._exit(query_counts()['opencl']['ray'])\n"
        "child = multiprocessing.get_context('fork').Process(target=ask)\n"
        "child.start()\n"
        "child.join(60)\n"
        "print(child.exitcode, index.wait_for_device())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.stdout.split() == ["0", "True"], done.stderr


def test_programs_are_kept(tmp_path):
    need_opencl()
    devices, infos = list_devices()
    cache = ProgramCache(str(tmp_path / "cache"))
    first = DeviceProgram(devices[0], infos[0], cache)
    first.keep()
    assert not first.from_cache and len(os.listdir(tmp_path / "cache")) == 1
    assert DeviceProgram(devices[0], infos[0], cache).from_cache
    other = infos[0]._replace(driver="another")
    assert not DeviceProgram(devices[0], other, cache).from_cache
    for name in os.listdir(tmp_path / "cache"):  # what the driver does not take is compiled again
        key = "\n".join(infos[0] + (_kernels._BVH_KERNEL_OPTIONS, _kernels._BVH_KERNELS))
        assert str(tmp_path / "cache" / name) == cache.path(key)
    cache.store(key, b"no program")
    assert not DeviceProgram(devices[0], infos[0], cache).from_cache


def test_files_of_the_cache(tmp_path, monkeypatch):
    cache, path = ProgramCache(str(tmp_path)), ProgramCache(str(tmp_path)).path("key")
    assert cache.load("key") is None and not cache.store("key", b"")
    assert cache.store("key", b"binary") and cache.load("key") == b"binary"
    assert os.listdir(tmp_path) == [os.path.basename(path)]
    with open(path, "rb") as file:
        content = file.read()
    for broken in (content[:-1], content[:5], b"", content + b"x", b"x" + content[1:]):
        with open(path, "wb") as file:
            file.write(broken)
        assert cache.load("key") is None
    assert cache.store("key", b"binary")
    os.chmod(path, 0o666)
    assert cache.load("key") is None  # anybody could have written it
    os.unlink(path)
    os.symlink("/dev/zero", path)
    assert cache.load("key") is None
    nowhere = ProgramCache("")
    assert not nowhere.store("key", b"binary") and nowhere.load("key") is None
    monkeypatch.setenv("XDG_CACHE_HOME", "/somewhere")
    assert default_folder() == "/somewhere/mesh_tools/opencl"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    monkeypatch.setenv("HOME", "/home/user")
    assert default_folder() == "/home/user/.cache/mesh_tools/opencl"
    monkeypatch.delenv("HOME")
    assert default_folder() == ""


class Failing:
    """Stands for module pyopencl, or an object of it; the n-th call of all raises an error."""

    calls = 0

    def __init__(self, real, limit, error):
        self._real, self._limit, self._error = real, limit, error

    def __getattr__(self, name):
        value = getattr(self._real, name)
        if isinstance(value, type) and issubclass(value, Exception):
            return value
        if not callable(value) or name in ("mem_flags", "device_type", "program_info"):
            return value

        def call(*arguments, **keywords):
            Failing.calls += 1
            if Failing.calls == self._limit:
                raise self._error
            plain = [a._real if isinstance(a, Failing) else a for a in arguments]
            return value(*plain, **keywords)

        return call


def errors():
    import pyopencl as cl

    return [cl.RuntimeError("device lost"), cl.MemoryError("out of memory"), OSError("broken")]


@functools.lru_cache(maxsize=None)
def program_after(start):
    """What the start of a device ends with, once for many sessions."""
    return start(session_module.Session(""))


@pytest.mark.parametrize("which", [0, 1, 2])
@pytest.mark.parametrize("query", ["rays", "any", "points", "sphere", "box", "visible"])
def test_any_call_may_fail(sessions, caplog, monkeypatch, query, which):
    """Whichever call of a query fails: one warning, and the same answer."""
    need_opencl()
    import pyopencl as cl

    start = session_module.Session._started
    monkeypatch.setattr(session_module.Session, "_started", lambda self: program_after(start))
    error = errors()[which]
    _, vertices, faces = SMALLER_MESH
    origins, directions, limits = some_rays(SMALLER_MESH, np.random.default_rng(0), 100)
    rays = {"origins": origins, "directions": directions, "max_distance": limits}
    ball = {"center": (1.5, 1.5, 0), "radius": 1.0}

    def ask(index, back_end):
        if query == "rays":
            return index.cast_batch(**rays, back_end=back_end)
        if query == "any":
            return index.any_hit_batch(**rays, back_end=back_end)
        if query == "points":
            return index.closest_batch(points=origins, back_end=back_end)
        if query == "sphere":
            return index.in_sphere(**ball, back_end=back_end)
        if query == "box":
            box = {"center": (1.5, 1.5, 0), "axes": np.eye(3), "half_size": (1, 1, 1)}
            return index.in_box(**box, back_end=back_end)
        return index.in_sphere(**ball, mode="visible", eye=(1.5, 1.5, 5), back_end=back_end)

    expected = ask(SpatialIndex(vertices, faces), "native")
    for call in range(1, 60):
        session_module._REGISTRY = session_module._Registry()
        index = SpatialIndex(vertices, faces)
        assert index.wait_for_device()
        program = index._device._session.program
        program.chunk = 64  # so that batches have several
        program.cl = Failing(cl, call, error)
        Failing.calls = 0
        caplog.clear()
        assert same(ask(index, "opencl"), expected)
        if Failing.calls < call:
            assert not warnings_of(caplog) and index.wait_for_device()
            break
        assert len(warnings_of(caplog)) == 1, warnings_of(caplog)
        before = query_counts()["opencl"]
        assert same(ask(index, "opencl"), expected)  # and nobody is asked again
        assert len(warnings_of(caplog)) == 1 and query_counts()["opencl"] == before
        other = SpatialIndex(vertices, faces)
        assert not index.wait_for_device()
        assert other.wait_for_device() == (which == 1)  # without memory, others may have room
    assert call > 5


def test_batches_are_native_while_the_device_starts(sessions, monkeypatch):
    """A batch that is worth a device starts it, and does not wait."""
    need_opencl()
    gate = threading.Event()
    start = session_module.Session._started

    def slow(self):
        assert gate.wait(60)
        return start(self)

    monkeypatch.setattr(session_module.Session, "_started", slow)
    index = SpatialIndex(TEST_MESH.vertices, TEST_MESH.faces)
    directions = np.tile((0.1, 0.2, -1.0), (20_000, 1))
    before = query_counts()
    native = index.cast_batch(origins=(1, 1, 5), directions=directions)
    assert "starting" in index.device
    gate.set()
    assert index.wait_for_device()
    index._device._session.program.faster_from = {"ray": 20_000}
    assert same(index.cast_batch(origins=(1, 1, 5), directions=directions), native)
    counts = query_counts()
    assert counts["opencl"]["ray"] - before["opencl"]["ray"] == 20_000
    assert counts["native"]["ray"] - before["native"]["ray"] >= 20_000


class FakeSession:
    """A device that is ready."""

    def __init__(self, kind, **faster_from):
        self.program = DeviceProgram.__new__(DeviceProgram)
        self.program.info = INFOS[0]._replace(type=kind)
        self.program.key, self.program.faster_from = "\n".join(self.program.info), faster_from

    def wait(self):
        return self.program


@pytest.mark.parametrize(
    "session, least",
    [
        (FakeSession("CPU"), {"auto": None, "opencl": 1}),
        (FakeSession("OTHER"), {"auto": None, "opencl": 1}),
        (FakeSession("CPU", ray=70_000), {"auto": 70_000, "opencl": 1}),
        (FakeSession("CPU", closest_point=70_000), {"auto": None, "opencl": 1}),
        (FakeSession("GPU"), {"auto": 4096, "opencl": 1}),
    ],
)
def test_a_processor_is_asked_only_where_it_was_measured_to_be_faster(monkeypatch, session, least):
    device = back_end_module.MeshDevice("", 0)
    monkeypatch.setattr(back_end_module, "shared_session", lambda wish: session)
    monkeypatch.setattr(device, "_with_mesh", lambda program, bvh: program)
    for back_end, size in least.items():
        sizes = [1, 4095, 4096, 69_999, 70_000, 10_000_000]
        asked = [count for count in sizes if device.for_batch("ray", count, back_end, None)]
        assert asked == [count for count in sizes if size and count >= size]


def test_a_measurement_is_kept(monkeypatch, tmp_path):
    """By device, driver and code; a file that is broken is none."""
    answers = [{"ray": (1.0, 0.79), "closest_point": (1.0, 0.81)}]
    monkeypatch.setattr(measurement, "measured", lambda program: answers.pop())
    cache, program = ProgramCache(str(tmp_path)), FakeSession("CPU").program
    assert measurement.faster_from(program, cache) == {"ray": measurement.BATCH}
    assert measurement.faster_from(program, cache) == {"ray": measurement.BATCH} and not answers
    other = FakeSession("CPU").program
    other.key += "another driver"
    answers.append({"ray": (0.06, 0.14)})
    assert measurement.faster_from(other, cache) == {} and not answers
    for content in (b"x", b"[1]", b'{"ray": 3}', b'{"ray": ["a", 1]}', None):
        key = measurement._key(program)
        if content is None:
            with open(cache.path(key), "ab") as file:
                file.write(b"broken")
        else:
            cache.store(key, content)
        answers.append({"ray": (2.0, 1.0)})
        assert measurement.faster_from(program, cache) == {"ray": measurement.BATCH}
        assert not answers and json.loads(cache.load(key)) == {"ray": [2.0, 1.0]}


def test_what_is_measured(sessions):
    index = index_of(SMALLER_MESH, "opencl")
    program = index._device._session.program
    found = measurement.measured(program)
    assert set(found) == {"ray", "closest_point"} and min(min(pair) for pair in found.values()) > 0
    if program.info.type != "GPU":
        assert set(program.faster_from) <= set(found)
        assert measurement._kept(ProgramCache(), measurement._key(program)) is not None
    assert ("native code is faster" in index.device) == (not program.faster_from)


WATCHED = """
import threading, time
longest = [0.0]
def watch():
    before = begin
    while True:
        now = time.process_time()  # which a busy machine does not add to
        longest[0] = max(longest[0], now - before)
        before = now
        time.sleep(0.001)
import atexit
begin = time.process_time()
threading.Thread(target=watch, daemon=True).start()
atexit.register(lambda: print("%.2f" % (longest[0] / (time.process_time() - begin))))
"""


def test_others_go_on_while_programs_are_compiled(tmp_path):
    """Drivers are loaded, and compile, without Python's lock."""
    need_opencl()
    folders = {"XDG_CACHE_HOME": str(tmp_path), "POCL_CACHE_DIR": str(tmp_path)}
    *answers, share = run_code(WATCHED, **folders)
    assert answers == ["5000 True", "10000 True"]
    assert float(share) < 0.15  # of the time; where pyopencl keeps the lock, a third


def test_a_mesh_without_room_is_native(caplog):
    index = index_of(TEST_MESH, "opencl")
    other = SpatialIndex(TEST_MESH.vertices, TEST_MESH.faces)
    program = index._device._session.program
    room, program.max_buffer = program.max_buffer, 1000
    try:
        rays = {"origins": (1, 1, 5), "directions": -np.eye(3)}
        native = other.cast_batch(**rays, back_end="native")
        for _ in range(2):
            assert same(other.cast_batch(**rays, back_end="opencl"), native)
        assert len(warnings_of(caplog)) == 1 and "no room" in other.device
        assert not other.wait_for_device() and index.wait_for_device()
    finally:
        program.max_buffer = room


WRONG_RAYS = """
kernel void cast_rays(global const float4* nodes, global const float* corners,
                      global const float4* rays, global const uchar* mask, uint flags,
                      uint ray_count, global uint* answers)
{
  const uint item = get_global_id(0);
  for (uint i = 0; item < ray_count && i < 4; ++i) {
    answers[4 * item + i] = 0xFFFFFFFFu;  // sure: nothing
  }
}
"""


def test_a_device_that_computes_wrongly_is_not_used(sessions, caplog, monkeypatch, tmp_path):
    need_opencl()
    renamed = _kernels._BVH_KERNELS.replace("kernel void cast_rays(", "kernel void others(")
    monkeypatch.setattr(_kernels, "_BVH_KERNELS", renamed + WRONG_RAYS)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    index = SpatialIndex(TEST_MESH.vertices, TEST_MESH.faces)
    assert not index.wait_for_device()
    assert "the device computes rays wrongly" in warnings_of(caplog)[0]
    assert not list(tmp_path.glob("**/*.pybin"))

"""SpatialIndex: what it refuses and keeps; how it is built, refitted, cancelled, interrupted."""

import gc
import signal
import subprocess
import sys
import threading
import time
import weakref

import numpy as np
import pytest
from mesh_map import MeshMap, SpatialIndex, _kernels
from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled
from mesh_map.spatial.spatial_index import query_counts
from meshes import TestMesh, small, terrain
from spatial_samples import TERRAIN, moved, need_opencl, same, some_points, some_rays, steep_rays

CORNERS = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]
APART = [[1, 0, 0, 1], [-1, 0, 0, 1], [0, 1, 0, 1], [0, -1, 0, 1]]  # planes that do not meet
NAN, INF = float("nan"), float("inf")


def answers(index, mesh):
    random = np.random.default_rng(3)
    origins, directions, limits = some_rays(mesh, random, 200)
    points = some_points(mesh, random, 100)
    box = {"center": points[0], "axes": np.eye(3), "half_size": (0.3, 0.2, 0.4)}
    return (
        *index.cast_batch(origins=origins, directions=directions, max_distance=limits),
        *index.closest_batch(points=points),
        index.in_sphere(center=points[1], radius=0.3),
        index.in_box(**box),
    )


@pytest.mark.parametrize(
    "vertices, faces, message",
    [
        (CORNERS, np.zeros((0, 3)), "without faces"),
        (np.zeros((0, 3)), np.zeros((0, 3)), "without faces"),
        (CORNERS, [[0, 1, 2], [0, 1, 3], [0, 9, 1]], r"face 1 \(and 1 face more\).* vertex 3"),
        (CORNERS, [[0, 1, -1]], "face 0 refers to vertex -1"),
        (CORNERS + [[0, NAN, 0]], [[0, 1, 2], [0, 1, 3]], "face 1 has vertex 3 .*not finite"),
        (CORNERS + [[0, 0, -INF]], [[0, 1, 2], [0, 1, 3]], "face 1 has vertex 3 .*not finite"),
        (CORNERS + [[1e60, 0, 0]], [[0, 1, 2], [0, 1, 3]], "face 1 has vertex 3 .*not finite"),
        (CORNERS, [[0, 1]], r"faces have to have the shape \(N, 3\)"),
        (np.zeros((3, 2)), [[0, 1, 2]], r"vertices have to have the shape \(N, 3\)"),
        (CORNERS, [[0.0, 1.0, 2.0]], "faces have to be whole numbers"),
        ([["a", "b", "c"]] * 3, [[0, 1, 2]], "vertices have to be numbers"),
    ],
)
def test_bad_meshes_are_refused(vertices, faces, message):
    with pytest.raises(ValueError, match=message) as caught:
        SpatialIndex(vertices, faces)
    assert "\n" not in str(caught.value)


def test_a_vertex_without_faces_may_be_anything():
    index = SpatialIndex(CORNERS + [[NAN, 0, 0]], [[0, 1, 2]])
    assert index.closest(point=(0, 0, 1)).distance == 1


@pytest.mark.parametrize(
    "query, arguments, message",
    [
        ("cast", {"origin": (0, 0), "direction": (0, 0, 1)}, "origin has to be 3 numbers"),
        ("cast", {"origin": "abc", "direction": (0, 0, 1)}, "origin has to be 3 numbers"),
        ("any_hit", {"origin": (0, 0, 0), "direction": None}, "direction has to be 3 numbers"),
        ("cast", {"origin": "\u00e9" * 300, "direction": (0, 0, 1)}, "origin has to be 3 numbers"),
        ("cast", {"origin": [None, 1, 2], "direction": (0, 0, 1)}, "origin has to be 3 numbers"),
        ("cast", {"origin": ["1", "2", "3"], "direction": (0, 0, 1)}, "origin has to be 3 numbers"),
        ("closest", {"point": np.zeros((5, 3))}, "point has to be 3 numbers"),
        ("cast", {"origin": (0, 0, 0), "direction": (0, 0, 1), "max_distance": None},
         "max_distance has to be a number, not None"),
        ("any_hit", {"origin": (0, 0, 0), "direction": (0, 0, 1), "max_distance": [1, 2]},
         "max_distance has to be a number"),
        ("closest", {"point": (0, 0, 0), "max_distance": "3"},
         "max_distance has to be a number, not '3'"),
        ("closest_batch", {"points": [[0, 0, 0]], "max_distance": None},
         "max_distance has to be a number"),
        ("closest_batch", {"points": [[0, 0, 0]], "cancel": threading.Event()},
         "cancel has to be a mesh_map.base.cancel.CancelFlag, not a Event"),
        ("cast_batch",
         {"origins": (0, 0, 0), "directions": [[0, 0, 1]], "cancel": threading.Event()},
         "cancel has to be a mesh_map.base.cancel.CancelFlag, not a Event"),
        ("in_sphere", {"center": (0, 0, 0), "radius": None}, "radius has to be a number"),
        ("closest", {"point": [[0, 0, 0]]}, "point has to be 3 numbers"),
        ("closest", {"point": (0, 0, 0), "normal": (0, 0, 1)}, "belong together"),
        ("closest", {"point": (0, 0, 0), "max_angle": 1}, "belong together"),
        ("closest", {"point": (0, 0, 0), "normal": (0, 0, 1), "max_angle": 180}, "0 to pi rad"),
        ("closest", {"point": (0, 0, 0), "normal": (0, 0, 1), "max_angle": NAN}, "0 to pi rad"),
        ("closest_batch", {"points": [[0, 0]]}, r"points has to have the shape \(N, 3\)"),
        ("closest_batch", {"points": [[0, 0, 0], [0]]}, "points has rows of different lengths"),
        ("closest_batch", {"points": [[0, 0, 0]] * 3, "normals": [[0, 0, 1]] * 2, "max_angle": 1},
         "normals has 2 rows for 3 queries"),
        ("cast_batch", {"origins": [[0, 0, 0]] * 2, "directions": [[0, 0, 1]] * 3},
         "origins has 2 rows for 3 queries"),
        ("cast_batch",
         {"origins": (0, 0, 0), "directions": [[0, 0, 1]] * 3, "max_distance": [1, 2]},
         r"max_distance has to have the shape \(3\)"),
        ("in_sphere", {"center": (0, 0), "radius": 1}, "center has to be 3 numbers"),
        ("in_sphere", {"center": (0, 0, 0), "radius": 1, "mode": "near"},
         "mode has to be touching or inside or visible, not 'near'"),
        ("in_sphere", {"center": (0, 0, 0), "radius": 1, "mode": "visible"}, "needs an eye"),
        ("in_frustum", {"planes": [[0, 0, 1]]}, r"planes has to have the shape \(N, 4\)"),
        ("in_frustum", {"planes": np.zeros((0, 4))}, "planes"),
        ("in_frustum", {"planes": np.ones((17, 4))}, "planes"),
        ("in_frustum", {"planes": np.ones((6, 4)), "mode": "visible", "pixels": (9, 9)},
         "needs an eye"),
        ("in_frustum",
         {"planes": APART, "mode": "visible", "eye": (5, 6, 7), "pixels": (9, 9)}, "eye"),
        ("in_frustum",
         {"planes": np.eye(4), "mode": "visible", "eye": (5, 6, 7), "pixels": (9, 0)},
         "pixels has to be two whole numbers above 0"),
        ("in_frustum",
         {"planes": np.eye(4), "mode": "visible", "eye": (5, 6, 7), "pixels": (1 << 20, 1 << 20)},
         "pixels has 1048576 x 1048576 pixels, more than 268435456; ask for a part"),
        ("in_box", {"center": (0, 0, 0), "axes": 2 * np.eye(3), "half_size": (1, 1, 1)},
         "axes have to be unit vectors at right angles"),
        ("in_box", {"center": (0, 0, 0), "axes": np.eye(2), "half_size": (1, 1, 1)},
         r"axes has to have the shape \(3, 3\)"),
        ("in_polygon", {"polygon": np.zeros((4, 3)), "view_projection": np.eye(4)},
         r"polygon has to have the shape \(N, 2\)"),
        ("in_polygon", {"polygon": np.zeros((4, 2)), "view_projection": np.eye(3)},
         r"view_projection has to have the shape \(4, 4\)"),
        ("in_polygon",
         {"polygon": np.eye(2), "view_projection": np.eye(4), "viewport": (640.5, 480)},
         "viewport has to be two whole numbers above 0"),
        ("in_polygon", {"polygon": np.eye(2), "view_projection": np.eye(4), "mode": "visible"},
         "needs an eye"),
        ("in_polygon",
         {"polygon": np.ones((3, 2)), "view_projection": np.zeros((4, 4)), "viewport": (9, 9),
          "mode": "visible"}, "inverse"),
    ],
)  # fmt: skip
def test_bad_questions_are_refused(query, arguments, message):
    index = SpatialIndex(CORNERS, [[0, 1, 2]])
    with pytest.raises(ValueError, match=message) as caught:
        getattr(index, query)(**arguments)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "mask, message",
    [
        (np.ones(2, bool), r"mask has to have the shape \(1,\), one for each face, not \(2,\)"),
        (np.ones((1, 1), bool), "mask has to have the shape"),
        (np.ones(1, np.uint8), "mask has to be an array of bool, not of uint8"),
        ([0], "mask has to be an array of bool"),
    ],
)
def test_bad_masks_are_refused(mask, message):
    index = SpatialIndex(CORNERS, [[0, 1, 2]])
    ray = {"origin": (0, 0, 1), "direction": (0, 0, -1)}
    batch = {"origins": (0, 0, 1), "directions": [[0, 0, -1]]}
    for query, arguments in (
        (index.cast, ray),
        (index.any_hit, ray),
        (index.cast_batch, batch),
        (index.any_hit_batch, batch),
        (index.closest, {"point": (0, 0, 1)}),
        (index.closest_batch, {"points": [[0, 0, 1]]}),
        (index.in_sphere, {"center": (0, 0, 0), "radius": 1}),
    ):
        with pytest.raises(ValueError, match=message):
            query(**arguments, mask=mask)


def test_bad_back_ends_and_devices_are_refused():
    index = SpatialIndex(CORNERS, [[0, 1, 2]])
    batch = {"origins": (0, 0, 1), "directions": [[0, 0, -1]], "back_end": "cuda"}
    with pytest.raises(ValueError, match="back_end has to be auto or native or opencl"):
        index.cast_batch(**batch)
    with pytest.raises(ValueError, match="back_end has to be auto or native or opencl"):
        normal = {"normals": (0, 0, 1), "max_angle": 1, "back_end": "cuda"}
        index.closest_batch(points=[[0, 0, 1]], **normal)
    with pytest.raises(ValueError, match="device has to be auto, off, gpu, cpu or part"):
        SpatialIndex(CORNERS, [[0, 1, 2]], device=3)
    for threads in (-1, None, 1.5, 1 << 40):
        with pytest.raises(ValueError, match="threads has to be a whole number, 0 .all cores. to"):
            SpatialIndex(CORNERS, [[0, 1, 2]], threads=threads)
        with pytest.raises(ValueError, match="threads has to be a whole number"):
            SpatialIndex.from_bytes(index.to_bytes(), CORNERS, [[0, 1, 2]], threads=threads)
    with pytest.raises(ValueError, match="cancel has to be a mesh_map.base.cancel.CancelFlag"):
        SpatialIndex(CORNERS, [[0, 1, 2]], cancel=threading.Event())


@small
def test_the_number_of_threads_does_not_matter(mesh):
    one = SpatialIndex(mesh.vertices, mesh.faces, threads=1)
    more = SpatialIndex(mesh.vertices, mesh.faces, threads=3)
    assert same(answers(one, mesh), answers(more, mesh))


@small
def test_bytes_make_the_same_index(mesh):
    index = SpatialIndex(mesh.vertices, mesh.faces)
    data = index.to_bytes()
    for form in (data, bytearray(data), memoryview(data)):
        copy = SpatialIndex.from_bytes(form, mesh.vertices, mesh.faces)
        assert copy.to_bytes() == data and same(answers(copy, mesh), answers(index, mesh))
    for broken in (b"", data[:-1], data[:20], data + b"\0", bytes(len(data))):
        with pytest.raises(ValueError):
            SpatialIndex.from_bytes(broken, mesh.vertices, mesh.faces)
    with pytest.raises(ValueError):
        SpatialIndex.from_bytes(data, mesh.vertices + 1, mesh.faces)
    with pytest.raises(ValueError):
        SpatialIndex.from_bytes(data, mesh.vertices, np.concatenate([mesh.faces] * 2))


def test_damaged_bytes_are_refused_or_safe():
    data = SpatialIndex(TERRAIN.vertices, TERRAIN.faces).to_bytes()
    random = np.random.default_rng(0)
    for _ in range(60):
        damaged = bytearray(data)
        damaged[random.integers(len(data))] ^= 1 << random.integers(8)
        try:
            index = SpatialIndex.from_bytes(damaged, TERRAIN.vertices, TERRAIN.faces)
        except ValueError:
            continue
        answers(index, TERRAIN)


@small
def test_refit_answers_for_the_moved_mesh(mesh):
    index = SpatialIndex(mesh.vertices, mesh.faces)
    random = np.random.default_rng(1)
    other = TestMesh("", mesh.vertices + random.normal(0, 0.2, mesh.vertices.shape), mesh.faces)
    other = moved(other, (3, -4, 5))
    index.refit(other.vertices)
    assert same(answers(index, other), answers(SpatialIndex(other.vertices, other.faces), other))
    for wrong in (other.vertices[:-1], np.full_like(other.vertices, NAN)):
        if len(wrong) <= mesh.faces.max() or np.isnan(wrong).any():
            with pytest.raises(ValueError):
                index.refit(wrong)
    fresh = SpatialIndex(other.vertices, other.faces)
    assert same(answers(index, other), answers(fresh, other))


def test_memory_and_arrays():
    mesh = terrain(200)
    index = SpatialIndex(mesh.vertices, mesh.faces)
    assert 40 * len(mesh.faces) < index.memory < 80 * len(mesh.faces)
    nodes, corners, faces = index.native._nodes, index.native._corners, index.native._faces
    assert sorted(faces) == list(range(len(mesh.faces)))
    triangles = corners[: 9 * len(faces)].reshape(-1, 3, 3)
    assert np.array_equal(triangles, mesh.vertices[mesh.faces[faces]])
    for array in (nodes, corners, faces):
        assert not array.flags.writeable and not array.flags.owndata
    content = nodes.tobytes()
    gone = weakref.ref(index)
    index.refit(mesh.vertices * 2)
    del index
    gc.collect()
    assert gone() is None and nodes.tobytes() == content  # the arrays keep what they show


def test_the_mesh_map_builds_one_index_when_it_is_asked():
    mesh = terrain(150)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    assert not mesh_map.geometry._made
    found = []
    threads = [
        threading.Thread(target=lambda: found.append(mesh_map.spatial_index)) for _ in range(6)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 6 and len(set(map(id, found))) == 1
    hit = mesh_map.closest_face((1, 1, 9), 20.0)
    assert same(tuple(hit)[1:], tuple(found[0].closest(point=(1, 1, 9)))[1:])


def test_progress_rises_to_one():
    mesh, told = terrain(250), []
    SpatialIndex(mesh.vertices, mesh.faces, progress=told.append)
    assert told[-1] == 1.0 and told == sorted(told) and len(told) > 2 and told[0] >= 0
    index = SpatialIndex(mesh.vertices, mesh.faces)
    told.clear()
    index.refit(mesh.vertices, progress=told.append)
    assert told[-1] == 1.0 and told == sorted(told)


def test_what_progress_raises_ends_the_build():
    mesh, calls = terrain(250), []

    def progress(share):
        calls.append(share)
        raise KeyError("enough")

    threads = set(threading.enumerate())
    with pytest.raises(KeyError, match="enough"):
        SpatialIndex(mesh.vertices, mesh.faces, progress=progress)
    assert len(calls) == 1 and set(threading.enumerate()) <= threads


def test_a_flag_that_is_set_ends_all():
    mesh, flag = terrain(120), CancelFlag()
    index = SpatialIndex(mesh.vertices, mesh.faces)
    before = answers(index, mesh)
    flag.set()
    directions = np.tile((0.1, 0.2, -1.0), (10_000, 1))
    with pytest.raises(Canceled):
        SpatialIndex(mesh.vertices, mesh.faces, cancel=flag)
    with pytest.raises(Canceled):
        index.refit(mesh.vertices * 2, cancel=flag)
    for count in (100, 10_000):
        rays = {"origins": (1, 1, 5), "directions": directions[:count], "cancel": flag}
        for back_end in ("native", "opencl"):
            with pytest.raises(Canceled):
                index.cast_batch(**rays, back_end=back_end)
            with pytest.raises(Canceled):
                index.any_hit_batch(**rays, back_end=back_end)
            with pytest.raises(Canceled):
                index.closest_batch(points=directions[:count], cancel=flag, back_end=back_end)
    with pytest.raises(Canceled):
        index.in_sphere(center=(6, 6, 0), radius=3, mode="visible", eye=(6, 6, 9), cancel=flag)
    assert same(answers(index, mesh), before)


def test_a_flag_ends_a_batch_soon():
    flag, ended = CancelFlag(), []
    mesh, rays = steep_rays()

    def cast():
        try:
            SpatialIndex(mesh.vertices, mesh.faces).cast_batch(
                **rays, cancel=flag, back_end="native"
            )
        except Canceled:
            ended.append(time.monotonic())

    thread = threading.Thread(target=cast)
    thread.start()
    time.sleep(0.3)
    set_at = time.monotonic()
    flag.set()
    thread.join(30)
    assert not thread.is_alive() and len(ended) == 1
    assert ended[0] - set_at < 5  # the batch would take far longer


INTERRUPTED = """
import os, signal, sys, threading, time
sys.path[:0] = {path!r}
from spatial_samples import steep_rays
from mesh_map import SpatialIndex

mesh, rays = steep_rays(layers={layers})
index = SpatialIndex(mesh.vertices, mesh.faces)
if {back_end!r} == "opencl":
    assert index.wait_for_device()
before = len(os.listdir("/proc/self/task"))
threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
start = time.monotonic()
try:
    index.cast_batch(**rays, back_end={back_end!r})
except KeyboardInterrupt:
    seconds = time.monotonic() - start
    end = time.monotonic() + 10  # for the thread of the timer, and what the system counts longer
    while len(os.listdir("/proc/self/task")) > before and time.monotonic() < end:
        time.sleep(0.01)
    more = len(os.listdir("/proc/self/task")) - before
    print("interrupted", more <= 0, seconds < 20)
"""


@pytest.mark.parametrize("back_end", ["native", "opencl"])
def test_ctrl_c_ends_a_batch_and_leaves_no_thread(back_end):
    if back_end == "opencl":
        need_opencl()
    layers = {"native": 3000, "opencl": 500}[back_end]
    arguments = {"path": sys.path, "back_end": back_end, "layers": layers}
    code = INTERRUPTED.format(**arguments)
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.stdout.split() == ["interrupted", "True", "True"], done.stderr


def test_ctrl_c_ends_a_build():
    code = (
        "import os, signal, threading\n"
        "import numpy as np\n"
        "from mesh_map import SpatialIndex\n"
        "points = np.random.default_rng(0).random((6_000_000, 3), np.float32)\n"
        "faces = np.arange(6_000_000, dtype=np.uint32).reshape(-1, 3)\n"
        "threading.Timer(0.1, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
        "try:\n"
        "    while True:\n"
        "        SpatialIndex(points, faces)\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.stdout.split() == ["interrupted"], done.stderr
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_many_threads_ask_while_the_mesh_moves():
    """Each answer is for the mesh before a refit, or for the one after."""
    index = SpatialIndex(TERRAIN.vertices, TERRAIN.faces)
    shifted = moved(TERRAIN, (0, 0, 2))
    points = some_points(TERRAIN, np.random.default_rng(0), 2000)
    expected = []
    for mesh in (shifted, TERRAIN):
        index.refit(mesh.vertices)
        expected.append(index.closest_batch(points=points))
    wrong = []

    def ask():
        for _ in range(10):
            found = index.closest_batch(points=points)
            if not any(same(found, answer) for answer in expected):
                wrong.append(found)

    threads = [threading.Thread(target=ask) for _ in range(3)]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        index.refit(shifted.vertices)
        index.refit(TERRAIN.vertices)
    assert not wrong


def test_queries_are_counted():
    index = SpatialIndex(CORNERS, [[0, 1, 2]], device="off")
    before = query_counts()["native"]
    index.cast(origin=(0, 0, 1), direction=(0, 0, 1))
    index.cast_batch(origins=(0, 0, 1), directions=np.ones((7, 3)))
    index.closest_batch(points=np.ones((5, 3)))
    index.in_sphere(center=(0, 0, 0), radius=1)
    index.in_box(center=(0, 0, 0), axes=np.eye(3), half_size=(1, 1, 1))
    index.in_polygon(polygon=np.ones((3, 2)), view_projection=np.eye(4))
    after = query_counts()["native"]
    counts = {query: after[query] - before[query] for query in after}
    assert counts == {"ray": 8, "closest_point": 5, "sphere": 1, "frustum": 1, "lasso": 1}


def test_kernels_refuse_arrays_of_another_type():
    bvh = SpatialIndex(CORNERS, [[0, 1, 2]]).native
    floats = np.zeros((2, 3), np.float32)
    with pytest.raises(ValueError, match="directions has to be an array of float64"):
        bvh._cast_batch(np.zeros((1, 3)), floats, np.ones(1), True, None, 0, None)
    with pytest.raises(ValueError, match="index 7"):
        region = _kernels._sphere((0, 0, 0), 1.0)
        bvh._seen(region, np.array([7], np.uint32), (0, 0, 0), lambda *rays: None)


def test_a_process_that_is_spawned_finds_the_kernels(tmp_path):
    script = tmp_path / "spawn.py"
    script.write_text(
        "import multiprocessing\n"
        "from mesh_map import SpatialIndex\n"
        "def ask():\n"
        "    index = SpatialIndex([[1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2]])\n"
        "    assert index.cast(origin=(1, 1, 1), direction=(-1, -1, -1)).face == 0\n"
        "if __name__ == '__main__':\n"
        "    child = multiprocessing.get_context('spawn').Process(target=ask)\n"
        "    child.start()\n"
        "    child.join(60)\n"
        "    print(child.exitcode)\n"
    )
    done = subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.stdout.split() == ["0"], done.stderr

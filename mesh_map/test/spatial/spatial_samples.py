"""Meshes and queries for the tests of the spatial index, and its back ends."""

import functools

import numpy as np
import pytest
from mesh_map.spatial.opencl.device import list_devices
from mesh_map.spatial.spatial_index import SpatialIndex
from meshes import SMALL, TestMesh, terrain

BACK_ENDS = pytest.mark.parametrize("back_end", ["native", "opencl"])


@functools.lru_cache(maxsize=None)
def why_no_opencl():
    """Empty where there is an OpenCL device."""
    try:
        devices, _ = list_devices()
    except ImportError as error:
        return "no pyopencl: %s" % error
    except Exception as error:  # the loader has errors of its own for no platform
        return "no OpenCL platform: %s" % error
    return "" if devices else "no OpenCL device"


def need_opencl():
    """Skips the test where no OpenCL device is."""
    if why_no_opencl():
        pytest.skip(why_no_opencl())


def index_of(mesh, back_end="native"):
    """An index whose device is ready where that is tested."""
    if back_end == "opencl":
        need_opencl()
    index = SpatialIndex(mesh.vertices, mesh.faces)
    if back_end == "opencl":
        assert index.wait_for_device(), index.device
    return index


def same(one, other):
    """Whether answers have the same bits (arrays, tuples of them, or None)."""
    if one is None or other is None:
        return one is other
    if not isinstance(one, tuple):
        one, other = (one,), (other,)
    pairs = [(np.asarray(a), np.asarray(b)) for a, b in zip(one, other)]
    return all(a.dtype == b.dtype and a.tobytes() == b.tobytes() for a, b in pairs)


def moved(mesh, offset):
    vertices = (mesh.vertices + np.float64(offset)).astype(np.float32)
    return TestMesh("%s_at_%g" % (mesh.name, np.max(offset)), vertices, mesh.faces)


def identical_triangles(count):
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.5]], np.float32)
    return TestMesh("identical", vertices, np.tile(np.array([[0, 1, 2]], np.uint32), (count, 1)))


def with_giant(mesh):
    """One triangle a million times larger than the rest."""
    size = 1e6 * np.linalg.norm(mesh.vertices[mesh.faces[0, 0]] - mesh.vertices[mesh.faces[0, 1]])
    low = mesh.vertices.min(0)
    giant = [[-size, -size, low[2] - 1], [size, -size, low[2] - 1], [0, size, low[2] - 1]]
    vertices = np.concatenate([mesh.vertices, np.array(giant, np.float32)])
    count = len(mesh.vertices)
    faces = np.concatenate([mesh.faces, [[count, count + 1, count + 2]]]).astype(np.uint32)
    return TestMesh(mesh.name + "_and_giant", vertices, faces)


def slivers(count=60):
    """Faces of 1 m by less and less, and some without area."""
    random = np.random.default_rng(2)
    a = random.uniform(-1, 1, (count, 3))
    way = random.normal(size=(count, 3))
    b = a + way / np.linalg.norm(way, axis=1, keepdims=True)
    width = 10.0 ** -np.linspace(1, 12, count)[:, None]
    c = a + 0.4 * (b - a) + width * random.normal(size=(count, 3))
    c[::10] = b[::10]
    vertices = np.stack([a, b, c], 1).reshape(-1, 3).astype(np.float32)
    return TestMesh("slivers", vertices, np.arange(3 * count, dtype=np.uint32).reshape(-1, 3))


TERRAIN = terrain(24)
ADVERSARIAL = SMALL + [
    TERRAIN,
    moved(TERRAIN, (1e6, -1e6, 1e6)),
    moved(slivers(), 1e5),
    identical_triangles(300),
    with_giant(TERRAIN),
    slivers(),
]
adversarial = pytest.mark.parametrize("mesh", ADVERSARIAL, ids=[m.name for m in ADVERSARIAL])


def some_points(mesh, random, count):
    """Around the mesh, on vertices, on edges, on faces, and far away."""
    used = mesh.vertices[mesh.faces].astype(np.float64)
    low, high = used.min((0, 1)), used.max((0, 1))
    size = high - low + 0.1
    around = random.uniform(low - 0.3 * size, high + 0.3 * size, (count, 3))
    weights = random.dirichlet((1, 1, 1), count)
    weights[::3, 0] = 0
    weights[::5, 1] = 0
    weights[1::7] = (1, 0, 0)
    weights /= np.maximum(weights.sum(1, keepdims=True), 1e-9)
    corners = used[random.integers(0, len(used), count)]
    on_mesh = np.einsum("nk,nkd->nd", weights, corners)
    far = around[: count // 4] + 1e6 * random.choice([-1, 0, 1], (count // 4, 3))
    return np.concatenate([around, on_mesh, far])


def some_rays(mesh, random, count):
    """Origins, directions and maximum distances, as unpleasant as they get."""
    origins = some_points(mesh, random, count)
    targets = some_points(mesh, random, count)
    random.shuffle(targets)
    directions = targets - origins
    number = np.arange(len(origins))
    along = number % 4 == 0  # along axes, many in planes of boxes
    directions[along] = np.eye(3)[random.integers(0, 3, along.sum())] * random.choice(
        [-1.0, 1.0], (along.sum(), 1)
    )
    directions[number % 11 == 5] *= 1e-30
    directions[number % 13 == 7] *= 1e30
    directions[number % 17 == 3, 0] = 0.0
    directions[number % 29 == 11] = 0.0
    directions[number % 31 == 13, 1] = -0.0
    odd = np.array([np.nan, np.inf, -np.inf, 1e300, 1e-310])
    for array, step in ((origins, 37), (directions, 41)):
        rows = np.flatnonzero(number % step == 17)
        array[rows, random.integers(0, 3, len(rows))] = random.choice(odd, len(rows))
    limits = np.full(len(origins), np.inf)
    size = np.linalg.norm(np.ptp(mesh.vertices[mesh.faces], axis=(0, 1))) + 0.1
    limits[number % 6 == 1] = random.uniform(0, size, (number % 6 == 1).sum())
    limits[number % 43 == 2] = -1.0
    limits[number % 47 == 4] = np.nan
    limits[number % 53 == 6] = 0.0
    return origins, directions, limits


def camera(eye, target, columns=40, rows=30, near=0.1, far=100.0):
    """A view-projection matrix as OpenGL has it, and the six planes of its frustum: left, right,
    bottom, top, near and far.
    """
    back = np.subtract(eye, target) / np.linalg.norm(np.subtract(eye, target))
    up = (0, 0, 1) if abs(back[2]) < 0.9 else (0, 1, 0)
    right = np.cross(up, back) / np.linalg.norm(np.cross(up, back))
    rotation = np.stack([right, np.cross(back, right), back])
    view = np.eye(4)
    view[:3, :3], view[:3, 3] = rotation, -rotation @ eye
    tangent = 0.5
    projection = np.zeros((4, 4))
    projection[0, 0], projection[1, 1] = rows / (columns * tangent), 1 / tangent
    projection[2, 2:] = (near + far) / (near - far), 2 * near * far / (near - far)
    projection[3, 2] = -1
    matrix = projection @ view
    planes = [matrix[3] + sign * matrix[axis] for axis in range(3) for sign in (1, -1)]
    return matrix, np.array(planes)


def steep_rays(count=3_000_000, layers=3000):
    """A mesh and a batch that takes long: each ray runs through all faces, none of which counts."""
    random = np.random.default_rng(0)
    heights = np.repeat(np.arange(layers) * 1e-3, 3)
    vertices = np.column_stack([random.uniform(-1, 1, (3 * layers, 2)), heights])
    faces = np.arange(3 * layers, dtype=np.uint32).reshape(-1, 3)
    directions = np.column_stack([random.normal(0, 1e-5, (count, 2)), np.ones(count)])
    rays = {"origins": (0.0, 0.0, -1.0), "directions": directions, "mask": np.zeros(layers, bool)}
    return TestMesh("layers", vertices.astype(np.float32), faces), rays

"""Whether a device computes what it shall, before it is asked in earnest."""

from typing import Any

import numpy as np

from mesh_map import _kernels
from mesh_map.base.query_arguments import Rays
from mesh_map.spatial.opencl.device_queries import DeviceQueries
from mesh_map.spatial.opencl.program import DeviceProgram

_CELLS = 16  # per side


def check_device(program: DeviceProgram) -> None:
    """Compares the answers of all kernels about a wavy square with the native ones.

    Raises:
        RuntimeError: what is wrong.
    """
    bvh = wavy_square(_CELLS)
    device = DeviceQueries(program, bvh, 1)
    number = np.arange(300)  # the last fifth beside the mesh
    points = np.stack([0.07 * number, 0.05 * (37 * number % 300), np.full(300, 3.0)], 1)
    rays = Rays(points, np.tile([0.3, -0.2, -1.0], (300, 1)), np.array([np.inf]))
    native = bvh._cast_batch(*rays, True, None, 1, None)
    _expect("rays", device.cast(rays, True, None, False, None), native)
    any_hit = bvh._any_hit_batch(*rays, True, None, 1, None)
    _expect("any hits", device.cast(rays, True, None, True, None), (any_hit,))
    closest = bvh._closest_batch(points, np.inf, None, np.pi, None, 1, None)
    _expect("closest points", device.closest(points, np.inf, None, None), closest)
    axes = np.array([[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    box = _kernels._box((8.0, 8.0, 0.0), axes, (5.0, 3.0, 0.5))
    for region in (_kernels._sphere((5.0, 6.0, 0.0), 3.0), box):
        roots, _ = bvh._selection_roots(region)
        for inside in (False, True):
            found = device.select(region, roots, inside, None)
            _expect("selections", [(found,)], (bvh._select(region, inside, None),))


def wavy_square(cells: int) -> Any:
    """_kernels._Bvh of a wavy square of so many cells of 1 m per side, from 0, 0, 0 on."""
    x, y = np.meshgrid(np.arange(cells + 1.0), np.arange(cells + 1.0), indexing="ij")
    vertices = np.stack([x, y, np.sin(0.7 * x) * np.cos(0.5 * y)], -1).reshape(-1, 3)
    index = np.arange(len(vertices), dtype=np.uint32).reshape(x.shape)
    a, b = index[:-1, :-1].ravel(), index[1:, :-1].ravel()
    c, d = index[:-1, 1:].ravel(), index[1:, 1:].ravel()
    faces = np.stack([a, b, c, c, b, d], 1).reshape(-1, 3)
    return _kernels._Bvh._build(vertices.astype(np.float32), faces, 1, None, None)


def _expect(what: str, chunks: object, native: object) -> None:
    found = [np.concatenate(parts) for parts in zip(*chunks)]  # type: ignore[call-overload]
    if not all(np.array_equal(a, b) for a, b in zip(found, native)):  # type: ignore
        raise RuntimeError("the device computes %s wrongly" % what)

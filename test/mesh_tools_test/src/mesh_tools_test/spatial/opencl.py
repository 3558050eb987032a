"""Figures of batches on the OpenCL device, and of its start."""

import os
import statistics
import subprocess
import sys
import tempfile
from typing import Any, List, Optional

import numpy as np
from mesh_map.spatial.opencl.device import choose_device, device_wish, list_devices
from mesh_map.spatial.spatial_index import SpatialIndex, query_counts

from mesh_tools_test.base.figures import Figure, million_per_second, timed
from mesh_tools_test.spatial import questions
from mesh_tools_test.spatial.linear_scan import LinearScan
from mesh_tools_test.spatial.native import INCOHERENT, POINTS

# A new process: import of pyopencl; then until a device has answered for the first time.
START = """
import time
import numpy as np
from mesh_map.spatial.spatial_index import SpatialIndex
index = SpatialIndex(np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.uint32))
before = time.perf_counter()
import pyopencl
imported = time.perf_counter()
assert index.wait_for_device(), index.device
print(1000.0 * (imported - before), 1000.0 * (time.perf_counter() - imported))
"""


def device() -> Optional[Any]:
    """The device of pyopencl that the index takes, None where there is none."""
    try:
        devices, infos = list_devices()
        chosen = choose_device(infos, device_wish())
    except Exception:  # no pyopencl, no platform, a broken driver
        return None
    return None if chosen is None else devices[chosen]


def device_name() -> Optional[str]:
    """Its name, platform and driver."""
    found = device()
    if found is None:
        return None
    return "%s (%s, driver %s)" % (
        found.name.strip(),
        found.platform.name.strip(),
        found.driver_version,
    )


def measure(
    index: SpatialIndex, vertices: np.ndarray, scan: Optional[LinearScan], repeats: int
) -> List[Figure]:
    """One ray and batches through pyopencl, beside native code; the start of a device.

    :raises SystemExit: where the device does not answer, or otherwise than native code
    """
    if not index.wait_for_device():
        raise SystemExit(f"error: {index.device}")
    return (
        _one_ray(index, vertices, scan, repeats)
        + _batches(index, vertices, repeats)
        + _start(repeats)
    )


def _one_ray(
    index: SpatialIndex, vertices: np.ndarray, scan: Optional[LinearScan], repeats: int
) -> List[Figure]:
    view = questions.side_camera(vertices)
    direction = view.directions(*questions.PICTURE)[-1]
    caster = index.on_device()
    ours, _ = timed(
        lambda: caster.cast_batch(origins=view.eye, directions=direction[None]), 20 * repeats
    )
    peer = timed(lambda: scan.cast(view.eye, direction), repeats)[0] if scan is not None else None
    return [Figure("one ray through pyopencl", ours, "ms", "linear OpenCL scan", peer, 0.3)]


def _batches(index: SpatialIndex, vertices: np.ndarray, repeats: int) -> List[Figure]:
    figures = []
    for name, rays, floor in (
        ("coherent", questions.coherent_rays(vertices), 3.0),
        ("incoherent", questions.incoherent_rays(vertices, INCOHERENT), None),
    ):
        origins, directions = rays[:, :3].astype(np.float64), rays[:, 3:].astype(np.float64)
        figures.extend(
            _beside_native(
                name + " rays, OpenCL",
                "ray",
                "Mray/s",
                lambda back_end: index.cast_batch(
                    origins=origins, directions=directions, back_end=back_end
                ),
                len(rays),
                repeats,
                floor,
            )
        )
    points = questions.points_near(vertices, POINTS).astype(np.float64)
    figures.extend(
        _beside_native(
            "closest points, OpenCL",
            "closest_point",
            "Mpoint/s",
            lambda back_end: index.closest_batch(points=points, back_end=back_end),
            POINTS,
            repeats,
            None,
        )
    )
    return figures


def _beside_native(
    name: str, query: str, unit: str, ask: Any, count: int, repeats: int, floor: Optional[float]
) -> List[Figure]:
    """A batch on the device beside native code from Python, and by the chosen one; all answer
    alike, to the last bit."""
    ask("opencl")  # the mesh goes to the device
    before = query_counts()["opencl"][query]
    ours, answers = timed(lambda: ask("opencl"), repeats)
    if query_counts()["opencl"][query] - before != repeats * count:
        raise SystemExit(f"error: the OpenCL device did not answer all of: {name}")
    native, expected = timed(lambda: ask("native"), repeats)
    if not all(np.array_equal(a, b) for a, b in zip(answers, expected)):
        raise SystemExit(f"error: the OpenCL device answers otherwise than native code: {name}")
    rate, beside = (million_per_second(count, time) for time in (ours, native))
    figures = [Figure(name, rate, unit, "native, Python", beside, floor)]
    chosen = million_per_second(count, timed(lambda: ask("auto"), repeats)[0])
    better = max(rate, beside)
    return [*figures, Figure(name + ", as chosen", chosen, unit, "the faster of both", better)]


def _start(repeats: int) -> List[Figure]:
    """Milliseconds until a device answers: with empty caches, and in that many later processes."""
    times = []
    with tempfile.TemporaryDirectory() as cache:
        environment = dict(os.environ, XDG_CACHE_HOME=cache, POCL_CACHE_DIR=cache + "/pocl")
        for _ in range(1 + repeats):
            command = [sys.executable, "-c", START]
            printed = subprocess.run(
                command, stdout=subprocess.PIPE, check=True, env=environment
            ).stdout.decode()
            times.append([float(text) for text in printed.split()])
    imported, started = (statistics.median(column) for column in zip(*times[1:]))
    return [
        Figure("start of OpenCL, warm", started, "ms", "with empty caches", times[0][1], 60.0),
        Figure("import of pyopencl", imported, "ms"),
    ]

"""Whether a device that has the cores of native code, a CPU, is faster than that."""

import json
import os
import time
from typing import Any, Callable, Dict, Tuple

import numpy as np

from mesh_map import _kernels
from mesh_map.base.query_arguments import Rays
from mesh_map.spatial.opencl.check import wavy_square
from mesh_map.spatial.opencl.device_queries import DeviceQueries
from mesh_map.spatial.opencl.program import DeviceProgram
from mesh_map.spatial.opencl.program_cache import ProgramCache

BATCH = 1 << 16  # rays and points: tens of milliseconds
MARGIN = 0.8  # of the native time, which a device that is faster takes at most
_CELLS = 200  # per side of the mesh
_REPEATS = 3

Seconds = Dict[str, Tuple[float, float]]  # of each query: natively, and on the device


def faster_from(program: DeviceProgram, cache: ProgramCache) -> Dict[str, int]:
    """{query: from which size of a batch on the device is faster}, queries as in query_counts().

    Measured once for a device, its driver, our code and the number of cores; what the cache keeps
    of that is used from then on.
    """
    seconds = _kept(cache, _key(program))
    if seconds is None:
        seconds = measured(program)
        cache.store(_key(program), json.dumps(seconds).encode())
    return {query: BATCH for query, (native, device) in seconds.items() if device < MARGIN * native}


def measured(program: DeviceProgram) -> Seconds:
    """The least of a few times of each batch."""
    bvh, random = wavy_square(_CELLS), np.random.default_rng(0)
    points = random.uniform((0, 0, 1.5), (_CELLS, _CELLS, 5), (BATCH, 3))
    rays = Rays(points, random.uniform((-1, -1, -1), (1, 1, -0.2), (BATCH, 3)), np.array([np.inf]))
    device = DeviceQueries(program, bvh, 0)
    return {
        "ray": _compared(
            lambda: bvh._cast_batch(*rays, True, None, 0, None),
            lambda: list(device.cast(rays, True, None, False, None)),
        ),
        "closest_point": _compared(
            lambda: bvh._closest_batch(points, np.inf, None, np.pi, None, 0, None),
            lambda: list(device.closest(points, np.inf, None, None)),
        ),
    }


def _compared(native: Callable[[], Any], device: Callable[[], Any]) -> Tuple[float, float]:
    device()  # some drivers compile for the size of a batch
    pairs = [(_seconds(native), _seconds(device)) for _ in range(_REPEATS)]
    return min(pair[0] for pair in pairs), min(pair[1] for pair in pairs)


def _seconds(ask: Callable[[], Any]) -> float:
    begin = time.perf_counter()
    ask()
    return time.perf_counter() - begin


def _key(program: DeviceProgram) -> str:
    built = os.stat(_kernels.__file__)
    code = "%d %d" % (built.st_size, built.st_mtime_ns)
    return "\n".join(("seconds", program.key, code, str(os.cpu_count())))


def _kept(cache: ProgramCache, key: str) -> Any:
    """What measured() gave; None where there is none, or it cannot be that."""
    try:
        found = json.loads(cache.load(key) or b"")
        return {query: (float(native), float(device)) for query, (native, device) in found.items()}
    except (ValueError, TypeError, AttributeError):
        return None

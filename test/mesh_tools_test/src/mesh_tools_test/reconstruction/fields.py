"""Times and memory of a field and its surface."""

import json
import subprocess
import sys
import tempfile
import time
from typing import List, NamedTuple

import numpy as np

from mesh_tools_test.base.figures import Figure
from mesh_tools_test.reconstruction.scene import VOXEL, Scene

FLOORS = {VOXEL: 0.4, 0.05: 0.8}  # s for a million points, with colors
MOST_MEGABYTES = 40.0

# A process that reads scan after scan from a folder into a field, and takes the surface out of it.
# Prints in bytes: the field; the most that the process had more than before, less the surface.
_GROWING = """
import glob, json, sys
import numpy
from mesh_map.reconstruction.signed_distance import SignedDistanceField
def memory(name):
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith(name)) * 1024
before = memory("VmRSS")
field = SignedDistanceField(voxel_size=float(sys.argv[2]), colors=True)
for path in sorted(glob.glob(sys.argv[1] + "/*.npz")):
    with numpy.load(path) as scan:
        field.integrate(scan["points"], scan["origin"], colors=scan["colors"])
found = field.extract()
arrays = found.vertices, found.faces, found.normals, found.colors, found.observations
mesh = sum(array.nbytes for array in arrays)
print(json.dumps([field.memory, memory("VmHWM") - before - mesh]))
"""


class Times(NamedTuple):
    """s for a million points; processor: of all threads together."""

    integrate: float
    extract: float
    processor: float

    @property
    def both(self) -> float:
        """To integrate and to extract."""
        return self.integrate + self.extract


def measure(scene: Scene, repeats: int) -> List[Figure]:
    """Integration and extraction beside one thread; memory."""
    figures = []
    for voxel_size, floor in FLOORS.items():
        ours, single = (times(scene, voxel_size, threads, repeats) for threads in (0, 1))
        name, peer = "integrate and extract, voxel %.2f m" % voxel_size, "one thread"
        figures += [
            Figure(name, ours.both, "s/M", peer, single.both, floor),
            Figure("  integrate", ours.integrate, "s/M", peer, single.integrate),
            Figure("  extract", ours.extract, "s/M", peer, single.extract),
            # What a busy machine does not make longer.
            Figure("  processor time", ours.processor, "s/M", peer, single.processor),
        ]
    field_bytes, peak = memory(scene, VOXEL)
    name = "memory of the field, voxel %.2f m" % VOXEL
    figures.append(Figure(name, field_bytes / 1e6, "MB", floor=MOST_MEGABYTES))
    figures.append(Figure("  of a process at most, beyond the mesh", peak / 1e6, "MB"))
    return figures


def times(scene: Scene, voxel_size: float, threads: int, repeats: int) -> Times:
    """Medians of a field that is filled, and of the surface taken out of it."""
    rows = []
    for _ in range(repeats):
        processor, begin = time.process_time(), time.perf_counter()
        field = scene.field(voxel_size, threads)
        filled = time.perf_counter()
        field.extract()
        end = time.perf_counter()
        rows.append((filled - begin, end - filled, time.process_time() - processor))
    return Times(*(float(value) / scene.points for value in np.median(rows, axis=0)))


def memory(scene: Scene, voxel_size: float) -> List[int]:
    """Bytes of the field, and what a process takes for it at most, beyond the mesh."""
    with tempfile.TemporaryDirectory() as folder:
        for number, scan in enumerate(scene.scans):
            np.savez(
                "%s/%05d.npz" % (folder, number),
                points=scan.in_map(),
                origin=scan.origins_in_map(),
                colors=scan.colors,
            )
        command = [sys.executable, "-c", _GROWING, folder, str(voxel_size)]
        output = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout
    field_bytes, peak = json.loads(output.decode())
    return [int(field_bytes), int(peak)]

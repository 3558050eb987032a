"""A process ends as it should, whatever threads of it are just computing."""

import subprocess
import sys

BUSY = """
import sys, threading, time
import numpy as np
from mesh_map import SpatialIndex
vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
index = SpatialIndex(vertices, np.array([[0, 1, 2]], np.uint32), device="off")
above, down = np.tile([0.2, 0.2, 1.0], (2000, 1)), np.tile([0.0, 0.0, -1.0], (2000, 1))
begun = threading.Barrier(5)

def work():
    index.cast_batch(origins=above, directions=down)
    begun.wait(60)
    while True:
        index.cast_batch(origins=above, directions=down)

for _ in range(4):
    threading.Thread(target=work, daemon=True).start()
begun.wait(60)
print("ends")
"""


def test_a_process_that_ends_while_threads_are_in_native_code():
    """Python ends them when they come back; native code below them must not abort the process."""
    command = [sys.executable, "-c", BUSY]
    for _ in range(10):
        ended = subprocess.run(command, capture_output=True, text=True, timeout=120)
        assert (ended.returncode, ended.stdout, ended.stderr) == (0, "ends\n", "")

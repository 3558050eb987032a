"""The C++ side of the benchmark, where Embree 3 answers the same questions."""

import os
import subprocess
import tempfile
from typing import Dict, Optional

import numpy as np

from mesh_tools_test.base.programs import find_program

PROGRAM = "spatial_index_embree"  # not built where Embree 3 was not there


def run(arrays: Dict[str, np.ndarray], repeats: int) -> Optional[Dict[str, float]]:
    """Every figure of the C++ program by its name (medians in milliseconds), None without it.

    :param arrays: file name -> array: `vertices.f32`, `faces.u32`, `coherent.f32`,
        `incoherent.f32` (6 numbers a ray), `points.f32`
    """
    program = find_program(PROGRAM)
    if program is None:
        return None
    with tempfile.TemporaryDirectory(prefix="spatial_index") as folder:
        for name, array in arrays.items():
            np.ascontiguousarray(array).tofile(os.path.join(folder, name))
        printed = subprocess.run(
            [program, folder, str(repeats)], stdout=subprocess.PIPE, check=True
        ).stdout.decode()
    return {name: float(value) for name, value in map(str.split, printed.splitlines())}

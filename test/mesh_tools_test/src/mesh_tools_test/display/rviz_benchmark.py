"""The figures of benchmark/rviz_display.py: RViz shows one mesh in three ways, one process each."""

import os
import tempfile
from pathlib import Path
from typing import Dict, List, NamedTuple, Optional, Tuple

import numpy as np

from mesh_tools_test.base.figures import Figure
from mesh_tools_test.base.programs import run_in_rviz

PROGRAM = "rviz_display_benchmark"
SUBJECTS = ("mesh", "marker", "manual_object")
PEERS = {"marker": "Marker", "manual_object": "ManualObject"}
SECONDS = 900.0  # of one process
FLOORS_HOLD = 2_000_000  # faces
LARGE = 10_000_000

Values = Dict[str, float]

# name of the figure, name in the C++ program, unit, floor at 2 and at 10 million faces
ROWS: Tuple[Tuple[str, str, str, Optional[float], Optional[float]], ...] = (
    ("message to first picture", "show_first", "ms", None, 1000),
    ("message to complete picture", "show_complete", "ms", 1000, 6000),
    ("longest update(), while it loads", "show_update", "ms", 50, 50),
    ("longest GUI block without drawing", "show_block", "ms", 50, 50),
    ("memory kept, host and GPU", "memory", "MB", None, None),
    ("memory at its peak, with the message", "memory_peak", "MB", None, None),
    ("memory kept, with two cost layers", "memory_layers", "MB", None, None),
    ("layer switch, CPU without drawing", "switch_cpu", "ms", None, None),
    ("layer switch, longest update()", "switch_update", "ms", 50, 50),
    ("layer switch, to the complete picture", "switch_complete", "ms", None, None),
    ("1 M sparse values, GUI at a time", "gui_sparse", "ms", 50, 50),
    ("1 M sparse values, GUI in all", "gui_sparse_all", "ms", None, None),
    ("100,000 at 100 Hz, GUI at a time", "gui_stream", "ms", 50, 50),
    ("100,000 at 100 Hz for 2 s, GUI in all", "gui_stream_all", "ms", None, None),
    ("8192 x 8192 texture, GUI at a time", "gui_texture", "ms", None, None),
    ("8192 x 8192 texture, GUI in all", "gui_texture_all", "ms", None, None),
    ("memory kept of that texture", "memory_texture", "MB", 400, 400),
    ("frame, mesh far away", "frame_far", "ms", 80, 120),
    ("frame, mesh fills the window", "frame_full", "ms", None, None),
    ("frame, camera inside", "frame_inside", "ms", 150, 150),
)
MEGABYTES = ("memory", "memory_peak", "memory_layers", "memory_texture")


class Setup(NamedTuple):
    """How it is run: how long a picture must stay the same, and where pictures go, if anywhere."""

    quiet: float
    pictures: Optional[Path] = None


def run_subject(program: str, folder: str, subject: str, setup: Setup) -> Values:
    """What the C++ program prints for one way to show the mesh in `folder`.

    :raises RuntimeError: with the end of its errors, if it fails.
    """
    arguments = [folder, subject, str(setup.quiet)]
    arguments += [str(setup.pictures)] if setup.pictures else []
    return run_in_rviz(program, arguments, SECONDS)


def write_world(folder: str, vertices: np.ndarray, faces: np.ndarray) -> None:
    """The mesh as the C++ programs read it."""
    np.ascontiguousarray(vertices, np.float32).tofile(os.path.join(folder, "vertices.f32"))
    np.ascontiguousarray(faces, np.uint32).tofile(os.path.join(folder, "faces.u32"))


def measure(
    program: str, vertices: np.ndarray, faces: np.ndarray, subjects: List[str], setup: Setup
) -> Dict[str, Values]:
    """The values of each way, run one after the other on the same mesh."""
    with tempfile.TemporaryDirectory(prefix="rviz_display") as folder:
        write_world(folder, vertices, faces)
        return {name: run_subject(program, folder, name, setup) for name in subjects}


def geometry_floor(vertex_count: int, face_count: int) -> float:
    """GPU bytes of geometry and one color; levels of detail may take half as much again."""
    return 1.5 * (40.0 * vertex_count + 12.0 * face_count)


def figures(values: Dict[str, Values], vertex_count: int, face_count: int) -> List[Figure]:
    """The table: ours with its floor, then beside each peer that was run."""
    ours = values["mesh"]
    column = {FLOORS_HOLD: 0, LARGE: 1}.get(face_count)
    found: List[Figure] = []

    def add(name: str, key: str, unit: str, floor: Optional[float]) -> None:
        scale = 1e-6 if key in MEGABYTES or key == "gpu" else 1.0
        peers = [peer for peer in PEERS if key in values.get(peer, {})]
        for i, peer in enumerate(peers or [""]):
            value = scale * values[peer][key] if peer else None
            limit = floor if i == 0 else None
            found.append(Figure(name, scale * ours[key], unit, PEERS.get(peer, ""), value, limit))

    for name, key, unit, *floors in ROWS:
        add(name, key, unit, None if column is None else floors[column])
    per_million = 100.0 * vertex_count / 1e6 if column is not None else None
    found = [
        f._replace(floor=per_million) if f.name.startswith("layer switch, CPU") and i == 0 else f
        for i, f in _numbered(found)
    ]
    add("GPU buffers", "gpu", "MB", 1e-6 * geometry_floor(vertex_count, face_count))
    return found


def _numbered(found: List[Figure]) -> List[Tuple[int, Figure]]:
    """Each figure with how many of the same name come before it."""
    names = [figure.name for figure in found]
    return [(names[:i].count(figure.name), figure) for i, figure in enumerate(found)]


def drawn(values: Dict[str, Values], face_count: int) -> str:
    """How many triangles went to OpenGL in each view."""
    lines = []
    for view in ("far", "full", "inside"):
        counts = [f"{name} {int(result[f'triangles_{view}']):,}" for name, result in values.items()]
        lines.append(f"triangles drawn, {view}: {', '.join(counts)} of {face_count:,}")
    return "\n".join(lines)

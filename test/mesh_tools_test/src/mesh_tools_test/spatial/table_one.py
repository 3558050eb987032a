"""Table 1 of the paper (selection times of its datasets), measured on worlds of as many faces."""

from typing import Any, List, NamedTuple, Tuple

import numpy as np
from mesh_map.spatial.spatial_index import SpatialIndex

from mesh_tools_test.base.exact_world import exact_world
from mesh_tools_test.base.figures import timed
from mesh_tools_test.spatial import questions
from mesh_tools_test.spatial.linear_scan import LinearScan

# name, triangles, and the paper's milliseconds for Single, Box and Radius
DATASETS = (
    ("Botanical Garden", 1_430_188, 104.3, 101.8, 147.3),
    ("Stone Quarry", 1_904_178, 148.6, 146.0, 267.4),
    ("Physics Campus", 1_617_772, 97.1, 121.4, 134.8),
    ("Farmer's Pit", 794_509, 82.5, 81.8, 90.1),
    ("Market Garden", 2_656_283, 168.6, 189.0, 214.8),
)
BOX_FACES, RADIUS = 31_000, 1.0
DIRECTION = np.array([0.002, 0.001, -1.0])  # downwards, into no edge


class Selections(NamedTuple):
    """Milliseconds of the three modes."""

    single: float
    box: float
    radius: float


def measure(faces: int, repeats: int, device: Any) -> Tuple[Selections, Selections]:
    """Ours, and those of the linear scan on an OpenCL device (zeros where that is None)."""
    vertices, triangles = exact_world(faces)
    index = SpatialIndex(vertices, triangles)
    view = questions.top_camera(vertices)
    origin, direction = view.eye, DIRECTION / np.linalg.norm(DIRECTION)
    hit = index.cast(origin=origin, direction=direction)
    middle = origin + hit.distance * direction
    planes, _ = questions.rectangle_of(
        view, min(BOX_FACES, faces // 4), lambda planes: index.in_frustum(planes=planes)
    )

    def brush() -> np.ndarray:
        where = index.cast(origin=origin, direction=direction)
        return index.in_sphere(center=origin + where.distance * direction, radius=RADIUS)

    ours = Selections(
        timed(lambda: index.cast(origin=origin, direction=direction), 20 * repeats)[0],
        timed(lambda: index.in_frustum(planes=planes), 5 * repeats)[0],
        timed(brush, 20 * repeats)[0],
    )
    if device is None:
        return ours, Selections(0.0, 0.0, 0.0)
    peer = LinearScan(vertices, triangles, device)
    if peer.cast(origin, direction) != hit.face:
        raise SystemExit("error: the linear scan picks another face")

    def scan_brush() -> np.ndarray:
        peer.cast(origin, direction)
        return peer.in_sphere(middle, RADIUS)

    return ours, Selections(
        timed(lambda: peer.cast(origin, direction), repeats)[0],
        timed(lambda: peer.in_planes(planes), repeats)[0],
        timed(scan_brush, repeats)[0],
    )


def table(repeats: int, device: Any) -> str:
    """A Markdown table: ours, the paper's, and the linear scan's milliseconds for each mode."""
    head = ["dataset", "triangles"]
    for mode in ("Single", "Box", "Radius"):
        head += [mode, "paper"] + (["linear scan"] if device is not None else [])
    rows: List[List[str]] = [head, ["---"] + ["---:"] * (len(head) - 1)]
    for name, faces, *paper in DATASETS:
        ours, peers = measure(faces, repeats, device)
        row = [name, f"{faces:,}"]
        for mode, published, peer in zip(ours, paper, peers):
            row += ["%.4f" % mode, "%.1f" % published] + (
                ["%.1f" % peer] if device is not None else []
            )
        rows.append(row)
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)

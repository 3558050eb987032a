"""Figures of single questions and selections from Python, beside the linear OpenCL scan."""

from typing import List, Optional

import numpy as np
from mesh_map.spatial.spatial_index import SpatialIndex

from mesh_tools_test.base.figures import Figure, timed
from mesh_tools_test.spatial import questions
from mesh_tools_test.spatial.linear_scan import LinearScan

SCAN = "linear OpenCL scan"
BOX_FACES, LARGE_BOX_SHARE = 31_000, 0.65  # the latter is 1.3 of 2 million
VISIBLE_PIXELS = (100, 80)


def measure(
    index: SpatialIndex, vertices: np.ndarray, scan: Optional[LinearScan], repeats: int
) -> List[Figure]:
    """Picks, spheres, boxes, lasso and visible faces."""
    figures = _picks(index, vertices, scan, repeats)
    center = questions.points_near(vertices, 1)[0].astype(np.float64)
    for radius, floor in ((1.0, 0.05), (5.0, None)):
        ours, faces = timed(lambda r=radius: index.in_sphere(center=center, radius=r), 10 * repeats)
        peer = None
        if scan is not None:
            peer, _ = timed(lambda r=radius: scan.in_sphere(center, r), repeats)
        name = "sphere of %g m, %d faces" % (radius, len(faces))
        figures.append(Figure(name, ours, "ms", SCAN, peer, floor))
    return figures + _boxes(index, vertices, scan, repeats) + _visible(index, vertices, repeats)


def _picks(
    index: SpatialIndex, vertices: np.ndarray, scan: Optional[LinearScan], repeats: int
) -> List[Figure]:
    view = questions.side_camera(vertices)
    count = 1000
    directions = view.directions(*questions.PICTURE)
    directions = directions[:: len(directions) // count][:count]

    def picks() -> None:
        for direction in directions:
            index.cast(origin=view.eye, direction=direction)

    time_picks, _ = timed(picks, repeats)
    peer = None
    if scan is not None:
        peer = 1000.0 * timed(lambda: scan.cast(view.eye, directions[-1]), 2 * repeats)[0]
    point = questions.points_near(vertices, 1)[0].astype(np.float64)
    closest, _ = timed(lambda: index.closest(point=point), 100 * repeats)
    return [
        Figure("pick, Python", 1000.0 * time_picks / count, "us", SCAN, peer),
        Figure("closest point, Python", 1000.0 * closest, "us"),
    ]


def _boxes(
    index: SpatialIndex, vertices: np.ndarray, scan: Optional[LinearScan], repeats: int
) -> List[Figure]:
    """The rectangle of Table 1, a large one, and a lasso of 32 corners."""
    view = questions.top_camera(vertices)
    figures = []
    sizes = (min(BOX_FACES, index.face_count // 4), int(LARGE_BOX_SHARE * index.face_count))
    for wanted, floor in zip(sizes, (0.2, 4.0)):
        planes, _ = questions.rectangle_of(view, wanted, lambda p: index.in_frustum(planes=p))
        ours, faces = timed(lambda p=planes: index.in_frustum(planes=p), 3 * repeats)
        peer = timed(lambda p=planes: scan.in_planes(p), repeats)[0] if scan is not None else None
        name = "box, {:,} faces".format(len(faces))
        figures.append(Figure(name, ours, "ms", SCAN, peer, floor))
    angle = np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)
    radius = 0.1 * (1.0 + 0.3 * np.sin(5.0 * angle))
    polygon = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    ours, faces = timed(
        lambda: index.in_polygon(polygon=polygon, view_projection=view.view_projection), repeats
    )
    return figures + [Figure("lasso, {:,} faces".format(len(faces)), ours, "ms")]


def _visible(index: SpatialIndex, vertices: np.ndarray, repeats: int) -> List[Figure]:
    """What shows in a part of the picture of 100 x 80 pixels."""
    view = questions.side_camera(vertices)
    share = [part / whole for part, whole in zip(VISIBLE_PIXELS, questions.PICTURE)]
    planes = view.planes(*share)
    ours, faces = timed(
        lambda: index.in_frustum(
            planes=planes, mode="visible", eye=view.eye, pixels=VISIBLE_PIXELS
        ),
        3 * repeats,
    )
    touched, others = timed(lambda: index.in_frustum(planes=planes), repeats)
    name = "visible in %d x %d pixels, %d faces" % (*VISIBLE_PIXELS, len(faces))
    behind = "all {:,} touched".format(len(others))
    return [Figure(name, ours, "ms", behind, touched, 5.0)]

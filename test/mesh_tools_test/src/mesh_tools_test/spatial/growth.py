"""How each time grows with the mesh."""

import numpy as np
from mesh_map.spatial.spatial_index import SpatialIndex
from typing import Any, Callable, Dict, List

from mesh_tools_test.base.exact_world import exact_world
from mesh_tools_test.base.figures import timed
from mesh_tools_test.base.growth import Growth
from mesh_tools_test.spatial import questions

SIZES = (10_000, 100_000, 1_000_000)
LARGE = 10_000_000
RAYS = 100_000


def times(faces: int, repeats: int) -> Dict[str, float]:
    """Milliseconds by question, on a world of that many faces."""
    vertices, triangles = exact_world(faces)
    built, index = timed(lambda: SpatialIndex(vertices, triangles), min(repeats, 3))
    rays = questions.coherent_rays(vertices)[:: 1_024_000 // RAYS].astype(np.float64)
    points = questions.points_near(vertices, RAYS).astype(np.float64)
    center = points[0]
    planes, _ = questions.rectangle_of(
        questions.top_camera(vertices), faces // 4, lambda planes: index.in_frustum(planes=planes)
    )
    actions: Dict[str, Callable[[], Any]] = {
        "1000 picks": lambda: [
            index.cast(origin=ray[:3], direction=ray[3:]) for ray in rays[:: RAYS // 1000]
        ],
        "100,000 rays": lambda: index.cast_batch(
            origins=rays[:, :3], directions=rays[:, 3:], back_end="native"
        ),
        "100,000 closest points": lambda: index.closest_batch(points=points, back_end="native"),
        "sphere of 1 m": lambda: index.in_sphere(center=center, radius=1.0),
        "a quarter of the faces": lambda: index.in_frustum(planes=planes),
    }
    result = {"build": built}
    result.update({name: timed(action, repeats)[0] for name, action in actions.items()})
    return result


def measured(sizes: List[int], repeats: int) -> Growth:
    """On worlds of so many faces."""
    return Growth("faces", sizes, [times(size, repeats) for size in sizes])

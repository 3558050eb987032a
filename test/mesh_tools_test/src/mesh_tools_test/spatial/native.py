"""Figures of the C++ library beside Embree, in one process."""

from typing import Dict, List, Optional

import numpy as np

from mesh_tools_test.base.figures import Figure, million_per_second
from mesh_tools_test.spatial import embree, questions

INCOHERENT, POINTS = 500_000, 200_000

# name, name in the C++ program, unit, peer, name of the peer there, floor
ROWS = (
    ("build, all cores", "build", "ms", "Embree, low quality", "embree_build_low", 400),
    ("build, all cores", "build", "ms", "Embree, medium", "embree_build_medium", None),
    ("build, all cores", "build", "ms", "Embree, high", "embree_build_high", None),
    ("build, one thread", "build_one", "ms", "Embree, low", "embree_build_low_one", None),
    ("refit", "refit", "ms", "Embree", "embree_refit", None),
    ("serialize", "serialize", "ms", None, None, None),
    ("deserialize", "deserialize", "ms", "build", "build", None),
    ("memory per face", "memory", "B", "Embree", "embree_memory", 80),
    ("serialized, per face", "serialized", "B", None, None, None),
    ("pick, C++", "pick", "us", "Embree Intersect1", "embree_pick", 10),
    ("coherent rays, all cores", "coherent", "Mray/s", "Intersect1", "embree_coherent_1", 5),
    ("coherent rays, all cores", "coherent", "Mray/s", "Intersect8", "embree_coherent_8", None),
    (
        "coherent rays, all cores",
        "coherent",
        "Mray/s",
        "Intersect1, robust",
        "embree_coherent_robust",
        None,
    ),
    ("coherent rays, one", "coherent_one", "Mray/s", "Intersect1", "embree_coherent_1_one", None),
    ("any hit, coherent", "coherent_any", "Mray/s", "Occluded1", "embree_coherent_any", None),
    ("incoherent rays", "incoherent", "Mray/s", "Intersect1", "embree_incoherent_1", None),
    ("incoherent rays", "incoherent", "Mray/s", "Intersect8", "embree_incoherent_8", None),
    (
        "incoherent rays, one",
        "incoherent_one",
        "Mray/s",
        "Intersect1",
        "embree_incoherent_1_one",
        None,
    ),
    ("any hit, incoherent", "incoherent_any", "Mray/s", "Occluded1", "embree_incoherent_any", None),
    ("closest points", "closest", "Mpoint/s", "point query", "embree_closest", None),
    ("sphere of 1 m, C++", "sphere_1", "ms", "point query", "embree_sphere_1", 0.05),
    ("sphere of 5 m, C++", "sphere_5", "ms", "point query", "embree_sphere_5", None),
)


def arrays_for(vertices: np.ndarray, faces: np.ndarray) -> Dict[str, np.ndarray]:
    """The files of the C++ program."""
    return {
        "vertices.f32": vertices,
        "faces.u32": faces,
        "coherent.f32": questions.coherent_rays(vertices),
        "incoherent.f32": questions.incoherent_rays(vertices, INCOHERENT),
        "points.f32": questions.points_near(vertices, POINTS),
    }


def in_unit(unit: str, milliseconds: float, count: int) -> float:
    """A figure of the C++ program in the unit of its row (1000 picks in ms are a pick in us)."""
    return million_per_second(count, milliseconds) if unit.endswith("/s") else milliseconds


def measure(vertices: np.ndarray, faces: np.ndarray, repeats: int) -> Optional[List[Figure]]:
    """Figures beside Embree; None where its program was not built."""
    arrays = arrays_for(vertices, faces)
    measured = embree.run(arrays, repeats)
    if measured is None:
        return None
    counts = {"coherent": len(arrays["coherent.f32"]), "incoherent": INCOHERENT, "closest": POINTS}
    figures = []
    for name, key, unit, peer, peer_key, floor in ROWS:
        count = counts.get(key.split("_")[0], 0)
        value = in_unit(unit, measured[key], count)
        beside = in_unit(unit, measured[peer_key], count) if peer_key else None
        figures.append(Figure(name, value, unit, peer or "", beside, floor))
    return figures + _agreement(measured, counts)


def _agreement(measured: Dict[str, float], counts: Dict[str, int]) -> List[Figure]:
    """How many of Embree's answers, which are in single precision, are not ours."""
    figures = []
    for name, count in counts.items():
        differ = measured[name + "_hit_by_one_only"] + measured[name + "_other_distance"]
        if differ > 1e-3 * count:
            raise SystemExit(f"error: {differ:.0f} of {count} {name} answers differ from Embree's")
        figures.append(Figure(f"{name}: answers unlike Embree's", differ, f"of {count}"))
    for name in ("sphere_1", "sphere_5"):
        if measured[name + "_faces"] != measured[f"embree_{name}_faces"]:
            raise SystemExit(f"error: {name} finds other faces than Embree")
    return figures

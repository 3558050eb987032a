"""Times of fields after local changes of costs, beside solving them anew."""

from typing import Callable, Dict, List

import numpy as np
from mesh_map.distance.wave_front import WaveFrontSolver

from mesh_tools_test.base.figures import Figure, timed
from mesh_tools_test.planning.world import PlanningWorld, patch

SIZES = (10, 100, 1_000, 10_000, 100_000)
DISTANCE = 30.0  # meters from the goal, where the costs change


def updates(world: PlanningWorld, repeats: int) -> List[Figure]:
    """The wave front after changes of more and more vertices, each costlier and back again."""
    front = WaveFrontSolver.of(world.geometry)
    before = (1.0 + world.costs).astype(np.float32)
    whole, field = timed(lambda: front.solve(world.source, slowness=before), repeats)
    near = world.vertex_at(field.potential, DISTANCE)
    found = []
    for size in SIZES:
        if size > len(before) // 3:
            break
        changed = patch(world, size, near)
        after = before.copy()
        after[changed] *= 1.5
        field = front.solve(world.source, slowness=before)
        turns = [0]

        def change() -> int:
            turns[0] += 1
            return field.update(after if turns[0] % 2 else before, changed)

        own, anew = timed(change, 2 * max(repeats // 2, 1))
        for slowness in (after, before):
            field.update(slowness, changed)
            expected = front.solve(world.source, slowness=slowness).potential
            if not np.allclose(field.potential, expected, rtol=1e-5):
                raise RuntimeError("the update of %d vertices differs from a new field" % size)
        name = "%d costs changed, %d labels anew" % (size, anew)
        found.append(Figure(name, own, "ms", "whole field", whole))
    return found


PARTS: Dict[str, Callable[[PlanningWorld, int], List[Figure]]] = {"updates": updates}

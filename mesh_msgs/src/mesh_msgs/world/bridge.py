"""The bridge of the generated outdoor world, which makes it a surface of two levels."""

import numpy as np

from mesh_msgs.world import layout as plan
from mesh_msgs.world.part import Height, WorldPart, closed, mottled, random_faces

CONCRETE = np.array([178, 176, 170.0])


def bridge(height: Height, edge: float, rng: np.random.Generator) -> WorldPart:
    """A slab with a parapet on either side, from a hole in the western bank to one in the eastern.

    The ring of a hole is the slab's cross section laid on the bank: the front edge (lower, towards
    the road) becomes its underside, the back edge (on the plateau) its deck; so the deck continues
    the path without a step.
    """
    half, front, back = plan.BRIDGE_HALF_WIDTH, -plan.BRIDGE_FRONT, -plan.BRIDGE_BACK
    thick = 0.22
    below = np.linspace(-half, half, max(2, int(round(2 * half / edge))) + 1)
    count = max(1, int(round((front - back) / edge)))
    side = np.linspace(0.0, 1.0, count + 1)[1:-1]
    inner = half - thick - 0.06
    deck = np.linspace(inner, -inner, max(2, int(round(2 * inner / edge))) + 1)
    parapet = np.linspace(half, half - thick, max(1, int(round(thick / edge))) + 1)
    over = np.concatenate([parapet, deck, -parapet[::-1]])
    raised = np.concatenate([np.ones(len(parapet)), np.zeros(len(deck)), np.ones(len(parapet))])
    # Counter-clockwise: front edge northwards, northern side, back edge southwards, southern side.
    x = np.concatenate([np.full(len(below), front), front + side * (back - front)])
    x = np.concatenate([x, np.full(len(over), back), back + side * (front - back)])
    y = np.concatenate([below, np.full(len(side), half), over, np.full(len(side), -half)])
    upper = np.concatenate([np.zeros(len(below)), side, np.ones(len(over)), 1.0 - side])
    raise_ = np.concatenate([np.zeros(len(below)), side, raised, 1.0 - side])
    west = np.stack([x, y], axis=1)
    east = west * [-1.0, 1.0]

    size, length = len(west), 2.0 * plan.BRIDGE_BACK
    count = max(6, int(round(length / edge)))
    share = (np.arange(1, count) / count)[None, :]
    z_west, z_east = height(west)[:, None], height(east)[:, None]
    # The deck is an arc, its underside a little more of one: slender in the middle.
    arc = 4.0 * share * (1.0 - share) * (0.30 + 0.12 * (1.0 - upper[:, None]))
    rise = np.clip(np.minimum(share, 1.0 - share) * length / 0.6, 0.0, 1.0)
    z = z_west + share * (z_east - z_west) + arc + 0.75 * raise_[:, None] * rise
    x = west[:, :1] * (1.0 - 2.0 * share)
    vertices = np.stack([x, np.broadcast_to(y[:, None], x.shape), z], axis=2).reshape(-1, 3)
    own = 2 * size + np.arange(size * (count - 1)).reshape(size, count - 1)
    # The ring in the east is the mirrored one, so it has to be counted the other way around.
    east_index = 2 * size - 1 - np.arange(size)
    index = np.concatenate([np.arange(size)[:, None], own, east_index[:, None]], axis=1)
    faces = random_faces(closed(index), rng)
    x, across = np.meshgrid(np.linspace(front, back, 5), np.linspace(-half, half, 13))
    grid = np.stack([x.ravel(), across.ravel()], axis=1)
    cover = np.concatenate([grid, np.full((len(grid), 1), 0.25)], axis=1)
    cover = np.concatenate([cover, cover * [-1.0, 1.0, 1.0]])
    driven = (upper == 1.0) & (np.abs(y) <= inner + 1e-9)
    color = np.where(np.repeat(driven, count - 1)[:, None], CONCRETE * 0.94, CONCRETE)
    colors = mottled(color, len(vertices), rng, 0.08)
    return WorldPart([west, east[::-1]], cover, vertices, colors, faces)

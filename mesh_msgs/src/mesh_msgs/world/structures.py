"""Walls and trees of the generated outdoor world."""

from typing import Any, NamedTuple

import numpy as np

from mesh_msgs.world import layout as plan
from mesh_msgs.world.part import Height, WorldPart, closed, mottled, random_faces

STONE, WOOD = np.array([176, 160, 134.0]), np.array([104, 76, 50.0])
LEAVES, NEEDLES = np.array([96, 140, 52.0]), np.array([44, 92, 56.0])


def wall(design: plan.Wall, height: Height, edge: float, rng: np.random.Generator) -> WorldPart:
    """A wall of dry stone: vertical sides that rise from the ground, and an uneven top."""
    middle, normals = plan.resample(design.line, min(edge, 1.2))
    # Stones of about 0.3 m, not all of one height.
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(middle, axis=0), axis=1))])
    stone = rng.permutation(np.linspace(-0.05, 0.05, int(along[-1] / 0.3) + 1))
    raised = design.height * (1.0 + stone[(along / 0.3).astype(int)])
    rows = max(1, int(round(design.height / edge)))
    block = _Block(middle, normals, plan.WALL_THICKNESS, raised, rows, 0.3 * min(edge, 0.2))
    return block.part(height, edge, rng)


def stairs(design: plan.Stairs, height: Height, edge: float, rng: np.random.Generator) -> WorldPart:
    """Steps, a landing and a ramp, between vertical sides. The risers lean by a centimeter, so that
    all of the top is seen from above; the end of the ramp is an edge of the ground."""
    profile = []
    for step in range(design.steps):
        begin, level = step * design.tread, (step + 1) * design.rise
        profile += [(begin + _LEAN * (step > 0), level), (begin + design.tread, level)]
    profile += [(profile[-1][0] + design.landing, profile[-1][1]), (design.length, 0.0)]
    x, z = np.array(profile).T
    pieces = np.maximum(1, np.rint(np.diff(x) / edge)).astype(int)
    along = np.concatenate(
        [np.linspace(*pair, count + 1)[:-1] for *pair, count in zip(x, x[1:], pieces)] + [x[-1:]]
    )
    middle = design.position + np.stack([along, np.zeros(len(along))], axis=1)
    normals = np.tile([0.0, 1.0], (len(along), 1))
    # Level up to the ramp, whatever the ground below; that ends where the ground is there.
    ground = height(middle)
    levels = ground[0] + z
    levels[-1] = ground[-1]
    raised = np.interp(along, x, levels) - ground
    rows = max(1, int(round(z.max() / edge)))
    return _Block(middle, normals, design.width, raised, rows, ends_flush=True).part(
        height, edge, rng
    )


_LEAN = 0.01  # m


class _Block(NamedTuple):
    """What stands on the ground with vertical sides, along a line seen from above."""

    # (N, 2) stations along the middle, and their miter normals to the left
    middle: np.ndarray
    normals: np.ndarray
    thickness: float
    # (N,) meters of the top above the ground at each station
    raised: np.ndarray
    # of triangles, in the sides
    rows: int
    # meters between the highest and the lowest noise of the top
    rough: float = 0.0
    # whether the far end of the top is an edge of the ground, and no side is below it; the ground
    # at a station is then that of its middle
    ends_flush: bool = False

    def part(self, height: Height, edge: float, rng: np.random.Generator) -> WorldPart:
        middle, normals, count = self.middle, self.normals, len(self.middle)
        across = max(1, int(round(self.thickness / edge)))
        offsets = (np.arange(across + 1) / across - 0.5) * self.thickness
        top = middle[:, None] + normals[:, None] * offsets[None, :, None]
        # The boundary of the grid of the top: right side, far end, left side, near end.
        station = np.concatenate([np.arange(count), np.full(across, count - 1)])
        station = np.concatenate(
            [station, np.arange(count - 1)[::-1], np.zeros(across - 1, dtype=int)]
        )
        column = np.concatenate([np.zeros(count, dtype=int), np.arange(1, across + 1)])
        column = np.concatenate([column, np.full(count - 1, across), np.arange(1, across)[::-1]])
        ring = top[station, column]
        ground = height(ring)
        if self.ends_flush:
            base = height(middle)
        else:
            base = np.bincount(station, ground) / np.bincount(station)
        top_z = (base + self.raised)[:, None]
        top_z = top_z + self.rough * (rng.random((count, across + 1)) - 0.5)

        rows, size = self.rows, len(ring)
        share = (np.arange(1, rows) + 0.5 * (rng.random((size, rows - 1)) - 0.5)) / rows
        side_z = ground[:, None] + share * (top_z[station, column] - ground)[:, None]
        side = np.concatenate([np.repeat(ring, rows - 1, axis=0), side_z.reshape(-1, 1)], axis=1)
        cap = np.concatenate([top.reshape(-1, 2), top_z.reshape(-1, 1)], axis=1)

        cap_index = size + len(side) + np.arange(count * (across + 1)).reshape(count, across + 1)
        side_index = size + np.arange(len(side)).reshape(size, rows - 1)
        columns = [np.arange(size)[:, None], side_index, cap_index[station, column][:, None]]
        grid = np.concatenate(columns, axis=1)
        vertices = np.concatenate([side, cap])
        if self.ends_flush:
            far = np.arange(count - 1, count + across)
            cap_index[-1] = far
            walls = np.roll(np.delete(grid, far, axis=0), 1 - count, axis=0)
            side_faces = [random_faces(walls, rng), _fan(walls[0], far[-1])[:, ::-1]]
            side_faces.append(_fan(walls[-1], far[0]))
            faces = np.concatenate(side_faces + [random_faces(cap_index, rng)])
            vertices, faces = _without_unused(vertices, faces, size)
        else:
            faces = np.concatenate([random_faces(closed(grid), rng), random_faces(cap_index, rng)])
        colors = mottled(STONE, len(vertices), rng, 0.30)
        return WorldPart([ring], self._cover(), vertices, colors, faces)

    def _cover(self) -> np.ndarray:
        """Discs over all of it; a wide one has several at each station, that overlap."""
        lanes = int(np.ceil(self.thickness / plan.WALL_THICKNESS))
        radius = self.thickness / max(lanes, 1) / 2
        if lanes <= 1:
            return np.concatenate([self.middle, np.full((len(self.middle), 1), radius)], axis=1)
        middle, normals = plan.resample(self.middle, radius)
        offsets = (np.arange(lanes) + 0.5) / lanes * self.thickness - self.thickness / 2
        places = (middle[:, None] + normals[:, None] * offsets[None, :, None]).reshape(-1, 2)
        return np.concatenate([places, np.full((len(places), 1), 1.3 * radius)], axis=1)


def _fan(column: np.ndarray, corner: int) -> np.ndarray:
    """Triangles between the vertices of a column, from the ground to the top, and one beside."""
    return np.stack([column[:-1], np.full(len(column) - 1, corner), column[1:]], axis=1)


def _without_unused(vertices: np.ndarray, faces: np.ndarray, size: int) -> Any:
    """Without vertices that no face has; indices count `size` vertices of the ring first."""
    used = np.zeros(size + len(vertices), dtype=bool)
    used[faces] = True
    used[:size] = True
    return vertices[used[size:]], (np.cumsum(used) - 1)[faces]


def trunk(design: plan.Tree, height: Height, edge: float, rng: np.random.Generator) -> WorldPart:
    """The trunk of a tree, tapered, closed at its top (which the crown hides)."""
    size = int(np.clip(round(2.0 * np.pi * design.trunk_radius / edge), 5, 24))
    angles = (np.arange(size) + 0.3 * rng.random(size)) * (2.0 * np.pi / size)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    ring = design.position + circle * design.trunk_radius
    ground = height(ring)
    foot = height(design.position[None])[0]
    rows = max(1, int(round(design.trunk_height / max(edge, design.trunk_radius))))
    share = np.arange(1, rows + 1)[None, :, None] / rows
    # Wide at the root, then slender.
    radius = design.trunk_radius * (0.62 + 0.38 * (1.0 - share) ** 3)
    xy = design.position + circle[:, None] * radius
    z = ground[:, None, None] + share * (foot + design.trunk_height - ground)[:, None, None]
    vertices = np.concatenate([xy, z], axis=2).reshape(-1, 3)
    vertices = np.concatenate([vertices, [[*design.position, foot + design.trunk_height]]])
    index = size + np.arange(size * rows).reshape(size, rows)
    index = closed(np.concatenate([np.arange(size)[:, None], index], axis=1))
    cap = np.stack([index[:-1, -1], index[1:, -1], np.full(size, size + size * rows)], axis=1)
    faces = np.concatenate([random_faces(index, rng), cap])
    cover = np.array([[*design.position, design.trunk_radius]])
    return WorldPart([ring], cover, vertices, mottled(WOOD, len(vertices), rng, 0.3), faces)


def crown(design: plan.Tree, height: Height, edge: float, rng: np.random.Generator) -> WorldPart:
    """The crown of a tree: a closed surface of its own, lumpy, or in tiers for a conifer."""
    rows = int(np.clip(round(2.2 * design.crown_height / edge), 3, 200))
    t = np.linspace(0.0, 1.0, rows + 2)[1:-1]
    if design.conifer:
        # Four skirts, each narrower than the one below; the profile starts inside, at the trunk.
        inside, outside = np.clip(t / 0.06, 0.0, 1.0), np.clip((t - 0.06) / 0.94, 0.0, 1.0)
        skirt = 0.42 * (4.0 * outside % 1.0) if rows >= 8 else 0.0
        profile = inside * (1.0 - 0.88 * outside) * (1.0 - skirt)
        level = 0.10 * inside + 0.90 * outside
        color = NEEDLES
    else:
        profile = np.sin(np.pi * t) * (1.12 - 0.24 * t)
        level = 0.5 - 0.5 * np.cos(np.pi * t)
        color = LEAVES
    around = int(np.clip(round(2.0 * np.pi * design.crown_radius / edge), 5, 200))
    steps = np.arange(around)[:, None] + 0.3 * rng.random((around, rows))
    angle = steps * (2.0 * np.pi / around)
    upward = np.broadcast_to(2.0 * level - 1.0, angle.shape)
    unit = np.stack([profile * np.cos(angle), profile * np.sin(angle), upward], axis=2)
    unit = unit.reshape(-1, 3)
    unit = np.concatenate([unit, [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]])
    strength = (0.03 if design.conifer else 0.12) * min(1.0, 0.5 * design.crown_radius / edge)
    lumps = _lumps(unit, rng, strength)
    scale = np.array([design.crown_radius, design.crown_radius, design.crown_height / 2])
    bottom = height(design.position[None])[0] + design.trunk_height - 0.35
    vertices = unit * scale * lumps[:, None] + [*design.position, bottom + design.crown_height / 2]

    count = around * rows
    index = closed(np.arange(count).reshape(around, rows))
    low = np.stack([np.full(around, count), index[1:, 0], index[:-1, 0]], axis=1)
    high = np.stack([index[:-1, -1], index[1:, -1], np.full(around, count + 1)], axis=1)
    faces = np.concatenate([random_faces(index, rng), low, high])
    # Light comes from above; every tree has a green of its own.
    light = 0.72 + 0.22 * (unit[:, 2:] + 1.0) / 2.0 + 1.2 * (lumps[:, None] - 1.0)
    shade = color * (1.0 + 0.24 * (rng.random(3) - 0.5) * [1.4, 1.0, 0.6])
    return WorldPart(
        [], np.zeros((0, 3)), vertices, mottled(shade, len(vertices), rng) * light, faces
    )


def _lumps(unit: np.ndarray, rng: np.random.Generator, strength: float) -> np.ndarray:
    """Smooth factors around 1: a few plane waves of random direction."""
    factor = np.ones(len(unit))
    for wave, weight in ((2.5, 0.4), (4.0, 0.5), (6.0, 0.6), (9.0, 0.5)):
        # Rather around than up, or crowns become hats.
        direction = (rng.random(3) * 2.0 - 1.0) * [1.0, 1.0, 0.4]
        direction *= wave / max(np.linalg.norm(direction), 0.1)
        phase = (unit * direction).sum(axis=1)
        factor += strength * weight * np.cos(phase + 2.0 * np.pi * rng.random())
    return factor

"""A zoo of small generated meshes for tests and documentation, one function each.

Every mesh is deterministic, in meters, and says by its traits (:data:`TRAITS`) what is true of it,
so that a test can pick what it needs:
``[mesh for mesh in all_meshes() if "manifold" in mesh.traits]``. The large world,
:func:`mesh_msgs.outdoor_world.outdoor_world`, is available from here too.
"""

from typing import List, Tuple

import numpy as np

from mesh_msgs.outdoor_world import outdoor_world  # noqa: F401
from mesh_msgs.world.zoo_mesh import TRAITS, ZooMesh, grid_faces, icosphere, zoo_mesh  # noqa: F401

_PLANE = "boundary manifold oriented orientable connected planar upward"


def _plane(cells: int, size: float) -> Tuple[np.ndarray, np.ndarray]:
    """A square with a corner at the origin; vertex (i, j) has the index i (cells + 1) + j."""
    ticks = np.linspace(0.0, size, cells + 1)
    x, y = np.meshgrid(ticks, ticks, indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    return vertices, grid_faces(np.arange(x.size).reshape(x.shape))


def tetrahedron(edge: float = 1.0) -> ZooMesh:
    """A regular tetrahedron around the origin: the smallest closed mesh."""
    vertices = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) * edge / np.sqrt(8.0)
    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    return zoo_mesh("tetrahedron", vertices, faces, "closed manifold oriented orientable connected")


def grid(cells: int = 10, size: float = 10.0) -> ZooMesh:
    """A regular square grid in the plane z = 0, all diagonals alike."""
    vertices, faces = _plane(cells, size)
    return zoo_mesh("grid", vertices, faces, _PLANE)


def jittered_plane(cells: int = 10, size: float = 10.0, seed: int = 0) -> ZooMesh:
    """A square in the plane z = 0 of irregular triangles: moved vertices, random diagonals."""
    vertices, _ = _plane(cells, size)
    rng = np.random.default_rng(seed)
    inner = ((vertices[:, :2] > 0.0) & (vertices[:, :2] < size)).all(axis=1)
    # Below a quarter of a cell every quadrilateral stays convex, so either diagonal will do.
    vertices[inner, :2] += (rng.random((np.count_nonzero(inner), 2)) - 0.5) * 0.48 * size / cells
    index = np.arange(len(vertices)).reshape(cells + 1, cells + 1)
    faces = grid_faces(index, rng.random((cells, cells)) < 0.5)
    return zoo_mesh("jittered_plane", vertices, faces, _PLANE)


def sphere(subdivisions: int = 2, radius: float = 1.0) -> ZooMesh:
    """A sphere around the origin: an icosahedron whose 20 faces are split in four `subdivisions`
    times.
    """
    vertices, faces = icosphere(subdivisions)
    return zoo_mesh(
        "sphere", vertices * radius, faces, "closed manifold oriented orientable connected"
    )


def torus(around: int = 24, across: int = 12, radius: float = 2.0, tube: float = 0.5) -> ZooMesh:
    """A torus around the z axis; `radius` is that of the circle in the middle of the tube."""
    u = np.arange(around) * (2.0 * np.pi / around)
    v = np.arange(across) * (2.0 * np.pi / across)
    u, v = np.meshgrid(u, v, indexing="ij")
    ring = radius + tube * np.cos(v)
    vertices = np.stack([ring * np.cos(u), ring * np.sin(u), tube * np.sin(v)], axis=2)
    index = np.arange(around * across).reshape(around, across)
    faces = grid_faces(np.pad(index, ((0, 1), (0, 1)), mode="wrap"))
    return zoo_mesh("torus", vertices, faces, "closed manifold oriented orientable connected")


def two_storeys(cells: int = 12, size: float = 12.0, height: float = 3.0) -> ZooMesh:
    """Two square floors, one exactly above the other, joined by a ramp along their side y = `size`.

    One connected surface that can be walked on everywhere: lower floor (z = 0), landing at the
    ramp's foot, ramp, landing at its head, upper floor (z = `height`). `cells` (at least 6) count
    along a side.
    """
    if cells < 6:
        raise ValueError(f"two_storeys: cells = {cells}, but at least 6 are needed")
    landing, lane = cells // 6, max(2, cells // 6)
    step = size / cells
    parts = []

    def add(columns: range, rows: range, level: object) -> None:
        x, y = np.meshgrid(columns, rows, indexing="ij")
        z = np.broadcast_to(level(x), x.shape)
        offset = sum(len(points) for points, _ in parts)
        index = offset + np.arange(x.size).reshape(x.shape)
        points = np.stack([x.ravel() * step, y.ravel() * step, z.ravel()], axis=1)
        parts.append((points, grid_faces(index)))

    floor, side = range(cells + 1), range(cells, cells + lane + 1)
    slope = height / (cells - 2 * landing)
    add(floor, range(cells + 1), lambda x: 0.0)
    add(range(landing + 1), side, lambda x: 0.0)
    add(range(landing, cells - landing + 1), side, lambda x: (x - landing) * slope)
    add(range(cells - landing, cells + 1), side, lambda x: height)
    add(floor, range(cells + 1), lambda x: height)
    points = np.concatenate([part for part, _ in parts]).astype(np.float32)
    faces = np.concatenate([part for _, part in parts])
    # The parts meet where their points are equal; the ramp's sides lie between the floors and touch
    # neither.
    vertices, where = np.unique(points, axis=0, return_inverse=True)
    traits = "boundary manifold oriented orientable connected upward multi_level"
    return zoo_mesh("two_storeys", vertices, where.reshape(-1)[faces], traits)


def hole(cells: int = 9, size: float = 9.0) -> ZooMesh:
    """A grid without the cells of its middle third: two boundary loops."""
    vertices, faces = _plane(cells, size)
    x, y = vertices[faces].mean(axis=1)[:, :2].T
    inside = (np.abs(x - size / 2) < size / 6) & (np.abs(y - size / 2) < size / 6)
    used, where = np.unique(faces[~inside], return_inverse=True)
    return zoo_mesh("hole", vertices[used], where.reshape(-1, 3), _PLANE)


def two_components(cells: int = 5, size: float = 5.0, gap: float = 1.0) -> ZooMesh:
    """Two grids side by side, `gap` apart in x: nothing leads from one to the other."""
    vertices, faces = _plane(cells, size)
    both = np.concatenate([vertices, vertices + [size + gap, 0.0, 0.0]])
    faces = np.concatenate([faces, faces + len(vertices)])
    return zoo_mesh(
        "two_components", both, faces, "boundary manifold oriented orientable planar upward"
    )


def moebius_strip(
    around: int = 24, across: int = 3, radius: float = 2.0, width: float = 1.0
) -> ZooMesh:
    """A strip with half a twist: one side, one boundary loop, no consistent orientation."""
    u = np.arange(around) * (2.0 * np.pi / around)
    v = np.linspace(-width / 2, width / 2, across + 1)
    u, v = np.meshgrid(u, v, indexing="ij")
    ring = radius + v * np.cos(u / 2)
    vertices = np.stack([ring * np.cos(u), ring * np.sin(u), v * np.sin(u / 2)], axis=2)
    index = np.arange(u.size).reshape(u.shape)
    # After one turn the strip arrives upside down.
    faces = grid_faces(np.concatenate([index, index[:1, ::-1]]))
    return zoo_mesh("moebius_strip", vertices, faces, "boundary manifold connected")


def bow_tie(size: float = 1.0) -> ZooMesh:
    """Two triangles that share a vertex and no edge: all edges are fine, the vertex is not."""
    vertices = np.array([[0, 0, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0]]) * size
    faces = [[0, 1, 2], [0, 3, 4]]
    return zoo_mesh(
        "bow_tie", vertices, faces, "boundary oriented orientable connected planar upward"
    )


def fan_of_three(size: float = 1.0) -> ZooMesh:
    """Three faces on one edge, like the pages of a book."""
    vertices = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0], [-0.5, 0.75, 0], [-0.5, -0.75, 0]]) * size
    return zoo_mesh(
        "fan_of_three", vertices, [[0, 1, 2], [0, 1, 3], [0, 1, 4]], "boundary connected"
    )


def sliver(height: float = 1e-5, size: float = 1.0) -> ZooMesh:
    """A triangle cut in three, one of them only `height` times its length thin, but not flat."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0.5, height, 0], [0.5, 1, 0]]) * size
    faces = [[0, 1, 2], [0, 2, 3], [1, 3, 2]]
    return zoo_mesh("sliver", vertices, faces, _PLANE + " degenerate")


def zero_area_face(size: float = 1.0) -> ZooMesh:
    """A triangle cut in two by the middle of a side, and a face without area between it and that
    side.
    """
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0.5, 0, 0], [0.5, 1, 0]]) * size
    faces = [[0, 1, 2], [0, 2, 3], [1, 3, 2]]
    traits = "boundary manifold oriented orientable connected planar degenerate"
    return zoo_mesh("zero_area_face", vertices, faces, traits)


def duplicate_vertex(size: float = 1.0) -> ZooMesh:
    """A square of two triangles that look joined, but have two vertices each of their own at the
    diagonal.
    """
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 0], [1, 1, 0], [0, 1, 0]]) * size
    traits = "boundary manifold oriented orientable planar upward duplicate_vertices"
    return zoo_mesh("duplicate_vertex", vertices, [[0, 1, 2], [3, 4, 5]], traits)


def duplicate_face(cells: int = 3, size: float = 3.0) -> ZooMesh:
    """A grid with its middle face twice; the copy starts at another corner."""
    vertices, faces = _plane(cells, size)
    faces = np.concatenate([faces, np.roll(faces[[len(faces) // 2]], 1, axis=1)])
    return zoo_mesh(
        "duplicate_face", vertices, faces, "boundary connected planar upward duplicate_faces"
    )


def flipped_face(cells: int = 3, size: float = 3.0) -> ZooMesh:
    """A grid whose middle face looks down."""
    vertices, faces = _plane(cells, size)
    middle = len(faces) // 2
    faces[middle] = faces[middle, ::-1]
    return zoo_mesh(
        "flipped_face", vertices, faces, "boundary manifold orientable connected planar"
    )


def isolated_vertex(cells: int = 3, size: float = 3.0) -> ZooMesh:
    """A grid, and before it, at index 0, a vertex above it that no face names."""
    vertices, faces = _plane(cells, size)
    vertices = np.concatenate([[[size / 2, size / 2, size / 2]], vertices])
    traits = "boundary manifold oriented orientable upward isolated_vertices"
    return zoo_mesh("isolated_vertex", vertices, faces + 1, traits)


def far_sphere(offset: float = 1e6, subdivisions: int = 2, radius: float = 10.0) -> ZooMesh:
    """A sphere `offset` meters from the origin along x and y, where float32 resolves some
    centimeters only.
    """
    vertices, faces = icosphere(subdivisions)
    vertices = vertices * radius + [offset, offset, 0.0]
    return zoo_mesh(
        "far_sphere", vertices, faces, "closed manifold oriented orientable connected far"
    )


def empty() -> ZooMesh:
    """No vertices, no faces."""
    return zoo_mesh("empty", [], [], "empty manifold oriented orientable planar")


def all_meshes() -> List[ZooMesh]:
    """Return every small mesh of the zoo with its default size (the outdoor world is not among
    them).
    """
    makers = [tetrahedron, grid, jittered_plane, sphere, torus, two_storeys, hole, two_components]
    makers += [
        moebius_strip,
        bow_tie,
        fan_of_three,
        sliver,
        zero_area_face,
        duplicate_vertex,
        duplicate_face,
    ]
    makers += [flipped_face, isolated_vertex, far_sphere, empty]
    return [make() for make in makers]

"""Random stories of a field: costs that jump, fields that stop early, many goals at once."""

from functools import lru_cache

import numpy as np
from mesh_map.distance.wave_front import WaveFrontSolver
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_msgs import zoo
from meshes import TestMesh, terrain
from scipy.spatial import Delaunay

FACTORS = (1.05, 1.2, 1.35, 2.0, 5.0, 20.0, 50.0)


def _delaunay(count=2500, squeezed=1.0):
    points = np.random.default_rng(8).uniform(0, 5, (count, 2)) * [1.0, squeezed]
    faces = Delaunay(points / [1.0, squeezed]).simplices
    return np.c_[points, np.zeros(count)], faces


@lru_cache(maxsize=None)
def ground(name):
    """Its solver; the last dozen of names is kept in memory."""
    made = {
        "grid": lambda: zoo.grid(cells=50),
        "jittered": lambda: zoo.jittered_plane(cells=50),
        "rough": lambda: terrain(50),
        "rougher": lambda: _rougher(terrain(50)),
        "sphere": lambda: zoo.sphere(subdivisions=4),
        "torus": lambda: zoo.torus(around=96, across=32),
        "storeys": lambda: zoo.two_storeys(cells=36),
    }
    if name == "random":
        vertices, faces = _delaunay()
    elif name == "squeezed":
        vertices, faces = _delaunay(squeezed=0.3)
    elif name in made:
        vertices, faces = made[name]()[1:3]
    else:
        mesh = next(mesh for mesh in zoo.all_meshes() if mesh.name == name)
        vertices, faces = mesh.vertices, mesh.faces
    geometry = MeshGeometry(np.asarray(vertices, np.float32), np.asarray(faces, np.uint32))
    return geometry, WaveFrontSolver.of(geometry)


LARGE = ("grid", "jittered", "rough", "rougher", "sphere", "torus", "storeys", "random", "squeezed")
SMALL = tuple(mesh.name for mesh in zoo.all_meshes() if len(mesh.faces))


def _rougher(mesh):
    vertices = mesh.vertices.copy()
    vertices[:, 2] += np.random.default_rng(3).uniform(-0.08, 0.08, len(vertices))
    return TestMesh("rougher", vertices, mesh.faces)


class Story:
    """One field and what happens to it; all that is random follows from the seed."""

    def __init__(self, name, seed):
        self.random = np.random.default_rng(seed)
        self.geometry, self.solver = ground(name)
        self.points = self.geometry.vertices.astype(np.float64)
        self.count = len(self.points)
        self.size = float(np.ptp(self.points, axis=0).max())
        self.goal = self._goal()
        self.slowness = self._costs()
        self.reach = {}
        if self.random.random() < 0.4:
            whole = self.anew()
            far = whole.labels[np.isfinite(whole.labels)]
            distance = float(np.median(far)) if len(far) else 1.0
            self.reach = {"max_distance": distance * self.random.uniform(0.5, 1.5)}
            if self.random.random() < 0.5:
                targets = self.random.integers(self.count, size=2)
                self.reach = {"targets": targets, "offset": 0.1 * distance}
        self.field = self.solver.solve(self.goal, slowness=self.slowness, **self.reach)

    def _goal(self):
        kind = self.random.integers(4)
        if kind == 0:
            return int(self.random.integers(self.count))
        if kind == 1:
            vertices = self.random.integers(self.count, size=3)
            return [(int(v), float(self.random.uniform(0, 0.1 * self.size))) for v in vertices]
        face = int(self.random.integers(len(self.geometry.faces)))
        weights = self.random.dirichlet(np.ones(3))

        class Point:
            position = weights @ self.points[self.geometry.faces[face]]

        Point.face = face
        return Point

    def _near(self, share):
        """(V,) bool: vertices in a ball, and their distances from its middle."""
        middle = self.points[self.random.integers(self.count)]
        distances = np.linalg.norm(self.points - middle, axis=1)
        return distances < share * self.size, distances

    def _costs(self):
        kind = self.random.integers(4)
        if kind == 0:
            slowness = np.ones(self.count)
        elif kind == 1:
            slowness = self.random.uniform(1, self.random.choice([1.2, 3.0, 100.0]), self.count)
        elif kind == 2:
            slowness = self.random.choice([1.0, *FACTORS], self.count)
        else:
            slowness = 1.5 + np.sin(3 * self.points / max(self.size, 1e-9) * 5).mean(1)
            for _ in range(3):
                slowness *= self._ring()
        return slowness.astype(np.float32)

    def _ring(self):
        """Lethal in the middle, and costs that fall off around it, as inflation makes them."""
        inside, distances = self._near(self.random.uniform(0.03, 0.12))
        reach = max(distances[inside].max(initial=0.0), 1e-9)
        most = self.random.choice([2.0, 10.0, 50.0])
        factor = np.where(inside, 1.0 + most * np.exp(-3.0 * distances / reach), 1.0)
        factor[distances < 0.3 * reach] = self.random.choice([np.inf, most])
        return factor

    def change(self):
        """The vertices that another slowness is at."""
        slowness, kind = self.slowness.astype(np.float64), self.random.integers(6)
        if kind == 0:
            chosen = self.random.integers(self.count, size=1)
            slowness[chosen] *= self.random.choice(FACTORS) ** self.random.choice([-1, 1])
        elif kind == 1:
            chosen = self.random.integers(self.count, size=max(1, self.count // 150))
            slowness[chosen] = self.random.uniform(1, 100, len(chosen))
        elif kind == 2:
            inside, _ = self._near(self.random.uniform(0.01, 0.08))
            slowness[inside] *= self.random.choice(FACTORS) ** self.random.choice([-1, 1])
        elif kind == 3:
            slowness *= self._ring()
        elif kind == 4:
            inside, _ = self._near(self.random.uniform(0.01, 0.08))
            slowness[inside] = self.random.choice([np.inf, np.nan, 1.0])
        else:
            gone = ~np.isfinite(slowness) & self._near(0.15)[0]
            slowness[gone] = self.random.uniform(1, 3, gone.sum())
        slowness = slowness.astype(np.float32)
        changed = np.flatnonzero(
            (slowness != self.slowness) & ~(np.isnan(slowness) & np.isnan(self.slowness))
        )
        self.slowness = slowness
        return changed

    def anew(self):
        return self.solver.solve(self.goal, slowness=self.slowness)

    def go_on(self):
        """One change, followed by the field; sometimes it reaches farther then."""
        changed = self.change()
        self.field.update(self.slowness, changed)
        if self.reach and self.random.random() < 0.3:
            self.field.extend(**self.reach)

    def error(self):
        """The largest relative difference to a new field, of all that is final in this one."""
        return difference(self.field, self.anew().labels)


def difference(field, expected):
    """The largest relative difference of final labels; infinite where only one is reached."""
    final = (field.labels <= field.limit) | (expected <= field.limit * (1 - 1e-5))
    found, wanted = field.labels[final], expected[final]
    if not (np.isfinite(found) == np.isfinite(wanted)).all():
        return np.inf
    both = np.isfinite(wanted)
    found, wanted = found[both], wanted[both]
    return float((np.abs(found - wanted) / np.maximum(wanted, 1e-12)).max(initial=0.0))

"""What the benchmark asks: rays, points, and regions that touch about as many faces as wanted."""

from typing import Callable, NamedTuple, Tuple

import numpy as np

PICTURE = (1280, 800)  # pixels


class Camera(NamedTuple):
    """A pinhole camera: its eye [m] and its matrix to clip space (row-major, as OpenGL has it)."""

    eye: np.ndarray
    view_projection: np.ndarray

    def directions(self, columns: int, rows: int) -> np.ndarray:
        """Unit directions (rows * columns, 3) through the centers of the pixels, row by row."""
        x = (np.arange(columns) + 0.5) / columns * 2.0 - 1.0
        y = 1.0 - (np.arange(rows) + 0.5) / rows * 2.0
        points = np.ones((rows, columns, 4))
        points[..., 0], points[..., 1] = x, y[:, None]
        far = points.reshape(-1, 4) @ np.linalg.inv(self.view_projection).T
        directions = far[:, :3] / far[:, 3:] - self.eye
        return directions / np.linalg.norm(directions, axis=1, keepdims=True)

    def planes(self, half_width: float, half_height: float) -> np.ndarray:
        """The part of space behind a rectangle in the middle of the picture (1 = to its border).

        Planes (6, 4): left, right, bottom, top, near, far; a x + b y + c z + d >= 0 is inside.
        """
        x, y, z, w = self.view_projection
        sides = [x + half_width * w, half_width * w - x, y + half_height * w, half_height * w - y]
        return np.array(sides + [w + z, w - z])


def camera(eye: np.ndarray, target: np.ndarray, up: np.ndarray, angle: float = 60.0) -> Camera:
    """A camera at `eye` that looks at `target`, `angle` degrees high."""
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    view = np.eye(4)
    view[:3, :3] = [right, np.cross(right, forward), -forward]
    view[:3, 3] = -view[:3, :3] @ eye
    near, far = 0.1, 1000.0
    scale = 1.0 / np.tan(0.5 * np.radians(angle))
    projection = np.zeros((4, 4))
    projection[0, 0], projection[1, 1] = scale * PICTURE[1] / PICTURE[0], scale
    projection[2, 2:] = (far + near) / (near - far), 2.0 * far * near / (near - far)
    projection[3, 2] = -1.0
    return Camera(np.asarray(eye, np.float64), projection @ view)


def side_camera(vertices: np.ndarray) -> Camera:
    """From a corner of the world to its middle: about half of the rays meet it."""
    low, high = vertices.min(axis=0).astype(np.float64), vertices.max(axis=0).astype(np.float64)
    eye = low + 0.1 * (high - low)
    eye[2] = vertices[:, 2].mean(dtype=np.float64) + 12.0
    target = np.append(0.5 * (low + high)[:2], eye[2] - 0.1 * (high - low)[0])
    return camera(eye, target, np.array([0.0, 0.0, 1.0]))


def top_camera(vertices: np.ndarray) -> Camera:
    """From above; the whole world is in the picture."""
    low, high = vertices.min(axis=0).astype(np.float64), vertices.max(axis=0).astype(np.float64)
    middle = 0.5 * (low + high)
    eye = middle + [0.0, 0.0, 1.2 * (high - low)[:2].max() + high[2]]
    return camera(eye, middle, np.array([0.0, 1.0, 0.0]))


def coherent_rays(vertices: np.ndarray) -> np.ndarray:
    """The rays of a picture, float32 (1,024,000, 6): origin, unit direction."""
    view = side_camera(vertices)
    directions = view.directions(*PICTURE)
    return np.column_stack([np.tile(view.eye, (len(directions), 1)), directions]).astype(np.float32)


def incoherent_rays(vertices: np.ndarray, count: int, seed: int = 0) -> np.ndarray:
    """Rays from anywhere in the box around the world to anywhere, float32 (count, 6)."""
    rng = np.random.default_rng(seed)
    origins = rng.uniform(vertices.min(axis=0), vertices.max(axis=0), (count, 3))
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return np.column_stack([origins, directions]).astype(np.float32)


def points_near(vertices: np.ndarray, count: int, seed: int = 0) -> np.ndarray:
    """Points about 0.5 m off vertices, float32 (count, 3); the first is near the middle."""
    rng = np.random.default_rng(seed)
    chosen = vertices[rng.integers(0, len(vertices), count)]
    chosen[0] = vertices[np.square(vertices[:, :2]).sum(axis=1).argmin()]
    return (chosen + rng.normal(0.0, 0.3, (count, 3))).astype(np.float32)


def rectangle_of(
    view: Camera, faces: int, select: Callable[[np.ndarray], np.ndarray]
) -> Tuple[np.ndarray, int]:
    """Planes of the rectangle that touches about `faces` faces, and how many it touches.

    `select` answers planes with face indices.
    """
    low, high = 0.0, 1.0
    for _ in range(30):
        half = 0.5 * (low + high)
        planes = view.planes(half, half)
        touched = len(select(planes))
        if abs(touched - faces) <= 0.01 * faces:
            break
        low, high = (half, high) if touched < faces else (low, half)
    return planes, touched

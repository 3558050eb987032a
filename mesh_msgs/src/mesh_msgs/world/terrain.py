"""The ground of the generated outdoor world: height and color at any point."""

from typing import List

import numpy as np
from scipy.ndimage import gaussian_filter1d, map_coordinates, spline_filter
from scipy.spatial import cKDTree

from mesh_msgs.world import layout as plan

GRASS_LIGHT, GRASS_DARK = np.array([134, 152, 74.0]), np.array([74, 112, 46.0])
ROCK_LIGHT, ROCK_DARK = np.array([150, 143, 133.0]), np.array([104, 98, 92.0])
_MARGIN = 12  # around a lattice, so that its edge changes nothing inside
ROAD, PATH = np.array([142, 139, 134.0]), np.array([186, 160, 118.0])


def smoothstep(begin: float, end: float, x: np.ndarray) -> np.ndarray:
    """Return 0 below `begin`, 1 above `end`, and a smooth transition between."""
    t = np.clip((x - begin) / (end - begin), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


class Noise:
    """Smooth noise of one wavelength (meters): cubic splines through random values in a lattice."""

    def __init__(self, rng: np.random.Generator, size: float, wavelength: float):
        self.half, self.wavelength = size / 2, wavelength
        count = int(np.ceil(size / wavelength)) + 4
        values = rng.random((count, count)) * 2.0 - 1.0
        # The splines are the same at each call: what map_coordinates() makes of values first.
        self._splines = spline_filter(np.pad(values, _MARGIN, mode="edge"), order=3)

    def __call__(self, xy: np.ndarray) -> np.ndarray:
        """Return values (N,), mostly within -1 .. 1, at points (N, 2) of the world."""
        where = (xy.T + self.half) / self.wavelength + 1.5
        return map_coordinates(self._splines, where + _MARGIN, prefilter=False, mode="nearest")


class Terrain:
    """Ground of the world planned by `layout`, with details down to twice the length `edge` (m)."""

    def __init__(self, layout: plan.WorldLayout, seed: int, edge: float):
        self.layout = layout
        rng = np.random.default_rng([seed, 2])
        size = layout.size
        wavelengths = 0.36 * size * 0.5 ** np.arange(12)
        # At least three octaves: the coarsest mesh too shall have rolling ground.
        count = max(3, int(np.count_nonzero(wavelengths > 2.0 * edge)))
        self.octaves: List[Noise] = [Noise(rng, size, w) for w in wavelengths[:count]]
        self.amplitudes = 0.055 * size**0.8 * 0.5 ** np.arange(count)
        self.ridge = [Noise(rng, size, w) for w in (0.13 * size, 0.055 * size)]
        self.tint = [Noise(rng, size, 0.15 * size), Noise(rng, size, 0.03 * size)]
        self.grain = np.random.default_rng([seed, 5])
        self._along = np.linspace(-0.5, 0.5, 513) * size
        self._profiles()

    def height(self, xy: np.ndarray) -> np.ndarray:
        """Return the height (N,) of the ground at points (N, 2), all in meters."""
        layout, (x, y) = self.layout, xy.T
        z = self._wild(xy)
        for center, inner, outer, level in self._pads:
            weight = 1.0 - smoothstep(inner, outer, np.linalg.norm(xy - center, axis=1))
            z += weight * (level + 0.15 * (z - level) - z)
        on_path = 1.0 - smoothstep(2.0, 6.0, layout.path_distance(xy))
        z += on_path * (np.interp(x, self._along, self._path) - z)
        # Straight banks, so that the bridge's ends find the slope they are made for.
        bank = (layout.road_distance(xy) - plan.ROAD_HALF_WIDTH) / plan.BANK_WIDTH
        bank = np.clip(bank, 0.0, 1.0)
        return z + (1.0 - bank) * (np.interp(y, self._along, self._road) - z)

    def color(self, xy: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """Return RGB (N, 3), floats 0..255, of the ground with the given slopes (N,) in radians."""
        tint = np.clip(0.5 + 0.45 * self.tint[0](xy) + 0.2 * self.tint[1](xy), 0.0, 1.0)[:, None]
        grass = GRASS_DARK + tint * (GRASS_LIGHT - GRASS_DARK)
        stone = ROCK_DARK + (0.3 + 0.7 * tint) * (ROCK_LIGHT - ROCK_DARK)
        edge = 0.25 * self.tint[1](xy)
        color = grass + smoothstep(0.56, 0.78, slope + 0.1 * edge)[:, None] * (stone - grass)
        trails = np.concatenate([plan.resample(line, 0.1)[0] for line in self.layout.trails()])
        away = cKDTree(trails).query(xy, distance_upper_bound=2.0)[0] + edge
        trodden = 0.75 * (1.0 - smoothstep(0.3, 0.9, away))
        half = plan.PATH_HALF_WIDTH
        path = 1.0 - smoothstep(half - 0.3, half + 0.3, self.layout.path_distance(xy) + edge)
        # Below the bridge there is the road only.
        x, y = xy.T
        path[(np.abs(x) < plan.BRIDGE_BACK - 0.1) & (np.abs(y) < 4.0)] = 0.0
        color += np.maximum(path, trodden)[:, None] * (PATH - color)
        half = plan.ROAD_HALF_WIDTH
        road = 1.0 - smoothstep(half - 0.5, half + 0.1, self.layout.road_distance(xy) + edge)
        color += road[:, None] * (ROAD - color)
        return color * (0.94 + 0.12 * self.grain.random((len(xy), 1)))

    def _wild(self, xy: np.ndarray) -> np.ndarray:
        """The ground before people came."""
        hills = self._hills(xy)
        scale = max(hill.height for hill in self.layout.hills)
        rough = np.clip(hills / scale, 0.0, 1.0)
        z = hills
        for number, (noise, amplitude) in enumerate(zip(self.octaves, self.amplitudes)):
            # Hills are rough in the small, meadows are not.
            z = z + amplitude * (1.0 if number < 2 else 0.4 + 1.6 * rough) * noise(xy)
        for noise, share in zip(self.ridge, (0.45, 0.20)):
            z += share * scale * rough * (0.5 - np.abs(noise(xy)))
        return z

    def _hills(self, xy: np.ndarray) -> np.ndarray:
        z = np.zeros(len(xy))
        for hill in self.layout.hills:
            distance = np.linalg.norm(xy - hill.position, axis=1) / hill.radius
            z += hill.height * (1.0 - smoothstep(0.0, 1.0, distance))
        return z

    def _profiles(self) -> None:
        """Heights along the middle of road and path, and of the levelled places."""
        layout, along = self.layout, self._along
        path = self._smoothed(np.stack([along, layout.path_y(along)], axis=1))
        road = self._smoothed(np.stack([layout.road_x(along), along], axis=1))
        near = 1.0 - smoothstep(plan.PLATEAU_END, plan.PLATEAU_END + 9.0, np.abs(along))
        self._path = path + near * (plan.PATH_LEVEL - path)
        near = 1.0 - smoothstep(3.0, 22.0, np.abs(along))
        self._road = road + near * (plan.ROAD_LEVEL - road)
        half = layout.garden_half
        pads = [(layout.start, 1.2, 3.5), (layout.goal, 1.3 * half, 1.3 * half + 3.0)]
        if layout.stairs is not None:
            reach = layout.stairs.length / 2 + 0.5
            pads.append((layout.stairs.middle, reach, reach + 3.0))
        self._pads = [(c, inner, outer, self._wild(c[None])[0]) for c, inner, outer in pads]

    def _smoothed(self, line: np.ndarray) -> np.ndarray:
        sigma = 3.0 / (self.layout.size / (len(self._along) - 1))
        return 0.8 * gaussian_filter1d(self._wild(line), sigma, mode="nearest")

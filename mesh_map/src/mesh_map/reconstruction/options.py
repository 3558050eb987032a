"""How a surface is made of scans, and what of it becomes a map."""

import math
from dataclasses import asdict, dataclass
from typing import Any, Dict, Mapping, Optional, Tuple

from mesh_map.base.errors import MeshMapError

_MOST = 1e6  # of lengths in m


@dataclass(frozen=True)
class FieldOptions:
    """What the signed distances are made with; they cannot be changed afterwards.

    voxel_size: m.
    truncation: m, up to which the distance to a measured surface is kept; None: as the field has
        it.
    min_range, max_range: m from the sensor; points outside are not used.
    decimate: the share of the points that is used, 0 < d <= 1, evenly of each scan; or each n-th
        for n > 1.
    carve: whether rays take away what they pass through.
    origin: (x, y, z) m, subtracted from all coordinates; None: where it is needed (see
        `Reconstruction.origin`).
    """

    voxel_size: float = 0.1
    truncation: Optional[float] = None
    min_range: float = 0.0
    max_range: float = math.inf
    decimate: float = 1.0
    carve: bool = False
    origin: Optional[Tuple[float, float, float]] = None

    def __post_init__(self) -> None:
        """
        Raises:
            MeshMapError: a value that makes no field.
        """
        _check("voxel_size", self.voxel_size, 1e-4, 100.0)
        if self.truncation is not None:
            _check("truncation", self.truncation, self.voxel_size, _MOST)
        _check("min_range", self.min_range, 0.0, _MOST)
        if not self.max_range > self.min_range:
            text = "max_range is %g m, min_range %g m, so no point is between them"
            raise MeshMapError(text % (self.max_range, self.min_range))
        _check("decimate", self.decimate, 1e-6, 1e6)
        if self.origin is not None and not all(abs(value) < 1e12 for value in self.origin):
            raise MeshMapError("origin %s is no place" % (self.origin,), "x, y, z in meters")

    def stored(self) -> Dict[str, Any]:
        """What json can write; an infinite range is None."""
        values = asdict(self)
        values["max_range"] = None if math.isinf(self.max_range) else self.max_range
        values["origin"] = None if self.origin is None else list(self.origin)
        return values

    @classmethod
    def of_stored(cls, values: Mapping[str, Any]) -> "FieldOptions":
        """Of what `stored()` gave.

        Raises:
            MeshMapError: it is something else.
        """
        given = dict(values)
        try:
            given["max_range"] = math.inf if given["max_range"] is None else given["max_range"]
            given["origin"] = None if given["origin"] is None else tuple(given["origin"])
            return cls(**given)
        except (KeyError, TypeError, ValueError) as error:
            raise MeshMapError("the options of the field cannot be used: %s" % error) from error


@dataclass(frozen=True)
class SurfaceOptions:
    """What of a surface is kept; each time that it is extracted.

    fill_holes: m, perimeter up to which holes in flat ground are closed; 0: none, and no shadows.
    fill_shadows: m, width up to which holes are closed where no ray came, if what is around tells
        what is in them (see fill_shadows()); 0: none.
    simplify: m, by which a simplified surface may be off; 0: it is not simplified. Layers and
        planners know costs at vertices only: flat ground whose faces are larger than the radius of
        a layer is known badly.
    min_component: pieces of fewer faces (before it is simplified; two are about a voxel's side)
        that nothing connects with others are dropped; 0: none.
    """

    fill_holes: float = 1.0
    fill_shadows: float = 1.0
    simplify: float = 0.0
    min_component: int = 500

    def __post_init__(self) -> None:
        """
        Raises:
            MeshMapError: a value that is none.
        """
        _check("fill_holes", self.fill_holes, 0.0, _MOST)
        _check("fill_shadows", self.fill_shadows, 0.0, _MOST)
        _check("simplify", self.simplify, 0.0, _MOST)
        _check("min_component", self.min_component, 0, 1 << 31)


def _check(name: str, value: float, least: float, most: float) -> None:
    if not least <= value <= most:
        text = "%s is %g, but has to be from %g to %g"
        raise MeshMapError(text % (name, value, least, most))

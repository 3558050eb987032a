"""Declarations of the parameters of a layer."""

import math
from dataclasses import dataclass
from typing import Any, Optional, Tuple, Union

from mesh_map.errors import MeshMapError

Value = Union[bool, int, float, str]


@dataclass(frozen=True)
class Parameter:
    """One parameter: its type is that of its default.

    Attributes:
        name, default, description: for users; units belong in the description.
        minimum, maximum: the range of a number, None for no limit. A value outside is moved to the
            limit with a warning, as dynamic_reconfigure does.
        affects_costs: False for one that is applied to costs afterwards (a threshold, a factor), so
            that stored costs stay good when it changes.
    """

    name: str
    default: Value
    minimum: Optional[float] = None
    maximum: Optional[float] = None
    description: str = ""
    affects_costs: bool = True

    def checked(self, value: Any) -> Tuple[Value, str]:
        """The value in the right type and range, and a warning ("" for none).

        Raises:
            MeshMapError: another type, or NaN.
        """
        kind = type(self.default)
        if kind in (bool, str):
            if not isinstance(value, kind):
                raise self._wrong(value, "a " + {bool: "boolean", str: "string"}[kind])
            return value, ""
        if isinstance(value, bool) or not isinstance(value, (int, float)) or math.isnan(value):
            raise self._wrong(value, "a number")
        limited = self._limited(value)
        if kind is int:
            if limited != math.floor(limited):
                raise self._wrong(value, "a whole number")
            limited = int(limited)
        else:
            limited = float(limited)
        if limited == value:
            return limited, ""
        warning = "%s is %s, outside of [%s, %s]: %s is used" % (
            self.name,
            value,
            self.minimum,
            self.maximum,
            limited,
        )
        return limited, warning

    def _limited(self, value: Union[int, float]) -> Union[int, float]:
        if self.minimum is not None and value < self.minimum:
            value = self.minimum
        if self.maximum is not None and value > self.maximum:
            value = self.maximum
        if math.isinf(value):
            raise self._wrong(value, "a finite number")
        return value

    def _wrong(self, value: Any, expected: str) -> MeshMapError:
        return MeshMapError("%s is %r, but it has to be %s" % (self.name, value, expected))

"""Declarations of the parameters of a layer."""

import difflib
import math
import sys
from dataclasses import dataclass
from typing import Any, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from mesh_map.base.errors import MeshMapError

Value = Union[bool, int, float, str, Tuple[Any, ...], Mapping[str, Any]]

_LARGEST = sys.float_info.max
_ALIKE = 0.8  # of the letters
_OTHER_KINDS = (
    (bool, bool, "a boolean"),
    (str, str, "a string"),
    (tuple, (tuple, list), "a list"),
    (dict, Mapping, "a dictionary"),
)


@dataclass(frozen=True)
class Parameter:
    """One parameter: its type is that of its default.

    Attributes:
        name, default, description: for users; units belong in the description. A default that is a
            tuple or a dictionary makes a parameter that is a list (given to the layer as a tuple)
            or a dictionary; what is in it is for the layer to check.
        minimum, maximum: the range of a number, None for no limit. A value outside is moved to the
            limit with a warning, as dynamic_reconfigure does. Infinite values are refused, unless
            the limit on their side is infinite itself.
        affects_costs: False for one that is applied to costs afterwards (a threshold, a factor), so
            that stored costs stay good when it changes.
        choices: of a string, all values that it may have; empty for any.
    """

    name: str
    default: Value
    minimum: Optional[float] = None
    maximum: Optional[float] = None
    description: str = ""
    affects_costs: bool = True
    choices: Tuple[str, ...] = ()

    def checked(self, value: Any) -> Tuple[Value, str]:
        """The value in the right type and range, and a warning ("" for none).

        Raises:
            MeshMapError: another type, NaN, or none of the choices.
        """
        if isinstance(value, np.generic):
            value = value.item()
        kind = type(self.default)
        for known, accepted, text in _OTHER_KINDS:
            if kind is known:
                if not isinstance(value, accepted):
                    raise self._wrong(value, text)
                if self.choices and value not in self.choices:
                    raise self._wrong(value, "one of " + ", ".join(self.choices))
                return kind(value), ""
        if isinstance(value, bool) or not isinstance(value, (int, float)) or value != value:
            raise self._wrong(value, "a number")
        limited = self._limited(value)
        if kind is int:
            if math.isinf(limited) or limited != int(limited):
                raise self._wrong(value, "a whole number")
            limited = int(limited)
        else:
            limited = float(limited)
        if limited == value:
            return limited, ""
        warning = "%s is %s, outside of [%s, %s]: %s is used" % (
            self.name,
            value,
            "-inf" if self.minimum is None else self.minimum,
            "inf" if self.maximum is None else self.maximum,
            limited,
        )
        return limited, warning

    def _limited(self, value: Union[int, float]) -> Union[int, float]:
        if self.minimum is not None and value < self.minimum:
            value = self.minimum
        if self.maximum is not None and value > self.maximum:
            value = self.maximum
        if not -_LARGEST <= value <= _LARGEST and value not in (self.minimum, self.maximum):
            raise self._wrong(value, "a finite number")
        return value

    def _wrong(self, value: Any, expected: str) -> MeshMapError:
        return MeshMapError("%s is %r, but it has to be %s" % (self.name, value, expected))


def checked_values(
    parameters: Iterable[Parameter], given: Mapping[str, Any]
) -> Tuple[Dict[str, Value], List[str]]:
    """The value of each parameter, the default where none is given, and one line for each warning.

    Raises:
        MeshMapError: a value that Parameter.checked() refuses.
    """
    values, warnings = {}, []
    for parameter in parameters:
        value = given.get(parameter.name, parameter.default)
        values[parameter.name], warning = parameter.checked(value)
        if warning:
            warnings.append(warning)
    return values, warnings


def misspelled(names: Iterable[Any], known: Iterable[str]) -> List[str]:
    """One sentence for each name that is none of the known ones, and nearly one of them."""
    known, found = list(known), []
    for name in names:
        if name not in known:
            for meant in difflib.get_close_matches(str(name), known, 1, _ALIKE):
                found.append("the parameter %s is not known; is %s meant?" % (name, meant))
    return found


def read_parameters(
    parameters: Sequence[Parameter],
    given: Mapping[str, Any],
    present: Optional[Mapping[str, Value]] = None,
) -> Tuple[Dict[str, Value], List[str]]:
    """The value of each parameter, and one sentence for each given value not used as it is.

    A number beyond its limits is moved to the limit, as dynamic_reconfigure does and configurations
    in the field rely on; in place of a value of another type, the default is used. Names that are
    no parameter are left alone: users keep settings of other programs there.

    Args:
        parameters: all that there are.
        given: the values that users give.
        present: of values that change: what they are now, which stays where nothing else will do.
    """
    values = {p.name: p.default for p in parameters} if present is None else dict(present)
    otherwise = "the default %r is used" if present is None else "it stays %r"
    complaints = []
    for parameter in parameters:
        if parameter.name not in given:
            continue
        try:
            values[parameter.name], complaint = parameter.checked(given[parameter.name])
        except MeshMapError as error:
            complaint = "%s: %s" % (error, otherwise % (values[parameter.name],))
        if complaint:
            complaints.append(complaint)
    return values, complaints

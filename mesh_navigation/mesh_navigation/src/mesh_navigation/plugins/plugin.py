"""What planners, controllers and recovery behaviors have in common."""

import threading
from typing import Any, ClassVar, List, Mapping, Tuple

from mesh_map.base.parameter import Parameter, Value, misspelled, read_parameters
from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.body.body import POINT, Body


class _Values:
    """Values of parameters, replaced as a whole; shared by the copies of a plugin."""

    def __init__(self, present: Mapping[str, Value]) -> None:
        self.lock = threading.Lock()
        self.present = present


class MeshPlugin:
    """Has a name, a map, and parameters that may change at any time.

    Construction takes no arguments and does nothing long. ``initialize`` is called once per map,
    before anything else; it may take its time.
    """

    parameters: ClassVar[Tuple[Parameter, ...]] = ()
    """What may be set below the plugin's name, with default and limits."""

    name: str = ""
    map: MeshMap
    body: Body = POINT
    """Of the robot on that map, set before ``initialize``; a point where nobody says."""

    def initialize(self, name: str, mesh_map: MeshMap, given: Mapping[str, Any] = {}) -> List[str]:
        """Prepare for work on a map.

        Args:
            name: of the plugin among the server's.
            mesh_map: with its layers computed.
            given: parameters that differ from their defaults.

        Returns:
            One sentence for each given value that could not be used as it is, and for each name
            that is nearly that of a parameter.
        """
        self.name = name
        self.map = mesh_map
        values, complaints = read_parameters(self.parameters, given)
        self._values = _Values(values)
        return complaints + misspelled(given, [parameter.name for parameter in self.parameters])

    @property
    def values(self) -> Mapping[str, Value]:
        """The parameters' values, complete and within their limits; never changed, only replaced.

        Take them once for what belongs together.
        """
        return self._values.present

    def set_parameters(self, values: Mapping[str, Any]) -> List[str]:
        """Change parameters, from any thread, while the plugin works.

        Args:
            values: those that change. Names that are no parameter are left alone.

        Returns:
            One sentence for each value that could not be used as it is: one beyond its limits is
            moved to the limit, in place of one of another type the present value stays.
        """
        shared = self._values
        with shared.lock:
            shared.present, complaints = read_parameters(self.parameters, values, shared.present)
        return complaints

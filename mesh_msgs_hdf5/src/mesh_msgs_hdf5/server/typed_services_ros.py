"""A service that clients know under two types."""
from typing import Any, Callable, Dict, Tuple

import rospy
from rospy.impl.tcpros_service import ServiceImpl

Answers = Tuple[Any, Callable[[Any], Any]]  # a service class, and its handler


class ServiceOfTwoTypes(rospy.Service):
    """Answers each client in the type whose md5 sum it asks with.

    rospy compares the sum of a request with that of the service's one type, and logs an error for
    any other one, at each call. The master is told the first type.
    """

    def __init__(self, name: str, first: Answers, second: Answers) -> None:
        (kind, handler), (other, other_handler) = first, second
        self._second_sum = other._md5sum
        self._second = ServiceImpl(name, other, other_handler)
        sums = _Sums(kind._md5sum)
        sums.other = other._md5sum
        members: Dict[str, Any] = {"_md5sum": sums}
        super().__init__(name, type(kind.__name__, (kind,), members), handler)

    def handle(self, transport: Any, header: Dict[str, str]) -> None:
        """Called by rospy, in a thread for each connection."""
        if header["md5sum"] == self._second_sum:
            self._second.handle(transport, header)
        else:
            super().handle(transport, header)


class _Sums(str):
    """An md5 sum that equals a second one, too."""

    other = ""

    def __eq__(self, sum_: object) -> bool:
        return str.__eq__(self, sum_) or self.other == sum_

    def __ne__(self, sum_: object) -> bool:
        return not self == sum_

    __hash__ = str.__hash__

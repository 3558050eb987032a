"""One difference between two meshes."""
from typing import Any, Dict, NamedTuple


class Difference(NamedTuple):
    """member: what differs, such as "vertices", "layers/slope" or "labels/tree_1"; kind: "count",
    "changed", "only in one", "only in other", or "same" for a remark on the others; text: a
    sentence; details: numbers for programs.
    """

    member: str
    kind: str
    text: str
    details: Dict[str, Any]

    def line(self) -> str:
        """For a person."""
        return "%s: %s" % (self.member, self.text)

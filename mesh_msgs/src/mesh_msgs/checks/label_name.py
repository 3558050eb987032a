"""Which texts may name labels: one rule for messages, maps, journals and label files.

RViz's is written in C++ (rviz_mesh_plugin, labels/label_name.h). Tests hold both to the same cases,
mesh_msgs/test/label_names.json.
"""

import re
from typing import NamedTuple, Optional

MAX_LABEL_BYTES = 255  # labels become names of files and HDF5 datasets

_CONTROL = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029]")
_NO_UTF8 = re.compile("[\ud800-\udfff]")
# They turn the direction of what follows, or are dropped by those who read text: with them, one
# name looks like another.
_DISGUISE = re.compile("[\u202a-\u202e\u2066-\u2069\ufeff]")


class LabelFault(NamedTuple):
    """What makes a text unusable as a label.

    what: the end of a sentence that begins with the label.
    index: the first character (for a text that is too long: byte) that does.
    """

    what: str
    index: int


def label_fault(label: str) -> Optional[LabelFault]:
    """What makes a text unusable as a label; None: nothing. Whether it is empty is not asked."""
    size = len(label.encode("utf-8", "surrogatepass"))
    if size > MAX_LABEL_BYTES:
        return LabelFault("has %d bytes" % size, MAX_LABEL_BYTES)
    control = _CONTROL.search(label)
    if control:
        return LabelFault("contains a control character", control.start())
    if "/" in label:
        return LabelFault("contains a slash", label.index("/"))
    if label in (".", ".."):
        return LabelFault("is no name", 0)
    undecoded = _NO_UTF8.search(label)
    if undecoded:
        return LabelFault("is no UTF-8", undecoded.start())
    disguise = _DISGUISE.search(label)
    if disguise:
        what = "contains U+%04X, which makes it look like another" % ord(disguise.group())
        return LabelFault(what, disguise.start())
    return None

"""What an FBX file says of its unit and axes, which assimp does not apply.

Binary files (7.x) and ASCII ones have the same properties: a name, three texts, a value.
"""
import re
import struct
from typing import Optional

from mesh_msgs_hdf5.files.probe import FBX_SIGNATURE

_VALUES = {ord("I"): "<i", ord("L"): "<q", ord("D"): "<d", ord("F"): "<f"}
_AXES = {0.0: "x", 1.0: "y", 2.0: "z"}
_CENTIMETER = 0.01  # what UnitScaleFactor counts
_TEXTS = 3  # between a name and its value


def up_axis(data: bytes) -> str:
    """One of x, y and z; y where the file does not say it."""
    number = _setting(data, b"UpAxis")
    return "y" if number is None else _AXES.get(number, "y")


def unit(data: bytes) -> float:
    """Meters; a centimeter where the file does not say it."""
    factor = _setting(data, b"UnitScaleFactor")
    return _CENTIMETER * (factor if factor is not None and 0 < factor < 1e12 else 1.0)


def _setting(data: bytes, name: bytes) -> Optional[float]:
    if data.startswith(FBX_SIGNATURE):
        return _binary_setting(data, name)
    found = re.search(rb'"' + name + rb'"[^\n]*,\s*(-?[\d.eE+-]+)\s*$', data, re.MULTILINE)
    try:
        return float(found[1]) if found else None
    except ValueError:
        return None


def _binary_setting(data: bytes, name: bytes) -> Optional[float]:
    key = b"S" + struct.pack("<I", len(name)) + name
    at = data.find(key)
    if at < 0:
        return None
    at += len(key)
    for _ in range(_TEXTS):
        if data[at : at + 1] != b"S" or len(data) < at + 5:
            return None
        at += 5 + struct.unpack_from("<I", data, at + 1)[0]
    form = _VALUES.get(data[at]) if at < len(data) else None
    if form is None or len(data) < at + 1 + struct.calcsize(form):
        return None
    return float(struct.unpack_from(form, data, at + 1)[0])

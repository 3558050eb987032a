"""Attributes of the objects of an open HDF5 file: single values and short rows of numbers."""
from typing import Any, Optional, Union

import h5py
import numpy as np

from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

MAX_ATTRIBUTE_BYTES = 1 << 20
_CLASSES = (h5py.h5t.INTEGER, h5py.h5t.FLOAT, h5py.h5t.STRING)


def attribute(path: PathLike, owner: Any, name: str) -> Union[str, int, float, None]:
    """The value of an attribute: str, int or float; None if there is none.

    Raises MapFileError (size, value).
    """
    value = _value(path, owner, name)
    if isinstance(value, (bytes, str)):
        try:  # h5py gives texts of variable length undecodable bytes as surrogates
            value = value.decode("utf-8") if isinstance(value, bytes) else value
            value.encode("utf-8")
        except UnicodeError as error:
            raise MapFileError(
                "value", path, "attribute %s of %s is not UTF-8" % (name, owner.name), ""
            ) from error
    elif hasattr(value, "item") and getattr(value, "size", 0) == 1:
        value = value.item()
    if value is not None and not isinstance(value, (str, int, float)):
        raise MapFileError(
            "value", path, "attribute %s of %s is no single value" % (name, owner.name), ""
        )
    return value


def text_attribute(path: PathLike, owner: Any, name: str) -> Optional[str]:
    """The text of an attribute; None if there is none.

    Raises MapFileError (size, value).
    """
    value = attribute(path, owner, name)
    if value is not None and not isinstance(value, str):
        raise MapFileError(
            "value", path, "attribute %s of %s is not a text" % (name, owner.name), ""
        )
    return value


def row_attribute(path: PathLike, owner: Any, name: str, length: int) -> Optional[np.ndarray]:
    """The numbers of an attribute: (length,) as they are stored; None if there is none.

    Raises MapFileError (size, value).
    """
    value = _value(path, owner, name)
    if value is None:
        return None
    value = np.asarray(value)
    if value.dtype.kind not in "fiu" or value.size != length:
        raise MapFileError(
            "value", path, "attribute %s of %s is not %d numbers" % (name, owner.name, length), ""
        )
    return value.reshape(-1)


def _value(path, owner, name):
    key = name.encode("utf-8")
    if not h5py.h5a.exists(owner.id, key):
        return None
    found = h5py.h5a.open(owner.id, key)
    if found.get_storage_size() > MAX_ATTRIBUTE_BYTES:
        raise MapFileError("size", path, "attribute %s of %s is too big" % (name, owner.name), "")
    kind = found.get_type().get_class()
    if kind not in _CLASSES:  # references and the like are not looked at
        raise MapFileError(
            "value", path, "attribute %s of %s is neither text nor number" % (name, owner.name), ""
        )
    if kind != h5py.h5t.STRING and found.get_space().get_simple_extent_type() != h5py.h5s.NULL:
        value = np.zeros(found.shape, found.dtype)  # owner.attrs takes twice as long
        found.read(value)
        return value[()]
    return owner.attrs[name]

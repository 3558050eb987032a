"""Random messages of the generated classes, made from their slot types alone."""

import io
import math

import genpy
import std_msgs.msg
from genpy.message import get_message_class
from hypothesis import strategies as st

from mesh_msgs import array_services, arrays


def classes_of(module):
    """Those that a module defines."""
    found = [value for value in vars(module).values() if isinstance(value, type)]
    return [value for value in found if value.__module__ == module.__name__]


ARRAY_MESSAGES = classes_of(arrays)
ARRAY_RESPONSES = [cls for cls in classes_of(array_services) if issubclass(cls, genpy.Message)]
ARRAY_SERVICES = [cls for cls in classes_of(array_services) if cls not in ARRAY_RESPONSES]
ARRAY_CLASSES = ARRAY_MESSAGES + ARRAY_RESPONSES

UINT32 = st.integers(0, 2**32 - 1)
PRIMITIVES = {
    "uint32": UINT32,
    "float32": st.floats(width=32),
    "float64": st.floats(),
    "string": st.text(max_size=9),
    "bool": st.booleans(),
    "time": st.builds(genpy.Time, UINT32, st.integers(0, 999999999)),
}


def stock_of(cls):
    """The generated class below an array class."""
    return next(
        base
        for base in cls.__mro__
        if not issubclass(base, tuple(ARRAY_CLASSES)) and issubclass(base, genpy.Message)
    )


def values(slot_type, max_size=5):
    """Strategy for a member of a ROS type."""
    if slot_type.endswith("]"):
        base, size = slot_type[:-1].split("[")
        low, high = (int(size), int(size)) if size else (0, max_size)
        return st.lists(values(base, max_size), min_size=low, max_size=high)
    if slot_type in PRIMITIVES:
        return PRIMITIVES[slot_type]
    cls = std_msgs.msg.Header if slot_type == "Header" else get_message_class(slot_type)
    return messages(cls, max_size)


def messages(cls, max_size=5):
    """Strategy for messages of a generated class."""
    return st.builds(cls, *[values(t, max_size) for t in cls._slot_types])


def filled(cls, size, seed=0):
    """A message of a generated class whose arrays have `size` items, all numbers different."""
    counter = iter(range(seed + 1, 10**9))

    def value(slot_type):
        if slot_type.endswith("]"):
            base, fixed = slot_type[:-1].split("[")
            return [value(base) for _ in range(int(fixed) if fixed else size)]
        if slot_type in ("float32", "float64"):
            return next(counter) / 4.0
        if slot_type == "uint32":
            return next(counter)
        if slot_type == "bool":
            return next(counter) % 2 == 0
        if slot_type == "string":
            return "größe %d" % next(counter)
        if slot_type == "time":
            return genpy.Time(next(counter), next(counter))
        inner = std_msgs.msg.Header if slot_type == "Header" else get_message_class(slot_type)
        return inner(*[value(t) for t in inner._slot_types])

    return cls(*[value(t) for t in cls._slot_types])


def encoded(message):
    """The serialized message."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def has_nan(message):
    """Whether any number of a generated message is NaN."""
    if isinstance(message, float):
        return math.isnan(message)
    if isinstance(message, (list, tuple)):
        return any(has_nan(item) for item in message)
    if isinstance(message, genpy.Message):
        return any(has_nan(getattr(message, name)) for name in message.__slots__)
    return False

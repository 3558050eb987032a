"""What every message with array members has in common."""

import io
from functools import partial
from typing import Any, Callable, ClassVar, Dict, Mapping, Optional, Tuple

import genpy

from mesh_msgs.wire.array_field import ArrayField, ConvertedOnWrite
from mesh_msgs.wire.fields import (
    HeaderField,
    MaterialListField,
    MessageField,
    MessageListField,
    NumberField,
    StringField,
)
from mesh_msgs.wire.framing import ArrayError, Parts, Reader

_POSITIONS = partial(ArrayField, dtype="<f8", columns=3, attributes=("x", "y", "z"))
_INDICES = partial(ArrayField, dtype="<u4", columns=3, attributes=("vertex_indices",))
# How members of these ROS types are carried. All others are messages that have an array class.
_FIELDS: Dict[str, Callable[[str], Any]] = {
    "std_msgs/Header": HeaderField,
    "string": StringField,
    "float32": partial(NumberField, code="f"),
    "bool": partial(NumberField, code="B"),
    "float32[]": partial(ArrayField, dtype="<f4"),
    "uint32[]": partial(ArrayField, dtype="<u4"),
    "geometry_msgs/Point[]": _POSITIONS,
    "geometry_msgs/Vector3[]": _POSITIONS,
    "std_msgs/ColorRGBA[]": partial(
        ArrayField, dtype="<f4", columns=4, attributes=("r", "g", "b", "a")
    ),
    "mesh_msgs/MeshTriangleIndices[]": _INDICES,
    "mesh_msgs/MeshVertexTexCoords[]": partial(
        ArrayField, dtype="<f4", columns=2, attributes=("u", "v")
    ),
    "mesh_msgs/MeshMaterial[]": MaterialListField,
}
_ARRAY_CLASSES: Dict[str, Any] = {}  # by their ROS types


class ArrayMessage:
    """Mixin in front of a generated message class: its array members become NumPy arrays.

    A subclass stays what ROS knows by `_type`, `_md5sum` and `_full_text`, has the same
    `__slots__`, constructor and bytes, and its instances are instances of the generated class.

    Attributes:
        FIELDS: the members in wire order, as follows from their types.
        OTHER_FIELDS: name -> field, of members that are carried in another way than others of their
            type.

    Raises:
        ArrayError (a ValueError): on assignment or serialization of a value that the member cannot
            carry. Nothing is written to the buffer in that case.
        genpy.DeserializationError: on a buffer that is truncated or whose lengths lie.
    """

    __slots__ = ()

    FIELDS: ClassVar[Tuple[Any, ...]] = ()
    OTHER_FIELDS: ClassVar[Mapping[str, Callable[[str], Any]]] = {}
    _slots: ClassVar[Dict[str, Any]] = {}
    _type: ClassVar[str]

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        if ArrayMessage not in cls.__bases__:
            return
        stock = stock_class(cls)
        cls.FIELDS = tuple(
            cls.OTHER_FIELDS[name](name) if name in cls.OTHER_FIELDS else _field(name, slot_type)
            for name, slot_type in zip(stock.__slots__, stock._slot_types)
        )
        _ARRAY_CLASSES[stock._type] = cls
        cls._slots = {field.name: getattr(stock, field.name) for field in cls.FIELDS}
        for field in cls.FIELDS:
            if isinstance(field, ArrayField) or field.normalizes:
                setattr(cls, field.name, _normalizing_property(field, cls._slots[field.name]))
        # genpy and rospy read the names of the members here. The empty __slots__ of the class body
        # kept instances free of a __dict__: a misspelled member stays an error.
        cls.__slots__ = stock.__slots__

    @classmethod
    def from_message(cls, message: Any) -> Any:
        """`message` itself if it is of this class, else a new one with its values as arrays.

        Args:
            message: a message of the same ROS type, e.g. of the generated class.
        Raises:
            ArrayError: another type, or a value that does not fit.
        """
        if isinstance(message, cls):
            return message
        if getattr(message, "_type", None) != cls._type:
            shown = getattr(message, "_type", type(message).__name__)
            raise ArrayError("expected a %s, got %s" % (cls._type, shown))
        return cls(**{field.name: getattr(message, field.name) for field in cls.FIELDS})

    def serialize(self, buff: Any) -> None:
        """Writes the message to a file-like object, as genpy's method does."""
        parts: Parts = []
        self._write(parts)
        for part in parts:
            if isinstance(part, ConvertedOnWrite):
                part.write_to(buff)
            else:
                buff.write(part)

    def deserialize(self, data: bytes) -> Any:
        """Reads the message; arrays become read-only views of `data` and keep it in memory."""
        reader = Reader(data, self._type)
        values = [field.read(reader) for field in self.FIELDS]
        self._store(values)
        return self

    def serialize_numpy(self, buff: Any, _numpy: Any) -> None:
        """Same as serialize: genpy's own form for flat number arrays has nothing to add."""
        ArrayMessage.serialize(self, buff)

    def deserialize_numpy(self, data: bytes, _numpy: Any) -> Any:
        """Same as deserialize."""
        return ArrayMessage.deserialize(self, data)

    def _write(self, parts: Parts) -> None:
        for field in self.FIELDS:
            try:
                field.write(getattr(self, field.name), parts)
            except ArrayError as error:
                raise ArrayError("%s.%s" % (self._type, error)) from error.__cause__

    @classmethod
    def _read(cls, reader: Reader) -> Any:
        message = cls.__new__(cls)
        message._store([field.read(reader) for field in cls.FIELDS])
        return message

    def _store(self, values: Any) -> None:
        for field, value in zip(self.FIELDS, values):
            self._slots[field.name].__set__(self, value)

    def _check_types(self, exc: Optional[Exception] = None) -> None:
        """genpy's check before a message is sent; its own does not know arrays."""
        self._write([])
        if exc is not None:
            raise genpy.SerializationError(str(exc))

    def __eq__(self, other: Any) -> bool:
        if getattr(other, "_type", None) != self._type:
            return False
        if not isinstance(other, type(self)):
            try:
                other = type(self).from_message(other)
            except ArrayError:
                return False
        return all(f.equal(getattr(self, f.name), getattr(other, f.name)) for f in self.FIELDS)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        """Types and shapes of the arrays, not their numbers: a logged message may have millions."""
        members = ["%s=%s" % (f.name, f.summary(getattr(self, f.name))) for f in self.FIELDS]
        return "%s(%s)" % (self._type, ", ".join(members))

    __str__ = __repr__


def _field(name: str, slot_type: str) -> Any:
    """The member of this name and ROS type."""
    if slot_type in _FIELDS:
        return _FIELDS[slot_type](name)
    if not slot_type.endswith("[]"):
        return MessageField(name, _ARRAY_CLASSES[slot_type])
    message_class, empty = _ARRAY_CLASSES[slot_type[:-2]], io.BytesIO()
    message_class().serialize(empty)
    return MessageListField(name, message_class, empty.tell())


def stock_class(cls: Any) -> Any:
    """The generated class below an array class."""
    for base in cls.__mro__:
        if issubclass(base, genpy.Message) and not issubclass(base, ArrayMessage):
            return base
    raise TypeError("%s does not derive from a generated message class" % cls.__name__)


def _normalizing_property(field: Any, slot: Any) -> property:
    def store(message: Any, value: Any) -> None:
        try:
            slot.__set__(message, field.normalize(value))
        except ArrayError as error:
            raise ArrayError("%s.%s" % (message._type, error)) from error.__cause__

    kind = "array" if isinstance(field, ArrayField) else "message"
    return property(slot.__get__, store, doc="The %s %s." % (kind, field.name))

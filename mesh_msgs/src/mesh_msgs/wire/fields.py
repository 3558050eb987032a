"""Message members that are no arrays: header, strings, numbers, messages within messages, lists."""
import struct
from typing import Any, List, Optional, Type

import std_msgs.msg

import mesh_msgs.msg
from mesh_msgs.wire.framing import ArrayError, Parts, Reader, pack, pack_count, pack_string

_MATERIAL = struct.Struct("<IffffB")  # texture_index, color (red, green, blue, alpha), has_texture


class Field:
    """One member: how it is normalized when assigned, written, read, compared and shown.

    This base class stores what is assigned as it is.
    """

    normalizes = False

    def __init__(self, name: str) -> None:
        self.name = name

    def normalize(self, value: Any) -> Any:
        """The value to be stored for an assigned one."""
        return value

    def write(self, value: Any, parts: Parts) -> None:
        """Appends the bytes of the member, or raises ArrayError."""
        raise NotImplementedError

    def read(self, reader: Reader) -> Any:
        """Reads the member, or raises genpy.DeserializationError."""
        raise NotImplementedError

    @staticmethod
    def equal(left: Any, right: Any) -> bool:
        """Whether two values of the member are the same."""
        return bool(left == right)

    def summary(self, value: Any) -> str:
        """A short text, however large the value is."""
        return repr(value)


class HeaderField(Field):
    """A std_msgs/Header."""

    _layout = struct.Struct("<III")

    def write(self, value: Any, parts: Parts) -> None:
        try:
            numbers = (value.seq, value.stamp.secs, value.stamp.nsecs)
            frame_id = value.frame_id
        except AttributeError as error:
            raise ArrayError("%s: expected a std_msgs/Header: %s" % (self.name, error)) from error
        parts.append(pack(self._layout, self.name + " (seq, secs, nsecs)", *numbers))
        parts.append(pack_string(self.name + ".frame_id", frame_id))

    def read(self, reader: Reader) -> Any:
        header = std_msgs.msg.Header()
        numbers = reader.unpack(self.name, self._layout)
        header.seq, header.stamp.secs, header.stamp.nsecs = numbers
        header.frame_id = reader.string(self.name + ".frame_id")
        return header

    def summary(self, value: Any) -> str:
        if value is None:
            return "None"
        stamp = "%d.%09d" % (value.stamp.secs, value.stamp.nsecs)
        return "(seq %s, stamp %s, frame_id %r)" % (value.seq, stamp, value.frame_id)


class StringField(Field):
    """A string."""

    def write(self, value: Any, parts: Parts) -> None:
        parts.append(pack_string(self.name, value))

    def read(self, reader: Reader) -> str:
        return reader.string(self.name)


class NumberField(Field):
    """One number of struct format `code`: "B" is a bool, "f" a float32."""

    def __init__(self, name: str, code: str) -> None:
        super().__init__(name)
        self._layout = struct.Struct("<" + code)
        self._type = bool if code == "B" else float

    def write(self, value: Any, parts: Parts) -> None:
        parts.append(pack(self._layout, self.name, value))

    def read(self, reader: Reader) -> Any:
        return self._type(reader.unpack(self.name, self._layout)[0])

    @staticmethod
    def equal(left: Any, right: Any) -> bool:
        return bool(left == right or (left != left and right != right))  # NaN equals NaN


class MessageField(Field):
    """A message of an array class within a message; a stock message is converted when assigned."""

    normalizes = True

    def __init__(self, name: str, message_class: Type[Any]) -> None:
        super().__init__(name)
        self.message_class = message_class

    def normalize(self, value: Any) -> Any:
        return None if value is None else converted(self.name, self.message_class, value)

    def write(self, value: Any, parts: Parts) -> None:
        if value is None:
            raise ArrayError("%s: is None, not a %s" % (self.name, self.message_class._type))
        value._write(parts)

    def read(self, reader: Reader) -> Any:
        return self.message_class._read(reader)


class ListField(Field):
    """A list that stays one; in summaries it is `items` after its length."""

    items = ""

    @staticmethod
    def equal(left: Any, right: Any) -> bool:
        if left is None or right is None:
            return left is right
        return list(left) == list(right)

    def summary(self, value: Any) -> str:
        return "None" if value is None else "%d %s" % (len(value), self.items)


class MessageListField(ListField):
    """Messages of an array class or its stock class, of `item_size` bytes or more each."""

    def __init__(self, name: str, message_class: Type[Any], item_size: int) -> None:
        super().__init__(name)
        self.message_class = message_class
        self.item_size = item_size
        self.items = "x " + message_class._type

    def write(self, value: Any, parts: Parts) -> None:
        parts.append(pack_count(self.name, length_of(self.name, value)))
        for index, item in enumerate(value):
            converted("%s[%d]" % (self.name, index), self.message_class, item)._write(parts)

    def read(self, reader: Reader) -> List[Any]:
        count = reader.count(self.name, self.item_size)
        return [self.message_class._read(reader) for _ in range(count)]


class ScalarListField(ListField):
    """A short list of uint32 that stays a list."""

    items = "x uint32"
    _item = struct.Struct("<I")

    def write(self, value: Any, parts: Parts) -> None:
        count = length_of(self.name, value)
        parts.append(pack_count(self.name, count))
        parts.append(pack(struct.Struct("<%dI" % count), self.name, *value))

    def read(self, reader: Reader) -> List[int]:
        count = reader.count(self.name, self._item.size)
        return list(reader.unpack(self.name, struct.Struct("<%dI" % count)))


def converted(name: str, message_class: Type[Any], value: Any) -> Any:
    """A message in its array class; an ArrayError that names the member where it is another one."""
    try:
        return message_class.from_message(value)
    except ArrayError as error:
        raise ArrayError("%s: %s" % (name, error)) from error.__cause__


def length_of(name: str, value: Optional[Any]) -> int:
    """Length of a list member; an ArrayError where it is no list."""
    try:
        return len(value)  # type: ignore[arg-type]
    except TypeError as error:
        raise ArrayError("%s: expected a list, got %r" % (name, value)) from error


class MaterialListField(ListField):
    """A list of mesh_msgs/MeshMaterial."""

    items = "materials"

    def write(self, value: Any, parts: Parts) -> None:
        parts.append(pack_count(self.name, length_of(self.name, value)))
        for index, item in enumerate(value):
            name = "%s[%d]" % (self.name, index)
            try:
                color = (item.color.r, item.color.g, item.color.b, item.color.a)
                numbers = (item.texture_index, *color, item.has_texture)
            except AttributeError as error:
                raise ArrayError("%s: expected a MeshMaterial: %s" % (name, error)) from error
            parts.append(pack(_MATERIAL, name, *numbers))

    def read(self, reader: Reader) -> List[Any]:
        count = reader.count(self.name, _MATERIAL.size)
        return [_material(*reader.unpack(self.name, _MATERIAL)) for _ in range(count)]


def _material(index: int, r: float, g: float, b: float, a: float, has_texture: int) -> Any:
    material = mesh_msgs.msg.MeshMaterial(texture_index=index, has_texture=bool(has_texture))
    material.color.r, material.color.g, material.color.b, material.color.a = r, g, b, a
    return material

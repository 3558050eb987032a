"""The list of materials of a mesh: few, so they stay message objects."""

import struct
from typing import Any, List

import mesh_msgs.msg

from mesh_msgs._fields import Field, length_of
from mesh_msgs._wire import ArrayError, Parts, Reader, pack, pack_count

_MATERIAL = struct.Struct("<IffffB")  # texture_index, color (red, green, blue, alpha), has_texture


class MaterialListField(Field):
    """A list of mesh_msgs/MeshMaterial."""

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

    def summary(self, value: Any) -> str:
        return "None" if value is None else "%d materials" % len(value)


def _material(index: int, r: float, g: float, b: float, a: float, has_texture: int) -> Any:
    material = mesh_msgs.msg.MeshMaterial(texture_index=index, has_texture=bool(has_texture))
    material.color.r, material.color.g, material.color.b, material.color.a = r, g, b, a
    return material

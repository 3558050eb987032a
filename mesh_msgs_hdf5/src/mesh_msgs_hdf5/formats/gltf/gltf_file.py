"""A glTF 2.0 file (GLB, or JSON with files beside it): its objects, buffers and accessors, checked.

Format: Khronos Group, glTF 2.0 Specification, 2021.
"""
import base64
import binascii
import json
import struct
from typing import Any, Dict, List, NoReturn, Optional
from urllib.parse import unquote

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.formats.base.beside import Folder, shown
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

MAGIC = b"glTF"
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942
_MAX_JSON = 64 << 20
_MAX_ZEROS = 1 << 24  # values of accessors that take no bytes in the file
COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_REPAIR = "export it again where it was made"


class GltfFile:
    """The JSON of the file (json), and what its indices mean; each refusal is a MapFileError."""

    def __init__(self, path: PathLike, data: bytes) -> None:
        self.path, self.folder = path, Folder(path)
        self._binary: Optional[memoryview] = None
        self._buffers: Dict[int, memoryview] = {}
        self._zeros = 0
        text = self._chunks(data) if data[:4] == MAGIC else data
        if len(text) > _MAX_JSON:
            raise MapFileError(
                "size",
                path,
                "its JSON has %d bytes, more than %d" % (len(text), _MAX_JSON),
                "export a .glb",
            )
        try:
            self.json = json.loads(text.decode("utf-8-sig"))
        except (ValueError, RecursionError) as error:
            reason = "nested too deeply" if isinstance(error, RecursionError) else str(error)
            raise MapFileError(
                "format", path, "the JSON of the glTF file cannot be read: %s" % reason, _REPAIR
            ) from error
        asset = self.json.get("asset") if isinstance(self.json, dict) else None
        version = asset.get("version") if isinstance(asset, dict) else None
        if not isinstance(version, str) or not version.startswith("2."):
            raise MapFileError(
                "format",
                path,
                "it is no glTF 2.0 file (version %s)" % one_line(repr(version))[:40],
                "export it as glTF 2.0",
            )

    def damaged(self, text: str, *values: Any) -> NoReturn:
        """Raise MapFileError."""
        raise MapFileError("damaged", self.path, text % values if values else text, _REPAIR)

    def _chunks(self, data):
        """The bytes of the JSON chunk of a GLB; the binary chunk is remembered."""
        if len(data) < 20:
            self._truncated(len(data), 20)
        version, length = struct.unpack_from("<2I", data, 4)
        if version != 2:
            raise MapFileError(
                "format", self.path, "it is GLB version %d, not 2" % version, "export it again"
            )
        if length > len(data):
            self._truncated(len(data), length)
        text, at, view = None, 12, memoryview(data)
        while at + 8 <= length:
            size, kind = struct.unpack_from("<2I", data, at)
            at += 8
            if at + size > length:
                self._truncated(len(data), at + size)
            if kind == JSON_CHUNK and text is None:
                text = bytes(view[at : at + size])
            elif kind == BINARY_CHUNK and self._binary is None:
                self._binary = view[at : at + size]
            at += size
        if text is None:
            self.damaged("the GLB file has no JSON chunk")
        return text

    def _truncated(self, found, wanted):
        raise MapFileError(
            "truncated",
            self.path,
            "the file is cut off: it has %d bytes of %d" % (found, wanted),
            "copy or fetch it again",
        )

    def items(self, kind: str) -> List[Any]:
        """The list of that name, e.g. meshes; empty if there is none."""
        found = self.json.get(kind, [])
        if not isinstance(found, list):
            self.damaged("%s is no list", kind)
        return found

    def item(self, kind: str, index: Any) -> Dict[str, Any]:
        """The object that an index refers to."""
        found = self.items(kind)
        if type(index) is not int or not 0 <= index < len(found):
            self.damaged(
                "something refers to %s of %s, of which there are %d",
                one_line(repr(index))[:40],
                kind,
                len(found),
            )
        if not isinstance(found[index], dict):
            self.damaged("%d of %s is no object", index, kind)
        return found[index]

    def whole(self, holder: Dict[str, Any], key: str, default: Optional[int], what: str) -> int:
        """A whole number >= 0 of an object."""
        value = holder.get(key, default)
        if type(value) is not int or not 0 <= value < 1 << 53:
            self.damaged("%s: %s is %s", what, key, one_line(repr(value))[:40])
        return value

    def numbers(self, holder: Dict[str, Any], key: str, default: List[float]) -> np.ndarray:
        """A list of finite numbers of an object, as long as the default."""
        found = holder.get(key, default)
        sound = isinstance(found, list) and len(found) == len(default)
        if not sound or not all(type(value) in (int, float) for value in found):
            self.damaged("%s is %s, not %d numbers", key, one_line(repr(found))[:60], len(default))
        try:
            array = np.array(found, dtype=np.float64)
        except OverflowError:
            array = np.array([np.inf])
        if not np.isfinite(array).all():
            self.damaged("%s is not finite", key)
        return array

    def buffer(self, index: Any) -> memoryview:
        """The bytes of a buffer: of the binary chunk, of a data URI, or of a file beside it."""
        item = self.item("buffers", index)
        if index not in self._buffers:
            if "uri" in item:
                data = memoryview(self._uri(item["uri"], "buffer %d" % index))
            elif index == 0 and self._binary is not None:
                data = self._binary
            else:
                self.damaged("buffer %d has no bytes", index)
            length = self.whole(item, "byteLength", None, "buffer %d" % index)
            if length > len(data):
                self.damaged("buffer %d has %d bytes, not %d", index, len(data), length)
            self._buffers[index] = data[:length]
        return self._buffers[index]

    def _uri(self, uri, what):
        data, reason = self.read_uri(uri)
        if data is None:
            raise MapFileError(
                "missing",
                self.path,
                "%s (%s) %s" % (what, shown(str(uri)[:120]), reason),
                "put it into the folder of the mesh, or export a .glb",
            )
        return data

    def read_uri(self, uri: Any):
        """(bytes, "") of a data URI or a file beside this one, or (None, why not)."""
        if not isinstance(uri, str):
            return None, "has no name"
        if uri.startswith("data:"):
            head, _, text = uri.partition(",")
            try:
                if head.endswith(";base64"):
                    return base64.b64decode(text, validate=True), ""
            except (binascii.Error, ValueError):
                pass
            return None, "is no data in base64"
        return self.folder.read(unquote(uri))

    def view(self, index: Any) -> memoryview:
        """The bytes of a buffer view."""
        item, what = self.item("bufferViews", index), "buffer view %s" % index
        data = self.buffer(item.get("buffer"))
        start = self.whole(item, "byteOffset", 0, what)
        length = self.whole(item, "byteLength", None, what)
        if start + length > len(data):
            self.damaged("%s ends at byte %d of a buffer of %d", what, start + length, len(data))
        return data[start : start + length]

    def accessor(self, index: Any) -> np.ndarray:
        """(N, C) of an accessor, in its own type."""
        item, what = self.item("accessors", index), "accessor %s" % index
        width = _WIDTHS.get(item.get("type")) if isinstance(item.get("type"), str) else None
        if width is None:
            self.damaged("%s is of the type %s", what, one_line(repr(item.get("type")))[:40])
        kind = self._component(item, what)
        count = self.whole(item, "count", None, what)
        if "bufferView" in item:
            result = self._stored(item, what, count, width, kind)
        else:
            self._zeros += count * width
            if self._zeros > _MAX_ZEROS:
                raise MapFileError(
                    "size", self.path, "%s has %d values but no bytes" % (what, count), _REPAIR
                )
            result = np.zeros((count, width), kind)
        return self._with_sparse(item, what, result) if "sparse" in item else result

    def _component(self, item, what):
        kind = item.get("componentType")
        if type(kind) is not int or kind not in COMPONENTS:
            self.damaged("%s has the component type %s", what, one_line(repr(kind))[:40])
        return np.dtype(COMPONENTS[kind])

    def _stored(self, item, what, count, width, kind):
        data = self.view(item["bufferView"])
        start = self.whole(item, "byteOffset", 0, what)
        size = width * kind.itemsize
        stride = self.whole(self.item("bufferViews", item["bufferView"]), "byteStride", size, what)
        if stride < size:
            self.damaged("%s: its rows of %d bytes are %d bytes apart", what, size, stride)
        if count and start + stride * (count - 1) + size > len(data):
            self.damaged(
                "%s needs %d bytes of a buffer view of %d",
                what,
                start + stride * (count - 1) + size,
                len(data),
            )
        if not count:
            return np.zeros((0, width), kind)
        return np.ndarray((count, width), kind, data, start, (stride, kind.itemsize))

    def _with_sparse(self, item, what, result):
        sparse = item["sparse"]
        parts = [
            sparse.get(key) if isinstance(sparse, dict) else None for key in ("indices", "values")
        ]
        if not all(isinstance(part, dict) and "bufferView" in part for part in parts):
            self.damaged("%s: sparse is no object with indices and values", what)
        count = self.whole(sparse, "count", None, what)
        at = self._stored(parts[0], what, count, 1, self._component(parts[0], what))[:, 0]
        if at.dtype.kind != "u" or (at >= len(result)).any():
            self.damaged("%s: a sparse index is not below %d", what, len(result))
        result = result.copy()
        result[at] = self._stored(parts[1], what, count, result.shape[1], result.dtype)
        return result

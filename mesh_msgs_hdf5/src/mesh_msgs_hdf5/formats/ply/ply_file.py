"""Reads the elements of a PLY file: ASCII, binary little and big endian, any element and property.

Format: G. Turk, The PLY Polygon File Format, 1994.
"""
import re
from collections import Counter
from dataclasses import dataclass, field
from typing import Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.formats.base.numbers_text import numbers
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "int64": "i8",
    "uint64": "u8",
    "float32": "f4",
    "float64": "f8",
}
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_MAX_HEADER = 1 << 24  # remarks of our exports (a label, a layer) are lines of it
_END = re.compile(rb"[\r\n]end_header[ \t]*(\r\n|\n|\r)")


@dataclass
class Property:
    """type and count: NumPy types without byte order.

    Count is None for a property that is no list.
    """

    name: str
    type: str
    count: Optional[str] = None


@dataclass
class Element:
    """Rows of one kind.

    After reading, values has (N,) for a plain property, lists (counts (N,), all items) for a list.
    """

    name: str
    rows: int
    properties: List[Property] = field(default_factory=list)
    values: Dict[str, np.ndarray] = field(default_factory=dict)
    lists: Dict[str, Tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    _types: Dict[str, np.dtype] = field(default_factory=dict, repr=False)

    def typed(self, name: str) -> np.ndarray:
        """(N,) of a plain property in the type that the header says, in native byte order.

        The numbers of an ASCII file that do not fit that type stay float64.
        """
        values = self.values[name]
        if len(self._types) < len(self.properties):
            self._types = {p.name: np.dtype(p.type) for p in self.properties}
        kind = self._types[name]
        if values.dtype.newbyteorder("=") == kind:
            return values.astype(kind, copy=False)
        with np.errstate(all="ignore"):
            result = values.astype(kind)
            fits = kind.kind == "f" or (result == values).all()
        return result if fits else values


def columns(element: Element, names: Sequence[str]) -> np.ndarray:
    """(N, C) of plain properties, in the type that holds them all, in native byte order."""
    found = [element.values[name] for name in names]
    return np.stack(found, axis=1).astype(np.result_type(*found).newbyteorder("="), copy=False)


class PlyFile(NamedTuple):
    """elements: by name; comments: of the header; left_over: values (ASCII) or bytes behind the
    last element.
    """

    elements: Dict[str, Element]
    comments: List[str]
    left_over: int


def read_elements(path: PathLike, data: bytes) -> PlyFile:
    """Everything in a PLY file's bytes.

    MapFileError (format, truncated).
    """
    order, elements, comments, offset = _header(path, data)
    if order:
        left_over = _read(path, np.frombuffer(data, np.uint8)[offset:], elements, order)
    else:
        try:
            left_over = _read(path, numbers(path, data[offset:], "data"), elements, order)
        except MapFileError:
            _check_lines(path, data[offset:], elements)
            raise
        if left_over:
            _check_lines(path, data[offset:], elements)
    return PlyFile({element.name: element for element in elements}, comments, left_over)


def _read(path, items, elements, order):
    """Fill the elements; returns how many items are left over."""
    for element in elements:
        items = items[_Rows(path, items, element, order).read() :]
    return len(items)


def _check_lines(path, data, elements):
    """Refuse a file whose lines are its rows if one, but for the last, has more than is declared:
    what comes behind is read as something else, and what is wrong there is not what is wrong.
    """
    lines = [line.split() for line in data.splitlines() if line.strip()]
    if len(lines) != sum(element.rows for element in elements):
        return
    rest = iter(lines[:-1])
    for element in elements:
        for row, words in zip(range(element.rows), rest):
            count = _declared_values(element, words)
            if len(words) > count:
                raise MapFileError(
                    "format",
                    path,
                    "row %d of element %s has %d values, but the header declares %d"
                    % (row, element.name, len(words), count),
                    "add a property to the header for each value",
                )


def _declared_values(element, words):
    """How many values a row has by the header and the lengths of its lists."""
    count = 0
    for p in element.properties:
        length = words[count] if p.count and count < len(words) else b""
        count += 1 + (int(length) if length.isdigit() else 0)
    return count


def _header(path, data):
    end = _END.search(data, 0, _MAX_HEADER)
    if end is None:
        raise MapFileError(
            "truncated", path, "the PLY header has no end_header line", "copy or fetch it again"
        )
    order, elements, comments = None, [], []
    for line in re.split("\r\n|\n|\r", data[: end.start()].decode("latin-1"))[1:]:
        words = line.split()
        try:
            if not words or words[0] == "obj_info":
                continue
            if words[0] == "comment":
                comments.append(line.strip()[len("comment") :].strip())
                continue
            if words[0] == "format":
                order = _ORDERS[words[1]]
            elif words[0] == "element":
                elements.append(Element(words[1], int(words[2])))
                if elements[-1].rows < 0:
                    raise ValueError("negative count")
            elif words[0] == "property" and words[1] == "list":
                count, kind, name = words[2:5]
                elements[-1].properties.append(Property(name, TYPES[kind], TYPES[count]))
            elif words[0] == "property":
                elements[-1].properties.append(Property(words[2], TYPES[words[1]]))
            else:
                raise KeyError(words[0])
        except (KeyError, IndexError, ValueError) as error:
            raise MapFileError(
                "format",
                path,
                "cannot read the PLY header line: %s" % one_line(line)[:80],
                "export the mesh again where it was made",
            ) from error
    if order is None:
        raise MapFileError(
            "format",
            path,
            "the PLY header has no format line",
            "as: format binary_little_endian 1.0",
        )
    _check_names(path, "elements", elements)
    for element in elements:
        _check_names(path, "properties of element %s" % element.name, element.properties)
    return order, elements, comments, end.end()


def _check_names(path, what, items):
    number = Counter(item.name for item in items)
    twice = sorted(name for name in number if number[name] > 1)
    if twice:
        raise MapFileError(
            "format", path, "the PLY header has two %s named %s" % (what, twice[0]), "rename one"
        )


class _Rows:
    """Reads one element from items: bytes, or the numbers of an ASCII file (each of size 1)."""

    def __init__(self, path, items, element, order):
        self.path, self.items, self.element, self.order = path, items, element, order

    def size(self, kind):
        return np.dtype(kind).itemsize if self.order else 1

    def read(self):
        """Fill the element; returns how many items it takes."""
        element = self.element
        if not element.rows or not element.properties:
            self._store(0, [0] * len(element.properties), 0)
            return 0
        smallest = sum(self.size(p.count or p.type) for p in element.properties)
        if element.rows * smallest > len(self.items):
            self._truncated(len(self.items) // smallest)
        lengths = self._first_lengths()
        width = smallest + sum(
            length * self.size(p.type) for p, length in zip(element.properties, lengths) if p.count
        )
        if element.rows * width <= len(self.items):
            if self._store(element.rows, lengths, width):
                return element.rows * width
        return self._walk()

    def _first_lengths(self):
        """Lengths of the first row's lists (0 for plain properties)."""
        offset, lengths = 0, []
        for p in self.element.properties:
            length = self._length(p, offset, 0) if p.count else 0
            lengths.append(length)
            offset += (
                self.size(p.count) + length * self.size(p.type) if p.count else self.size(p.type)
            )
        return lengths

    def _length(self, p, offset, row):
        raw = self.items[offset : offset + self.size(p.count)]
        if len(raw) < self.size(p.count):
            self._truncated(row)
        value = raw.view(self.order + p.count)[0] if self.order else raw[0]
        if not (value >= 0 and value == int(value)):
            raise MapFileError(
                "format",
                self.path,
                "row %d of element %s has a list of length %s" % (row, self.element.name, value),
                "is the file damaged?",
            )
        return int(value)

    def _store(self, rows, lengths, width):
        """Take rows that all have the same list lengths; False if they have not."""
        element, offset, found = self.element, 0, []
        table = self.items[: rows * width].reshape(rows, width)
        for p, length in zip(element.properties, lengths):
            if p.count:
                counts = self._column(table, offset, p.count, 1, rows).reshape(-1)
                if not (counts == length).all():
                    return False
                offset += self.size(p.count)
                values = self._column(table, offset, p.type, length, rows).reshape(-1)
                found.append((element.lists, p.name, (np.full(rows, length, np.int64), values)))
                offset += length * self.size(p.type)
            else:
                values = self._column(table, offset, p.type, 1, rows).reshape(-1)
                found.append((element.values, p.name, values))
                offset += self.size(p.type)
        for place, name, values in found:
            place[name] = values
        return True

    def _column(self, table, offset, kind, length, rows):
        if not rows or not length:
            return np.zeros((rows, length), kind)
        block = np.ascontiguousarray(table[:, offset : offset + length * self.size(kind)])
        if not self.order:
            return block  # numbers as written; the mesh is checked when they are converted
        return block.view(self.order + kind)

    def _walk(self):
        """Rows of different lengths: find the places row by row, then gather all at once."""
        properties = self.element.properties
        steps = [(p.count, self.size(p.count or p.type), self.size(p.type)) for p in properties]
        places = [[] for _ in properties]
        counts = [[] for _ in properties]
        columns = list(zip(steps, properties, places, counts))
        length_at = self._length_reader()
        offset, end = 0, len(self.items)
        for row in range(self.element.rows):
            for (count, first, size), p, place, number in columns:
                if not count:
                    place.append(offset)
                    offset += size
                    continue
                if offset + first > end:
                    self._truncated(row)
                length = length_at(p, offset, row)
                offset += first
                place.append(offset)
                number.append(length)
                offset += length * size
            if offset > end:
                self._truncated(row)
        for _, p, place, number in columns:
            number = np.array(number if p.count else [1] * len(place), dtype=np.int64)
            values = self._gather(np.array(place, dtype=np.int64), number, p.type)
            if p.count:
                self.element.lists[p.name] = (number, values)
            else:
                self.element.values[p.name] = values
        return offset

    def _length_reader(self):
        """A function of property, offset and row; fast for the usual lists of a binary file."""
        kinds = {p.count for p in self.element.properties if p.count}
        if self.order and kinds == {"u1"}:
            data = memoryview(self.items)
            return lambda _p, offset, _row: data[offset]
        return self._length

    def _gather(self, places, counts, kind):
        size = self.size(kind)
        within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        index = np.repeat(places, counts) + within * size
        if not self.order:
            return self.items[index]
        raw = np.ascontiguousarray(self.items[index[:, None] + np.arange(size)])
        return raw.view(self.order + kind).reshape(-1)

    def _truncated(self, rows):
        raise MapFileError(
            "truncated",
            self.path,
            "the file is cut off: it announces %d rows of element %s, but holds about %d"
            % (self.element.rows, self.element.name, rows),
            "copy or fetch it again",
        )

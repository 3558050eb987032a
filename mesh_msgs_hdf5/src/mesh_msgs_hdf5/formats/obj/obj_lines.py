"""The lines of an OBJ file as arrays, in blocks; only the few lines that hold no numbers are looked
at one by one.
"""
import re
from dataclasses import dataclass, field
from typing import Dict, Iterator, List, Tuple

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.formats.base.numbers_text import numbers
from mesh_msgs_hdf5.formats.base.remarks import PREFIX
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

_SLASH, _BLANK, _NEWLINE = ord("/"), 32, 10
_BLOCK_BYTES = 8 << 20
_CONTINUED = re.compile(rb"\\[ \t]*(?:\r\n|\n|\r)")
_INDENTED = re.compile(rb"(?m)^ +")
_COMMENT_BEHIND = re.compile(rb"(?m)^(v|vn|vt|f)( [^\n#]*)#[^\n]*")
_BLANKS = bytes.maketrans(b"\t\v\f\r", b"   \n")
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
_NUMBERS = {b"v": "vertices", b"vn": "normals", b"vt": "texture coordinates", b"f": "faces"}
_NAMES = (b"usemtl", b"g", b"o", b"mtllib")
_SILENT = {b"s"}  # they change no value of the mesh


def corner_numbers(path: PathLike, text: bytes, counts: np.ndarray, first: int) -> np.ndarray:
    """(N, 3) whole numbers of the corners: vertex, texture coordinates, normal; 0 if there is none.

    text: corners like 1, 1/2, 1//3 or 1/2/3 with blanks between; counts: corners of each face;
    first: the number of the first face, for the error.
    """
    found = _found(path, text, counts, first)
    small = not len(found) or max(-found.min(), found.max()) < 1 << 31
    return found.astype(np.int32) if small else found


def _found(path, text, counts, first):
    total = int(counts.sum())
    found = np.zeros((total, 3), np.int64)
    slashes = text.count(b"/")
    if not slashes:
        found[:, 0] = numbers(path, text, "faces", np.int64, before=first)
        return found
    if slashes == _same_slashes(text, total) * total:
        # all corners have the same form, or one has too few numbers: then they are not enough
        doubled = text.count(b"//")
        columns = {(1, 0): [0, 1], (2, 0): [0, 1, 2], (2, total): [0, 2]}.get(
            (slashes // total, doubled)
        )
        if columns is not None:
            flat = numbers(path, text.replace(b"/", b" "), "faces", np.int64, before=first)
            if len(flat) == total * len(columns):
                found[:, columns] = flat.reshape(-1, len(columns))
                return found
    return _one_by_one(path, text, counts, found, first)


def _same_slashes(text, total):
    """How many slashes each corner has, or 0 if they differ."""
    letters = np.frombuffer(text, np.uint8)
    places = np.flatnonzero(_word_begins(letters))
    number = np.add.reduceat(letters == _SLASH, places, dtype=np.int64)
    return int(number[0]) if len(places) == total and (number == number[0]).all() else 0


def _word_begins(letters):
    """(N,): which letters of a text are the first of a word."""
    in_word = (letters != _BLANK) & (letters != _NEWLINE)
    begins = in_word.copy()
    begins[1:] &= ~in_word[:-1]
    return begins


def _one_by_one(path, text, counts, found, first):
    for i, word in enumerate(text.split()):
        parts = word.split(b"/")
        try:
            if len(parts) > 3:
                raise ValueError
            for column, part in enumerate(parts):
                if part or column == 0:
                    found[i, column] = int(part)
        except (ValueError, OverflowError) as error:
            face = first + int(np.searchsorted(np.cumsum(counts), i, side="right"))
            raise MapFileError(
                "format",
                path,
                "face %d has a corner that is none: %s" % (face, one_line(repr(word[:40])[1:])),
                "is the file damaged?",
            ) from error
    return found


def from_zero(written: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Indices from 0 of OBJ's numbers (N,): from 1, or negative from the last one before the face.

    last: (N,) how many stood before the face. 0 becomes -1: no index.
    """
    if (written >= 0).all():
        return written - 1
    return np.where(written > 0, written - 1, np.where(written < 0, last + written, -1))


@dataclass
class Table:
    """Numbers of lines: values (all numbers, one after the other), counts (numbers per line)."""

    values: List[np.ndarray] = field(default_factory=list)
    counts: List[np.ndarray] = field(default_factory=list)
    rows: int = 0

    def add(self, values: np.ndarray, counts: np.ndarray) -> None:
        self.values.append(values)
        self.counts.append(counts)
        self.rows += len(counts)

    def joined(self) -> Tuple[np.ndarray, np.ndarray]:
        """(values, counts) of all lines."""
        none = np.zeros(0), np.zeros(0, np.int64)
        return tuple(  # type: ignore[return-value]
            np.concatenate(parts) if parts else empty
            for parts, empty in zip((self.values, self.counts), none)
        )


@dataclass
class ObjLines:
    """vertices, normals, coordinates: numbers of the lines v, vn, vt.

    faces: of each corner, three whole numbers as they stand in the file (vertex, texture, normal; 0
    where there is none), and the number of corners of each face. before: for each face how many
    vertices, coordinates and normals stand before it, what negative numbers count from; an empty
    list if there are none. names: (number of faces before it, key, text) of lines usemtl, g and
    mtllib. others: how many lines of each key were not read. remarks: comments of our exports.
    """

    vertices: Table = field(default_factory=Table)
    normals: Table = field(default_factory=Table)
    coordinates: Table = field(default_factory=Table)
    faces: Table = field(default_factory=Table)
    before: List[np.ndarray] = field(default_factory=list)
    names: List[Tuple[int, bytes, bytes]] = field(default_factory=list)
    others: Dict[bytes, int] = field(default_factory=dict)
    remarks: List[str] = field(default_factory=list)

    def table(self, key: bytes) -> Table:
        """The table of the lines that begin with this key."""
        named = {b"v": self.vertices, b"vn": self.normals, b"vt": self.coordinates}
        return named.get(key, self.faces)


def read_lines(path: PathLike, data: bytes) -> ObjLines:
    """All lines of an OBJ file's bytes."""
    lines = ObjLines()
    negative = False
    for block in _blocks(data):
        negative |= _Block(path, block, lines).read()
    if not negative:
        lines.before = []
    return lines


def _blocks(data: bytes) -> Iterator[bytes]:
    """The data in pieces that end where a line ends that is not continued."""
    start = len(_BYTE_ORDER_MARK) if data.startswith(_BYTE_ORDER_MARK) else 0
    while start < len(data):
        end = start + _BLOCK_BYTES
        while True:
            end = data.find(b"\n", end) + 1
            line = data[max(start, end - 100) : end].rstrip()
            if not end or not line.endswith(b"\\"):
                break
        yield data[start : end or len(data)]
        start = end or len(data)


class _Block:
    """Some whole lines of the file."""

    def __init__(self, path, block, lines):
        self._path, self._lines = path, lines
        if b"\\" in block:
            block = _CONTINUED.sub(b" ", block)
        block = block.translate(_BLANKS)
        if block.startswith(b" ") or b"\n " in block:
            block = _INDENTED.sub(b"", block)
        if block.count(b"#") > block.count(b"\n#") + block.startswith(b"#"):
            block = _COMMENT_BEHIND.sub(rb"\1\2", block)
        # so that each line ends, and the third letter of each can be looked at
        self._bytes = np.frombuffer(block + b"\n\n\n", np.uint8)
        self._text = block
        ends = np.flatnonzero(self._bytes[: len(block) + 1] == _NEWLINE)
        self._starts = np.concatenate([[0], ends[:-1] + 1])
        self._ends = ends

    def read(self):
        """Put everything into the lines; returns whether a face counts from the end."""
        first, second, third = (self._bytes[self._starts + i] for i in range(3))
        # an empty line begins with its end: it is none of these
        kinds = {
            b"v": (first == ord("v")) & (second == _BLANK),
            b"vn": (first == ord("v")) & (second == ord("n")) & (third == _BLANK),
            b"vt": (first == ord("v")) & (second == ord("t")) & (third == _BLANK),
            b"f": (first == ord("f")) & (second == _BLANK),
        }
        others = (first != _NEWLINE) & ~np.logical_or.reduce(list(kinds.values()))
        faces_before = self._lines.faces.rows
        before = [self._lines.table(key).rows for key in (b"v", b"vt", b"vn")]
        self._read_others(np.flatnonzero(others), faces_before, kinds[b"f"])
        for key in (b"v", b"vn", b"vt"):
            text, counts = self._words(kinds[key], len(key))
            table = self._lines.table(key)
            read = sum(len(values) for values in table.values)
            table.add(numbers(self._path, text, _NUMBERS[key], before=read), counts)
        return self._read_faces(kinds, before)

    def _read_faces(self, kinds, before):
        text, counts = self._words(kinds[b"f"], 1)
        if not len(counts):
            return False
        self._lines.faces.add(
            corner_numbers(self._path, text, counts, self._lines.faces.rows), counts
        )
        at = np.flatnonzero(kinds[b"f"])
        self._lines.before.append(
            np.stack(
                [n + np.cumsum(kinds[key])[at] for n, key in zip(before, (b"v", b"vt", b"vn"))],
                axis=1,
            )
        )
        return b"-" in text

    def _words(self, chosen, key_length):
        """(text of the chosen lines without their keys, number of words of each)."""
        if not chosen.any():
            return b"", np.zeros(0, np.int64)
        lengths = self._ends - self._starts + 1
        found = self._bytes[: lengths.sum()][np.repeat(chosen, lengths)].copy()
        starts = np.cumsum(lengths[chosen]) - lengths[chosen]
        for i in range(key_length):
            found[starts + i] = _BLANK
        return found.tobytes(), np.add.reduceat(_word_begins(found), starts, dtype=np.int64)

    def _read_others(self, at, faces_before, is_face):
        faces = faces_before + np.cumsum(is_face)
        for i in at.tolist():
            line = self._text[self._starts[i] : self._ends[i]]
            key, _, text = line.partition(b" ")
            if key[:1] == b"#":
                comment = line[1:].decode("latin-1").strip()
                if comment.startswith(PREFIX):
                    self._lines.remarks.append(comment)
            elif key in _NUMBERS:
                raise MapFileError(
                    "format",
                    self._path,
                    "a line %s of the OBJ file has no values" % key.decode(),
                    "is the file damaged?",
                )
            elif key in _NAMES:
                self._lines.names.append((int(faces[i]), key, text.strip()))
            elif key not in _SILENT:
                self._lines.others[key] = self._lines.others.get(key, 0) + 1

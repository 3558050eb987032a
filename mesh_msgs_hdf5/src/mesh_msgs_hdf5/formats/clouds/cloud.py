"""A point cloud in a file: what its points have, and the points block by block."""
from dataclasses import dataclass, field
from typing import Callable, Dict, Iterator, List, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

BLOCK_ROWS = 1 << 17
MOST_HEADER = 1 << 16  # bytes
MOST_FIELDS = 256
POINTS = "points"
# what is one array of several fields, in LVR2's names
GROUPED: Dict[str, Tuple[str, ...]] = {
    POINTS: ("x", "y", "z"),
    "normals": ("nx", "ny", "nz"),
    "colors": ("red", "green", "blue"),
}


@dataclass
class Cloud:
    """count: points; dtype: the fields of one, in the order of the file, native or not; blocks: a
    function that reads them, (n,) of that dtype at a time; format: of the file; viewpoint: (4, 4)
    of the sensor, as far as the file says it: None where it says something else."""

    path: PathLike
    format: str
    count: int
    dtype: np.dtype
    blocks: Callable[[], Iterator[np.ndarray]]
    viewpoint: Optional[np.ndarray] = field(default_factory=lambda: np.eye(4))

    def channels(self) -> Dict[str, Tuple[str, ...]]:
        """Array -> the fields that it is made of; those that belong together are one."""
        left = list(self.dtype.names or ())
        found = {}
        for name, fields in GROUPED.items():
            kinds = {self.dtype[f] for f in fields if f in left}
            if set(fields) <= set(left) and len(kinds) == 1 and not next(iter(kinds)).shape:
                found[name] = fields
                left = [f for f in left if f not in fields]
        if POINTS not in found:
            text = "its points have no x, y and z of one type"
            raise MapFileError("format", self.path, text, "the fields are: %s" % ", ".join(left))
        taken = set(found)
        for name in left:
            plain = "".join(c if c.isprintable() and c != "/" else "_" for c in name)
            if not plain or plain in taken or plain in (".", ".."):
                text = "field %r cannot be kept: its name is taken, or none" % name[:80]
                raise MapFileError("format", self.path, text, "rename it in the cloud")
            taken.add(plain)
            found[plain] = (name,)
        return found


def checked_dtype(path: PathLike, fields: List[Tuple], what: str = "point") -> np.dtype:
    """The dtype of these fields. Raises MapFileError where it cannot be."""
    names = [field[0] for field in fields]
    if not fields or len(fields) > MOST_FIELDS or len(set(names)) < len(names):
        text = "its %ss have %d fields, which are none, too many, or of one name" % (
            what,
            len(fields),
        )
        raise MapFileError("format", path, text, "is it a point cloud?")
    return np.dtype(fields)


def cut_short(path: PathLike, have: int, wanted: int) -> MapFileError:
    """The error of a file with fewer points than it says."""
    text = "it ends at point %d of %d" % (have, wanted)
    return MapFileError("damaged", path, text, "the file was not written, or copied, to its end")


def too_many(path: PathLike, have: int, wanted: int) -> MapFileError:
    """The error of a file with more points than it says."""
    text = "it has %d points, but its line POINTS says %d" % (have, wanted)
    return MapFileError("damaged", path, text, "correct that line")


def binary_blocks(path: PathLike, start: int, count: int, dtype: np.dtype) -> Iterator[np.ndarray]:
    """Points that lie one behind the other from a byte on."""
    with open(path, "rb") as stream:
        stream.seek(start)
        done = 0
        while done < count:
            rows = min(BLOCK_ROWS, count - done)
            block = np.fromfile(stream, dtype, rows)
            if len(block) < rows:
                raise cut_short(path, done + len(block), count)
            yield block
            done += rows


def text_blocks(
    path: PathLike, start: int, count: int, dtype: np.dtype, alone: bool = False
) -> Iterator[np.ndarray]:
    """Points one a line, from a byte on. alone: nothing else follows."""
    width = sum(int(np.prod(dtype[name].shape, dtype=int)) for name in dtype.names)
    done = 0
    with open(path, "rb") as stream:
        stream.seek(start)
        while done < count:
            rows: List[List[bytes]] = []
            for line in stream:
                words = line.split()
                if words:
                    rows.append(words)
                    if len(words) != width:
                        text = "point %d has %d numbers, not %d" % (
                            done + len(rows) - 1,
                            len(words),
                            width,
                        )
                        raise MapFileError("damaged", path, text, "one line for each point")
                if len(rows) == min(BLOCK_ROWS // 4, count - done):
                    break
            if not rows:
                raise cut_short(path, done, count)
            yield _parsed(path, rows, dtype, done)
            done += len(rows)
        more = sum(1 for line in stream if line.strip()) if alone else 0
        if more:
            raise too_many(path, count + more, count)


def _parsed(path, rows, dtype, done):
    block = np.zeros(len(rows), dtype)
    columns = np.array(rows)
    place = 0
    for name in dtype.names:
        kind = dtype[name].base
        width = int(np.prod(dtype[name].shape, dtype=int))
        words = columns[:, place : place + width]
        place += width
        try:
            block[name] = words.astype(kind).reshape(block[name].shape)
        except (ValueError, OverflowError) as error:
            text = "field %s from point %d on has what is no %s" % (name[:80], done, kind.name)
            raise MapFileError("damaged", path, text, str(error)[:100]) from error
    return block

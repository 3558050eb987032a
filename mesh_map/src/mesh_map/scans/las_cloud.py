"""Point clouds in LAS and LAZ files, by laspy where that is there.

LAS 1.4: https://www.asprs.org/wp-content/uploads/2019/07/LAS_1_4_r15.pdf
"""

from typing import Any, Iterator, List, Tuple

import numpy as np
from mesh_msgs_hdf5.formats.clouds.cloud import BLOCK_ROWS, Cloud, cut_short
from mesh_msgs_hdf5.model.errors import MapFileError

SUFFIXES = (".las", ".laz")
_COLORS = ("red", "green", "blue")


def read_las_cloud(path: str) -> Cloud:
    """A LAS or LAZ file: x, y, z (float64), intensity, and colors where the points have some.

    Raises:
        MapFileError: laspy, or what it unpacks LAZ with, is not there; or the file is none.
    """
    try:
        import laspy
    except ImportError as error:
        text = "LAS files are read by laspy, which is not there"
        hint = "python3 -m pip install 'laspy[lazrs]', or convert the cloud to PLY or PCD"
        raise MapFileError("format", path, text, hint) from error
    with _las_errors(path), laspy.open(path) as reader:
        count = int(reader.header.point_count)
        names = set(reader.header.point_format.dimension_names)
    fields: List[Tuple[str, str]] = [(name, "<f8") for name in "xyz"]
    fields += [(name, "<u2") for name in ("intensity", *_COLORS) if name in names]
    dtype = np.dtype(fields)

    def blocks() -> Iterator[np.ndarray]:
        done = 0
        with _las_errors(path), laspy.open(path) as opened:
            for points in opened.chunk_iterator(BLOCK_ROWS):
                block = np.zeros(len(points), dtype)
                for name in dtype.names:
                    block[name] = np.asarray(getattr(points, name))
                done += len(block)
                yield block
        if done < count:
            raise cut_short(path, done, count)

    return Cloud(path, "LAS", count, dtype, blocks)


class _las_errors:
    """What laspy raises becomes a MapFileError."""

    def __init__(self, path: str) -> None:
        self._path = path

    def __enter__(self) -> None:
        pass

    def __exit__(self, _kind: Any, error: Any, _trace: Any) -> None:
        if error is None or not isinstance(error, Exception) or isinstance(error, MapFileError):
            return
        text = "laspy cannot read it: %s" % (str(error) or type(error).__name__)
        hint = "is it a LAS file?"
        if self._path.lower().endswith(".laz"):
            hint = "LAZ needs lazrs, too: python3 -m pip install 'laspy[lazrs]'; or is it damaged?"
        raise MapFileError("format", self._path, text[:200], hint) from error

"""Where scans come from: a bag, a cloud, a folder of clouds, or a map file."""

import hashlib
import os
from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Optional

from mesh_msgs_hdf5.files.probe import os_error
from mesh_msgs_hdf5.model.errors import MapFileError

from mesh_map.scans.left_out import LeftOutCounts
from mesh_map.scans.scan import Scan

_READ = 1 << 22  # bytes at once


class Step(NamedTuple):
    """One step of a source: `position` is where to go on after it; `scan` is None where what was
    there is left out."""

    position: int
    scan: Optional[Scan]


class ScanSource:
    """Scans of one input, read one at a time.

    Attributes:
        path: of the input, as the user gave it.
        kind: "bag", "clouds" or "map".
        left_out: what is left out, counted; of all sources together.
        notes: what else is to be said, once.
        options: with which it was opened, what json can write (see InputOptions.stored).
        part: how much has been read, from 0 to 1.
        identity: what makes its scans what they are, beside its files: poses of other files.
    """

    kind = ""

    def __init__(self, path: str, left_out: LeftOutCounts) -> None:
        self.path, self.left_out = path, left_out
        self.notes: List[str] = []
        self.options: Dict[str, Any] = {}
        self.part = 0.0
        self.identity = b""

    def files(self) -> List[str]:
        """The files that it is made of, in their order."""
        return [self.path]

    def steps(self, start: int = 0) -> Iterator[Step]:
        """The scans from a position on.

        Args:
            start: a `Step.position`, or 0.
        Raises:
            MapFileError: nothing of it can be used; what is said in `left_out` is
                not raised.
        """
        raise NotImplementedError


def fingerprint(
    files: List[str], is_ended: Callable[[], bool] = lambda: False, identity: bytes = b""
) -> str:
    """32 hexadecimal digits of what is in some files, in their order (BLAKE2b).

    Args:
        identity: of the source.
        is_ended: asked now and then; true gives up, and returns "".
    Raises:
        MapFileError: a file that cannot be read.
    """
    hasher = hashlib.blake2b(identity, digest_size=16)
    for path in files:
        hasher.update(b"%d;" % file_bytes([path]))
        try:
            with open(path, "rb") as stream:
                while True:
                    if is_ended():
                        return ""
                    block = stream.read(_READ)
                    if not block:
                        break
                    hasher.update(block)
        except OSError as error:
            raise os_error(path, error) from error
    return hasher.hexdigest()


def file_bytes(files: List[str]) -> int:
    """The size of some files together.

    Raises:
        MapFileError: one is not there.
    """
    total = 0
    for path in files:
        try:
            total += os.stat(path).st_size
        except OSError as error:
            raise os_error(path, error) from error
    return total


def no_scans(path: str, why: str, hint: str) -> MapFileError:
    """The error of an input of which nothing can be used."""
    return MapFileError("value", path, why, hint)

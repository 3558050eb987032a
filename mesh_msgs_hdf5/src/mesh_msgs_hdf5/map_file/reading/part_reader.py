"""What the readers of all members of a part share."""
from typing import Callable, List, TypeVar

import numpy as np

from mesh_msgs_hdf5.checks.exact import place, to_exact
from mesh_msgs_hdf5.map_file.hdf5.guarded_group import GuardedGroup
from mesh_msgs_hdf5.map_file.reading.layouts import Layout
from mesh_msgs_hdf5.model.errors import MapFileError

MAX_NOTES = 200
_MORE = "more is wrong with this file than is said here: mesh_tool validate lists all of it"
_Value = TypeVar("_Value")


class PartReader:
    """A part of an open map file, without its members; nothing is read before it is asked for.

    One bad value does not make a map useless: what means nothing by itself is left out, or mended
    where it is clear how, and notes say what, where and how many. Only the geometry has to be good.

    Attributes: guarded (the group of the part), layout, strict (what is bad is an error instead),
    notes (a sentence for each thing that is not as it is in the file).
    """

    def __init__(self, guarded: GuardedGroup, layout: Layout, strict: bool = False) -> None:
        self.guarded = guarded
        self.layout = layout
        self.strict = strict
        self.notes: List[str] = []
        if not strict:
            guarded.tell = self.note

    def note(self, text: str) -> None:
        """Say something about the file, once."""
        if text not in self.notes and len(self.notes) <= MAX_NOTES:
            self.notes.append(text if len(self.notes) < MAX_NOTES else _MORE)

    def leave_out(self, error: MapFileError) -> None:
        """What this error is about is left out. Raises it where that is not to be, and where it is
        one of size: who leaves out one large thing after the other has read much too much.
        """
        if self.strict or error.code == "size":
            raise error
        self.note("left out: " + error.message)

    def tolerated(self, read: Callable[[], _Value], default: _Value) -> _Value:
        """What is read; the default where it is left out."""
        try:
            return read()
        except MapFileError as error:
            self.leave_out(error)
            return default

    def float32(self, values: np.ndarray, name: str) -> np.ndarray:
        """Numbers as float32. Wider floats are rounded; what float32 has no number for is refused.

        name: of the values, for notes and errors.
        """
        if self.strict or values.dtype.kind != "f" or values.dtype.itemsize <= 4:
            return to_exact(values, "<f4", self.guarded.path, name)
        with np.errstate(all="ignore"):
            result = values.astype("<f4")
        if (np.isinf(result) & np.isfinite(values)).any():
            return to_exact(values, "<f4", self.guarded.path, name)
        changed = (result != values) & ~np.isnan(values)
        if changed.any():
            finite = np.where(np.isfinite(values), values, 0)
            most = np.abs(np.where(np.isfinite(result), result, 0) - finite).max()
            first = np.argwhere(changed)[0]
            self.note(
                "rounded: %s is %s; %d values are another float32, by at most %.3g, first %s"
                % (name, values.dtype.name, np.count_nonzero(changed), most, place(first))
            )
        return result

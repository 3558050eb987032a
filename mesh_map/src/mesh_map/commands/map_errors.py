"""What mesh_map says while a verb runs, as mesh_tool says it."""

import contextlib
import logging
from typing import Iterator, List

from mesh_msgs_hdf5.model.errors import MapFileError

from mesh_map.base.errors import MeshMapError


class _Notes(logging.Handler):
    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.notes: List[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        text = record.getMessage()
        if text not in self.notes:
            self.notes.append(text)


@contextlib.contextmanager
def as_map_errors(path: str) -> Iterator[List[str]]:
    """Within, errors of mesh_map become those of the file, and what it warns of becomes notes.

    Raises:
        MapFileError: code value; what an error was made of.
    """
    log, handler = logging.getLogger("mesh_map"), _Notes()
    propagate, log.propagate = log.propagate, False
    log.addHandler(handler)
    try:
        yield handler.notes
    except MeshMapError as error:
        cause = error.__cause__
        if isinstance(cause, MapFileError) and error.message == str(cause):
            raise cause from error  # it names the file, which would be there twice
        raise MapFileError("value", path, error.message, error.hint) from error
    finally:
        log.removeHandler(handler)
        log.propagate = propagate

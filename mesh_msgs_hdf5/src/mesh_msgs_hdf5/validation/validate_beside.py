"""What lies beside a map file: its journal, and what killed programs left; as findings."""
import contextlib
import fcntl
import os
from typing import Iterator

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.files.save import temporary_paths
from mesh_msgs_hdf5.formats.any_mesh import Members
from mesh_msgs_hdf5.labels.journal_reading import read_journal
from mesh_msgs_hdf5.labels.label_store import journal_path, label_file
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.validation.findings import WARNING, MapFinding


def check_journal(file: Members) -> Iterator[MapFinding]:
    """A finding if edits of labels have not been saved in the map."""
    try:
        journal = journal_path(label_file(file.path, file.schema), file.part)
        content = read_journal(journal, file.uuid, file.face_count)
    except MapFileError as error:
        text = one_line("%s: %s" % (os.path.basename(error.path), error.message))
        yield MapFinding("journal", WARNING, "labels", text)
        return
    name = one_line(os.path.basename(journal))
    if content.damaged:
        text = "lines of %s are damaged: their edits of labels are lost" % name
        yield MapFinding("journal", WARNING, "labels", text, None, len(content.damaged))
    edits = content.edits
    if edits:
        text = "edits of labels are in %s but not in the map yet (the node that owns it saves them)"
        yield MapFinding("journal", WARNING, "labels", text % name, None, len(edits))


def check_temporaries(path: str) -> Iterator[MapFinding]:
    """A finding if temporary files of saving this map are left that no program has open."""
    stale = []
    for temporary in temporary_paths(os.path.realpath(os.fsdecode(path))):
        with contextlib.suppress(OSError), open(temporary, "rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # fails while one saves
            stale.append(os.path.basename(temporary))
    if stale:
        text = "a program was killed while it saved: %s (the next save removes it)"
        text = text % one_line(stale[0])
        yield MapFinding("stale_temporary", WARNING, "file", text, None, len(stale))

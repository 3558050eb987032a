"""Looks at a label journal without changing it."""
import fcntl
import os
from typing import Any, Dict, Mapping, Optional

from mesh_msgs_hdf5.errors import MapFileError, PathLike, one_line
from mesh_msgs_hdf5.labels.journal_content import JournalContent, read_content
from mesh_msgs_hdf5.labels.journal_files import open_existing, save_error


class OwnedError(MapFileError):
    """Somebody else owns the labels (code owned); owner: what is known of them."""

    def __init__(self, path: PathLike, owner: Optional[Dict[str, Any]]) -> None:
        self.owner = owner or {}
        super().__init__(
            "owned",
            path,
            "its labels are edited by %s" % owner_text(self.owner),
            "label there, or end that program",
        )


def owner_text(owner: Mapping[str, Any]) -> str:
    """An owner in words."""
    who = str(owner.get("node") or owner.get("program") or "another program")
    where = ["pid %s" % owner["pid"]] if "pid" in owner else []
    where += ["host %s" % owner["host"]] if "host" in owner else []
    return one_line(who + (" (%s)" % ", ".join(where) if where else ""))[:200]


def is_owned(path: PathLike) -> bool:
    """True if a process holds the lock of a journal."""
    try:
        descriptor = open_existing(path, os.O_RDONLY)
    except MapFileError:
        return False
    if descriptor is None:
        return False
    try:
        return not lock(descriptor, fcntl.LOCK_SH)
    except OSError:
        return False  # no locks on this disk: nobody can tell
    finally:
        os.close(descriptor)


def read_journal(path: PathLike, uuid: str, face_count: Optional[int]) -> JournalContent:
    """The content of a journal, which is not changed.

    An empty content if there is no journal. Raises MapFileError (journal: it is of another mesh).
    """
    descriptor = open_existing(path, os.O_RDONLY)
    if descriptor is None:
        return JournalContent(uuid)
    try:
        return content_of(descriptor, path, uuid, face_count)
    except OSError as error:
        raise save_error(path, "it cannot be read", error) from error
    finally:
        os.close(descriptor)


def lock(descriptor: int, kind: int) -> bool:
    """Take a lock without waiting; False if somebody else holds it. Raises OSError."""
    try:
        fcntl.flock(descriptor, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def content_of(
    descriptor: int, path: PathLike, uuid: Optional[str], face_count: Optional[int]
) -> JournalContent:
    """The content, refused if it has edits of another geometry (uuid None: any will do)."""
    with open(descriptor, "rb", closefd=False) as stream:
        stream.seek(0)
        content = read_content(stream, path, face_count)
    if uuid is None or content.uuid == uuid or not content.has_edits:
        return content
    count = content.edit_count + len(content.damaged)
    if content.uuid is None:
        message = "it holds %d label edits, but its first lines are damaged: of which mesh?" % count
    else:
        message = "it holds %d label edits of another mesh (UUID %s, not %s)"
        message %= count, content.uuid[:80], uuid
    raise MapFileError(
        "journal",
        path,
        message,
        "put that mesh back and save its labels, or move this journal away; nothing was changed",
    )

"""What stands in a label journal, read without changing it."""
import fcntl
import os
from dataclasses import dataclass, field
from typing import Any, BinaryIO, Dict, List, Mapping, Optional

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.labels import journal_lines
from mesh_msgs_hdf5.labels.journal_files import open_existing, save_error
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Label

_MAX_LINE = 256 << 20  # bytes; nothing that a program of ours writes


@dataclass
class JournalContent:
    """The edits of a journal and what is wrong with it.

    uuid: of the geometry; None if no line says so.
    edits: text -> label, or None for a deleted one; the last edit of each label counts.
    edit_count: number of good lines with edits.
    owner: who opened it last to write.
    damaged: the lines that cannot be read or are no edits of this mesh, without their newlines.
    torn: bytes of an edit at the end that never returned, because its program was killed.
    end: where the next line begins.
    unterminated: the last line is whole but for its newline.
    """

    uuid: Optional[str] = None
    edits: Dict[str, Optional[Label]] = field(default_factory=dict)
    edit_count: int = 0
    owner: Optional[Dict[str, Any]] = None
    damaged: List[bytes] = field(default_factory=list)
    torn: int = 0
    end: int = 0
    unterminated: bool = False


def read_content(stream: BinaryIO, path: PathLike, face_count: Optional[int]) -> JournalContent:
    """Read a journal from where the stream stands.

    face_count: faces of the mesh, None if it is not known. Raises MapFileError (version) for a
    journal of a newer program, and OSError.
    """
    content = JournalContent()
    while True:
        line = stream.readline(_MAX_LINE)
        if not line:
            return content
        if line.endswith(b"\n"):
            content.end += len(line)
            if not _take(content, line[:-1], path, face_count):
                _take_pieces(content, line[:-1], path, face_count)
        elif len(line) == _MAX_LINE:
            content.end += len(line)
            content.damaged.append(line)
        elif _take(content, line, path, face_count):
            content.end += len(line)
            content.unterminated = True
        else:
            content.torn = len(line)


def _take_pieces(content, line, path, face_count):
    for piece in journal_lines.pieces(line):
        if not _take(content, piece, path, face_count):
            content.damaged.append(piece)


def _take(content, line, path, face_count):
    """Add what the line says; False if it says nothing that can be understood."""
    entry = journal_lines.decoded(line)
    if entry is None:
        return False
    if "journal" in entry:
        return _take_header(content, entry, path)
    if "owner" in entry:
        if not isinstance(entry["owner"], dict) or not isinstance(entry.get("uuid"), str):
            return False
        content.owner = entry["owner"]
        content.uuid = content.uuid or entry["uuid"]
        return True
    edit = journal_lines.edit_of(entry, face_count)
    if edit is None:
        return False
    text, label = edit
    content.edits.pop(text, None)
    content.edits[text] = label
    content.edit_count += 1
    return True


def _take_header(content, entry, path):
    version, uuid = entry.get("version"), entry.get("uuid")
    if not isinstance(uuid, str) or not isinstance(version, int):
        return False
    if entry["journal"] != journal_lines.FORMAT or version > journal_lines.VERSION:
        raise MapFileError(
            "version",
            path,
            "it is a journal of a newer Mesh Tools (%s, version %d)"
            % (str(entry["journal"])[:40], version),
            "use that one to save its labels",
        )
    content.uuid = uuid
    return True


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
    count = content.edit_count + len(content.damaged)
    if uuid is None or content.uuid == uuid or not count:
        return content
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

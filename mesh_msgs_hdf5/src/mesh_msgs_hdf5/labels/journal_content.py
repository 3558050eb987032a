"""What stands in a label journal, as far as it can be read."""
from dataclasses import dataclass, field
from typing import Any, BinaryIO, Dict, List, Optional

from mesh_msgs_hdf5.errors import MapFileError, PathLike
from mesh_msgs_hdf5.labels import journal_lines
from mesh_msgs_hdf5.mesh import Label

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

    @property
    def has_edits(self) -> bool:
        """True if something would be lost with the journal."""
        return bool(self.edit_count or self.damaged)


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

"""The label journal: edits of labels are safe in it before they are in the map file.

Beside the map garden.h5 it is garden.h5.journal: one line for each edit (see journal_lines), which
is on the disk before the edit returns. Who has it open to write holds a lock on it, which the
kernel releases when that program ends, however it ends.
"""
import contextlib
import errno
import fcntl
import os
import time
from typing import Any, Mapping, Optional

from mesh_msgs_hdf5.labels import journal_lines
from mesh_msgs_hdf5.labels.journal_files import (
    create,
    cut,
    is_at,
    keep_damaged,
    open_existing,
    replace,
    save_error,
    sync_folder,
    write_all,
)
from mesh_msgs_hdf5.labels.journal_reading import OwnedError, content_of, lock
from mesh_msgs_hdf5.model.errors import PathLike
from mesh_msgs_hdf5.model.mesh import Label

_WAIT = 0.1  # seconds: somebody who only looks whether there is an owner holds the lock shortly
_NO_LOCKS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)


class Journal:
    """A journal that is open to write, locked until close().

    Not for use from several threads at once. Attributes: path; content (what it held when it was
    opened); notes (sentences about what was found).
    """

    def __init__(
        self,
        path: PathLike,
        uuid: str,
        part: Optional[str] = None,
        face_count: Optional[int] = None,
        owner: Optional[Mapping[str, Any]] = None,
        like: Optional[PathLike] = None,
    ) -> None:
        """Open or create it, and take over its edits.

        uuid, part, face_count: of the geometry; face_count None if it is not known. owner: what
        others shall know. like: a new journal gets the owner and permissions of this file. Raises
        OwnedError, and MapFileError (journal: it is of another mesh, save: no room, ...).
        """
        self.path = os.fsdecode(path)
        self.notes = []
        self._like = like
        entries = (
            journal_lines.header(uuid, part, face_count),
            journal_lines.owner_entry(dict(owner or {}), uuid),
        )
        self._head = b"".join(journal_lines.encoded(entry) for entry in entries)
        self._folder_synced = True
        self._size = -1  # bytes, as this object has left it
        self._bad_end = None  # where the good lines end, if what follows could not be cut off
        self._descriptor, created = self._open(face_count)
        try:
            self.content = content_of(self._descriptor, self.path, uuid, face_count)
            self._take_over()
        except BaseException as error:
            if created:
                with contextlib.suppress(OSError):
                    os.unlink(self.path)
            os.close(self._descriptor)
            if isinstance(error, OSError):
                raise save_error(self.path, "it cannot be opened", error) from error
            raise

    @property
    def size(self) -> int:
        """Bytes."""
        return os.fstat(self._descriptor).st_size

    def append(self, text: str, label: Optional[Label]) -> None:
        """Add the edit of a label (faces ascending; None: deleted); it is on the disk on return.

        Raises MapFileError (save); then the journal is as it was.
        """
        line = journal_lines.encoded(journal_lines.edit_entry(text, label))
        try:
            self._append(line)
        except OSError as error:
            message = "label %s is not stored, nothing was changed" % text
            raise save_error(self.path, message, error) from error

    def rewrite(self, edits: Mapping[str, Optional[Label]]) -> None:
        """Replace all edits by these, in one step.

        Raises MapFileError (save); then the journal is as it was.
        """
        lines = [journal_lines.encoded(journal_lines.edit_entry(*edit)) for edit in edits.items()]
        try:
            keep_damaged(self.path, self.content.damaged, self._like)
            descriptor = replace(self.path, [self._head] + lines, self._like)
        except OSError as error:
            raise save_error(self.path, "it cannot be written anew", error) from error
        os.close(self._descriptor)
        self._descriptor, self._bad_end = descriptor, None
        self._size = self.size
        self._folder_synced = False
        with contextlib.suppress(OSError):  # the next edit tries again; both files have these edits
            self._sync_folder()

    def clear(self) -> None:
        """Forget all edits: they are in the map.

        Raises MapFileError (save); then they are still there, and replaying them is harmless.
        """
        try:
            keep_damaged(self.path, self.content.damaged, self._like)
            cut(self._descriptor, 0)
        except OSError as error:
            message = "the labels are in the map, but the journal cannot be emptied"
            raise save_error(self.path, message, error) from error
        self._bad_end, self._size = None, 0
        # without room for the head: the next edit brings it
        with contextlib.suppress(OSError):
            self._append(b"")

    def is_in_place(self) -> bool:
        """False if somebody has removed or replaced the file: rewrite() makes it again."""
        return is_at(self._descriptor, self.path)

    def fault(self) -> str:
        """What somebody else has done to the file, whatever locks say; "" if nothing. rewrite()
        mends it."""
        if not self.is_in_place():
            return "removed or replaced"
        if self._bad_end is None and self.size != self._size:  # else this object knows
            return "changed (%d bytes, were %d)" % (self.size, self._size)
        return ""

    def close(self, remove: bool = False) -> None:
        """End the ownership; remove: there are no edits, so no file is left behind."""
        if self._descriptor < 0:
            return
        if remove and self.is_in_place():
            with contextlib.suppress(OSError):
                os.unlink(self.path)
        with contextlib.suppress(OSError):  # everything was synced before
            os.close(self._descriptor)
        self._descriptor = -1

    def _open(self, face_count):
        """(descriptor, whether it is new)"""
        deadline = time.monotonic() + _WAIT
        while True:
            descriptor, created = open_existing(self.path, os.O_RDWR | os.O_APPEND), False
            if descriptor is None:
                descriptor, created = create(self.path, self._like), True
            if descriptor is None:  # another program was first
                continue
            try:
                self._lock(descriptor, deadline, face_count)
                if is_at(descriptor, self.path):
                    return descriptor, created
            except BaseException:
                os.close(descriptor)
                raise
            os.close(descriptor)  # its last owner removed it meanwhile

    def _lock(self, descriptor, deadline, face_count):
        while True:
            try:
                if lock(descriptor, fcntl.LOCK_EX):
                    return
            except OSError as error:
                if error.errno not in _NO_LOCKS:
                    raise save_error(self.path, "it cannot be locked", error) from error
                self.notes.append(
                    "the disk has no locks (%s): run one program at a time that labels this map"
                    % error.strerror
                )
                return
            if time.monotonic() > deadline:
                raise OwnedError(
                    self.path, content_of(descriptor, self.path, None, face_count).owner
                )
            time.sleep(0.01)

    def _take_over(self):
        """Make the journal sound, and say who owns it now."""
        content = self.content
        if content.torn:
            self.notes.append(
                "the last edit was not finished when its program ended, and is dropped (%d bytes)"
                % content.torn
            )
            cut(self._descriptor, content.end)
        if content.unterminated:
            write_all(self._descriptor, b"\n")
        if content.damaged:
            place = keep_damaged(self.path, content.damaged, self._like)
            self.notes.append(
                "%d damaged lines are not replayed; they are kept in %s"
                % (len(content.damaged), place)
            )
        if not content.edit_count:
            cut(self._descriptor, 0)
            self._append(b"")
        else:
            self._append(self._head.splitlines(True)[1])

    def _sync_folder(self):
        if not self._folder_synced:
            sync_folder(self.path)
            self._folder_synced = True

    def _append(self, line):
        self._sync_folder()
        if self._bad_end is not None:
            cut(self._descriptor, self._bad_end)
            self._bad_end = None
        end = os.fstat(self._descriptor).st_size
        try:
            write_all(self._descriptor, line if end else self._head + line)
            os.fsync(self._descriptor)
            self._size = self.size
        except BaseException:
            self._bad_end = self._size = end
            with contextlib.suppress(OSError):
                cut(self._descriptor, end)
                self._bad_end = None
            raise

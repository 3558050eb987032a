"""What a ZAE file, an archive of COLLADA with its images, holds; assimp reads its document."""
import io
import posixpath
import zipfile
from typing import Optional, Tuple
from urllib.parse import unquote

_HEAD = 1 << 20  # bytes of a document
_MOST_BYTES = 1 << 28  # of an image, however small it is packed


def document_head(data: bytes) -> bytes:
    """What the document in an archive begins with; nothing where it cannot be read."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            name = next(each for each in archive.namelist() if each.lower().endswith(".dae"))
            with archive.open(name) as stream:
                return stream.read(_HEAD)
    except Exception:  # a damaged archive may bring out anything; its reader says what is wrong
        return b""


def image_in(data: bytes, name: str) -> Tuple[Optional[bytes], str]:
    """(bytes of an image in an archive, "") or (None, why not); it is looked for by its last part,
    as documents name their images in many ways.
    """
    wanted = {posixpath.basename(text.replace("\\", "/")) for text in (name, unquote(name))}
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            for entry in archive.infolist():
                if posixpath.basename(entry.filename) in wanted:
                    with archive.open(entry) as stream:
                        found = stream.read(_MOST_BYTES + 1)
                    large = "has more than %d bytes" % _MOST_BYTES
                    return (found, "") if len(found) <= _MOST_BYTES else (None, large)
    except Exception as error:  # as above
        return None, "cannot be read: %s" % type(error).__name__
    return None, "is not in the archive"

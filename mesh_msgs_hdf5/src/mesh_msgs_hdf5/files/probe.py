"""What kind of file a path names, from its first bytes.

A distinct error for each thing that is not a mesh.
"""
import errno
import os
import stat

from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

HEAD_BYTES = 4096
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
FBX_SIGNATURE = b"Kaydara FBX Binary  \0"
LFS_POINTER = b"version https://git-lfs"
_OS_ERRORS = {
    errno.ENOENT: ("missing", "there is no such file", "check the path"),
    errno.ENOTDIR: ("missing", "a part of the path is a file, not a folder", "check the path"),
    errno.EACCES: ("permission", "no permission to read it", "chmod u+r, or run as its owner"),
    errno.EPERM: ("permission", "no permission to read it", "chmod u+r, or run as its owner"),
    errno.ENAMETOOLONG: ("name", "the name is too long for a file", "check the path"),
    errno.ELOOP: ("name", "symbolic links go round in a circle", "check the path"),
    errno.EISDIR: ("directory", "it is a folder, not a file", "name a file inside it"),
}
_KINDS = ((stat.S_ISFIFO, "pipe"), (stat.S_ISSOCK, "socket"), (lambda mode: True, "device"))


def os_error(path: PathLike, error: OSError) -> MapFileError:
    """The MapFileError of an OSError met while reading path."""
    code, message, hint = _OS_ERRORS.get(
        error.errno, ("unreadable", "cannot be read: %s" % (error.strerror or error), "")
    )
    if code == "missing" and os.path.islink(path):
        message = "it is a link to %s, which does not exist" % os.readlink(path)
    return MapFileError(code, path, message, hint)


def check_name(path: PathLike) -> None:
    """Refuse a path that no file can have."""
    if "\0" in os.fsdecode(path):
        raise MapFileError("name", path, "the name contains a NUL character", "check the path")


def check_node_path(path: str) -> None:
    """Refuse a relative path to no file: a node is not where its user is, who gave it.

    Raises MapFileError (missing).
    """
    if path and not os.path.isabs(path) and not os.path.lexists(path):
        here = os.path.abspath("")
        hint = "nodes run in %s, where relative paths begin; give an absolute path" % here
        raise MapFileError("missing", path, "there is no such file", hint)


def check_regular(path: PathLike) -> None:
    """Refuse what is no regular file, without opening it: a pipe would wait for a writer.

    Raises MapFileError (missing, directory, not_regular, name, permission, unreadable).
    """
    try:
        mode = os.stat(path).st_mode
    except ValueError:
        check_name(path)
        raise
    except OSError as error:
        raise os_error(path, error) from error
    if stat.S_ISREG(mode):
        return
    if stat.S_ISDIR(mode):
        raise os_error(path, IsADirectoryError(errno.EISDIR, "is a folder"))
    kind = next(name for test, name in _KINDS if test(mode))
    raise MapFileError("not_regular", path, "it is a %s" % kind, "name a regular file")


def read_head(path: PathLike) -> bytes:
    """The first 4096 bytes of a regular, non-empty file that is no git-LFS pointer.

    Raises MapFileError (missing, directory, not_regular, permission, name, empty, lfs_pointer,
    unreadable).
    """
    check_regular(path)
    try:
        with open(path, "rb") as stream:
            head = stream.read(HEAD_BYTES)
    except OSError as error:
        raise os_error(path, error) from error
    if not head:
        raise MapFileError("empty", path, "the file is empty (0 bytes)", "fetch or save it again")
    if head.startswith(LFS_POINTER):
        raise MapFileError(
            "lfs_pointer",
            path,
            "it is a git-LFS pointer, not the file itself",
            "run: git lfs install && git lfs pull",
        )
    return head


def read_file(path: PathLike) -> bytes:
    """All bytes of a mesh file; errors as read_head."""
    read_head(path)
    try:
        with open(path, "rb") as stream:
            return stream.read()
    except OSError as error:
        raise os_error(path, error) from error


def kind_of(path: PathLike, head: bytes) -> str:
    """One of "h5", "ply", "obj", "stl", "off", "dae", "zae", "fbx", "3ds", "glb", "gltf": by first
    bytes, or suffix.

    "" if neither tells.
    """
    if HDF5_SIGNATURE in (head[0:8], head[512:520], head[1024:1032], head[2048:2056]):
        return "h5"
    if head[:4] in (b"ply\n", b"ply\r"):
        return "ply"
    if head[:4] == b"glTF":
        return "glb"
    if b"<COLLADA" in head:
        return "dae"
    if head.startswith(FBX_SIGNATURE) or head.lstrip().startswith(b"; FBX "):
        return "fbx"
    suffix = os.path.splitext(os.fsdecode(path))[1].lower().lstrip(".")
    known = ("h5", "ply", "obj", "stl", "off", "dae", "zae", "fbx", "3ds", "glb", "gltf")
    return {"hdf5": "h5"}.get(suffix, suffix if suffix in known else "")

"""Calls that take drivers long, made without Python's lock, which pyopencl keeps in them.

Each is made once more by pyopencl, and is quick then. Where the library is not found under its
usual name, pyopencl's call is the first one.
"""

import ctypes
from typing import Any, Optional

_DEVICE_TYPE_ALL = 0xFFFFFFFF
_PROGRAM_BINARY_SIZES = 0x1165
_MOST = 64  # platforms


def _library() -> Optional[ctypes.CDLL]:
    try:
        return ctypes.CDLL("libOpenCL.so.1")
    except OSError:
        return None


def load_drivers() -> None:
    """Loads the drivers of all platforms."""
    library = _library()
    if library is None:
        return
    platforms, count = (ctypes.c_void_p * _MOST)(), ctypes.c_uint32()
    if library.clGetPlatformIDs(_MOST, platforms, ctypes.byref(count)) == 0:
        kind = ctypes.c_uint64(_DEVICE_TYPE_ALL)
        for platform in platforms[: count.value]:
            library.clGetDeviceIDs(ctypes.c_void_p(platform), kind, 0, None, ctypes.byref(count))


def link_program(program: Any) -> None:
    """Makes the binary of a program of pyopencl for one device, for which some compile again."""
    library = _library()
    if library is not None:
        size = ctypes.c_size_t()
        library.clGetProgramInfo(
            ctypes.c_void_p(program.int_ptr),
            _PROGRAM_BINARY_SIZES,
            ctypes.c_size_t(ctypes.sizeof(size)),
            ctypes.byref(size),
            None,
        )

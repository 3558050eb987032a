"""Who draws: the environments in which a program finds OSMesa, or a private X server, or both."""

import contextlib
import ctypes.util
import os
from enum import Enum
from typing import Dict, Iterator, Mapping

from osmesa_harness.xvfb import private_x_server

SHIM = "libosmesa_glx.so"
OSMESA = "libOSMesa.so.8"


class HeadlessError(Exception):
    """Something needed to run a program is missing; the message is one line with the way out."""


class BackEnd(Enum):
    """OSMESA: no X server. XVFB: its own GLX. OSMESA_X: on Xvfb, but drawn by OSMesa."""

    OSMESA = "osmesa"
    XVFB = "xvfb"
    OSMESA_X = "osmesa_x"


def shim_folder(environment: Mapping[str, str]) -> str:
    """The folder of libosmesa_glx.so, looked for as the dynamic linker and catkin do; '' where the
    linker finds it without being told, as it does in an installed Debian package.

    Raises HeadlessError where it is neither in LD_LIBRARY_PATH, in CMAKE_PREFIX_PATH/lib nor there.
    """
    folders = environment.get("LD_LIBRARY_PATH", "").split(":")
    prefixes = environment.get("CMAKE_PREFIX_PATH", "").split(":")
    folders += [os.path.join(prefix, "lib") for prefix in prefixes if prefix]
    for folder in folders:
        if folder and os.path.isfile(os.path.join(folder, SHIM)):
            return os.path.abspath(folder)
    if ctypes.util.find_library("osmesa_glx") == SHIM:
        return ""
    raise HeadlessError(
        f"{SHIM} is in none of LD_LIBRARY_PATH, CMAKE_PREFIX_PATH and the system's folders; "
        "build osmesa_harness and source the setup.bash of its workspace"
    )


def _find_shim(environment: Dict[str, str]) -> None:
    folders = [shim_folder(environment), environment.get("LD_LIBRARY_PATH", "")]
    environment["LD_LIBRARY_PATH"] = ":".join(filter(None, folders))


def _preload(environment: Dict[str, str]) -> None:
    # By bare names: LD_PRELOAD is split at spaces, too, which the folder's name may contain.
    libraries = [SHIM, OSMESA, environment.get("LD_PRELOAD", "")]
    environment["LD_PRELOAD"] = ":".join(filter(None, libraries))


@contextlib.contextmanager
def environment_of(
    back_end: BackEnd, environment: Mapping[str, str], preload: bool = True
) -> Iterator[Dict[str, str]]:
    """The environment for programs drawn by `back_end`; its X server, if any, lives as long.

    Without `preload` they must link the shim themselves: sanitizers want to be the first library.
    Raises HeadlessError where the shim or Xvfb is missing.
    """
    changed = dict(environment)
    # Pixels are pixels, whatever the screen of the person who runs this.
    for variable in ("QT_SCALE_FACTOR", "QT_SCREEN_SCALE_FACTORS", "QT_AUTO_SCREEN_SCALE_FACTOR"):
        changed.pop(variable, None)
    for variable in ("DISPLAY", "WAYLAND_DISPLAY", "XAUTHORITY", "OSMESA_GLX_NO_X"):
        changed.pop(variable, None)
    if back_end is not BackEnd.XVFB:
        _find_shim(changed)
        if preload:
            _preload(changed)
    if back_end is BackEnd.OSMESA:
        changed["QT_QPA_PLATFORM"] = "offscreen"
        changed["OSMESA_GLX_NO_X"] = "1"
        yield changed
        return
    changed["QT_QPA_PLATFORM"] = "xcb"
    try:
        with private_x_server() as display:
            changed["DISPLAY"] = display
            yield changed
    except FileNotFoundError as error:
        raise HeadlessError(f"{error.filename} is not installed: apt-get install xvfb") from error

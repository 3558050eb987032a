"""Which OpenCL device is used."""

import os
import sys
from typing import Any, List, NamedTuple, Optional, Sequence, Tuple

from mesh_map.spatial.opencl.driver_calls import load_drivers

OFF = "off"
_PREFERRED = ("GPU", "CPU", "OTHER")


class DeviceInfo(NamedTuple):
    """A device as its drivers describe it. type: GPU, CPU or OTHER."""

    type: str
    name: str
    platform: str
    driver: str
    platform_version: str
    device_version: str

    def text(self) -> str:
        """One line: name (platform, driver)."""
        return "%s (%s, driver %s)" % (self.name, self.platform, self.driver)


def device_wish(parameter: str = "auto") -> str:
    """Which device is wished for, in lower case.

    Args:
        parameter: as below; "auto" for the environment variable MESH_TOOLS_OPENCL, where it is set.
    Returns:
        "": any device: a GPU before a CPU before others;
        "off": none, everything is answered natively;
        "gpu" or "cpu": a device of that type;
        other text: a device whose name, or that of its platform, contains it.
    Raises:
        ValueError: the parameter is no string.
    """
    if not isinstance(parameter, str):
        raise ValueError(
            "device has to be auto, off, gpu, cpu or part of a name, not %r" % (parameter,)
        )
    wish = parameter.strip().lower()
    if wish in ("", "auto"):
        wish = os.environ.get("MESH_TOOLS_OPENCL", "").strip().lower()
    return "" if wish == "auto" else wish


def choose_device(infos: Sequence[DeviceInfo], wish: str) -> Optional[int]:
    """Index of the device that a wish takes, or None. Of several as good, the first."""
    best = None
    for index, info in enumerate(infos):
        if wish in ("gpu", "cpu"):
            fits = info.type.lower() == wish
        else:
            fits = wish in info.name.lower() or wish in info.platform.lower()
        rank = _PREFERRED.index(info.type)
        if wish != OFF and fits and (best is None or rank < best[0]):
            best = (rank, index)
    return None if best is None else best[1]


def list_devices() -> Tuple[List[Any], List[DeviceInfo]]:
    """The devices of all platforms that can compile and share this machine's byte order."""
    import pyopencl as cl

    load_drivers()
    devices, infos = [], []
    for platform in cl.get_platforms():
        try:
            found = platform.get_devices()
        except cl.Error:  # a platform without devices may say so as an error
            found = []
        for device in found:
            little = bool(device.endian_little) == (sys.byteorder == "little")
            old = device.version.startswith(("OpenCL 1.0", "OpenCL 1.1"))  # kernels need 1.2
            if device.available and device.compiler_available and little and not old:
                devices.append(device)
                infos.append(_describe(cl, platform, device))
    return devices, infos


def _describe(cl: Any, platform: Any, device: Any) -> DeviceInfo:
    kind = "OTHER"
    for name in ("CPU", "GPU"):
        if device.type & getattr(cl.device_type, name):
            kind = name
    texts = (device.name, platform.name, device.driver_version, platform.version, device.version)
    return DeviceInfo(kind, *(" ".join(text.replace("\0", " ").split()) for text in texts))

"""How much memory a reconstruction may take."""

import re

_UNITS = {"": 1, "k": 1 << 10, "m": 1 << 20, "g": 1 << 30, "t": 1 << 40}
_SHARE = 0.5  # of what is free
_LEAST = 256 << 20
_CGROUP = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes")


def parsed_bytes(text: str) -> int:
    """Bytes of 500M, 4G, 1.5GB or 1000000.

    Raises:
        ValueError: it is no size above 0.
    """
    found = re.fullmatch(r"([0-9.]+) *([kmgt]?)i?b?", text.strip().lower())
    if found is None:
        raise ValueError(text)
    value = int(float(found.group(1)) * _UNITS[found.group(2)])
    if value <= 0:
        raise ValueError(text)
    return value


parsed_bytes.__name__ = "size (such as 4G)"


def default_memory_limit() -> int:
    """Half of the memory that is free, within the limits of the container."""
    free = _available()
    for path in _CGROUP:
        try:
            with open(path, encoding="ascii") as stream:
                free = min(free, int(stream.read()))
        except (OSError, ValueError):  # there is none
            continue
    return max(_LEAST, int(_SHARE * free))


def _available() -> int:
    """Bytes, of /proc/meminfo."""
    try:
        with open("/proc/meminfo", encoding="ascii") as stream:
            found = re.search(r"MemAvailable:\s+(\d+) kB", stream.read())
    except OSError:
        found = None
    return int(found.group(1)) << 10 if found else 4 << 30

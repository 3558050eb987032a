"""Functions that end badly; test_isolation.py has them called in a process of their own."""
import ctypes
import os
import signal
import socket
import time

import numpy as np

from mesh_msgs_hdf5.isolation.wire import Wire
from mesh_msgs_hdf5.model.errors import MapFileError


def echo(path, *values, **more):
    return [path, *values, more]


def where(path):
    """Process, its parent, its session, the number of its threads."""
    return os.getpid(), os.getppid(), os.getsid(0), len(os.listdir("/proc/self/task"))


def open_files(path):
    """What the descriptors of this process lead to."""
    folder = "/proc/self/fd/"
    numbers = [int(name) for name in os.listdir(folder)]
    return [os.readlink(folder + str(n)) for n in numbers if os.path.exists(folder + str(n))]


def crash(path, how):
    """End this process in one of many ways."""
    if how == "null":
        ctypes.string_at(0)
    elif how == "abort":
        os.abort()
    elif how.isdigit():
        os._exit(int(how))
    else:
        os.kill(os.getpid(), getattr(signal, how))


def swallow(path, size):
    """Take so much memory, really."""
    return int(np.ones(size, np.uint8).sum())


def swallow_8_gib(path):
    return swallow(path, 8 << 30)


def compare(path, size):
    """Where there is memory for an array, but none for what it is compared to."""
    return bool((np.zeros(size, np.uint8) == 1).any())


def sleep(path, seconds):
    """Say who sleeps, in the file, and sleep."""
    with open(path, "w") as stream:
        stream.write(str(os.getpid()))
    time.sleep(seconds)


def sleep_long(path):
    time.sleep(60)


def abort(path):
    os.abort()


def fail(path, kind="key"):
    raise {"key": KeyError, "recursion": RecursionError, "system": SystemError}[kind]("so\nthere")


def fail_for_memory(path):
    try:
        raise MemoryError
    except MemoryError as error:
        raise MapFileError("damaged", path, "what h5py's errors become", "") from error


def answer_with(path, kind):
    """What cannot be carried, or is not what it says."""
    return {"object": object(), "big": np.zeros(1 << 25, np.uint8), "deep": _deep(500)}[kind]


def _deep(levels):
    value = []
    for _ in range(levels):
        value = [value]
    return value


def shout(path, raw):
    """Send these bytes in place of an answer."""
    connection = _connection()
    connection.sendall(raw.encode("latin-1"))
    os._exit(0)


def speak(path, reply):
    """Send this value in place of an answer."""
    Wire(_connection()).send(reply)
    os._exit(0)


def _connection():
    """This process has but one socket."""
    places = {int(name): "/proc/self/fd/" + name for name in os.listdir("/proc/self/fd")}
    open_ones = {number: place for number, place in places.items() if os.path.lexists(place)}
    (number,) = [n for n, place in open_ones.items() if os.readlink(place).startswith("socket:")]
    return socket.socket(fileno=number)

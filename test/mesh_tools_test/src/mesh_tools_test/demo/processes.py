"""Child processes of the demo: a roscore on a free port, nodes, and their orderly end."""
import os
import signal
import socket
import subprocess
import time
from contextlib import contextmanager
from pathlib import Path
from xmlrpc.client import ServerProxy

from osmesa_harness.processes import tied


class DemoError(Exception):
    """A step of the demo did not succeed; the text is one line with the way out."""


def free_port():
    """A TCP port that nobody uses at this moment."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def wait_until(condition, timeout, what, processes=()):
    """Poll the condition until it returns something true, and return that.

    :param processes: (name, process, log file) of children that must stay alive meanwhile
    :raises DemoError: after timeout [s], or when one of the processes ends
    """
    end = time.monotonic() + timeout
    while True:
        value = condition()
        if value:
            return value
        for name, process, log in processes:
            if process.poll() is not None:
                raise DemoError(f"{name} ended with code {process.returncode}; see {log}")
        if time.monotonic() > end:
            raise DemoError(f"{what} did not happen within {timeout:.0f} s")
        time.sleep(0.1)


def environment_with_home(folder, **variables):
    """The environment of a child that has this folder as its home, and of the real one only the
    caches: drivers of OpenCL and OpenGL would compile everything anew."""
    cache = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return dict(os.environ, HOME=str(folder), XDG_CACHE_HOME=cache, **variables)


@contextmanager
def process(name, command, log_folder, environment=None):
    """A command as a child, ended with SIGINT, then SIGKILL; yields (name, process, log file).

    The child also gets SIGINT when this process is killed.
    """
    log = Path(log_folder) / f"{name}.log"
    log.parent.mkdir(parents=True, exist_ok=True)
    with open(log, "wb") as stream:
        child = subprocess.Popen(
            tied(command, "INT"),
            stdin=subprocess.DEVNULL,
            stdout=stream,
            stderr=subprocess.STDOUT,
            env=environment,
            start_new_session=True,
        )
        try:
            yield name, child, log
        finally:
            end_process(child)


def end_process(child):
    """End a child and the group it leads: SIGINT, as Ctrl+C would, then SIGKILL after 30 s
    (roslaunch itself waits for its nodes, and would leave them behind if killed)."""
    for number, patience in ((signal.SIGINT, 30.0), (signal.SIGKILL, 2.0)):
        try:
            os.killpg(child.pid, number)
        except ProcessLookupError:
            pass
        try:
            child.wait(timeout=patience)
            break
        except subprocess.TimeoutExpired:
            continue
    try:  # what the leader left behind
        os.killpg(child.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass


def master_answers(uri):
    """Whether a ROS master answers at that URI."""
    try:
        return ServerProxy(uri).getPid("/mesh_tools_demo")[0] == 1
    except (OSError, ValueError):
        return False


def subscribers(uri, topic):
    """Names of the nodes that subscribe to a topic."""
    _, _, (_, subscriptions, _) = ServerProxy(uri).getSystemState("/mesh_tools_demo")
    return dict(subscriptions).get(topic, [])


@contextmanager
def roscore(log_folder, port=None):
    """A master of our own on a free port; yields its URI and sets ROS_MASTER_URI to it.

    All nodes talk over the loopback interface: a machine's own name need not resolve.
    """
    port = port or free_port()
    uri = f"http://127.0.0.1:{port}"
    names = ("ROS_MASTER_URI", "ROS_LOG_DIR", "ROS_IP", "ROS_HOSTNAME")
    before = {name: os.environ.pop(name, None) for name in names}
    os.environ["ROS_IP"] = "127.0.0.1"
    os.environ.update(ROS_MASTER_URI=uri, ROS_LOG_DIR=str(Path(log_folder).resolve() / "ros"))
    try:
        with process("roscore", ["roscore", "-p", str(port)], log_folder) as master:
            wait_until(lambda: master_answers(uri), 30, "the start of roscore", [master])
            yield uri
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value

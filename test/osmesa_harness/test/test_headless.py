"""The command `headless`: environments, exit statuses, and that nothing is left behind."""

import os
import shutil
import signal
import subprocess
import sys
from typing import Dict, List

import pytest

from osmesa_harness.back_ends import SHIM, HeadlessError, shim_folder

TEXT = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "universal_newlines": True}

ASK_MASTER = """
import os, xmlrpc.client
uri = os.environ["ROS_MASTER_URI"]
print(uri, xmlrpc.client.ServerProxy(uri).getUri("/test")[2])
"""


def start(command: List[str], environment: Dict[str, str]) -> "subprocess.Popen[str]":
    return subprocess.Popen(command, env=environment, stdin=subprocess.PIPE, **TEXT)


def output(command: List[str], environment: Dict[str, str]) -> str:
    done = subprocess.run(command, env=environment, check=True, **TEXT)
    return done.stdout.strip()


@pytest.mark.parametrize("status", [0, 1, 42])
def test_the_exit_status_is_that_of_the_program(script, environment, status):
    done = subprocess.run(script("headless", "sh", "-c", f"exit {status}"), env=environment)
    assert done.returncode == status


def test_a_program_ended_by_a_signal_counts_as_in_a_shell(script, environment):
    done = subprocess.run(script("headless", "sh", "-c", "kill -SEGV $$"), env=environment)
    assert done.returncode == 128 + signal.SIGSEGV


def test_arguments_reach_the_program_as_they_are(script, environment):
    words = ["--x", "a  b", "$HOME", "*", ""]
    printed = output(script("headless", "--", "printf", "[%s]", *words), environment)
    assert printed == "".join(f"[{word}]" for word in words)


def test_a_missing_program_is_named(script, environment):
    done = subprocess.run(script("headless", "no_such_program"), env=environment, **TEXT)
    assert done.returncode == 127
    assert done.stderr == "headless: no program no_such_program: give a path or a name on PATH\n"


@pytest.mark.parametrize("arguments", [[], ["--x"], ["--x", "--x-osmesa", "true"], ["--what"]])
def test_wrong_usage_is_told(script, environment, arguments):
    done = subprocess.run(script("headless", *arguments), env=environment, **TEXT)
    assert done.returncode == 2
    assert done.stderr.startswith("usage: headless")


def test_without_x_the_shim_is_loaded_and_no_display_known(script, environment):
    environment["DISPLAY"] = ":77"
    environment["OSMESA_GLX_DUMP"] = "/tmp/kept"
    command = "env; cat /proc/$$/maps /proc/self/maps"
    lines = output(script("headless", "sh", "-c", command), environment).splitlines()
    assert "QT_QPA_PLATFORM=offscreen" in lines
    assert "OSMESA_GLX_NO_X=1" in lines
    assert "OSMESA_GLX_DUMP=/tmp/kept" in lines
    assert not any(line.startswith("DISPLAY=") for line in lines)
    assert any(line.endswith(f"/{SHIM}") for line in lines)
    assert any("/libOSMesa.so" in line for line in lines)


def test_the_shim_is_found_in_a_folder_with_a_space(script, environment, tmp_path):
    folder = tmp_path / "a b"
    folder.mkdir()
    shutil.copy(os.path.join(shim_folder(environment), SHIM), str(folder))
    environment["LD_LIBRARY_PATH"] = f"{folder}:{environment['LD_LIBRARY_PATH']}"
    assert f"{folder}/{SHIM}" in output(script("headless", "cat", "/proc/self/maps"), environment)


NOWHERE = {"LD_LIBRARY_PATH": "/nowhere", "CMAKE_PREFIX_PATH": "/nothing"}


def test_an_installed_shim_is_left_to_the_linker(monkeypatch):
    monkeypatch.setattr("ctypes.util.find_library", {"osmesa_glx": SHIM}.get)
    assert shim_folder(NOWHERE) == ""


def test_a_missing_shim_is_told_with_the_way_out(monkeypatch):
    monkeypatch.setattr("ctypes.util.find_library", {}.get)
    with pytest.raises(HeadlessError, match="source the setup.bash"):
        shim_folder(NOWHERE)


@pytest.mark.parametrize("option, loaded", [("--x", False), ("--x-osmesa", True)])
def test_on_x_there_is_a_server_that_goes_again(
    script, environment, option, loaded, children, is_running
):
    environment["XAUTHORITY"] = "/nowhere"
    ask = "echo $DISPLAY; read go; echo $QT_QPA_PLATFORM; cat /proc/self/maps"
    run = start(script("headless", option, "sh", "-c", ask), environment)
    display = run.stdout.readline()
    processes = children(run.pid)
    lines = run.communicate("go\n")[0].splitlines()
    assert run.returncode == 0
    assert display.startswith(":")
    assert len(processes) == 2  # the server and the program
    assert not any(is_running(pid) for pid in processes)
    assert lines[0] == "xcb"
    assert any(SHIM in line for line in lines) == loaded


def test_parallel_runs_have_servers_of_their_own(script, environment):
    command = script("headless", "--x", "sh", "-c", "echo $DISPLAY; read go")
    runs = [start(command, environment) for _ in range(3)]
    displays = [run.stdout.readline() for run in runs]
    for run in runs:
        run.communicate("go\n")
    assert all(displays) and len(set(displays)) == 3
    assert [run.returncode for run in runs] == [0, 0, 0]


def test_a_private_master_answers_and_is_gone_afterwards(script, environment):
    environment["ROS_MASTER_URI"] = "http://localhost:1/"
    environment["ROS_HOSTNAME"] = "no-such-host"
    command = script("headless", "--master", sys.executable, "-c", ASK_MASTER)
    answers = [output(command, environment).split() for _ in range(2)]
    for expected, said in answers:
        assert expected == said
        assert expected.startswith("http://127.0.0.1:")
        gone = subprocess.run(
            [sys.executable, "-c", ASK_MASTER], env={**environment, "ROS_MASTER_URI": said}, **TEXT
        )
        assert "ConnectionRefusedError" in gone.stderr


def test_without_that_the_master_is_the_users(script, environment):
    environment["ROS_MASTER_URI"] = "http://somewhere:11311/"
    printed = output(script("headless", "sh", "-c", "echo $ROS_MASTER_URI"), environment)
    assert printed == "http://somewhere:11311/"


def test_a_time_limit_ends_all_that_was_started(script, environment, tmp_path, is_running):
    pids = tmp_path / "pids"
    command = f"trap '' TERM; sleep 1000 & echo $! $$ >{pids}; wait; sleep 1000"
    done = subprocess.run(
        script("headless", "--timeout", "0.5", "sh", "-c", command), env=environment, **TEXT
    )
    assert done.returncode == 124
    assert done.stderr == "headless: sh ended after 0.5 s\n"
    assert not any(is_running(int(pid)) for pid in pids.read_text().split())


def test_what_a_program_leaves_running_is_ended(script, environment, is_running):
    left = output(
        script("headless", "sh", "-c", "sleep 1000 >/dev/null 2>&1 & echo $!"), environment
    )
    assert not is_running(int(left))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_reach_the_program(script, environment, number):
    command = f"trap 'exit 7' {number.name[3:]}; echo ready; while :; do sleep 0.05; done"
    run = start(script("headless", "sh", "-c", command), environment)
    assert run.stdout.readline() == "ready\n"
    run.send_signal(number)
    run.communicate()
    assert run.returncode == 7


def test_killed_it_leaves_nothing(script, environment, wait_for, children, is_running):
    command = script("headless", "--x", "--master", "sh", "-c", "echo $DISPLAY; exec sleep 1000")
    run = start(command, environment)
    run.stdout.readline()
    processes = children(run.pid)
    run.kill()
    run.communicate()
    assert len(processes) == 2
    wait_for(lambda: not any(is_running(pid) for pid in processes))

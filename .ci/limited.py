#!/usr/bin/python3
"""Runs a command for a limited time: what still runs then is told, and ended."""
import argparse
import os
import signal
import subprocess
import sys


def descendants(pid):
    """Lines 'seconds command' of all processes below one, the oldest first."""
    columns = ["ps", "-eo", "pid=,ppid=,etimes=,args="]
    lines = subprocess.run(columns, stdout=subprocess.PIPE, universal_newlines=True).stdout
    processes = [line.split(None, 3) for line in lines.splitlines()]
    below = {str(pid)}
    found = []
    grown = True
    while grown:
        grown = False
        for process in processes:
            if process[1] in below and process[0] not in below:
                below.add(process[0])
                found.append(process)
                grown = True
    found.sort(key=lambda process: -int(process[2]))
    return ["%6s s  %s" % (process[2], process[3]) for process in found]


def end(process):
    """Asks the command to end, and what it started in its session; in the end they must."""
    for signal_number, seconds in ((signal.SIGTERM, 30), (signal.SIGKILL, None)):
        try:
            os.killpg(process.pid, signal_number)
            process.wait(seconds)
            return
        except subprocess.TimeoutExpired:
            continue
        except ProcessLookupError:
            return


def main():
    """The exit code is that of the command; 124: its time was over."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("seconds", type=float)
    parser.add_argument("command", nargs=argparse.REMAINDER)
    options = parser.parse_args()
    process = subprocess.Popen(options.command, start_new_session=True)
    try:
        return process.wait(options.seconds)
    except subprocess.TimeoutExpired:
        print("After %g s these still ran:" % options.seconds, file=sys.stderr)
        print("\n".join(descendants(process.pid)), file=sys.stderr)
        end(process)
        return 124
    except KeyboardInterrupt:
        end(process)
        return 130


if __name__ == "__main__":
    sys.exit(main())

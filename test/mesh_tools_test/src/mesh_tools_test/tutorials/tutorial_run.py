"""A tutorial done as a reader would do it, who does not know more than what the page says."""
import os
import tempfile
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path

from mesh_tools_test.demo.processes import free_port
from mesh_tools_test.tutorials.terminal import Terminal
from mesh_tools_test.tutorials.tutorial import MAIN, Tutorial, TutorialError, line_pattern

PATIENCE = 240.0  # seconds for one block; far more than it takes
_LAST_LINES = 60  # of a terminal, that are told after a failure


class _Run:
    def __init__(self, tutorial, folder, environment, stack, say):
        self._tutorial, self._folder, self._stack = tutorial, folder, stack
        self._environment, self._say = environment, say
        self._terminals = {}
        self._printed = ""
        self._do = {"run": self._run, "type": self._type, "write": self._write, "see": self._see}

    def steps(self):
        for step in self._tutorial.steps:
            begin = time.monotonic()
            self._do[step.kind](step)
            first = (step.name if step.kind == "write" else step.text.strip()).split("\n")[0]
            self._say("%6.1f s  %s %s" % (time.monotonic() - begin, step.kind, first))

    def _terminal(self, name):
        if name not in self._terminals:
            terminal = Terminal(self._folder, self._environment)
            self._stack.callback(terminal.close)
            self._terminals[name] = terminal
        return self._terminals[name]

    def _fail(self, step, reason):
        where = "%s:%d" % (self._tutorial.path.name, step.line)
        logs = [
            "--- %s terminal ---\n%s"
            % (name or "first", "\n".join(terminal.output().splitlines()[-_LAST_LINES:]))
            for name, terminal in self._terminals.items()
        ]
        raise TutorialError("%s: %s\n%s\n%s" % (where, reason, step.text, "\n".join(logs)))

    def _run(self, step):
        printed = self._terminal(MAIN).run(step.text, PATIENCE)
        if printed is None:
            self._fail(step, "a command fails, or takes more than %g s" % PATIENCE)
        self._printed = printed

    def _type(self, step):
        self._terminal(step.name).type(step.text)

    def _write(self, step):
        path = self._folder / step.name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(step.text, encoding="utf-8")

    def _see(self, step):
        for line in step.text.splitlines():
            if line.strip() and not line_pattern(line.strip()).search(self._printed):
                self._fail(step, "nothing like %r was printed, but\n%s" % (line, self._printed))


def _environment(folder):
    """That of a user who has only sourced the workspace: a home without settings, no roscore."""
    home = folder / "home"
    home.mkdir()
    cache = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    variables = dict(os.environ, HOME=str(home), XDG_CACHE_HOME=cache, PWD=str(folder))
    for name in ("ROS_NAMESPACE", "ROS_HOSTNAME", "ROS_LOG_DIR", "PYTHONUNBUFFERED"):
        variables.pop(name, None)
    variables.update(ROS_IP="127.0.0.1", ROS_MASTER_URI="http://127.0.0.1:%d" % free_port())
    return variables


@contextmanager
def _given(folder):
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        yield folder
        return
    with tempfile.TemporaryDirectory() as temporary:
        yield Path(temporary)


def run_tutorial(tutorial: Tutorial, pictures: Path, folder=None, say=lambda line: None):
    """Do what the page says, and keep the pictures that it shows.

    :param pictures: folder for them
    :param folder: where the reader works; by default one that is deleted afterwards
    :param say: gets a line for each step
    :raises TutorialError: a step fails, or a picture is not made
    """
    with _given(folder) as work, ExitStack() as stack:
        _Run(tutorial, work, _environment(work), stack, say).steps()
        pictures.mkdir(parents=True, exist_ok=True)
        for name in sorted(tutorial.pictures):
            made = work / name
            if not made.is_file():
                reason = "%s: picture %s is shown, but not made in the folder where the page works"
                raise TutorialError(reason % (tutorial.path.name, name))
            kept = pictures / (name + ".part")
            kept.write_bytes(made.read_bytes())
            kept.replace(pictures / name)

"""Verbs of mesh_tool that other packages export: found, run in a process of their own, broken."""
import json
import os
import signal
import subprocess
import textwrap
import time
from pathlib import Path

import pytest

from mesh_msgs_hdf5.commands import ELSEWHERE
from mesh_msgs_hdf5.commands.mesh_tool import main

PROGRAM = Path(__file__).resolve().parents[2] / "nodes" / "mesh_tool"
# what a verb of a stranger may do
WASH = """
import os, signal, sys, time
from mesh_msgs_hdf5.files.save import save_file
from mesh_msgs_hdf5.commands._common import add_output_options, say
from mesh_msgs_hdf5.model.errors import MapFileError

NAME, HELP, EXAMPLE = "wash", "wash meshes", "mesh_tool wash a.h5"

def add_arguments(parser):
    parser.add_argument("how")
    parser.add_argument("--degrees", type=int, default=40)
    parser.add_argument("--soap", choices=("green", "hard"))
    add_output_options(parser)

def run(arguments):
    if arguments.how == "abort":
        os.abort()
    if arguments.how == "fail":
        raise RuntimeError("no\\nwater")
    if arguments.how == "refuse":
        raise MapFileError("value", "a.h5", "it is clean", "leave it")
    if arguments.how == "code":
        return 7
    if arguments.how == "huge code":
        return 256
    if os.path.isdir(arguments.how):
        save_file(os.path.join(arguments.how, "clean"), b"x")
        print(os.getpid(), flush=True)
        time.sleep(60)
    if arguments.how == "save":
        told = []
        signal.signal(signal.SIGTERM, lambda *_: told.append(1))
        print(os.getpid(), flush=True)
        while not told:
            time.sleep(0.01)
        print("saved", flush=True)
        return 143
    if arguments.how == "wait":
        try:
            print(os.getpid(), flush=True)
            time.sleep(60)
        except KeyboardInterrupt:
            print("tidying up", flush=True)
            time.sleep(0.2)
            print("tidy", flush=True)
            raise
    say(arguments, vars(arguments)["degrees"], ["washed"])
    return 0
"""


def export(folder, package, verbs, text=None):
    """A package below a folder that exports these verbs: (name, module)."""
    place = folder / package
    place.mkdir(parents=True)
    (place / "package.xml").write_text(
        textwrap.dedent(
            """\
            <package format="2"><name>%s</name><version>1.0.0</version><description>x</description>
              <maintainer email="a@example.org">a</maintainer><license>BSD</license>
              <export><mesh_msgs_hdf5 verbs="${prefix}/verbs.xml"/></export></package>"""
            % package
        )
    )
    row = '<verb name="%s" module="%s"><description>does %s</description></verb>'
    rows = "".join(row % (name, module, name) for name, module in verbs)
    (place / "verbs.xml").write_text(text or "<verbs>%s</verbs>" % rows)
    return place


@pytest.fixture
def packages(tmp_path, monkeypatch):
    """A folder for packages; the laundry is there, and its module."""
    (tmp_path / "python" / "laundry").mkdir(parents=True)
    (tmp_path / "python" / "laundry" / "__init__.py").touch()
    (tmp_path / "python" / "laundry" / "wash.py").write_text(WASH)
    monkeypatch.syspath_prepend(str(tmp_path / "python"))
    monkeypatch.setenv("PYTHONPATH", "%s:%s" % (tmp_path / "python", os.environ["PYTHONPATH"]))
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))
    module = "laundry.wash"
    export(tmp_path / "ros", "laundry", [("wash", module), ("layers wash", module)])
    return tmp_path / "ros"


def helped(capfd, *arguments):
    with pytest.raises(SystemExit) as ended:
        main([*arguments, "--help"])
    assert ended.value.code == 0
    return capfd.readouterr()


def test_they_are_listed_and_run(packages, capfd):
    out, err = helped(capfd)
    assert "wash        does wash" in out and "layers wash" not in out and not err
    out, err = helped(capfd, "layers")
    assert "wash      does layers wash" in out and "rename" in out and not err
    assert main([]) == 2 and "does wash" in capfd.readouterr().out
    assert main(["layers", "wash", "ok"]) == 0 and capfd.readouterr().out == "washed\n"
    assert main(["wash", "ok", "--json", "--degrees", "60"]) == 0
    assert json.loads(capfd.readouterr().out) == 60
    assert main(["wash", "ok", "-q"]) == 0 and capfd.readouterr().out == ""
    assert main(["layers", "wash", "--help"]) == 0
    out = capfd.readouterr().out
    assert out.startswith("usage: mesh_tool layers wash [-h]")
    assert "example: rosrun mesh_msgs_hdf5 mesh_tool wash a.h5" in out


@pytest.mark.parametrize(
    "arguments,code,text",
    [
        (["abort"], 134, "verb wash of package laundry crashed: SIGABRT"),
        (["fail"], 1, "verb wash of package laundry failed: RuntimeError: no water"),
        (["refuse"], 1, "a.h5: it is clean (leave it)"),
        (["ok", "--degres", "3"], 2, "did you mean --degrees?"),
        ([], 2, "how"),
    ],
)
def test_what_goes_wrong_in_one_is_one_line_and_its_code(packages, capfd, arguments, code, text):
    assert main(["wash", *arguments]) == code
    out, err = capfd.readouterr()
    assert text in err and err.startswith("mesh_tool: error: ") and err.count("\n") == 1
    assert not out


def test_its_exit_code_is_kept(packages, capfd):
    assert main(["wash", "code"]) == 7
    assert main(["wash", "huge code"]) == 1  # which the system would cut to 0
    assert capfd.readouterr() == ("", "")


def started(how="wait"):
    process = subprocess.Popen(
        [PROGRAM, "wash", how], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    return process, int(process.stdout.readline())


def is_gone(pid):
    """Whether a process ends within a while (no zombie is left, either)."""
    for _ in range(500):
        if not os.path.exists("/proc/%d" % pid):
            return True
        time.sleep(0.02)
    return False


@pytest.mark.parametrize("to_both", [False, True])
def test_an_interrupt_reaches_it_once(packages, to_both):
    process, child = started()
    process.send_signal(signal.SIGINT)
    assert process.stdout.readline() == "tidying up\n"
    if to_both:  # as a terminal does
        os.kill(child, signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130 and out == "tidy\n" and is_gone(child)
    assert err == "mesh_tool: error: interrupted, nothing was saved\n"


def test_one_that_is_told_to_end_may_save_first(packages):
    process, child = started("save")
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err) == (143, "saved\n", "") and is_gone(child)


@pytest.mark.parametrize("number,code", [(signal.SIGINT, 130), (signal.SIGSEGV, 139)])
def test_what_one_saved_before_it_was_ended_is_said(packages, tmp_path, number, code):
    place = tmp_path / "basket"
    place.mkdir()
    process, child = started(str(place))
    os.kill(child, number)
    _, err = process.communicate(timeout=60)
    assert process.returncode == code and "saved already: %s/clean" % place in err, err
    assert "nothing was saved" not in err


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_it_ends_with_mesh_tool(packages, number):
    process, child = started()
    process.send_signal(number)
    process.communicate(timeout=60)
    assert process.returncode == -number and is_gone(child)


def test_broken_exports_are_named_and_the_others_go_on(packages, capfd):
    export(packages, "a_missing", []).joinpath("verbs.xml").unlink()
    export(packages, "b_text", [], "no XML")
    export(packages, "c_bomb", [], '<!DOCTYPE verbs [<!ENTITY a "b">]><verbs/>')
    verbs = [("info", "x.y"), ("layers list", "x.y"), ("info now", "x.y"), ("Bad", "x.y")]
    verbs += [("fine", "no_module"), ("iron", "no.such.module"), ("wash", "x.y")]
    export(packages, "d_many", verbs)
    export(packages, "e_no_xml", []).joinpath("package.xml").write_text("<mesh_msgs_hdf5")
    export(packages, "z_late", [("wash", "x.y")])
    out, err = helped(capfd)
    lines = err.splitlines()
    assert all(line.startswith("mesh_tool: warning: verb") for line in lines)
    for words in (
        ("a_missing", "No such file"),
        ("b_text", "is no XML"),
        ("c_bomb", "document type"),
        ("'info' of package d_many", "mesh_tool has a verb of this name"),
        ("'layers list' of package d_many", "mesh_tool has a verb of this name"),
        ("'info now' of package d_many", "no verb info with actions"),
        ("'Bad' of package d_many", "a-z"),
        ("'fine' of package d_many", "package.module"),
        ("e_no_xml",),
        ("'wash' of package laundry", "package d_many has one of this name"),
        ("'wash' of package z_late", "package d_many has one of this name"),
    ):
        found = [line for line in lines if all(word in line for word in words)]
        assert len(found) == 1, (words, lines)
    assert len(lines) == 11 and "does iron" in out
    assert main(["layers", "wash", "ok"]) == 0 and capfd.readouterr() == ("washed\n", "")
    assert main(["iron"]) == 1
    err = capfd.readouterr().err
    assert "verb iron of package d_many cannot be loaded: ModuleNotFoundError" in err
    assert "sourced" in err and err.count("\n") == 1
    with pytest.raises(SystemExit):
        main(["info", "--help"])  # of this one nothing is looked for
    assert not capfd.readouterr().err


@pytest.mark.parametrize("name", ELSEWHERE)
def test_one_whose_package_is_missing_is_named(packages, capfd, name):
    with pytest.raises(SystemExit) as ended:
        main([*name.split(), "a.h5", "b.h5"])
    err = capfd.readouterr().err
    assert ended.value.code == 1 and err.count("\n") == 1
    assert "verb %s comes with package %s, which is not built" % (name, ELSEWHERE[name]) in err


def test_a_description_may_have_any_signs(packages, capfd):
    text = "<description>50 % of %s %(prog)s</description></verb>"
    names = (
        '<verb name="spin" module="laundry.wash">',
        '<verb name="layers spin" module="laundry.wash">',
    )
    export(packages, "dryer", [], "<verbs>%s</verbs>" % "".join(name + text for name in names))
    for words in ([], ["layers"]):
        out, err = helped(capfd, *words)
        assert "50 % of %s %(prog)s" in out and not err
    module = packages.parent / "python" / "laundry" / "wash.py"
    module.write_text(WASH.replace('"wash meshes", "mesh_tool wash', '"90 % %(prog)s", "% wash'))
    assert main(["spin", "--help"]) == 0
    out = capfd.readouterr().out
    assert "90 % %(prog)s" in out and "rosrun mesh_msgs_hdf5 % wash" in out


def test_unknown_words_are_compared_with_them(packages, capfd):
    with pytest.raises(SystemExit):
        main(["wahs"])
    assert "did you mean wash?" in capfd.readouterr().err
    with pytest.raises(SystemExit):
        main(["layers", "wahs", "a", "b"])
    assert "did you mean wash?" in capfd.readouterr().err


@pytest.mark.parametrize(
    "line,words",
    [
        ("mesh_tool wa", {"wash"}),
        ("mesh_tool layers w", {"wash"}),
        ("mesh_tool wash ok --soap ", {"green", "hard"}),
        ("mesh_tool layers wash ok --soap g", {"green"}),
    ],
)
def test_bash_completes_them(packages, line, words):
    pytest.importorskip("argcomplete")
    variables = {"_ARGCOMPLETE": "1", "COMP_LINE": line, "COMP_POINT": str(len(line))}
    variables.update(_ARGCOMPLETE_IFS="\013", _ARGCOMPLETE_SUPPRESS_SPACE="1")
    script = 'exec 8>&1 9>/dev/null; exec "$@" >/dev/null 2>&1'
    result = subprocess.run(
        ["bash", "-c", script, "bash", PROGRAM],
        env=dict(os.environ, **variables),
        stdout=subprocess.PIPE,
        check=False,
        timeout=60,
    )
    assert set(result.stdout.decode().split("\013")) - {""} >= words

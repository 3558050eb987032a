"""The command mesh_tool: usage, help, output on odd terminals, signals, completion."""
import json
import os
import pty
import re
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from mesh_msgs_hdf5.commands import VERBS, command
from mesh_msgs_hdf5.commands.mesh_tool import VERSION, main, make_parser, options_of
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Label, Mesh

PACKAGE = Path(__file__).resolve().parents[2]
PROGRAM = PACKAGE / "nodes" / "mesh_tool"
TRIANGLE = Mesh(np.eye(3, dtype=np.float32), np.uint32([[0, 1, 2]]))


@pytest.fixture
def triangle(tmp_path):
    mesh = Mesh(TRIANGLE.vertices, TRIANGLE.faces, vertex_costs={"slope": np.ones(3, "f4")})
    mesh.labels = {"tree_1": Label(np.uint32([0]))}
    MapFile.write(tmp_path / "triangle.h5", mesh)
    return tmp_path / "triangle.h5"


def start(*arguments, **keywords):
    """The finished executable."""
    keywords.setdefault("stderr", subprocess.PIPE)
    keywords.setdefault("stdout", subprocess.PIPE)
    return subprocess.run([PROGRAM, *arguments], timeout=120, check=False, **keywords)


@pytest.mark.parametrize(
    "arguments,words",
    [
        (["wash"], "there are: info, validate"),
        (["inof"], "did you mean info?"),
        (["Import"], "did you mean import?"),
        (["import"], "IN, OUT.h5"),
        (["import", "a"], "OUT.h5"),
        (["import", "a", "b.h5", "--orign", "auto"], "did you mean --origin?"),
        (["import", "a", "b.h5", "--origin", "1,2"], "invalid origin (auto, or X,Y,Z) value"),
        (["import", "a", "b.h5", "--origin", "1,2,nan"], "origin"),
        (["import", "a", "b.h5", "--merge-vertices", "-1"], "tolerance"),
        (["import", "a", "b.h5", "--compression", "lzf"], "gzip"),
        (["info"], "FILE"),
        (["info", "a", "b"], "b"),
        (["info", "a", "--x"], "--x"),
        (["layers"], "FILE"),
        (["layers", "delte", "a", "b"], "did you mean delete?"),
        (["layers", "delete", "a"], "NAME"),
        (["labels", "exprot", "a", "b"], "did you mean export?"),
        (["labels", "color", "a", "red", "b"], "color"),
        (["labels", "list", "--jsno", "a"], "did you mean --json?"),
        (["convert", "a", "b", "--for", "me"], "lvr2"),
        (["parts"], "FILE"),
        (["parts", "renmae", "a", "b", "c"], "did you mean rename?"),
        (["parts", "add", "a", "b"], "IN"),
        (["parts", "list", "a", "--part", "b"], "--part"),
        (["diff", "a"], "B"),
        (["diff", "a", "b", "--tolerance", "-1"], "tolerance"),
        (["diff", "a", "b", "--ignore", "color"], "colors"),
        (["validate"], "FILE"),
        (["validate", "a", "--ignore", "everything"], "components"),
        (["render", "a", "b", "--view", "up"], "view"),
        (["render", "a", "b", "--view", "10,91"], "view"),
        (["render", "a", "b", "--size", "100x100"], "200 to 8000"),
        (["render", "a", "b", "--limits", "2,1"], "limits"),
        (["render", "a", "b", "--labels", "--colors"], "not allowed"),
        (["completion", "fish"], "bash"),
    ],
)
def test_wrong_usage_is_one_line_and_code_2(capsys, arguments, words):
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    output = capsys.readouterr()
    assert ended.value.code == 2 and output.out == "" and words in output.err, output.err
    assert output.err.startswith("mesh_tool: error: ") and output.err.count("\n") == 1
    assert "--help" in output.err


def test_help_has_an_example_for_each_verb_that_can_be_parsed(capsys):
    for arguments in (["--help"], ["-h"], *([verb, "--help"] for verb in VERBS)):
        with pytest.raises(SystemExit) as ended:
            main(arguments)
        assert ended.value.code == 0
    text = capsys.readouterr().out
    for verb in VERBS:
        module = command(verb)
        assert module.NAME == verb and verb in text and module.HELP.split()[0] in text
        example = re.sub(" *[(].*", "", module.EXAMPLE).split()
        assert example[:2] == ["mesh_tool", verb]
        parsed = make_parser([verb]).parse_args(example[1:])
        assert parsed.run is module.run
        for action in getattr(module, "ACTIONS", ()):
            with pytest.raises(SystemExit) as ended:
                main([verb, action, "--help"])
            shown = " ".join(capsys.readouterr().out.split())
            example = shown.split("example: rosrun mesh_msgs_hdf5 mesh_tool ")[1].split()
            assert make_parser([verb]).parse_args(example).action == action


def test_every_verb_has_json_and_quiet():
    for verb in set(VERBS) - {"completion"}:
        assert {"--json", "--quiet"} <= options_of(make_parser([verb]))


def test_the_version_is_that_of_the_package(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    assert ended.value.code == 0 and capsys.readouterr().out == "mesh_tool %s\n" % VERSION
    package = (PACKAGE / "package.xml").read_text(encoding="utf-8")
    assert "<version>%s</version>" % VERSION in package


def test_a_verb_loads_what_it_needs_alone():
    code = (
        "import sys; from mesh_msgs_hdf5.commands.mesh_tool import main; main(['info', 'none']);"
        "print([m for m in ('matplotlib', 'scipy', 'tqdm', 'rospy') if m in sys.modules])"
    )
    result = subprocess.run(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=True
    )
    assert result.stdout in (b"[]\n", b"['tqdm']\n")


def test_alone_it_prints_its_help(capsys):
    assert main([]) == 2  # as wrong usage ends
    out, err = capsys.readouterr()
    assert out.startswith("usage: mesh_tool") and not err
    assert all(verb in out for verb in VERBS)


def test_completion_as_other_commands_have_it(capsys):
    assert main(["completion", "bash"]) == 0
    script = capsys.readouterr().out
    with pytest.raises(SystemExit) as ended:
        main(["--completion"])
    assert ended.value.code in (0, None) and capsys.readouterr().out == script


def test_the_executable_needs_no_roscore(triangle):
    environment = dict(os.environ, ROS_MASTER_URI="http://localhost:1")
    result = start("info", triangle, env=environment)
    assert b"vertices   3" in result.stdout and result.returncode == 0
    missing = start("info", "none")
    assert missing.returncode == 1
    assert missing.stderr == b"mesh_tool: error: none: there is no such file (check the path)\n"


@pytest.mark.parametrize("verb", ["info", "validate", "layers", "labels"])
def test_a_reader_that_goes_away_is_no_crash(triangle, verb):
    read, write = os.pipe()
    os.close(read)
    result = start(verb, triangle, stdout=write)
    os.close(write)
    assert result.stderr == b"" and result.returncode == 1


def test_a_full_disk_behind_the_output_is_one_line(triangle):
    with open("/dev/full", "wb") as full:
        result = start("info", triangle, stdout=full)
    expected = b"mesh_tool: error: cannot write the output: No space left on device\n"
    assert (result.stderr, result.returncode) == (expected, 1)


@pytest.mark.parametrize(
    "locale,encoding",
    [("C", None), ("C.UTF-8", "ascii"), ("de_DE.ISO-8859-1", "latin-1"), ("nonsense", None)],
)
def test_odd_names_in_any_locale(tmp_path, locale, encoding):
    mesh = Mesh(TRIANGLE.vertices, TRIANGLE.faces, vertex_costs={"Höhe 樹": np.ones(3, "f4")})
    path = os.fsencode(tmp_path) + b"/M\xfcll \xe2\x82\xac\n.h5"
    MapFile.write(path, mesh)
    environment = dict(os.environ, LC_ALL=locale, LANG=locale)
    environment.pop("PYTHONIOENCODING", None)
    if encoding:
        environment["PYTHONIOENCODING"] = encoding
    result = start("info", path, env=environment)
    assert (result.returncode, result.stderr) == (0, b"")
    assert b"ll " in result.stdout and result.stdout.count(b"\n") == 13
    result = start("info", "--json", path, env=environment)
    assert (result.returncode, result.stderr) == (0, b"")
    found = json.loads(result.stdout.decode("ascii"))
    assert found["layers"][0]["name"] == "Höhe 樹"
    assert found["path"].endswith("M\\udcfcll €\n.h5")
    missing = start("info", path + b"x", env=environment)
    assert missing.returncode == 1 and missing.stderr.count(b"\n") == 1


def test_odd_names_of_outputs(tmp_path):
    folder = os.fsencode(tmp_path)
    MapFile.write(folder + b"/\xff.h5", TRIANGLE)
    for name in (b"\xff.png", b"\xfe\n.ply", b"\xfd.csv"):
        words = {b".png": ("render",), b".ply": ("export",), b".csv": ("labels", "export")}
        result = start(*words[name[-4:]], folder + b"/\xff.h5", folder + b"/" + name)
        assert (result.returncode, result.stderr) == (0, b"")
        assert os.path.getsize(folder + b"/" + name)


def test_without_streams_and_home(triangle, tmp_path):
    environment = dict(os.environ, HOME="/nonexistent", MPLCONFIGDIR="/nonexistent/x")
    result = start(
        "render", triangle, tmp_path / "a.png", env=environment, stdin=subprocess.DEVNULL
    )
    assert (result.returncode, result.stderr) == (0, b"")


@pytest.mark.parametrize("closed", ["<&-", ">&-", "<&- >&-", ">&- 2>&-", "<&- >&- 2>&-"])
def test_closed_streams(triangle, closed):
    command = '"$0" layers copy "$1" slope again %s' % closed
    result = subprocess.run(
        ["bash", "-c", command, str(PROGRAM), str(triangle)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        timeout=60,
        check=False,
    )
    assert (result.returncode, result.stderr) == (0, b"")
    assert "again" in MapFile(triangle).layer_names()


def new_terminal():
    """Our and its descriptor; skips where the machine gives none, as in a bare chroot."""
    try:
        return pty.openpty()
    except OSError as error:
        pytest.skip("no terminal can be made here: %s" % error)


def on_a_terminal(*arguments, seconds=60):
    """(exit code, what the terminal got on stderr) of the executable."""
    ours, theirs = new_terminal()
    process = subprocess.Popen([PROGRAM, *arguments], stdout=subprocess.DEVNULL, stderr=theirs)
    os.close(theirs)
    said = b""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if select.select([ours], [], [], 1)[0]:
            try:
                said += os.read(ours, 65536)
            except OSError:  # it has ended
                break
    os.close(ours)
    return process.wait(60), said


def test_progress_is_shown_on_a_terminal_only(tmp_path):
    pytest.importorskip("tqdm")
    code = (
        "import sys, time\n"
        "from mesh_msgs_hdf5.commands.progress import ProgressLine\n"
        "with ProgressLine('-q' in sys.argv) as progress:\n"
        "    progress.stage('reading x')\n    time.sleep(1.2)\n"
        "    progress.stage('drawing')\n    progress.part(0.4)\n    time.sleep(0.6)\n"
        "    progress.write('seen')\n"
    )
    script = tmp_path / "slow.py"
    script.write_text(code)
    shown = {}
    for option in ("-v", "-q"):
        ours, theirs = new_terminal()
        process = subprocess.Popen([sys.executable, script, option], stderr=theirs)
        os.close(theirs)
        shown[option] = b""
        while True:
            try:
                shown[option] += os.read(ours, 65536)
            except OSError:
                break
        os.close(ours)
        assert process.wait(60) == 0
    assert b"reading x" in shown["-v"] and b"drawing" in shown["-v"] and b"40%" in shown["-v"]
    assert re.search(rb"[\r\n]seen\r\n", shown["-v"])  # a line of its own
    assert shown["-q"] == b"seen\r\n"
    piped = subprocess.run([sys.executable, script, "-v"], stderr=subprocess.PIPE, check=True)
    assert piped.stderr == b"seen\n"


def test_a_quick_command_shows_no_progress(triangle):
    code, said = on_a_terminal("layers", "none.h5")
    assert code == 1 and b"\r\r" not in said and said.count(b"\n") == 1


def test_ctrl_c_is_one_line_and_leaves_nothing(tmp_path):
    slow = (
        "import sys, time, os\n"
        "import mesh_msgs_hdf5.commands.import_mesh as verb\n"
        "from mesh_msgs_hdf5.commands.mesh_tool import main\n"
        "def wait(*arguments, **keywords):\n"
        "    print('waiting', flush=True)\n    time.sleep(60)\n"
        "verb.read_map = wait\n"
        "sys.exit(main(sys.argv[1:]))\n"
    )
    (tmp_path / "a.ply").write_bytes(b"ply\n")
    process = subprocess.Popen(
        [sys.executable, "-c", slow, "import", tmp_path / "a.ply", tmp_path / "a.h5"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdout.readline() == b"waiting\n"
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert err == b"mesh_tool: error: interrupted, nothing was saved\n"
    assert os.listdir(tmp_path) == ["a.ply"]


@pytest.fixture(scope="module")
def completion_script(tmp_path_factory):
    """The path of what bash is to evaluate."""
    path = tmp_path_factory.mktemp("completion") / "mesh_tool.bash"
    path.write_bytes(start("completion", "bash").stdout)
    return str(path)


COMPLETION = """
_roscomplete_exe() { COMPREPLY=(what rosbash says); }
complete -F _roscomplete_exe rosrun
eval "$(cat "$0")"
eval "$(cat "$0")"  # twice is once
compopt() { :; }  # only while bash completes
COMP_LINE=$1 COMP_POINT=${#1} COMP_TYPE=9
read -ra COMP_WORDS <<<"$COMP_LINE"
[[ $COMP_LINE == *" " ]] && COMP_WORDS+=("")
COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
if [[ $COMP_LINE == rosrun* ]]; then _mesh_tool_rosrun; else _mesh_tool; fi
printf '%s\\n' "${COMPREPLY[@]}"
complete -p mesh_tool rosrun >&2
"""


@pytest.mark.parametrize(
    "line,expected",
    [
        ("mesh_tool l", ["labels", "layers"]),
        ("mesh_tool layers d", ["delete"]),
        ("mesh_tool import --compression ", ["gzip", "none"]),
        ("mesh_tool render triangle.h5 a.png --view ", ["front", "iso", "side", "top"]),
        ("mesh_tool render a b --lab", ["--labels"]),
        ("mesh_tool info tri", ["triangle.h5"]),
        ("mesh_tool layers delete triangle.h5 s", ["slope"]),
        ("mesh_tool layers rename triangle.h5 s", ["slope"]),
        ("mesh_tool labels delete triangle.h5 t", ["tree_1"]),
        ("mesh_tool render triangle.h5 a.png --layer ", ["slope"]),
        ("mesh_tool layers delete missing.h5 s", []),
        ("mesh_tool parts r", ["rename"]),
        ("mesh_tool parts delete triangle.h5 m", ["mesh"]),
        ("mesh_tool scans e", ["extract"]),
        ("mesh_tool info triangle.h5 --part ", ["mesh"]),
        ("mesh_tool validate triangle.h5 --part ", ["mesh"]),
        ("mesh_tool diff a.h5 triangle.h5 --other-part ", ["mesh"]),
        ("mesh_tool import a.ply triangle.h5 --to-part ", ["mesh"]),
        ("mesh_tool layers copy a.h5 slope --from triangle.h5 --from-part ", ["mesh"]),
        ("mesh_tool nonsense x", []),
        ("rosrun mesh_msgs_hdf5 mesh_tool va", ["validate"]),
        ("rosrun mesh_msgs_hdf5 mesh_tool labels color triangle.h5 none t", ["tree_1"]),
        ("rosrun mesh_msgs_hdf5 mesh_t", ["rosbash", "says", "what"]),
        ("rosrun other node x", ["rosbash", "says", "what"]),
    ],
)
def test_completion_in_bash(triangle, completion_script, line, expected):
    pytest.importorskip("argcomplete")
    result = subprocess.run(
        ["bash", "--norc", "-c", COMPLETION, completion_script, line],
        cwd=triangle.parent,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        timeout=120,
        check=True,
    )
    found = [word.strip() for word in result.stdout.decode().split("\n") if word.strip()]
    assert sorted(found) == expected, result
    assert b"-F _mesh_tool mesh_tool" in result.stderr
    assert b"-F _mesh_tool_rosrun rosrun" in result.stderr


def test_names_that_bash_would_take_for_more_are_quoted(tmp_path, completion_script):
    """Where each is completed and run, the command gets that name and no other."""
    pytest.importorskip("argcomplete")
    names = ["#tree", "~", "?", "[ab]", "*", "{a,b}", "$HOME", "a b", "it's", 'a"b', "a\\?", "a&b"]
    names += ["!x", ";id;", "a", "b"]
    mesh = Mesh(np.eye(3, dtype="f4"), np.uint32([[0, 1, 2]]))
    mesh.labels = {name: Label(np.zeros(1, np.uint32)) for name in names}
    MapFile.write(tmp_path / "names.h5", mesh)
    (tmp_path / "a").write_text("")
    (tmp_path / "b").write_text("")
    run = COMPLETION + 'eval "set -- $(printf \'%s \' "${COMPREPLY[@]}")"; printf \'%s\\0\' "$@"'
    result = subprocess.run(
        ["bash", "--norc", "-c", run, completion_script, "mesh_tool labels delete names.h5 "],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        timeout=120,
        check=True,
    )
    found = result.stdout.decode().rpartition("\n")[2].split("\0")[:-1]
    assert sorted(word for word in found if not word.startswith("--")) == sorted(names), result

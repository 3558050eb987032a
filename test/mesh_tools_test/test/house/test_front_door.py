"""The front door says what it does, and refuses what it does not know."""
import os
import re
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[4]
pytestmark = pytest.mark.skipif(
    not (ROOT / "build/devel/setup.bash").exists(), reason="built elsewhere, not by ./run build"
)


def run(*arguments, **options):
    """Run the front door; stdin closed, output captured."""
    return subprocess.run(
        [str(ROOT / "run"), *arguments],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
        timeout=120,
        **options,
    )


def commands():
    """The commands that the script dispatches on."""
    cases = re.findall(r"^  ([a-z]+)\)", (ROOT / "run").read_text(), flags=re.MULTILINE)
    assert "build" in cases and "demo" in cases
    return cases


def test_help_explains_every_command():
    text = run("help").stdout
    for command in commands():
        assert re.search(rf"^  {command}\b.{{10,}}", text, flags=re.MULTILINE), command


def test_no_command_is_a_request_for_help():
    result = run()
    assert result.returncode == 0
    assert result.stdout == run("help").stdout


def test_unknown_command_is_refused():
    result = run("dance")
    assert result.returncode == 2
    assert "dance" in result.stderr


@pytest.mark.parametrize(
    "arguments, hint",
    [
        (["nothing"], "there are: example_mesh_layer example_mesh_navigation label_manager mbf_"),
        (["--sanitize", "mesh_msgs"], "there are: mesh_map rviz_mesh_plugin "),
        (["--sanitize=thread", "Bvh.*"], "names of tests come after --"),
        (["--sanitize=memory"], "there is --sanitize"),
        (["--asan"], "there is --sanitize"),
    ],
)
def test_what_cannot_be_tested_is_refused_with_what_can_be(arguments, hint):
    result = run("test", *arguments)
    assert (result.returncode, result.stdout) == (1, "")
    assert len(result.stderr.splitlines()) == 1
    assert arguments[-1] in result.stderr and hint in result.stderr


def test_deb_refuses_what_it_does_not_know():
    result = run("deb", "--install")
    assert (result.returncode, result.stdout) == (1, "")
    assert result.stderr == "run: unknown option '--install' of deb; there is --check\n"


def test_the_demo_of_installed_packages_needs_no_build(tmp_path):
    tree, programs = tmp_path / "tree", tmp_path / "bin"
    texts = {
        "rospack": '[ "$*" = "find mesh_tools_test" ] && echo /usr/share/mesh_tools_test',
        "rosrun": 'echo "$*"',
        "dpkg-query": f"touch {tmp_path}/set_up",
        "apt-get": "exit 100",
    }
    tree.mkdir()
    programs.mkdir()
    for name, text in texts.items():
        (programs / name).write_text(f"#!/bin/sh\n{text}\n")
        (programs / name).chmod(0o755)
    shutil.copy(ROOT / "run", tree)
    environment = dict(os.environ, PATH=f"{programs}:{os.environ['PATH']}")
    command = [str(tree / "run"), "demo", "my forest.ply"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.stdout == f"mesh_tools_test demo --output {tree}/demo my forest.ply\n"
    assert "the installed packages (/usr/share/mesh_tools_test)" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert not (tmp_path / "set_up").exists()
    # what is built here comes first
    (tree / "build/devel").mkdir(parents=True)
    (tree / "build/devel/setup.bash").write_text("")
    subprocess.run(command, env=environment, capture_output=True)
    assert (tmp_path / "set_up").exists()


def test_exec_runs_in_the_workspace_and_passes_the_exit_code():
    assert run("exec", "rosmsg", "md5", "mesh_msgs/MeshGeometryStamped").stdout.strip() == (
        "2d62dc21b3d9b8f528e4ee7f76a77fb7"
    )
    assert run("exec", "bash", "-c", "exit 7").returncode == 7


def test_rviz_finds_the_plugin():
    plugins = run("exec", "rospack", "plugins", "--attrib=plugin", "rviz").stdout
    assert re.search(r"^rviz_mesh_plugin .*/plugin_description\.xml$", plugins, re.MULTILINE)


BAD_FILES = {
    "missing.ply": None,
    "empty.ply": b"",
    "pointer.ply": b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n",
    "text.ply": b"hello\n",
}


@pytest.fixture(scope="module")
def refusals(tmp_path_factory):
    """What came of a demo of each bad file, all at once, and its folder of results."""
    folder = tmp_path_factory.mktemp("bad")

    def demo(file):
        if BAD_FILES[file] is not None:
            (folder / file).write_bytes(BAD_FILES[file])
        output = folder / f"{file}.out"
        words = "exec", "rosrun", "mesh_tools_test", "demo", "--output", str(output)
        return run(*words, str(folder / file)), output

    with ThreadPoolExecutor(len(BAD_FILES)) as pool:
        return dict(zip(BAD_FILES, pool.map(demo, BAD_FILES)))


@pytest.mark.parametrize(
    "file, hint",
    [
        ("missing.ply", "no such file"),
        ("empty.ply", "empty"),
        ("pointer.ply", "lfs"),
        ("text.ply", "ply"),
    ],
)
def test_demo_refuses_bad_files_in_one_line(refusals, file, hint):
    result, output = refusals[file]
    assert result.returncode == 1
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1 and lines[0].startswith("demo: error: ")
    assert hint in lines[0].lower()
    assert not list(output.glob("*.h5"))


@pytest.mark.skipif("ID=debian" not in Path("/etc/os-release").read_text(), reason="not Debian")
@pytest.mark.parametrize("command", ["setup", "build", "deb", "demo", "test", "lint"])
def test_nothing_goes_on_after_a_failed_installation(tmp_path, command):
    programs = {
        "dpkg-query": "exit 0",  # knows no package
        "apt-get": "exit 100",
        "sudo": 'exec "$@"',
        "cmake": f"touch {tmp_path}/went_on",
    }
    for name, text in programs.items():
        (tmp_path / name).write_text(f"#!/bin/sh\n{text}\n")
        (tmp_path / name).chmod(0o755)
    environment = dict(os.environ, PATH=f"{tmp_path}:{os.environ['PATH']}")
    result = run(command, env=environment)
    assert result.returncode == 1
    assert "run: apt-get update failed" in result.stderr
    assert result.stdout == ""
    assert not (tmp_path / "went_on").exists()


def test_a_tree_configured_in_its_own_environment_is_configured_again(tmp_path):
    """By cmake itself in ./run shell: then the workspace is missing where its tests run."""
    tree, programs = tmp_path / "tree", tmp_path / "bin"
    cached = tree / "build/catkin_generated/setup_cached.sh"
    texts = {
        "dpkg-query": 'for name; do echo "installed $name"; done',
        "cmake": f"""
            echo "$1" >>{tmp_path}/calls
            if [ "$1" != --build ]; then
              mkdir -p {cached.parent}
              touch {tree}/build/build.ninja
              echo "export PYTHONPATH='{tree}/build/devel/lib/python3'" >{cached}
            fi""",
        "ninja": "",
    }
    programs.mkdir()
    for name, text in texts.items():
        (programs / name).write_text(f"#!/bin/sh\n{text}\n")
        (programs / name).chmod(0o755)
    tree.mkdir()
    shutil.copy(ROOT / "run", tree)
    environment = dict(os.environ, PATH=f"{programs}:{os.environ['PATH']}")

    def build():
        (tmp_path / "calls").write_text("")
        done = subprocess.run([tree / "run", "build"], env=environment, capture_output=True)
        assert done.returncode == 0, done.stderr
        return (tmp_path / "calls").read_text().split()

    assert build() == ["-G", "--build"]
    assert build() == ["--build"]
    cached.write_text("export PYTHONPATH='/elsewhere'\n")
    assert build() == ["-G", "--build"]
    assert build() == ["--build"]

"""What of a page is done, and that a page that does not do what it says fails."""
import os
import time

import pytest

from mesh_tools_test.tutorials.terminal import Terminal
from mesh_tools_test.tutorials.tutorial import (
    Step,
    TutorialError,
    line_pattern,
    read_tutorial,
)
from mesh_tools_test.tutorials.tutorial_run import run_tutorial

PAGE = """# A page

% a note, which is none of a reader's steps
% run: touch hidden
% type other: echo typed

```bash
echo one; echo two big words
```

```text
one
two … words
```

```{code-block} python
:caption: folder/a.py

x = 1
```

```{code-block} bash
:caption: Second terminal

sleep 1000
```

```python
print("hello")
```

* in a list

  ```bash
  ls folder
  ```

```console
$ this is only shown
```

```yaml
so: is this
```

```{code-block} yaml
and: this
```

![a picture](pictures/a.png) and ![none of ours](other/b.png)

```{figure} pictures/c.png
:alt: a figure
```
"""


def written(folder, text):
    path = folder / "page.md"
    path.write_text(text, encoding="utf-8")
    return read_tutorial(path)


def run(place, text, **more):
    run_tutorial(written(place, text), place / "pictures", **more)


def test_the_steps_of_a_page(tmp_path):
    page = written(tmp_path, PAGE)
    assert page.steps == [
        Step(4, "run", "touch hidden\n"),
        Step(5, "type", "echo typed\n", "other"),
        Step(7, "run", "echo one; echo two big words\n"),
        Step(11, "see", "one\ntwo … words\n"),
        Step(16, "write", "x = 1\n", "folder/a.py"),
        Step(22, "type", "sleep 1000\n", "Second"),
        Step(
            28,
            "run",
            "/usr/bin/python3 - <<'END_OF_PYTHON'\nprint(\"hello\")\nEND_OF_PYTHON\n",
        ),
        Step(34, "run", "ls folder\n"),
    ]
    assert page.pictures == {"a.png", "c.png"}


@pytest.mark.parametrize(
    "line, printed, fits",
    [
        ("one", "this one here", True),
        ("one", "two", False),
        ("a … c", "a b c", True),
        ("a … c", "c b a", False),
        ("a  b", "a     b", True),
        ("(0): path of 42…", "SUCCESS (0): path of 42.3 m", True),
        ("(0): path of 42…", "SUCCESS (0): path of 41.3 m", False),
        ("x … .. … m", "x          -19.6885 .. 19.6885 m", True),
        ("a.c", "abc", False),
    ],
)
def test_lines_of_output(line, printed, fits):
    assert bool(line_pattern(line).search(printed)) == fits


def test_a_page_is_done(tmp_path):
    work = tmp_path / "work"
    text = PAGE.replace(
        "print(", "open('a.png', 'w').write('A'); open('c.png', 'w').write('C'); print("
    )
    said = []
    begin = time.monotonic()
    run(tmp_path, text, folder=work, say=said.append)
    assert time.monotonic() - begin < 200  # what stays in another terminal has ended
    assert (work / "hidden").exists()
    assert (work / "folder" / "a.py").read_text() == "x = 1\n"
    assert [(tmp_path / "pictures" / name).read_text() for name in ("a.png", "c.png")] == ["A", "C"]
    assert len(said) == 8


@pytest.mark.parametrize(
    "text, reason",
    [
        ("```bash\nfalse\n```\n", r"page\.md:1: a command fails"),
        ("```bash\nfalse | cat\n```\n", r"page\.md:1: a command fails"),
        ("```bash\nfalse\ntrue\n```\n", r"page\.md:1: a command fails"),
        ("```bash\nexit 0\n```\n", r"page\.md:1: a command fails"),
        ("text\n\n```python\n1/0\n```\n", r"page\.md:3: a command fails[\s\S]*ZeroDivisionError"),
        ("```bash\necho a\n```\n\n```text\nb\n```\n", r"page\.md:5: nothing like 'b' was printed"),
        ("```bash\necho b\necho a\n```\n\n```bash\ntrue\n```\n\n```text\nb\n```\n", "nothing like"),
        ("![x](pictures/x.png)\n", r"page\.md: picture x\.png is shown, but not made"),
    ],
)
def test_a_page_that_does_not_do_what_it_says(tmp_path, text, reason):
    with pytest.raises(TutorialError, match=reason):
        run(tmp_path, text)


def test_a_command_that_reads_its_input_does_not_eat_the_next_one(tmp_path):
    run(tmp_path, "```bash\ncat\nread x || echo nothing\n```\n\n```text\nnothing\n```\n")


def test_a_reader_has_a_home_and_a_roscore_of_his_own(tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_NAMESPACE", "elsewhere")
    text = """```bash
echo "home $HOME"
echo "master $ROS_MASTER_URI namespace ${ROS_NAMESPACE:-none}"
```

```text
home %s/work/home
master http://127.0.0.1:… namespace none
```
"""
    run(tmp_path, text % tmp_path, folder=tmp_path / "work")


def test_what_runs_in_a_terminal_ends_with_it(tmp_path):
    terminal = Terminal(tmp_path, os.environ)
    terminal.type("bash -c 'echo $$ > pid; sleep 1000'; echo interrupted > after")
    end = time.monotonic() + 60
    while not (tmp_path / "pid").exists() or not (tmp_path / "pid").read_text():
        assert time.monotonic() < end
        time.sleep(0.01)
    terminal.close()
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)

"""What the gatherer finds in small sources of Python."""

import textwrap

import pytest

from mesh_tools_test.troubleshooting.python_messages import python_messages


def texts(source):
    return [message.text for message in python_messages({"a.py": textwrap.dedent(source)})]


@pytest.mark.parametrize(
    "source",
    [
        'raise ValueError("it is wrong")',
        'raise MeshMapError("it is wrong", "the way out")\nclass MeshMapError(Exception): pass',
        'raise OSError(1, "it is wrong")',
        'parser.error("it is wrong")',
        'rospy.logwarn("it is wrong")',
        'rospy.logerr_throttle(5, "it is wrong")',
        'rospy.logfatal("it is wrong")',
        '_LOG.warning("it is wrong")',
        'logging.getLogger("a").error("it is wrong")',
        'warnings.warn("it is wrong")',
        'print("it is wrong", file=sys.stderr)',
        'self.notes.append("it is wrong")',
        'self._log(f"it is wrong")',
        'Status(ERROR, "it is wrong")',
        'result = WARN, "it is wrong"',
        'answer(success=False, message="it is wrong")',
        'result.message = "it is wrong"',
        'def why_not():\n    return "it is wrong"',
    ],
)
def test_each_kind_of_call_is_found(source):
    assert texts(source) == ["it is wrong"]


@pytest.mark.parametrize(
    "source",
    [
        'assert x, "it is wrong"',
        'raise AssertionError("it is wrong")',
        'raise NotImplementedError("it is wrong")',
        'raise TypeError("it is wrong")',
        'rospy.loginfo("all is well")',
        'print("all is well")',
        'Result(SUCCESS, "all is well")\nclass Result:\n    outcome: int\n    message: str',
        'answer(success=True, message="all is well")',
        '# raise ValueError("it is wrong")',
        '"""raise ValueError("it is wrong")"""',
        'parser.error("usage: mesh_tool VERB")',
        'parser.error("example: mesh_tool info garden.h5")',
        'raise ValueError("word")',
        "raise ValueError(text)",
    ],
)
def test_contracts_success_and_comments_are_left_out(source):
    assert texts(source) == []


@pytest.mark.parametrize(
    "expression, text",
    [
        ('"%d of %s are wrong (%.3g %%)" % (a, b, c)', "… of … are wrong (… %)"),
        ('f"{a:.2f} of {b!r} are wrong"', "… of … are wrong"),
        ('"{} of {name:>8} are {{wrong}}".format(a, name=b)', "… of … are {wrong}"),
        ('"it is " + word + " and wrong"', "it is … and wrong"),
        ('"it is "\n    "wrong\\n\\there"', "it is wrong here"),
        ('one_line("it is %r" % a + "; wrong")', "it is …; wrong"),
        ('"%s%s are wrong"', "… are wrong"),
    ],
)
def test_what_varies_becomes_a_sign(expression, text):
    assert texts("raise ValueError(%s)" % expression) == [text]


def test_alternatives_are_told_each():
    found = texts('raise ValueError("it is too small" if a else "it is too large")')
    assert sorted(found) == ["it is too large", "it is too small"]


def test_a_text_is_followed_through_variables_tables_and_constants():
    source = """
        WHY = "the constant is wrong"
        TABLE = {1: ("code", "the table is wrong"), 2: ("code", "the table is odd")}

        def check(a):
            text = "the variable of %s is wrong" % a
            code, message = TABLE.get(a, ("code", "the default is wrong"))
            raise ValueError(text if a else WHY) from OSError(1, message)
    """
    assert sorted(texts(source)) == [
        "the constant is wrong",
        "the default is wrong",
        "the table is odd",
        "the table is wrong",
        "the variable of … is wrong",
    ]


def test_a_helper_is_followed_to_its_callers_and_to_what_it_returns():
    source = """
        def _wrong(path, message):
            return ValueError("%s: %s" % (path, message))

        def fault(a):
            yield "the width %d is wrong" % a

        def check(a):
            for finding in fault(a):
                raise RuntimeError(finding)
            raise _wrong(a, message="the height is wrong")
    """
    assert texts(source) == ["the width … is wrong", "the height is wrong"]


def test_rows_of_a_loop_and_parameters_that_change_are_followed():
    source = """
        def check(a, reason):
            for text, values in (("the width is wrong", a), ("the height is wrong", a)):
                raise ValueError(text)
            reason = reason % a if "%" in reason else reason
            raise ValueError(reason)

        check(1, "the depth of %s is wrong")
    """
    assert sorted(texts(source)) == [
        "the depth of … is wrong",
        "the height is wrong",
        "the width is wrong",
    ]


def test_a_reason_inside_a_message_is_told_apart():
    source = """
        def reason(a):
            return "since all of it has gone" if a else "now"

        raise ValueError("nothing can be shown here, %s" % reason(1))
    """
    assert sorted(texts(source)) == ["nothing can be shown here, …", "since all of it has gone"]


def test_messages_know_their_place():
    source = 'def f():\n    raise ValueError(\n        "it is "\n        "wrong"\n    )\n'
    (message,) = python_messages({"folder/a.py": source})
    assert message[:2] == ("folder/a.py", 3)

"""What the gatherer finds in small sources of C++, and its tokens."""

import pytest

from mesh_tools_test.troubleshooting.cpp_messages import cpp_messages
from mesh_tools_test.troubleshooting.cpp_tokens import functions_of, partners, tokens_of


def texts(*lines):
    return [message.text for message in cpp_messages({"src/a.cpp": "\n".join(lines)})]


@pytest.mark.parametrize(
    "statement",
    [
        'ROS_WARN("it is wrong");',
        'ROS_ERROR_STREAM("it is " << "wrong");',
        'ROS_ERROR_THROTTLE(10, "it is wrong");',
        'throw std::runtime_error("it is wrong");',
        'throw LabelFileError(std::string("it is wrong"));',
        'lines.report("Name", StatusLine::warn("it is wrong"));',
        'return StatusLine::error("it is ", "wrong");',
        'say("it is wrong");',
        'report_->setText("it is wrong");',
        'require(x > 0, "it is wrong");',
        'PyErr_SetString(type, "it is wrong");',
        'log(LogLevel::WARNING, "it is wrong");',
        'findings.push_back(Finding{"rule", "it is wrong", "the way out"});',
        'state.failure = "it is wrong";',
    ],
)
def test_each_kind_of_call_is_found(statement):
    assert texts("void f() {", statement, "}") == ["it is wrong"]


def test_a_sentence_that_a_function_returns_is_a_reason():
    assert texts("std::string f() {", 'return "there is no mesh here";', "}") == [
        "there is no mesh here"
    ]
    assert texts("std::string f() {", 'return "three short words";', "}") == []


@pytest.mark.parametrize(
    "statement",
    [
        'ROS_INFO("all is well here");',
        'return StatusLine::ok("all is well here");',
        'throw std::logic_error("it is wrong");',
        "throw Canceled();",
        "throw std::bad_alloc();",
        '// throw std::runtime_error("it is wrong");',
        '/* ROS_ERROR("it is wrong"); */',
        '#define X throw std::runtime_error("it is wrong")',
        'label->setToolTip("all is well here");',
        'say("Click at the first point");',
        'say("word");',
    ],
)
def test_what_is_no_error_is_left_out(statement):
    assert texts("void f() {", statement, "}") == []


@pytest.mark.parametrize(
    "expression, text",
    [
        ('"it is " + std::to_string(a) + " and wrong"', "it is … and wrong"),
        ('"it is "\n  "wrong"', "it is wrong"),
        ('QString("it is %1 and %2").arg(a).arg(b)', "it is … and …"),
        ('joined("it is ", a, " m, more than ", b)', "it is … m, more than …"),
        ('"it is \\"wrong\\"\\tand \\\\ so"', 'it is "wrong" and \\ so'),
        ('R"(it is "wrong")"', 'it is "wrong"'),
        ('"it is " + (n == 1 ? "one" : "many") + " and wrong"', "it is … and wrong"),
        ('"it is // no comment"', "it is // no comment"),
    ],
)
def test_what_varies_becomes_a_sign(expression, text):
    assert texts("void f() {", "throw std::runtime_error(%s);" % expression, "}") == [text]


def test_a_format_of_the_log_is_read():
    statement = 'ROS_WARN("the %s of %.3f m (%zu %%) is wrong", a, b, c);'
    assert texts("void f() {", statement, "}") == ["the … of … m (… %) is wrong"]


def test_alternatives_are_told_each():
    statement = 'throw std::runtime_error(a ? "it is too small" : "it is too large");'
    assert sorted(texts("void f() {", statement, "}")) == ["it is too large", "it is too small"]


def test_what_is_said_now_and_then_varies_and_is_told_apart():
    statement = 'return StatusLine::warn("it is wrong", a ? "; wait for a moment" : "");'
    assert sorted(texts("void f() {", statement, "}")) == ["it is wrong…", "wait for a moment"]


def test_a_text_is_followed_through_variables_helpers_and_returns():
    found = texts(
        "namespace {",
        'const char* const WHY = "the constant is wrong";',
        'std::string reason() { return a ? "the width is wrong" : WHY; }',
        "[[noreturn]] void refuse(const std::string& path, const std::string& text)",
        '{ throw std::runtime_error(path + ": " + text); }',
        "}",
        "void f() {",
        '  std::string text = "the variable is wrong";',
        "  if (a) { throw std::runtime_error(text); }",
        "  if (b) { throw std::runtime_error(reason()); }",
        '  refuse(path, "the height is wrong");',
        "}",
    )
    assert sorted(found) == [
        "the constant is wrong",
        "the height is wrong",
        "the variable is wrong",
        "the width is wrong",
    ]


def test_what_is_added_to_a_text_is_told_apart():
    found = texts(
        "void f() {",
        '  std::string line = "all of it is wrong";',
        '  if (a) { line += "; wait for a moment"; }',
        '  line += " or for two";',
        "  return StatusLine::error(line);",
        "}",
    )
    assert sorted(found) == ["all of it is wrong…", "or for two", "wait for a moment"]


def test_reasons_in_a_table_are_found():
    found = texts(
        "std::string whyNot(int a) {",
        '  const Row rows[] = {{1, a > 0, "choose one label in the list"},',
        '                      {2, has_mesh, "there is no mesh"}};',
        "  return rows[a].reason;",
        "}",
    )
    assert sorted(found) == ["choose one label in the list", "there is no mesh"]


def test_messages_know_their_place():
    (message,) = cpp_messages(
        {"src/a.cpp": '/* one\n two */ void f() {\n throw Error("it is\\n wrong");}'}
    )
    assert tuple(message) == ("src/a.cpp", 3, "it is wrong")


def test_tokens_know_literals_numbers_and_lines():
    tokens = tokens_of('int a = 1\'000;  // "no"\nchar c = \'"\'; f(u8"x" "y", 1.5e-3f);')
    assert [t.value for t in tokens if t.kind == "text"] == ["xy"]
    assert [t.value for t in tokens if t.kind == "number"] == ["1'000", "1.5e-3f"]
    assert [t.line for t in tokens if t.kind == "char"] == [2]


def test_functions_are_found_with_their_parameters():
    tokens = tokens_of(
        "A::A(int one) : a_(one), b_{one} {}"
        'int f(const std::string& text = "") const noexcept { return 1; }'
        "int g(int); if (x) { }"
    )
    found = functions_of(tokens, partners(tokens))
    assert [(f.name, f.parameters) for f in found] == [("A", ["one"]), ("f", ["text"])]

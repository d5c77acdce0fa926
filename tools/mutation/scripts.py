"""Mutants of the readers, which the conformance kit tests. In Python and JavaScript each is a copy of the reader with
one change, tested for JavaScript also by the reader's own tests; the reader in Python is called within one process
(kit.py), but for the functions that talk to the kit. Those in C++ are compiled at once (served.py)."""

import ast
import json
import os
import re
import shutil
import subprocess
from dataclasses import dataclass

from . import served
from .kit import Worker
from .mutant import Mutant
from .operators import ARITHMETIC, ASSIGNMENTS, LOGIC, RELATIONS
from .rooms import ROOT
from .runs import Test, run
from .tree import FOLDER

PROGRAM = ROOT / "build/release/t4d"
CORPUS = FOLDER / "corpus"
WORKER = Worker()
SERVED = []  # the kit of the reader in C++
SECONDS = 300


@dataclass(frozen=True)
class Reader:
    files: str   # a pattern
    folder: str  # is copied
    command: str
    # Functions that only a process of its own shows, as it does what is in none; None where that is so of all.
    talking: tuple | None = None


CPP = "C++ reader"
READERS = {
    "python reader": Reader("conformance/readers/python/*.py", "conformance/readers/python",
                            "/usr/bin/python3 -IS conformance/readers/python/t4d_reader.py",
                            ("request_of", "serve", "main")),
    "web reader": Reader("web/reader/src/*.js", "web", "node web/reader/conform.mjs"),
    CPP: Reader("formats/t4d/*.cpp", "formats/t4d", str(served.PROGRAM)),
}


class Changes:
    """Collects the mutants of a file: bytes that take the place of others."""

    def __init__(self, file, source):
        self.file, self.source, self.found = file, source, []

    def text(self, begin, end):
        return self.source[begin:end].decode()

    def add(self, operator, begin, end, new):
        line = self.source.count(b"\n", 0, begin) + 1
        first = self.source.rfind(b"\n", 0, begin) + 1
        last = self.source.find(b"\n", end)
        change = " ".join(f"{self.text(first, begin)}{{{self.text(begin, end)} -> {new}}}"
                          f"{self.text(end, last)}".split())
        own = self.source.split(b"\n")[line - 1].decode().strip()
        self.found.append(Mutant(self.file, line, operator, change, own, ((begin, end, new),)))

    def operator(self, begin, end, tables):
        """Replaces the operator that stands between two operands."""
        text = self.text(begin, end)
        match = re.search(r"[^\s()]+(\s+[a-z]+)?", text)
        for name, table in tables.items():
            for new in table.get(match.group(), ()) if match else ():
                self.add(name, begin + match.start(), begin + match.end(), new)

    def constant(self, begin, end):
        text = self.text(begin, end)
        if re.fullmatch(r"\d+|0x[\dA-Fa-f]+", text):
            self.add("constant", begin, end, f"({text} + 1)")
            if int(text, 0) > 0:
                self.add("constant", begin, end, f"({text} - 1)")


# Python -----------------------------------------------------------------------------------------

class PythonChanges(ast.NodeVisitor, Changes):
    TABLES = {"relation": {**RELATIONS, "in": ("not in",), "not in": ("in",)},
              "arithmetic": {**ARITHMETIC, "//": ("*",)}, "assignment": ASSIGNMENTS}

    def __init__(self, file, source):
        Changes.__init__(self, file, source)
        self.starts = [0]
        for line in source.split(b"\n"):
            self.starts.append(self.starts[-1] + len(line) + 1)
        self.visit(ast.parse(source))

    def span(self, node):
        return (self.starts[node.lineno - 1] + node.col_offset,
                self.starts[node.end_lineno - 1] + node.end_col_offset)

    def between(self, left, right):
        self.operator(self.span(left)[1], self.span(right)[0], self.TABLES)

    def visit_JoinedStr(self, node):
        pass

    def visit_Raise(self, node):
        pass

    def visit_Compare(self, node):
        for left, right in zip([node.left, *node.comparators], node.comparators):
            self.between(left, right)
        self.generic_visit(node)

    def visit_BinOp(self, node):
        texts = (ast.Constant, ast.JoinedStr)
        if not (isinstance(node.left, texts) and not isinstance(getattr(node.left, "value", 0), int)):
            self.between(node.left, node.right)
        self.generic_visit(node)

    def visit_BoolOp(self, node):
        begin, end = self.span(node)
        word = "or" if isinstance(node.op, ast.And) else "and"
        values = [f"({self.text(*self.span(value))})" for value in node.values]
        self.add("logic", begin, end, f" {word} ".join(values))
        for i in range(len(values)):
            others = [value for k, value in enumerate(values) if k != i]
            self.add("dropped operand", begin, end,
                     f" {'and' if isinstance(node.op, ast.And) else 'or'} ".join(others))
        self.generic_visit(node)

    def visit_UnaryOp(self, node):
        if isinstance(node.op, (ast.USub, ast.Not)):
            self.add("negation", *self.span(node), f"({self.text(*self.span(node.operand))})")
        self.generic_visit(node)

    def visit_AugAssign(self, node):
        self.between(node.target, node.value)
        self.generic_visit(node)

    def visit_Constant(self, node):
        if isinstance(node.value, bool):
            self.add("constant", *self.span(node), str(not node.value))
        elif isinstance(node.value, int):
            self.constant(*self.span(node))

    def visit_If(self, node):
        if not isinstance(node.test, ast.Compare):
            self.add("negation", *self.span(node.test), f"not ({self.text(*self.span(node.test))})")
        self.generic_visit(node)

    def visit_Return(self, node):
        if node.value is not None and getattr(node.value, "value", 0) is not None:
            self.add("return", *self.span(node.value), "None")
        self.generic_visit(node)

    def visit_Expr(self, node):
        if isinstance(node.value, ast.Constant):  # a comment
            return
        self.add("dropped statement", *self.span(node), "pass")
        self.generic_visit(node)

    def visit_Call(self, node):
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        for one, two in (("min", "max"), ("any", "all")):
            if name in (one, two):
                self.add(f"{one} and {two}", *self.span(node.func), two if name == one else one)
        # What follows the condition of a check are place and text of the message.
        arguments = node.args[:1] if name == "check" else node.args
        for one, two in zip(arguments, arguments[1:]):
            if isinstance(one, ast.Name) and isinstance(two, ast.Name) and one.id != two.id:
                self.add("swap", self.span(one)[0], self.span(two)[1], f"{two.id}, {one.id}")
        for argument in arguments:
            self.visit(argument)
        self.visit(node.func)


# JavaScript -------------------------------------------------------------------------------------

class JavaScriptChanges(Changes):
    TABLES = {"relation": {**RELATIONS, "===": ("!==",), "!==": ("===",)},
              "arithmetic": {**ARITHMETIC, ">>>": ("<<",)}, "assignment": ASSIGNMENTS,
              "logic": {**LOGIC, "??": ("&&",)}}

    def __init__(self, file, source):
        super().__init__(file, source)
        # acorn counts UTF-16 units.
        self.string = source.decode()
        if not self.string.isascii():
            units = [len(c.encode()) for c in self.string]
            self.offsets = [0]
            for size in units:
                self.offsets.append(self.offsets[-1] + size)
        else:
            self.offsets = None
        parsed = subprocess.run(
            ["node", "-e", "process.stdout.write(JSON.stringify(require('acorn').parse("
             "require('fs').readFileSync(0, 'utf8'), {ecmaVersion: 2022, sourceType: 'module'}), "
             "(_, value) => typeof value === 'bigint' ? null : value))"],
            cwd=ROOT / "tools/web", input=source, check=True, capture_output=True).stdout
        self.visit(json.loads(parsed))

    def span(self, node):
        begin, end = node["start"], node["end"]
        return (begin, end) if self.offsets is None else (self.offsets[begin], self.offsets[end])

    def visit(self, node):
        if isinstance(node, list):
            for child in node:
                self.visit(child)
        if not isinstance(node, dict):
            return
        kind = node.get("type")
        if kind in ("TemplateLiteral", "ThrowStatement", "ImportDeclaration"):
            return
        if kind in ("BinaryExpression", "LogicalExpression", "AssignmentExpression"):
            self.operator(self.span(node["left"])[1], self.span(node["right"])[0], self.TABLES)
        elif kind == "Literal" and isinstance(node["value"], bool):
            self.add("constant", *self.span(node), "false" if node["value"] else "true")
        elif kind == "Literal" and isinstance(node["value"], (int, float)):
            self.constant(*self.span(node))
        elif kind == "IfStatement" and node["test"]["type"] != "BinaryExpression":
            begin, end = self.span(node["test"])
            self.add("negation", begin, end, f"!({self.text(begin, end)})")
        elif kind == "ReturnStatement" and node["argument"]:
            self.add("return", *self.span(node["argument"]), "undefined")
        elif kind == "ExpressionStatement" and "directive" not in node:
            self.add("dropped statement", *self.span(node), ";")
        elif kind == "CallExpression":
            self.call(node)
            if node["callee"].get("name") == "check":
                self.visit(node["arguments"][:1])
                return
        for value in node.values():
            self.visit(value)

    def call(self, node):
        begin, end = self.span(node["callee"])
        others = {"Math.min": "Math.max", "Math.max": "Math.min"}
        if self.text(begin, end) in others:
            self.add("min and max", begin, end, others[self.text(begin, end)])
        arguments = node["arguments"]
        for one, two in zip(arguments, arguments[1:]):
            if one["type"] == two["type"] == "Identifier" and one["name"] != two["name"]:
                self.add("swap", self.span(one)[0], self.span(two)[1],
                         f"{two['name']}, {one['name']}")


# Running ----------------------------------------------------------------------------------------

# A reader may skip pages, so no case breaks their rules.
NOT_READ = ("_test.cpp", "pages.cpp")


def files_of(room):
    return sorted(str(path.relative_to(ROOT)) for path in ROOT.glob(READERS[room].files)
                  if not path.name.endswith(NOT_READ))


def find(room, files):
    if room == CPP:
        return served.find(files)
    found = []
    for file in files:
        changes = PythonChanges if file.endswith(".py") else JavaScriptChanges
        found += changes(file, (ROOT / file).read_bytes()).found
    return found


def of_reader(room, mutants):
    """Those of the mutants that are in the reader: of C++, which has one library for readers and writers, the checks in
    functions that it calls."""
    if room != CPP:
        return mutants
    copy_corpus()
    SERVED.append(served.Kit([mutant for mutant in mutants if mutant.check], CORPUS))
    return SERVED[0].of_reader()


def judge(mutant):
    """Runs the tests of a reader with a mutant; the outcome as runs.judge says it."""
    if mutant.room == CPP:
        return SERVED[0].judge(mutant)
    reader = READERS[mutant.room]
    right = (ROOT / mutant.file).read_bytes()
    (begin, end, new), = mutant.edits
    source = right[:begin] + new.encode() + right[end:]
    if reader.talking is not None:
        found = WORKER.judge(CORPUS, right, source)
        if found:
            return {"outcome": "killed", **found, "reached by": 1}
        if function_of(right, mutant.line) not in (None, *reader.talking):
            return {"outcome": "survived", "reached by": 1, "tests run": 1, "tests": ["kit.py"]}
    place = FOLDER / "readers" / str(mutant.number)
    copy(reader, place)
    (place / mutant.file).write_bytes(source)
    tests = tests_of(reader, place)
    killed = failing(tests)
    shutil.rmtree(place, ignore_errors=True)
    if killed:
        return {"outcome": "killed", **killed, "reached by": len(tests)}
    return {"outcome": "survived", "reached by": len(tests), "tests run": len(tests),
            "tests": [test.name for test in tests]}


def function_of(source, line):
    """The name of the function at the top of a module that has the line, or None."""
    for node in ast.parse(source).body:
        if isinstance(node, ast.FunctionDef) and node.lineno <= line <= node.end_lineno:
            return node.name
    return None


def copy_corpus():
    if not PROGRAM.exists():
        raise SystemExit(f"{PROGRAM} is missing, whose conformance kit tests the readers: build it")
    subprocess.run([PROGRAM, "conform", "copy", CORPUS, "--force"], check=True, stdout=subprocess.DEVNULL)


def check(room):
    """A reader must pass its tests as it is."""
    if READERS[room].talking is not None:
        copy_corpus()
    if room == CPP or READERS[room].talking is not None:  # It is checked where it is served.
        return
    place = FOLDER / "readers/unchanged"
    copy(READERS[room], place)
    killed = failing(tests_of(READERS[room], place))
    if killed:
        raise SystemExit(f"{room}: without a mutant {killed['by']} {killed['how']}")


def copy(reader, place):
    shutil.rmtree(place, ignore_errors=True)
    ignored = shutil.ignore_patterns("__pycache__", "node_modules", "viewer")
    shutil.copytree(ROOT / reader.folder, place / reader.folder, ignore=ignored)
    if reader.folder == "web":
        (place / "web/node_modules").symlink_to(ROOT / "web/node_modules")
        for needed in ("conformance", "formats"):  # the adapter to the kit, the corpus, the specification
            (place / needed).symlink_to(ROOT / needed)


def tests_of(reader, place):
    def kit(*options):
        return Test("t4d conform reader " + " ".join(options), [
            str(PROGRAM), "conform", "reader", "--reader", reader.command, "--first", *options], str(place), {})

    if reader.talking is not None:  # kit.py has judged its answers.
        return [Test("calls", [str(ROOT / "conformance/readers/calls"), reader.command], str(place), {}),
                *(kit(*way, "--only", "cross-polytope", "invalid/H*") for way in (("--serve",), ()))]
    return [Test("web/reader/test", ["node", "--test", "web/reader/test"], str(place), {}), kit("--serve")]


def failing(tests):
    """The first of the tests that fails, and how; or nothing."""
    for test in tests:
        outcome, _ = run(test, SECONDS)
        if outcome != "passed":
            return {"by": test.name, "how": outcome}
    return None

"""Finds the mutants of C++ sources in clang's syntax trees.

Left out: what the compiler evaluates, since a mutant is chosen at run time; messages of errors and
what becomes part of them; calls that change only speed and memory; `return call.error()`, which
hands on the error of a call, and the conditions of these.
"""

import hashlib
import json
import pickle
import re
import shlex
from dataclasses import dataclass, replace
from pathlib import Path

from clang import cindex
from clang.cindex import CursorKind as K
from clang.cindex import TypeKind as T

from .mutant import ACTIVE, ORIGINAL, Edit, Mutant
from .operators import ARITHMETIC, ASSIGNMENTS, LOGIC, RELATIONS
from .rooms import ROOT

# The library is that of the version whose bindings tools/setup installs.
cindex.Config.set_library_file(
    next(str(library) for version in (16, 19, 18, 17)
         if (library := Path(f"/usr/lib/llvm-{version}/lib/libclang.so.1")).exists()))

NOT_WALKED = {K.STATIC_ASSERT, K.ENUM_DECL, K.TYPE_ALIAS_DECL, K.TYPEDEF_DECL, K.PARM_DECL,
              K.TEMPLATE_TYPE_PARAMETER, K.TEMPLATE_NON_TYPE_PARAMETER, K.TYPE_REF, K.TEMPLATE_REF,
              K.TYPE_ALIAS_TEMPLATE_DECL}
FUNCTIONS = {K.FUNCTION_DECL, K.CXX_METHOD, K.FUNCTION_TEMPLATE, K.CONSTRUCTOR, K.DESTRUCTOR,
             K.CONVERSION_FUNCTION}
# Their literal children are arguments of templates or bounds of arrays.
NAMES = {K.DECL_REF_EXPR, K.MEMBER_REF_EXPR, K.OVERLOADED_DECL_REF, K.FIELD_DECL, *FUNCTIONS}
STATEMENTS = {K.CALL_EXPR, K.BINARY_OPERATOR, K.COMPOUND_ASSIGNMENT_OPERATOR, K.UNARY_OPERATOR}
LITERALS = {K.INTEGER_LITERAL, K.FLOATING_LITERAL}

TEXT_TYPE = re.compile(r"^(const )?(t4d::Error\b|std::(__cxx11::)?basic_string<)")
SPEED_OR_PROGRESS = re.compile(
    r"reserve|shrink_to_fit|giveBackFreedMemory|madvise|prefetch|[pP]rogress|assert")
SYMMETRIC = re.compile(r"operator|min|max|minmax|hypot|swap|midpoint|gcd|lcm|dot")
MESSAGE = re.compile(rb"return\s+(\w+(\.|->|::))*(invalid|damaged\w*|fail\w*|unsupported)\(")
REFUSAL = re.compile(rb"return\s+(\w+(\.|->|::))*(invalid|damaged\w*|fail\w*|unsupported|wrong\w*)\(")
PASSED = re.compile(rb"return\s+([^;?]*(\.|->)error\(\)|\*?(\w*E|e)rror_?)\s*(;|$)")
TEXT = re.compile(rb"return\s+fmt::format\(")
PROGRESS = re.compile(r"\w+\(progress_?,")


@dataclass(frozen=True)
class Scope:
    """The surroundings of a cursor."""

    returns: str = ""  # "bool", "value", or "" where no default can be returned
    constant: bool = False
    function: int = 0  # the offset of the innermost one
    check: bool = False  # in a condition under which an error is returned


class Finder:
    """The mutants of one file."""

    def __init__(self, file, source):
        self.file = file
        self.source = source
        self.lines = source.split(b"\n")
        self.found = {}

    def text(self, begin, end):
        return self.source[begin:end].decode()

    def add(self, scope, operator, at, old, new, *edits):
        line = self.source.count(b"\n", 0, at) + 1
        change = squeezed(old) + (f" -> {squeezed(new)}" if new else "")
        mutant = Mutant(self.file, line, operator, change,
                        self.lines[line - 1].decode().strip(), edits, scope.constant,
                        scope.function, scope.check)
        # clang has several nodes for an expression that is converted.
        self.found.setdefault((operator, change, tuple((e.begin, e.end) for e in edits)), mutant)

    # Walking ------------------------------------------------------------------------------------

    def walk(self, cursor, parent, scope):
        kind = cursor.kind
        if kind in NOT_WALKED:
            return
        begin, end = span(cursor)
        if kind in FUNCTIONS:
            head = self.source[begin:self.body_of(cursor, end)]
            if b"consteval" in head or text_type(cursor.result_type):
                return
            scope = Scope(returned(cursor, head), b"constexpr" in head, begin)
        elif kind == K.LAMBDA_EXPR:
            scope = replace(scope, returns="")
        elif kind == K.VAR_DECL:
            if re.search(rb"\b(constexpr|constinit)\b", self.source[begin:cursor.location.offset]):
                return
        elif kind == K.CALL_EXPR:
            if (text_type(cursor.type) or SPEED_OR_PROGRESS.search(cursor.spelling)
                    or PROGRESS.match(self.text(begin, end))):
                return
            self.call(cursor, begin, end, scope)
        elif kind == K.BINARY_OPERATOR or kind == K.COMPOUND_ASSIGNMENT_OPERATOR:
            self.binary(list(cursor.get_children()), cursor, end, scope, kind)
        elif kind == K.UNARY_OPERATOR:
            self.unary(cursor, begin, end, scope)
        elif kind in LITERALS:
            self.literal(parent, begin, end, scope)
        elif kind == K.CXX_BOOL_LITERAL_EXPR:
            self.boolean(parent, begin, end, scope)
        elif kind == K.IF_STMT:
            self.condition(cursor, begin, scope)
        elif kind == K.CONDITIONAL_OPERATOR:
            self.negation(next(cursor.get_children()), scope)
        elif kind == K.RETURN_STMT:
            text = self.source[begin:end]
            if PASSED.match(text) or TEXT.match(text):
                return
            self.returned_default(begin, end, scope, parent)
        elif kind == K.COMPOUND_STMT:
            for child in cursor.get_children():
                self.dropped(child, scope)
        children = list(cursor.get_children())
        if kind == K.CASE_STMT:
            children = children[1:]
        elif kind == K.IF_STMT and re.match(rb"if\s+constexpr", self.source[begin:end]):
            children = children[1:]
        named = kind == K.VAR_DECL or kind == K.FIELD_DECL
        for child in children:
            # Before the name of a variable is its type.
            if named and child.extent.start.offset < cursor.location.offset:
                continue
            inner = scope
            if kind == K.IF_STMT and child.kind.is_expression():
                inner = replace(scope, check=self.refuses(cursor))
            self.walk(child, parent if kind == K.UNEXPOSED_EXPR else cursor, inner)

    def refuses(self, statement):
        """Whether an error is returned where the condition of this `if` holds."""
        for child in statement.get_children():
            _, end = span(child)
            if self.source[end:end + 1] == b")" and child.kind.is_expression():
                return REFUSAL.match(self.source[end + 1:span(statement)[1]].lstrip(b" \n{")) is not None
        return False

    def body_of(self, cursor, end):
        bodies = [c.extent.start.offset for c in cursor.get_children()
                  if c.kind in (K.COMPOUND_STMT, K.CXX_TRY_STMT)]
        return bodies[-1] if bodies else end

    # Operators ----------------------------------------------------------------------------------

    def binary(self, children, cursor, end, scope, kind):
        if len(children) != 2:
            return
        (a, b), (c, d) = span(children[0]), span(children[1])
        operator = without_comments(self.text(b, c)).strip()
        if not (a < b <= c < d == end):
            return
        if operator in ARITHMETIC and (not number(cursor.type) or self.source[a:a + 1] == b'"'):
            return
        for table, name in ((RELATIONS, "relation"), (LOGIC, "logic"), (ARITHMETIC, "arithmetic"),
                            (ASSIGNMENTS, "assignment")):
            for other in table.get(operator, ()):
                self.replaced(name, (a, b), operator, other, (c, d), scope)

    def replaced(self, name, left, operator, other, right, scope):
        a, b, c, d = *left, *right
        self.add(scope, name, b, self.text(a, d),
                 f"{self.text(a, b)} {other} {self.text(c, d)}",
                 Edit(a, d, ("(", ACTIVE, " ? ((", (a, b), f") {other} (", (c, d), ")) : (",
                             ORIGINAL, "))")))

    def call(self, cursor, begin, end, scope):
        name = cursor.spelling
        children = list(cursor.get_children())
        if name.startswith("operator") and len(children) == 3:
            self.overloaded(name[8:], children, cursor, end, scope)
        for old, new in (("std::min", "std::max"), ("std::max", "std::min")):
            text = self.text(begin, end)
            if "std::" + name == old and text.startswith(old):
                rest = (begin + len(old), end)
                self.add(scope, "min and max", begin, text, new + self.text(*rest),
                         Edit(begin, end, ("(", ACTIVE, f" ? {new}", rest, " : ", ORIGINAL, ")")))
        if not SYMMETRIC.match(name):
            arguments = list(cursor.get_arguments())
            for first, second in zip(arguments, arguments[1:]):
                self.swapped(name, first, second, scope)

    def overloaded(self, operator, children, cursor, end, scope):
        (a, b), (c, d) = span(children[0]), span(children[2])
        if not a < b <= c < d == end or self.text(b, c).strip() != operator:
            return
        eigen = "Eigen::" in cursor.type.get_canonical().spelling
        if operator in RELATIONS:
            for other in RELATIONS[operator]:
                self.replaced("relation", (a, b), operator, other, (c, d), scope)
        elif operator in ASSIGNMENTS and eigen:
            for other in ASSIGNMENTS[operator]:
                self.replaced("assignment", (a, b), operator, other, (c, d), scope)
        elif operator in ("+", "-") and eigen:
            # The type of an expression says which operators it has: the sign is a factor.
            other = ARITHMETIC[operator][0]
            self.add(scope, "arithmetic", b, self.text(a, d),
                     f"{self.text(a, b)} {other} {self.text(c, d)}",
                     Edit(c, d, ("((", ACTIVE, " ? -1.0 : 1.0) * (", ORIGINAL, "))")))

    def unary(self, cursor, begin, end, scope):
        operand = next(cursor.get_children(), None)
        text = self.text(begin, end)
        if operand is None or not re.match(r"-[^-]", text) or operand.kind in LITERALS:
            return
        a, b = span(operand)
        if number(cursor.type) and not re.fullmatch(r"[\d.]+\w*", self.text(a, b)):
            self.add(scope, "arithmetic", begin, text, self.text(a, b),
                     Edit(begin, end, ("(", ACTIVE, " ? (", (a, b), ") : (", ORIGINAL, "))")))

    def literal(self, parent, begin, end, scope):
        text = self.text(begin, end)
        if parent.kind in NAMES or not re.fullmatch(r"\d[\w.']*(e-\d+)?", text):
            return
        changes = ["+ 1"]
        if re.fullmatch(r"[1-9]\d*[uUlL]*", text):
            changes.append("- 1")
        for change in changes:
            self.add(scope, "constant", begin, self.around(begin, end, f"{text} {change}"), "",
                     Edit(begin, end, ("(", ACTIVE, f" ? {text} {change} : ", ORIGINAL, ")")))

    def boolean(self, parent, begin, end, scope):
        text = self.text(begin, end)
        if parent.kind not in NAMES and text in ("true", "false"):
            other = "false" if text == "true" else "true"
            self.add(scope, "constant", begin, self.around(begin, end, other), "",
                     Edit(begin, end, ("(", ACTIVE, f" ? {other} : {text})")))

    def around(self, begin, end, other):
        """A literal and what takes its place, in their line."""
        line = self.source.rfind(b"\n", 0, begin) + 1
        last = self.source.find(b"\n", end)
        return (f"{self.text(line, begin).lstrip()}{{{self.text(begin, end)} -> {other}}}"
                f"{self.text(end, last)}")

    def swapped(self, name, first, second, scope):
        (a, b), (c, d) = span(first), span(second)
        one, two = self.text(a, b), self.text(c, d)
        same = bare(first.type) == bare(second.type) and bare(first.type)
        if not same or not a < b <= c < d or one == two or "[" == one[:1] or "[" == two[:1]:
            return
        if "begin" in one or "end()" in two or self.text(b, c).strip() != ",":
            return
        self.add(scope, "swap", a, f"{name}({one}, {two})", f"{name}({two}, {one})",
                 Edit(a, b, ("(", ACTIVE, " ? (", (c, d), ") : (", ORIGINAL, "))")),
                 Edit(c, d, ("(", ACTIVE, " ? (", (a, b), ") : (", ORIGINAL, "))")))

    # Conditions and statements ------------------------------------------------------------------

    def condition(self, cursor, begin, scope):
        for child in cursor.get_children():
            _, end = span(child)
            # The condition ends at the parenthesis; a branch does not.
            if self.source[end:end + 1] == b")" and child.kind.is_expression():
                rest = self.source[end + 1:span(cursor)[1]].lstrip(b" \n{")
                if not PASSED.match(rest):
                    self.negation(child, scope)
                return

    def negation(self, condition, scope):
        begin, end = span(condition)
        inner = converted(condition)
        if inner.kind == K.BINARY_OPERATOR:
            left, right = map(span, inner.get_children())
            if self.text(left[1], right[0]).strip() in RELATIONS:
                return
        text = self.text(begin, end)
        negated = inner.kind == K.UNARY_OPERATOR and text.startswith("!")
        self.add(scope, "negation", begin, f"if ({text})", text[1:] if negated else f"!({text})",
                 Edit(begin, end, ("(", ACTIVE, " != static_cast<bool>(", ORIGINAL, "))")))

    def returned_default(self, begin, end, scope, parent):
        value = self.text(begin + len("return"), end).strip()
        if self.source[end:end + 1] != b";" or value in ("", "{}", "0", "nullptr", "std::nullopt"):
            return
        if scope.returns == "bool" and not value.startswith("{"):
            self.add(scope, "return", begin, f"return {value}", f"return !({value})",
                     Edit(end - len(value.encode()), end,
                          ("(", ACTIVE, " != static_cast<bool>(", ORIGINAL, "))")))
        elif scope.returns == "value" and (parent.kind == K.COMPOUND_STMT
                                           or not MESSAGE.match(self.source[begin:end])):
            self.add(scope, "return", begin, f"return {value}", "return {}",
                     Edit(begin, end + 1, ("{ if (", ACTIVE, ") return {}; ", ORIGINAL, " }")))

    def dropped(self, statement, scope):
        begin, end = span(statement)
        inner = converted(statement)
        if inner.kind == K.IF_STMT:
            text = self.source[begin:end]
            if re.match(rb"if\s+constexpr", text) or re.search(rb"\belse\b", text):
                return
            # A call whose error is handed on is dropped with it.
            if PASSED.search(text) and not re.match(rb"if \([^;]*;", text):
                return
            last = list(statement.get_children())[-1]
            end = span(last)[1]
            if self.source[end - 1:end] != b"}":
                end += 1
            scope = replace(scope, check=self.refuses(inner))
        elif inner.kind in STATEMENTS and self.source[end:end + 1] == b";":
            if inner.kind == K.CALL_EXPR and SPEED_OR_PROGRESS.search(inner.spelling):
                return
            end += 1
        else:
            return
        self.add(scope, "dropped statement", begin, self.text(begin, end), "",
                 Edit(begin, end, ("if (!", ACTIVE, ") ", ORIGINAL)))


def span(cursor):
    return cursor.extent.start.offset, cursor.extent.end.offset


def converted(cursor):
    """The cursor that an implicit conversion is applied to."""
    while cursor.kind == K.UNEXPOSED_EXPR:
        inner = next(cursor.get_children(), None)
        if inner is None:
            break
        cursor = inner
    return cursor


def number(type_):
    kind = type_.get_canonical().kind
    return T.BOOL.value <= kind.value <= T.LONGDOUBLE.value or kind in (T.DEPENDENT, T.POINTER)


def bare(type_):
    """A type's name without const and reference; "" if it is not known, or a text."""
    type_ = type_.get_canonical()
    if type_.kind in (T.LVALUEREFERENCE, T.RVALUEREFERENCE):
        type_ = type_.get_pointee()
    if type_.kind in (T.DEPENDENT, T.INVALID, T.UNEXPOSED):
        return ""
    name = type_.spelling.removeprefix("const ")
    return "" if "basic_string" in name or "lambda" in name else name


def text_type(type_):
    return TEXT_TYPE.match(type_.get_canonical().spelling) is not None


def returned(function, head):
    if function.kind in (K.CONSTRUCTOR, K.DESTRUCTOR, K.CONVERSION_FUNCTION):
        return ""
    type_ = function.result_type.get_canonical()
    if type_.kind == T.BOOL:
        return "bool"
    if type_.kind in (T.VOID, T.LVALUEREFERENCE, T.RVALUEREFERENCE, T.AUTO):
        return ""
    return "" if re.match(rb"(\w+ )*auto\b", head) else "value"


def squeezed(text):
    return re.sub(r"\s+", " ", without_comments(text)).strip()


def without_comments(text):
    return re.sub(r"//[^\n]*", "", text)


# Parsing ----------------------------------------------------------------------------------------

def flags_of(database):
    """The flags of each file, as clang takes them: it knows no header that g++ has precompiled."""
    flags = {}
    for entry in json.loads(database.read_text()):
        words = shlex.split(re.sub(r"-include \S+", "", entry["command"]))
        words = [w for w in words[1:words.index("-o")] if not w.startswith("-W") and w != "-Werror"]
        flags[entry["file"]] = (*words, "-w")
    return flags


def find(files, database, kept):
    """The mutants of each file: those with the same flags are parsed together, as headers take
    most of the time. The folder `kept` has those that were found earlier."""
    flags = flags_of(database)
    found, groups, places = {}, {}, {}
    for file in files:
        # A header is parsed as the first source beside it.
        own = flags.get(str(ROOT / file)) or next(
            f for path, f in flags.items() if Path(path).parent == (ROOT / file).parent)
        content = (ROOT / file).read_bytes() + Path(__file__).read_bytes() + " ".join(own).encode()
        places[file] = kept / hashlib.sha256(file.encode() + content).hexdigest()
        if places[file].exists():
            found[file] = pickle.loads(places[file].read_bytes())
        else:
            groups.setdefault(own, []).append(file)
    kept.mkdir(parents=True, exist_ok=True)
    for own, group in groups.items():
        again = parse(group, own, found)
        # Names that are unique in their files only.
        for file in again:
            if parse([file], own, found):
                raise SystemExit(f"{file}: clang does not parse it")
        for file in group:
            places[file].write_bytes(pickle.dumps(found[file]))
    return [mutant for file in files for mutant in found[file]]


def parse(files, flags, found):
    """Adds the mutants of the files; those that have errors are returned in place of that."""
    main = str(ROOT / "model/mutated_together.cpp")
    text = "".join(f'#include "{ROOT / file}"\n' for file in files)
    unit = cindex.Index.create().parse(main, flags, unsaved_files=[(main, text)])
    wrong = {d.location.file.name for d in unit.diagnostics if d.severity >= 3 and d.location.file}
    finders = {str(ROOT / file): Finder(file, (ROOT / file).read_bytes()) for file in files}
    for cursor in unit.cursor.get_children():
        at = cursor.location.file
        if at and at.name in finders:
            finders[at.name].walk(cursor, unit.cursor, Scope())
    for path, finder in finders.items():
        if path not in wrong:
            found[finder.file] = list(finder.found.values())
    return [finder.file for path, finder in finders.items() if path in wrong]

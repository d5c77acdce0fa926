"""Writes tools/verbs.py: a function for each verb of the program, with its options and its report.

    make_verbs.py PROGRAM OUTPUT

Options and reports are those that ``t4d VERB --help --json`` describes.
"""

import json
import keyword
import subprocess
import sys
from pathlib import Path

HEAD = '''"""The verbs of the program t4d as functions, with the same words.

``verbs.quality("bolt.t4d", time_scale=2, worst=3)`` is ``t4d quality bolt.t4d --time-scale 2 --worst
3 --json``; it returns what the verb prints as JSON, as a ``Report``, or its text if the verb has no
JSON. Options that need no value are True; a list becomes its numbers with commas, or the option once
for each where it can be repeated; a dictionary is a file of JSON, as in ``motion={"segments":
[...]}``; ``o`` is ``output``.

A ``Mesh`` or a ``TriangleMesh`` can stand for a file that is read, and these classes for a file that
is written: ``verbs.slice(mesh, time=2, output=t4d.TriangleMesh).mesh``. They go through temporary
files (TMPDIR says where), without rounding.

A verb runs in a process of its own, so that Ctrl-C ends it and nothing half-written is left. It ends
with Python, if a daemon thread waits for it.
"""

from __future__ import annotations

from typing import Any, Dict, Iterable, List, Literal, Optional, Union

from t4d.commands import File, Number, Option, Output
from t4d.commands import Report as Report
from t4d.commands import options_of as options_of
from t4d.commands import program as program
from t4d.commands import report_as
from t4d.commands import run as run
from t4d.commands import run_words as run_words

'''

SCALARS = {"string": "str", "integer": "int", "number": "float", "boolean": "bool"}
# Prints the report of the verb whose reports it joins.
ANY_REPORT = {"join"}
MOST_PARTS = {"type": "integer", "description": "With --most-parts, which prints this alone."}
# Names that members of a report cannot have: methods of a dictionary, and the made mesh.
TAKEN = {*dir(dict), "mesh"}


def camel(name):
    return "".join(part.capitalize() for part in name.replace("-", "_").split("_"))


def one_of(name):
    """A name of what there are several of."""
    if name.endswith("ies"):
        return name[:-3] + "y"
    return name[:-1] if name.endswith("s") and not name.endswith("ss") else name


class Reports:
    """Classes for the objects of a schema, those that others have before them."""

    def __init__(self, schema):
        self.schema = schema
        self.classes = {}

    def class_of(self, node, name):
        lines = [f"class {name}(Report):"]
        members = {}
        about = [node.get("description", "")] if node.get("description") else []
        for member, type_ in node["properties"].items():
            if member in TAKEN or keyword.iskeyword(member) or not member.isidentifier():
                continue
            hint = self.hint(type_, name.removesuffix("Report") + camel(member))
            is_there = member in node.get("required", ()) or hint.startswith("Optional") or hint == "Any"
            members[member] = hint if is_there else f"Optional[{hint}]"
            said = type_.get("description")
            if said:
                about.append(f"{member}: {said}")
        if about:
            text = in_quotes("\n\n    ".join(about))
            lines += [f'    """{text}"""', ""]
        lines += [f"    {member}: {hint}" for member, hint in members.items()] or ["    pass"]
        self.classes[name] = lines
        return name

    def hint(self, node, name):
        if "enum" in node or "const" in node:
            return f"Literal[{', '.join(map(repr, node.get('enum', [node.get('const')])))}]"
        kinds = node.get("type", [])
        kinds = [kinds] if isinstance(kinds, str) else kinds
        hints = [self.hint_of(kind, node, name) for kind in kinds if kind != "null"] or ["Any"]
        hint = hints[0] if len(hints) == 1 else f"Union[{', '.join(hints)}]"
        return f"Optional[{hint}]" if "null" in kinds else hint

    def hint_of(self, kind, node, name):
        if kind == "array":
            return f"List[{self.hint(node.get('items', {}), one_of(name))}]"
        if kind != "object":
            return SCALARS[kind]
        if "properties" in node:
            return self.class_of(node, name)
        if isinstance(node.get("additionalProperties"), dict):
            return f"Dict[str, {self.hint(node['additionalProperties'], one_of(name))}]"
        return "Any"


def in_quotes(text):
    """The text as that of a docstring."""
    return text.rstrip().replace("\\", "\\\\").replace('"""', "'''")


def option_hint(option):
    if option["value"] is None:
        return "bool", "False"
    if option["value"] in ("FLOAT", "INT", "UINT"):
        hint = "Union[Number, Iterable[Number]]" if option["repeats"] else "Number"
    elif option["choices"] and not option["repeats"]:
        hint = f"Literal[{', '.join(map(repr, option['choices']))}]"
    else:
        hint = "Output" if "--output" in option["names"] else "Option"
    return f"Optional[{hint}]", "None"


def function(verb, help_text, reports):
    name = verb["name"]
    kind = f"{camel(name)}Report"
    lines = [f"def {name}("]
    given = []
    if verb["arguments"]:
        lines.append("    *files: File,")
    words = {word: option for option in verb["options"] for word in option["names"]}
    long_first = sorted(words, key=lambda word: word[1] != "-")
    options = {word.lstrip("-").replace("-", "_"): words[word] for word in long_first}
    has_json = "json" in options
    for word in ("help", "h", "json"):
        options.pop(word, None)
    if options and not verb["arguments"]:
        lines.append("    *,")
    for word, option in options.items():
        hint, default = option_hint(option)
        safe = f"{word}_" if keyword.iskeyword(word) else word
        lines.append(f"    {safe}: {hint} = {default},")
        given.append(f"{safe}={safe}")
    result = kind if has_json and reports else "Any"
    files = ["*files"] if verb["arguments"] else []
    call = f"run({', '.join([repr(name), *files, *given])})"
    return [
        *lines,
        f") -> {result}:",
        f'    """{in_quotes(help_text)}\n    """',
        f"    return report_as({kind}, {call})" if result == kind else f"    return {call}",
    ]


def open_function(verb, help_text):
    """The function of a verb with others below it."""
    name = verb["name"]
    return [
        f"def {name}(*files: File, **options: Any) -> Any:",
        f'    """{in_quotes(help_text)}\n    """',
        f'    return run("{name}", *files, **options)',
    ]


def main(program, output):
    def printed(*words):
        return subprocess.run([program, *words], capture_output=True, text=True, check=True).stdout

    verbs = json.loads(printed("--help", "--json"))["verbs"]
    parts = []
    for verb in verbs:
        help_text = printed(verb["name"], "--help")
        if verb.get("verbs"):
            parts.append(open_function(verb, help_text))
            continue
        classes = {}
        if verb["report"] and verb["name"] not in ANY_REPORT:
            reports = Reports(verb["report"])
            if any("--most-parts" in option["names"] for option in verb["options"]):
                reports.schema["properties"]["parts"] = MOST_PARTS
            reports.class_of(reports.schema, f"{camel(verb['name'])}Report")
            classes = reports.classes
        parts += classes.values()
        parts.append(function(verb, help_text, bool(classes)))
    names = "".join(f'    "{verb["name"]}",\n' for verb in verbs)
    text = HEAD + f"__all__ = [\n{names}]\n"
    for lines in parts:
        text += "\n\n" + "\n".join(lines) + "\n"
    Path(output).write_text(text)


if __name__ == "__main__":
    main(*sys.argv[1:])

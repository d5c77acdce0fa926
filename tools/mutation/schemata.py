"""Writes sources that hold many mutants at once, of which a number in the environment chooses one
when a program runs: one build serves all."""

from .mutant import ACTIVE, ORIGINAL

HEADER = "model/mutation.h"

# T4D_MUTANT is the active mutant; the numbers of those that are executed are appended to the file
# T4D_MUTANT_TRACE, each at once, as a process may end in any way. System calls, since tests replace
# the functions of the C library by failing ones.
HEADER_TEXT = """#pragma once

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <type_traits>

#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

// Constants that became variables, and other consequences of mutation.
%(pragmas)s

namespace t4d_mutation {

inline const int active = std::getenv("T4D_MUTANT") ? std::atoi(std::getenv("T4D_MUTANT")) : 0;
inline const char* const trace = std::getenv("T4D_MUTANT_TRACE");
inline std::atomic<bool> traced[%(count)d];

[[gnu::cold, gnu::noinline]] inline void reached(int number) {
  if (traced[number].exchange(true)) return;
  char line[16];
  const int length = std::snprintf(line, sizeof line, "%%d\\n", number);
  const long file = syscall(SYS_openat, AT_FDCWD, trace, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0644);
  if (file < 0) return;
  syscall(SYS_write, file, line, length);
  syscall(SYS_close, file);
}

[[gnu::always_inline]] inline bool isActive(int number) {
  if (trace && !traced[number].load(std::memory_order_relaxed)) reached(number);
  return number == active;
}

/// False where the compiler evaluates a constant.
constexpr bool on(int number) {
  return !std::is_constant_evaluated() && isActive(number);
}

}  // namespace t4d_mutation
"""
WARNINGS = ("narrowing", "parentheses", "sign-compare", "type-limits", "dangling-else",
            "unused-variable", "unused-but-set-variable", "unused-parameter", "unused-function",
            "unused-value", "maybe-uninitialized", "uninitialized", "array-bounds", "bool-compare",
            "int-in-bool-context", "bool-operation", "return-type", "logical-op", "overflow",
            "address", "shift-count-overflow", "shift-count-negative", "stringop-overflow",
            "stringop-overread", "nonnull", "misleading-indentation", "aggressive-loop-optimizations",
            "implicit-fallthrough", "unused-result", "extra", "div-by-zero", "pedantic",
            "unused-local-typedefs", "empty-body", "enum-compare", "tautological-compare",
            "null-dereference", "free-nonheap-object", "alloc-size-larger-than=")


def header(mutants):
    pragmas = "\n".join(f'#pragma GCC diagnostic ignored "-W{w}"' for w in WARNINGS)
    return HEADER_TEXT % {"pragmas": pragmas, "count": 1 + max(m.number for m in mutants)}


def mutated(source, mutants):
    """The source with all these mutants of its file, and the lines that each changed in it:
    number -> [(first, last)]."""
    edits = sorted(((e.begin, -e.end, m.number, e) for m in mutants for e in m.edits),
                   key=lambda item: item[:3])
    edits = [(number, edit) for _, _, number, edit in edits]
    text, ranges = [], []
    place(source, 0, len(source), edits, text, ranges)
    head = f'#include "{HEADER}"\n#line 1\n'.encode()
    lines = {}
    offsets = [0]
    for piece in text:
        offsets.append(offsets[-1] + len(piece))
    whole = b"".join(text)
    for number, first, last in ranges:
        lines.setdefault(number, []).append(
            (1 + whole.count(b"\n", 0, offsets[first]), 1 + whole.count(b"\n", 0, offsets[last])))
    return head + whole, lines


def place(source, begin, end, edits, text, ranges):
    """Appends the bytes begin..end with the edits, which come in the order of their beginnings, the
    longer first. `ranges` gets where in `text` each mutant is."""
    at, k = begin, 0
    while k < len(edits):
        number, edit = edits[k]
        inner = [(n, e) for n, e in edits[k + 1:] if e.end <= edit.end and e.begin >= edit.begin]
        text.append(source[at:edit.begin])
        first = len(text)
        for piece in edit.pieces:
            if piece == ORIGINAL:
                place(source, edit.begin, edit.end, inner, text, ranges)
            elif piece == ACTIVE:
                text.append(b"t4d_mutation::on(%d)" % number)
            elif isinstance(piece, tuple):
                a, b = piece
                within = [(n, e) for n, e in inner if a <= e.begin and e.end <= b]
                place(source, a, b, within, text, ranges)
            else:
                text.append(piece.encode())
        ranges.append((number, first, len(text)))
        at = edit.end
        k += 1 + len(inner)
    text.append(source[at:end])

"""A mutant: one change of the source, which a number selects at run time."""

from dataclasses import dataclass

# Stands in an edit's pieces for the text that it replaces, with the edits of other mutants in it.
ORIGINAL = 0
# Stands in an edit's pieces for whether the mutant is active.
ACTIVE = 1


@dataclass(frozen=True)
class Edit:
    """Replaces the bytes begin..end by pieces: text, ORIGINAL, ACTIVE, or a range (begin, end)."""

    begin: int
    end: int
    pieces: tuple


@dataclass
class Mutant:
    file: str
    line: int
    operator: str
    change: str        # "a < b: a <= b"
    source_line: str
    edits: tuple
    # The mutant is in a constexpr function: the compiler may have evaluated every call.
    constant: bool = False
    function: int = 0  # where its function begins in the file
    check: bool = False  # it is in the condition of a refusal, or drops it
    number: int = 0
    room: str = ""

    @property
    def key(self):
        return self.file, self.source_line, self.change

"""What goes wrong, as exceptions that say where and why."""

from __future__ import annotations

import re
from typing import Any, List, Optional, Tuple


class Error(Exception):
    """Anything that t4d cannot do.

    ``message`` says what was found, what was expected and what to do; ``where`` is the file, with
    the line or the byte, the slab or the frame ("" if it is clear), and ``offset`` the byte in the
    file, if there is one.
    """

    def __init__(self, message: str, where: str = "", offset: Optional[int] = None) -> None:
        super().__init__(f"{where}: {message}" if where else message)
        self.message = message
        self.where = where
        self.offset = offset

    def __reduce__(self) -> Tuple[Any, ...]:
        return type(self), (self.message, self.where, self.offset), self.__dict__

    @property
    def file(self) -> str:
        """The file among ``where``: without its line, byte or part."""
        return re.split(r":(?=\d+(?::|$)| )", self.where, maxsplit=1)[0]


class InvalidInput(Error, ValueError):
    """The data violates a requirement."""


class FileError(Error, OSError):
    """A file cannot be opened or read."""

    __str__ = Exception.__str__


class Unsupported(Error, NotImplementedError):
    """Valid, but beyond what this build or version can do."""


class Failed(Error, RuntimeError):
    """A failure on valid input, or in writing the output."""


class VerbError(Error):
    """A verb of the program has failed; ``exit_code`` is 1, 2 (wrong usage) or 4 (invalid input)."""

    def __init__(self, message: str, verb: str, exit_code: int) -> None:
        super().__init__(message)
        self.verb = verb
        self.exit_code = exit_code

    def __reduce__(self) -> Tuple[Any, ...]:
        return type(self), (self.message, self.verb, self.exit_code), self.__dict__


class Loss(UserWarning):
    """Done, with a loss: each warning is a sentence that names what was lost."""


def warn(kind: type, sentences: List[str]) -> None:
    import warnings

    for sentence in sentences:
        warnings.warn(sentence, kind, stacklevel=3)

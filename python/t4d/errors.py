"""Errors as exceptions that say where and why."""

from __future__ import annotations

import contextlib
import os
import sys
import warnings
from typing import Any, Iterator, List, Optional, Tuple, Type


class Error(Exception):
    """Anything that t4d cannot do.

    ``message`` says what was found, what was expected and what to do; ``where`` is the file, with
    the line or the byte, the slab or the frame ("" if it is clear), ``file`` the path of the file,
    or None, and ``offset`` the byte in the file, if there is one.
    """

    file: Optional[str] = None

    def __init__(
        self, message: str, where: str = "", offset: Optional[int] = None, named: Optional[str] = None, within: str = ""
    ) -> None:
        """``where`` consists of ``named``, a file, and ``within``; by default it is a file."""
        super().__init__(f"{where}: {message}" if where else message)
        self.message = message
        self.where = where
        self.offset = offset
        self._named = where if named is None else named
        self._within = within

    def __reduce__(self) -> Tuple[Any, ...]:
        return type(self), (self.message, self.where, self.offset), self.__dict__

    @property
    def place(self) -> str:
        """``where`` without the file: the line or the byte, the slab or the frame."""
        return self._within if self.file == self._named else self.where


class InvalidInput(Error, ValueError):
    """The data violates a requirement."""


class FileError(Error, OSError):
    """A file cannot be opened, read or written."""

    def __init__(
        self, message: str, where: str = "", offset: Optional[int] = None, named: Optional[str] = None, within: str = ""
    ) -> None:
        super().__init__(message, where, offset, named, within)
        self.file = self._named or None

    @property
    def filename(self) -> Optional[str]:
        return self.file

    __str__ = Exception.__str__


class Unsupported(Error, NotImplementedError):
    """Valid, but beyond what this build or version can do."""


class Failed(Error, RuntimeError):
    """A failure on valid input."""


class VerbError(Error):
    """A verb of the program has failed; ``exit_code`` is 1, 2 (wrong usage) or 4 (invalid input)."""

    def __init__(self, message: str, verb: str, exit_code: int) -> None:
        super().__init__(message)
        self.verb = verb
        self.exit_code = exit_code

    def __reduce__(self) -> Tuple[Any, ...]:
        return type(self), (self.message, self.verb, self.exit_code), self.__dict__


@contextlib.contextmanager
def about(file: Optional[str] = None, output: Optional[str] = None) -> Iterator[None]:
    """Errors in the block are about ``file``, or about ``output`` where they say so. To the library
    an output that cannot be written is a failure like others; to Python it is an ``OSError``."""
    try:
        yield
    except Error as error:
        raised = error
        if isinstance(error, Failed) and error.where and output:
            if os.path.realpath(error.where) == os.path.realpath(output):
                raised = FileError(error.message, error.where)
        named = error._named if error._named in (output, file) else None
        raised.file = named or raised.file or file
        raise raised from None


class Loss(UserWarning):
    """Done, with a loss: each warning is a sentence that names what was lost."""


def warn(kind: Type[Warning], sentences: List[str]) -> None:
    """Warns of the line of the caller, which is the first that is not of this package."""
    package = os.path.dirname(__file__)
    stacklevel, frame = 2, sys._getframe(1)
    while frame.f_back and os.path.dirname(frame.f_code.co_filename) == package:
        stacklevel, frame = stacklevel + 1, frame.f_back
    for sentence in sentences:
        warnings.warn(sentence, kind, stacklevel=stacklevel)

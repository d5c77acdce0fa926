"""Objects that do not change once they are made."""

from __future__ import annotations

from typing import Any, Dict, TypeVar

T = TypeVar("T")


class Unchanging:
    """Its copies are itself. It cannot be pickled: ``_instead`` says what to do."""

    _instead: str

    def __copy__(self: T) -> T:
        return self

    def __deepcopy__(self: T, memo: Dict[int, Any]) -> T:
        return self

    def __reduce__(self) -> Any:
        raise TypeError(f"a t4d.{type(self).__name__} cannot be pickled: {self._instead}")

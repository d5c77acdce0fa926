"""Objects that do not change once they are made."""

from __future__ import annotations

import copy
from typing import Any, Dict, TypeVar

T = TypeVar("T")


class Unchanging:
    """Its copies are itself; those of a subclass have attributes of their own. It cannot be pickled:
    ``_instead`` says what to do."""

    _instead: str

    def __copy__(self: T) -> T:
        return self if _is_ours(self) else _like(self, self.__dict__)

    def __deepcopy__(self: T, memo: Dict[int, Any]) -> T:
        if _is_ours(self):
            return self
        # What it is made of does not change; attributes of the subclass may.
        for value in self.__dict__.values():
            parts = value if isinstance(value, list) else [value]
            memo.update((id(part), part) for part in parts if _is_ours(part))
        return _like(self, copy.deepcopy(self.__dict__, memo))

    def __reduce__(self) -> Any:
        raise TypeError(f"{_name(self)} cannot be pickled: {self._instead}")


def _is_ours(given: Any) -> bool:
    return type(given).__module__.partition(".")[0] == "t4d"


def _name(given: Any) -> str:
    kind = type(given)
    return f"a t4d.{kind.__name__}" if _is_ours(given) else f"a {kind.__module__}.{kind.__qualname__}"


def _like(given: T, attributes: Dict[str, Any]) -> T:
    made = type(given).__new__(type(given))
    made.__dict__.update(attributes)
    return made

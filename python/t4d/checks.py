"""Checks of what is given: errors name the option, what was given and what is expected."""

from __future__ import annotations

import math
import operator
import os
from typing import Any, Callable, Iterable, Optional, Sequence, SupportsFloat, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

Path = Union[str, bytes, os.PathLike[str], os.PathLike[bytes]]
Numbers = Iterable[SupportsFloat]
"""Of Python or numpy, or an array."""


def _says(option: str, value: Any, expected: str) -> str:
    text = repr(value)
    return f"{option} is {text if len(text) <= 80 else text[:77] + '...'}; expected {expected}"


def number(
    option: str,
    value: Any,
    expected: str = "a number",
    holds: Callable[[float], bool] = math.isfinite,
) -> float:
    plain = not isinstance(value, (str, bytes, bytearray, bool, np.bool_))
    if not plain or not hasattr(value, "__float__") or np.ndim(value) or np.iscomplexobj(value):
        raise TypeError(_says(option, value, expected))
    try:
        found = float(value)
    except TypeError:
        raise TypeError(_says(option, value, expected)) from None
    except OverflowError:
        found = math.inf
    if not holds(found):
        raise ValueError(_says(option, value, expected))
    return found


def positive(option: str, value: Any) -> float:
    return number(option, value, "a number above zero", lambda x: 0 < x < math.inf)


def numbers(option: str, values: Any, count: Optional[int] = None) -> Tuple[float, ...]:
    expected = "numbers" if count is None else f"{count} numbers"
    if isinstance(values, (str, bytes)):
        raise TypeError(_says(option, values, expected))
    try:
        given = list(values)
    except TypeError:
        raise TypeError(_says(option, values, expected)) from None
    found = tuple(number(f"{option}[{i}]", value) for i, value in enumerate(given))
    if count is not None and len(found) != count:
        raise ValueError(_says(option, values, expected))
    return found


def whole(option: str, value: Any, least: int, most: int = 2**64 - 1) -> int:
    expected = f"a whole number from {least}" + (f" to {most}" if most < 2**64 - 1 else "")
    if isinstance(value, (bool, np.bool_)):
        raise TypeError(_says(option, value, expected))
    try:
        found = operator.index(value)
    except TypeError:
        raise TypeError(_says(option, value, expected)) from None
    if not least <= found <= most:
        raise ValueError(_says(option, value, expected))
    return found


def flag(option: str, value: Any) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(_says(option, value, "True or False"))
    return bool(value)


def text(option: str, value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(_says(option, value, "a text"))
    try:
        value.encode()
    except UnicodeEncodeError:
        raise ValueError(_says(option, value, "a text that can be written as UTF-8")) from None
    return value


def choice(option: str, value: Any, choices: Sequence[str]) -> str:
    expected = f"{', '.join(map(repr, choices[:-1]))} or {choices[-1]!r}"
    if not isinstance(value, str):
        raise TypeError(_says(option, value, expected))
    if value not in choices:
        raise ValueError(_says(option, value, expected))
    return value


def function(option: str, value: Any) -> Any:
    if value is not None and not callable(value):
        raise TypeError(_says(option, value, "a function or None"))
    return value


def array(what: str, values: ArrayLike) -> NDArray[Any]:
    """An array of real numbers: what a mask hides, or an imaginary part, is not dropped."""
    parts = values if isinstance(values, (list, tuple)) else [values]
    if any(isinstance(part, np.ma.MaskedArray) and np.any(part.mask) for part in parts):
        raise TypeError(f"{what}: the array is masked; fill in the masked values, or leave them out")
    found = np.asarray(values)
    if found.dtype.kind == "O":
        try:
            return found.astype(np.float64)
        except (TypeError, ValueError):
            pass
    if found.dtype.kind not in "biuf":
        raise TypeError(f"{what}: the array is of {found.dtype}; expected real numbers")
    return found


def indices(what: str, values: ArrayLike) -> NDArray[Any]:
    """An array of whole numbers: floats and objects are not converted, even if they are whole."""
    found = np.asarray(values)
    if found.dtype.kind in "bfO":
        raise TypeError(
            f"{what}: the array is of {found.dtype}; expected whole numbers: convert it with "
            ".astype(np.uint32)"
        )
    return array(what, values)


def counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def path_text(path: Path) -> str:
    """The path with bytes that are not UTF-8 as Python keeps them in names of files."""
    name = os.fsdecode(path)
    if "\0" in name:
        raise ValueError(f"the path {name!r} has a null character")
    return name

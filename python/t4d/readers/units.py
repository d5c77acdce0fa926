"""One spelling for each unit, and how units convert."""

from __future__ import annotations

from typing import Dict, Tuple

# The unit, its size in metres or seconds, and its other names in lower case, without the s of a plural.
# "\u00b5" is a micro sign, "\u03bc" the Greek letter, and ImageJ writes the first one out.
_LENGTHS: Tuple[Tuple[str, float, str], ...] = (
    ("angstrom", 1e-10, "\u00c5 \u212b"),
    ("nm", 1e-9, "nanometer nanometre"),
    ("um", 1e-6, "micrometer micrometre micron \u00b5m \u03bcm \\u00b5m"),
    ("mm", 1e-3, "millimeter millimetre"),
    ("cm", 1e-2, "centimeter centimetre"),
    ("m", 1.0, "meter metre"),
    ("km", 1e3, "kilometer kilometre"),
    ("inch", 0.0254, "inches"),
)
_TIMES: Tuple[Tuple[str, float, str], ...] = (
    ("ns", 1e-9, "nanosecond"),
    ("us", 1e-6, "microsecond \u00b5s \u03bcs"),
    ("ms", 1e-3, "millisecond msec"),
    ("s", 1.0, "second sec"),
    ("min", 60.0, "minute"),
    ("h", 3600.0, "hour"),
    ("d", 86400.0, "day"),
)
_SHORT = 3  # prefixes of short names differ by case: mm and Mm


def unit_named(name: str) -> str:
    """A unit's usual name: "um" for "µm", "micron" and so on; other names as they are, and "" for pixels."""
    word = name if len(name) <= _SHORT else name.lower()
    singular = word[:-1] if len(word) > _SHORT and word.endswith("s") else word
    if singular == "pixel":
        return ""
    known = (unit for unit, _, names in _LENGTHS + _TIMES if {word, singular} & {unit, *names.split()})
    return next(known, name)


def factor_to(unit: str, other: str) -> float:
    """The factor from ``unit`` to ``other``. Raises ValueError if they do not convert."""
    for units in (_LENGTHS, _TIMES):
        sizes = {name: size for name, size, _ in units}
        if unit in sizes and other in sizes:
            return float(f"{sizes[unit] / sizes[other]:.12g}")  # a power of ten is one
    if unit == other:
        return 1.0
    raise ValueError(f"has lengths in {unit} and in {other}; expected one unit of length")


def in_one_unit(lengths: Dict[str, float], units: Dict[str, str]) -> Tuple[Dict[str, float], str]:
    """Lengths by axis, converted to the unit of the first axis of x, y, z that has one, and this unit. A length
    without a unit is in that of the others. Raises ValueError for units that do not convert."""
    known = [units[axis] for axis in "xyz" if units.get(axis) and (axis in lengths or not lengths)]
    if not known:
        return dict(lengths), ""
    return {axis: n * factor_to(units.get(axis) or known[0], known[0]) for axis, n in lengths.items()}, known[0]

"""Attributes of a 4D mesh, by the names that they have in the solid that was swept."""

import numpy as np

from .recorder import Problem

CORNERS = ":corners"  # of the solid's triangles: light slices have the same corners, exact ones have not


def components(values):
    return 1 if values.ndim == 1 else values.shape[1]


def attribute_of(solid, name, light):
    """Its values and where they are, in Blender's terms; None if the slice has none of this name."""
    if name in solid.vertex_attributes:
        return solid.vertex_attributes[name], "POINT"
    if name in solid.triangle_attributes:
        return solid.triangle_attributes[name], "FACE"
    corners = solid.triangle_attributes.get(name + CORNERS)
    if not light or corners is None:
        return None
    parts = components(corners) // 3
    return corners.reshape((-1, parts) if parts > 1 else -1), "CORNER"


def color_of(solid, name, light):
    """An attribute that can be shown as colours."""
    found = attribute_of(solid, name, light)
    if found is None:
        known = {*solid.vertex_attributes, *solid.triangle_attributes} - {"velocity"}
        raise Problem(missing(name, known, light))
    if components(found[0]) not in (1, 3, 4):
        raise Problem(f"attribute '{name}' has {components(found[0])} components; colours have 1, 3 or 4")
    return found


def missing(name, known, light):
    names = sorted({one.removesuffix(CORNERS) for one in known if light or not one.endswith(CORNERS)})
    says = f"no attribute '{name}'; there are {', '.join(names)}" if names else f"no attribute '{name}'"
    return f"{says}; light slices have it" if not light and name + CORNERS in known else says


def range_of(bodies, name, light):
    """The least and the largest number of an attribute in all slices, or None if it has colours."""
    low, high, known = np.inf, -np.inf, set()
    for body in bodies:
        for slab in body.slabs():
            begin, end = slab.time_span
            if begin == end:  # a cap, which no slice cuts
                continue
            found = {**slab.cell_attributes, **slab.vertex_attributes}
            known |= set(found)
            parts = 1
            values = found.get(name)
            if values is None and light:
                values, parts = found.get(name + CORNERS), 3
            if values is None or not len(values):
                continue
            if components(values) > parts:
                return None
            finite = values[np.isfinite(values)]
            if len(finite):
                low, high = min(low, finite.min()), max(high, finite.max())
    if name not in known and not (light and name + CORNERS in known):
        raise Problem(missing(name, known, light))
    return float(low), float(high)

"""Units of length."""

METRES = {
    "nm": 1e-9, "um": 1e-6, "µm": 1e-6, "mm": 1e-3, "millimetre": 1e-3, "cm": 1e-2, "dm": 0.1,
    "m": 1, "metre": 1, "meter": 1, "km": 1e3,
    "in": 0.0254, "inch": 0.0254, "ft": 0.3048, "foot": 0.3048, "yd": 0.9144,
}  # fmt: skip


def metres_per_unit(scene):
    """What a unit of the scene means; without a system of units, a metre."""
    return 1 if scene.unit_settings.system == "NONE" else scene.unit_settings.scale_length

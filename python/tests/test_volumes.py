"""Volumes as tifffile writes them."""

import numpy as np
import pytest
import tifffile
from t4d import verbs

SHAPE = {"T": 3, "Z": 5, "C": 2, "Y": 18, "X": 21}


def samples(axes):
    """Channel 1 has a solid without any symmetry, channel 0 nothing."""
    at = np.indices([SHAPE[axis] for axis in axes])
    place = {axis: at[i] for i, axis in enumerate(axes)}
    value = 2 * place["X"] + 3 * place["Y"] + 5 * place["Z"] + 7 * place["T"]
    inside = (value < 55) & (place["X"] > place["T"]) & (place["Y"] > 1)
    if "C" in axes:
        inside &= place["C"] == 1
    return np.where(inside, 200, 20)


@pytest.mark.parametrize(
    "name, axes, how, options",
    [
        ("a.tif", "TZYX", {"imagej": True}, {}),
        ("a.tif", "TZCYX", {"imagej": True, "byteorder": "<"}, {"channel": 1}),
        ("a.ome.tif", "TZYX", {"compression": "zlib", "tile": (16, 16)}, {}),
        ("a.ome.tif", "TCZYX", {"bigtiff": True}, {"channel": 1}),
        ("a.ome.tif", "ZTCYX", {}, {"channel": 1}),
        ("a.ome.tif", "CTZYX", {"byteorder": ">"}, {"channel": 1}),
        ("a.tif", "TZYX", {"compression": "zlib", "byteorder": ">"}, {}),
        ("a.tif", "ZTYX", {}, {"axes": "ztyx"}),
    ],
)
@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32])
def test_a_tiff_is_the_array(tmp_path, name, axes, how, options, kind):
    metadata = {"axes": axes} if name == "a.ome.tif" or "imagej" in how else None
    given = dict(how)
    if metadata is not None:
        given["metadata"] = metadata
    tifffile.imwrite(
        tmp_path / name, samples(axes).astype(kind), photometric="minisblack", **given
    )
    np.save(tmp_path / "a.npy", samples("TZYX").astype(kind))
    verbs.weave(tmp_path / name, iso=100, frame_time=1, body="a", output=tmp_path / "tiff.t4d", **options)
    verbs.weave(
        tmp_path / "a.npy", iso=100, axes="tzyx", frame_time=1, output=tmp_path / "array.t4d"
    )
    found = verbs.diff(tmp_path / "tiff.t4d", tmp_path / "array.t4d")
    assert found["same"] and found["level"] == "mesh", found


def test_units_and_spacing_are_those_that_are_written(tmp_path):
    data = samples("TZYX").astype(np.uint8)
    tifffile.imwrite(
        tmp_path / "a.tif", data, imagej=True, resolution=(4, 2),
        metadata={"axes": "TZYX", "spacing": 0.75, "unit": "um", "finterval": 0.5},
    )
    sizes = {f"PhysicalSize{a}": s for a, s in zip("XYZ", (0.25, 0.5, 0.75))}
    units = {f"PhysicalSize{a}Unit": "µm" for a in "XYZ"}
    tifffile.imwrite(
        tmp_path / "a.ome.tif", data, photometric="minisblack",
        metadata={"axes": "TZYX", "TimeIncrement": 500.0, "TimeIncrementUnit": "ms", **sizes, **units},
    )
    infos = []
    for name in ("a.tif", "a.ome.tif"):
        verbs.weave(tmp_path / name, iso=100, output=tmp_path / "a.t4d")
        infos.append(verbs.info(tmp_path / "a.t4d"))
    assert infos[0].length_unit == infos[1].length_unit == "um"
    assert (infos[0].time_end, infos[0].time_unit) == (1.0, "s")
    assert (infos[1].time_end, infos[1].time_unit) == (1000.0, "ms")
    for info in infos:
        assert info.bounds_max[0] < 21 * 0.25 and info.bounds_max[1] < 18 * 0.5
    assert infos[0].bounds_max == pytest.approx(infos[1].bounds_max)

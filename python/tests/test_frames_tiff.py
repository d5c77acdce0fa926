"""TIFF through tifffile, against the array that was written, Pillow and bioio's reader of OME."""

import itertools
import re

import numpy as np
import pytest

tifffile = pytest.importorskip("tifffile")

import t4d  # noqa: E402

SHAPE = {"T": 3, "Z": 5, "C": 2, "Y": 18, "X": 21}


def samples(axes, kind=np.uint16):
    """No two axes can be taken for each other, nor turned round."""
    at = np.indices([SHAPE[axis] for axis in axes])
    place = {axis: at[i] for i, axis in enumerate(axes)}
    value = place["X"] + 21 * (place["Y"] % 5) + 3 * place["Z"] + 50 * place["T"]
    return (value + 7 * place["C"] if "C" in axes else value + 7).astype(kind)


def expected(kind=np.uint16):
    """Frames (t, x, y, z) of channel 1."""
    return samples("TCXYZ", kind)[:, 1]


def same(frames, wanted):
    assert len(frames) == len(wanted)
    assert all(np.array_equal(mine, other) for mine, other in zip(frames, wanted))


def refused(path, **options):
    with pytest.raises(t4d.Error) as error:
        frames = t4d.open_frames(path, **options)
        for frame in frames:
            pass
    return str(error.value)


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
        ("a.tif", "CZTYX", {"metadata": {"axes": "CZTYX"}}, {"channel": 1}),
    ],
)
@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32])
def test_a_tiff_is_the_array(tmp_path, name, axes, how, options, kind):
    given = dict(how)
    if name == "a.ome.tif" or "imagej" in how:
        given["metadata"] = {"axes": axes}
    tifffile.imwrite(tmp_path / name, samples(axes, kind), photometric="minisblack", **given)
    frames = t4d.open_frames(tmp_path / name, **options)
    assert frames.dtype == kind
    same(frames, expected(kind))
    cut = t4d.open_frames(tmp_path / name, region="3:9,:,1:4,1:3", **options)
    same(cut, expected(kind)[1:3, 3:9, :, 1:4])


def pages(path, planes, description="", **how):
    """A page for each plane, in strips or tiles, and the description with the first, whatever it says."""
    with tifffile.TiffWriter(path, **{name: how.pop(name) for name in ("bigtiff", "byteorder") if name in how}) as file:
        for i, plane in enumerate(planes):
            said = description.encode() if i == 0 and description else None
            file.write(plane, photometric="minisblack", metadata=None, contiguous=False, description=said, **how)
    return path


def flat(axes, kind=np.uint8):
    """The planes of these axes, one after another."""
    return samples(axes + "YX", kind).reshape(-1, SHAPE["Y"], SHAPE["X"])


def imagej(slices, frames, more=""):
    return f"ImageJ=1.53t\nimages={slices * frames}\nslices={slices}\nframes={frames}\nhyperstack=true\n{more}"


FORMS = {"classic": {"byteorder": "<"}, "big-endian": {"byteorder": ">"}, "BigTIFF": {"bigtiff": True}}
KINDS = [np.dtype(f"{kind}{size}") for kind in "ui" for size in (1, 2, 4, 8)] + [np.dtype(f"f{n}") for n in (2, 4, 8)]


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_all_types_strips_tiles_and_compressions(tmp_path, kind):
    packed = itertools.cycle((None, "lzw", "zlib", "packbits"))
    for form, (layout, compression) in itertools.product(FORMS.values(), zip(
            ({"rowsperstrip": 5}, {"tile": (16, 16)}, {"rowsperstrip": 5}, {"tile": (16, 16)}), packed)):  # fmt: skip
        path = pages(tmp_path / "a.tif", flat("TZ", kind), imagej(5, 3), compression=compression, **form, **layout)
        frames = t4d.open_frames(path)
        assert frames.dtype == (np.float32 if kind == np.float16 else kind)
        same(frames, samples("TXYZ", kind))


@pytest.mark.parametrize("order", "<>")
def test_imagej_above_4_gib_has_its_planes_after_its_only_page(tmp_path, order):
    path = tmp_path / "a.tif"
    tifffile.imwrite(path, samples("TZYX"), imagej=True, metadata={"axes": "TZYX"}, byteorder=order)
    whole = bytearray(path.read_bytes())
    with tifffile.TiffFile(path) as file:
        page = file.pages[0]
        last = page.offset + 2 + 12 * len(page.tags)
    whole[last : last + 4] = bytes(4)  # no page after it
    path.write_bytes(whole)
    assert len(tifffile.TiffFile(path).pages) == 1
    same(t4d.open_frames(path), samples("TXYZ"))


def test_units_and_spacing_are_those_that_are_written(tmp_path):
    data = samples("TZYX", np.uint8)
    tifffile.imwrite(
        tmp_path / "a.tif", data, imagej=True, resolution=(4, 2),
        metadata={"axes": "TZYX", "spacing": -0.75, "unit": "micron", "finterval": 0.5},
    )
    sizes = {f"PhysicalSize{a}": s for a, s in zip("XYZ", (0.25, 0.5, 0.75))}
    units = {f"PhysicalSize{a}Unit": "µm" for a in "XYZ"}
    tifffile.imwrite(
        tmp_path / "a.ome.tif", data, photometric="minisblack",
        metadata={"axes": "TZYX", "TimeIncrement": 500.0, "TimeIncrementUnit": "ms", **sizes, **units},
    )
    imagej, ome = (t4d.open_frames(tmp_path / name) for name in ("a.tif", "a.ome.tif"))
    assert imagej.length_unit == ome.length_unit == "um"
    assert (imagej.times, imagej.time_unit) == ([0, 0.5, 1.0], "s")
    assert (ome.times, ome.time_unit) == ([0, 500, 1000], "ms")
    for frames in (imagej, ome):
        assert np.array_equal(frames.affine, np.diag([0.25, 0.5, 0.75, 1])) and frames.unsized == ""


def test_nanometres_beside_micrometres_become_one_unit(tmp_path):
    sizes = {"PhysicalSizeX": 250.0, "PhysicalSizeXUnit": "nm", "PhysicalSizeY": 0.5, "PhysicalSizeYUnit": "µm",
             "PhysicalSizeZ": 0.002, "PhysicalSizeZUnit": "mm"}  # fmt: skip
    tifffile.imwrite(tmp_path / "a.ome.tif", samples("TZYX"), photometric="minisblack",
                     metadata={"axes": "TZYX", **sizes})
    frames = t4d.open_frames(tmp_path / "a.ome.tif")
    assert frames.length_unit == "nm" and np.allclose(np.diag(frames.affine), [250, 500, 2000, 1])
    assert frames.times is None


def with_planes(path, times, unit="s"):
    """An OME-TIFF with the time of each plane: [t][z]."""
    planes = {"DeltaT": [time for frame in times for time in frame], "DeltaTUnit": [unit] * 15}
    tifffile.imwrite(path, samples("TZYX"), photometric="minisblack",
                     metadata={"axes": "TZYX", "TimeIncrement": 10.0, "Plane": planes})
    return path


def test_planes_say_when_they_were_taken(tmp_path):
    """The mean of each frame, as of DICOM; bioio has the same planes."""
    times = [[100 * t * t + 2 * z for z in range(5)] for t in range(3)]
    frames = t4d.open_frames(with_planes(tmp_path / "a.ome.tif", times, "ms"))
    assert frames.time_unit == "s" and np.allclose(frames.times, [0.004, 0.104, 0.404])
    xml = tifffile.TiffFile(tmp_path / "a.ome.tif").ome_metadata
    found = [float(value) for value in re.findall(r'DeltaT="([^"]+)"', xml)]
    assert np.allclose(np.reshape(found, (3, 5)).mean(axis=1) / 1000, frames.times)
    still = t4d.open_frames(with_planes(tmp_path / "b.ome.tif", [[5, 5, 5, 5, 5]] * 3))
    assert still.times == [0, 10, 20] and any("DeltaT" in note for note in still.notes)


def ome(order, data, channels=1, times=3, uuid=""):
    """The description of an image whose planes are where ``data`` says."""
    return (
        '<?xml version="1.0" encoding="UTF-8"?><OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06"'
        f'{uuid and f" UUID={chr(34)}{uuid}{chr(34)}"}><Image ID="Image:0"><Pixels ID="Pixels:0" Type="uint8" '
        f'DimensionOrder="{order}" SizeX="21" SizeY="18" SizeZ="5" SizeC="{channels}" SizeT="{times}" '
        f'PhysicalSizeX="0.5" PhysicalSizeY="0.5" TimeIncrement="2">{data}</Pixels></Image></OME>'
    )


def placed(t, z, page, c=0, file="", uuid=""):
    inner = f'<UUID FileName="{file}">{uuid}</UUID>' if file else ""
    return f'<TiffData FirstT="{t}" FirstC="{c}" FirstZ="{z}" IFD="{page}" PlaneCount="1">{inner}</TiffData>'


@pytest.mark.parametrize("order", ["".join(order) for order in itertools.permutations("CZT")])
def test_planes_of_ome_in_every_order(tmp_path, order):
    path = pages(tmp_path / "a.ome.tif", flat(order[::-1]), ome("XY" + order, "<TiffData/>", channels=2))
    same(t4d.open_frames(path, channel=1), expected(np.uint8))


@pytest.mark.parametrize("file", ["", "a.ome.tif"])
def test_ome_says_where_each_plane_is(tmp_path, file):
    planes = [*itertools.product(range(3), range(5), range(2))]
    np.random.default_rng(4).shuffle(planes)
    said = "".join(placed(t, z, page, c, file, "urn:uuid:1") for page, (t, z, c) in enumerate(planes))
    whole = samples("TZCYX", np.uint8)
    pages(tmp_path / "a.ome.tif", [whole[t, z, c] for t, z, c in planes], ome("XYZCT", said, channels=2))
    same(t4d.open_frames(tmp_path / "a.ome.tif", channel=1), expected(np.uint8))


def test_an_image_in_several_files(tmp_path):
    """One file for each time, of which each has the description of all, and one that is missing."""
    data = samples("TZYX", np.uint8)
    names = [f"a_{t}.ome.tif" for t in range(3)]
    uuids = [f"urn:uuid:0000000{t}-0000-0000-0000-000000000000" for t in range(3)]
    said = "".join(placed(t, z, z, file=names[t], uuid=uuids[t]) for t in range(3) for z in range(5))
    for planes, name, uuid in zip(data, names, uuids):
        pages(tmp_path / name, planes, ome("XYZCT", said, uuid=uuid))
    same(t4d.open_frames(tmp_path / names[0]), data.transpose(0, 3, 2, 1))
    frames = t4d.open_frames([tmp_path / name for name in names])
    same(frames, data.transpose(0, 3, 2, 1))
    assert frames.times == [0, 2, 4] and frames.unsized == "z"
    (tmp_path / names[1]).unlink()
    assert "15 planes, but 10 are there" in refused(tmp_path / names[0])


def test_bioio_reads_the_same(tmp_path):
    bioio = pytest.importorskip("bioio")
    pytest.importorskip("bioio_ome_tiff")
    tifffile.imwrite(
        tmp_path / "a.ome.tif", samples("TCZYX"), photometric="minisblack",
        metadata={"axes": "TCZYX", "PhysicalSizeX": 0.25, "PhysicalSizeY": 0.5, "PhysicalSizeZ": 0.75,
                  "Channel": {"Name": ["DNA", "membrane"]}},
    )  # fmt: skip
    image = bioio.BioImage(tmp_path / "a.ome.tif")
    frames = t4d.open_frames(tmp_path / "a.ome.tif", channel="membrane")
    same(frames, [image.get_image_data("XYZ", T=t, C=1) for t in range(3)])
    sizes = image.physical_pixel_sizes
    assert np.allclose(np.diag(frames.affine)[:3], (sizes.X, sizes.Y, sizes.Z))
    assert image.channel_names[1] == "membrane"


def test_white_is_zero_is_inverted(tmp_path):
    data = samples("TZYX", np.uint8)
    tifffile.imwrite(tmp_path / "a.tif", 255 - data, photometric="miniswhite", metadata={"axes": "TZYX"})
    frames = t4d.open_frames(tmp_path / "a.tif")
    same(frames, data.transpose(0, 3, 2, 1))
    assert any("MINISWHITE" in note for note in frames.notes)
    pillow = pytest.importorskip("PIL.Image")
    with pillow.open(tmp_path / "a.tif") as image:  # of 8 bits, Pillow inverts, too
        assert np.array_equal(np.asarray(image.convert("L")).T, frames.frame(0)[:, :, 0])


@pytest.mark.parametrize("orientation", range(1, 9))
def test_the_orientation_turns_pages(tmp_path, orientation):
    ops = pytest.importorskip("PIL.ImageOps")
    pillow = pytest.importorskip("PIL.Image")
    tifffile.imwrite(tmp_path / "a.tif", samples("TZYX", np.uint8), photometric="minisblack", metadata={"axes": "TZYX"},
                     compression="zlib", extratags=[(274, 3, 1, orientation, False)])  # fmt: skip
    frames = t4d.open_frames(tmp_path / "a.tif")
    with pillow.open(tmp_path / "a.tif") as image:
        for page in range(15):
            image.seek(page)
            turned = np.asarray(ops.exif_transpose(image))
            if turned.shape == np.asarray(image).shape and orientation > 4:
                image.getexif()[274] = orientation
                turned = np.asarray(ops.exif_transpose(image.copy()))
            if page == 0:
                assert np.array_equal(frames.frame(0)[:, :, 0], turned.T)
    assert frames.size[:2] == ((18, 21) if orientation > 4 else (21, 18))


def test_pages_without_a_description(tmp_path):
    names = [tmp_path / f"s{t}.tif" for t in (1, 2, 10)]
    for name, frame in zip(names, samples("TZYX")):
        tifffile.imwrite(name, frame, photometric="minisblack", metadata=None)
    frames = t4d.open_frames(names)
    same(frames, samples("TXYZ"))
    assert frames.assumed_axes == ["zyx"] and frames.affine is None and frames.unsized == "xyz"
    same(t4d.open_frames(tmp_path), samples("TXYZ"))  # the folder, by the numbers in its names
    assert "has one frame only" in refused(names[0])
    movie = t4d.open_frames(names[0], axes="tyx")
    assert len(movie) == 5 and movie.size == (21, 18, 1)
    assert "does not say how its 5 pages" in refused(names[0], axes="tzyx")
    tifffile.imwrite(tmp_path / "five.tif", np.zeros((2, 3, 4, 18, 21), np.uint8), photometric="minisblack")
    assert "does not say how its" in refused(tmp_path / "five.tif")


WRONG = {
    "more slices": (imagej(6, 3), "18 planes, but 15 are there"),
    "fewer frames": (imagej(5, 2), "10 planes, but 15 are there"),
    "slices below 0": (imagej(-5, 3), ""),
    "too many frames": (imagej(5, 10**20), ""),
    "another shape": ('{"shape": [3, 6, 18, 21]}', ""),
    "a negative shape": ('{"shape": [3, -5, 18, 21]}', ""),
    "one plane of 15": (ome("XYZCT", placed(0, 0, 0)), "15 planes, but 1 are there"),
    "a page behind the last": (ome("XYZCT", '<TiffData IFD="15"/>'), ""),
    "a time behind the last": (ome("XYZCT", '<TiffData IFD="0" FirstT="3"/>'), ""),
    "planes that are placed twice": (ome("XYZCT", '<TiffData IFD="0" PlaneCount="15"/>' + placed(0, 0, 5)), ""),
    "files that are missing": (ome("XYZCT", placed(0, 0, 0, file="a") + placed(0, 1, 1, file="b")), "planes, but"),
    "more times": (ome("XYZCT", "<TiffData/>", times=4), "20 planes, but 15 are there"),
    "far more times": (ome("XYZCT", "<TiffData/>", times=2_000_000), ""),
    "half of a description": (ome("XYZCT", "<TiffData/>")[:300], ""),
    "nothing": ("<OME></OME>", ""),
}  # fmt: skip


@pytest.mark.parametrize("description, reason", WRONG.values(), ids=WRONG)
def test_descriptions_that_pages_contradict_are_refused(tmp_path, description, reason):
    said = refused(pages(tmp_path / "a.ome.tif", flat("TZ"), description))
    assert "a.ome.tif" in said and reason in said


def test_what_is_wrong_is_said(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", samples("TZCYX"), imagej=True, metadata={"axes": "TZCYX"})
    assert "has 2 channels; choose one, 0 to 1" in refused(tmp_path / "a.tif")
    assert "there is no channel 2" in refused(tmp_path / "a.tif", channel=2)
    with pytest.raises(TypeError, match="level is not for TIFF"):
        t4d.open_frames(tmp_path / "a.tif", level=1)
    (tmp_path / "b.tif").write_text("no TIFF at all")
    assert str(tmp_path / "b.tif") in refused(tmp_path / "b.tif")
    with pytest.raises(t4d.FileError):
        t4d.open_frames(tmp_path / "none.tif")


@pytest.mark.parametrize("compression", ["lzw", "zlib"])
def test_damage_is_an_error_or_samples(tmp_path, compression):
    path = pages(tmp_path / "a.tif", flat("TZ"), imagej(5, 3), compression=compression)
    whole = path.read_bytes()
    for end in range(0, len(whole), 83):
        path.write_bytes(whole[:end])
        assert "a.tif" in refused(path), end
    random = np.random.default_rng(9)
    for _ in range(100):
        damaged = bytearray(whole)
        for at in random.integers(0, len(whole), 3):
            damaged[at] = random.integers(256)
        path.write_bytes(damaged)
        try:
            for frame in t4d.open_frames(path):
                assert frame.ndim == 3
        except (t4d.Error, MemoryError) as error:
            assert len(str(error)) < 1000

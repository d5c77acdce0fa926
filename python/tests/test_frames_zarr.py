"""Zarr through zarr-python: arrays and images that it and ome-zarr write, against the samples as an array, and
against ome-zarr's own reader."""

import itertools
import json
import os
import pickle
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

zarr = pytest.importorskip("zarr", "3")

import numcodecs  # noqa: E402
import t4d  # noqa: E402
from zarr import codecs  # noqa: E402
from zarr.codecs import numcodecs as others  # noqa: E402

SIZES = (3, 9, 11, 14)  # t, z, y, x
SPACING = (2.0, 0.5, 0.25)  # z, y, x


def solid(dtype="uint16"):
    """No axis can be taken for another, nor turned round."""
    t, z, y, x = np.indices(SIZES)
    values = (3 * x + 5 * y + 7 * z + 11 * t + 1) % 120
    return values > 49 if np.dtype(dtype) == bool else values.astype(dtype)


NOISE = np.random.default_rng(5).integers(0, 200, SIZES).astype("uint8")


def same(frames, array):
    """Compares frames with an array (t, z, y, x)."""
    assert len(frames) == len(array)
    for mine, other in zip(frames, array):
        assert np.array_equal(mine.transpose(2, 1, 0), other, equal_nan=mine.dtype.kind == "f")
    return frames


def refused(path, **options):
    with pytest.raises(t4d.Error) as error:
        for _ in t4d.open_frames(path, **options):
            pass
    return str(error.value)


def stored(path, array, version=3, chunks=(2, 4, 4, 5), **how):
    shutil.rmtree(path, ignore_errors=True)
    made = zarr.create_array(path, shape=array.shape, chunks=chunks, dtype=array.dtype, zarr_format=version, **how)
    made[:] = array
    return path


TYPES = ["bool", "uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float16", "float32",
         "float64", ">u2", ">i4", ">f4", ">f8"]  # fmt: skip


@pytest.mark.parametrize("dtype", TYPES)
def test_all_types(tmp_path, dtype):
    array = solid(dtype)
    wanted = np.dtype("float32" if dtype == "float16" else dtype).newbyteorder("=")
    big = {"serializer": codecs.BytesCodec(endian="big")} if dtype.startswith(">") else {}
    for path in (stored(tmp_path / "2.zarr", array, 2),
                 stored(tmp_path / "3.zarr", array.astype(array.dtype.newbyteorder("=")), **big)):  # fmt: skip
        frames = same(t4d.open_frames(path, axes="tzyx"), array)
        assert frames.dtype == wanted and frames.mask == (dtype == "bool")


BLOSC = list(itertools.product(("blosclz", "lz4", "lz4hc", "zlib", "zstd"), range(3)))
OF_2 = [None, numcodecs.Zlib(), numcodecs.GZip(), numcodecs.Zstd(), numcodecs.LZ4(), numcodecs.BZ2(),
        *(numcodecs.Blosc(cname=name, shuffle=shuffle) for name, shuffle in BLOSC)]  # fmt: skip
OF_3 = [[], [codecs.GzipCodec()], [codecs.ZstdCodec(checksum=True)], [codecs.Crc32cCodec()],
        [codecs.ZstdCodec(), codecs.Crc32cCodec()], [others.LZ4()], [others.Zlib()],
        *([codecs.BloscCodec(cname=name, shuffle=("noshuffle", "shuffle", "bitshuffle")[shuffle])]
          for name, shuffle in BLOSC)]  # fmt: skip


def test_codecs_orders_and_keys_of_version_2(tmp_path):
    for packed, (order, separator) in itertools.product(OF_2, ("C.", "F/")):
        keys = {"name": "v2", "separator": separator}
        path = stored(tmp_path / "a.zarr", solid(), 2, (2, 5, 6, 14), compressors=packed, order=order,
                      chunk_key_encoding=keys)  # fmt: skip
        same(t4d.open_frames(path, axes="tzyx"), solid())
    delta = stored(tmp_path / "a.zarr", solid("uint8"), 2, filters=[numcodecs.Delta("u1")])
    same(t4d.open_frames(delta, axes="tzyx"), solid("uint8"))


def test_codecs_and_keys_of_version_3(tmp_path):
    turned = codecs.TransposeCodec(order=(2, 0, 3, 1))
    for packed in OF_3:
        path = stored(tmp_path / "a.zarr", solid(), 3, (2, 5, 6, 14), compressors=packed, filters=[turned])
        same(t4d.open_frames(path, axes="tzyx"), solid())
    path = stored(tmp_path / "a.zarr", solid(), chunk_key_encoding={"name": "v2", "separator": "."})
    same(t4d.open_frames(path, axes="tzyx"), solid())


def sharded(path, array, place="end", inner=(), index=(codecs.BytesCodec(), codecs.Crc32cCodec())):
    sharding = codecs.ShardingCodec(chunk_shape=(1, 4, 4, 5), codecs=[codecs.BytesCodec(), *inner], index_codecs=index,
                                    index_location=place)  # fmt: skip
    return stored(path, array, 3, (2, 8, 8, 10), serializer=sharding, compressors=None)


@pytest.mark.parametrize("place", ["start", "end"])
@pytest.mark.parametrize("inner", [(), (codecs.BloscCodec(),), (codecs.ZstdCodec(),)], ids=str)
def test_shards(tmp_path, place, inner):
    same(t4d.open_frames(sharded(tmp_path / "a.zarr", solid(), place, inner), axes="tzyx"), solid())


@pytest.mark.parametrize("chunks", [(3, 9, 11, 14), (50, 20, 20, 20), (1, 1, 1, 1)])
def test_chunks_of_many_frames_and_larger_than_the_array(tmp_path, chunks):
    array = solid()[:, :5, 2:6, -4:]
    for version in (2, 3):
        same(t4d.open_frames(stored(tmp_path / "a.zarr", array, version, chunks), axes="tzyx"), array)


def test_any_array_in_any_chunks(tmp_path):
    random = np.random.default_rng(11)
    for number in range(30):
        axes = "".join(random.permutation([*("txyz" if number % 2 else "tcxyz")]))
        array = random.integers(1 << 16, size=random.integers(1, 7, len(axes)), dtype="uint16")
        packed = {2: OF_2, 3: OF_3}[version := int(random.integers(2, 4))]
        path = stored(tmp_path / "a.zarr", array, version, [int(n) for n in random.integers(1, 8, len(axes))],
                      compressors=packed[random.integers(len(packed))])  # fmt: skip
        channel = random.integers(array.shape[axes.index("c")]) if "c" in axes else 0
        wanted = array.take(channel, axes.index("c")) if "c" in axes else array
        order = [axes.replace("c", "").index(axis) for axis in "tzyx"]
        options = {"channel": channel} if "c" in axes else {}
        same(t4d.open_frames(path, axes=axes, **options), wanted.transpose(order))


@pytest.mark.parametrize("axes", ["zyxt", "xyzt", "ztyx", "tcxzy", "ctzyx"])
def test_axes_that_are_named(tmp_path, axes):
    array = solid("float32")
    moved, names = (np.stack([array[::-1], array]), "ctzyx") if "c" in axes else (array, "tzyx")
    moved = moved.transpose([names.index(a) for a in axes])
    path = stored(tmp_path / "in.zarr", moved, chunks=tuple(min(5, n) for n in moved.shape), dimension_names=list(axes))
    options = {"channel": 1} if "c" in axes else {}
    same(t4d.open_frames(path, **options), array)
    same(t4d.open_frames(path, axes=axes, **options), array)
    if "c" in axes:
        assert "2 channels" in refused(path)
        assert "no channel 2" in refused(path, channel=2)


def test_nothing_names_the_axes(tmp_path):
    frames = t4d.open_frames(stored(tmp_path / "a.zarr", solid()))
    assert frames.assumed_axes == ["txyz"] and frames.size == (9, 11, 14)
    five = stored(tmp_path / "b.zarr", solid()[None], chunks=(1, 1, 4, 4, 4))
    assert "do not tell x, y, z, t and c" in refused(five)


FILLS = [("int16", 0, 0), ("int16", 60, 60), ("int16", -1, -1), ("float32", "NaN", np.nan), ("float32", 60.0, 60),
         ("float32", "Infinity", np.inf), ("float32", "-Infinity", -np.inf)]  # fmt: skip


@pytest.mark.parametrize(
    "dtype, fill, expected, version",
    [*((*one, version) for one in FILLS for version in (2, 3)),
     ("float32", None, 0, 2), ("float32", "0x42480000", 50, 3)],
)
def test_missing_chunks_have_the_fill_value_and_are_counted(tmp_path, dtype, fill, expected, version):
    array = solid(dtype)
    path = stored(tmp_path / "a.zarr", array, version, (1, 4, 4, 5), config={"write_empty_chunks": True})
    edit(path / {2: ".zarray", 3: "zarr.json"}[version], put("fill_value", fill))
    (path / {2: "0.1.1.1", 3: "c/0/1/1/1"}[version]).unlink()
    array[0, 4:8, 4:8, 5:10] = expected
    frames = same(t4d.open_frames(path, axes="tzyx"), array)
    assert any("1 of 81 chunks have no file" in note for note in frames.notes)
    if not np.isfinite(expected):
        with pytest.raises(t4d.InvalidInput, match=r"the value at \(5, 4, 4\) is"):
            t4d.weave(frames, iso=49).load()


# Images ------------------------------------------------------------------------------------------


def ome(path, array, version, levels=2, axes="tzyx", whole=None, units=None, scale=True, more=None):
    """An image as OME-NGFF describes it, the second level half as fine."""
    root = zarr.create_group(path, zarr_format=2 if version == "0.4" else 3)
    unit = {"t": "second", **dict.fromkeys("xyz", "micrometer")} if units is None else units
    kinds = {"t": "time", "c": "channel"}
    said = [{"name": a, "type": kinds.get(a, "space"), **({"unit": unit[a]} if a in unit else {})} for a in axes]
    datasets = []
    for level in range(levels):
        step = tuple(2**level if a in "xyz" else 1 for a in axes)
        part = array[tuple(slice(None, None, s) for s in step)]
        names = {} if version == "0.4" else {"dimension_names": list(axes)}
        data = root.create_array(f"scale/{level}", shape=part.shape, dtype=part.dtype,
                                 chunks=tuple(min(5, n) for n in part.shape), **names)  # fmt: skip
        data[:] = part
        lengths = {"t": 0.1, "c": 1, "z": SPACING[0], "y": SPACING[1], "x": SPACING[2]}
        offset = {"t": 3, "c": 0, "z": -7, "y": 5, "x": 11}
        placed = [{"type": "scale", "scale": [lengths[a] * s for a, s in zip(axes, step)]},
                  {"type": "translation", "translation": [offset[a] for a in axes]}]  # fmt: skip
        datasets.append({"path": f"scale/{level}", **({"coordinateTransformations": placed} if scale else {})})
    image = {"axes": said, "datasets": datasets, "name": "brick"}
    image.update({"coordinateTransformations": whole} if whole else {})
    about = {"multiscales": [{**image, "version": version}, *(more or [])],
             "omero": {"channels": [{"label": "DNA"}, {"label": "membrane"}]}}  # fmt: skip
    root.attrs.update(about if version == "0.4" else {"ome": {"version": version, **about}})
    return path


@pytest.mark.parametrize("version", ["0.4", "0.5"])
def test_images_have_their_place(tmp_path, version):
    array = solid()
    path = ome(tmp_path / "in.zarr", array, version)
    frames = same(t4d.open_frames(path), array)
    assert np.allclose(np.diag(frames.affine)[:3], SPACING[::-1]) and np.allclose(frames.affine[:3, 3], (11, 5, -7))
    assert np.allclose(frames.times, [3, 3.1, 3.2])
    assert (frames.length_unit, frames.time_unit, frames.unsized, frames.assumed_axes) == ("um", "s", "", [])
    for level in (1, "1", "scale/1"):
        half = same(t4d.open_frames(path, level=level), array[:, ::2, ::2, ::2])
        assert np.allclose(np.diag(half.affine)[:3], 2 * np.array(SPACING[::-1]))
    named = {"axes": "tzyx"} if version == "0.4" else {}
    same(t4d.open_frames(path / "scale/1", **named), array[:, ::2, ::2, ::2])
    cut = t4d.open_frames(path, region="5:10,4:8,0:8,1:3")
    same(cut, array[1:3, :8, 4:8, 5:10])
    assert np.allclose(cut.affine[:3, 3], (11 + 5 * 0.25, 5 + 4 * 0.5, -7)) and np.allclose(cut.times, [3.1, 3.2])
    assert "no level 2" in refused(path, level=2)


@pytest.mark.parametrize("version", ["0.4", "0.5"])
def test_the_whole_is_moved_after_its_levels(tmp_path, version):
    whole = [{"type": "scale", "scale": [2, 3, 3, 3]}, {"type": "translation", "translation": [1, 10, 20, 30]}]
    frames = t4d.open_frames(ome(tmp_path / "in.zarr", solid(), version, whole=whole))
    assert np.allclose(np.diag(frames.affine)[:3], 3 * np.array(SPACING[::-1]))
    assert np.allclose(frames.affine[:3, 3], (63, 35, -11)) and np.allclose(frames.times, [7, 7.2, 7.4])


def test_the_brick_is_where_it_is(tmp_path):
    """Woven: its middle and its times, in micrometres and seconds."""
    array = np.zeros(SIZES, "uint8")
    for t in range(SIZES[0]):
        array[t, 2:5, 3:8, 2 + t : 10 + t] = 1
        array[t, 5:7, 3:5, 2 + t : 4 + t] = 1
    mesh = t4d.weave(ome(tmp_path / "in.zarr", array, "0.5"), label=1)
    middles = [((np.argwhere(frame == 1).mean(axis=0) * SPACING) + (-7, 5, 11))[::-1] for frame in array]
    assert np.abs(mesh.measure([3, 3.1, 3.2])["centroid"] - middles).max() < 0.05
    assert (mesh.length_unit, mesh.time_unit) == ("um", "s")


def test_channels_have_the_names_of_omero(tmp_path):
    array = solid()
    both = np.stack([array[::-1], array], axis=1)
    path = ome(tmp_path / "in.zarr", both, "0.5", axes="tczyx")
    same(t4d.open_frames(path, channel="membrane"), array)
    assert "(0 DNA, 1 membrane)" in refused(path)


def test_ome_zarr_reads_the_same(tmp_path):
    pytest.importorskip("ome_zarr")
    from ome_zarr.io import parse_url
    from ome_zarr.reader import Reader
    from ome_zarr.writer import write_image, write_labels

    array = solid()
    both = np.stack([array[::-1], array], axis=1)
    path = tmp_path / "in.zarr"
    root = zarr.group(store=parse_url(path, mode="w").store)
    units = {"t": "second", **dict.fromkeys("xyz", "micrometer")}
    scale = dict(zip("tczyx", (0.1, 1, *SPACING)))
    write_image(both, root, axes="tczyx", scale=scale, axes_units=units)
    write_labels(array.astype("uint8"), root, name="cells", axes="tzyx")
    frames = same(t4d.open_frames(path, channel=1), array)
    assert np.allclose(np.diag(frames.affine)[:3], SPACING[::-1]) and np.allclose(frames.times, [0, 0.1, 0.2])
    image = next(iter(Reader(parse_url(path))()))
    levels = len(image.data)
    assert np.array_equal(np.asarray(image.data[1])[2, 1], t4d.open_frames(path, channel=1, level=1).frame(2).T)
    assert f"has {levels} levels" in refused(path, channel=1, level=levels)
    same(t4d.open_frames(path, dataset="labels/cells"), array.astype("uint8"))
    same(t4d.open_frames(path / "labels", dataset="cells"), array.astype("uint8"))


def test_images_by_name_and_groups_without_one(tmp_path):
    other = {"name": "coarse", "axes": [{"name": a} for a in "tzyx"], "datasets": [{"path": "scale/1"}]}
    path = ome(tmp_path / "in.zarr", solid(), "0.5", more=[other])
    assert "of which the first, 'brick', is used" in " ".join(t4d.open_frames(path).notes)
    same(t4d.open_frames(path, dataset="coarse"), solid()[:, ::2, ::2, ::2])
    assert "has nothing named 'none'" in refused(path, dataset="none")
    zarr.create_group(tmp_path / "bare.zarr")
    assert "without an image" in refused(tmp_path / "bare.zarr")
    ome(tmp_path / "bare.zarr" / "0", solid(), "0.5")
    same(t4d.open_frames(tmp_path / "bare.zarr"), solid())


UNITS = [
    ({"x": "um", "y": "µm", "z": "micron"}, (0.25, 0.5, 2)),
    ({"x": "\u03bcm", "y": "\u00b5m", "z": "micrometer"}, (0.25, 0.5, 2)),
    ({"x": "micrometer", "y": "nanometer", "z": "millimeter"}, (0.25, 0.0005, 2000)),
]


@pytest.mark.parametrize("units, sizes", UNITS)
def test_units_of_length_are_one(tmp_path, units, sizes):
    frames = t4d.open_frames(ome(tmp_path / "in.zarr", solid(), "0.5", units={"t": "sec", **units}))
    assert frames.length_unit == "um" and frames.time_unit == "s"
    assert np.allclose(np.diag(frames.affine)[:3], sizes)


def test_no_scale_says_nothing(tmp_path):
    frames = t4d.open_frames(ome(tmp_path / "in.zarr", solid(), "0.5", scale=False))
    assert frames.affine is None and frames.unsized == "xyz" and frames.times is None
    assert (frames.length_unit, frames.time_unit) == ("um", "s")


# What is wrong -----------------------------------------------------------------------------------


def put(*keys_and_value):
    """A function that puts a value at the end of keys."""
    *keys, last, value = keys_and_value

    def change(metadata):
        for key in keys:
            metadata = metadata[key]
        metadata[last] = value

    return change


def edit(file, change):
    metadata = json.loads(file.read_text())
    change(metadata)
    file.write_text(json.dumps(metadata))


@pytest.mark.parametrize("version", ["0.4", "0.5"])
def test_a_key_given_twice_is_an_error(tmp_path, version):
    path = ome(tmp_path / "in.zarr", solid(), version)
    for name in ((".zattrs", "scale/0/.zarray") if version == "0.4" else ("zarr.json", "scale/0/zarr.json")):
        text = (path / name).read_text()
        (path / name).write_text(text.replace("{", '{"zarr_format": 2, "zarr_format": 3, ', 1))
        assert "has the key 'zarr_format' twice" in refused(path)
        assert name in refused(path)
        (path / name).write_text(text)
    same(t4d.open_frames(path), solid())


@pytest.mark.parametrize("version", ["0.4", "0.5"])
def test_images_that_cannot_be_are_refused(tmp_path, version):
    path = ome(tmp_path / "in.zarr", solid(), version)
    file = path / {"0.4": ".zattrs", "0.5": "zarr.json"}[version]
    whole = file.read_text()
    image = (("attributes", "ome") if version == "0.5" else ()) + ("multiscales", 0)
    level, placed = (*image, "datasets", 0), (*image, "datasets", 0, "coordinateTransformations", 0)
    stored(tmp_path / "secret", solid(), 2)
    for change, reason in (
        (put(*level, "path", "../secret"), "must be in the group"),
        (put(*level, "path", str(tmp_path / "secret")), "must be in the group"),
        (put(*level, "path", "scale/../scale/0"), "must be in the group"),
        (put(*level, "path", "none"), "there is no array"),
        (put(*level, "path", 7), "there is no array"),
        (put(*image, "datasets", []), "names no levels"),
        (put(*image, "axes", 1, "name", "depth of field"), "do not tell"),
        (put(*image, "axes", 1, "name", "y"), "do not tell"),
        (put(*image, "axes", 0, "type", "space"), "do not tell"),
        (put(*placed, {"type": "affine"}), "affine"),
        (put(*placed, {"type": "rotation", "rotation": [1]}), "rotation"),
        (put(*placed, "scale", [1, 1, 1]), "cannot be"),
        (put(*placed, "scale", [1, 1, 1, "a"]), "cannot be"),
        (put(*placed, "scale", [0, 1, 1, 1]), "increase"),
        (put(*placed, "scale", [1, 1, 1, 0]), ""),
        (put(*image, "coordinateTransformations", 5), ""),
    ):
        edit(file, change)
        assert reason in refused(path) and "in.zarr" in refused(path), reason
        file.write_text(whole)
    edit(file, put(*image, "axes", 1, "name", "depth of field"))
    same(t4d.open_frames(path, axes="tzyx"), solid())
    with pytest.raises(TypeError, match="series is not for Zarr"):
        t4d.open_frames(path, series=1)


@pytest.mark.parametrize("version", ["0.4", "0.5"])
def test_another_level_that_is_damaged_is_noted(tmp_path, version):
    path = ome(tmp_path / "in.zarr", solid(), version)
    other = path / "scale/1" / {"0.4": ".zarray", "0.5": "zarr.json"}[version]
    edit(other, put("shape", [3, 5, 6]))
    for _ in range(2):
        assert any("levels that cannot be read: scale/1" in note for note in same(t4d.open_frames(path), solid()).notes)
        other.unlink(missing_ok=True)


HUGE = 2**40
CHUNK = ("chunk_grid", "configuration", "chunk_shape")
NOT_ARRAYS = [
    *(("shape", shape) for shape in (
        [3, 9, 11], [3, 9, 11, 0], [HUGE] * 4, [2, HUGE, 11, 14], [2, 600000, 600000, 14], "x", [3, 9, 11, -1],
        [3, 9, 11, 1.5], [2**31 - 1, 1, 1, 1])),
    *((*CHUNK, shape) for shape in ([1, 4, 4, 0], [HUGE, 4, 4, 5], [2**16] * 4, [1, 4, 4, 6])),
    ("chunk_grid", "name", "rectilinear"), ("data_type", "complex64"), ("data_type", {}), ("codecs", []), ("codecs", 5),
    ("codecs", [{"name": "transpose"}]), ("codecs", 1, "name", "jpegxl"), ("codecs", 1, "name", "vlen-utf8"),
    ("codecs", 1, "name", 7), ("node_type", "x"), ("zarr_format", 4), ("fill_value", "0x"), ("fill_value", 256),
    ("fill_value", [1]), ("chunk_key_encoding", 5), ("dimension_names", ["x"]), ("storage_transformers", [{}]),
]  # fmt: skip


@pytest.mark.parametrize("change", NOT_ARRAYS, ids=str)
def test_arrays_that_cannot_be_are_refused(tmp_path, change):
    path = stored(tmp_path / "in.zarr", solid("uint8"), chunks=(1, 4, 4, 5), fill_value=0)
    edit(path / "zarr.json", put(*change))
    said = refused(path, axes="tzyx")
    assert "in.zarr" in said and (change[-1] != "jpegxl" or "jpegxl" in said)


def test_metadata_that_are_cut_or_of_another_kind_are_refused(tmp_path):
    path = stored(tmp_path / "in.zarr", solid(), 2)
    whole = (path / ".zarray").read_text()
    for end in range(0, len(whole.rstrip()) - 1, 7):
        (path / ".zarray").write_text(whole[:end])
        assert "in.zarr" in refused(path, axes="tzyx"), end
    (path / ".zarray").unlink()
    assert "is no Zarr" in refused(path)
    for text in ("[" * 100_000, '{"a":' * 100_000, "{}", "[]", "null", "", '{"zarr_format": 3', "\0\xff"):
        (path / "zarr.json").write_text(text)
        assert "in.zarr" in refused(path), text[:20]
    (tmp_path / "file.zarr").write_text("none")
    assert "is no Zarr" in refused(tmp_path / "file.zarr")
    assert "No such file" in refused(tmp_path / "none.zarr")


def judged(path, array, label):
    """Damaged chunks are an error, or have their samples all the same."""
    try:
        same(t4d.open_frames(path, axes="tzyx"), array)
    except t4d.Error as error:
        assert "in.zarr" in str(error), label


PACKED = {"raw": None, "zstd": codecs.ZstdCodec(), "gzip": codecs.GzipCodec(), "blosc": codecs.BloscCodec(),
          "crc": codecs.Crc32cCodec(), "lz4": others.LZ4(), "zlib": others.Zlib()}  # fmt: skip


@pytest.mark.parametrize("packed", PACKED)
def test_damaged_chunks_are_never_other_samples(tmp_path, packed):
    path = stored(tmp_path / "in.zarr", NOISE, 3, (1, 4, 4, 5), compressors=PACKED[packed])
    chunk = path / "c/1/1/1/1"
    whole = chunk.read_bytes()
    for damaged in (b"", *(whole[:end] for end in range(1, len(whole), 9)), whole[:-1], whole + b"\0", whole + whole,
                    *([bytes(len(whole))] if packed != "raw" else [])):  # fmt: skip
        chunk.write_bytes(damaged)
        judged(path, NOISE, len(damaged))


def test_damaged_shards_are_never_other_samples(tmp_path):
    path = sharded(tmp_path / "in.zarr", NOISE, index=[codecs.BytesCodec()])
    shard = path / "c/0/0/0/0"
    whole = shard.read_bytes()
    size = 16 * 2 * 2 * 2 * 2
    for entry in [(2**64 - 2, 80), (0, 2**63), (len(whole) - 10, 80), (0, 79), (2**62, 2**62)]:
        index = np.frombuffer(whole[-size:], "<u8").copy()
        index[:2] = entry
        shard.write_bytes(whole[:-size] + index.tobytes())
        judged(path, NOISE, entry)
    for end in (0, 1, size - 1):
        shard.write_bytes(whole[:end])
        judged(path, NOISE, end)
    path = sharded(tmp_path / "in.zarr", NOISE)
    whole = bytearray(shard.read_bytes())
    for at in range(len(whole) - size - 4, len(whole), 17):
        shard.write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :])
        assert "checksum" in refused(path, axes="tzyx")


def test_random_damage_is_an_error_or_samples(tmp_path):
    random = np.random.default_rng(3)
    for version in ("0.4", "0.5"):
        path = ome(tmp_path / f"{version}.zarr", solid(), version)
        files = sorted(f for f in path.rglob("*") if f.is_file())
        for _ in range(40):
            file = files[random.integers(len(files))]
            whole = file.read_bytes()
            damaged = bytearray(whole)
            for at in random.integers(0, len(whole), 4):
                damaged[at] = random.integers(256)
            file.write_bytes(damaged)
            try:
                for frame in t4d.open_frames(path):
                    assert frame.ndim == 3
            except t4d.Error as error:
                assert len(str(error)) < 1000
            file.write_bytes(whole)


def within(seconds, path, *words):
    """The exit code and what is said of the command, which may take these seconds and 4 GB."""
    done = subprocess.run(
        [sys.executable, "-m", "t4d", "weave", path, "--iso", "49", "-o", path.parent / "no.t4d", *words],
        capture_output=True, text=True, timeout=seconds,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (1 << 32, 1 << 32)),
    )  # fmt: skip
    assert not (path.parent / "no.t4d").exists()
    return done.returncode, done.stderr


@pytest.mark.parametrize("name", ["c/1/1/1/1", "zarr.json"])
@pytest.mark.parametrize("kind", ["pipe", "loop", "zeros"])
def test_what_is_no_file_is_refused(tmp_path, name, kind):
    path = stored(tmp_path / "in.zarr", solid(), chunks=(1, 4, 4, 5), config={"write_empty_chunks": True})
    (path / name).unlink()
    if kind == "pipe":
        os.mkfifo(path / name)
    else:
        (path / name).symlink_to("/dev/zero" if kind == "zeros" else path / name)
    code, said = within(10, path, "--axes", "tzyx")
    assert code == 4 and "in.zarr" in said and said.count("\n") == 1, said


def test_far_more_chunks_than_files_are_refused(tmp_path):
    path = stored(tmp_path / "in.zarr", solid("uint8")[:, :2, :2, :2], chunks=(1, 1, 1, 1))
    edit(path / "zarr.json", put("shape", [2, 300, 300, 300]))
    code, said = within(10, path, "--axes", "tzyx")
    assert code == 4 and "chunks" in said, said


def test_only_a_region_must_fit_into_memory(tmp_path):
    path = stored(tmp_path / "huge.zarr", solid(), chunks=(1, 4, 4, 5))
    edit(path / "zarr.json", put("shape", [3, 2**17, 2**17, 2**17]))
    same(t4d.open_frames(path, axes="tzyx", region="5:10,4:8,0:8,1:3"), solid()[1:3, :8, 4:8, 5:10])
    assert "memory" in refused(path, axes="tzyx")


# Over the web and in other stores ----------------------------------------------------------------


@pytest.fixture
def server(tmp_path):
    """The URL of tests/web_server.py, behind which is a fault and then a file of the folder."""
    pytest.importorskip("aiohttp")
    script = Path(__file__).parents[2] / "tests" / "web_server.py"
    with subprocess.Popen([sys.executable, script, tmp_path], stdout=subprocess.PIPE) as process:
        yield f"http://127.0.0.1:{int(process.stdout.readline())}"
        process.kill()


def requests(folder, part):
    every = [json.loads(line) for line in (folder / "requests.jsonl").read_text().splitlines()]
    return [one for one in every if part in one["path"]]


@pytest.mark.parametrize("version", ["0.4", "0.5"])
def test_images_over_the_web(tmp_path, server, version):
    array = solid()
    path = ome(tmp_path / "in.zarr", array, version)
    for url in ("plain/in.zarr", "plain/in.zarr/", "redirect/in.zarr"):
        assert np.allclose(same(t4d.open_frames(f"{server}/{url}"), array).times, [3, 3.1, 3.2])
    named = {"axes": "tzyx"} if version == "0.4" else {}
    same(t4d.open_frames(f"{server}/plain/in.zarr/scale/1", **named), array[:, ::2, ::2, ::2])
    same(t4d.open_frames(server.replace("//", "//user:secret@") + "/login/in.zarr"), array)
    chunk, part = {"0.4": ("scale/0/0.0.1.0", "0.0.1.0"), "0.5": ("scale/0/c/0/0/1/0", "c")}[version]
    for status in (403, 500):
        said = refused(f"{server}/status-{status}@{part}/in.zarr")
        assert str(status) in said and f"/{part}" in said
    (path / chunk).unlink()
    array[:3, :5, 5:10, :5] = 0
    same(t4d.open_frames(f"{server}/plain/in.zarr"), array)
    for url in ("plain/none", "status-401", "status-404", "redirect-for-ever", "dropped", "zipped"):
        said = refused(server.replace("//", "//user:secret@") + f"/{url}/in.zarr")
        assert "in.zarr" in said and "secret" not in said


def test_over_the_web_only_chunks_of_the_region_are_requested(tmp_path, server):
    stored(tmp_path / "in.zarr", solid(), chunks=(1, 4, 4, 5))
    cut = t4d.open_frames(f"{server}/plain/in.zarr", axes="tzyx", region="5:10,4:8,0:8,1:3")
    same(cut, solid()[1:3, :8, 4:8, 5:10])
    chunks = sorted({one["path"] for one in requests(tmp_path, "/c/")})
    assert chunks == [f"/plain/in.zarr/c/{t}/{z}/1/1" for t in (1, 2) for z in (0, 1)]


@pytest.mark.parametrize("place", ["start", "end"])
def test_of_shards_over_the_web_ranges_are_requested(tmp_path, server, place):
    sharded(tmp_path / "in.zarr", solid(), place)
    same(t4d.open_frames(f"{server}/plain/in.zarr", axes="tzyx"), solid())
    asked = requests(tmp_path, "/c/")
    shards = {one["path"] for one in asked}
    assert all(one["range"] for one in asked) and len(asked) >= 2 * len(shards)  # an index and chunks


def test_other_stores_of_fsspec(tmp_path):
    fsspec = pytest.importorskip("fsspec")
    path = stored(tmp_path / "in.zarr", solid(), 3)
    memory = fsspec.filesystem("memory")
    for file in Path(path).rglob("*"):
        if file.is_file():
            memory.pipe(f"/store/in.zarr/{file.relative_to(path)}", file.read_bytes())
    same(t4d.open_frames("memory://store/in.zarr", axes="tzyx"), solid())
    shutil.make_archive(str(tmp_path / "in.zarr"), "zip", path)
    same(t4d.open_frames(tmp_path / "in.zarr.zip", axes="tzyx"), solid())


def test_arrays_and_groups_that_are_open(tmp_path):
    array = solid()
    path = ome(tmp_path / "in.zarr", array, "0.5")
    group = zarr.open(path, mode="r")
    assert np.allclose(same(t4d.open_frames(group), array).times, [3, 3.1, 3.2])
    same(t4d.open_frames(group["scale/1"]), array[:, ::2, ::2, ::2])


def test_arrays_of_xarray_have_coordinates(tmp_path):
    xarray = pytest.importorskip("xarray")
    array = xarray.DataArray(
        solid("float32"), dims=("time", "z", "y", "x"), name="density",
        coords={"time": ("time", [0.0, 2.0, 5.0], {"units": "minutes"}),
                "x": ("x", 10 + 0.5 * np.arange(14), {"units": "mm"})},
    )  # fmt: skip
    for version in (2, 3):
        path = tmp_path / f"{version}.zarr"
        array.to_zarr(path, zarr_format=version)
        frames = same(t4d.open_frames(path), solid("float32"))
        assert frames.times == [0, 2, 5] and (frames.time_unit, frames.length_unit) == ("min", "mm")
        assert frames.affine[0].tolist() == [0.5, 0, 0, 10] and frames.unsized == "yz"


def test_chunks_run_no_code(tmp_path):
    """numcodecs before 0.15.2 unpickles what a filter of a file says."""
    (tmp_path / "in.zarr").mkdir()
    told = {"zarr_format": 2, "shape": [2, 3, 3, 3], "chunks": [2, 3, 3, 3], "dtype": "|u1", "compressor": None,
            "fill_value": 0, "order": "C", "filters": [{"id": "pickle"}]}  # fmt: skip
    (tmp_path / "in.zarr/.zarray").write_text(json.dumps(told))
    (tmp_path / "in.zarr/0.0.0.0").write_bytes(pickle.dumps(Touch(tmp_path / "touched")))
    assert "pickle" in refused(tmp_path / "in.zarr")
    assert not (tmp_path / "touched").exists()


class Touch:
    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)

"""Zarr through zarr-python: arrays and images that it and ome-zarr write, against the samples as an array, and
against ome-zarr's own reader."""

import functools
import http.server
import json
import shutil
import threading
from pathlib import Path

import numpy as np
import pytest

zarr = pytest.importorskip("zarr", "3")

import t4d  # noqa: E402

SIZES = (3, 9, 11, 14)  # t, z, y, x
SPACING = (2.0, 0.5, 0.25)  # z, y, x


def solid(dtype="uint16"):
    """No axis can be taken for another, nor turned round."""
    t, z, y, x = np.indices(SIZES)
    values = (3 * x + 5 * y + 7 * z + 11 * t + 1) % 120
    return values > 49 if np.dtype(dtype) == bool else values.astype(dtype)


def same(frames, array):
    """As (t, z, y, x)."""
    assert len(frames) == len(array)
    for mine, other in zip(frames, array):
        assert np.array_equal(mine.transpose(2, 1, 0), other)
    return frames


def refused(path, **options):
    with pytest.raises(t4d.Error) as error:
        for _ in t4d.open_frames(path, **options):
            pass
    return str(error.value)


def stored(path, array, version=3, chunks=(2, 4, 4, 5), **how):
    made = zarr.create_array(path, shape=array.shape, chunks=chunks, dtype=array.dtype, zarr_format=version, **how)
    made[:] = array
    return path


TYPES = ["bool", "uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float32", "float64"]


@pytest.mark.parametrize("dtype", [*TYPES, ">u2", ">f4"])
def test_all_types(tmp_path, dtype):
    array = solid(dtype)
    frames = same(t4d.open_frames(stored(tmp_path / "2.zarr", array, 2), axes="tzyx"), array)
    assert frames.dtype == array.dtype.newbyteorder("=") and frames.mask == (dtype == "bool")
    if not dtype.startswith(">"):
        same(t4d.open_frames(stored(tmp_path / "3.zarr", array), axes="tzyx"), array)


def test_floats_of_16_bits_are_read_as_32(tmp_path):
    frames = t4d.open_frames(stored(tmp_path / "a.zarr", solid("float16")), axes="tzyx")
    assert same(frames, solid("float32")).dtype == np.float32


def test_codecs_and_shards(tmp_path):
    import numcodecs
    from zarr import codecs

    array = solid()
    for i, packed in enumerate([None, numcodecs.Zlib(), numcodecs.LZ4(), numcodecs.Blosc(cname="lz4hc", shuffle=2)]):
        path = stored(tmp_path / f"{i}.zarr", array, 2, compressors=packed, order="F")
        same(t4d.open_frames(path, axes="tzyx"), array)
    for i, packed in enumerate([[], [codecs.ZstdCodec(checksum=True), codecs.Crc32cCodec()], [codecs.BloscCodec()]]):
        path = stored(tmp_path / f"3{i}.zarr", array, compressors=packed, shards=(2, 8, 8, 10))
        same(t4d.open_frames(path, axes="tzyx"), array)


@pytest.mark.parametrize("axes", ["zyxt", "xyzt", "ztyx", "tcxzy", "ctzyx"])
def test_axes_in_any_order(tmp_path, axes):
    array = solid("float32")
    moved, names = array, "tzyx"
    if "c" in axes:
        moved, names = np.stack([array[::-1], array]), "ctzyx"
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


def test_missing_chunks_have_the_fill_value_and_are_counted(tmp_path):
    array = solid("int16")
    for version, gone in ((2, "0.1.1.1"), (3, "c/0/1/1/1")):
        path = stored(tmp_path / f"{version}.zarr", array, version, (1, 4, 4, 5), fill_value=60,
                      config={"write_empty_chunks": True})  # fmt: skip
        (path / gone).unlink()
        expected = array.copy()
        expected[0, 4:8, 4:8, 5:10] = 60
        frames = same(t4d.open_frames(path, axes="tzyx"), expected)
        assert any("1 of 81 chunks have no file" in note for note in frames.notes)


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
    cut = t4d.open_frames(path, region="5:10,4:8,0:8,1:3")
    same(cut, array[1:3, :8, 4:8, 5:10])
    assert np.allclose(cut.affine[:3, 3], (11 + 5 * 0.25, 5 + 4 * 0.5, -7)) and np.allclose(cut.times, [3.1, 3.2])
    assert "no level 2" in refused(path, level=2)


def test_the_whole_is_moved_after_its_levels(tmp_path):
    whole = [{"type": "scale", "scale": [2, 3, 3, 3]}, {"type": "translation", "translation": [1, 10, 20, 30]}]
    frames = t4d.open_frames(ome(tmp_path / "in.zarr", solid(), "0.5", whole=whole))
    assert np.allclose(np.diag(frames.affine)[:3], 3 * np.array(SPACING[::-1]))
    assert np.allclose(frames.affine[:3, 3], (63, 35, -11)) and np.allclose(frames.times, [7, 7.2, 7.4])


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


def changed(path, tmp_path, change):
    copy = tmp_path / "changed.zarr"
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(path, copy)
    metadata = json.loads((copy / "zarr.json").read_text())
    change(metadata["attributes"]["ome"]["multiscales"][0])
    (copy / "zarr.json").write_text(json.dumps(metadata))
    return copy


def test_descriptions_that_cannot_be_are_refused(tmp_path):
    path = ome(tmp_path / "in.zarr", solid(), "0.5")

    def case(change):
        return refused(changed(path, tmp_path, change))

    def transformed(**one):
        return lambda image: image["datasets"][0].update(coordinateTransformations=[one])

    assert "must be in the group" in case(lambda image: image["datasets"][0].update(path="../in.zarr/scale/0"))
    assert "there is no array" in case(lambda image: image["datasets"][0].update(path="scale/9"))
    assert "names no levels" in case(lambda image: image.update(datasets=[]))
    assert "do not tell" in case(lambda image: image["axes"][1].update(name="depth of field"))
    assert "rotation" in case(transformed(type="rotation", rotation=[1]))
    assert "cannot be" in case(transformed(type="scale", scale=[1, 2]))
    gone = changed(path, tmp_path, lambda image: image["datasets"][1].update(path="scale/9"))
    assert any("levels that cannot be read: scale/9" in note for note in t4d.open_frames(gone).notes)
    assert "No such file" in refused(tmp_path / "none.zarr")
    with pytest.raises(TypeError, match="series is not for Zarr"):
        t4d.open_frames(path, series=1)


def test_only_a_region_must_fit_into_memory(tmp_path):
    path = stored(tmp_path / "huge.zarr", solid(), chunks=(1, 4, 4, 5))
    metadata = json.loads((path / "zarr.json").read_text())
    (path / "zarr.json").write_text(json.dumps({**metadata, "shape": [3, 2**12, 2**12, 2**14]}))
    same(t4d.open_frames(path, axes="tzyx", region="5:10,4:8,0:8,1:3"), solid()[1:3, :8, 4:8, 5:10])
    assert "memory" in refused(path, axes="tzyx")


# Over the web ------------------------------------------------------------------------------------


class Server:
    """Python's server for the files of a folder, which keeps the requests."""

    def __init__(self, folder, status=None):
        requests = self.requests = []

        class Handler(http.server.SimpleHTTPRequestHandler):
            def do_GET(self):
                requests.append(self.path)
                if status and status[0] in self.path:
                    self.send_error(status[1])
                    return
                super().do_GET()

            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=folder))
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        self.url = f"http://127.0.0.1:{self.server.server_port}"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.server.shutdown()
        self.server.server_close()


def test_over_the_web_only_chunks_of_the_region_are_requested(tmp_path):
    pytest.importorskip("aiohttp")
    array = solid()
    ome(tmp_path / "4.zarr", array, "0.4")
    ome(tmp_path / "5.zarr", array, "0.5")
    stored(tmp_path / "in.zarr", array, chunks=(1, 4, 4, 5))
    with Server(tmp_path) as server:
        for name in ("4.zarr", "5.zarr"):
            frames = same(t4d.open_frames(f"{server.url}/{name}"), array)
            assert np.allclose(frames.times, [3, 3.1, 3.2])
        cut = t4d.open_frames(f"{server.url}/in.zarr", axes="tzyx", region="5:10,4:8,0:8,1:3")
        same(cut, array[1:3, :8, 4:8, 5:10])
        chunks = sorted({r for r in server.requests if "/in.zarr/c/" in r})
        assert chunks == [f"/in.zarr/c/{t}/{z}/1/1" for t in (1, 2) for z in (0, 1)]
        assert "no Zarr" in refused(server.url + "/none.zarr")
    for status in (403, 500):
        with Server(tmp_path, ("scale/0/c/0/1", status)) as server:
            assert str(status) in refused(server.url + "/5.zarr")


def test_a_password_in_a_url_is_not_shown(tmp_path):
    pytest.importorskip("aiohttp")
    with Server(tmp_path) as server:
        assert "secret" not in refused(server.url.replace("//", "//user:secret@") + "/none.zarr")


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

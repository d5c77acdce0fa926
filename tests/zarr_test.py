"""Zarr as zarr-python and ome-zarr write it, woven by the program, against the same samples as a
NumPy array."""

import functools
import http.server
import json
import os
import shutil
import subprocess
import threading
from pathlib import Path

import numcodecs
import numpy as np
import pytest
import zarr
import zarr.codecs as codecs
from zarr.codecs.numcodecs import LZ4 as Lz4
from zarr.codecs.numcodecs import Zlib

PROGRAM = Path(os.environ["T4D_BUILD"]) / "t4d"
SIZES = (3, 9, 11, 14)  # t, z, y, x
SPACING = (2.0, 0.5, 0.25)  # z, y, x
MIDDLE = np.array([4.2, 5.1, 6.4])  # of the brick in the first frame
HALF = np.array([1.5, 2.5, 4.0])


def solid(dtype="uint8"):
    """A brick that moves along x, brighter by 100 inside, which fades at its faces; no axis can be
    taken for another, nor turned round."""
    t, z, y, x = np.meshgrid(*(np.arange(n) for n in SIZES), indexing="ij")
    depth = np.minimum.reduce(
        [h - abs(a - m) for a, m, h in zip((z, y, x - 0.5 * t), MIDDLE, HALF)])
    corner = (z > 4) & (y > 5)
    values = np.clip(50 + 50 * depth - 30 * corner, 0, 120).round()
    if np.dtype(dtype) == bool:
        return values > 49
    return values.astype(dtype)


def program(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)


def woven(path, tmp_path, *options):
    """The file, and what was said."""
    output = tmp_path / "out.t4d"
    done = program("weave", path, "-o", output, "-q", "--json", "--body", "brick", *options)
    assert done.returncode == 0, done.stderr
    return output, done


def same(path, array, tmp_path, *options, npy_options=()):
    """The array in the store makes the mesh that it makes as .npy."""
    iso = [] if array.dtype == bool else ["--iso", 49]
    np.save(tmp_path / "same.npy", array)
    expected, _ = woven(tmp_path / "same.npy", tmp_path, *iso, "--axes", "tzyx", *npy_options)
    expected = expected.rename(tmp_path / "expected.t4d")
    found, done = woven(path, tmp_path, *iso, *options)
    differing = program("diff", expected, found, "--json")
    assert json.loads(differing.stdout)["level"] == "mesh", differing.stdout + differing.stderr
    return done


def refused(path, tmp_path, *options):
    done = program("weave", path, "--iso", 49, "-o", tmp_path / "no.t4d", *options)
    assert done.returncode == 4, done.stderr
    assert not (tmp_path / "no.t4d").exists()
    return done.stderr


def version2(path, array, chunks=(2, 4, 4, 5), **how):
    store = zarr.create_array(path, shape=array.shape, chunks=chunks, dtype=array.dtype,
                              zarr_format=2, **how)
    store[:] = array
    return path


def version3(path, array, chunks=(1, 4, 4, 5), **how):
    store = zarr.create_array(path, shape=array.shape, chunks=chunks, dtype=array.dtype,
                              zarr_format=3, **how)
    store[:] = array
    return path


PLAIN = ("--axes", "tzyx")

TYPES = ["bool", "uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64",
         "float32", "float64", ">u2", ">i4", ">f4", ">f8"]


@pytest.mark.parametrize("dtype", TYPES)
def test_all_types(tmp_path, dtype):
    array = solid(dtype)
    plain = array.astype(array.dtype.newbyteorder("="))
    same(version2(tmp_path / "2.zarr", array), plain, tmp_path, *PLAIN)
    if dtype.startswith(">"):
        serializer = codecs.BytesCodec(endian="big")
        same(version3(tmp_path / "3.zarr", plain, serializer=serializer), plain, tmp_path, *PLAIN)
    else:
        same(version3(tmp_path / "3.zarr", plain), plain, tmp_path, *PLAIN)


def test_floats_of_16_bits(tmp_path):
    array = solid("float32")
    for write in (version2, version3):
        path = write(tmp_path / f"{write.__name__}.zarr", array.astype("float16"))
        same(path, array, tmp_path, *PLAIN)


BLOSC = [(name, shuffle) for name in ("blosclz", "lz4", "lz4hc", "zlib", "zstd")
         for shuffle in (0, 1, 2)]
PACKED = [None, numcodecs.Zlib(), numcodecs.GZip(), numcodecs.Zstd(), numcodecs.LZ4(),
          *(numcodecs.Blosc(cname=name, shuffle=shuffle) for name, shuffle in BLOSC)]


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("separator", [".", "/"])
@pytest.mark.parametrize("packed", PACKED, ids=str)
def test_version_2(tmp_path, packed, separator, order):
    array = solid("uint16")
    path = version2(tmp_path / "in.zarr", array, compressors=packed, order=order,
                    chunk_key_encoding={"name": "v2", "separator": separator})
    same(path, array, tmp_path, *PLAIN)


PACKED_3 = [[], [codecs.GzipCodec()], [codecs.ZstdCodec(checksum=True)], [codecs.Crc32cCodec()],
            [codecs.ZstdCodec(), codecs.Crc32cCodec()], [Lz4()], [Zlib()],
            *([codecs.BloscCodec(cname=name, shuffle=("noshuffle", "shuffle", "bitshuffle")[s])]
              for name, s in BLOSC)]


@pytest.mark.parametrize("packed", PACKED_3, ids=str)
def test_version_3(tmp_path, packed):
    array = solid("uint16")
    path = version3(tmp_path / "in.zarr", array, compressors=packed,
                    filters=[codecs.TransposeCodec(order=(2, 0, 3, 1))])
    same(path, array, tmp_path, *PLAIN)
    if not packed:
        other = version3(tmp_path / "keys.zarr", array, compressors=packed,
                         chunk_key_encoding={"name": "v2", "separator": "."})
        same(other, array, tmp_path, *PLAIN)


@pytest.mark.parametrize("place", ["start", "end"])
@pytest.mark.parametrize("packed", [None, codecs.BloscCodec(), codecs.ZstdCodec()], ids=str)
def test_shards(tmp_path, place, packed):
    array = solid("uint16")
    path = tmp_path / "in.zarr"
    inner = [codecs.BytesCodec()] + ([packed] if packed else [])
    sharding = codecs.ShardingCodec(chunk_shape=(1, 4, 4, 5), codecs=inner, index_location=place)
    store = zarr.create_array(path, shape=array.shape, chunks=(2, 8, 8, 10), dtype="uint16",
                              zarr_format=3, serializer=sharding, compressors=None)
    store[:] = array
    same(path, array, tmp_path, *PLAIN)


def test_chunks_of_many_frames_and_larger_than_the_array(tmp_path):
    array = solid()
    for chunks in [(3, 9, 11, 14), (50, 20, 20, 20), (1, 1, 1, 1)]:
        name = "_".join(map(str, chunks))
        same(version2(tmp_path / f"{name}.zarr", array, chunks), array, tmp_path, *PLAIN)


@pytest.mark.parametrize("axes", ["zyxt", "xyzt", "ztyx", "tcxzy", "ctzyx"])
def test_axes_in_any_order(tmp_path, axes):
    """The channel that is not read has noise."""
    array = solid("float32")
    moved = array
    names = "tzyx"
    if "c" in axes:
        noise = np.random.default_rng(1).random(array.shape, "float32")
        moved, names = np.stack([noise, array]), "ctzyx"
    moved = moved.transpose([names.index(a) for a in axes])
    chunks = tuple(min(5, n) for n in moved.shape)
    path = version3(tmp_path / "in.zarr", moved, chunks, dimension_names=list(axes))
    options = ["--channel", 1] if "c" in axes else []
    same(path, array, tmp_path, *options)
    same(path, array, tmp_path, "--axes", axes, *options)
    if "c" in axes:
        assert "2 channels" in refused(path, tmp_path)
        assert "no channel 2" in refused(path, tmp_path, "--channel", 2)


@pytest.mark.parametrize("fill", [0, 60, -1])
def test_missing_chunks_have_the_fill_value(tmp_path, fill):
    array = solid("int16")
    for write in (version2, version3):
        path = write(tmp_path / f"{write.__name__}.zarr", array, (1, 4, 4, 5), fill_value=fill,
                     config={"write_empty_chunks": True})
        gone = path / ("0.1.1.1" if write is version2 else "c/0/1/1/1")
        gone.unlink()
        expected = array.copy()
        expected[0, 4:8, 4:8, 5:10] = fill
        done = same(path, expected, tmp_path, *PLAIN)
        said = program("weave", path, "--iso", 49, *PLAIN, "-o", tmp_path / "said.t4d")
        assert said.returncode == 0
        assert "1 of 81 chunks have no file" in said.stderr, (said.stderr, done.stderr)


@pytest.mark.parametrize("fill", ["NaN", "Infinity", "-Infinity", "0x42480000", 60.0, None])
def test_fill_values_of_floats(tmp_path, fill):
    array = solid("float32")
    path = version2(tmp_path / "2.zarr", array, (1, 4, 4, 5), config={"write_empty_chunks": True})
    metadata = json.loads((path / ".zarray").read_text())
    metadata["fill_value"] = fill
    (path / ".zarray").write_text(json.dumps(metadata))
    (path / "2.0.0.0").unlink()
    if isinstance(fill, str) and fill[0] != "0":
        assert "is not finite" in refused(path, tmp_path, *PLAIN)
    else:
        expected = array.copy()
        expected[2, :4, :4, :5] = {"0x42480000": 50, 60.0: 60, None: 0}[fill]
        same(path, expected, tmp_path, *PLAIN)


def ome(path, array, version, levels=2, axes="tzyx", whole=None, units=True):
    """An image as OME-NGFF describes it, the second level half as fine."""
    root = zarr.create_group(path, zarr_format=2 if version == "0.4" else 3)
    types = {"t": "time", "c": "channel"}
    unit = {"t": "second", **dict.fromkeys("xyz", "micrometer")} if units else {}
    said = [{"name": a, "type": types.get(a, "space"), **({"unit": unit[a]} if a in unit else {})}
            for a in axes]
    datasets = []
    for level in range(levels):
        step = tuple(2**level if a in "xyz" else 1 for a in axes)
        part = array[tuple(slice(None, None, s) for s in step)]
        name = f"scale/{level}"
        data = root.create_array(name, shape=part.shape, dtype=part.dtype,
                                 chunks=tuple(min(5, n) for n in part.shape),
                                 **({"dimension_names": list(axes)} if version != "0.4" else {}))
        data[:] = part
        lengths = {"t": 0.1, "c": 1, "z": SPACING[0], "y": SPACING[1], "x": SPACING[2]}
        offset = {"t": 3, "c": 0, "z": -7, "y": 5, "x": 11}
        datasets.append({"path": name, "coordinateTransformations": [
            {"type": "scale", "scale": [lengths[a] * s for a, s in zip(axes, step)]},
            {"type": "translation", "translation": [offset[a] for a in axes]}]})
    image = {"axes": said, "datasets": datasets, "name": "brick"}
    if whole:
        image["coordinateTransformations"] = whole
    if version == "0.4":
        root.attrs["multiscales"] = [{**image, "version": version}]
    else:
        root.attrs["ome"] = {"version": version, "multiscales": [image]}
    return path


PLACED = ("--spacing", *SPACING[::-1], "--origin", 11, 5, -7, "--frame-time", 0.1, "--start-time", 3,
          "--length-unit", "um", "--time-unit", "s")


@pytest.mark.parametrize("version", ["0.4", "0.5"])
def test_images_have_their_place(tmp_path, version):
    array = solid("uint16")
    path = ome(tmp_path / "in.zarr", array, version)
    same(path, array, tmp_path, npy_options=PLACED)
    half = array[:, ::2, ::2, ::2]
    twice = list(PLACED)
    twice[1:4] = (2 * s for s in SPACING[::-1])
    same(path, half, tmp_path, "--level", 1, npy_options=twice)
    same(path / "scale" / "1", half, tmp_path, *([] if version == "0.5" else PLAIN))
    assert "no level 2" in refused(path, tmp_path, "--level", 2)


@pytest.mark.parametrize("version", ["0.4", "0.5"])
def test_the_whole_is_moved_after_its_levels(tmp_path, version):
    array = solid("uint16")
    whole = [{"type": "scale", "scale": [2, 3, 3, 3]},
             {"type": "translation", "translation": [1, 10, 20, 30]}]
    path = ome(tmp_path / "in.zarr", array, version, whole=whole)
    placed = ("--spacing", *(3 * s for s in SPACING[::-1]), "--origin", 63, 35, -11,
              "--frame-time", 0.2, "--start-time", 7, "--length-unit", "um", "--time-unit", "s")
    same(path, array, tmp_path, npy_options=placed)


def test_the_brick_is_where_it_is(tmp_path):
    """Its middle, its volume and its direction, in micrometres."""
    array = np.zeros(SIZES, "uint8")
    for t in range(SIZES[0]):
        array[t, 2:5, 3:8, 2 + t:10 + t] = 1
        array[t, 5:7, 3:5, 2 + t:4 + t] = 1
    path = ome(tmp_path / "in.zarr", array, "0.5")
    output, _ = woven(path, tmp_path, "--label", 1)
    said = program("measure", output, "--frames", SIZES[0], "--json")
    samples = json.loads(said.stdout)["samples"]
    for t in range(SIZES[0]):
        at = np.argwhere(array[t] == 1).mean(axis=0)
        middle = (at * SPACING + (-7, 5, 11))[::-1]
        assert np.abs(np.array(samples[t]["centroid"]) - middle).max() < 0.05, t
        assert samples[t]["time"] == pytest.approx(3 + 0.1 * t)


def test_what_ome_zarr_writes(tmp_path):
    from ome_zarr.io import parse_url
    from ome_zarr.writer import write_image

    array = solid("uint16")
    both = np.stack([np.zeros_like(array), array], axis=1)
    path = tmp_path / "in.zarr"
    root = zarr.group(store=parse_url(path, mode="w").store)
    units = {"t": "second", **dict.fromkeys("xyz", "micrometer")}
    scale = dict(zip("tczyx", (0.1, 1, *SPACING)))
    write_image(both, root, axes="tczyx", scale=scale, axes_units=units)
    options = ("--spacing", *SPACING[::-1], "--frame-time", 0.1, "--length-unit", "um",
               "--time-unit", "s")  # fmt: skip
    same(path, array, tmp_path, "--channel", 1, npy_options=options)


# Over the web ------------------------------------------------------------------------------------


class Server:
    """Python's server for the files of a folder, which keeps the requests."""

    def __init__(self, folder, status=None):
        requests = self.requests = []

        class Handler(http.server.SimpleHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self):
                requests.append(self.path)
                if status and status[0] in self.path:
                    self.send_error(status[1])
                    return
                super().do_GET()

            def log_message(self, *_):
                pass

        handler = functools.partial(Handler, directory=folder)
        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        self.url = f"http://127.0.0.1:{self.server.server_port}"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.server.shutdown()
        self.server.server_close()


def test_over_the_web(tmp_path):
    array = solid("uint16")
    ome(tmp_path / "4.zarr", array, "0.4")
    ome(tmp_path / "5.zarr", array, "0.5")
    with Server(tmp_path) as server:
        same(f"{server.url}/5.zarr", array, tmp_path, npy_options=PLACED)
        same(f"{server.url}/4.zarr/", array, tmp_path, npy_options=PLACED)
        same(f"{server.url}/5.zarr/scale/0", array, tmp_path)


def test_missing_files_on_the_web(tmp_path):
    array = solid("uint16")
    ome(tmp_path / "5.zarr", array, "0.5")
    (tmp_path / "5.zarr/scale/0/c/0/0/0/0").unlink(missing_ok=True)
    with Server(tmp_path) as server:
        url = server.url.replace("//", "//user:secret@") + "/5.zarr"
        said = program("weave", url, "--iso", 49, "-o", tmp_path / "out.t4d")
        assert said.returncode == 0, said.stderr
        assert "chunks have no file" in said.stderr
        assert "secret" not in said.stderr + said.stdout
        assert b"secret" not in (tmp_path / "out.t4d").read_bytes()
        assert "no Zarr" in refused(server.url + "/none.zarr", tmp_path)
    for status in (403, 500):
        with Server(tmp_path, ("scale/0/c/0/1", status)) as server:
            said = refused(server.url + "/5.zarr", tmp_path)
            assert f"{server.url}/5.zarr/scale/0/c/0/1" in said and str(status) in said


def test_chunks_outside_of_a_region_are_not_requested(tmp_path):
    array = solid("uint16")
    version3(tmp_path / "in.zarr", array, (1, 4, 4, 5))
    version3(tmp_path / "huge.zarr", array, (1, 4, 4, 5))
    region = ("--region", "5:10,4:8,0:8,1:3")
    with Server(tmp_path) as server:
        same(server.url + "/in.zarr", array, tmp_path, *PLAIN, *region, npy_options=region)
        chunks = sorted(r for r in server.requests if "/c/" in r)
        assert chunks == [f"/in.zarr/c/{t}/{z}/1/1" for t in (1, 2) for z in (0, 1)]
    # Only what is read must fit into memory.
    metadata = tmp_path / "huge.zarr" / "zarr.json"
    whole = json.loads(metadata.read_text())
    metadata.write_text(json.dumps({**whole, "shape": [3, 2**17, 2**17, 2**17]}))
    same(tmp_path / "huge.zarr", array, tmp_path, *PLAIN, *region, npy_options=region)
    assert "memory" in refused(tmp_path / "huge.zarr", tmp_path, *PLAIN)


def test_shards_on_the_web(tmp_path):
    """Also from a server that sends files only as a whole."""
    array = solid("uint16")
    version3(tmp_path / "in.zarr", array, (1, 4, 4, 5), shards=(2, 8, 8, 10))
    with Server(tmp_path) as server:
        same(server.url + "/in.zarr", array, tmp_path, *PLAIN)
    served = Path(__file__).parent / "web_server.py"
    with subprocess.Popen(["python3", served, tmp_path], stdout=subprocess.PIPE) as ranges:
        try:
            port = int(ranges.stdout.readline())
            url = f"http://127.0.0.1:{port}/plain/in.zarr"
            same(url, array, tmp_path, *PLAIN)
            asked = [json.loads(line) for line in (tmp_path / "requests.jsonl").open()]
            shards = [r for r in asked if "/c/" in r["path"]]
            assert all(r["range"] for r in shards) and len(shards) > 2 * 3 * 3 * 3
        finally:
            ranges.kill()


# Bad input ---------------------------------------------------------------------------------------


def changed(path, tmp_path, change, file="zarr.json"):
    """A copy with changed metadata."""
    copy = tmp_path / "changed.zarr"
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(path, copy)
    metadata = json.loads((copy / file).read_text())
    change(metadata)
    (copy / file).write_text(json.dumps(metadata))
    return copy


def put(*keys_and_value):
    *keys, last, value = keys_and_value

    def change(metadata):
        for key in keys:
            metadata = metadata[key]
        metadata[last] = value

    return change


def test_unknown_codecs_are_named(tmp_path):
    array = solid()
    path = version3(tmp_path / "3.zarr", array)
    for name in ("jpegxl", "vlen-utf8", 7):
        said = refused(changed(path, tmp_path, put("codecs", 1, "name", name)), tmp_path, *PLAIN)
        assert str(name) in said and "blosc, crc32c, gzip, lz4, zlib, zstd" in said
    path = version2(tmp_path / "2.zarr", array, compressors=numcodecs.BZ2())
    assert "bz2" in refused(path, tmp_path, *PLAIN)
    path = version2(tmp_path / "delta.zarr", array, filters=[numcodecs.Delta("u1")])
    assert "delta" in refused(path, tmp_path, *PLAIN)


HUGE = 2**40
ARRAY_DAMAGE = [
    put("shape", [3, 9, 11]), put("shape", [3, 9, 11, 0]), put("shape", [HUGE] * 4),
    put("shape", [2, HUGE, 11, 14]), put("shape", [2, 60000, 60000, 14]), put("shape", "x"),
    put("shape", [3, 9, 11, -1]), put("shape", [3, 9, 11, 1.5]), put("shape", [2**31 - 1, 1, 1, 1]),
    put("chunk_grid", "configuration", "chunk_shape", [1, 4, 4, 0]),
    put("chunk_grid", "configuration", "chunk_shape", [HUGE, 4, 4, 5]),
    put("chunk_grid", "configuration", "chunk_shape", [2**16] * 4),
    put("chunk_grid", "configuration", "chunk_shape", [1, 4, 4, 6]),
    put("chunk_grid", "name", "rectilinear"), put("data_type", "complex64"), put("data_type", {}),
    put("codecs", []), put("codecs", 5), put("codecs", [{"name": "transpose"}]), put("node_type", "x"),
    put("zarr_format", 4), put("fill_value", "0x"), put("fill_value", 256), put("fill_value", [1]),
    put("chunk_key_encoding", 5), put("dimension_names", ["x"]), put("storage_transformers", [{}]),
]  # fmt: skip


@pytest.mark.parametrize("change", ARRAY_DAMAGE)
def test_damaged_arrays_are_refused(tmp_path, change):
    path = version3(tmp_path / "3.zarr", solid(), fill_value=0)
    said = refused(changed(path, tmp_path, change), tmp_path, *PLAIN)
    assert "changed.zarr" in said


@pytest.mark.parametrize("version", ["0.4", "0.5"])
def test_damaged_images_are_refused(tmp_path, version):
    path = ome(tmp_path / "in.zarr", solid(), version)
    at = ("attributes", "ome", "multiscales", 0) if version == "0.5" else ("multiscales", 0)
    file = "zarr.json" if version == "0.5" else ".zattrs"
    (tmp_path / "secret").mkdir()
    version2(tmp_path / "secret" / "array", solid())
    cases = [
        (put(*at, "datasets", 0, "path", "../secret/array"), "in the group"),
        (put(*at, "datasets", 0, "path", str(tmp_path / "secret/array")), "in the group"),
        (put(*at, "datasets", 0, "path", "scale/../scale/0"), "in the group"),
        (put(*at, "datasets", 0, "path", "none"), "no array"),
        (put(*at, "datasets", 0, "path", 7), "in the group"),
        (put(*at, "datasets", []), "no levels"),
        (put(*at, "datasets", [{"path": "scale/0"}] * 1000), "too many"),
        (put(*at, "axes", 1, "name", "depth"), "--axes"),
        (put(*at, "axes", 1, "name", "y"), "--axes"),
        (put(*at, "axes", 0, "type", "space"), "--axes"),
        (put(*at, "axes", 1, "unit", "millimeter"), "unit of length"),
        (put(*at, "datasets", 0, "coordinateTransformations", 0, "scale", [1, 1, 1]), "scale"),
        (put(*at, "datasets", 0, "coordinateTransformations", 0, "scale", [1, 1, 1, 0]), "volume"),
        (put(*at, "datasets", 0, "coordinateTransformations", 0, "scale", [0, 1, 1, 1]), "apart"),
        (put(*at, "datasets", 0, "coordinateTransformations", 0, "scale", [1, 1, 1, "a"]), "scale"),
        (put(*at, "datasets", 0, "coordinateTransformations", 0, {"type": "affine"}), "affine"),
        (put(*at, "coordinateTransformations", 5), "coordinateTransformations"),
    ]
    for change, reason in cases:
        assert reason in refused(changed(path, tmp_path, change, file), tmp_path), reason
    given = changed(path, tmp_path, put(*at, "axes", 1, "name", "depth"), file)
    same(given, solid(), tmp_path, *PLAIN, npy_options=PLACED)


def test_levels_that_differ_are_refused(tmp_path):
    path = ome(tmp_path / "in.zarr", solid(), "0.5")
    other = path / "scale/1/zarr.json"
    metadata = json.loads(other.read_text())
    for shape, reason in [([2, 5, 6, 7], "2 frames"), ([3, 5, 6], "dimension_names")]:
        other.write_text(json.dumps({**metadata, "shape": shape}))
        if len(shape) == 4:
            assert reason in refused(path, tmp_path)
    other.unlink()
    said = program("weave", path, "--iso", 49, "-o", tmp_path / "out.t4d")
    assert said.returncode == 0 and "scale/1" in said.stderr


def test_damaged_chunks_are_refused(tmp_path):
    array = np.random.default_rng(5).integers(0, 200, SIZES).astype("uint8")
    packed = {"zstd": codecs.ZstdCodec(), "gzip": codecs.GzipCodec(), "blosc": codecs.BloscCodec(),
              "crc": codecs.Crc32cCodec()}
    for name, codec in packed.items():
        path = version3(tmp_path / f"{name}.zarr", array, compressors=[codec])
        chunk = path / "c/1/1/1/1"
        whole = chunk.read_bytes()
        for damaged in (b"", whole[: len(whole) // 2], whole[:-1], bytes(len(whole)), whole + whole):
            chunk.write_bytes(damaged)
            said = refused(path, tmp_path, *PLAIN)
            assert "c/1/1/1/1" in said, (name, len(damaged))
        chunk.write_bytes(whole)
    path = version3(tmp_path / "raw.zarr", array, compressors=None)
    for size in (79, 81):
        (path / "c/1/1/1/1").write_bytes(bytes(size))
        assert "c/1/1/1/1" in refused(path, tmp_path, *PLAIN)


def test_damaged_shards_are_refused(tmp_path):
    array = np.random.default_rng(5).integers(0, 200, SIZES).astype("uint8")
    path = tmp_path / "in.zarr"
    sharding = codecs.ShardingCodec(chunk_shape=(1, 4, 4, 5), index_codecs=[codecs.BytesCodec()],
                                    codecs=[codecs.BytesCodec()])
    store = zarr.create_array(path, shape=array.shape, chunks=(2, 8, 8, 10), dtype="uint8",
                              serializer=sharding, compressors=None)
    store[:] = array
    shard = path / "c/0/0/0/0"
    whole = shard.read_bytes()
    size = 16 * 2 * 2 * 2 * 2
    for entry in [(2**64 - 2, 80), (0, 2**63), (len(whole), 80), (len(whole) - 10, 80), (0, 79),
                  (0, 0), (2**62, 2**62)]:
        index = np.frombuffer(whole[-size:], "<u8").copy()
        index[:2] = entry
        shard.write_bytes(whole[:-size] + index.tobytes())
        assert "c/0/0/0/0" in refused(path, tmp_path, *PLAIN), entry
    for cut in (0, 1, size - 1):
        shard.write_bytes(whole[:cut])
        assert "c/0/0/0/0" in refused(path, tmp_path, *PLAIN)
    checked = version3(tmp_path / "checked.zarr", array, (1, 4, 4, 5), shards=(2, 8, 8, 10))
    shard = checked / "c/0/0/0/0"
    whole = bytearray(shard.read_bytes())
    whole[-40] ^= 1
    shard.write_bytes(whole)
    assert "checksum" in refused(checked, tmp_path, *PLAIN)


def test_odd_files_are_refused(tmp_path):
    array = solid()
    path = version3(tmp_path / "in.zarr", array, config={"write_empty_chunks": True})
    outside = tmp_path / "outside"
    outside.write_bytes((path / "c/1/1/1/1").read_bytes())
    for place in (path / "c/1/1/1/1", path / "zarr.json"):
        content = place.read_bytes()
        for make in (os.mkfifo, os.mkdir, lambda p: p.symlink_to(outside),
                     lambda p: p.symlink_to(p), lambda p: p.symlink_to("/dev/zero")):
            place.unlink()
            make(place)
            assert "in.zarr" in refused(path, tmp_path, *PLAIN)
            place.rmdir() if place.is_dir() and not place.is_symlink() else place.unlink()
            place.write_bytes(content)
    (tmp_path / "file.zarr").write_text("none")
    assert "not a folder" in refused(tmp_path / "file.zarr", tmp_path)
    assert "no such" in refused(tmp_path / "none.zarr", tmp_path)
    (tmp_path / "empty.zarr").mkdir()
    assert "no Zarr" in refused(tmp_path / "empty.zarr", tmp_path)


def test_bombs_of_json_are_refused(tmp_path):
    path = tmp_path / "in.zarr"
    path.mkdir()
    for text in ("[" * 100_000, '{"a":' * 100_000, "{}", "[]", "null", "", '{"zarr_format": 3',
                 '{"a": "' + "x" * 5_000_000 + '"}', "\0\xff"):
        (path / "zarr.json").write_text(text)
        assert "zarr.json" in refused(path, tmp_path)


def test_groups_say_what_to_name(tmp_path):
    path = tmp_path / "in.zarr"
    zarr.create_group(path).create_array("image", shape=(2, 3, 3, 3), dtype="u1")
    assert "without an image" in refused(path, tmp_path)


def test_random_damage_never_crashes(tmp_path):
    random = np.random.default_rng(3)
    for packed in (codecs.BloscCodec(cname="zstd"), codecs.BloscCodec(cname="lz4"),
                   codecs.ZstdCodec(), codecs.GzipCodec()):  # fmt: skip
        path = ome(tmp_path / f"{type(packed).__name__}{random.integers(1 << 30)}.zarr", solid(), "0.5")
        files = [f for f in path.rglob("*") if f.is_file()]
        for _ in range(25):
            file = files[random.integers(len(files))]
            whole = file.read_bytes()
            damaged = bytearray(whole)
            for at in random.integers(0, len(whole), 4):
                damaged[at] = random.integers(256)
            file.write_bytes(damaged)
            done = program("weave", path, "--iso", 49, "-o", tmp_path / "out.t4d")
            assert done.returncode in (0, 3, 4), done.stderr
            file.write_bytes(whole)


def test_far_more_chunks_than_files_are_refused(tmp_path):
    path = version3(tmp_path / "in.zarr", solid(), (1, 1, 1, 1))
    for shape in ([2, 300, 300, 300], [2**20, 100, 100, 10]):
        assert "chunks" in refused(changed(path, tmp_path, put("shape", shape)), tmp_path, *PLAIN)

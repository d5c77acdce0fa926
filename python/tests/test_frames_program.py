"""``t4d weave -`` and ``python3 -m t4d``, with the program: what goes through the stream is woven as from a file, and a
stream that is damaged is refused."""

import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import t4d
from t4d.stream import write_stream

BUILD = Path(os.environ.get("T4D_BUILD", Path(__file__).parents[2] / "build" / "release"))


def ball(t, kind=np.float32):
    x, y, z = np.indices((13, 11, 9)) - np.array([5 + t, 5, 4]).reshape(3, 1, 1, 1)
    return (np.sqrt(x * x + y * y + z * z) - 3).astype(kind)


FRAMES = np.stack([ball(t) for t in range(4)])
LABELS = (FRAMES < 0).astype(np.int16) + 2 * (FRAMES < -2)


def stream_of(array, sent=None, **members):
    """The bytes of a stream; members replace those of the header, None leaves one out."""
    file = io.BytesIO()
    write_stream(t4d.open_frames(array), file, sent)
    head, samples = file.getvalue().split(b"\n", 1)
    header = {**json.loads(head), **members}
    return json.dumps({name: value for name, value in header.items() if value is not None}).encode() + b"\n" + samples


def weave(stream, out, *words):
    """The exit code and what is said of ``t4d weave -``."""
    out.unlink(missing_ok=True)
    done = subprocess.run(
        [BUILD / "t4d", "weave", "-", "-o", out, *words], input=stream, capture_output=True, timeout=60
    )
    assert out.exists() == (done.returncode in (0, 3))
    return done.returncode, done.stderr.decode()


def slabs(path):
    """The vertices and the cells of each slab of each body."""
    return [(np.array(slab.vertices), np.array(slab.cells)) for body in t4d.read(path) for slab in body.slabs()]


def same(path, other):
    mine, others = slabs(path), slabs(other)
    return len(mine) == len(others) and all(
        np.array_equal(a, b) for one, two in zip(mine, others) for a, b in zip(one, two)
    )


def from_file(array, folder, *words):
    np.save(folder / "file.npy", array)
    subprocess.run([BUILD / "t4d", "weave", folder / "file.npy", "-q", "-o", folder / "file.t4d", *words], check=True,
                   stderr=subprocess.DEVNULL)  # fmt: skip
    return folder / "file.t4d"


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("kind", ["<f4", ">f4", "<f8"])
def test_a_stream_is_woven_as_a_file_is(tmp_path, kind, order):
    stream = stream_of(np.asarray(FRAMES, dtype=kind, order=order))
    assert weave(stream, tmp_path / "a.t4d")[0] == 0
    assert same(tmp_path / "a.t4d", from_file(FRAMES.astype(kind), tmp_path))


def test_parts_join_to_the_whole(tmp_path):
    assert weave(stream_of(FRAMES), tmp_path / "all.t4d")[0] == 0
    for number, part in [(1, (0, 2)), (2, (2, 3))]:  # of three steps
        words = ("--part", f"{number}/2")
        assert weave(stream_of(FRAMES, part), tmp_path / f"{number}.t4d", *words)[0] == 0
        assert weave(stream_of(FRAMES), tmp_path / f"whole-{number}.t4d", *words)[0] == 0
        assert (tmp_path / f"{number}.t4d").read_bytes() == (tmp_path / f"whole-{number}.t4d").read_bytes()
    subprocess.run([BUILD / "t4d", "join", tmp_path / "1.t4d", tmp_path / "2.t4d", "-o", tmp_path / "joined.t4d"],
                   check=True, stdout=subprocess.DEVNULL)  # fmt: skip
    assert same(tmp_path / "joined.t4d", tmp_path / "all.t4d")


@pytest.mark.parametrize("words", [("--label", "1"), ("--label", "1", "--label", "3"), ("--label", "all"), ("--iso", "2")])
def test_labels_and_densities_are_those_of_a_file(tmp_path, words):
    assert weave(stream_of(LABELS), tmp_path / "a.t4d", *words)[0] == 0
    assert same(tmp_path / "a.t4d", from_file(LABELS, tmp_path, *words))


def test_masks_may_have_any_type(tmp_path):
    inside = FRAMES < 0
    assert weave(stream_of(inside), tmp_path / "bool.t4d")[0] == 0
    assert weave(stream_of(inside.astype(np.uint8), mask=True), tmp_path / "mask.t4d")[0] == 0
    assert same(tmp_path / "bool.t4d", tmp_path / "mask.t4d")


def test_the_header_says_where_when_and_what(tmp_path):
    affine = [[0, -2, 0, 5], [2, 0, 0, 6], [0, 0, 3, 7]]
    code, said = weave(
        stream_of(FRAMES, affine=affine, times=[1, 2, 4, 8], length_unit="mm", time_unit="s", space="LPS",
                  name="heart.zarr", notes=["one", "two"], losses=["the rest"]),
        tmp_path / "a.t4d")  # fmt: skip
    assert code == 3 and "t4d: lost: the rest" in said and "t4d: note: one\nt4d: note: two\n" in said
    mesh = t4d.read(tmp_path / "a.t4d")
    assert (mesh.length_unit, mesh.time_unit, mesh.space, mesh.up) == ("mm", "s", "LPS", "z")
    assert list(mesh.names) == ["heart"]
    given = t4d.weave(FRAMES, affine=affine, times=[1, 2, 4, 8])
    np.testing.assert_allclose(mesh.volumes([1, 3, 8]), given.volumes([1, 3, 8]), rtol=1e-12)
    np.testing.assert_allclose(mesh.measure([3])["centroid"], given.measure([3])["centroid"], rtol=1e-12)


def test_a_region_says_where_the_solid_is_cut_off(tmp_path):
    cut = FRAMES[:, 4:]
    affine = [[2, 0, 0, 100], [0, 2, 0, 0], [0, 0, 2, 0]]
    code, said = weave(stream_of(cut, affine=affine, region={"size": [13, 11, 9], "first": [4, 0, 0]}), tmp_path / "a.t4d")
    assert code == 0 and "x = 4" in said
    assert np.min(t4d.read(tmp_path / "a.t4d").slice(time=0).vertices[:, 0]) == pytest.approx(100, abs=2)


WRONG = {
    "an unknown member": dict(frame=3),
    "another format": dict(format="frames"),
    "another version": dict(version=2),
    "no size": dict(size=None),
    "another size": dict(size=[13, 11, 8]),
    "a size of text": dict(size=["13", 11, 9]),
    "a negative size": dict(size=[-13, 11, 9]),
    "more frames": dict(frames=5, times=None),
    "fewer frames": dict(frames=3, times=None),
    "one frame": dict(frames=1, times=None),
    "too many frames": dict(frames=2**40, times=None),
    "fewer times": dict(times=[0, 1, 2]),
    "times that stand still": dict(times=[0, 1, 1, 2]),
    "times of text": dict(times=["a", "b", "c", "d"]),
    "a flat affine": dict(affine=[[1, 0, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0]]),
    "a short affine": dict(affine=[[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    "another space": dict(space="XYZ"),
    "a mask of text": dict(mask="yes"),
    "a mask of floats": dict(mask=True),
    "lists in lists": dict(notes=[[[["a"]]]]),
    "fewer names": dict(names=["a"]),
    "names that are none": dict(names=[1, 2, 3, 4]),
    "a part": dict(part=[1, 3]),
    "a part beyond": dict(part=[0, 9]),
    "a part backwards": dict(part=[3, 1]),
    "a small region": dict(region={"size": [12, 11, 9], "first": [0, 0, 0]}),
    "a region without a place": dict(region={"size": [13, 11, 9]}),
}


@pytest.mark.parametrize("members", WRONG.values(), ids=WRONG)
def test_what_the_header_contradicts_is_refused(tmp_path, members):
    code, said = weave(stream_of(FRAMES, **members), tmp_path / "a.t4d")
    assert code == 4 and said.startswith("t4d: standard input: "), said


def test_a_damaged_stream_is_refused(tmp_path):
    stream = stream_of(FRAMES)
    begin = stream.index(b"\n") + 1
    frame = (len(stream) - begin) // 4
    cuts = [0, 1, begin - 1, begin, begin + 5, begin + 127, begin + 128, begin + frame, begin + frame + 9, len(stream) - 1]
    for cut in cuts:
        assert weave(stream[:cut], tmp_path / "a.t4d")[0] == 4, cut
    head, samples = stream.split(b"\n", 1)
    for wrong in (
        stream + b"x",
        head.replace(b'"version": 1', b'"version": 1, "version": 1') + b"\n" + samples,
        b"\xff\xfe" + stream,
        b"[" * 10_000_000 + b"\n",
        stream_of(FRAMES, part=[0, 1]),
        head + b"\n" + samples[:frame] + samples[: frame - 1],
        head + b"\n" + samples[:frame] + stream_of(FRAMES.astype(np.float64)).split(b"\n", 1)[1],
        head + b"\n" + samples.replace(b"NUMPY\x01", b"NUMPY\x09"),
    ):
        assert weave(wrong, tmp_path / "a.t4d")[0] == 4, wrong[:80]
    generator = np.random.default_rng(1)
    for _ in range(60):  # bytes of the header and of the first .npy header
        damaged = bytearray(stream)
        damaged[generator.integers(begin + 120)] = generator.integers(256)
        assert weave(bytes(damaged), tmp_path / "b.t4d")[0] in (0, 4)


def test_samples_that_never_come_take_no_memory(tmp_path):
    npy = io.BytesIO()
    np.lib.format.write_array_header_1_0(npy, {"descr": "<f8", "fortran_order": False, "shape": (2**10, 2**11, 2**11)})
    head = json.dumps({"format": "t4d-frames", "version": 1, "size": [2**10, 2**11, 2**11], "frames": 2})
    code, said = weave(head.encode() + b"\n" + npy.getvalue() + bytes(1000), tmp_path / "a.t4d")
    assert code in (1, 4) and ("ends within frame 0" in said or "memory" in said), said


def test_options_of_files_are_refused(tmp_path):
    stream = stream_of(FRAMES)
    for words in (["--axes", "tzyx"], ["--channel", "0"], ["--level", "1"], ["--series", "1"], ["--grid", "a"],
                  ["--region", "0:3,0:3,0:3"], ["--raw", "raw float32 13 11 9 4"], [tmp_path / "a.npy"]):  # fmt: skip
        assert weave(stream, tmp_path / "a.t4d", *words)[0] == 2, words


def test_the_module_feeds_the_program(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    sizes = {"PhysicalSizeX": 0.5, "PhysicalSizeY": 0.5, "PhysicalSizeZ": 2.0, "TimeIncrement": 3.0}
    tifffile.imwrite(tmp_path / "a.ome.tif", FRAMES.transpose(0, 3, 2, 1), photometric="minisblack",
                     metadata={"axes": "TZYX", **sizes})  # fmt: skip
    done = subprocess.run([sys.executable, "-m", "t4d", "weave", tmp_path / "a.ome.tif", "--json", "-o", tmp_path / "a.t4d"],
                          capture_output=True, text=True, timeout=60)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["frames"] == 4
    mesh, given = t4d.read(tmp_path / "a.t4d"), t4d.weave(tmp_path / "a.ome.tif")
    assert (mesh.length_unit, mesh.time_unit) == ("um", "s")
    assert np.array_equal(mesh.volumes([0, 4, 9]), given.volumes([0, 4, 9]))
    wrong = subprocess.run([sys.executable, "-m", "t4d", "weave", tmp_path / "a.ome.tif", "--axes", "q"],
                           capture_output=True, text=True, timeout=60)  # fmt: skip
    assert wrong.returncode in (2, 4) and wrong.stderr.startswith("t4d: ")


def module(*words):
    """The exit code and what is said of ``python3 -m t4d``."""
    done = subprocess.run([sys.executable, "-m", "t4d", *map(os.fspath, words)], capture_output=True, timeout=60)
    return done.returncode, os.fsdecode(done.stderr)


@pytest.fixture
def array(tmp_path):
    """A file that only the module reads."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["a"] = LABELS
    return tmp_path / "a.h5"


def test_parts_of_all_labels_are_found_in_all_frames(tmp_path, array):
    for number in "12":
        assert module("weave", array, "--label", "all", "--part", f"{number}/2", "-o", tmp_path / f"{number}.t4d")[0] == 0
    assert module("weave", array, "--label", "all", "-o", tmp_path / "all.t4d")[0] == 0
    joined = [BUILD / "t4d", "join", tmp_path / "1.t4d", tmp_path / "2.t4d", "-o", tmp_path / "joined.t4d"]
    subprocess.run(joined, check=True, stdout=subprocess.DEVNULL)
    assert same(tmp_path / "joined.t4d", tmp_path / "all.t4d")


def test_words_are_those_of_the_program(tmp_path, array):
    out = tmp_path / "o.t4d"
    assert module("weave", array, "--iso", "1", "-qo", out)[0] == 0 and out.exists()
    for words, expected in [
        (["--isso", "3"], "did you mean --iso"),
        (["--frame-time", "1", "--frame-time", "2"], "--frame-time is given 2 times"),
        (["--region"], "--region has no value"),
        (["--times", "0:6:2000000000"], "N from 1 to 1000000"),
        (["-"], "standard input (-) has all frames"),
        (["--velocity-file", "u.h5", "v.h5"], "--velocity-file takes three files"),
        (["--level", "x"], "--level is not for HDF5"),
    ]:
        code, said = module("weave", array, *words, "-o", tmp_path / "x.t4d")
        assert code == 2 and expected in said and "Traceback" not in said, said


def test_levels_and_regions_are_words(tmp_path):
    zarr = pytest.importorskip("zarr")
    zarr.save_array(tmp_path / "a.zarr", LABELS)
    for words, expected, reason in [
        (["--level", "x"], 2, "t4d: --level: 'x'; expected a number, counted from 0"),
        (["--level", "1"], 4, "a.zarr: has 1 level, so there is no level 1"),
        (["--region", "1:2"], 2, "t4d: --region: '1:2'; expected ranges"),
    ]:
        code, said = module("weave", tmp_path / "a.zarr", "--iso", "1", *words, "-o", tmp_path / "x.t4d")
        assert code == expected and reason in said, said
    assert module("weave", tmp_path / "a.zarr", "--iso", "1", "--level", "0", "-o", tmp_path / "x.t4d")[0] == 0


def test_messages_name_the_path_as_it_is_given(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "nan.h5", "w") as file:
        file["a"] = np.where(FRAMES < -2, np.nan, FRAMES)
    code, said = module("weave", tmp_path / "nan.h5", "-o", tmp_path / "x.t4d")
    assert code == 4 and f"t4d: {tmp_path / 'nan.h5'}: the sample (" in said, said


@pytest.mark.parametrize("axes", ["txyz", "tzyx"])
def test_velocities_of_any_kind_carry_the_solid(tmp_path, axes):
    """The same mesh as from three .npy, which the program reads: a ball that moves by two voxels a frame."""
    h5py, tifffile, zarr = map(pytest.importorskip, ("h5py", "tifffile", "zarr"))
    order = ["txyz".index(axis) for axis in axes]
    solid = np.stack([ball(2 * t) for t in range(3)]).transpose(order)
    still = np.zeros_like(solid)
    parts = [np.full_like(solid, 2 * 0.5 / 0.25), still, still]  # two voxels of 0.5 each 0.25
    np.save(tmp_path / "a.npy", solid)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["a"] = solid
    for name, part in zip("uvw", parts):
        np.save(tmp_path / f"{name}.npy", part)
        zarr.save_array(tmp_path / f"{name}.zarr", part)
    both = np.stack(parts, axis=1)
    one = zarr.create_array(tmp_path / "one.zarr", shape=both.shape, dtype=both.dtype, chunks=both.shape,
                            dimension_names=["t", "c", *axes[1:]])  # fmt: skip
    one[:] = both
    tzyx = [axes.index(axis) for axis in "tzyx"]
    pages = np.stack([part.transpose(tzyx) for part in parts], axis=2)
    tifffile.imwrite(tmp_path / "one.tif", pages, imagej=True, metadata={"axes": "TZCYX"})
    words = ["--axes", axes, "--spacing", "0.5", "1", "1.5", "--origin=1,2,3", "--frame-time", "0.25", "--json"]

    def woven(program, frames, *velocities):
        command = [*program, "weave", tmp_path / frames, *words, "-o", tmp_path / "x.t4d", "--velocity-file",
                   *(tmp_path / name for name in velocities)]  # fmt: skip
        done = subprocess.run(command, capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr
        report = json.loads(done.stdout)
        counts = [report[name] for name in ("frames", "frames_in_between", "vertices", "tetrahedra")]
        return counts, slabs(tmp_path / "x.t4d")

    counts, expected = woven([BUILD / "t4d"], "a.npy", "u.npy", "v.npy", "w.npy")
    assert counts[:2] == [9, 6]
    for frames, *velocities in [
        ("a.npy", "one.tif"), ("a.npy", "one.zarr"), ("a.npy", "u.zarr", "v.zarr", "w.zarr"),
        ("a.h5", "one.zarr"), ("a.h5", "u.npy", "v.npy", "w.npy"),
    ]:  # fmt: skip
        found = woven([sys.executable, "-m", "t4d"], frames, *velocities)
        assert found[0] == counts
        assert all(np.array_equal(a, b) for one, two in zip(found[1], expected) for a, b in zip(one, two))


def test_velocities_elsewhere_are_refused(tmp_path, array):
    zarr = pytest.importorskip("zarr")
    zarr.save_array(tmp_path / "u.zarr", FRAMES[:, 1:])
    words = ["--iso", "1", "--frame-time", "1", "--velocity-file", *[tmp_path / "u.zarr"] * 3, "-o", tmp_path / "x.t4d"]
    code, said = module("weave", array, *words)
    assert code == 4 and "x-u.zarr.nrrd: frame 0: has velocities of 12 x 11 x 9 samples in 4 frames" in said, said


def test_termination_is_that_of_the_program(tmp_path, array):
    """The process ends by the same signal, and without a file."""
    solid = np.stack([np.repeat(np.repeat(np.repeat(ball(t), 12, 0), 12, 1), 12, 2) for t in range(4)])
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "large.h5", "w") as file:
        file["a"] = solid
    np.save(tmp_path / "large.npy", solid)
    ends = []
    for command, name in (([BUILD / "t4d"], "large.npy"), ([sys.executable, "-m", "t4d"], "large.h5")):
        out = tmp_path / f"{name}.t4d"
        with subprocess.Popen([*command, "weave", tmp_path / name, "-o", out], stderr=subprocess.PIPE) as process:
            for _ in range(400):
                if any(file.name.startswith(f".{out.name}") or file == out for file in tmp_path.iterdir()):
                    break
                time.sleep(0.02)
            process.send_signal(signal.SIGTERM)
            ends.append((process.wait(20), process.stderr.read(), [f for f in tmp_path.iterdir() if "t4d" in f.name]))
    assert ends[0] == ends[1] == (-signal.SIGTERM, b"", []), ends


def test_what_is_no_file_is_refused(tmp_path, array):
    os.mkfifo(tmp_path / "pipe.h5")
    assert module("weave", tmp_path / "pipe.h5", "--iso", "1", "-o", tmp_path / "x.t4d") == (
        4, f"t4d: {tmp_path}/pipe.h5: is not a regular file\n")  # fmt: skip
    code, said = module("weave", tmp_path / "none.mha", "--iso", "1", "-o", tmp_path / "x.t4d")
    assert code == 4 and "No such file" in said
    strange = os.fsencode(tmp_path) + b"/\xff.h5"
    os.rename(array, strange)
    assert module("weave", strange, "--iso", "1", "-o", tmp_path / "x.t4d")[0] == 0
    code, said = module("weave", os.fsencode(tmp_path) + b"/\xff.mha", "--iso", "1", "-o", tmp_path / "x.t4d")
    assert code == 4 and "No such file" in said

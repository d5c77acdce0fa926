"""The stream of frames, and ``python3 -m t4d``, which feeds a program by it: here a program of Python that reads the
stream by numpy alone."""

import atexit
import io
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
import t4d
from t4d.stream import header_of, write_nrrd, write_stream

PROGRAM = Path(tempfile.mkdtemp(prefix="t4d-test-")) / "program"
PROGRAM.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{Path(__file__).with_name("stream_program.py")}" "$@"\n')
PROGRAM.chmod(0o755)
atexit.register(shutil.rmtree, PROGRAM.parent)
SIZES = (4, 7, 6, 5)


def samples(kind=np.uint16):
    t, x, y, z = np.indices(SIZES)
    return (x + 7 * y + 42 * z + 210 * t + 1).astype(kind)


def door(*words, how="", **more):
    """Runs ``python3 -m t4d``; its exit code, its output and its messages."""
    path = os.pathsep.join([str(Path(t4d.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "T4D_PROGRAM": str(PROGRAM), "STREAM_PROGRAM": how, "PYTHONPATH": path, **more}
    done = subprocess.run([sys.executable, "-m", "t4d", *map(str, words)], env=environment, capture_output=True,
                          text=True, timeout=60)  # fmt: skip
    return done.returncode, done.stdout, done.stderr


def report(*words, **more):
    code, out, said = door(*words, **more)
    assert code == 0, said
    return json.loads(out)


@pytest.fixture
def tiff(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    path = tmp_path / "a.ome.tif"
    tifffile.imwrite(path, samples().transpose(0, 3, 2, 1), photometric="minisblack",
                     metadata={"axes": "TZYX", "PhysicalSizeX": 0.5, "PhysicalSizeY": 0.5, "TimeIncrement": 2.0})
    return path


@pytest.mark.parametrize("order", ["C", "F", "neither"])
@pytest.mark.parametrize("kind", ["bool", "uint8", "int16", ">i4", "float16", "float32", "float64"])
def test_a_stream_is_read_by_numpy(kind, order):
    array = samples(kind) if kind != "bool" else samples() % 3 == 0
    given = np.stack([array, array], -1)[..., 0] if order == "neither" else np.asarray(array, order=order)
    frames = t4d.open_frames(given, axes="txyz", frame_time=0.5, spacing=(1, 2, 3))
    file = io.BytesIO()
    write_stream(frames, file)
    file.seek(0)
    header = json.loads(file.readline())
    assert header["size"] == [7, 6, 5] and header["frames"] == 4 and header["times"] == [0, 0.5, 1, 1.5]
    assert header["affine"] == [[1, 0, 0, 0], [0, 2, 0, 0], [0, 0, 3, 0]]
    assert header.get("mask", False) == (kind == "bool")
    written = np.dtype("float32" if kind == "float16" else kind).newbyteorder("=")
    for frame in array:
        found = np.lib.format.read_array(file)
        assert np.array_equal(found, frame) and found.dtype == written
    assert file.read() == b""


def test_what_nothing_says_is_left_out():
    header = header_of(t4d.open_frames(samples()))
    assert set(header) == {"format", "version", "size", "frames", "assumed_axes"}
    assert header["format"] == "t4d-frames" and header["version"] == 1


def test_two_frames_are_in_memory():
    """The third is not read before the first is written."""
    events = []

    class Source:
        shape, dtype = (4, 3, 3, 3), np.dtype("u1")

        def __getitem__(self, at):
            events.append(f"read {at[0]}")
            return np.zeros((3, 3, 3), "u1")

    class Sink(io.BytesIO):
        def write(self, data):
            if len(data) == 27:
                events.append("write")
            return super().write(data)

    write_stream(t4d.open_frames(Source(), axes="txyz"), Sink())
    written = 0
    for event in events:
        written += event == "write"
        assert event == "write" or int(event[5:]) <= written + 1
    assert events.count("write") == 4


def test_the_door_feeds_the_program(tiff):
    found = report("weave", tiff, "--iso", "300", "-o", "x.t4d", "--region", "1:4,:,:,1:4", "-q")
    cut = samples()[1:4, 1:4]
    assert found["words"] == ["weave", "-", "--iso", "300", "-o", "x.t4d", "-q"]
    assert found["header"]["size"] == [3, 6, 5] and found["header"]["times"] == [2, 4, 6]
    assert found["header"]["unsized"] == "z" and found["header"]["length_unit"] == "um"
    assert found["header"]["name"] == str(tiff)
    assert found["header"]["region"] == {"size": [7, 6, 5], "first": [1, 0, 0]}
    assert [total for _, total in found["frames"]] == [float(frame.sum()) for frame in cut]


def test_options_are_told_apart_by_the_description(tiff):
    for words in (["--label", "1", "2", "-o", "x.t4d"], ["--label=all", "-ox.t4d"], ["-q"],
                  ["--iso", "-5", "--body=nut"]):  # fmt: skip
        found = report("weave", tiff, *words)
        assert found["words"][2:] == words
    assert report("weave", "--axes", "tzyx", "--iso=3", tiff)["header"]["frames"] == 4
    assert report("weave", "--iso=3", "--", tiff)["header"]["frames"] == 4


def test_places_and_times_are_those_of_the_file(tiff):
    """A region does not move anything."""
    words = ["--spacing", "1", "2", "3", "--origin=10,20,30", "--region", "2:5,:,1:,1:3"]
    found = report("weave", tiff, "--iso=3", *words, "--times", "0,1,4,9")
    assert found["words"] == ["weave", "-", "--iso=3"]
    header = found["header"]
    assert header["affine"] == [[1, 0, 0, 12], [0, 2, 0, 20], [0, 0, 3, 33]] and header["times"] == [1, 4]
    assert "unsized" not in header
    even = report("weave", tiff, "--iso=3", *words, "--frame-time", "0.5", "--start-time", "-1")
    assert even["header"]["times"] == [-0.5, 0]
    assert report("weave", tiff, "--iso=3", "--times", "0:9:4")["header"]["times"] == [0, 3, 6, 9]
    both = ["--times=0,1,2,3", "--frame-time=1"]
    for wrong in (["--times", "a:b:c"], ["--spacing=x"], both, ["--spacing", "1", "2"]):
        code, out, said = door("weave", tiff, "--iso=3", *wrong)
        assert code == 2 and out == "" and "t4d: " in said, said


def test_a_part_has_the_frames_of_its_steps(tiff):
    """Three steps in two parts: the first has one more."""
    first, second = (report("weave", tiff, "--iso", "3", "--part", f"{k}/2") for k in (1, 2))
    assert first["header"]["part"] == [0, 2] and second["header"]["part"] == [2, 3]
    assert first["frames"][-1] == second["frames"][0]


def test_all_else_is_the_programs(tiff, tmp_path):
    np.save(tmp_path / "a.npy", samples())
    array = str(tmp_path / "a.npy")
    for words in (["info", "x.t4d"], ["weave", array, "--iso", "3"], ["weave", "x.vdb", "--wrong"], []):
        code, out, _ = door(*words)
        assert (code, json.loads(out)) == (7, words)


def test_misuse_and_errors_come_before_any_output(tiff, tmp_path):
    (tmp_path / "b.tif").write_text("no TIFF")
    cases = [
        (["weave", tiff, "--level", "1"], 2, "t4d: --level is not for TIFF"),
        (["weave", tiff, "--region", "1:2"], 2, "t4d: --region: '1:2'; expected ranges along x, y and z"),
        (["weave", tiff, "--region", "5:2,:,:"], 2, "t4d: --region: '5:2,:,:'; expected a range along x that begins"),
        (["weave", tiff, "--frame-time", "0"], 2, "t4d: --frame-time: 0.0; expected a number above zero"),
        (["weave", tiff, "--spacing", "1", "x", "1"], 2, "t4d: --spacing: '1,x,1'; expected a number"),
        (["weave", tiff, "--spacing", "1", "0", "1"], 2, "t4d: --spacing: 0.0; expected a number above zero"),
        (["weave", tiff, "--axes", "tzyq"], 2, "t4d: --axes: 'tzyq'; expected an order"),
        (["weave", tiff, "--times=0,1,2,3", "--frame-time=1"], 2, "t4d: --times says when all frames are"),
        (["weave", tiff, "--channel", "dapi"], 2, "t4d: --channel: 'dapi'; expected a number"),
        (["weave", tiff, "--channel", "1"], 4, "has 1 channel, so there is no channel 1"),
        (["weave", tiff, "--region", "0:99,:,:"], 4, f"t4d: {tiff}: the region has 0:99 along x"),
        (["weave", tmp_path / "b.tif", "--iso", "3"], 4, f"t4d: {tmp_path / 'b.tif'}: "),
        (["weave", tmp_path / "none.tif", "--iso", "3"], 4, "No such file"),
    ]
    for words, expected, reason in cases:
        code, out, said = door(*words)
        assert code == expected and out == "" and reason in said and "Traceback" not in said, said


def test_several_channels_need_a_choice(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    tifffile.imwrite(tmp_path / "a.tif", np.zeros((3, 4, 2, 5, 6), np.uint8), imagej=True, metadata={"axes": "TZCYX"})
    code, _, said = door("weave", tmp_path / "a.tif", "--iso", "3")
    assert code == 4 and said.splitlines()[-1] == "t4d: try: --channel NUMBER, counted from 0"
    assert report("weave", tmp_path / "a.tif", "--iso", "3", "--channel", "1")["header"]["frames"] == 3


def test_the_program_ends_early(tiff):
    code, _, said = door("weave", tiff, "--iso", "3", how="early")
    assert code == 4 and said == "t4d: the program ends early\n"


def test_an_error_within_the_stream_ends_the_program(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    tifffile.imwrite(tmp_path / "a.tif", samples().transpose(0, 3, 2, 1), photometric="minisblack", compression="zlib",
                     metadata={"axes": "TZYX"})  # fmt: skip
    whole = bytearray((tmp_path / "a.tif").read_bytes())
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        begin, count = file.pages[12].dataoffsets[0], file.pages[12].databytecounts[0]
    whole[begin : begin + count] = bytes(count)
    (tmp_path / "a.tif").write_bytes(whole)
    code, out, said = door("weave", tmp_path / "a.tif", "--iso", "3")
    assert code == 4 and out == "" and said.count("\n") == 1, said
    assert said.startswith(f"t4d: {tmp_path / 'a.tif'}: cannot be read")


def test_interruption_ends_both(tiff):
    path = os.pathsep.join([str(Path(t4d.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "T4D_PROGRAM": str(PROGRAM), "STREAM_PROGRAM": "wait", "PYTHONPATH": path}
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        with subprocess.Popen([sys.executable, "-m", "t4d", "weave", tiff, "--iso", "3"], env=environment,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:  # fmt: skip
            assert process.stdout.readline() == "ready\n"
            process.send_signal(number)
            _, said = process.communicate(timeout=20)
        assert (process.returncode, said) == (-number, "")


def test_a_program_that_is_none(tiff, tmp_path):
    """It says itself what is wrong with it."""
    assert door("weave", tiff, T4D_PROGRAM="/bin/false") == (1, "", "")
    code, _, said = door("weave", tiff, T4D_PROGRAM=str(tmp_path / "none"))
    assert code == 1 and said.startswith("t4d: ") and "none" in said and said.count("\n") == 1, said


def test_what_is_cut_off_is_said_to_be(tmp_path):
    """Not to have fewer frames: tifffile leaves out pages that are behind the end."""
    tifffile = pytest.importorskip("tifffile")
    for how in ({"compression": "zlib"}, {}, {"imagej": True}):
        tifffile.imwrite(tmp_path / "a.tif", samples()[:, :, :, 0].transpose(0, 2, 1), photometric="minisblack",
                         metadata=None if not how.get("imagej") else {"axes": "TYX"}, **how)  # fmt: skip
        whole = (tmp_path / "a.tif").read_bytes()
        for end in (len(whole) // 3, 2 * len(whole) // 3):
            (tmp_path / "b.tif").write_bytes(whole[:end])
            code, _, said = door("weave", tmp_path / "b.tif", "--iso", "3", "--axes", "tyx")
            assert code == 4 and ("is damaged or cut off: " in said or "cannot be read: " in said), said


def test_a_folder_that_has_dicom_below_it(tmp_path):
    pytest.importorskip("pydicom", "3")
    (tmp_path / "a b" / "c").mkdir(parents=True)
    (tmp_path / "a b" / "c" / "1").write_bytes(bytes(128) + b"DICM")
    code, _, said = door("weave", tmp_path / "a b", "--iso", "3")
    assert code == 4 and said.endswith(f"a folder in it does: python3 -m t4d weave '{tmp_path}/a b/c'\n"), said


def test_errors_of_itk_are_one_line(tmp_path):
    pytest.importorskip("SimpleITK")
    (tmp_path / "a.mha").write_text("none")
    code, _, said = door("weave", tmp_path / "a.mha", "--iso", "3")
    name = tmp_path / "a.mha"
    assert (code, said) == (4, f't4d: {name}: cannot be read: Unable to determine ImageIO reader for "{name}"\n')


def test_names_in_the_order_of_a_shell(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    names = [tmp_path / f"f{i}.tif" for i in (1, 10, 2)]
    for i, name in zip((0, 2, 1), names):
        tifffile.imwrite(name, samples()[i].transpose(2, 1, 0), metadata=None, photometric="minisblack")
    found = report("weave", *names, "--iso", "3")
    assert [total for _, total in found["frames"]] == [float(frame.sum()) for frame in samples()[:3]]
    assert "in the order of the numbers" in found["header"]["notes"][0]
    assert [Path(name).name for name in found["header"]["names"]] == ["f1.tif", "f2.tif", "f10.tif"]


def test_padding_and_whole_numbers(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["a"] = samples("i2")
        file["a"].attrs["_FillValue"] = np.int16(1)
    found = report("weave", tmp_path / "a.h5", "--iso", "3")
    assert found["words"][-1] == "--outside-value=nan" and found["frames"][0][0] == "float32"
    assert found["frames"][0][1] == samples()[0].sum() - 1
    other = report("weave", tmp_path / "a.h5", "--iso", "3", "--outside-value", "2")
    assert other["frames"][0][1] == samples()[0].sum() - 3 and other["words"].count("--outside-value=nan") == 1
    assert "2" not in other["words"]
    labels = report("weave", tmp_path / "a.h5", "--label", "4")
    assert labels["frames"][0][1] == samples()[0].sum() - 1 and "--outside-value=nan" not in labels["words"]
    code, _, said = door("weave", tmp_path / "a.h5")
    assert code == 4 and "has whole numbers as samples" in said and "try: --iso VALUE" in said


def test_a_nrrd_has_the_place_of_its_frames(tmp_path):
    frames = t4d.open_frames(samples(np.int16), axes="txyz", spacing=(1, 0.5, 3), origin=(4, 5.5, -1e-7))
    write_nrrd(frames, tmp_path / "a.nrrd")
    head, body = (tmp_path / "a.nrrd").read_bytes().split(b"\n\n", 1)
    assert b"space directions: (1.0,0.0,0.0) (0.0,0.5,0.0) (0.0,0.0,3.0) none\nspace origin: (4.0,5.5,-1e-07)" in head
    assert b"type: float\n" in head and b"sizes: 7 6 5 4\n" in head
    assert np.array_equal(np.frombuffer(body, "<f4").reshape(4, 5, 6, 7), samples().transpose(0, 3, 2, 1))
    with pytest.raises(t4d.InvalidInput, match="bools"):
        write_nrrd(t4d.open_frames(samples() > 3), tmp_path / "b.nrrd")


def volumes_of_velocity(tmp_path, axes):
    """Frames, velocities of them in one file, and in three, in another order of axes."""
    h5py = pytest.importorskip("h5py")
    tifffile = pytest.importorskip("tifffile")
    np.save(tmp_path / "a.npy", samples(np.float32).transpose(["txyz".index(axis) for axis in axes]))
    velocities = np.stack([samples(np.float32) * factor for factor in (1, 2, 4)])
    tifffile.imwrite(tmp_path / "v.tif", velocities.transpose(1, 4, 0, 3, 2), imagej=True, metadata={"axes": "TZCYX"})
    for name, of_axis in zip("uvw", velocities):
        with h5py.File(tmp_path / f"{name}.h5", "w") as file:
            file["a"] = of_axis.transpose(["txyz".index(axis) for axis in axes])
    return tmp_path / "a.npy", [tmp_path / "v.tif"], [tmp_path / f"{name}.h5" for name in "uvw"]


@pytest.mark.parametrize("axes", ["txyz", "tzyx"])
def test_velocities_are_written_for_the_program(tmp_path, axes):
    frames, one, three = volumes_of_velocity(tmp_path, axes)
    total = float(samples().sum())
    words = ["--axes", axes, "--spacing", "1", "2", "3", "--origin=4,5,6"]
    for files in (one, three):
        code, out, said = door("weave", frames, *words, "--velocity-file", *files, "--substeps", "2")
        found = json.loads(out)
        assert (code, said) == (7, "") and found["words"][:-6] == ["weave", str(frames), *words], said
        names, fields, sums = zip(*found["velocities"])
        assert sums == (total, 2 * total, 4 * total)
        of_axes = zip("xyz", one * 3 if files == one else three)
        assert names == tuple(f"{axis}-{file.name}.nrrd" for axis, file in of_axes)
        assert fields[0] == fields[2] and fields[0]["sizes"] == "7 6 5 4" and fields[0]["type"] == "float"
        assert fields[0]["space directions"] == "(1.0,0.0,0.0) (0.0,1.0,0.0) (0.0,0.0,1.0) none"
        assert fields[0]["space origin"] == "(0.0,0.0,0.0)"
    found = report("weave", three[0], *words, "--velocity-file", *three)
    assert found["words"][:6] == ["weave", "-", *words[2:6]] and found["header"]["affine"][2] == [0, 0, 3, 6]
    for wrong, said in [
        (["--velocity-file", *three[:2]], "--velocity-file takes three files"),
        (["--velocity-file", *three, "--region", ":,:,:"], "--region and velocities exclude each other"),
    ]:
        code, out, reason = door("weave", three[0], *wrong)
        assert (code, out) == (2, "") and said in reason, reason


def test_the_page_has_a_writer():
    page = (Path(__file__).parents[2] / "docs" / "frame-stream.md").read_text()
    code = page.split("```python\n")[1].split("```")[0]
    stream = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout
    environment = {**os.environ, "STREAM_PROGRAM": ""}
    done = subprocess.run([PROGRAM, "weave", "-"], input=stream, env=environment, capture_output=True, check=True)
    found = json.loads(done.stdout)
    assert found["header"]["times"] == [0, 0.5, 1] and [kind for kind, _ in found["frames"]] == ["float64"] * 3


def test_verbs_go_through_the_door(tiff, monkeypatch, tmp_path):
    from t4d import commands

    monkeypatch.setattr(commands, "program", lambda: str(PROGRAM))
    commands.options_of.cache_clear()
    try:
        found = commands.run("weave", tiff, iso=3, region="1:4,:,:", output="x.t4d")
    finally:
        commands.options_of.cache_clear()
    assert found["header"]["size"] == [3, 6, 5] and "--output=x.t4d" in found["words"] and "--json" in found["words"]


def test_help_has_what_the_door_adds():
    code, out, _ = door("weave", "--help")
    assert code == 7 and "also reads DICOM, Zarr" in out and ".tif" in out


def test_libraries_say_nothing_of_their_own(tmp_path):
    """tifffile logs, pydicom warns, and zarr leaves tasks behind when a request fails."""
    tifffile = pytest.importorskip("tifffile")
    tifffile.imwrite(tmp_path / "a.tif", samples().transpose(0, 3, 2, 1), photometric="minisblack",
                     metadata={"axes": "TZYX"})  # fmt: skip
    whole = (tmp_path / "a.tif").read_bytes()
    for end in range(200, len(whole), len(whole) // 5):
        (tmp_path / "b.tif").write_bytes(whole[:end])
        code, _, said = door("weave", tmp_path / "b.tif", "--iso", "3")
        assert code in (0, 4) and all(line.startswith("t4d: ") for line in said.splitlines()), said  # all but tags

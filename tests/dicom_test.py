"""DICOM series as pydicom writes them, woven by the program, against SimpleITK's reading of them."""

import json
import os
import subprocess
from pathlib import Path

import dicom_series as series
import numpy as np
import pydicom
import pytest
import SimpleITK
from pydicom.uid import (
    DeflatedExplicitVRLittleEndian,
    ImplicitVRLittleEndian,
    RLELossless,
)

PROGRAM = Path(os.environ["T4D_BUILD"]) / "t4d"


def program(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)


def woven(path, tmp_path, *options):
    """What `measure` finds in the frames of a series, at the level of half the ball."""
    done = program("weave", path, "--iso", 550, "-o", tmp_path / "out.t4d", "-q", *options)
    assert done.returncode == 0, done.stderr
    said = program("measure", tmp_path / "out.t4d", "--frames", series.FRAMES, "--json")
    return json.loads(said.stdout)["samples"]


def refused(path, tmp_path, *options):
    done = program("weave", path, "--iso", 550, "-o", tmp_path / "no.t4d", *options)
    assert done.returncode == 4
    assert not (tmp_path / "no.t4d").exists()
    return done.stderr


def by_trigger(image, frame, k):
    """A beat that is not even, and slices that are not taken at quite the same delay."""
    image.TriggerTime = [0, 40.5, 82, 121][frame] + 0.25 * (k % 3)


def by_reference(image, frame, k):
    image.FrameReferenceTime = 1000 * frame + 500
    image.RescaleSlope, image.RescaleIntercept = round(1 + 0.1 * k + 0.05 * frame, 3), 0
    values = np.round(series.samples(frame)[k] / image.RescaleSlope).astype(np.uint16)
    image.set_pixel_data(values, "MONOCHROME2", 16)


def ball_by_itk(files, level=550):
    """The middle of what is above the level in a volume that SimpleITK reads, on a grid five times
    as fine."""
    reader = SimpleITK.ImageSeriesReader()
    reader.SetFileNames(files)
    volume = SimpleITK.Expand(reader.Execute(), [5, 5, 5])
    values = SimpleITK.GetArrayFromImage(volume)
    inside = np.argwhere(values > level)[:, ::-1].mean(axis=0)
    return np.array(volume.TransformContinuousIndexToPhysicalPoint(inside.tolist()))


def files_of_frame(folder, order):
    """The files of each frame, by their place along the normal."""
    images = [pydicom.dcmread(f, stop_before_pixels=True) for f in sorted(folder.iterdir())]
    frames = [[] for _ in range(series.FRAMES)]
    for image in images:
        x, y = np.array(image.ImageOrientationPatient).reshape(2, 3)
        depth = np.cross(x, y) @ np.array(image.ImagePositionPatient)
        frames[order(image)].append((depth, image.filename))
    return [[name for _, name in sorted(frame)] for frame in frames]


@pytest.mark.parametrize("oblique", [False, True])
@pytest.mark.parametrize("stamp", [by_trigger, by_reference])
def test_the_ball_is_where_simpleitk_sees_it(tmp_path, oblique, stamp):
    folder = series.classic(tmp_path / "series", stamp, oblique)
    frame_of = {
        by_trigger: lambda image: round(image.get("TriggerTime", 0) / 40),
        by_reference: lambda image: int(image.get("FrameReferenceTime", 0) // 1000),
    }[stamp]
    found = woven(folder, tmp_path)
    frames = files_of_frame(folder, frame_of)
    for sample, files in [(found[0], frames[0]), (found[-1], frames[-1])]:
        assert np.linalg.norm(np.array(sample["centroid"]) - ball_by_itk(files)) < 0.02


def test_every_way_of_saying_it_gives_the_ball(tmp_path):
    """Enhanced or classic, packed or not: the same ball."""
    expected = woven(series.classic(tmp_path / "plain", by_trigger), tmp_path)

    def syntax(uid):
        def change(image, frame, k):
            image.file_meta.TransferSyntaxUID = uid
        return change

    others = [
        series.classic(tmp_path / "rle", by_trigger, compress=RLELossless),
        *(
            series.classic(tmp_path / uid, by_trigger, change=syntax(uid))
            for uid in (DeflatedExplicitVRLittleEndian, ImplicitVRLittleEndian)
        ),
        series.enhanced(tmp_path / "enhanced.dcm"),
    ]
    for path in others:
        found = woven(path, tmp_path)
        for index in (0, -1):
            middle = expected[index]["centroid"]
            assert np.allclose(found[index]["centroid"], middle, atol=1e-5), path


def at_temporal_position(image, frame, k):
    image.TemporalPositionIdentifier, image.NumberOfTemporalPositions = frame + 1, series.FRAMES
    image.TemporalResolution = 250


def at_midnight(image, frame, k):
    image.AcquisitionDate = "20260228" if frame < 2 else "20260301"
    image.AcquisitionTime = ["235958.5", "235959.5", "000000.5", "000001.5"][frame]


@pytest.mark.parametrize(
    "stamp, first, last",
    [
        (by_trigger, 0.00025, 0.12125),
        (by_reference, 0.5, 3.5),
        (at_temporal_position, 0, 0.75),
        (at_midnight, 0, 3),
    ],
)
def test_times_are_in_seconds(tmp_path, stamp, first, last):
    found = woven(series.classic(tmp_path / "series", stamp), tmp_path)
    assert found[0]["time"] == pytest.approx(first)
    assert found[-1]["time"] == pytest.approx(last)


def test_a_tilted_gantry_keeps_the_volume(tmp_path):
    straight = woven(series.classic(tmp_path / "straight", by_trigger), tmp_path)
    tilted = woven(series.classic(tmp_path / "tilted", by_trigger, shear=(0, 0.5, 0)), tmp_path)
    assert tilted[0]["volume"] == pytest.approx(straight[0]["volume"])
    middle = (series.SIZES[2] - 1) / 2
    moved = tilted[0]["centroid"][1] - straight[0]["centroid"][1]
    assert moved == pytest.approx(0.5 * middle, abs=0.4)


def test_what_is_not_one_volume_over_time_is_refused(tmp_path):
    def write(name, stamp=by_trigger, **how):
        return series.classic(tmp_path / name, stamp, **how)

    def doubled(image, frame, k):
        image.TriggerTime = 40 * min(frame, 2)

    def colours(image, frame, k):
        image.PhotometricInterpretation = "RGB"

    cases = [
        (write("missing", change=lambda i, f, k: (f, k) != (2, 5)), "one is missing"),
        (write("doubled", doubled), "is a second image at the position"),
        (write("timeless", lambda *_: None), "says when"),
        (write("single", frames=1), "one frame only"),
        (write("gap", change=lambda i, f, k: k != 5), "slices are"),
        (write("plane", change=lambda i, f, k: k == 5), "at one position"),
        (write("colours", change=colours), "RGB"),
    ]
    for path, reason in cases:
        assert reason in refused(path, tmp_path), path


def test_a_film_is_refused(tmp_path):
    film = series.empty(tmp_path / "film.dcm")
    film.NumberOfFrames = 3
    film.PixelData = bytes(3 * 2 * series.SIZES[0] * series.SIZES[1])
    film.save_as(tmp_path / "film.dcm", enforce_file_format=True)
    assert "no positions of their own" in refused(tmp_path / "film.dcm", tmp_path)


def test_one_of_several_series_is_chosen(tmp_path):
    folder = series.classic(tmp_path / "both", by_trigger)
    for file in series.classic(tmp_path / "more", by_trigger, series="9.9.9", number=7).iterdir():
        file.rename(folder / f"more{file.name}")
    os.mkfifo(folder / "pipe")
    (folder / "notes.txt").write_text("none of the series")
    (folder / "DICOMDIR").write_bytes(bytes(128) + b"DICM")
    said = refused(folder, tmp_path)
    assert "2 series" in said and "9.9.9" in said and "--series" in said
    assert woven(folder, tmp_path, "--series", 7) == woven(folder, tmp_path, "--series", "9.9.9")
    assert "no series" in refused(folder, tmp_path, "--series", 8)


def test_a_damaged_file_is_refused(tmp_path):
    """Cut anywhere, and with any byte of its header changed: refused or read, never worse."""
    folder = series.classic(tmp_path / "series", by_trigger)
    file = sorted(folder.iterdir())[0]
    whole = file.read_bytes()
    random = np.random.default_rng(3)
    for _ in range(60):
        damaged = bytearray(whole)
        for at in random.integers(128, 1200, 3):
            damaged[at] = random.integers(256)
        end = len(whole) if random.random() < 0.5 else random.integers(len(whole))
        file.write_bytes(damaged[:end])
        done = program("weave", folder, "--iso", 550, "-o", tmp_path / "out.t4d")
        assert done.returncode in (0, 3, 4), done.stderr

"""DICOM through pydicom, against what SimpleITK reads."""

import os

import numpy as np
import pytest

pydicom = pytest.importorskip("pydicom", "3")
sitk = pytest.importorskip("SimpleITK")

import dicom_series as series  # noqa: E402
import t4d  # noqa: E402
from pydicom.dataset import Dataset  # noqa: E402
from pydicom.sequence import Sequence  # noqa: E402
from pydicom.uid import (  # noqa: E402
    DeflatedExplicitVRLittleEndian, ImplicitVRLittleEndian, JPEG2000Lossless, JPEGLSLossless, RLELossless,
)  # fmt: skip


def by_trigger(image, frame, k):
    """A beat that is not even, and slices that are not taken at quite the same delay."""
    image.TriggerTime = [0, 40.5, 82, 121][frame] + 0.25 * (k % 3)


def by_reference(image, frame, k):
    image.FrameReferenceTime = 1000 * frame + 500
    image.RescaleSlope, image.RescaleIntercept = round(1 + 0.1 * k + 0.05 * frame, 3), 0
    values = np.round(series.samples(frame)[k] / image.RescaleSlope).astype(np.uint16)
    image.set_pixel_data(values, "MONOCHROME2", 16)


def at_temporal_position(image, frame, k):
    image.TemporalPositionIdentifier, image.NumberOfTemporalPositions = frame + 1, series.FRAMES
    image.TemporalResolution = 250


def at_midnight(image, frame, k):
    image.AcquisitionDate = "20260228" if frame < 2 else "20260301"
    image.AcquisitionTime = ["235958.5", "235959.5", "000000.5", "000001.5"][frame]


def files_of_frame(folder, frame_of):
    """The files of each frame, by their place along the normal."""
    images = [pydicom.dcmread(f, stop_before_pixels=True) for f in sorted(folder.iterdir())]
    frames = [[] for _ in range(series.FRAMES)]
    for image in images:
        x, y = np.array(image.ImageOrientationPatient).reshape(2, 3)
        depth = np.cross(x, y) @ np.array(image.ImagePositionPatient)
        frames[frame_of(image)].append((depth, image.filename))
    return [[name for _, name in sorted(frame)] for frame in frames]


def by_itk(files):
    """Samples (x, y, z) and affine of a frame, as SimpleITK reads it."""
    reader = sitk.ImageSeriesReader()
    reader.SetFileNames(files)
    reader.SetOutputPixelType(sitk.sitkFloat64)  # each slice has its own slope
    image = reader.Execute()
    affine = np.eye(4)
    affine[:3, :3] = np.reshape(image.GetDirection(), (3, 3)) * image.GetSpacing()
    affine[:3, 3] = image.GetOrigin()
    return sitk.GetArrayFromImage(image).transpose(2, 1, 0), affine


def ball_by_itk(files, level=550):
    """The middle of what is above the level in a volume that SimpleITK reads, on a grid five times as fine."""
    reader = sitk.ImageSeriesReader()
    reader.SetFileNames(files)
    volume = sitk.Expand(reader.Execute(), [5, 5, 5])
    inside = np.argwhere(sitk.GetArrayFromImage(volume) > level)[:, ::-1].mean(axis=0)
    return np.array(volume.TransformContinuousIndexToPhysicalPoint(inside.tolist()))


def woven(source):
    """Measures each frame, at the level of half the ball."""
    frames = t4d.open_frames(source)
    return t4d.weave(frames, iso=550).measure(frames.times)


def refused(path, **options):
    with pytest.raises(t4d.InvalidInput) as error:
        t4d.open_frames(path, **options)
    return str(error.value)


@pytest.mark.parametrize("oblique", [False, True])
@pytest.mark.parametrize("stamp", [by_trigger, by_reference])
def test_frames_are_those_of_simpleitk(tmp_path, oblique, stamp):
    folder = series.classic(tmp_path / "series", stamp, oblique)
    frame_of = {
        by_trigger: lambda image: round(image.get("TriggerTime", 0) / 40),
        by_reference: lambda image: int(image.get("FrameReferenceTime", 0) // 1000),
    }[stamp]
    frames = t4d.open_frames(folder)
    assert frames.space == "LPS" and frames.length_unit == "mm" and frames.size == series.SIZES
    for i, files in enumerate(files_of_frame(folder, frame_of)):
        samples, affine = by_itk(files)
        assert np.allclose(frames.affine, affine, atol=1e-6)
        assert np.allclose(frames.frame(i), samples, atol=1e-9)
    found = woven(folder)
    for i in (0, -1):
        files = files_of_frame(folder, frame_of)[i]
        assert np.linalg.norm(found["centroid"][i] - ball_by_itk(files)) < 0.02


def test_every_way_of_saying_it_gives_the_same_samples(tmp_path):
    expected = t4d.open_frames(series.classic(tmp_path / "plain", by_trigger))

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
    for package, uid in (("openjpeg", JPEG2000Lossless), ("jpeg_ls", JPEGLSLossless)):
        try:
            __import__(package)
            others.append(series.classic(tmp_path / package, by_trigger, compress=uid))
        except (ImportError, RuntimeError):
            continue  # pydicom has no encoder
    for path in others:
        frames = t4d.open_frames(path)
        assert np.allclose(frames.affine, expected.affine), path
        for mine, other in zip(frames, expected):
            assert np.array_equal(mine, other), path


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
    frames = t4d.open_frames(series.classic(tmp_path / "series", stamp))
    assert frames.time_unit == "s" and len(frames) == series.FRAMES
    assert frames.times[0] == pytest.approx(first, abs=2e-5)
    assert frames.times[-1] == pytest.approx(last, abs=2e-5)


@pytest.mark.parametrize("date", [None, "20260228"])
def test_midnight_passes_without_dates(tmp_path, date):
    def stamp(image, frame, k):
        if date:
            image.AcquisitionDate = date
        image.AcquisitionTime = ["235958.5", "235959.5", "000000.5", "000001.5"][frame]

    frames = t4d.open_frames(series.classic(tmp_path / "series", stamp))
    assert np.allclose(frames.times, [0, 1, 2, 3])
    assert any("midnight" in note for note in frames.notes)


def test_one_attribute_orders_the_whole_series(tmp_path):
    def stamp(image, frame, k):
        image.AcquisitionTime = f"1200{10 + frame:02d}"  # in the other order
        if (frame, k) != (2, 7):
            image.TriggerTime = 100 - 30 * frame

    said = refused(series.classic(tmp_path / "series", stamp))
    assert "has no TriggerTime" in said and "71 of 72" in said
    (lacking,) = [f for f in (tmp_path / "series").iterdir() if "TriggerTime" not in pydicom.dcmread(f)]
    assert str(lacking) in said


def test_an_attribute_that_makes_no_frames_is_named(tmp_path):
    def stamp(image, frame, k):
        image.TriggerTime = 40 * min(frame, 2) + k
        image.AcquisitionTime = f"1200{10 + frame:02d}"

    frames = t4d.open_frames(series.classic(tmp_path / "series", stamp))
    assert np.allclose(frames.times, [0, 1, 2, 3])
    assert any("TriggerTime makes no frames" in note and "AcquisitionTime does" in note for note in frames.notes)


def test_phases_of_a_gated_series_are_percent(tmp_path):
    path = series.enhanced(tmp_path / "enhanced.dcm")
    image = pydicom.dcmread(path)
    for group in image.PerFrameFunctionalGroupsSequence:
        phase = Dataset()
        phase.NominalPercentageOfCardiacPhase = 25.0 * (group.FrameContentSequence[0].TemporalPositionIndex - 1)
        group.CardiacSynchronizationSequence = Sequence([phase])
        del group.FrameContentSequence
    image.save_as(path)
    frames = t4d.open_frames(path)
    assert frames.times == [0, 25, 50, 75] and frames.time_unit == "%"


def test_rescale_is_exact_in_whole_numbers(tmp_path):
    def hounsfield(image, frame, k):
        by_trigger(image, frame, k)
        image.RescaleSlope, image.RescaleIntercept = 1, -1024
        image.BitsStored, image.HighBit = 12, 11

    folder = series.classic(tmp_path / "ct", hounsfield)
    frames = t4d.open_frames(folder)
    assert frames.dtype == np.int16
    files = files_of_frame(folder, lambda image: round(image.TriggerTime / 40))
    assert np.array_equal(frames.frame(1), by_itk(files[1])[0])


def test_the_modality_lut_makes_values(tmp_path):
    """The lut is a square root; SimpleITK leaves it out, so pydicom's dcmtk-like rule is held against numpy."""
    table = np.sqrt(np.arange(1024) * 64).round().astype(np.uint16)

    def looked_up(image, frame, k):
        by_trigger(image, frame, k)
        lut = Dataset()
        lut.LUTDescriptor = [1024, 0, 16]
        lut.ModalityLUTType = "US"
        lut.LUTData = table.tobytes()
        lut["LUTData"].VR = "OW"
        image.ModalityLUTSequence = Sequence([lut])
        image.RescaleSlope, image.RescaleIntercept = 7, 7  # which a LUT replaces

    frames = t4d.open_frames(series.classic(tmp_path / "lut", looked_up))
    assert np.array_equal(frames.frame(2), table[series.samples(2).transpose(2, 1, 0)])


@pytest.mark.parametrize("signed", [False, True])
def test_padding_is_no_data(tmp_path, signed):
    def padded(image, frame, k):
        by_trigger(image, frame, k)
        values = series.samples(frame)[k].astype(np.int16)
        values[:4] = -2000 if signed else 4000 + np.arange(4)[:, None]
        image.set_pixel_data(values.view(np.uint16) if not signed else values, "MONOCHROME2", 16)
        image.RescaleSlope, image.RescaleIntercept = 1, -100
        if signed:
            image.add_new("PixelPaddingValue", "SS", -2000)
        else:
            image.add_new("PixelPaddingValue", "US", 4000)
            image.add_new("PixelPaddingRangeLimit", "US", 4003)

    frames = t4d.open_frames(series.classic(tmp_path / "padded", padded))
    assert frames.padded and frames.whole and frames.dtype == np.float32
    frame = frames.frame(1)
    assert np.all(np.isnan(frame[:, :4])) and not np.any(np.isnan(frame[:, 4:]))
    assert np.array_equal(frame[:, 4:], series.samples(1).transpose(2, 1, 0)[:, 4:] - 100.0)
    assert np.array_equal(frames.filled(5).frame(1)[:, :4], np.full(frame[:, :4].shape, 5))


def test_a_tilted_gantry_keeps_the_volume(tmp_path):
    straight = woven(series.classic(tmp_path / "straight", by_trigger))
    tilted = woven(series.classic(tmp_path / "tilted", by_trigger, shear=(0, 0.5, 0)))
    assert tilted["volume"][0] == pytest.approx(straight["volume"][0])
    moved = tilted["centroid"][0] - straight["centroid"][0]
    assert moved[1] == pytest.approx(0.5 * (series.SIZES[2] - 1) / 2, abs=0.4)


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
        assert reason in refused(path), path


def test_a_film_is_refused(tmp_path):
    film = series.empty(tmp_path / "film.dcm")
    film.NumberOfFrames = 3
    film.PixelData = bytes(3 * 2 * series.SIZES[0] * series.SIZES[1])
    film.save_as(tmp_path / "film.dcm", enforce_file_format=True)
    assert "no positions of their own" in refused(tmp_path / "film.dcm")


def test_one_of_several_series_is_chosen(tmp_path):
    folder = series.classic(tmp_path / "both", by_trigger)
    long = "1.2.826.0.1.3680043.8.498.12345678901234567890123456789012345678"
    for file in series.classic(tmp_path / "more", by_trigger, series=long, number=7).iterdir():
        file.rename(folder / f"more{file.name}")
    os.mkfifo(folder / "pipe")
    (folder / "notes.txt").write_text("none of the series")
    (folder / "DICOMDIR").write_bytes(bytes(128) + b"DICM")
    said = refused(folder)
    assert "2 series" in said and said.count(long) == 1 and "1.2.3.4.5" in said
    by_number, by_uid = (t4d.open_frames(folder, series=which) for which in (7, long))
    assert all(np.array_equal(a, b) for a, b in zip(by_number, by_uid))
    assert "no series" in refused(folder, series=8)


def test_a_folder_below_is_named(tmp_path):
    (tmp_path / "patient" / "study").mkdir(parents=True)
    folder = series.classic(tmp_path / "patient" / "study" / "series", by_trigger)
    assert f"python3 -m t4d weave {folder}" in refused(tmp_path / "patient")


def test_a_damaged_file_is_refused(tmp_path):
    """Cut anywhere, and with any byte of its header changed: an error of this package or frames."""
    folder = series.classic(tmp_path / "series", by_trigger)
    file = sorted(folder.iterdir())[0]
    whole = file.read_bytes()
    random = np.random.default_rng(3)
    for _ in range(20):
        damaged = bytearray(whole)
        for at in random.integers(128, 1200, 3):
            damaged[at] = random.integers(256)
        end = len(whole) if random.random() < 0.5 else random.integers(len(whole))
        file.write_bytes(damaged[:end])
        try:
            for frame in t4d.open_frames(folder):
                assert frame.shape == series.SIZES
        except t4d.Error as error:
            assert str(error)


def test_real_slices_are_those_of_simpleitk(tmp_path):
    """MR_small of pydicom in all its codings, as a series of two frames of two slices."""
    examples = [pydicom.data.get_testdata_file(f"MR_small{kind}.dcm") for kind in (
        "", "_RLE", "_bigendian", "_implicit", "_jp2klossless", "_jpeg_ls_lossless", "_padded")]  # fmt: skip
    for example in examples:
        try:
            image = pydicom.dcmread(example)
            image.pixel_array
        except (RuntimeError, AttributeError, NotImplementedError):
            continue  # no decoder, or cut
        folder = tmp_path / os.path.basename(example)
        folder.mkdir()
        for n in range(4):
            image.TriggerTime = 100 * (n // 2)
            x, y, z = (float(v) for v in image.ImagePositionPatient)
            image.ImagePositionPatient = [x, y, (n % 2) * 2.0]
            image.SOPInstanceUID = f"1.2.3.{n}"
            image.save_as(folder / f"{n}.dcm")
        frames = t4d.open_frames(folder)
        expected, affine = by_itk([str(folder / "2.dcm"), str(folder / "3.dcm")])
        found = frames.frame(1)
        assert np.allclose(frames.affine, affine), example
        assert np.array_equal(found[~np.isnan(found)], expected[~np.isnan(found)]), example

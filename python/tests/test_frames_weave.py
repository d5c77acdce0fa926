"""Frames in ``t4d.weave``: the mesh is that of the array, where and when the input says."""

import subprocess
import sys
import warnings

import numpy as np
import pytest
import t4d


def ball(t):
    x, y, z = np.indices((12, 11, 10)) - np.array([4 + t, 5, 4.5]).reshape(3, 1, 1, 1)
    return np.clip(1000 - 200 * np.sqrt(x * x + y * y + z * z), 0, None).astype(np.int16)


FRAMES = np.stack([ball(t) for t in range(3)])


def alike(mesh, other):
    return all(np.array_equal(a, b) for a, b in zip(mesh.flat(), other.flat()))


@pytest.fixture
def tiff(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    sizes = {"PhysicalSizeX": 0.5, "PhysicalSizeY": 0.5, "PhysicalSizeZ": 2.0, "TimeIncrement": 3.0}
    tifffile.imwrite(tmp_path / "a.ome.tif", FRAMES.transpose(0, 3, 2, 1), photometric="minisblack",
                     metadata={"axes": "TZYX", **sizes})  # fmt: skip
    return tmp_path / "a.ome.tif"


def test_a_path_is_woven(tiff):
    expected = t4d.weave(FRAMES, iso=400, spacing=(0.5, 0.5, 2), times=[0, 3, 6])
    for source in (tiff, str(tiff), t4d.open_frames(tiff)):
        mesh = t4d.weave(source, iso=400)
        assert (mesh.length_unit, mesh.time_unit, mesh.space, mesh.up) == ("um", "s", "", "y")
        assert alike(mesh, expected)
    placed = t4d.weave(tiff, iso=400, spacing=2, origin=(1, 2, 3), times=[1, 2, 4], units=("mm", "d"))
    assert (placed.length_unit, placed.time_unit) == ("mm", "d")
    assert alike(placed, t4d.weave(FRAMES, iso=400, spacing=2, origin=(1, 2, 3), times=[1, 2, 4]))


def test_a_patient_has_z_up():
    nibabel = pytest.importorskip("nibabel")
    affine = np.array([[0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 2, 7], [0, 0, 0, 1.0]])
    image = nibabel.Nifti1Image(np.moveaxis(FRAMES, 0, 3), affine)
    image.header.set_xyzt_units("mm", "sec")
    mesh = t4d.weave(t4d.open_frames(image, frame_time=0.5), iso=400)
    assert (mesh.space, mesh.up, mesh.length_unit, mesh.time_unit) == ("RAS", "z", "mm", "s")
    assert alike(mesh, t4d.weave(FRAMES, iso=400, affine=affine, times=[0, 0.5, 1]))
    assert t4d.weave(t4d.open_frames(image, frame_time=0.5), iso=400, up="y").up == "y"


def test_samples_without_data_lie_outside(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["a"] = np.where(FRAMES > 900, -1, FRAMES)
        file["a"].attrs["_FillValue"] = np.int16(-1)
    hollow = np.where(FRAMES > 900, np.nan, FRAMES).astype(np.float32)
    assert alike(t4d.weave(tmp_path / "a.h5", iso=400), t4d.weave(hollow, iso=400, outside_value=np.nan))
    assert alike(t4d.weave(tmp_path / "a.h5", below=400), t4d.weave(hollow, below=400, outside_value=np.nan))
    value = int(FRAMES[0, 4, 5, 2])
    both = np.where(FRAMES == value, np.nan, hollow).astype(np.float32)
    without = t4d.weave(tmp_path / "a.h5", iso=400, outside_value=value)
    assert alike(without, t4d.weave(both, iso=400, outside_value=np.nan))
    assert alike(t4d.weave(tmp_path / "a.h5", label=value), t4d.weave(FRAMES, label=value))
    with pytest.raises(t4d.InvalidInput, match="whole numbers"):
        t4d.weave(tmp_path / "a.h5")


def test_losses_are_warned_of(tiff):
    frames = t4d.open_frames(tiff)
    frames.losses.append("the last bits are lost")
    with pytest.warns(t4d.Loss, match="the last bits"):
        t4d.weave(frames, iso=400)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        t4d.weave(t4d.open_frames(tiff), iso=400)


def dicom(folder):
    pydicom = pytest.importorskip("pydicom", "3")
    import dicom_series

    dicom_series.classic(folder / "scan", lambda image, frame, k: setattr(image, "TriggerTime", 40 * frame))
    return folder / "scan", max((folder / "scan").iterdir(), key=lambda file: pydicom.dcmread(file).TriggerTime)


def ome_tiff(folder):
    tifffile = pytest.importorskip("tifffile")
    tifffile.imwrite(folder / "a.ome.tif", FRAMES.transpose(0, 3, 2, 1), photometric="minisblack", compression="zlib",
                     metadata={"axes": "TZYX"})  # fmt: skip
    return folder / "a.ome.tif", folder / "a.ome.tif"


def zarr_array(folder):
    zarr = pytest.importorskip("zarr", "3")
    zarr.create_array(folder / "a.zarr", data=FRAMES, chunks=(1, 12, 11, 10), dimension_names=[*"txyz"])
    return folder / "a.zarr", folder / "a.zarr" / "c/2/0/0/0"


@pytest.mark.parametrize("make", [dicom, ome_tiff, zarr_array])
def test_a_last_frame_that_is_damaged_leaves_no_file(tmp_path, make):
    path, last = make(tmp_path)
    (tmp_path / "out").mkdir()

    def woven():
        words = [sys.executable, "-m", "t4d", "weave", path, "--iso", "400", "-o", tmp_path / "out" / "a.t4d"]
        done = subprocess.run(words, capture_output=True, text=True, timeout=60)
        return done.returncode, [file.name for file in (tmp_path / "out").iterdir()], done.stderr

    assert woven()[:2] == (0, ["a.t4d"])
    (tmp_path / "out" / "a.t4d").unlink()
    last.write_bytes(last.read_bytes()[:-200])
    code, left, said = woven()
    assert (code, left) == (4, []) and said.startswith(f"t4d: {tmp_path}") and said.count("\n") == 1, said

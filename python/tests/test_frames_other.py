"""HDF5 and NetCDF, medical images, VTK, and arrays of other libraries: against what wrote them, and against ITK."""

import os
import sys

import numpy as np
import pytest
import t4d

SIZES = (4, 7, 6, 5)  # t, x, y, z


def samples(kind=np.float32):
    """(t, x, y, z), of which no axis can be taken for another."""
    t, x, y, z = np.indices(SIZES)
    return (x + 7 * y + 42 * z + 210 * t + 1).astype(kind)


def same(frames, array=None):
    wanted = samples() if array is None else array
    assert len(frames) == len(wanted)
    for mine, other in zip(frames, wanted):
        assert np.array_equal(mine, other, equal_nan=mine.dtype.kind == "f")
    return frames


def refused(source, **options):
    with pytest.raises(t4d.Error) as error:
        for _ in t4d.open_frames(source, **options):
            pass
    return str(error.value)


# HDF5 and NetCDF -----------------------------------------------------------------------------------


def test_an_array_by_its_path(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["one/data"] = samples().transpose(0, 3, 2, 1)
        file["one/table"] = np.zeros((3, 3))
    frames = same(t4d.open_frames(tmp_path / "a.h5", axes="tzyx"))
    assert any("one/data" in note for note in frames.notes) and frames.affine is None
    with h5py.File(tmp_path / "a.h5", "a") as file:
        file["two"] = np.zeros((2, 3, 4, 5))
        same(t4d.open_frames(file["one/data"], axes="tzyx"))
    assert "has 2 arrays" in refused(tmp_path / "a.h5") and "one/data (4, 5, 6, 7)" in refused(tmp_path / "a.h5")
    same(t4d.open_frames(tmp_path / "a.h5", dataset="/one/data", axes="tzyx", region="1:4,:,:,1:3"),
         samples()[1:3, 1:4])
    assert "has no array 'three'" in refused(tmp_path / "a.h5", dataset="three")
    (tmp_path / "b.h5").write_bytes((tmp_path / "a.h5").read_bytes()[:3000])
    assert str(tmp_path / "b.h5") in refused(tmp_path / "b.h5")


def netcdf(xarray, path, engine="h5netcdf", **how):
    packed = xarray.DataArray(
        samples().transpose(0, 3, 2, 1), dims=("time", "z", "y", "x"), name="rain",
        coords={"time": ("time", [0.0, 1.5, 4.0, 5.0], {"units": "hours"}),
                "z": ("z", 100 + 20.0 * np.arange(5), {"units": "m"}), "y": ("y", 3.0 - np.arange(6), {"units": "km"}),
                "x": ("x", 2.0 * np.arange(7), {"units": "km"})},
    )  # fmt: skip
    packed.to_netcdf(path, engine=engine, **how)
    return packed


def test_netcdf_has_coordinates_with_units(tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    array = netcdf(xarray, tmp_path / "a.nc")
    expected = np.diag([2, -1, 0.02, 1])
    expected[:3, 3] = 0, 3, 0.1
    for frames in (t4d.open_frames(tmp_path / "a.nc"), t4d.open_frames(array)):
        same(frames)
        assert (frames.times, frames.time_unit, frames.length_unit) == ([0, 1.5, 4, 5], "h", "km")
        assert np.allclose(frames.affine, expected) and frames.unsized == "" and frames.assumed_axes == []


def test_packed_values_and_missing_ones(tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    values = samples(np.float64)
    values[1, 2, 3, 4] = np.nan
    array = xarray.DataArray(values, dims=("t", "x", "y", "z"), name="a")
    array.to_netcdf(tmp_path / "a.nc", engine="h5netcdf",
                    encoding={"a": {"dtype": "i2", "scale_factor": 0.5, "add_offset": 10, "_FillValue": -999}})
    frames = t4d.open_frames(tmp_path / "a.nc")
    assert frames.padded and frames.whole
    same(frames, xarray.open_dataarray(tmp_path / "a.nc").values)


def test_axes_that_are_not_even_are_refused(tmp_path):
    xarray = pytest.importorskip("xarray")
    array = xarray.DataArray(samples(), dims=("t", "x", "y", "z"), coords={"x": [0, 1, 2, 3, 4, 5, 7]})
    assert "coordinates along x are not evenly spaced" in refused(array)
    moments = np.datetime64("2020-01-01T23:59:58") + np.array([0, 1, 2, 5]) * np.timedelta64(1, "s")
    dated = xarray.DataArray(samples(), dims=("time", "x", "y", "z"), coords={"time": moments})
    assert (t4d.open_frames(dated).times, t4d.open_frames(dated).time_unit) == ([0, 1, 2, 5], "s")


# Medical images ------------------------------------------------------------------------------------


def image4d(sitk):
    image = sitk.GetImageFromArray(samples().transpose(0, 3, 2, 1), isVector=False)
    turn = np.eye(4)
    turn[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    image.SetDirection(turn.ravel().tolist())
    image.SetSpacing([0.5, 0.75, 2, 0.25])
    image.SetOrigin([10, 20, 30, 1.5])
    return image


def placed(affine):
    expected = np.array([[0, -0.75, 0, 10], [0.5, 0, 0, 20], [0, 0, 2, 30], [0, 0, 0, 1]])
    return np.allclose(affine, expected)


@pytest.mark.parametrize("name", ["a.mha", "a.mhd", "a.nrrd", "packed.mha"])
def test_images_of_itk(tmp_path, name):
    sitk = pytest.importorskip("SimpleITK")
    sitk.WriteImage(image4d(sitk), str(tmp_path / name), useCompression=name.startswith("packed"))
    frames = same(t4d.open_frames(tmp_path / name))
    # ITK writes a space of four dimensions into NRRD, which says nothing of a patient.
    said = ("", "") if name == "a.nrrd" else ("LPS", "mm")
    assert placed(frames.affine) and (frames.space, frames.length_unit) == said
    assert np.allclose(frames.times, [1.5, 1.75, 2, 2.25])
    itk = pytest.importorskip("itk")
    judge = itk.imread(str(tmp_path / name))  # of another interface
    array = itk.array_from_image(judge)
    assert np.array_equal(array[2].T, frames.frame(2))
    assert np.allclose([*judge.GetOrigin()][:3], frames.affine[:3, 3])
    cut = t4d.open_frames(tmp_path / name, region="1:5,2:6,:,1:3")
    same(cut, samples()[1:3, 1:5, 2:6])


def test_images_that_are_open(tmp_path):
    sitk = pytest.importorskip("SimpleITK")
    image = image4d(sitk)
    assert placed(same(t4d.open_frames(image)).affine)
    volumes = [image[:, :, :, i] for i in range(4)]
    frames = same(t4d.open_frames(volumes, times=[0, 2, 3, 7]))
    assert placed(frames.affine) and frames.times == [0, 2, 3, 7]
    volumes[2].SetOrigin([11, 20, 30])
    assert "is placed elsewhere in space" in refused(volumes)


SEQUENCE = """NRRD0005
type: float
dimension: 4
space: right-anterior-superior
sizes: 4 7 6 5
space directions: none (0.5,0,0) (0,0.75,0) (0,0,2)
kinds: list domain domain domain
endian: little
encoding: raw
space origin: (-10,-20,30)
axis 0 index type:=numeric
axis 0 index unit:=ms
axis 0 index values:=0 40 85 120

"""


def test_sequences_of_slicer(tmp_path):
    """RAS in the file; ITK makes it LPS, which is said."""
    pytest.importorskip("SimpleITK")
    body = samples().astype("<f4").transpose(3, 2, 1, 0).tobytes()
    (tmp_path / "a.seq.nrrd").write_bytes(SEQUENCE.encode() + body)
    frames = same(t4d.open_frames(tmp_path / "a.seq.nrrd"))
    assert (frames.times, frames.time_unit, frames.space) == ([0, 40, 85, 120], "ms", "LPS")
    assert np.allclose(frames.affine, [[-0.5, 0, 0, 10], [0, -0.75, 0, 20], [0, 0, 2, 30], [0, 0, 0, 1]])


@pytest.mark.parametrize("name", ["a.nii", "a.nii.gz", "a.mgz"])
def test_images_of_nibabel(tmp_path, name):
    """RAS, against SimpleITK, which has LPS."""
    nibabel = pytest.importorskip("nibabel")
    sitk = pytest.importorskip("SimpleITK")
    affine = np.array([[0, -0.75, 0, 10], [0.5, 0, 0, 20], [0, 0, 2, 30], [0, 0, 0, 1.0]])
    kind = nibabel.freesurfer.MGHImage if name == "a.mgz" else nibabel.Nifti1Image
    image = kind(samples().transpose(1, 2, 3, 0), affine)
    if name != "a.mgz":
        image.header.set_xyzt_units("mm", "msec")
        image.header.set_zooms((0.5, 0.75, 2, 40))
    nibabel.save(image, tmp_path / name)
    frames = same(t4d.open_frames(tmp_path / name))
    assert np.allclose(frames.affine, affine) and frames.space == "RAS" and frames.length_unit == "mm"
    if name != "a.mgz":
        assert np.allclose(frames.times, [0, 40, 80, 120]) and frames.time_unit == "ms"
        judge = sitk.ReadImage(str(tmp_path / name))
        assert np.allclose(np.diag([-1, -1, 1]) @ frames.affine[:3, 3], judge.GetOrigin()[:3], atol=1e-5)
        assert np.array_equal(sitk.GetArrayFromImage(judge)[3].T, frames.frame(3))
    same(t4d.open_frames(nibabel.load(tmp_path / name)))


def test_real_images_of_nibabel():
    """minc1_4d, minc2_4d, example4d: against nibabel's own array, and SimpleITK where it reads them."""
    nibabel = pytest.importorskip("nibabel")
    folder = os.path.join(os.path.dirname(nibabel.__file__), "tests", "data")
    for name in ("minc1_4d.mnc", "minc2_4d.mnc", "example4d.nii.gz", "functional.nii"):
        path = os.path.join(folder, name)
        if not os.path.exists(path):
            continue
        if name.startswith("minc2"):
            pytest.importorskip("h5py")
        image = nibabel.load(path)
        frames = t4d.open_frames(path)
        # The files of MINC say time, zspace, yspace, xspace.
        data = np.moveaxis(image.get_fdata(), 0 if name.endswith(".mnc") else 3, 0)
        assert np.allclose(frames.affine, image.affine) and len(frames) == len(data) == (2 if "4d" in name else 20), name
        assert all(map(np.allclose, frames, data)), name


# VTK -----------------------------------------------------------------------------------------------


def test_volumes_of_vtk(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    entries = []
    for t, frame in enumerate(samples()):
        grid = pyvista.ImageData(dimensions=frame.shape, spacing=(0.5, 0.75, 2), origin=(10, 20, 30))
        grid.point_data["density"] = frame.ravel(order="F")
        grid.save(tmp_path / f"v{t}.vti")
        entries.append(f'<DataSet timestep="{(0, 1.5, 2, 7)[t]}" part="0" file="v{t}.vti"/>')
    (tmp_path / "a.pvd").write_text(
        f'<?xml version="1.0"?><VTKFile type="Collection"><Collection>{"".join(entries)}</Collection></VTKFile>'
    )
    frames = same(t4d.open_frames(tmp_path / "a.pvd"))
    assert frames.times == [0, 1.5, 2, 7] and frames.unsized == ""
    assert np.allclose(frames.affine, [[0.5, 0, 0, 10], [0, 0.75, 0, 20], [0, 0, 2, 30], [0, 0, 0, 1]])
    files = same(t4d.open_frames([tmp_path / f"v{t}.vti" for t in range(4)], region="1:4,:,:"), samples()[:, 1:4])
    assert files.times is None and np.allclose(files.affine[:3, 3], (10.5, 20, 30))
    grid.cell_data["pressure"] = np.arange(6 * 5 * 4.0)
    grid.save(tmp_path / "c.vti")
    assert "several arrays; there are: density, pressure" in refused(tmp_path / "c.vti")
    cells = t4d.open_frames([tmp_path / "c.vti"] * 2, dataset="pressure")
    assert cells.size == (6, 5, 4) and np.allclose(cells.affine[:3, 3], (10.25, 20.375, 31))
    assert np.array_equal(cells.frame(0).ravel(order="F"), np.arange(120))


# Arrays --------------------------------------------------------------------------------------------


def test_arrays_over_time(tmp_path):
    same(t4d.open_frames(samples()))
    assert t4d.open_frames(samples()).assumed_axes == ["txyz"]
    same(t4d.open_frames(samples().transpose(3, 2, 1, 0), axes="zyxt"))
    np.save(tmp_path / "a.npy", samples())
    same(t4d.open_frames(tmp_path / "a.npy"))
    dask = pytest.importorskip("dask.array")
    same(t4d.open_frames(dask.from_array(samples(), chunks=2)))
    with pytest.raises(TypeError, match="expected a path"):
        t4d.open_frames(5)
    with pytest.raises(t4d.Unsupported, match="complex"):
        t4d.open_frames(samples().astype(complex))


class Counted:
    """An array that says what is read."""

    def __init__(self, array, chunks=None):
        self.array, self.shape, self.dtype, self.read = array, array.shape, array.dtype, []
        if chunks:
            self.chunks = chunks

    def __getitem__(self, at):
        self.read.append(at)
        return self.array[at]


def test_frames_are_read_when_they_are_asked_for():
    array = Counted(samples())
    frames = t4d.open_frames(array, axes="txyz", region="1:3,:,:,1:4")
    assert array.read == []
    frames.frame(1)
    assert array.read == [(2, slice(1, 3), slice(0, 6), slice(0, 5))]
    chunked = Counted(samples(), (2, 7, 6, 5))
    same(t4d.open_frames(chunked, axes="txyz"))
    assert [at[0] for at in chunked.read] == [slice(0, 2), slice(2, 4)]  # each chunk once


def test_what_the_caller_says_takes_the_place():
    frames = t4d.open_frames(samples(), axes="txyz", spacing=(1, 2, 3), origin=(4, 5, 6), frame_time=0.5, start_time=2,
                             length_unit="mm", time_unit="s")
    assert np.array_equal(frames.affine, [[1, 0, 0, 4], [0, 2, 0, 5], [0, 0, 3, 6], [0, 0, 0, 1]])
    assert frames.times == [2, 2.5, 3, 3.5] and (frames.length_unit, frames.time_unit) == ("mm", "s")
    assert t4d.open_frames(samples(), times=[0, 1, 3, 9], region=":,:,:,1:3").times == [1, 3]
    assert "3 times for 4 frames" in refused(samples(), times=[0, 1, 2])
    assert "do not increase" in refused(samples(), times=[0, 1, 1, 2])
    for region, said in (("9:10,:,:", "along x, where there are 7"), (":,:,:,1:2", "one frame")):
        assert said in refused(samples(), region=region)
    for region in ("1:2", "a:2,:,:", "3:2,:,:"):
        with pytest.raises(ValueError):
            t4d.open_frames(samples(), region=region)
    for wrong in ({"axes": "tzz"}, {"channel": -1}, {"spacing": 0}):
        with pytest.raises(ValueError):
            t4d.open_frames(samples(), **wrong)


def test_samples_without_data():
    array = samples()
    frames = t4d.open_frames(array).without(array[1, 1, 1, 1])
    assert frames.padded and np.isnan(frames.frame(1)).sum() == 1
    assert np.array_equal(frames.filled(array[1, 1, 1, 1]).frame(1), array[1])


def test_a_missing_library_names_the_extra(tmp_path, monkeypatch):
    for name, package, extra in (("a.tif", "tifffile", "tiff"), ("a.h5", "h5py", "hdf5"), ("a.dcm", "pydicom", "dicom"),
                                 ("a.zarr", "zarr", "zarr"), ("a.mha", "SimpleITK", "itk")):  # fmt: skip
        (tmp_path / name).write_bytes(bytes(200))
        for module in [module for module in sys.modules if module.partition(".")[0] == package]:
            monkeypatch.delitem(sys.modules, module)
        monkeypatch.setitem(sys.modules, package, None)
        with pytest.raises(t4d.Unsupported, match=rf"pip install t4d\[{extra}\]"):
            t4d.open_frames(tmp_path / name)


def test_folders_and_names(tmp_path):
    assert "holds no frames" in refused(tmp_path)
    assert "No such file" in refused(tmp_path / "none")
    (tmp_path / "a.vdb").write_bytes(b"")
    assert "program alone" in refused(tmp_path / "a.vdb")
    (tmp_path / "a.txt").write_text("a")
    assert "of no kind" in refused(tmp_path / "a.txt")
    np.save(tmp_path / "a.npy", samples())
    assert "not of one kind" in refused([tmp_path / "a.npy", tmp_path / "a.tif"])

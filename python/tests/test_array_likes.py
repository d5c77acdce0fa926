"""Arrays that are read when they are asked for are woven frame by frame.

Runs with Debian's h5py, zarr and dask, and in tests/.venv with today's, where numpy is 2."""

import os
import subprocess
import weakref

import dask.array
import h5py
import numpy as np
import pytest
import t4d
import zarr

FRAMES = 5


@pytest.fixture(scope="module")
def labels():
    """Two solids that grow and move, without any symmetry; background 0."""
    x, y, z = np.indices((20, 16, 18))
    frames = np.zeros((FRAMES, 20, 16, 18), np.uint16)
    for i, frame in enumerate(frames):
        frame[(x - 6 - i) ** 2 + 2 * (y - 7) ** 2 + (z - 5) ** 2 < 16 + i] = 2
        frame[(x - 12) ** 2 + (y - 8) ** 2 + 2 * (z - 12 + i / 2) ** 2 < 10] = 300
    return frames


class Recorder:
    """It has a shape and gives its parts, no more. Records what is asked of it, and how much of that
    is still there."""

    def __init__(self, frames):
        self.shape = frames.shape
        self.asked = []
        self.live = self.most = 0
        self._frames = frames

    def __getitem__(self, index):
        self.asked.append(index)
        frame = np.array(self._frames[index])
        self.live += 1
        self.most = max(self.most, self.live)
        weakref.finalize(frame, self._gone)
        return frame

    def _gone(self):
        self.live -= 1


def memmapped(labels, folder):
    np.save(folder / "a.npy", labels)
    return np.load(folder / "a.npy", mmap_mode="r")


def in_hdf5(labels, folder):
    with h5py.File(folder / "a.h5", "w") as file:
        file.create_dataset("a", data=labels, chunks=(2, 10, 8, 9), compression="gzip")
    return h5py.File(folder / "a.h5", "r")["a"]


def in_zarr(labels, folder):
    made = zarr.open(str(folder / "a.zarr"), mode="w", shape=labels.shape, dtype=labels.dtype,
                     chunks=(1, 10, 8, 9))  # fmt: skip
    made[:] = labels
    return zarr.open(str(folder / "a.zarr"), mode="r")


def in_dask(labels, folder):
    return dask.array.from_array(labels.astype(">u2"), chunks=(2, 7, 16, 18))


KINDS = [memmapped, in_hdf5, in_zarr, in_dask, lambda labels, _: list(labels), lambda labels, _: Recorder(labels)]


@pytest.mark.parametrize("kind", KINDS)
def test_any_array_is_woven_as_one_of_numpy(labels, tmp_path, kind):
    frames = kind(labels, tmp_path)
    options = dict(label=2, spacing=(0.5, 1, 2), units=("um", "s"))
    t4d.weave(labels, **options).save(tmp_path / "array.t4d")
    t4d.weave(frames, **options).save(tmp_path / "kind.t4d")
    assert (tmp_path / "kind.t4d").read_bytes() == (tmp_path / "array.t4d").read_bytes()
    both = t4d.weave(frames, label=[2, 300])
    times = np.linspace(0, FRAMES - 1, 9)
    for i, label in enumerate((2, 300)):
        assert np.array_equal(both[i].volumes(times), t4d.weave(labels == label).volumes(times))


def test_a_frame_is_read_at_a_time(labels, tmp_path):
    frames = Recorder(labels)
    mesh = t4d.weave(frames, label=2)
    assert frames.asked == []
    mesh.save(tmp_path / "mesh.t4d")
    assert frames.asked == list(range(FRAMES))
    assert frames.most <= 2
    # An iterator of zarr 2 would take all 5 frames of a chunk at once.
    with pytest.raises(t4d.InvalidInput, match=r"shape \(5, 20, 16\); expected \(nt, nx, ny, nz\)"):
        t4d.weave(Recorder(labels[..., 0]), label=2)
    with pytest.raises(t4d.InvalidInput, match="4 times for 5 frames"):
        t4d.weave(frames, label=2, times=range(4))


def test_memory_is_that_of_two_frames(tmp_path):
    """The array is computed frame by frame, however many frames there are."""
    script = (
        "import resource, sys, dask.array as da, numpy as np, t4d\n"
        "def frame(i):\n"
        "    frame = np.zeros((128,) * 3, np.float32)\n"
        "    frame[20 + i % 20:60, 30:70, 40:80] = 1\n"
        "    return frame\n"
        "frames = da.map_blocks(lambda block_info: frame(block_info[None]['chunk-location'][0])[None],\n"
        "                       chunks=((1,) * int(sys.argv[1]), (128,), (128,), (128,)), dtype=np.float32)\n"
        "t4d.weave(frames, iso=0.5).save(sys.argv[2])\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)\n"
    )

    def peak(count):
        command = [os.sys.executable, "-c", script, str(count), str(tmp_path / "x.t4d")]
        return int(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

    # A frame has 8 MiB.
    assert peak(64) - peak(8) < 40 << 10


def test_units_are_those_of_length_and_time(labels):
    for units, expected in [("mm", ("mm", "")), (("um", "ms"), ("um", "ms")), (None, ("", ""))]:
        mesh = t4d.weave(labels, label=2, units=units)
        assert (mesh.length_unit, mesh.time_unit) == expected
    with pytest.raises(TypeError, match="in place of|takes the place of"):
        t4d.weave(labels, label=2, units="mm", length_unit="mm")
    for wrong, error in [(("mm",), ValueError), (("mm", 3), TypeError), (5, TypeError)]:
        with pytest.raises(error):
            t4d.weave(labels, label=2, units=wrong)

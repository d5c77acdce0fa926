"""Frames as the program reads them: as a stream for `t4d weave -`, a line of JSON and then each frame as a .npy
(docs/frame-stream.md), and as a .nrrd."""

from __future__ import annotations

import io
import json
from concurrent.futures import ThreadPoolExecutor
from typing import IO, Any, Dict, Optional, Tuple

import numpy as np
from numpy.typing import NDArray

from t4d.errors import InvalidInput
from t4d.frames import Frames


def header_of(frames: Frames, part: Optional[Tuple[int, int]] = None) -> Dict[str, Any]:
    """The members of the header; those that say nothing are left out. ``part`` has the first and the last frame
    that follow, if not all do."""
    said = {
        "format": "t4d-frames", "version": 1, "size": list(frames.size), "frames": len(frames),
        "times": frames.times, "affine": None if frames.affine is None else frames.affine[:3].tolist(),
        "unsized": "" if frames.affine is None else frames.unsized, "length_unit": frames.length_unit,
        "time_unit": frames.time_unit, "space": frames.space, "assumed_axes": frames.assumed_axes,
        "mask": frames.mask, "names": frames.names, "notes": frames.notes, "losses": frames.losses,
        "part": None if part is None else list(part), "name": frames.name,
        "region": frames.region and dict(zip(("size", "first"), frames.region)),
    }  # fmt: skip
    return {name: value for name, value in said.items() if value not in (None, "", False, [])}


def write_stream(frames: Frames, file: IO[bytes], part: Optional[Tuple[int, int]] = None) -> None:
    """Writes the header and the frames, two of which are in memory: the next one is read while one is written.
    Raises what reading raises, and BrokenPipeError if nobody takes them."""
    head = json.dumps(header_of(frames, part), allow_nan=False, ensure_ascii=False)
    file.write(head.encode(errors="replace") + b"\n")  # names may not be UTF-8
    first, last = part or (0, len(frames) - 1)
    fortran: Optional[bool] = None
    reader = ThreadPoolExecutor(1)
    try:
        following = reader.submit(frames.frame, first)
        for number in range(first, last + 1):
            frame = following.result()
            if number < last:
                following = reader.submit(frames.frame, number + 1)
            fortran = not frame.flags.c_contiguous if fortran is None else fortran
            _write_npy(frame, file, fortran)
            del frame
    finally:
        reader.shutdown(wait=False)  # a signal does not wait for a frame
    file.flush()


def _write_npy(array: NDArray[Any], file: IO[bytes], fortran: bool) -> None:
    """Writes samples in one order for all frames; without a copy of samples that are in memory in this order."""
    dense: Any = np.asfortranarray(array) if fortran else np.ascontiguousarray(array)
    npy: Any = np.lib.format
    begin = io.BytesIO()
    described = {"descr": npy.dtype_to_descr(dense.dtype), "fortran_order": fortran, "shape": dense.shape}
    npy.write_array_header_1_0(begin, described)
    file.write(begin.getvalue())
    file.write(memoryview(dense.T if fortran else dense).cast("B"))


def write_nrrd(frames: Frames, path: str) -> None:
    """Writes numbers, as floats; samples without data are 0. One frame is in memory at a time."""
    if frames.mask:
        raise InvalidInput("has bools as samples; expected numbers", frames.name)
    frames = frames.filled(0) if frames.padded else frames
    kind = np.result_type(frames.dtype, np.float32).newbyteorder("<")
    affine = np.eye(4) if frames.affine is None else frames.affine
    x, y, z, origin = (f"({','.join(repr(float(one)) for one in column)})" for column in affine[:3].T)
    fields = {
        "type": "float" if kind.itemsize == 4 else "double", "dimension": 4, "space dimension": 3,
        "sizes": " ".join(map(str, (*frames.size, len(frames)))), "kinds": "space space space time",
        "space directions": f"{x} {y} {z} none", "space origin": origin, "endian": "little", "encoding": "raw",
    }  # fmt: skip
    with open(path, "wb") as file:
        file.write("".join(["NRRD0004\n", *(f"{name}: {value}\n" for name, value in fields.items()), "\n"]).encode())
        for frame in frames:
            file.write(np.asarray(frame, kind).tobytes(order="F"))

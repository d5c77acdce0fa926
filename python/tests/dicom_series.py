"""Writes DICOM series of a moving ball with pydicom, for tests."""

import functools
from pathlib import Path

import numpy as np
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
from pydicom.sequence import Sequence
from pydicom.uid import ExplicitVRLittleEndian, generate_uid

SPACING = np.array([1.5, 2.0, 2.5])  # mm along columns, rows and slices
SIZES = (26, 22, 18)
ORIGIN = np.array([-40.0, 25.0, 100.0])
TURNED = np.linalg.qr(np.array([[0.9, 0.2, -0.4], [-0.1, 0.95, 0.3], [0.4, -0.25, 0.86]]))[0]
FRAMES = 4


def axes(oblique):
    """Unit vectors along rows, columns and slices, the last their cross product."""
    turned = TURNED if oblique else np.eye(3)
    x, y = turned[:, 0], turned[:, 1]
    return np.stack([x, y, np.cross(x, y)], axis=1)


@functools.lru_cache
def samples(frame):
    """A ball of 9 mm as (z, y, x): 1000 at its middle, falling by 50 a millimetre."""
    at = np.stack(np.meshgrid(*(np.arange(n) for n in SIZES), indexing="ij"), -1) * SPACING
    middle = (np.array(SIZES) - 1) / 2 * SPACING + np.array([1.2, -0.7, 0.9]) * (frame - 1.5)
    values = 1000 - 50 * np.linalg.norm(at - middle, axis=-1)
    return np.maximum(values, 0).round().astype(np.uint16).transpose(2, 1, 0)


def empty(path, uid="1.2.840.10008.5.1.4.1.1.4", syntax=ExplicitVRLittleEndian):
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID = uid
    meta.MediaStorageSOPInstanceUID = generate_uid()
    meta.TransferSyntaxUID = syntax
    image = FileDataset(str(path), {}, file_meta=meta, preamble=b"\0" * 128)
    image.SOPClassUID = uid
    image.SOPInstanceUID = meta.MediaStorageSOPInstanceUID
    image.PatientName, image.PatientID = "Ball^Moving", "1"
    image.StudyInstanceUID = "1.2.3.4"
    image.SamplesPerPixel, image.PhotometricInterpretation = 1, "MONOCHROME2"
    image.Rows, image.Columns = SIZES[1], SIZES[0]
    image.BitsAllocated, image.BitsStored, image.HighBit = 16, 16, 15
    image.PixelRepresentation = 0
    return image


def placed(oblique, k, shear=(0, 0, 0)):
    turned = axes(oblique)
    position = ORIGIN + turned[:, 2] * SPACING[2] * k + np.array(shear) * k
    return ([round(float(v), 9) for v in position],
            [round(float(v), 9) for v in np.r_[turned[:, 0], turned[:, 1]]],
            [float(SPACING[1]), float(SPACING[0])])  # fmt: skip


def classic(folder, stamp, oblique=False, series="1.2.3.4.5", number=1, change=None,
            frames=FRAMES, shear=(0, 0, 0), compress=None):  # fmt: skip
    """A file a slice and frame, in names that do not sort by either. `stamp` sets the times of an
    image from its frame and slice, `change` anything else."""
    folder = Path(folder)
    folder.mkdir(exist_ok=True)
    order = np.random.default_rng(1).permutation(frames * SIZES[2])
    for n in range(frames * SIZES[2]):
        frame, k = divmod(n, SIZES[2])
        path = folder / f"IM{order[n]:04d}"
        image = empty(path)
        image.SeriesInstanceUID, image.SeriesNumber = series, number
        image.SeriesDescription = f"ball {number}"
        position, orientation, spacing = placed(oblique, k, shear)
        image.ImagePositionPatient, image.ImageOrientationPatient = position, orientation
        image.PixelSpacing = spacing
        image.set_pixel_data(samples(frame % FRAMES)[k], "MONOCHROME2", 16)
        stamp(image, frame, k)
        if change is not None and change(image, frame, k) is False:
            continue
        if compress is not None:
            image.compress(compress)
        image.save_as(path, enforce_file_format=True)
    return folder


def enhanced(path, oblique=False):
    """All in one file, its frames in an order of its own, with the times in seconds."""
    image = empty(path, "1.2.840.10008.5.1.4.1.1.2.1")
    image.SeriesInstanceUID, image.SeriesNumber = "1.2.3.4.6", 2
    image.SeriesDescription = "enhanced ball"
    order = np.random.default_rng(2).permutation(FRAMES * SIZES[2])
    image.NumberOfFrames = len(order)
    shared = Dataset()
    measures = Dataset()
    groups, planes = [], []
    for n in order:
        frame, k = divmod(int(n), SIZES[2])
        position, orientation, spacing = placed(oblique, k)
        group, place, direction, content = Dataset(), Dataset(), Dataset(), Dataset()
        place.ImagePositionPatient = position
        direction.ImageOrientationPatient = orientation
        content.FrameAcquisitionDateTime = f"20260101235959.{frame * 200000:06d}"
        content.TemporalPositionIndex = frame + 1
        group.PlanePositionSequence = Sequence([place])
        group.PlaneOrientationSequence = Sequence([direction])
        group.FrameContentSequence = Sequence([content])
        groups.append(group)
        planes.append(samples(frame)[k])
    measures.PixelSpacing = spacing
    shared.PixelMeasuresSequence = Sequence([measures])
    image.SharedFunctionalGroupsSequence = Sequence([shared])
    image.PerFrameFunctionalGroupsSequence = Sequence(groups)
    image.PixelData = np.stack(planes).astype("<u2").tobytes()
    image.save_as(path, enforce_file_format=True)
    return path

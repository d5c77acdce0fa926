"""Zarr 2 and 3, and OME-Zarr 0.1 to 0.5, with zarr-python: a folder, a .zip, or a URL of fsspec."""

from __future__ import annotations

import json
import os
import re
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from t4d.errors import InvalidInput, Unsupported
from t4d.readers.coordinates import Coordinates, volume_of
from t4d.readers.units import in_one_unit, unit_named
from t4d.readers.volume import (
    Choice, Missing, Volume, axis_named, choose_channel, library, listed, number_of, through, unknown_axes, usable,
)  # fmt: skip

OPTIONS = ("axes", "channel", "level", "dataset")

_METADATA = ("zarr.json", ".zgroup", ".zarray", ".zattrs")
_MOST_COUNTED = 1 << 16  # chunks: zarr-python goes through the names of all


def is_zarr(path: str) -> bool:
    """Whether it is a URL, a folder that holds metadata of Zarr or has .zarr in its path, or a .zarr.zip."""
    if "://" in path or path.lower().endswith(".zarr.zip"):
        return True
    if any(part.lower().endswith(".zarr") for part in os.path.normpath(path).split(os.sep)):
        return True
    return any(os.path.isfile(os.path.join(path, name)) for name in _METADATA)


def read(paths: Sequence[str], choice: Choice) -> List[Volume]:
    return [_read(path, choice) for path in paths]


def shown(url: str) -> str:
    """A URL without the user, the password and the words behind "?" in it; a path as it is."""
    return re.sub(r"://(?:[^/]*@)?([^?#]*).*", r"://\1", url)


def _read(path: str, choice: Choice) -> Volume:
    where = shown(path)
    zarr = library("zarr", "zarr", where, "Zarr")
    with through(where):
        zipped = path.lower().endswith(".zip") and "://" not in path
        if not zipped:
            _check_metadata(path)
        try:
            node = zarr.open(zarr.storage.ZipStore(path, mode="r") if zipped else path, mode="r")
        except (FileNotFoundError, KeyError) as error:  # zarr has exceptions of its own, which are of these
            raise InvalidInput("has none of zarr.json, .zarray and .zgroup, so it is no Zarr", where) from error
        return of_node(node, where, choice, "" if zipped else path)


def _check_metadata(path: str) -> None:
    """Raises InvalidInput if a key is given twice in the JSON of a node: zarr takes the last one."""

    def once(pairs: List[Tuple[str, Any]]) -> Dict[str, Any]:
        keys = [key for key, _ in pairs]
        twice = [key for key in keys if keys.count(key) > 1]
        if twice:
            raise InvalidInput(f"has the key '{twice[0]}' twice", place)
        return dict(pairs)

    for name in _METADATA:
        place = f"{shown(path).rstrip('/')}/{name}"
        with through(place):
            json.loads(_contents(path, name) or b"{}", object_pairs_hook=once)


def _contents(path: str, name: str) -> Optional[bytes]:
    """The contents of a file of a store; None if it is not there."""
    try:
        if "://" in path:
            files, root = library("fsspec", "zarr", shown(path), "a URL").core.url_to_fs(path)
            return bytes(files.cat_file(f"{root.rstrip('/')}/{name}"))
        _check_regular(os.path.join(path, name))
        with open(os.path.join(path, name), "rb") as file:
            return file.read()
    except (FileNotFoundError, NotADirectoryError):
        return None


def _check_regular(file: str) -> None:
    if os.path.lexists(file) and not os.path.isfile(file):  # a pipe never ends
        raise InvalidInput("is not a regular file", file)


def of_node(node: Any, where: str, choice: Choice, path: str = "") -> Volume:
    """The volume of a group or an array of zarr that is open; ``path`` is where, if it has one."""
    name = (choice.dataset or "").strip("/")
    if name and not hasattr(node, "shape") and node.get(name) is not None:
        node, where, path, name = node[name], _join(where, name), _join(path, name), ""
    if path:
        _check_metadata(path)
    if hasattr(node, "shape"):
        number_of("level", choice.level, [""], where)  # itself
        return _of_array(node, where, choice, path)
    attributes = _attributes(node)
    images = attributes.get("multiscales")
    if not isinstance(images, list) or not images or not all(isinstance(image, Mapping) for image in images):
        return _of_group(node, name, where, choice, path)
    named = [str(image.get("name", "")) for image in images]
    if name and name not in named:
        raise InvalidInput(f"has nothing named '{name}'; its images are {', '.join(named)}", where)
    volume = _of_image(node, images[named.index(name) if name else 0], attributes, where, choice, path)
    if len(images) > 1 and not name:
        volume.notes.insert(0, f"holds {len(images)} images (multiscales), of which the first, '{named[0]}', is used")
    return volume


def _join(path: str, name: str) -> str:
    return f"{path.rstrip('/')}/{name}" if path else ""


def _attributes(node: Any) -> Any:
    ome = node.attrs.get("ome")
    return ome if isinstance(ome, Mapping) else dict(node.attrs)


def _of_group(node: Any, name: str, where: str, choice: Choice, path: str) -> Volume:
    """A volume of a group without an image: the only image or array of volumes in it, or an error that lists them."""
    try:
        inside = {child: node[child] for child in sorted(node)}
    except (NotImplementedError, OSError):
        inside = {}  # a server that cannot list
    images = [child for child, part in inside.items() if "multiscales" in _attributes(part)]
    arrays = [child for child, part in inside.items() if len(getattr(part, "shape", ())) >= 3]
    if len(images or arrays) == 1 and not name:
        only = (images or arrays)[0]
        volume = of_node(node, where, Choice(choice.axes, choice.channel, choice.level, None, only), path)
        volume.notes.insert(0, f"'{only}' is used, the only volume in {where}")
        return volume
    named = f": {listed([*inside])}" if inside else f", as {_join(where, '0')}"
    said = f"has no '{name}'" if name else "is a group without an image (multiscales)"
    raise Missing(f"{said}; name an image or an array in it{named}", where, "dataset", "NAME")


# Images ----------------------------------------------------------------------------------------


def _of_image(node: Any, image: Any, attributes: Any, where: str, choice: Choice, path: str) -> Volume:
    levels = image.get("datasets")
    if not isinstance(levels, list) or not levels:
        raise InvalidInput("its image names no levels (datasets)", where)
    paths = [str(level.get("path", "")) for level in levels]
    number = number_of("level", choice.level, paths, where)
    at = paths[number]
    place = _join(where, at)
    if not at or at.startswith("/") or ".." in at.split("/") or "\\" in at:
        raise InvalidInput(f"names the level '{at}'; a level must be in the group", where)
    with through(place):
        if path:
            _check_metadata(_join(path, at))
        array = node.get(at)
        if array is None or not hasattr(array, "shape"):
            raise InvalidInput("there is no array, but it is a level of the image", place)
    axes, units = _axes(image, choice, where)
    if len(axes) != len(array.shape):
        raise InvalidInput(f"has {len(array.shape)} axes, but its image has {len(axes)}", place)
    volume = Volume(place, array, axes, time_unit=units.get("t", ""))
    omero = attributes.get("omero") or {}
    choose_channel(volume, choice, [str(channel.get("label", "")) for channel in omero.get("channels", [])])
    _place(volume, [levels[number], image], units, where)
    absent = [other for other in paths if not _opens(node, other)]
    volume.notes += [f"levels that cannot be read: {', '.join(absent)}"] if absent else []
    return _missing_chunks(volume, path)


def _opens(node: Any, name: str) -> bool:
    try:
        return node.get(name) is not None
    except Exception:  # as its metadata are damaged
        return False


def _axes(image: Any, choice: Choice, where: str) -> Tuple[str, Dict[str, str]]:
    """A letter for each axis, and the units of those that have one."""
    if image.get("axes") is None:  # before version 0.3
        return choice.axes or "tczyx", {}
    axes = [axis if isinstance(axis, Mapping) else {"name": axis} for axis in image["axes"]]
    letters = "".join(map(_letter, axes))
    if choice.axes is not None and len(choice.axes) == len(axes):
        letters = choice.axes
    if len(letters) < len(axes) or not usable(letters):
        raise unknown_axes("'" + "', '".join(str(axis.get("name", "")) for axis in axes) + "'", where)
    return letters, {a: unit_named(axis["unit"]) for a, axis in zip(letters, axes) if isinstance(axis.get("unit"), str)}


def _letter(axis: Any) -> str:
    name, kind = str(axis.get("name", "")), axis.get("type")
    letter = axis_named(name) if len(name) == 1 or name.lower() in ("time", "channel") else ""
    if kind in ("time", "channel"):
        return str(kind)[0]
    return letter if kind is None or (kind == "space") == (letter in ("x", "y", "z")) else ""


def _place(volume: Volume, parts: List[Any], units: Dict[str, str], where: str) -> None:
    """Scale and translation of a level and then of the whole. A scale of 1 without a unit says nothing."""
    scale, offset = np.ones(len(volume.axes)), np.zeros(len(volume.axes))
    said = False
    for one in (one for part in parts for one in part.get("coordinateTransformations") or []):
        kind = one.get("type")
        if kind == "identity":
            continue
        if kind not in ("scale", "translation") or one.get(kind) is None:
            shortened = json.dumps(one)[:80]
            raise Unsupported(f"has the transformation {shortened}; scale and translation can be read", where)
        numbers = np.array(one[kind])
        if numbers.shape != scale.shape or numbers.dtype.kind not in "iuf" or not np.all(np.isfinite(numbers)):
            raise InvalidInput(f"its image has the {kind} {one[kind]}, which cannot be", where)
        if kind == "scale":
            said, scale, offset = True, scale * numbers, offset * numbers
        else:
            offset = offset + numbers
    unit_of_length = any(units.get(axis) for axis in "xyz")
    known = {axis: said and (size != 1 or bool(units.get("t") if axis == "t" else unit_of_length))
             for axis, size in zip(volume.axes, scale)}  # fmt: skip
    sizes = {axis: float(size) for axis, size in zip(volume.axes, scale) if known[axis]}
    begins = {axis: float(at) for axis, at in zip(volume.axes, offset) if known[axis] or at}
    if "t" in sizes:
        volume.frame_time, volume.start_time = sizes["t"], begins["t"]
    with through(where):
        volume.spacing, volume.length_unit = in_one_unit(_in_space(sizes), units)
        volume.origin, _ = in_one_unit(_in_space(begins), units)


def _in_space(of_axes: Dict[str, float]) -> Dict[str, float]:
    return {axis: number for axis, number in of_axes.items() if axis in "xyz"}


# Arrays ----------------------------------------------------------------------------------------


def _of_array(array: Any, where: str, choice: Choice, path: str) -> Volume:
    names = getattr(getattr(array, "metadata", None), "dimension_names", None)  # of version 3
    named = [str(name or "") for name in names or array.attrs.get("_ARRAY_DIMENSIONS") or []]
    coordinates = [_beside(array, name) for name in named]
    return _missing_chunks(volume_of(array, where, choice, named, dict(array.attrs), coordinates), path)


def _beside(array: Any, name: str) -> Coordinates:
    """The coordinates of an axis: an array with its name in the same group, as xarray writes them."""
    try:
        place = f"{array.path.rpartition('/')[0]}/{name}".strip("/")
        one = library("zarr", "zarr", "", "Zarr").open_array(array.store, path=place, mode="r")
        _check_codecs(one, place)
        return (one[:], dict(one.attrs)) if array.path and name and len(one.shape) == 1 else None
    except Exception:  # there is none
        return None


def _check_codecs(array: Any, where: str) -> List[str]:
    """Codec names. Raises InvalidInput for pickle, which runs what a chunk says, and which numcodecs took before
    0.15.2."""
    last = array.compressors if hasattr(array, "compressors") else [array.compressor]
    codecs = [*(array.filters or ()), *last]
    names = [str(getattr(codec, "codec_id", type(codec).__name__)).lower() for codec in codecs]
    if "pickle" in names:
        raise InvalidInput("is stored by pickle, which can run any code; store it as numbers", where)
    return names


def _check_blosc(file: str) -> None:
    """Raises InvalidInput for a chunk that is cut off, which numcodecs unpacks to other samples."""
    with open(file, "rb") as chunk:
        size = int.from_bytes(chunk.read(16)[12:], "little")
        if os.fstat(chunk.fileno()).st_size < size:
            raise InvalidInput("is cut off", file)


def _missing_chunks(volume: Volume, path: str) -> Volume:
    """A note of chunks that have no file, where files can be counted at once, which must be regular ones."""
    array = volume.array
    blosc = _check_codecs(array, volume.where)[-1:] in (["blosc"], ["blosccodec"])
    if path and "://" not in path and getattr(array, "shards", None) is None and array.nchunks <= _MOST_COUNTED:
        for place, _, names in os.walk(path):
            for name in names:
                _check_regular(os.path.join(place, name))
                if blosc and name not in (*_METADATA, ".zmetadata"):
                    _check_blosc(os.path.join(place, name))
        missing = array.nchunks - array.nchunks_initialized
        if missing > 0:
            volume.notes.append(f"{missing} of {array.nchunks} chunks have no file, and hold the fill value")
    return volume

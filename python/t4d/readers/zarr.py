"""Zarr 2 and 3, and OME-Zarr 0.1 to 0.5, with zarr-python: a folder, a .zip, or a URL of fsspec."""

from __future__ import annotations

import json
import math
import os
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

from t4d.errors import InvalidInput, Unsupported
from t4d.readers.coordinates import coordinates_of
from t4d.readers.units import in_one_unit, unit_named
from t4d.readers.volume import Choice, Missing, Volume, axes_of, axis_named, chosen_channel, library, through, usable

EXTRA = "zarr"
OPTIONS = ("axes", "channel", "level", "dataset")

_METADATA = ("zarr.json", ".zgroup", ".zarray", ".zattrs")
_MOST_LISTED = 20
_MOST_COUNTED = 1 << 16  # chunks


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
    """A URL without the user and the password in it."""
    scheme, found, rest = url.partition("://")
    host, slash, path = rest.partition("/")
    return scheme + found + host.rpartition("@")[2] + slash + path if found else url


def _read(path: str, choice: Choice) -> Volume:
    zarr = library("zarr", EXTRA, shown(path), "Zarr")
    where = shown(path)
    with through(where):
        store: Any = path
        if path.lower().endswith(".zip") and "://" not in path:
            store = zarr.storage.ZipStore(path, mode="r")
        elif "://" not in path and not any(os.path.exists(os.path.join(path, name)) for name in _METADATA):
            raise InvalidInput("has none of zarr.json, .zarray, .zgroup and .zattrs, so it is no Zarr", where)
        check_metadata(path, "")
        try:
            node = zarr.open(store, mode="r")
        except (FileNotFoundError, KeyError) as error:  # zarr has exceptions of its own, which are of these
            raise InvalidInput("is no Zarr that is there", where) from error
    return of_node(node, where, choice, path)


def check_metadata(path: str, inner: str) -> None:
    """Raises InvalidInput if a key is given twice in the JSON of a node: zarr takes the last one."""

    def once(pairs: List[Tuple[str, Any]]) -> Dict[str, Any]:
        keys = [key for key, _ in pairs]
        for key in keys:
            if keys.count(key) > 1:
                raise InvalidInput(f"has the key '{key}' twice", place)
        return dict(pairs)

    for name in _METADATA:
        place = "/".join(part for part in (shown(path).rstrip("/"), inner.strip("/"), name) if part)
        text = _contents(path, inner, name)
        if text is not None:
            try:
                json.loads(text, object_pairs_hook=once)
            except ValueError as error:
                if isinstance(error, InvalidInput):
                    raise
                raise InvalidInput(f"is no JSON: {error}", place) from None


def _contents(path: str, inner: str, name: str) -> Optional[bytes]:
    """Of a file of a store; None if it is not there, or in a .zip."""
    if "://" in path:
        files, root = library("fsspec", EXTRA, shown(path), "a URL").core.url_to_fs(path)
        try:
            return bytes(files.cat_file("/".join([root.rstrip("/"), *filter(None, [inner.strip("/")]), name])))
        except FileNotFoundError:
            return None
    try:
        with open(os.path.join(path, inner.strip("/"), name), "rb") as file:
            return file.read()
    except (FileNotFoundError, NotADirectoryError):
        return None


def of_node(node: Any, where: str, choice: Choice, path: str = "") -> Volume:
    """The volume of a group or an array of zarr that is open."""
    name = ""
    if choice.dataset is not None and not hasattr(node, "shape"):
        inner = choice.dataset.strip("/")
        found = node.get(inner) if inner else node
        if found is None:
            name = choice.dataset  # of one of several images
        elif inner:
            if path:
                check_metadata(path, inner)
            node, where = found, f"{where.rstrip('/')}/{inner}"
            path = f"{path.rstrip('/')}/{inner}" if path else ""
    if hasattr(node, "shape"):
        if choice.level not in (None, 0):
            raise InvalidInput(f"is one array, so there is no level {choice.level}", where)
        return _of_array(node, where, choice, path)
    attributes = dict(node.attrs)
    within = attributes.get("ome") if isinstance(attributes.get("ome"), Mapping) else attributes
    images = within.get("multiscales")
    if isinstance(images, list) and images and isinstance(images[0], Mapping):
        image = _image(images, name, where)
        volume = _of_image(node, image, within, where, choice, path)
        if len(images) > 1 and not name:
            said = f", '{image['name']}'," if image.get("name") else ""
            volume.notes.insert(0, f"holds {len(images)} images (multiscales), of which the first{said} is used")
        return volume
    if name:
        raise _no_dataset(node, name, where)
    return _of_group(node, within, where, choice, path)


def _image(images: List[Any], name: str, where: str) -> Any:
    found = [image for image in images if image.get("name") == name] if name else images
    if not found:
        names = ", ".join(f"'{image.get('name', '')}'" for image in images)
        raise InvalidInput(f"has nothing named '{name}'; its images are {names}", where)
    return found[0]


def _of_group(node: Any, attributes: Any, where: str, choice: Choice, path: str) -> Volume:
    """Of a group without an image: the only image or array of volumes in it, or an error that lists them."""
    with through(where):
        inside = {name: part for name, part in _children(node)}
        arrays = [name for name, part in inside.items() if hasattr(part, "shape") and len(part.shape) >= 3]
        groups = [name for name, part in inside.items() if not hasattr(part, "shape")]
    images = [name for name in groups if "multiscales" in (inside[name].attrs.get("ome") or inside[name].attrs)]
    found = images or arrays
    if len(found) == 1:
        inner = Choice(choice.axes, choice.channel, choice.level, None, found[0])
        volume = of_node(node, where, inner, path)
        volume.notes.insert(0, f"'{found[0]}' is used, the only volume in {where}")
        return volume
    raise _no_dataset(node, "", where)


def _children(node: Any) -> List[Tuple[str, Any]]:
    """By name; none on a server that cannot list them."""
    try:
        return sorted((name, node[name]) for name in node)
    except (NotImplementedError, OSError):
        return []


def _no_dataset(node: Any, name: str, where: str) -> InvalidInput:
    names = [child for child, _ in _children(node)]
    more = f", and {len(names) - _MOST_LISTED} more" if len(names) > _MOST_LISTED else ""
    listed = f": {', '.join(names[:_MOST_LISTED])}{more}" if names else f", as {where.rstrip('/')}/0"
    said = f"has no '{name}'" if name else "is a group without an image (multiscales)"
    return Missing(f"{said}; name an image or an array in it{listed}", where, "dataset", "NAME")


# Images ----------------------------------------------------------------------------------------


def _of_image(node: Any, image: Any, attributes: Any, where: str, choice: Choice, path: str) -> Volume:
    levels = image.get("datasets")
    if not isinstance(levels, list) or not levels or not all(isinstance(level, Mapping) for level in levels):
        raise InvalidInput("its image names no levels (datasets)", where)
    level = _level(levels, choice, where)
    at = str(levels[level].get("path", ""))
    if not at or at.startswith("/") or ".." in at.split("/") or "\\" in at:
        raise InvalidInput(f"names the level '{at}'; a level must be in the group", where)
    place = f"{where.rstrip('/')}/{at}"
    with through(place):
        if path:
            check_metadata(path, at)
        array = node.get(at)
    if array is None or not hasattr(array, "shape"):
        raise InvalidInput("there is no array, but it is a level of the image", place)
    axes, units = _axes(image, choice, where)
    if len(axes) != len(array.shape):
        raise InvalidInput(f"has {len(array.shape)} axes, but its image has {len(axes)}", place)
    notes = _other_levels(node, levels, level, array, axes, where)
    scale, offset, said = _placed([levels[level], image], len(axes), where)
    volume = Volume(place, array, axes, notes=notes)
    names = [str(channel.get("label", "")) for channel in (attributes.get("omero") or {}).get("channels", [])]
    count = volume.size("c")
    volume.channel = chosen_channel(count, choice, place, names if len(names) == count else ())
    lengths, origins = {}, {}
    volume.time_unit = units.get("t", "")
    unit_known = any(units.get(axis) for axis in "xyz")
    for i, axis in enumerate(axes):
        # A scale of 1 without a unit says nothing.
        sized = said and (bool(volume.time_unit if axis == "t" else unit_known) or scale[i] != 1)
        if axis == "t":
            volume.frame_time, volume.start_time = (scale[i] if sized else None), (offset[i] if sized else None)
        elif axis != "c":
            lengths.update({axis: scale[i]} if sized else {})
            origins.update({axis: offset[i]} if offset[i] or sized else {})
    with through(where):
        volume.spacing, volume.length_unit = in_one_unit(lengths, units)
        volume.origin, _ = in_one_unit(origins, units)
    return _missing_chunks(volume, path)


def _level(levels: List[Any], choice: Choice, where: str) -> int:
    paths = [level.get("path") for level in levels]
    if isinstance(choice.level, str) and choice.level in paths:
        return paths.index(choice.level)
    level = choice.level or 0
    number = int(level) if str(level).isdigit() else -1
    if not 0 <= number < len(levels):
        said = f"{len(levels)} level" + ("" if len(levels) == 1 else "s")
        raise InvalidInput(f"has {said}, so there is no level {level} (counted from 0)", where)
    return number


def _axes(image: Any, choice: Choice, where: str) -> Tuple[str, Dict[str, str]]:
    """A letter for each axis, and the units of those that have one."""
    axes = image.get("axes")
    if axes is None:  # before version 0.3
        return choice.axes or "tczyx", {}
    names = [str(axis.get("name", "") if isinstance(axis, Mapping) else axis) for axis in axes]
    letters = [_letter(axis, name) for axis, name in zip(axes, names)]
    if choice.axes is not None and len(choice.axes) == len(axes):
        letters = list(choice.axes)
    if "" in letters or not usable("".join(letters)):
        said = "', '".join(names)
        raise Missing(f"has the axes '{said}', which do not tell x, y, z, t and c", where, "axes", "ORDER, as in --axes tzyx")
    given = [axis.get("unit") if isinstance(axis, Mapping) else None for axis in axes]
    return "".join(letters), {a: unit_named(unit) for a, unit in zip(letters, given) if isinstance(unit, str)}


def _letter(axis: Any, name: str) -> str:
    kind = axis.get("type") if isinstance(axis, Mapping) else None
    letter = axis_named(name) if len(name) == 1 or name.lower() in ("time", "channel") else ""
    if kind in ("time", "channel"):
        return str(kind)[0]
    return letter if kind is None or (kind == "space") == (letter in ("x", "y", "z")) else ""


def _placed(parts: List[Any], count: int, where: str) -> Tuple[List[float], List[float], bool]:
    """Scale and translation of a level and then of the whole, and whether there is a scale."""
    scale, offset, said = [1.0] * count, [0.0] * count, False
    for part in parts:
        for one in part.get("coordinateTransformations") or []:
            kind = one.get("type")
            numbers = one.get(kind)
            if kind == "identity":
                continue
            if kind not in ("scale", "translation") or numbers is None:
                raise Unsupported(
                    f"has the transformation {json.dumps(one)[:80]}; scale and translation with their numbers can be "
                    "read", where,
                )  # fmt: skip
            if len(numbers) != count or not all(isinstance(n, (int, float)) and math.isfinite(n) for n in numbers):
                raise InvalidInput(f"its image has the {kind} {numbers}, which cannot be", where)
            if kind == "scale":
                scale = [a * b for a, b in zip(scale, numbers)]
                offset = [a * b for a, b in zip(offset, numbers)]
                said = True
            else:
                offset = [a + b for a, b in zip(offset, numbers)]
    return scale, offset, said


def _other_levels(node: Any, levels: List[Any], level: int, array: Any, axes: str, where: str) -> List[str]:
    """Checks that other levels have the frames and channels of this one; a note of those that are not there."""
    absent = []
    for i, other in enumerate(levels):
        if i == level:
            continue
        name = str(other.get("path", ""))
        try:
            found = node.get(name)
        except Exception:  # damaged levels that are not read
            found = None
        if found is None or not hasattr(found, "shape"):
            absent.append(name)
        elif len(found.shape) != len(axes):
            raise InvalidInput(f"has {len(found.shape)} axes, but its image has {len(axes)}", f"{where}/{name}")
        else:
            for axis, what in (("t", "frames"), ("c", "channels")):
                if axis in axes and found.shape[axes.index(axis)] != array.shape[axes.index(axis)]:
                    raise InvalidInput(
                        f"has {found.shape[axes.index(axis)]} {what}, but level {level} has "
                        f"{array.shape[axes.index(axis)]}", f"{where}/{name}",
                    )  # fmt: skip
    return [f"levels that cannot be read: {', '.join(absent)}"] if absent else []


# Arrays ----------------------------------------------------------------------------------------


def _of_array(array: Any, where: str, choice: Choice, path: str) -> Volume:
    names = getattr(array.metadata, "dimension_names", None) or array.attrs.get("_ARRAY_DIMENSIONS") or []
    named = [str(name or "") for name in names]
    axes, assumed = axes_of(array.shape, named, choice, where)
    volume = Volume(where, array, axes, axes_assumed=assumed)
    volume.channel = chosen_channel(volume.size("c"), choice, where)
    coordinates_of(volume, dict(array.attrs), _beside(array, named, path))
    return _missing_chunks(volume, path)


def _beside(array: Any, names: Sequence[str], path: str) -> Dict[str, Tuple[Any, Dict[str, Any]]]:
    """The coordinates of axes, by their letters: arrays of one axis with their names in the same group, as
    xarray writes them."""
    found: Dict[str, Tuple[Any, Dict[str, Any]]] = {}
    group = "/".join(array.path.split("/")[:-1])
    for name in names:
        if not axis_named(name) or not array.path:
            continue
        try:
            zarr = library("zarr", EXTRA, path, "Zarr")
            one = zarr.open_array(array.store, path=f"{group}/{name}".strip("/"), mode="r")
        except Exception:  # there is none
            continue
        if len(one.shape) == 1:
            found[axis_named(name)] = one[:], dict(one.attrs)
    return found


def _missing_chunks(volume: Volume, path: str) -> Volume:
    """A note of chunks that have no file, where files can be counted at once."""
    array = volume.array
    if path and "://" not in path and getattr(array, "shards", None) is None and array.nchunks <= _MOST_COUNTED:
        missing = array.nchunks - array.nchunks_initialized
        if missing > 0:
            volume.notes.append(f"{missing} of {array.nchunks} chunks have no file, and hold the fill value")
    return volume

"""4D meshes: the boundary of a moving solid in space-time (x, y, z, t)."""

from __future__ import annotations

import functools
import json
import math
import operator
import os
import weakref
from typing import (
    Any,
    Callable,
    Dict,
    Iterator,
    List,
    Mapping,
    Optional,
    Sequence,
    SupportsFloat,
    SupportsIndex,
    Tuple,
    Union,
    cast,
)

import numpy as np
from numpy.typing import ArrayLike, NDArray

from t4d import _t4d, checks
from t4d.checks import Numbers, Path
from t4d.errors import InvalidInput, Loss, about, warn
from t4d.frames import Frames, is_path, open_frames
from t4d.motions import Motion, MotionLike
from t4d.slabs import SlabStream
from t4d.tracks import Tracks, tables
from t4d.triangles import TriangleMesh
from t4d.unchanging import Unchanging

Progress = Optional[Callable[[float], None]]
"""Called with the fraction done, from 0 to 1, some twenty times a second. What it raises ends the
work, as Ctrl-C does."""


class Slab(Unchanging):
    """The part of a 4D mesh between two consecutive times. All arrays are read-only, and none is a
    copy. Vertices are ordered: lower layer, interior, upper layer."""

    _instead = "pickle its arrays, or the mesh's file and the slab's number"

    def __init__(self, slab: _t4d.Slab) -> None:
        self._slab = slab

    @property
    def time_span(self) -> Tuple[float, float]:
        return self._slab.time_begin, self._slab.time_end

    @property
    def vertices(self) -> NDArray[np.float64]:
        """(n, 4) float64: x, y, z, t."""
        return self._slab.vertices

    @property
    def cells(self) -> NDArray[np.uint32]:
        """(m, 4) uint32: tetrahedra, with det[outward normal, b - a, c - a, d - a] > 0."""
        return self._slab.cells

    @property
    def lower_layer(self) -> NDArray[np.float64]:
        """The vertices at the first time."""
        return self._slab.vertices[: self._slab.lower_count]

    @property
    def upper_layer(self) -> NDArray[np.float64]:
        """The vertices at the last time: the lower layer of the next slab."""
        return self._slab.vertices[len(self._slab.vertices) - self._slab.upper_count :]

    @property
    def mean_count(self) -> int:
        """The last vertices before the upper layer that are means of others."""
        return self._slab.mean_count

    @property
    def vertex_attributes(self) -> Dict[str, NDArray[Any]]:
        """Attributes of vertices by name, (n,) or (n, components)."""
        return self._slab.vertex_attributes

    @property
    def cell_attributes(self) -> Dict[str, NDArray[Any]]:
        """Attributes of cells by name, (m,) or (m, components)."""
        return self._slab.cell_attributes

    @property
    def attributes(self) -> List[Tuple[str, str, NDArray[Any]]]:
        """All as ("vertex" or "cell", name, values), in the order of the file."""
        return self._slab.attributes

    def __repr__(self) -> str:
        begin, end = self.time_span
        return f"<t4d.Slab: {len(self.cells)} cells from {begin} to {end}>"


class Mesh(Unchanging):
    """A 4D mesh of one body or several: ``mesh["nut"]`` or ``mesh[0]`` is a mesh of one of them.

    It is in a file (``read``), in memory (``load``), or only described (``sweep``, ``weave``): then
    ``save`` and ``slabs`` make it slab by slab, in the memory of one or two, and everything else
    loads it first.
    """

    _instead = "save it, pass on the path, and open that by t4d.read"
    _bodies: List[_t4d.Body]
    _producer: Optional[_t4d.Producer]
    _name: str
    _metadata: Dict[str, str]
    _file: Optional[str]
    _other_half: Optional[Tuple[int, Any, weakref.ref[Any]]] = None  # of flat(), see _half
    _whole_file: Optional[Tuple[str, Any]] = None  # the file that holds all of the mesh, and its state

    def __init__(self) -> None:
        raise TypeError("a t4d.Mesh is made by t4d.read, t4d.sweep or t4d.weave")

    @classmethod
    def _of(
        cls,
        bodies: Sequence[_t4d.Body] = (),
        producer: Optional[_t4d.Producer] = None,
        name: str = "",
        metadata: Optional[Dict[str, str]] = None,
        file: Optional[str] = None,
    ) -> Mesh:
        made = cls.__new__(cls)
        made._bodies = list(bodies)
        made._producer = producer
        made._name = name
        made._metadata = metadata or {}
        made._file = file
        return made

    # What it is

    def load(self, progress: Progress = None) -> Mesh:
        """Makes the mesh in memory, if it is only described; returns it."""
        if not self._bodies:
            assert self._producer is not None
            checks.function("progress", progress)
            self._bodies = [self._producer.load(self._name, progress)]
            self._producer = None
        return self

    @property
    def names(self) -> List[str]:
        """The names of the bodies."""
        return [body.name for body in self._bodies] if self._bodies else [self._name]

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, key: Union[SupportsIndex, str]) -> Mesh:
        names = self.names
        if isinstance(key, str):
            if key not in names:
                raise KeyError(f"no body '{key}'; the bodies are {', '.join(names)}")
            index = names.index(key)
        else:
            try:
                index = operator.index(key)
            except TypeError:
                raise TypeError(
                    f"mesh[{key!r}]: a body is chosen by its name or its number, one at a time"
                ) from None
            if not -len(names) <= index < len(names):
                raise IndexError(f"there is no body {index}; the mesh has {len(names)}")
        self.load()
        return Mesh._of([self._bodies[index]], metadata=self._metadata, file=self._file)

    def __contains__(self, name: object) -> bool:
        """Whether a body has this name."""
        return name in self.names

    def __iter__(self) -> Iterator[Mesh]:
        return (self[i] for i in range(len(self)))

    def _one(self) -> _t4d.Body:
        self.load()
        if len(self._bodies) > 1:
            raise ValueError(
                f"the mesh has {len(self._bodies)} bodies: choose one, for instance "
                f"mesh[{self._bodies[0].name!r}], or go through them, `for body in mesh`"
            )
        return self._bodies[0]

    @property
    def length_unit(self) -> str:
        """"" if unknown."""
        return self._metadata.get("length_unit", "")

    @property
    def time_unit(self) -> str:
        return self._metadata.get("time_unit", "")

    @property
    def up(self) -> str:
        """The axis that points up: "y" or "z"."""
        return self._metadata.get("up", "y")

    @property
    def space(self) -> str:
        """Where the axes point in a patient: "RAS" or "LPS"; "" if that is not said."""
        return self._metadata.get("space", "")

    @property
    def attribute_kinds(self) -> Dict[str, Tuple[str, str]]:
        """Kind and unit of attributes, by their names, as far as a file says so: a ``("vector",
        "length/time")`` turns and is scaled with the solid."""
        return self._bodies[0].attribute_kinds if self._bodies else {}

    @property
    def version(self) -> str:
        """The version of the format, if the mesh is in a file; else ""."""
        return self._bodies[0].version if self._bodies else ""

    @property
    def features(self) -> List[str]:
        """The features that a reader of the file must support."""
        return self._bodies[0].features if self._bodies else []

    @property
    def time_span(self) -> Tuple[float, float]:
        """The first time of any body and the last one."""
        self.load()
        spans = [body.time_span for body in self._bodies]
        return min(begin for begin, _ in spans), max(end for _, end in spans)

    @property
    def slab_count(self) -> int:
        return self._one().slab_count

    @property
    def layer_times(self) -> NDArray[np.float64]:
        """The times at which slabs begin and end, in order, each time once. In a file with an index,
        no slab is read for it."""
        self.load()
        spans = [body.slab_span(i) for body in self._bodies for i in range(body.slab_count)]
        times: NDArray[np.float64] = np.unique(np.array(spans))
        return times

    # What is in it

    def slabs(self) -> Iterator[Slab]:
        """The slabs in time order, of which one or two are in memory."""
        if self._producer is not None:
            return (Slab(slab) for slab in SlabStream(self._producer))
        return (self._slab(i) for i in range(self.slab_count))

    def slab(self, index: SupportsIndex) -> Slab:
        """Slab number ``index``; negative numbers count from the end."""
        count = self.slab_count
        try:
            index = operator.index(index)
        except TypeError:
            raise TypeError(f"slab({index!r}): slabs are chosen by their number") from None
        if not -count <= index < count:
            raise IndexError(f"there is no slab {index}; the mesh has {count}")
        return self._slab(index % count)

    def _slab(self, index: int) -> Slab:
        with about(self._file):
            return Slab(self._one().slab(index))

    def flat(self, progress: Progress = None) -> Tuple[NDArray[np.float64], NDArray[np.uint32]]:
        """All vertices (n, 4) and cells (m, 4); layers between slabs appear once."""
        checks.function("progress", progress)
        with about(self._file):
            return self._one().flat(progress)

    @property
    def vertices(self) -> NDArray[np.float64]:
        """(n, 4) float64: those of ``flat()``, which gives both at once."""
        vertices: NDArray[np.float64] = self._half(0)
        return vertices

    @property
    def cells(self) -> NDArray[np.uint32]:
        """(m, 4) uint32."""
        cells: NDArray[np.uint32] = self._half(1)
        return cells

    def _half(self, which: int) -> Any:
        # The other half is kept while this one is in use, for who asks for it next.
        kept, self._other_half = self._other_half, None
        if kept is not None and kept[0] == which:
            return kept[1]
        pair = self.flat()
        owner = weakref.ref(self)

        def drop(unused: weakref.ref[Any]) -> None:
            mesh = owner()
            if mesh is not None and mesh._other_half is not None and mesh._other_half[2] is unused:
                mesh._other_half = None

        self._other_half = (1 - which, pair[1 - which], weakref.ref(pair[which], drop))
        return pair[which]

    def slice(
        self,
        time: Optional[SupportsFloat] = None,
        *,
        x: Optional[SupportsFloat] = None,
        y: Optional[SupportsFloat] = None,
        z: Optional[SupportsFloat] = None,
        hyperplane: Optional[Numbers] = None,
        light: bool = False,
        velocity: bool = False,
        max_speed: Optional[SupportsFloat] = None,
    ) -> TriangleMesh:
        """The section by a hyperplane, a closed triangle mesh that faces outward: the solid at a
        time, in (x, y, z); what passes through a plane x, y or z = constant, for x in (y, z, t);
        or all points with ``hyperplane`` (a, b, c, d, v) a x + b y + c z + d t = v, in coordinates
        that ``t4d slice`` describes.

        ``light``, at a time: the triangles of the layers, between their two positions, as ``t4d
        slice --light``. Of a swept solid these are its own, in its order, at all times, and enclose
        the same volume. What is not swept is sliced exactly, with a warning.

        ``velocity``, at a time: adds the vertex attribute ``velocity``, (n, 3) in length units per
        time unit, as ``t4d slice --velocity``; ``max_speed`` slows faster vertices down to it."""
        most = _max_speed(velocity, max_speed)
        places = {"x": x, "y": y, "z": z, "time": time}
        planes = [
            tuple(float(i == axis) for i in range(4)) + (checks.number(name, value),)
            for axis, (name, value) in enumerate(places.items())
            if value is not None
        ]
        if hyperplane is not None:
            planes.append(checks.numbers("hyperplane", hyperplane, 5))
        if len(planes) != 1:
            raise TypeError("give one of time, x, y, z and hyperplane")
        if most is not None and time is None:
            raise TypeError("velocities are those of slices at a time")
        if checks.flag("light", light):
            if time is None:
                raise TypeError("light slices are those at a time")
            return self._light_slices([planes[0][4]], None, most)[0]
        with about(self._file):
            return TriangleMesh._of(self._one().slice(planes[0], most))

    def slices(
        self,
        times: Numbers,
        progress: Progress = None,
        *,
        light: bool = False,
        velocity: bool = False,
        max_speed: Optional[SupportsFloat] = None,
    ) -> List[TriangleMesh]:
        """The solid at each of ``times``, in their order; every slab is read once. ``light`` as of
        ``slice``: then all have the same triangles, and slabs are read for each time. ``velocity``
        and ``max_speed`` as of ``slice``."""
        most = _max_speed(velocity, max_speed)
        moments = checks.numbers("times", times)
        checks.function("progress", progress)
        if checks.flag("light", light):
            return self._light_slices(moments, progress, most)
        with about(self._file):
            return [TriangleMesh._of(one) for one in self._one().slices(moments, progress, most)]

    def _light_slices(
        self, times: Sequence[float], progress: Progress, most: Optional[float]
    ) -> List[TriangleMesh]:
        with about(self._file):
            slices = self._one().light_slices(times, progress, most)
        reasons = [why for _, why in slices if why][:1]
        warn(
            UserWarning,
            [f"slices are exact where a slab does not consist of prisms: {why}" for why in reasons],
        )
        return [TriangleMesh._of(mesh) for mesh, _ in slices]

    def measure(self, times: Numbers, progress: Progress = None) -> Dict[str, NDArray[Any]]:
        """Arrays of what the solid is at each of ``times``: ``time``, ``volume``, ``area``,
        ``centroid`` (n, 3), ``components``, ``cavities``, ``genus``, ``min`` and ``max`` (n, 3), as
        ``t4d measure``. Several times are sliced at once."""
        moments = checks.numbers("times", times)
        checks.function("progress", progress)
        with about(self._file):
            return self._one().measure(moments, progress)

    def volumes(self, times: Numbers, progress: Progress = None) -> NDArray[np.float64]:
        """The volume at each of ``times``, as of ``measure``."""
        return self.measure(times, progress)["volume"]

    def tracks(self, **options: Any) -> Tracks:
        """The components over time, and when each appears, splits, merges and vanishes: tables for
        pandas and links for networkx. Options are those of ``t4d.verbs.track``, such as
        ``surfaces=True`` and ``min_volume=8``."""
        from t4d.commands import run

        return tables(run("track", self, **options))

    # What is done with it

    def check(self, deep: bool = False, progress: Progress = None) -> Dict[str, Any]:
        """Whether the mesh is closed, oriented and valid; counts, components and measures; and the
        findings, as ``t4d validate``. ``hypervolume`` is None of what is open or not oriented.
        ``deep`` checks that every vertex is manifold, too."""
        checks.flag("deep", deep)
        checks.function("progress", progress)
        with about(self._file):
            return self._one().check(deep, progress)

    @property
    def hypervolume(self) -> float:
        """Enclosed, in length^3 times time. ValueError if the mesh is open or not oriented, so that it
        encloses nothing."""
        found = self.check()["hypervolume"]
        if found is None:
            raise ValueError("the mesh is open or not oriented, and encloses nothing; t4d validate says where")
        return float(found)

    def simplify(self, **options: Any) -> "Mesh":
        """A Mesh with fewer cells: ``max_error=0.1`` for the largest distance of a slice from that of
        this mesh, which is proved, ``ratio=0.1`` for a part of the cells, or ``cells=1000``. Options
        are those of ``t4d.verbs.simplify``, whose report says what it measured."""
        from t4d.commands import run

        simplified: Mesh = run("simplify", self, **{"output": Mesh, **options}).mesh
        return simplified

    def save(
        self,
        path: Path,
        *,
        compression: SupportsIndex = 3,
        float32: bool = False,
        grid: Optional[SupportsFloat] = None,
        index: bool = True,
        progress: Progress = None,
    ) -> int:
        """Writes a .t4d file, which appears whole or not at all; returns its size in bytes.

        ``compression`` is the level of zstd, 1 to 19, or 0; positions are kept as they are, rounded
        to ``float32``, or to whole numbers of a ``grid``. Warns (``Loss``) if rounding made cells
        flat or turned them over, and names chunks of a file it was read from that this version does
        not know and that may not be copied. ``verbs.convert`` writes other formats of 4D meshes.
        """
        name = checks.path_text(path)
        if not name.lower().endswith(".t4d"):
            raise ValueError(f"{name}: save writes .t4d; t4d.verbs.convert writes other formats")
        metadata = {
            "generator": f"t4d {_t4d.version} (Python)",
            "backend": "",
            "length_unit": "",
            "time_unit": "",
            "up": "y",
            "space": "",
            "details": "{}",
            **self._metadata,
        }
        options = {
            "compression": checks.whole("compression", compression, 0, 19),
            "float32": checks.flag("float32", float32),
            "grid": None if grid is None else checks.positive("grid", grid),
            "index": checks.flag("index", index),
        }
        checks.function("progress", progress)
        place = os.fsencode(name)
        with about(self._file, output=name):
            if self._producer is not None:
                size, losses = self._producer.save(self._name, place, metadata, options, progress)
            else:
                size, losses = _t4d.save_bodies(self._bodies, place, metadata, options, progress)
        losses += [
            f"the body '{body.name}' has no parent any more: '{body.parent}' is not in the file"
            for body in self._bodies
            if body.parent and body.parent not in self
        ]
        warn(Loss, losses)
        return size

    def __repr__(self) -> str:
        if self._producer is not None:
            return f"<t4d.Mesh: '{self._name}', not made yet>"
        begin, end = self.time_span
        return f"<t4d.Mesh: {', '.join(self.names)}, from {begin} to {end}>"


def read(
    path: Path, *, whole: bool = False, max_cells: Optional[SupportsIndex] = None, progress: Progress = None
) -> Mesh:
    """Opens a .t4d file, or one in parts (.t4dm), by its path or URL. Slabs are read when they are
    asked for, and checked then; ``whole`` checks every byte first. A file with more than 100
    million cells, and 10,000 for each of its bytes, is refused unless ``max_cells`` allows them."""
    name = checks.path_text(path)
    if max_cells is not None:
        max_cells = checks.whole("max_cells", max_cells, 0)
    checks.function("progress", progress)
    checks.flag("whole", whole)
    with about(name):
        bodies = _t4d.read(os.fsencode(name), whole, max_cells, progress)
    first = bodies[0]
    metadata = {
        "backend": first.backend,
        "length_unit": first.length_unit,
        "time_unit": first.time_unit,
        "up": first.up,
        "space": first.space,
        "details": first.details,
    }
    mesh = Mesh._of(bodies, metadata=metadata, file=name)
    if os.path.isfile(name):
        mesh._whole_file = os.path.abspath(name), _state(name)
    return mesh


def _state(path: str) -> Any:
    """Changes with the file at this path."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns


def file_of(mesh: Mesh) -> Optional[str]:
    """The file that holds the mesh as it is, if there is one."""
    if mesh._whole_file is None or mesh._whole_file[1] != _state(mesh._whole_file[0]):
        return None
    return mesh._whole_file[0]


def sweep(
    vertices: Union[ArrayLike, TriangleMesh, Path],
    triangles: Optional[ArrayLike] = None,
    motion: Optional[MotionLike] = None,
    *,
    times: Optional[Numbers] = None,
    steps: Optional[SupportsIndex] = None,
    rv_min: Optional[SupportsFloat] = None,
    max_deviation: Optional[SupportsFloat] = None,
    caps: str = "tetgen",
    prism: SupportsIndex = 14,
    name: str = "solid",
    units: Union[None, str, Sequence[str]] = None,
    up: str = "y",
) -> Mesh:
    """The 4D mesh of a solid that moves (the mesh method).

    ``sweep(V, F, motion)`` or ``sweep(mesh, motion=motion)``: a closed triangle mesh, ``V`` (n, 3)
    and ``F`` (m, 3), along a motion (anything that ``Motion`` takes), in ``steps`` of each segment,
    or such that the volume of every slice stays above ``rv_min`` of the solid's (0.998), or every
    slice stays within ``max_deviation`` of the true solid.

    ``sweep(V, F, times=times)`` with ``V`` (k, n, 3): a solid that is deformed, from key to key.

    ``sweep("machine.glb")``: a file that moves by itself, of any kind that ``t4d sweep`` or t4d-blender
    reads (docs/blender.md), with a body for each of its meshes. It is swept at once, within
    ``max_deviation``; by default, glTF within a thousandth of its size, and others from frame to frame.
    The file says names, units and axes.

    ``units`` are those of length and time, ``("mm", "s")``, or of length alone; by default those of
    the motion, if it has any. ``caps`` are filled by "tetgen" or closed by a "cone"; each step of a
    triangle has ``prism`` 14 or 3 cells. Nothing is computed before the mesh is saved, loaded or
    asked for something.
    """
    checks.choice("caps", caps, ("tetgen", "cone"))
    prism = checks.whole("prism", prism, 3, 14)
    if prism not in (14, 3):
        raise ValueError(f"prism is {prism}; a prism has 14 or 3 cells")
    checks.text("name", name)
    checks.choice("up", up, ("y", "z"))
    given: Dict[str, Any] = {}
    if steps is not None:
        given["steps"] = checks.whole("steps", steps, 1)
    if rv_min is not None:
        given["rv_min"] = checks.number("rv_min", rv_min)
    if max_deviation is not None:
        given["max_deviation"] = checks.positive("max_deviation", max_deviation)
    if len(given) > 1:
        raise TypeError("give one of steps, rv_min and max_deviation")
    options: Dict[str, Any] = {"caps": caps, "prism": prism, **given}
    if isinstance(vertices, (str, bytes, os.PathLike)):
        given_too = (triangles, motion, times, units)
        if any(one is not None for one in given_too) or name != "solid" or up != "y":
            raise TypeError(
                "a file moves by itself, and has names, units and axes; for a solid, give its "
                "read_triangles"
            )
        from t4d.commands import run

        usual = {"caps": "tetgen", "prism": 14}
        chosen = {name: value for name, value in options.items() if value != usual.get(name)}
        if max_deviation is not None:
            chosen["tolerance"] = chosen.pop("max_deviation")
        swept: Mesh = run("sweep", vertices, output=Mesh, **chosen).mesh
        return swept
    metadata = {"backend": "mesh4d", "up": up}
    if isinstance(triangles, (Motion, Mapping, str, bytes, os.PathLike)):
        raise TypeError("the second argument is a motion: write sweep(mesh, motion=...)")
    if isinstance(vertices, TriangleMesh):
        if triangles is not None:
            raise TypeError("the mesh has its triangles: write sweep(mesh, motion=...)")
        mesh, keys = vertices, None
    else:
        if triangles is None:
            raise TypeError("triangles are missing: sweep(V, F, motion), or sweep(mesh, motion=...)")
        keys = checks.array("vertices", vertices)
        mesh = TriangleMesh(keys[0] if keys.ndim == 3 else keys, triangles)
    if motion is None:
        if times is None or keys is None or keys.ndim != 3:
            raise TypeError("give a motion, or vertices of shape (k, n, 3) and their k times")
        if given:
            raise TypeError("a solid that is deformed goes straight from key to key, without steps")
        moments = list(checks.numbers("times", times))
        if len(keys) != len(moments):
            raise ValueError(
                f"{checks.counted(len(moments), 'time')} for {checks.counted(len(keys), 'key')}"
            )
        producer = _t4d.sweep_keys(mesh._mesh, moments, list(keys), **options)
    else:
        if times is not None or (keys is not None and keys.ndim != 2):
            raise TypeError("a motion takes vertices of shape (n, 3), and no times")
        moved = Motion(motion)
        metadata["length_unit"] = moved.length_unit
        metadata["time_unit"] = moved.time_unit
        producer = _t4d.sweep_motion(mesh._mesh, moved._motion, **options)
    if units is not None:
        metadata["length_unit"], metadata["time_unit"] = _units(units, "", "")
    metadata["details"] = json.dumps({"parameters": {"caps": caps, "prism": prism, **given}})
    return Mesh._of(producer=producer, name=name, metadata=metadata)


def _max_speed(velocity: bool, given: Optional[SupportsFloat]) -> Optional[float]:
    """The largest speed; None without velocities."""
    if not checks.flag("velocity", velocity):
        if given is not None:
            raise TypeError("max_speed needs velocity=True")
        return None
    return math.inf if given is None else checks.positive("max_speed", given)


def _is_array(frames: Any) -> bool:
    """Whether it is an array of numpy, or like it, whose parts are read when they are asked for."""
    return hasattr(frames, "shape") and hasattr(frames, "__getitem__")


def _one_by_one(frames: Any) -> Iterator[Any]:
    """Not by the array's own iterator: that of zarr 2 reads many frames at once."""
    if _is_array(frames):
        return (frames[i] for i in range(frames.shape[0]))
    return cast(Iterator[Any], iter(frames))


class _Frames:
    """Frames one by one, checked, of which there are ``count``."""

    def __init__(self, frames: Any, count: int) -> None:
        self._source = _one_by_one(frames)
        self._count = count
        self._given = 0

    def __iter__(self) -> _Frames:
        return self

    def __next__(self) -> NDArray[Any]:
        frame = checks.array(f"frame {self._given}", next(self._source))
        self._given += 1
        if self._given == self._count:
            for _ in self._source:
                raise InvalidInput(f"{self._count} times for at least {self._count + 1} frames")
        if frame.dtype.kind == "f" and frame.dtype.itemsize not in (4, 8):
            return frame.astype(np.float32 if frame.dtype.itemsize < 4 else np.float64)
        return frame.astype(frame.dtype.newbyteorder("="), copy=False)


def _place(
    spacing: Union[SupportsFloat, Numbers], origin: Numbers, affine: Optional[ArrayLike]
) -> NDArray[np.float64]:
    """The map from indices to space, (3, 4)."""
    if affine is None:
        edges: Any = [spacing] * 3 if np.ndim(cast(Any, spacing)) == 0 else spacing
        steps = [checks.positive("spacing", edge) for edge in checks.numbers("spacing", edges, 3)]
        return np.column_stack([np.diag(steps), checks.numbers("origin", origin, 3)])
    if np.ndim(cast(Any, spacing)) != 0 or spacing != 1 or tuple(origin) != (0, 0, 0):
        raise TypeError("affine takes the place of spacing and origin")
    given = checks.array("affine", affine).astype(np.float64)
    if given.shape not in ((3, 4), (4, 4)) or not np.all(np.isfinite(given)):
        raise ValueError(f"affine has the shape {given.shape}; expected 3 x 4 or 4 x 4 numbers")
    if len(given) == 4 and not np.array_equal(given[3], (0, 0, 0, 1)):
        raise ValueError(f"the last row of affine is {given[3]}; expected 0 0 0 1")
    size = np.linalg.norm(given[:3, :3], axis=0)
    if not abs(np.linalg.det(given[:3, :3])) > 1e-9 * np.prod(size):
        raise ValueError("affine maps voxels to something flat")
    return given[:3]


def _units(units: Any, length_unit: str, time_unit: str) -> Tuple[str, str]:
    """The units of length and of time."""
    if units is not None and (length_unit or time_unit):
        raise TypeError("units takes the place of length_unit and time_unit")
    found: Tuple[Any, ...] = length_unit, time_unit
    if units is not None:
        found = (units, "") if isinstance(units, str) else tuple(units)
        if len(found) != 2:
            raise ValueError(f"units is {units!r}; expected a unit of length, or one and one of time")
    return checks.text("length_unit", found[0]), checks.text("time_unit", found[1])


def _label(label: SupportsIndex) -> int:
    return checks.whole("label", label, -(2**63), 2**63 - 1)


def _affine_of(frames: Frames, spacing: Any, origin: Numbers) -> NDArray[np.float64]:
    """The affine map of frames, with the edges of voxels and the origin that are given instead."""
    place = np.eye(4) if frames.affine is None else frames.affine.copy()
    if np.ndim(spacing) != 0 or spacing != 1:
        place[:3, :3] *= np.linalg.norm(_place(spacing, (0, 0, 0), None)[:, :3], axis=0) / np.linalg.norm(
            place[:3, :3], axis=0
        )
    if tuple(origin) != (0, 0, 0):
        place[:3, 3] = checks.numbers("origin", origin, 3)
    return place


def _without_padding(
    frames: Frames, levelled: bool, label: Any, outside_value: Optional[SupportsFloat]
) -> Tuple[Frames, Optional[SupportsFloat]]:
    """The frames and their outside value: NaN where they have samples without data, which for labels have one that
    is not asked for."""
    if label is not None and frames.padded:
        return frames.filled(0 if isinstance(label, str) or not np.any(np.asarray(label) == 0) else -1), outside_value
    if label is None and not levelled and frames.whole and frames.dtype.kind == "f":
        raise InvalidInput("the frames have whole numbers as samples: give iso, below or label")
    if not frames.padded:
        return frames, outside_value
    value = math.nan if outside_value is None else checks.number("outside_value", outside_value, holds=lambda _: True)
    return frames if math.isnan(value) else frames.without(value), math.nan


def weave(
    frames: Any,
    *,
    spacing: Union[SupportsFloat, Numbers] = 1.0,
    origin: Numbers = (0.0, 0.0, 0.0),
    affine: Optional[ArrayLike] = None,
    times: Optional[Numbers] = None,
    iso: Optional[SupportsFloat] = None,
    below: Optional[SupportsFloat] = None,
    label: Union[None, str, SupportsIndex, Sequence[SupportsIndex]] = None,
    outside_value: Optional[SupportsFloat] = None,
    caps: str = "flat",
    between: str = "distance",
    name: str = "solid",
    units: Union[None, str, Sequence[str]] = None,
    length_unit: str = "",
    time_unit: str = "",
    up: Optional[str] = None,
) -> Mesh:
    """The 4D mesh of a time series of volumes (the voxel method, 4D marching cubes).

    ``frames`` is what ``open_frames`` opens, or its path, or several paths: then places, times and units are
    theirs, except those given here, ``outside_value`` is NaN where they have samples without data, and losses are
    warned of (``Loss``). Or it is an array (nt, nx, ny, nz), or anything that gives arrays (nx, ny, nz) one by one.
    Arrays of numpy.memmap, h5py, zarr, dask and others that read what is asked for are read frame
    by frame, and two frames are in memory at a time; of an iterator, too, and ``times`` says how
    many it gives. Inside are values above ``iso``, values below ``below``, or whole numbers that
    equal ``label``; without any of these, values below zero, and True. Several labels, or "all"
    but 0, make a mesh of as many bodies, in memory. Samples of the ``outside_value``, which may be
    NaN, are no data and lie outside.

    The point (0, 0, 0) lies at ``origin``, the next ones ``spacing`` apart, one number or one for
    each axis; or ``affine``, (3, 4) or (4, 4), maps indices to space, as nibabel has it. Everything
    beyond the arrays is outside. ``times`` are 0, 1, 2, ... if not given. ``units`` are those of
    length and time, ``("um", "s")``, or of length alone, "mm"; or ``length_unit`` and ``time_unit``.

    Between frames of bools, or of two values, the surface moves by distances from it; with
    ``between="midpoint"`` it jumps halfway, as published.

    Nothing is computed before the mesh is used, and then from what the arrays hold at that time:
    they are not copied here. What is changed in an array until then, or between two uses, changes
    the mesh; give a copy if it must not. ``.load()`` keeps the mesh as it is now.
    """
    space = ""
    if is_path(frames):
        frames = open_frames(frames)
    if isinstance(frames, Frames):
        affine = _affine_of(frames, spacing, origin) if affine is None else affine
        spacing, origin = 1.0, (0.0, 0.0, 0.0)
        times = frames.times if times is None else times
        if units is None:
            length_unit, time_unit = length_unit or frames.length_unit, time_unit or frames.time_unit
        space = frames.space
        warn(Loss, frames.losses)
        frames, outside_value = _without_padding(frames, iso is not None or below is not None, label, outside_value)
    upward = up or ("z" if space else "y")  # of a patient, z points up
    if isinstance(frames, np.ndarray):
        frames = checks.array("frames", frames)
    if _is_array(frames):
        if len(frames.shape) != 4:
            raise InvalidInput(
                f"the frames have the shape {frames.shape}; expected (nt, nx, ny, nz)"
            )
    elif not hasattr(frames, "__iter__"):
        raise TypeError(
            f"frames is {frames!r}; expected a path, t4d.Frames, an array (nt, nx, ny, nz), or arrays one by one"
        )
    count: Optional[int] = None
    if _is_array(frames):
        count = int(frames.shape[0])
    elif hasattr(frames, "__len__"):
        count = len(frames)
    if times is None:
        if count is None:
            raise TypeError("the frames come from an iterator: give their times")
        times = range(count)
    moments = list(checks.numbers("times", times))
    if count is not None and count != len(moments):
        raise InvalidInput(
            f"{checks.counted(len(moments), 'time')} for {checks.counted(count, 'frame')}"
        )
    if len(moments) < 2:
        raise InvalidInput(f"{checks.counted(len(moments), 'time')}; a motion has at least 2")
    once = not _is_array(frames) and iter(frames) is frames
    place = _place(spacing, origin, affine)
    if sum(given is not None for given in (iso, below, label)) > 1:
        raise TypeError("iso, below and label exclude each other")
    threshold = None if iso is None else checks.number("iso", iso)
    if below is not None:
        threshold = checks.number("below", below)
    no_data = (
        None
        if outside_value is None
        else checks.number("outside_value", outside_value, holds=lambda value: True)
    )
    checks.choice("caps", caps, ("flat", "graded", "half-step"))
    checks.choice("between", between, ("distance", "midpoint"))
    checks.text("name", name)
    length_unit, time_unit = _units(units, length_unit, time_unit)
    checks.choice("up", upward, ("y", "z"))

    def woven(which: Optional[int], body: str) -> Mesh:
        producer = _t4d.weave_frames(
            lambda: _Frames(frames, len(moments)),
            moments,
            place.ravel().tolist(),
            threshold,
            below is not None,
            which,
            no_data,
            caps,
            between,
            once,
            isinstance(frames, np.ndarray),
        )
        parameters: Dict[str, Any] = {"affine": place.tolist(), "caps": caps, "between": between}
        if which is not None:
            parameters["label"] = which
        metadata = {
            "backend": "voxel4d",
            "length_unit": length_unit,
            "time_unit": time_unit,
            "up": upward,
            "space": space,
            "details": json.dumps({"parameters": parameters}),
        }
        return Mesh._of(producer=producer, name=body, metadata=metadata)

    if label is None or hasattr(label, "__index__"):
        return woven(None if label is None else _label(label), name)
    if once:
        raise TypeError("an iterator gives its frames once: give one label, or an array")
    if isinstance(label, str):
        checks.choice("label", label, ("all",))
        found = (np.unique(frame) for frame in _Frames(frames, len(moments)))
        label = [int(one) for one in functools.reduce(np.union1d, found) if one != 0]
    labels = [_label(one) for one in label]
    if not labels or len(set(labels)) < len(labels):
        raise ValueError(f"label: {labels}; expected different whole numbers")
    meshes = [woven(one, f"{name} {one}").load() for one in labels]
    return Mesh._of([mesh._bodies[0] for mesh in meshes], metadata=meshes[0]._metadata)

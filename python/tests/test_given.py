"""Arguments are checked, and errors name them."""

import collections
import copy
import json
import os
import pickle
import types
import warnings
from pathlib import Path

import numpy as np
import pytest

import t4d
from t4d import verbs

SLIDE = {"segments": [{"duration": 2, "translation": [4, 0, 0]}]}


def boxes(count, kind=np.float32):
    """A box that is there in every frame: 1 inside, 0 outside."""
    frames = np.zeros((count, 5, 5, 5), dtype=kind)
    frames[:, 1:4, 1:4, 1:4] = 1
    return frames


@pytest.mark.parametrize("count, times", [(3, 2), (3, 4), (4, 3), (5, 2)])
def test_as_many_times_as_frames(count, times):
    frames = boxes(count)
    for given in (frames, list(frames)):
        with pytest.raises(ValueError, match=f"^{times} times for {count} frames$"):
            t4d.weave(given, times=range(times), iso=0.5)
    with pytest.raises(ValueError, match=f"^{times} times for .* frames$"):
        t4d.weave(iter(frames), times=range(times), iso=0.5).load()
    woven = t4d.weave(iter(frames), times=range(count), iso=0.5)
    assert woven.time_span == (0, count - 1)


WRONG = {
    "save": [
        ("compression", ["zstd", 3.5, True, -1, 20, 2**70]),
        ("float32", ["yes", 2, None]),
        ("grid", ["a", 0, -1, np.nan, np.inf, 1j]),
        ("index", [None, "no"]),
        ("progress", [1]),
    ],
    "sweep": [
        ("steps", [-1, 0, 1.5, "a", True]),
        ("rv_min", ["a", np.nan, [0.9]]),
        ("max_deviation", ["a", -1, np.inf]),
        ("caps", ["round", None, ["cone"]]),
        ("prism", [5, "14", 14.5]),
        ("name", [None, 5, b"a", "\udcff"]),
        ("up", ["x", None]),
    ],
    "weave": [
        ("frames", [5, None]),
        ("spacing", [0, -1, "a", (1, 2), (1, 2, 0), np.nan, None]),
        ("origin", [(0, 0), 0, "abc", (0, 0, np.inf), None]),
        ("times", [("a", "b"), 5, (0, np.nan)]),
        ("iso", ["a", np.nan, (1, 2)]),
        ("caps", ["round", None]),
        ("name", [None]),
        ("length_unit", [5]),
        ("time_unit", [None]),
        ("up", ["x"]),
    ],
    "read": [("max_cells", [-1, 1.5, "a", 2**64]), ("whole", ["a", None]), ("progress", ["a"])],
    "slice": [("time", ["a", np.nan]), ("x", ["a"]), ("hyperplane", [(1, 2), 3, "abcde"])],
}
CASES = [
    (function, option, value)
    for function, options in WRONG.items()
    for option, values in options
    for value in values
]


@pytest.mark.parametrize("function, option, value", CASES)
def test_wrong_options_are_named(models, cube, tmp_path, function, option, value):
    call = {
        "save": lambda **given: t4d.sweep(*cube, SLIDE).save(tmp_path / "x.t4d", **given),
        "sweep": lambda **given: t4d.sweep(*cube, SLIDE, **given),
        "weave": lambda **given: t4d.weave(**{"frames": boxes(2) > 0, **given}),
        "read": lambda **given: t4d.read(models / "cube.t4d", **given),
        "slice": lambda **given: t4d.read(models / "cube.t4d").slice(**given),
    }[function]
    with pytest.raises((TypeError, ValueError), match=rf"^{option}\b.*expected|^prism is 5"):
        call(**{option: value})
    assert os.listdir(tmp_path) == []


def test_numbers_of_numpy_are_numbers(cube, tmp_path):
    swept = t4d.sweep(*cube, SLIDE, steps=np.int32(2), prism=np.int64(3))
    swept.save(tmp_path / "x.t4d", compression=np.uint8(0), float32=np.True_)
    assert t4d.read(tmp_path / "x.t4d", max_cells=np.int64(10**6)).slab_count == 4
    woven = t4d.weave(boxes(2), iso=np.float32(0.5), spacing=np.ones(3), origin=np.zeros(3))
    assert woven.slice(time=np.float32(0.5)).closed


def test_masks_and_imaginary_parts_are_not_dropped(cube):
    vertices, triangles = cube
    masked = np.ma.masked_greater(vertices, 0.5)
    for wrong in (vertices.astype(str), vertices.astype("M8[s]"), [["a"] * 3]):
        with pytest.raises(TypeError, match="vertices: the array is of"):
            t4d.sweep(wrong, triangles, SLIDE)
    for wrong in (masked, vertices + 1j):
        with pytest.raises(TypeError, match="vertices: the array is"):
            t4d.sweep(wrong, triangles, SLIDE)
        with pytest.raises(TypeError, match="vertices: the array is"):
            t4d.sweep(np.ma.stack([wrong, wrong]), triangles, times=[0, 1])
    frames = boxes(3)
    hidden = np.ma.masked_greater(frames, 0.5)
    for wrong in (hidden, frames + 1j):
        with pytest.raises(TypeError, match="frames: the array is"):
            t4d.weave(wrong, iso=0.5)
        with pytest.raises(TypeError, match="frame 0: the array is"):
            t4d.weave(iter(wrong), times=range(3), iso=0.5).load()
    plain = t4d.weave(np.ma.masked_array(frames), iso=0.5)
    assert plain.hypervolume == t4d.weave(frames, iso=0.5).hypervolume
    unmasked = np.ma.masked_array(vertices)
    assert t4d.sweep(unmasked, triangles, SLIDE).hypervolume == pytest.approx(2)


def test_a_file_that_is_opened_and_saved_keeps_its_metadata(models, tmp_path):
    for name in ("cube", "screw"):
        mesh = t4d.read(models / f"{name}.t4d")
        mesh.save(tmp_path / "again.t4d")
        found = verbs.diff(models / f"{name}.t4d", tmp_path / "again.t4d")
        assert found["same"] and found["level"] in ("mesh", "bytes")
        first, again = (verbs.info(path) for path in (models / f"{name}.t4d", tmp_path / "again.t4d"))
        for key in ("backend", "details", "length_unit", "time_unit", "up"):
            assert first.get(key) == again.get(key)
    saved = t4d.read(tmp_path / "again.t4d")
    assert json.loads(saved._metadata["details"]) == json.loads(mesh._metadata["details"]) != {}
    assert saved._metadata["backend"] == "mesh4d"


def test_a_body_that_is_saved_alone_keeps_what_it_can(tmp_path):
    corpus = Path(__file__).parents[2] / "conformance/corpus/files/valid"
    mesh = t4d.read(corpus / "head-bodies-with-all-members.t4d")
    with pytest.warns(t4d.Loss, match="the body 'part' has no parent any more"):
        mesh["part"].save(tmp_path / "part.t4d")
    assert t4d.read(tmp_path / "part.t4d").names == ["part"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh.save(tmp_path / "all.t4d")
    assert verbs.diff(corpus / "head-bodies-with-all-members.t4d", tmp_path / "all.t4d")["same"]


def test_errors_can_be_pickled(models, tmp_path):
    errors = []
    for fails in (
        lambda: verbs.slice(models / "cube.t4d", time=99),
        lambda: t4d.read(tmp_path / "missing.t4d"),
        lambda: t4d.weave(boxes(2)[:, 0:0]).load(),
    ):
        with pytest.raises(t4d.Error) as caught:
            fails()
        errors.append(caught.value)
    for error in errors:
        again = pickle.loads(pickle.dumps(error))
        assert type(again) is type(error) and str(again) == str(error)
        assert vars(again) == vars(error)


def test_what_cannot_be_pickled_says_what_to_do(cube, models):
    mesh = t4d.read(models / "cube.t4d")
    cases = [
        (mesh, "a t4d.Mesh cannot be pickled: save it"),
        (t4d.sweep(*cube, SLIDE), "a t4d.Mesh cannot be pickled: save it"),
        (mesh.slab(1), "a t4d.Slab cannot be pickled: pickle its arrays"),
        (t4d.Motion(SLIDE), "a t4d.Motion cannot be pickled: pickle what it is made of"),
    ]
    for given, message in cases:
        with pytest.raises(TypeError, match=message):
            pickle.dumps(given)
        assert copy.copy(given) is given and copy.deepcopy([given])[0] is given


def test_triangle_meshes_can_be_pickled(cube):
    mesh = t4d.TriangleMesh(*cube, {"heat": np.arange(8.0)}, {"part": np.arange(24).reshape(12, 2)})
    for again in (pickle.loads(pickle.dumps(mesh)), copy.deepcopy(mesh), copy.copy(mesh)):
        assert again.volume == 1
        for name in ("vertices", "triangles"):
            assert np.array_equal(getattr(again, name), getattr(mesh, name))
        assert np.array_equal(again.vertex_attributes["heat"], np.arange(8.0))
        assert np.array_equal(again.triangle_attributes["part"], np.arange(24).reshape(12, 2))


class Part(t4d.TriangleMesh):
    __slots__ = ("weight",)

    def __init__(self, vertices, triangles, material):
        super().__init__(vertices, triangles, {"heat": np.arange(8.0)})
        self.material = material
        self.weight = 3


class Path3(t4d.Motion):
    pass


def test_copies_of_subclasses_have_their_class_and_attributes(cube):
    part = Part(*cube, ["steel"])
    copies = [copy.copy(part), copy.deepcopy(part)]
    copies += [pickle.loads(pickle.dumps(part, protocol)) for protocol in range(2, 6)]
    for again in copies:
        assert type(again) is Part and again.material == ["steel"] and again.weight == 3
        assert again.volume == 1 and np.array_equal(again.vertex_attributes["heat"], np.arange(8.0))
    path = Path3(SLIDE)
    path.notes = ["slow"]
    shallow, deep = copy.copy(path), copy.deepcopy(path)
    for again in (shallow, deep):
        assert type(again) is Path3 and again is not path and again.notes == ["slow"]
        assert np.array_equal(again.at(1), path.at(1))
    shallow.speed = 1
    deep.notes.append("deep")
    assert not hasattr(path, "speed") and path.notes == ["slow"]
    with pytest.raises(TypeError, match=rf"^a {__name__}.Path3 cannot be pickled"):
        pickle.dumps(path)


def test_numbers_that_are_not_finite_are_named(cube):
    vertices, triangles = cube
    for wrong in (np.nan, np.inf, -np.inf):
        bad = vertices.copy()
        bad[5, 1] = wrong
        named = rf"vertices\[5\] is \(1(\.0)?, {wrong}, 1(\.0)?\)"
        for use in (
            lambda: t4d.TriangleMesh(bad, triangles),
            lambda: t4d.TriangleMesh(bad.astype(np.float32).tolist(), triangles),
            lambda: t4d.sweep(bad, triangles, SLIDE),
        ):
            with pytest.raises(ValueError, match=named + "; expected finite numbers"):
                use()
        with pytest.raises(ValueError, match=r"vertices\[1\]\[5\] is \("):
            t4d.sweep(np.stack([vertices, bad]), triangles, times=[0, 1])


@pytest.mark.parametrize("kind", [np.int8, np.int64, ">i4", np.uint8, np.uint32, np.uint64])
def test_an_index_out_of_range_is_shown_as_it_was_given(cube, kind):
    vertices, triangles = cube
    last = int(np.iinfo(kind).max)
    for wrong in [8, last] + ([-1] if np.dtype(kind).kind == "i" else []):
        bad = triangles.astype(kind)
        bad[3, 1] = wrong
        with pytest.raises(ValueError, match=rf"^triangles\[3\]\[1\] is {wrong}; expected .* 8 vertices"):
            t4d.TriangleMesh(vertices, bad)
    mesh = t4d.sweep(vertices, triangles, SLIDE, steps=1).load()
    with pytest.raises(IndexError, match="no slab -9; the mesh has 3"):
        mesh.slab(-9)
    with pytest.raises(IndexError, match="no body -2; the mesh has 1"):
        mesh[-2]


def test_an_array_that_is_too_large_is_a_memory_error(cube):
    vertices, triangles = cube
    far = np.broadcast_to(vertices[:1], (2**44, 3))
    many = np.broadcast_to(triangles[:1], (2**44, 3))
    for use in (
        lambda: t4d.TriangleMesh(far, triangles),
        lambda: t4d.TriangleMesh(vertices, many),
        lambda: t4d.TriangleMesh(vertices, triangles, {"a": np.broadcast_to(1.0, (8, 2**44))}),
        lambda: t4d.sweep(far, triangles, SLIDE),
        lambda: t4d.sweep(far[None], triangles, times=[0]),
    ):
        with pytest.raises(MemoryError):
            use()


def test_what_cannot_be_written_is_an_os_error(cube, models, tmp_path):
    mesh = t4d.TriangleMesh(*cube)
    swept, opened = t4d.sweep(mesh, motion=SLIDE), t4d.read(models / "cube.t4d")
    (tmp_path / "folder.t4d").mkdir()
    (tmp_path / "full.t4d").symlink_to("/dev/full")
    (tmp_path / "full.stl").symlink_to("/dev/full")
    (tmp_path / "link.t4d").symlink_to(tmp_path / "missing" / "x.t4d")
    cases = [
        (mesh, "missing/x.stl", "there is no folder"),
        (mesh, "full.stl", "No space left"),
        (swept, "missing/x.t4d", "there is no folder"),
        (swept, "folder.t4d", "is a folder"),
        (swept, "full.t4d", "No space left"),
        (opened, "link.t4d", "there is no folder"),
        (opened, "full.t4d", "No space left"),
        (opened, "missing: 1/x.t4d", "there is no folder"),
    ]
    for given, name, message in cases:
        with pytest.raises(OSError, match=message) as caught:
            given.save(tmp_path / name)
        error = caught.value
        assert type(error) is t4d.FileError and error.place == ""
        assert error.filename == error.file == str(tmp_path / name)
        again = pickle.loads(pickle.dumps(error))
        assert again.filename == error.filename and str(again) == str(error)


def test_a_file_in_an_error_is_a_path_or_none(cube, models, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mesh = t4d.read(models / "cube.t4d")
    opened = str(models / "cube.t4d")
    data = (models / "cube.t4d").read_bytes()
    Path("cut: 1.t4d").write_bytes(data[: len(data) // 2])
    Path("x.obj").write_text("v 0 0 zero\n")
    box = boxes(2)
    cases = [
        (lambda: mesh.slice(time=99), opened, ""),
        (lambda: mesh[0].slice(time=99), opened, ""),
        (lambda: mesh.save("x.t4d", grid=1e-300), "x.t4d", "slab 0"),
        (lambda: t4d.read("cut: 1.t4d"), "cut: 1.t4d", "byte "),
        (lambda: t4d.read_triangles("x.obj"), "x.obj", "1"),
        (lambda: t4d.Motion("x.obj"), "x.obj", ""),
        (lambda: t4d.TriangleMesh(*cube).save("x.foo"), "x.foo", ""),
        (lambda: t4d.weave([box[0], box[0][1:]]).load(), None, "frame 1"),
        (lambda: t4d.weave([box[0], box[0][1:]]).save("x.t4d"), None, "frame 1"),
        (lambda: t4d.Motion({"segments": [{}]}), None, "motion"),
        (lambda: t4d.Motion.from_matrices([0, 0], [np.eye(4)] * 2), None, "pose 1"),
        (lambda: t4d.sweep(cube[0], cube[1][1:], SLIDE).save("x.t4d"), None, ""),
        (lambda: verbs.info("missing.t4d"), None, ""),
    ]
    for fails, file, place in cases:
        with pytest.raises(t4d.Error) as caught:
            fails()
        assert caught.value.file == file
        assert caught.value.place.startswith(place) and bool(caught.value.place) == bool(place)


def test_motions_of_numpy():
    plain = t4d.Motion(SLIDE)
    for given in (
        {"segments": [{"duration": np.float32(2), "translation": np.array([4, 0, 0])}]},
        {"segments": ({"duration": np.int64(2), "translation": (np.int8(4), 0, 0.0)},)},
        types.MappingProxyType(SLIDE),
        collections.ChainMap(SLIDE),
    ):
        assert np.array_equal(t4d.Motion(given).at(0.5), plain.at(0.5))
    for wrong in (np.nan, np.inf, np.float32("-inf")):
        with pytest.raises(ValueError, match=r"segments\[0\]\.duration is -?(nan|inf)"):
            t4d.Motion({"segments": [{"duration": wrong}]})
        with pytest.raises(ValueError, match=r"segments\[0\]\.translation\[1\] is"):
            t4d.Motion({"segments": [{"translation": np.array([0, wrong, 0])}]})
    for wrong in (1j, {1, 2}, np.array([1j])):
        with pytest.raises(TypeError, match=r"segments\[0\]\.duration"):
            t4d.Motion({"segments": [{"duration": wrong}]})
    for wrong, kind in ((np.nan, ValueError), ("a", TypeError), (None, TypeError)):
        with pytest.raises(kind, match="time is"):
            plain.at(wrong)
    assert np.array_equal(plain.at(np.inf), plain.at(2))
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[1, 0, 2] = np.nan
    with pytest.raises(ValueError, match=r"matrices\[1\]\[0\]\[2\] is nan"):
        t4d.Motion.from_matrices([0, 1], poses)
    for wrong in (5, None, [SLIDE]):
        with pytest.raises(TypeError, match="the motion is"):
            t4d.Motion(wrong)
    assert repr(plain) == "<t4d.Motion: from 0.0 to 2.0>"
    assert "(mm, s)" in repr(t4d.Motion({**SLIDE, "length_unit": "mm", "time_unit": "s"}))


def test_bodies_are_chosen_by_name_or_number(models):
    mesh = t4d.read(models / "cube.t4d")
    assert "paper-cube" in mesh and "bolt" not in mesh and 0 not in mesh
    assert mesh[np.int64(0)].names == mesh[-1].names == mesh["paper-cube"].names
    for wrong in (slice(0, 1), 0.0, None, ["paper-cube"]):
        with pytest.raises(TypeError, match="by its name or its number"):
            mesh[wrong]
    with pytest.raises(IndexError, match="there is no body 1; the mesh has 1"):
        mesh[1]
    with pytest.raises(TypeError, match="t4d.read, t4d.sweep or t4d.weave"):
        t4d.Mesh()


def test_a_motion_as_second_argument(cube, models):
    mesh = t4d.TriangleMesh(*cube)
    for motion in (t4d.Motion(SLIDE), SLIDE, "screw.json", models / "paper-screw.json"):
        for solid in (mesh, cube[0]):
            with pytest.raises(TypeError, match="write .*motion=..."):
                t4d.sweep(solid, motion)


KINDS = [np.uint8, np.int8, np.uint16, np.int16, np.uint32, np.int32, np.uint64, np.int64]


@pytest.mark.parametrize("kind", KINDS)
def test_whole_numbers_need_an_iso(kind):
    found = t4d.weave(boxes(2, kind), iso=0.5)
    assert found.hypervolume == t4d.weave(boxes(2), iso=0.5).hypervolume
    with pytest.raises(t4d.InvalidInput, match=f"frame 0: the array is of {np.dtype(kind)}"):
        t4d.weave(boxes(2, kind)).load()


@pytest.mark.parametrize("kind", ["f2", ">f2", ">f4", "<f8", ">f8", "longdouble"])
def test_floats_of_any_size_and_byte_order(cube, kind):
    frames = 0.5 - boxes(2)
    expected = t4d.weave(frames).hypervolume
    assert t4d.weave(frames.astype(kind)).hypervolume == expected
    assert t4d.weave(-frames.astype(kind), iso=0).hypervolume == expected
    if kind != "longdouble":
        vertices, triangles = cube
        mesh = t4d.TriangleMesh(vertices.astype(kind), triangles.astype(">i8"))
        assert mesh.volume == 1


def test_numbers_of_any_byte_order(cube):
    heat = np.arange(12)
    for kind in (">f4", ">f8", ">i2", ">u8"):
        mesh = t4d.TriangleMesh(*cube, triangle_attributes={"heat": heat.astype(kind)})
        assert np.array_equal(mesh.triangle_attributes["heat"], heat)
    assert t4d.weave(boxes(2, ">i4"), iso=0.5).hypervolume == t4d.weave(boxes(2), iso=0.5).hypervolume


@pytest.mark.parametrize("kind", [float, np.float32, bool, object])
def test_indices_are_whole_numbers(cube, kind):
    vertices, triangles = cube
    for use in (
        lambda: t4d.TriangleMesh(vertices, triangles.astype(kind)),
        lambda: t4d.sweep(vertices, triangles.astype(kind), SLIDE),
    ):
        with pytest.raises(TypeError, match=r"triangles: the array is of .* \.astype\(np\.uint32\)"):
            use()


def test_one_is_singular(cube):
    frame = boxes(1)
    with pytest.raises(ValueError, match="^2 times for 1 frame$"):
        t4d.weave(frame, times=[0, 1])
    with pytest.raises(ValueError, match="^2 times for only 1 frame$"):
        t4d.weave(iter(frame), times=[0, 1], iso=0.5).load()
    with pytest.raises(ValueError, match="^1 time for 2 frames$"):
        t4d.weave(boxes(2), times=[0])
    with pytest.raises(ValueError, match="^1 time; a motion has at least 2$"):
        t4d.weave(iter(frame), times=[0])
    with pytest.raises(ValueError, match="^2 times for 1 key$"):
        t4d.sweep(cube[0][None], cube[1], times=[0, 1])


@pytest.mark.parametrize("name", [b"plain", "größe".encode(), b"not-utf8-\xff"])
def test_paths_are_text_bytes_or_path(cube, tmp_path, name):
    place = os.fsencode(tmp_path) + b"/" + name + b".t4d"
    for path in (place, os.fsdecode(place), Path(os.fsdecode(place))):
        t4d.sweep(*cube, SLIDE).save(path)
        assert os.path.exists(place)
        assert t4d.read(path).slab_count > 0
        assert verbs.validate(path)["valid"]
        os.remove(place)
        with pytest.raises(t4d.FileError) as caught:
            t4d.read(path)
        assert os.fsencode(caught.value.file) == place
        surface = type(path)(os.fsdecode(path)[:-4] + ".stl") if path is not place else place[:-4] + b".stl"
        t4d.TriangleMesh(*cube).save(surface)
        assert len(t4d.read_triangles(surface).triangles) == 12
    for wrong in (5, None):
        for use in (t4d.read, t4d.read_triangles, t4d.sweep(*cube, SLIDE).save):
            with pytest.raises(TypeError):
                use(wrong)
    with pytest.raises(ValueError, match="null"):
        t4d.read("a\0.t4d")


@pytest.mark.parametrize(
    "verb, option, needs",
    [
        ("quality", "time_scale", True),
        ("quality", "o", True),
        ("quality", "attributes", True),
        ("flipbook", "n", True),
        ("slice", "hyperplane", True),
        ("slice", "coplanar", True),
        ("mend", "max_hole", True),
        ("convert", "from_", True),
        ("slice", "light", False),
        ("slice", "meshopt", False),
        ("slice", "attributes", False),
        ("flipbook", "rigid", False),
        ("info", "quiet", False),
        ("info", "q", False),
    ],
)
def test_an_option_of_a_verb_that_needs_a_value_is_not_true(verb, option, needs):
    """Flags come as far as the program, which has no such file."""
    error, message = (TypeError, f"^{option} is True; expected a value") if needs else (t4d.VerbError, "")
    with pytest.raises(error, match=message):
        getattr(verbs, verb)("missing.t4d", **{option: True})


def test_hints_of_verbs_are_no_warnings(models, tmp_path):
    data = bytearray((models / "cube.t4d").read_bytes())
    data[300] ^= 255
    (tmp_path / "damaged.t4d").write_bytes(data)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not verbs.validate(tmp_path / "damaged.t4d")["valid"]
    with pytest.raises(t4d.VerbError, match="try: t4d recover"):
        verbs.slice(tmp_path / "damaged.t4d", time=1)
    far = t4d.TriangleMesh(1e9 + np.eye(4, 3), [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    far.save(tmp_path / "far.obj")
    motion = tmp_path / "slide.json"
    motion.write_text(json.dumps(SLIDE))
    verbs.sweep(tmp_path / "far.obj", motion=motion, output=tmp_path / "far.t4d")
    with pytest.warns(t4d.Loss) as caught:
        verbs.slice(tmp_path / "far.t4d", time=1, output=tmp_path / "far.stl")
    assert "; try: --center" in str(caught[-1].message)
    assert caught[0].filename == __file__


def test_verbs_take_lists_and_any_name(models, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    motion = models / "paper-translation.json"
    for part, name in (("1/2", "-a.t4d"), ("2/2", "b.t4d")):
        verbs.sweep(models / "paper-cube.obj", motion=motion, part=part, output=name)
    names = [["-a.t4d", "b.t4d"]], [("-a.t4d", b"b.t4d")], ["-a.t4d", "b.t4d"], [iter(["-a.t4d", "b.t4d"])]
    for i, files in enumerate(names):
        verbs.join(*files, **{("o", "output")[i % 2]: f"-{i}.t4d"})
        assert verbs.diff(f"-{i}.t4d", models / "cube.t4d")["same"]
    with pytest.raises(TypeError, match="not the name of a file"):
        verbs.join("b.t4d", 5)

"""4D meshes from files, sweeps and arrays."""

import gc
import inspect
import itertools
import json
import os
import resource
import signal
import subprocess
import threading
import time
import warnings

import numpy as np
import pytest

import t4d
from t4d import verbs

SCREW = {
    "segments": [
        {
            "duration": 1,
            "axis_point": [0, 0, 0],
            "axis_direction": [0, 0, 1],
            "angle_degrees": 90,
            "translation": [0, 0, 3],
        }
    ]
}


def test_the_papers_table_in_five_lines(models):
    mesh = t4d.read_triangles(models / "paper-cube.obj")
    swept = t4d.sweep(mesh, motion=models / "paper-screw.json").load()
    report = swept.check(deep=True)
    assert report["closed"] and report["oriented"] and report["vertex_links_ok"]
    steps = swept.slab_count - 2
    edges = 3 * len(mesh.triangles) // 2
    assert report["vertices"] == (steps + 1) * len(mesh.vertices) + steps * (
        edges + len(mesh.triangles)
    ) + sum(len(s.vertices) - len(mesh.vertices) for s in (swept.slab(0), swept.slab(-1)))


def test_what_is_open_encloses_nothing(models, program, tmp_path):
    whole, opened = tmp_path / "whole.off", tmp_path / "open.off"
    subprocess.run([program, "convert", models / "16-cell.off", whole, "--to", "off-ijk", "-q"], check=True)
    lines = whole.read_text().splitlines()
    opened.write_text("\n".join([line.replace("8 16 0", "8 15 0") for line in lines[:-1]]) + "\n")
    subprocess.run([program, "convert", opened, tmp_path / "open.t4d", "--allow-open", "-q"], check=True)
    mesh = t4d.read(tmp_path / "open.t4d")
    found = mesh.check()
    assert not found["closed"] and found["hypervolume"] is None
    with pytest.raises(ValueError, match="is open or not oriented"):
        mesh.hypervolume


@pytest.mark.parametrize("name", ["cube", "screw"])
def test_a_sweep_is_the_programs(models, tmp_path, name):
    mesh = t4d.read_triangles(models / "paper-cube.obj")
    motion = {"cube": "paper-translation.json", "screw": "paper-screw.json"}[name]
    t4d.sweep(mesh, motion=models / motion, name="paper-cube").save(tmp_path / "own.t4d")
    found = verbs.diff(models / f"{name}.t4d", tmp_path / "own.t4d")
    assert found["same"] and found["level"] == "mesh"


def test_slices_and_measures_over_time_are_those_of_each_slice(models):
    mesh = t4d.read(models / "screw.t4d")
    times = [2.5, 0.0, 0.7, mesh.time_span[1]]
    slices = mesh.slices(times)
    assert [len(s.triangles) for s in slices] == [len(mesh.slice(t).triangles) for t in times]
    found = mesh.measure(times)
    expected = verbs.measure(models / "screw.t4d", times="0.7:0.7:1").samples[0]
    for name, values in found.items():
        assert len(values) == len(times)
        assert np.array_equal(values[2], expected[name]), name
    assert np.allclose(found["volume"], [s.volume for s in slices], rtol=1e-12)
    assert np.array_equal(mesh.volumes(times), found["volume"])
    assert np.all(found["components"] == 1) and np.all(found["genus"] == 0)
    with pytest.raises(t4d.InvalidInput, match="outside the mesh"):
        mesh.volumes([mesh.time_span[1] + 1])
    with pytest.raises(ValueError):
        mesh.volumes([float("nan")])


def test_counts_are_signed_so_that_a_merge_is_a_negative_difference():
    frames = np.zeros((2, 9, 5, 5), dtype=bool)
    frames[:, 1:3, 1:4, 1:4] = frames[:, 6:8, 1:4, 1:4] = True
    frames[1, 1:8, 1:4, 1:4] = True
    found = t4d.weave(frames).measure([0, 1])
    assert found["components"].dtype == found["cavities"].dtype == np.int64
    assert list(np.diff(found["components"])) == [-1]


@pytest.mark.parametrize("between", ["distance", "midpoint"])
def test_masks_move_evenly_or_jump(between):
    points = np.indices((40, 40, 40)) - 19.4
    frames = np.array([(points**2).sum(0) < r * r for r in (10, 13)])
    before, after = t4d.weave(frames, between=between).volumes([0.499, 0.501])
    assert (after / before < 1.01) == (between == "distance")
    with pytest.raises(ValueError, match="between"):
        t4d.weave(frames, between="never")


@pytest.mark.parametrize("plane", [{"time": 2.5}, {"time": 0.7}, {"x": 1.5}, {"z": 20.0}])
def test_a_slice_is_the_programs(models, plane):
    mesh = t4d.read(models / "screw.t4d")
    found = mesh.slice(**plane)
    expected = verbs.slice(models / "screw.t4d", **plane)
    assert len(found.vertices) == expected["vertices"]
    assert len(found.triangles) == expected["triangles"]
    assert found.closed
    assert found.volume == expected["volume"]
    assert found.area == expected["area"]


def test_slices_by_any_hyperplane(models):
    mesh = t4d.read(models / "screw.t4d")
    assert mesh.slice(hyperplane=(0, 0, 0, 2, 5)).volume == mesh.slice(time=2.5).volume
    assert mesh.slice(hyperplane=(0, 1, 0, 0, 3)).volume == mesh.slice(y=3).volume
    assert mesh.slice(hyperplane=(0, 0, 1, 1, 30)).closed
    for wrong in ({}, {"time": 1, "x": 2}):
        with pytest.raises(TypeError):
            mesh.slice(**wrong)
    with pytest.raises(ValueError):
        mesh.slice(hyperplane=(0, 0, 0, 0, 1))
    begin, end = mesh.time_span
    with pytest.raises(t4d.InvalidInput, match=f"from {begin:g} to {end:g}"):
        mesh.slice(time=end + 1)


def test_a_prism_sweeps_area_times_length_times_time(cube):
    vertices, triangles = cube
    motion = {"segments": [{"duration": 2, "translation": [4, 0, 0]}]}
    swept = t4d.sweep(vertices, triangles, motion)
    assert swept.hypervolume == pytest.approx(2, rel=1e-14)
    assert swept.slice(time=1).volume == pytest.approx(1, rel=1e-14)
    V, F = swept.slice(time=2)
    assert np.array_equal(np.unique(V[:, 0]), [4, 5])
    assert F.dtype == np.uint32 and F.max() < len(V)


def test_a_deformation_has_simpsons_hypervolume(cube):
    vertices, triangles = cube
    keys = np.stack([vertices, 2 * vertices, 3 * vertices])
    swept = t4d.sweep(keys, triangles, times=[0, 1, 3])
    expected = (1 + 4 * 1.5**3 + 2**3) / 6 + 2 * (2**3 + 4 * 2.5**3 + 3**3) / 6
    assert swept.hypervolume == pytest.approx(expected, rel=1e-13)


def test_arrays_are_views_that_keep_what_they_show(models):
    def vertices():
        return t4d.read(models / "cube.t4d").slab(1).vertices

    held = vertices()
    gc.collect()
    assert not held.flags.writeable and not held.flags.owndata
    assert held.shape == (88, 4)
    assert np.array_equal(held, t4d.read(models / "cube.t4d").slab(1).vertices)


def test_slabs_join(models):
    mesh = t4d.read(models / "screw.t4d")
    slabs = list(mesh.slabs())
    for before, after in itertools.pairwise(slabs):
        assert np.array_equal(before.upper_layer, after.lower_layer)
        assert before.time_span[1] == after.time_span[0]
    assert mesh.layer_times.tolist() == sorted({time for slab in slabs for time in slab.time_span})
    vertices, cells = mesh.flat()
    assert len(cells) == sum(len(slab.cells) for slab in slabs)
    # The second of the two is kept while the first is in use.
    again = mesh.vertices
    assert np.array_equal(again, vertices) and np.array_equal(mesh.cells, cells)
    assert not np.shares_memory(mesh.vertices, again)
    del again
    assert mesh._other_half is None
    corners = vertices[cells]
    assert np.linalg.det(corners).sum() / 24 == pytest.approx(mesh.hypervolume, rel=1e-12)
    assert set(slabs[1].cell_attributes) == {"triangle", "kind"}
    assert mesh.slab(-1).time_span == slabs[-1].time_span
    with pytest.raises(IndexError):
        mesh.slab(len(slabs))


def test_slabs_of_a_sweep_come_as_they_are_made(cube):
    vertices, triangles = cube
    swept = t4d.sweep(vertices, triangles, SCREW, steps=1_000_000)
    first = list(itertools.islice(swept.slabs(), 3))
    assert [len(slab.cells) for slab in first][1:] == [14 * 12, 14 * 12]


def ball(times, n=24):
    axis = np.linspace(-1, 1, n)
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij")
    for t in times:
        yield np.sqrt((x - 0.3 * t) ** 2 + y**2 + z**2) - 0.5


def test_a_ball_woven_of_an_array_or_of_frames(tmp_path):
    times = [0, 0.5, 1]
    spacing = 2 / 23
    array = np.stack(list(ball(times)))
    options = {"spacing": spacing, "origin": (-1, -1, -1), "times": times}
    whole = t4d.weave(array, **options)
    assert whole.hypervolume == pytest.approx(np.pi / 6, rel=0.03)
    assert whole.slice(time=0.5).volume == pytest.approx(np.pi / 6, rel=0.03)
    frames = t4d.weave(ball(times), **options)
    frames.save(tmp_path / "frames.t4d")
    whole.save(tmp_path / "whole.t4d")
    assert verbs.diff(tmp_path / "frames.t4d", tmp_path / "whole.t4d")["level"] in ("mesh", "bytes")
    with pytest.raises(ValueError, match="have been used"):
        frames.save(tmp_path / "again.t4d")


def test_an_iterator_has_one_frame_in_memory(tmp_path):
    alive = []

    def frames():
        import weakref

        for frame in ball(range(6)):
            frame = frame.astype(np.float32)
            alive.append(weakref.ref(frame))
            assert sum(ref() is not None for ref in alive) <= 2
            yield frame
            del frame

    t4d.weave(frames(), times=range(6)).save(tmp_path / "ball.t4d")
    assert len(alive) == 6


def test_voxels_that_are_no_cubes():
    box = np.zeros((2, 4, 5, 6), dtype=bool)
    box[:, 1:3, 1:4, 1:5] = True
    mesh = t4d.weave(box, spacing=(1, 2, 3), times=[0, 0.5])
    cubes = t4d.weave(box, times=[0, 0.5])
    assert mesh.hypervolume == pytest.approx(6 * cubes.hypervolume, rel=1e-13)
    densities = t4d.weave(box.astype(float), iso=0.5, times=[0, 0.5])
    assert densities.hypervolume == pytest.approx(cubes.hypervolume, rel=1e-6)


def test_wrong_frames_are_named(tmp_path):
    good = np.ones((4, 4, 4), dtype=np.float32)
    good[1:3, 1:3, 1:3] = -1
    cases = [
        ([good, good[:3]], r"frame 1: the array has the shape \(3, 4, 4\), frame 0 \(4, 4, 4\)"),
        ([good, good[0]], r"frame 1: the array has the shape \(4, 4\); expected \(nx, ny, nz\)"),
        ([good, good.astype(int)], "frame 1: the array is of int64; expected floats"),
        ([good, good * np.nan], r"frame 1: the value at \(0, 0, 0\) is nan"),
    ]
    for order in "CF":
        spoilt = np.array(np.stack([good, good]), order=order)
        spoilt[1, 3, 0, 2] = np.nan
        cases.append((spoilt, r"frame 1: the value at \(3, 0, 2\) is nan"))
        cases.append((spoilt.transpose(0, 3, 2, 1), r"the value at \(2, 0, 3\) is nan"))
    for frames, message in cases:
        with pytest.raises(t4d.InvalidInput, match=message):
            t4d.weave(frames).save(tmp_path / "x.t4d")
        assert not (tmp_path / "x.t4d").exists()
    with pytest.raises(t4d.InvalidInput, match="3 times for only 2 frames"):
        t4d.weave(iter([good, good]), times=range(3)).load()

    def broken():
        yield good
        raise KeyError("no more")

    for use in (lambda mesh: mesh.load(), lambda mesh: list(mesh.slabs())):
        with pytest.raises(KeyError, match="no more"):
            use(t4d.weave(broken(), times=range(3)))


def test_an_array_too_large_is_a_memory_error(tmp_path):
    for kind in (bool, np.float32, np.float64, np.int16):
        huge = np.broadcast_to(kind(0), (2, 2**19, 2**19, 2**19))
        for use in (lambda mesh: mesh.load(), lambda mesh: mesh.save(tmp_path / "x.t4d")):
            with pytest.raises(MemoryError):
                use(t4d.weave(huge, iso=None if kind is not np.int16 else 0.5))
    assert list(tmp_path.iterdir()) == []


def test_a_mesh_that_is_woven_later_sees_the_arrays_as_they_are_then():
    box = np.zeros((2, 6, 6, 6), dtype=bool)
    box[:, 1:3, 1:3, 1:3] = True
    small = t4d.weave(box.copy()).load().hypervolume
    lazy, loaded = t4d.weave(box), t4d.weave(box).load()
    box[:, 1:5, 1:5, 1:5] = True
    assert loaded.hypervolume == small < t4d.weave(box).hypervolume == lazy.hypervolume


@pytest.mark.parametrize("spacing", [1, 0.1, (1, 2, 3), 1e-20])
def test_far_arrays_are_refused(spacing):
    box = np.zeros((2, 6, 6, 6), dtype=bool)
    box[:, 1:5, 1:4, 1:3] = True
    expected = t4d.weave(box, spacing=spacing).hypervolume
    assert expected > 0
    for away in (1e3, 1e8):
        near = t4d.weave(box, spacing=spacing, origin=away * np.min(spacing) * np.ones(3))
        assert near.hypervolume == pytest.approx(expected, rel=1e-6)
    for away in (1e10, 1e16, 1e17, 1e40, 1e80):
        for axis in range(3):
            far = t4d.weave(box, spacing=spacing, origin=away * np.max(spacing) * np.eye(3)[axis])
            with pytest.raises(t4d.InvalidInput, match="frame 0: lies up to .* voxels from the origin"):
                far.load()


def test_motions_are_the_same_however_given():
    angles = np.linspace(0, np.pi / 2, 5)
    times = np.linspace(0, 1, 5)
    matrices = np.tile(np.eye(4), (5, 1, 1))
    matrices[:, 0, 0] = matrices[:, 1, 1] = np.cos(angles)
    matrices[:, 1, 0], matrices[:, 0, 1] = np.sin(angles), -np.sin(angles)
    matrices[:, 2, 3] = 3 * times
    quaternions = np.stack([0 * angles, 0 * angles, np.sin(angles / 2), np.cos(angles / 2)], axis=1)
    given = [
        t4d.Motion(SCREW),
        t4d.Motion.from_matrices(times, matrices),
        t4d.Motion.from_quaternions(times, matrices[:, :3, 3], quaternions),
    ]
    for motion in given:
        assert motion.time_span == (0, 1)
        for time in np.linspace(0, 1, 9):
            assert np.allclose(motion.at(time), given[0].at(time), atol=1e-14)
    random = np.random.default_rng(7)
    for _ in range(100):
        rotation, _ = np.linalg.qr(random.normal(size=(3, 3)))
        pose = np.eye(4)
        pose[:3, :3] = rotation * np.sign(np.linalg.det(rotation))
        pose[:3, 3] = random.normal(size=3)
        motion = t4d.Motion.from_matrices([0, 1], [np.eye(4), pose])
        assert np.allclose(motion.at(1), pose, atol=1e-12)
    with pytest.raises(ValueError, match="matrix 1 is not a rotation"):
        t4d.Motion.from_matrices([0, 1], [np.eye(4), 2 * np.eye(4)])
    with pytest.raises(t4d.InvalidInput, match="duration"):
        t4d.Motion({"segments": [{}]})


def test_errors_say_where_and_why(models, tmp_path, cube):
    with pytest.raises(t4d.FileError) as caught:
        t4d.read(tmp_path / "missing.t4d")
    assert caught.value.file == str(tmp_path / "missing.t4d")
    assert isinstance(caught.value, OSError)
    (tmp_path / "broken.obj").write_text("v 0 0 zero\n")
    with pytest.raises(t4d.InvalidInput) as caught:
        t4d.read_triangles(tmp_path / "broken.obj")
    assert caught.value.where == f"{tmp_path / 'broken.obj'}:1"
    assert caught.value.file == str(tmp_path / "broken.obj")
    data = (models / "cube.t4d").read_bytes()
    (tmp_path / "cut.t4d").write_bytes(data[: len(data) // 2])
    with pytest.raises(t4d.InvalidInput) as caught:
        t4d.read(tmp_path / "cut.t4d")
    assert caught.value.file == str(tmp_path / "cut.t4d")
    vertices, triangles = cube
    with pytest.raises(ValueError, match="shape"):
        t4d.TriangleMesh(vertices[:, :2], triangles)
    with pytest.raises(ValueError, match=r"triangles\[0\]\[2\] is 99; expected the index of one of 8 vertices"):
        t4d.TriangleMesh(vertices, [[0, 1, 99]])
    with pytest.raises(t4d.InvalidInput, match="closed|edge"):
        t4d.sweep(vertices, triangles[:-1], SCREW).load()
    with pytest.raises(ValueError, match="writes .t4d"):
        t4d.sweep(vertices, triangles, SCREW).save(tmp_path / "x.vtu")


def test_attributes_travel(cube, tmp_path):
    vertices, triangles = cube
    heat = np.arange(12, dtype=np.float32)
    mesh = t4d.TriangleMesh(vertices, triangles, triangle_attributes={"heat": heat})
    swept = t4d.sweep(mesh, motion=SCREW)
    swept.save(tmp_path / "x.t4d")
    for made in (swept, t4d.read(tmp_path / "x.t4d")):
        section = made.slice(time=0.5)
        number = section.triangle_attributes["triangle"]
        assert np.array_equal(section.triangle_attributes["heat"], heat[number])
    with pytest.raises(ValueError, match="attribute 'heat' has the shape"):
        t4d.TriangleMesh(vertices, triangles, triangle_attributes={"heat": heat[:3]})


@pytest.mark.parametrize("kind", ["ply", "vtp", "glb", "gltf", "stl", "obj", "off"])
def test_attributes_that_a_format_cannot_hold_are_listed(cube, tmp_path, kind):
    vertices, triangles = cube
    mesh = t4d.TriangleMesh(
        vertices, triangles, {"heat": np.arange(8, dtype=np.float32)}, {"part": np.arange(12)}
    )
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        mesh.save(tmp_path / f"x.{kind}", attributes=True)
    lost = {word for loss in caught for word in ("heat", "part") if f"'{word}'" in str(loss.message)}
    assert all(loss.category is t4d.Loss for loss in caught)
    assert lost == {"ply": set(), "vtp": set(), "glb": {"part"}, "gltf": {"part"}}.get(
        kind, {"heat", "part"}
    )
    data = (tmp_path / f"x.{kind}").read_bytes().lower()
    assert (b"heat" in data) == ("heat" not in lost) and (b"part" in data) == ("part" not in lost)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh.save(tmp_path / f"y.{kind}")
    assert b"heat" not in (tmp_path / f"y.{kind}").read_bytes().lower()


def test_several_bodies(models, tmp_path):
    one = t4d.read(models / "cube.t4d")
    two = t4d.read(models / "screw.t4d")
    assert one.names == ["paper-cube"] and len(one) == 1
    both = t4d.Mesh._of([*one._bodies, *two._bodies])
    with pytest.raises(ValueError, match="choose one"):
        both.slice(time=1)
    assert both[1].slice(time=1).closed
    with pytest.raises(KeyError, match="no body 'nut'"):
        one["nut"]


def test_a_sweep_says_its_units_and_what_is_up(cube, tmp_path):
    vertices, triangles = cube
    keys = np.stack([vertices, vertices + 1])
    t4d.sweep(keys, triangles, times=[0, 1], units=("mm", "s"), up="z").save(tmp_path / "x.t4d")
    mesh = t4d.read(tmp_path / "x.t4d")
    assert (mesh.length_unit, mesh.time_unit, mesh.up) == ("mm", "s", "z")
    motion = {"length_unit": "in", "segments": [{"duration": 1}]}
    assert t4d.sweep(vertices, triangles, motion).length_unit == "in"
    assert t4d.sweep(vertices, triangles, motion, units="cm").length_unit == "cm"
    assert t4d.sweep(vertices, triangles, motion).up == "y"


def test_progress_and_what_it_raises(cube, tmp_path):
    vertices, triangles = cube
    seen = []
    swept = t4d.sweep(vertices, triangles, SCREW, steps=30_000)
    swept.save(tmp_path / "x.t4d", progress=seen.append)
    assert seen == sorted(seen) and seen[-1] == 1

    class Enough(Exception):
        pass

    def stop(fraction):
        raise Enough

    swept = t4d.sweep(vertices, triangles, SCREW, steps=300_000)
    with pytest.raises(Enough):
        swept.save(tmp_path / "y.t4d", progress=stop)
    assert os.listdir(tmp_path) == ["x.t4d"]


def test_ctrl_c_ends_long_work(cube, tmp_path):
    vertices, triangles = cube
    swept = t4d.sweep(vertices, triangles, SCREW, steps=20_000_000)
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        swept.save(tmp_path / "x.t4d")
    assert time.monotonic() - begin < 30
    assert os.listdir(tmp_path) == []


def test_other_threads_run_meanwhile(cube, tmp_path):
    vertices, triangles = cube
    swept = t4d.sweep(vertices, triangles, SCREW, steps=100_000)
    worker = threading.Thread(target=lambda: swept.save(tmp_path / "x.t4d"))
    worker.start()
    turns = 0
    while worker.is_alive():
        turns += 1
        time.sleep(0.001)
    assert turns > 10


def test_ten_thousand_slices_leak_nothing(models):
    mesh = t4d.read(models / "cube.t4d")

    def some(count):
        for i in range(count):
            vertices, _ = mesh.slice(time=0.5 + 60 * i / count)
            assert len(vertices)
        gc.collect()
        with open("/proc/self/statm") as statm:
            return int(statm.read().split()[1]) * resource.getpagesize()

    before = some(1000)
    after = some(10_000)
    assert after - before < 8 << 20


def test_memory_of_a_long_sweep_is_that_of_a_slab(cube, tmp_path):
    vertices, triangles = cube
    script = (
        "import resource, sys, numpy as np, t4d\n"
        "V, F, motion = np.array(eval(sys.argv[1])), np.array(eval(sys.argv[2])), eval(sys.argv[3])\n"
        "t4d.sweep(V, F, motion, steps=int(sys.argv[4])).save(sys.argv[5])\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)\n"
    )

    def peak(steps):
        arguments = [repr(vertices.tolist()), repr(triangles.tolist()), repr(SCREW), str(steps)]
        command = [os.sys.executable, "-c", script, *arguments, str(tmp_path / "x.t4d")]
        return int(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

    # The index of the file takes some 200 bytes a slab.
    assert peak(101_000) - peak(1000) < 60 << 10


def test_verbs_have_the_words_of_the_program(models, program, tmp_path):
    text = subprocess.run([program, "--help"], capture_output=True, text=True, check=True).stdout
    listed = text.split("Subcommands:")[1].split("\n\n")[0]
    words = [line.split()[0].rstrip(",") for line in listed.splitlines() if line.startswith("  ") and line[2] != " "]
    assert words == verbs.__all__
    assert "Usage: t4d quality" in verbs.quality.__doc__
    parameters = inspect.signature(verbs.slice).parameters
    assert parameters["coplanar"].default is None and parameters["light"].default is False
    untyped = [word for word in words if not hasattr(verbs, f"{word.capitalize()}Report")]
    assert untyped == ["conform", "join", "cat"]
    assert verbs.options_of("slice")["o"]["names"] == ["-o", "--output"]
    assert verbs.options_of("weave")["label"]["repeats"]
    info = verbs.info(models / "cube.t4d")
    assert json.dumps(info)
    assert verbs.validate(models / "cube.t4d")["valid"]
    verbs.slice(models / "cube.t4d", time=2, o=tmp_path / "two.stl")
    assert (tmp_path / "two.stl").exists()
    with pytest.raises(t4d.VerbError) as caught:
        verbs.slice(models / "cube.t4d", time=99)
    assert caught.value.exit_code == 4 and "from 0 to 64" in str(caught.value)
    with pytest.raises(TypeError, match="tiem"):
        verbs.slice(models / "cube.t4d", tiem=2)


def test_labels_and_affines(tmp_path):
    points = np.indices((24, 24, 24))
    frames = np.zeros((3, 24, 24, 24), np.int16)
    for i in range(3):
        frames[i][((points - np.reshape([7 + i, 7, 7], (3, 1, 1, 1))) ** 2).sum(0) < 16] = 1
        frames[i][((points - np.reshape([16 - i, 16, 16], (3, 1, 1, 1))) ** 2).sum(0) < 9] = -2
    one = t4d.weave(frames, label=1)
    assert one.measure([1])["centroid"] == pytest.approx(np.array([[8, 7, 7]]), abs=1e-9)
    assert one.hypervolume == t4d.weave(frames == 1).hypervolume
    both = t4d.weave(frames, label=[1, -2], name="cell")
    assert both.names == ["cell 1", "cell -2"]
    both.save(tmp_path / "cells.t4d")
    assert t4d.read(tmp_path / "cells.t4d")["cell -2"].check()["valid"]

    # A turn, long voxels, a mirror, and a shift.
    affine = np.array([[0, 0, -3.0, 50], [2, 0, 0, 60], [0, 1.5, 0, 70], [0, 0, 0, 1]])
    placed = t4d.weave(frames, label=1, affine=affine)
    centre = affine[:3] @ np.array([8, 7, 7, 1])
    assert placed.measure([1])["centroid"][0] == pytest.approx(centre, abs=1e-9)
    assert placed.check()["valid"]
    assert placed.volumes([0])[0] == pytest.approx(9 * one.volumes([0])[0], rel=1e-12)
    same = t4d.weave(frames, label=1, affine=affine[:3])
    assert np.array_equal(same.vertices, placed.vertices)

    for wrong, error in [
        ({"label": 1, "iso": 0.5}, TypeError),
        ({"label": 1.5}, TypeError),
        ({"label": [1, 1]}, ValueError),
        ({"label": []}, ValueError),
        ({"label": 2**63}, ValueError),
        ({"label": 1, "affine": np.eye(3)}, ValueError),
        ({"label": 1, "affine": np.full((4, 4), np.nan)}, ValueError),
        ({"label": 1, "affine": np.zeros((3, 4))}, ValueError),
        ({"label": 1, "affine": np.eye(4), "spacing": 2}, TypeError),
        ({"label": 1, "affine": np.eye(4), "origin": (1, 0, 0)}, TypeError),
    ]:
        with pytest.raises(error):
            t4d.weave(frames, **wrong)
    with pytest.raises(TypeError, match="once"):
        t4d.weave(iter(frames), label=[1, -2], times=range(3))
    every = t4d.weave(frames, label="all", name="cell")
    assert every.names == [f"cell {one}" for one in np.unique(frames) if one != 0]
    with pytest.raises(t4d.InvalidInput, match="labels are whole numbers"):
        t4d.weave(frames.astype(float), label=1).load()


def test_below_and_no_data():
    side = np.arange(-5, 6.0)
    squares = side[:, None, None] ** 2 + side[:, None] ** 2 + side**2
    frames = np.stack([squares, squares])
    volume = t4d.weave(-frames, iso=-9).volumes([0.5])
    assert t4d.weave(frames, below=9).volumes([0.5]) == volume
    half = np.where(side[:, None, None] > 0, np.nan, frames)
    assert 0 < t4d.weave(half, below=9, outside_value=np.nan).volumes([0.5]) < 0.7 * volume
    with pytest.raises(t4d.InvalidInput):
        t4d.weave(half, below=9).load()
    with pytest.raises(TypeError, match="exclude each other"):
        t4d.weave(frames, below=9, iso=3)


def test_a_curve_retimes_frames(models, tmp_path):
    curve = tmp_path / "curve.csv"
    curve.write_text("playback,time\n0,2\n1,1\n")
    report = verbs.frames(models / "cube.t4d", speed_file=curve, fps=2, format="ply", o=tmp_path / "frames")
    assert (report.frames, report.time_begin, report.time_end) == (3, 2, 1)


def test_velocities_of_slices_are_the_programs(models, tmp_path):
    mesh = t4d.read(models / "screw.t4d")
    for light in (False, True):
        found = mesh.slice(7.7, light=light, velocity=True)
        velocity = found.vertex_attributes["velocity"]
        assert velocity.shape == found.vertices.shape
        report = verbs.slice(models / "screw.t4d", time=7.7, light=light, velocity=True)
        assert np.linalg.norm(velocity, axis=1).max() == pytest.approx(report.max_speed)
        rate = (mesh.slice(7.7 + 1e-4).volume - mesh.slice(7.7 - 1e-4).volume) / 2e-4
        assert report.volume_rate == pytest.approx(rate, abs=1e-4 * found.volume)
        (again,) = mesh.slices([7.7], light=light, velocity=True, max_speed=report.max_speed / 2)
        slower = np.linalg.norm(again.vertex_attributes["velocity"], axis=1)
        assert slower.max() == pytest.approx(report.max_speed / 2)
        assert "velocity" not in mesh.slice(7.7, light=light).vertex_attributes
    with pytest.raises(TypeError, match="at a time"):
        mesh.slice(x=1, velocity=True)
    with pytest.raises(TypeError, match="needs velocity=True"):
        mesh.slice(1, max_speed=2)
    with pytest.raises(ValueError, match="above zero"):
        mesh.slice(1, velocity=True, max_speed=-2)


def test_light_slices_are_the_programs(models, tmp_path):
    mesh = t4d.read(models / "screw.t4d")
    times = [30.3, 0, 64, 7.7]
    light = mesh.slices(times, light=True)
    for time, found in zip(times, light):
        expected = verbs.slice(
            models / "screw.t4d", time=time, light=True, output=t4d.TriangleMesh
        ).mesh
        assert np.array_equal(found.vertices, expected.vertices)
        assert np.array_equal(found.triangles, expected.triangles)
        assert np.array_equal(found.triangles, light[1].triangles)
        assert np.array_equal(found.vertices, mesh.slice(time, light=True).vertices)
        exact = mesh.slice(time)
        assert len(found.triangles) <= len(exact.triangles)
        assert found.volume == pytest.approx(exact.volume, rel=1e-12)
    woven = t4d.weave(np.pad(np.ones((2, 3, 3, 3), bool), ((0, 0), (1, 1), (1, 1), (1, 1))))
    with pytest.warns(UserWarning, match="exact where a slab does not consist of prisms"):
        assert np.array_equal(woven.slice(0.5, light=True).vertices, woven.slice(0.5).vertices)
    with pytest.raises(t4d.InvalidInput, match="outside"):
        mesh.slices([1, 999], light=True)
    with pytest.raises(TypeError, match="at a time"):
        mesh.slice(x=1, light=True)
    with pytest.raises(TypeError):
        mesh.slice(1, light=1)


def test_a_file_in_parts_is_read_as_one_file(models, tmp_path, program):
    solid = models / "paper-cube.obj", "--motion", models / "paper-screw.json"
    parts = [tmp_path / f"{k}.t4d" for k in (1, 2, 3)]
    for k, part in enumerate(parts, start=1):
        subprocess.run([program, "sweep", *solid, "--part", f"{k}/3", "-o", part, "-q"], check=True)
    manifest = tmp_path / "parts.t4dm"
    subprocess.run([program, "join", *parts, "--manifest", "-o", manifest, "-q"], check=True)
    whole, parted = t4d.read(models / "screw.t4d"), t4d.read(manifest, whole=True)
    assert parted.time_span == whole.time_span and parted.slab_count == whole.slab_count
    begin, end = whole.time_span
    for time in np.linspace(begin, end, 7):
        assert np.array_equal(parted.slice(time=time).vertices, whole.slice(time=time).vertices)
    assert parted.check()["valid"]
    parted = t4d.read(manifest)
    parts[1].unlink()
    assert parted.slice(time=begin).volume > 0
    with pytest.raises(t4d.Error, match="2.t4d"):
        parted.slice(time=(begin + end) / 2)
    with pytest.raises(t4d.Error, match="2.t4d"):
        [slab.time_span for slab in parted.slabs()]

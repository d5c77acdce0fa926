"""Verbs on meshes in memory."""

import pickle
import shutil
import subprocess
import sys
import typing

import numpy as np
import pytest
import t4d
from t4d import verbs


def test_collide_finds_the_same_in_memory_as_in_files(cube, tmp_path):
    vertices, triangles = cube
    motion = t4d.Motion({"segments": [{"duration": 2, "axis_point": [0, 0, 0], "axis_direction": [0, 0, 1],
                                      "angle_degrees": 40, "translation": [0, 0, 3]}]})
    turning = t4d.sweep(vertices, triangles, motion)
    still = t4d.sweep(vertices + [3, 0, 0], triangles, {"segments": [{"duration": 2}]})
    found = t4d.collide(turning, still)
    turning.save(tmp_path / "turning.t4d")
    still.save(tmp_path / "still.t4d")
    assert found == verbs.collide(tmp_path / "turning.t4d", tmp_path / "still.t4d")
    assert found.pairs[0].verdict == found["pairs"][0]["verdict"] == "clear"
    with pytest.raises(AttributeError, match="has no 'verdict'; it has pairs"):
        found.verdict
    assert isinstance(found, verbs.CollideReport) and isinstance(found.pairs[0], verbs.CollidePair)
    again = pickle.loads(pickle.dumps(found))
    assert again == found and again.pairs[0].verdict == "clear"


def test_what_verbs_find_wrong_is_a_report_and_what_is_not_printed_is_none(models, tmp_path):
    found = verbs.diff(models / "cube.t4d", models / "screw.t4d")
    assert not found.same and found.level == "different" and found.messages
    assert verbs.validate(models / "cube.t4d").part is None
    assert verbs.quality(models / "cube.t4d", most_parts=True).parts > 0
    with pytest.raises(t4d.VerbError):
        verbs.collide(models / "cube.t4d", models / "cube.t4d", fail_on_contact=True)
    assert isinstance(found.copy(), verbs.DiffReport)


def test_tracks_are_tables_of_the_report(cube):
    vertices, triangles = cube
    mesh = t4d.sweep(vertices, triangles, {"segments": [{"duration": 2}]})
    found = mesh.tracks(times=(0, 1, 2))
    assert found.tracks["id"].tolist() == [1] and found.tracks["begins"][0] == "mesh"
    assert found.tracks["from"] == found.tracks["into"] == [[]] and found.links == []
    assert found.samples["time"].tolist() == [0, 1, 2] and found.samples["x"].shape == (3,)
    assert np.isnan(found.samples["speed"][0]) and abs(found.samples["speed"][1]) < 1e-14
    assert np.allclose(found.samples["volume"], mesh.volumes([0, 1, 2]))
    assert found.events["x"].shape == (0,) and found.events["before"] == []


def test_the_last_option_takes_no_file(models):
    plane = verbs.slice(models / "cube.t4d", hyperplane=(0, 0, 0, 1, 2), output=t4d.TriangleMesh)
    again = verbs.slice(models / "cube.t4d", output=t4d.TriangleMesh, time=np.array(2))
    assert plane.mesh.volume == again.mesh.volume != 0
    rows = np.hstack([np.eye(3), [[1], [2], [3]]])
    moved = verbs.transform(models / "cube.t4d", matrix=rows, output=t4d.Mesh).mesh
    assert np.array_equal(moved.slice(time=2).vertices, again.mesh.vertices + [1, 2, 3])


def test_annotations_can_be_evaluated():
    for verb in verbs.__all__:
        typing.get_type_hints(getattr(verbs, verb))


def test_an_envelope_in_memory_is_the_one_that_is_written(models, tmp_path):
    mesh = t4d.read(models / "cube.t4d")
    report = t4d.envelope(mesh, voxel_size=1)
    verbs.envelope(models / "cube.t4d", voxel_size=1, output=tmp_path / "envelope.ply")
    written = t4d.read_triangles(tmp_path / "envelope.ply")
    assert np.array_equal(report.mesh.vertices, written.vertices)
    assert np.array_equal(report.mesh.triangles, written.triangles)
    assert report.mesh.volume == pytest.approx(report.volume, rel=1e-9)


def test_mend_closes_an_open_cube(cube):
    vertices, triangles = cube
    report = t4d.mend(vertices / 3, triangles[:-2])
    assert report.mesh.closed and report.closed
    assert report.mesh.volume == pytest.approx(1 / 27)
    # Nothing is rounded, though a third has no end.
    assert {tuple(v) for v in report.mesh.vertices} == {tuple(v) for v in vertices / 3}
    again = t4d.mend(t4d.TriangleMesh(vertices / 3, triangles[:-2]))
    assert np.array_equal(again.mesh.vertices, report.mesh.vertices)


def test_resolve_leaves_clear_solids(cube):
    vertices, triangles = cube
    motion = t4d.Motion({"segments": [{"duration": 1, "translation": [4, 0, 0]}]})
    rest = t4d.Motion({"segments": [{"duration": 1}]})
    moving = t4d.sweep(vertices, triangles, motion)
    wall = t4d.sweep(vertices + [2, 0.9, 0], triangles, rest)
    assert t4d.collide(wall, moving).pairs[0].contact
    report = t4d.resolve(wall, moving, clearance=0.01)
    assert isinstance(report.mesh, t4d.Mesh)
    assert not t4d.collide(wall, report.mesh).pairs[0].contact


def test_verbs_read_the_file_of_a_mesh_only_while_it_is_that_file(models, tmp_path):
    path = tmp_path / "a.t4d"
    shutil.copy(models / "cube.t4d", path)
    mesh = t4d.read(path)
    cells = verbs.quality(mesh).cells
    shutil.copy(models / "screw.t4d", tmp_path / "b.t4d")
    (tmp_path / "b.t4d").replace(path)
    assert verbs.quality(mesh).cells == cells != verbs.quality(path).cells
    path.unlink()
    assert verbs.quality(mesh).cells == cells


def test_outputs_are_paths_or_classes_of_meshes(models):
    made = verbs.transform(models / "cube.t4d", move=[1, 2, 3], output=t4d.Mesh).mesh
    assert made.slice(time=0).vertices.min(axis=0) == pytest.approx(
        t4d.read(models / "cube.t4d").slice(time=0).vertices.min(axis=0) + [1, 2, 3]
    )
    with pytest.raises(TypeError, match="expected a path, t4d.Mesh or t4d.TriangleMesh"):
        verbs.transform(models / "cube.t4d", move=[1, 2, 3], output=dict)
    with pytest.raises(t4d.VerbError):
        verbs.transform(models / "cube.t4d", move=[1, 2, 3], output=t4d.TriangleMesh)


def test_a_body_of_several_is_all_that_a_verb_sees(models, tmp_path):
    verbs.weave(models / "labels.nrrd", label=[1, 2], output=tmp_path / "both.t4d")
    both = t4d.read(tmp_path / "both.t4d")
    names = both.names
    assert len(names) > 1
    assert [body["name"] for body in verbs.info(both[1])["bodies"]] == names[1:2]


def test_simplify_in_memory_keeps_the_hypervolume_and_its_promise(models):
    mesh = t4d.read(models / "cube.t4d")
    small = mesh.simplify(max_error=0.1)
    cells = [sum(len(slab.cells) for slab in one.slabs()) for one in (mesh, small)]
    assert cells[1] < cells[0] / 10
    assert small.hypervolume == pytest.approx(512000, rel=1e-12)
    assert small.time_span == mesh.time_span
    with pytest.raises(t4d.Error, match="at most 1"):
        mesh.simplify(ratio=2)


def test_a_dictionary_is_a_file_of_json(cube, tmp_path):
    steps = {"segments": [{"duration": np.float64(2), "translation": np.array([1, 0, 0])}]}
    swept = t4d.verbs.sweep(t4d.TriangleMesh(*cube), motion=steps, output=t4d.Mesh).mesh
    assert swept.time_span == (0, 2)
    with pytest.raises(TypeError, match="motion is a t4d.Motion; expected a motion file or a dictionary"):
        t4d.verbs.sweep("cube.obj", motion=t4d.Motion(steps), output=tmp_path / "out.t4d")


def test_verbs_come_with_the_module():
    code = "import t4d; print(t4d.verbs.__name__, t4d.distributed.__name__, hasattr(t4d, 'nothing'))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "t4d.verbs t4d.distributed False\n"

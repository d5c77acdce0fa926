"""USD as Pixar's own library reads it: every sample is ours, and its validators find nothing."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

pxr = pytest.importorskip("pxr")
from pxr import Usd, UsdGeom, UsdValidation  # noqa: E402

import t4d  # noqa: E402
from t4d import verbs  # noqa: E402

BUILD = Path(os.environ["T4D_BUILD"])
FRAMES = 7


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("usd")
    subprocess.run([BUILD / "t4d-fixtures", made], check=True, stdout=subprocess.DEVNULL)
    bolt = [made / "bolt.obj", "--motion", made / "screw-in.json", "--up", "z"]
    pebble = [made / "pebble.obj", "--motion", made / "paper-translation.json"]
    for name, words in [("bolt", bolt), ("pebble", pebble)]:
        subprocess.run([BUILD / "t4d", "sweep", *words, "-q", "-o", made / f"{name}.t4d"], check=True)
    return made


@pytest.fixture
def bolt(folder):
    return t4d.read(folder / "bolt.t4d")


def meshes(stage):
    return [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]


def valid(path):
    """The stage, in which the validators of usdchecker find nothing."""
    stage = Usd.Stage.Open(str(path))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) > 10
    found = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [f"{error.GetName()}: {error.GetMessage()}" for error in found] == []
    return stage


def assert_is(mesh, code, expected):
    """The vertices and triangles of a slice, at a time code."""
    assert np.array_equal(mesh.GetPointsAttr().Get(code), expected.vertices.astype(np.float32))
    corners = np.array(mesh.GetFaceVertexIndicesAttr().Get(code)).reshape(-1, 3)
    assert np.array_equal(corners, expected.triangles)
    assert set(mesh.GetFaceVertexCountsAttr().Get(code)) == {3}
    low, high = np.array(mesh.GetExtentAttr().Get(code))
    assert np.array_equal(low, expected.vertices.astype(np.float32).min(axis=0))
    assert np.array_equal(high, expected.vertices.astype(np.float32).max(axis=0))


@pytest.mark.parametrize("extension", ["usda", "usdz", "usdc"])
@pytest.mark.parametrize("exact", [False, True])
def test_every_sample_is_the_slice(folder, bolt, extension, exact, tmp_path):
    place = tmp_path / f"bolt.{extension}"
    report = verbs.flipbook(bolt, frames=FRAMES, exact=exact, output=place)
    assert report.files == [str(place)] and report.bytes == place.stat().st_size
    stage = valid(place)
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0, FRAMES - 1)
    assert stage.GetTimeCodesPerSecond() == (FRAMES - 1) / 5  # real time
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.001
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    (mesh,) = meshes(stage)
    times = np.linspace(0, 5, FRAMES)
    for code, time in enumerate(times):
        assert stage.GetDefaultPrim().GetAttribute("t4d:time").Get(code) == pytest.approx(time)
        assert_is(mesh, code, bolt.slice(time, light=not exact))
    # Points of one mesh move straight between samples; of several they stay.
    between = np.array(mesh.GetPointsAttr().Get(0.5))
    first = np.array(mesh.GetPointsAttr().Get(0))
    if exact:
        assert np.array_equal(between, first)
    else:
        halfway = (first + np.array(mesh.GetPointsAttr().Get(1))) / 2
        assert np.allclose(between, halfway, atol=1e-5)


def test_velocities_are_per_second_of_playback(bolt, tmp_path):
    place = tmp_path / "bolt.usda"
    verbs.flipbook(bolt, times="1:2:5", fps=8, velocity=True, output=place)
    stage = valid(place)
    (mesh,) = meshes(stage)
    rate = 0.25 * 8
    for code, time in enumerate(np.linspace(1, 2, 5)):
        expected = bolt.slice(time, light=True, velocity=True).vertex_attributes["velocity"]
        assert np.allclose(mesh.GetVelocitiesAttr().Get(code), rate * expected, rtol=1e-6, atol=1e-6)
    # Players move points by them, for motion blur: here as far as the step of the mesh goes.
    moved = np.array(UsdGeom.PointBased(mesh).ComputePointsAtTime(0.02, 0))
    assert np.abs(moved - bolt.slice(1.005, light=True).vertices).max() < 1e-5
    assert np.abs(moved - bolt.slice(1, light=True).vertices).max() > 0.01


def test_colours_normals_and_attributes(bolt, tmp_path):
    place = tmp_path / "bolt.usda"
    verbs.flipbook(bolt, frames=3, color="time", normals="smooth", attributes=True, output=place)
    stage = valid(place)
    (mesh,) = meshes(stage)
    first, last = (np.array(mesh.GetDisplayColorAttr().Get(code)) for code in (0, 2))
    assert mesh.GetDisplayColorPrimvar().GetInterpolation() == "constant"
    assert first.shape == (1, 3) and not np.array_equal(first, last)
    assert mesh.GetNormalsInterpolation() == "faceVarying"
    normals = np.array(mesh.GetNormalsAttr().Get(1))
    expected = bolt.slice(2.5, light=True)
    assert normals.shape == (3 * len(expected.triangles), 3)
    corners = expected.vertices[expected.triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("ij,ij->i", normals[::3], across) > 0).mean() > 0.9
    primvar = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("triangle")
    assert primvar.GetInterpolation() == "uniform"
    assert np.array_equal(primvar.Get(1), expected.triangle_attributes["triangle"])


def test_shapes_at_layers_are_the_light_slice_at_any_time(bolt, tmp_path):
    place = tmp_path / "bolt.usda"
    verbs.flipbook(bolt, frames=11, morph=True, output=place)
    stage = valid(place)
    (mesh,) = meshes(stage)
    for code in (0, 0.3, 4.77, 10):
        expected = bolt.slice(code / 2, light=True).vertices
        assert np.abs(np.array(mesh.GetPointsAttr().Get(code)) - expected).max() < 1e-5


def test_poses_move_the_solid(bolt, tmp_path):
    place = tmp_path / "bolt.usda"
    report = verbs.flipbook(bolt, frames=11, rigid=True, output=place)
    stage = valid(place)
    (mesh,) = meshes(stage)
    assert place.stat().st_size < 300_000
    for code in (0, 0.3, 4.77, 10):
        to_world = np.array(mesh.ComputeLocalToWorldTransform(code))
        points = np.array(mesh.GetPointsAttr().Get(code)) @ to_world[:3, :3] + to_world[3, :3]
        assert np.abs(points - bolt.slice(code / 2, light=True).vertices).max() < report.distance + 1e-5


@pytest.mark.parametrize("light", [False, True])
def test_frames_are_a_value_clip_set(bolt, light, tmp_path):
    verbs.frames(bolt, frames=FRAMES, format="usda", light=light, velocity=True, output=tmp_path / "set")
    stage = valid(tmp_path / "set" / "frames.usda")
    (mesh,) = meshes(stage)
    for code, time in enumerate(np.linspace(0, 5, FRAMES)):
        assert mesh.ComputeVisibility(code) == "inherited"
        assert_is(mesh, code, bolt.slice(time, light=light))
        assert len(mesh.GetVelocitiesAttr().Get(code)) == len(mesh.GetPointsAttr().Get(code))
    valid(tmp_path / "set" / "frame_0003.usda")
    # Flattened it is an animation that can be swept again.
    if light:
        stage.Flatten().Export(str(tmp_path / "flat.usda"))
        swept = verbs.sweep(tmp_path / "flat.usda", output=t4d.Mesh).mesh
        assert swept.slice(0).volume == pytest.approx(1e-9 * bolt.slice(0).volume, rel=1e-5)  # from millimetres


def test_slices_and_names(bolt, tmp_path):
    solid = bolt.slice(2.5)
    for extension in ("usda", "usdz", "usdc"):
        place = tmp_path / f"solid.{extension}"
        solid.save(place, name='7 "bolts"', attributes=True)
        stage = valid(place)
        (mesh,) = meshes(stage)
        assert mesh.GetPrim().GetName() == "_7__bolts_"
        assert mesh.GetPrim().GetDisplayName() == '7 "bolts"'
        assert_is(mesh, 0, solid)
        assert t4d.read_triangles(place).volume == pytest.approx(solid.volume, rel=1e-6)


def written_stage(path, up="Z"):
    """A stage of Pixar's, of a cube that turns about a pivot within an arm, and breathes."""
    stage = Usd.Stage.CreateNew(str(path))
    stage.SetTimeCodesPerSecond(10)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(20)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.SetStageUpAxis(stage, up)
    arm = UsdGeom.Xform.Define(stage, "/arm")
    turn = arm.AddRotateZOp()
    turn.Set(0, 0)
    turn.Set(150, 20)
    mesh = UsdGeom.Mesh.Define(stage, "/arm/cube")
    mesh.AddTranslateOp().Set((4, 0, 0))
    pivot = mesh.AddTranslateOp(opSuffix="pivot")
    pivot.Set((0.5, 0.5, 0.5))
    spin = mesh.AddRotateXYZOp()
    for code, angles in [(0, (0, 0, 0)), (8, (40, -30, 90)), (20, (0, 0, 200))]:
        spin.Set(angles, code)
    mesh.AddScaleOp().Set((1, 2, 1))
    mesh.AddTranslateOp(opSuffix="pivot", isInverseOp=True)
    corners = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)], dtype=float)
    for code in range(0, 21, 4):
        mesh.GetPointsAttr().Set(corners * (1 + 0.1 * np.sin(code)), code)
    squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    mesh.GetFaceVertexCountsAttr().Set([4] * 6)
    mesh.GetFaceVertexIndicesAttr().Set(sum(squares, []))
    mesh.GetSubdivisionSchemeAttr().Set("none")
    stage.Save()
    return stage, mesh


def test_bodies_are_visible_while_they_exist(tmp_path):
    stage, mesh = written_stage(tmp_path / "in.usda")
    other = UsdGeom.Mesh.Define(stage, "/other")
    for name in ("points", "faceVertexCounts", "faceVertexIndices", "subdivisionScheme"):
        value = mesh.GetPrim().GetAttribute(name).Get(0)
        other.GetPrim().GetAttribute(name).Set(value)
    for code, word in [(0, "invisible"), (5, "inherited"), (15, "invisible")]:
        other.GetVisibilityAttr().Set(word, code)
    stage.Save()
    verbs.sweep(tmp_path / "in.usda", output=tmp_path / "two.t4d")
    assert t4d.read(tmp_path / "two.t4d")["other"].time_span == (0.5, 1.4)  # of the frames that show it
    verbs.flipbook(tmp_path / "two.t4d", times="0:2:21", fps=10, output=tmp_path / "out.usda")
    played = valid(tmp_path / "out.usda")
    seen = {mesh.GetPrim().GetName(): mesh for mesh in meshes(played)}
    for code in range(21):
        assert seen["cube"].ComputeVisibility(code) == "inherited"
        there = "inherited" if 5 <= code <= 14 else "invisible"
        assert seen["other"].ComputeVisibility(code) == there


@pytest.mark.parametrize("extension", ["usda", "usdc", "usd"])
def test_what_pixar_writes_is_swept_within_the_tolerance(extension, tmp_path):
    place = tmp_path / f"scene.{extension}"
    stage, mesh = written_stage(place)
    tolerance = 1e-4
    swept = t4d.sweep(place, max_deviation=tolerance)
    assert swept.names == ["cube"]
    assert (swept.length_unit, swept.time_unit, swept.up) == ("m", "s", "z")
    assert swept.check()["valid"]
    for code in np.linspace(0, 20, 23):
        to_world = np.array(mesh.ComputeLocalToWorldTransform(code))
        true = np.array(mesh.GetPointsAttr().Get(code)) @ to_world[:3, :3] + to_world[3, :3]
        found = swept.slice(min(code / 10, 2), light=True).vertices
        assert found.shape == true.shape
        assert np.linalg.norm(found - true / 100, axis=1).max() < 1.1 * tolerance


def test_references_are_followed(tmp_path):
    written_stage(tmp_path / "scene.usda")
    stage = Usd.Stage.CreateNew(str(tmp_path / "uses.usda"))
    stage.SetTimeCodesPerSecond(10)
    stage.OverridePrim("/arm").GetReferences().AddReference("./scene.usda", "/arm")
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    stage.Save()
    stage.Flatten().Export(str(tmp_path / "flat.usda"))
    uses, flat = (t4d.sweep(tmp_path / name) for name in ("uses.usda", "flat.usda"))
    assert uses.names == ["cube"]
    assert np.array_equal(uses.slice(0.77).vertices, flat.slice(0.77).vertices)


def test_binary_files_need_pixars_package(tmp_path, monkeypatch, bolt):
    monkeypatch.setitem(__import__("sys").modules, "pxr.Sdf", None)
    with pytest.raises(t4d.Unsupported, match="usd-core.*usdcat"):
        bolt.slice(1).save(tmp_path / "out.usdc")
    assert not (tmp_path / "out.usdc").exists()

"""t4d-blender with usd-core, on stages whose motion has a closed form."""

import json
import math
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip("pxr")
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdSkel, UsdUtils, Vt  # noqa: E402

import t4d  # noqa: E402

CORNERS = np.array([(x, y, z) for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], dtype=float)
FACES = [0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7]


def run(*words):
    words = [sys.executable, "-m", "t4d.blender", *map(str, words)]
    return subprocess.run(words, capture_output=True, text=True, check=False)


def door(file, *words, code=0):
    """The mesh that t4d-blender makes of a file, and its report."""
    done = run(file, "-o", f"{file}.t4d", "--json", *words)
    assert done.returncode == code, done.stderr
    return t4d.read(f"{file}.t4d"), json.loads(done.stdout)


def apart(here, there):
    """The largest distance of a point from the nearest of the others."""
    distances = np.linalg.norm(np.asarray(here)[:, None] - np.asarray(there)[None], axis=2)
    return max(distances.min(axis=0).max(), distances.min(axis=1).max())


def new(path, last=12, up="Z", metres=1.0, fps=24):
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, metres)
    stage.SetTimeCodesPerSecond(fps)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(last)
    return stage


def mesh_at(stage, path, points=CORNERS, faces=FACES, kind=4):
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.asarray(points, dtype=np.float32)))
    mesh.CreateFaceVertexCountsAttr(len(faces) // kind * [kind])
    mesh.CreateFaceVertexIndicesAttr(faces)
    mesh.CreateSubdivisionSchemeAttr("none")
    return mesh


def along_x(prim, last=12, distance=2):
    move = UsdGeom.Xformable(prim).AddTranslateOp()
    for time, x in ((0, 0), (last, distance)):
        move.Set(Gf.Vec3d(x, 0, 0), time)


def test_a_turning_box_is_rigid_in_every_unit_axis_and_format(tmp_path):
    """With y up, x y z becomes x -z y."""
    for up, metres, extension in (("Z", 1, "usda"), ("Y", 0.01, "usdc"), ("Z", 1, "usdz"), ("Z", 1, "usd")):
        file = tmp_path / f"box-{extension}.{extension}"
        stage = new(tmp_path / "packed.usdc" if extension == "usdz" else file, up=up, metres=metres, fps=30)
        parent = UsdGeom.Xform.Define(stage, "/Parent")
        parent.AddTranslateOp().Set(Gf.Vec3d(3, 0, 0))
        box = mesh_at(stage, "/Parent/Box")
        turn = box.AddRotateZOp() if up == "Z" else box.AddRotateYOp()
        for time, angle in ((0, 0), (12, 90)):
            turn.Set(angle, time)
        stage.Save()
        if extension == "usdz":
            assert UsdUtils.CreateNewUsdzPackage(str(tmp_path / "packed.usdc"), str(file))
        mesh, report = door(file)
        (body,) = report["bodies"]
        assert (body["name"], body["way"], body["keys"], report["fps"]) == ("Box", "poses", 13, 30)
        assert body["distance"] < 1e-6 and mesh.check(deep=True)["valid"]
        assert (mesh.length_unit, mesh.up) == ("m", "z") and np.allclose(mesh.time_span, (0, 0.4))
        for frame in range(13):
            c, s = math.cos(frame * math.pi / 24), math.sin(frame * math.pi / 24)
            there = CORNERS @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + [3, 0, 0]
            assert apart(mesh.slice(frame / 30, light=True).vertices / metres, there) < 1e-5, (extension, frame)


def test_points_move_along_straight_lines_between_samples(tmp_path):
    stage = new(tmp_path / "grown.usda")
    points = mesh_at(stage, "/Box").GetPointsAttr()
    for time, size in ((0, 1), (12, 3)):
        points.Set(Vt.Vec3fArray.FromNumpy((size * CORNERS).astype(np.float32)), time)
    stage.Save()
    mesh, report = door(tmp_path / "grown.usda")
    assert report["bodies"][0]["way"] == "keys" and report["bodies"][0]["distance"] < 1e-6
    for time in np.linspace(0, 0.5, 23):
        assert abs(mesh.slice(time).volume / (2 + 8 * time) ** 3 - 1) < 1e-6, time


def skinned(stage):
    """A bar of three rings under a skeleton of two joints, of which the second turns by 60 degrees about x, and a blend
    shape that lifts the last ring."""
    UsdSkel.Root.Define(stage, "/Root")
    skeleton = UsdSkel.Skeleton.Define(stage, "/Root/Skeleton")
    animation = UsdSkel.Animation.Define(stage, "/Root/Animation")
    joints = ["a", "a/b"]
    for one in (skeleton, animation):
        one.CreateJointsAttr(joints)
    up = [Gf.Matrix4d(1), Gf.Matrix4d().SetTranslate(Gf.Vec3d(0, 0, 1))]
    skeleton.CreateBindTransformsAttr(up)
    skeleton.CreateRestTransformsAttr(up)
    animation.CreateTranslationsAttr([Gf.Vec3f(0, 0, 0), Gf.Vec3f(0, 0, 1)])
    animation.CreateScalesAttr([Gf.Vec3h(1, 1, 1)] * 2)
    half = math.radians(30)
    turned = Gf.Quatf(math.cos(half), math.sin(half), 0, 0)
    animation.CreateRotationsAttr().Set([Gf.Quatf(1, 0, 0, 0)] * 2, 0)
    animation.GetRotationsAttr().Set([Gf.Quatf(1, 0, 0, 0), turned], 12)
    points = np.array([(x, y, z) for z in (0, 1, 2) for x, y in ((-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2))])
    around = [[i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4] for i in range(4)]
    faces = [3, 2, 1, 0, *np.ravel(around), *(np.ravel(around) + 4), 8, 9, 10, 11]
    bar = mesh_at(stage, "/Root/Bar", points, [int(corner) for corner in faces])
    binding = UsdSkel.BindingAPI.Apply(bar.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    binding.CreateJointIndicesPrimvar(False, 2).Set(12 * [0, 1])
    binding.CreateJointWeightsPrimvar(False, 2).Set(4 * [1, 0] + 4 * [0.5, 0.5] + 4 * [0, 1])
    shape = UsdSkel.BlendShape.Define(stage, "/Root/Bar/higher")
    shape.CreateOffsetsAttr([Gf.Vec3f(0, 0, 1)] * 4)
    shape.CreatePointIndicesAttr([8, 9, 10, 11])
    binding.CreateBlendShapesAttr(["higher"])
    binding.CreateBlendShapeTargetsRel().SetTargets([shape.GetPath()])
    animation.CreateBlendShapesAttr(["higher"])
    for time in (0, 12):
        animation.CreateBlendShapeWeightsAttr().Set([time / 12], time)
    return points


def test_skins_and_blend_shapes_deform(tmp_path):
    stage = new(tmp_path / "bar.usda")
    points = skinned(stage)
    along_x(stage.GetPrimAtPath("/Root"))
    stage.Save()
    mesh, report = door(tmp_path / "bar.usda")
    assert [(body["name"], body["way"], body["keys"]) for body in report["bodies"]] == [("Bar", "keys", 13)]
    for frame in range(13):
        angle = math.radians(60 * frame / 12)
        turn = np.array([[1, 0, 0], [0, math.cos(angle), -math.sin(angle)], [0, math.sin(angle), math.cos(angle)]])
        shaped = points + np.outer(points[:, 2] == 2, [0, 0, frame / 12])
        turned = (shaped - [0, 0, 1]) @ turn.T + [0, 0, 1]
        there = np.concatenate([shaped[:4], (shaped[4:8] + turned[4:8]) / 2, turned[8:]]) + [2 * frame / 12, 0, 0]
        assert apart(mesh.slice(frame / 24, light=True).vertices, there) < 1e-5, frame


def test_instances_of_both_kinds_are_bodies(tmp_path):
    stage = new(tmp_path / "instances.usda")
    stage.CreateClassPrim("/Part")
    along_x(mesh_at(stage, "/Part/Box"))
    for number in (1, 2):
        copy = UsdGeom.Xform.Define(stage, f"/Copy{number}")
        copy.AddTranslateOp().Set(Gf.Vec3d(0, 5 * number, 0))
        copy.GetPrim().GetReferences().AddInternalReference("/Part")
        copy.GetPrim().SetInstanceable(True)
    many = UsdGeom.PointInstancer.Define(stage, "/Many")
    mesh_at(stage, "/Many/Small", CORNERS / 4)
    many.CreatePrototypesRel().SetTargets(["/Many/Small"])
    many.CreateProtoIndicesAttr([0, 0, 0])
    many.CreateInvisibleIdsAttr([1])
    for time, z in ((0, 0), (12, 1)):
        many.CreatePositionsAttr().Set([Gf.Vec3f(-5, 5 * y, z) for y in range(3)], time)
    stage.Save()
    mesh, report = door(tmp_path / "instances.usda")
    assert mesh.names == ["Box", "Box 2", "Many Small", "Many Small 2"] and not report["losses"]
    for body, place, size in (("Box", (1, 5, 0), 1), ("Box 2", (1, 10, 0), 1),
                              ("Many Small", (-5, 0, 0.5), 0.25), ("Many Small 2", (-5, 10, 0.5), 0.25)):  # fmt: skip
        assert apart(mesh[body].slice(0.25, light=True).vertices, size * CORNERS + place) < 1e-6
    mesh, _ = door(tmp_path / "instances.usda", "--object", "Copy2", "--frame-range", "0:6")
    assert mesh.names == ["Box"] and mesh.time_span == (0, 0.25)


def test_what_hides_and_returns_is_two_bodies_and_the_rest_is_listed(tmp_path):
    stage = new(tmp_path / "ghost.usda")
    ghost = mesh_at(stage, "/Ghost")
    along_x(ghost)
    for time, shown in ((0, "inherited"), (3, "invisible"), (6, "inherited")):
        ghost.CreateVisibilityAttr().Set(shown, time)
    mesh_at(stage, "/Guide").CreatePurposeAttr("guide")
    mesh_at(stage, "/Broken", faces=[0, 1, 2, 99])
    UsdGeom.Sphere.Define(stage, "/Ball")
    stage.DefinePrim("/Far").GetReferences().AddReference("none.usda")
    stage.Save()
    mesh, report = door(tmp_path / "ghost.usda", code=3)
    assert mesh.names == ["Ghost", "Ghost 2"]
    assert np.allclose(mesh["Ghost"].time_span, (0, 2 / 24)) and np.allclose(mesh["Ghost 2"].time_span, (6 / 24, 0.5))
    said = "\n".join(report["losses"])
    for expected in ("hidden objects or such without faces: 'Guide'", "objects of the type Sphere: 'Ball'",
                     "the faces of 'Broken' are invalid", "none.usda"):  # fmt: skip
        assert expected in said, said


def test_attributes_are_those_of_the_stage(tmp_path):
    stage = new(tmp_path / "painted.usda", last=1)
    box = mesh_at(stage, "/Box")
    along_x(box, 1)
    materials = [UsdShade.Material.Define(stage, f"/Looks/{name}") for name in ("Red", "Green")]
    UsdShade.MaterialBindingAPI.Apply(box.GetPrim()).Bind(materials[0])
    subset = UsdShade.MaterialBindingAPI(box.GetPrim()).CreateMaterialBindSubset("green", [3])
    UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(materials[1])
    places = [(corner / 24, 1) for corner in range(24)]
    kind = Sdf.ValueTypeNames.TexCoord2fArray
    primvar = UsdGeom.PrimvarsAPI(box).CreatePrimvar("st", kind, "faceVarying")
    primvar.Set([Gf.Vec2f(*one) for one in places])
    box.CreateDisplayColorPrimvar("vertex").Set([Gf.Vec3f(number / 8, 0, 1) for number in range(8)])
    stage.Save()
    mesh, _ = door(tmp_path / "painted.usda")
    solid = mesh.slice(0, light=True)
    assert sorted(solid.triangle_attributes["material"].tolist()) == 10 * [1] + 2 * [2]
    assert json.loads(mesh._metadata["details"])["materials"] == ["", "Red", "Green"]
    assert apart(solid.triangle_attributes["uv:corners"].reshape(-1, 2), places) < 1e-7
    colors = solid.vertex_attributes["color"]  # of which all corners at a vertex have one
    assert np.allclose(colors[:, 0], np.arange(8) / 8) and (colors[:, 2:] == 1).all()


def test_layers_make_one_stage(tmp_path):
    part = new(tmp_path / "part.usda")
    along_x(mesh_at(part, "/Box"))
    part.SetDefaultPrim(part.GetPrimAtPath("/Box"))
    part.Save()
    stage = new(tmp_path / "late.usda", last=24)
    late = stage.DefinePrim("/Late")
    late.GetReferences().AddReference(Sdf.Reference("part.usda", layerOffset=Sdf.LayerOffset(12)))
    stage.Save()
    mesh, _ = door(tmp_path / "late.usda")
    for frame, x in ((6, 0), (12, 0), (18, 1), (24, 2)):
        assert apart(mesh.slice(frame / 24, light=True).vertices, CORNERS + [x, 0, 0]) < 1e-6


def test_left_handed_faces_and_subdivision_surfaces_are_read(tmp_path):
    stage = new(tmp_path / "left.usda")
    box = mesh_at(stage, "/Box", CORNERS * [-1, 1, 1])
    box.CreateOrientationAttr("leftHanded")
    box.CreateSubdivisionSchemeAttr("catmullClark")
    along_x(box)
    stage.Save()
    done = run(tmp_path / "left.usda", "-o", tmp_path / "left.t4d")
    assert done.returncode == 0 and "subdivision surfaces are read as their cages: 'Box'" in done.stderr
    assert "inside out" not in done.stderr and abs(t4d.read(tmp_path / "left.t4d").slice(0.1).volume - 8) < 1e-6


def test_what_cannot_be_done_is_said_and_nothing_is_left(tmp_path):
    still = new(tmp_path / "still.usda")
    mesh_at(still, "/Still")
    still.Save()
    timeless = new(tmp_path / "timeless.usda", fps=0)
    along_x(mesh_at(timeless, "/Box"))
    timeless.Save()
    (tmp_path / "not.usda").write_text("nothing")
    for words, code, said in (
        (["not.usda"], 4, "not.usda: usd-core"),
        (["still.usda"], 4, "still.usda: nothing in it moves"),
        (["still.usda", "--object", "Moved"], 4, "there is no object 'Moved'; there are 'Still'"),
        (["timeless.usda"], 4, "its timeCodesPerSecond is 0"),
        (["still.usda", "--take", "Walk"], 2, "--take is for an .fbx"),
    ):
        done = run(tmp_path / words[0], *words[1:], "-o", tmp_path / "kept.t4d")
        assert done.returncode == code and said in done.stderr, (words, done.returncode, done.stderr)
        assert done.stderr.startswith("t4d: ") and "Traceback" not in done.stderr and not done.stdout
    assert not (tmp_path / "kept.t4d").exists()
    mesh, report = door(tmp_path / "timeless.usda", "--fps", 12)
    assert report["fps"] == 12 and np.allclose(mesh.time_span, (0, 1))


def test_a_stage_at_rest_is_one_triangle_mesh_in_metres_with_its_attributes(tmp_path):
    """With y up, x y z becomes x -z y. Solids without a colour are white."""
    for extension in ("usda", "usdc", "usdz"):
        file = tmp_path / f"still.{extension}"
        stage = new(tmp_path / "packed.usdc" if extension == "usdz" else file, up="Y", metres=0.1)
        red = mesh_at(stage, "/Red")
        red.CreateDisplayColorAttr([(1, 0, 0)])
        UsdGeom.Xformable(mesh_at(stage, "/Plain")).AddTranslateOp().Set(Gf.Vec3d(0, 5, 0))
        stage.Save()
        if extension == "usdz":
            UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(tmp_path / "packed.usdc")), str(file))
        with pytest.warns(UserWarning, match="1 of 2 objects have no 'color:corners'"):
            mesh = t4d.read_triangles(file)
        assert apart(mesh.vertices, np.concatenate([CORNERS, CORNERS + [0, 0, 5]]) / 10) < 1e-7
        colors = mesh.triangle_attributes["color:corners"].reshape(-1, 12)
        assert sorted(map(tuple, colors)) == 12 * [3 * (1, 0, 0, 1)] + 12 * [12 * (1,)]
    done = run(tmp_path / "still.usda", "-o", tmp_path / "still.usda")
    assert done.returncode == 2 and "is the input, which is never replaced" in done.stderr
    done = run(tmp_path / "still.usdc", "-o", tmp_path / "still.vtp", "--frame-range", "7:7")
    assert done.returncode == 0 and "note: 1 of 2 objects" in done.stderr
    with pytest.warns(t4d.Loss, match="data that are not read: color:corners"):
        assert np.array_equal(t4d.read_triangles(tmp_path / "still.vtp").vertices, mesh.vertices)

"""t4d-blender with ufbx, on files whose motion has a closed form."""

import json
import math
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip("ufbx")
import fbx_text  # noqa: E402

import t4d  # noqa: E402

CORNERS = np.array(fbx_text.CUBE[0], dtype=float).reshape(-1, 3)


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
    distances = np.linalg.norm(here[:, None] - np.asarray(there)[None], axis=2)
    return max(distances.min(axis=0).max(), distances.min(axis=1).max())


def moved(tmp_path, keys, last=1, layers=(), **how):
    """A cube that a curve moves along x."""
    scene = fbx_text.Scene()
    cube = scene.cube()
    stack, base = scene.take("Take", 0, last)
    scene.curve(base, cube, "Lcl Translation", "d|X", keys, **how)
    for given, own in layers:
        scene.curve(scene.layer(stack, "over", **given), cube, "Lcl Translation", "d|X", own)
    return scene.save(tmp_path / "moved.fbx")


def is_along(mesh, place, last=1):
    """The theorem of all that is moved: at every frame, the cube is where a function of seconds says."""
    assert np.allclose(mesh.time_span, (0, last)) and mesh.check(deep=True)["valid"]
    for frame in range(round(24 * last) + 1):
        there = CORNERS + [place(frame / 24), 0, 0]
        assert apart(mesh.slice(frame / 24, light=True).vertices, there) < 1e-5, frame


def hermite(t, values, slopes):
    """The cubic from 0 to 1 with these values and slopes at its ends."""
    (a, b), (c, d) = values, slopes
    return a * (1 + 2 * t) * (1 - t) ** 2 + c * t * (1 - t) ** 2 + b * t * t * (3 - 2 * t) + d * t * t * (t - 1)


def test_cubic_keys_follow_their_tangents(tmp_path):
    file = moved(tmp_path, {0: 0, 1: 2}, kind=fbx_text.CUBIC + 0x400, slopes=(3, -5))
    mesh, report = door(file)
    (body,) = report["bodies"]
    assert (body["name"], body["way"], body["keys"], report["fps"]) == ("Cube", "poses", 25, 24)
    is_along(mesh, lambda t: hermite(t, (0, 2), (3, -5)))
    assert 1e-4 < body["distance"] < 1e-2
    mesh, report = door(file, "--step", 4, "--tolerance", 1e-4)
    assert report["bodies"][0]["distance"] <= 1e-4 and report["bodies"][0]["keys"] > 25
    for t in np.linspace(0, 1, 91):
        assert abs(mesh.slice(t).vertices[:, 0].mean() - hermite(t, (0, 2), (3, -5))) < 2e-4


def test_keys_of_steps_stay_until_the_next(tmp_path):
    mesh, _ = door(moved(tmp_path, {0: 0, 0.5: 3, 1: 5}, kind=fbx_text.CONSTANT))
    is_along(mesh, lambda t: 0 if t < 0.5 else 3 if t < 1 else 5)


def test_curves_go_on_after_their_last_key_as_they_say(tmp_path):
    keys = {0: 0, 0.5: 1}
    for way, place in (("C", lambda t: min(2 * t, 1)), ("R", lambda t: 2 * math.fmod(t, 0.5)),
                       ("M", lambda t: 1 - abs(2 * math.fmod(t, 1) - 1)), ("A", lambda t: 2 * t)):  # fmt: skip
        mesh, _ = door(moved(tmp_path, keys, last=2, after=way))
        for frame in (1, 6, 11, 13, 18, 23, 25, 30, 41):
            vertices = mesh.slice(frame / 24, light=True).vertices
            assert apart(vertices, CORNERS + [place(frame / 24), 0, 0]) < 1e-5, (way, frame)


def test_layers_add_or_take_the_place(tmp_path):
    mesh, _ = door(moved(tmp_path, {0: 0, 1: 2}, layers=[({"BlendMode": 0, "Weight": 50.0}, {0: 0, 1: 4})]))
    is_along(mesh, lambda t: 2 * t + 0.5 * 4 * t)
    mesh, _ = door(moved(tmp_path, {0: 0, 1: 2}, layers=[({"BlendMode": 1, "Weight": 100.0}, {0: 1, 1: 4})]))
    is_along(mesh, lambda t: 1 + 3 * t)


def test_a_turning_box_is_rigid_in_every_unit_and_axis(tmp_path):
    """With y up, x y z becomes x -z y. Half frames are on the screw motions between the keys."""
    for up, metres, axis in (("z", 1, "d|Z"), ("y", 0.01, "d|Y")):
        scene = fbx_text.Scene(fps=30, up=up, metres=metres)
        parent = scene.model("Parent", **{"Lcl Translation": (3.0, 0.0, 0.0), "Lcl Scaling": (2.0, 2.0, 2.0)})
        cube = scene.cube(parent=parent)
        _, base = scene.take("Take", 1, 2)
        scene.curve(base, cube, "Lcl Rotation", axis, {1: 0, 2: 90})
        mesh, report = door(scene.save(tmp_path / "turned.fbx"))
        (body,) = report["bodies"]
        assert (body["way"], body["keys"], report["fps"]) == ("poses", 31, 30) and body["distance"] < 1e-6
        assert (mesh.length_unit, mesh.up) == ("m", "z") and np.allclose(mesh.time_span, (0, 1))
        for time in np.linspace(0, 1, 31):
            angle = time * math.pi / 2
            turn = np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])
            assert apart(mesh.slice(time, light=True).vertices / metres, 2 * CORNERS @ turn.T + [3, 0, 0]) < 1e-5


def bar(scene):
    """Rings of four at z = 0, 1 and 2: the geometry, and all points."""
    points = np.array([(x, y, z) for z in (0, 1, 2) for x, y in ((-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2))])
    around = [[i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4] for i in range(4)]
    polygons = [[3, 2, 1, 0], *around, *([corner + 4 for corner in one] for one in around), [8, 9, 10, 11]]
    return scene.mesh("Bar", points.ravel(), polygons), points


def test_a_skin_follows_its_bones(tmp_path):
    """The upper ring turns with its bone, the middle one is half way, the lower one stays."""
    scene = fbx_text.Scene()
    (_, geometry), points = bar(scene)
    root = scene.model("Root", "LimbNode")
    bone = scene.model("Bone", "LimbNode", root, **{"Lcl Translation": (0.0, 0.0, 1.0)})
    scene.skin(geometry, {
        root: ({**dict.fromkeys(range(4), 1), **dict.fromkeys(range(4, 8), 0.5)}, (0, 0, 0)),
        bone: ({**dict.fromkeys(range(4, 8), 0.5), **dict.fromkeys(range(8, 12), 1)}, (0, 0, 1)),
    })  # fmt: skip
    _, base = scene.take("Take", 0, 0.5)
    scene.curve(base, bone, "Lcl Rotation", "d|X", {0: 0, 0.5: 60})
    mesh, report = door(scene.save(tmp_path / "bar.fbx"))
    assert [(body["way"], body["keys"]) for body in report["bodies"]] == [("keys", 13)]
    for frame in range(13):
        angle = math.radians(60 * frame / 12)
        turn = np.array([[1, 0, 0], [0, math.cos(angle), -math.sin(angle)], [0, math.sin(angle), math.cos(angle)]])
        turned = (points - [0, 0, 1]) @ turn.T + [0, 0, 1]
        there = np.concatenate([points[:4], (points[4:8] + turned[4:8]) / 2, turned[8:]])
        assert apart(mesh.slice(frame / 24, light=True).vertices, there) < 1e-6, frame


def test_a_blend_shape_moves_by_its_weight(tmp_path):
    scene = fbx_text.Scene()
    (_, geometry), points = bar(scene)
    channel = scene.shape(geometry, {vertex: (0, 0, 1) for vertex in range(8, 12)})
    _, base = scene.take("Take", 0, 0.5)
    scene.curve(base, channel, "DeformPercent", "d|DeformPercent", {0: 0, 0.5: 100})
    mesh, _ = door(scene.save(tmp_path / "bar.fbx"))
    for time in np.linspace(0, 0.5, 31):
        assert abs(mesh.slice(time).volume - 0.4**2 * (2 + 2 * time)) < 1e-6, time


def test_what_hides_and_returns_is_two_bodies_and_the_rest_is_listed(tmp_path):
    scene = fbx_text.Scene()
    ghost = scene.cube("Ghost")
    parent = scene.model("Away", Visibility=0.0)
    scene.cube("Hidden", parent=parent)
    scene.model("Eye", "Camera")
    scene.add("Constraint", "Constraint::Held", "Position", 'Type: "Position"\nMultiLayer: 0\n'
              + fbx_text.properties({"Active": 1, "Weight": 100.0}))  # fmt: skip
    _, base = scene.take("Take", 0, 1)
    scene.curve(base, ghost, "Visibility", "d|Visibility", {0: 1, 0.25: 0, 0.5: 1}, kind=fbx_text.CONSTANT)
    scene.curve(base, ghost, "Lcl Translation", "d|X", {0: 0, 1: 24})
    mesh, report = door(scene.save(tmp_path / "ghost.fbx"), code=3)
    assert mesh.names == ["Ghost", "Ghost 2"]
    assert np.allclose(mesh["Ghost"].time_span, (0, 5 / 24)) and np.allclose(mesh["Ghost 2"].time_span, (0.5, 1))
    assert report["losses"] == ["constraints: 'Held'", "hidden objects: 'Hidden'"]


def test_attributes_are_those_of_the_file(tmp_path):
    scene = fbx_text.Scene()
    places = [corner / 24 for corner in range(24)]
    layers = ('LayerElementUV: 0 {\nName: "map"\nMappingInformationType: "ByPolygonVertex"\n'
              'ReferenceInformationType: "Direct"\n'
              + fbx_text.numbers("UV", (value for one in places for value in (one, 1)))
              + '}\nLayerElementColor: 0 {\nName: "paint"\nMappingInformationType: "ByPolygonVertex"\n'
              'ReferenceInformationType: "Direct"\n'
              + fbx_text.numbers("Colors", (value for one in places for value in (one, 0, 1, 1)))
              + '}\nLayerElementMaterial: 0 {\nMappingInformationType: "ByPolygon"\n'
              'ReferenceInformationType: "IndexToDirect"\n' + fbx_text.numbers("Materials", [0, 0, 1, 0, 0, 0]) + "}\n"
              "Layer: 0 {\n" + "".join(f'LayerElement: {{\nType: "LayerElement{kind}"\nTypedIndex: 0\n}}\n'
                                       for kind in ("UV", "Color", "Material")) + "}\n")  # fmt: skip
    cube, _ = scene.mesh("Cube", *fbx_text.CUBE, layers=layers)
    for name in ("Red", "Green"):
        scene.connect(scene.add("Material", f"Material::{name}"), cube)
    _, base = scene.take("Take", 0, 1 / 24)
    scene.curve(base, cube, "Lcl Translation", "d|X", {0: 0, 1: 1})
    file = scene.save(tmp_path / "painted.fbx")
    for words in ([], ["--caps", "cone"], ["--mend"], ["--bodies", "component"]):
        mesh, _ = door(file, *words)
        solid = mesh.slice(0, light=True)
        assert sorted(solid.triangle_attributes["material"].tolist()) == 10 * [1] + 2 * [2]
        assert json.loads(mesh._metadata["details"])["materials"] == ["", "Red", "Green"]
        corners = solid.triangle_attributes["uv:corners"].reshape(-1, 2)
        assert apart(corners, [(one, 1) for one in places]) < 1e-7
        colors = solid.triangle_attributes["color:corners"].reshape(-1, 4)
        assert np.array_equal(colors[:, 0], np.rint(corners[:, 0] * 255)) and (colors[:, 2:] == 255).all()


def test_one_take_is_read_and_the_others_are_named(tmp_path):
    scene = fbx_text.Scene()
    cube = scene.cube()
    for name, last in (("Walk", 0.5), ("Run", 1)):
        scene.curve(scene.take(name, 0, last)[1], cube, "Lcl Translation", "d|X", {0: 0, last: 1})
    file = scene.save(tmp_path / "takes.fbx")
    done = run(file, "-o", tmp_path / "a.t4d")
    assert done.returncode == 0 and "note: the take is 'Walk'; there are also 'Run'" in done.stderr
    assert t4d.read(tmp_path / "a.t4d").time_span == (0, 0.5)
    mesh, _ = door(file, "--take", "Run")
    assert mesh.time_span == (0, 1)
    done = run(file, "-o", tmp_path / "a.t4d", "--take", "Jump")
    assert done.returncode == 4 and "there is no take 'Jump'; there are 'Walk', 'Run'" in done.stderr


def test_what_cannot_be_done_is_said_and_nothing_is_left(tmp_path):
    moving = moved(tmp_path, {0: 0, 1: 2})
    still = fbx_text.Scene()
    still.cube()
    still.save(tmp_path / "still.fbx")
    (tmp_path / "not.fbx").write_text("nothing")
    (tmp_path / "kept.t4d").write_text("kept")
    for words, code, said in (
        ([tmp_path / "none.fbx"], 4, "none.fbx: cannot be opened"),
        ([tmp_path / "not.fbx"], 4, "not.fbx: ufbx 0."),
        ([tmp_path / "still.fbx"], 4, "still.fbx: nothing in it moves; -o with a .ply"),
        ([moving, "--object", "Moved"], 4, "there is no object 'Moved'; there are 'Cube'"),
        ([moving, "--frame-range", "3:3"], 4, "a motion has at least 2"),
        ([moving, "--part", "1/2"], 2, "--part is for what t4d sweep reads itself"),
        ([moving, "--frame-range", "0:1000000"], 4, "frames 0 to 1e+06 are 1,000,000, expected at most 100,000"),
    ):
        done = run(*words, "-o", tmp_path / "kept.t4d")
        assert done.returncode == code and said in done.stderr, (words, done.returncode, done.stderr)
        assert done.stderr.startswith("t4d: ") and "Traceback" not in done.stderr and not done.stdout
    assert (tmp_path / "kept.t4d").read_text() == "kept"
    assert {one.suffix for one in tmp_path.iterdir()} == {".fbx", ".t4d"}


def test_sweep_of_the_module_is_the_same(tmp_path):
    file = moved(tmp_path, {0: 0, 1: 2})
    mesh, _ = door(file)
    swept = [sys.executable, "-m", "t4d", "sweep", "-q", str(file), "-o", str(tmp_path / "swept.t4d")]
    assert subprocess.run(swept, capture_output=True, check=True).stdout == b""
    for time in (0, 0.3, 1):
        assert np.array_equal(t4d.read(tmp_path / "swept.t4d").slice(time).vertices, mesh.slice(time).vertices)


def test_a_scene_at_rest_is_one_triangle_mesh_of_its_first_frame(tmp_path):
    """With y up in centimetres, x y z becomes x -z y in metres."""
    scene = fbx_text.Scene(up="y", metres=0.01)
    scene.cube("Low")
    scene.cube("High", **{"Lcl Translation": (0.0, 5.0, 0.0)})
    scene.cube("Hidden", Visibility=0.0)
    file = scene.save(tmp_path / "still.fbx")
    both = np.concatenate([CORNERS, CORNERS + [0, 0, 5]]) / 100
    for extension in ("ply", "vtp", "obj", "stl", "off", "glb", "gltf"):
        output = tmp_path / f"still.{extension}"
        done = run(file, "-o", output, "--json")
        report = json.loads(done.stdout)
        assert done.returncode == 3 and report["losses"] == ["hidden objects: 'Hidden'"], done.stderr
        assert [body["name"] for body in report["bodies"]] == ["Low", "High"] and report["triangles"] == 24
        mesh = t4d.read_triangles(output)
        assert apart(mesh.vertices, both) < 1e-8 and abs(mesh.volume - 16e-6) < 1e-11, extension
    done = run(file, "-o", output, "--object", "High", "-q")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert apart(t4d.read_triangles(output).vertices, both[8:]) < 1e-8
    with pytest.warns(t4d.Loss, match="hidden objects: 'Hidden'"):
        assert apart(t4d.read_triangles(file).vertices, both) < 1e-15


def test_a_frame_of_a_motion_is_a_triangle_mesh(tmp_path):
    file = moved(tmp_path, {0: 1, 1: 3})
    for words, place in (([], 1), (["--frame-range", "12:12"], 2), (["--frame-range", "24:30"], 3)):
        assert run(file, "-o", tmp_path / "one.ply", *words).returncode == 0
        assert apart(t4d.read_triangles(tmp_path / "one.ply").vertices, CORNERS + [place, 0, 0]) < 1e-5
    for words, said in ((["one.ply", "--mend"], "--mend is an option of t4d sweep"), (["one.xyz"], "expected a name")):
        done = run(file, "-o", *words)
        assert done.returncode == 2 and said in done.stderr, done.stderr


def test_verbs_take_the_solids_of_a_scene(tmp_path):
    scene = fbx_text.Scene()
    cube, _ = scene.mesh("Cube", *fbx_text.CUBE, layers=(
        "LayerElementMaterial: 0 {\nMappingInformationType: \"AllSame\"\n"
        'ReferenceInformationType: "IndexToDirect"\n' + fbx_text.numbers("Materials", [0]) + "}\n"
        'Layer: 0 {\nLayerElement: {\nType: "LayerElementMaterial"\nTypedIndex: 0\n}\n}\n'))  # fmt: skip
    scene.connect(scene.add("Material", "Material::Red"), cube)
    file = scene.save(tmp_path / "part.fbx")
    (tmp_path / "up.json").write_text('{"segments": [{"duration": 1, "translation": [0, 0, 3]}]}')
    words = [sys.executable, "-m", "t4d", "sweep", "part.fbx", "--motion=up.json", "-o", "up.t4d"]
    done = subprocess.run(words, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    mesh = t4d.read(tmp_path / "up.t4d")
    assert mesh.names == ["part"] and abs(mesh.slice(0.5).vertices[:, 2].max() - 2.5) < 1e-12
    assert (mesh.slice(0.5, light=True).triangle_attributes["material"] == 1).all()
    opened = fbx_text.Scene()
    opened.mesh("Open", fbx_text.CUBE[0], fbx_text.CUBE[1][1:])
    opened.save(tmp_path / "open.fbx")
    words[4] = "open.fbx"
    done = subprocess.run(words, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 4 and done.stderr.startswith("t4d: open.fbx: the mesh is open")
    assert "try: python3 -m t4d mend open.fbx -o open-mended.ply" in done.stderr and "/tmp" not in done.stderr
    assert t4d.mend(t4d.read_triangles(tmp_path / "open.fbx")).closed
    assert t4d.verbs.mend(tmp_path / "open.fbx", output=t4d.TriangleMesh).mesh.closed
    assert t4d.sweep(moved(tmp_path, {0: 0, 1: 2})).names == ["Cube"]
    with pytest.raises(t4d.VerbError, match="none.fbx: cannot be opened") as raised:
        t4d.verbs.mend("none.fbx", output="none.ply")
    assert raised.value.exit_code == 4


def shifted(points, x, y=0, z=0):
    return [value + (x, y, z)[at % 3] for at, value in enumerate(points)]


def test_advice_makes_solids_of_what_was_lost(tmp_path):
    """An open box, a sheet and two boxes in one object that cross each other, all moved by 2 along x, and a box whose
    parts cross each other and grow by a blend shape."""
    points, faces = fbx_text.CUBE
    both = [*faces, *([corner + 8 for corner in one] for one in faces)]
    scene = fbx_text.Scene()
    good = scene.cube("Good")
    open_, _ = scene.mesh("Open", shifted(points, 0, 10), faces[1:])
    sheet, _ = scene.mesh("Sheet", shifted(points, 0, 20), faces[:1])
    crossed, _ = scene.mesh("Crossed", points + shifted(points, 1, 1, 1), both)
    _, geometry = scene.mesh("Grown", shifted(points, 0, 30) + shifted(points, 1, 31, 1), both)
    channel = scene.shape(geometry, {vertex: (0, 0, 1) for vertex in range(4, 8)})
    _, base = scene.take("Take", 0, 0.25)
    for model in (good, open_, sheet, crossed):
        scene.curve(base, model, "Lcl Translation", "d|X", {0: 0, 0.25: 2})
    scene.curve(base, channel, "DeformPercent", "d|DeformPercent", {0: 0, 0.25: 100})
    file = scene.save(tmp_path / "lost.fbx")
    done = run(file, "-o", tmp_path / "lost.t4d")
    assert done.returncode == 3 and t4d.read(tmp_path / "lost.t4d").names == ["Good"]
    advice = done.stderr.splitlines()[-1]
    assert advice.startswith("t4d: try: --mend --thicken 0.01 --bodies component") and "/tmp" not in done.stderr
    mesh, report = door(file, *advice.split()[2:])
    assert mesh.names == ["Good", "Open", "Sheet", "Crossed 1", "Crossed 2", "Grown 1", "Grown 2"]
    assert not report["losses"] and all(body.check(deep=True)["valid"] for body in mesh)
    assert [body["way"] for body in report["bodies"]] == 3 * ["poses"] + 4 * ["keys"]
    for name, volume in (("Good", 8), ("Open", 8), ("Sheet", 0.04), ("Crossed 1", 8), ("Grown 1", 10), ("Grown 2", 8)):
        assert abs(mesh[name].slice(0.125).volume - volume) < 1e-6, name
    alone = door(file, "--object", "Crossed", "--mend")[0]  # the outer surface of both
    assert alone.names == ["Crossed"] and abs(alone.slice(0.1).volume - 15) < 1e-6
    done = run(file, "-o", tmp_path / "lost.t4d", "--object", "Sheet", "--mend")
    assert done.returncode == 4 and done.stderr.splitlines()[-1] == "t4d: try: --thicken 0.01"


def test_what_nothing_helps_is_lost_alone(tmp_path):
    """Two boxes that share the places of a side at first, and part later."""
    points, faces = fbx_text.CUBE
    both = [*faces, *([corner + 8 for corner in one] for one in faces)]
    scene = fbx_text.Scene()
    scene.cube("Good")
    _, geometry = scene.mesh("Parting", points + shifted(points, 2), both)
    channel = scene.shape(geometry, {vertex: (3, 0, 0) for vertex in range(8, 16)})
    _, base = scene.take("Take", 0, 0.25)
    scene.curve(base, channel, "DeformPercent", "d|DeformPercent", {0: 0, 0.25: 100})
    _, report = door(scene.save(tmp_path / "parting.fbx"), code=3)
    (loss,) = report["losses"]
    assert loss.startswith("the body 'Parting': vertices that are at one place at first are")
    assert [body["name"] for body in report["bodies"]] == ["Good"]


def test_one_component_keeps_its_name_and_others_take_none(tmp_path):
    points, faces = fbx_text.CUBE
    both = [*faces, *([corner + 8 for corner in one] for one in faces)]
    scene = fbx_text.Scene()
    _, base = scene.take("Take", 0, 0.25)
    for name, x in (("Box", 0), ("Box 1", 9)):
        model, _ = scene.mesh(name, shifted(points, x) + shifted(points, x + 4), both)
        scene.curve(base, model, "Lcl Translation", "d|X", {0: 0, 0.25: 2})
    scene.curve(base, scene.cube("Box 3"), "Lcl Rotation", "d|X", {0: 0, 0.25: 90})
    mesh, report = door(scene.save(tmp_path / "boxes.fbx"), "--bodies", "component")
    assert mesh.names == ["Box part 1", "Box part 2", "Box 1 1", "Box 1 2", "Box 3"]
    assert report["bodies"][-1]["way"] == "poses"


def test_a_union_is_one_solid_of_all_objects(tmp_path):
    """Two boxes, of which one goes into the other: a voxel or less from the closed form."""
    scene = fbx_text.Scene()
    scene.cube("Still")
    moving = scene.cube("Moving")
    _, base = scene.take("Take", 0, 0.25)
    scene.curve(base, moving, "Lcl Translation", "d|X", {0: 3, 0.25: 1})
    file = scene.save(tmp_path / "union.fbx")
    mesh, report = door(file, "--union", "--voxel-size", 0.125)
    assert mesh.names == ["union"] and mesh.check()["valid"]
    for time in (0.05, 0.2):
        overlap = max(0, 2 - (3 - 2 * time / 0.25))
        assert abs(mesh.slice(time).volume - (16 - 4 * overlap)) < 24 * 0.125, time
    ghost = fbx_text.Scene()
    model = ghost.cube("Ghost")
    ghost.cube("Still")
    _, base = ghost.take("Take", 0, 0.25)
    ghost.curve(base, model, "Visibility", "d|Visibility", {0: 1, 0.125: 0}, kind=fbx_text.CONSTANT)
    done = run(ghost.save(tmp_path / "ghost.fbx"), "--union", "-o", tmp_path / "ghost.t4d")
    assert done.returncode == 4 and "ghost.fbx: the object 'Ghost' is there at frames 0 to 2, not 0 to 6" in done.stderr

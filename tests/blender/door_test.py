"""t4d-blender, and the export of whole scenes: run by tests/blender/check, in Blender's Python.

The judge is the evaluated scene itself, before it was written to a file: positions at keys, volumes by closed forms,
and the distance of a chord from its arc.
"""

import json
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy  # the first: as a module, it brings the second
import bmesh
import numpy as np

BUILD = Path(sys.argv[sys.argv.index("--") + 1]).resolve()
sys.path.insert(0, str(BUILD / "python"))
import t4d  # noqa: E402

# t4d-blender runs the Blender that runs this test.
DOOR = [BUILD / "t4d-blender", "--blender", bpy.app.binary_path]
if not bpy.app.binary_path:
    DOOR = [sys.executable, BUILD / "t4d-blender"]


def fresh(frames=13, fps=30):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.render.fps = 1, frames, fps
    return scene


def show(frame):
    bpy.context.scene.frame_set(math.floor(frame), subframe=frame % 1)


def keyed(block, path, values):
    """Straight from key to key: `values` by frame."""
    for frame, value in values.items():
        setattr(block, path, value)
        block.keyframe_insert(path, frame=frame)
    action = (block.id_data.animation_data or block.animation_data).action
    for curve in curves_of(action):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"


def curves_of(action):
    if bpy.app.version < (5, 0, 0):
        return list(action.fcurves)
    bags = [bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags]
    return [curve for bag in bags for curve in bag.fcurves]


def material(name):
    return bpy.data.materials.new(name)


def box(name, size=2, location=(0, 0, 0)):
    bpy.ops.mesh.primitive_cube_add(size=size, location=location)
    made = bpy.context.object
    made.name = made.data.name = name
    return made


def run(*words):
    return subprocess.run([*map(str, DOOR), *map(str, words)], capture_output=True, text=True, check=False)


def door(file, *words, code=0):
    """The mesh that t4d-blender makes of a file, and its report."""
    output = f"{file}.t4d"
    done = run(file, "-o", output, "--json", *words)
    assert done.returncode == code, (file, done.returncode, done.stderr)
    return t4d.read(output), json.loads(done.stdout)


def saved(name):
    """The scene as a .blend."""
    bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(name))
    return name


def vertices_of(made):
    """Of the evaluated scene."""
    evaluated = made.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array([evaluated.matrix_world @ vertex.co for vertex in evaluated.data.vertices])


def volume_of(made):
    evaluated = made.evaluated_get(bpy.context.evaluated_depsgraph_get())
    work = bmesh.new()
    work.from_mesh(evaluated.data)
    work.transform(made.matrix_world)
    found = work.calc_volume(signed=True)
    work.free()
    return found


def apart(here, there):
    """The largest distance of a point from the nearest of the others."""
    distances = np.linalg.norm(here[:, None] - there[None], axis=2)
    return max(distances.min(axis=0).max(), distances.min(axis=1).max())


def bent_bar(name="Bar"):
    """A bar whose upper half a bone turns by `bone.rotation_euler`."""
    bpy.ops.object.armature_add()
    armature = bpy.context.object
    bone = armature.pose.bones[0]
    bone.rotation_mode = "XYZ"
    made = box(name)
    group = made.vertex_groups.new(name=bone.name)
    group.add(range(len(made.data.vertices)), 1, "REPLACE")
    bend = made.modifiers.new("Armature", "ARMATURE")
    bend.object = armature
    return made, armature, bone


FORMATS = {  # the operator that writes it, and its options
    "blend": None,
    "fbx": ("export_scene", "fbx", {}),
    "glb": ("export_scene", "gltf", {}),
    "dae": ("wm", "collada_export", {}),
    "abc": ("wm", "alembic_export", {}),
    "usda": ("wm", "usd_export", {"export_animation": True}),
    "usdc": ("wm", "usd_export", {"export_animation": True}),
}


def test_a_turning_box_is_the_same_from_every_file():
    scene = fresh()
    made = box("Box")
    made.data.materials.append(material("Red"))
    keyed(made, "rotation_euler", {1: (0, 0, 0), 13: (0, 0, math.pi / 2)})
    keyed(made, "location", {1: (0, 0, 0), 13: (1, 2, 3)})
    places = []
    for frame in range(1, 14):
        show(frame)
        places.append(vertices_of(made))
    tried = []
    for extension, writer in FORMATS.items():
        if writer and writer[1] not in dir(getattr(bpy.ops, writer[0])):
            continue
        file = f"box.{extension}"
        if writer:
            getattr(getattr(bpy.ops, writer[0]), writer[1])(filepath=os.path.abspath(file), **writer[2])
        else:
            saved(file)
        rate = ["--fps", "30"] if extension == "usdc" else []
        mesh, report = door(file, *rate)
        assert report["fps"] == 30 and len(report["bodies"]) == 1, (extension, report)
        (body,) = report["bodies"]
        assert (body["name"], body["way"], body["keys"]) == ("Box", "poses", 13), (extension, body)
        assert np.allclose(mesh.time_span, (0, 12 / 30)), (extension, mesh.time_span)
        assert (mesh.length_unit, mesh.time_unit, mesh.up) == ("m", "s", "z")
        assert mesh.check(deep=True)["valid"]
        for number, there in enumerate(places):
            assert apart(mesh.slice(number / 30).vertices, there) < 1e-5, (extension, number)
        details = json.loads(mesh._metadata["details"])
        assert details.get("materials", ["", "Red"]) == ["", "Red"], (extension, details)
        tried.append(extension)
    assert len(tried) >= 4
    print("   ", *tried)


def test_positions_at_keys_are_those_of_modifiers_armatures_shape_keys_and_drivers():
    scene = fresh(9)
    made, armature, bone = bent_bar()
    made.shape_key_add(name="Basis")
    wide = made.shape_key_add(name="wide")
    for point in wide.data:
        point.co.x *= 2
    keyed(bone, "rotation_euler", {1: (0, 0, 0), 9: (0.7, 0.2, 0)})
    driver = wide.driver_add("value").driver
    driver.type = "SUM"
    variable = driver.variables.new()
    variable.type = "TRANSFORMS"
    variable.targets[0].id, variable.targets[0].bone_target = armature, bone.name
    variable.targets[0].transform_type, variable.targets[0].transform_space = "ROT_X", "LOCAL_SPACE"
    smooth = made.modifiers.new("Smooth", "SUBSURF")
    smooth.levels = 2
    mesh, report = door(saved("character.blend"))
    (body,) = report["bodies"]
    assert (body["name"], body["way"], body["keys"]) == ("Bar", "keys", 9) and report["fps"] == 30
    for frame in range(1, 10):
        show(frame)
        solid = mesh.slice((frame - 1) / 30)
        assert apart(solid.vertices, vertices_of(made)) < 1e-6, frame
        assert abs(solid.volume / volume_of(made) - 1) < 1e-6, frame
    show(9)
    assert volume_of(made) > 1.3 * mesh.slice(0).volume  # the driver is in it


def test_a_growing_box_has_the_volume_of_the_closed_form():
    fresh(5)
    made = box("Box")
    keyed(made, "scale", {1: (1, 1, 1), 5: (3, 3, 3)})
    mesh, report = door(saved("growing.blend"))
    assert report["bodies"][0]["distance"] < 1e-6  # every vertex moves along a line
    for time in np.linspace(0, 4 / 30, 23):
        assert abs(mesh.slice(time).volume / (8 * (1 + 2 * time * 30 / 4) ** 3) - 1) < 1e-6, time


def test_half_frames_are_as_far_as_an_arc_from_its_chord():
    fresh(5)
    made, armature, bone = bent_bar()
    keyed(bone, "rotation_euler", {1: (0, 0, 0), 5: (0, 1.6, 0)})  # about the bone, which is upright
    radius, angle = math.sqrt(2), 0.4
    chord = lambda angle: radius * (1 - math.cos(angle / 2))  # noqa: E731
    file = saved("turning.blend")
    mesh, report = door(file)
    (body,) = report["bodies"]
    assert body["way"] == "keys" and body["keys"] == 5
    assert abs(body["distance"] - chord(angle)) < 1e-6 and body["distance_frame"] % 1 == 0.5
    tolerance = chord(angle) / 10  # a quarter of the angle has a sixteenth of the distance
    mesh, report = door(file, "--tolerance", tolerance)
    (body,) = report["bodies"]
    assert body["keys"] == 4 * 4 + 1 and abs(body["distance"] - chord(angle / 4)) < 1e-6
    for time in np.linspace(0, 4 / 30, 101):
        most = np.linalg.norm(mesh.slice(time, light=True).vertices[:, :2], axis=1)
        assert radius - tolerance <= most.max() <= radius + 1e-6
    turned = box("Turned")  # rigid, so in between it turns, too
    keyed(turned, "rotation_euler", {1: (0, 0, 0), 5: (0, 0, 1.6)})
    _, report = door(saved("turned.blend"), "--object", "Turned")
    assert [body["way"] for body in report["bodies"]] == ["poses"] and report["bodies"][0]["distance"] < 1e-6


def test_faces_that_change_are_woven():
    fresh(5)
    made = box("Block")
    drill = box("Drill", 1)
    keyed(drill, "location", {1: (0, 0, 2), 5: (0, 0, 0.6)})
    drill.hide_set(True)
    cut = made.modifiers.new("Cut", "BOOLEAN")
    cut.object, cut.operation = drill, "DIFFERENCE"
    mesh, report = door(saved("drilled.blend"), "--voxel-size", 0.05, code=3)
    (body,) = report["bodies"]
    assert (body["name"], body["way"], body["distance"]) == ("Block", "voxels", None)
    assert report["losses"] == ["hidden objects: 'Drill'"]
    for frame in range(1, 6):
        show(frame)
        assert abs(mesh.slice((frame - 1) / 30).volume / volume_of(made) - 1) < 0.02, frame
    assert volume_of(made) < 7.2 and mesh.check()["valid"]


def test_instances_and_curves_are_bodies_and_what_is_none_is_listed():
    scene = fresh(3)
    made = box("Part", 1)
    keyed(made, "location", {1: (0, 0, 0), 3: (0, 0, 1)})
    parts = bpy.data.collections.new("Parts")
    parts.objects.link(made)
    for number in (1, 2):
        instance = bpy.data.objects.new(f"Copy {number}", None)
        instance.instance_type, instance.instance_collection = "COLLECTION", parts
        instance.location.x = 3 * number
        scene.collection.objects.link(instance)
    bpy.ops.curve.primitive_bezier_circle_add(location=(0, 5, 0))
    bpy.context.object.name, bpy.context.object.data.bevel_depth = "Ring", 0.2
    bpy.ops.mesh.primitive_plane_add(location=(0, 0, -3))
    bpy.context.object.name = "Floor"
    box("Hidden").hide_set(True)
    bpy.ops.object.camera_add()
    mesh, report = door(saved("parts.blend"), code=3)
    assert sorted(mesh.names) == ["Copy 1 Part", "Copy 2 Part", "Part", "Ring"], mesh.names
    assert np.allclose(mesh["Copy 2 Part"].slice(1 / 30).vertices.mean(axis=0), (6, 0, 0.5))
    text = "\n".join(report["losses"])
    assert "hidden objects: 'Hidden'" in text and "camera: 'Camera'" in text
    assert "the body 'Floor': the mesh is open" in text and "/tmp" not in text, text
    mesh, report = door("parts.blend", "--object", "Copy 1", "--frame-range", "1:2")
    assert mesh.names == ["Copy 1 Part"] and not report["losses"] and mesh.time_span == (0, 1 / 30)


def test_an_object_that_hides_and_returns_is_two_bodies():
    fresh(9)
    made = box("Ghost")
    keyed(made, "location", {1: (0, 0, 0), 9: (8, 0, 0)})
    for frame, hidden in ((1, False), (4, True), (7, False)):
        made.hide_viewport = hidden
        made.keyframe_insert("hide_viewport", frame=frame)
    mesh, _ = door(saved("ghost.blend"))
    assert mesh.names == ["Ghost", "Ghost 2"]
    for name, first, last in (("Ghost", 0, 2), ("Ghost 2", 6, 8)):
        assert np.allclose(mesh[name].time_span, (first / 30, last / 30))


def test_attributes_are_those_of_the_scene():
    fresh(2)
    made = box("Box")
    made.data.materials.append(material("Red"))
    made.data.materials.append(material("Green"))
    made.data.polygons[3].material_index = 1
    paint = made.data.color_attributes.new("Paint", "BYTE_COLOR", "POINT")
    for number, one in enumerate(paint.data):
        one.color_srgb = (number / 7, 0, 1, 1)
    made.data.color_attributes.active_color = paint
    keyed(made, "location", {1: (0, 0, 0), 2: (1, 0, 0)})
    mesh, _ = door(saved("painted.blend"))
    solid = mesh.slice(0, light=True)
    assert sorted(solid.triangle_attributes["material"].tolist()) == 10 * [1] + 2 * [2]
    assert json.loads(mesh._metadata["details"])["materials"] == ["", "Red", "Green"]
    colors = solid.vertex_attributes["color"]
    assert np.array_equal(colors[:, 0], np.rint(np.arange(8) / 7 * 255)) and (colors[:, 2:] == 255).all()
    corners = solid.triangle_attributes["uv:corners"].reshape(-1, 2)
    places = np.array([one.uv for one in made.data.uv_layers.active.data])
    assert apart(corners, places) == 0


def test_a_scene_at_rest_is_one_triangle_mesh():
    fresh(3)
    box("Low")
    box("High").location.z = 5
    bpy.context.view_layer.update()
    there = np.concatenate([vertices_of(bpy.data.objects[name]) for name in ("Low", "High")])
    saved("still.blend")
    bpy.ops.export_scene.gltf(filepath=os.path.abspath("still.glb"), export_animations=False)
    for file in ("still.blend", "still.glb"):
        done = run(file, "-o", "still.ply")
        assert done.returncode == 0, done.stderr
        mesh = t4d.read_triangles("still.ply")
        assert apart(mesh.vertices, there) < 1e-6 and abs(mesh.volume - 16) < 1e-5, file


def test_what_cannot_be_done_is_said_and_nothing_is_left():
    fresh(3)
    box("Still")
    Path("not.fbx").write_text("nothing")
    saved("still.blend")
    bpy.ops.export_scene.fbx(filepath=os.path.abspath("still.fbx"), bake_anim=False)
    Path("kept.t4d").write_text("kept")
    for words, code, said in (
        (["none.fbx"], 4, "none.fbx: cannot be opened"),
        (["not.fbx"], 4, "not.fbx: Blender"),
        (["still.fbx"], 4, "still.fbx: nothing in it moves"),
        (["still.blend", "--object", "Moved"], 4, "there is no object 'Moved'; there are 'Still'"),
        (["still.blend", "--frame-range", "3:3"], 4, "a motion has at least 2"),
        (["still.blend", "--frame-range", "3"], 2, "--frame-range"),
        (["still.blend", "--sharp"], 2, "--sharp"),
        (["still.blend", "--tolerance", "0"], 2, "--tolerance"),
    ):
        done = run(*words, "-o", "kept.t4d")
        assert done.returncode == code and said in done.stderr, (words, done.returncode, done.stderr)
        assert done.stderr.startswith("t4d: ") and "Traceback" not in done.stderr and not done.stdout
    assert Path("kept.t4d").read_text() == "kept"
    assert {one.suffix for one in Path().iterdir()} <= {".blend", ".fbx", ".t4d", ".blend1"}


def main():
    tests = [(name, test) for name, test in globals().items() if name.startswith("test_")]
    chosen = sys.argv[sys.argv.index("--") + 2 :]
    for name, test in tests:
        if chosen and not any(word in name for word in chosen):
            continue
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            print(name[5:].replace("_", " "), flush=True)
            test()
            os.chdir("/")
    print(f"Blender {bpy.app.version_string}: {len(tests)} tests of t4d-blender passed")


main()

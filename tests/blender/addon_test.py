"""The add-on in Blender: run by tests/blender/check, in Blender's Python.

Volumes at frames and between them are those of slices, however a frame shows a slice: while it plays,
baked, and after an export. Blender's own volume of a mesh is the judge. Streaks of motion blur are as
long as the velocity says.
"""

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
from t4d import verbs  # noqa: E402

# Positions are float32 in Blender; a volume adds products of three of them.
CLOSE = 2e-6


def make_models():
    subprocess.run([BUILD / "t4d-fixtures", "."], check=True, stdout=subprocess.DEVNULL)
    cube = t4d.read_triangles("paper-cube.obj")
    screw = t4d.sweep(cube, motion="paper-screw.json", name="screw")
    screw.save("screw.t4d")
    moved = t4d.sweep(cube, motion="paper-translation.json", name="cube")
    moved.save("cube.t4d")
    t4d.Mesh._of([*screw.load()._bodies, *moved.load()._bodies]).save("pair.t4d")


def install():
    """As a user does: the same zip as an add-on, or from 4.2 on as an extension."""
    archive = str(BUILD / "blender" / "io_mesh_t4d.zip")
    if bpy.app.version >= (4, 2, 0):
        bpy.ops.preferences.addon_enable(module="bl_pkg")
        bpy.ops.extensions.package_install_files(filepath=archive, repo="user_default")
    else:
        bpy.ops.preferences.addon_install(filepath=archive)
        bpy.ops.preferences.addon_enable(module="io_mesh_t4d")


def fresh(fps=24):
    """An empty scene."""
    for kind in (bpy.data.objects, bpy.data.meshes, bpy.data.materials, bpy.data.collections):
        bpy.data.batch_remove(list(kind))
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = fps, 1
    scene.frame_start, scene.frame_end, scene.frame_step = 1, 250, 1
    return scene


def brought(file, **options):
    """What an import makes."""
    before = set(bpy.data.objects)
    assert bpy.ops.import_mesh.t4d(filepath=os.path.abspath(file), **options) == {"FINISHED"}
    return sorted(set(bpy.data.objects) - before, key=lambda made: made.name)


def volume(made):
    """Of the mesh that Blender draws and renders, in coordinates of the mesh."""
    evaluated = made.evaluated_get(bpy.context.evaluated_depsgraph_get())
    work = bmesh.new()
    work.from_mesh(evaluated.data)
    assert all(edge.is_manifold for edge in work.edges)
    found = work.calc_volume(signed=True)
    work.free()
    return found


def show(frame):
    bpy.context.scene.frame_set(math.floor(frame), subframe=frame % 1)


def close(a, b, tolerance=CLOSE):
    return abs(a - b) <= tolerance * max(abs(a), abs(b))


def refused(call, *words):
    """Whether an operator fails with a sentence that has these words."""
    try:
        call()
    except RuntimeError as error:
        missing = [word for word in words if word not in str(error)]
        assert not missing, f"{error}: does not say {missing}"
        return True
    return False


def test_volumes_at_frames_and_between_are_those_of_slices():
    screw = t4d.read("screw.t4d")
    begin, end = screw.time_span
    for detail in ("EXACT", "LIGHT"):
        fresh()
        (made,) = brought("screw.t4d", speed=10, start=5, detail=detail)
        for frame in (5, 6, 17.25, 100, 163.5, 244):
            show(frame)
            time = min(begin + (frame - 5) / 24 * 10, end)
            exact = screw.slice(time)
            assert close(volume(made), exact.volume), (detail, frame)
            if detail == "EXACT":
                assert len(made.data.polygons) == len(exact.triangles)
            else:
                assert len(made.data.polygons) == 24


def test_a_frame_shows_the_time_that_start_speed_and_rate_say():
    cube = t4d.read("cube.t4d")
    for speed, start, rate, frame, time in (
        (1, 1, 24, 25, 1),
        (0.1, 1, 25, 26, 0.1),
        (16, 11, 30, 26, 8),
        (-4, 1, 24, 7, 63),
        (1, 1, 24, -30, 0),  # it stands still before
        (100, 1, 24, 400, 64),  # and after
    ):
        scene = fresh(rate)
        (made,) = brought("cube.t4d", speed=speed, start=start)
        show(frame)
        here = np.array([vertex.co for vertex in made.data.vertices])
        there = cube.slice(time).vertices
        assert here.shape == there.shape and np.abs(here - there).max() < 1e-5, (speed, frame)
        assert scene.frame_start == start and scene.frame_end == start + round(64 / abs(speed) * rate)


def test_the_scene_gets_metres_and_z_up():
    solid = t4d.read_triangles("paper-cube.obj")
    motion = {"length_unit": "mm", "segments": [{"duration": 1, "translation": [0, 5, 0]}]}
    for up in ("y", "z"):
        t4d.sweep(solid, motion=motion, up=up).save("up.t4d")
        fresh()
        (made,) = brought("up.t4d", speed=1)
        places = []
        for frame in (1, 25):
            show(frame)
            places.append(np.array(made.matrix_world @ made.data.vertices[0].co))
        moved = [0, 0, 0.005] if up == "y" else [0, 0.005, 0]
        assert np.allclose(places[1] - places[0], moved, atol=1e-8), up


def test_every_body_is_an_object():
    pair = t4d.read("pair.t4d")
    fresh()
    made = brought("pair.t4d", speed=4)
    assert [one.name for one in made] == ["cube", "screw"]
    show(49)
    for one in made:
        assert close(volume(one), pair[one.name].slice(8).volume)
    show(24 * 20 + 1)  # time 80: the cube has ended at 64
    assert not made[0].data.vertices and made[1].data.vertices
    fresh()
    assert [one.name for one in brought("pair.t4d", body="screw")] == ["screw"]
    assert refused(lambda: brought("pair.t4d", body="nut"), "no body 'nut'", "screw, cube")


def test_what_cannot_be_read_is_refused():
    fresh()
    Path("not.t4d").write_text("nothing")
    for file, word in (("none.t4d", "none.t4d"), ("not.t4d", "not.t4d")):
        assert refused(lambda: brought(file), word)
    assert refused(lambda: brought("screw.t4d", attribute="heat"), "no attribute 'heat'", "kind, triangle")
    assert not bpy.data.objects and not bpy.data.meshes and not bpy.data.materials


def test_a_file_that_goes_or_changes_is_noticed():
    solid = t4d.read_triangles("paper-cube.obj")
    still = {"segments": [{"duration": 1}]}
    fresh()
    t4d.sweep(solid, motion=still).save("here.t4d")
    (made,) = brought("here.t4d")
    whole = volume(made)
    os.remove("here.t4d")
    show(2)
    assert not made.data.vertices and "here.t4d" in made.data.t4d.message
    t4d.sweep(solid.vertices * 2, solid.triangles, still).save("here.t4d")
    show(3)
    assert close(volume(made), 8 * whole) and not made.data.t4d.message


def test_settings_act_at_once():
    fresh()
    (made,) = brought("screw.t4d")
    show(30)
    settings = made.data.t4d
    count = len(made.data.polygons)
    settings.detail = "LIGHT"
    assert len(made.data.polygons) == 24 < count
    settings.smooth = True
    assert all(polygon.use_smooth for polygon in made.data.polygons)
    settings.attribute = "heat"
    assert not made.data.vertices and "no attribute 'heat'" in settings.message
    settings.attribute = "kind"
    assert "color" in made.data.attributes and not settings.message
    settings.velocity = False
    assert "velocity" not in made.data.attributes
    settings.body = "nut"
    assert not made.data.vertices and "no body 'nut'" in settings.message


def test_light_slices_of_what_is_woven_are_exact_and_the_panel_says_so():
    axis = np.linspace(-2, 2, 17)
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij")
    balls = np.stack([np.sqrt(x**2 + y**2 + z**2) - radius for radius in (1, 1.2, 1.4)])
    t4d.weave(balls, spacing=0.25, origin=(-2, -2, -2)).save("ball.t4d")
    fresh()
    (made,) = brought("ball.t4d", detail="LIGHT")
    show(13)
    assert close(volume(made), t4d.read("ball.t4d").slice(0.5).volume)
    assert "exact" in made.data.t4d.message and "prisms" in made.data.t4d.message


def test_attributes_become_colours():
    fresh()
    (made,) = brought("screw.t4d", attribute="triangle")
    show(20.5)
    solid = t4d.read("screw.t4d").slice(19.5 / 24)
    values = np.empty(len(made.data.polygons))
    made.data.attributes["color"].data.foreach_get("value", values)
    assert np.array_equal(values, solid.triangle_attributes["triangle"].astype(np.float32))
    (material,) = made.data.materials
    assert any(node.type == "MAP_RANGE" for node in material.node_tree.nodes)


def test_colours_and_textures_of_the_solid_are_those_of_light_slices():
    solid = t4d.read_triangles("paper-cube.obj")
    painted = t4d.TriangleMesh(
        *solid,
        {
            "paint": np.tile(np.array([255, 0, 188, 255], dtype=np.uint8), (len(solid.vertices), 1)),
            "uv": solid.vertices[:, :2],
            "heat": solid.vertices[:, 2],
        },
    )
    t4d.sweep(painted, motion="paper-screw.json").save("painted.t4d")
    for attribute, components in (("paint", 4), ("heat", 1)):
        fresh()
        (made,) = brought("painted.t4d", attribute=attribute, detail="LIGHT")
        show(20.5)
        found = np.empty(components * len(solid.vertices))
        values = made.data.attributes["color"].data
        values.foreach_get("color" if components > 1 else "value", found)
        if attribute == "paint":
            assert np.allclose(found.reshape(-1, 4), [1, 0, 0.5029, 1], atol=1e-4)
        else:
            assert np.allclose(found, solid.vertices[:, 2])
            (limits,) = (n for n in made.data.materials[0].node_tree.nodes if n.type == "MAP_RANGE")
            assert limits.inputs["From Max"].default_value == solid.vertices[:, 2].max()
        for corner, place in zip(made.data.loops, made.data.uv_layers[0].data):
            assert np.allclose(place.uv, solid.vertices[corner.vertex_index, :2])
    assert refused(lambda: brought("painted.t4d", attribute="paint"), "light slices have it")


def velocities(made):
    found = np.empty(3 * len(made.data.vertices))
    made.data.attributes["velocity"].data.foreach_get("vector", found)
    return found.reshape(-1, 3)


def test_velocities_are_per_second():
    screw = t4d.read("screw.t4d")
    for speed in (4, -4):
        fresh()
        (made,) = brought("screw.t4d", speed=speed)
        show(30)
        time = 29 / 24 * speed % 100
        expected = screw.slice(time, velocity=True).vertex_attributes["velocity"] * speed
        assert np.abs(velocities(made) - expected).max() <= 1e-5 * np.abs(expected).max()
        made.data.t4d.max_speed = 0.5
        assert np.linalg.norm(velocities(made), axis=1).max() <= 0.5 * (1 + 1e-6)
        show(-5)
        assert not velocities(made).any()  # it stands still


def test_a_baked_sequence_shows_each_slice_at_its_frame():
    scene = fresh()
    (made,) = brought("screw.t4d", speed=24, set_range=False)
    scene.frame_start, scene.frame_end = 3, 9
    assert bpy.ops.object.t4d_bake() == {"FINISHED"}
    baked = [one for one in bpy.data.objects if one != made]
    assert len(baked) == 7 and not any(one.data.t4d.path for one in baked)
    assert made.hide_render
    os.rename("screw.t4d", "away.t4d")  # it is not needed any more
    for frame in range(2, 11):
        show(frame)
        seen = [one for one in baked if not one.hide_render]
        assert [one.name for one in seen] == ([f"screw {frame:04d}"] if 3 <= frame <= 9 else [])
        if seen:
            assert close(volume(seen[0]), t4d.read("away.t4d").slice(frame - 1).volume)
            assert "velocity" in seen[0].data.attributes
    os.rename("away.t4d", "screw.t4d")


def test_a_bake_that_fails_leaves_nothing():
    scene = fresh()
    (made,) = brought("cube.t4d", set_range=False)
    scene.frame_end = 3
    os.rename("cube.t4d", "away.t4d")
    assert refused(bpy.ops.object.t4d_bake, "cube.t4d")
    assert list(bpy.data.objects) == [made] and not made.hide_render and not bpy.data.collections
    os.rename("away.t4d", "cube.t4d")


def key_poses(made):
    """A cube that turns and moves in eight frames."""
    for frame, place, turn in ((1, (0, 0, 0), (0, 0, 0)), (9, (4, 1, 0), (0.3, 0.9, 0))):
        made.location, made.rotation_euler = place, turn
        made.keyframe_insert("location", frame=frame)
        made.keyframe_insert("rotation_euler", frame=frame)


def exported(file, **options):
    assert bpy.ops.export_mesh.t4d(filepath=os.path.abspath(file), **options) == {"FINISHED"}
    return t4d.read(file)


def blenders_vertices(made):
    evaluated = made.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array([evaluated.matrix_world @ vertex.co for vertex in evaluated.data.vertices])


def test_a_rigid_object_is_exported_with_its_poses_and_comes_back():
    scene = fresh()
    bpy.ops.mesh.primitive_cube_add(size=2)
    made = bpy.context.object
    made.scale = (1, 2, -3)  # mirrored, so inside out
    key_poses(made)
    scene.frame_end = 9
    mesh = exported("rigid.t4d")
    assert mesh.check(deep=True)["valid"] and (mesh.length_unit, mesh.time_unit, mesh.up) == ("m", "s", "z")
    assert mesh.names == ["Cube"] and np.allclose(mesh.time_span, (0, 8 / 24))
    for frame in range(1, 10):
        show(frame)
        layer = mesh.slice((frame - 1) / 24).vertices
        assert np.abs(layer - blenders_vertices(made)).max() < 1e-5, frame
    verbs.flipbook(mesh, output="rigid.glb", rigid=True, n=9)  # which needs the poses
    (back,) = brought("rigid.t4d")
    for frame in (1, 2.5, 7, 9):
        show(frame)
        assert close(volume(back), mesh.slice((frame - 1) / 24).volume)
        assert close(volume(back), 48, 1e-3)


def test_a_deformed_object_goes_from_key_to_key_and_comes_back():
    scene = fresh()
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2)
    made = bpy.context.object
    made.shape_key_add(name="Basis")
    wide = made.shape_key_add(name="wide")
    for point in wide.data:
        point.co.x *= 3
    for frame, value in ((1, 0), (5, 1)):
        wide.value = value
        wide.keyframe_insert("value", frame=frame)
    scene.frame_end = 5
    mesh = exported("deformed.t4d", step=2)
    assert mesh.check(deep=True)["valid"]
    for frame in (1, 3, 5):
        show(frame)
        assert close(mesh.slice((frame - 1) / 24).volume, volume(made), 1e-5)
    (back,) = brought("deformed.t4d", detail="LIGHT")
    for frame in (1, 1.75, 4, 5):
        show(frame)
        assert close(volume(back), mesh.slice((frame - 1) / 24).volume)


def test_an_export_is_of_all_that_is_visible_or_selected():
    scene = fresh()
    scene.frame_end = 3
    bpy.ops.mesh.primitive_cube_add(size=2)
    key_poses(bpy.context.object)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=1)
    assert exported("all.t4d").names == ["Cube", "Icosphere"]
    assert exported("one.t4d", use_selection=True).names == ["Icosphere"]
    bpy.ops.mesh.primitive_plane_add()
    assert exported("solids.t4d").names == ["Cube", "Icosphere"]  # and a warning of the plane


def test_a_modifier_that_changes_faces_is_woven():
    scene = fresh()
    scene.frame_end = 3
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3)
    made = bpy.context.object
    cut = made.modifiers.new("cut", "DECIMATE")
    for frame, ratio in ((1, 1), (3, 0.5)):
        cut.ratio = ratio
        cut.keyframe_insert("ratio", frame=frame)
    mesh = exported("woven.t4d", voxel_size=0.1)
    for frame in (1, 2, 3):
        show(frame)
        assert close(mesh.slice((frame - 1) / 24).volume, volume(made), 0.03)


def test_what_no_sweep_can_be_is_refused_and_no_file_is_left():
    scene = fresh()
    scene.frame_end = 4
    out = lambda **options: exported("no.t4d", **options)  # noqa: E731
    assert refused(out, "no visible object has faces")
    bpy.ops.mesh.primitive_plane_add()
    assert refused(out, "Plane", "closed")
    bpy.ops.mesh.primitive_cube_add()
    assert refused(lambda: out(first=2, last=2), "at least 2")
    assert not os.path.exists("no.t4d")


def test_without_the_module_the_operator_says_what_to_do():
    fresh()
    loaded = {name: part for name, part in sys.modules.items() if name.split(".")[0] == "t4d"}
    sys.modules.update(dict.fromkeys(loaded))
    try:
        assert refused(lambda: brought("other.t4d"), "the module t4d", "pip install")
        bpy.ops.mesh.primitive_cube_add()
        assert refused(lambda: exported("other.t4d"), "pip install")
    finally:
        sys.modules.update(loaded)


def test_a_saved_scene_follows_again_when_it_is_opened():
    fresh()
    (made,) = brought("screw.t4d", speed=10)
    made.data.t4d.path = bpy.path.relpath(os.path.abspath("screw.t4d"), start=os.getcwd())
    show(7)
    bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath("scene.blend"))
    bpy.data.meshes["screw"].clear_geometry()
    bpy.ops.wm.open_mainfile(filepath=os.path.abspath("scene.blend"))
    made = bpy.data.objects["screw"]
    for frame in (7, 30):
        show(frame)
        assert close(volume(made), t4d.read("screw.t4d").slice((frame - 1) / 24 * 10).volume)
    assert made.data.t4d.path.startswith("//")


def camera(scene, width, pixels):
    """From above, parallel; light is what bodies emit."""
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 64, False
    scene.render.resolution_x, scene.render.resolution_y = pixels, pixels // 4
    scene.view_settings.view_transform = "Standard"
    scene.render.image_settings.file_format = "OPEN_EXR"
    lens = bpy.data.cameras.new("camera")
    lens.type, lens.ortho_scale = "ORTHO", width
    scene.camera = bpy.data.objects.new("camera", lens)
    scene.camera.location = (0, 0, 50)
    scene.collection.objects.link(scene.camera)
    if scene.world.node_tree is None:
        scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)


def shining():
    made = bpy.data.materials.new("light")
    if made.node_tree is None:
        made.use_nodes = True
    nodes = made.node_tree.nodes
    (output,) = (node for node in nodes if node.type == "OUTPUT_MATERIAL")
    made.node_tree.links.new(nodes.new("ShaderNodeEmission").outputs[0], output.inputs[0])
    return made


def streak(file, width):
    """(from, to) of what is lit in the middle row, in units of the scene."""
    image = bpy.data.images.load(os.path.abspath(file), check_existing=False)
    columns, rows = image.size
    pixels = np.array(image.pixels[:]).reshape(rows, columns, -1)
    lit = np.flatnonzero(pixels[rows // 2, :, 0] > 1e-3)
    bpy.data.images.remove(image)
    return (lit[0] / columns - 0.5) * width, ((lit[-1] + 1) / columns - 0.5) * width


def test_motion_blur_is_as_long_as_the_velocity_says():
    """A cube of side 2 that moves along x, 12 units a second, is open to light for half a frame."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    motion = {"segments": [{"duration": 4, "translation": [24, 0, 0]}]}
    t4d.sweep(corners - [6, 0, 0], faces, motion, up="z", steps=7).save("flies.t4d")
    width, pixels = 24, 480
    for detail, blur in (("EXACT", True), ("LIGHT", True), ("EXACT", False)):
        scene = fresh(fps=6)
        camera(scene, width, pixels)
        (made,) = brought("flies.t4d", speed=2, detail=detail, velocity=blur, set_range=False)
        made.data.materials.append(shining())
        scene.render.use_motion_blur, scene.render.motion_blur_shutter = blur, 0.5
        scene.frame_start, scene.frame_end = 3, 5
        scene.render.filepath = os.path.abspath("picture-")
        bpy.ops.render.render(animation=True)
        for frame in (3, 4, 5):
            begin, end = streak(f"picture-{frame:04d}.exr", width)
            center = -6 + 2 * (frame - 1)
            half = 1 + (0.5 if blur else 0)  # 2 units a frame, half of it open: a unit in all
            pixel = width / pixels
            assert abs(begin - (center - half)) < 1.5 * pixel, (detail, blur, frame, begin, end)
            assert abs(end - (center + half)) < 1.5 * pixel, (detail, blur, frame, begin, end)


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        make_models()
        install()
        tests = [(name, test) for name, test in globals().items() if name.startswith("test_")]
        for name, test in tests:
            print(name[5:].replace("_", " "), flush=True)
            test()
    print(f"Blender {bpy.app.version_string}: {len(tests)} tests passed")


main()

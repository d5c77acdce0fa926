"""File > Export > 4D mesh: the sweep of an animated mesh."""

import bpy
import numpy as np
from bpy.props import IntProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from .library import FAILURES, Problem, module, remarks, sentence
from .units import metres_per_unit

# Blender keeps positions in float32, whose seven digits leave a pose this far from a rotation.
RIGID = 1e-5


def array_of(elements, name, kind, columns=1):
    values = np.empty(len(elements) * columns, dtype=kind)
    elements.foreach_get(name, values)
    return values.reshape(-1, columns) if columns > 1 else values


class Shape:
    """A mesh at a frame, with its modifiers, in its own coordinates; and where it is."""

    def __init__(self, source, graph):
        evaluated = source.evaluated_get(graph)
        mesh = evaluated.to_mesh()
        self.vertices = array_of(mesh.vertices, "co", np.float32, 3).astype(np.float64)
        self.corners = array_of(mesh.loops, "vertex_index", np.int32)
        self.starts = array_of(mesh.polygons, "loop_start", np.int32)
        mesh.calc_loop_triangles()
        self.triangles = array_of(mesh.loop_triangles, "vertices", np.int32, 3)
        self.matrix = np.array(evaluated.matrix_world, dtype=np.float64)
        evaluated.to_mesh_clear()

    def has_faces_of(self, other):
        return (
            len(self.vertices) == len(other.vertices)
            and np.array_equal(self.corners, other.corners)
            and np.array_equal(self.starts, other.starts)
        )

    def __str__(self):
        return f"{len(self.vertices)} vertices and {len(self.starts)} faces"

    def placed(self):
        return self.vertices @ self.matrix[:3, :3].T + self.matrix[:3, 3]


def shapes_of(source, context, frames):
    """At each frame, all with the vertices and faces of the first."""
    shapes = []
    for number, frame in enumerate(frames):
        context.window_manager.progress_update(number)
        context.scene.frame_set(frame)
        shapes.append(Shape(source, context.evaluated_depsgraph_get()))
        if not shapes[-1].has_faces_of(shapes[0]):
            raise Problem(
                f"'{source.name}' has {shapes[-1]} at frame {frame}, but {shapes[0]} at frame "
                f"{frames[0]}, or joins them otherwise; a sweep needs the same faces at all frames: turn "
                "off the modifier that changes them, or export frames as volumes and use t4d weave"
            )
    if not len(shapes[0].triangles):
        raise Problem(f"'{source.name}' has no faces at frame {frames[0]}; a solid has a closed surface")
    return shapes


def poses_of(shapes):
    """(n, 4, 4) rotations and translations that take the first shape to each, or None if it changes."""
    first = shapes[0]
    back = np.linalg.inv(first.matrix)
    poses = []
    for shape in shapes:
        if not np.array_equal(shape.vertices, first.vertices):
            return None
        pose = shape.matrix @ back
        left, scales, right = np.linalg.svd(pose[:3, :3])
        turn = left @ right
        if np.abs(scales - 1).max() > RIGID or np.linalg.det(turn) < 0:
            return None
        pose[:3, 3] = shape.matrix[:3, 3] - turn @ first.matrix[:3, 3]
        pose[:3, :3] = turn
        poses.append(pose)
    return np.array(poses)


def swept(source, context, frames):
    """The 4D mesh of an object: of its poses if it is rigid, otherwise from frame to frame."""
    t4d = module()
    scene = context.scene
    shapes = shapes_of(source, context, frames)
    metres = metres_per_unit(scene)
    used, triangles = np.unique(shapes[0].triangles, return_inverse=True)
    triangles = triangles.reshape(-1, 3)
    times = [(frame - frames[0]) * scene.render.fps_base / scene.render.fps for frame in frames]
    options = {"name": source.name, "up": "z", "units": ("m", "s")}
    poses = poses_of(shapes)
    if poses is not None:
        poses[:, :3, 3] *= metres
        solid = t4d.TriangleMesh(shapes[0].placed()[used] * metres, triangles)
        return t4d.sweep(solid, motion=t4d.Motion.from_matrices(times, poses), **options)
    keys = np.stack([shape.placed()[used] for shape in shapes]) * metres
    return t4d.sweep(keys, triangles, times=times, **options)


class T4D_OT_export(bpy.types.Operator, ExportHelper):
    """Export the active mesh object and its motion as a 4D mesh"""

    bl_idname = "export_mesh.t4d"
    bl_label = "Export 4D Mesh"

    filename_ext = ".t4d"
    filter_glob: StringProperty(default="*.t4d", options={"HIDDEN"})
    first: IntProperty(name="First Frame", description="By default, that of the scene")
    last: IntProperty(name="Last Frame", description="By default, that of the scene")
    step: IntProperty(name="Step", description="Frames from one key to the next", default=1, min=1)

    @classmethod
    def poll(cls, context):
        return context.object and context.object.type == "MESH" and context.mode == "OBJECT"

    def invoke(self, context, event):
        self.first, self.last = self._range(context.scene)
        return super().invoke(context, event)

    def execute(self, context):
        first, last = self._range(context.scene)
        frames = range(first, last + 1, self.step)
        if len(frames) < 2:
            self.report(
                {"ERROR"},
                f"frames {first} to {last} in steps of {self.step} are {len(frames)}; a motion has at least 2",
            )
            return {"CANCELLED"}
        before = context.scene.frame_current
        context.window_manager.progress_begin(0, len(frames))
        try:
            with remarks() as found:
                swept(context.object, context, frames).save(self.filepath)
        except FAILURES as failure:
            self.report({"ERROR"}, sentence(failure))
            return {"CANCELLED"}
        finally:
            context.window_manager.progress_end()
            context.scene.frame_set(before)
        for one in found:
            self.report({"WARNING"}, one)
        return {"FINISHED"}

    def _range(self, scene):
        given = self.properties.is_property_set
        return (
            self.first if given("first") else scene.frame_start,
            self.last if given("last") else scene.frame_end,
        )


def add_to_menu(menu, _):
    menu.layout.operator(T4D_OT_export.bl_idname, text="4D mesh (.t4d)")


def register():
    bpy.utils.register_class(T4D_OT_export)
    bpy.types.TOPBAR_MT_file_export.append(add_to_menu)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(add_to_menu)
    bpy.utils.unregister_class(T4D_OT_export)

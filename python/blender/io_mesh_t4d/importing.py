"""File > Import > 4D mesh."""

import math

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty
from bpy_extras.io_utils import ImportHelper
from mathutils import Matrix

from . import coloring
from .library import FAILURES, opened, sentence
from .settings import DETAILS
from .units import METRES, metres_per_unit


def placement(whole, scene):
    """The matrix from the file's coordinates to the scene's: its unit of length, and z up."""
    metres = METRES.get(whole.length_unit)
    scale = metres / metres_per_unit(scene) if metres else 1
    turn = 0 if whole.up == "z" else 90
    return Matrix.Scale(scale, 4) @ Matrix.Rotation(math.radians(turn), 4, "X")


class T4D_OT_import(bpy.types.Operator, ImportHelper):
    """Import a 4D mesh: one object per body, whose mesh is the solid at the scene's frame"""

    bl_idname = "import_mesh.t4d"
    bl_label = "Import 4D Mesh"
    bl_options = {"UNDO", "PRESET"}

    filename_ext = ".t4d"
    filter_glob: StringProperty(default="*.t4d", options={"HIDDEN"})
    body: StringProperty(name="Body", description="Import only the body of this name; empty: all bodies")
    detail: EnumProperty(name="Slices", items=DETAILS, default="EXACT")
    start: FloatProperty(
        name="Start", description="Frame that shows the first time of the file", default=1
    )
    speed: FloatProperty(
        name="Speed",
        description="How much of the 4D mesh's time passes in a second; negative: backwards",
        default=1,
    )
    smooth: BoolProperty(name="Shade Smooth", default=False)
    velocity: BoolProperty(
        name="Velocity", description="Write velocities, from which Cycles makes motion blur", default=True
    )
    attribute: StringProperty(
        name="Attribute", description="Colour by this attribute of the 4D mesh; empty: no colours"
    )
    set_range: BoolProperty(
        name="Set Frame Range",
        description="Let the scene begin and end with the motion",
        default=True,
    )

    def execute(self, context):
        try:
            whole = opened(self.filepath)
            names = [self.body] if self.body else whole.names
            bodies = [whole[name] for name in names]  # a wrong name is refused before anything is made
            light = self.detail == "LIGHT"
            colors = coloring.material(bodies, self.attribute, light) if self.attribute else None
        except FAILURES as failure:
            self.report({"ERROR"}, sentence(failure))
            return {"CANCELLED"}
        self._tell_of_units(whole)
        if self.set_range and self.speed:
            self._set_range(context.scene, whole.time_span)
        for name in names:
            made = self._object(context, name, colors)
            made.matrix_world = placement(whole, context.scene)
            if made.data.t4d.message:
                self.report({"WARNING"}, made.data.t4d.message)
        # Blender's interface must not draw what handlers change during a render.
        context.scene.render.use_lock_interface = True
        return {"FINISHED"}

    def _object(self, context, name, colors):
        mesh = bpy.data.meshes.new(name)
        if colors:
            mesh.materials.append(colors)
        settings = mesh.t4d
        for option in ("detail", "start", "speed", "smooth", "velocity", "attribute"):
            setattr(settings, option, getattr(self, option))
        settings.body = name
        settings.path = self.filepath
        made = bpy.data.objects.new(name, mesh)
        context.collection.objects.link(made)
        for other in context.selected_objects:
            other.select_set(False)
        made.select_set(True)
        context.view_layer.objects.active = made
        return made

    def _set_range(self, scene, span):
        frames = (span[1] - span[0]) / abs(self.speed) * scene.render.fps / scene.render.fps_base
        scene.frame_start = round(self.start)
        scene.frame_end = round(self.start + frames)

    def _tell_of_units(self, whole):
        if whole.length_unit and whole.length_unit not in METRES:
            self.report(
                {"WARNING"},
                f"the length unit '{whole.length_unit}' is unknown; it is shown as a unit of Blender",
            )


def add_to_menu(menu, _):
    menu.layout.operator(T4D_OT_import.bl_idname, text="4D mesh (.t4d)")


def register():
    bpy.utils.register_class(T4D_OT_import)
    bpy.types.TOPBAR_MT_file_import.append(add_to_menu)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(add_to_menu)
    bpy.utils.unregister_class(T4D_OT_import)

"""File > Export > 4D mesh: the scene, as t4d-blender makes it of a file."""

import tempfile

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from .library import FAILURES, module, sentence
from .recorder import Recorder
from .scene import Scene


class T4D_OT_export(bpy.types.Operator, ExportHelper):
    """Export visible objects and their motion as a 4D mesh"""

    bl_idname = "export_mesh.t4d"
    bl_label = "Export 4D Mesh"

    filename_ext = ".t4d"
    filter_glob: StringProperty(default="*.t4d", options={"HIDDEN"})
    use_selection: BoolProperty(name="Selected Objects", description="Export selected objects only", default=False)
    first: IntProperty(name="First Frame", description="By default, that of the scene")
    last: IntProperty(name="Last Frame", description="By default, that of the scene")
    step: IntProperty(name="Step", description="Frames from one key to the next", default=1, min=1)
    tolerance: FloatProperty(
        name="Tolerance",
        description="Add keys where half frames are farther than this from the straight way, in metres; 0: none",
        default=0,
        min=0,
        precision=4,
    )
    voxel_size: FloatProperty(
        name="Voxel Size",
        description="Edge of voxels, in metres, of objects whose faces change; 0: a hundredth of the object",
        default=0,
        min=0,
        precision=4,
    )

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def invoke(self, context, event):
        self.first, self.last = self._range(context.scene)
        return super().invoke(context, event)

    def execute(self, context):
        before = context.scene.frame_current
        first, last = self._range(context.scene)
        chosen = [one.name for one in context.selected_objects] if self.use_selection else []
        context.window_manager.progress_begin(first, max(last, first + 1))
        failures = FAILURES
        try:
            failures = (*FAILURES, module().Error)
            from t4d import recorded

            with tempfile.TemporaryDirectory(prefix="t4d-") as folder:
                recorder = Recorder(Scene(context, chosen), folder, self.tolerance or None)
                recorder.record(first, last, self.step, context.window_manager.progress_update)
                recorder.finish(bpy.path.basename(bpy.data.filepath))
                done = recorded.save(folder, self.filepath, voxel_size=self.voxel_size or None)
        except failures as failure:
            self.report({"ERROR"}, sentence(failure))
            return {"CANCELLED"}
        finally:
            context.window_manager.progress_end()
            context.scene.frame_set(before)
        for line in recorded.lines_of(done.report):
            self.report({"INFO"}, line)
        for line in [*done.notes, *(f"lost: {loss}" for loss in done.losses)]:
            self.report({"WARNING"}, line)
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

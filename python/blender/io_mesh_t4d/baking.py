"""A mesh that follows the frame becomes one object per frame, which need neither the file nor t4d."""

import bpy


def frames_of(scene):
    return range(scene.frame_start, scene.frame_end + 1, scene.frame_step)


def show_from(made, frame, end):
    """Lets an object be visible from a frame until just before another."""
    for moment, hidden in ((frame - 1, True), (frame, False), (end, True)):
        made.hide_viewport = made.hide_render = hidden
        made.keyframe_insert("hide_viewport", frame=moment)
        made.keyframe_insert("hide_render", frame=moment)


def frozen(source, graph, name):
    """The object as it is now, with its modifiers applied."""
    mesh = bpy.data.meshes.new_from_object(
        source.evaluated_get(graph), preserve_all_data_layers=True, depsgraph=graph
    )
    mesh.name = name
    mesh.t4d.property_unset("path")
    made = bpy.data.objects.new(name, mesh)
    made.matrix_world = source.matrix_world
    return made


class T4D_OT_bake(bpy.types.Operator):
    """Make one object for each frame of the scene, shown at that frame only, and hide this one"""

    bl_idname = "object.t4d_bake"
    bl_label = "Bake to Mesh Sequence"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.object and context.object.type == "MESH" and context.object.data.t4d.path

    def execute(self, context):
        source, scene = context.object, context.scene
        before = scene.frame_current
        made = []
        context.window_manager.progress_begin(0, len(frames_of(scene)))
        for frame in frames_of(scene):
            context.window_manager.progress_update(len(made))
            scene.frame_set(frame)
            if source.data.t4d.message and not source.data.vertices:
                self.report({"ERROR"}, source.data.t4d.message)
                break
            made.append(frozen(source, context.evaluated_depsgraph_get(), f"{source.name} {frame:04d}"))
        context.window_manager.progress_end()
        scene.frame_set(before)
        if len(made) < len(frames_of(scene)):
            bpy.data.batch_remove([*made, *(one.data for one in made)])
            return {"CANCELLED"}
        collection = bpy.data.collections.new(f"{source.name} baked")
        scene.collection.children.link(collection)
        for frame, one in zip(frames_of(scene), made):
            collection.objects.link(one)
            show_from(one, frame, frame + scene.frame_step)
        source.hide_render = source.hide_viewport = True
        scene.frame_set(before)
        return {"FINISHED"}


def register():
    bpy.utils.register_class(T4D_OT_bake)


def unregister():
    bpy.utils.unregister_class(T4D_OT_bake)

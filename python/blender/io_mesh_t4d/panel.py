"""Properties > Object Data > 4D Mesh."""

import textwrap

import bpy

SHOWN = ("path", "body", "start", "speed", "detail", "smooth", "attribute", "velocity", "max_speed")


class T4D_PT_mesh(bpy.types.Panel):
    bl_label = "4D Mesh"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return context.mesh and context.mesh.t4d.path

    def draw(self, context):
        layout, settings = self.layout, context.mesh.t4d
        layout.use_property_split = True
        for name in SHOWN:
            layout.prop(settings, name)
        for number, line in enumerate(textwrap.wrap(settings.message, 50)):
            layout.label(text=line, icon="BLANK1" if number else "ERROR")
        if not context.scene.render.use_lock_interface:
            layout.label(text="Turn on Render > Lock Interface to render", icon="ERROR")
        layout.operator("object.t4d_bake")


def register():
    bpy.utils.register_class(T4D_PT_mesh)


def unregister():
    bpy.utils.unregister_class(T4D_PT_mesh)

"""The settings of a mesh that shows a 4D mesh: `mesh.t4d`."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, PointerProperty, StringProperty

DETAILS = [
    ("EXACT", "Exact", "The section of the 4D mesh: up to 13 times the triangles of a swept solid"),
    ("LIGHT", "Light", "The triangles of a swept solid, at all frames the same, with the same volume"),
]
# Later Blenders want to be told that a path may begin with //.
RELATIVE = {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (5, 0, 0) else set()


def _changed(settings, context):
    from . import following

    following.follow(settings.id_data, context.scene)


class T4dSettings(bpy.types.PropertyGroup):
    path: StringProperty(
        name="File",
        description="The .t4d file",
        subtype="FILE_PATH",
        options=RELATIVE,
        update=_changed,
    )
    body: StringProperty(
        name="Body",
        description="Name of a body in the file; may be empty if there is only one",
        options=set(),
        update=_changed,
    )
    start: FloatProperty(
        name="Start",
        description="Frame that shows the first time of the file, or the last one if it plays backwards",
        default=1,
        options=set(),
        update=_changed,
    )
    speed: FloatProperty(
        name="Speed",
        description="How much of the 4D mesh's time passes in a second; negative: backwards",
        default=1,
        options=set(),
        update=_changed,
    )
    detail: EnumProperty(
        name="Slices", items=DETAILS, default="EXACT", options=set(), update=_changed
    )
    smooth: BoolProperty(name="Shade Smooth", default=False, options=set(), update=_changed)
    velocity: BoolProperty(
        name="Velocity",
        description="Write the attribute 'velocity', from which Cycles makes motion blur",
        default=True,
        options=set(),
        update=_changed,
    )
    max_speed: FloatProperty(
        name="Maximum Speed",
        description="Limit of velocities in length units of the 4D mesh per second; 0: none. "
        "Where surfaces merge, velocities grow without bound",
        default=0,
        min=0,
        options=set(),
        update=_changed,
    )
    attribute: StringProperty(
        name="Attribute",
        description="Attribute of the 4D mesh to write as the attribute 'color'; empty: none",
        options=set(),
        update=_changed,
    )
    message: StringProperty(options={"HIDDEN"})


def register():
    bpy.utils.register_class(T4dSettings)
    bpy.types.Mesh.t4d = PointerProperty(type=T4dSettings)


def unregister():
    del bpy.types.Mesh.t4d
    bpy.utils.unregister_class(T4dSettings)

"""4D meshes in Blender: an object whose mesh follows the frame, baked frames, and export by a sweep."""

bl_info = {
    "name": "4D mesh format (.t4d)",
    "description": "Import moving solids that are sliced at every frame, and export animated meshes",
    "author": "The t4d authors",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "File > Import-Export; Properties > Object Data > 4D Mesh",
    "category": "Import-Export",
}

from . import baking, exporting, following, importing, panel, settings

PARTS = (settings, following, importing, exporting, baking, panel)


def register():
    for part in PARTS:
        part.register()


def unregister():
    for part in reversed(PARTS):
        part.unregister()

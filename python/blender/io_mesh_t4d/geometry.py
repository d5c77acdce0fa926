"""Arrays of numpy to the geometry of a mesh in Blender."""

import bpy
import numpy as np

COLOR = "color"  # the name of the attribute


def fill(mesh, solid, smooth):
    """Replaces all geometry; materials stay."""
    count = len(solid.triangles)
    mesh.clear_geometry()
    mesh.vertices.add(len(solid.vertices))
    mesh.loops.add(3 * count)
    mesh.polygons.add(count)
    # Blender copies an array whole if its type is the very one of the property.
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    positions = solid.vertices.astype(np.float32).ravel()
    corners = solid.triangles.astype(np.int32).ravel()
    if bpy.app.version >= (4, 1, 0):
        mesh.attributes["position"].data.foreach_set("vector", positions)
        mesh.attributes[".corner_vert"].data.foreach_set("value", corners)
        (mesh.shade_smooth if smooth else mesh.shade_flat)()
    else:
        mesh.vertices.foreach_set("co", positions)
        mesh.loops.foreach_set("vertex_index", corners.view(np.uint32))
        mesh.polygons.foreach_set("loop_total", np.full(count, 3, dtype=np.int32))
        mesh.polygons.foreach_set("use_smooth", np.full(count, smooth))
    mesh.update(calc_edges=True)


def set_velocity(mesh, velocity):
    """Sets the velocity in units of the mesh per second, as Cycles expects it."""
    made = mesh.attributes.new("velocity", "FLOAT_VECTOR", "POINT")
    made.data.foreach_set("vector", velocity.astype(np.float32).ravel())


def set_color(mesh, values, domain):
    """A number for each vertex, triangle or corner as it is; three or four as colours."""
    if values.ndim == 1:
        made = mesh.attributes.new(COLOR, "FLOAT", domain)
        made.data.foreach_set("value", values.astype(np.float32))
        return
    colors = linear_colors(values)
    if domain == "FACE":  # Blender has colours of vertices and of corners only
        colors, domain = np.repeat(colors, 3, axis=0), "CORNER"
    made = mesh.color_attributes.new(COLOR, "FLOAT_COLOR", domain)
    made.data.foreach_set("color", colors.ravel())


def set_texture_coordinates(mesh, values, domain):
    """Sets texture coordinates, which belong to corners in Blender."""
    if domain == "POINT":
        corners = np.empty(len(mesh.loops), dtype=np.int32)
        mesh.loops.foreach_get("vertex_index", corners)
        values = values[corners]
    made = mesh.uv_layers.new(name="UVMap", do_init=False)
    made.data.foreach_set("uv", values.astype(np.float32).ravel())


def linear_colors(values):
    """(n, 3) or (n, 4) to linear red, green, blue and opacity: uint8 is sRGB, uint16 linear."""
    colors = np.ones((len(values), 4), dtype=np.float32)
    scale = {np.dtype(np.uint8): 255, np.dtype(np.uint16): 65535}.get(values.dtype, 1)
    colors[:, : values.shape[1]] = values / scale
    if values.dtype == np.uint8:
        rgb = colors[:, :3]
        colors[:, :3] = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return colors

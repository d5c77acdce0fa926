"""A material that shows an attribute of a 4D mesh."""

import bpy
import numpy as np

from .attributes import range_of
from .geometry import COLOR, linear_colors

# The colours go from dark blue to yellow (viridis), as in t4d flipbook.
RAMP = np.array([(68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 231, 37)], dtype=np.uint8)


def material(bodies, attribute, light):
    """Colours as they are; numbers by a ramp over their range in the whole motion."""
    limits = range_of(bodies, attribute, light)
    made = bpy.data.materials.new(attribute)
    if made.node_tree is None:  # before Blender 5
        made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    source = nodes.new("ShaderNodeAttribute")
    source.attribute_name = COLOR
    color = source.outputs["Color"]
    if limits:
        color = ramp(nodes, links, source.outputs["Fac"], limits)
    shader = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    links.new(color, shader.inputs["Base Color"])
    return made


def ramp(nodes, links, value, limits):
    scaled, colors = nodes.new("ShaderNodeMapRange"), nodes.new("ShaderNodeValToRGB")
    scaled.inputs["From Min"].default_value, scaled.inputs["From Max"].default_value = limits
    stops = colors.color_ramp.elements
    while len(stops) < len(RAMP):
        stops.new(0.5)
    for number, color in enumerate(linear_colors(RAMP)):
        stops[number].position, stops[number].color = number / (len(RAMP) - 1), color
    links.new(value, scaled.inputs["Value"])
    links.new(scaled.outputs["Result"], colors.inputs["Fac"])
    return colors.outputs["Color"]

"""Meshes that follow the frame of the scene: each is filled with the slice at its time."""

import sys

import bpy
import numpy as np
from bpy.app.handlers import persistent

from . import geometry
from .attributes import attribute_of, color_of
from .library import FAILURES, opened, remarks, sentence
from .recorder import Problem


def body_of(mesh):
    """(file, body) of the 4D mesh that a mesh of Blender shows."""
    settings = mesh.t4d
    whole = opened(bpy.path.abspath(settings.path, library=mesh.library))
    if settings.body:
        return whole, whole[settings.body]
    if len(whole) > 1:
        raise Problem(f"{settings.path} has several bodies, {', '.join(whole.names)}: name one")
    return whole, whole


def as_typed(value):
    """Blender keeps 0.1 as a float32, 0.10000000149; this is 0.1 again."""
    return float(str(np.float32(value)))


def moment(settings, scene, span):
    """The time of the 4D mesh at the scene's frame, and the speed there: before the first and after
    the last time of the file it stands still."""
    begin, end = span
    speed = as_typed(settings.speed)
    frames = scene.frame_current_final - as_typed(settings.start)
    seconds = frames * scene.render.fps_base / scene.render.fps
    time = (begin if speed >= 0 else end) + seconds * speed
    if begin <= time <= end:
        return time, speed
    return min(max(time, begin), end), 0.0


def slice_of(mesh, scene):
    """The solid at the scene's frame, or None if the body is not there, and the speed of playback."""
    settings = mesh.t4d
    whole, body = body_of(mesh)
    time, speed = moment(settings, scene, whole.time_span)
    begin, end = body.time_span
    if not begin <= time <= end:
        return None, speed
    options = {"light": settings.detail == "LIGHT"}
    if settings.velocity:
        options["velocity"] = True
        if settings.max_speed and speed:
            options["max_speed"] = as_typed(settings.max_speed) / abs(speed)
    return body.slice(time, **options), speed


def show(mesh, scene):
    """Fills a mesh with its slice."""
    settings = mesh.t4d
    solid, speed = slice_of(mesh, scene)
    if solid is None:
        mesh.clear_geometry()
        return
    light = settings.detail == "LIGHT"
    color = color_of(solid, settings.attribute, light) if settings.attribute else None
    geometry.fill(mesh, solid, settings.smooth)
    if settings.velocity:
        geometry.set_velocity(mesh, solid.vertex_attributes["velocity"] * speed)
    if color:
        geometry.set_color(mesh, *color)
    texture = attribute_of(solid, "uv", light)
    if texture:
        geometry.set_texture_coordinates(mesh, *texture)


def follow(mesh, scene):
    """Fills a mesh, or empties it and says why: what it showed before would be wrong."""
    settings = mesh.t4d
    if not settings.path or mesh.is_editmode:
        return
    try:
        with remarks() as found:
            show(mesh, scene)
        message = "; ".join(found)
    except FAILURES as failure:
        mesh.clear_geometry()
        message = sentence(failure)
    if message and message != settings.message:
        print(f"t4d: mesh '{mesh.name}': {message}", file=sys.stderr)
    settings.message = message


@persistent
def follow_all(scene, _=None):
    for mesh in bpy.data.meshes:
        if mesh.users:
            follow(mesh, scene)


@persistent
def follow_after_loading(*_):
    follow_all(bpy.context.scene)


HANDLERS = (
    (bpy.app.handlers.frame_change_post, follow_all),
    (bpy.app.handlers.load_post, follow_after_loading),
)


def register():
    for handlers, function in HANDLERS:
        handlers.append(function)


def unregister():
    for handlers, function in HANDLERS:
        handlers.remove(function)

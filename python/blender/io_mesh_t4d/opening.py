"""Files that Blender imports, as the current scene: importers, rates of frames, and where motions begin and end."""

from __future__ import annotations

import os
import re
import struct
from typing import Any, List, Optional, Tuple

import bpy
import numpy as np

from .recorder import Problem

# Where the operator that imports a file is not named after its extension.
NAMES = {"glb": "gltf", "dae": "collada", "abc": "alembic", "usda": "usd", "usdc": "usd", "usdz": "usd",
         "wrl": "x3d"}  # fmt: skip
IN_SECONDS = ("gltf", "collada")
RATES = (24, 25, 30, 48, 50, 60, 100, 120)  # frames per second that files are made with
ON_FRAME = 0.01  # closer to a whole frame, a time was one before it was rounded to float32 or milliseconds
FBX_SECOND = 46186158000
FBX_TIME = rb'Local%s(?:", "KTime", "Time", "\w*",\s*(-?\d+)|S.{4}KTimeS.{4}TimeS.{4}\w*L(.{8}))'


def open_file(path: str, fps: Optional[float] = None) -> None:
    """Makes a .blend, or a scene of what an importer makes of another file, the current scene. The rate is for files
    that do not say their own. Raises Problem if this Blender cannot."""
    extension = os.path.splitext(path)[1].lower().lstrip(".")
    try:
        if extension == "blend":
            bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=False)
            return
        name = NAMES.get(extension, extension)
        _import(path, name, fps or RATES[0])
        if name in IN_SECONDS and not fps and _rate_of_keys() != RATES[0]:
            _import(path, name, _rate_of_keys())
    except RuntimeError as error:
        lines = [line for line in str(error).splitlines() if line and line[0] not in " "]
        raised = (line for line in lines if re.match(r"\w+Error: ", line))  # the last line of what Python traces
        said = next(raised, lines[0])
        raise Problem(f"Blender {bpy.app.version_string} cannot read it: {said.removeprefix('Error: ')}") from None
    if not bpy.context.scene.objects:
        raise Problem(f"Blender {bpy.app.version_string} finds nothing in it")


def _import(path: str, name: str, fps: float) -> None:
    if "bool" not in vars(np):  # the importer of glTF in Debian 12's Blender is older than its numpy
        vars(np)["bool"] = np.bool_
    bpy.ops.wm.read_factory_settings(use_empty=True)
    render = bpy.context.scene.render
    render.fps, render.fps_base = round(fps), round(fps) / fps
    for group, operator in ("wm", f"{name}_import"), ("import_scene", name), ("import_mesh", name):
        if operator in dir(getattr(bpy.ops, group)):
            getattr(getattr(bpy.ops, group), operator)(filepath=path)
            return
    raise Problem(f"Blender {bpy.app.version_string} has no importer for it")


def _rate_of_keys() -> float:
    """The rate at which all keys of curves, imported at RATES[0], are at whole frames; RATES[0] if there is none."""
    curves = [curve for action in bpy.data.actions for curve in _curves_of(action)]
    times = np.array([key.co.x for curve in curves for key in curve.keyframe_points]) / RATES[0]
    fits = (rate for rate in RATES if np.abs(times * rate - np.rint(times * rate)).max(initial=0) < ON_FRAME)
    return next(fits, RATES[0])


def _curves_of(action: Any) -> List[Any]:
    if bpy.app.version < (5, 0, 0):
        return list(action.fcurves)
    bags = [bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags]
    return [curve for bag in bags for curve in bag.fcurves]


def notes_of(path: str) -> List[str]:
    """Notes on what Blender does not do as the file says."""
    if not path.lower().endswith(".fbx"):
        return []
    for curve in (curve for action in bpy.data.actions for curve in _curves_of(action)):
        keys = np.array([key.co for key in curve.keyframe_points])
        if ((np.diff(keys[:, 0]) > 1 + ON_FRAME) & (np.diff(keys[:, 1]) != 0)).any():
            return ["between two keys of an .fbx Blender moves along a straight line, whatever the curve in the file: "
                    "pip install ufbx reads it as it is, or bake the animation with a key at every frame"]  # fmt: skip
    return []


def span_of(path: str) -> Optional[Tuple[float, float]]:
    """The first and the last frame of the current scene, made of a file: those that a .blend or a cache says, those
    of the one take of an .fbx, otherwise those of the curves in use. None if nothing in it moves."""
    scene = bpy.context.scene
    if path.lower().endswith(".blend") or bpy.data.cache_files:
        return scene.frame_start, scene.frame_end
    spans: List[Tuple[float, float]] = []
    blocks = [*scene.objects, *(one.data for one in scene.objects if one.data), *bpy.data.shape_keys]
    for moved in [block.animation_data for block in blocks if block.animation_data]:
        if moved.action:
            spans.append(tuple(moved.action.frame_range))
        strips = [strip for track in moved.nla_tracks if not track.mute for strip in track.strips]
        spans += [(strip.frame_start, strip.frame_end) for strip in strips]
    if not spans:
        return None
    if path.lower().endswith(".fbx"):
        spans = _take_of(path) or spans
    ends = min(begin for begin, _ in spans), max(end for _, end in spans)
    return tuple(round(end) if abs(end - round(end)) < ON_FRAME else end for end in ends)


def _take_of(path: str) -> List[Tuple[float, float]]:
    """The frames of the take of an .fbx, text or binary, if it has one. Blender shows the file's time 0 at frame 1."""
    with open(path, "rb") as file:
        data = file.read()
    render = bpy.context.scene.render
    ends = []
    for which in (b"Start", b"Stop"):
        found = {int(text) if text else struct.unpack("<q", raw)[0]
                 for text, raw in re.findall(FBX_TIME % which, data, re.DOTALL)} - {0}  # fmt: skip
        if len(found) > 1:
            return []
        ends.append(1 + (found or {0}).pop() / FBX_SECOND * render.fps / render.fps_base)
    return [(ends[0], ends[1])] if ends[1] > ends[0] else []

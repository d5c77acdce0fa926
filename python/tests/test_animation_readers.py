"""Who reads an animation, and when sweep is one's door."""

import importlib.util
import shutil
import sys

import pytest

from t4d import scenes
from t4d.converted import animation_of, is_needed
from t4d.errors import Unsupported


def readers(monkeypatch, file, installed=(), program=None):
    """The names and modules of those that read a file."""
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: name in installed or None)
    monkeypatch.setattr(shutil, "which", lambda name: f"/bin/{name}" if name in installed else None)
    monkeypatch.setattr(scenes, "_addon", lambda: "addon.zip")
    return [(one.name, one.module, one.command[0]) for one in scenes.readers(file, program)]


def test_a_library_made_for_the_format_comes_before_blender(monkeypatch):
    everything = "ufbx", "pxr", "bpy", "blender"
    ufbx = [("ufbx", "t4d.fbx_scene", sys.executable)]
    pixar = [("usd-core", "t4d.usd_scene", sys.executable)]
    blenders = [("Blender", "io_mesh_t4d.recording", program) for program in (sys.executable, "/bin/blender")]
    for file, installed, found in (
        ("a.fbx", everything, ufbx),
        ("A.FBX", ["ufbx"], ufbx),
        ("a.fbx", ["pxr", "bpy", "blender"], blenders),
        ("a.usdz", everything, pixar),
        ("a.usda", ["ufbx", "blender"], blenders[1:]),
        ("a.abc", everything, blenders),
    ):
        assert readers(monkeypatch, file, installed) == found, file
    assert readers(monkeypatch, "a.fbx", everything, "blender") == blenders[1:]


def test_what_is_missing_is_named(monkeypatch):
    for file, said in (("a.fbx", "pip install ufbx, or bpy"), ("a.usd", "pip install usd-core, or bpy"),
                       ("a.abc", "pip install bpy, or a Blender: t4d-blender --blender PROGRAM"),
                       ("a.dae", "pip install pycollada, for what is at rest, or bpy before version 5")):  # fmt: skip
        with pytest.raises(Unsupported, match=said) as raised:
            readers(monkeypatch, file)
        assert f"{file}: Blender is not found" in str(raised.value)
    with pytest.raises(Unsupported, match="other is not found"):
        readers(monkeypatch, "a.fbx", ["ufbx"], "other")


def test_sweep_hands_over_animations_but_no_solid_that_a_motion_moves():
    for words, given in (
        ("walk.fbx -o walk.t4d", "walk.fbx -o walk.t4d"),
        ("--caps cone -o walk.t4d walk.FBX", "walk.FBX --caps cone -o walk.t4d"),
        ("shot.blend -o shot.t4d", "shot.blend -o shot.t4d"),
        ("bolt.fbx --motion screw.json -o bolt.t4d", None),
        ("bolt.fbx --motion=screw.json -o bolt.t4d", None),
        ("machine.glb -o machine.t4d", None),
        ("a.fbx b.fbx -o c.t4d", None),
        ("bolt.glb -o a.usda", None),
    ):
        assert animation_of(words.split()) == (given or "").split(), words


def test_scenes_are_inputs_but_no_outputs():
    for words, scene in (("part.fbx -o part.ply", True), ("a.t4d --tool=cutter.usdz -o b.t4d", True),
                         ("a.t4d --tool CUTTER.DAE -o b.t4d", True), ("a.t4d -o a.usda", False),
                         ("a.t4d --output a.usdz", False), ("a.t4d --output=a.usdz", False),
                         ("a.glb -o b.ply", False)):  # fmt: skip
        assert is_needed(words.split()) == scene, words

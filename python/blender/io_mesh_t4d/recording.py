"""Answers what t4d-blender asks of a Blender without a window."""

from __future__ import annotations

from typing import Any, Dict, List, Optional, Tuple

import bpy

from . import recorder
from .opening import notes_of, open_file, span_of
from .scene import Scene


class File(Scene):
    """The scene that Blender imports from a file."""

    def __init__(self, request: Dict[str, Any]) -> None:
        self.path = request["file"]
        open_file(self.path, request["fps"])
        super().__init__(bpy.context, request["objects"])

    def span(self) -> Optional[Tuple[float, float]]:
        return span_of(self.path)

    def notes(self) -> List[str]:
        return notes_of(self.path)


def record_file(request: Dict[str, Any]) -> None:
    recorder.record_file(request, File)

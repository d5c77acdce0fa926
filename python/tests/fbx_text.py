"""Writes .fbx files as text, version 7.4, for tests."""

import struct
from pathlib import Path

SECOND = 46186158000
CONSTANT, LINEAR, CUBIC = 2, 4, 8  # with user tangents: CUBIC + 0x400
WEIGHTS = 218434821  # of both tangents a third, packed
TIME_MODES = {30: 6, 24: 11, 25: 10}

CUBE = ([-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1],
        [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])  # fmt: skip


def numbers(name, values):
    values = list(values)
    return f"{name}: *{len(values)} {{ a: {','.join(format(value, '.17g') for value in values)} }}\n"


def bits(value):
    return struct.unpack("<i", struct.pack("<f", value))[0]


def properties(given):
    kinds = {float: '"Number", "", "A"', int: '"enum", "", ""', tuple: '"Vector3D", "Vector", "A"'}
    lines = []
    for name, value in given.items():
        values = value if isinstance(value, tuple) else (value,)
        lines.append(f'P: "{name}", {kinds[type(value)]},{",".join(map(str, values))}')
    return "Properties70: {\n" + "\n".join(lines) + "\n}\n"


class Scene:
    def __init__(self, fps=24, up="z", metres=1.0):
        self.fps, self.up, self.centimetres = fps, up, metres * 100
        self.objects, self.connections = [], []

    def add(self, node, name, kind="", body=""):
        """An object; its number."""
        number = 1000 + len(self.objects)
        self.objects.append(f'{node}: {number}, "{name}", "{kind}" {{\n{body}}}\n')
        return number

    def connect(self, child, parent, name=None):
        self.connections.append(f'C: "OO",{child},{parent}' if name is None else f'C: "OP",{child},{parent}, "{name}"')

    def model(self, name, kind="Null", parent=0, **given):
        model = self.add("Model", f"Model::{name}", kind, "Version: 232\n" + properties(given))
        self.connect(model, parent)
        return model

    def mesh(self, name, points, polygons, parent=0, layers="", **given):
        """The numbers of a model and of its geometry."""
        corners = [corner for polygon in polygons for corner in (*polygon[:-1], ~polygon[-1])]
        body = numbers("Vertices", points) + numbers("PolygonVertexIndex", corners) + "GeometryVersion: 124\n" + layers
        geometry = self.add("Geometry", "Geometry::", "Mesh", body)
        model = self.model(name, "Mesh", parent, **given)
        self.connect(geometry, model)
        return model, geometry

    def cube(self, name="Cube", **given):
        return self.mesh(name, *CUBE, **given)[0]

    def take(self, name, first, last):
        """A stack of seconds, and its base layer."""
        span = "".join(f'P: "{which}", "KTime", "Time", "",{round(time * SECOND)}\n'
                       for which, time in (("LocalStart", first), ("LocalStop", last)))  # fmt: skip
        stack = self.add("AnimationStack", f"AnimStack::{name}", "", "Properties70: {\n" + span + "}\n")
        return stack, self.layer(stack, "Base")

    def layer(self, stack, name, **given):
        layer = self.add("AnimationLayer", f"AnimLayer::{name}", "", properties(given))
        self.connect(layer, stack)
        return layer

    def curve(self, layer, target, name, axis, keys, kind=LINEAR, slopes=(), after=""):
        """Keys are values by their seconds; slopes, one for each, are per second."""
        node = self.add("AnimationCurveNode", f"AnimCurveNode::{name}", "", properties({axis: 0.0}))
        self.connect(node, layer)
        self.connect(node, target, name)
        slopes = [*(slopes or len(keys) * [0]), 0]
        data = [word for right, left in zip(slopes, slopes[1:]) for word in (bits(right), bits(left), WEIGHTS, 0)]
        body = ("Default: 0\nKeyVer: 4008\n" + numbers("KeyTime", (round(time * SECOND) for time in keys))
                + numbers("KeyValueFloat", keys.values()) + numbers("KeyAttrFlags", len(keys) * [kind])
                + numbers("KeyAttrDataFloat", data) + numbers("KeyAttrRefCount", len(keys) * [1]))  # fmt: skip
        if after:
            body += f"Post-Extrapolation: {{\nType: {after}\nRepetition: -1\n}}\n"
        curve = self.add("AnimationCurve", "AnimCurve::", "", body)
        self.connect(curve, node, axis)

    def skin(self, geometry, bones):
        """Bones are models, each with the vertices that it moves by their weights, and where it is at first."""
        deformer = self.add("Deformer", "Deformer::Skin", "Skin", "Version: 101\n")
        self.connect(deformer, geometry)
        for bone, (weights, (x, y, z)) in bones.items():
            to_bone = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -z, 1]
            of_bone = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1]
            cluster = self.add("Deformer", "SubDeformer::", "Cluster", "Version: 100\n"
                               + numbers("Indexes", weights) + numbers("Weights", weights.values())
                               + numbers("Transform", to_bone) + numbers("TransformLink", of_bone))  # fmt: skip
            self.connect(cluster, deformer)
            self.connect(bone, cluster)

    def shape(self, geometry, offsets):
        """The channel of a blend shape: offsets (x, y, z) by vertex."""
        body = ("Version: 100\n" + numbers("Indexes", offsets)
                + numbers("Vertices", (value for offset in offsets.values() for value in offset)))  # fmt: skip
        deformer = self.add("Deformer", "Deformer::", "BlendShape", "Version: 100\n")
        channel = self.add("Deformer", "SubDeformer::wide", "BlendShapeChannel",
                           "Version: 100\nDeformPercent: 0\n" + numbers("FullWeights", [100]))  # fmt: skip
        self.connect(deformer, geometry)
        self.connect(channel, deformer)
        self.connect(self.add("Geometry", "Geometry::wide", "Shape", body), channel)
        return channel

    def save(self, path):
        up = {"y": (1, 1, 2, 1), "z": (2, 1, 1, -1)}[self.up]
        axes = {"UpAxis": up[0], "UpAxisSign": up[1], "FrontAxis": up[2], "FrontAxisSign": up[3],
                "CoordAxis": 0, "CoordAxisSign": 1, "UnitScaleFactor": float(self.centimetres),
                "TimeMode": TIME_MODES[self.fps]}  # fmt: skip
        Path(path).write_text(
            "; FBX 7.4.0 project file\nFBXHeaderExtension: {\nFBXHeaderVersion: 1003\nFBXVersion: 7400\n}\n"
            + "GlobalSettings: {\nVersion: 1000\n" + properties(axes) + "}\nObjects: {\n" + "".join(self.objects)
            + "}\nConnections: {\n" + "\n".join(self.connections) + "\n}\n", encoding="utf-8")  # fmt: skip
        return path

"""What all classes of inputs share: the seeds, the folder of a run, and how to make a run.

A class is a function that takes the Attack and returns a Run; `input_class` registers it.
"""

import contextlib
import gzip
import json
import os
import re
import socket
import struct
import subprocess
import sys
import threading
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
BASE_SECONDS = 40  # TetGen's own limit is 30
BASE_BYTES = 1_500_000_000
BYTES_PER_BYTE = 20_000

CLASSES = {}  # by name, in the order of the topics


class InputClass:
    def __init__(self, make, weight):
        self.name = make.__name__
        self.make = make
        self.weight = weight
        self.description = " ".join(make.__doc__.split())


def input_class(weight):
    """Registers a class of inputs; `weight` is how many of 100 runs are of it. Its docstring says
    which inputs it makes, and what is judged of them if that is more than usual."""
    def register(make):
        CLASSES[make.__name__] = InputClass(make, weight)
        return make
    return register


class Run:
    """One command, its inputs and what it may leave behind."""

    def __init__(self, arguments, inputs=(), output=None, must_fail=False, expect=None, check=None,
                 seconds=BASE_SECONDS, most_bytes=None, stdin=os.devnull):
        self.arguments = [str(a) for a in arguments]
        self.inputs = [Path(i) for i in inputs]
        self.output = Path(output) if output else None
        self.must_fail = must_fail
        self.expect = expect  # a set of exit codes
        self.check = check  # of the Result, whatever it is: a list of problems
        self.seconds = seconds
        self.most_bytes = most_bytes  # by default in proportion to the inputs
        self.stdin = stdin


def cells_of_cube():
    """A cube as two wedges, as the text of a .vtu."""
    def array(name, kind, values):
        return f'<DataArray type="{kind}" {name} format="ascii">{values}</DataArray>\n'
    points = " ".join(f"{i & 1} {i >> 1 & 1} {i >> 2}" for i in range(8))
    return ('<VTKFile type="UnstructuredGrid"><UnstructuredGrid>\n'
            '<Piece NumberOfPoints="8" NumberOfCells="2"><Points>\n'
            + array('NumberOfComponents="3"', "Float64", points) + "</Points><Cells>\n"
            + array('Name="connectivity"', "Int64", "0 1 2 4 5 6 1 3 2 5 7 6")
            + array('Name="offsets"', "Int64", "6 12") + array('Name="types"', "UInt8", "13 13")
            + "</Cells></Piece></UnstructuredGrid></VTKFile>\n")


class Result:
    """The exit code of a command, and its output."""

    def __init__(self, code, out, err):
        self.code = code  # None after a signal
        self.out = out
        self.err = err

    @property
    def succeeded(self):
        return self.code in (0, 3)

    @property
    def json(self):
        """The output of --json; None if nothing was printed."""
        return json.loads(self.out) if self.out else None


class Attack:
    def __init__(self, program, folder):
        self.program = str(program)
        self.folder = folder  # for all runs
        self.seeds = {}  # files by kind
        self.commands = []  # those of make_commands
        self.rng = None  # of this run
        self.scene = None  # the folder of this run
        self.ending = contextlib.ExitStack()  # what to do after this run

    def begin(self, rng, name):
        self.rng = rng
        self.scene = self.folder / name
        self.scene.mkdir()

    # Seeds ----------------------------------------------------------------------------------

    def make_seeds(self):
        seeds = self.folder / "seeds"
        subprocess.run([str(Path(self.program).parent / "t4d-fixtures"), seeds], check=True,
                       stdout=subprocess.DEVNULL)
        motion = seeds / "skew-axis.json"
        self.make_seed("sweep", seeds / "cube.obj", "-m", motion, "-o", seeds / "mesh.t4d")
        self.make_seed("sweep", seeds / "cube.obj", "-m", motion, "--backend", "voxel4d",
                       "--voxel-size", 4, "--frames", 3, "-o", seeds / "voxel.t4d")
        self.make_seed("sweep", seeds / "torus.obj", "-m", motion, "--compression", 0, "--steps", 2,
                       "-o", seeds / "plain.t4d")
        self.make_seed("transform", seeds / "mesh.t4d", "--move", 5, 1, 2, "-o",
                       seeds / "moved.t4d")
        for part in (1, 2, 3):
            self.make_seed("sweep", seeds / "cube.obj", "-m", motion, "--part", f"{part}/3", "-o",
                           seeds / f"part{part}.t4d")
        (seeds / "corner.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                          "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        self.make_seed("sweep", seeds / "corner.obj", "-m", seeds / "screw-in.json", "--steps", 4000,
                       "-o", seeds / "paged.t4d")
        self.make_seed("voxelize", seeds / "cube.obj", "-m", motion, "--voxel-size", 4, "--frames",
                       2, "-o", seeds / "frames")
        for extension in ("stl", "ply", "glb", "gltf", "obj", "vtp"):
            self.make_seed("slice", seeds / "mesh.t4d", "-t", 0, "-o", seeds / f"slice.{extension}")
        self.make_seed("frames", seeds / "mesh.t4d", "-n", 3, "--light", "-o", seeds / "vtp/a_%d.vtp")
        (seeds / "cells.vtu").write_text(cells_of_cube())
        binary = {"vtu": "vtu", "msh": "gmshb", "meshb": "meditb", "g4b": "g4b"}
        for extension, form in binary.items():
            self.make_seed("convert", seeds / "mesh.t4d", seeds / f"mesh4d.{extension}", "--to",
                           form, "--accept-loss")
        self.seeds = {
            "cube": [seeds / "cube.obj"],
            "obj": sorted(seeds.glob("*.obj")),
            "real": [path for path in sorted((ROOT.parent / "shared/meshes").glob("*.obj"))
                     if path.stat().st_size < 300_000 and self.is_swept(path)],
            "mesh": [seeds / f"slice.{e}" for e in ("stl", "ply", "glb", "gltf", "obj", "vtp")]
                    + [seeds / "cells.vtu"],
            "mesh4d": [seeds / f"mesh4d.{e}" for e in binary],
            "motion": sorted(p for p in seeds.glob("*.json") if "bodies" not in p.read_text()),
            "t4d": [seeds / f"{name}.t4d" for name in ("mesh", "plain", "voxel")],
            "moved": [seeds / "moved.t4d"],  # mesh.t4d elsewhere
            "parts": [seeds / f"part{part}.t4d" for part in (1, 2, 3)],
            "paged": [seeds / "paged.t4d"],  # of 20,000 slabs
            "vdb": sorted((seeds / "frames").glob("*.vdb")),
        }
        self.make_commands(seeds)

    def make_seed(self, *arguments):
        made = self.t4d(*arguments)
        if not made.succeeded:
            print(f"no seed of: t4d {' '.join(map(str, arguments))}\n  {made.err.strip()}",
                  file=sys.stderr)

    def is_swept(self, mesh):
        """Some real meshes are open."""
        seeds = self.folder / "seeds"
        return self.t4d("sweep", mesh, "-m", seeds / "rest.json", "--caps", "cone", "-o",
                        self.folder / "swept.t4d").succeeded

    def make_commands(self, seeds):
        """A command of each verb for each kind of file that it reads; each of them succeeds. OUT is
        the output."""
        cube, motion = self.seeds["cube"][0], seeds / "skew-axis.json"
        mesh, plain, _ = self.seeds["t4d"]
        moved = self.seeds["moved"][0]
        for extension in ("vtu", "msh", "mesh", "meshb", "4do", "g4tf", "g4b", "off", "node"):
            self.make_seed("convert", plain, seeds / f"converted.{extension}", "--accept-loss")
        self.make_seed("transform", mesh, "--move", 50, 0, 0, "-o", seeds / "aside.t4d")
        self.make_seed("filter", mesh, "--to", 1, "-o", seeds / "first.t4d")
        self.make_seed("filter", mesh, "--from", 1, "-o", seeds / "last.t4d")
        self.make_seed("flipbook", mesh, "-n", 2, "-o", seeds / "animated.glb")
        self.make_seed("frames", mesh, "-n", 3, "--format", "stl", "-o", seeds / "layers")
        (seeds / "poses.csv").write_text(
            "time,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n1,1,0,0,0,0,0,1\n")
        (seeds / "path.nc").write_text("G21 G90\nG0 X0 Y0 Z30\nG1 X1 F600\n")
        (seeds / "path.cl").write_text("FEDRAT/600\nGOTO/0,0,30,0,0,1\nGOTO/1,0,30,0,0,1\n")
        values = b"".join(struct.pack("<f", 1 - 2 * (i % 64 in (21, 22, 25, 26, 37, 38, 41, 42)))
                          for i in range(128))
        (seeds / "volume.samples").write_bytes(values)
        (seeds / "volume.raw").write_bytes(b"raw float32 4 4 4 2 little\n" + values)
        header = (b"{'descr': '<f4', 'fortran_order': False, 'shape': (2, 4, 4, 4), }").ljust(117)
        (seeds / "volume.npy").write_bytes(
            b"\x93NUMPY\x01\x00" + struct.pack("<H", 118) + header + b"\n" + values)
        nrrd = ("NRRD0005\ntype: float\ndimension: 4\nsizes: 4 4 4 2\nencoding: raw\n"
                "endian: little\nspacings: 1 1 1 1\nkinds: domain domain domain time\n")
        (seeds / "volume.nrrd").write_bytes(nrrd.encode() + b"\n" + values)
        (seeds / "volume.nhdr").write_text(nrrd + "data file: volume.samples\n")
        nifti = bytearray(352)
        struct.pack_into("<i", nifti, 0, 348)
        struct.pack_into("<8h", nifti, 40, 4, 4, 4, 4, 2, 1, 1, 1)
        struct.pack_into("<2h", nifti, 70, 16, 32)
        struct.pack_into("<8f", nifti, 76, 1, 1, 1, 1, 1, 0, 0, 0)
        struct.pack_into("<f", nifti, 108, 352)
        nifti[344:348] = b"n+1\0"
        (seeds / "volume.nii").write_bytes(bytes(nifti) + values)
        (seeds / "volume.nii.gz").write_bytes(gzip.compress(bytes(nifti) + values))
        struct.pack_into("<f", nifti, 108, 0)
        nifti[344:348] = b"ni1\0"
        (seeds / "pair.hdr").write_bytes(nifti[:348])
        (seeds / "pair.img").write_bytes(values)
        corners = [[float(c) for c in line.split()[1:4]] for line in cube.read_text().splitlines()
                   if line.startswith("v ")]
        numbers = [c + moved for moved in (0, 1) for corner in corners for c in corner]
        (seeds / "cache.pc2").write_bytes(
            b"POINTCACHE2\0" + struct.pack("<2i2fi", 1, len(corners), 0, 1, 2)
            + struct.pack(f"<{len(numbers)}f", *numbers))
        (seeds / "cache.mdd").write_bytes(
            struct.pack(">2i2f", 2, len(corners), 0, 1)
            + struct.pack(f">{len(numbers)}f", *numbers))
        (seeds / "arm.srdf").write_text(
            '<robot name="arm"><disable_collisions link1="a" link2="b" reason="Never"/></robot>')
        meshes = sorted((seeds / "layers").glob("*.stl"))
        mill = ["mill", cube, "--tool", "flat:d=6,l=30", "--voxel-size", 4]
        weave = ["weave", "--frame-time", 1, "-o", "OUT.t4d"]
        commands = [[verb, mesh] for verb in (
            "info", "validate", "quality", "du", "cat", "envelope --voxel-size 5")]
        commands += [
            ["slice", mesh, "-t", 0.1], ["slice", mesh, "-t", 0.1, "-o", "OUT.ply"],
            ["flipbook", mesh, "-n", 2, "-o", "OUT.glb"],
            ["frames", mesh, "-n", 2, "-o", "OUT"], ["recover", mesh, "-o", "OUT.t4d"],
            ["rasterize", mesh, "--voxel-size", 5, "--frames", 2, "-o", "OUT"],
            ["compare", mesh, mesh, "--slices", 2], ["diff", mesh, mesh],
            ["transform", mesh, "--move", 1, 0, 0, "-o", "OUT.t4d"],
            ["filter", mesh, "--from", 0.1, "-o", "OUT.t4d"], ["filter", mesh, "--track", 1, "-o", "OUT.t4d"],
            ["track", mesh, "-o", "OUT.svg"], ["track", mesh, "--contacts", "OUT.csv"],
            ["track", mesh, "--ctc", "OUT", "--spacing", 5],
            ["compress", mesh, "-o", "OUT.t4d"],
            ["join", seeds / "first.t4d", seeds / "last.t4d", "-o", "OUT.t4d"],
            ["merge", mesh, moved, "-o", "OUT.t4d"],
            ["collide", mesh, moved], ["collide", mesh, moved, "--ignore", seeds / "arm.srdf"],
            ["resolve", mesh, seeds / "aside.t4d", "-o", "OUT.t4d"],
            ["view", mesh, "-o", "OUT"],
            ["convert", mesh, "OUT.vtu"],
            ["sweep", cube, "-m", seeds / "poses.csv", "--steps", 1, "-o", "OUT.t4d"],
            ["sweep", cube, seeds / "cache.pc2", "-o", "OUT.t4d"],
            ["sweep", cube, seeds / "cache.mdd", "-o", "OUT.t4d"],
            ["sweep", seeds / "animated.glb", "-o", "OUT.t4d"],
            ["flipbook", mesh, "-n", 2, "-o", "OUT.usda"],
            ["voxelize", cube, "-m", motion, "--voxel-size", 5, "--frames", 2, "-o", "OUT"],
            ["mend", cube, "-o", "OUT.obj"],
            ["compare", cube, "-m", motion, "--voxel-size", 5, "--slices", 2],
            [*mill, "-m", motion, "-o", "OUT.t4d"],
            [*mill, "--gcode", seeds / "path.nc", "-o", "OUT.t4d"],
            [*mill, "--locations", seeds / "path.cl", "-o", "OUT.t4d"],
            ["mill", cube, "--tool", cube, "--holder", seeds / "slice.stl", "--shank",
             seeds / "slice.ply", "-m", motion, "--voxel-size", 4, "-o", "OUT.t4d"],
            [*weave, *self.seeds["vdb"]], [*weave, *meshes, "--voxel-size", 5],
            [*weave, seeds / "vtp/a.pvd", "--voxel-size", 5],
            ["sweep", seeds / "vtp/a.pvd", "-o", "OUT.t4d"],
        ]
        commands += [["sweep", file, "-m", motion, "--steps", 1, "-o", "OUT.t4d"]
                     for file in self.seeds["mesh"]]
        commands += [["convert", file, "OUT.t4d"] for file in sorted(seeds.glob("converted.*"))]
        commands += [[*weave, file] for file in
                     [*sorted(seeds.glob("volume.n*")), seeds / "volume.raw", seeds / "pair.hdr"]]
        self.commands = [[*verb.split(), *map(str, rest)] for verb, *rest in commands]

    # Tools of the classes -------------------------------------------------------------------

    def path(self, name):
        return self.scene / name

    def pick(self, kind):
        return self.rng.choice(self.seeds[kind])

    def t4d(self, *arguments, seconds=3 * BASE_SECONDS):
        """Runs the program to make an input, or to look at an output."""
        done = subprocess.run([self.program, *map(str, arguments)], stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, errors="replace", check=False,
                              timeout=seconds)
        return Result(done.returncode if done.returncode >= 0 else None, done.stdout, done.stderr)

    def extreme(self):
        """A number at an end of floating point, or one that people type."""
        rng = self.rng
        return rng.choice([
            0.0, -0.0, 1.0, -1.0, 0.1, 0.7, 1e-5, 1e-20, 1e-62, 1e-150, 1e-308, 5e-324, 1e5, 5e6,
            1e11, 1e16, 1e20, 1e39, 1e60, 1e80, 1e150, 1e300, 1.7976931348623157e308,
            rng.uniform(-1, 1) * 10 ** rng.uniform(-300, 300)])

    def altered(self, source, name):
        """A copy with flipped bits, a cut, an overwritten or a repeated part."""
        rng = self.rng
        data = bytearray(source.read_bytes())
        kind = rng.randrange(5)
        at = rng.randrange(len(data))
        if kind == 0:
            for _ in range(rng.choice([1, 1, 2, 8])):
                data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
        elif kind == 1:
            del data[at:]
        elif kind == 2:
            end = min(len(data), at + rng.choice([1, 4, 8, 64]))
            data[at:end] = bytes(rng.choice([0, 0xFF, rng.randrange(256)]) for _ in range(end - at))
        elif kind == 3:
            end = min(len(data), at + rng.randrange(1, 200))
            data[at:at] = data[at:end]
        else:
            del data[at:at + rng.randrange(1, 100)]
        path = self.path(name)
        path.write_bytes(data)
        return path, bytes(data) != source.read_bytes()

    def altered_text(self, source, name):
        """A copy of a text with a number, word or line replaced."""
        rng = self.rng
        text = source.read_text(errors="replace")
        numbers = list(re.finditer(r"-?\d+(\.\d+)?([eE][-+]?\d+)?", text))
        spot = rng.choice(numbers)
        new = rng.choice([repr(self.extreme()), "nan", "inf", "-1", "1e999", "4294967296", "",
                          "\x1b[31m", "\u00e9", "0x10", "9" * 400])
        path = self.path(name)
        path.write_text(text[:spot.start()] + new + text[spot.end():])
        return path

    def make_odd(self, path, kind, content=b""):
        """Makes what is no ordinary file; `content` goes through a pipe that is fed."""
        if kind in ("fifo", "fed"):
            os.mkfifo(path)
            if kind == "fed":
                self.feed(path, content)
        elif kind == "folder":
            path.mkdir()
        elif kind == "empty":
            path.touch()
        elif kind == "socket":
            socket.socket(socket.AF_UNIX).bind(str(path))
        elif kind != "missing":
            path.symlink_to({"zeros": "/dev/zero", "null": "/dev/null", "loop": path,
                             "unreadable": "/proc/self/mem", "dangling": "/missing"}[kind])

    def feed(self, pipe, content):
        """Writes into a pipe as soon as somebody reads it, and as long."""
        def write():
            try:
                pipe.write_bytes(content)
            except OSError:
                pass  # nobody reads on, or the pipe is gone
        threading.Thread(target=write, daemon=True).start()

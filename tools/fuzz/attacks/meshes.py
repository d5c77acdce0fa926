"""Meshes of the formats of other programs."""

import lzma
import shutil
import struct
import zlib

from .attack import Run, input_class


def scaled(attack, source, scale, offset):
    lines = []
    for line in source.read_text().splitlines():
        if line.startswith("v "):
            line = "v " + " ".join(repr(float(c) * scale + offset) for c in line.split()[1:4])
        lines.append(line)
    path = attack.path("scaled.obj")
    path.write_text("\n".join(lines) + "\n")
    return path


def extent(mesh):
    points = [[float(c) for c in line.split()[1:4]] for line in mesh.read_text().splitlines()
              if line.startswith("v ")]
    return max(max(axis) - min(axis) for axis in zip(*points))


@input_class(weight=6)
def numbers(attack):
    """solids scaled and moved to the ends of floating point, swept by either backend, as float32,
    centred"""
    rng = attack.rng
    mesh = scaled(attack, attack.pick("obj"), abs(attack.extreme()) or 1,
                       rng.choice([0, 0, attack.extreme()]))
    output = attack.path("out.t4d")
    # Hundreds of voxels across are much work, rightly; far more are refused.
    voxel, size = abs(attack.extreme()) or 1, extent(mesh)
    if 100 < size / voxel < 1e5:
        voxel = size / 100
    options = rng.choice([[], ["--caps", "cone"], ["--precision", "float32"],
                          ["--precision", "float32", "--center"],
                          ["--backend", "voxel4d", "--frames", "2", "--voxel-size", repr(voxel)]])
    motion = attack.pick("motion")
    return Run(["sweep", mesh, "-m", motion, "--steps", 2, *options, "-o", output]
               if "--backend" not in options
               else ["sweep", mesh, "-m", motion, *options, "-o", output],
               [mesh, motion], output)


@input_class(weight=6)
def meshes(attack):
    """STL, PLY, GLB, glTF, OBJ, .vtp and .vtu with flipped bits, cuts, overwritten, doubled or missing parts"""
    source = attack.pick("mesh")
    mesh, _ = attack.altered(source, "mesh" + source.suffix)
    output = attack.path("out.t4d")
    motion = attack.pick("motion")
    return Run(["sweep", mesh, "-m", motion, "--steps", 1, "-o", output], [mesh, motion],
               output)


@input_class(weight=6)
def texts(attack):
    """motions, OBJ and glTF with a number replaced by another, a word, an escape code or nothing"""
    output = attack.path("out.t4d")
    if attack.rng.random() < 0.5:
        mesh, motion = attack.pick("obj"), attack.altered_text(attack.pick("motion"), "motion.json")
    else:
        mesh = attack.altered_text(attack.seeds["mesh"][attack.rng.choice([3, 4])], "x")
        mesh = mesh.rename(attack.path("mesh.gltf" if mesh.read_text().startswith("{")
                                     else "mesh.obj"))
        motion = attack.pick("motion")
    return Run(["sweep", mesh, "-m", motion, "--steps", 1, "-o", output], [mesh, motion],
               output)


@input_class(weight=1)
def collections(attack):
    """.pvd, the text of a .vtu, or a .vtp that one lists, with a number replaced or bits flipped,
    swept and woven"""
    rng = attack.rng
    folder = attack.scene / "vtp"
    shutil.copytree(attack.folder / "seeds/vtp", folder)
    listed = folder / "a.pvd"
    kind = rng.choice(["list", "mesh", "grid"])
    if kind == "list":
        attack.altered_text(listed, "a.pvd").replace(listed)
    elif kind == "mesh":
        attack.altered(folder / "a_1.vtp", "a_1.vtp")[0].replace(folder / "a_1.vtp")
    else:
        attack.altered_text(attack.folder / "seeds/cells.vtu", "a.vtu").replace(folder / "a.vtu")
        text = listed.read_text()
        listed.write_text(text.replace("a_1.vtp", "a.vtu"))
    output = attack.path("out.t4d")
    command = rng.choice([["sweep", listed], ["weave", listed, "--voxel-size", 5]])
    return Run([*command, "-o", output], sorted(folder.iterdir()), output)


@input_class(weight=1)
def bombs(attack):
    """`.vtu` whose compressed arrays are large, as 4D meshes and as surfaces, and binary Gmsh, Medit and G4MF with other
    counts"""
    rng = attack.rng
    if rng.random() < 0.3:
        source = rng.choice(attack.seeds["mesh4d"])
        data = bytearray(source.read_bytes())
        at = rng.randrange(max(1, len(data) - 8))
        count = rng.choice([2 ** 31 - 1, 2 ** 32 - 1, 2 ** 40, 10 ** 8])
        data[at:at + 8] = count.to_bytes(8, "little")
        path = attack.path("bomb" + source.suffix)
        path.write_bytes(data)
        return Run(["convert", path, attack.path("out.t4d")], [path], attack.path("out.t4d"),
                   most_bytes=700_000_000)
    surface = rng.random() < 0.5
    points = rng.choice([10 ** 6, 2 * 10 ** 7, 10 ** 8])
    cells = rng.choice([5, 10 ** 6, 10 ** 8])
    name, pack = rng.choice([
        ("vtkZLibDataCompressor", lambda b: zlib.compress(b, 9)),
        ("vtkLZMADataCompressor", lambda b: lzma.compress(b))])
    block = 1 << 25
    packed = {}  # of a whole block and of the last

    def array(kind, label, size, fill=0, more=""):
        blocks = (size + block - 1) // block
        last = size % block
        data = b""
        sizes = []
        for i in range(blocks):
            length = last if last and i + 1 == blocks else block
            if (length, fill) not in packed:
                packed[length, fill] = pack(bytes([fill]) * length)
            sizes.append(len(packed[length, fill]))
            data += packed[length, fill]
        head = struct.pack(f"<{3 + blocks}Q", blocks, block, last, *sizes)
        offset = len(appended)
        appended.extend(head + data)
        return (f'<DataArray type="{kind}" Name="{label}"{more} format="appended" '
                f'offset="{offset}"/>')
    appended = bytearray()
    lie = rng.choice([1, 1, 2])
    text = (f'<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
            f'header_type="UInt64" compressor="{name}"><UnstructuredGrid>'
            f'<Piece NumberOfPoints="{points}" NumberOfCells="{cells}"><PointData>'
            + array("Float64", "t", 8 * points // lie) + "</PointData><Points>"
            + array("Float64", "Points", 24 * points, more=' NumberOfComponents="3"')
            + "</Points><Cells>" + array("Int64", "connectivity", 32 * cells)
            + array("Int64", "offsets", 8 * cells // lie)
            + array("UInt8", "types", cells, 10)
            + '</Cells></Piece></UnstructuredGrid><AppendedData encoding="raw">_')
    path = attack.path("bomb.vtu")
    path.write_bytes(text.encode() + bytes(appended) + b"</AppendedData></VTKFile>")
    size = path.stat().st_size
    output = attack.path("out.ply" if surface else "out.t4d")
    return Run(["mend", path, "-o", output] if surface else ["convert", path, output], [path],
               output, expect={4}, most_bytes=700_000_000 + 2_000 * size)

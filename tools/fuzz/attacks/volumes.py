"""Volumes: frames of voxels, and four-dimensional arrays of samples."""

import gzip
import json
import math
import struct

from .attack import Run, input_class

# Letter of `struct`, names in NRRD and NumPy, and number in NIfTI.
SAMPLE_TYPES = {"uint8": ("B", "uchar", "u1", 2), "int16": ("h", "short", "i2", 4),
                "float32": ("f", "float", "f4", 16), "float64": ("d", "double", "f8", 64)}


def region(rng):
    """A `--region`, often one that the frames do not have."""
    if rng.random() < 0.1:
        return rng.choice(["", ",,", ":,:", "1,2,3", "0:9:2,:,:", "5:5,:,:", "1e9:,:,:", ":,:,:,1:2"])

    def end():
        return rng.choice(["", "", 0, 1, 2, 3, 5, 6, -1, -20, 2**31, 2**63 - 1, -2**63, 2**64])

    return ",".join(f"{end()}:{end()}" for _ in range(rng.choice([3, 3, 4])))


@input_class(weight=6)
def vdb(attack):
    """`.vdb` with flipped bits, cuts, overwritten, doubled or missing parts"""
    source = attack.pick("vdb")
    file, _ = attack.altered(source, "frame.vdb")
    other = attack.rng.choice(attack.seeds["vdb"])
    output = attack.path("out.t4d")
    part = [f"--region={region(attack.rng)}"] if attack.rng.random() < 0.3 else []
    return Run(["weave", file, other, "--frame-time", "1", *part, "-o", output], [file, other], output)


def samples(kind, order, sizes):
    """A ball that moves, 100 inside and -100 outside, with the axes in this order, the first
    fastest."""
    letter = SAMPLE_TYPES[kind][0]
    values = []
    for i in range(math.prod(sizes[a] for a in order)):
        at = {}
        for axis in order:
            i, at[axis] = divmod(i, sizes[axis])
        x, y, z, t = (at.get(a, 0) for a in "xyzt")
        inside = (x - 2 - t / 4) ** 2 + (y - 2) ** 2 + (z - 2) ** 2 < 3
        values.append(100 if inside else 0 if kind == "uint8" else -100)
    return struct.pack(f"<{len(values)}{letter}", *values)


def npy(data, descr, shape, fortran="True"):
    head = f"{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(head)) + head.encode() + data


def volume(attack, number):
    """A volume in one of the formats; `number` gives the numbers of its header from those of a
    volume at the origin, and whether they are a position."""
    rng = attack.rng
    sizes = {"x": 6, "y": 5, "z": 5, "t": 3}
    kind = rng.choice(list(SAMPLE_TYPES))
    _, nrrd, letters, nifti = SAMPLE_TYPES[kind]
    order = "".join(rng.sample("xyzt", 4)) if rng.random() < 0.5 else "xyzt"
    form = rng.choice(["nrrd", "nrrd", "nhdr", "npy", "nii", "nii.gz", "hdr", "raw"])
    if form not in ("nrrd", "nhdr", "npy"):
        order = "xyzt"
    data = samples(kind, order, sizes)
    path = attack.path(f"volume.{form}")
    options = ["--iso", 50, "--between", rng.choice(["distance", "midpoint"])]
    if rng.random() < 0.3:
        options.append(f"--region={region(rng)}")
    if form in ("nrrd", "nhdr"):
        packing = rng.choice(["raw", "gzip"])
        steps = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
        directions = " ".join(
            "none" if a == "t" else f"({','.join(number(c) for c in steps[a])})" for a in order)
        head = [f"type: {nrrd}", "dimension: 4",
                f"sizes: {' '.join(str(sizes[a]) for a in order)}",
                f"space: {rng.choice(['RAS', 'LPS', 'left-anterior-superior', '3D-left-handed'])}",
                f"space directions: {directions}",
                f"space origin: ({','.join(number(0, True) for _ in 'xyz')})",
                f"spacings: {' '.join(number(0.5) if a == 't' else 'nan' for a in order)}",
                f"encoding: {packing}", "endian: little"]
        if rng.random() < 0.2:
            del head[3:6]
            head[3] = "spacings: " + " ".join(number(0.5 if a == "t" else 1) for a in order)
        if rng.random() < 0.2:
            at = rng.randrange(len(head))
            head[at] = rng.choice([head[at].upper(), head[at].replace(": ", ":"), head[at] * 2,
                                   head[at].replace("e", "\u00e9"), head[at].split(":")[0] + ": "])
        packed = gzip.compress(data) if packing == "gzip" else data
        if form == "nhdr":
            head.append("data file: volume.raw")
            attack.path("volume.raw").write_bytes(packed)
        path.write_bytes(("NRRD0005\n" + "\n".join(head) + "\n\n").encode()
                         + (packed if form == "nrrd" else b""))
    elif form == "npy":
        path.write_bytes(npy(data, f"<{letters}", tuple(sizes[a] for a in order)))
        options += ["--axes", order, f"--frame-time={number(0.5)}"]
    elif form == "raw":
        path.write_bytes(f"raw {kind} 6 5 5 3 little\n".encode() + data)
        options += [f"--spacing={number(1)}", "--origin", *(number(0, True) for _ in "xyz"),
                    f"--frame-time={number(0.5)}"]
    else:
        head = bytearray(352)
        def put(at, form, *values):
            try:
                struct.pack_into("<" + form, head, at, *values)
            except (OverflowError, struct.error):
                pass  # too large for a float32
        put(0, "i", 348)
        put(40, "8h", 4, 6, 5, 5, 3, 1, 1, 1)
        put(70, "2h", nifti, 8 * struct.calcsize(SAMPLE_TYPES[kind][0]))
        put(76, "8f", 1, *(float(number(1)) for _ in "xyz"), float(number(0.5)), 0, 0, 0)
        put(108, "f", 0 if form == "hdr" else 352)
        code = rng.choice([0, 1, 2])
        put(252, "2h", int(code == 1), int(code == 2))
        put(268, "3f", *(float(number(0, True)) for _ in "xyz"))
        for row in range(3):
            put(280 + 16 * row, "4f", *(float(number(int(row == i), i == 3)) for i in range(4)))
        head[344:347] = b"ni1" if form == "hdr" else b"n+1"
        whole = bytes(head) + (b"" if form == "hdr" else data)
        path.write_bytes(gzip.compress(whole) if form == "nii.gz" else whole)
        if form == "hdr":
            attack.path("volume.img").write_bytes(data)
    return path, options


NAME = "standard input"  # which messages have
ANYTHING = [None, True, False, 0, -1, 1, 3, 1.5, 2**31, 2**63, 2**64, 1e308, "", NAME, NAME + "\x1b[31m", [], [[]],
            [1, 2], [None], [2**40] * 3, [0, 0, 0], [NAME] * 3, {}, {"a": {}}, {"size": [6, 5, 5], "first": [0, 0, 0]}]


def stream(attack):
    """A stream of frames (docs/frame-stream.md) far away, tiny or huge, with other members, and with frames that are
    not alike, cut off or altered, as the standard input."""
    rng = attack.rng
    kind = rng.choice(list(SAMPLE_TYPES))
    scale, offset = (10 ** rng.uniform(-90, 90) if rng.random() < 0.3 else 1 for _ in range(2))

    def number(n):
        return attack.extreme() if rng.random() < 0.03 else float(n)

    header = {
        "format": "t4d-frames", "version": 1, "size": [6, 5, 5], "frames": 3,
        "times": [number(t * scale) for t in range(3)],
        "affine": [[number(scale * (i == j)) for j in range(3)] + [number(offset)] for i in range(3)],
        "length_unit": "mm", "time_unit": "s", "space": rng.choice(["", "RAS", "LPS"]), "name": NAME, "mask": False,
        "unsized": rng.choice(["", "z", "xyz"]), "assumed_axes": [], "names": [f"{NAME} {t}" for t in "abc"],
        "notes": ["one"], "losses": [], "part": [0, 2],
        "region": {"size": [9, 5, 5], "first": [rng.choice([0, 3]), 0, 0]},
    }
    for member in rng.sample([*header], rng.choice([0, 4, 12])):
        if member not in ("format", "version", "size", "frames"):
            del header[member]
    altered = rng.random() < 0.4
    if altered:  # which changes names
        header = {member: value for member, value in header.items() if not member.startswith("name")}
    for _ in range(rng.choice([0, 0, 1, 2])):
        member = rng.choice([*header, "unknown"])
        if rng.random() < 0.3 and member in header:
            del header[member]
        else:
            header[member] = rng.choice(ANYTHING)
    text = json.dumps(header)
    if rng.random() < 0.1:
        member = rng.choice([*header])
        text = text[:-1] + f", {json.dumps(member)}: {json.dumps(rng.choice([header[member], *ANYTHING]))}}}"
    letter, _, descr, _ = SAMPLE_TYPES[kind]
    every = samples(kind, "xyzt", {"x": 6, "y": 5, "z": 5, "t": 4})
    frames = []
    for t in range(rng.choice([3, 3, 3, 3, 2, 4])):
        shape, described, fortran = (6, 5, 5), "<" + descr, "True"
        data = every[t * len(every) // 4:(t + 1) * len(every) // 4]
        if rng.random() < 0.05:
            shape = rng.choice([(5, 6, 5), (6, 5), (6, 5, 5, 1), (2**40, 2**40, 5), (0, 5, 5), (-6, 5, 5), ()])
        if rng.random() < 0.05:
            described = rng.choice([">" + descr, "|b1", "<f2", "<c16", "|O", "<U4", "|V1", "<u8", "<i99", ""])
        if rng.random() < 0.05:
            fortran = rng.choice(["False", "0", "None"])
        if letter in "fd" and rng.random() < 0.1:
            data = struct.pack(f"<{letter}", rng.choice([math.nan, math.inf, 3e38])) + data[struct.calcsize(letter):]
        frames.append(npy(data, described, shape, fortran))
    path = attack.path(NAME)
    path.write_bytes(text.encode() + b"\n" + b"".join(frames))
    if altered:
        content, _ = attack.altered(path, "altered")
        content.rename(path)
    output = attack.path("out.t4d")
    level = rng.choice([["--iso", 50], ["--below", 0], ["--label", 100], ["--label", "all"], []])
    more = rng.choice([[], [], [], ["--outside-value", "nan"], ["--frame-time", 0.1], ["--axes", "tzyx"],
                       ["--spacing", attack.extreme()], ["--caps", "graded"]])
    return Run(["weave", "-", *level, *more, "-o", output], [path], output, expect={0, 2, 3, 4}, stdin=path)


@input_class(weight=8)
def volumes(attack):
    """NRRD, NIfTI, `.npy`, `.raw` and streams of frames far away, tiny and huge, altered, with pipes, devices and links
    in place of their files, and packed a thousandfold, with the axes in every order"""
    rng = attack.rng
    output = attack.path("out.t4d")
    kind = rng.choice(["far", "far", "numbers", "altered", "odd", "bomb", "stream", "stream", "stream"])
    if kind == "stream":
        return stream(attack)
    if kind == "far":
        scale, offset = 10 ** rng.uniform(-90, 90), rng.choice([0, 10 ** rng.uniform(-90, 90)])
        path, options = volume(
            attack, lambda n, is_place=False: repr(float(offset if is_place else n * scale)))
    elif kind == "bomb":
        frames = rng.choice([1, 50, 2000])
        sizes = {"t": frames, "x": 20, "y": 4_000_000 // 400 // frames + 1, "z": 20}
        order = "".join(rng.sample("xyzt", 4))
        count = math.prod(sizes.values())
        announced = " ".join(str(sizes[a] * rng.choice([1, 1, 1, 1000])) for a in order)
        path, options = attack.path("volume.nrrd"), ["--iso", 0]
        path.write_bytes(
            f"NRRD0004\ntype: uint8\ndimension: 4\nsizes: {announced}\nkinds: "
            f"{' '.join('time' if a == 't' else 'domain' for a in order)}\nencoding: gzip\n\n"
            .encode() + gzip.compress(bytes([rng.choice([0, 1])]) * count, 9))
    else:
        def number(n, _=False):
            if kind == "numbers" and rng.random() < 0.1:
                return repr(attack.extreme())
            return repr(float(n))
        path, options = volume(attack, number)
    files = [p for p in attack.scene.rglob("*") if p.is_file()]
    if kind == "altered":
        victim = rng.choice(files)
        content, _ = attack.altered(victim, "altered")
        content.rename(victim)
    elif kind == "odd":
        victim = rng.choice(files)
        content = victim.read_bytes()
        victim.unlink()
        way = rng.choice(["fifo", "zeros", "null", "folder", "link", "loop", "missing"])
        if way != "link":
            attack.make_odd(victim, way)
        elif victim != path:
            # Samples are read from the folder of their header only.
            outside = attack.folder / f"{attack.scene.name}-outside"
            outside.write_bytes(content)
            attack.ending.callback(outside.unlink)
            victim.symlink_to(outside)
        return Run(["weave", path, *options, "-o", output], [path], output, expect={1, 2, 4})
    if rng.random() < 0.2:
        options += ["--caps", rng.choice(["graded", "half-step"])]
    return Run(["weave", path, *options, "-o", output], files, output)


@input_class(weight=3)
def velocities(attack):
    """velocities of volumes: other sizes, types and numbers than those of the solid, altered, pipes and devices"""
    rng = attack.rng
    output = attack.path("out.t4d")

    def written(name, kind, valueAt, size=8):
        letter, _, descr, _ = SAMPLE_TYPES[kind]
        values = [valueAt(i % size, i // size % size, i // size**2 % size, i // size**3) for i in range(3 * size**3)]
        path = attack.path(name)
        path.write_bytes(npy(struct.pack(f"<{len(values)}{letter}", *values), f"<{descr}", (3, size, size, size),
                             "False"))
        return path

    solid = written("solid.npy", "float32", lambda x, y, z, t: math.dist((x, y, z), (3 + t / 2, 4, 4)) - 2.2)
    files = []
    for axis in "xyz":
        kind = rng.choice(["float32", "float32", "float64", "int16"])
        speed = rng.choice([0, 0.5, 1, -3, 20, 1e3] if kind != "int16" else [0, 1, -3, 20])
        if kind == "float64" and rng.random() < 0.2:
            speed = attack.extreme()
        files.append(written(f"v{axis}.npy", kind, lambda *_: speed if kind != "int16" else int(speed),
                             size=rng.choice([8, 8, 8, 8, 7])))
    if rng.random() < 0.3:
        content, _ = attack.altered(files[0], "altered")
        content.rename(files[0])
    elif rng.random() < 0.2:
        files[1].unlink()
        attack.make_odd(files[1], rng.choice(["fifo", "zeros", "null", "folder", "loop", "missing"]))
    given = rng.sample(files, rng.choice([3, 3, 3, 3, 2, 1]))
    command = ["weave", solid, "--axes", "tzyx", "--frame-time", rng.choice([1, 0.01, 1e6]),
               "--velocity-file", ",".join(map(str, given)), "--substeps", rng.choice([1, 2, 5]), "-o", output]
    return Run(command, [solid, *files], output)


@input_class(weight=2)
def vdb_velocities(attack):
    """`.vdb` frames with one of their own grids, or none, as velocity"""
    file, _ = attack.altered(attack.pick("vdb"), "frame.vdb")
    other = attack.rng.choice(attack.seeds["vdb"])
    output = attack.path("out.t4d")
    name = attack.rng.choice(["surface", "v", "vel", "\x1b[31m", "grid"])
    return Run(["weave", file, other, "--frame-time", "1", f"--velocity={name}", "-o", output], [file, other], output)

"""Volumes: frames of voxels, and four-dimensional arrays of samples."""

import gzip
import json
import math
import struct
import zlib

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


def tiff(data, kind, description):
    """A TIFF of 6 x 5 samples a page, with the description in the first."""
    letter = SAMPLE_TYPES[kind][0]
    size = struct.calcsize(letter)
    page = 30 * size
    text = description.encode() + b"\0"
    text += b"\0" * (-len(text) % 2)
    out = bytearray(struct.pack("<2sHI", b"II", 42, 8 + len(text) + len(data)) + text + data)
    pages = len(data) // page
    for i in range(pages):
        format_ = 3 if letter in "fd" else 2 if letter.islower() else 1
        tags = [(256, 4, 1, 6), (257, 4, 1, 5), (258, 3, 1, 8 * size), (259, 3, 1, 1), (262, 3, 1, 1),
                *([(270, 2, len(text), 8)] if i == 0 else []),
                (273, 4, 1, 8 + len(text) + i * page), (277, 3, 1, 1), (278, 4, 1, 5),
                (279, 4, 1, page), (339, 3, 1, format_)]
        out += struct.pack("<H", len(tags))
        for tag, type_, count, value in tags:
            out += struct.pack("<HHII", tag, type_, count, value)
        out += struct.pack("<I", len(out) + 4 if i + 1 < pages else 0)
    return bytes(out)


def dicom(data, kind, number):
    """An enhanced image of 5 slices at 3 times, explicit and little-endian; `data` without packing."""
    def element(tag, type_, value):
        value += (b" " if type_ in ("DS", "CS", "IS", "DT") else b"\0") * (len(value) % 2)
        size = struct.pack("<2xI" if type_ in ("OW", "SQ") else "<H", len(value) & 0xFFFFFFFF)
        return struct.pack("<HH", tag >> 16, tag & 0xFFFF) + type_.encode() + size + value

    def text(tag, type_, *values):
        return element(tag, type_, "\\".join(str(v) for v in values).encode()[:65000])

    def sequence(tag, *items):
        return element(tag, "SQ", b"".join(
            struct.pack("<HHI", 0xFFFE, 0xE000, len(item)) + item for item in items))

    letter = SAMPLE_TYPES[kind][0]
    bits = 8 * struct.calcsize(letter)
    frames = [
        sequence(0x00209111, text(0x00189074, "DT", f"2026010112000{t}.{number(0)}"))
        + sequence(0x00209113, text(0x00200032, "DS", number(0, True), number(0, True), number(k)))
        for t in range(3) for k in range(5)]
    shared = (sequence(0x00209116, text(0x00200037, "DS", 1, 0, 0, 0, 1, 0))
              + sequence(0x00289110, text(0x00280030, "DS", number(1), number(1)))
              + sequence(0x00289145, text(0x00281052, "DS", number(0)), text(0x00281053, "DS", 1)))
    numbers = [(0x00280010, 5), (0x00280011, 6), (0x00280100, bits), (0x00280101, bits),
               (0x00280102, bits - 1), (0x00280103, int(letter.islower()))]
    return (b"\0" * 128 + b"DICM" + text(0x00020010, "UI", "1.2.840.10008.1.2.1")
            + text(0x0020000E, "UI", "1.2.3") + text(0x00280004, "CS", "MONOCHROME2")
            + text(0x00280008, "IS", 15)
            + b"".join(element(tag, "US", struct.pack("<H", value)) for tag, value in numbers)
            + sequence(0x52009229, shared) + sequence(0x52009230, *frames)
            + element(0x7FE00010, "OW", data))


def zarr(attack, path, data, kind, number):
    """An image of OME-Zarr with one level of a chunk a frame, or in shards, of which frames follow
    one another in the data."""
    rng = attack.rng
    sizes, chunk = [3, 5, 5, 6], [1, 5, 5, 6]
    frame = len(data) // 3
    packing = rng.choice(["raw", "gzip", "zlib", "shards"])
    pack = {"gzip": gzip.compress, "zlib": zlib.compress}.get(packing, bytes)
    frames = [pack(data[i * frame:(i + 1) * frame]) for i in range(3)]
    image = {"axes": [{"name": a, "type": "time" if a == "t" else "space"} for a in "tzyx"],
             "datasets": [{"path": "0", "coordinateTransformations": [
                 {"type": "scale", "scale": [float(number(0.5)), *(float(number(1)) for _ in "zyx")]},
                 {"type": "translation", "translation": [0, *(float(number(0, True)) for _ in "zyx")]}]}]}
    version2 = packing in ("raw", "zlib") and rng.random() < 0.5
    files = {}
    if version2:
        files[".zgroup"] = {"zarr_format": 2}
        files[".zattrs"] = {"multiscales": [{**image, "version": "0.4"}]}
        files["0/.zarray"] = {"zarr_format": 2, "shape": sizes, "chunks": chunk, "order": "C",
                              "dtype": f"<{SAMPLE_TYPES[kind][2]}", "fill_value": 0, "filters": None,
                              "compressor": None if packing == "raw" else {"id": packing}}
        files.update({f"0/{i}.0.0.0": frames[i] for i in range(3)})
    else:
        little = {"name": "bytes", "configuration": {"endian": "little"}}
        codecs = [little] + ([{"name": packing}] if packing in ("gzip", "zlib") else [])
        if packing == "shards":
            codecs = [{"name": "sharding_indexed", "configuration": {
                "chunk_shape": chunk, "codecs": [little], "index_codecs": [little]}}]
        files["zarr.json"] = {"zarr_format": 3, "node_type": "group", "attributes": {
            "ome": {"version": "0.5", "multiscales": [image]}}}
        files["0/zarr.json"] = {
            "zarr_format": 3, "node_type": "array", "shape": sizes, "data_type": kind, "fill_value": 0,
            "chunk_grid": {"name": "regular", "configuration": {
                "chunk_shape": [4, 5, 5, 6] if packing == "shards" else chunk}},
            "chunk_key_encoding": {"name": "default"}, "codecs": codecs}
        index = struct.pack("<8Q", *(v for i in range(3) for v in (i * frame, frame)), *[2**64 - 1] * 2)
        chunks = [data + index] if packing == "shards" else frames
        files.update({f"0/c/{i}/0/0/0": part for i, part in enumerate(chunks)})
    if rng.random() < 0.2:
        # A number of the metadata that sizes something.
        metadata = files["0/.zarray" if version2 else "0/zarr.json"]
        grid = metadata if version2 else metadata["chunk_grid"]["configuration"]
        of = rng.choice([metadata["shape"], grid["chunks" if version2 else "chunk_shape"]])
        of[rng.randrange(4)] = rng.choice([0, -1, 1, 7, 1000, 2**20, 2**31, 2**40, 2**63, 2**64, "x"])
    for name, content in files.items():
        file = path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content if isinstance(content, bytes) else json.dumps(content).encode())


def volume(attack, number):
    """A volume in one of the formats; `number` gives the numbers of its header from those of a
    volume at the origin, and whether they are a position."""
    rng = attack.rng
    sizes = {"x": 6, "y": 5, "z": 5, "t": 3}
    kind = rng.choice(list(SAMPLE_TYPES))
    _, nrrd, npy, nifti = SAMPLE_TYPES[kind]
    order = "".join(rng.sample("xyzt", 4)) if rng.random() < 0.5 else "xyzt"
    form = rng.choice(["nrrd", "nrrd", "nhdr", "npy", "nii", "nii.gz", "hdr", "raw", "tif", "tif",
                       "dcm", "dcm", "zarr", "zarr", "zarr"])
    if form == "dcm":
        kind = rng.choice(["uint8", "int16"])
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
        head = (f"{{'descr': '<{npy}', 'fortran_order': True, 'shape': "
                f"({', '.join(str(sizes[a]) for a in order)}), }}").ljust(117) + "\n"
        path.write_bytes(b"\x93NUMPY\1\0" + struct.pack("<H", len(head)) + head.encode() + data)
        options += ["--axes", order, f"--frame-time={number(0.5)}"]
    elif form == "tif":
        description = f"ImageJ=1\nimages=15\nslices=5\nframes=3\nspacing={number(1)}\nfinterval={number(0.5)}\n"
        if rng.random() < 0.5:
            planes = "".join(f'<TiffData FirstT="{i // 5}" FirstZ="{i % 5}" IFD="{i}"/>' for i in range(15))
            description = (f'<OME><Image><Pixels DimensionOrder="XYZTC" SizeZ="5" SizeT="3" '
                           f'PhysicalSizeX="{number(1)}" TimeIncrement="{number(0.5)}">{planes}</Pixels></Image></OME>')
        path.write_bytes(tiff(data, kind, description))
    elif form == "zarr":
        zarr(attack, path, data, kind, number)
    elif form == "dcm":
        path.write_bytes(dicom(data, kind, number))
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


@input_class(weight=8)
def volumes(attack):
    """NRRD, NIfTI, TIFF, DICOM, Zarr, `.npy` and `.raw` far away, tiny and huge, altered, with pipes, devices and
    links in place of their files, and packed a thousandfold, with the axes in every order"""
    rng = attack.rng
    output = attack.path("out.t4d")
    kind = rng.choice(["far", "far", "numbers", "altered", "odd", "bomb"])
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
        # A chunk of Zarr that is missing has the fill value.
        expect = {0, 1, 2, 4} if path.suffix == ".zarr" and way == "missing" else {1, 2, 4}
        return Run(["weave", path, *options, "-o", output], [path], output, expect=expect)
    if rng.random() < 0.2:
        options += ["--caps", rng.choice(["graded", "half-step"])]
    return Run(["weave", path, *options, "-o", output], files, output)


@input_class(weight=3)
def velocities(attack):
    """velocities of volumes: other sizes, types and numbers than those of the solid, altered, pipes and devices"""
    rng = attack.rng
    output = attack.path("out.t4d")

    def npy(name, kind, valueAt, size=8):
        letter, _, descr, _ = SAMPLE_TYPES[kind]
        head = (f"{{'descr': '<{descr}', 'fortran_order': False, 'shape': (3, {size}, {size}, {size}), }}"
                ).ljust(117) + "\n"
        values = [valueAt(i % size, i // size % size, i // size**2 % size, i // size**3) for i in range(3 * size**3)]
        path = attack.path(name)
        path.write_bytes(b"\x93NUMPY\1\0" + struct.pack("<H", len(head)) + head.encode()
                         + struct.pack(f"<{len(values)}{letter}", *values))
        return path

    solid = npy("solid.npy", "float32", lambda x, y, z, t: math.dist((x, y, z), (3 + t / 2, 4, 4)) - 2.2)
    files = []
    for axis in "xyz":
        kind = rng.choice(["float32", "float32", "float64", "int16"])
        speed = rng.choice([0, 0.5, 1, -3, 20, 1e3] if kind != "int16" else [0, 1, -3, 20])
        if kind == "float64" and rng.random() < 0.2:
            speed = attack.extreme()
        files.append(npy(f"v{axis}.npy", kind, lambda *_: speed if kind != "int16" else int(speed),
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

"""The format .t4d, with checksums that are right or wrong."""

import json
import math
import os
import struct
from fractions import Fraction

from .attack import Run, input_class


def crc_table():
    table = list(range(256))
    for _ in range(8):
        table = [value >> 1 ^ (value & 1) * 0x82F63B78 for value in table]
    return table


CRC_TABLE = crc_table()


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ CRC_TABLE[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


class Chunk:
    """A chunk of a valid .t4d: its place in the bytes of the file, and what its header says."""

    def __init__(self, data, at):
        self.data, self.at = data, at
        self.type = bytes(data[at:at + 4]).decode()
        self.length, self.front, self.blocks = struct.unpack_from("<QII", data, at + 8)
        self.end = at + 32 + self.length + -self.length % 8

    @staticmethod
    def all(data):
        """The chunks up to the index, or to the end of a file without."""
        chunks = [Chunk(data, 24)]
        while chunks[-1].type != "INDX" and chunks[-1].end < len(data):
            chunks.append(Chunk(data, chunks[-1].end))
        return chunks

    @property
    def payload(self):
        return bytes(self.data[self.at + 32:self.at + 32 + self.length])

    def field(self, layout, at):
        """The value of a field that is `at` bytes after the first field."""
        return struct.unpack_from("<" + layout, self.data, self.at + 32 + 8 * self.blocks + at)[0]

    def parts(self):
        """The offsets of the chunks that a SLAB or POSE names."""
        places = {"SLAB": (16, 24, 32), "POSE": (8,)}.get(self.type, ())
        return {self.at - self.field("Q", place) for place in places}

    def seal(self):
        """Makes the checksums right."""
        data, payload = self.data, self.at + 32
        begin = payload + self.front
        for entry in range(payload, payload + 8 * self.blocks, 8):
            size, = struct.unpack_from("<I", data, entry)
            struct.pack_into("<I", data, entry + 4, crc32c(data[begin:begin + size]))
            begin += size + -size % 8
        struct.pack_into("<I", data, self.at + 24, crc32c(data[payload:payload + self.front]))
        struct.pack_into("<I", data, self.at + 28, crc32c(data[self.at:self.at + 28]))


def padded(data):
    return data + bytes(-len(data) % 8)


class T4dFile:
    """A .t4d file of one simplex, written chunk by chunk, without index."""

    CELLS = [1, 2, 3, 4, 2, 0, 3, 4, 0, 1, 3, 4, 1, 0, 2, 4, 0, 1, 2, 3]
    CORNERS = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]

    def __init__(self):
        self.bytes = (b"\x89T4D\r\n\x1a\n" + struct.pack("<HHII", 1, 1, 0, 0))
        self.bytes += struct.pack("<I", crc32c(self.bytes))
        self.chunks = 0

    def chunk(self, kind, fields, blocks=(), flags=1):
        at = len(self.bytes)
        front = b"".join(struct.pack("<II", len(b), crc32c(b)) for b in blocks) + fields
        payload = front + b"".join(padded(b) for b in blocks)
        header = kind.encode() + struct.pack("<IQIII", flags, len(payload), len(front),
                                             len(blocks), crc32c(front))
        self.bytes += header + struct.pack("<I", crc32c(header)) + padded(payload)
        self.chunks += 1
        return at

    @staticmethod
    def array(scalar, components, rows):
        return struct.pack("<BB6xQ", scalar, components, rows)

    def simplex(self, begin, attributes):
        """CONN, SLAB and DONE; attributes of vertices, each the same row of doubles everywhere."""
        connection = self.chunk(
            "CONN", struct.pack("<6I", 5, 0, 0, 0, 0, 0) + self.array(5, 4, 5),
            [struct.pack("<20I", *self.CELLS)])
        times = [begin] * 4 + [begin + 1]
        fields = struct.pack("<ddQQQIIII", begin, begin + 1, len(self.bytes) - connection, 0, 0, 0,
                             len(attributes), 0, 0)
        fields += self.array(10, 3, 5) + self.array(10, 1, 5)
        blocks = [struct.pack("<15d", *self.CORNERS), struct.pack("<5d", *times)]
        for name, row in attributes.items():
            fields += struct.pack("<B3xI", 1, len(name)) + padded(name.encode())
            fields += self.array(10, len(row), 5)
            blocks.append(struct.pack(f"<{5 * len(row)}d", *row * 5))
        self.chunk("SLAB", fields, blocks)
        self.chunk("DONE", struct.pack("<QI4xQQQ8d", self.chunks, 1, 1, 5, 5, begin, begin + 1,
                                       0, 0, 0, 1, 1, 1))


def rows(slab, attributes):
    """The first rows of these attributes in a SLAB without compression and layers."""
    found = {}
    for name in attributes:
        record = struct.pack("<B3xI", 1, len(name)) + padded(name.encode())
        at = slab.find(record)
        if at >= 0:
            found[name] = at
    # The blocks follow the fields in the order of the arrays; the last ones are of attributes.
    order = sorted(found, key=found.get)
    ends = len(slab)
    for name in reversed(order):
        size = len(attributes[name])
        begin = ends - len(padded(bytes(40 * size)))
        found[name] = struct.unpack_from(f"<{size}d", slab, begin)
        ends = begin
    return found


@input_class(weight=10)
def t4d(attack):
    """`.t4d` with flipped bits, cuts, overwritten, doubled or missing parts, given to every verb
    that reads them: `validate` finds each change"""
    source = attack.pick("t4d")
    file, differs = attack.altered(source, "altered.t4d")
    verb = attack.rng.choice(["info", "validate", "validate --deep", "slice", "flipbook",
                            "recover", "rasterize", "compare"])
    output = None
    arguments = [*verb.split(), file]
    if verb == "slice":
        output = attack.path("out.ply")
        arguments += ["-t", "0.5", "-o", output]
    elif verb == "flipbook":
        output = attack.path("out.glb")
        arguments += ["-n", "3", "-o", output]
    elif verb == "recover":
        output = attack.path("out.t4d")
        arguments += ["-o", output]
    elif verb == "rasterize":
        output = attack.path("frames")
        arguments += ["--voxel-size", "5", "--frames", "2", "-o", output]
    elif verb == "compare":
        arguments += [source, "--slices", "2"]
    return Run(arguments, [file], output, must_fail=verb.startswith("validate") and differs)


@input_class(weight=5)
def sealed(attack):
    """`.t4d` altered behind checksums that are right: a chunk exchanged for another under the same
    INDX, which a slice reads; zero bytes after the blocks"""
    rng = attack.rng
    source = attack.pick("t4d")
    data = bytearray(source.read_bytes())
    chunks = Chunk.all(data)
    slabs = [chunk for chunk in chunks if chunk.type == "SLAB"
             and chunk.field("d", 0) < chunk.field("d", 8)]
    after_blocks = rng.random() < 0.25
    slab = slabs[-1] if after_blocks else rng.choice(slabs)
    middle = slab.field("d", 0) / 2 + slab.field("d", 8) / 2
    if after_blocks:
        index = chunks[-1]
        before = bytes(data[slab.at:slab.at + 28])
        data[slab.end:slab.end] = bytes(8)
        struct.pack_into("<Q", data, slab.at + 8, slab.length + 8)
        slab.seal()
        # INDX and footer are those of the file, unless the index is left as it was.
        index.at += 8
        header = data.find(before, index.at)
        if header >= 0 and rng.random() < 0.8:
            data[header:header + 28] = data[slab.at:slab.at + 28]
            index.seal()
        footer = len(data) - 40
        done, = struct.unpack_from("<Q", data, footer + 8)
        struct.pack_into("<QQQ", data, footer, index.at, done + 8, len(data))
        data[footer + 24:footer + 28] = data[index.at + 28:index.at + 32]
        struct.pack_into("<I", data, footer + 28, crc32c(data[footer:footer + 28]))
    else:
        # One that a slice in the middle of the slab reads.
        read = slab.parts()
        for chunk in chunks:
            if chunk.at in read:
                read |= chunk.parts()
        chunk = rng.choice([slab] + [each for each in chunks if each.at in read])
        begin, end = (chunk.front, chunk.length) if rng.random() < 0.8 else (8 * chunk.blocks,
                                                                              chunk.front)
        if begin == end:
            begin, end = 8 * chunk.blocks, chunk.front
        for _ in range(rng.choice([1, 1, 8])):
            data[chunk.at + 32 + rng.randrange(begin, end)] ^= 1 << rng.randrange(8)
        chunk.seal()
    file = attack.path("sealed.t4d")
    file.write_bytes(data)
    verb = rng.choice(["validate", "validate --deep", "slice", "slice", "slice", "info",
                       "convert"])
    if verb == "slice":
        output = attack.path("out.ply")
        return Run(["slice", file, f"--time={middle!r}", "-o", output], [file], output, expect={4})
    if verb == "convert":
        output = attack.path("out.vtu")
        return Run(["convert", file, output], [file], output, expect={4})
    return Run([*verb.split(), file], [file], expect={4} if verb != "info" else None)


@input_class(weight=2)
def index_pages(attack):
    """pages of an index with flipped bits behind checksums that are right: `validate` finds each"""
    rng = attack.rng
    data = bytearray(attack.pick("paged").read_bytes())
    chunks = Chunk.all(data)
    pages = [chunk for chunk in chunks if chunk.type == "PAGE"]
    pgix = next(chunk for chunk in chunks if chunk.type == "PGIX")
    chunk = rng.choice([pgix, *pages])
    before = bytes(data[chunk.at + 28:chunk.at + 32])
    for _ in range(rng.choice([1, 1, 8])):
        data[chunk.at + 32 + rng.randrange(8 * chunk.blocks, chunk.length)] ^= 1 << rng.randrange(8)
    chunk.seal()
    if chunk is not pgix and rng.random() < 0.8:
        entry = data.index(before, pgix.at)
        data[entry:entry + 4] = data[chunk.at + 28:chunk.at + 32]
        pgix.seal()
    file = attack.path("pages.t4d")
    file.write_bytes(data)
    verb = rng.choice(["validate", "slice", "info --slabs", "join"])
    if verb == "slice":
        output = attack.path("out.ply")
        return Run(["slice", file, "-t", rng.uniform(0, 5), "-o", output], [file], output)
    if verb == "join":
        output = attack.path("out.t4d")
        return Run(["join", file, "-o", output], [file], output, expect={4})
    return Run([*verb.split(), file], [file], expect={4} if verb == "validate" else None)


@input_class(weight=3)
def manifests(attack):
    """files in parts (`.t4dm`): a part missing, exchanged, altered or a pipe; members of the manifest
    replaced, and paths that lead elsewhere"""
    rng = attack.rng
    parts = []
    for seed in attack.seeds["parts"]:
        parts.append(attack.path(seed.name))
        parts[-1].write_bytes(seed.read_bytes())
    file = attack.path("solid.t4dm")
    attack.t4d("join", *parts, "--manifest", "-o", file)
    manifest = json.loads(file.read_text())
    kind = rng.choice(["sound", "missing", "exchanged", "altered", "pipe", "path", "member", "text"])
    part = rng.choice(parts)
    if kind == "missing":
        part.unlink()
    elif kind == "exchanged":
        part.write_bytes(rng.choice([each for each in parts if each != part]).read_bytes())
    elif kind == "altered":
        data = bytearray(part.read_bytes())
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
        part.write_bytes(data)
    elif kind == "pipe":
        part.unlink()
        os.mkfifo(part)
    elif kind == "path":
        rng.choice(manifest["parts"])["path"] = rng.choice([
            "../part1.t4d", "/etc/passwd", "/dev/zero", "solid.t4dm", ".", "", "part1.t4d\0", "a" * 5000,
            "file:///etc/passwd", "http://127.0.0.1:1/part1.t4d", "part1.t4d/../part1.t4d"])
    elif kind == "member":
        of = rng.choice([manifest, *manifest["parts"], *(p["bodies"][0] for p in manifest["parts"])])
        of[rng.choice(sorted(of))] = rng.choice([None, -1, 0, 1e300, 2 ** 64, "", "x", [], {}, [0, 0, 0]])
    if kind in ("path", "member"):
        file.write_text(json.dumps(manifest))
    elif kind == "text":
        data = bytearray(file.read_bytes())
        data[rng.randrange(len(data))] = rng.randrange(256)
        file.write_bytes(data)
    verb = rng.choice(["validate", "slice", "info", "measure", "track", "join", "convert"])
    wrong = {4} if kind in ("missing", "exchanged", "pipe", "path") else None
    inputs = [file, *(each for each in parts if each.is_file())]
    if verb in ("validate", "info", "measure", "track"):
        must = wrong if verb == "validate" or kind in ("missing", "pipe", "path") else None
        return Run([verb, file], inputs, expect=must or ({4} if kind == "altered" and verb == "validate"
                                                         else None))
    output = attack.path({"slice": "out.ply", "join": "out.t4d", "convert": "out.vtu"}[verb])
    arguments = {"slice": ["slice", file, "-t", 0.5, "-o", output],
                 "join": ["join", file, "-o", output], "convert": ["convert", file, output]}[verb]
    return Run(arguments, inputs, output, expect=wrong if verb != "slice" else None)


@input_class(weight=5)
def transforms(attack):
    """maps of all magnitudes, of a mesh with attributes of all kinds: each follows its kind, or is
    listed"""
    rng = attack.rng
    attributes = {
        "velocity": [2.0, 0.5, -1.0], "step": [0.0, 1.0, 3.0], "force": [0.0, 3.0, 1.0],
        "place": [1.0, 2.0, 3.0], "normal": [0.0, 0.6, 0.8], "thick": [4.0], "rate": [8.0],
        "label": [5.0], "color": [1.0, 0.5, 0.0], "plain": [1.0, 2.0, 3.0]}
    kinds = {"step": {"kind": "vector"}, "force": {"kind": "vector", "unit": "N"},
             "place": {"kind": "point"}, "normal": {"kind": "normal"},
             "thick": {"unit": "length"}, "rate": {"kind": "scalar", "unit": "1/time"},
             "label": {"kind": "label"}, "color": {"kind": "color"}}
    file = T4dFile()
    file.chunk("HEAD", json.dumps({"features": [], "bodies": [{"name": "b"}],
                                   "attributes": kinds}).encode())
    file.simplex(0.0, attributes)
    source, output = attack.path("in.t4d"), attack.path("out.t4d")
    source.write_bytes(file.bytes)
    magnitude = lambda most: 10.0 ** rng.uniform(-most, most)
    size = magnitude(rng.choice([0, 3, 30, 80, 200]))
    spread = rng.choice([0, 0, 2, 8])
    if rng.random() < 0.3:  # a similarity
        angle = rng.uniform(0, 7)
        c, d = math.cos(angle) * size, math.sin(angle) * size
        linear = [[c, -d, 0], [d, c, 0], [0, 0, rng.choice([size, -size])]]
    else:
        linear = [[rng.gauss(0, 1) * size * magnitude(spread) for _ in range(3)]
                  for _ in range(3)]
    shift = [rng.choice([0, 0, rng.gauss(0, 1) * size * magnitude(6)]) for _ in range(3)]
    factor = rng.choice([1.0, 1.0, 2.0, magnitude(10), magnitude(90)])
    matrix = [repr(x) for row, b in zip(linear, shift) for x in [*row, b]]
    return Run(["transform", source, "--matrix", *matrix, "--time-scale", repr(factor),
                "--compression", 0, "-o", output], [source], output,
               check=lambda result: judge_map(output, attributes, linear, shift, factor, result))


def judge_map(output, attributes, linear, shift, factor, result):
    if not result.succeeded:
        return []
    said = result.err
    exact = [[Fraction(x) for x in row] for row in linear]
    def times(matrix, v):
        return [sum(m * Fraction(x) for m, x in zip(row, v)) for row in matrix]
    cofactors = [[exact[(i + 1) % 3][(j + 1) % 3] * exact[(i + 2) % 3][(j + 2) % 3]
                  - exact[(i + 1) % 3][(j + 2) % 3] * exact[(i + 2) % 3][(j + 1) % 3]
                  for j in range(3)] for i in range(3)]
    determinant = sum(exact[0][j] * cofactors[0][j] for j in range(3))
    columns = [[float(exact[i][j]) for i in range(3)] for j in range(3)]
    lengths = [math.hypot(*c) for c in columns]
    scale = lengths[0]
    similar = all(abs(l / scale - 1) < 1e-9 for l in lengths) and all(
        abs(sum(a / scale * b / scale for a, b in zip(columns[i], columns[j]))) < 1e-9
        for i, j in ((0, 1), (0, 2), (1, 2)))
    f = Fraction(factor)
    expected = {
        "velocity": [x / f for x in times(exact, attributes["velocity"])],
        "step": times(exact, attributes["step"]),
        "place": [x + Fraction(b) for x, b in zip(times(exact, attributes["place"]), shift)],
        "rate": [Fraction(8) / f]}
    for same in ("label", "color", "plain"):
        expected[same] = [Fraction(x) for x in attributes[same]]
    if similar:
        expected["force"] = [x / Fraction(scale) for x in times(exact, attributes["force"])]
        expected["thick"] = [4 * Fraction(scale)]
    normal = times(cofactors, attributes["normal"])
    largest = max(abs(x) for x in normal) * (1 if determinant > 0 else -1)
    if max(abs(c) for row in cofactors for c in row) < 100 * abs(largest):
        unit = [float(x / largest) for x in normal]
        expected["normal"] = [Fraction(x / math.hypot(*unit)) for x in unit]
    slab = next(c.payload for c in Chunk.all(output.read_bytes()) if c.type == "SLAB")
    found = rows(slab, attributes)
    problems = []
    for name in attributes:
        if name not in found:
            if f"attribute '{name}'" not in said:
                problems.append(f"attribute {name} is gone without a word")
            continue
        if name in ("force", "thick") and not similar:
            problems.append(f"attribute {name} cannot follow this map, and was kept")
        if name not in expected:
            continue
        # Sums may cancel: the error is relative to their terms.
        terms = [sum(abs(x) for x in row) * 4 + abs(Fraction(b))
                 for row, b in zip(exact, shift)] if name in ("velocity", "step", "place",
                                                              "force") else None
        for i, (is_, right) in enumerate(zip(found[name], expected[name])):
            allowed = abs(right) if terms is None else terms[i]
            if name == "velocity":
                allowed /= f
            elif name == "force":
                allowed /= Fraction(scale)
            elif name == "normal":
                allowed = 1
            if abs(Fraction(is_) - right) > allowed * Fraction(1e-9):
                problems.append(f"attribute {name}: {is_!r}, not {float(right)!r}")
                break
    return problems


@input_class(weight=5)
def editors(attack):
    """chunks and members of HEAD that no version knows, through everything that edits: kept or
    listed"""
    rng = attack.rng
    letters = "abcdefghijklmnopqrstuvwxyz"
    def value(depth=0):
        return rng.choice([
            None, True, rng.randrange(-10 ** 15, 10 ** 15), rng.uniform(-1e9, 1e9), "",
            "\u00e4\u0000\U0001F529", *([] if depth > 3 else [
                [value(depth + 1) for _ in range(rng.randrange(4))],
                {f"k{i}": value(depth + 1) for i in range(rng.randrange(4))}])])
    def members():
        return {f"{rng.choice(letters)}x:{i}": value() for i in range(rng.randrange(4))}
    def chunk():
        kind = rng.choice(letters) + "".join(
            rng.choice(letters + letters.upper() + "0123456789") for _ in range(3))
        blocks = [rng.randbytes(rng.randrange(40)) for _ in range(rng.choice([0, 0, 1, 3]))]
        fields = rng.randbytes(rng.randrange(0, 64, 8 if blocks else 1))
        return rng.choice([kind, kind, kind, "NEWX", "PADD"]), fields, blocks
    paths, heads, given = [], [], []
    verb = rng.choice(["compress", "transform", "filter", "quality", "recover", "join",
                       "convert", "resolve", "simplify"])
    shared = [chunk() for _ in range(rng.randrange(3))]
    for i in range(2 if verb == "join" else 1):
        file = T4dFile()
        heads.append({"features": [], "bodies": [{"name": "b", **members()}], **members()})
        if rng.random() < 0.3:
            heads[-1]["attributes"] = rng.choice([
                {}, 7, {"a": {"kind": "label", **({} if verb == "join" else members())}}])
        file.chunk("HEAD", json.dumps(heads[-1]).encode())
        mine = shared + [chunk() for _ in range(rng.randrange(5))]
        rng.shuffle(mine)
        for kind, fields, blocks in mine:
            file.chunk(kind, fields, blocks, 0)
        given.append([k for k in mine if k[0] != "PADD"])
        file.simplex(float(i), {})
        paths.append(attack.path(f"in{i}.t4d"))
        paths[-1].write_bytes(file.bytes)
    output = attack.path("out.t4d")
    arguments = {"transform": ["--move", "1", "2", "3"], "filter": ["--to", "0.5"],
                 "simplify": ["--ratio", "0.5", "--max-error", "0.5"]}.get(verb, [])
    command = [verb, *paths, *arguments, "-o", output]
    if verb == "convert":
        command = [verb, *paths, output]
    elif verb == "resolve":
        far = T4dFile()
        far.chunk("HEAD", b'{"features": [], "bodies": [{"name": "b"}]}')
        far.simplex(9.0, {})
        attack.path("far.t4d").write_bytes(far.bytes)
        command = [verb, attack.path("far.t4d"), *paths, "-o", output]
    return Run(command, paths, output, expect={0, 3},
               check=lambda result: judge_editor(output, heads, given, result))


def judge_editor(output, heads, given, result):
    if not result.succeeded:
        return []
    said = result.err
    problems = []
    chunks = Chunk.all(output.read_bytes())
    head = json.loads(chunks[0].payload)
    kept = [(c.type, c.payload) for c in chunks if c.type[0].islower() or c.type == "NEWX"]
    safe, seen = [], set()
    for file in given:
        for kind, fields, blocks in file:
            table = b"".join(struct.pack("<II", len(b), crc32c(b)) for b in blocks)
            one = (kind, table + fields + b"".join(padded(b) for b in blocks))
            if not (kind[0].islower() and kind[3].islower()):
                if f"'{kind}'" not in said:
                    problems.append(f"chunk {kind} is gone without a word")
            elif len(given) == 1 or one not in seen:
                seen.add(one)
                safe.append(one)
    if kept != safe:
        problems.append(f"kept {[k for k, _ in kept]}, not {[k for k, _ in safe]}")
    def judge_members(before, after, where):
        for name in {n for object_ in before for n in object_}:
            values = [o[name] for o in before if name in o]
            if name == "attributes" and all(isinstance(v, dict) for v in values):
                values = [{n: a for v in values for n, a in v.items()}]  # what any of them says
            if any(v != values[0] for v in values):
                if f"'{name}'" not in said:
                    problems.append(f"member {name} of {where} differs, without a word")
            elif after.get(name, "gone") != values[0]:
                problems.append(f"member {name} of {where} is {after.get(name)!r}")
    own = ("features", "bodies")
    judge_members([{k: v for k, v in h.items() if k not in own} for h in heads], head, "HEAD")
    judge_members([{k: v for k, v in h["bodies"][0].items() if k != "name"} for h in heads],
                  head["bodies"][0], "the body")
    return problems

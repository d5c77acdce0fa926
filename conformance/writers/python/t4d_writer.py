#!/usr/bin/python3 -IS
"""Writes a mesh given as JSON (docs/conform.md, "Writers") as a .t4d file:

    t4d_writer.py MESH.json OUT.t4d

Exits with 0, or with 1 if the mesh cannot be stored. Written from formats/t4d/SPEC.md alone, for
Python 3.11 and its standard library. Arrays are stored as they are (codec 0), so nothing is compressed.
The file has an index.
"""
import json
import os
import struct
import sys
from collections import deque
from itertools import pairwise
from math import inf

# Checksums and padding ----------------------------------------------------------------------------


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


def padded(data):
    return data + bytes(-len(data) % 8)


# Payloads -----------------------------------------------------------------------------------------

# Letters of the module struct.
SCALARS = {1: "B", 2: "b", 3: "H", 4: "h", 5: "I", 6: "i", 7: "Q", 8: "q", 9: "f", 10: "d"}
U8, U32, U64, F64 = 1, 5, 7, 10
POSITIONS = F64
BLOCK_ROWS = 65536


class Payload:
    """Fields, and the blocks of the arrays among them."""

    def __init__(self):
        self.fields, self.blocks = bytearray(), []

    def pack(self, layout, *values):
        self.fields += struct.pack("<" + layout, *values)

    def array(self, scalar, components, rows):
        """Writes an array of rows of numbers."""
        layout = struct.Struct(f"<{components}{SCALARS[scalar]}")
        self.stored(scalar, components, [layout.pack(*row) for row in rows])

    def stored(self, scalar, components, rows):
        """Rows as they are stored."""
        self.pack("BBB5xQ", scalar, components, 0, len(rows))
        for first in range(0, len(rows), BLOCK_ROWS):
            self.blocks.append(b"".join(rows[first:first + BLOCK_ROWS]))

    def attributes(self, domain, attributes):
        for each in attributes:
            name = each["name"].encode()
            self.pack("B3xI", domain, len(name))
            self.fields += padded(name)
            self.stored(each["type"], each["components"], [bytes.fromhex(r) for r in each["rows"]])


class Out:
    """The file so far."""

    def __init__(self, stream):
        self.stream, self.at, self.headers = stream, 0, []

    def write(self, data):
        self.stream.write(data)
        self.at += len(data)

    def chunk(self, name, payload):
        """Writes a chunk; returns its offset."""
        at = self.at
        table = b"".join(struct.pack("<II", len(b), crc32c(b)) for b in payload.blocks)
        front = table + bytes(payload.fields)
        data = b"".join([front, *map(padded, payload.blocks)])
        if payload.blocks:
            assert len(front) % 8 == 0
        header = struct.pack("<4sIQIII", name, 1, len(data), len(front), len(payload.blocks),
                             crc32c(front))
        self.headers.append(header)
        self.write(header + struct.pack("<I", crc32c(header)) + padded(data))
        return at


# What chunks hold ---------------------------------------------------------------------------------


def box(points, axes):
    """Minimum, then maximum, of each axis; infinite without a point."""
    columns = list(zip(*points)) or [()] * 4
    return [function(column, default=none) for function, none in ((min, inf), (max, -inf))
            for column in columns[:axes]]


def mean(sources):
    # This is not sum(): from Python 3.12 on it carries the rounding errors along.
    total = list(sources[0])
    for point in sources[1:]:
        for axis in range(4):
            total[axis] += point[axis]
    return tuple(number / len(sources) for number in total)


class Connectivity:
    def __init__(self, mesh):
        self.mesh = mesh
        self.vertices, self.lower, self.upper = mesh["vertices"], mesh["lower"], mesh["upper"]
        self.cells, self.means = mesh["cells"], mesh["means"]
        self.first_upper = self.vertices - self.upper
        self.first_mean = self.first_upper - len(self.means)
        # The vertices of each block of cells, if there is more than one.
        self.blocks = []
        if len(self.cells) > BLOCK_ROWS:
            self.blocks = [set().union(*self.cells[first:first + BLOCK_ROWS])
                           for first in range(0, len(self.cells), BLOCK_ROWS)]

    def ranges(self, vertices):
        """Ranges of the needed vertices of the lower layer, the interior and the upper layer."""
        means = {i for i in vertices if self.first_mean <= i < self.first_upper}
        needed = (vertices - means).union(*(self.means[i - self.first_mean] for i in means))
        for first, end in pairwise((0, self.lower, self.first_upper, self.vertices)):
            inside = [i for i in needed if first <= i < end]
            yield from (min(inside), max(inside) + 1) if inside else (0, 0)

    def payload(self):
        payload = Payload()
        payload.pack("6I", self.vertices, self.lower, self.upper, len(self.means),
                     len(self.mesh["attributes"]), len(self.blocks))
        for block in self.blocks:
            payload.pack("6I", *self.ranges(block))
        payload.array(U32, 4, self.cells)
        if self.means:
            payload.array(U32, 1, [[len(sources)] for sources in self.means])
            payload.array(U32, 1, [[i] for sources in self.means for i in sources])
        payload.attributes(2, self.mesh["attributes"])
        return payload


def layer_payload(layer):
    payload = Payload()
    payload.pack("dI4x", layer["time"], len(layer["attributes"]))
    payload.array(POSITIONS, 3, layer["positions"])
    payload.attributes(1, layer["attributes"])
    return payload


def slab_payload(slab, body, conn, parts, points):
    """`parts` are the distances to its CONN and its LAYRs, `points` its vertices."""
    own = slab["interior_attributes"], slab["cell_attributes"]
    payload = Payload()
    payload.pack("ddQQQIII4x", slab["begin"], slab["end"], *parts, body, sum(map(len, own)),
                 len(conn.blocks))
    for block in conn.blocks:
        payload.pack("8d", *box([points[i] for i in block], 4))
    payload.array(POSITIONS, 3, [point[:3] for point in slab["interior"]])
    payload.array(F64, 1, [point[3:] for point in slab["interior"]])
    payload.attributes(1, own[0])
    payload.attributes(2, own[1])
    return payload


# The file -----------------------------------------------------------------------------------------

NOT_IN_HEAD = "bodies", "connectivities", "layers"


class Summary:
    """The summary of a body in DONE."""

    def __init__(self):
        self.slabs = self.vertices = self.cells = 0
        self.begin = self.end = None
        self.corners = []

    def add(self, slab, conn, bounds):
        if self.begin is None:
            self.begin = slab["begin"]
            self.vertices += conn.lower
        self.end = slab["end"]
        self.slabs += 1
        self.vertices += conn.vertices - conn.lower
        self.cells += len(conn.cells)
        if conn.vertices:
            self.corners += [bounds[:3], bounds[3:]]

    def fields(self):
        return (self.slabs, self.vertices, self.cells, self.begin, self.end,
                *box(self.corners, 3)[:6])


class Writer:
    SIGNATURE = b"\x89T4D\r\n\x1a\n"

    def __init__(self, mesh, stream):
        self.mesh, self.out = mesh, Out(stream)
        self.connectivities = [Connectivity(each) for each in mesh["connectivities"]]
        self.offsets = {}  # of parts that are written
        # The last of them, which may be named.
        self.last = {name: deque(maxlen=16 * len(mesh["bodies"])) for name in (b"CONN", b"LAYR")}
        self.summaries = [Summary() for _ in mesh["bodies"]]
        self.rows = []  # what INDX says of slabs

    def part(self, name, number, payload):
        """The offset of a part, which is written where it is first needed, and after many others."""
        if self.offsets.get((name, number)) not in self.last[name]:
            self.offsets[name, number] = self.out.chunk(name, payload())
            self.last[name].append(self.offsets[name, number])
        return self.offsets[name, number]

    def layer(self, number):
        if number is None:
            return 0, []
        layer = self.mesh["layers"][number]
        return (self.part(b"LAYR", number, lambda: layer_payload(layer)),
                [(*position, layer["time"]) for position in layer["positions"]])

    def slab(self, slab, body):
        number = slab["connectivity"]
        conn = self.connectivities[number]
        conn_at = self.part(b"CONN", number, conn.payload)
        lower_at, lower = self.layer(slab["lower"])
        upper_at, upper = self.layer(slab["upper"])
        interior = [tuple(point) for point in slab["interior"]]
        known = lower + interior + [None] * len(conn.means) + upper
        means = [mean([known[i] for i in sources]) for sources in conn.means]
        points = lower + interior + means + upper
        parts = [at and self.out.at - at for at in (conn_at, lower_at, upper_at)]
        self.out.chunk(b"SLAB", slab_payload(slab, body, conn, parts, points))
        bounds = box(points, 3)
        self.rows.append(([slab["begin"], slab["end"]], parts, [body], [len(conn.cells)], bounds))
        self.summaries[body].add(slab, conn, bounds)

    def head(self):
        head = {name: value for name, value in self.mesh.items() if name not in NOT_IN_HEAD}
        head["features"] = ["means"] if any(each.means for each in self.connectivities) else []
        head["bodies"] = [{name: value for name, value in body.items() if name != "slabs"}
                          for body in self.mesh["bodies"]]
        head["generator"] = "t4d_writer.py"
        return json.dumps(head, ensure_ascii=False).encode()

    def write(self):
        out, bodies = self.out, self.mesh["bodies"]
        file_header = self.SIGNATURE + struct.pack("<HHII", 1, 0, 1, 0)
        out.write(file_header + struct.pack("<I", crc32c(file_header)))
        head = Payload()
        head.fields += self.head()
        out.chunk(b"HEAD", head)
        for number, body in enumerate(bodies):
            for slab in body["slabs"]:
                self.slab(slab, number)
        done = Payload()
        done.pack("QI4x", len(out.headers), len(bodies))
        for each in self.summaries:
            done.pack("3Q8d", *each.fields())
        done_at = out.chunk(b"DONE", done)

        index = Payload()
        index.fields += file_header
        index.pack("I", len(self.rows))
        index.stored(U8, 1, [bytes([byte]) for byte in head.fields])
        index.stored(U8, 28, out.headers)
        columns = list(zip(*self.rows))
        for column, (scalar, components) in zip(
                columns, [(F64, 2), (U64, 3), (U32, 1), (U64, 1), (F64, 6)]):
            index.array(scalar, components, column)
        index_at = out.chunk(b"INDX", index)
        footer = struct.pack("<QQQI", index_at, done_at, out.at + 40, crc32c(out.headers[-1]))
        out.write(footer + struct.pack("<I", crc32c(footer)) + self.SIGNATURE[::-1])


def main(arguments):
    if len(arguments) != 2:
        sys.exit("usage: t4d_writer.py MESH.json OUT.t4d")
    source, target = arguments
    with open(source, encoding="utf-8") as file:
        mesh = json.load(file)
    # The file appears under its name when it is whole.
    part = target + ".part"
    with open(part, "wb") as stream:
        Writer(mesh, stream).write()
    os.replace(part, target)


if __name__ == "__main__":
    main(sys.argv[1:])

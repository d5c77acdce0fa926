#!/usr/bin/python3 -IS
"""Reads a .t4d file as the appendix "A reader under test" of formats/t4d/SPEC.md asks:

    t4d_reader.py FILE describe     reads everything and checks every rule
    t4d_reader.py FILE slice T      reads what the slice needs, no more if the file has an index
    t4d_reader.py FILE slice x C    slices by x = C, y = C or z = C; reads and checks everything
    t4d_reader.py FILE slice A,B,C,D E      the same for A x + B y + C z + D t = E
    t4d_reader.py --serve           answers such requests from standard input, one a line

Prints one JSON object and exits with 0, or refuses the file and exits with 1; the message on
standard error then names the rule and the byte, counted from the beginning of the file. 2 is wrong
usage. A mistake in this program exits with 70: Python's own 1 would look like a refusal.

Written from SPEC.md alone, for Python 3.11 and its standard library. Python has no Zstandard before
3.14, so arrays of codecs 1 and 2 are decompressed by the system's libzstd.so.1 through ctypes.
Files without such arrays do not need it.
"""
import json
import os
import re
import struct
import sys
from bisect import bisect_left
from collections import deque
from itertools import islice, pairwise, repeat
from math import hypot, inf, isfinite, isnan, nan, sqrt
from typing import NamedTuple


class Invalid(Exception):
    """The file breaks a rule, or cannot be read here; the text says which and where."""


def check(ok, at, rule, message):
    if not ok:
        raise Invalid(f"byte {at}: {rule}: {message}")


def crc_table():
    table = list(range(256))
    for _ in range(8):
        table = [value >> 1 ^ (value & 1) * 0x82F63B78 for value in table]
    return table


CRC_TABLE = crc_table()


def crc32c(data, before=0):
    """The checksum of the data, after bytes that have the checksum `before`."""
    crc = before ^ 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ CRC_TABLE[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


def padded(length):
    return length + -length % 8


# File header, chunks, footer ----------------------------------------------------------------------

SIGNATURE = b"\x89T4D\r\n\x1a\n"
# The types of chunks, each with the rule that says where its fields end.
TYPES = {b"HEAD": "M3", b"CONN": "N11", b"LAYR": "L4", b"POSE": "K4", b"SLAB": "S9", b"DONE": "D4",
         b"INDX": "I8"}
FOOTER_SIZE = 40


class File:
    def __init__(self, path):
        self.stream = open(path, "rb")
        self.size = self.stream.seek(0, 2)

    def read(self, at, length, rule):
        check(at + length <= self.size, at, rule, f"{length} bytes of a file of {self.size}")
        self.stream.seek(at)
        return self.stream.read(length)


TYPE = re.compile(rb"[A-Z][A-Z0-9]{3}|[a-z][A-Za-z0-9]{3}")


class Chunk:
    """A chunk, whole and with right checksums; fields and blocks are taken from front to back."""

    def __init__(self, file, at):
        self.at, self.header = at, file.read(at, 32, "C3")
        self.type, flags, length, front, blocks, front_sum, header_sum = struct.unpack(
            "<4sIQIIII", self.header)
        check(TYPE.fullmatch(self.type), at, "C1", f"chunk type {self.type}")
        check(flags <= 1, at + 4, "C2", "reserved flags set")
        self.size = 32 + padded(length)
        check(at + self.size <= file.size, at + 8, "C3", f"{length} bytes are not there")
        check(crc32c(self.header[:28]) == header_sum, at + 28, "C4", "header checksum")
        check(8 * blocks <= front <= length, at + 16, "C9", f"{front} of {length} bytes in front")
        data = file.read(at + 32, self.size - 32, "C3")
        self.front = data[:front]
        check(crc32c(self.front) == front_sum, at + 24, "C5", "front checksum")
        check(flags & 1 or self.type not in TYPES, at + 4, "C7", f"{self.type} not critical")
        check(not flags & 1 or self.type in TYPES, at, "C8", f"unknown critical chunk {self.type}")
        check(front % 8 == 0 or blocks == 0, at + 16, "C9", f"{front} bytes in front of blocks")
        check(blocks == 0 or self.type not in (b"HEAD", b"DONE"), at + 20, "C11", "blocks")
        self.rule, self.blocks, self.taken, end = TYPES.get(self.type, "C8"), [], 0, front
        for _ in range(blocks):
            place = self.place()
            size, checksum = self.unpack("II")
            begin, end = end, end + padded(size)
            check(end <= length, place, "C9", "a block ends after the payload")
            block = data[begin:begin + size]
            check(crc32c(block) == checksum, place + 4, "C10", "checksum of a block")
            check(not any(data[begin + size:end]), at + 32 + begin + size, "C6", "padding not zero")
            self.blocks.append(block)
        check(end == length, at + 8, "C9", f"{length - end} bytes follow front and blocks")
        check(not any(data[length:]), at + 32 + length, "C6", "padding not zero")
        self.blocks.reverse()

    def place(self):
        """The offset of what is taken next."""
        return self.at + 32 + self.taken

    def bytes(self, length, rule=None):
        left = len(self.front) - self.taken
        check(length <= left, self.place(), rule or self.rule,
              f"{length} bytes are wanted, {left} are left of the fields")
        self.taken += length
        return self.front[self.taken - length:self.taken]

    def unpack(self, layout):
        return struct.unpack("<" + layout, self.bytes(struct.calcsize("<" + layout)))

    def zeros(self, length, rule):
        at = self.place()
        check(not any(self.bytes(length)), at, rule, "reserved bytes or padding not zero")

    def end(self):
        left = len(self.front) - self.taken
        check(left == 0 and (not self.blocks or self.type == b"DONE"), self.place(), self.rule,
              f"{left} bytes and {len(self.blocks)} blocks too many")


def read_file_header(file):
    """(version, whether the file has an index)"""
    data = file.read(0, 24, "H1")
    check(data[:8] == SIGNATURE, 0, "H1", "this is no .t4d file")
    major, minor, flags, reserved, checksum = struct.unpack("<HHIII", data[8:])
    check(crc32c(data[:20]) == checksum, 20, "H2", "checksum of the file header")
    check(major == 1, 8, "H3", f"version {major}.{minor}, this reader knows 1.0")
    check(flags <= 1, 12, "H4", "reserved flags set")
    check(reserved == 0, 16, "H5", "reserved bytes not zero")
    return f"{major}.{minor}", flags & 1 == 1


def read_ends(file):
    """(Indx, Done), by the footer; they take all bytes from DONE on."""
    at = file.size - FOOTER_SIZE
    check(at >= 24, 24, "F1", "no room for the footer")
    data = file.read(at, FOOTER_SIZE, "F1")
    indx_at, done_at, length, indx_sum, checksum, signature = struct.unpack("<QQQ4sI8s", data)
    check(signature == SIGNATURE[::-1], at + 32, "F1", "no end signature: the file is cut off")
    check(crc32c(data[:28]) == checksum, at + 28, "F2", "checksum of the footer")
    check(length == file.size, at + 16, "F3", f"length {length}, the file has {file.size} bytes")
    indx = Chunk(file, indx_at)
    check(indx.type == b"INDX", at, "F4", f"INDX is not at {indx_at}")
    check(indx.header[28:] == indx_sum, at + 24, "F6", "not the checksum of this INDX")
    done = Chunk(file, done_at)
    check(done.type == b"DONE", at + 8, "F5", f"DONE is not at {done_at}")
    check(done_at + done.size == indx_at, indx_at, "O4", "INDX does not follow DONE")
    check(indx_at + indx.size == at, at, "O4", "the footer does not follow INDX")
    indx = Indx(indx)
    check(indx.file_header == file.read(0, 20, "H1"), indx_at + 32, "I1", "another file header")
    check(indx.chunks.get(done_at) == done.header[:28] and indx.end == indx_at, indx_at, "I2",
          f"DONE at {done_at} is not the last of the chunks")
    return indx, Done(done, indx.head)


# Arrays and attributes ----------------------------------------------------------------------------

# Letters of the module struct.
SCALARS = {1: "B", 2: "b", 3: "H", 4: "h", 5: "I", 6: "i", 7: "Q", 8: "q", 9: "f", 10: "d"}
U8, U32, S32, U64, F32, F64 = 1, 5, 6, 7, 9, 10
BLOCK_ROWS = 65536


class Array:
    """The array whose record comes next; `data` are its bytes row after row, whatever the codec."""

    def __init__(self, chunk, features, rule=None, types=(), components=0):
        self.at = at = chunk.place()
        self.type, self.components, codec = chunk.unpack("BBB")
        check(self.type in SCALARS, at, "A1", f"scalar type {self.type}")
        check(self.components > 0, at + 1, "A2", "no components")
        check(codec <= 2, at + 2, "A3", f"codec {codec}")
        chunk.zeros(5, "A4")
        self.rows, = chunk.unpack("Q")
        check(rule is None or self.type in types and self.components == components, at, rule,
              f"scalar type {self.type}, {self.components} components")
        blocks = -(-self.rows // BLOCK_ROWS)
        check(blocks <= len(chunk.blocks), at + 8, "A5", f"{len(chunk.blocks)} blocks are left")
        check(codec == 0 or self.rows > 0, at + 2, "A6", "an array of no rows is compressed")
        check(codec != 2 or self.type == U32, at + 2, "A8", f"scalar type {self.type}")
        check(codec not in (1, 2) or "zstd" in features, at + 2, "A13", "HEAD does not name zstd")
        row = self.components * struct.calcsize("<" + SCALARS[self.type])
        self.data = bytearray()
        for i in range(blocks):
            rows, block = min(BLOCK_ROWS, self.rows - i * BLOCK_ROWS), chunk.blocks.pop()
            size = rows * row
            check(codec > 0 or len(block) == size, at, "A7", f"{len(block)} bytes, not {size}")
            check(size <= 1024 * len(block), at, "A9", f"{size} bytes from {len(block)}")
            if codec == 1:
                block = in_rows(decompress(block, size, size, at), row)
            elif codec == 2:
                # A byte for each scalar, and the scalar itself for some.
                count = rows * self.components
                block = decompress(block, count, count + size, at)
                block = repeats(block, count, self.components, at)
            self.data += block

    def numbers(self):
        return struct.unpack(f"<{self.rows * self.components}{SCALARS[self.type]}", self.data)


def in_rows(content, size):
    """Rows of `size` bytes that were transposed."""
    rows, data = len(content) // size, bytearray(len(content))
    for byte in range(size):
        data[byte::size] = content[byte * rows:(byte + 1) * rows]
    return data


def repeats(content, count, components, at):
    """The bytes of `count` scalars, of codec 2."""
    distances = in_rows(content[:count], components)
    rest = distances.count(0)
    check(len(content) == count + 4 * rest, at, "A15", f"{rest} numbers are not repeated")
    stored = iter(struct.unpack(f"<{rest}I", in_rows(content[count:], 4)))
    scalars, before = [], 0
    for i, distance in enumerate(distances):
        check(distance <= i, at, "A14", "a distance to before the first scalar")
        if distance == 0:
            z = next(stored)
            before = (before + (z >> 1 ^ -(z & 1))) % 2**32
        scalars.append(scalars[-distance] if distance else before)
    return struct.pack(f"<{count}I", *scalars)


libzstd = None


def load_libzstd():
    global libzstd
    import ctypes
    try:
        libzstd = ctypes.CDLL("libzstd.so.1")
    except OSError as error:
        raise Invalid(f"codecs 1 and 2 cannot be read here: {error}")
    size, text = ctypes.c_size_t, ctypes.c_char_p
    for name, result, *arguments in (
            ("ZSTD_findFrameCompressedSize", size, text, size),
            ("ZSTD_getDictID_fromFrame", ctypes.c_uint, text, size),
            ("ZSTD_getFrameContentSize", ctypes.c_ulonglong, text, size),
            ("ZSTD_decompress", size, text, size, text, size)):
        function = getattr(libzstd, name)
        function.restype, function.argtypes = result, arguments


def decompress(frame, least, most, at):
    """The content of a frame that has to have `least` to `most` bytes."""
    if libzstd is None:
        load_libzstd()
    # libzstd takes skippable frames and those of its first versions, too; RFC 8878 means this one.
    check(frame[:4] == b"\x28\xb5\x2f\xfd", at, "A10", "not a Zstandard frame")
    check(libzstd.ZSTD_findFrameCompressedSize(frame, len(frame)) == len(frame), at, "A10",
          "not one whole Zstandard frame")
    check(libzstd.ZSTD_getDictID_fromFrame(frame, len(frame)) == 0, at, "A10", "dictionary")
    # A number near 2^64 where it is not declared, or where decompression fails.
    size = libzstd.ZSTD_getFrameContentSize(frame, len(frame))
    check(least <= size <= most, at, "A11", f"the frame declares {size} bytes, not {most}")
    content = bytes(size)
    check(libzstd.ZSTD_decompress(content, size, frame, len(frame)) == size, at, "A12",
          "the frame does not decompress")
    return content


class Attribute:
    def __init__(self, chunk, features):
        self.at = at = chunk.place()
        self.domain, = chunk.unpack("B")
        check(self.domain in (1, 2), at, "T1", f"domain {self.domain}")
        chunk.zeros(3, "T2")
        length, = chunk.unpack("I")
        check(1 <= length <= 255, at + 4, "T3", f"name of {length} bytes")
        name = chunk.bytes(length, "T3")
        try:
            self.name = name.decode("utf-8")
        except UnicodeDecodeError as error:
            check(False, at + 8 + error.start, "T4", "the name is not UTF-8")
        check(is_name(self.name), at + 8, "T4", f"name {self.name!r}")
        chunk.zeros(padded(length) - length, "T5")
        self.values = Array(chunk, features)


    def kind(self):
        return self.name, self.values.type, self.values.components


def check_attributes(attributes, vertices, cells):
    seen = set()
    for each in attributes:
        rows = vertices if each.domain == 1 else cells
        check(each.values.rows == rows, each.values.at + 8, "T6",
              f"{each.values.rows} rows for {rows} vertices or cells")
        check((each.domain, each.name) not in seen, each.at, "T7", "a name again")
        seen.add((each.domain, each.name))


# Contents of chunks -------------------------------------------------------------------------------

def is_name(text):
    try:
        size = len(text.encode("utf-8"))
    except UnicodeEncodeError:                                  # a surrogate alone has no UTF-8
        return False
    return 1 <= size <= 255 and not any(
        i <= 0x1F or 0x7F <= i <= 0x9F or 0x202A <= i <= 0x202E or 0x2066 <= i <= 0x2069
        or i in (0x2F, 0x61C, 0x200E, 0x200F) for i in map(ord, text))


class Head:
    FEATURES = {"zstd", "means", "pose", "grid"}
    OPTIONAL = {"generator": str, "backend": str, "length_unit": str, "time_unit": str, "up": str,
                "details": dict}

    def __init__(self, data, at):
        check(len(data) <= 16 << 20, at, "M1", f"{len(data)} bytes")
        check(not data.startswith(b"\xef\xbb\xbf"), at, "M2", "byte order mark")
        try:
            # Integers become doubles, for int() refuses those of more than 4,300 digits.
            head = json.loads(data.decode("utf-8-sig"), parse_int=float,
                              parse_constant=lambda name: check(False, at, "M3", f"{name} in JSON"))
        except UnicodeDecodeError as error:
            check(False, at + error.start, "M2", "not UTF-8")
        except json.JSONDecodeError as error:
            check(False, at + len(error.doc[:error.pos].encode()), "M3", error.msg)
        except RecursionError:
            check(False, at, "M4", "nested far too deep")
        check(isinstance(head, dict), at, "M3", "no JSON object")
        depth, level = 0, [head]
        while level:
            depth += 1
            inner = [each.values() if isinstance(each, dict) else each for each in level]
            level = [each for values in inner for each in values if isinstance(each, (dict, list))]
        check(depth <= 64, at, "M4", f"nested {depth} deep")
        self.data = data
        self.features = self.strings(head, "features", at, "M5")
        for each in self.features:
            check(each in self.FEATURES, at, "M6", f"feature {each!r}, which is unknown here")
        bodies = head.get("bodies")
        check(isinstance(bodies, list) and 1 <= len(bodies) <= 65536
              and all(isinstance(each, dict) for each in bodies), at, "M7", "bodies")
        self.bodies = [each.get("name") for each in bodies]
        for each in self.bodies:
            check(isinstance(each, str) and is_name(each), at, "M8", f"name {each!r}")
        check(len(set(self.bodies)) == len(self.bodies), at, "M9", "two bodies of one name")
        self.check_members(bodies, at)
        for member, kind in self.OPTIONAL.items():
            check(isinstance(head.get(member, kind()), kind), at, "M10", f"type of {member}")
        check(head.get("up", "y") in ("y", "z"), at, "M10", "up is neither y nor z")
        self.grid = self.grid_of(head, at)

    def grid_of(self, head, at):
        """((x, y, z) of the origin, step), or None"""
        grid = head.get("grid", None if "grid" in self.features else {"origin": [0] * 3, "step": 1})
        check(isinstance(grid, dict), at, "M10", "grid is no object")
        origin, step = grid.get("origin"), grid.get("step")
        numbers = [*origin, step] if isinstance(origin, list) else []
        check(len(numbers) == 4 and all(isinstance(each, float | int) and not isinstance(each, bool)
                                        and isfinite(each) for each in numbers) and step > 0,
              at, "M10", "origin or step of the grid")
        return (origin, step) if "grid" in self.features else None

    def check_members(self, bodies, at):
        for each in bodies:
            for member, kind in ("material", str), ("parent", str), ("details", dict):
                check(isinstance(each.get(member, kind()), kind), at, "M11", f"type of {member}")
            color = each.get("color", [0, 0, 0])
            check(isinstance(color, list) and len(color) in (3, 4)
                  and all(isinstance(part, float | int) and not isinstance(part, bool)
                          and 0 <= part <= 1 for part in color), at, "M11", "color")
        parents = {each["name"]: each["parent"] for each in bodies if "parent" in each}
        names = set(self.bodies)
        rooted = names - set(parents)
        for name in self.bodies:
            path = [name]
            while path[-1] not in rooted:
                path.append(parents[path[-1]])
                check(path[-1] in names and len(path) <= len(bodies), at, "M11",
                      f"parent of {name!r}")
            rooted.update(path)

    @staticmethod
    def strings(head, member, at, rule):
        value = head.get(member)
        check(isinstance(value, list) and all(isinstance(each, str) for each in value), at, rule,
              f"{member} is no array of strings")
        return value


class Conn:
    def __init__(self, chunk, features):
        at = chunk.place()
        self.vertices, self.lower, self.upper, self.means, attributes, blocks = chunk.unpack("6I")
        self.first_upper = self.vertices - self.upper
        self.first_mean = self.first_upper - self.means
        check(self.lower <= self.first_mean, at, "N1", "layers and means exceed the vertices")
        ranges = chunk.unpack(f"{6 * blocks}I")
        record = Array(chunk, features, "N3", (U32,), 4)
        self.cells = rows_of(record)
        for i, (a, b, c, d) in enumerate(self.cells):
            check(max(a, b, c, d) < self.vertices, record.at, "N4", f"index in cell {i}")
            check(a != b and a != c and a != d and b != c and b != d and c != d, record.at, "N5",
                  f"cell {i} has a vertex twice")
        self.sources = self.read_means(chunk, features) if self.means else []
        self.attributes = []
        for _ in range(attributes):
            each = Attribute(chunk, features)
            check(each.domain == 2, each.at, "N10", "an attribute of vertices")
            self.attributes.append(each)
        chunk.end()
        check(self.means == 0 or "means" in features, at + 12, "N12", "HEAD does not name means")
        check_attributes(self.attributes, 0, len(self.cells))
        # The numbers of the vertices of each block of cells, if there is more than one.
        self.blocks = []
        if len(self.cells) > BLOCK_ROWS:
            self.blocks = [set().union(*self.cells[first:first + BLOCK_ROWS])
                           for first in range(0, len(self.cells), BLOCK_ROWS)]
        expected = [number for block in self.blocks for number in self.ranges_of(block)]
        check(list(ranges) == expected, at + 20, "N2", f"the ranges are {expected}")

    def read_means(self, chunk, features):
        """A list of the sources of each mean."""
        sizes = Array(chunk, features, "N6", (U32,), 1)
        check(sizes.rows == self.means, sizes.at + 8, "N6", f"{sizes.rows} mean sizes")
        sources = Array(chunk, features, "N6", (U32,), 1)
        lengths, numbers = sizes.numbers(), sources.numbers()
        check(min(lengths) > 0, sizes.at, "N7", "a mean of nothing")
        check(sum(lengths) == len(numbers), sizes.at, "N8", f"there are {len(numbers)} sources")
        check(all(i < self.first_mean or self.first_upper <= i < self.vertices for i in numbers),
              sources.at, "N9", "a source is a mean, or no vertex")
        rest = iter(numbers)
        return [list(islice(rest, length)) for length in lengths]

    def ranges_of(self, vertices):
        means = [i for i in vertices if self.first_mean <= i < self.first_upper]
        needed = vertices.difference(means).union(
            *(self.sources[i - self.first_mean] for i in means))
        for first, end in pairwise((0, self.lower, self.first_upper, self.vertices)):
            inside = [i for i in needed if first <= i < end]
            yield from (min(inside), max(inside) + 1) if inside else (0, 0)


class Layr:
    def __init__(self, chunk, head):
        at, features = chunk.place(), head.features
        self.time, = chunk.unpack("d")
        attributes, = chunk.unpack("I")
        check(isfinite(self.time), at, "L1", f"time {self.time}")
        chunk.zeros(4, "L6")
        positions = Array(chunk, features, "L2", position_types(head), 3)
        check(positions.rows > 0, positions.at + 8, "L3", "no rows")
        self.attributes = [Attribute(chunk, features) for _ in range(attributes)]
        for each in self.attributes:
            check(each.domain == 1, each.at, "L5", "an attribute of cells")
        check_attributes(self.attributes, positions.rows, 0)
        chunk.end()
        self.is_float32 = positions.type == F32
        self.points = points(positions, repeat(self.time), head)


class Pose:
    """Like the Layr that it moves, at its own time. part(offset) is a Conn, a Layr, a Pose or None."""

    def __init__(self, chunk, head, part):
        at = chunk.place()
        self.time, distance = chunk.unpack("dQ")
        matrix = chunk.unpack("12d")
        chunk.end()
        check("pose" in head.features, at, "K5", "HEAD does not name pose")
        check(isfinite(self.time), at, "K1", f"time {self.time}")
        check(all(map(isfinite, matrix)), at + 16, "K3", f"matrix {matrix}")
        self.layer_at = chunk.at - distance
        layer = part(self.layer_at) if 0 < distance < chunk.at else None
        check(isinstance(layer, Layr), at + 8, "K2", f"no LAYR {distance} bytes before it")
        self.attributes = layer.attributes
        rows = matrix[:4], matrix[4:8], matrix[8:]
        self.points = []
        for x, y, z, _ in layer.points:
            point = [((a * x + b * y) + c * z) + d for a, b, c, d in rows]
            if layer.is_float32 and all(map(isfinite, point)):
                point = map(float32, point)
            self.points.append((*point, self.time))


def float32(number):
    """The number rounded to binary32; infinite where that is, which Python's module refuses."""
    try:
        return struct.unpack("<f", struct.pack("<f", number))[0]
    except OverflowError:
        return inf


def position_types(head):
    return (S32, F32, F64) if head.grid else (F32, F64)


def rows_of(record):
    number = iter(record.numbers())
    return list(zip(*[number] * record.components))


def points(positions, times, head):
    rows = rows_of(positions)
    if positions.type == S32:
        (x, y, z), step = head.grid
        rows = [(x + step * i, y + step * j, z + step * k) for i, j, k in rows]
    return [(*position, time) for position, time in zip(rows, times)]


class Record(NamedTuple):
    """The record of a slab in INDX, and its offset. Parts are so many bytes before it."""
    begin: float
    end: float
    conn: int
    lower: int
    upper: int
    body: int
    cells: int
    low: tuple
    high: tuple
    at: int

    def parts(self):
        """The offsets of connectivity, lower and upper, None for an empty layer."""
        return [self.at - each if each else None for each in (self.conn, self.lower, self.upper)]


class Slab:
    """`vertices` is a list of (x, y, z, t)."""

    def __init__(self, chunk, head, part):
        """part(offset) is a Conn, a Layr, a Pose or None."""
        self.at = at = chunk.place()
        fields = chunk.unpack("ddQQQI")
        self.begin, self.end, to_conn, to_lower, to_upper, self.body = fields
        attributes, blocks = chunk.unpack("II")
        check(isfinite(self.begin) and isfinite(self.end) and self.begin <= self.end, at, "S1",
              f"begin {self.begin}, end {self.end}")
        check(self.body < len(head.bodies), at + 40, "S4", f"body {self.body}")
        chunk.zeros(4, "S11")
        bounds = chunk.unpack(f"{8 * blocks}d")
        positions = Array(chunk, head.features, "S5", position_types(head), 3)
        times = Array(chunk, head.features, "S6", (F64,), 1)
        check(times.rows == positions.rows, times.at + 8, "S6", f"{times.rows} interior times")
        own = [Attribute(chunk, head.features) for _ in range(attributes)]
        chunk.end()
        self.conn = conn = part(chunk.at - to_conn) if 0 < to_conn < chunk.at else None
        check(isinstance(conn, Conn), at + 16, "S2", f"no CONN {to_conn} bytes before it")
        interior = points(positions, times.numbers(), head)
        check(len(interior) == conn.first_mean - conn.lower, positions.at, "P1",
              f"{len(interior)} interior vertices")
        lower, of_lower = self.layer(part, chunk, to_lower, conn.lower, self.begin, at + 24)
        upper, of_upper = self.layer(part, chunk, to_upper, conn.upper, self.end, at + 32)
        known = lower + interior + [None] * conn.means + upper
        means = [mean([known[i] for i in sources]) for sources in conn.sources]
        self.vertices = lower + interior + means + upper
        for point in self.vertices:
            check(all(map(isfinite, point)), at, "P2", f"vertex {point}")
        for point in interior + means:
            check(self.begin <= point[3] <= self.end, at, "P4", f"interior vertex {point}")
        check_attributes(conn.attributes + own, len(interior), len(conn.cells))
        of_vertices = [each for each in own if each.domain == 1]
        check(interior or not of_vertices, at + 44, "P5", "attributes of no vertices")
        kinds = {tuple(map(Attribute.kind, attributes)) for points, attributes
                 in ((lower, of_lower), (interior, of_vertices), (upper, of_upper)) if points}
        check(len(kinds) <= 1, at, "P5", f"its vertices have {kinds}")
        # (domain, name, type, components, bytes) of each.
        self.attributes = [(2, *each.kind(), each.values.data) for each in conn.attributes]
        for i, kind in enumerate(kinds.pop() if kinds else ()):
            parts = [attributes[i].values.data if attributes else b""
                     for attributes in (of_lower, of_vertices, of_upper)]
            self.attributes.append((1, *kind, with_means(parts, conn, *kind[1:])))
        self.attributes += [(2, *each.kind(), each.values.data) for each in own if each.domain == 2]
        expected = [number for block in conn.blocks
                    for corner in box([self.vertices[i] for i in block]) for number in corner]
        check(not bounds or list(bounds) == expected, at + 48, "S10", f"the bounds are {expected}")
        self.box = low, high = box(self.vertices)
        self.record = Record(*fields, len(conn.cells), low[:3], high[:3], chunk.at)

    @staticmethod
    def layer(part, chunk, distance, rows, time, at):
        layer = part(chunk.at - distance) if 0 < distance < chunk.at else None
        check(distance == 0 or isinstance(layer, Layr | Pose), at, "S3",
              f"no layer {distance} bytes before it")
        found = layer.points if layer else []
        check(len(found) == rows, at, "P1", f"layer of {len(found)} vertices, not {rows}")
        check(layer is None or layer.time == time, at, "P3", f"layer not at {time}")
        return found, layer.attributes if layer else []


def mean(sources):
    # This is not sum(): from Python 3.12 on it carries the rounding errors along.
    x, y, z, t = sources[0]
    for point in sources[1:]:
        x += point[0]
        y += point[1]
        z += point[2]
        t += point[3]
    n = len(sources)
    return x / n, y / n, z / n, t / n


def with_means(parts, conn, kind, components):
    """The bytes of an attribute of the vertices of a slab, made of those of its three parts."""
    size = components * struct.calcsize("<" + SCALARS[kind])
    lower, interior, upper = parts
    known = lower + interior + bytes(conn.means * size) + upper
    rows = [known[i * size:(i + 1) * size] for i in range(conn.vertices)]
    means = []
    for sources in conn.sources:
        if kind in (F32, F64):
            layout = f"<{components}{SCALARS[kind]}"
            sums = list(struct.unpack(layout, rows[sources[0]]))
            for i in sources[1:]:
                sums = [a + b for a, b in zip(sums, struct.unpack(layout, rows[i]))]
            # The result is the positive quiet NaN without payload, which is Python's own.
            values = [nan if isnan(each) else each / len(sources) for each in sums]
            means.append(struct.pack(layout, *values))
        else:
            means.append(rows[sources[0]])
    return lower + interior + b"".join(means) + upper


def box(points):
    """(minimum, maximum) of x, y, z, t; infinite ones without a point."""
    columns = list(zip(*points)) or [()] * 4
    return (tuple(min(each, default=inf) for each in columns),
            tuple(max(each, default=-inf) for each in columns))


def joined(boxes):
    lows, highs = zip(*boxes)
    return box(lows)[0], box(highs)[1]


class Done:
    def __init__(self, chunk, head):
        self.at = chunk.place()
        self.chunks, bodies = chunk.unpack("QI")
        check(bodies == len(head.bodies), self.at + 8, "D2", f"{bodies} bodies")
        chunk.zeros(4, "D3")
        # slabs, vertices, cells, begin, end, minimum of x, y, z, maximum of x, y, z
        self.summaries = [chunk.unpack("3Q8d") for _ in range(bodies)]
        chunk.end()

    def check_records(self, bodies, headers):
        """`bodies` has a list of records for each body, `headers` those of all chunks but INDX."""
        check(self.chunks == len(headers) - 1, self.at, "D1",
              f"{self.chunks} chunks, not {len(headers) - 1}")
        conns, layrs, poses = ([at for at, header in headers.items() if header[:4] == each]
                               for each in (b"CONN", b"LAYR", b"POSE"))

        def is_near(part, slab, *places):
            """Whether it is one of the last in one of these lists of offsets."""
            ends = [bisect_left(each, slab.at) for each in places]
            return any(part in each[max(0, end - 16 * len(bodies)):end]
                       for each, end in zip(places, ends))

        for i, (said, slabs) in enumerate(zip(self.summaries, bodies)):
            at = self.at + 16 + 88 * i
            check(said[0] == len(slabs) > 0, at, "D5", f"{said[0]} slabs, {len(slabs)} are there")
            for last, slab in pairwise(slabs):
                lower, upper = slab.parts()[1], last.parts()[2]
                is_copy = (headers.get(lower, b"")[:4] == b"LAYR"
                           and headers[lower] == headers.get(upper))
                check(lower == upper or is_copy, slab.at, "S7", "lower is not upper before")
                check(slab.begin == last.end or slab.lower == 0 and slab.begin > last.end, slab.at,
                      "S8", f"begins at {slab.begin}, the slab before ends at {last.end}")
            for last, slab in zip([None, *slabs], slabs):
                conn, *layers = slab.parts()
                if last and layers[0] == last.parts()[2]:
                    del layers[0]
                check(is_near(conn, slab, conns) and all(
                    each is None or is_near(each, slab, layrs, poses) for each in layers),
                    slab.at, "S12", "a part is far back")
            times, cells = (slabs[0].begin, slabs[-1].end), sum(each.cells for each in slabs)
            check(said[2] == cells, at + 16, "D6", f"{cells} cells are there")
            check(said[3:5] == times, at + 24, "D7", f"{said[3:5]}, the slabs have {times}")

    def check_vertices(self, body, vertices, low, high):
        said, at = self.summaries[body], self.at + 16 + 88 * body
        check(said[1] == vertices, at + 8, "D6", f"{vertices} vertices are there")
        check(said[5:] == low[:3] + high[:3], at + 40, "D8", f"bounds are {low[:3]}, {high[:3]}")


class Indx:
    # Scalar type and components of the arrays that have a row for each slab.
    COLUMNS = (F64, 2), (U64, 3), (U32, 1), (U64, 1), (F64, 6)

    def __init__(self, chunk):
        self.at = at = chunk.place()
        self.file_header = chunk.bytes(20)
        count, = chunk.unpack("I")
        # This array is not compressed: HEAD says whether others may be.
        copy = Array(chunk, (), "I7", (U8,), 1)
        self.head = Head(bytes(copy.data), copy.at)
        headers = Array(chunk, self.head.features, "I7", (U8,), 28).data
        columns = [Array(chunk, self.head.features, "I7", (scalar,), components)
                   for scalar, components in self.COLUMNS]
        chunk.end()
        # The headers, without their checksums, by their offsets, up to `end`.
        self.chunks, self.end = {}, 24
        for i in range(0, len(headers), 28):
            self.chunks[self.end] = bytes(headers[i:i + 28])
            self.end += 32 + padded(*struct.unpack_from("<Q", headers, i + 8))
        first = struct.unpack_from("<4s4xQ8xI", self.chunks.get(24, bytes(28)))
        check(first == (b"HEAD", len(copy.data), crc32c(copy.data)), copy.at, "I1", "another HEAD")
        slabs = [at for at, header in self.chunks.items() if header[:4] == b"SLAB"]
        check({count} == {len(slabs), *(each.rows for each in columns)}, at + 20, "I3",
              f"{count} slabs, {len(slabs)} are there")
        self.records = [Record(*times, *parts, *body, *cells, bounds[:3], bounds[3:], at)
                        for times, parts, body, cells, bounds, at
                        in zip(*map(rows_of, columns), slabs)]
        self.bodies = [[] for _ in self.head.bodies]
        for each in self.records:
            check(each.body < len(self.bodies), columns[2].at, "I4", f"body {each.body}")
            self.bodies[each.body].append(each)


def check_record(said, found, at):
    check(said[:6] == found[:6], at, "I4", f"{said[:6]}, the slab has {found[:6]}")
    check(said.cells == found.cells, at, "I5", f"{said.cells} cells, not {found.cells}")
    check(said[7:] == found[7:], at, "I6", f"bounds {said[7:9]}, not {found[7:9]}")


# Whole files --------------------------------------------------------------------------------------

PARTS = {b"CONN": lambda chunk, head, part: Conn(chunk, head.features),
         b"LAYR": lambda chunk, head, part: Layr(chunk, head), b"POSE": Pose}


class Body:
    """What is found of a body; `results` are what was made of its slabs."""

    def __init__(self):
        self.records, self.results, self.boxes, self.vertices = [], [], [], 0

    def add(self, slab, result):
        self.vertices += slab.conn.vertices - (slab.conn.lower if self.records else 0)
        self.records.append(slab.record)
        self.results.append(result)
        self.boxes.append(box(slab.vertices))


def read_all(file, use):
    """(version, Head, a Body for each) of a file that breaks no rule; calls use(slab) for each."""
    version, has_index = read_file_header(file)
    indx, done = read_ends(file) if has_index else (None, None)
    head, headers, parts, records, at = None, {}, {}, [], 24
    while True:
        check(at < file.size, at, "O3", "the file ends without DONE")
        chunk = Chunk(file, at)
        check((chunk.type == b"HEAD") == (head is None), at, "O2" if head else "O1", "HEAD, or not")
        if chunk.type == b"DONE":
            break
        check(chunk.type != b"INDX", at, "O4" if has_index else "O5", "INDX before DONE")
        if chunk.type == b"HEAD":
            head = Head(chunk.front, at + 32)
            bodies = [Body() for _ in head.bodies]
            layers = deque(maxlen=16 * len(bodies))          # offsets of the last LAYRs
        elif chunk.type in PARTS:
            parts[at] = made = PARTS[chunk.type](chunk, head, parts.get)
            check(chunk.type != b"POSE" or made.layer_at in layers, at, "K6", "far back")
            if chunk.type == b"LAYR":
                layers.append(at)
        elif chunk.type == b"SLAB":
            slab = Slab(chunk, head, parts.get)
            records.append(slab.record)
            bodies[slab.body].add(slab, use(slab))
        headers[at] = chunk.header[:28]
        at += chunk.size
    headers[at] = chunk.header[:28]
    named = {offset for each in records for offset in each.parts()}
    named.update(each.layer_at for each in parts.values() if isinstance(each, Pose))
    for offset in parts:
        check(offset in named, offset, "O6", "no slab names this part")
    if has_index:
        check(head.data == indx.head.data, indx.at + 32, "I1", "another HEAD")
        check(headers == indx.chunks, indx.at, "I2", "other headers")
        for said, found in zip(indx.records, records):
            check_record(said, found, indx.at)
    else:
        check(at + chunk.size == file.size, at + chunk.size, "O5", "bytes after DONE")
        done = Done(chunk, head)
    done.check_records([body.records for body in bodies], headers)
    for i, body in enumerate(bodies):
        done.check_vertices(i, body.vertices, *joined(body.boxes))
    return version, head, bodies


def read_slabs_at(file, time):
    """(Head, for each body a list of the slab that answers a slice, if any, and its last time)"""
    if not read_file_header(file)[1]:
        _, head, bodies = read_all(
            file, lambda slab: slab if slab.begin <= time <= slab.end else None)
        numbers = [answering(body.records, time) for body in bodies]
        return head, [([] if i is None else [body.results[i]], body.records[-1].end)
                      for i, body in zip(numbers, bodies)]
    indx, done = read_ends(file)
    done.check_records(indx.bodies, indx.chunks)
    parts, found = {}, []

    def chunk_at(offset):
        chunk = Chunk(file, offset)
        check(chunk.header[:28] == indx.chunks[offset], offset, "I2", "INDX has another header")
        return chunk

    def part(offset):
        if offset in indx.chunks and offset not in parts:
            chunk = chunk_at(offset)
            parts[offset] = chunk.type in PARTS and PARTS[chunk.type](chunk, indx.head, part)
        return parts.get(offset)

    for records in indx.bodies:
        i, answers = answering(records, time), []
        if i is not None:
            slab = Slab(chunk_at(records[i].at), indx.head, part)
            check_record(records[i], slab.record, indx.at)
            answers.append(slab)
        found.append((answers, records[-1].end))
    return indx.head, found


def answering(slabs, time):
    """The number of the slab that answers a slice (X2), or None."""
    last = slabs[-1].end
    for i, (begin, end, *_) in enumerate(slabs):
        if end > time or end == time == last:
            return i if begin <= time else None
    return None


# Answers ------------------------------------------------------------------------------------------

def describe(file):
    checksums = {}                                   # of vertices and of cells so far, by body

    def use(slab):
        before = checksums.get(slab.body, (0, 0))
        checksums[slab.body] = tuple(map(crc32c, contents(slab), before))
        return describe_slab(slab)

    version, head, bodies = read_all(file, use)
    return {"version": version, "features": head.features,
            "bodies": [describe_body(name, body, *checksums[i])
                       for i, (name, body) in enumerate(zip(head.bodies, bodies))]}


def contents(slab):
    """(bytes of all vertices, bytes of all cells)"""
    return (b"".join(struct.pack("<4d", *vertex) for vertex in slab.vertices),
            b"".join(struct.pack("<4I", *cell) for cell in slab.conn.cells))


def describe_body(name, body, vertices, cells):
    hypervolume = 0.0
    for each, _ in body.results:
        hypervolume += each
    corners = joined([(each.low, each.high) for each in body.records])
    return {"name": name, "vertices": str(body.vertices),
            "cells": str(sum(each.cells for each in body.records)),
            "begin": body.records[0].begin.hex(), "end": body.records[-1].end.hex(),
            **bounds(corners, 3), "hypervolume": hypervolume.hex(),
            "vertices_checksum": f"{vertices:08x}", "cells_checksum": f"{cells:08x}",
            "slabs": [slab for _, slab in body.results]}


def describe_slab(slab):
    """(hypervolume, description)"""
    conn, vertex, hypervolume = slab.conn, slab.vertices, 0.0
    for a, b, c, d in conn.cells:
        hypervolume += determinant4(vertex[a], vertex[b], vertex[c], vertex[d]) / 24
    return hypervolume, {
        "begin": slab.begin.hex(), "end": slab.end.hex(), "vertices": str(conn.vertices),
        "lower": str(conn.lower), "upper": str(conn.upper), "means": str(conn.means),
        "cells": str(len(conn.cells)), **bounds(slab.box, 4),
        "attributes": [{
            "domain": "vertex" if domain == 1 else "cell", "name": name, "type": str(kind),
            "components": str(components), "checksum": f"{crc32c(data):08x}"}
            for domain, name, kind, components, data in slab.attributes]}


def bounds(corners, size):
    low, high = ([each.hex() for each in corner[:size]] for corner in corners)
    return {"min": low, "max": high} if corners[0][0] < inf else {"min": None, "max": None}


def determinant4(a, b, c, d):
    """det[a, b, c, d], by the minors of a and b with those of c and d."""
    ax, ay, az, at = a
    bx, by, bz, bt = b
    cx, cy, cz, ct = c
    dx, dy, dz, dt = d
    return ((ax * by - ay * bx) * (cz * dt - ct * dz) - (ax * bz - az * bx) * (cy * dt - ct * dy)
            + (ax * bt - at * bx) * (cy * dz - cz * dy) + (ay * bz - az * by) * (cx * dt - ct * dx)
            - (ay * bt - at * by) * (cx * dz - cz * dx) + (az * bt - at * bz) * (cx * dy - cy * dx))


TIME = (0.0, 0.0, 0.0, 1.0)
UNITS = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), TIME)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]


class Hyperplane:
    """All points p with normal.p = offset, and the axes of its slices."""

    def __init__(self, normal, offset):
        self.normal, self.offset = normal, offset
        # Gram-Schmidt. The axes for x, y, z and t are the other three, in their order.
        basis = [unit(normal)]
        steepest = max(UNITS, key=lambda each: abs(dot(each, normal)))
        for axis in UNITS:
            if axis != steepest:
                for other in basis:
                    along = dot(axis, other)
                    axis = [a - along * b for a, b in zip(axis, other)]
                basis.append(unit(axis))
        self.axes = basis[1:]
        self.is_reversed = determinant4(*self.axes, normal) < 0


def unit(vector):
    length = hypot(*vector)
    return [each / length for each in vector]


def slice_at(file, plane):
    if plane.normal == TIME:
        head, found = read_slabs_at(file, plane.offset)
    else:
        _, head, bodies = read_all(file, lambda slab: slab)
        found = [(body.results, None) for body in bodies]
    return {"bodies": [describe_slice(name, *cut(slabs, plane, plane.offset == last))
                       for name, (slabs, last) in zip(head.bodies, found)]}


# A cell whose first vertices, as many as the key says, are above: the edges that are cut, so that
# they run counterclockwise seen from outside (X5), or clockwise where the hyperplane is_reversed.
# The other cases are even permutations of these.
EDGES = {1: ("01", "03", "02"), 2: ("12", "13", "03", "02"), 3: ("23", "13", "03")}
EVEN = ("0123", "1032", "2301", "3210", "0231", "0312",
        "1203", "1320", "2013", "2130", "3021", "3102")


def cut_edges(mask):
    above = {str(i) for i in range(4) if mask >> i & 1}
    order = next(order for order in EVEN if set(order[:len(above)]) == above)
    return [(int(order[int(i)]), int(order[int(k)])) for i, k in EDGES.get(len(above), ())]


# The edges for each set of vertices above, as bits.
CUTS = [cut_edges(mask) for mask in range(16)]


def cut(slabs, plane, at_last):
    """(points by what they come from, triangles of these) by marching tetrahedra."""
    points, triangles, end = {}, [], 0
    for slab in slabs:
        conn = slab.conn
        # Vertices are numbered through all slabs: those of a shared layer have one number (X3).
        first = end - conn.lower
        end = first + conn.vertices
        heights = [dot(plane.normal, point) for point in slab.vertices]
        vertices = list(zip(range(first, end), heights, slab.vertices))
        above = [h >= plane.offset if at_last else h > plane.offset for h in heights]      # X1
        for cell in conn.cells:
            a, b, c, d = cell
            corners = [cut_point(vertices[cell[i]], vertices[cell[k]], plane.offset)
                       for i, k in CUTS[above[a] + 2 * above[b] + 4 * above[c] + 8 * above[d]]]
            for i in range(2, len(corners)):
                (p, q, r) = (key for key, _ in (corners[0], corners[i - 1], corners[i]))
                if p != q and q != r and r != p:                                           # X4
                    points.update((corners[0], corners[i - 1], corners[i]))
                    triangles.append((r, q, p) if plane.is_reversed else (p, q, r))
    return {key: tuple(dot(axis, point) for axis in plane.axes)
            for key, point in points.items()}, triangles


def cut_point(p, q, offset):
    """(what it comes from, its x, y, z, t) for ends (number, height, point) in either order."""
    (a, low, start), (b, high, end) = sorted((p, q))
    if low == offset:                                                                      # X3
        return a, start
    if high == offset:
        return b, end
    s = (offset - low) / (high - low)
    return (a, b), [i + s * (k - i) for i, k in zip(start, end)]


def describe_slice(name, points, triangles):
    volume = area = 0.0
    for p, q, r in triangles:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = points[p], points[q], points[r]
        volume += (ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz)
                   + az * (bx * cy - by * cx)) / 6
        ux, uy, uz, vx, vy, vz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        area += sqrt(nx * nx + ny * ny + nz * nz) / 2
    return {"name": name, "points": str(len(points)), "triangles": str(len(triangles)),
            "volume": volume.hex(), "area": area.hex(), **bounds(box(points.values()), 3)}


def answer(path, verb, *plane):
    """(0, the answer), (1, why the file is refused) or (70, the mistake in this program)"""
    file = None
    try:
        file = File(path)
        return 0, slice_at(file, *plane) if verb == "slice" else describe(file)
    except (Invalid, OSError) as error:
        return 1, f"{path}: {error}"
    except MemoryError:
        return 1, f"{path}: not enough memory"
    except Exception as error:
        frame = error.__traceback__
        while frame.tb_next:
            frame = frame.tb_next
        return 70, f"t4d_reader.py, line {frame.tb_lineno}: {error!r}: a mistake in this program"
    finally:
        if file:
            file.stream.close()


def request_of(words):
    """("describe",) or ("slice", a Hyperplane), or None"""
    try:
        match words:
            case ["describe"]:
                return ("describe",)
            case ["slice", offset]:
                normal = TIME
            case ["slice", "x" | "y" | "z" as axis, offset]:
                normal = UNITS["xyz".index(axis)]
            case ["slice", numbers, offset]:
                normal = tuple(map(float, numbers.split(",")))
            case _:
                return None
        offset = float(offset)
    except ValueError:
        return None
    known = len(normal) == 4 and any(normal) and all(map(isfinite, (*normal, offset)))
    return ("slice", Hyperplane(normal, offset)) if known else None


def serve():
    """Answers requests line by line, such as "describe FILE" and "slice T FILE"."""
    sys.stdout.reconfigure(errors="backslashreplace")
    for line in sys.stdin.buffer:
        line = os.fsdecode(line.rstrip(b"\n"))
        # FILE may contain spaces: the request is the fewest words that make one.
        for length in (1, 2, 3):
            *words, path = line.split(" ", length)
            request = request_of(words)
            if request:
                break
        code, found = answer(path, *request) if request else (2, f"what is {line!r}?")
        if code > 1:
            print(found, file=sys.stderr)
            return code
        reply = "refuse " + " ".join(found.split()) if code else "accept " + json.dumps(found)
        print(reply, flush=True)
    return 0


def main(arguments):
    if arguments == ["--serve"]:
        return serve()
    request = request_of(arguments[1:])
    if not request:
        print("usage: t4d_reader.py FILE describe | FILE slice T | FILE slice x|y|z C | "
              "FILE slice A,B,C,D E | --serve", file=sys.stderr)
        return 2
    code, found = answer(arguments[0], *request)
    print(found if code else json.dumps(found, indent=1), file=sys.stderr if code else sys.stdout)
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

#!/usr/bin/python3 -IS
"""Reads a .t4d file as the appendix "A reader under test" of t4d/formats/t4d/SPEC.md asks:

    t4d_reader.py FILE describe     reads everything and checks every rule
    t4d_reader.py FILE slice T      reads what the slice needs, no more if the file has an index
    t4d_reader.py FILE slice x C    slices by x = C, y = C or z = C; reads and checks everything
    t4d_reader.py FILE slice A,B,C,D E      the same for A x + B y + C z + D t = E
    t4d_reader.py --serve           answers such requests from standard input, one a line

Prints one JSON object and exits with 0, or refuses the file and exits with 1; the message on
standard error then names the rule and the byte, counted from the beginning of the file. 2 is wrong
usage. A mistake in this program exits with 70: Python's own 1 would look like a refusal.

Written from SPEC.md alone, for Python 3.11 and its standard library. Python has no Zstandard before
3.14, so arrays of codec 1 are decompressed by the system's libzstd.so.1 through ctypes. Files
without such arrays do not need it.
"""
import json
import os
import struct
import sys
from array import array
from itertools import islice, repeat
from math import hypot, inf, isfinite, sqrt


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


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ CRC_TABLE[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


def padding_of(length):
    return -length % 8


# File header, chunks, footer ----------------------------------------------------------------------

SIGNATURE = b"\x89T4D\r\n\x1a\n"
TYPES = {b"HEAD", b"CONN", b"LAYR", b"SLAB", b"DONE", b"INDX"}
MAX_HEAD = 16 << 20
FOOTER_SIZE = 40


class File:
    def __init__(self, path):
        self.stream = open(path, "rb")
        self.size = self.stream.seek(0, 2)

    def read(self, at, length, rule):
        check(at + length <= self.size, at, rule, f"{length} bytes of a file of {self.size}")
        self.stream.seek(at)
        return self.stream.read(length)


class Cursor:
    """Takes a payload apart from front to back; `rule` is the one that says where it ends."""

    def __init__(self, data, at, rule):
        self.data, self.base, self.rule, self.taken = data, at, rule, 0

    def at(self):
        return self.base + self.taken

    def left(self):
        return len(self.data) - self.taken

    def bytes(self, length, rule=None):
        check(length <= self.left(), self.at(), rule or self.rule,
              f"{length} bytes are wanted, {self.left()} are left of the payload")
        self.taken += length
        return self.data[self.taken - length:self.taken]

    def unpack(self, layout):
        return struct.unpack("<" + layout, self.bytes(struct.calcsize("<" + layout)))

    def zeros(self, length, rule):
        at = self.at()
        check(not any(self.bytes(length)), at, rule, "reserved bytes or padding not zero")

    def end(self):
        check(self.left() == 0, self.at(), self.rule, f"{self.left()} bytes too many")


class Chunk:
    """A chunk, whole and with right checksums."""

    def __init__(self, file, at):
        header = file.read(at, 24, "C3")
        self.at = at
        self.type, flags, length, payload_sum, header_sum = struct.unpack("<4sIQII", header)
        check(self.type.isalnum(), at, "C1", f"chunk type {self.type}")
        check(flags <= 1, at + 4, "C2", "reserved flags set")
        self.size = 24 + length + padding_of(length)
        check(at + self.size <= file.size, at + 8, "C3", f"{length} bytes are not there")
        check(crc32c(header[:20]) == header_sum, at + 20, "C4", "header checksum")
        check(self.type != b"HEAD" or length <= MAX_HEAD, at + 8, "M1", f"HEAD of {length} bytes")
        data = file.read(at + 24, self.size - 24, "C3")
        self.payload = data[:length]
        check(crc32c(self.payload) == payload_sum, at + 16, "C5", "payload checksum")
        check(not any(data[length:]), at + 24 + length, "C6", "padding not zero")
        check(flags == 1 or self.type not in TYPES, at + 4, "C7", f"{self.type} not critical")
        check(flags == 0 or self.type in TYPES, at, "C8", f"unknown critical chunk {self.type}")

    def cursor(self, rule):
        return Cursor(self.payload, self.at + 24, rule)


def read_file_header(file):
    """(version, whether the file has an index)"""
    data = file.read(0, 24, "H1")
    check(data[:8] == SIGNATURE, 0, "H1", "this is no .t4d file")
    major, minor, flags, reserved, checksum = struct.unpack("<HHIII", data[8:])
    check(crc32c(data[:20]) == checksum, 20, "H2", "checksum of the file header")
    check(major == 1, 8, "H3", f"version {major}.{minor}, this reader knows 1.0")
    check(flags <= 1, 12, "H4", "reserved flags set")
    check(reserved == 0, 16, "H5", "reserved bytes not zero")
    return f"{major}.{minor}", flags == 1


def read_footer(file):
    """Offsets of INDX and DONE; that these are there (F4, F5) is checked where they are read."""
    at = file.size - FOOTER_SIZE
    check(at >= 24, 24, "F1", "no room for the footer")
    data = file.read(at, FOOTER_SIZE, "F1")
    indx, done, length, reserved, checksum, signature = struct.unpack("<QQQII8s", data)
    check(signature == SIGNATURE[::-1], at + 32, "F1", "no end signature: the file is cut off")
    check(crc32c(data[:28]) == checksum, at + 28, "F2", "checksum of the footer")
    check(length == file.size, at + 16, "F3", f"length {length}, the file has {file.size} bytes")
    check(reserved == 0, at + 24, "F6", "reserved bytes not zero")
    return indx, done


# Arrays and attributes ----------------------------------------------------------------------------

# Letters of the modules array and struct.
SCALARS = {1: "B", 2: "b", 3: "H", 4: "h", 5: "I", 6: "i", 7: "Q", 8: "q", 9: "f", 10: "d"}
U32, F32, F64 = 5, 9, 10
# What this reader unpacks at most, in bytes.
MAX_ARRAY = 1 << 30


class Array:
    """An array record; `data` are its bytes row after row, whatever the codec."""

    def __init__(self, cursor, features):
        self.at = at = cursor.at()
        self.type, self.components, codec = cursor.unpack("BBB")
        check(self.type in SCALARS, at, "A1", f"scalar type {self.type}")
        check(self.components > 0, at + 1, "A2", "no components")
        check(codec <= 1, at + 2, "A3", f"codec {codec}")
        cursor.zeros(5, "A4")
        self.rows, stored_size = cursor.unpack("QQ")
        stored = cursor.bytes(stored_size, "A5")
        check(padding_of(stored_size) <= cursor.left(), cursor.at(), "A5", "padding cut off")
        cursor.zeros(padding_of(stored_size), "A6")
        row = self.components * struct.calcsize("<" + SCALARS[self.type])
        size = self.rows * row
        check(codec == 1 or stored_size == size, at + 16, "A7", f"{stored_size} bytes, not {size}")
        check(codec == 0 or self.rows > 0, at + 2, "A8", "an array of no rows is compressed")
        check(size <= 1024 * stored_size, at + 8, "A9", f"{size} bytes from {stored_size}")
        if codec == 0:
            self.data = stored
        else:
            check("zstd" in features, at + 2, "A13", "HEAD does not name the feature zstd")
            check(size <= MAX_ARRAY, at + 8, "A9", f"not enough memory here for {size} bytes")
            content = decompress(stored, size, at + 24)
            self.data = bytearray(size)
            for byte in range(row):
                self.data[byte::row] = content[byte * self.rows:(byte + 1) * self.rows]

    def check_type(self, types, components, rule):
        check(self.type in types and self.components == components, self.at, rule,
              f"scalar type {self.type}, {self.components} components")

    def numbers(self):
        numbers = array(SCALARS[self.type], bytes(self.data))
        if sys.byteorder == "big":
            numbers.byteswap()
        return numbers


libzstd = None


def load_libzstd():
    global libzstd
    import ctypes
    try:
        libzstd = ctypes.CDLL("libzstd.so.1")
    except OSError as error:
        raise Invalid(f"codec 1 cannot be read here: {error}")
    size, text = ctypes.c_size_t, ctypes.c_char_p
    for name, result, *arguments in (
            ("ZSTD_findFrameCompressedSize", size, text, size),
            ("ZSTD_getDictID_fromFrame", ctypes.c_uint, text, size),
            ("ZSTD_getFrameContentSize", ctypes.c_ulonglong, text, size),
            ("ZSTD_decompress", size, text, size, text, size)):
        function = getattr(libzstd, name)
        function.restype, function.argtypes = result, arguments


def decompress(frame, size, at):
    """The content of a frame that has to have `size` bytes."""
    if libzstd is None:
        load_libzstd()
    # libzstd takes skippable frames and those of its first versions, too; RFC 8878 means this one.
    check(frame[:4] == b"\x28\xb5\x2f\xfd", at, "A10", "not a Zstandard frame")
    check(libzstd.ZSTD_findFrameCompressedSize(frame, len(frame)) == len(frame), at, "A10",
          "not one whole Zstandard frame")
    check(libzstd.ZSTD_getDictID_fromFrame(frame, len(frame)) == 0, at, "A10", "dictionary")
    declared = libzstd.ZSTD_getFrameContentSize(frame, len(frame))
    check(declared == size, at, "A11", f"the frame does not declare {size} bytes")
    # Where it fails, libzstd returns a number near 2^64.
    content = bytes(size)
    check(libzstd.ZSTD_decompress(content, size, frame, len(frame)) == size, at, "A12",
          "the frame does not decompress")
    return content


class Attribute:
    def __init__(self, cursor, features):
        self.at = at = cursor.at()
        self.domain, = cursor.unpack("B")
        check(self.domain in (1, 2), at, "T1", f"domain {self.domain}")
        cursor.zeros(3, "T2")
        length, = cursor.unpack("I")
        check(1 <= length <= 255, at + 4, "T3", f"name of {length} bytes")
        name = cursor.bytes(length, "T3")
        try:
            self.name = name.decode("utf-8")
        except UnicodeDecodeError as error:
            check(False, at + 8 + error.start, "T4", "the name is not UTF-8")
        cursor.zeros(padding_of(length), "T5")
        self.values = Array(cursor, features)


def check_attributes(attributes, conn):
    seen = set()
    for each in attributes:
        rows = conn.vertices if each.domain == 1 else conn.cell_count
        check(each.values.rows == rows, each.values.at + 8, "T6",
              f"{each.values.rows} rows for {rows} vertices or cells")
        check((each.domain, each.name) not in seen, each.at, "T7", "a name again")
        seen.add((each.domain, each.name))


# Chunks -------------------------------------------------------------------------------------------

class Head:
    FEATURES = {"zstd", "means"}
    OPTIONAL = {"generator": str, "backend": str, "length_unit": str, "time_unit": str, "up": str,
                "details": dict}

    def __init__(self, chunk):
        at = chunk.at + 24
        check(not chunk.payload.startswith(b"\xef\xbb\xbf"), at, "M2", "byte order mark")
        try:
            # Integers become doubles, for int() refuses those of more than 4,300 digits.
            head = json.loads(chunk.payload.decode("utf-8"), parse_int=float,
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
        self.features = self.strings(head, "features", at, "M5")
        for each in self.features:
            check(each in self.FEATURES, at, "M6", f"feature {each!r}, which is unknown here")
        self.bodies = self.strings(head, "bodies", at, "M7")
        check(1 <= len(self.bodies) <= 65536, at, "M7", f"{len(self.bodies)} bodies")
        for each in self.bodies:
            data = each.encode("utf-8", "ignore")
            check(data.decode("utf-8") == each, at, "M8", "a surrogate alone has no UTF-8")
            check(1 <= len(data) <= 255, at, "M8", f"name of {len(data)} bytes")
        check(len(set(self.bodies)) == len(self.bodies), at, "M9", "two bodies of one name")
        for member, kind in self.OPTIONAL.items():
            check(isinstance(head.get(member, kind()), kind), at, "M10", f"type of {member}")
        check(head.get("up", "y") in ("y", "z"), at, "M10", "up is neither y nor z")

    @staticmethod
    def strings(head, member, at, rule):
        value = head.get(member)
        check(isinstance(value, list) and all(isinstance(each, str) for each in value), at, rule,
              f"{member} is no array of strings")
        return value


class Conn:
    def __init__(self, chunk, features):
        cursor = chunk.cursor("N11")
        at = cursor.at()
        self.vertices, self.lower, self.upper, self.means, attributes = cursor.unpack("5I")
        self.interior = self.vertices - self.lower - self.upper - self.means
        check(self.interior >= 0, at, "N1", "more vertices in layers and means than in all")
        cursor.zeros(4, "N2")
        record = Array(cursor, features)
        record.check_type((U32,), 4, "N3")
        self.indices, self.cell_count = record.numbers(), record.rows
        largest = max(self.indices, default=-1)
        check(largest < self.vertices, record.at + 24, "N4", f"index {largest} of {self.vertices}")
        for i, (a, b, c, d) in enumerate(self.cells()):
            check(a != b and a != c and a != d and b != c and b != d and c != d, record.at + 24,
                  "N5", f"cell {i} has a vertex twice")
        self.sources = self.read_means(cursor, features) if self.means else []
        self.attributes = []
        for _ in range(attributes):
            each = Attribute(cursor, features)
            check(each.domain == 2, each.at, "N10", "an attribute of vertices")
            self.attributes.append(each)
        cursor.end()
        check(self.means == 0 or "means" in features, at + 12, "N12", "HEAD does not name means")
        check_attributes(self.attributes, self)

    def cells(self):
        index = iter(self.indices)
        return zip(index, index, index, index)

    def read_means(self, cursor, features):
        """A list of the sources of each mean."""
        sizes = Array(cursor, features)
        sizes.check_type((U32,), 1, "N6")
        check(sizes.rows == self.means, sizes.at + 8, "N6", f"{sizes.rows} mean sizes")
        sources = Array(cursor, features)
        sources.check_type((U32,), 1, "N6")
        lengths, numbers = sizes.numbers(), sources.numbers()
        check(min(lengths) > 0, sizes.at + 24, "N7", "a mean of nothing")
        check(sum(lengths) == len(numbers), sizes.at + 24, "N8", f"sources are {len(numbers)}")
        end = self.vertices - self.upper
        check(all(i < end - self.means or end <= i < self.vertices for i in numbers),
              sources.at + 24, "N9", "a source is a mean, or no vertex")
        rest = iter(numbers)
        return [array("I", islice(rest, length)) for length in lengths]


class Layr:
    def __init__(self, chunk, features):
        cursor = chunk.cursor("L4")
        self.time, = cursor.unpack("d")
        check(isfinite(self.time), chunk.at + 24, "L1", f"time {self.time}")
        positions = Array(cursor, features)
        positions.check_type((F32, F64), 3, "L2")
        check(positions.rows > 0, positions.at + 8, "L3", "no rows")
        cursor.end()
        self.rows, self.positions = positions.rows, positions.numbers()

    def points(self):
        return points(self.positions, repeat(self.time))


def points(positions, times):
    number = iter(positions)
    return list(zip(number, number, number, times))


class Slab:
    def __init__(self, chunk, head):
        cursor = chunk.cursor("S9")
        self.place, self.at = (chunk.at, chunk.size), chunk.at + 24
        # As they are in INDX.
        self.fields = cursor.unpack("ddQQQI")
        self.begin, self.end, self.conn, self.lower, self.upper, self.body = self.fields
        attributes, = cursor.unpack("I")
        check(isfinite(self.begin) and isfinite(self.end) and self.begin <= self.end, self.at, "S1",
              f"begin {self.begin}, end {self.end}")
        check(self.body < len(head.bodies), self.at + 40, "S4", f"body {self.body}")
        positions = Array(cursor, head.features)
        positions.check_type((F32, F64), 3, "S5")
        times = Array(cursor, head.features)
        times.check_type((F64,), 1, "S6")
        check(times.rows == positions.rows, times.at + 8, "S6", f"{times.rows} interior times")
        self.attributes = [Attribute(cursor, head.features) for _ in range(attributes)]
        cursor.end()
        self.interior = points(positions.numbers(), times.numbers())

    def assemble(self, part):
        """Makes `vertices`, a list of (x, y, z, t); part(offset) is a Conn, a Layr or None."""
        conn = part(self.conn) if self.conn < self.at else None
        check(isinstance(conn, Conn), self.at + 16, "S2", f"no CONN at {self.conn} before it")
        layers = []
        for offset, rows, time, at in ((self.lower, conn.lower, self.begin, self.at + 24),
                                       (self.upper, conn.upper, self.end, self.at + 32)):
            layer = part(offset) if 0 < offset < self.at else None
            check(offset == 0 or isinstance(layer, Layr), at, "S3", f"no LAYR at {offset}")
            found = layer.rows if layer else 0
            check(found == rows, at, "P1", f"layer of {found} vertices, not {rows}")
            check(layer is None or layer.time == time, at, "P3", f"layer not at {time}")
            layers.append(layer.points() if layer else [])
        check(len(self.interior) == conn.interior, self.at + 48, "P1",
              f"{len(self.interior)} interior vertices, not {conn.interior}")
        lower, upper = layers
        known = lower + self.interior + [None] * conn.means + upper
        means = [mean([known[i] for i in sources]) for sources in conn.sources]
        self.stored = lower + self.interior + upper
        self.vertices = lower + self.interior + means + upper
        for point in self.vertices:
            check(all(map(isfinite, point)), self.at, "P2", f"vertex {point}")
        for point in self.interior + means:
            check(self.begin <= point[3] <= self.end, self.at, "P4", f"interior vertex {point}")
        self.connectivity = conn
        self.attributes = conn.attributes + self.attributes
        check_attributes(self.attributes, conn)


def mean(sources):
    # Not sum(): from Python 3.12 on it carries the rounding errors along.
    x, y, z, t = sources[0]
    for point in sources[1:]:
        x += point[0]
        y += point[1]
        z += point[2]
        t += point[3]
    n = len(sources)
    return x / n, y / n, z / n, t / n


class Done:
    def __init__(self, chunk, head):
        cursor = chunk.cursor("D4")
        self.at = cursor.at()
        self.chunks, bodies = cursor.unpack("QI")
        check(bodies == len(head.bodies), self.at + 8, "D2", f"{bodies} bodies")
        cursor.zeros(4, "D3")
        # slabs, vertices, cells, begin, end, minimum of x, y, z, maximum of x, y, z
        self.summaries = [cursor.unpack("3Q8d") for _ in range(bodies)]
        cursor.end()

    def check_slabs(self, body, slabs):
        """`slabs` are the fields of all slabs of this body."""
        said, at = self.summaries[body], self.at + 16 + 88 * body
        check(said[0] == len(slabs) > 0, at, "D5", f"{said[0]} slabs, {len(slabs)} are there")
        times = slabs[0][0], slabs[-1][1]
        check(said[3:5] == times, at + 24, "D7", f"{said[3:5]}, the slabs have {times}")

    def check_contents(self, body, vertices, cells, corners):
        said, at = self.summaries[body], self.at + 16 + 88 * body
        check(said[1:3] == (vertices, cells), at + 8, "D6", f"{vertices} and {cells} are there")
        low, high = corners or ((inf,) * 3, (-inf,) * 3)
        check(said[5:] == low[:3] + high[:3], at + 40, "D8", f"bounds are {low[:3]}, {high[:3]}")


class Indx:
    def __init__(self, chunk):
        cursor = chunk.cursor("I1")
        self.at = cursor.at()
        count, = cursor.unpack("Q")
        check(cursor.left() == 64 * count, self.at, "I1", f"{count} records, {cursor.left()} bytes")
        self.records = []
        for _ in range(count):
            self.records.append((cursor.unpack("QQ"), cursor.unpack("ddQQQI")))
            cursor.zeros(4, "I4")

    def check_record(self, i, place, fields):
        at = self.at + 8 + 64 * i
        check(self.records[i][0] == place, at, "I2", f"offset and size of the slab are {place}")
        check(self.records[i][1] == fields, at + 16, "I3", f"the slab has {fields}")


def check_follows(before, fields, at):
    """`fields` begin at the byte `at`, in a SLAB or in INDX."""
    check(fields[3] == before[4], at + 24, "S7", f"lower is not upper before, {before[4]}")
    check(fields[0] == before[1] or fields[3] == 0 and fields[0] > before[1], at, "S8",
          f"begins at {fields[0]}, the slab before ends at {before[1]}")


# Whole files --------------------------------------------------------------------------------------

class Body:
    """What is found of a body; `results` are what was made of its slabs."""

    def __init__(self):
        self.slabs, self.results = [], []
        self.vertices = self.cells = 0
        self.corners, self.stored_corners = [], []

    def add(self, slab, result):
        conn = slab.connectivity
        if self.slabs:
            check_follows(self.slabs[-1], slab.fields, slab.at)
            self.vertices -= conn.lower
        self.slabs.append(slab.fields)
        self.results.append(result)
        self.vertices += conn.vertices
        self.cells += conn.cell_count
        self.corners = corners_of(self.corners + corners_of(slab.vertices))
        self.stored_corners = corners_of(self.stored_corners + corners_of(slab.stored))


def corners_of(points):
    """[minimum, maximum] of each coordinate, [] without a point."""
    columns = list(zip(*points))
    return [tuple(map(min, columns)), tuple(map(max, columns))] if columns else []


def read_all(file, use):
    """(version, Head, a Body for each) of a file that breaks no rule; calls use(slab) for each."""
    version, has_index = read_file_header(file)
    indx_at, done_at = read_footer(file) if has_index else (None, None)
    end = file.size - FOOTER_SIZE if has_index else file.size
    head = done = indx = None
    parts, unused, slabs = {}, {}, []
    at, count = 24, 0
    while done is None or has_index and indx is None:
        rule, missing = ("O4", "INDX") if done else ("O3", "DONE") if head else ("O1", "HEAD")
        check(at < end, at, rule, f"the chunks end without {missing}")
        chunk = Chunk(file, at)
        check(head or chunk.type == b"HEAD", at, "O1", f"the first chunk is {chunk.type}")
        check(done is None or chunk.type == b"INDX", at, "O4", f"{chunk.type} after DONE")
        if chunk.type == b"HEAD":
            check(head is None, at, "O2", "HEAD again")
            head = Head(chunk)
            bodies = [Body() for _ in head.bodies]
        elif chunk.type in (b"CONN", b"LAYR"):
            parts[at] = (Conn if chunk.type == b"CONN" else Layr)(chunk, head.features)
            unused[at] = chunk.type
        elif chunk.type == b"SLAB":
            slab = Slab(chunk, head)
            slab.assemble(parts.get)
            for offset in (slab.conn, slab.lower, slab.upper):
                unused.pop(offset, None)
            bodies[slab.body].add(slab, use(slab))
            slabs.append((slab.place, slab.fields))
        elif chunk.type == b"DONE":
            done = Done(chunk, head)
            check(done.chunks == count, done.at, "D1", f"{done.chunks} chunks, not {count}")
            check(done_at in (None, at), end + 8, "F5", f"DONE is at {at}, not {done_at}")
        elif chunk.type == b"INDX":
            check(done, at, "O4" if has_index else "O5", "INDX before DONE")
            check(indx_at == at, end, "F4", f"INDX is at {at}, not {indx_at}")
            indx = Indx(chunk)
        at += chunk.size
        count += 1
    check(at == end, at, "O4" if has_index else "O5", f"{end - at} bytes after the last chunk")
    for offset, kind in unused.items():
        check(False, offset, "O6", f"no slab names this {kind}")
    for i, body in enumerate(bodies):
        done.check_slabs(i, body.slabs)
        done.check_contents(i, body.vertices, body.cells, body.stored_corners)
    if indx:
        check(len(indx.records) == len(slabs), indx.at, "I1", f"{len(slabs)} slabs are there")
        for i, (place, fields) in enumerate(slabs):
            indx.check_record(i, place, fields)
    return version, head, bodies


def read_slabs_at(file, time):
    """(Head, for each body a list of the slab that answers a slice, if any, and its last time)"""
    if not read_file_header(file)[1]:
        def keep(slab):
            return slab if slab.begin <= time <= slab.end else None
        _, head, bodies = read_all(file, keep)
        numbers = [answering(body.slabs, time) for body in bodies]
        return head, [([] if i is None else [body.results[i]], body.slabs[-1][1])
                      for i, body in zip(numbers, bodies)]

    def chunk_at(offset, kind, rule):
        chunk = Chunk(file, offset)
        check(chunk.type == kind, offset, rule, f"{chunk.type} instead of {kind}")
        return chunk

    indx_at, done_at = read_footer(file)
    head = Head(chunk_at(24, b"HEAD", "O1"))
    done_chunk, indx_chunk = chunk_at(done_at, b"DONE", "F5"), chunk_at(indx_at, b"INDX", "F4")
    check(done_at + done_chunk.size == indx_at, indx_at, "O4", "INDX does not follow DONE")
    check(indx_at + indx_chunk.size == file.size - FOOTER_SIZE, indx_at, "O4", "no footer after it")
    done, indx = Done(done_chunk, head), Indx(indx_chunk)
    bodies = [[] for _ in head.bodies]
    for i, (_, fields) in enumerate(indx.records):
        at = indx.at + 8 + 64 * i + 16
        check(fields[5] < len(bodies), at + 40, "I3", f"body {fields[5]}")
        if bodies[fields[5]]:
            check_follows(indx.records[bodies[fields[5]][-1]][1], fields, at)
        bodies[fields[5]].append(i)
    parts, found = {}, []

    def part(offset):
        if offset not in parts:
            chunk = Chunk(file, offset)
            kind = {b"CONN": Conn, b"LAYR": Layr}.get(chunk.type)
            parts[offset] = kind and kind(chunk, head.features)
        return parts[offset]

    for body, numbers in enumerate(bodies):
        slabs = [indx.records[i][1] for i in numbers]
        done.check_slabs(body, slabs)
        i, answers = answering(slabs, time), []
        if i is not None:
            slab = Slab(chunk_at(indx.records[numbers[i]][0][0], b"SLAB", "I2"), head)
            indx.check_record(numbers[i], slab.place, slab.fields)
            slab.assemble(part)
            answers.append(slab)
        found.append((answers, slabs[-1][1]))
    return head, found


def answering(slabs, time):
    """The number of the slab that answers a slice (X2), or None."""
    last = slabs[-1][1]
    for i, (begin, end, *_) in enumerate(slabs):
        if end > time or end == time == last:
            return i if begin <= time else None
    return None


# Answers ------------------------------------------------------------------------------------------

def describe(file):
    version, head, bodies = read_all(file, describe_slab)
    return {"version": version, "features": head.features,
            "bodies": [describe_body(*each) for each in zip(head.bodies, bodies)]}


def describe_body(name, body):
    hypervolume = 0.0
    for each, _ in body.results:
        hypervolume += each
    return {"name": name, "vertices": str(body.vertices), "cells": str(body.cells),
            "begin": body.slabs[0][0].hex(), "end": body.slabs[-1][1].hex(),
            **bounds(body.corners, 3), "hypervolume": hypervolume.hex(),
            "slabs": [slab for _, slab in body.results]}


def describe_slab(slab):
    """(hypervolume, description)"""
    conn, vertex, hypervolume = slab.connectivity, slab.vertices, 0.0
    for a, b, c, d in conn.cells():
        hypervolume += determinant4(vertex[a], vertex[b], vertex[c], vertex[d]) / 24
    return hypervolume, {
        "begin": slab.begin.hex(), "end": slab.end.hex(), "vertices": str(conn.vertices),
        "lower": str(conn.lower), "upper": str(conn.upper), "means": str(conn.means),
        "cells": str(conn.cell_count), **bounds(corners_of(slab.vertices), 4),
        "attributes": [{
            "domain": "vertex" if each.domain == 1 else "cell", "name": each.name,
            "type": str(each.values.type), "components": str(each.values.components),
            "checksum": f"{crc32c(each.values.data):08x}"} for each in slab.attributes]}


def bounds(corners, size):
    low, high = ([each.hex() for each in corner[:size]] for corner in corners or ((), ()))
    return {"min": low or None, "max": high or None}


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
    """All p with normal.p = offset, and the axes of its slices."""

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
        conn = slab.connectivity
        # Vertices are numbered through all slabs: those of a shared layer have one number (X3).
        first = end - conn.lower
        end = first + conn.vertices
        heights = [dot(plane.normal, point) for point in slab.vertices]
        vertices = list(zip(range(first, end), heights, slab.vertices))
        above = [h >= plane.offset if at_last else h > plane.offset for h in heights]      # X1
        for cell in conn.cells():
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
            "volume": volume.hex(), "area": area.hex(), **bounds(corners_of(points.values()), 3)}


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

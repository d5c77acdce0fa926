"""Questions to which the answer is known: a closed form, or the answer at another scale."""

import hashlib
import json
import math
import uuid
from fractions import Fraction

from .attack import BASE_SECONDS, Run, input_class


@input_class(weight=4)
def options(attack):
    """values of options at the ends of floating point, and words in place of numbers"""
    rng = attack.rng
    value = rng.choice([repr(attack.extreme()), "nan", "inf", "-inf", "", "1e999", "0x1p3", "1,2",
                        "-5", "99999999999999999999", "\x1b[2J"])
    file = attack.pick("t4d")
    mesh, motion = attack.pick("obj"), attack.pick("motion")
    animated = attack.folder / "seeds/animated.glb"
    out = attack.path("out.t4d")
    return rng.choice([
        Run(["slice", file, f"--time={value}"], [file]),
        Run(["slice", file, f"--x={value}"], [file]),
        Run(["slice", file, f"--hyperplane={value},1,{value},2,{value}"], [file]),
        Run(["slice", file, "--time=0.5", "--velocity", f"--max-speed={value}"], [file]),
        Run(["collide", file, file, "--no-volume", f"--clearance={value}", f"--ignore={value}:a",
             f"--times={value}:1:3", "-o", attack.path("clearance.csv")], [file]),
        Run(["frames", file, "-n", 2, "--velocity", f"--fps={value}", "--format", "vtp",
             "-o", attack.path("frames")], [file]),
        Run(["flipbook", file, f"--times={value}:1:3", "-o", attack.path("out.glb")], [file]),
        Run(["flipbook", file, "-n", 2, f"--fps={value}", "-o", attack.path("out.glb")], [file]),
        Run(["sweep", mesh, "-m", motion, f"--rv-min={value}", "-o", out], [mesh, motion], out),
        Run(["sweep", mesh, "-m", motion, f"--max-deviation={value}", "-o", out],
            [mesh, motion], out),
        Run(["sweep", animated, "--mend", f"--{rng.choice(['thicken', 'max-hole', 'weld'])}={value}",
             *rng.choice([[], ["--bodies", "component"], ["--caps", "cone"]]), "-o", out], [animated], out),
        Run(["sweep", animated, "--union", "-n", 2, f"--voxel-size={value}", "-o", out], [animated], out),
        Run(["weave", *attack.seeds["vdb"], f"--frame-time={value}", "--start-time",
             repr(attack.extreme()), "-o", out], attack.seeds["vdb"], out),
        Run(["weave", *attack.seeds["vdb"], f"--iso={value}", "-o", out], attack.seeds["vdb"], out),
        Run(["simplify", file, f"--{rng.choice(['ratio', 'cells', 'max-error', 'window', 'part'])}={value}",
             "--html", attack.path("page.html"), "-o", out], [file], out),
        Run(["simplify", file, "--ratio", "0.5", f"--time-scale={value}", "-o", out], [file], out),
        Run(["track", file, f"--{rng.choice(['min-volume', 'min-duration', 'times', 'frames'])}={value}", "-o",
             attack.path("tracks.svg")], [file]),
        Run(["track", file, "--ctc", attack.path("masks"), f"--spacing={value}",
             *rng.choice([[], ["--size", value, 3, 3]]), *rng.choice([[], ["--origin", 0, value, 0]])], [file]),
        Run(["track", file, f"--part={value}", "--json"], [file]),
        Run(["track", file, rng.choice(["--contacts", "--events", "--samples"]), attack.path("rows.csv"),
             *rng.choice([[], ["--surfaces"], [f"--times={value}:1:3"]])], [file]),
        Run(["filter", file, f"--track={value}", "-o", out], [file], out),
        Run(["filter", file, "--track", rng.choice([1, 1, 2, 7]), "-o", out], [file], out),
        Run(["view", file, "--tracks", rng.choice([motion, file, mesh]), "-o", attack.path("page.html")],
            [file, motion, mesh]),
    ])


@input_class(weight=2)
def slice_velocities(attack):
    """slices of meshes at any scale of space and time: the flux of the velocity is the rate of the
    volume, and no vertex is faster than it may be"""
    rng = attack.rng
    source = attack.pick("t4d")
    file = attack.path("scaled.t4d")
    scales = [repr(10 ** rng.uniform(-12, 12)) for _ in range(2)]
    made = attack.t4d("transform", source, "--scale", scales[0], "--time-scale", scales[1], "-q",
                      "-o", file)
    if not made.succeeded:
        return Run(["info", source], [source])
    about = attack.t4d("info", file, "--json").json
    begin, end = about["time_begin"], about["time_end"]
    part = (end - begin) * 1e-5
    time = rng.uniform(begin + 2 * part, end - 2 * part)

    def at(moment):
        return attack.t4d("slice", file, "-t", repr(moment), "--json").json

    most = repr(10 ** rng.uniform(-3, 3))
    def check(result):
        if not result.succeeded:
            return [f"no velocity: {result.err}"]
        found = result.json
        rate = (at(time + part)["volume"] - at(time - part)["volume"]) / (2 * part)
        scale = found["area"] * max(found["area"], 1e-300) ** 0.5 / (end - begin)
        problems = []
        if abs(rate - found["volume_rate"]) > 1e-2 * (scale + abs(rate)):
            problems.append(f"the flux is {found['volume_rate']!r}, the rate of the volume {rate!r}")
        if found["max_speed"] > float(most) * (1 + 1e-12):
            problems.append(f"a vertex has {found['max_speed']!r}, at most {most}")
        return problems

    return Run(["slice", file, "-t", repr(time), "--velocity", "--max-speed", most, "--json"],
               [file], check=check)


@input_class(weight=1)
def simplified_parts(attack):
    """a mesh that is simplified in parts of any windows: joined they are closed, with its hypervolume"""
    rng = attack.rng
    file = attack.pick("t4d")
    whole = attack.t4d("validate", file, "--json").json
    count = rng.randrange(1, 5)
    how = rng.choice([["--ratio", repr(rng.uniform(0.05, 1))],
                      ["--max-error", repr(10 ** rng.uniform(-4, 0))]])
    how += ["--time-scale", repr(2.0 ** rng.randrange(-2, 3)), "--window", rng.randrange(1, 5)]
    parts = []
    for k in range(1, count + 1):
        parts.append(attack.path(f"part-{k}.t4d"))
        command = ["simplify", file, *how, "--part", f"{k}/{count}", "-o", parts[-1], "-q"]
        if attack.t4d(*command).code not in (0, 3):  # more parts than windows: it must be refused well
            return Run(command, [file], parts[-1])
    out = attack.path("out.t4d")
    def check(result):
        if not result.succeeded:
            return [f"parts do not join: {result.err}"]
        joined = attack.t4d("validate", out, "--json").json
        difference = abs(joined["hypervolume"] - whole["hypervolume"])
        sound = joined["valid"] and difference <= 1e-9 * abs(whole["hypervolume"])
        return [] if sound else [f"joined: {joined['valid']}, hypervolume {joined['hypervolume']!r} "
                                 f"instead of {whole['hypervolume']!r}"]
    return Run(["join", *parts, "-o", out], parts, out, check=check)


@input_class(weight=2)
def reports_of_parts(attack):
    """reports on parts, one of them missing, twice, of another run, or altered: good ones join to the
    report on the whole, others are refused"""
    rng = attack.rng
    file = attack.pick("t4d")
    verb = rng.choice([["validate", file], ["validate", file, "--deep"], ["quality", file],
                       ["measure", file, "--frames", 8], ["track", file]])
    count = rng.randrange(1, 1 + min(6, attack.t4d(*verb, "--most-parts").json["parts"]))

    def report(name, *command):
        path = attack.path(name)
        path.write_text(attack.t4d(*command, "--json").out)
        return path

    parts = [report(f"{k}.json", *verb, "--part", f"{k}/{count}") for k in range(1, count + 1)]
    at = rng.randrange(count)
    fault = rng.choice(["none", "missing", "twice", "count", "options", "input", "whole", "text", "bytes"])
    if fault == "missing" and count == 1:
        fault = "none"
    elif fault == "missing":
        del parts[at]
    elif fault == "twice":
        parts.append(parts[at])
    elif fault == "count":
        parts.append(report("other.json", "measure", file, "--frames", 9, "--part", "1/9"))
    elif fault == "options":
        parts[at] = report("other.json", *verb, "--threads", 1, "--part", f"{at + 1}/{count}")
        fault = "none"  # the number of threads changes nothing
    elif fault == "input":
        parts.append(report("other.json", verb[0], attack.pick("moved"), *verb[2:], "--part", f"{at + 1}/{count}"))
    elif fault == "whole":
        parts[at] = report("other.json", *verb)
    elif fault == "text":
        parts[at] = attack.altered_text(parts[at], "altered.json")
    elif fault == "bytes":
        parts[at], _ = attack.altered(parts[at], "altered.json")
    rng.shuffle(parts)
    whole = attack.t4d(*verb, "--json").out

    def check(result):
        if fault != "none":
            return []
        return [] if result.out == whole else [f"joined {result.out!r} in place of {whole!r}"]

    refused = fault not in ("none", "text", "bytes")
    return Run(["join", *parts], parts, expect={1, 4} if refused else None, check=check)


@input_class(weight=1)
def parts_of_files(attack):
    """a file compressed in parts, one of them missing, twice, of other bytes, or altered: good ones join
    to the whole, with gaps and overlaps they are refused"""
    rng = attack.rng
    file = attack.pick("t4d")
    most = attack.t4d("compress", file, "-o", attack.path("x.t4d"), "--most-parts").json["parts"]
    count = rng.randrange(1, 1 + min(5, most))
    parts = [attack.path(f"{k}.t4d") for k in range(1, count + 1)]
    for k, part in enumerate(parts, 1):
        attack.t4d("compress", file, "--part", f"{k}/{count}", "-o", part, "-q")
    at = rng.randrange(count)
    fault = rng.choice(["none", "gap", "twice", "disorder", "altered"])
    if fault == "gap" and 0 < at < count - 1:
        del parts[at]
    elif fault == "twice":
        parts.insert(at, parts[at])
    elif fault == "disorder" and count > 1:
        parts.reverse()
    elif fault == "altered":
        parts[at], different = attack.altered(parts[at], "altered.t4d")
        fault = "altered" if different else "none"
    else:
        fault = "none"
    out = attack.path("out.t4d")

    def check(result):
        if fault != "none" or not result.succeeded:
            return [] if fault != "none" else [f"parts do not join: {result.err}"]
        level = attack.t4d("diff", file, out, "--json").json["level"]
        return [] if level in ("bytes", "mesh") else [f"joined, it differs by {level}"]

    return Run(["join", *parts, "-o", out], parts, out, must_fail=fault != "none", check=check)


def with_own_uuid(path):
    """Gives a .vdb the UUID of its bytes, as t4d does, whatever they are."""
    data = bytearray(path.read_bytes())
    if len(data) >= 57:
        data[21:57] = b"0" * 36
        name = hashlib.sha1(uuid.NAMESPACE_OID.bytes + data).digest()[:16]
        data[21:57] = str(uuid.UUID(bytes=name, version=5)).encode()
    path.write_bytes(data)


@input_class(weight=2)
def parts_of_fields(attack):
    """fields of an envelope in parts, one of them missing, twice, of another run, altered, or altered
    behind a UUID that is right: good ones join to the bytes of the whole, others are refused"""
    rng = attack.rng
    field = rng.choice(["--visits", "--dwell", "--first", "--last"])

    def make(name, *options, size=2.5):
        path = attack.path(name)
        attack.t4d("envelope", attack.seeds["t4d"][0], "--voxel-size", size, field, path, *options)
        return path

    most = attack.t4d("envelope", attack.seeds["t4d"][0], "--voxel-size", 2.5, "--most-parts").json
    count = rng.randrange(1, 1 + min(4, most["parts"]))
    parts = [make(f"{k}.vdb", "--part", f"{k}/{count}") for k in range(1, count + 1)]
    at = rng.randrange(count)
    fault = rng.choice(["none", "missing", "twice", "run", "whole", "altered", "sealed", "sealed"])
    if fault == "missing" and count > 1:
        del parts[at]
    elif fault == "twice":
        parts.append(parts[at])
    elif fault == "run":
        parts.append(make("other.vdb", "--part", f"{at + 1}/{count}", size=2.4))
    elif fault == "whole":
        parts[at] = make("other.vdb")
    elif fault in ("altered", "sealed"):
        parts[at], different = attack.altered(parts[at], "altered.vdb")
        fault = fault if different else "none"
    else:
        fault = "none"
    if fault == "sealed":
        with_own_uuid(parts[at])
    rng.shuffle(parts)
    out = attack.path("out.vdb")

    def check(result):
        if fault != "none":
            return []
        if not result.succeeded:
            return [f"parts do not join: {result.err}"]
        same = out.read_bytes() == make("whole.vdb").read_bytes()
        return [] if same else ["joined, it differs from the whole"]

    return Run(["join", *parts, "-o", out], parts, out,
               expect=None if fault in ("none", "sealed") else {4}, check=check)


@input_class(weight=1)
def times_files(attack):
    """lists and tables of times: any separators, words, empty lines, millions of rows, bytes that are no
    text; what `measure` says of a good list is one row a time, in its order"""
    rng = attack.rng
    file = attack.pick("t4d")
    path = attack.path("times.csv")
    bad = rng.random() < 0.5
    info = attack.t4d("info", file, "--json").json
    begin, end = info["time_begin"], info["time_end"]
    times = [begin + (end - begin) * rng.random() for _ in range(rng.randrange(1, 6))]
    separator = rng.choice([",", ";", "\t", " ", ", "])
    lines = [separator.join(["frame", "time"])] if rng.random() < 0.5 else []
    lines += [separator.join([str(i), repr(t)] if lines and lines[0].startswith("frame") else [repr(t)])
              for i, t in enumerate(times)]
    if bad:
        at = rng.randrange(len(lines))
        lines[at] = rng.choice(["", "#", "x", "nan", "inf", "1e999", "time", "\0", "\x1b[2J", "-", "1e-400",
                                repr(attack.extreme()), separator * 3, "9" * 5000, "1\n" * 300_000])
    text = rng.choice(["\n", "\r\n"]).join(lines).encode()
    path.write_bytes(b"\xef\xbb\xbf" + text if rng.random() < 0.2 else text)
    if bad and rng.random() < 0.3:
        path, _ = attack.altered(path, "altered.csv")
    def check(result):
        if bad or not result.succeeded:
            return [] if bad else [f"refused a good list: {result.err}"]
        found = [sample["time"] for sample in result.json["samples"]]
        return [] if found == times else [f"measured {found} in place of {times}"]
    return Run(["measure", file, "--times-file", path, "--json"], [file, path], check=check)


@input_class(weight=1)
def speed_files(attack):
    """curves of time or speed over playback: rows in disorder, numbers at the ends of floating point, bytes
    that are no text; the frames of a good curve have its times"""
    rng = attack.rng
    file = attack.pick("t4d")
    path, out = attack.path("curve.csv"), attack.path("frames")
    bad = rng.random() < 0.5
    info = attack.t4d("info", file, "--json").json
    begin, end = info["time_begin"], info["time_end"]
    # Rows at whole frames, of a mesh whose time passes at most twice as fast as at an even pace.
    steps = [rng.randrange(1, 4) for _ in range(rng.randrange(1, 5))]
    frames = [sum(steps[:i]) for i in range(len(steps) + 1)]
    is_speed = rng.random() < 0.5
    pace = (end - begin) / (2 * frames[-1])
    values = [pace * 2 * rng.random() if is_speed else begin + (end - begin) * rng.random() for _ in frames]
    separator = rng.choice([",", ";", "\t", " ", ", "])
    start = rng.choice([0, 0, 10, -3])
    rows = [[str(start + frame), repr(value)] for frame, value in zip(frames, values)]
    lines = [separator.join(row) for row in [["playback", "speed" if is_speed else "time"], *rows]]
    if bad:
        at = rng.randrange(len(lines))
        lines[at] = rng.choice(["", "#", "x", "nan,1", "1,inf", "time,playback", "\0", "\x1b[2J", "1e308,0", "0,1e308",
                                "-1e308,1e308", f"{attack.extreme()!r},{attack.extreme()!r}", "5,5,5", "9" * 5000,
                                "0,0\n" * 300_000])
    path.write_bytes(rng.choice(["\n", "\r\n"]).join(lines).encode())
    if bad and rng.random() < 0.3:
        path, _ = attack.altered(path, "altered.csv")

    def time_at(frame):
        at = max(i for i in range(len(steps)) if frames[i] <= frame)
        if not is_speed:
            return values[at] + (values[at + 1] - values[at]) * (frame - frames[at]) / steps[at]
        time = begin + sum((values[i] + values[i + 1]) / 2 * steps[i] for i in range(at))
        passed = frame - frames[at]
        return time + values[at] * passed + (values[at + 1] - values[at]) * passed**2 / (2 * steps[at])

    def check(result):
        if bad or not result.succeeded:
            return [] if bad else [f"refused a good curve: {result.err}"]
        found = [frame["time"] for frame in json.loads((out / "manifest.json").read_text())["frames"]]
        expected = [time_at(frame) for frame in range(frames[-1] + 1)]
        near = len(found) == len(expected) and all(
            math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-9 * max(abs(begin), abs(end)))
            for a, b in zip(found, expected))
        return [] if near else [f"showed {found} in place of {expected}"]
    return Run(["frames", file, "--speed-file", path, "--fps", 1, "--format", "ply", "--json", "-o", out],
               [file, path], check=check)


def pentachoron(attack, scale, far):
    """Corners, cells facing outward, and 24 times the hypervolume, of a simplex that is cut into
    five about a point inside; `far` moves a corner or that point along some axes."""
    rng = attack.rng
    corners = [[float(axis == i) for axis in range(4)] for i in range(4)] + [[0.0] * 4]
    cells = [[c for c in range(5) if c != out] for out in range(5)]
    # A pyramid over each tetrahedron of one side makes vertices that can be moved.
    corners.append([0.1, 0.2, 0.15, 0.1])
    split = cells.pop()
    cells += [[5 if c == out else c for c in split] for out in split]
    if far:
        moved = rng.randrange(len(corners))
        for axis in rng.sample(range(4), rng.randrange(1, 5)):
            corners[moved][axis] = far * rng.choice([-1, 1, 0.7])
    corners = [[c * scale for c in corner] for corner in corners]
    if rng.random() < 0.3:
        corners = [[c + scale for c in corner] for corner in corners]
    exact = [[Fraction(c) for c in corner] for corner in corners]

    # Neighbours agree if each triangle is gone through both ways round.
    oriented, waiting = [list(cells[0])], [list(c) for c in cells[1:]]
    def triangles(cell):
        for i in range(4):
            rest = [c for k, c in enumerate(cell) if k != i]
            order = sorted(rest)
            inversions = sum(rest[a] > rest[b] for a in range(3) for b in range(a + 1, 3))
            yield tuple(order), (inversions + i) % 2
    while waiting:
        known = {t for cell in oriented for t in triangles(cell)}
        for cell in waiting:
            shared = [(t, p) for t, p in triangles(cell)
                      if (t, p) in known or (t, 1 - p) in known]
            if shared:
                if shared[0] in known:
                    cell[2], cell[3] = cell[3], cell[2]
                oriented.append(cell)
                waiting.remove(cell)
                break
    def determinant(rows):
        if len(rows) == 1:
            return rows[0][0]
        return sum((-1) ** j * rows[0][j] * determinant([r[:j] + r[j + 1:] for r in rows[1:]])
                   for j in range(len(rows)) if rows[0][j])
    volume = sum(determinant([exact[c] for c in cell]) for cell in oriented)
    if volume < 0:
        for cell in oriented:
            cell[2], cell[3] = cell[3], cell[2]
    return corners, oriented, abs(volume)


def write4d(attack, corners, cells):
    """A 4D mesh in one of the formats that are easy to write."""
    kind = attack.rng.choice(["tetgen", "vtu", "gmsh", "medit", "ijk"])
    lines = [" ".join(map(repr, c)) for c in corners]
    if kind == "tetgen":
        node, ele = attack.path("m.node"), attack.path("m.ele")
        node.write_text(f"{len(corners)} 3 1 0\n" + "".join(
            f"{i} {line}\n" for i, line in enumerate(lines)))
        ele.write_text(f"{len(cells)} 4 0\n" + "".join(
            f"{i} {' '.join(map(str, c))}\n" for i, c in enumerate(cells)))
        return node
    if kind == "ijk":
        path = attack.path("m.off")
        path.write_text(f"4OFF\n{len(corners)} {len(cells)} 0\n" + "\n".join(lines) + "\n"
                        + "".join(f"4 {' '.join(map(str, c))}\n" for c in cells))
        return path
    if kind == "medit":
        path = attack.path("m.mesh")
        path.write_text(
            f"MeshVersionFormatted 2\nDimension 4\nVertices\n{len(corners)}\n"
            + "".join(line + " 0\n" for line in lines) + f"Tetrahedra\n{len(cells)}\n"
            + "".join(" ".join(str(c + 1) for c in cell) + " 0\n" for cell in cells) + "End\n")
        return path
    if kind == "gmsh":
        path = attack.path("m.msh")
        n, m = len(corners), len(cells)
        path.write_text(
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n"
            + f"1 {n} 1 {n}\n3 1 0 {n}\n" + "".join(f"{i + 1}\n" for i in range(n))
            + "".join(" ".join(map(repr, c[:3])) + "\n" for c in corners)
            + f"$EndNodes\n$Elements\n1 {m} 1 {m}\n3 1 4 {m}\n" + "".join(
                f"{i + 1} {' '.join(str(c + 1) for c in cell)}\n" for i, cell in enumerate(cells))
            + '$EndElements\n$NodeData\n1\n"time"\n1\n0\n3\n0\n1\n' + f"{n}\n"
            + "".join(f"{i + 1} {c[3]!r}\n" for i, c in enumerate(corners)) + "$EndNodeData\n")
        return path
    path = attack.path("m.vtu")
    arrays = lambda values: " ".join(map(str, values))
    path.write_text(
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian">'
        f'<UnstructuredGrid><Piece NumberOfPoints="{len(corners)}" '
        f'NumberOfCells="{len(cells)}"><PointData><DataArray type="Float64" Name="t" '
        f'format="ascii">{arrays(c[3] for c in corners)}</DataArray></PointData><Points>'
        '<DataArray type="Float64" NumberOfComponents="3" format="ascii">'
        f'{arrays(x for c in corners for x in c[:3])}</DataArray></Points><Cells>'
        '<DataArray type="Int64" Name="connectivity" format="ascii">'
        f'{arrays(c for cell in cells for c in cell)}</DataArray>'
        '<DataArray type="Int64" Name="offsets" format="ascii">'
        f'{arrays(4 * i + 4 for i in range(len(cells)))}</DataArray>'
        '<DataArray type="UInt8" Name="types" format="ascii">'
        f'{arrays(10 for _ in cells)}</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>')
    return path


@input_class(weight=5)
def scales(attack):
    """4D meshes of any size and with vertices far away in other formats: the hypervolume is the
    closed form; `mend`, `collide`, `compare`, `quality` and `diff` of scaled meshes: the scaled
    results"""
    rng = attack.rng
    if rng.random() < 0.5:
        scale = 2.0 ** rng.randrange(-230, 231) if rng.random() < 0.7 else 1.0
        far = rng.choice([0, 0, 1e5, 1e20, 1e60]) if scale < 1e9 else 0
        corners, cells, volume = pentachoron(attack, scale, far)
        if rng.random() < 0.5:
            cells = [[a, b, d, c] for a, b, c, d in cells]
        source, output = write4d(attack, corners, cells), attack.path("out.t4d")

        def judge(result):
            if not result.succeeded:
                return []
            if volume == 0:
                return ["a mesh without hypervolume passed"]
            found = attack.t4d("validate", output, "--json").json["hypervolume"]
            expected = float(volume / 24)
            if found is None or not math.isclose(found, expected, rel_tol=1e-9):
                return [f"the hypervolume is {found}, expected {expected}"]
            return []
        most = max(abs(c) for corner in corners for c in corner)
        expect = None if most > 1e70 or volume == 0 else {0, 3}
        return Run(["convert", source, output], [source], output, check=judge, expect=expect)

    exponent = rng.randrange(-230, 231) if rng.random() < 0.8 else rng.randrange(-480, 481)
    scale = 2.0 ** exponent
    kind = rng.choice(["mend", "collide", "compare", "quality", "diff"])
    if kind == "mend":
        lines = attack.pick("cube").read_text().splitlines()
        if rng.random() < 0.5:
            lines.remove(rng.choice([l for l in lines if l.startswith("f ")]))
        unit, mesh = attack.path("unit.obj"), attack.path("mesh.obj")
        unit.write_text("\n".join(lines))
        mesh.write_text("\n".join(
            "v " + " ".join(repr(float(c) * scale) for c in l.split()[1:4])
            if l.startswith("v ") else l for l in lines))
        powers = {"volume_before": 3, "volume_after": 3, "hausdorff": 1}
        command = lambda path, out: ["mend", path, "-o", attack.path(out), "--json"]
        files, units = [mesh], [unit]
    else:
        units = [attack.seeds["t4d"][0], attack.seeds["moved"][0]]
        files = [attack.path(unit.name) for unit in units]
        for unit, file in zip(units, files):
            enlarge = ["transform", unit, "--scale", repr(scale), "-o", file]
            if not attack.t4d(*enlarge).succeeded:
                return Run(enlarge, [unit], expect={2, 4})
        if kind == "quality":
            del files[1], units[1]
        powers = {"overlap_volume": 3, "overlap_volume_error": 3, "min_clearance": 1,
                  "min_clearance_bound": 1, "chord_bound": 1, "depth": 1, "clear_by": 1,
                  "volume_a": 3, "volume_b": 3, "area_a": 2, "area_b": 2, "hausdorff": 1,
                  "difference": 3, "hypervolume": 3, "time_scale": 1}
        command = lambda *paths: [kind, *paths[:len(files)], *(
            ["--slices", "3"] if kind == "compare" else []), "--json"]
    first = attack.t4d(*command(*units, "unit.ply"))

    def numbers(value, key=""):
        if isinstance(value, dict):
            for name in sorted(value):
                yield from numbers(value[name], name)
        elif isinstance(value, list):
            for one in value:
                yield from numbers(one, key)
        elif key in powers or isinstance(value, str) and key == "verdict":
            yield key, value

    def judge(result):
        if result.code != first.code or not result.out:
            return []
        expected, found = list(numbers(first.json)), list(numbers(result.json))
        if len(found) != len(expected):
            return [f"{len(found)} numbers, expected {len(expected)}"]
        for (key, a), (_, b) in zip(found, expected):
            if isinstance(b, str) or b is None:
                if a != b:
                    return [f"{key} is {a}, expected {b}"]
                continue
            scaled = Fraction(b) * Fraction(scale) ** powers[key]
            if a is None or not math.isfinite(a):
                if abs(scaled) < 1e300:
                    return [f"{key} is {a}, expected {float(scaled)}"]
            elif abs(Fraction(a) - scaled) > abs(scaled) / 10 ** 6 + Fraction(5e-324):
                return [f"{key} is {a}, expected {b} * 2^{exponent * powers[key]}"]
        return []
    # The exit code of `diff` says whether they differ.
    return Run(command(*files, "out.ply"), files, check=judge, expect={first.code, 1, 4})


def box(attack, name, sides, middle=(0, 0, 0)):
    """A box as .obj."""
    path = attack.path(name)
    lines = [f"v {middle[0] + (i & 1 or -1) * sides[0] / 2!r} "
             f"{middle[1] + (i >> 1 & 1 or -1) * sides[1] / 2!r} "
             f"{middle[2] + (i >> 2 & 1 or -1) * sides[2] / 2!r}" for i in range(8)]
    lines += ["f 1 3 4 2", "f 5 6 8 7", "f 1 2 6 5", "f 3 7 8 4", "f 1 5 7 3", "f 2 4 8 6"]
    path.write_text("\n".join(lines) + "\n")
    return path


def swept(attack, name, mesh, segment, *options):
    """The file of the box swept by a segment; None if the program refuses that."""
    motion = attack.path(name + ".json")
    motion.write_text(json.dumps({"segments": [segment]}))
    output = attack.path(name + ".t4d")
    done = attack.t4d("sweep", mesh, "-m", motion, "-o", output, "-q", *options)
    return output if done.code == 0 else None


@input_class(weight=2)
def envelopes(attack):
    """envelopes of sheets, rods and boxes of all sizes and places, with voxels of all sizes;
    `--outside`, `--simplify` and `--exact` against closed forms"""
    rng = attack.rng
    scale = 10 ** rng.choice([0, 0, 0, rng.uniform(-30, 30)])
    sides = [scale * 10 ** rng.choice([0, 0, -1, -2, -4]) * rng.uniform(0.5, 2)
             for _ in range(3)]
    far = scale * rng.choice([0, 0, 1, 1e3, 1e6])
    mesh = box(attack, "box.obj", sides, (far, 0, 0))
    turn = rng.choice([0, 0, 5, 90, 170, 360]) * 1.0
    move = [scale * rng.choice([0, 0.1, 3]) * rng.uniform(-1, 1) for _ in range(3)]
    steps = rng.choice([1, 2, 7])
    if turn == 170:
        steps = max(steps, 2)
    known = turn <= 180 * steps  # poses tell no more than half a turn
    segment = {"duration": 1, "translation": move}
    if turn:
        # About an axis through the box, of which the chords' bound is known.
        segment |= {"axis_point": [far, 0, 0], "axis_direction": [0, 0, 1],
                    "angle_degrees": turn, "translation": [0, 0, move[2]]}
    file = swept(attack, "box", mesh, segment, "--steps", steps, "--caps", "cone")
    if file is None:
        return Run(["info", attack.pick("t4d")], [])
    size = max(sides) * 10 ** rng.uniform(-3, 1)
    how = rng.choice([[], ["--outside"], ["--outside"], ["--exact"],
                      ["--voxel-size", repr(size)], ["--outside", "--voxel-size", repr(size)],
                      ["--voxel-size", repr(abs(attack.extreme()) or 1)]])
    asked = None
    if "--exact" not in how and rng.random() < 0.2:
        asked = rng.choice([4, 12, 100, 1000])
        how = [*how, "--simplify", asked]
    if "--exact" in how and turn and steps > 1:
        how = []  # a thousand triangles that cross each other may take minutes
    output = attack.path("out" + rng.choice([".ply", ".stl", ".glb"]))
    half = math.radians(turn / steps) / 2
    radius = math.hypot(sides[0], sides[1]) / 2
    bound = radius * (1 - math.cos(half)) + 2 * radius * math.sin(half) / 6

    def check(result):
        value = result.json
        if not result.succeeded or value is None:
            return []
        problems = []
        if not value["closed"] or value["self_intersections"]:
            problems.append("the envelope is open or crosses itself")
        chord = value["chord_bound"]
        if not known:
            if chord is not None or (value["outside"] and result.code != 3):
                problems.append(f"chord_bound {chord} of a step of a whole turn")
        elif chord is None or abs(chord - bound) > 1e-6 * bound + 1e-9 * far * half:
            problems.append(f"chord_bound {chord}, but it is {bound}")
        volume = sides[0] * sides[1] * sides[2]
        if value["outside"]:
            if not turn:
                volume = value["visits_volume"]
            if value["volume"] < volume * (1 - 1e-6):
                problems.append(f"--outside has a volume of {value['volume']}, less than {volume}")
            if asked and value["triangles"] > asked and result.code != 3:
                problems.append(f"{value['triangles']} triangles, more than {asked}")
            if known and value["outside_by"] < chord:
                problems.append("outside_by is less than the bound of chords")
        if "--exact" in how and not turn:
            # Vertices of some formats are rounded to float32.
            rounding = 0 if output.suffix == ".ply" else 2 ** -23 * (far + max(sides) + scale * 3)
            if (abs(value["volume"] - value["visits_volume"]) >
                    (1e-6 + 8 * rounding / min(sides)) * value["visits_volume"]):
                problems.append("the exact volume is not that of the box and its shadow")
        return problems
    return Run(["envelope", file, *how, "--json", "--max-memory", "1", "-o", output], [file],
               output, check=check, seconds=2 * BASE_SECONDS)


@input_class(weight=2)
def contacts(attack):
    """a bar that moves past a wall at a known distance: clearances about it, and what `resolve`
    leaves, against the closed form"""
    rng = attack.rng
    scale = 10 ** rng.choice([0, 0, 0, rng.uniform(-12, 12)])
    length = scale * rng.uniform(1, 10)
    width = scale * 10 ** rng.uniform(-3, 0)
    gap = scale * rng.choice([0.2, 10 ** rng.uniform(-6, 0)])
    turn = rng.random() < 0.7
    # The corners of the bar that turns reach the circle about its axis.
    reach = math.hypot(length, width) / 2 if turn else width / 2
    bar = swept(attack, "bar", box(attack, "bar.obj", (length, width, scale)), (
        {"duration": 1, "axis_direction": [0, 0, 1], "angle_degrees": 180.0} if turn else
        {"duration": 1, "translation": [length * rng.uniform(-1, 1), 0, 0]}),
        "--steps", rng.choice([5, 20, 100]))
    wall = swept(attack, "wall", box(attack, "wall.obj", (4 * length, scale, scale),
                                       (0, reach + gap + scale / 2, 0)), {"duration": 1})
    if bar is None or wall is None:
        return Run(["info", attack.pick("t4d")], [])
    rounding = 1e-12 * (length + scale)
    clearance = gap * rng.choice([0, 0.5, 0.99, 1, 1.01, 2, 10 ** rng.uniform(-3, 3)])

    def check_collide(result):
        value = result.json
        if value is None:
            return []
        pair = value["pairs"][0]
        problems = []
        if pair["keeps_clearance"] and clearance > gap + rounding:
            problems.append(f"{clearance} is said to be kept, but the gap is {gap}")
        if pair["breaks_clearance"] and clearance < gap - rounding:
            problems.append(f"{clearance} is said to be broken, but the gap is {gap}")
        if pair["clear_by"] > gap + rounding:
            problems.append(f"clear by {pair['clear_by']}, but the gap is {gap}")
        if pair["keeps_clearance"] != (pair["clear_by"] >= clearance):
            if not (clearance == 0 and pair["verdict"] == "within-tolerance"):
                problems.append("clear_by contradicts keeps_clearance")
        if pair["verdict"] in ("hit", "touch") and gap > rounding:
            problems.append(f"a {pair['verdict']}, but the gap is {gap}")
        fails = (pair["contact"] or pair["verdict"] == "within-tolerance"
                 or not pair["keeps_clearance"])
        if result.code != (1 if fails else 0):
            problems.append(f"exit code {result.code} contradicts the verdict")
        return problems

    output = attack.path("out.t4d")

    def check_resolve(result):
        if result.code != 0:
            return []
        enough = result.json["deciding_clearance"]
        code = attack.t4d("collide", wall, output, "--fail-on-contact").code
        # A mesh that was changed no longer has the poses that tell its true motion: it counts as it is.
        if (code == 0) != (enough is None or result.json["changed"]):
            return [f"deciding_clearance is {enough}, but collide ends with {code}"]
        if enough is None:
            return []
        last = attack.path("last.t4d")
        again = attack.t4d("resolve", wall, bar, "--clearance", repr(enough), "--json", "-o", last)
        if again.code != 0:
            return []  # no way out
        if (again.json["deciding_clearance"] is not None
                or attack.t4d("collide", wall, last, "--fail-on-contact").code != 0):
            return [f"--clearance {enough} does not decide it"]
        return []

    if rng.random() < 0.7:
        return Run(["collide", bar, wall, "--clearance", repr(clearance), "--fail-on-contact",
                    "--json"], [bar, wall], check=check_collide)
    some = rng.choice([[], [], ["--clearance", repr(clearance)]])
    return Run(["resolve", wall, bar, *some, "--json", "-o", output], [wall, bar], output,
               check=check_resolve)


@input_class(weight=1)
def merges(attack):
    """files of any bodies merged, some scaled, altered or of other units: the cells of all of them
    are there, and every body is what it was"""
    rng = attack.rng
    files = []
    for i in range(rng.randrange(1, 4)):
        file = attack.path(f"part{i}.t4d")
        options = rng.choice([["--scale", "2"], ["--move", "1", "2", "3"], ["--length-unit", "in"]])
        source = attack.pick("t4d")
        if not attack.t4d("transform", source, *options, "-q", "-o", file).succeeded:
            file = source
        files.append(file)
    if rng.random() < 0.3:
        files[-1], _ = attack.altered(files[-1], "altered.t4d")
    output = attack.path("out.t4d")

    def check(result):
        if not result.succeeded:
            return []
        found = result.json
        wanted = [attack.t4d("info", file, "--json").json for file in files]
        cells = sum(one["tetrahedra"] for one in wanted)
        problems = [] if found["tetrahedra"] == cells else [f"{cells} cells, not {found}"]
        names = [body["name"] for body in found["bodies"]]
        if len(set(names)) != len(names):
            problems.append(f"names are not unique: {names}")
        return problems
    return Run(["merge", *files, "--json", "-o", output], files, output, check=check)

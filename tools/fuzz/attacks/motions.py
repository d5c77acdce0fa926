"""Motions: segments, tables of poses and tool paths."""

import base64
import json
import math
import re
import struct

from .attack import BASE_SECONDS, Run, input_class


def unit(v):
    length = math.hypot(*v)
    return [c / length for c in v]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def turned(p, axis, degrees):
    """The point turned about an axis, by Rodrigues' formula."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    along, across = dot(axis, p), cross(axis, p)
    return [c * p[k] + s * across[k] + (1 - c) * along * axis[k] for k in range(3)]


def read_obj(path):
    """Vertices, and the triangles of fans."""
    vertices, triangles = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(c) for c in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [int(w.split("/")[0]) for w in words[1:]]
            corners = [c - 1 if c > 0 else len(vertices) + c for c in corners]
            triangles += [(corners[0], *pair) for pair in zip(corners[1:], corners[2:])]
    return vertices, triangles


def distance(p, vertices, triangles):
    """The distance from a point to a surface."""
    least = math.inf
    for triangle in triangles:
        v = [[c - q for c, q in zip(vertices[i], p)] for i in triangle]
        # No nearer than the box.
        box = math.hypot(*(max(0, min(a, b, c), -max(a, b, c)) for a, b, c in zip(*v)))
        if box >= least:
            continue
        sides = [[v[(k + 1) % 3][i] - v[k][i] for i in range(3)] for k in range(3)]
        normal = cross(sides[0], sides[1])
        inside = all(dot(cross(normal, sides[k]), v[k]) <= 0 for k in range(3))
        if inside and dot(normal, normal) > 0:
            least = min(least, abs(dot(normal, v[0])) / math.hypot(*normal))
            continue
        for k in range(3):
            length = dot(sides[k], sides[k])
            part = min(1, max(0, -dot(v[k], sides[k]) / length)) if length > 0 else 0
            least = min(least, math.hypot(*(v[k][i] + part * sides[k][i] for i in range(3))))
    return least


@input_class(weight=6)
def motions(attack):
    """motions with numbers at the ends of floating point, swept by either backend"""
    rng = attack.rng
    segment = {"duration": abs(attack.extreme()) or 1, "axis_point": [attack.extreme(), 0, 1],
               "axis_direction": [attack.extreme(), 1, 0], "angle_degrees": attack.extreme(),
               "translation": [0, attack.extreme(), 0]}
    for key in rng.sample(list(segment)[1:], rng.randrange(5)):
        del segment[key]
    if "angle_degrees" in segment and "axis_direction" not in segment:
        segment["axis_direction"] = [0, 0, 1]
    motion = attack.path("motion.json")
    motion.write_text(json.dumps({"start_time": rng.choice([0, attack.extreme()]),
                                  "segments": [segment]}))
    mesh = attack.pick("obj")
    output = attack.path("out.t4d")
    # At most some ten thousand steps of a solid of size 10.
    turns = min(abs(segment.get("angle_degrees", 0)) / 360, 1e100)
    deviation = max(abs(attack.extreme()) or 1, 5e-7 * turns**2)
    options = rng.choice([["--steps", "2"], ["--max-deviation", repr(deviation)],
                          ["--backend", "voxel4d", "--frames", "2", "--voxel-size", "4"]])
    return Run(["sweep", mesh, "-m", motion, *options, "-o", output], [mesh, motion], output)


@input_class(weight=2)
def poses(attack):
    """tables and files of poses that are half a turn apart, exactly or nearly: each must be
    noted"""
    rng = attack.rng
    axis = unit([rng.gauss(0, 1) for _ in range(3)]) if rng.random() < 0.5 else \
        rng.choice([[1, 0, 0], [0, 1, 0], [0, 0, -1]])
    degrees = [0.0]
    half = 0
    for _ in range(rng.randrange(1, 6)):
        turn = rng.choice([180, -180, 180 + rng.uniform(-0.01, 0.01), rng.uniform(-175, 175)])
        half += abs(abs(turn) - 180) < 0.05
        degrees.append(degrees[-1] + turn)
    digits = rng.choice([5, 9, 17])
    rows = []
    for i, angle in enumerate(degrees):
        sine = math.sin(math.radians(angle / 2))
        q = [sine * axis[0], sine * axis[1], sine * axis[2], math.cos(math.radians(angle / 2))]
        if rng.random() < 0.5:
            q = [-c for c in q]
        rows.append([float(i), *(rng.uniform(-5, 5) for _ in range(3)), *q])
    form = rng.choice(["csv", "tum", "json"])
    if form == "json":
        motion = attack.path("motion.json")
        motion.write_text(json.dumps({"poses": [
            {"time": r[0], "position": r[1:4], "quaternion": r[4:]} for r in rows]}))
    else:
        motion = attack.path("motion.csv" if form == "csv" else "motion.txt")
        join = "," if form == "csv" else " "
        head = join.join(["time", "x", "y", "z", "qx", "qy", "qz", "qw"])
        motion.write_text(("# " if form == "tum" else "") + head + "\n" + "".join(
            join.join(f"{c:.{digits}g}" for c in r) + "\n" for r in rows))
    mesh, output = attack.pick("obj"), attack.path("out.t4d")

    def check(result):
        if not result.succeeded:
            return []
        turns = result.json.get("half_turns", {"count": 0, "first": []})
        problems = []
        if turns["count"] != half or len(turns["first"]) != half:
            problems.append(f"{half} half turns, but half_turns is {turns}")
        if ("half a turn apart" in result.err) != (half > 0):
            problems.append(f"{half} half turns, but the note is {result.err.strip()[:300]!r}")
        return problems
    return Run(["sweep", mesh, "-m", motion, "--caps", "cone", "--steps", 2, "--json", "-o",
                output], [mesh, motion], output, check=check)


@input_class(weight=2)
def deviations(attack):
    """`--max-deviation` at any magnitude, on real meshes: points of slices are measured against the
    posed solid"""
    rng = attack.rng
    mesh = rng.choice(attack.seeds["real"] + attack.seeds["obj"])
    vertices, triangles = read_obj(mesh)
    size = math.dist([min(c) for c in zip(*vertices)], [max(c) for c in zip(*vertices)])
    allowed = size * 10 ** rng.uniform(-9, -1)
    axis = unit([rng.gauss(0, 1) for _ in range(3)])
    point = [size * rng.uniform(-1, 1) for _ in range(3)]
    shift = [size * rng.uniform(-1, 1) for _ in range(3)]
    # A few steps if edges are as long as the solid.
    degrees = math.degrees(min(10, rng.uniform(0.5, 20) * 12 * allowed / size))
    motion = attack.path("motion.json")
    motion.write_text(json.dumps({"segments": [
        {"duration": 1, "axis_point": point, "axis_direction": axis, "angle_degrees": degrees,
         "translation": shift}]}))
    output, prism = attack.path("out.t4d"), rng.choice([3, 14])

    def check(result):
        if not result.succeeded:
            return []
        report = result.json
        bound = report["chord_bound"]
        problems = [] if bound <= allowed else [f"chord_bound is {bound}, above {allowed}"]
        step = rng.randrange(report["steps"])
        moment = (step + rng.choice([0.25, 0.5, rng.random()])) / report["steps"]
        cut = attack.path("cut.obj")
        sliced = attack.t4d("slice", output, "-t", repr(moment), "-o", cut)
        if not sliced.succeeded:
            return problems + [f"no slice at {moment}: {sliced.err.strip()[:300]}"]
        corners, faces = read_obj(cut)
        # The corners in the coordinates of the solid: turned back.
        back = [turned([p[k] - moment * shift[k] - point[k] for k in range(3)], axis,
                       -moment * degrees) for p in rng.sample(corners, min(40, len(corners)))]
        back = [[p[k] + point[k] for k in range(3)] for p in back]
        worst = max(distance(p, vertices, triangles) for p in back)
        if worst > bound + 1e-12 * size:
            problems.append(f"a slice is {worst} off, more than {bound}")
        return problems
    return Run(["sweep", mesh, "-m", motion, "--caps", "cone", "--prism", prism,
                f"--max-deviation={allowed!r}", "--json", "-o", output], [mesh, motion],
               output, check=check)


def animated_box(attack, sides, middle, tangents, axis, degrees):
    """A .gltf of a box that moves from the origin to `middle` within a second, as a cubic spline,
    and turns."""
    corners = [[(i >> k & 1) * sides[k] for k in range(3)] for i in range(8)]
    faces = [0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6,
             2, 1, 3, 7, 1, 7, 5]
    half = math.radians(degrees) / 2
    turn = [0, 0, 0, 1, *(math.sin(half) * c for c in axis), math.cos(half)]
    spline = [0, 0, 0, 0, 0, 0, *tangents[0], *tangents[1], *middle, 0, 0, 0]
    floats = lambda values: struct.pack(f"<{len(values)}f", *values)
    arrays = [(floats([c for corner in corners for c in corner]), 5126, 8, "VEC3"),
              (struct.pack("<36H", *faces), 5123, 36, "SCALAR"),
              (floats([0, 1]), 5126, 2, "SCALAR"), (floats(spline), 5126, 6, "VEC3"),
              (floats(turn), 5126, 2, "VEC4")]
    data, views, accessors = b"", [], []
    for values, component, count, kind in arrays:
        accessors.append({"bufferView": len(views), "componentType": component, "count": count,
                          "type": kind})
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(values)})
        data += values
    rounded = [struct.unpack("<f", struct.pack("<f", c))[0] for c in sides]
    accessors[0] |= {"min": [0, 0, 0], "max": rounded}
    accessors[2] |= {"min": [0], "max": [1]}
    path = attack.path("moving.gltf")
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "bufferViews": views, "accessors": accessors,
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64,"
                     + base64.b64encode(data).decode()}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0,
        "animations": [{
            "samplers": [{"input": 2, "output": 3, "interpolation": "CUBICSPLINE"},
                         {"input": 2, "output": 4}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}},
                         {"sampler": 1, "target": {"node": 0, "path": "rotation"}}]}]}))
    return path


@input_class(weight=1)
def animations(attack):
    """animated glTF along curves: points of slices are measured against the posed solid, and no
    verb takes its poses to tell the motion between them"""
    rng = attack.rng
    scale = 10 ** rng.choice([0, 0, rng.uniform(-5, 5)])
    some = lambda most: [scale * rng.uniform(-most, most) for _ in range(3)]
    sides = [scale * rng.uniform(0.2, 3) for _ in range(3)]
    middle, tangents = some(3), [some(20), some(20)]
    axis = unit([rng.gauss(0, 1) for _ in range(3)])
    degrees = rng.choice([0, rng.uniform(1, 170)])
    allowed = max(sides) * 10 ** rng.uniform(-3, -0.5)
    mesh = animated_box(attack, sides, middle, tangents, axis, degrees)
    output = attack.path("out.t4d")

    def check(result):
        if not result.succeeded:
            return []
        problems = []
        for verb in (["envelope", output], ["envelope", output, "--outside"]):
            made = attack.t4d(*verb, "--voxel-size", repr(max(sides)), "--json")
            if made.out and made.json["chord_bound"] is not None:
                problems.append(f"{verb[-1]}: chord_bound is {made.json['chord_bound']}")
        t = rng.random()
        cut = attack.path("cut.obj")
        if not attack.t4d("slice", output, "-t", repr(t), "-o", cut).succeeded:
            return problems + [f"no slice at {t}"]
        place = [(t ** 3 - 2 * t * t + t) * tangents[0][k] + (t ** 3 - t * t) * tangents[1][k]
                 + (3 * t * t - 2 * t ** 3) * middle[k] for k in range(3)]
        vertices = [[(i >> k & 1) * sides[k] for k in range(3)] for i in range(8)]
        triangles = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 6, 7),
                     (2, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)]
        back = [turned([p[k] - place[k] for k in range(3)], axis, -t * degrees)
                for p in read_obj(cut)[0]]
        worst = max(distance(p, vertices, triangles) for p in back)
        # Numbers of the file are float32.
        if worst > allowed + 1e-5 * scale:
            problems.append(f"a slice at {t} is {worst} off, more than {allowed}")
        return problems
    return Run(["sweep", mesh, "--tolerance", repr(allowed), "-o", output], [mesh], output,
               check=check, expect={0})


@input_class(weight=3)
def paths(attack):
    """`mill` with tool paths in every format that lead far away, in tiny steps, or round and
    round"""
    rng = attack.rng
    far = lambda: rng.choice([-1, 1]) * 10 ** rng.uniform(0, rng.choice([3, 9, 9, 20, 70]))
    near = lambda: rng.uniform(-15, 15)
    place = lambda: [rng.choice([far, near, near])() for _ in range(3)]
    form = rng.choice(["nc", "cl", "json", "csv"])
    path = attack.path("path." + form)
    turns = 0
    count = rng.choice([2, 5, 40, 5000 if form in ("nc", "cl") else 300])
    if form == "nc":
        spot = lambda: " ".join(f"{a}{c:.3f}" for a, c in zip("XYZ", place()))
        lines = [f"G0 {spot()}", f"F{abs(far()):.6f}"]
        for _ in range(count):
            kind = rng.choice(["G0", "G1", "G1", "arc"])
            if kind == "arc":
                lines.append(f"G{rng.choice([2, 3])} I{far():.3f} J{near():.3f}")
            else:
                lines.append(f"{kind} {spot()}")
    elif form == "cl":
        lines = [f"FEDRAT/{abs(far())!r},MMPM"]
        for _ in range(count):
            tilt = unit([rng.gauss(0, 0.3), rng.gauss(0, 0.3), 1])
            lines.append("GOTO/" + ",".join(repr(c) for c in place() + tilt))
            if rng.random() < 0.3:
                lines.append("RAPID")
    elif form == "json":
        segments = [
            {"duration": abs(far()), "translation": place(), "axis_point": place(),
             "axis_direction": [near(), near(), 1], "repeat": rng.choice([1, 1, 3, 1000]),
             "angle_degrees": rng.choice([0, 0, near(), far()])} for _ in range(count)]
        turns = sum(s["repeat"] * abs(s["angle_degrees"]) / 360 for s in segments)
        if 1000 < turns < 1e9:  # which takes minutes, rightly; far more is refused
            for segment in segments:
                segment["angle_degrees"] *= 1000 / turns
        lines = [json.dumps({"segments": segments})]
    else:
        lines = ["time,x,y,z"] + [",".join(repr(c) for c in [i, *place()])
                                  for i in range(count)]
    path.write_text("\n".join(lines) + "\n")
    mesh, output = attack.seeds["cube"][0], attack.path("out.t4d")
    option = {"nc": "--gcode", "cl": "--locations"}.get(form, "--motion")
    extra = rng.choice([[], ["--shank", "d=8,l=20"], ["--tolerance", "0.05"],
                        ["--max-memory", "0.2"]])
    if turns > 100 and "--tolerance" in extra:
        extra = []  # hundreds of turns in small steps are much work, rightly
    return Run(["mill", mesh, "--tool", rng.choice(["ball:d=6,l=30", "flat:d=4,l=12"]), option,
                path, "--voxel-size", rng.choice([2, 4]), "--frames", rng.choice([2, 5]), *extra,
                "-o", output], [mesh, path], output, seconds=2 * BASE_SECONDS)


ROTATIONS = {
    "qw,qx,qy,qz": (4, []), "q1,q2,q3,q4": (4, ["--quaternion", "wxyz"]),
    "roll_deg,pitch_deg,yaw_deg": (3, []), "roll,pitch,yaw": (3, ["--angles", "rpy:rad"]),
    "rx,ry,rz": (3, []), "rx [deg],ry [deg],rz [deg]": (3, ["--angles", "rotvec:deg"]),
    "/t/orientation/w,/t/orientation/x,/t/orientation/y,/t/orientation/z": (4, [])}
TIMES = {"time": 1, "t_ms": 1, "secs,nsecs": 2, "%time": 1, "timestamp [ns]": 1}


@input_class(weight=2)
def logs(attack):
    """tables of poses with columns of all names and units, at irregular, repeated and huge times,
    with numbers at the ends of floating point and altered texts"""
    rng = attack.rng
    rotation, (count, options) = rng.choice(list(ROTATIONS.items()))
    time, time_count = rng.choice(list(TIMES.items()))
    place = rng.choice(["x,y,z", "x_mm,y_mm,z_mm", "x [m],y [m],z [m]", "/t/position/x,/t/position/y,"
                        "/t/position/z"])
    separator = rng.choice([",", ";", "\t"])
    rows = [",".join([time, place, rotation]).replace(",", separator)]
    moment = rng.choice([0, 17, 1.7e9, 1.7e18])
    for _ in range(rng.randrange(2, 8)):
        q = unit([rng.gauss(0, 1) for _ in range(4)])
        turn = q if count == 4 else [rng.uniform(-3, 3) for _ in range(3)]
        row = [moment, *[rng.randrange(10 ** 9)] * (time_count - 1),
               *(rng.uniform(-20, 20) for _ in range(3)), *turn]
        rows += [separator.join(map(repr, row))] * rng.choice([1, 1, 1, 2])
        moment += rng.choice([0.001, 1, 1e6, 1e9]) * rng.random()
    table = attack.path("log.csv")
    table.write_text("\n".join(rows) + "\n")
    alteration = rng.randrange(3)
    if alteration == 1:
        table = attack.altered_text(table, "altered.csv")
    elif alteration == 2:
        table, _ = attack.altered(table, "altered.csv")
    units = rng.choice([[], ["--length-unit", "mm"], ["--time-unit", "s"]])
    mesh, output = attack.pick("obj"), attack.path("out.t4d")
    return Run(["sweep", mesh, "-m", table, *options, *units, "--steps", 1, "--caps", "cone", "-o",
                output], [mesh, table], output)


def mechanism_text(attack, extreme):
    """A mechanism of boxes with joints of all types."""
    rng = attack.rng
    number = lambda scale: attack.extreme() if rng.random() < extreme else rng.uniform(-scale, scale)
    vector = lambda scale: [number(scale) for _ in range(3)]
    times = lambda: sorted(rng.uniform(0, 5) for _ in range(rng.randrange(2, 5)))
    bodies = []
    for i in range(rng.randrange(1, 7)):
        kind = rng.choice(["fixed", "revolute", "revolute", "prismatic", "screw", "free"])
        joint, motion = {"type": kind}, None
        if kind not in ("fixed", "free"):
            joint |= {"axis": vector(1), "origin": vector(10)}
            if kind == "screw":
                joint["pitch"] = number(3)
            moments = times()
            motion = {"times": moments, "values": [number(90) for _ in moments]}
            leaders = [b["name"] for b in bodies if "values" in b.get("motion", {})]
            if leaders and rng.random() < 0.3:
                motion = {"follows": rng.choice(leaders), "ratio": number(2), "offset": number(9)}
        elif kind == "free":
            motion = {"poses": [{"time": t, "position": vector(10)} for t in times()]}
        body = {"name": f"b{i}", "position": vector(10), "joint": joint,
                "solid": rng.choice([{"box": [abs(c) for c in vector(5)]}, {"sphere": abs(number(3))},
                                     {"cylinder": {"radius": abs(number(3)), "length": 2}}])}
        if i > 0 and rng.random() < 0.8:
            body["parent"] = f"b{rng.randrange(i)}"
        if motion:
            body["motion"] = motion
        bodies.append(body)
    return json.dumps({"length_unit": "mm", "time_unit": "s", "angle_unit": "deg",
                       "bodies": bodies})


@input_class(weight=2)
def mechanisms(attack):
    """mechanisms of up to six bodies with joints of all types, with numbers at the ends of floating
    point and altered texts; the bound of a good one is within --max-deviation"""
    rng = attack.rng
    path, output = attack.path("mechanism.json"), attack.path("out.t4d")
    path.write_text(mechanism_text(attack, rng.choice([0, 0, 0.05])))
    if rng.random() < 0.4:
        path = attack.altered_text(path, "altered.json")
    allowed = 10 ** rng.uniform(-1, 3)
    options = rng.choice([["--steps", 2], [f"--max-deviation={allowed!r}"], []])

    def check(result):
        if not result.succeeded or len(options) != 1:
            return []
        bound = result.json["chord_bound"]
        return [] if bound <= allowed else [f"chord_bound is {bound}, above {allowed}"]
    return Run(["sweep", path, *options, *rng.choice([[], ["--own-steps"]]), "--caps", "cone",
                "--json", "-o", output], [path], output, check=check)


@input_class(weight=1)
def robots(attack):
    """URDF of chains and trees, and tables of their joints, altered"""
    rng = attack.rng
    text, joints = "<link name='l0'><collision><geometry><sphere radius='1'/></geometry></collision>"\
                   "</link>", []
    for i in range(1, rng.randrange(2, 8)):
        kind = rng.choice(["fixed", "revolute", "continuous", "prismatic"])
        joints += [f"j{i}"] * (kind != "fixed")
        text += (f"<link name='l{i}'><collision><origin xyz='0 0 1'/><geometry><box size='1 1 1'/>"
                 f"</geometry></collision></link>\n<joint name='j{i}' type='{kind}'>"
                 f"<parent link='l{rng.randrange(i)}'/><child link='l{i}'/><axis xyz='0 1 0'/>"
                 f"<origin xyz='0 0 2' rpy='0.5 0 0'/><limit lower='-1' upper='1' velocity='1'/>"
                 "</joint>\n")
    robot, table = attack.path("robot.urdf"), attack.path("joints.csv")
    robot.write_text(f"<robot name='r'>\n{text}</robot>\n")
    table.write_text(",".join(["time", *joints]) + "\n" + "".join(
        ",".join(repr(c) for c in [t, *(rng.uniform(-2, 2) for _ in joints)]) + "\n"
        for t in range(rng.randrange(1, 5))))
    which = rng.randrange(4)
    if which == 0:
        robot = attack.altered_text(robot, "altered.urdf")
    elif which == 1:
        robot, _ = attack.altered(robot, "altered.urdf")
    elif which == 2:
        table = attack.altered_text(table, "altered.csv")
    output = attack.path("out.t4d")
    return Run(["sweep", robot, "-m", table, "--steps", 2, "--caps", "cone", "-o", output],
               [robot, table], output)


@input_class(weight=3)
def gcode(attack):
    """`mill` with G-code of all words in any order: canned cycles, origins, tools, parameters,
    loops, subprograms and rotary axes; a refusal names the line"""
    rng = attack.rng
    wild = rng.choice([0, 0, 0, 0.02])  # how often a number or a line is anything
    turns = rng.random() < 0.4
    tools = rng.choice([["--tool", "flat:d=6,l=30"],
                        ["--tool", "1=drill:d=4", "--tool", "2=taper:r=1,a=8,l=20", "--shank", "2=d=8,l=9"]])
    labels = iter(range(1, 1000))

    def number(low=-15, high=15):
        if rng.random() < wild:
            return rng.choice([f"{rng.choice([-1, 1]) * 10 ** rng.uniform(-9, 9):.6f}", "#5220", "#<_x>",
                               "#<unset>", "[#1/0]", "1." + "0" * 400, "--1", "[[[1]]]", ""])
        value = f"{rng.uniform(low, high):.3f}"
        return rng.choice([value, value, value, f"[{value}+#1]", f"[{value}*cos[#2]]", "#2"])

    def words(letters):
        return " ".join(f"{letter}{number()}" for letter in letters if rng.random() < 0.8)

    def line():
        if rng.random() < wild:
            return rng.choice(["G41 D1", "M98 P7", "M99", "o1 call [1]", "o2 break", "(comment", "%", "G1 X X",
                               "H2 P3", "T7 M6", "#<a>=[1 mod 0]", "O<sub> sub"])
        return rng.choice([
            f"G0 {words('XY')} Z{number(11, 20)}", f"G1 {words('XYZ')} F{rng.randint(100, 900)}", words("XYZ"),
            f"G1 {words('XYZAC' if turns else 'XYZ')} F500", f"G0 {words('AC' if turns else 'XY')}",
            f"{rng.choice(['G2', 'G3'])} X{number()} Y{number()} R{rng.randint(40, 60)} F500",
            f"G3 I{number()} J{number()} P{rng.randint(1, 3)} F500",
            f"G{rng.choice([81, 82, 84, 85, 86, 89])} X{number()} Y{number()} Z-12 R11 F300",
            f"G{rng.choice([73, 83])} X{number()} Z-9 R{number(11, 20)} Q{rng.uniform(1, 3):.2f} L2 F300",
            "G80 G0 Z20", f"G92 {words('XY')} Z20", "G92.1", f"G52 X{number()}", "G28 G91 Z0\nG90",
            f"G53 G0 Z0\nG0 X0 Y0 Z{rng.randint(11, 20)}", "G55", "G54", "G10 L20 P2 X0 Y0 Z0", "G17", "G98", "G99", "T1 M6",
            "G43 H1", f"G91 G1 {words('XYZ')} F500\nG90", f"G43.4\nG1 {words('XYZ')} F500\nG49",
            "T1 M6" if tools[1] == "flat:d=6,l=30" else "T2 M6", f"G93 G1 {words('XYZ')} F9\nG94",
            f"#1={number()}", f"#2=[{number()}]", f"M98 P100 L{rng.randint(0, 3)}", "/G0 X1",
            f"G{rng.choice(['41', '42', '41.1 D3', '42.1 D3'])} G1 {words('XY')} F500\n{words('XY')}\n{words('XY')}\nG40",
            "G41", "G40", f"G1 X{number()} Y{number()} ,{rng.choice('RC')}1 F500\n{words('XY')}", "G1 X1 ,R1 F500",
            f"G5 {words('XY')} I1 J2 P-1 Q2 F500", f"G5.1 {words('XY')} I1 J2 F500",
            f"G5.2 {words('XY')} P1 L3 F500\n{words('XY')}\n{words('XY')}\nG5.3\nG1", f"G33 {words('Z')} K1 S100\nG1",
            f"G68 {words('XY')} R{number()}", "G69", f"G51 {words('XY')} P{rng.choice(['2.', '0', '500', '1e-3'])}", "G50",
            f"G51.1 {words('X')}", "G50.1", "G16", "G15", f"@{number()} ^{number()}", f"G10 L2 P1 R{number()}",
            "G95", "G94", "M70", "M72", "M73", "G18", "G17", f"G65 P100 A{number()}", "N7 #3=#3+1\nIF [#3 LT 9] GOTO 7",
            "#3=0\nWHILE [#3 LT 3] DO 1\n#3=#3+1\nEND 1", f"G4 P{number()}", f"G1 {words('XY')}"])

    def block(depth):
        lines = [line() for _ in range(rng.randint(1, 6))]
        if depth > 0:
            o = f"o{next(labels)}"
            begin, end = rng.choice([
                (f"{o} repeat [{number(0, 4)}]", f"{o} endrepeat"), (f"{o} do", f"#3=[#3+1]\n{o} while [#3 lt 9]"),
                (f"{o} if [{number()} gt 0]", f"{o} else\n{line()}\n{o} endif"),
                (f"{o} sub", f"{o} endsub\n{o} call [{number()}]"),
                (f"{o} while [#3 lt 5]", f"#3=[#3+1]\n{o} endwhile")])
            lines += [begin, *block(depth - 1), end, *block(depth - 1)]
        return lines

    path = attack.path("program.nc")
    path.write_text("\n".join(["T1 M6", "#1=1 #2=30", "G0 X0 Y0 Z20 F600", *block(rng.randint(0, 4)), "M30", "O100",
                               line(), "M99"]) + "\n")
    mesh, output = attack.seeds["cube"][0], attack.path("out.t4d")
    machine = ["--offset", "G55=9,0,0", *rng.choice([[], ["--offset", "G53=0,0,80"]]),
               *rng.choice([[], ["--start", f"{rng.uniform(-20, 20)},0,{rng.choice(['30', '1e6'])}"]]),
               *rng.choice([[], ["--feed", "300"]]), *rng.choice([[], ["--dialect", rng.choice(["fanuc", "mach3", "siemens"])]])]
    if turns:
        machine += rng.choice([["--rotary", "A=table:0,0,-9", "--rotary", "C=-table"],
                               ["--rotary", "C=head", "--rotary", "A=head:0,0,99", "--tcp"]])

    def names_the_line(result):
        named = re.search(r"program\.nc:\d+: |program\.nc: nothing moves|out of the", result.err)
        return [] if result.succeeded or named else ["no line is named"]

    stock = rng.choice([[mesh], [mesh], ["--stock", rng.choice(["box:40,40,20", "box:9,9,9@-4,-4,-4", "box:40,0.1,9"])]])
    return Run(["mill", *stock, *tools, *machine, "--gcode", path, "--voxel-size", 4, "--frames", 3,
                "--tolerance", "0.5", "-o", output], [mesh, path], output, check=names_the_line,
               seconds=2 * BASE_SECONDS)

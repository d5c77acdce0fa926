"""What runs beside the program: other programs, web servers, and work that takes long."""

import json
import math
import socket
import threading
import time

from .attack import BASE_SECONDS, Run, input_class


@input_class(weight=1)
def programs(attack):
    """readers and backends that hang, crash, print without end, or make pipes"""
    rng = attack.rng
    script = attack.path("program")
    script.write_text("#!/bin/sh\n" + rng.choice([
        "sleep 100", "kill -SEGV $$", "yes", "exit 0", "cat /dev/zero", "echo '{'",
        "trap '' TERM; sleep 100", 'for last; do :; done; rm -f "$last"; mkfifo "$last"',
        "yes >&2", "printf '\\033[2J'"]) + "\n")
    script.chmod(0o755)
    if rng.random() < 0.5:
        return Run(["conform", "backends", "--backend-program", script, "--timeout", "1",
                    "--case", "cube-at-rest"], [script], expect={1})
    return Run(["conform", "reader", "--reader", script, "--timeout", "0.1", "--only",
                "valid/s*"], [script], expect={1})


@input_class(weight=1)
def servers(attack):
    """web servers that trickle, send without end, redirect in circles or answer with wrong
    ranges"""
    rng = attack.rng
    content = attack.pick("t4d").read_bytes()
    kind = rng.choice(["endless redirect", "circle", "endless header", "endless body", "cut",
                       "wrong range", "nonsense", "silent", "informational", "altered"])
    listener = socket.create_server(("127.0.0.1", 0))
    address = f"http://127.0.0.1:{listener.getsockname()[1]}/a.t4d"
    first = max(0, len(content) - (1 << 18))
    part = content[first:]
    status = b"HTTP/1.1 206 Partial Content\r\n"
    place = f"Content-Range: bytes {first}-{len(content) - 1}/{len(content)}\r\n".encode()
    length = f"Content-Length: {len(part)}\r\n\r\n".encode()
    wrong = rng.choice([
        b"bytes 0-0/1", b"bytes 5-3/9", b"bytes */7", b"bytes 0-9/18446744073709551615", b"",
        b"bytes 0-18446744073709551615/18446744073709551616", rng.randbytes(20).hex().encode()])
    altered = bytearray(part)
    altered[rng.randrange(len(part))] ^= 1 << rng.randrange(8)
    begin, repeated = {
        "endless redirect": (b"HTTP/1.1 302 Found\r\nLocation: /b\r\n\r\n", bytes(1 << 16)),
        "circle": (b"HTTP/1.1 302 Found\r\nLocation: /a.t4d\r\nContent-Length: 0\r\n\r\n", b""),
        "endless header": (status, b"X: " + b"x" * 1000 + b"\r\n"),
        "endless body": (status + place + b"\r\n", part),
        "cut": (status + place + length + part[:rng.randrange(len(part))], b""),
        "wrong range": (status + b"Content-Range: " + wrong + b"\r\n" + length + part, b""),
        "nonsense": (rng.randbytes(rng.randrange(1, 3000)), b""),
        "silent": (b"", b""),
        "informational": (b"", b"HTTP/1.1 100 Continue\r\n\r\n" * 100),
        "altered": (status + place + length + bytes(altered), b""),
    }[kind]

    def serve():
        while True:
            try:
                connection, _ = listener.accept()
            except OSError:
                return  # the run is over
            with connection:
                try:
                    connection.recv(65536)
                    connection.sendall(begin)
                    until = time.monotonic() + 2 * BASE_SECONDS
                    while repeated and time.monotonic() < until:
                        connection.sendall(repeated)
                except OSError:
                    pass  # the client is gone

    def stop():
        listener.shutdown(socket.SHUT_RDWR)
        listener.close()
    attack.ending.callback(stop)
    threading.Thread(target=serve, daemon=True).start()
    output = attack.path("out.ply")
    return Run(["slice", address, "-t", 0.5, "-o", output], [], output,
               expect=None if kind == "altered" else {1, 4})


@input_class(weight=1)
def work(attack):
    """small files that ask for much work: fans, crossings, endless motions, deep nesting"""
    rng = attack.rng
    kind = rng.choice(["fan", "crossings", "segments", "steps", "nesting"])
    mesh, motion, out = attack.pick("obj"), attack.pick("motion"), attack.path("out.t4d")
    if kind == "fan":
        n = rng.choice([1000, 20000])
        lines = [f"v {math.cos(6.283185307179586 * i / n)!r} "
                 f"{math.sin(6.283185307179586 * i / n)!r} 0" for i in range(n)]
        lines += ["v 0 0 1", "v 0 0 -1"]
        for i in range(n):
            j = (i + 1) % n
            lines += [f"f {i + 1} {j + 1} {n + 1}", f"f {j + 1} {i + 1} {n + 2}"]
        mesh = attack.path("fan.obj")
        mesh.write_text("\n".join(lines))
        return Run(["sweep", mesh, "-m", attack.seeds["motion"][-1], "--steps", 1, "--caps",
                    rng.choice(["cone", "tetgen"]), "-o", out], [mesh], out)
    if kind == "crossings":
        cube = [l for l in attack.seeds["obj"][1].read_text().splitlines() if l[:1] in "vf"]
        vertices = [[float(c) for c in l.split()[1:]] for l in cube if l[0] == "v"]
        faces = [[int(c) for c in l.split()[1:]] for l in cube if l[0] == "f"]
        lines = []
        count = rng.choice([2, 300])
        for i in range(count):
            lines += [f"v {x + i * 1e-3!r} {y + i * 2e-3!r} {z + i * 3e-3!r}"
                      for x, y, z in vertices]
        for i in range(count):
            lines += ["f " + " ".join(str(c + i * len(vertices)) for c in f) for f in faces]
        mesh = attack.path("crossings.obj")
        mesh.write_text("\n".join(lines))
        return Run(["sweep", mesh, "-m", motion, "--steps", 1, "-o", out], [mesh], out)
    path = attack.path("motion.json")
    if kind == "segments":
        path.write_text(json.dumps({"segments": [
            {"duration": 1, "repeat": rng.choice([2_000_000, 2 ** 40, 10 ** 30])}]}))
    elif kind == "steps":
        path.write_text(json.dumps({"segments": [
            {"duration": 1, "axis_direction": [0, 0, 1], "angle_degrees": 1e15}]}))
    else:
        path.write_text("[" * rng.choice([100, 100_000]))
    return Run(["sweep", mesh, "-m", path, "-o", out], [path], out, expect={2, 4})

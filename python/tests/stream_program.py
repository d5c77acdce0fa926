"""Stands for the program: describes the options of weave, and reads the stream of frames as its page says. What it
found is the report; STREAM_PROGRAM says how to misbehave."""

import json
import os
import signal
import sys
import time

import numpy as np

OPTIONS = [
    (["--iso"], "FLOAT", False), (["--below"], "FLOAT", False), (["--label"], "INT|all", True),
    (["--outside-value"], "V|nan", False), (["--frame-time"], "FLOAT", False), (["--spacing"], "DX [DY DZ]", False),
    (["--axes"], "AXES", False), (["--channel"], "UINT", False), (["--level"], "UINT", False),
    (["--region"], "TEXT", False), (["--series"], "TEXT", False), (["--part"], "K/N", False),
    (["-o", "--output"], "TEXT", False), (["--body"], "TEXT", False), (["--json"], None, False),
    (["-q", "--quiet"], None, False), (["--velocity-file"], "VX VY VZ", False),
    (["--substeps"], "UINT", False),
]  # fmt: skip


class Pipe:
    """numpy reads files of their own kind by their position, which a pipe has not."""

    read = sys.stdin.buffer.read
    readline = sys.stdin.buffer.readline


def once(pairs):
    assert len(dict(pairs)) == len(pairs), "a member is given twice"
    return dict(pairs)


def velocities(words):
    """The header of each file of velocities, and the sum of its samples."""
    found = []
    for path in words[words.index("--velocity-file") + 1 :][:3] if "--velocity-file" in words else []:
        with open(path, "rb") as file:
            head, samples = file.read().split(b"\n\n", 1)
        fields = dict(line.split(": ") for line in head.decode().splitlines()[1:])
        kind = {"float": "<f4", "double": "<f8"}[fields["type"]]
        found.append([os.path.basename(path), fields, float(np.frombuffer(samples, kind).sum(dtype=float))])
    return found


def main(words):
    if words[-2:] == ["--help", "--json"]:
        print(json.dumps({"options": [
            {"names": names, "value": value, "values": 1 if value else 0, "repeats": repeats}
            for names, value, repeats in OPTIONS]}))  # fmt: skip
        return 0
    if words[:2] != ["weave", "-"]:
        print(json.dumps({"words": words, "velocities": found} if (found := velocities(words)) else words))
        return 7
    how = os.environ.get("STREAM_PROGRAM", "")
    if how == "early":
        print("t4d: the program ends early", file=sys.stderr)
        return 4
    if how == "wait":
        signal.signal(signal.SIGINT, lambda *_: os._exit(9))
        print("ready", flush=True)
        time.sleep(60)
    source = Pipe()
    header = json.loads(source.readline(), object_pairs_hook=once)
    first, last = header.get("part", [0, header["frames"] - 1])
    sums = []
    for _ in range(last - first + 1):
        frame = np.lib.format.read_array(source)
        assert list(frame.shape) == header["size"]
        sums.append([str(frame.dtype), float(np.nansum(frame.astype(float)))])
    assert source.read() == b""
    print(json.dumps({"words": words, "header": header, "frames": sums, "velocities": velocities(words)}))
    return 3 if header.get("losses") else 0


if __name__ == "__main__":
    try:
        code = main(sys.argv[1:])
    except (EOFError, ValueError) as error:
        print(f"t4d: -: {error}", file=sys.stderr)
        code = 4
    sys.exit(code)

"""A file that is read and saved keeps what this version does not know, as far as that may be kept."""

import json
import struct
import warnings

import pytest
import t4d


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


def chunk(kind, payload, flags=0):
    header = kind + struct.pack("<IQIII", flags, len(payload), len(payload), 0, crc32c(payload))
    return header + struct.pack("<I", crc32c(header)) + payload + bytes(-len(payload) % 8)


def altered(path, members, chunks):
    """The file, without index, with further members of HEAD and chunks after it."""
    data = path.read_bytes()
    length, = struct.unpack_from("<Q", data, 32)
    head = {**json.loads(data[56:56 + length]), **members}
    end = 56 + length + -length % 8
    done = data.index(b"DONE\x01\0\0\0", end)
    fields, = struct.unpack_from("<Q", data, done + 8)
    count, = struct.unpack_from("<Q", data, done + 32)
    sums = struct.pack("<Q", count + len(chunks)) + data[done + 40:done + 32 + fields]
    path.write_bytes(data[:24] + chunk(b"HEAD", json.dumps(head).encode(), 1)
                     + b"".join(chunk(*c) for c in chunks) + data[end:done]
                     + chunk(b"DONE", sums, 1))


@pytest.fixture
def file(tmp_path, cube):
    path = tmp_path / "in.t4d"
    motion = {"segments": [{"duration": 1, "translation": [0, 0, 1]}]}
    t4d.sweep(*cube, motion).save(path, index=False)
    return path


MEMBERS = {"space": "LPS", "acme:project": {"id": [1, 2.5]},
           "attributes": {"velocity": {"kind": "vector", "unit": "length/time"}, "n": {}}}


def test_what_may_be_kept_is_kept(file, tmp_path):
    altered(file, MEMBERS, [(b"note", b"acme.example: one"), (b"acMe", b"acme.example: two")])
    mesh = t4d.read(file, whole=True)
    assert mesh.space == "LPS"
    assert mesh.attribute_kinds == {"velocity": ("vector", "length/time"), "n": ("scalar", "")}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh.save(tmp_path / "out.t4d", index=False)
    data = (tmp_path / "out.t4d").read_bytes()
    length, = struct.unpack_from("<Q", data, 32)
    head = json.loads(data[56:56 + length])
    for name, value in MEMBERS.items():
        assert head[name] == value
    assert b"acme.example: one" in data and b"acme.example: two" in data
    t4d.read(tmp_path / "out.t4d", whole=True)


def test_what_may_not_be_kept_is_named(file, tmp_path):
    altered(file, {}, [(b"acmE", b"acme.example: of the mesh")])
    with pytest.warns(t4d.Loss, match="acmE"):
        t4d.read(file).save(tmp_path / "out.t4d")
    assert b"of the mesh" not in (tmp_path / "out.t4d").read_bytes()

"""An arm of six links, a table and a wall: all pairs of bodies as FCL finds them, by root finding
on the joints' closed form."""

import json
import os
import subprocess
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

fcl = pytest.importorskip("fcl")

BUILD = Path(os.environ["T4D_BUILD"])
GJK = 1e-4  # mm, how far the distances of FCL are to be trusted


def t4d(*words):
    return subprocess.run([BUILD / "t4d", *map(str, words)], check=True, capture_output=True,
                          text=True).stdout


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("mechanism")
    subprocess.run([BUILD / "t4d-fixtures", made], check=True, stdout=subprocess.DEVNULL)
    t4d("sweep", made / "arm.json", "--max-deviation", 0.5, "-q", "-o", made / "arm.t4d")
    return made


class Arm:
    """The bodies of arm.json: convex solids, and where the joints put them (Brockett 1984)."""

    def __init__(self, folder):
        self.bodies = {body["name"]: body
                       for body in json.loads((folder / "arm.json").read_text())["bodies"]}
        self.solids = {}
        for name, body in self.bodies.items():
            vertices, faces = self.mesh(body["solid"])
            faces = np.insert(faces, 0, 3, axis=1)
            convex = fcl.Convex(vertices, len(faces), faces.ravel())
            self.solids[name] = fcl.CollisionObject(convex)

    @staticmethod
    def mesh(solid):
        if "box" in solid:
            half = np.array(solid["box"]) / 2
            ring = half * np.array([[1, 1, 1], [-1, 1, 1], [-1, -1, 1], [1, -1, 1]])
        else:
            round_ = solid["cylinder"]
            angles = 2 * np.pi * np.arange(64) / 64
            ring = np.stack([round_["radius"] * np.cos(angles), round_["radius"] * np.sin(angles),
                             np.full(64, round_["length"] / 2)], axis=1)
        count = len(ring)
        after = np.roll(np.arange(count), -1)
        sides = [[(i + count, after[i] + count, after[i]), (i + count, after[i], i)]
                 for i in range(count)]
        caps = [[(0, i, i + 1), (count, count + i + 1, count + i)] for i in range(1, count - 1)]
        return (np.concatenate([ring, ring * [1, 1, -1]]),
                np.concatenate([np.concatenate(sides), np.concatenate(caps)]))

    def pose(self, name, time):
        rotation, shift = np.eye(3), np.array(self.bodies[name]["position"], dtype=float)
        while name:
            body = self.bodies[name]
            if "joint" in body:
                angle = np.radians(np.interp(time, body["motion"]["times"],
                                             body["motion"]["values"]))
                x, y, z = body["joint"]["axis"]
                cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
                turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
                origin = np.array(body["joint"]["origin"])
                rotation, shift = turn @ rotation, turn @ (shift - origin) + origin
            name = body.get("parent")
        return fcl.Transform(rotation, shift)

    def distance(self, a, b, time):
        """0 or less if they meet."""
        for name in (a, b):
            self.solids[name].setTransform(self.pose(name, time))
        return fcl.distance(self.solids[a], self.solids[b], fcl.DistanceRequest(),
                            fcl.DistanceResult())


@pytest.fixture(scope="module")
def arm(folder):
    return Arm(folder)


@pytest.fixture(scope="module")
def pairs(folder):
    found = json.loads(t4d("collide", folder / "arm.t4d", "--adjacent", "--no-volume", "--json"))
    return {(pair["a"], pair["b"]): pair for pair in found["pairs"]}


TIMES = np.linspace(0, 4, 1601)


def first_root(distance):
    """The first time of contact, between the first sample in contact and the one before it."""
    touching = [distance(time) <= 0 for time in TIMES].index(True)
    clear, hit = TIMES[touching - 1], TIMES[touching]
    for _ in range(50):
        middle = (clear + hit) / 2
        clear, hit = (clear, middle) if distance(middle) <= 0 else (middle, hit)
    return hit


def least(distance):
    """The smallest distance: the best sample, refined between its neighbours."""
    best = TIMES[np.argmin([distance(time) for time in TIMES])]
    low, high = max(best - 0.0025, 0), min(best + 0.0025, 4)
    return min(distance(time) for time in np.linspace(low, high, 201))


def test_all_pairs_are_there(arm, pairs):
    assert set(pairs) == set(combinations(arm.bodies, 2)) and len(pairs) == 28


def test_pairs_that_are_clear_come_as_near_as_fcl_says(arm, pairs):
    clear = {names: pair for names, pair in pairs.items() if pair["verdict"] == "clear"}
    assert len(clear) == 19
    for names, pair in clear.items():
        true = least(lambda time: arm.distance(*names, time))
        assert abs(pair["min_clearance"] - true) <= pair["chord_bound"] + GJK, names
        assert true >= pair["clear_by"] - GJK, names


def test_pairs_that_meet_do_so_when_fcl_says(arm, pairs):
    hits = {names: pair for names, pair in pairs.items() if pair["verdict"] == "hit"}
    assert len(hits) == 8
    for names, pair in hits.items():
        root = first_root(lambda time: arm.distance(*names, time))
        speed = arm.distance(*names, root - 1e-4) / 1e-4
        # In this time the solids come nearer by what the meshes are off.
        late = pair["first_contact"]["time"] - root
        assert abs(late) <= 1.5 * (pair["chord_bound"] + GJK) / speed, names


def test_the_table_and_the_wall_touch(pairs):
    assert pairs["table", "wall"]["verdict"] == "touch"


def test_an_srdf_leaves_out_all_bodies_of_its_links(folder):
    (folder / "arm.srdf").write_text('<robot name="arm"><disable_collisions link1="world" '
                                     'link2="link3" reason="Never"/></robot>')
    t4d("sweep", folder / "arm.urdf", "--motion", folder / "arm-joints.csv", "-q", "-o",
        folder / "robot.t4d")
    found = json.loads(t4d("collide", folder / "robot.t4d", "--no-volume", "--json", "--ignore",
                           folder / "arm.srdf"))
    ignored = {(pair["a"], pair["b"]) for pair in found["ignored"]}
    assert ("world", "link3") in ignored and ("world 2", "link3") in ignored
    assert ("link1", "link2") in ignored and ("world 2", "link1") in ignored
    assert len(found["pairs"]) + len(ignored) == 28

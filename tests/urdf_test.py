"""Robots in URDF as yourdfpy poses them: every link of a slice is where its kinematics put it, and as
far from the others as FCL says."""

import csv
import json
import os
import random
import subprocess
from pathlib import Path

import numpy as np
import pytest

fcl = pytest.importorskip("fcl")
trimesh = pytest.importorskip("trimesh")
yourdfpy = pytest.importorskip("yourdfpy")

BUILD = Path(os.environ["T4D_BUILD"])
TIMES = [0, 0.3, 1.1, 1.15, 4]  # irregular


def numbers(values):
    return " ".join(repr(float(value)) for value in values)


def origin(rng, reach=1.0):
    xyz = [rng.uniform(-reach, reach) for _ in range(3)]
    rpy = [rng.uniform(-3, 3) for _ in range(3)]
    return f'<origin xyz="{numbers(xyz)}" rpy="{numbers(rpy)}"/>'


def random_robot(rng, links=12):
    """A tree of boxes with joints of all types; the names of those that the table moves."""
    text, moving = "", []
    for i in range(links):
        size = numbers(rng.uniform(0.1, 1) for _ in range(3))
        text += (f'<link name="l{i}"><collision>{origin(rng)}<geometry><box size="{size}"/>'
                 "</geometry></collision></link>\n")
        if i == 0:
            continue
        kind = rng.choice(["fixed", "revolute", "continuous", "prismatic", "prismatic", "revolute"])
        axis = [rng.gauss(0, 1) for _ in range(3)]
        axis = np.array(axis) / np.linalg.norm(axis)
        mimic = ""
        if kind != "fixed" and moving and rng.random() < 0.25:
            mimic = (f'<mimic joint="{rng.choice(moving)}" multiplier="{rng.uniform(-2, 2)}" '
                     f'offset="{rng.uniform(-1, 1)}"/>')
        elif kind != "fixed":
            moving.append(f"j{i}")
        text += (f'<joint name="j{i}" type="{kind}"><parent link="l{rng.randrange(i)}"/>'
                 f'<child link="l{i}"/>{origin(rng)}<axis xyz="{numbers(axis)}"/>'
                 f'<limit lower="-9" upper="9" velocity="99" effort="1"/>{mimic}</joint>\n')
    return f'<robot name="random">\n{text}</robot>\n', moving


def write_table(path, joints, values):
    with open(path, "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["time", *joints])
        for time, row in zip(TIMES, values):
            rows.writerow([time, *map(repr, row)])


def vertices_of(path, body, time, folder):
    out = folder / "slice.obj"
    subprocess.run([BUILD / "t4d", "slice", path, "--time", str(time), "--body", body, "-q", "-o",
                    out], check=True)
    rows = [line.split()[1:4] for line in out.read_text().splitlines() if line.startswith("v ")]
    return np.array(rows, dtype=float)


def expected_corners(robot, name):
    collision = robot.link_map[name].collisions[0]
    pose = robot.get_transform(name) @ collision.origin
    half = np.array(collision.geometry.box.size) / 2
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    return signs * half @ pose[:3, :3].T + pose[:3, 3]


def assert_within(found, wanted, bound):
    """The box with these corners and the slice are within the bound of each other."""
    distances = np.linalg.norm(found[:, None] - wanted[None], axis=2)
    assert distances.min(axis=0).max() <= bound
    middle = wanted.mean(axis=0)
    edges = wanted[[1, 2, 4]] - wanted[0]
    half = np.linalg.norm(edges, axis=1) / 2
    inside = (found - middle) @ (edges / (2 * half[:, None])).T
    nearest = np.clip(inside, -half, half)
    assert np.linalg.norm(inside - nearest, axis=1).max() <= bound


def assert_same_points(found, wanted):
    assert len(found) >= len(wanted)
    distances = np.linalg.norm(found[:, None] - wanted[None], axis=2)
    assert distances.min(axis=0).max() < 1e-9
    # Points that are none of the corners lie on the faces between them.
    assert np.all(found.min(axis=0) > wanted.min(axis=0) - 1e-9)
    assert np.all(found.max(axis=0) < wanted.max(axis=0) + 1e-9)


def swept_robot(rng, tmp_path):
    """A random robot, swept to r.t4d; its moving joints, their values at TIMES, and the bound of the
    motion's chords."""
    text, moving = random_robot(rng)
    (tmp_path / "r.urdf").write_text(text)
    values = [[rng.uniform(-3, 3) for _ in moving] for _ in TIMES]
    write_table(tmp_path / "joints.csv", moving, values)
    swept = subprocess.run([BUILD / "t4d", "sweep", tmp_path / "r.urdf", "--motion",
                            tmp_path / "joints.csv", "--caps", "cone", "--json", "-o",
                            tmp_path / "r.t4d"], check=True, capture_output=True)
    robot = yourdfpy.URDF.load(str(tmp_path / "r.urdf"), load_meshes=False,
                               load_collision_meshes=False, build_collision_scene_graph=False)
    return robot, moving, values, json.loads(swept.stdout)["chord_bound"]


@pytest.mark.parametrize("seed", range(5))
def test_links_are_where_the_kinematics_put_them(seed, tmp_path):
    rng = random.Random(seed)
    robot, moving, values, _ = swept_robot(rng, tmp_path)
    for time, row in zip(TIMES, values):
        robot.update_cfg(dict(zip(moving, row)))
        for name in robot.link_map:
            found = vertices_of(tmp_path / "r.t4d", name, time, tmp_path)
            assert_same_points(found, expected_corners(robot, name))


@pytest.mark.parametrize("seed", range(5, 8))
def test_between_their_layers_links_are_within_the_bound(seed, tmp_path):
    rng = random.Random(seed)
    robot, moving, values, bound = swept_robot(rng, tmp_path)
    for time in [rng.uniform(0, 4) for _ in range(6)]:
        row = [np.interp(time, TIMES, column) for column in zip(*values)]
        robot.update_cfg(dict(zip(moving, row)))
        for name in robot.link_map:
            found = vertices_of(tmp_path / "r.t4d", name, time, tmp_path)
            assert_within(found, expected_corners(robot, name), bound)


def fcl_boxes(robot):
    """Every link as a solid box and as the mesh of its surface, which alone has exact distances."""
    solids, surfaces = {}, {}
    for name in robot.link_map:
        collision = robot.link_map[name].collisions[0]
        pose = robot.get_transform(name) @ collision.origin
        solids[name] = fcl.CollisionObject(fcl.Box(*collision.geometry.box.size),
                                           fcl.Transform(pose[:3, :3], pose[:3, 3]))
        hull = trimesh.convex.convex_hull(expected_corners(robot, name))
        mesh = fcl.BVHModel()
        mesh.beginModel(len(hull.vertices), len(hull.faces))
        mesh.addSubModel(hull.vertices, hull.faces)
        mesh.endModel()
        surfaces[name] = fcl.CollisionObject(mesh)
    return solids, surfaces


@pytest.mark.parametrize("seed", range(8, 10))
def test_distances_are_those_of_fcl_within_the_bound(seed, tmp_path):
    rng = random.Random(seed)
    robot, moving, values, chord_bound = swept_robot(rng, tmp_path)
    bound = 2 * chord_bound + 1e-9
    subprocess.run([BUILD / "t4d", "collide", tmp_path / "r.t4d", "--no-volume", "--frames", "20", "-q",
                    "-o", tmp_path / "clearance.csv"], check=True)
    with open(tmp_path / "clearance.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    apart = 0
    for time in sorted({float(row["time"]) for row in rows}):
        robot.update_cfg({joint: np.interp(time, TIMES, column)
                          for joint, column in zip(moving, zip(*values))})
        solids, surfaces = fcl_boxes(robot)
        for row in (row for row in rows if float(row["time"]) == time):
            a, b = row["a"], row["b"]
            true = 0 if fcl.collide(solids[a], solids[b]) else fcl.distance(surfaces[a], surfaces[b])
            assert abs(float(row["distance"]) - true) <= bound, (time, a, b)
            assert float(row["lower_bound"]) <= true + 1e-9, (time, a, b)
            apart += true > 0
    assert len(rows) >= 20 * 50 and 0 < apart < len(rows)

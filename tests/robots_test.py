"""Robots of the package example-robot-data as they come, each link as its convex hull: pinocchio says where they are,
FCL how far apart. And where planar and floating joints put links."""

import csv
import os
import random
import subprocess
import sysconfig
from pathlib import Path

import numpy as np
import pytest

fcl = pytest.importorskip("fcl")
pinocchio = pytest.importorskip("pinocchio")
spatial = pytest.importorskip("scipy.spatial")

BUILD = Path(os.environ["T4D_BUILD"])
FOLDER = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix/share/example-robot-data/robots"
ROBOTS = [
    "a1_description/urdf/a1", "go1_description/urdf/go1", "go2_description/urdf/go2", "laikago_description/urdf/laikago",
    "panda_description/urdf/panda", "panda_description/urdf/panda_collision", "xarm_description/urdf/xarm7",
    "z1_description/urdf/z1", "b1_description/urdf/b1", "ur_description/urdf/ur3_robot", "ur_description/urdf/ur5_robot",
    "ur_description/urdf/ur10_robot", "ur_description/urdf/ur3_gripper", "solo_description/robots/solo12",
    "bolt_description/robots/bolt", "so_arm_description/urdf/so100", "finger_edu_description/robots/finger_edu",
    "talos_data/robots/talos_left_arm", "allegro_hand_description/urdf/allegro_right_hand",
    "anymal_c_simple_description/urdf/anymal", "quadruped_description/urdf/quadruped",
    "double_pendulum_description/urdf/double_pendulum",
]  # fmt: skip
TIMES = [0.0, 0.4, 1.0]
FLOAT32 = 2e-6  # metres: meshes are STL


def t4d(*words, codes=(0,)):
    done = subprocess.run([BUILD / "t4d", *map(str, words)], check=False, capture_output=True, text=True)
    assert done.returncode in codes, done.stderr
    return done


class Judge:
    """A robot in pinocchio, and random values of its joints at each time."""

    def __init__(self, urdf):
        packages = [str(FOLDER), str(FOLDER.parent.parent)]
        self.model = pinocchio.buildModelFromUrdf(str(urdf))
        self.solids = pinocchio.buildGeomFromUrdf(
            self.model, str(urdf), pinocchio.GeometryType.COLLISION, package_dirs=packages)  # fmt: skip
        rng = random.Random(1)
        self.joints = [i for i in range(1, self.model.njoints) if self.model.joints[i].nv == 1]
        self.values = [[rng.uniform(-0.6, 0.6) for _ in self.joints] for _ in TIMES]

    def write_log(self, path):
        with open(path, "w", newline="") as file:
            rows = csv.writer(file)
            rows.writerow(["time", *(self.model.names[i] for i in self.joints)])
            rows.writerows([time, *map(repr, row)] for time, row in zip(TIMES, self.values))

    def points(self, row):
        """Of each body that is a mesh, at a time, by the name that t4d gives it."""
        q = pinocchio.neutral(self.model)
        for joint, value in zip(self.joints, row):
            at = self.model.joints[joint].idx_q
            is_circle = self.model.joints[joint].nq == 2
            q[at : at + 2 if is_circle else at + 1] = [np.cos(value), np.sin(value)] if is_circle else [value]
        data, placed = self.model.createData(), self.solids.createData()
        pinocchio.updateGeometryPlacements(self.model, data, self.solids, placed, q)
        found, counts = {}, {}
        for solid, pose in zip(self.solids.geometryObjects, placed.oMg):
            link = self.model.frames[solid.parentFrame].name
            counts[link] = counts.get(link, 0) + 1
            if hasattr(solid.geometry, "vertices"):
                name = link if counts[link] == 1 else f"{link} {counts[link]}"
                found[name] = np.asarray(solid.geometry.vertices()) @ pose.rotation.T + pose.translation
        return found


def slice_of(mesh, body, time, folder):
    t4d("slice", mesh, "--time", time, "--body", body, "-q", "-o", folder / "slice.obj")
    rows = [line.split()[1:4] for line in (folder / "slice.obj").read_text().splitlines() if line.startswith("v ")]
    return np.array(rows, dtype=float)


def hull_of(points):
    hull = spatial.ConvexHull(points)
    model = fcl.BVHModel()
    model.beginModel(len(points), len(hull.simplices))
    model.addSubModel(points, hull.simplices)
    model.endModel()
    return fcl.CollisionObject(model)


@pytest.mark.parametrize("robot", ROBOTS)
def test_links_are_where_pinocchio_puts_them_and_as_far_as_fcl_says(robot, tmp_path):
    urdf = FOLDER / f"{robot}.urdf"
    if not urdf.exists():
        pytest.skip("example-robot-data is not installed")
    judge = Judge(urdf)
    judge.write_log(tmp_path / "log.csv")
    mesh = tmp_path / "robot.t4d"
    t4d("sweep", urdf, "-m", tmp_path / "log.csv", "--hull", "always", "-q", "-o", mesh, codes=(0, 3))
    directions = np.random.default_rng(1).normal(size=(50, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    for time, row in zip(TIMES, judge.values):
        for name, points in list(judge.points(row).items())[:12]:
            found = slice_of(mesh, name, time, tmp_path)
            assert np.abs((found @ directions.T).max(0) - (points @ directions.T).max(0)).max() < FLOAT32, (name, time)
    points = dict(list(judge.points(judge.values[1]).items())[-5:])
    if len(points) < 2:
        return
    bodies = [word for name in points for word in ("--body", name)]
    t4d("collide", mesh, *bodies, "--adjacent", "--no-volume", "--times", TIMES[1], "-q", "-o", tmp_path / "c.csv")
    with open(tmp_path / "c.csv", newline="") as file:
        for pair in csv.DictReader(file):
            wanted = fcl.distance(hull_of(points[pair["a"]]), hull_of(points[pair["b"]]))
            assert abs(float(pair["distance"]) - max(wanted, 0)) < FLOAT32, pair


PARTS = {"planar": ["x", "y", "angle"], "floating": ["x", "y", "z", "qx", "qy", "qz", "qw"]}


def tree_of_all_joints(rng, links=8):
    """Boxes, and the type of the joint that moves each but the first."""
    text, kinds = "", {}
    for i in range(links):
        xyz, rpy, size = (" ".join(repr(rng.uniform(0.1, 1)) for _ in range(3)) for _ in range(3))
        text += f'<link name="l{i}"><collision><geometry><box size="{size}"/></geometry></collision></link>'
        if i:
            kinds[f"j{i}"] = rng.choice(["planar", "floating", "revolute"])
            text += (
                f'<joint name="j{i}" type="{kinds[f"j{i}"]}"><parent link="l{rng.randrange(i)}"/><child link="l{i}"/>'
                f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="0 0 1"/>'
                '<limit lower="-9" upper="9" velocity="99" effort="1"/></joint>'
            )
    return f'<robot name="tree">{text}</robot>', kinds


@pytest.mark.parametrize("seed", range(5))
def test_planar_and_floating_joints_put_links_where_pinocchio_does(seed, tmp_path):
    rng = random.Random(seed)
    text, kinds = tree_of_all_joints(rng)
    (tmp_path / "tree.urdf").write_text(text)
    model = pinocchio.buildModelFromUrdf(str(tmp_path / "tree.urdf"))
    solids = pinocchio.buildGeomFromUrdf(model, str(tmp_path / "tree.urdf"), pinocchio.GeometryType.COLLISION)
    names, rows, poses = [], [], []
    for joint, kind in kinds.items():
        names += [f"{joint}.{part}" for part in PARTS[kind]] if kind in PARTS else [joint]
    for time in TIMES:
        q, row = pinocchio.neutral(model), [time]
        for joint, kind in kinds.items():
            values = [rng.uniform(-1, 1) for _ in PARTS.get(kind, [0])]
            own = list(values)
            if kind == "floating":
                own[3:] = values[3:] = np.array(values[3:]) / np.linalg.norm(values[3:])
            elif kind == "planar":
                own[2:] = [np.cos(values[2]), np.sin(values[2])]
            at = model.joints[model.getJointId(joint)].idx_q
            q[at : at + len(own)] = own
            row += map(float, values)
        placed = solids.createData()
        pinocchio.updateGeometryPlacements(model, model.createData(), solids, placed, q)
        poses.append(placed)
        rows.append(row)
    with open(tmp_path / "log.csv", "w", newline="") as file:
        csv.writer(file).writerows([["time", *names], *rows])
    t4d("sweep", tmp_path / "tree.urdf", "-m", tmp_path / "log.csv", "-q", "-o", tmp_path / "tree.t4d")
    corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    for time, placed in zip(TIMES, poses):
        for solid, pose in zip(solids.geometryObjects, placed.oMg):
            wanted = corners * np.asarray(solid.geometry.halfSide) @ pose.rotation.T + pose.translation
            found = slice_of(tmp_path / "tree.t4d", solid.name.rpartition("_")[0], time, tmp_path)
            far = np.linalg.norm(found[:, None] - wanted[None], axis=2).min(axis=0).max()
            assert far < 1e-9, (time, solid.name)

"""Robots whose links are in COLLADA files are swept as those in .obj files with the same triangles."""

import json
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip("collada")
import t4d  # noqa: E402
from t4d import collada_mesh  # noqa: E402

CORNERS = np.array([(x, y, z) for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], dtype=float)
QUADS = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
TRIANGLES = [[one[0], *pair] for one in QUADS for pair in ((one[1], one[2]), (one[2], one[3]))]


def dae(path, nodes, metres=1.0, up="Z_UP", polygons=QUADS, kind="polylist"):
    """Nodes are texts of transforms, each with the cube below it."""
    places = " ".join(map(str, CORNERS.ravel()))
    corners = " ".join(str(corner) for one in polygons for corner in one)
    counts = f"<vcount>{' '.join(str(len(one)) for one in polygons)}</vcount>" if kind == "polylist" else ""
    scene = "".join(f'<node>{node}<instance_geometry url="#cube"/></node>' for node in nodes)
    path.write_text(f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="{metres}"/><up_axis>{up}</up_axis></asset>
<library_geometries><geometry id="cube"><mesh>
<source id="places"><float_array id="numbers" count="24">{places}</float_array><technique_common>
<accessor source="#numbers" count="8" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="vertices"><input semantic="POSITION" source="#places"/></vertices>
<{kind} count="{len(polygons)}"><input semantic="VERTEX" source="#vertices" offset="0"/>{counts}
<p>{corners}</p></{kind}></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene">{scene}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>""")
    return path


def obj(path, vertices):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(vertices).tolist()]
    faces = [f"f {' '.join(str(8 * part + corner + 1) for corner in one)}" for part in range(len(vertices) // 8)
             for one in TRIANGLES]  # fmt: skip
    path.write_text("\n".join([*lines, *faces, ""]))
    return path


def sweep(*words, cwd, code=0):
    words = [sys.executable, "-m", "t4d", "sweep", *map(str, words)]
    done = subprocess.run(words, capture_output=True, text=True, check=False, cwd=cwd)
    assert done.returncode == code, done.stderr
    assert "/tmp/t4d-" not in done.stderr
    return done.stderr


def test_triangles_are_where_nodes_and_the_unit_put_them(tmp_path):
    moved = "<translate>4 0 0</translate><scale>1 2 1</scale>"
    for up, kind, polygons in (("Z_UP", "polylist", QUADS), ("Y_UP", "triangles", TRIANGLES)):
        mesh = collada_mesh.read(str(dae(tmp_path / "a.dae", [moved, ""], 0.5, up, polygons, kind)))
        there = np.concatenate([CORNERS * [1, 2, 1] + [4, 0, 0], CORNERS]) / 2
        assert np.array_equal(mesh.vertices, there) and not mesh.losses
        assert abs(t4d.TriangleMesh(mesh.vertices, mesh.triangles).volume - 3) < 1e-12
    mirrored = collada_mesh.read(str(dae(tmp_path / "a.dae", ["<scale>-1 1 1</scale>"])))
    assert abs(t4d.TriangleMesh(mirrored.vertices, mirrored.triangles).volume - 8) < 1e-12


def test_a_mesh_of_its_own_is_turned_upright(tmp_path):
    """The specification says that right, inward and up are x -z y, x y z and -y -z x."""
    for up, there in (("Y_UP", [0, -3, 2]), ("Z_UP", [0, 2, 3]), ("X_UP", [-2, -3, 0])):
        mesh = t4d.read_triangles(dae(tmp_path / "a.dae", ["<translate>0 2 3</translate>"], up=up))
        assert mesh.closed and abs(mesh.volume - 8) < 1e-12 and np.array_equal(mesh.vertices.mean(axis=0), there), up


def test_what_is_no_mesh_is_said(tmp_path):
    (tmp_path / "a.dae").write_text("<COLLADA>")
    with pytest.raises(t4d.InvalidInput, match="a.dae: pycollada cannot read it"):
        collada_mesh.read(str(tmp_path / "a.dae"))
    with pytest.raises(t4d.InvalidInput, match="a.dae: has no triangles in its scene"):
        collada_mesh.read(str(dae(tmp_path / "a.dae", [])))


ROBOT = """<robot name="arm">
<link name="base"><collision><geometry><mesh filename="{base}" scale="0.5 0.5 1"/></geometry></collision>
<visual><geometry><mesh filename="nowhere.dae"/></geometry></visual></link>
<!-- <mesh filename="old.dae"/> -->
<link name="tip"><collision><origin xyz="0 0 2" rpy="0 0 1"/><geometry><mesh
 filename='{tip}'/></geometry></collision></link>
<joint name="j" type="revolute"><parent link="base"/><child link="tip"/><origin xyz="0 0 3"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" velocity="9" effort="1"/></joint>
</robot>
"""


def test_a_robot_of_collada_is_that_of_obj(tmp_path):
    package = tmp_path / "arm & hand"
    (package / "meshes").mkdir(parents=True)
    (package / "urdf").mkdir()
    dae(package / "meshes" / "base.dae", [""], up="Y_UP")
    dae(package / "meshes" / "tip.dae", ["<translate>1 0 0</translate>", "<translate>0 0 8</translate>"], 0.25)
    obj(package / "meshes" / "base.obj", CORNERS)
    obj(package / "meshes" / "tip.obj", np.concatenate([CORNERS + [1, 0, 0], CORNERS + [0, 0, 8]]) / 4)
    (tmp_path / "joints.csv").write_text("time,j\n0,0\n1,1\n2,0.5\n")
    for kind in ("dae", "obj"):
        text = ROBOT.format(base=f"../meshes/base.{kind}", tip=f"package://arm &amp; hand/meshes/tip.{kind}")
        (package / "urdf" / f"{kind}.urdf").write_text(text)
        robot = f"arm & hand/urdf/{kind}.urdf"
        sweep(robot, "--motion", "joints.csv", "-o", f"{kind}.t4d", cwd=tmp_path)
    found, wanted = (t4d.read(tmp_path / f"{kind}.t4d") for kind in ("dae", "obj"))
    assert found.names == wanted.names == ["base", "tip"] and found.up == "z"
    for name in found.names:
        for time in (0, 0.4, 1.9):
            assert np.array_equal(found[name].slice(time).vertices, wanted[name].slice(time).vertices), (name, time)
    again = t4d.verbs.sweep(package / "urdf" / "dae.urdf", motion=tmp_path / "joints.csv", output=t4d.Mesh).mesh
    assert again.names == ["base", "tip"]
    dae(package / "meshes" / "tip.dae", [""], polygons=QUADS[1:])
    said = sweep(package / "urdf" / "dae.urdf", "--motion", "joints.csv", "-o", "x.t4d", cwd=tmp_path, code=3)
    assert "lost: the shape of bodies that were mended (--mend): tip" in said, said


def test_a_mechanism_of_collada_is_in_metres(tmp_path):
    (tmp_path / "parts").mkdir()
    dae(tmp_path / "parts" / "box.dae", [""])
    obj(tmp_path / "parts" / "box.obj", CORNERS * 1000)
    (tmp_path / "turn.csv").write_text("time,wheel_deg\n0,0\n1,90\n")
    for kind in ("dae", "obj"):
        (tmp_path / f"{kind}.json").write_text(json.dumps({"length_unit": "mm", "time_unit": "s", "bodies": [{
            "name": "box", "solid": f"parts/box.{kind}", "joint": {"type": "revolute", "axis": [0, 0, 1]},
            "motion": {"file": "turn.csv", "column": "wheel"}}]}))  # fmt: skip
        sweep(f"{kind}.json", "-o", f"{kind}.t4d", cwd=tmp_path)
    found, wanted = (t4d.read(tmp_path / f"{kind}.t4d") for kind in ("dae", "obj"))
    assert (found.length_unit, found.time_unit) == ("mm", "s")
    for time in (0, 0.3):
        assert np.array_equal(found.slice(time).vertices, wanted.slice(time).vertices)


def test_the_package_that_is_missing_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "collada", None)
    with pytest.raises(t4d.Unsupported, match="a.dae: is COLLADA, which needs .*pip install pycollada"):
        collada_mesh.read(str(dae(tmp_path / "a.dae", [""])))


MJCF = """<mujoco><compiler angle="radian"/><asset><mesh name="part" file="part.obj"/></asset><worldbody>
<geom name="floor" type="plane" size="1 1 1"/>
<geom name="post" type="box" size="0.1 0.2 0.5" pos="0 0 -1"/>
<body name="arm" pos="0.1 0.2 0.3" euler="0.3 0.2 0.1">
  <joint name="lift" type="slide" axis="0 1 1" range="-1 1" limited="true"/>
  <joint name="turn" type="hinge" axis="1 0 0.5" pos="0 0.3 0" ref="0.25"/>
  <geom type="capsule" size="0.1 0.4" euler="1 0 0"/>
  <geom type="sphere" size="0.3" contype="0" conaffinity="0"/>
  <body name="hand" pos="0 0 0.6"><joint name="grip" type="hinge" axis="0 0 1"/>
    <geom type="mesh" mesh="part" pos="0.2 0 0"/><geom type="ellipsoid" size="0.1 0.2 0.3" euler="0 1 0"/></body>
  <body name="thumb"><joint name="follower" axis="1 0 0"/><geom type="cylinder" size="0.1 0.1" pos="0 0.5 0"/></body>
</body></worldbody>
<equality><joint joint1="follower" joint2="grip" polycoef="0.1 -2 0 0 0"/></equality></mujoco>
"""


def test_a_robot_of_mujoco_moves_as_in_mujoco(tmp_path):
    mujoco = pytest.importorskip("mujoco")
    obj(tmp_path / "part.obj", CORNERS * [0.1, 0.2, 0.3])
    (tmp_path / "robot.xml").write_text(MJCF)
    rows = {0: (0, 0, 0), 1: (0.4, -0.7, 0.5), 2: (-0.2, 1.1, 0.9)}
    log = "".join(f"{time},{','.join(map(str, row))}\n" for time, row in rows.items())
    (tmp_path / "log.csv").write_text("time,lift,turn,grip\n" + log)
    said = sweep("robot.xml", "--motion", "log.csv", "-o", "robot.t4d", cwd=tmp_path, code=3)
    assert "lost: robot.xml: floor of world: a plane" in said, said
    mesh = t4d.read(tmp_path / "robot.t4d")
    assert mesh.names == ["world", "arm", "hand", "hand 2", "thumb"] and mesh.up == "z"
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    data = mujoco.MjData(model)
    solids = {"hand": 4, "hand 2": 5, "thumb": 6, "arm": 2}  # geoms
    for time, (lift, turn, grip) in rows.items():
        follower = 0.1 - 2 * grip
        for name, value in (("lift", lift), ("turn", turn), ("grip", grip), ("follower", follower)):
            data.qpos[model.jnt_qposadr[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)]] = value
        mujoco.mj_kinematics(model, data)
        for name, geom in solids.items():
            pose, place = data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]
            found = (mesh[name].slice(time).vertices - place) @ pose  # in the frame of the geom
            low, high = found.min(axis=0), found.max(axis=0)
            size = {"hand": [0.1, 0.2, 0.3], "hand 2": [0.1, 0.2, 0.3], "thumb": [0.1, 0.1, 0.1], "arm": [0.1, 0.1, 0.5]}
            extent = np.sort(size[name]) if name == "hand" else size[name]  # mujoco gives a mesh its main axes
            assert np.allclose(np.sort(high) if name == "hand" else high, extent, atol=2e-7), (name, time, high)
            assert np.allclose(low, -high, atol=2e-7), (name, time)

"""Robots whose links are in COLLADA files are swept as those in .obj files with the same triangles; those of MuJoCo and
Gazebo move as their formats say."""

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


SDF = """<sdf version="1.9"><world name="cell">
<include><uri>model://sun</uri></include>
<model name="arm"><pose degrees="true">1 2 0.5  0 0 90</pose>
  <frame name="mount"><pose relative_to="base">0 0 1 0 0 0</pose></frame>
  <link name="base"><collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>
    <collision name="d"><geometry><box><size>0.4 0.4 2</size></box></geometry></collision></link>
  <joint name="shoulder" type="revolute"><pose relative_to="mount"/><parent>base</parent><child>upper</child>
    <axis><xyz>0 0 1</xyz><limit><lower>-1e16</lower><upper>1e16</upper></limit></axis></joint>
  <link name="upper"><pose relative_to="shoulder" rotation_format="quat_xyzw">1 0 0  1 0 0 0</pose>
    <collision name="c"><pose>0 0 0.1 0 0 0</pose><geometry><box><size>2 0.2 0.2</size></box></geometry></collision></link>
  <frame name="elbow_place" attached_to="upper"><pose relative_to="upper">1 0 0 0 0 0</pose></frame>
  <joint name="elbow" type="revolute"><pose relative_to="elbow_place"/><parent>elbow_place</parent><child>fore</child>
    <axis><xyz expressed_in="__model__">0 0 1</xyz><limit><lower>-2</lower><upper>2</upper></limit></axis></joint>
  <link name="fore"><pose relative_to="elbow">0.5 0 0 0 0 0</pose>
    <collision name="c"><geometry><mesh><uri>model://arm/fore.dae</uri><scale>0.5 0.1 0.1</scale></mesh></geometry>
    </collision></link>
  <joint name="loop" type="fixed"><parent>base</parent><child>fore</child></joint>
  <model name="hand"><pose relative_to="fore">0.5 0 0 0 0 0</pose><link name="palm">
    <collision name="c"><geometry><ellipsoid><radii>0.1 0.2 0.3</radii></ellipsoid></geometry></collision></link></model>
  <joint name="grip" type="prismatic"><parent>fore</parent><child>hand::palm</child>
    <axis><xyz>1 0 0</xyz><mimic joint="elbow"><multiplier>0.5</multiplier><offset>0.3</offset><reference>0.2</reference>
    </mimic></axis></joint>
</model></world></sdf>
"""


def test_a_robot_of_gazebo_is_a_chain_of_two_links(tmp_path):
    """Seen from above, the upper arm is 2 long and the forearm 1. The frame of the upper arm is turned by half about x,
    so what is above in it is below."""
    (tmp_path / "arm").mkdir()
    dae(tmp_path / "arm" / "fore.dae", [""])
    (tmp_path / "robot.sdf").write_text(SDF)
    rows = {0: (0, 0), 1: (0.4, -0.7), 2: (-0.2, 1.1)}
    log = "".join(f"{time},{','.join(map(str, row))}\n" for time, row in rows.items())
    (tmp_path / "log.csv").write_text("time,shoulder,elbow\n" + log)
    said = sweep("robot.sdf", "--motion", "log.csv", "-o", "robot.t4d", cwd=tmp_path, code=3)
    assert "lost: robot.sdf: what it includes: model://sun" in said, said
    assert "lost: robot.sdf: joint loop, which closes a loop" in said, said
    assert "lost: robot.sdf: c of base: plane" in said, said
    mesh = t4d.read(tmp_path / "robot.t4d")
    assert mesh.names == ["base", "upper", "fore", "hand::palm"] and mesh.up == "z"
    for time, (shoulder, elbow) in rows.items():
        upper, fore = np.pi / 2 + shoulder, np.pi / 2 + shoulder + elbow
        joint = np.array([1 + 2 * np.cos(upper), 2 + 2 * np.sin(upper), 1.5])
        along = np.array([np.cos(fore), np.sin(fore), 0])
        places = {
            "base": ([1, 2, 0.5], np.pi / 2, [0.2, 0.2, 1]),
            "upper": ([1 + np.cos(upper), 2 + np.sin(upper), 1.4], upper, [1, 0.1, 0.1]),
            "fore": (joint + 0.5 * along, fore, [0.5, 0.1, 0.1]),
            "hand::palm": (joint + (1 + 0.3 + 0.5 * (elbow - 0.2)) * along, fore, [0.1, 0.2, 0.3]),
        }
        for name, (middle, angle, half) in places.items():
            turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
            found = (mesh[name].slice(time).vertices - middle) @ turn
            assert np.allclose(found.max(axis=0), half, atol=2e-7), (name, time, found.max(axis=0))
            assert np.allclose(found.min(axis=0), np.negative(half), atol=2e-7), (name, time)


def test_old_axes_of_gazebo_are_those_of_the_model(tmp_path):
    """Before 1.5, and where a flag says so: the link is turned by a quarter about x, the axis is not."""
    box = "<geometry><box><size>2 0.4 0.2</size></box></geometry>"
    for version, flag, axis in (("1.4", "", 2), ("1.6", "<use_parent_model_frame>1</use_parent_model_frame>", 2),
                                ("1.6", "", 1), ("1.4", "<use_parent_model_frame>0</use_parent_model_frame>", 1)):  # fmt: skip
        (tmp_path / "r.sdf").write_text(
            f'<sdf version="{version}"><model name="m"><link name="a"><pose>0 0 0 1.5707963267948966 0 0</pose>'
            f'<collision name="c">{box}</collision></link><joint name="j" type="revolute"><parent>world</parent>'
            f"<child>a</child><axis><xyz>0 0 1</xyz>{flag}</axis></joint></model></sdf>"
        )
        (tmp_path / "log.csv").write_text("time,j_deg\n0,0\n1,90\n")
        sweep("r.sdf", "--motion", "log.csv", "-o", "r.t4d", cwd=tmp_path)
        turned = t4d.read(tmp_path / "r.t4d").slice(1).vertices
        # The long side lies along x and goes to y about the model's z, to z about the link's, which is -y.
        assert np.allclose(turned.max(axis=0), [0.1, 1, 0.2] if axis == 2 else [0.2, 0.1, 1], atol=1e-7), (version, flag)


@pytest.mark.parametrize(("text", "message"), [
    ("<sdf>", "r.sdf: is not XML"),
    ("<sdf/>", "r.sdf: has no <model>"),
    ('<sdf><model name="m"><link name="a"><pose>0 0 0</pose></link></model></sdf>', "model 'm': found the pose '0 0 0'"),
    ('<sdf><model name="m"><link name="a"><pose>0 0 b 0 0 0</pose></link></model></sdf>', "found '0 0 b 0 0 0' in <pose>"),
    ('<sdf><model name="m"><link name="a"><pose relative_to="b"/></link></model></sdf>', "'b' is no link, joint or frame"),
    ('<sdf><model name="m"><link name="a"><pose relative_to="a"/></link></model></sdf>', "'a' depends on itself"),
    ('<sdf><model name="m"><link name="a"/><joint name="j"><parent>b</parent><child>a</child></joint></model></sdf>',
     "'b' is no link of it"),
])  # fmt: skip
def test_what_is_no_robot_of_gazebo_is_said(text, message, tmp_path):
    (tmp_path / "r.sdf").write_text(text)
    (tmp_path / "log.csv").write_text("time,j\n0,0\n1,1\n")
    assert message in sweep("r.sdf", "--motion", "log.csv", "-o", "r.t4d", cwd=tmp_path, code=4)

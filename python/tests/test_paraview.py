"""The reader for ParaView and VTK gives what t4d slices, and reads no more than it needs."""

import json
import re
import subprocess
import sys
import xml.etree.ElementTree
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkCompositeDataSet
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline
from vtkmodules.vtkFiltersCore import vtkMassProperties
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

import t4d
from t4d import verbs

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "python" / "paraview"))
import t4d_reader  # noqa: E402


@pytest.fixture
def said():
    """The text that VTK shows its user."""
    window, before = vtkStringOutputWindow(), vtkOutputWindow.GetInstance()
    vtkOutputWindow.SetInstance(window)
    yield window.GetOutput
    vtkOutputWindow.SetInstance(before)


@pytest.fixture
def no_message(said):
    yield
    assert said() == ""


@pytest.fixture(scope="module")
def two_cubes(tmp_path_factory):
    """Two bodies: "early" lasts from 0 to 2, "late" from 1 to 3."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    bodies = [
        t4d.sweep([corners, corners + [1, 0, 0]], triangles, times=[begin, begin + 2], name=name).load()
        for name, begin in (("early", 0), ("late", 1))
    ]
    path = tmp_path_factory.mktemp("cubes") / "two.t4d"
    units = {"length_unit": "mm", "time_unit": "s"}
    t4d.Mesh._of([body._bodies[0] for body in bodies], metadata=units).save(path)
    return path


def reader_of(path, **properties):
    reader = t4d_reader.T4dReader()
    reader.SetFileName(str(path))
    for name, value in properties.items():
        getattr(reader, f"Set{name}")(*value if isinstance(value, tuple) else (value,))
    return reader


def blocks_of(reader, time=None):
    """The blocks of the output, by name."""
    reader.Update() if time is None else reader.UpdateTimeStep(time)
    output = reader.GetOutputDataObject(0)
    return {
        output.GetMetaData(i).Get(vtkCompositeDataSet.NAME()): output.GetBlock(i)
        for i in range(output.GetNumberOfBlocks())
    }


def one_block(reader, time=None):
    (block,) = blocks_of(reader, time).values()
    return block


def arrays_of(data):
    names = [data.GetArrayName(i) for i in range(data.GetNumberOfArrays())]
    return {name: vtk_to_numpy(data.GetArray(name)) for name in names}


def assert_same_arrays(found, expected):
    assert set(found) == set(expected)
    for name, rows in expected.items():
        assert (found[name].dtype, found[name].shape) == (rows.dtype, rows.shape), name
        assert found[name].tobytes() == rows.tobytes(), name  # NaNs, too


def assert_is(block, mesh):
    """Compares a block with a TriangleMesh, bit for bit."""
    assert np.array_equal(vtk_to_numpy(block.GetPoints().GetData()), mesh.vertices)
    polys = block.GetPolys()
    assert np.array_equal(vtk_to_numpy(polys.GetConnectivityArray()).reshape(-1, 3), mesh.triangles)
    assert np.array_equal(vtk_to_numpy(polys.GetOffsetsArray()), 3 * np.arange(len(mesh.triangles) + 1))
    assert_same_arrays(arrays_of(block.GetPointData()), mesh.vertex_attributes)
    assert_same_arrays(arrays_of(block.GetCellData()), mesh.triangle_attributes)


@pytest.mark.parametrize("light", [False, True])
@pytest.mark.parametrize("velocity", [False, True])
def test_at_any_time_it_is_the_slice(models, no_message, light, velocity):
    mesh = t4d.read(models / "screw.t4d")
    reader = reader_of(models / "screw.t4d", Light=light, Velocity=velocity)
    begin, end = mesh.time_span
    for time in [begin, 0.7, 2.5, 0.1, end]:
        block = one_block(reader, time)
        assert_is(block, mesh.slice(time, light=light, velocity=velocity))
        assert block.GetPointData().HasArray("velocity") == velocity
        assert block.GetCellData().HasArray("triangle")
        volume = vtkMassProperties()
        volume.SetInputData(block)
        expected = verbs.slice(models / "screw.t4d", time=time, light=light)["volume"]
        assert volume.GetVolume() == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("axis, value", [("x", 1.5), ("y", -3.0), ("z", 20.0), ("x", 1e6)])
def test_by_a_plane_it_is_the_section(models, no_message, axis, value):
    block = one_block(reader_of(models / "screw.t4d", SliceBy=axis, Value=value))
    assert_is(block, t4d.read(models / "screw.t4d").slice(**{axis: value}))


def test_by_a_hyperplane_it_is_the_section(models, no_message):
    reader = reader_of(models / "screw.t4d", SliceBy="hyperplane", Normal=(0, 0, 1, 1), Value=30)
    assert_is(one_block(reader), t4d.read(models / "screw.t4d").slice(hyperplane=(0, 0, 1, 1, 30)))


@pytest.mark.parametrize("name", ["cube", "screw"])
def test_by_nothing_it_is_the_grid_that_convert_writes(models, tmp_path, no_message, name):
    with pytest.warns(UserWarning, match="lost: metadata"):
        verbs.convert(models / f"{name}.t4d", tmp_path / "mesh.vtu", accept_loss=True)
    converted = vtkXMLUnstructuredGridReader()
    converted.SetFileName(str(tmp_path / "mesh.vtu"))
    converted.Update()
    expected = converted.GetOutput()
    grid = one_block(reader_of(models / f"{name}.t4d", SliceBy="nothing"))
    assert {grid.GetCellType(i) for i in range(grid.GetNumberOfCells())} == {VTK_TETRA}
    assert grid.GetPointData().HasArray("t") and grid.GetCellData().HasArray("triangle")
    found, wanted = (
        {
            "points": vtk_to_numpy(data.GetPoints().GetData()),
            "cells": vtk_to_numpy(data.GetCells().GetConnectivityArray()),
            **arrays_of(data.GetPointData()),
            **arrays_of(data.GetCellData()),
        }
        for data in (grid, expected)
    )
    found["cells"] = found["cells"].astype(wanted["cells"].dtype)
    assert_same_arrays(found, wanted)


def test_every_file_of_the_corpus(said):
    corpus = ROOT / "conformance" / "corpus" / "files" / "valid"
    for path in corpus.glob("*.t4d"):
        mesh = t4d.read(path)
        begin, end = mesh.time_span
        reader = reader_of(path)
        for time in (begin, 0.7 * begin + 0.3 * end, end):
            for body, block in zip(mesh, blocks_of(reader, time).values(), strict=True):
                if body.time_span[0] <= time <= body.time_span[1]:
                    assert_is(block, body.slice(time, velocity=True))
        reader.SetSliceBy("nothing")
        for body, grid in zip(mesh, blocks_of(reader).values(), strict=True):
            points = vtk_to_numpy(grid.GetPoints().GetData())
            vertices = np.column_stack([points, arrays_of(grid.GetPointData())["t"]])
            corners = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
            assert np.array_equal(vertices, body.vertices)
            assert np.array_equal(corners[:, [0, 1, 3, 2]], body.cells)
    # The note is about attribute-of-no-rows.t4d.
    assert said().strip() == "t4d: the attribute 'none' is left out: not all parts of the 4D mesh have it"


def test_an_attribute_t_gives_way_to_the_times():
    slab = SimpleNamespace(
        vertices=np.eye(4), cells=np.array([[0, 1, 2, 3]]), upper_layer=np.zeros((0, 4)),
        vertex_attributes={"t": np.full(4, 7.0)}, cell_attributes={},
    )  # fmt: skip
    with pytest.warns(UserWarning, match="the attribute 't' of vertices is left out"):
        grid = t4d_reader.grid_of(SimpleNamespace(slabs=lambda: [slab]))
    assert arrays_of(grid.GetPointData())["t"].tolist() == [0, 0, 0, 1]


def times_of(reader):
    reader.UpdateInformation()
    information = reader.GetOutputInformation(0)
    if not information.Has(Pipeline.TIME_STEPS()):
        assert not information.Has(Pipeline.TIME_RANGE())
        return ()
    times = information.Get(Pipeline.TIME_STEPS())
    assert information.Get(Pipeline.TIME_RANGE()) == (times[0], times[-1])
    return times


def test_its_times_are_the_layers(models, two_cubes, no_message):
    assert times_of(reader_of(models / "cube.t4d")) == tuple(range(65))
    reader = reader_of(two_cubes)
    assert times_of(reader) == (0, 1, 2, 3)
    reader.GetBodies().DisableArray("early")
    assert times_of(reader) == (1, 3)
    for way in ("x", "hyperplane", "nothing"):
        reader.SetSliceBy(way)
        assert times_of(reader) == ()
    reader.SetSliceBy("time")
    assert times_of(reader) == (1, 3)


def test_a_block_for_each_body_while_it_exists(two_cubes, no_message):
    mesh = t4d.read(two_cubes)
    reader = reader_of(two_cubes)
    assert [block.GetNumberOfPoints() > 0 for block in blocks_of(reader).values()] == [True, False]
    for time, there in ((0.5, ["early"]), (1.5, ["early", "late"]), (2.5, ["late"])):
        blocks = blocks_of(reader, time)
        assert list(blocks) == ["early", "late"]
        for name, block in blocks.items():
            if name in there:
                assert_is(block, mesh[name].slice(time, velocity=True))
            else:
                assert block.GetNumberOfPoints() == 0
        information = reader.GetOutputDataObject(0).GetInformation()
        assert information.Get(reader.GetOutputDataObject(0).DATA_TIME_STEP()) == time
    fields = reader.GetOutputDataObject(0).GetFieldData()
    units = {name: fields.GetAbstractArray(name).GetValue(0) for name in ("length_unit", "time_unit")}
    assert units == {"length_unit": "mm", "time_unit": "s"}
    reader.GetBodies().DisableArray("early")
    assert list(blocks_of(reader, 1.5)) == ["late"]
    reader.GetBodies().DisableAllArrays()
    assert blocks_of(reader, 1.5) == {}


def test_processes_share_the_bodies(two_cubes, no_message):
    made = []
    for piece in range(2):
        reader = reader_of(two_cubes)
        reader.UpdateInformation()
        reader.UpdatePiece(piece, 2, 0)
        output = reader.GetOutputDataObject(0)
        made.append([output.GetBlock(i) is not None for i in range(output.GetNumberOfBlocks())])
    assert made == [[True, False], [False, True]]


def test_outside_its_times_there_is_nothing_and_that_is_said_once(models, said):
    reader = reader_of(models / "cube.t4d")
    for time in (-1, 64.5, 100):
        assert one_block(reader, time).GetNumberOfPoints() == 0
    assert said().count("nothing to show before time 0.0 and after 64.0") == 1
    assert one_block(reader, 64).GetNumberOfPoints() > 0


def test_an_end_that_differs_by_rounding_is_the_end(models, no_message):
    reader = reader_of(models / "cube.t4d")
    assert one_block(reader, np.nextafter(64, 65)).GetNumberOfPoints() > 0


def test_what_is_not_light_is_said_once(tmp_path, said):
    box = np.zeros((3, 6, 6, 6), dtype=bool)
    box[:, 1:5, 1:4, 1:3] = True
    t4d.weave(box).save(tmp_path / "box.t4d")
    reader = reader_of(tmp_path / "box.t4d", Light=True)
    for time in (0.5, 1.5):
        assert_is(one_block(reader, time), t4d.read(tmp_path / "box.t4d").slice(time, velocity=True))
    assert said().count("exact where a slab does not consist of prisms") == 1


def test_another_file_is_read(models, two_cubes, no_message):
    reader = reader_of(two_cubes)
    assert list(blocks_of(reader)) == ["early", "late"]
    reader.SetFileName(str(models / "cube.t4d"))
    assert list(blocks_of(reader)) == t4d.read(models / "cube.t4d").names
    assert len(times_of(reader)) == 65


@pytest.fixture
def site(tmp_path):
    """Serves the files of tmp_path and counts the bytes: (URL before their names, bytes of a file sent)."""
    server = subprocess.Popen([sys.executable, ROOT / "tests/web_server.py", tmp_path], stdout=subprocess.PIPE)
    port = int(server.stdout.readline())

    def sent():
        requests = (tmp_path / "requests.jsonl").read_text().splitlines()
        return sum(json.loads(request)["bytes"] for request in requests)

    yield f"http://127.0.0.1:{port}/plain/", sent
    server.kill()
    server.wait()


def test_of_a_file_on_a_web_server_only_the_slabs_needed_are_read(site, tmp_path, models, no_message):
    vertices, triangles = t4d.read_triangles(models / "bolt.obj")
    growing = [(1 + time / 100) * vertices for time in range(101)]
    t4d.sweep(growing, triangles, times=range(101)).save(tmp_path / "bolt.t4d", compression=0)
    whole = (tmp_path / "bolt.t4d").stat().st_size
    url, sent = site
    reader = reader_of(url + "bolt.t4d")
    assert times_of(reader) == tuple(range(101))
    of_times = sent()
    block = one_block(reader, 50.25)
    of_slice = sent() - of_times
    assert_is(block, t4d.read(tmp_path / "bolt.t4d").slice(50.25, velocity=True))
    assert of_times + of_slice < whole / 4


@pytest.mark.parametrize(
    "path, properties, message",
    [
        ("", {}, "no file is set: give the path or URL of a .t4d file"),
        ("none.t4d", {}, "none.t4d"),
        ("paper-cube.obj", {}, "paper-cube.obj"),
        ("http://127.0.0.1:9/none.t4d", {}, "http://127.0.0.1:9/none.t4d"),
        ("cube.t4d", {"SliceBy": "hyperplane", "Normal": (0, 0, 0, 0)}, "normal"),
        ("cube.t4d", {"SliceBy": "x", "Value": float("nan")}, "nan"),
    ],
)
def test_what_fails_is_said(models, monkeypatch, said, path, properties, message):
    monkeypatch.chdir(models)
    reader = reader_of(path, **properties)
    reader.Update()
    sentences = [line for line in said().splitlines() if line.startswith("t4d: ")]
    assert sentences and all(message in line for line in sentences), said()
    assert "Traceback" not in said()


def test_before_there_is_a_file_nothing_is_said(no_message):
    assert times_of(t4d_reader.T4dURLReader()) == ()


def test_a_way_to_slice_that_is_none_is_refused():
    with pytest.raises(ValueError, match="slice by 't': expected one of time, x, y, z, hyperplane, nothing"):
        t4d_reader.T4dReader().SetSliceBy("t")


def test_without_the_module_it_says_what_to_do(models, monkeypatch, said):
    monkeypatch.setitem(sys.modules, "t4d", None)
    reader_of(models / "cube.t4d").Update()
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    assert f"contains t4d, built for Python {version}, to the environment variable PYTHONPATH" in said()


@pytest.mark.parametrize("own", [t4d_reader.FILE, t4d_reader.URL])
def test_paraviews_properties_are_the_readers(own):
    properties = xml.etree.ElementTree.fromstring(f"<all>{own}{t4d_reader.PROPERTIES}</all>")
    commands = [one.get("command") for one in properties if one.get("command")]
    assert set(commands) == {name for name in vars(t4d_reader.Reader) if name[:3] in ("Set", "Get")}
    ways = [one.get("value") for one in properties.iter("String")]
    assert ways == list(t4d_reader.SLICED_BY)
    for decorator in properties.iter("PropertyWidgetDecorator"):
        assert set(decorator.get("values").split()) <= set(ways)


def test_the_page_shows_what_happens(models, monkeypatch, capsys, no_message):
    monkeypatch.chdir(models)
    monkeypatch.setattr(sys, "path", list(sys.path))
    t4d.sweep(t4d.read_triangles("bolt.obj"), motion="screw-in.json", up="z").save("bolt.t4d")
    page = (ROOT / "docs" / "paraview.md").read_text().split("## In Python with VTK")[1]
    script = "".join(re.findall(r"^```python\n(.*?)^```$", page, re.M | re.S))
    exec(script, {})
    assert capsys.readouterr().out.splitlines() == re.findall(r"^print\(.*\)  # (.*)$", script, re.M)

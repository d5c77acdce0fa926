#!/usr/bin/python3
"""VTK opens the .vtu and .vtp files of t4d, and t4d the .vtu of VTK.

Usage: vtu_test.py T4D T4D_FIXTURES

Contouring the array `t` in VTK gives the volume of `t4d slice`. What VTK writes of the same grid, in
each of its encodings, converts to the same .t4d as the file of t4d. meshio opens the file, too; t4d reads
the binary Gmsh file of meshio, and meshio that of t4d. The
frames that a .pvd lists have its times, and the triangles and volumes of the manifest. Names of several
bodies, and those that older files have as strings, are the same in each encoding.
"""
import base64
import json
import os
import re
import subprocess
import sys
import tempfile
import types
import xml.etree.ElementTree as ElementTree

import meshio
import meshio.vtu._vtu
import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkStringArray
from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkFiltersCore import vtkContour3DLinearGrid, vtkContourFilter, vtkMassProperties
from vtkmodules.vtkIOXML import (vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader,
                                 vtkXMLUnstructuredGridWriter)

RELATIVE = 1e-9

# meshio decodes an array together with those that follow it, and relies on base64 to end at its padding, which it
# does until Python 3.12.
meshio.vtu._vtu.base64 = types.SimpleNamespace(
    b64encode=base64.b64encode, b64decode=lambda text: base64.b64decode(re.match("[^=]*=*", text).group()))


def run(*words):
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, f"{' '.join(words)}: exit {done.returncode}\n{done.stderr}"
    return done.stdout


def grid_of(path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def contour_volume(grid, time, contour):
    """The volume that the contour of `t` encloses: positive, because it faces outward."""
    contour.SetInputData(grid)
    contour.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_POINTS, "t")
    contour.SetValue(0, time)
    contour.SetComputeNormals(0)
    contour.Update()
    surface = contour.GetOutput()
    points = vtk_to_numpy(surface.GetPoints().GetData()).astype(float)
    corners = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    points -= points.mean(axis=0)
    a, b, c = (points[corners[:, i]] for i in range(3))
    return float((a * numpy.cross(b, c)).sum() / 6)


def check_frames(t4d, detail):
    """Frames of a.t4d; those of light slices have the triangles of the solid."""
    run(t4d, "frames", "a.t4d", "--count", "7", "--format", "vtp", "--attributes", "-o", "frames", *detail)
    with open("frames/manifest.json") as file:
        manifest = json.load(file)["frames"]
    sets = ElementTree.parse("frames/frames.pvd").getroot().findall("Collection/DataSet")
    assert len(sets) == len(manifest) == 7
    for listed, expected in zip(sets, manifest):
        assert listed.get("file") == expected["file"]
        assert float(listed.get("timestep")) == expected["time"]
        reader = vtkXMLPolyDataReader()
        reader.SetFileName("frames/" + expected["file"])
        reader.Update()
        solid = reader.GetOutput()
        assert solid.GetFieldData().GetArray("TimeValue").GetValue(0) == expected["time"]
        assert solid.GetNumberOfPoints() == expected["vertices"]
        assert solid.GetNumberOfPolys() == expected["triangles"]
        assert solid.GetCellData().GetArray("triangle").GetNumberOfTuples() == expected["triangles"]
        mass = vtkMassProperties()
        mass.SetInputData(solid)
        assert abs(mass.GetVolume() - expected["volume"]) <= RELATIVE * expected["volume"]


def check_names(t4d):
    """Names of two bodies: as t4d writes them, and as strings, which VTK writes in each encoding."""
    names = ["erster", "Ring ø"]
    with open("paper-cube.obj") as file:
        lines = [line for line in file if line[:2] in ("v ", "f ")]
    with open("both.obj", "w") as file:
        for number, name in enumerate(names):
            file.write(f"o {name}\n")
            for line in lines:
                words = line.split()
                if words[0] == "v":
                    file.write(f"v {float(words[1]) + 100 * number} {words[2]} {words[3]}\n")
                else:
                    count = sum(other[0] == "v" for other in lines)
                    corners = (int(word.split("/")[0]) + count * number for word in words[1:])
                    file.write("f " + " ".join(map(str, corners)) + "\n")
    run(t4d, "sweep", "both.obj", "--bodies", "object", "--motion", "paper-translation.json", "--steps", "1",
        "-o", "both.t4d")
    run(t4d, "convert", "both.t4d", "both.vtu", "--accept-loss")
    assert len(meshio.read("both.vtu").cells_dict["tetra"]) > 0
    for as_strings in (False, True):
        grid = grid_of("both.vtu")
        if as_strings:
            grid.GetFieldData().RemoveArray("body_names")
            strings = vtkStringArray()
            strings.SetName("body_names")
            for name in names:
                strings.InsertNextValue(name)
            grid.GetFieldData().AddArray(strings)
        for mode in ("Ascii", "Binary", "Appended"):
            for compressor in ("None", "ZLib", "LZ4", "LZMA"):
                for encoded in (0, 1):
                    writer = vtkXMLUnstructuredGridWriter()
                    writer.SetInputData(grid)
                    writer.SetFileName("c.vtu")
                    getattr(writer, f"SetDataModeTo{mode}")()
                    getattr(writer, f"SetCompressorTypeTo{compressor}")()
                    writer.SetEncodeAppendedData(encoded)
                    writer.Write()
                    run(t4d, "convert", "c.vtu", "c.t4d")
                    bodies = json.loads(run(t4d, "info", "c.t4d", "--json"))["bodies"]
                    found = [body["name"] for body in bodies]
                    assert found == names, f"{mode}, {compressor}, {encoded}, {as_strings}: {found}"


def main(t4d, fixtures):
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        run(fixtures, ".")
        check_names(t4d)
        for solid, motion in (("paper-cube", "paper-translation"), ("torus", "several-segments")):
            # A name of its own, and attributes: both are kept.
            run(t4d, "sweep", solid + ".obj", "--motion", motion + ".json", "--caps", "cone",
                "--body", "Körper 1", "-o", "a.t4d")
            run(t4d, "convert", "a.t4d", "a.vtu", "--accept-loss")
            grid = grid_of("a.vtu")
            info = json.loads(run(t4d, "info", "a.t4d", "--json"))
            assert grid.GetNumberOfCells() == info["tetrahedra"], "VTK has not all tetrahedra"
            assert grid.GetNumberOfPoints() == info["vertices"], "VTK has not all vertices"
            begin, end = grid.GetPointData().GetArray("t").GetRange()
            for fraction in (0.0137, 0.31, 0.7, 0.93):
                time = begin + fraction * (end - begin)
                expected = json.loads(run(t4d, "slice", "a.t4d", "--time", repr(time), "--json"))
                for contour in (vtkContourFilter(), vtkContour3DLinearGrid()):
                    found = contour_volume(grid, time, contour)
                    # The second one has points in single precision.
                    allowed = 1e-5 if isinstance(contour, vtkContour3DLinearGrid) else RELATIVE
                    assert abs(found - expected["volume"]) <= allowed * expected["volume"], (
                        f"{solid} at {time}: VTK {found}, t4d {expected['volume']}")

            check_frames(t4d, [])
            check_frames(t4d, ["--light"])

            mesh = meshio.read("a.vtu")
            assert len(mesh.cells_dict["tetra"]) == info["tetrahedra"]
            assert "t" in mesh.point_data

            run(t4d, "convert", "a.vtu", "same.t4d")
            again = json.loads(run(t4d, "info", "same.t4d", "--json"))
            assert [b["name"] for b in again["bodies"]] == ["Körper 1"]
            assert {"kind", "triangle"} <= set(mesh.cell_data)
            with open("same.t4d", "rb") as file:
                same = file.read()

            # meshio's binary Gmsh has all that is ours.
            timed = meshio.Mesh(mesh.points, mesh.cells, point_data={"time": mesh.point_data["t"]})
            meshio.write("a.msh", timed, file_format="gmsh", binary=True)
            run(t4d, "convert", "a.msh", "b.t4d")
            run(t4d, "convert", "b.t4d", "b.off", "--to", "off-ijk", "--accept-loss")
            run(t4d, "convert", "same.t4d", "a.off", "--to", "off-ijk", "--accept-loss")
            with open("a.off") as file, open("b.off") as other:
                assert file.read() == other.read(), "the mesh through meshio's Gmsh file differs"
            run(t4d, "convert", "a.t4d", "a.msh", "--to", "gmshb", "--accept-loss")
            assert len(meshio.read("a.msh").cells_dict["tetra"]) == info["tetrahedra"]
            encodings = 0
            for mode in ("Ascii", "Binary", "Appended"):
                for compressor in ("None", "ZLib", "LZ4", "LZMA") if mode != "Ascii" else ("None",):
                    for encoded in (False, True):
                        writer = vtkXMLUnstructuredGridWriter()
                        writer.SetInputData(grid)
                        writer.SetFileName("a.vtu")
                        getattr(writer, f"SetDataModeTo{mode}")()
                        getattr(writer, f"SetCompressorTypeTo{compressor}")()
                        writer.SetEncodeAppendedData(encoded)
                        (writer.SetHeaderTypeToUInt64 if encoded else writer.SetHeaderTypeToUInt32)()
                        # Half of them, each compressor in both orders.
                        big = encoded != (mode == "Binary")
                        (writer.SetByteOrderToBigEndian if big else writer.SetByteOrderToLittleEndian)()
                        writer.Write()
                        run(t4d, "convert", "a.vtu", "b.t4d")
                        with open("b.t4d", "rb") as file:
                            assert file.read() == same, f"{mode}, {compressor}, {encoded}"
                        encodings += 1
            print(f"{solid}: 4 contours, {encodings} encodings, 14 frames")


main(os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]))

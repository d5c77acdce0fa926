#!/usr/bin/python3
"""t4d reads the surfaces that VTK and meshio write, and its own.

Usage: vtk_surface_test.py T4D T4D_FIXTURES

What VTK writes of a surface, as polygonal data or as a grid, in each of its encodings, is the same mesh to
the byte. The boundary of a grid of volume cells encloses the volume of the cells. Frames as .vtp are the
series that they were written of, and a .pvd that VTK's Python users write has parts and uneven times.
"""
import filecmp
import json
import os
import subprocess
import sys
import tempfile

import meshio
import numpy
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkIdList, vtkPoints
from vtkmodules.vtkCommonDataModel import (VTK_HEXAHEDRON, VTK_PYRAMID, VTK_TETRA, VTK_VOXEL, VTK_WEDGE,
                                           vtkUnstructuredGrid)
from vtkmodules.vtkFiltersCore import vtkAppendFilter, vtkStripper
from vtkmodules.vtkFiltersGeneral import vtkTransformPolyDataFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkCommonTransforms import vtkTransform
from vtkmodules.vtkIOXML import (vtkXMLPolyDataReader, vtkXMLPolyDataWriter,
                                 vtkXMLUnstructuredGridWriter)


def run(*words, code=0):
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == code, f"{' '.join(words)}: exit {done.returncode}\n{done.stderr}"
    return done.stdout


def mended(t4d, name):
    """What t4d says of a mesh in which there is nothing to mend."""
    report = json.loads(run(t4d, "mend", name, "-o", "mended.ply", "--json"))
    assert not report["changes"], report["changes"]
    return report


def ball(center=(0, 0, 0), radius=1):
    source = vtkSphereSource()
    source.SetCenter(center)
    source.SetRadius(radius)
    source.SetThetaResolution(24)
    source.SetPhiResolution(24)
    source.Update()
    surface = source.GetOutput()
    # Some versions of VTK write eight digits of a float, which are enough for these.
    points = vtk_to_numpy(surface.GetPoints().GetData())
    points[:] = numpy.round(points * 256) / 256
    return surface


def write(writer, data, name):
    writer.SetInputData(data)
    writer.SetFileName(name)
    assert writer.Write() == 1


def encodings():
    """Each data mode, compressor, kind of appended data, byte order and header."""
    for mode in ("Ascii", "Binary", "Appended"):
        for compressor in ("None", "ZLib", "LZ4", "LZMA") if mode != "Ascii" else ("None",):
            for encoded in (False, True) if mode == "Appended" else (False,):
                for order in ("BigEndian", "LittleEndian"):
                    for header in ("UInt32", "UInt64"):
                        yield mode, compressor, encoded, order, header


def check_encodings(t4d):
    surface = ball()
    heights = numpy.array([surface.GetPoint(i)[2] for i in range(surface.GetNumberOfPoints())])
    pressure = numpy_to_vtk(heights, deep=True)
    pressure.SetName("pressure")
    surface.GetPointData().AddArray(pressure)
    grid = vtkAppendFilter()
    grid.AddInputData(surface)
    grid.Update()
    with open("rest.json", "w") as file:
        json.dump({"segments": [{"duration": 1, "translation": [1, 0, 0]}]}, file)
    count = 0
    expected = None
    for writer_type, data, name in ((vtkXMLPolyDataWriter, surface, "a.vtp"),
                                    (vtkXMLUnstructuredGridWriter, grid.GetOutput(), "a.vtu")):
        for mode, compressor, encoded, order, header in encodings():
            writer = writer_type()
            getattr(writer, f"SetDataModeTo{mode}")()
            getattr(writer, f"SetCompressorTypeTo{compressor}")()
            writer.SetEncodeAppendedData(encoded)
            getattr(writer, f"SetByteOrderTo{order}")()
            getattr(writer, f"SetHeaderTypeTo{header}")()
            writer.SetBlockSize(4096)
            write(writer, data, name)
            run(t4d, "sweep", name, "--motion", "rest.json", "--steps", "1", "--caps", "cone", "-o", "a.t4d")
            run(t4d, "slice", "a.t4d", "--time", "0", "--light", "--attributes", "-o", "a.ply")
            with open("a.ply", "rb") as file:
                found = file.read()
            expected = expected or found
            assert b"pressure" in found
            assert found == expected, f"{name}, {mode}, {compressor}, {encoded}, {order}, {header}"
            count += 1
    return count


def check_strips_and_meshio(t4d):
    triangles = mended(t4d, "a.vtp")
    with open("mended.ply", "rb") as file:
        assert b"pressure" in file.read()
    strips = vtkStripper()
    strips.SetInputData(ball())
    strips.Update()
    write(vtkXMLPolyDataWriter(), strips.GetOutput(), "strips.vtp")
    found = mended(t4d, "strips.vtp")
    assert found["triangles"] == triangles["triangles"]
    assert abs(found["volume_after"] - triangles["volume_after"]) < 1e-12, found
    mesh = meshio.read("mended.ply")
    for name, options in (("io.vtu", {}), ("io.vtu", {"compression": None}),
                          ("io.vtu", {"compression": "lzma"})):
        meshio.write(name, meshio.Mesh(mesh.points, mesh.cells), **options)
        again = mended(t4d, name)
        assert again["triangles"] == triangles["triangles"], options
        assert abs(again["volume_after"] - triangles["volume_after"]) < 1e-12, options


def grid_of(points, cells):
    grid = vtkUnstructuredGrid()
    places = vtkPoints()
    places.SetDataTypeToDouble()
    for point in points:
        places.InsertNextPoint(point)
    grid.SetPoints(places)
    for kind, corners in cells:
        ids = vtkIdList()
        for corner in corners:
            ids.InsertNextId(corner)
        grid.InsertNextCell(kind, ids)
    return grid


def check_volumes(t4d):
    """Each kind of cell in both orders of its corners, and all of them joined."""
    cube = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    hexahedron = [0, 1, 3, 2, 4, 5, 7, 6]
    alone = [
        (VTK_VOXEL, list(range(8)), list(range(4, 8)) + list(range(4)), 1),
        (VTK_HEXAHEDRON, hexahedron, hexahedron[4:] + hexahedron[:4], 1),
        (VTK_WEDGE, [0, 1, 2, 4, 5, 6], [4, 5, 6, 0, 1, 2], 1 / 2),
        (VTK_PYRAMID, [0, 1, 3, 2, 4], [0, 2, 3, 1, 4], 1 / 3),
        (VTK_TETRA, [0, 1, 2, 4], [0, 2, 1, 4], 1 / 6),
    ]
    for kind, corners, other, volume in alone:
        for order in (corners, other):
            write(vtkXMLUnstructuredGridWriter(), grid_of(cube, [(kind, order)]), "cell.vtu")
            found = mended(t4d, "cell.vtu")
            assert abs(found["volume_after"] - volume) < 1e-12, (kind, order, found)
    # A hexahedron with a pyramid on its top, a wedge at its side, and a tetrahedron at the end of that one.
    points = cube + [(0.5, 0.5, 2), (2, 0, 0), (2, 1, 0), (1.5, -1, 0.5)]
    cells = [(VTK_HEXAHEDRON, hexahedron), (VTK_PYRAMID, [4, 5, 7, 6, 8]), (VTK_WEDGE, [1, 5, 9, 3, 7, 10]),
             (VTK_TETRA, [1, 5, 9, 11])]
    volume = 1 + 1 / 3 + 1 / 2 + 1 / 6
    write(vtkXMLUnstructuredGridWriter(), grid_of(points, cells), "cells.vtu")
    found = mended(t4d, "cells.vtu")
    assert found["components"] == 1
    assert abs(found["volume_after"] - volume) < 1e-12, found
    # The same cells with points of their own: those at one place are one.
    pieces = vtkAppendFilter()
    pieces.MergePointsOff()
    for cell in cells:
        pieces.AddInputData(grid_of(points, [cell]))
    pieces.Update()
    write(vtkXMLUnstructuredGridWriter(), pieces.GetOutput(), "pieces.vtu")
    assert abs(mended(t4d, "pieces.vtu")["volume_after"] - found["volume_after"]) < 1e-12


def check_frames(t4d):
    """Frames of a deformation come back as they were, times and triangles."""
    run(t4d, "sweep", *sorted(f"bending_{i}.obj" for i in range(9)), "--frame-time", "0.25", "-o", "b.t4d")
    run(t4d, "frames", "b.t4d", "--frames", "9", "--light", "-o", "fr/b_%d.vtp")
    run(t4d, "sweep", "fr/b.pvd", "--body", "bending_0", "-o", "again.t4d")
    run(t4d, "diff", "b.t4d", "again.t4d", "--tolerance", "0")
    for name in ("b", "again"):
        run(t4d, "slice", f"{name}.t4d", "--time", "1.1", "-o", f"{name}.ply")
    assert filecmp.cmp("b.ply", "again.ply", shallow=False), "frames differ from their deformation"
    run(t4d, "slice", "b.t4d", "--time", "1.1", "-o", "slice.vtp")
    mended(t4d, "slice.vtp")
    reader = vtkXMLPolyDataReader()
    reader.SetFileName("slice.vtp")
    reader.Update()
    assert reader.GetOutput().GetNumberOfPolys() == json.loads(
        run(t4d, "mend", "b.ply", "-o", "c.ply", "--json"))["triangles"]


def check_collection(t4d):
    """Two balls in parts, at uneven times that are not in order."""
    times = [0, 0.5, 2]
    os.mkdir("sub")
    listed = []
    for number, time in enumerate(times):
        for part in (0, 1):
            name = f"sub/balls_{number}_{part}.vtp"
            move = vtkTransform()
            move.Translate(time, 3 * part, 0)
            moved = vtkTransformPolyDataFilter()
            moved.SetTransform(move)
            moved.SetInputData(ball())
            moved.Update()
            write(vtkXMLPolyDataWriter(), moved.GetOutput(), name)
            listed.append(f'<DataSet timestep="{time}" group="" part="{part}" file="{name}"/>')
    with open("balls.pvd", "w") as file:
        file.write('<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n<Collection>\n' +
                   "\n".join(reversed(listed)) + "\n</Collection>\n</VTKFile>\n")
    one = json.loads(run(t4d, "mend", "sub/balls_0_0.vtp", "-o", "mended.ply", "--json"))["volume_after"]
    run(t4d, "sweep", "balls.pvd", "-o", "balls.t4d")
    run(t4d, "weave", "balls.pvd", "--voxel-size", "0.2", "-o", "woven.t4d")
    for name, tolerance in (("balls", 1e-6), ("woven", 0.06)):
        info = json.loads(run(t4d, "info", f"{name}.t4d", "--json"))
        assert (info["time_begin"], info["time_end"]) == (0, 2), name
        for time in times:
            found = json.loads(run(t4d, "slice", f"{name}.t4d", "--time", str(time), "--json"))
            assert abs(found["volume"] - 2 * one) < tolerance * one, (name, time, found["volume"], one)
    with open("balls.pvd") as file:
        text = file.read()
    with open("sub/outside.pvd", "w") as file:
        file.write(text.replace("sub/", "../sub/../bending_", 1))
    run(t4d, "sweep", "sub/outside.pvd", "-o", "none.t4d", code=4)


def main(t4d, fixtures):
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        run(fixtures, ".")
        count = check_encodings(t4d)
        check_strips_and_meshio(t4d)
        check_volumes(t4d)
        check_frames(t4d)
        check_collection(t4d)
        print(f"surfaces of VTK: {count} encodings, grids of 5 kinds of cells, 2 series")


main(os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]))

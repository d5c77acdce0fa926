"""What others take for the inputs of `t4d-bench --files`: prints seconds as JSON.

    peers.py pass FILE.npy              numpy: which samples are above 0
    peers.py surfaces FILE.nrrd         VTK: vtkFlyingEdges3D of each frame, in space
    peers.py contour FILE.vtu TIME      VTK: vtkContour3DLinearGrid of all cells, by time
    peers.py decimate POINTS TRIANGLES RATIO
                                        fast-simplification: the surface with these doubles and
                                        32-bit integers

Loading Python, numpy and VTK does not count; reading the file does, but for the .vtu and the surface.
"""

import json
import sys
import time

import numpy


def read_nrrd(path):
    with open(path, "rb") as file:
        fields = {}
        for line in iter(lambda: file.readline().decode().strip(), ""):
            name, colon, value = line.partition(": ")
            if colon:
                fields[name] = value
        kind = {"uint8": numpy.uint8, "float": numpy.float32}[fields["type"]]
        shape = [int(size) for size in fields["sizes"].split()]
        return numpy.fromfile(file, kind).reshape(shape[::-1])


def pass_over(path):
    samples = numpy.load(path, mmap_mode="r")
    return sum(int((frame > 0).sum()) for frame in samples)


def surfaces(path):
    import vtkmodules.all as vtk
    from vtkmodules.util.numpy_support import numpy_to_vtk

    triangles = 0
    frames = read_nrrd(path)
    for frame in frames:
        image = vtk.vtkImageData()
        image.SetDimensions(frame.shape[::-1])
        image.GetPointData().SetScalars(numpy_to_vtk(frame.ravel()))
        edges = vtk.vtkFlyingEdges3D()
        edges.SetInputData(image)
        edges.SetValue(0, 0.5 if frame.dtype == numpy.uint8 else 0.0)
        edges.ComputeNormalsOff()
        edges.Update()
        triangles += edges.GetOutput().GetNumberOfPolys()
    return triangles


def contour(path, time_of_slice):
    import vtkmodules.all as vtk

    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    mesh = reader.GetOutput()
    mesh.GetPointData().SetActiveScalars("t")
    begin = time.perf_counter()
    cut = vtk.vtkContour3DLinearGrid()
    cut.SetInputData(mesh)
    cut.SetValue(0, float(time_of_slice))
    cut.MergePointsOn()
    cut.Update()
    seconds = time.perf_counter() - begin
    return seconds, cut.GetOutput().GetNumberOfPolys()


def decimate(points, triangles, ratio):
    import fast_simplification

    points = numpy.fromfile(points).reshape(-1, 3)
    triangles = numpy.fromfile(triangles, numpy.uint32).reshape(-1, 3)
    begin = time.perf_counter()
    _, left = fast_simplification.simplify(points, triangles, 1 - float(ratio))
    return time.perf_counter() - begin, len(left)


def timed(work, *arguments):
    begin = time.perf_counter()
    result = work(*arguments)
    return time.perf_counter() - begin, result


def main():
    what, arguments = sys.argv[1], sys.argv[2:]
    if what in ("surfaces", "contour"):
        import vtkmodules.all  # noqa: F401
    if what in ("contour", "decimate"):
        seconds, result = {"contour": contour, "decimate": decimate}[what](*arguments)
    else:
        seconds, result = timed({"pass": pass_over, "surfaces": surfaces}[what], *arguments)
    print(json.dumps({"seconds": seconds, "result": result}))


main()

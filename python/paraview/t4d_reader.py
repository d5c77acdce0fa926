"""A reader of .t4d for ParaView and VTK: 4D meshes, sliced at any time.

In ParaView, load this file with Tools > Manage Plugins > Load New. In Python with VTK:

>>> from t4d_reader import T4dReader
>>> reader = T4dReader()
>>> reader.SetFileName("bolt.t4d")
>>> reader.UpdateTimeStep(2.5)
>>> bolt = reader.GetOutputDataObject(0).GetBlock(0)

The output has a block for each body. docs/paraview.md describes the properties.
"""

import functools
import sys
import warnings

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkDataArraySelection, vtkOutputWindow, vtkPoints, vtkStringArray
from vtkmodules.vtkCommonDataModel import (
    VTK_TETRA,
    vtkCellArray,
    vtkCompositeDataSet,
    vtkDataObject,
    vtkMultiBlockDataSet,
    vtkPolyData,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm, vtkStreamingDemandDrivenPipeline

try:
    from paraview.util.vtkAlgorithm import VTKPythonAlgorithmBase, smproperty, smproxy
except ModuleNotFoundError:  # VTK alone
    from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase

    class WithoutParaView:
        """Decorators that leave a class as it is."""

        def __getattr__(self, _):
            return lambda *_, **__: lambda decorated: decorated

    smproperty = smproxy = WithoutParaView()

SLICED_BY = ("time", "x", "y", "z", "hyperplane", "nothing")
PIPELINE = vtkStreamingDemandDrivenPipeline


# Arrays of t4d to data of VTK


def points_of(positions):
    points = vtkPoints()
    points.SetData(numpy_to_vtk(positions, deep=True))
    return points


def cells_of(corners):
    """The cells of (n, k) indices: n cells with k corners each."""
    cells = vtkCellArray()
    cells.SetData(corners.shape[1], numpy_to_vtk(corners.astype(np.int64, copy=False).ravel(), deep=True))
    return cells


def add_arrays(data, attributes):
    for name, values in attributes.items():
        array = numpy_to_vtk(values, deep=True)
        array.SetName(name)
        data.AddArray(array)


def surface_of(mesh):
    surface = vtkPolyData()
    surface.SetPoints(points_of(mesh.vertices))
    surface.SetPolys(cells_of(mesh.triangles))
    add_arrays(surface.GetPointData(), mesh.vertex_attributes)
    add_arrays(surface.GetCellData(), mesh.triangle_attributes)
    return surface


def grid_of(body):
    """All tetrahedra of a body, at (x, y, z), with point data `t`."""
    vertices, cells, of_vertices, of_cells = [], [], [], []
    end = shared = 0  # a slab shares its lower layer with the slab before
    for slab in body.slabs():
        first = end - shared
        end = first + len(slab.vertices)
        vertices.append(slab.vertices[shared:])
        # VTK's contours of t face outward with the corners in this order.
        cells.append(slab.cells[:, [0, 1, 3, 2]].astype(np.int64) + first)
        of_vertices.append({name: rows[shared:] for name, rows in slab.vertex_attributes.items()})
        of_cells.append(slab.cell_attributes)
        shared = len(slab.upper_layer)
    points = np.concatenate(vertices)
    grid = vtkUnstructuredGrid()
    grid.SetPoints(points_of(points[:, :3]))
    grid.SetCells(VTK_TETRA, cells_of(np.concatenate(cells)))
    attributes = joined(of_vertices)
    if "t" in attributes:
        warnings.warn("the attribute 't' of vertices is left out: point data t are the times")
    add_arrays(grid.GetPointData(), {**attributes, "t": points[:, 3]})
    add_arrays(grid.GetCellData(), joined(of_cells))
    return grid


def joined(attributes_of_slabs):
    """The attributes that all slabs have, of one type."""
    kinds = [{(name, rows.dtype, rows.shape[1:]) for name, rows in slab.items()} for slab in attributes_of_slabs]
    kept = {name for name, *_ in set.intersection(*kinds)}
    for name in sorted({name for name, *_ in set.union(*kinds)} - kept):
        warnings.warn(f"the attribute '{name}' is left out: not all parts of the 4D mesh have it")
    return {name: np.concatenate([slab[name] for slab in attributes_of_slabs]) for name in kept}


def solid_at(body, time, **options):
    """The slice of a body at a time; nothing before it begins and after it ends."""
    begin, end = body.time_span
    try:
        return surface_of(body.slice(time, **options))
    except ValueError:
        # Times that differ from the end by rounding are the end, so t4d says what is outside.
        if begin <= time <= end:
            raise
        return vtkPolyData()


def add_texts(data, texts):
    for name, text in texts.items():
        array = vtkStringArray()
        array.SetName(name)
        array.InsertNextValue(text)
        data.AddArray(array)


# What is said to the user


def read(path_or_url):
    """The mesh by t4d, which is imported no earlier, so that its absence can be explained."""
    try:
        import t4d
    except ImportError as error:
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        raise ImportError(
            f"the Python module t4d cannot be imported ({error}). Add the folder that contains t4d, built for "
            f"Python {version}, to the environment variable PYTHONPATH and start this program again"
        ) from error
    return t4d.read(path_or_url)


def reported(request):
    """Shows what a request warns of, once for each file, and why it fails."""

    @functools.wraps(request)
    def reporting(self, _, inputs, outputs):
        window = vtkOutputWindow.GetInstance()
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                request(self, outputs.GetInformationObject(0))
                succeeded = 1
            except (ImportError, MemoryError, OSError, RuntimeError, ValueError) as error:
                window.DisplayErrorText(f"t4d: {error or 'not enough memory'}\n")
                succeeded = 0
        for sentence in {str(warning.message): None for warning in caught}:
            if sentence not in self._said:
                self._said.add(sentence)
                window.DisplayWarningText(f"t4d: {sentence}\n")
        return succeeded

    return reporting


class Reader(VTKPythonAlgorithmBase):
    def __init__(self):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkMultiBlockDataSet")
        self._file = ""
        self._mesh = None  # of the file, once it is open
        self._said = set()
        self._slice_by = "time"
        self._value = 0.0
        self._normal = (0.0, 0.0, 0.0, 1.0)
        self._light = False
        self._velocity = True
        self._bodies = vtkDataArraySelection()
        self._bodies.AddObserver("ModifiedEvent", lambda *_: self.Modified())

    def _set(self, name, value):
        if getattr(self, name) != value:
            setattr(self, name, value)
            self.Modified()

    def SetFileName(self, path_or_url):
        """Sets the name of a .t4d file; a URL begins with http:// or https://."""
        if path_or_url != self._file:
            self._mesh = None
            self._said.clear()
            self._bodies.RemoveAllArrays()
        self._set("_file", path_or_url)

    def SetSliceBy(self, what):
        """One of SLICED_BY; by nothing, the output is the 4D mesh."""
        if what not in SLICED_BY:
            raise ValueError(f"slice by {what!r}: expected one of {', '.join(SLICED_BY)}")
        self._set("_slice_by", what)

    def SetValue(self, value):
        """Sets the value of x, y or z, or of the hyperplane's equation."""
        self._set("_value", value)

    def SetNormal(self, a, b, c, d):
        """Sets the normal of the hyperplane a x + b y + c z + d t = value."""
        self._set("_normal", (a, b, c, d))

    def SetLight(self, light):
        """Sets whether slices at a time are light."""
        self._set("_light", bool(light))

    def SetVelocity(self, velocity):
        """Sets whether slices at a time have the attribute `velocity`."""
        self._set("_velocity", bool(velocity))

    def GetBodies(self):
        """The vtkDataArraySelection of bodies, by their names."""
        return self._bodies

    def _chosen(self):
        """The bodies that are chosen, of the file, which is opened once."""
        if self._mesh is None:
            if not self._file:
                raise ValueError("no file is set: give the path or URL of a .t4d file")
            self._mesh = read(self._file)
            for name in self._mesh.names:
                self._bodies.AddArray(name)
        return [body for body in self._mesh if self._bodies.ArrayIsEnabled(body.names[0])]

    @reported
    def RequestInformation(self, information):
        # ParaView asks before its user can enter a URL.
        bodies = self._chosen() if self._file else []
        information.Remove(PIPELINE.TIME_STEPS())
        information.Remove(PIPELINE.TIME_RANGE())
        information.Set(vtkAlgorithm.CAN_HANDLE_PIECE_REQUEST(), 1)
        if self._slice_by == "time" and bodies:
            times = np.unique(np.concatenate([body.layer_times for body in bodies]))
            information.Set(PIPELINE.TIME_STEPS(), times.tolist(), len(times))
            information.Set(PIPELINE.TIME_RANGE(), [times[0], times[-1]], 2)

    @reported
    def RequestData(self, information):
        bodies = self._chosen()
        time = self._time(information, bodies)
        # Each process of a server makes some of the blocks.
        piece = information.Get(PIPELINE.UPDATE_PIECE_NUMBER())
        pieces = information.Get(PIPELINE.UPDATE_NUMBER_OF_PIECES())
        blocks = []
        for number, body in enumerate(bodies):
            blocks.append(self._block(body, time) if number % pieces == piece else None)
            self.UpdateProgress((number + 1) / len(bodies))
        output = vtkMultiBlockDataSet.GetData(information)
        output.Initialize()
        for number, (body, block) in enumerate(zip(bodies, blocks)):
            output.SetBlock(number, block)
            output.GetMetaData(number).Set(vtkCompositeDataSet.NAME(), body.names[0])
        units = {"length_unit": self._mesh.length_unit, "time_unit": self._mesh.time_unit}
        add_texts(output.GetFieldData(), units)
        if time is not None:
            output.GetInformation().Set(vtkDataObject.DATA_TIME_STEP(), time)
            self._warn_if_outside(time, bodies, output)

    def _time(self, information, bodies):
        """The requested time, or else the first; None if the output has no time."""
        if self._slice_by != "time" or not bodies:
            return None
        if information.Has(PIPELINE.UPDATE_TIME_STEP()):
            return information.Get(PIPELINE.UPDATE_TIME_STEP())
        return min(body.time_span[0] for body in bodies)

    def _warn_if_outside(self, time, bodies, output):
        begin, end = min(body.time_span[0] for body in bodies), max(body.time_span[1] for body in bodies)
        if not begin <= time <= end and output.GetNumberOfPoints() == 0:
            warnings.warn(f"{self._file}: nothing to show before time {begin} and after {end}")

    def _block(self, body, time):
        if self._slice_by == "time":
            return solid_at(body, time, light=self._light, velocity=self._velocity)
        if self._slice_by == "nothing":
            return grid_of(body)
        if self._slice_by == "hyperplane":
            return surface_of(body.slice(hyperplane=(*self._normal, self._value)))
        return surface_of(body.slice(**{self._slice_by: self._value}))


# The readers, as ParaView shows them


def visible_for(ways):
    """The hint of a property that has an effect in these ways of slicing alone."""
    return (
        '<Hints><PropertyWidgetDecorator type="GenericDecorator" mode="visibility" property="SliceBy" '
        f'values="{ways}"/></Hints>'
    )


PROPERTIES = f"""
  <StringVectorProperty name="SliceBy" command="SetSliceBy" number_of_elements="1" default_values="time">
    <StringListDomain name="list">{"".join(f'<String value="{way}"/>' for way in SLICED_BY)}</StringListDomain>
    <Documentation>time: the solid at the time of the animation. x, y, z: what passes through a plane, over
    time. hyperplane: all points of one. nothing: the 4D mesh, tetrahedra with t as point data.</Documentation>
  </StringVectorProperty>
  <IntVectorProperty name="Light" command="SetLight" number_of_elements="1" default_values="0">
    <BooleanDomain name="bool"/>
    <Documentation>At a time: the triangles of the layers, with vertices interpolated, instead of the exact
    slice, which has 13 times as many of a swept solid.</Documentation>
    {visible_for("time")}
  </IntVectorProperty>
  <IntVectorProperty name="Velocity" command="SetVelocity" number_of_elements="1" default_values="1">
    <BooleanDomain name="bool"/>
    <Documentation>At a time: point data `velocity`, in length units for each time unit.</Documentation>
    {visible_for("time")}
  </IntVectorProperty>
  <DoubleVectorProperty name="Value" command="SetValue" number_of_elements="1" default_values="0">
    <Documentation>Of x, y or z; or v of the hyperplane a x + b y + c z + d t = v.</Documentation>
    {visible_for("x y z hyperplane")}
  </DoubleVectorProperty>
  <DoubleVectorProperty name="Normal" command="SetNormal" number_of_elements="4" default_values="0 0 0 1">
    <Documentation>(a, b, c, d) of the hyperplane a x + b y + c z + d t = v.</Documentation>
    {visible_for("hyperplane")}
  </DoubleVectorProperty>
  <StringVectorProperty name="BodiesInfo" command="GetBodies" number_of_elements_per_command="2"
    information_only="1" si_class="vtkSIDataArraySelectionProperty"/>
  <StringVectorProperty name="Bodies" command="GetBodies" information_property="BodiesInfo"
    number_of_elements_per_command="2" element_types="2 0" repeat_command="1"
    si_class="vtkSIDataArraySelectionProperty">
    <ArraySelectionDomain name="array_list">
      <RequiredProperties><Property function="ArrayList" name="BodiesInfo"/></RequiredProperties>
    </ArraySelectionDomain>
    <Documentation>The bodies to show.</Documentation>
  </StringVectorProperty>
  <DoubleVectorProperty name="TimestepValues" information_only="1" repeatable="1">
    <TimeStepsInformationHelper/>
  </DoubleVectorProperty>
"""
FILE = """
  <StringVectorProperty name="FileName" command="SetFileName" number_of_elements="1" animateable="0">
    <FileListDomain name="files"/>
    <Hints><FileChooser extensions="t4d" file_description="4D meshes (t4d)"/></Hints>
    <Documentation>A .t4d file, or its URL.</Documentation>
  </StringVectorProperty>
"""
URL = """
  <StringVectorProperty name="URL" label="URL" command="SetFileName" number_of_elements="1" animateable="0">
    <Documentation>Of a .t4d file, such as https://host/bolt.t4d: only the parts that are needed are read.</Documentation>
  </StringVectorProperty>
"""


# ParaView's Python has them by their labels, without the spaces.


@smproxy.reader(label="T4d Reader", extensions="t4d", file_description="4D meshes (t4d)", support_reload=False)
@smproperty.xml(FILE + PROPERTIES)
class T4dReader(Reader):
    """Reads a .t4d file."""


@smproxy.source(label="T4d URL Reader", support_reload=False)
@smproperty.xml(URL + PROPERTIES)
class T4dURLReader(Reader):
    """Reads a .t4d file on a web server; of use where file names are chosen in a dialog."""

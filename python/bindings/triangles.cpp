#include "python/bindings/triangles.h"

#include "python/bindings/gil.h"
#include "t4d/surface.h"

namespace t4d::python {
namespace {

std::shared_ptr<model::TriangleMesh> make(const py::array& vertices, const py::array& triangles,
                                          const py::dict& ofVertices, const py::dict& ofTriangles) {
  auto mesh = std::make_shared<model::TriangleMesh>();
  mesh->vertices = pointsOf(vertices, "vertices");
  mesh->triangles = trianglesOf(triangles, mesh->vertices.size());
  const auto add = [&](const py::dict& given, model::Domain domain, std::size_t rows) {
    for (const auto& [name, values] : given) {
      mesh->attributes.push_back(
          attributeOf(name.cast<std::string>(), domain, py::array::ensure(values), rows));
    }
  };
  add(ofVertices, model::Domain::Vertex, mesh->vertices.size());
  add(ofTriangles, model::Domain::Cell, mesh->triangles.size());
  return mesh;
}

}  // namespace

void defineTriangles(py::module_& module) {
  using model::TriangleMesh;
  py::class_<TriangleMesh, std::shared_ptr<TriangleMesh>>(module, "TriangleMesh")
      .def(py::init(&make))
      .def(py::pickle(
          [](const py::object& self) {
            return py::make_tuple(self.attr("vertices"), self.attr("triangles"),
                                  self.attr("vertex_attributes"), self.attr("triangle_attributes"));
          },
          [](const py::tuple& state) {
            return make(state[0].cast<py::array>(), state[1].cast<py::array>(),
                        state[2].cast<py::dict>(), state[3].cast<py::dict>());
          }))
      .def_property_readonly(
          "vertices",
          [](const py::object& self) { return viewOf(self.cast<TriangleMesh&>().vertices, self); })
      .def_property_readonly(
          "triangles",
          [](const py::object& self) { return viewOf(self.cast<TriangleMesh&>().triangles, self); })
      .def_property_readonly("vertex_attributes",
                             [](const py::object& self) {
                               return viewsOf(self.cast<TriangleMesh&>().attributes,
                                              model::Domain::Vertex, self);
                             })
      .def_property_readonly("triangle_attributes",
                             [](const py::object& self) {
                               return viewsOf(self.cast<TriangleMesh&>().attributes,
                                              model::Domain::Cell, self);
                             })
      .def_property_readonly("volume", &model::signedVolume)
      .def_property_readonly("area", &model::surfaceArea)
      .def_property_readonly("closed", &model::isClosed);

  module.def("read_triangles", [](const std::string& path) {
    auto loaded = [&] {
      const Unlocked unlocked;
      return formats::readTriangleMesh(path);
    }();
    auto value = valueOf(std::move(loaded));
    return py::make_tuple(std::make_shared<TriangleMesh>(std::move(value.mesh)), value.notices,
                          value.losses);
  });
  module.def("write_triangles", [](const TriangleMesh& mesh, const std::string& path,
                                   const std::string& name, bool attributes) {
    const formats::NamedMesh named{name, mesh};
    auto written = [&] {
      const Unlocked unlocked;
      return formats::writeTriangleMeshes(path, {&named, 1}, {.attributes = attributes});
    }();
    return valueOf(std::move(written));
  });
}

}  // namespace t4d::python

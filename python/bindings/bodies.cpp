#include "python/bindings/bodies.h"

#include <cmath>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "model/parallel.h"
#include "model/slab_groups.h"
#include "python/bindings/arrays.h"
#include "slice/velocity.h"
#include "t4d/check.h"
#include "t4d/file.h"
#include "t4d/mesh.h"
#include "t4d/slice.h"

namespace t4d::python {

const slice::TimeSlicer& Body::slicer(slice::WithMotion withMotion) const {
  const std::lock_guard lock(mutex_);
  auto& slicer = slicers_[static_cast<std::size_t>(withMotion)];
  if (!slicer) slicer = std::make_unique<slice::TimeSlicer>(*source, withMotion);
  return *slicer;
}

const slice::LightSlicer& Body::lightSlicer(slice::WithMotion withMotion) const {
  const std::lock_guard lock(mutex_);
  auto& slicer = lightSlicers_[static_cast<std::size_t>(withMotion)];
  if (!slicer) slicer = std::make_unique<slice::LightSlicer>(*source, withMotion);
  return *slicer;
}

namespace {

std::vector<std::shared_ptr<Body>> read(const std::string& path, bool whole,
                                        const py::object& maxCells, py::object callback) {
  Watch watch(std::move(callback));
  std::optional<std::uint64_t> most;
  if (!maxCells.is_none()) most = maxCells.cast<std::uint64_t>();
  auto opened = watch.run([&](const model::Progress& progress) {
    return formats::T4dReader::open(
        path, whole ? formats::T4dOpen::Checked : formats::T4dOpen::Whole, progress, most);
  });
  const auto reader = std::make_shared<const formats::T4dReader>(std::move(opened));
  for (std::size_t i = 0; whole && i < reader->bodyCount(); ++i) {
    model::NullSink nothing;
    watch.run(
        [&](const model::Progress& progress) { return reader->readThrough(i, nothing, progress); });
  }
  const formats::Metadata& metadata = reader->metadata();
  std::vector<std::shared_ptr<Body>> bodies;
  for (std::size_t i = 0; i < reader->bodyCount(); ++i) {
    auto body = std::make_shared<Body>();
    body->source = {reader, &reader->body(i)};
    body->info = metadata.bodies[i];
    body->lengthUnit = metadata.lengthUnit;
    body->timeUnit = metadata.timeUnit;
    body->up = metadata.up;
    body->backend = metadata.backend;
    body->detailsJson = metadata.detailsJson;
    body->version = fmt::format("{}.{}", reader->version().major, reader->version().minor);
    body->features = metadata.features;
    body->file = reader;
    bodies.push_back(std::move(body));
  }
  return bodies;
}

/// The most speed that vertices may have; without it, no velocity is asked for.
using MaxSpeed = std::optional<double>;

slice::WithMotion motionFor(const MaxSpeed& maxSpeed) {
  return maxSpeed ? slice::WithMotion::Yes : slice::WithMotion::No;
}

/// The mesh of a slice, with its velocities if they are asked for.
Result<std::shared_ptr<model::TriangleMesh>> meshOf(slice::Slice slice, const MaxSpeed& maxSpeed) {
  if (maxSpeed) {
    if (auto added = addVelocity(slice, {.most = *maxSpeed}); !added) {
      return added.error();
    }
  }
  return std::make_shared<model::TriangleMesh>(std::move(slice.mesh));
}

std::shared_ptr<model::TriangleMesh> sliceOf(const Body& body,
                                             const std::array<double, 5>& hyperplane,
                                             const MaxSpeed& maxSpeed) {
  slice::Hyperplane plane;
  for (int i = 0; i < 4; ++i) plane.normal[i] = hyperplane[static_cast<std::size_t>(i)];
  plane.offset = hyperplane[4];
  auto made = [&]() -> Result<std::shared_ptr<model::TriangleMesh>> {
    const Unlocked unlocked;
    auto slice = plane.normal.isApprox(Eigen::Vector4d::UnitW(), 0)
                     ? body.slicer(motionFor(maxSpeed)).at(plane.offset)
                     : slice::slice(*body.source, plane);
    if (!slice) return slice.error();
    return meshOf(std::move(*slice), maxSpeed);
  }();
  return valueOf(std::move(made));
}

py::tuple flat(const Body& body, py::object callback) {
  Watch watch(std::move(callback));
  auto made = std::make_unique<model::FlatMesh>(watch.run(
      [&](const model::Progress& progress) { return model::flatten(*body.source, progress); }));
  const py::capsule owner(made.get(),
                          [](void* mesh) { delete static_cast<model::FlatMesh*>(mesh); });
  const model::FlatMesh& mesh = *made.release();
  return py::make_tuple(
      view(mesh.vertices.data(), static_cast<std::size_t>(mesh.vertices.rows()), 4, owner),
      view(mesh.cells.data(), static_cast<std::size_t>(mesh.cells.rows()), 4, owner));
}

std::vector<std::shared_ptr<model::TriangleMesh>> slices(const Body& body,
                                                         const std::vector<double>& times,
                                                         py::object callback,
                                                         const MaxSpeed& maxSpeed) {
  using Meshes = std::vector<std::shared_ptr<model::TriangleMesh>>;
  Watch watch(std::move(callback));
  return watch.run([&](const model::Progress& progress) -> Result<Meshes> {
    Meshes meshes;
    for (auto& slice : slice::sliceAtTimes(*body.source, times, progress, motionFor(maxSpeed))) {
      if (!slice) return slice.error();
      auto mesh = meshOf(std::move(*slice), maxSpeed);
      if (!mesh) return mesh.error();
      meshes.push_back(std::move(*mesh));
    }
    return meshes;
  });
}

/// The meshes, and why they are exact slices where they are.
std::vector<std::pair<std::shared_ptr<model::TriangleMesh>, std::string>> lightSlices(
    const Body& body, const std::vector<double>& times, py::object callback,
    const MaxSpeed& maxSpeed) {
  Watch watch(std::move(callback));
  using Made = std::shared_ptr<Result<slice::LightSlice>>;
  std::vector<std::pair<std::shared_ptr<model::TriangleMesh>, std::string>> slices;
  watch.run([&](const model::Progress& progress) {
    Result<void> done;
    const auto make = [&](std::size_t i) {
      return std::make_shared<Result<slice::LightSlice>>(
          body.lightSlicer(motionFor(maxSpeed)).at(times[i]));
    };
    model::inOrder<Made>(times.size(), make, [&](const Made& made) {
      if (!*made) {
        done = made->error();
        return false;
      }
      auto mesh = meshOf(std::move((**made).slice), maxSpeed);
      if (!mesh) {
        done = mesh.error();
        return false;
      }
      slices.emplace_back(std::move(*mesh), (**made).whyExact);
      done = model::report(progress, slices.size(), times.size());
      return done.has_value();
    });
    return done;
  });
  return slices;
}

py::dict measure(const Body& body, const std::vector<double>& times, py::object callback) {
  Watch watch(std::move(callback));
  const model::Body one{body.info.name, body.source.get()};
  const auto found = watch.run([&](const model::Progress& progress) {
    return measure::measuresAt({&one, 1}, times, progress);
  });
  const auto rows = static_cast<py::ssize_t>(found.size());
  const auto numbers = [&](auto of) {
    using Number = decltype(of(found.front()));
    py::array_t<Number> array({rows}, {static_cast<py::ssize_t>(sizeof(Number))});
    for (py::ssize_t i = 0; i < rows; ++i) {
      array.mutable_at(i) = of(found[static_cast<std::size_t>(i)]);
    }
    return array;
  };
  const auto points = [&](auto of) {
    constexpr py::ssize_t kWidth = sizeof(double);
    py::array_t<double> array({rows, py::ssize_t{3}}, {3 * kWidth, kWidth});
    for (py::ssize_t i = 0; i < rows; ++i) {
      const measure::SolidMeasures& one = found[static_cast<std::size_t>(i)];
      for (py::ssize_t k = 0; k < 3; ++k) {
        array.mutable_at(i, k) = one.bounds.empty() ? std::nan("") : of(one)[k];
      }
    }
    return array;
  };
  // Signed, so that differences of counts may be negative.
  const auto count = [](std::uint64_t number) { return static_cast<std::int64_t>(number); };
  using Of = const measure::SolidMeasures&;
  return py::dict(py::arg("time") = numbers([](Of one) { return one.time; }),
                  py::arg("volume") = numbers([](Of one) { return one.volume; }),
                  py::arg("area") = numbers([](Of one) { return one.area; }),
                  py::arg("centroid") = points([](Of one) { return one.centroid; }),
                  py::arg("components") = numbers([=](Of one) { return count(one.components); }),
                  py::arg("cavities") = numbers([=](Of one) { return count(one.cavities); }),
                  py::arg("genus") = numbers([](Of one) { return one.genus; }),
                  py::arg("min") = points([](Of one) { return one.bounds.min; }),
                  py::arg("max") = points([](Of one) { return one.bounds.max; }));
}

py::dict check(const Body& body, bool deep, py::object callback) {
  Watch watch(std::move(callback));
  measure::MeshChecker checker({.vertexLinks = deep});
  watch.run([&](const model::Progress& progress) {
    return model::pump(*body.source, checker, progress);
  });
  const measure::MeshReport report = checker.finish();
  py::list issues;
  for (const measure::Issue& issue : report.issues.issues) {
    issues.append(py::dict(py::arg("code") = issue.code, py::arg("message") = issue.message,
                           py::arg("slab") = issue.slab,
                           py::arg("error") = issue.severity == measure::Severity::Error));
  }
  // What is open, or not oriented, encloses nothing.
  py::object hypervolume = py::none();
  if (report.closed && report.oriented) hypervolume = py::float_(report.hypervolume);
  return py::dict(py::arg("valid") = report.valid(), py::arg("closed") = report.closed,
                  py::arg("oriented") = report.oriented, py::arg("slabs") = report.slabs,
                  py::arg("vertices") = report.vertices, py::arg("tetrahedra") = report.tetrahedra,
                  py::arg("components") = report.components, py::arg("hypervolume") = hypervolume,
                  py::arg("boundary_volume") = report.boundaryVolume,
                  py::arg("vertex_links_ok") = report.vertexLinksOk, py::arg("issues") = issues);
}

}  // namespace

void defineBodies(py::module_& module) {
  using model::Slab;
  py::class_<Slab, std::shared_ptr<Slab>>(module, "Slab")
      .def_readonly("time_begin", &Slab::timeBegin)
      .def_readonly("time_end", &Slab::timeEnd)
      .def_property_readonly(
          "vertices",
          [](const py::object& self) { return viewOf(self.cast<Slab&>().vertices, self); })
      .def_property_readonly("cells",
                             [](const py::object& self) {
                               return viewOf(self.cast<Slab&>().connectivity->cells, self);
                             })
      .def_property_readonly("lower_count",
                             [](const Slab& slab) { return slab.connectivity->lowerCount; })
      .def_property_readonly("upper_count",
                             [](const Slab& slab) { return slab.connectivity->upperCount; })
      .def_property_readonly("mean_count",
                             [](const Slab& slab) { return slab.connectivity->means.size(); })
      .def_property_readonly("vertex_attributes",
                             [](const py::object& self) {
                               return viewsOf(self.cast<Slab&>().attributes, model::Domain::Vertex,
                                              self);
                             })
      .def_property_readonly(
          "cell_attributes",
          [](const py::object& self) {
            const Slab& slab = self.cast<Slab&>();
            py::dict views = viewsOf(slab.connectivity->cellAttributes, model::Domain::Cell, self);
            views.attr("update")(viewsOf(slab.attributes, model::Domain::Cell, self));
            return views;
          })
      .def_property_readonly("attributes", [](const py::object& self) {
        const Slab& slab = self.cast<Slab&>();
        py::list all;
        for (const auto* attributes : {&slab.connectivity->cellAttributes, &slab.attributes}) {
          for (const model::Attribute& attribute : *attributes) {
            all.append(py::make_tuple(attribute.domain == model::Domain::Vertex ? "vertex" : "cell",
                                      attribute.name, viewOf(attribute, self)));
          }
        }
        return all;
      });

  py::class_<Body, std::shared_ptr<Body>>(module, "Body")
      .def_property_readonly("name", [](const Body& body) { return body.info.name; })
      .def_property_readonly("parent", [](const Body& body) { return body.info.parent; })
      .def_readonly("length_unit", &Body::lengthUnit)
      .def_readonly("time_unit", &Body::timeUnit)
      .def_readonly("up", &Body::up)
      .def_readonly("backend", &Body::backend)
      .def_readonly("details", &Body::detailsJson)
      .def_readonly("version", &Body::version)
      .def_readonly("features", &Body::features)
      .def_property_readonly(
          "space",
          [](const Body& body) { return body.file ? body.file->metadata().space : std::string(); })
      .def_property_readonly(
          "attribute_kinds",
          [](const Body& body) {
            py::dict kinds;
            if (!body.file) return kinds;
            for (const auto& [name, meaning] : body.file->metadata().attributes) {
              kinds[py::str(name)] =
                  py::make_tuple(meaning.kind.empty() ? "scalar" : meaning.kind, meaning.unit);
            }
            return kinds;
          })
      .def_property_readonly("slab_count",
                             [](const Body& body) { return body.source->slabCount(); })
      .def_property_readonly("time_span",
                             [](const Body& body) {
                               const model::TimeSpan span = model::timeSpanOf(*body.source);
                               return py::make_tuple(span.begin, span.end);
                             })
      .def("slab_span",
           [](const Body& body, std::size_t index) {
             const model::TimeSpan span = body.source->timeSpan(index);
             // This is the time of the whole part if the part cannot be read.
             if (!model::slabGroupsOf(*body.source).empty() && !body.source->cellCount(index)) {
               valueOf(body.source->slab(index));
             }
             return py::make_tuple(span.begin, span.end);
           })
      .def(
          "slab",
          [](const Body& body, std::size_t index) {
            auto read = [&] {
              const Unlocked unlocked;
              return body.source->slab(index);
            }();
            // Python sees it through read-only arrays alone.
            return std::const_pointer_cast<Slab>(valueOf(std::move(read)));
          },
          py::keep_alive<0, 1>())
      .def("slice", &sliceOf)
      .def("slices", &slices)
      .def("light_slices", &lightSlices)
      .def("measure", &measure)
      .def("flat", &flat)
      .def("check", &check);

  module.def("read", &read);
}

}  // namespace t4d::python

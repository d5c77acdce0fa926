#include "python/bindings/producers.h"

#include <algorithm>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "python/bindings/arrays.h"
#include "python/bindings/frame_iterator.h"
#include "t4d/file.h"
#include "t4d/sweep.h"
#include "t4d/weave.h"

namespace t4d::python {
namespace {

using model::TriangleMesh;

mesh4d::SweepOptions sweepOptions(const py::kwargs& options) {
  mesh4d::SweepOptions how;
  if (options.contains("steps")) {
    how.steps = mesh4d::StepsPerSegment{options["steps"].cast<std::uint64_t>()};
  } else if (options.contains("max_deviation")) {
    how.steps = mesh4d::MaxDeviation{options["max_deviation"].cast<double>()};
  } else if (options.contains("rv_min")) {
    how.steps = mesh4d::MinVolumeRatio{options["rv_min"].cast<double>()};
  }
  if (options.contains("caps") && options["caps"].cast<std::string>() == "cone") {
    how.caps = mesh4d::CapMethod::Cone;
  }
  if (options.contains("prism") && options["prism"].cast<int>() == 3) {
    how.prism = mesh4d::PrismSplit::Three;
  }
  return how;
}

std::shared_ptr<Producer> sweepMotion(const std::shared_ptr<TriangleMesh>& mesh,
                                      const model::Motion& motion, const py::kwargs& options) {
  auto producer = std::make_shared<Producer>();
  producer->run = [mesh, motion, how = sweepOptions(options)](
                      model::Sink& sink, const model::Progress& progress) -> Result<void> {
    auto done = mesh4d::sweep(*mesh, motion, how, sink, progress);
    return done ? Result<void>() : done.error();
  };
  return producer;
}

std::shared_ptr<Producer> sweepKeys(const std::shared_ptr<TriangleMesh>& mesh,
                                    const std::vector<double>& times, const py::list& positions,
                                    const py::kwargs& options) {
  std::vector<model::StoredKeys::Key> keys;
  for (std::size_t i = 0; i < times.size(); ++i) {
    keys.push_back(
        {times[i], pointsOf(py::array::ensure(positions[i]), fmt::format("vertices[{}]", i))});
    if (keys.back().positions.size() != mesh->vertices.size()) {
      throw py::value_error("every key has as many vertices as the first");
    }
  }
  auto stored = std::make_shared<const model::StoredKeys>(std::move(keys));
  auto producer = std::make_shared<Producer>();
  producer->run = [mesh, stored, how = sweepOptions(options)](
                      model::Sink& sink, const model::Progress& progress) -> Result<void> {
    auto done = mesh4d::sweep(*mesh, *stored, how, sink, progress);
    return done ? Result<void>() : done.error();
  };
  return producer;
}

voxel4d::CapStyle capStyleOf(const std::string& name) {
  if (name == "flat") return voxel4d::CapStyle::Flat;
  if (name == "half-step") return voxel4d::CapStyle::HalfStep;
  if (name == "graded") return voxel4d::CapStyle::Graded;
  throw py::value_error("caps are 'flat', 'graded' or 'half-step'");
}

/// `again` makes a new iterator over the frames for each run. `place` maps lattice points to space,
/// row after row; voxels that are no cubes along the axes are woven as cubes of edge 1, and the
/// mesh is mapped.
std::shared_ptr<Producer> weaveFrames(const py::function& again, const std::vector<double>& times,
                                      const std::array<double, 12>& place,
                                      std::optional<double> iso, bool below,
                                      std::optional<std::int64_t> label,
                                      std::optional<double> outside, const std::string& caps,
                                      const std::string& between, bool once, bool stay) {
  voxel4d::Lattice lattice;
  voxel4d::WeaveOptions how;
  how.caps = capStyleOf(caps);
  how.between = between == "midpoint" ? voxel4d::Between::Midpoint : voxel4d::Between::Distance;
  const model::Affine3x4 toSpace =
      Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(place.data());
  const double edge = toSpace(0, 0);
  if (edge > 0 && toSpace.leftCols<3>() == edge * Eigen::Matrix3d::Identity()) {
    lattice = {edge, toSpace.col(3)};
  } else {
    how.toSpace = toSpace;
  }
  auto producer = std::make_shared<Producer>();
  producer->once = once;
  producer->run = [=, raised = &producer->raised](model::Sink& sink,
                                                  const model::Progress& progress) -> Result<void> {
    std::optional<FrameIterator> frames;
    {
      const Locked locked;
      frames.emplace(inPython([&] { return py::iter(again()); }), times, lattice,
                     voxel4d::ArrayInside{iso, below, label, outside}, stay);
    }
    auto done = voxel4d::weave(*frames, how, sink, progress);
    if (frames->raised) *raised = std::exchange(frames->raised, std::nullopt);
    return done ? Result<void>() : done.error();
  };
  return producer;
}

/// Calls `work`; an exception that Python code raised in it takes the place of what came of it.
template <class Work>
auto rethrowing(Producer& producer, Work work) {
  try {
    return work();
  } catch (const py::error_already_set&) {
    if (producer.raised) throw *std::exchange(producer.raised, std::nullopt);
    throw;
  }
}

void use(Producer& producer) {
  if (producer.once && producer.used) {
    throw py::value_error(
        "the frames come from an iterator and have been used: keep the mesh with .load()");
  }
  producer.used = true;
}

formats::Metadata metadataOf(const py::dict& given, std::vector<formats::BodyInfo> bodies) {
  formats::Metadata metadata;
  metadata.generator = given["generator"].cast<std::string>();
  metadata.backend = given["backend"].cast<std::string>();
  metadata.lengthUnit = given["length_unit"].cast<std::string>();
  metadata.timeUnit = given["time_unit"].cast<std::string>();
  metadata.up = given["up"].cast<std::string>();
  metadata.detailsJson = given["details"].cast<std::string>();
  metadata.space = given["space"].cast<std::string>();
  metadata.bodies = std::move(bodies);
  return metadata;
}

formats::T4dWriteOptions writeOptions(const py::dict& given) {
  formats::T4dWriteOptions how;
  how.compression = given["compression"].cast<int>();
  how.float32 = given["float32"].cast<bool>();
  how.index = given["index"].cast<bool>();
  if (!given["grid"].is_none()) how.step = given["grid"].cast<double>();
  return how;
}

/// Writes bodies from `put(i, sink, progress)`; of the file that they are from, if there is one,
/// also the chunks that this version does not know.
template <class Put>
py::tuple save(const std::string& path, const formats::Metadata& metadata, const py::dict& options,
               py::object callback, const formats::T4dReader* file, Put put) {
  Watch watch(std::move(callback));
  const auto how = writeOptions(options);
  using Written = std::pair<std::uint64_t, std::vector<std::string>>;
  const auto written = watch.run([&](const model::Progress& progress) -> Result<Written> {
    auto writer = formats::T4dWriter::create(path, metadata, how);
    if (!writer) return writer.error();
    for (std::size_t i = 0; i < metadata.bodies.size(); ++i) {
      if (auto done = put(i, writer->body(i), progress); !done) return done.error();
    }
    if (file != nullptr) {
      if (auto kept = writer->keep(file->optionalChunks()); !kept) return kept.error();
    }
    const auto bytes = writer->finish();
    if (!bytes) return bytes.error();
    return Written{*bytes, writer->losses()};
  });
  return py::make_tuple(written.first, written.second);
}

py::tuple saveBodies(const std::vector<std::shared_ptr<Body>>& bodies, const std::string& path,
                     const py::dict& metadata, const py::dict& options,
                     const py::object& callback) {
  std::vector<formats::BodyInfo> infos;
  infos.reserve(bodies.size());
  for (const auto& body : bodies) {
    infos.push_back(body->info);
    // A body that is saved without its parent has none.
    if (std::ranges::none_of(
            bodies, [&](const auto& other) { return other->info.name == body->info.parent; })) {
      infos.back().parent.clear();
    }
  }
  formats::Metadata head = metadataOf(metadata, std::move(infos));
  const formats::T4dReader* const file = bodies.front()->file.get();
  if (file != nullptr) {
    head.attributes = file->metadata().attributes;
    head.otherJson = file->metadata().otherJson;
  }
  return save(path, head, options, callback, file,
              [&](std::size_t i, model::Sink& sink, const model::Progress& progress) {
                return model::pump(*bodies[i]->source, sink, progress);
              });
}

py::tuple saveProduced(Producer& producer, const std::string& name, const std::string& path,
                       const py::dict& metadata, const py::dict& options,
                       const py::object& callback) {
  use(producer);
  return rethrowing(producer, [&] {
    return save(path, metadataOf(metadata, {{name}}), options, callback, nullptr,
                [&](std::size_t, model::Sink& sink, const model::Progress& progress) {
                  return producer.run(sink, progress);
                });
  });
}

std::shared_ptr<Body> load(Producer& producer, const std::string& name, py::object callback) {
  use(producer);
  Watch watch(std::move(callback));
  auto mesh = std::make_shared<model::Mesh>();
  rethrowing(producer, [&] {
    watch.run([&](const model::Progress& progress) { return producer.run(*mesh, progress); });
  });
  auto body = std::make_shared<Body>();
  body->source = std::move(mesh);
  body->info.name = name;
  return body;
}

/// Calls `put` with each slab. Call `use` first.
void each(Producer& producer, py::object put) {
  Watch watch(std::move(put));
  Watch::Caller caller(watch);
  rethrowing(producer,
             [&] { watch.run([&](const model::Progress&) { return producer.run(caller, {}); }); });
}

}  // namespace

void defineProducers(py::module_& module) {
  py::class_<Producer, std::shared_ptr<Producer>>(module, "Producer")
      .def("load", &load)
      .def("save", &saveProduced)
      .def("use", &use)
      .def("each", &each);
  module.def("sweep_motion", &sweepMotion);
  module.def("sweep_keys", &sweepKeys);
  module.def("weave_frames", &weaveFrames);
  module.def("save_bodies", &saveBodies);
}

}  // namespace t4d::python

#include "conformance/corpus/cases.h"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "formats/t4d/chunks.h"
#include "formats/t4d/layout.h"

namespace t4d::conformance {
namespace {

using model::Slab;

/// `bodies` as a reader returns them: positions rounded, means computed from the rounded values.
std::vector<BodySlabs> stored(std::vector<BodySlabs> bodies, const ImageOptions& options) {
  if (!options.positions().round()) return bodies;
  for (BodySlabs& body : bodies) {
    for (Slab& slab : body.slabs) slab = formats::roundedSlab(slab, options.positions());
  }
  return bodies;
}

template <class Predicate>
bool anySlab(const std::vector<BodySlabs>& bodies, Predicate predicate) {
  return std::any_of(bodies.begin(), bodies.end(), [&](const BodySlabs& body) {
    return std::any_of(body.slabs.begin(), body.slabs.end(), predicate);
  });
}

/// The features that a file uses, as keywords for filters.
std::vector<std::string> usedBy(const std::vector<BodySlabs>& bodies, const ImageOptions& options) {
  std::vector<std::string> used = neededFeatures(bodies, options);
  const auto note = [&](const char* word, bool is) {
    if (is) used.emplace_back(word);
  };
  note(options.index ? "index" : "no-index", true);
  note("float32", options.float32);
  note("later-minor", options.minorVersion > formats::t4d_layout::kMinorVersion);
  note("many-bodies", bodies.size() > 1);
  note("many-slabs", std::any_of(bodies.begin(), bodies.end(),
                                 [](const BodySlabs& body) { return body.slabs.size() > 1; }));
  note("layers", anySlab(bodies, [](const Slab& slab) {
         return slab.connectivity->lowerCount + slab.connectivity->upperCount > 0;
       }));
  note("flat-slabs",
       anySlab(bodies, [](const Slab& slab) { return slab.timeBegin == slab.timeEnd; }));
  note("attributes", anySlab(bodies, [](const Slab& slab) {
         return !slab.attributes.empty() || !slab.connectivity->cellAttributes.empty();
       }));
  bool shared = false;
  for (const BodySlabs& body : bodies) {
    for (std::size_t i = 1; i < body.slabs.size(); ++i) {
      shared = shared || body.slabs[i].connectivity == body.slabs[i - 1].connectivity;
    }
  }
  note("shared-connectivity", shared);
  return used;
}

/// Hyperplanes to slice the bodies by: across x, y and z, between vertices and at one; askew,
/// likewise. None for bodies with so many cells that a slow reader would take long, and for numbers
/// so large or so small that the products in n.p leave few digits.
std::vector<slice::Hyperplane> sectionsOf(const std::vector<BodySlabs>& bodies) {
  constexpr std::size_t kMostCells = 2000;
  model::Bounds4 bounds;
  std::size_t cells = 0;
  std::optional<model::Point4> inner;
  for (const BodySlabs& body : bodies) {
    for (const Slab& slab : body.slabs) {
      cells += slab.connectivity->cells.size();
      for (const model::Point4& vertex : slab.vertices) bounds.add(vertex);
      if (!slab.vertices.empty()) inner = slab.vertices[slab.vertices.size() / 2];
    }
  }
  if (bounds.empty() || cells == 0 || cells > kMostCells) return {};
  const Eigen::Vector4d extent = bounds.max - bounds.min;
  const double reach = bounds.max.cwiseAbs().cwiseMax(bounds.min.cwiseAbs()).maxCoeff();
  if (!(reach < 1e3) || !(extent.minCoeff() > 1e-3)) return {};
  const model::Point4 between = bounds.min + 0.375 * extent;
  std::vector<slice::Hyperplane> hyperplanes;
  for (int axis = 0; axis < 3; ++axis) {
    hyperplanes.push_back(slice::Hyperplane::across(axis, between[axis]));
    hyperplanes.push_back(slice::Hyperplane::across(axis, (*inner)[axis]));
  }
  for (const Eigen::Vector4d& normal :
       {Eigen::Vector4d(1, 0.5, -0.75, 0.25), Eigen::Vector4d(-0.1, 0.3, 0.7, -1.1)}) {
    hyperplanes.push_back({normal, slice::along(normal, between)});
    hyperplanes.push_back({normal, slice::along(normal, *inner)});
  }
  return hyperplanes;
}

}  // namespace

std::vector<std::string> neededFeatures(const std::vector<BodySlabs>& bodies,
                                        const ImageOptions& options) {
  std::vector<std::string> features;
  if (anySlab(bodies, [](const Slab& slab) { return slab.connectivity->means.size() > 0; })) {
    features.emplace_back(formats::t4d_layout::kFeatureMeans);
  }
  if (options.storage != Storage::Raw) {
    features.emplace_back(formats::t4d_layout::kFeatureZstd);
  }
  if (anySlab(bodies, [](const Slab& slab) { return slab.upperPose != nullptr; })) {
    features.emplace_back(formats::t4d_layout::kFeaturePose);
  }
  if (options.grid) features.emplace_back(formats::t4d_layout::kFeatureGrid);
  return features;
}

AcceptedBuilder::AcceptedBuilder(const std::string& id, Validity validity,
                                 const std::string& what) {
  case_.file.id = id;
  case_.file.validity = validity;
  case_.file.fault = what;
}

AcceptedBuilder& AcceptedBuilder::of(const std::vector<BodySlabs>& bodies,
                                     const ImageOptions& options,
                                     const std::optional<std::string>& head) {
  return of(Image::of(bodies, options, head), bodies, options);
}

AcceptedBuilder& AcceptedBuilder::of(const Image& image, const std::vector<BodySlabs>& bodies,
                                     const ImageOptions& options) {
  case_.file.bytes = image.bytes();
  case_.bodies = stored(bodies, options);
  options_ = options;
  named_ = neededFeatures(bodies, options);
  return *this;
}

AcceptedBuilder& AcceptedBuilder::naming(const std::vector<std::string>& features) {
  named_ = features;
  return *this;
}

AcceptedBuilder& AcceptedBuilder::shows(const std::vector<std::string>& features) {
  shown_ = features;
  return *this;
}

AcceptedBuilder& AcceptedBuilder::slicedAt(const std::vector<double>& times) {
  times_ = times;
  return *this;
}

AcceptedBuilder& AcceptedBuilder::slicedBy(const std::vector<slice::Hyperplane>& hyperplanes) {
  hyperplanes_ = hyperplanes;
  return *this;
}

AcceptedBuilder& AcceptedBuilder::encloses(double hypervolume,
                                           std::function<double(double)> sliceVolume) {
  case_.hypervolume = hypervolume;
  case_.sliceVolume = std::move(sliceVolume);
  return *this;
}

AcceptedBuilder& AcceptedBuilder::leftOpenIn(const std::string& heading) {
  case_.file.rule = heading;
  return *this;
}

AcceptedBuilder& AcceptedBuilder::at(std::uint64_t offset) {
  case_.file.offset = offset;
  return *this;
}

AcceptedCase AcceptedBuilder::finish() const {
  AcceptedCase made = case_;
  made.file.features = usedBy(made.bodies, options_);
  for (const std::string& feature : shown_) {
    auto& all = made.file.features;
    if (std::find(all.begin(), all.end(), feature) == all.end()) all.push_back(feature);
  }
  std::vector<model::Mesh> meshes(made.bodies.size());
  std::vector<NamedSource> sources;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    for (const Slab& slab : made.bodies[i].slabs) {
      auto sound = checkConnectivity(*slab.connectivity);
      if (sound) sound = checkSlab(slab);
      if (!sound) throw std::logic_error(made.file.id + " " + sound.error().message);
      (void)meshes[i].put(slab);
    }
    sources.push_back({made.bodies[i].name, &meshes[i]});
  }
  // Slabs in memory can always be described and sliced.
  made.file.describe = *describe(sources, {1, options_.minorVersion}, named_);
  for (const double time : times_) {
    Answer answer = *sliceAt(sources, time);
    made.file.slices.push_back({time, std::move(answer.json), std::move(answer.within)});
  }
  std::vector<slice::Hyperplane> hyperplanes = sectionsOf(made.bodies);
  hyperplanes.insert(hyperplanes.end(), hyperplanes_.begin(), hyperplanes_.end());
  for (const slice::Hyperplane& hyperplane : hyperplanes) {
    Answer answer = *sliceBy(sources, hyperplane);
    made.file.sections.push_back({hyperplane, std::move(answer.json), std::move(answer.within)});
  }
  return made;
}

AcceptedBuilder& AcceptedCases::add(const std::string& name, const std::string& what) {
  const std::string folder = validity_ == Validity::Valid ? "valid/" : "impl/";
  return builders_.emplace_back(folder + name, validity_, what);
}

std::vector<AcceptedCase> AcceptedCases::finish() const {
  std::vector<AcceptedCase> cases;
  for (const AcceptedBuilder& builder : builders_) cases.push_back(builder.finish());
  return cases;
}

}  // namespace t4d::conformance

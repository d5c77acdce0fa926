#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <set>

#include <fmt/format.h>

#include "edit/contact_times.h"
#include "edit/displaced_source.h"
#include "edit/give_way.h"
#include "edit/solid_sample.h"
#include "edit/surface_crossings.h"
#include "edit/vertex_tracks.h"
#include "model/parallel.h"
#include "model/progress.h"
#include "t4d/check.h"
#include "t4d/edit.h"
#include "t4d/slice.h"

namespace t4d::edit {
namespace {

using model::Body;
using model::Point3;
using model::TriangleMesh;

/// The least distance to keep, as a fraction of the size of the body: touching is contact.
constexpr double kGap = 1e-4;
/// How far a contact between points that are tested moves them at first, in gaps; doubled with
/// each round.
constexpr double kNudge = 1;
/// Evaluations of layers between two tests for contact.
constexpr int kInnerRounds = 12;
/// Steps are halved at most so often.
constexpr double kSmallestFraction = 1.0 / 64;
/// Triangles of obstacles that are kept for the next look.
constexpr std::size_t kKeptTriangles = 300'000;

/// The direction in which vertices move out.
enum class Way : std::uint8_t { Nearest, Inward };

std::string placeText(const Point3& place) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", place[0], place[1], place[2]);
}

void append(const TriangleMesh& mesh, TriangleMesh& all) {
  const auto first = static_cast<std::uint32_t>(all.vertices.size());
  all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
  for (const auto& [a, b, c] : mesh.triangles) {
    all.triangles.push_back({a + first, b + first, c + first});
  }
}

/// The obstacles together at any time.
class Obstacles {
 public:
  explicit Obstacles(std::span<const Body> bodies) {
    for (const Body& body : bodies) {
      times_.push_back(timeSpanOf(*body.source));
      slicers_.push_back(std::make_unique<slice::LightSlicer>(*body.source));
    }
  }

  /// Null if there are none at this time.
  Result<std::shared_ptr<const SolidSample>> at(double time) {
    for (const auto& [known, sample] : known_) {
      if (known == time) return sample;
    }
    TriangleMesh all;
    for (std::size_t i = 0; i < slicers_.size(); ++i) {
      if (time < times_[i].begin || time > times_[i].end) continue;
      const auto slice = slicers_[i]->at(time);
      if (!slice) return slice.error();
      append(slice->slice.mesh, all);
    }
    std::shared_ptr<const SolidSample> sample;
    kept_ += all.triangles.size();
    if (!all.triangles.empty()) sample = std::make_shared<const SolidSample>(std::move(all));
    known_.emplace_back(time, sample);
    while (kept_ > kKeptTriangles && known_.size() > 1) {
      if (known_.front().second) kept_ -= known_.front().second->mesh().triangles.size();
      known_.pop_front();
    }
    return sample;
  }

 private:
  std::vector<model::TimeSpan> times_;
  std::vector<std::unique_ptr<slice::LightSlicer>> slicers_;
  std::deque<std::pair<double, std::shared_ptr<const SolidSample>>> known_;
  std::size_t kept_ = 0;
};

std::vector<Point3> normalsOf(const TriangleMesh& mesh) {
  std::vector<Point3> normals(mesh.vertices.size(), Point3::Zero());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Point3 normal =
        (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
    for (const std::uint32_t vertex : {a, b, c}) normals[vertex] += normal;
  }
  for (Point3& normal : normals) normal.normalize();
  return normals;
}

/// A vertex that is still too near to an obstacle: how much farther it has to go.
struct Near {
  std::uint32_t vertex = 0;
  double more = 0;
  Point3 along = Point3::Zero();
};

/// One attempt, with one way out.
class Attempt {
 public:
  Attempt(Obstacles& obstacles, std::span<const Body> bodies, const Body& body,
          const VertexTracks& tracks, const ResolveOptions& options, double size, Way way)
      : obstacles_(obstacles),
        bodies_(bodies),
        body_(body),
        tracks_(tracks),
        options_(options),
        gap_(kGap * size),
        keep_(options.clearance + gap_),
        way_(way) {
    for (std::size_t k = 0; k <= tracks_.steps(); ++k) layers_[{k, 0}] = tracks_.layerTime(k);
  }

  /// Handles contacts until nothing meets.
  Result<void> run(std::vector<ContactTime> contacts, double maxMove, const Spread& by,
                   const model::Progress& progress) {
    maxMove_ = maxMove;
    by_ = by;
    for (; rounds_ < options_.maxRounds; ++rounds_) {
      if (auto done = handle(contacts); !done) return done;
      auto now = contactTimes(bodies_, {body_.name, source(false).get()}, options_.clearance,
                              model::eachOf(progress, rounds_, options_.maxRounds));
      if (!now) return now.error();
      if (now->empty()) {
        ++rounds_;
        return {};
      }
      contacts = std::move(*now);
    }
    const ContactTime& left = contacts.front();
    return fail(ErrorCode::Failed,
                fmt::format("it still meets '{}' after {} rounds, at time {:.6g}, about at {}; "
                            "allow more rounds, or give way over a longer distance or time",
                            left.obstacle, rounds_, left.time, placeText(left.place)));
  }

  std::shared_ptr<const DisplacedSource> source(bool withAttribute) {
    current_ = std::make_shared<const DisplacedSource>(tracks_, displacement_, withAttribute);
    return current_;
  }

  const Displacement& displacement() const { return displacement_; }
  const std::map<LayerKey, double>& layers() const { return layers_; }
  const Spread& spreadUsed() const { return by_; }
  int rounds() const { return rounds_; }

 private:
  /// Moves vertices at the times of the contacts.
  Result<void> handle(const std::vector<ContactTime>& contacts) {
    std::set<LayerKey> keys;
    for (const ContactTime& contact : contacts) {
      auto at = layers_.lower_bound(keyBefore(contact.span.begin));
      for (; at != layers_.end(); ++at) {
        keys.insert(at->first);
        if (at->second >= contact.span.end) break;
      }
    }
    bool moves = false;
    for (int inner = 0; inner < kInnerRounds; ++inner) {
      bool more = false;
      for (const LayerKey& key : keys) {
        const auto near = nearAt(key, layers_.at(key), false);
        if (!near) return near.error();
        more = more || !near->empty();
        if (auto done = push(key, *near); !done) return done;
      }
      if (!more) break;
      moves = true;
      if (auto done = spreadPushes(); !done) return done;
    }
    if (moves) return {};
    for (const ContactTime& contact : contacts) {
      if (auto done = betweenLayers(contact); !done) return done;
    }
    return spreadPushes();
  }

  /// The last layer that is not after a time.
  LayerKey keyBefore(double time) const {
    LayerKey key = layers_.begin()->first;
    for (const auto& [one, at] : layers_) {
      if (at > time) break;
      key = one;
    }
    return key;
  }

  /// A contact at a time between layers that are clear: the step is divided or, if it is short
  /// already, both layers move.
  Result<void> betweenLayers(const ContactTime& contact) {
    const LayerKey lower = keyBefore(contact.time);
    auto next = layers_.upper_bound(lower);
    if (next == layers_.end()) return nudge(lower, lower, contact);
    const LayerKey upper = next->first;
    const double end = upper.fraction == 0 ? 1 : upper.fraction;
    const double begin = lower.fraction;
    const double from = layers_.at(lower);
    const double to = next->second;
    const bool isLong = to - from > by_.time / 2 || (!movesAt(lower) && !movesAt(upper));
    if (contact.time > from && isLong && end - begin > kSmallestFraction) {
      const double middle = (begin + end) / 2;
      const double time =
          (1 - middle) * tracks_.layerTime(lower.step) + middle * tracks_.layerTime(lower.step + 1);
      if (from < time && time < to) {
        layers_[{lower.step, middle}] = time;
        const LayerKey key{lower.step, middle};
        displacement_[key];
        const auto near = nearAt(key, time, true);
        if (!near) return near.error();
        return push(key, *near);
      }
    }
    // Both layers move as the time between them requires.
    const double fraction = begin + (end - begin) * (contact.time - from) / (to - from);
    const auto near = nearAt({lower.step, fraction}, contact.time, true);
    if (!near) return near.error();
    if (near->empty()) return nudge(lower, upper, contact);
    if (auto done = push(lower, *near); !done) return done;
    return push(upper, *near);
  }

  bool movesAt(const LayerKey& key) const {
    const auto found = displacement_.find(key);
    return found != displacement_.end() && !found->second.empty();
  }

  /// Moves the corners of the triangle nearest to a contact a little.
  Result<void> nudge(const LayerKey& lower, const LayerKey& upper, const ContactTime& contact) {
    const auto sample = obstacles_.at(contact.time);
    if (!sample) return sample.error();
    if (*sample == nullptr) return {};
    for (const LayerKey& key : {lower, upper}) {
      auto mesh = meshAt(key);
      if (!mesh) return mesh.error();
      const std::vector<Point3> normals = normalsOf(*mesh);
      const SolidSample self(std::move(*mesh));
      std::vector<Near> near;
      for (const std::uint32_t vertex : self.mesh().triangles[self.at(contact.place).triangle]) {
        near.push_back({vertex, std::ldexp(kNudge * gap_, rounds_), -normals[vertex]});
      }
      if (auto done = push(key, near); !done) return done;
    }
    return {};
  }

  /// The surface at a layer or between two, as it is displaced now.
  Result<TriangleMesh> meshAt(const LayerKey& key) const {
    auto places = placesAt(tracks_, key);
    if (!places) return places.error();
    TriangleMesh mesh{std::move(*places), tracks_.triangles(), {}};
    if (const auto known = displacement_.find(key); known != displacement_.end()) {
      for (const auto& [vertex, by] : known->second) mesh.vertices[vertex] += by;
      return mesh;
    }
    if (key.fraction == 0) return mesh;
    const LayerKey upper = layers_.upper_bound(key)->first;
    const LayerKey lower = std::prev(layers_.lower_bound(key))->first;
    const double end = upper.fraction == 0 ? 1 : upper.fraction;
    const double part = (key.fraction - lower.fraction) / (end - lower.fraction);
    for (const auto& [layer, weight] : {std::pair(lower, 1 - part), std::pair(upper, part)}) {
      const auto moved = displacement_.find(layer);
      if (moved == displacement_.end()) continue;
      for (const auto& [vertex, by] : moved->second) mesh.vertices[vertex] += weight * by;
    }
    return mesh;
  }

  /// The vertices that have to go farther at a layer, or within a step; with `fine`, the middles of
  /// triangles and edges are looked at, too.
  Result<std::vector<Near>> nearAt(const LayerKey& key, double time, bool fine) {
    const auto found = obstacles_.at(time);
    if (!found) return found.error();
    if (*found == nullptr) return std::vector<Near>();
    const SolidSample& obstacle = **found;
    const auto mesh = meshAt(key);
    if (!mesh) return mesh.error();
    const std::vector<Point3> normals = normalsOf(*mesh);
    std::vector<Near> all(mesh->vertices.size());
    model::forEach(all.size(), [&](std::size_t i) {
      all[i] = nearOf(obstacle, mesh->vertices[i], static_cast<std::uint32_t>(i), key, normals[i]);
    });
    std::vector<Near> near;
    for (const Near& one : all) {
      if (one.more > 0) near.push_back(one);
    }
    addFromInside(obstacle, *mesh, near);
    if (fine && near.empty()) addFromMiddles(obstacle, *mesh, key, normals, near);
    for (const Near& one : near) {
      if (std::isfinite(one.more)) continue;
      return fail(ErrorCode::Failed,
                  fmt::format("at time {:.6g} its point {} has no way out within a move of {:.6g}",
                              time, placeText(mesh->vertices[one.vertex]), maxMove_));
    }
    return near;
  }

  Near nearOf(const SolidSample& obstacle, const Point3& point, std::uint32_t vertex,
              const LayerKey& key, const Point3& normal) const {
    if (!isNear(obstacle.bounds(), point, keep_)) return {vertex};
    const SolidSample::Place place = obstacle.at(point);
    if (place.distance >= options_.clearance + gap_ / 2) return {vertex};
    Point3 along = way_ == Way::Nearest ? place.out : Point3(-normal);
    if (const auto known = displacement_.find(key); known != displacement_.end()) {
      const auto at = std::ranges::lower_bound(known->second, vertex, {},
                                               [](const auto& one) { return one.first; });
      if (at != known->second.end() && at->first == vertex) along = at->second.normalized();
    }
    const auto more = obstacle.wayOut(point, along, keep_, maxMove_);
    return {vertex, more.value_or(std::numeric_limits<double>::infinity()), along};
  }

  /// Vertices of the obstacle that lie in the body, or near it, move the triangle there.
  void addFromInside(const SolidSample& obstacle, const TriangleMesh& mesh,
                     std::vector<Near>& near) const {
    const model::Bounds3 bounds = boundsOf(mesh);
    std::vector<Point3> points;
    for (const Point3& point : obstacle.mesh().vertices) {
      if (isNear(bounds, point, keep_)) points.push_back(point);
    }
    if (points.empty()) return;
    const SolidSample self(mesh);
    std::vector<SolidSample::Place> places(points.size());
    model::forEach(points.size(), [&](std::size_t i) { places[i] = self.at(points[i]); });
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (places[i].distance >= options_.clearance + gap_ / 2) continue;
      for (const std::uint32_t vertex : mesh.triangles[places[i].triangle]) {
        near.push_back({vertex, keep_ - places[i].distance, -places[i].out});
      }
    }
  }

  void addFromMiddles(const SolidSample& obstacle, const TriangleMesh& mesh, const LayerKey& key,
                      const std::vector<Point3>& normals, std::vector<Near>& near) const {
    for (const model::Triangle& triangle : mesh.triangles) {
      const std::array<Point3, 3> corners = {mesh.vertices[triangle[0]], mesh.vertices[triangle[1]],
                                             mesh.vertices[triangle[2]]};
      for (int k = 0; k < 4; ++k) {
        const Point3 middle = k == 3 ? Point3((corners[0] + corners[1] + corners[2]) / 3)
                                     : Point3((corners[k] + corners[(k + 1) % 3]) / 2);
        const Near one = nearOf(obstacle, middle, triangle[k % 3], key, normals[triangle[k % 3]]);
        if (!(one.more > 0)) continue;
        for (const std::uint32_t vertex : triangle) near.push_back({vertex, one.more, one.along});
      }
    }
  }

  /// Remembers how far vertices of a layer have to go in all.
  Result<void> push(const LayerKey& key, const std::vector<Near>& near) {
    LayerPushes& layer = pushes_[key];
    const auto moved = displacement_.find(key);
    for (const Near& one : near) {
      double depth = one.more;
      Point3 along = one.along;
      if (moved != displacement_.end()) {
        const auto at = std::ranges::lower_bound(moved->second, one.vertex, {},
                                                 [](const auto& each) { return each.first; });
        if (at != moved->second.end() && at->first == one.vertex) {
          depth += at->second.norm();
          along = at->second.normalized();
        }
      }
      Push& known = layer[one.vertex];
      if (known.depth == 0) known.along = along;
      known.depth = std::max(known.depth, depth);
      if (known.depth > maxMove_) {
        const auto places = placesAt(tracks_, key);
        if (!places) return places.error();
        return fail(
            ErrorCode::Failed,
            fmt::format("at time {:.6g} its point {} would have to move by {:.6g}, but "
                        "{:.6g} is the most allowed",
                        layers_.at(key), placeText((*places)[one.vertex]), known.depth, maxMove_));
      }
      deepest_ = std::max(deepest_, known.depth);
    }
    return {};
  }

  Result<void> spreadPushes() {
    if (!options_.smoothSpace) by_.space = std::max(by_.space, 3 * deepest_);
    auto spreadOut = spread(tracks_, layers_, pushes_, by_);
    if (!spreadOut) return spreadOut.error();
    displacement_ = std::move(*spreadOut);
    return {};
  }

  Obstacles& obstacles_;
  std::span<const Body> bodies_;
  const Body& body_;
  const VertexTracks& tracks_;
  const ResolveOptions& options_;
  double gap_;
  double keep_;
  Way way_;
  double maxMove_ = 0;
  double deepest_ = 0;
  Spread by_;
  std::map<LayerKey, double> layers_;  // their times
  Pushes pushes_;
  Displacement displacement_;
  std::shared_ptr<const DisplacedSource> current_;
  int rounds_ = 0;
};

double meanEdge(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    sum += (mesh.vertices[a] - mesh.vertices[b]).norm() +
           (mesh.vertices[b] - mesh.vertices[c]).norm() +
           (mesh.vertices[c] - mesh.vertices[a]).norm();
  }
  return sum / (3 * static_cast<double>(mesh.triangles.size()));
}

/// Fails if the surface crosses itself in a step that has changed.
Result<void> checkCrossings(const VertexTracks& tracks, const DisplacedSource& source) {
  if (!findsCrossings()) return {};
  const auto first = tracks.layer(0);
  if (!first) return first.error();
  const TriangleMesh mesh{*first, tracks.triangles(), {}};
  const auto sound = findCrossings(mesh, 1);
  if (!sound) return sound.error();
  if (!sound->pairs.empty()) return {};  // the body did before
  for (std::size_t i = 0; i < source.slabCount(); ++i) {
    const model::TimeSpan span = source.timeSpan(i);
    if (!source.isChanged(i) || !(span.begin < span.end)) continue;
    const auto slab = source.slab(i);
    if (!slab) return slab.error();
    const auto crossing = crossingWithin(mesh, **slab);
    if (!crossing) return crossing.error();
    if (!*crossing) continue;
    return fail(ErrorCode::Failed,
                fmt::format("its surface would cross itself at time {:.6g}, at {}; give way over a "
                            "longer distance or time",
                            (*crossing)->at, placeText((*crossing)->place)));
  }
  return {};
}

Result<void> fillReport(const VertexTracks& tracks, const Attempt& attempt,
                        const DisplacedSource& source, ResolveReport& report) {
  report.changed = true;
  report.rounds = static_cast<std::uint64_t>(attempt.rounds());
  report.smoothSpace = attempt.spreadUsed().space;
  report.smoothTime = attempt.spreadUsed().time;
  for (const auto& [key, time] : attempt.layers()) {
    auto places = placesAt(tracks, key);
    if (!places) return places.error();
    TriangleMesh mesh{std::move(*places), tracks.triangles(), {}};
    ResolvedLayer layer{time, signedVolume(mesh), 0, 0};
    layer.volumeAfter = layer.volumeBefore;
    report.addedLayers += key.fraction != 0 ? 1 : 0;
    const auto moved = attempt.displacement().find(key);
    if (moved != attempt.displacement().end() && !moved->second.empty()) {
      report.movedVertices += moved->second.size();
      for (const auto& [vertex, by] : moved->second) {
        layer.displacement = std::max(layer.displacement, by.norm());
        if (by.norm() > report.maxDisplacement) {
          report.maxDisplacement = by.norm();
          report.maxDisplacementTime = time;
          report.maxDisplacementPlace = mesh.vertices[vertex];
        }
        mesh.vertices[vertex] += by;
      }
      layer.volumeAfter = signedVolume(mesh);
    }
    const double change = layer.volumeAfter - layer.volumeBefore;
    if (std::abs(change) > std::abs(report.volumeChangeMax)) report.volumeChangeMax = change;
    report.layers.push_back(layer);
  }
  const auto before = measure::checkMesh(tracks.source());
  if (!before) return before.error();
  const auto after = measure::checkMesh(source);
  if (!after) return after.error();
  if (before->valid() && !after->valid()) {
    return fail(ErrorCode::Failed,
                "the mesh would not be valid: " + after->issues.issues.front().message);
  }
  report.hypervolumeChange = after->hypervolume - before->hypervolume;
  return {};
}

/// Holds what the slabs of a resolved body are made of.
struct Resolved {
  VertexTracks tracks;
  std::shared_ptr<const DisplacedSource> source;
};

}  // namespace

Result<ResolvedBody> resolve(std::span<const Body> obstacles, const Body& body,
                             const ResolveOptions& options, const model::Progress& progress) {
  ResolvedBody unchanged{std::shared_ptr<const model::Source>(std::shared_ptr<void>(), body.source),
                         {}};
  auto contacts = contactTimes(obstacles, body, options.clearance, progress);
  if (!contacts) return contacts.error();
  if (contacts->empty()) return unchanged;

  auto tracks = VertexTracks::of(*body.source);
  if (!tracks) return tracks.error();
  auto held = std::make_shared<Resolved>(Resolved{std::move(*tracks), nullptr});
  const auto first = held->tracks.layer(0);
  if (!first) return first.error();
  const TriangleMesh solid{*first, held->tracks.triangles(), {}};
  const Point3 extent = boundsOf(solid).max - boundsOf(solid).min;
  const double maxMove = options.maxMove.value_or(extent.minCoeff() / 2);
  const model::TimeSpan time = timeSpanOf(*body.source);
  const double twoEdges = 2 * meanEdge(solid);
  const Spread by{options.smoothSpace.value_or(twoEdges),
                  options.smoothTime.value_or((time.end - time.begin) / 10), options.stay};

  Obstacles samples(obstacles);
  std::optional<Error> why;
  for (const Way way : {Way::Nearest, Way::Inward}) {
    Attempt attempt(samples, obstacles, body, held->tracks, options, extent.norm(), way);
    auto done = attempt.run(*contacts, maxMove, by, progress);
    if (done) {
      held->source = attempt.source(true);
      done = checkCrossings(held->tracks, *held->source);
    }
    ResolvedBody resolved{std::shared_ptr<const model::Source>(held, held->source.get()), {}};
    if (done) done = fillReport(held->tracks, attempt, *held->source, resolved.report);
    if (done) return resolved;
    if (done.error().code != ErrorCode::Failed) return done.error();
    if (!why) why = done.error();
  }
  why->message = fmt::format("body '{}' cannot get out of the way: {}", body.name, why->message);
  if (by.space < twoEdges) {
    why->message +=
        fmt::format("; smoothing over two mean edges, {:.4g}, or more may find a way", twoEdges);
  }
  return *why;
}

}  // namespace t4d::edit

#include "edit/displaced_source.h"

#include <algorithm>
#include <cstring>

#include <fmt/format.h>

#include "mesh4d/cap.h"

namespace t4d::edit {
namespace {

using model::Attribute;
using model::Domain;
using model::Point3;
using model::Point4;
using model::Slab;

bool isIn(const LayerDisplacement* moved) { return moved != nullptr && !moved->empty(); }

void displace(std::span<Point4> layer, const LayerDisplacement* moved) {
  if (moved == nullptr) return;
  for (const auto& [vertex, by] : *moved) layer[vertex].head<3>() += by;
}

/// The rows of a layer at a fraction of a step, for vertex attributes.
void copyRows(const Attribute& from, std::size_t fromLower, std::size_t fromUpper, double fraction,
              std::size_t count, Attribute& into, std::size_t first) {
  const std::size_t bytes = from.rowBytes();
  for (std::size_t i = 0; i < count; ++i) {
    std::byte* row = into.values.data() + (first + i) * bytes;
    if (fraction == 0 || fraction == 1) {
      std::memcpy(row, from.row((fraction == 0 ? fromLower : fromUpper) + i), bytes);
    } else {
      interpolateRow(from, fromLower + i, fromUpper + i, fraction, row);
    }
  }
}

/// `count` rows that equal the first of an attribute; zeros if it has none.
Attribute repeated(const Attribute& attribute, std::size_t count) {
  Attribute made{attribute.name, attribute.domain, attribute.type, attribute.components, {}};
  const std::size_t bytes = attribute.rowBytes();
  made.values.resize(count * bytes);
  if (attribute.rows() == 0) return made;
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(made.values.data() + i * bytes, attribute.row(0), bytes);
  }
  return made;
}

}  // namespace

DisplacedSource::DisplacedSource(const VertexTracks& tracks, Displacement displacement,
                                 bool withAttribute)
    : tracks_(tracks), displacement_(std::move(displacement)), withAttribute_(withAttribute) {
  const std::size_t first = tracks_.firstStep();
  for (std::size_t i = 0; i < first; ++i) slabs_.push_back({i, {0, 0}, {0, 0}, true});
  for (std::size_t k = 0; k < tracks_.steps(); ++k) {
    LayerKey lower{k, 0};
    for (auto at = displacement_.upper_bound(lower);
         at != displacement_.end() && at->first.step == k; ++at) {
      slabs_.push_back({first + k, lower, at->first, false});
      lower = at->first;
    }
    slabs_.push_back({first + k, lower, {k + 1, 0}, false});
  }
  const LayerKey last{tracks_.steps(), 0};
  for (std::size_t i = first + tracks_.steps(); i < tracks_.source().slabCount(); ++i) {
    slabs_.push_back({i, last, last, true});
  }
}

double DisplacedSource::timeOf(const LayerKey& key) const {
  const double begin = tracks_.layerTime(key.step);
  if (key.fraction == 0) return begin;
  return (1 - key.fraction) * begin + key.fraction * tracks_.layerTime(key.step + 1);
}

model::TimeSpan DisplacedSource::timeSpan(std::size_t index) const {
  return {timeOf(slabs_[index].lower), timeOf(slabs_[index].upper)};
}

const LayerDisplacement* DisplacedSource::moved(const LayerKey& key) const {
  const auto found = displacement_.find(key);
  return found == displacement_.end() ? nullptr : &found->second;
}

bool DisplacedSource::isChanged(std::size_t index) const {
  const Piece& piece = slabs_[index];
  return piece.lower.fraction != 0 || piece.upper.fraction != 0 || isIn(moved(piece.lower)) ||
         isIn(moved(piece.upper));
}

Result<std::shared_ptr<const Slab>> DisplacedSource::slab(std::size_t index) const {
  const Piece& piece = slabs_[index];
  if (piece.isCap && isChanged(index)) {
    const std::scoped_lock lock(mutex_);
    if (const auto known = caps_.find(index); known != caps_.end()) return known->second;
    const auto from = tracks_.source().slab(piece.slab);
    if (!from) return from;
    auto made = cap(piece, **from);
    if (!made) return made.error();
    if (withAttribute_) addAttribute(piece, *made);
    return caps_[index] = std::make_shared<const Slab>(std::move(*made));
  }
  const auto from = tracks_.source().slab(piece.slab);
  if (!from || (!withAttribute_ && !isChanged(index))) return from;
  Slab made;
  if (isChanged(index)) {
    auto stepped = step(piece, **from);
    if (!stepped) return stepped.error();
    made = std::move(*stepped);
  } else {
    made = **from;
  }
  if (withAttribute_) addAttribute(piece, made);
  return std::make_shared<const Slab>(std::move(made));
}

Result<Slab> DisplacedSource::step(const Piece& piece, const Slab& from) const {
  const model::Connectivity& connectivity = *from.connectivity;
  const std::size_t count = connectivity.lowerCount;
  const std::size_t upper = connectivity.firstUpper();
  Slab made;
  made.timeBegin = timeOf(piece.lower);
  made.timeEnd = timeOf(piece.upper);
  if (!(made.timeBegin < made.timeEnd)) {
    return fail(ErrorCode::Failed,
                fmt::format("the steps at time {} cannot be divided further: there is no number "
                            "between their times",
                            made.timeBegin));
  }
  made.connectivity = from.connectivity;
  made.vertices.resize(connectivity.vertexCount);
  const double lowerFraction = piece.lower.fraction;
  const double upperFraction = piece.upper.fraction == 0 ? 1 : piece.upper.fraction;
  for (std::size_t i = 0; i < count; ++i) {
    const Point4& begin = from.vertices[i];
    const Point4& end = from.vertices[upper + i];
    const auto at = [&](double fraction) {
      return fraction == 1 ? Point3(end.head<3>())
                           : between(begin.head<3>(), end.head<3>(), fraction);
    };
    made.vertices[i] << at(lowerFraction), made.timeBegin;
    made.vertices[upper + i] << at(upperFraction), made.timeEnd;
  }
  displace(std::span(made.vertices).first(count), moved(piece.lower));
  displace(std::span(made.vertices).last(count), moved(piece.upper));
  setMeans(connectivity, made.vertices);
  for (const Attribute& attribute : from.attributes) {
    made.attributes.push_back(attribute);
    if (attribute.domain != Domain::Vertex) continue;
    copyRows(attribute, 0, upper, lowerFraction, count, made.attributes.back(), 0);
    copyRows(attribute, 0, upper, upperFraction, count, made.attributes.back(), upper);
    setMeans(connectivity, made.attributes.back());
  }
  if (from.upperPose && piece.upper.fraction == 0 && !isIn(moved(piece.upper))) {
    made.upperPose = from.upperPose;
  }
  return made;
}

Result<Slab> DisplacedSource::cap(const Piece& piece, const Slab& from) const {
  const bool begins = from.connectivity->upperCount > 0;
  std::vector<Point4> layer(begins ? from.upperLayer().begin() : from.lowerLayer().begin(),
                            begins ? from.upperLayer().end() : from.lowerLayer().end());
  displace(layer, moved(piece.lower));
  model::TriangleMesh mesh;
  for (const Point4& vertex : layer) mesh.vertices.emplace_back(vertex.head<3>());
  mesh.triangles = tracks_.triangles();
  const bool isCone = from.connectivity->cells.size() == mesh.triangles.size() &&
                      from.connectivity->vertexCount == layer.size() + 1;
  auto filled =
      mesh4d::fillSolid(mesh, isCone ? mesh4d::CapMethod::Cone : mesh4d::CapMethod::TetGen);
  if (!filled && filled.error().code == ErrorCode::Unsupported) {
    filled = mesh4d::fillSolid(mesh, mesh4d::CapMethod::Cone);
  }
  if (!filled) return filled.error();
  auto connectivity = std::make_shared<model::Connectivity>(
      *(begins ? startCapConnectivity(*filled, mesh) : endCapConnectivity(*filled, mesh)));
  connectivity->cellAttributes.clear();
  for (const Attribute& attribute : from.connectivity->cellAttributes) {
    connectivity->cellAttributes.push_back(repeated(attribute, connectivity->cells.size()));
  }
  Slab made;
  made.timeBegin = from.timeBegin;
  made.timeEnd = from.timeEnd;
  std::vector<Point4> inner;
  for (const Point3& point : filled->inner) inner.emplace_back(point[0], point[1], point[2], 0);
  for (Point4& point : inner) point[3] = from.timeBegin;
  made.vertices = begins ? inner : layer;
  const std::vector<Point4>& rest = begins ? layer : inner;
  made.vertices.insert(made.vertices.end(), rest.begin(), rest.end());
  // The layer keeps what its vertices have; points within have what its first vertex has.
  const std::size_t fromFirst = begins ? from.connectivity->firstUpper() : 0;
  const std::size_t first = begins ? inner.size() : 0;
  for (const Attribute& attribute : from.attributes) {
    if (attribute.domain == Domain::Cell) {
      made.attributes.push_back(repeated(attribute, connectivity->cells.size()));
      continue;
    }
    Attribute rows = repeated(attribute, made.vertices.size());
    const std::size_t bytes = attribute.rowBytes();
    for (std::size_t i = 0; i < rows.rows(); ++i) {
      const std::size_t row = i >= first && i < first + layer.size() ? i - first : 0;
      std::memcpy(rows.values.data() + i * bytes, attribute.row(fromFirst + row), bytes);
    }
    made.attributes.push_back(std::move(rows));
  }
  made.connectivity = std::move(connectivity);
  return made;
}

void DisplacedSource::addAttribute(const Piece& piece, Slab& slab) const {
  const model::Connectivity& connectivity = *slab.connectivity;
  std::erase_if(slab.attributes,
                [](const Attribute& one) { return one.name == kDisplacementAttribute; });
  std::vector<float> rows(std::size_t{3} * connectivity.vertexCount);
  const auto fill = [&](const LayerKey& key, std::size_t first) {
    const LayerDisplacement* layer = moved(key);
    if (layer == nullptr) return;
    for (const auto& [vertex, by] : *layer) {
      for (std::size_t k = 0; k < 3; ++k) {
        rows[3 * (first + vertex) + k] = static_cast<float>(by[static_cast<Eigen::Index>(k)]);
      }
    }
  };
  if (connectivity.lowerCount > 0) fill(piece.lower, 0);
  if (connectivity.upperCount > 0) fill(piece.upper, connectivity.firstUpper());
  Attribute attribute = model::makeAttribute(kDisplacementAttribute, Domain::Vertex, rows);
  attribute.components = 3;
  setMeans(connectivity, attribute);
  slab.attributes.push_back(std::move(attribute));
}

}  // namespace t4d::edit

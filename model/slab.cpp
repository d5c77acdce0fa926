#include <cmath>
#include <cstring>
#include <limits>

#include <fmt/format.h>

#include "model/slab_groups.h"
#include "t4d/mesh.h"

namespace t4d::model {

void Means::add(std::span<const std::uint32_t> from) {
  if (offsets.empty()) offsets.push_back(0);
  sources.insert(sources.end(), from.begin(), from.end());
  offsets.push_back(static_cast<std::uint32_t>(sources.size()));
}

namespace {

Result<void> checkMeans(const Connectivity& connectivity) {
  const Means& means = connectivity.means;
  if (means.offsets.empty()) {
    return means.sources.empty() ? Result<void>() : invalid("has sources of means but no means");
  }
  if (means.offsets.front() != 0 || means.offsets.back() != means.sources.size()) {
    return invalid("the means' offsets do not span their sources");
  }
  for (std::uint32_t i = 0; i < means.size(); ++i) {
    if (means.offsets[i] >= means.offsets[i + 1]) {
      return invalid(fmt::format("mean {} is the mean of no vertex", i));
    }
  }
  const std::uint32_t firstMean = connectivity.firstMean();
  const std::uint32_t firstUpper = connectivity.firstUpper();
  for (const std::uint32_t source : means.sources) {
    if (source >= connectivity.vertexCount) {
      return invalid(fmt::format("a mean's source {} is not one of the {} vertices", source,
                                 connectivity.vertexCount));
    }
    if (source >= firstMean && source < firstUpper) {
      return invalid(fmt::format("a mean's source {} is a mean itself", source));
    }
  }
  return {};
}

}  // namespace

Result<void> checkAttributes(std::span<const Attribute> attributes, std::size_t vertexCount,
                             std::size_t cellCount) {
  for (const Attribute& attribute : attributes) {
    const std::size_t expected = attribute.domain == Domain::Vertex ? vertexCount : cellCount;
    if (attribute.rowBytes() == 0 || attribute.values.size() % attribute.rowBytes() != 0 ||
        attribute.rows() != expected) {
      return invalid(fmt::format("attribute '{}' has {} bytes where {} rows of {} are expected",
                                 attribute.name, attribute.values.size(), expected,
                                 attribute.rowBytes()));
    }
  }
  return {};
}

Result<void> checkCells(std::span<const Cell> cells, std::uint32_t vertexCount,
                        std::uint64_t first) {
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Cell& cell = cells[i];
    for (int corner = 0; corner < 4; ++corner) {
      if (cell[corner] >= vertexCount) {
        return invalid(
            fmt::format("cell {} has the vertex {}, of {}", first + i, cell[corner], vertexCount));
      }
      for (int other = 0; other < corner; ++other) {
        if (cell[corner] == cell[other]) {
          return invalid(fmt::format("cell {} has the vertex {} twice", first + i, cell[corner]));
        }
      }
    }
  }
  return {};
}

Result<void> checkConnectivity(const Connectivity& connectivity) {
  const std::uint64_t parts =
      std::uint64_t{connectivity.lowerCount} + connectivity.upperCount + connectivity.means.size();
  if (parts > connectivity.vertexCount) {
    return invalid(fmt::format("layers of {} and {} vertices and {} means exceed the {} vertices",
                               connectivity.lowerCount, connectivity.upperCount,
                               connectivity.means.size(), connectivity.vertexCount));
  }
  if (auto cells = checkCells(connectivity.cells, connectivity.vertexCount); !cells) return cells;
  if (auto means = checkMeans(connectivity); !means) return means;
  for (const Attribute& attribute : connectivity.cellAttributes) {
    if (attribute.domain != Domain::Cell) {
      return invalid(
          fmt::format("attribute '{}' of a connectivity is not per cell", attribute.name));
    }
  }
  return checkAttributes(connectivity.cellAttributes, connectivity.vertexCount,
                         connectivity.cells.size());
}

void setMeans(const Connectivity& connectivity, std::span<Point4> vertices) {
  const Means& means = connectivity.means;
  const std::uint32_t firstMean = connectivity.firstMean();
  for (std::uint32_t i = 0; i < means.size(); ++i) {
    const std::uint32_t begin = means.offsets[i];
    const std::uint32_t end = means.offsets[i + 1];
    Point4 sum = vertices[means.sources[begin]];
    for (std::uint32_t k = begin + 1; k < end; ++k) sum += vertices[means.sources[k]];
    vertices[firstMean + i] = sum / static_cast<double>(end - begin);
  }
}

namespace {

template <class Scalar>
void setMeansOf(const Connectivity& connectivity, Attribute& attribute) {
  const Means& means = connectivity.means;
  const auto at = [&](std::uint32_t row, std::uint32_t component) {
    return attribute.values.data() + row * attribute.rowBytes() + component * sizeof(Scalar);
  };
  const auto number = [&](std::uint32_t row, std::uint32_t component) {
    Scalar value;
    std::memcpy(&value, at(row, component), sizeof value);
    return static_cast<double>(value);
  };
  for (std::uint32_t i = 0; i < means.size(); ++i) {
    const std::uint32_t begin = means.offsets[i];
    const std::uint32_t end = means.offsets[i + 1];
    for (std::uint32_t k = 0; k < attribute.components; ++k) {
      double sum = number(means.sources[begin], k);
      for (std::uint32_t j = begin + 1; j < end; ++j) sum += number(means.sources[j], k);
      auto mean = static_cast<Scalar>(sum / static_cast<double>(end - begin));
      // Which NaN an operation gives depends on the machine.
      if (std::isnan(mean)) mean = std::numeric_limits<Scalar>::quiet_NaN();
      std::memcpy(at(connectivity.firstMean() + i, k), &mean, sizeof mean);
    }
  }
}

}  // namespace

void setMeans(const Connectivity& connectivity, Attribute& attribute) {
  if (attribute.type == ScalarType::Float64) return setMeansOf<double>(connectivity, attribute);
  if (attribute.type == ScalarType::Float32) return setMeansOf<float>(connectivity, attribute);
  const Means& means = connectivity.means;
  for (std::uint32_t i = 0; i < means.size(); ++i) {
    std::memcpy(attribute.values.data() + (connectivity.firstMean() + i) * attribute.rowBytes(),
                attribute.row(means.sources[means.offsets[i]]), attribute.rowBytes());
  }
}

Result<void> checkVertices(std::span<const Point4> vertices, const VertexCounts& counts,
                           const TimeSpan& time, std::uint32_t first) {
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Point4& vertex = vertices[i];
    const std::size_t number = first + i;
    if (!vertex.allFinite()) {
      return invalid(fmt::format("vertex {} is ({}, {}, {}, {})", number, vertex[0], vertex[1],
                                 vertex[2], vertex[3]));
    }
    const bool lower = number < counts.lowerCount;
    const bool upper = number >= counts.firstUpper();
    if ((lower && vertex[3] != time.begin) || (upper && vertex[3] != time.end)) {
      return invalid(fmt::format("vertex {} of the {} layer is at time {}, not {}", number,
                                 lower ? "lower" : "upper", vertex[3],
                                 lower ? time.begin : time.end));
    }
    if (vertex[3] < time.begin || vertex[3] > time.end) {
      return invalid(fmt::format("vertex {} is at time {}, outside {} to {}", number, vertex[3],
                                 time.begin, time.end));
    }
  }
  return {};
}

Result<void> checkSlab(const Slab& slab) {
  if (!slab.connectivity) return invalid("has no connectivity");
  const Connectivity& connectivity = *slab.connectivity;
  if (slab.vertices.size() != connectivity.vertexCount) {
    return invalid(fmt::format("has {} vertices where its connectivity has {}",
                               slab.vertices.size(), connectivity.vertexCount));
  }
  if (!std::isfinite(slab.timeBegin) || !std::isfinite(slab.timeEnd) ||
      slab.timeBegin > slab.timeEnd) {
    return invalid(fmt::format("lasts from time {} to {}", slab.timeBegin, slab.timeEnd));
  }
  if (auto vertices = checkVertices(slab.vertices, connectivity, {slab.timeBegin, slab.timeEnd});
      !vertices) {
    return vertices;
  }
  return checkAttributes(slab.attributes, connectivity.vertexCount, connectivity.cells.size());
}

TimeSpan timeSpanOf(const Source& source) {
  if (source.slabCount() == 0) return {};
  if (const auto& groups = slabGroupsOf(source); !groups.empty()) {
    return {groups.front().time.begin, groups.back().time.end};
  }
  return {source.timeSpan(0).begin, source.timeSpan(source.slabCount() - 1).end};
}

Result<void> Mesh::put(const Slab& slab) {
  slabs_.push_back(slab);
  return {};
}

TimeSpan Mesh::timeSpan(std::size_t index) const {
  return {slabs_[index].timeBegin, slabs_[index].timeEnd};
}

std::optional<std::uint64_t> Mesh::cellCount(std::size_t index) const {
  const auto& connectivity = slabs_[index].connectivity;
  return connectivity ? connectivity->cells.size() : 0;
}

Result<std::shared_ptr<const Slab>> Mesh::slab(std::size_t index) const {
  return std::shared_ptr<const Slab>(std::shared_ptr<void>(), &slabs_[index]);  // non-owning
}

}  // namespace t4d::model

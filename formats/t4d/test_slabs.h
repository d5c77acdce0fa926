#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "formats/t4d/chunk_list.h"
#include "formats/t4d/chunks.h"
#include "formats/t4d/layout.h"
#include "formats/test_files.h"
#include "platform/crc32c.h"
#include "t4d/file.h"
#include "t4d/mesh.h"

/// Shared by the tests of .t4d: slabs, and hand-made files.
namespace t4d::formats {

inline constexpr model::ScalarType kAllScalarTypes[] = {
    model::ScalarType::UInt8,   model::ScalarType::Int8,   model::ScalarType::UInt16,
    model::ScalarType::Int16,   model::ScalarType::UInt32, model::ScalarType::Int32,
    model::ScalarType::UInt64,  model::ScalarType::Int64,  model::ScalarType::Float32,
    model::ScalarType::Float64,
};

/// The boundary of the 4-simplex spanned by the origin and the four unit points: one slab without
/// layers.
inline model::Slab simplexSlab() {
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->vertexCount = 5;
  connectivity->cells = {{1, 2, 3, 4}, {2, 0, 3, 4}, {0, 1, 3, 4}, {1, 0, 2, 4}, {0, 1, 2, 3}};
  model::Slab slab;
  slab.timeEnd = 1;
  slab.vertices = {{0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  slab.connectivity = connectivity;
  return slab;
}

/// Consecutive slabs with a random choice of everything a slab can have: full and empty layers,
/// means, repeated connectivity, no thickness, no cells, attributes of every type. They are not
/// closed meshes; files do not require that.
class RandomSlabs {
 public:
  explicit RandomSlabs(unsigned seed) : random_(seed) {}

  std::vector<model::Slab> make(int count) {
    std::vector<model::Slab> slabs;
    double time = onGrid(number());
    for (int i = 0; i < count; ++i) {
      slabs.push_back(next(slabs.empty() ? nullptr : &slabs.back(), time, i == 0, i + 1 == count));
      time = slabs.back().timeEnd;
      if (slabs.back().connectivity->upperCount == 0 && chance(0.5)) time += 1;
    }
    return slabs;
  }

 private:
  bool chance(double p) { return std::bernoulli_distribution(p)(random_); }
  std::uint32_t upTo(std::uint32_t most) {
    return std::uniform_int_distribution<std::uint32_t>(0, most)(random_);
  }
  double number() { return std::uniform_real_distribution<double>(-10, 10)(random_); }

  /// Sums of such times are exact, so no mean is rounded to a time outside its slab.
  static double onGrid(double time) { return std::round(time * 1024) / 1024; }

  model::Attribute attribute(const std::string& name, model::Domain domain, std::size_t rows) {
    model::Attribute attribute{name, domain, kAllScalarTypes[upTo(9)], 1 + upTo(3), {}};
    attribute.values.resize(rows * attribute.rowBytes());
    const auto mask = std::byte(chance(0.5) ? 0xFF : 0x03);
    for (std::byte& byte : attribute.values) byte = std::byte(upTo(255)) & mask;
    return attribute;
  }

  std::shared_ptr<const model::Connectivity> connectivity(std::uint32_t lower,
                                                          std::uint32_t upper) {
    auto made = std::make_shared<model::Connectivity>();
    made->lowerCount = lower;
    made->upperCount = upper;
    const std::uint32_t stored = upTo(6);
    const std::uint32_t means = lower + stored + upper == 0 ? 0 : upTo(6);
    made->vertexCount = lower + stored + means + upper;
    for (std::uint32_t i = 0; i < means; ++i) {
      std::vector<std::uint32_t> sources;
      for (std::uint32_t k = 0; k <= upTo(3); ++k) {
        const std::uint32_t pick = upTo(lower + stored + upper - 1);
        sources.push_back(pick < lower + stored ? pick : pick + means);
      }
      made->means.add(sources);
    }
    if (made->vertexCount >= 4) {
      for (std::uint32_t i = upTo(20); i > 0; --i) {
        std::set<std::uint32_t> corners;
        while (corners.size() < 4) corners.insert(upTo(made->vertexCount - 1));
        model::Cell cell{};
        std::copy(corners.begin(), corners.end(), cell.begin());
        made->cells.push_back(cell);
      }
    }
    for (std::uint32_t i = upTo(2); i > 0; --i) {
      made->cellAttributes.push_back(
          attribute("connectivity " + std::to_string(i), model::Domain::Cell, made->cells.size()));
    }
    return made;
  }

  void putVertexAttributes(const model::Slab* before, model::Slab& slab) {
    const model::Connectivity& shared = *slab.connectivity;
    std::vector<model::Attribute> lower;
    if (before != nullptr && shared.lowerCount > 0) {
      lower = vertexRows(before->attributes, before->connectivity->firstUpper(), shared.lowerCount);
    } else {
      for (std::uint32_t i = upTo(2); i > 0; --i) {
        lower.push_back(
            attribute("vertex " + std::to_string(i), model::Domain::Vertex, shared.lowerCount));
      }
    }
    for (model::Attribute& each : lower) {
      const std::size_t known = each.values.size();
      each.values.resize(shared.vertexCount * each.rowBytes());
      const auto more = each.values.begin() + static_cast<std::ptrdiff_t>(known);
      for (auto byte = more; byte != each.values.end(); ++byte) *byte = std::byte(upTo(255));
      setMeans(shared, each);
      slab.attributes.push_back(std::move(each));
    }
  }

  model::Slab next(const model::Slab* before, double time, bool first, bool last) {
    const std::uint32_t lower = before != nullptr      ? before->connectivity->upperCount
                                : first && chance(0.5) ? 0
                                                       : upTo(8);
    model::Slab slab;
    if (before != nullptr && before->connectivity->lowerCount == lower && chance(0.6)) {
      slab.connectivity = before->connectivity;
    } else {
      slab.connectivity = connectivity(lower, last || chance(0.2) ? 0 : upTo(8));
    }
    const model::Connectivity& shared = *slab.connectivity;
    slab.timeBegin = time;
    slab.timeEnd = chance(0.2) ? time : time + 0.125 + upTo(5);
    slab.vertices.resize(shared.vertexCount);
    for (std::uint32_t i = 0; i < shared.vertexCount; ++i) {
      const double s = std::uniform_real_distribution<double>(0, 1)(random_);
      const double t = i < shared.lowerCount ? slab.timeBegin
                       : i >= shared.firstUpper()
                           ? slab.timeEnd
                           : onGrid((1 - s) * slab.timeBegin + s * slab.timeEnd);
      slab.vertices[i] = {chance(0.1) ? -0.0 : number(), number(), number(), t};
    }
    if (before != nullptr) {
      std::copy(before->upperLayer().begin(), before->upperLayer().end(), slab.vertices.begin());
    }
    model::setMeans(shared, slab.vertices);
    if (shared.vertexCount > 0) putVertexAttributes(before, slab);
    for (std::uint32_t i = upTo(2); i > 0; --i) {
      slab.attributes.push_back(
          attribute("cell " + std::to_string(i), model::Domain::Cell, shared.cells.size()));
    }
    return slab;
  }

  std::mt19937 random_;
};

/// Whether two slabs are the same, bit for bit.
inline testing::AssertionResult same(const model::Slab& a, const model::Slab& b) {
  if (a.timeBegin != b.timeBegin || a.timeEnd != b.timeEnd) {
    return testing::AssertionFailure() << "times differ";
  }
  if (!(*a.connectivity == *b.connectivity)) {
    return testing::AssertionFailure() << "connectivities differ";
  }
  if (a.vertices.size() != b.vertices.size()) {
    return testing::AssertionFailure() << "numbers of vertices differ";
  }
  for (std::size_t i = 0; i < a.vertices.size(); ++i) {
    if (std::memcmp(a.vertices[i].data(), b.vertices[i].data(), sizeof(model::Point4)) != 0) {
      return testing::AssertionFailure()
             << "vertex " << i << " differs: " << a.vertices[i].transpose() << " and "
             << b.vertices[i].transpose();
    }
  }
  if (a.attributes != b.attributes) return testing::AssertionFailure() << "attributes differ";
  return testing::AssertionSuccess();
}

inline Metadata metadataOf(const std::vector<std::string>& bodies) {
  Metadata metadata;
  metadata.generator = "test";
  for (const std::string& body : bodies) metadata.bodies.push_back({body});
  return metadata;
}

/// A file of these slabs, one list per body; bodies alternate.
inline std::filesystem::path writeT4d(const std::string& name,
                                      const std::vector<std::vector<model::Slab>>& bodies,
                                      const T4dWriteOptions& options = {}) {
  const auto path = temporaryPath(name);
  std::vector<std::string> names;
  std::size_t longest = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    names.push_back("body " + std::to_string(i));
    longest = std::max(longest, bodies[i].size());
  }
  auto writer = T4dWriter::create(path, metadataOf(names), options);
  EXPECT_TRUE(writer) << writer.error().text();
  for (std::size_t k = 0; k < longest; ++k) {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (k >= bodies[i].size()) continue;
      const auto put = writer->body(i).put(bodies[i][k]);
      EXPECT_TRUE(put) << put.error().text();
    }
  }
  const auto finished = writer->finish();
  EXPECT_TRUE(finished) << finished.error().text();
  EXPECT_EQ(finished.value_or(0), std::filesystem::file_size(path));
  return path;
}

template <class T>
void overwrite(std::string& bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

/// Builds a file chunk by chunk, with valid checksums and arbitrary content.
class FileBuilder {
 public:
  explicit FileBuilder(const std::string& head = R"({"features":[],"bodies":[{"name":"b"}]})",
                       std::uint16_t major = t4d_layout::kMajorVersion,
                       std::uint16_t minor = t4d_layout::kMinorVersion, std::uint32_t flags = 0) {
    t4d_layout::ByteWriter header;
    header.putBytes(t4d_layout::kSignature.data(), t4d_layout::kSignature.size());
    header.put(major);
    header.put(minor);
    header.put(flags);
    header.put(std::uint32_t{0});
    header.put(platform::crc32c(header.data(), header.size()));
    append(header.bytes());
    t4d_layout::PayloadWriter payload;
    payload.putBytes(head.data(), head.size());
    put(t4d_layout::kHead, payload);
  }

  std::uint64_t put(t4d_layout::ChunkType type, const t4d_layout::PayloadWriter& payload,
                    std::uint32_t flags = t4d_layout::kFlagCritical) {
    const std::uint64_t offset = bytes_.size();
    const auto [header, front] = frontOf(type, payload, offset, flags);
    const ChunkHeaderBytes encoded = encodeChunkHeader(header);
    append(encoded);
    append(front.bytes());
    for (const auto& block : payload.blocks()) append(block.bytes());
    ++chunks_;
    return offset;
  }

  /// `offsets` as the slab that is put next names them.
  SlabParts fromHere(const SlabParts& offsets) const {
    const auto distance = [&](std::uint64_t offset) {
      return offset == 0 ? 0 : bytes_.size() - offset;
    };
    return {distance(offsets.connectivity), distance(offsets.lower), distance(offsets.upper),
            offsets.body};
  }

  /// The connectivity of simplexSlab(); returns offsets.
  SlabParts putSimplexConnectivity() {
    SlabParts parts;
    parts.connectivity =
        put(t4d_layout::kConnectivity, encodeConnectivity(*simplexSlab().connectivity, {0, false}));
    return parts;
  }
  std::uint64_t putSimplex(const SlabParts& parts, model::TimeSpan time = {0, 1}) {
    model::Slab slab = simplexSlab();
    slab.timeBegin = time.begin;
    slab.timeEnd = time.end;
    return put(t4d_layout::kSlab, encodeSlab(slab, fromHere(parts), {0, false}));
  }

  /// A correct end mark for `slabs` slabs in one body.
  void putDone(std::uint64_t slabs = 1, model::TimeSpan time = {0, 1}) {
    Done done;
    done.chunks = chunks_;
    done.bodies.resize(1);
    for (std::uint64_t i = 0; i < slabs; ++i) addSlab(done.bodies[0], simplexSlab());
    done.bodies[0].time = time;
    put(t4d_layout::kDone, encodeDone(done));
  }

  std::uint64_t chunks() const { return chunks_; }
  const std::string& bytes() const { return bytes_; }

 private:
  /// Appends a part, with the padding after it.
  void append(std::span<const std::byte> part) {
    bytes_.append(reinterpret_cast<const char*>(part.data()), part.size());
    bytes_.resize(t4d_layout::padded(bytes_.size()));
  }
  std::string bytes_;
  std::uint64_t chunks_ = 0;
};

/// `payload` with other fields, which `change` makes of its own.
template <class Change>
t4d_layout::PayloadWriter withFields(const t4d_layout::PayloadWriter& payload, Change change) {
  std::vector<std::byte> fields(payload.bytes().begin(), payload.bytes().end());
  change(fields);
  t4d_layout::PayloadWriter changed;
  changed.putBytes(fields.data(), fields.size());
  for (const auto& block : payload.blocks()) changed.putBlock(block);
  return changed;
}

/// The first error in opening a file and reading all of its slabs; empty if there is none.
inline std::string faultOf(const std::filesystem::path& path, T4dOpen how = T4dOpen::Whole) {
  auto reader = T4dReader::open(path, how);
  if (!reader) return reader.error().text();
  for (std::size_t i = 0; i < reader->bodyCount(); ++i) {
    for (std::size_t k = 0; k < reader->body(i).slabCount(); ++k) {
      const auto slab = reader->body(i).slab(k);
      if (!slab) return slab.error().text();
      // Every slab returned must be valid.
      EXPECT_TRUE(model::checkSlab(**slab));
      EXPECT_TRUE(model::checkConnectivity(*(*slab)->connectivity));
    }
  }
  return {};
}

/// The first error in reading the file as a stream; empty if there is none.
inline std::string streamFaultOf(const std::filesystem::path& path) {
  auto stream = T4dStream::open(path, kAnyCells);
  if (!stream) return stream.error().text();
  while (true) {
    const auto item = stream->next();
    if (!item) return item.error().text();
    if (!*item) return {};
    EXPECT_TRUE(model::checkSlab(*(*item)->slab));
  }
}

inline std::string faultOf(const FileBuilder& file) {
  return faultOf(writeFile("by_hand.t4d", file.bytes()));
}

}  // namespace t4d::formats

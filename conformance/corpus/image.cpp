#include "conformance/corpus/image.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/t4d/layout.h"
#include "platform/crc32c.h"

namespace t4d::conformance {

using namespace formats::t4d_layout;

namespace {

std::string textOf(const std::array<std::uint8_t, 8>& bytes) {
  return {bytes.begin(), bytes.end()};
}

std::string textOf(const ChunkType& type) { return {type.begin(), type.end()}; }

std::uint32_t checksumOf(std::string_view bytes) {
  return platform::crc32c(bytes.data(), bytes.size());
}

template <class Predicate>
bool hasSlab(const std::vector<BodySlabs>& bodies, Predicate predicate) {
  return std::ranges::any_of(
      bodies, [&](const BodySlabs& body) { return std::ranges::any_of(body.slabs, predicate); });
}

bool hasMeans(const model::Slab& slab) { return slab.connectivity->means.size() > 0; }
bool isPosed(const model::Slab& slab) { return slab.upperPose != nullptr; }

std::string headOf(const std::vector<BodySlabs>& bodies, const ImageOptions& options) {
  std::vector<std::string> features;
  if (hasSlab(bodies, hasMeans)) features.emplace_back(kFeatureMeans);
  if (options.storage != Storage::Raw) features.emplace_back(kFeatureZstd);
  if (hasSlab(bodies, isPosed)) features.emplace_back(kFeaturePose);
  if (options.grid) features.emplace_back(kFeatureGrid);
  std::vector<std::string> names;
  names.reserve(bodies.size());
  for (const BodySlabs& body : bodies) names.push_back(body.name);
  return headJson(features, names, options.grid ? gridJson(*options.grid) : "");
}

/// The parts that slabs of a body share with earlier ones.
struct Shared {
  std::shared_ptr<const std::vector<model::Point3>> reference;
  std::string referenceName;
  std::shared_ptr<const model::Connectivity> connectivity;
  std::string connectivityName;
  std::string upper;
};

}  // namespace

std::string gridJson(const formats::Grid& grid) {
  const nlohmann::json json = {{"origin", {grid.origin[0], grid.origin[1], grid.origin[2]}},
                               {"step", grid.step}};
  return "\"grid\":" + json.dump();
}

std::string headJson(const std::vector<std::string>& features,
                     const std::vector<std::string>& bodies, const std::string& more) {
  nlohmann::json list = nlohmann::json::array();
  for (const std::string& name : bodies) list.push_back({{"name", name}});
  return fmt::format(R"({{"features":{},"bodies":{}{}{}}})", nlohmann::json(features).dump(),
                     list.dump(), more.empty() ? "" : ",", more);
}

Image::Image(const std::string& head, const ImageOptions& options) : options_(options) {
  Record payload;
  payload.putBytes("json", head);
  add({"HEAD", textOf(kHead), payload, kFlagCritical, {}, {}, Chunk::Sum::None});
}

Image Image::of(const std::vector<BodySlabs>& bodies, const ImageOptions& options,
                const std::optional<std::string>& head) {
  Image image(head ? *head : headOf(bodies, options), options);
  std::vector<Shared> shared(bodies.size());
  std::size_t connectivities = 0;
  std::size_t layers = 0;
  std::size_t poses = 0;
  std::size_t slabs = 0;
  const auto layer = [&](double time, const model::Slab& slab, std::size_t first,
                         std::size_t count) -> std::string {
    if (count == 0) return "";
    std::string name = fmt::format("LAYR {}", layers++);
    image.addLayer(name, time, std::span(slab.vertices).subspan(first, count),
                   vertexRows(slab.attributes, first, count));
    return name;
  };
  std::size_t most = 0;
  for (const BodySlabs& body : bodies) most = std::max(most, body.slabs.size());
  for (std::size_t k = 0; k < most; ++k) {
    for (std::uint32_t i = 0; i < bodies.size(); ++i) {
      if (k >= bodies[i].slabs.size()) continue;
      const model::Slab& slab = bodies[i].slabs[k];
      Shared& before = shared[i];
      if (slab.connectivity != before.connectivity) {
        before.connectivity = slab.connectivity;
        before.connectivityName = fmt::format("CONN {}", connectivities++);
        image.addConnectivity(before.connectivityName, *slab.connectivity);
      }
      const model::Connectivity& counts = *slab.connectivity;
      const std::string lower =
          k == 0 ? layer(slab.timeBegin, slab, 0, counts.lowerCount) : before.upper;
      const std::uint32_t upper = counts.firstUpper();
      if (!slab.upperPose) {
        before.upper = layer(slab.timeEnd, slab, upper, counts.upperCount);
      } else {
        if (before.reference != slab.upperPose->reference) {
          before.reference = slab.upperPose->reference;
          model::Slab unmoved = slab;
          for (std::size_t v = 0; v < counts.upperCount; ++v) {
            unmoved.vertices[upper + v].head<3>() = (*before.reference)[v];
          }
          before.referenceName = layer(slab.timeEnd, unmoved, upper, counts.upperCount);
        }
        before.upper = before.referenceName;
        if (slab.upperPose->pose != model::Affine3x4::Identity()) {
          before.upper = fmt::format("POSE {}", poses++);
          image.addPose(before.upper, slab.timeEnd, slab.upperPose->pose, before.referenceName);
        }
      }
      image.addSlab(fmt::format("SLAB {}", slabs++), i, slab, before.connectivityName, lower,
                    before.upper);
    }
  }
  image.addEnd();
  return image;
}

void Image::add(Chunk chunk, const std::string& before) {
  const std::size_t at = before.empty() ? chunks_.size() : position(before);
  chunks_.insert(chunks_.begin() + static_cast<std::ptrdiff_t>(at), std::move(chunk));
}

void Image::addConnectivity(const std::string& name, const model::Connectivity& connectivity) {
  add({name,
       textOf(kConnectivity),
       connectivityRecord(connectivity, options_.storage),
       kFlagCritical,
       {},
       {},
       Chunk::Sum::None});
}

void Image::addLayer(const std::string& name, double time, std::span<const model::Point4> vertices,
                     std::span<const model::Attribute> attributes) {
  add({name,
       textOf(kLayer),
       layerRecord(time, vertices, attributes, options_.positions(), options_.storage),
       kFlagCritical,
       {},
       {},
       Chunk::Sum::None});
}

void Image::addPose(const std::string& name, double time, const model::Affine3x4& pose,
                    const std::string& layer) {
  add({name,
       textOf(kPose),
       poseRecord(time, pose),
       kFlagCritical,
       {{"layer", layer}},
       {},
       Chunk::Sum::None});
}

void Image::addSlab(const std::string& name, std::uint32_t body, const model::Slab& slab,
                    const std::string& connectivity, const std::string& lower,
                    const std::string& upper) {
  const model::Connectivity& shared = *slab.connectivity;
  const model::Slab stored =
      options_.positions().round() ? formats::roundedSlab(slab, options_.positions()) : slab;
  const auto interior =
      std::span(slab.vertices).subspan(shared.lowerCount, shared.firstMean() - shared.lowerCount);
  Chunk chunk{
      name,
      textOf(kSlab),
      slabRecord({slab.timeBegin, slab.timeEnd}, body,
                 options_.cellBounds ? formats::boundsOfBlocks(shared, stored.vertices)
                                     : std::vector<model::Bounds4>{},
                 interior, formats::ownAttributes(slab), options_.positions(), options_.storage),
      kFlagCritical,
      {{"connectivity", connectivity}},
      body,
      Chunk::Sum::None};
  if (!lower.empty()) chunk.offsets["lower"] = lower;
  if (!upper.empty()) chunk.offsets["upper"] = upper;
  chunk.extent = formats::extentOf(stored);
  add(std::move(chunk));
  if (summaries_.size() <= body) summaries_.resize(body + 1);
  formats::addSlab(summaries_[body], stored);
}

void Image::addEnd() {
  add({"DONE", textOf(kDone), {}, kFlagCritical, {}, {}, Chunk::Sum::Done});
  if (options_.index) {
    add({"INDX", textOf(kIndex), {}, kFlagCritical, {}, {}, Chunk::Sum::Index});
  }
}

std::size_t Image::position(const std::string& name) const {
  const auto found = std::find_if(chunks_.begin(), chunks_.end(),
                                  [&](const Chunk& chunk) { return chunk.name == name; });
  if (found == chunks_.end()) throw std::out_of_range("no chunk " + name);
  return static_cast<std::size_t>(found - chunks_.begin());
}

Image::Chunk& Image::chunk(const std::string& name) { return chunks_[position(name)]; }

void Image::remove(const std::string& name) {
  chunks_.erase(chunks_.begin() + static_cast<std::ptrdiff_t>(position(name)));
}

void Image::move(const std::string& name, const std::string& before) {
  Chunk moved = chunk(name);
  remove(name);
  add(std::move(moved), before);
}

void Image::setBytes(const std::string& place, std::string_view bytes, std::size_t at) {
  patches_.push_back({place, std::string(bytes), at, false});
}

void Image::flip(const std::string& place, std::size_t at) {
  patches_.push_back({place, "", at, true});
}

/// Applies the patches to PREFIX + FIELD; with `field`, only to that one; not to what `before` has.
void Image::patch(Record& record, const std::string& prefix, const std::string& field,
                  const Record& before) const {
  for (const Patch& patch : patches_) {
    if (!patch.place.starts_with(prefix)) continue;
    const std::string inner = patch.place.substr(prefix.size());
    if (!record.has(inner) || before.has(inner) || (!field.empty() && inner != field)) continue;
    if (patch.flip) {
      const char byte = record.contents(inner)[patch.at];
      record.overwrite(inner, std::string(1, static_cast<char>(byte ^ 1)), patch.at);
    } else {
      record.overwrite(inner, patch.bytes, patch.at);
    }
  }
}

Record Image::header() const {
  Record record;
  record.putBytes("signature", textOf(kSignature));
  record.put("major", kMajorVersion);
  record.put("minor", options_.minorVersion);
  record.put("flags", options_.index ? kFlagIndexed : std::uint32_t{0});
  record.put("reserved", std::uint32_t{0});
  patch(record, "file/");
  record.put("checksum", checksumOf(record.bytes()));
  patch(record, "file/", "checksum");
  return record;
}

Record Image::footer(std::uint64_t offset, const std::vector<std::uint64_t>& chunkOffsets,
                     std::uint32_t indexChecksum) const {
  const auto last = [&](const ChunkType& type) {
    std::uint64_t found = 0;
    for (std::size_t i = 0; i < chunks_.size(); ++i) {
      if (chunks_[i].type == textOf(type)) found = chunkOffsets[i];
    }
    return found;
  };
  Record record;
  record.put("index", last(kIndex));
  record.put("done", last(kDone));
  record.put("file length", offset + kFooterBytes);
  record.put("index checksum", indexChecksum);
  patch(record, "footer/");
  record.put("checksum", checksumOf(record.bytes()));
  patch(record, "footer/", "checksum");
  record.putBytes("end signature", textOf(kEndSignature));
  patch(record, "footer/", "end signature");
  return record;
}

Record Image::chunkHeader(const Chunk& chunk, const Payload& payload) const {
  const std::string prefix = chunk.name + "/header/";
  Record record;
  record.putBytes("type", chunk.type);
  record.put("flags", chunk.flags);
  record.put("length", std::uint64_t{payload.bytes.size()});
  record.put("front", static_cast<std::uint32_t>(payload.front));
  record.put("blocks", static_cast<std::uint32_t>(payload.blocks));
  record.put("front checksum", std::uint32_t{0});
  patch(record, prefix);
  const auto front = record.get<std::uint32_t>("front");
  record.overwrite("front checksum",
                   bytesOf(checksumOf(std::string_view(payload.bytes.bytes()).substr(0, front))));
  patch(record, prefix, "front checksum");
  record.put("header checksum", checksumOf(record.bytes()));
  patch(record, prefix, "header checksum");
  return record;
}

Record Image::donePayload(std::size_t chunksBefore,
                          const std::vector<formats::BodySummary>& summaries) {
  Record payload;
  payload.put("chunks", std::uint64_t{chunksBefore});
  payload.put("bodies", static_cast<std::uint32_t>(summaries.size()));
  payload.put("reserved", std::uint32_t{0});
  for (std::size_t i = 0; i < summaries.size(); ++i) {
    const formats::BodySummary& body = summaries[i];
    Record record;
    record.put("slabs", body.slabs);
    record.put("vertices", body.vertices);
    record.put("cells", body.tetrahedra);
    record.put("begin", body.time.begin);
    record.put("end", body.time.end);
    for (int k = 0; k < 3; ++k) record.put(fmt::format("minimum {}", k), body.bounds.min[k]);
    for (int k = 0; k < 3; ++k) record.put(fmt::format("maximum {}", k), body.bounds.max[k]);
    payload.add(fmt::format("body {}", i), record);
  }
  return payload;
}

Record Image::indexPayload(const std::vector<Indexed>& slabs, const std::string& headers) const {
  Record payload;
  payload.putBytes("file header", header().bytes().substr(0, kFileHeaderCopyBytes));
  payload.put("slabs", static_cast<std::uint32_t>(slabs.size()));
  std::string times;
  std::string parts;
  std::string bodies;
  std::string cells;
  std::string bounds;
  for (const auto& [slab, extent] : slabs) {
    times += slab.contents("begin") + slab.contents("end");
    parts += slab.contents("connectivity") + slab.contents("lower") + slab.contents("upper");
    bodies += slab.contents("body");
    cells += bytesOf(extent.cells);
    for (const model::Point3& corner : {extent.bounds.min, extent.bounds.max}) {
      for (const double coordinate : corner) bounds += bytesOf(coordinate);
    }
  }
  const auto addArray = [&](const char* name, model::ScalarType type, std::uint8_t components,
                            const std::string& bytes) {
    payload.add(name, arrayRecord(type, components, bytes, options_.storage));
  };
  payload.add("head", arrayRecord(model::ScalarType::UInt8, 1, headOfFile(), Storage::Raw));
  addArray("chunks", model::ScalarType::UInt8, kDirectoryEntryBytes, headers);
  addArray("times", model::ScalarType::Float64, 2, times);
  addArray("parts", model::ScalarType::UInt64, 3, parts);
  addArray("bodies", model::ScalarType::UInt32, 1, bodies);
  addArray("cells", model::ScalarType::UInt64, 1, cells);
  addArray("bounds", model::ScalarType::Float64, 6, bounds);
  return payload;
}

/// The payload of HEAD.
std::string Image::headOfFile() const {
  for (const Chunk& chunk : chunks_) {
    if (chunk.type != textOf(kHead)) continue;
    Record payload = chunk.payload;
    patch(payload, chunk.name + "/");
    return payload.bytes();
  }
  return "";
}

Image::Payload Image::finished(const Chunk& chunk, const Record& fields) const {
  Payload payload{fields.asPayload(), fields.frontSize(), fields.blocks().size()};
  patch(payload.bytes, chunk.name + "/", "", fields);
  return payload;
}

std::vector<Image::Laid> Image::layOut() const {
  // Sizes do not depend on the offsets that are filled in, but for that of INDX, the last chunk.
  std::vector<std::uint64_t> offsets = {kFileHeaderBytes};
  for (const Chunk& chunk : chunks_) {
    const std::size_t size = chunk.sum == Chunk::Sum::Done
                                 ? 16 + summaries_.size() * kBodySummaryBytes
                                 : chunk.payload.asPayload().size();
    offsets.push_back(offsets.back() + kChunkHeaderBytes + padded(size));
  }
  std::vector<Laid> laid;
  std::vector<formats::BodySummary> summaries = summaries_;
  std::vector<bool> begun(summaries.size());
  std::vector<Indexed> slabs;
  std::string headers;
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    const Chunk& chunk = chunks_[i];
    Record fields = chunk.payload;
    for (const auto& [field, name] : chunk.offsets) {
      fields.overwrite(field, bytesOf(offsets[i] - offsets[position(name)]));
    }
    if (chunk.sum == Chunk::Sum::Done) fields = donePayload(i, summaries);
    if (chunk.sum == Chunk::Sum::Index) fields = indexPayload(slabs, headers);
    patch(fields, chunk.name + "/");
    if (chunk.slabOf) {
      slabs.push_back({fields, chunk.extent});
      model::TimeSpan& time = summaries[*chunk.slabOf].time;
      if (!begun[*chunk.slabOf]) time.begin = fields.get<double>("begin");
      begun[*chunk.slabOf] = true;
      time.end = fields.get<double>("end");
    }
    Payload payload = finished(chunk, fields);
    Record header = chunkHeader(chunk, payload);
    if (chunk.type != textOf(kIndex)) {
      headers += header.bytes().substr(0, kDirectoryEntryBytes);
    }
    laid.push_back({std::move(fields), std::move(payload), std::move(header)});
  }
  return laid;
}

Record Image::assemble() const {
  const std::vector<Laid> all = layOut();
  Record file;
  file.add("file", header());
  std::vector<std::uint64_t> offsets;
  std::uint32_t indexChecksum = 0;
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    const std::string& name = chunks_[i].name;
    offsets.push_back(file.size());
    if (chunks_[i].type == textOf(kIndex)) {
      indexChecksum = all[i].header.get<std::uint32_t>("header checksum");
    }
    file.add(name + "/header", all[i].header);
    file.add(name, all[i].payload.bytes);
    file.pad(name + "/padding");
    patch(file, "", name + "/padding");
  }
  if (options_.index) file.add("footer", footer(file.size(), offsets, indexChecksum));
  return file;
}

void Image::freeze(const std::string& name) {
  Chunk& frozen = chunk(name);
  frozen.payload = layOut()[position(name)].fields;
  frozen.sum = Chunk::Sum::None;
}

}  // namespace t4d::conformance

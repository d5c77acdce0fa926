#include "formats/t4d/merge.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "formats/t4d/body_details.h"
#include "formats/t4d/file_copy.h"
#include "formats/t4d/metadata.h"
#include "formats/t4d/names.h"
#include "formats/t4d/within_memory.h"
#include "model/progress.h"
#include "platform/crc32c.h"

namespace t4d::formats {
namespace {

using nlohmann::ordered_json;

std::string orUnknown(const std::string& text) { return text.empty() ? "unknown" : text; }

/// Gives a SLAB another body. Its blocks stay as they are.
void assignBody(std::uint32_t body, ChunkHeader& header, std::span<std::byte> payload) {
  constexpr std::size_t kBodyInFields = 40;
  std::memcpy(payload.data() + header.blocks * t4d_layout::kBlockEntryBytes + kBodyInFields, &body,
              sizeof body);
  header.frontCrc = platform::crc32c(payload.data(), header.frontBytes);
}

/// Copies a chunk; the bodies of its file have numbers from `firstBody` on.
Result<void> putChunk(ChunkFile::Chunk& chunk, const IndexRecord* slab, std::uint32_t firstBody,
                      ChunkWriter& into) {
  if (slab != nullptr && firstBody > 0) {
    assignBody(slab->parts.body + firstBody, chunk.header, chunk.payload.bytes);
  }
  const auto offset = into.putCopy(chunk.header, chunk.payload.bytes);
  if (!offset) return offset.error();
  if (slab == nullptr) return {};
  SlabParts parts = slab->parts;
  parts.body += firstBody;
  into.addSlab({*offset, slab->slabBytes, parts, slab->time, slab->extent});
  return {};
}

class Merger {
 public:
  /// Reads a file through, and checks that it fits those before.
  Result<void> add(const std::filesystem::path& path, const model::Progress& progress) {
    auto file = readForCopy(path, chunks_, progress);
    if (!file) return file.error();
    for (const CopiedFile& before : files_) {
      if (auto fits = checkFit(*file, before); !fits) return fits;
    }
    if (file->bodies.size() > t4d_layout::kMaxBodies - report_.bodies.size()) {
      return invalid(
          fmt::format("has {} bodies, after {} of the files before it; a file has at "
                      "most {}",
                      file->bodies.size(), report_.bodies.size(), t4d_layout::kMaxBodies),
          path.string());
    }
    addBodies(*file);
    files_.push_back(std::move(*file));
    return {};
  }

  Result<MergeReport> write(const std::filesystem::path& into, const model::Progress& progress) {
    auto chunks = beginCopy(into, metadata(), files_);
    if (!chunks) return chunks.error();
    std::uint64_t done = 0;
    const auto one = [&] { return model::report(progress, ++done, chunks_.chunks.size()); };
    CopyState state;
    std::uint32_t firstBody = 0;
    for (const CopiedFile& file : files_) {
      auto opened = ChunkFile::open(file.path);
      if (!opened) return opened.error();
      const auto put = [&](ChunkFile::Chunk& chunk, const IndexRecord* slab) {
        return putChunk(chunk, slab, firstBody, *chunks);
      };
      if (auto copied = copyChunks(*opened, file, chunks_, put, state, one); !copied) {
        return copied.error();
      }
      firstBody += static_cast<std::uint32_t>(file.bodies.size());
    }
    std::vector<BodySummary> summaries;
    for (const MergeReport::Body& body : report_.bodies) summaries.push_back(body.summary);
    auto bytes = chunks->finish(summaries);
    if (!bytes) return bytes.error();
    report_.bytes = *bytes;
    for (std::string& line : state.lost.lines()) report_.losses.push_back(std::move(line));
    return std::move(report_);
  }

 private:
  static Result<void> checkFit(const CopiedFile& file, const CopiedFile& before) {
    const Metadata& one = before.metadata();
    const Metadata& other = file.metadata();
    const auto unfit = [&](const char* what, const std::string& found,
                           const std::string& expected) {
      return invalid(
          fmt::format("cannot be merged: its {} is {}, and that of {} is {}; convert one "
                      "of them first",
                      what, orUnknown(found), before.path.string(), orUnknown(expected)),
          file.path.string(), Remedy::Units);
    };
    if (one.lengthUnit != other.lengthUnit) {
      return unfit("unit of length", other.lengthUnit, one.lengthUnit);
    }
    if (one.timeUnit != other.timeUnit) return unfit("unit of time", other.timeUnit, one.timeUnit);
    if (one.up != other.up) return unfit("upward axis", other.up, one.up);
    if (one.space != other.space) return unfit("space", other.space, one.space);
    if (one.grid && other.grid && one.grid != other.grid) {
      return invalid(fmt::format("cannot be merged: the grid of its positions is not that of {}; "
                                 "write both with the same step, or one of them without",
                                 before.path.string()),
                     file.path.string());
    }
    if (const auto name = differingAttribute(one, other)) {
      return invalid(fmt::format("cannot be merged: its attribute '{}' is of another kind or unit "
                                 "than that of {}; leave it out of one of them",
                                 *name, before.path.string()),
                     file.path.string());
    }
    return {};
  }

  void addBodies(const CopiedFile& file) {
    std::map<std::string, std::string> renamed;
    std::vector<BodyInfo> added = file.metadata().bodies;
    std::vector<std::string> links;
    for (BodyInfo& body : added) {
      links.push_back(linkOf(body));
      const std::string name = uniqueName(body.name);
      if (name != body.name) {
        report_.notices.push_back(
            fmt::format("{}: the body '{}' is named '{}', since there is one "
                        "of that name before it",
                        file.path.string(), body.name, name));
      }
      renamed[body.name] = name;
      body.name = name;
    }
    for (std::size_t i = 0; i < added.size(); ++i) {
      const auto parent = renamed.find(added[i].parent);
      if (parent != renamed.end()) added[i].parent = parent->second;
      const auto link = renamed.find(links[i]);
      if (link != renamed.end() && link->second != added[i].name) setLink(added[i], link->second);
      report_.bodies.push_back({added[i].name, files_.size(), file.bodies[i]});
      infos_.push_back(std::move(added[i]));
    }
  }

  std::string uniqueName(const std::string& name) {
    std::string unique = name;
    for (int i = 2; !names_.insert(unique).second; ++i) {
      const std::string number = fmt::format(" {}", i);
      // Cut before the number, if the name is as long as names can be.
      unique = asName(name.substr(0, t4d_layout::kMaxNameBytes - number.size())) + number;
    }
    return unique;
  }

  /// The metadata of the merged file. What each file says of how it was made is kept under
  /// `merged`.
  Metadata metadata() {
    std::vector<Metadata> all;
    std::vector<std::string> backends;
    ordered_json merged = ordered_json::array();
    for (const CopiedFile& file : files_) {
      all.push_back(file.metadata());
      all.back().bodies.clear();
      merged.push_back({{"file", asName(file.path.filename().string())},
                        {"details", ordered_json::parse(all.back().detailsJson)}});
      const std::string& backend = all.back().backend;
      if (std::ranges::find(backends, backend) == backends.end()) backends.push_back(backend);
    }
    std::vector<const Metadata*> pointers;
    for (const Metadata& one : all) pointers.push_back(&one);
    Metadata joined = joinedMetadata(pointers, report_.losses);
    joined.backend = fmt::format("{}", fmt::join(backends, ", "));
    joined.bodies = infos_;
    joined.detailsJson = ordered_json{{"merged", merged}}.dump(
        -1, ' ', false, ordered_json::error_handler_t::replace);
    return joined;
  }

  std::vector<CopiedFile> files_;
  CopiedChunks chunks_;
  std::vector<BodyInfo> infos_;
  std::set<std::string> names_;
  MergeReport report_;
};

}  // namespace

Result<MergeReport> mergeT4d(const std::vector<std::filesystem::path>& files,
                             const std::filesystem::path& into, const model::Progress& progress) {
  if (files.empty()) return invalid("no file is to be merged");
  // The share of the work that reading through takes; copying is the rest.
  constexpr double kReading = 0.5;
  Merger merger;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto reading = model::eachOf(model::partOf(progress, 0, kReading), i, files.size());
    const auto added =
        withinMemory(files[i].string(), [&] { return merger.add(files[i], reading); });
    if (!added) return added.error();
  }
  return withinMemory(into.string(),
                      [&] { return merger.write(into, model::partOf(progress, kReading, 1)); });
}

}  // namespace t4d::formats

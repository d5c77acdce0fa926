#include <algorithm>
#include <deque>
#include <mutex>
#include <set>

#include <fmt/format.h>

#include "formats/t4d/cell_limit.h"
#include "formats/t4d/chunks.h"
#include "formats/t4d/grouped_body.h"
#include "formats/t4d/join.h"
#include "formats/t4d/manifest.h"
#include "formats/t4d/metadata.h"
#include "formats/t4d/reader_file.h"
#include "formats/t4d/url.h"
#include "platform/crc32c.h"

namespace t4d::formats {
namespace {

using FilePointer = std::shared_ptr<const T4dReader::File>;

/// The parts of a file, each opened when it is needed first. Safe from several threads at once.
class OpenParts {
 public:
  OpenParts(Manifest manifest, std::string name)
      : manifest_(std::move(manifest)),
        name_(std::move(name)),
        files_([this](std::size_t number) { return open(number); }) {}
  OpenParts(const OpenParts&) = delete;
  OpenParts& operator=(const OpenParts&) = delete;

  const Manifest& manifest() const { return manifest_; }
  const std::string& name() const { return name_; }

  /// Fails if it is not the part that the manifest describes.
  Result<FilePointer> get(std::size_t number) const { return files_.get(number); }

  std::uint64_t bytesRead() const { return sum(&T4dReader::File::bytesRead, closed_->bytes); }
  std::uint64_t requests() const { return sum(&T4dReader::File::requests, closed_->requests); }

 private:
  /// Sums over parts that are closed again.
  struct Closed {
    std::mutex mutex;
    std::uint64_t bytes = 0;
    std::uint64_t requests = 0;
  };

  Result<FilePointer> open(std::size_t number) const {
    const ManifestPart& part = manifest_.parts[number];
    auto source = openPart(part, name_);
    if (!source) return source.error();
    auto opened = T4dReader::File::openOne(std::move(*source), T4dOpen::Whole, {}, kAnyCells);
    if (!opened) return inPart(opened.error(), part, name_);
    if (auto same = checkPart(part, **opened); !same) return same.error();
    return FilePointer(opened->release(), [closed = closed_](const T4dReader::File* file) {
      const std::scoped_lock lock(closed->mutex);
      closed->bytes += file->bytesRead();
      closed->requests += file->requests();
      delete file;
    });
  }

  Result<void> checkPart(const ManifestPart& part, const T4dReader::File& file) const {
    const auto other = [&](const std::string& message) {
      return invalid(fmt::format("is not the part that {} describes: {}", name_, message),
                     file.name());
    };
    const Metadata& own = file.metadata();
    const Metadata& all = manifest_.metadata;
    if (!std::ranges::equal(own.bodies, all.bodies, {}, &BodyInfo::name, &BodyInfo::name)) {
      return other("its bodies have other names");
    }
    if (own.lengthUnit != all.lengthUnit || own.timeUnit != all.timeUnit || own.up != all.up ||
        own.space != all.space) {
      return other("its units, its space, or the axis that points up, are others");
    }
    for (std::size_t i = 0; i < part.bodies.size(); ++i) {
      if (auto same = checkSummary(part.bodies[i].summary, file.summary(i)); !same) {
        return other(fmt::format("body '{}': {}", own.bodies[i].name, same.error().message));
      }
    }
    return {};
  }

  std::uint64_t sum(std::uint64_t (T4dReader::File::*of)() const,
                    const std::uint64_t& closed) const {
    std::uint64_t sum = 0;
    files_.each([&](const T4dReader::File& file) { sum += (file.*of)(); });
    const std::scoped_lock lock(closed_->mutex);
    return sum + closed;
  }

  Manifest manifest_;
  std::string name_;
  std::shared_ptr<Closed> closed_ = std::make_shared<Closed>();
  OpenThings<T4dReader::File> files_;
};

/// The slabs of one body, in all parts.
GroupedBody bodyOf(const OpenParts& parts, std::size_t body) {
  std::vector<model::SlabGroup> groups;
  std::size_t next = 0;
  for (const ManifestPart& part : parts.manifest().parts) {
    const BodySummary& summary = part.bodies[body].summary;
    groups.push_back({next, next + summary.slabs, summary.time, summary.bounds});
    next += summary.slabs;
  }
  const auto open = [&parts,
                     body](std::size_t part) -> Result<std::shared_ptr<const model::Source>> {
    const auto file = parts.get(part);
    if (!file) return file.error();
    return std::shared_ptr<const model::Source>(*file, &(*file)->body(body));
  };
  return {std::move(groups), open};
}

/// Passes on the optional chunks of all parts, those with the same header once.
OptionalChunks::Walk walkOf(const OpenParts& parts) {
  return [&parts](const OptionalChunks::Take& take) -> Result<void> {
    const auto hasSome = [](const ManifestPart& part) {
      return std::ranges::any_of(part.chunks, [](const T4dChunks& chunks) {
        t4d_layout::ChunkType type{};
        std::ranges::copy_n(chunks.type.begin(),
                            static_cast<std::ptrdiff_t>(std::min(type.size(), chunks.type.size())),
                            type.begin());
        return isUnknown(type);
      });
    };
    std::set<ChunkHeaderBytes> taken;
    for (std::size_t i = 0; i < parts.manifest().parts.size(); ++i) {
      if (!hasSome(parts.manifest().parts[i])) continue;
      const auto file = parts.get(i);
      if (!file) return file.error();
      auto walked = (*file)->optionalChunks().each([&](const ChunkFile& from,
                                                       const ChunkHeader& header) -> Result<void> {
        return taken.insert(encodeChunkHeader(header)).second ? take(from, header) : Result<void>();
      });
      if (!walked) return walked;
    }
    return {};
  };
}

class PartedFile : public T4dReader::File {
 public:
  PartedFile(Manifest manifest, std::string name)
      : parts_(std::move(manifest), std::move(name)), optional_(walkOf(parts_)) {
    for (std::size_t i = 0; i < metadata().bodies.size(); ++i) {
      bodies_.push_back(bodyOf(parts_, i));
      summaries_.push_back(parts_.manifest().summary(i));
    }
    for (const ManifestPart& part : parts_.manifest().parts) {
      for (const T4dChunks& each : part.chunks) add(each);
    }
  }

  Result<void> checkCells(std::optional<std::uint64_t> maxCells) const {
    std::uint64_t cells = 0;
    for (const BodySummary& body : summaries_) cells += body.tetrahedra;
    return checkCellCount(name(), fileBytes(), cells, maxCells);
  }

  /// Compares all of every part with what the manifest says of it.
  Result<void> check(const model::Progress& progress) const {
    const std::vector<ManifestPart>& said = parts_.manifest().parts;
    std::vector<std::filesystem::path> places;
    for (std::size_t i = 0; i < said.size(); ++i) {
      if (const auto opened = parts_.get(i); !opened) return opened.error();
      places.push_back(said[i].place);
    }
    const auto found = describeParts(places, progress);
    if (!found) return found.error();
    for (std::size_t i = 0; i < said.size(); ++i) {
      if (auto same = checkSame(said[i], found->parts[i]); !same) return same;
    }
    return {};
  }

  T4dVersion version() const override {
    return {t4d_layout::kMajorVersion, minorVersionFor(metadata())};
  }
  const Metadata& metadata() const override { return parts_.manifest().metadata; }
  bool indexed() const override { return true; }
  const std::string& name() const override { return parts_.name(); }
  std::uint64_t fileBytes() const override { return parts_.manifest().bytes(); }
  std::uint32_t fingerprint() const override {
    std::string footers;
    for (const ManifestPart& part : parts_.manifest().parts) footers += part.footer;
    return platform::crc32c(footers.data(), footers.size());
  }
  std::uint64_t bytesRead() const override { return parts_.bytesRead(); }
  std::uint64_t requests() const override { return parts_.requests(); }
  const std::vector<T4dChunks>& chunks() const override { return chunks_; }
  const OptionalChunks& optionalChunks() const override { return optional_; }
  const BodySummary& summary(std::size_t body) const override { return summaries_[body]; }
  const model::Source& body(std::size_t index) const override { return bodies_[index]; }
  std::uint64_t slabOffset(std::size_t body, std::size_t slab) const override {
    const auto [part, number] = bodies_[body].placeOf(slab);
    const auto file = parts_.get(part);
    return file ? (*file)->slabOffset(body, number) : 0;
  }
  Result<T4dSlab> slabContents(std::size_t body, std::size_t slab) const override {
    const auto [part, number] = bodies_[body].placeOf(slab);
    const auto file = parts_.get(part);
    if (!file) return file.error();
    return (*file)->slabContents(body, number);
  }
  const std::optional<Error>& damage() const override { return damage_; }
  Result<void> checkSummary(std::size_t body, const BodySummary& found) const override {
    auto checked = formats::checkSummary(summaries_[body], found);
    if (checked) return checked;
    return invalid(fmt::format("body {}: {}", body, checked.error().message), name());
  }

 private:
  void add(const T4dChunks& more) {
    const auto known = std::ranges::find(chunks_, more.type, &T4dChunks::type);
    T4dChunks& sum = known == chunks_.end() ? chunks_.emplace_back(T4dChunks{more.type}) : *known;
    sum.count += more.count;
    sum.bytes += more.bytes;
  }

  Result<void> checkSame(const ManifestPart& said, const ManifestPart& found) const {
    const auto other = [&](const std::string& what) {
      return invalid(fmt::format("is not the part that {} describes: {}", name(), what),
                     shownName(said.place.string()));
    };
    if (said.sha256 != found.sha256) return other("its SHA-256 is " + found.sha256);
    const auto same = [](const T4dChunks& a, const T4dChunks& b) {
      return a.type == b.type && a.count == b.count && a.bytes == b.bytes;
    };
    if (!std::ranges::equal(said.chunks, found.chunks, same)) return other("its chunks are others");
    for (std::size_t i = 0; i < said.bodies.size(); ++i) {
      if (said.bodies[i].shared == found.bodies[i].shared) continue;
      return other(fmt::format("body '{}' shares {} vertices with the part before, not {}",
                               metadata().bodies[i].name, found.bodies[i].shared,
                               said.bodies[i].shared));
    }
    return {};
  }

  OpenParts parts_;
  OptionalChunks optional_;
  std::deque<GroupedBody> bodies_;
  std::vector<BodySummary> summaries_;
  std::vector<T4dChunks> chunks_;
  std::optional<Error> damage_;
};

}  // namespace

Result<std::unique_ptr<T4dReader::File>> T4dReader::File::openParts(
    const std::filesystem::path& pathOrUrl, T4dOpen how, const model::Progress& progress,
    std::optional<std::uint64_t> maxCells) {
  const std::string name = shownName(pathOrUrl.string());
  auto manifest = readManifest(pathOrUrl);
  if (!manifest) return manifest.error();
  if (how == T4dOpen::FromFront) {
    return fail(ErrorCode::Unsupported, "is a file in parts; read the parts one by one", name);
  }
  if (auto there = checkPartsAreThere(*manifest, name); !there) return there.error();
  auto file = std::make_unique<PartedFile>(std::move(*manifest), name);
  if (auto few = file->checkCells(maxCells); !few) return few.error();
  if (how == T4dOpen::Checked) {
    if (auto sound = file->check(progress); !sound) return sound.error();
  }
  return file;
}

}  // namespace t4d::formats

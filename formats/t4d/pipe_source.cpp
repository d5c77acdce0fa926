#include "formats/t4d/pipe_source.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <mutex>

namespace t4d::formats {

struct PipeSource::Kept {
  std::mutex mutex;
  std::uint64_t end = 0;                                  // of what was read
  std::map<std::uint64_t, std::vector<std::byte>> reads;  // by their offsets
  std::vector<std::byte> ahead;                           // received, and not read yet
  std::size_t aheadBegin = 0;
  bool atEnd = false;
};

Result<std::unique_ptr<PipeSource>> PipeSource::open(const std::filesystem::path& path) {
  auto file = platform::OpenFile::open(path);
  if (!file) return file.error();
  std::unique_ptr<PipeSource> source(new PipeSource(std::move(*file)));
  if (auto filled = source->fill(); !filled) return filled.error();
  return source;
}

PipeSource::PipeSource(platform::OpenFile file)
    : file_(std::move(file)), kept_(std::make_unique<Kept>()) {}

PipeSource::~PipeSource() = default;

std::uint64_t PipeSource::size() const {
  const std::scoped_lock lock(kept_->mutex);
  return kept_->atEnd ? kept_->end + kept_->ahead.size() - kept_->aheadBegin : kUnknownSize;
}

std::uint64_t PipeSource::bytesRead() const {
  const std::scoped_lock lock(kept_->mutex);
  return kept_->end;
}

void PipeSource::plan(std::span<const ByteRange> /*ranges*/) {
  const std::scoped_lock lock(kept_->mutex);
  // An error is reported when the bytes are read.
  if (kept_->aheadBegin == kept_->ahead.size()) (void)fill();
}

/// Waits for bytes, or the end.
Result<void> PipeSource::fill() {
  constexpr std::size_t kMost = std::size_t{1} << 18;
  kept_->ahead.resize(kMost);
  kept_->aheadBegin = 0;
  const auto got = file_.read(kept_->ahead);
  kept_->ahead.resize(got ? *got : 0);
  if (!got) return got.error();
  kept_->atEnd = *got == 0;
  return {};
}

Result<void> PipeSource::read(std::uint64_t offset, std::span<std::byte> into) {
  if (into.empty()) return {};
  const std::scoped_lock lock(kept_->mutex);
  if (offset != kept_->end) {
    const auto next = kept_->reads.upper_bound(offset);
    if (next != kept_->reads.begin()) {
      const auto& [begin, bytes] = *std::prev(next);
      if (offset + into.size() <= begin + bytes.size()) {
        std::memcpy(into.data(), bytes.data() + (offset - begin), into.size());
        return {};
      }
    }
    return fail(ErrorCode::Failed, "comes through a pipe, and cannot be read again", name());
  }
  std::vector<std::byte> bytes(into.size());
  for (std::size_t have = 0; have < bytes.size();) {
    if (kept_->aheadBegin == kept_->ahead.size()) {
      if (auto filled = fill(); !filled) return filled;
    }
    if (kept_->atEnd) {
      const std::uint64_t end = kept_->end + have;
      return Error{ErrorCode::InvalidInput,
                   "the file ends here, before the end of what it says comes: it is truncated",
                   placeOfByte(name(), end), end};
    }
    const std::size_t some = std::min(bytes.size() - have, kept_->ahead.size() - kept_->aheadBegin);
    std::memcpy(bytes.data() + have, kept_->ahead.data() + kept_->aheadBegin, some);
    kept_->aheadBegin += some;
    have += some;
  }
  std::ranges::copy(bytes, into.begin());
  kept_->end += bytes.size();
  kept_->reads.emplace(offset, std::move(bytes));
  return {};
}

void PipeSource::forgetAllBut(std::span<const ByteRange> ranges) {
  const std::scoped_lock lock(kept_->mutex);
  std::erase_if(kept_->reads, [&](const auto& read) {
    const auto range = std::ranges::upper_bound(ranges, read.first, {}, &ByteRange::begin);
    return range == ranges.begin() || read.first >= std::prev(range)->end;
  });
}

}  // namespace t4d::formats

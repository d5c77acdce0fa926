#include "formats/t4d/http_source.h"

#include <algorithm>
#include <cstring>
#include <mutex>
#include <vector>

#include <fmt/format.h>

#include "t4d/file.h"

namespace t4d::formats {

namespace {

/// The size of the end of a file that has footer, INDX and DONE of most files.
constexpr std::uint64_t kTailBytes = std::uint64_t{256} << 10;
/// The least bytes to fetch where nothing is planned.
constexpr std::uint64_t kLeastBytes = std::uint64_t{64} << 10;
/// A request takes longer than as many bytes between two planned ranges.
constexpr std::uint64_t kLargestGap = std::uint64_t{64} << 10;
/// The most bytes of one request, and of what is kept.
constexpr std::uint64_t kMostBytes = std::uint64_t{64} << 20;

class HttpSource : public ByteSource {
 public:
  HttpSource(const std::string& url, HttpTimeouts timeouts) : client_(url, timeouts) {}

  Result<void> open() {
    auto part = client_.get(fmt::format("-{}", kTailBytes), kTailBytes, {});
    if (!part) return part.error();
    const ByteRange all = {part->total - std::min(part->total, kTailBytes), part->total};
    if (part->range.begin != all.begin || part->range.end != all.end) {
      return refused("the last", all, *part);
    }
    size_ = part->total;
    etag_ = part->etag;
    lastModified_ = part->lastModified;
    pieces_.push_back({part->range, std::move(part->bytes)});
    return {};
  }

  const std::string& name() const override { return client_.name(); }
  std::uint64_t size() const override { return size_; }
  bool sizeIsCertain() const override { return false; }
  bool remote() const override { return true; }

  std::uint64_t bytesRead() const override {
    const std::scoped_lock lock(mutex_);
    return client_.bytesReceived();
  }
  std::uint64_t requests() const override {
    const std::scoped_lock lock(mutex_);
    return client_.requests();
  }

  void plan(std::span<const ByteRange> ranges) override {
    std::vector<ByteRange> sorted(ranges.begin(), ranges.end());
    std::ranges::sort(sorted, {}, &ByteRange::begin);
    const std::scoped_lock lock(mutex_);
    planned_.clear();
    for (const ByteRange& range : sorted) {
      if (range.begin == range.end) continue;
      if (!planned_.empty() && range.begin <= planned_.back().end + kLargestGap) {
        planned_.back().end = std::max(planned_.back().end, range.end);
      } else {
        planned_.push_back(range);
      }
    }
  }

  Result<void> read(std::uint64_t offset, std::span<std::byte> into) override {
    const std::scoped_lock lock(mutex_);
    while (!into.empty()) {
      const auto piece = std::ranges::find_if(pieces_, [&](const Piece& candidate) {
        return candidate.range.begin <= offset && offset < candidate.range.end;
      });
      if (piece == pieces_.end()) {
        if (auto fetched = fetch(offset, into.size()); !fetched) return fetched;
        continue;
      }
      const std::size_t bytes = std::min<std::uint64_t>(into.size(), piece->range.end - offset);
      std::memcpy(into.data(), piece->bytes.data() + (offset - piece->range.begin), bytes);
      into = into.subspan(bytes);
      offset += bytes;
    }
    return {};
  }

 private:
  struct Piece {
    ByteRange range;
    std::vector<std::byte> bytes;
  };

  /// Fetches the byte at `at`, which is not kept, and what is planned with it.
  Result<void> fetch(std::uint64_t at, std::uint64_t wanted) {
    ByteRange range = {at, at + std::clamp(wanted, kLeastBytes, kMostBytes)};
    for (const ByteRange& planned : planned_) {
      if (at < planned.begin || at >= planned.end) continue;
      range.begin = at - (at - planned.begin) % kMostBytes;
      range.end = std::min(range.begin + kMostBytes, planned.end);
    }
    range.end = std::min(range.end, size_);
    for (const Piece& piece : pieces_) {
      if (piece.range.end <= at) range.begin = std::max(range.begin, piece.range.end);
      if (piece.range.begin > at) range.end = std::min(range.end, piece.range.begin);
    }
    const std::uint64_t bytes = range.end - range.begin;
    const bool strong = etag_.starts_with('"');
    auto part = client_.get(fmt::format("{}-{}", range.begin, range.end - 1), bytes,
                            strong ? etag_ : std::string());
    if (!part) return part.error();
    if (part->total != size_ || part->etag != etag_ || part->lastModified != lastModified_) {
      return fail(ErrorCode::Io, "the file has changed while it was read; start again", name());
    }
    if (part->range.begin != range.begin || part->range.end != range.end) {
      return refused("the", range, *part);
    }
    pieces_.push_back({range, std::move(part->bytes)});
    // The first is the end of the file, which has the index.
    std::uint64_t kept = 0;
    for (std::size_t i = pieces_.size(); i-- > 1;) {
      kept += pieces_[i].bytes.size();
      if (kept <= kMostBytes || i + 1 == pieces_.size()) continue;
      pieces_.erase(pieces_.begin() + 1, pieces_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
      break;
    }
    return {};
  }

  Error refused(const char* which, const ByteRange& asked, const HttpPart& part) const {
    return fail(
        ErrorCode::Io,
        fmt::format("{} bytes from {} to {} of {} were requested; the server sends those "
                    "from {} to {}",
                    which, asked.begin, asked.end, part.total, part.range.begin, part.range.end),
        name());
  }

  mutable std::mutex mutex_;
  HttpClient client_;
  std::uint64_t size_ = 0;
  std::string etag_;
  std::string lastModified_;
  std::vector<ByteRange> planned_;  // sorted, apart
  std::vector<Piece> pieces_;       // disjoint, oldest first but for the end of the file
};

}  // namespace

Result<std::unique_ptr<ByteSource>> openHttpSource(const std::string& url, HttpTimeouts timeouts) {
  auto source = std::make_unique<HttpSource>(url, timeouts);
  if (auto opened = source->open(); !opened) return opened.error();
  return source;
}

void readUrls() {
  setUrlOpener([](const std::string& url) { return openHttpSource(url); });
}

}  // namespace t4d::formats

#include "voxel4d/volumes/sample_reader.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <utility>

#include <fmt/format.h>

#include "model/number.h"
#include "model/parallel.h"
#include "platform/open_file.h"
#include "platform/regular_file.h"
#include "voxel4d/volumes/gzip_stream.h"

namespace t4d::voxel4d {
namespace {

class RawReader : public SampleReader {
 public:
  RawReader(platform::OpenFile file, std::uint64_t begin, std::uint64_t end)
      : file_(std::move(file)), at_(begin), end_(end) {}

  Result<void> read(std::span<std::byte> into) override {
    constexpr std::size_t kWindow = std::size_t{1} << 16U;
    while (!into.empty()) {
      if (at_ < windowBegin_ || at_ >= windowBegin_ + window_.size()) {
        if (at_ >= end_) return invalid("is cut off: it ends before its samples do", file_.name());
        if (into.size() >= kWindow) {
          const auto part = into.first(std::min<std::uint64_t>(into.size(), end_ - at_));
          if (auto filled = fill(part); !filled) return filled;
          at_ += part.size();
          into = into.subspan(part.size());
          continue;
        }
        window_.resize(std::min<std::uint64_t>(kWindow, end_ - at_));
        windowBegin_ = at_;
        if (auto filled = fill(window_); !filled) return filled;
      }
      const auto here = std::span(window_).subspan(at_ - windowBegin_);
      const std::size_t part = std::min(here.size(), into.size());
      std::ranges::copy(here.first(part), into.begin());
      at_ += part;
      into = into.subspan(part);
    }
    return {};
  }
  Result<void> skip(std::uint64_t bytes) override {
    at_ += bytes;
    return {};
  }
  Result<void> finish(bool mayHaveMore) override {
    if (at_ == end_ || mayHaveMore) return {};
    return invalid(
        fmt::format("has {} bytes more than the samples that its header announces", end_ - at_),
        file_.name());
  }

 private:
  Result<void> fill(std::span<std::byte> into) {
    const auto got = file_.readAt(at_, into);
    if (!got) return got.error();
    if (*got < into.size()) return invalid("has become shorter while it was read", file_.name());
    return {};
  }

  platform::OpenFile file_;
  std::uint64_t at_;
  std::uint64_t end_;
  std::vector<std::byte> window_;
  std::uint64_t windowBegin_ = 0;
};

/// Unpacks the next piece while the last one is used, if there is a thread for it.
class GzipReader : public SampleReader {
 public:
  /// `wanted`: the bytes that are to be read in all.
  GzipReader(platform::OpenFile file, std::uint64_t wanted)
      : where_(file.name()), stream_(std::move(file)), wanted_(wanted) {
    unpackNext();
  }
  GzipReader(const GzipReader&) = delete;
  GzipReader& operator=(const GzipReader&) = delete;
  ~GzipReader() noexcept override { unpacking_.wait(); }

  Result<void> read(std::span<std::byte> into) override {
    while (!into.empty()) {
      const auto piece = take(into.size());
      if (piece.empty()) return damaged();
      std::ranges::copy(piece, into.begin());
      read_ += piece.size();
      into = into.subspan(piece.size());
    }
    return {};
  }
  Result<void> skip(std::uint64_t bytes) override {
    while (bytes > 0) {
      const auto piece = take(bytes);
      if (piece.empty()) return damaged();
      read_ += piece.size();
      bytes -= piece.size();
    }
    return {};
  }
  Result<void> finish(bool mayHaveMore) override {
    // The checksum is at the end.
    std::uint64_t beyond = 0;
    std::size_t got = 0;
    do {
      got = take(kPiece).size();
      beyond += got;
    } while (got > 0 && (mayHaveMore || beyond < kMostCounted));
    if (got == 0 && stream_.state() != GzipStream::State::End) return damaged();
    if (beyond == 0 || mayHaveMore) return {};
    return invalid(fmt::format("unpacks to {}{} bytes, but its header announces {}",
                               got > 0 ? "more than " : "", read_ + beyond, read_),
                   where_);
  }

 private:
  struct Piece {
    std::vector<std::byte> bytes = std::vector<std::byte>(kPiece);
    std::size_t size = 0;
  };

  void unpackNext() {
    unpacking_.begin([this] { next_.size = stream_.read(next_.bytes); });
  }

  /// At most so many of the next bytes; none if there are no more.
  std::span<const std::byte> take(std::uint64_t most) {
    if (used_ == current_.size) {
      unpacking_.wait();
      std::swap(current_, next_);
      next_.size = 0;
      used_ = 0;
      if (stream_.state() == GzipStream::State::Good) unpackNext();
    }
    const auto left = std::span(current_.bytes).first(current_.size).subspan(used_);
    const auto piece = left.first(std::min<std::uint64_t>(most, left.size()));
    used_ += piece.size();
    return piece;
  }

  Error damaged() const {
    switch (stream_.state()) {
      case GzipStream::State::Damaged:
        return invalid(fmt::format("its compressed data are damaged: {}", stream_.fault()), where_);
      case GzipStream::State::CannotRead:
        return stream_.error();
      default:
        return invalid(
            fmt::format("is cut off: it unpacks to {} bytes, but its header announces {}", read_,
                        wanted_),
            where_);
    }
  }

  static constexpr std::size_t kPiece = std::size_t{1} << 20U;
  /// More bytes than announced are counted up to so many.
  static constexpr std::uint64_t kMostCounted = std::uint64_t{1} << 30U;

  std::string where_;
  GzipStream stream_;  // used by `unpacking_` alone while it runs
  std::uint64_t wanted_;
  std::uint64_t read_ = 0;
  Piece current_;
  std::size_t used_ = 0;  // bytes of it
  Piece next_;
  model::Aside unpacking_;
};

/// Numbers written in decimals.
class TextReader : public SampleReader {
 public:
  /// `wanted`: the numbers that are to be read in all.
  TextReader(std::ifstream file, std::string where, SampleType type, std::uint64_t wanted)
      : file_(std::move(file)), where_(std::move(where)), type_(type), wanted_(wanted) {}

  Result<void> read(std::span<std::byte> into) override {
    for (std::size_t at = 0; at < into.size(); at += sizeOf(type_)) {
      if (auto one = readOne(into.data() + at); !one) return one;
    }
    return {};
  }
  Result<void> skip(std::uint64_t bytes) override {
    std::array<std::byte, 8> passed;
    for (std::uint64_t at = 0; at < bytes; at += sizeOf(type_)) {
      if (auto one = readOne(passed.data()); !one) return one;
    }
    return {};
  }
  Result<void> finish(bool mayHaveMore) override {
    std::string more;
    if (mayHaveMore || !(file_ >> more)) return {};
    std::uint64_t found = read_ + 1;
    while (file_ >> more) ++found;
    return invalid(fmt::format("has {} samples, but its header announces {}", found, wanted_),
                   where_);
  }

 private:
  Result<void> readOne(std::byte* into) {
    std::string word;
    constexpr int kLongest = 400;
    file_.width(kLongest);
    if (!(file_ >> word)) {
      return invalid(
          fmt::format("is cut off: it has {} samples, but its header announces {}", read_, wanted_),
          where_);
    }
    ++read_;
    switch (type_) {
      case SampleType::Float32:
        return parse<float>(word, into);
      case SampleType::Float64:
        return parse<double>(word, into);
      case SampleType::Int8:
        return parse<std::int8_t>(word, into);
      case SampleType::Int16:
        return parse<std::int16_t>(word, into);
      case SampleType::Int32:
        return parse<std::int32_t>(word, into);
      case SampleType::Int64:
        return parse<std::int64_t>(word, into);
      case SampleType::Bool:
      case SampleType::UInt8:
        return parse<std::uint8_t>(word, into);
      case SampleType::UInt16:
        return parse<std::uint16_t>(word, into);
      case SampleType::UInt32:
        return parse<std::uint32_t>(word, into);
      case SampleType::UInt64:
        return parse<std::uint64_t>(word, into);
    }
    return {};
  }

  template <class T>
  Result<void> parse(const std::string& word, std::byte* into) const {
    const auto value = model::numberIn<T>(word);
    if (!value) {
      return invalid(
          fmt::format("found the sample '{}', expected a number of its type", word.substr(0, 40)),
          where_);
    }
    std::memcpy(into, &*value, sizeof *value);
    return {};
  }

  std::ifstream file_;
  std::string where_;
  SampleType type_;
  std::uint64_t wanted_;
  std::uint64_t read_ = 0;
};

/// The reader of a stream, which stays where it is between two uses.
class StreamReader : public SampleReader {
 public:
  explicit StreamReader(std::shared_ptr<SampleReader> stream) : stream_(std::move(stream)) {}
  Result<void> read(std::span<std::byte> into) override { return stream_->read(into); }
  Result<void> skip(std::uint64_t bytes) override { return stream_->skip(bytes); }
  Result<void> finish(bool mayHaveMore) override { return stream_->finish(mayHaveMore); }

 private:
  std::shared_ptr<SampleReader> stream_;
};

/// The most that a byte of a file can stand for: gzip's best is 1,032; a number in decimals takes
/// two characters.
std::uint64_t mostBytes(SampleEncoding encoding, SampleType type) {
  switch (encoding) {
    case SampleEncoding::Raw:
    case SampleEncoding::Stream:
      return 1;
    case SampleEncoding::Gzip:
      return 1032;
    case SampleEncoding::Text:
      return sizeOf(type);
  }
  return 1;
}

Result<platform::OpenFile> openGzip(const std::filesystem::path& path, std::uint64_t offset) {
  auto file = platform::OpenFile::openRegular(path);
  if (!file) return file;
  std::array<std::byte, 2> magic{};  // stays zero where the file ends
  if (const auto got = file->readAt(offset, magic); !got) return got.error();
  if (magic != std::array{std::byte{0x1F}, std::byte{0x8B}}) {
    return invalid("its samples are not compressed by gzip, although its header says so",
                   file->name());
  }
  file->seek(offset);
  return file;
}

}  // namespace

Result<std::uint64_t> unpackedBytes(const std::filesystem::path& path, std::uint64_t offset) {
  if (const auto size = platform::sizeOfRegularFile(path); !size) return size.error();
  auto file = openGzip(path, offset);
  if (!file) return file.error();
  GzipStream stream(std::move(*file));
  std::vector<std::byte> piece(std::size_t{1} << 18U);
  std::uint64_t bytes = 0;
  while (stream.state() == GzipStream::State::Good) bytes += stream.read(piece);
  switch (stream.state()) {
    case GzipStream::State::Damaged:
      return invalid(fmt::format("its compressed data are damaged: {}", stream.fault()),
                     path.string());
    case GzipStream::State::CannotRead:
      return stream.error();
    case GzipStream::State::CutOff:
      return invalid(fmt::format("is cut off: its compressed data end after {} bytes", bytes),
                     path.string());
    default:
      return bytes;
  }
}

Result<std::unique_ptr<SampleReader>> openSamples(const SampleData& data, SampleType type,
                                                  std::uint64_t bytes) {
  if (data.encoding == SampleEncoding::Stream) return std::make_unique<StreamReader>(data.stream);
  const std::string where = data.path.string();
  const auto size = platform::sizeOfRegularFile(data.path);
  if (!size) return size.error();
  const std::uint64_t stored = *size - std::min(*size, data.offset);
  if (bytes / mostBytes(data.encoding, type) > stored) {
    return invalid(
        fmt::format("is cut off or damaged: {} bytes of samples are announced, which {} bytes "
                    "cannot hold",
                    bytes, stored),
        where);
  }
  if (data.encoding == SampleEncoding::Text) {
    std::ifstream file(data.path, std::ios::binary);
    file.seekg(static_cast<std::streamoff>(data.offset));
    return std::make_unique<TextReader>(std::move(file), where, type, bytes / sizeOf(type));
  }
  if (data.encoding == SampleEncoding::Gzip) {
    auto file = openGzip(data.path, data.offset);
    if (!file) return file.error();
    return std::make_unique<GzipReader>(std::move(*file), bytes);
  }
  auto file = platform::OpenFile::openRegular(data.path);
  if (!file) return file.error();
  return std::make_unique<RawReader>(std::move(*file), data.offset, *size);
}

}  // namespace t4d::voxel4d

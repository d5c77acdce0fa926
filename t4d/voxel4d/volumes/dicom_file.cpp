#include "t4d/voxel4d/volumes/dicom_file.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <span>
#include <string_view>

#include <fmt/format.h>
#include <zlib.h>

#include "t4d/system/regular_file.h"
#include "t4d/voxel4d/volumes/header_text.h"

namespace t4d::voxel4d {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kImplicit = "1.2.840.10008.1.2";
constexpr std::string_view kExplicit = "1.2.840.10008.1.2.1";
constexpr std::string_view kDeflated = "1.2.840.10008.1.2.1.99";
constexpr std::string_view kBigEndian = "1.2.840.10008.1.2.2";

constexpr std::uint32_t kUndefinedLength = 0xFFFFFFFF;
constexpr std::uint64_t kSignatureEnd = 132;

/// Elements by group and number: (0028,0010) is 0x00280010.
enum Tag : std::uint32_t {
  kTransferSyntax = 0x00020010,
  kAcquisitionDate = 0x00080022,
  kContentDate = 0x00080023,
  kAcquisitionDateTime = 0x0008002A,
  kAcquisitionTime = 0x00080032,
  kContentTime = 0x00080033,
  kSeriesDescription = 0x0008103E,
  kTriggerTime = 0x00181060,
  kFrameAcquisitionDateTime = 0x00189074,
  kCardiacSynchronization = 0x00189118,
  kFrameReferenceDateTime = 0x00189151,
  kNominalTriggerDelay = 0x00189153,
  kSeries = 0x0020000E,
  kSeriesNumber = 0x00200011,
  kPosition = 0x00200032,
  kOrientation = 0x00200037,
  kTemporalPosition = 0x00200100,
  kTemporalResolution = 0x00200110,
  kFrameContent = 0x00209111,
  kPlanePosition = 0x00209113,
  kPlaneOrientation = 0x00209116,
  kTemporalPositionIndex = 0x00209128,
  kTemporalPositions = 0x00209310,
  kTemporalPositionOffset = 0x0020930D,
  kSamplesPerPixel = 0x00280002,
  kPhotometric = 0x00280004,
  kFrames = 0x00280008,
  kRows = 0x00280010,
  kColumns = 0x00280011,
  kPixelSpacing = 0x00280030,
  kBitsAllocated = 0x00280100,
  kBitsStored = 0x00280101,
  kHighBit = 0x00280102,
  kPixelRepresentation = 0x00280103,
  kRescaleIntercept = 0x00281052,
  kRescaleSlope = 0x00281053,
  kPixelMeasures = 0x00289110,
  kPixelTransformation = 0x00289145,
  kFrameReferenceTime = 0x00541300,
  kSharedGroups = 0x52009229,
  kFrameGroups = 0x52009230,
  kFloatPixels = 0x7FE00008,
  kDoublePixels = 0x7FE00009,
  kPixels = 0x7FE00010,
  kItem = 0xFFFEE000,
  kItemEnd = 0xFFFEE00D,
  kSequenceEnd = 0xFFFEE0DD,
};

const std::set<std::uint32_t>& wantedSequences() {
  static const std::set<std::uint32_t> tags = {
      kCardiacSynchronization, kFrameContent,      kPlanePosition,
      kPlaneOrientation,       kTemporalPositions, kPixelMeasures,
      kPixelTransformation,    kSharedGroups,      kFrameGroups};
  return tags;
}

const std::set<std::uint32_t>& wantedValues() {
  static const std::set<std::uint32_t> tags = {kTransferSyntax,
                                               kAcquisitionDate,
                                               kContentDate,
                                               kAcquisitionTime,
                                               kAcquisitionDateTime,
                                               kContentTime,
                                               kSeriesDescription,
                                               kTriggerTime,
                                               kFrameAcquisitionDateTime,
                                               kNominalTriggerDelay,
                                               kFrameReferenceDateTime,
                                               kSeries,
                                               kSeriesNumber,
                                               kPosition,
                                               kOrientation,
                                               kTemporalPosition,
                                               kTemporalResolution,
                                               kTemporalPositionIndex,
                                               kSamplesPerPixel,
                                               kTemporalPositionOffset,
                                               kPhotometric,
                                               kFrames,
                                               kRows,
                                               kColumns,
                                               kPixelSpacing,
                                               kBitsAllocated,
                                               kBitsStored,
                                               kHighBit,
                                               kPixelRepresentation,
                                               kRescaleIntercept,
                                               kRescaleSlope,
                                               kFrameReferenceTime};
  return tags;
}

std::string tagText(std::uint32_t tag) {
  return fmt::format("({:04X},{:04X})", tag >> 16U, tag & 0xFFFFU);
}

/// What is kept of a data set: values in the order of bytes of the file, and items of sequences.
struct DataSet {
  std::map<std::uint32_t, std::string> values;
  std::map<std::uint32_t, std::vector<DataSet>> sequences;

  const DataSet* item(std::uint32_t tag) const {
    const auto found = sequences.find(tag);
    return found == sequences.end() || found->second.empty() ? nullptr : &found->second.front();
  }
};

/// The bytes of a file, or of what is inflated from it.
class Bytes {
 public:
  static Result<Bytes> open(const fs::path& path) {
    const auto size = system::sizeOfRegularFile(path);
    if (!size) return size.error();
    Bytes bytes;
    bytes.where_ = path.string();
    bytes.size_ = *size;
    bytes.file_.open(path, std::ios::binary);
    if (!bytes.file_) return fail(ErrorCode::Io, "cannot be read", bytes.where_);
    return bytes;
  }

  const std::string& where() const { return where_; }
  std::uint64_t size() const { return size_; }

  Result<void> read(std::uint64_t at, std::span<char> into) {
    if (at > size_ || into.size() > size_ - at) return cutOff();
    if (inflated_) {
      std::copy_n(inflated_->data() + at, into.size(), into.data());
      return {};
    }
    file_.seekg(static_cast<std::streamoff>(at));
    file_.read(into.data(), static_cast<std::streamsize>(into.size()));
    if (file_) return {};
    file_.clear();
    return invalid("cannot be read, or has become shorter while it was read", where_);
  }

  /// From here on, these are the bytes inflated from byte `from` on, which keep their places.
  Result<void> inflate(std::uint64_t from) {
    std::string packed(size_ - from, '\0');
    if (auto done = read(from, packed); !done) return done;
    z_stream stream{};
    inflateInit2(&stream, -MAX_WBITS);
    stream.next_in = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_in = static_cast<uInt>(packed.size());
    std::string all(from, '\0');
    int state = Z_OK;
    while (state == Z_OK && all.size() < kMostInflated) {
      const std::size_t before = all.size();
      all.resize(before + kPart);
      stream.next_out = reinterpret_cast<Bytef*>(all.data() + before);
      stream.avail_out = kPart;
      state = ::inflate(&stream, Z_NO_FLUSH);
      all.erase(all.size() - stream.avail_out);
    }
    inflateEnd(&stream);
    if (state == Z_OK) {
      return invalid(fmt::format("inflates to more than {} bytes, the most that is read; store it "
                                 "without compression",
                                 kMostInflated),
                     where_);
    }
    if (state != Z_STREAM_END) return invalid("its deflated data set is damaged", where_);
    size_ = all.size();
    inflated_ = std::move(all);
    return {};
  }

  Error cutOff() const { return invalid("is cut off or damaged", where_); }

 private:
  static constexpr unsigned kPart = 1U << 18U;
  static constexpr std::uint64_t kMostInflated = std::uint64_t{1} << 29U;
  std::string where_;
  std::uint64_t size_ = 0;
  std::ifstream file_;
  std::optional<std::string> inflated_;
};

/// What stands before the value of an element.
struct ElementHead {
  std::uint32_t tag = 0;
  std::uint32_t length = 0;
  std::uint64_t value = 0;  ///< the byte where it begins
  bool sequence = false;
  bool unknown = false;  ///< of a type that the writer did not know

  std::uint64_t end() const { return value + length; }
};

/// Walks through elements. Every length is held against what is around it.
class Parser {
 public:
  explicit Parser(Bytes& bytes) : bytes_(bytes) {}

  void setSyntax(bool isExplicit, bool bigEndian) {
    explicit_ = isExplicit;
    bigEndian_ = bigEndian;
  }

  Result<ElementHead> head(std::uint64_t at, std::uint64_t end) {
    std::array<char, 12> raw{};
    if (at > end || end - at < 8) return bytes_.cutOff();
    if (auto done = bytes_.read(at, std::span(raw).first(8)); !done) return done.error();
    ElementHead head;
    head.tag = static_cast<std::uint32_t>(number(raw.data(), 2) << 16U | number(raw.data() + 2, 2));
    head.value = at + 8;
    const bool ofSequence = head.tag >> 16U == 0xFFFE;
    if (!explicit_ || ofSequence) {
      head.length = static_cast<std::uint32_t>(number(raw.data() + 4, 4));
      head.sequence =
          !ofSequence && (wantedSequences().contains(head.tag) || head.length == kUndefinedLength);
    } else {
      const std::string_view type(raw.data() + 4, 2);
      constexpr std::string_view kLong = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";
      if (kLong.find(type) == std::string_view::npos || type[0] == ' ' || type[1] == ' ') {
        head.length = static_cast<std::uint32_t>(number(raw.data() + 6, 2));
      } else {
        if (end - at < 12) return bytes_.cutOff();
        if (auto done = bytes_.read(at + 8, std::span(raw).subspan(8)); !done) {
          return done.error();
        }
        head.length = static_cast<std::uint32_t>(number(raw.data() + 8, 4));
        head.value = at + 12;
      }
      head.unknown = type == "UN";
      head.sequence = type == "SQ" || head.length == kUndefinedLength;
    }
    if (head.length != kUndefinedLength && head.length > end - head.value) {
      return invalid(fmt::format("is cut off or damaged: the element {} at byte {} has {} bytes, "
                                 "which are more than there are",
                                 tagText(head.tag), at, head.length),
                     bytes_.where());
    }
    return head;
  }

  /// Reads elements from `at` to `end`, or to the end of the item; stops at the samples, whose
  /// place it returns, or else where it ended.
  Result<std::uint64_t> dataSet(std::uint64_t at, std::uint64_t end, DataSet* into, int depth) {
    while (at < end) {
      auto element = head(at, end);
      if (!element) return element.error();
      if (element->tag == kItemEnd) return element->value;
      if (depth == 0 && element->tag >= kFloatPixels && element->tag <= kPixels) return at;
      auto next = value(*element, end, into, depth);
      if (!next) return next.error();
      at = *next;
    }
    return at;
  }

  std::uint64_t number(const char* from, int bytes) const {
    std::uint64_t value = 0;
    for (int i = 0; i < bytes; ++i) {
      value = value << 8U | static_cast<unsigned char>(from[bigEndian_ ? i : bytes - 1 - i]);
    }
    return value;
  }
  bool bigEndian() const { return bigEndian_; }

 private:
  /// Returns where the next element begins.
  Result<std::uint64_t> value(const ElementHead& element, std::uint64_t end, DataSet* into,
                              int depth) {
    const bool wanted = into != nullptr && wantedSequences().contains(element.tag);
    if (element.sequence && (wanted || element.length == kUndefinedLength)) {
      // What a writer did not know is without types.
      const bool before = explicit_;
      if (element.unknown) explicit_ = false;
      auto next = sequence(element, end, wanted ? &into->sequences[element.tag] : nullptr, depth);
      explicit_ = before;
      return next;
    }
    if (into != nullptr && wantedValues().contains(element.tag) && element.length <= kLongest) {
      std::string& text = into->values[element.tag];
      text.resize(element.length);
      if (auto done = bytes_.read(element.value, text); !done) return done.error();
    }
    return element.end();
  }

  Result<std::uint64_t> sequence(const ElementHead& sequence, std::uint64_t end,
                                 std::vector<DataSet>* into, int depth) {
    if (depth > kDeepest) {
      return invalid(fmt::format("has sequences more than {} deep", kDeepest), bytes_.where());
    }
    const bool open = sequence.length == kUndefinedLength;
    if (!open) end = sequence.end();
    std::uint64_t at = sequence.value;
    while (open || at < end) {
      auto item = head(at, end);
      if (!item) return item.error();
      if (item->tag == kSequenceEnd) return item->value;
      if (item->tag != kItem) {
        return invalid(fmt::format("is damaged: in the sequence {} byte {} begins {}, expected an "
                                   "item",
                                   tagText(sequence.tag), at, tagText(item->tag)),
                       bytes_.where());
      }
      DataSet* set = into != nullptr ? &into->emplace_back() : nullptr;
      const std::uint64_t itemEnd = item->length == kUndefinedLength ? end : item->end();
      auto next = dataSet(item->value, itemEnd, set, depth + 1);
      if (!next) return next;
      at = *next;
    }
    return at;
  }

  static constexpr std::uint32_t kLongest = 1024;  // a value that is of use is shorter
  static constexpr int kDeepest = 32;
  Bytes& bytes_;
  bool explicit_ = true;
  bool bigEndian_ = false;
};

/// Without the blanks and zeros that fill values up.
std::string textOf(const DataSet& set, std::uint32_t tag) {
  const auto found = set.values.find(tag);
  if (found == set.values.end()) return {};
  std::string text = found->second;
  std::ranges::replace(text, '\0', ' ');
  return trimmed(text);
}

/// Numbers in decimals between backslashes; none if one of them is not a finite number.
std::vector<double> decimals(const DataSet& set, std::uint32_t tag) {
  std::string text = textOf(set, tag);
  std::vector<double> numbers;
  while (!text.empty()) {
    const auto end = std::min(text.find('\\'), text.size());
    const auto one = numberIn<double>(trimmed(text.substr(0, end)));
    if (!one || !std::isfinite(*one)) return {};
    numbers.push_back(*one);
    text.erase(0, end + 1);
  }
  return numbers;
}

std::optional<double> decimal(const DataSet& set, std::uint32_t tag) {
  const auto numbers = decimals(set, tag);
  return numbers.empty() ? std::nullopt : std::optional(numbers.front());
}

template <std::size_t N>
std::optional<std::array<double, N>> decimals(const DataSet& set, std::uint32_t tag) {
  const auto numbers = decimals(set, tag);
  if (numbers.size() != N) return std::nullopt;
  std::array<double, N> all{};
  std::ranges::copy(numbers, all.begin());
  return all;
}

/// Digits as a number; nothing if there is another character.
std::optional<int> digits(std::string_view text) {
  if (text.empty() || !std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; })) {
    return std::nullopt;
  }
  return numberIn<int>(text);
}

/// Seconds of HHMMSS.FFFFFF, of which the last parts may lack.
std::optional<double> secondsOfDay(std::string text) {
  std::erase(text, ':');
  const auto hours = digits(std::string_view(text).substr(0, 2));
  if (!hours) return std::nullopt;
  double seconds = *hours * 3600.0;
  if (text.size() >= 4) {
    const auto minutes = digits(std::string_view(text).substr(2, 2));
    if (!minutes) return std::nullopt;
    seconds += *minutes * 60.0;
  }
  if (text.size() > 4) {
    const auto rest = numberIn<double>(std::string_view(text).substr(4));
    if (!rest || !(*rest >= 0 && *rest < 100)) return std::nullopt;
    seconds += *rest;
  }
  return seconds;
}

/// Seconds of YYYYMMDD since 1970.
std::optional<double> secondsOfDate(std::string text) {
  std::erase(text, '.');
  if (text.size() != 8) return std::nullopt;
  const std::string_view all = text;
  const auto year = digits(all.substr(0, 4));
  const auto month = digits(all.substr(4, 2));
  const auto day = digits(all.substr(6, 2));
  if (!year || !month || !day) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(*year),
                                         std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day))};
  if (!date.ok()) return std::nullopt;
  return 86400.0 * static_cast<double>(std::chrono::sys_days(date).time_since_epoch().count());
}

/// Of YYYYMMDDHHMMSS.FFFFFF, without the time zone, which is the same in all of a series.
std::optional<double> secondsOfDateTime(const std::string& text) {
  if (text.size() < 10) return std::nullopt;
  const auto date = secondsOfDate(text.substr(0, 8));
  const auto time = secondsOfDay(text.substr(8, text.find_first_of("+-&", 8) - 8));
  if (!date || !time) return std::nullopt;
  return *date + *time;
}

std::optional<double> secondsOf(const DataSet& set, std::uint32_t date, std::uint32_t time) {
  const auto ofDay = secondsOfDay(textOf(set, time));
  if (!ofDay) return std::nullopt;
  return *ofDay + secondsOfDate(textOf(set, date)).value_or(0);
}

std::optional<double> inSeconds(std::optional<double> milliseconds) {
  if (milliseconds) *milliseconds /= 1000;
  return milliseconds;
}

class Reading {
 public:
  explicit Reading(Bytes bytes) : bytes_(std::move(bytes)), parser_(bytes_) {}
  Reading(const Reading&) = delete;
  Reading& operator=(const Reading&) = delete;

  Result<DicomFile> run() {
    const auto at = meta();
    if (!at) return at.error();
    const auto pixels = parser_.dataSet(*at, bytes_.size(), &set_, 0);
    if (!pixels) return pixels.error();
    file_.series = textOf(set_, kSeries);
    file_.number = textOf(set_, kSeriesNumber);
    file_.description = textOf(set_, kSeriesDescription);
    const auto good =
        layout().and_then([&] { return images(); }).and_then([&] { return samples(*pixels); });
    if (!good) file_.fault = good.error();
    return std::move(file_);
  }

 private:
  Error wrong(std::string message) const { return invalid(std::move(message), bytes_.where()); }

  /// Reads the group 0002, which says how the rest is written; returns where that begins.
  Result<std::uint64_t> meta() {
    std::array<char, 4> magic{};
    if (bytes_.size() < kSignatureEnd) return wrong("is not a DICOM file: it is too short");
    if (auto done = bytes_.read(kSignatureEnd - 4, magic); !done) return done.error();
    if (std::string_view(magic.data(), 4) != "DICM") {
      return wrong("is not a DICOM file: it has no 'DICM' at byte 128");
    }
    std::uint64_t at = kSignatureEnd;
    DataSet meta;
    while (at + 8 <= bytes_.size()) {
      std::array<char, 2> group{};
      if (auto done = bytes_.read(at, group); !done) return done.error();
      if (parser_.number(group.data(), 2) != 2) break;
      const auto element = parser_.head(at, bytes_.size());
      if (!element) return element.error();
      if (element->length == kUndefinedLength) return bytes_.cutOff();
      if (element->tag == kTransferSyntax) {
        std::string& text = meta.values[kTransferSyntax];
        text.resize(std::min<std::uint32_t>(element->length, 64));
        if (auto done = bytes_.read(element->value, text); !done) return done.error();
      }
      at = element->end();
    }
    DicomLayout& layout = file_.layout;
    layout.syntax = textOf(meta, kTransferSyntax);
    if (layout.syntax.empty()) return wrong("does not say its transfer syntax (0002,0010)");
    layout.bigEndian = layout.syntax == kBigEndian;
    layout.encapsulated = !layout.bigEndian && layout.syntax != kImplicit &&
                          layout.syntax != kExplicit && layout.syntax != kDeflated;
    if (layout.syntax == kDeflated) {
      deflatedFrom_ = at;
      if (auto done = bytes_.inflate(at); !done) return done.error();
    }
    parser_.setSyntax(layout.syntax != kImplicit, layout.bigEndian);
    return at;
  }

  std::optional<std::uint32_t> small(std::uint32_t tag) const {
    const auto found = set_.values.find(tag);
    if (found == set_.values.end() || found->second.size() < 2) return std::nullopt;
    return static_cast<std::uint32_t>(parser_.number(found->second.data(), 2));
  }

  Result<void> layout() {
    DicomLayout& layout = file_.layout;
    const std::string photometric = textOf(set_, kPhotometric);
    layout.rows = small(kRows).value_or(0);
    layout.columns = small(kColumns).value_or(0);
    layout.bits = small(kBitsAllocated).value_or(0);
    layout.stored = small(kBitsStored).value_or(layout.bits);
    layout.isSigned = small(kPixelRepresentation).value_or(0) == 1;
    if (layout.rows == 0 || layout.columns == 0) {
      return wrong(
          fmt::format("has no image: it has {} rows and {} columns", layout.rows, layout.columns));
    }
    if (photometric != "MONOCHROME1" && photometric != "MONOCHROME2") {
      return wrong(fmt::format("has the colours '{}', expected grey values (MONOCHROME2)",
                               shown(photometric)));
    }
    if (small(kSamplesPerPixel).value_or(1) != 1) {
      return wrong(fmt::format("has {} samples a pixel, expected 1", *small(kSamplesPerPixel)));
    }
    if (layout.bits != 8 && layout.bits != 16 && layout.bits != 32) {
      return wrong(fmt::format("has samples of {} bits; 8, 16 and 32 can be used", layout.bits));
    }
    if (layout.stored == 0 || layout.stored > layout.bits ||
        small(kHighBit).value_or(layout.stored - 1) != layout.stored - 1) {
      return wrong(
          fmt::format("has samples of {} bits, of which {} count, up to bit {}; expected "
                      "are the lowest",
                      layout.bits, layout.stored, small(kHighBit).value_or(0)));
    }
    if (layout.bigEndian && layout.bits == 8) {
      return wrong("has samples of 8 bits in the retired order of bytes 'big endian'");
    }
    file_.inverted = photometric == "MONOCHROME1";
    return {};
  }

  /// What a data set says of its frame, and the items of an enhanced image's functional groups.
  Result<void> describe(const DataSet& set, DicomImage& image) const {
    const auto from = [&](std::uint32_t sequence) -> const DataSet& {
      const DataSet* item = set.item(sequence);
      return item != nullptr ? *item : set;
    };
    if (const auto found = decimals<3>(from(kPlanePosition), kPosition)) {
      image.position = Eigen::Vector3d(found->data());
    }
    if (const auto found = decimals<6>(from(kPlaneOrientation), kOrientation)) {
      image.orientation = found;
    }
    if (const auto found = decimals<2>(from(kPixelMeasures), kPixelSpacing)) image.spacing = found;
    const DataSet& scale = from(kPixelTransformation);
    if (scale.values.contains(kRescaleSlope) || scale.values.contains(kRescaleIntercept)) {
      const auto slope = decimal(scale, kRescaleSlope);
      const auto intercept = decimal(scale, kRescaleIntercept);
      if (!slope || !intercept || *slope == 0) {
        return wrong(fmt::format("scales its samples by '{}' and adds '{}'",
                                 shown(textOf(scale, kRescaleSlope)),
                                 shown(textOf(scale, kRescaleIntercept))));
      }
      image.slope = *slope;
      image.intercept = *intercept;
    }
    times(set, from, image);
    return {};
  }

  template <class From>
  void times(const DataSet& set, const From& from, DicomImage& image) const {
    const auto put = [&](DicomTime kind, std::optional<double> time) {
      if (time && std::isfinite(*time)) image.times[static_cast<std::size_t>(kind)] = time;
    };
    put(DicomTime::Trigger, inSeconds(decimal(set, kTriggerTime)));
    put(DicomTime::Trigger, inSeconds(binary(from(kCardiacSynchronization), kNominalTriggerDelay)));
    const auto position = decimal(set, kTemporalPosition);
    const auto apart = decimal(set, kTemporalResolution);
    put(DicomTime::TemporalPosition, position);
    if (position && apart) put(DicomTime::TemporalOffset, (*position - 1) * *apart / 1000);
    put(DicomTime::TemporalOffset, binary(from(kTemporalPositions), kTemporalPositionOffset));
    put(DicomTime::FrameReference, inSeconds(decimal(set, kFrameReferenceTime)));
    put(DicomTime::Acquisition, secondsOf(set, kAcquisitionDate, kAcquisitionTime));
    put(DicomTime::Acquisition, secondsOfDateTime(textOf(set, kAcquisitionDateTime)));
    put(DicomTime::Content, secondsOf(set, kContentDate, kContentTime));
    const DataSet& content = from(kFrameContent);
    put(DicomTime::Acquisition, secondsOfDateTime(textOf(content, kFrameReferenceDateTime)));
    put(DicomTime::Acquisition, secondsOfDateTime(textOf(content, kFrameAcquisitionDateTime)));
    if (const auto found = content.values.find(kTemporalPositionIndex);
        found != content.values.end() && found->second.size() == 4) {
      put(DicomTime::TemporalPosition,
          static_cast<double>(parser_.number(found->second.data(), 4)));
    }
  }

  /// A double in binary.
  std::optional<double> binary(const DataSet& set, std::uint32_t tag) const {
    const auto found = set.values.find(tag);
    if (found == set.values.end() || found->second.size() != 8) return std::nullopt;
    return std::bit_cast<double>(parser_.number(found->second.data(), 8));
  }

  Result<void> images() {
    DicomImage common;
    common.deflatedFrom = deflatedFrom_;
    if (auto done = describe(set_, common); !done) return done;
    if (const DataSet* shared = set_.item(kSharedGroups)) {
      if (auto done = describe(*shared, common); !done) return done;
    }
    const double frames = decimal(set_, kFrames).value_or(1);
    const auto groups = set_.sequences.find(kFrameGroups);
    if (groups == set_.sequences.end()) {
      if (frames > 1) {
        return wrong(
            fmt::format("holds {} frames that have no positions of their own, such as "
                        "films of ultrasound or X-rays have: it is not a volume over time",
                        frames));
      }
      file_.images = {std::move(common)};
      return {};
    }
    if (frames != static_cast<double>(groups->second.size())) {
      return wrong(fmt::format("has {} frames, but describes {}", frames, groups->second.size()));
    }
    for (const DataSet& group : groups->second) {
      DicomImage& image = file_.images.emplace_back(common);
      if (auto done = describe(group, image); !done) return done;
    }
    return {};
  }

  /// Where the samples of each image are.
  Result<void> samples(std::uint64_t at) {
    if (at >= bytes_.size()) return wrong("has no samples (7FE0,0010)");
    const auto pixels = parser_.head(at, bytes_.size());
    if (!pixels) return pixels.error();
    if (pixels->tag == kDoublePixels) {
      return wrong("has doubles as samples; floats and integers can be read");
    }
    if (pixels->tag == kFloatPixels) {
      if (auto good = floats(); !good) return good;
    }
    const bool open = pixels->length == kUndefinedLength;
    if (open != file_.layout.encapsulated) {
      return wrong("its samples are not stored as its transfer syntax says");
    }
    if (open) return fragments(pixels->value);
    const std::uint64_t each = file_.layout.bytes();
    if (pixels->length / each < file_.images.size()) {
      return wrong(fmt::format("has {} bytes of samples; {} of {} x {} with {} bits need {}",
                               pixels->length, file_.images.size(), file_.layout.columns,
                               file_.layout.rows, file_.layout.bits, each * file_.images.size()));
    }
    for (std::size_t i = 0; i < file_.images.size(); ++i) {
      file_.images[i].pieces = {{pixels->value + i * each, each}};
    }
    return {};
  }

  Result<void> floats() {
    file_.layout.isFloat = true;
    const bool scaled = std::ranges::any_of(file_.images, [](const DicomImage& image) {
      return image.slope != 1 || image.intercept != 0;
    });
    if (file_.layout.bits == 32 && file_.layout.stored == 32 && !scaled) return {};
    return wrong("has floats as samples, but not of 32 bits, or scaled");
  }

  Result<void> fragments(std::uint64_t at) {
    std::vector<DicomPiece> pieces;  // the first is a table of offsets
    while (true) {
      const auto item = parser_.head(at, bytes_.size());
      if (!item) return item.error();
      if (item->tag == kSequenceEnd) break;
      if (item->tag != kItem || item->length == kUndefinedLength) return bytes_.cutOff();
      pieces.push_back({item->value, item->length});
      at = item->end();
    }
    const std::size_t count = file_.images.size();
    // Empty images pack best: a kilobyte or two of markers whatever their size.
    constexpr std::uint64_t kMostPerByte = 4096;
    constexpr std::uint64_t kMarkers = 1024;
    std::uint64_t packed = 0;
    for (const DicomPiece& piece : pieces) packed += piece.bytes;
    if (file_.layout.bytes() / kMostPerByte * count > packed + kMarkers * count) {
      return wrong(fmt::format("is damaged: {} compressed bytes cannot hold its images of {} x {}",
                               packed, file_.layout.columns, file_.layout.rows));
    }
    if (pieces.size() < 2) return wrong("has no samples (7FE0,0010)");
    pieces.erase(pieces.begin());
    if (count == 1) {
      file_.images.front().pieces = std::move(pieces);
      return {};
    }
    if (pieces.size() != count) {
      return wrong(
          fmt::format("has {} compressed pieces for {} frames, expected one each; store "
                      "it without compression",
                      pieces.size(), count));
    }
    for (std::size_t i = 0; i < count; ++i) file_.images[i].pieces = {pieces[i]};
    return {};
  }

  Bytes bytes_;
  Parser parser_;
  DataSet set_;
  std::uint64_t deflatedFrom_ = 0;
  DicomFile file_;
};

}  // namespace

SampleType DicomLayout::type() const {
  if (bits == 8) return isSigned ? SampleType::Int8 : SampleType::UInt8;
  if (isFloat) return SampleType::Float32;
  if (bits == 16) return isSigned ? SampleType::Int16 : SampleType::UInt16;
  return isSigned ? SampleType::Int32 : SampleType::UInt32;
}

bool hasDicomSignature(const fs::path& path) {
  auto bytes = Bytes::open(path);
  std::array<char, 4> magic{};
  return bytes && bytes->size() >= kSignatureEnd && bytes->read(kSignatureEnd - 4, magic) &&
         std::string_view(magic.data(), 4) == "DICM";
}

Result<DicomFile> readDicomFile(const fs::path& path) {
  auto bytes = Bytes::open(path);
  if (!bytes) return bytes.error();
  return Reading(std::move(*bytes)).run();
}

Result<std::string> readDicomPieces(const fs::path& path, const DicomImage& image) {
  auto bytes = Bytes::open(path);
  if (!bytes) return bytes.error();
  if (image.deflatedFrom > 0) {
    if (image.deflatedFrom > bytes->size()) return bytes->cutOff();
    if (auto done = bytes->inflate(image.deflatedFrom); !done) return done.error();
  }
  std::string all;
  for (const DicomPiece& piece : image.pieces) {
    if (piece.bytes > bytes->size()) return bytes->cutOff();
    const std::size_t before = all.size();
    all.resize(before + piece.bytes);
    if (auto done = bytes->read(piece.offset, std::span(all).subspan(before)); !done) {
      return done.error();
    }
  }
  return all;
}

}  // namespace t4d::voxel4d

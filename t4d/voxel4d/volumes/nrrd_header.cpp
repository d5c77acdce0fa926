#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include <fmt/format.h>

#include "t4d/voxel4d/volumes/header_text.h"
#include "t4d/voxel4d/volumes/headers.h"

namespace t4d::voxel4d {
namespace {

namespace fs = std::filesystem;

std::optional<SampleType> typeOf(const std::string& name) {
  static const std::map<std::string, std::string> kAliases = {
      {"signed char", "int8"},
      {"int8_t", "int8"},
      {"uchar", "uint8"},
      {"unsigned char", "uint8"},
      {"uint8_t", "uint8"},
      {"short", "int16"},
      {"short int", "int16"},
      {"signed short", "int16"},
      {"signed short int", "int16"},
      {"int16_t", "int16"},
      {"ushort", "uint16"},
      {"unsigned short", "uint16"},
      {"unsigned short int", "uint16"},
      {"uint16_t", "uint16"},
      {"int", "int32"},
      {"signed int", "int32"},
      {"int32_t", "int32"},
      {"uint", "uint32"},
      {"unsigned int", "uint32"},
      {"uint32_t", "uint32"},
      {"longlong", "int64"},
      {"long long", "int64"},
      {"long long int", "int64"},
      {"signed long long", "int64"},
      {"signed long long int", "int64"},
      {"int64_t", "int64"},
      {"ulonglong", "uint64"},
      {"unsigned long long", "uint64"},
      {"unsigned long long int", "uint64"},
      {"uint64_t", "uint64"},
      {"float", "float32"},
      {"double", "float64"},
  };
  const std::string lower = lowerCase(name);
  const auto alias = kAliases.find(lower);
  return sampleTypeNamed(alias == kAliases.end() ? lower : alias->second);
}

/// The names of all fields that NRRD has, without blanks.
constexpr std::array<std::string_view, 31> kFields = {"axismaxs",
                                                      "axismins",
                                                      "blocksize",
                                                      "byteskip",
                                                      "centerings",
                                                      "centers",
                                                      "content",
                                                      "datafile",
                                                      "dimension",
                                                      "encoding",
                                                      "endian",
                                                      "kinds",
                                                      "labels",
                                                      "lineskip",
                                                      "max",
                                                      "measurementframe",
                                                      "min",
                                                      "number",
                                                      "oldmax",
                                                      "oldmin",
                                                      "sampleunits",
                                                      "sizes",
                                                      "space",
                                                      "spacedimension",
                                                      "spacedirections",
                                                      "spaceorigin",
                                                      "spaceunits",
                                                      "spacings",
                                                      "thicknesses",
                                                      "type",
                                                      "units"};

/// The lines of a header, by the name of their field.
class Header {
 public:
  static Result<Header> read(const fs::path& path) {
    Header header;
    header.where = path.string();
    auto file = openHeader(path);
    if (!file) return file.error();
    std::string line;
    constexpr std::uint64_t kLongest = 1U << 20U;
    std::uint64_t bytes = 0;
    for (std::uint64_t number = 1; takeLine(*file, line, bytes); ++number) {
      if (bytes > kLongest) {
        return invalid("has a header of more than a megabyte", header.where);
      }
      if (number == 1) {
        if (!line.starts_with("NRRD000")) {
          return invalid("is not an NRRD file: its first line does not begin with NRRD000",
                         header.where);
        }
        if (line.size() != 8 || line[7] < '1' || line[7] > '5') {
          return invalid(
              fmt::format("is of version '{}'; NRRD0001 to NRRD0005 can be read", shown(line)),
              header.where);
        }
        continue;
      }
      if (line.empty()) {
        header.end_ = bytes;
        return header;
      }
      if (line.front() == '#') continue;
      const auto colon = line.find(": ");
      if (line.find(":=") < colon) continue;  // a key and a value of somebody's own
      const Place where = {header.where, number};
      if (colon == std::string::npos) {
        return invalid(fmt::format("found '{}', expected 'FIELD: VALUE'", shown(line)), where);
      }
      const std::string field = line.substr(0, colon);
      const auto [value, isNew] =
          header.fields_.emplace(keyOf(field), trimmed(line.substr(colon + 2)));
      if (!isNew) {
        return invalid(fmt::format("has the field '{}' a second time", shown(field)), where);
      }
      if (keyOf(field) == "datafile" && value->second.starts_with("LIST")) {
        while (takeLine(*file, line, bytes)) {
          if (!line.empty()) header.list.push_back(line);
        }
        return header;
      }
    }
    return header;  // a detached header ends with its file
  }

  /// Empty if it is not there. Names are compared without case and blanks, which NRRD allows in
  /// some.
  std::string operator()(const std::string& field) const {
    const auto found = fields_.find(keyOf(field));
    return found == fields_.end() ? std::string() : found->second;
  }
  /// A value of a fixed set, which is compared without case.
  std::string word(const std::string& field) const { return lowerCase((*this)(field)); }
  std::vector<std::string> words(const std::string& field) const { return wordsOf((*this)(field)); }
  /// A number for each of `count` axes, none where NRRD's `nan` says that it is unknown; empty
  /// without the field.
  Result<std::vector<std::optional<double>>> numbers(const std::string& field,
                                                     std::size_t count) const {
    std::vector<std::optional<double>> all;
    for (const std::string& word : words(field)) {
      const auto number = numberIn<double>(word);
      if (!number || std::isinf(*number)) {
        return wrong(field,
                     fmt::format("has '{}' where a number, or nan, is expected", shown(word)));
      }
      all.push_back(std::isnan(*number) ? std::nullopt : number);
    }
    if (all.empty() || all.size() == count) return all;
    return wrong(field, fmt::format("does not have a number for each of {} axes", count));
  }
  /// Fails for a field that NRRD does not have: its name may be misspelt.
  Result<void> checkNames() const {
    for (const auto& [name, value] : fields_) {
      if (std::ranges::find(kFields, name) != kFields.end()) continue;
      return invalid(fmt::format("has the field '{}', which NRRD does not have; a key of your own "
                                 "is written as 'KEY:=VALUE'",
                                 shown(name)),
                     where);
    }
    return {};
  }
  Error wrong(const std::string& field, const std::string& message) const {
    if ((*this)(field).empty()) {
      return invalid(fmt::format("lacks the field '{}', which is required", field), where);
    }
    return invalid(fmt::format("its field '{}: {}' {}", field, shown((*this)(field)), message),
                   where);
  }
  /// Of the blank line, if the samples are in the same file.
  std::optional<std::uint64_t> end() const { return end_; }

  std::string where;
  std::vector<std::string> list;  // of data files

 private:
  static std::string keyOf(std::string field) {
    std::erase(field, ' ');
    return lowerCase(std::move(field));
  }
  static bool takeLine(std::istream& file, std::string& line, std::uint64_t& bytes) {
    if (!std::getline(file, line)) return false;
    bytes += line.size() + 1;
    if (line.ends_with('\r')) line.pop_back();
    return true;
  }

  std::map<std::string, std::string> fields_;
  std::optional<std::uint64_t> end_;
};

/// "(1,0,0) none (0, 1, 0)": a vector or nothing for each.
std::optional<std::vector<std::optional<Eigen::Vector3d>>> vectorsIn(const std::string& text) {
  std::vector<std::optional<Eigen::Vector3d>> vectors;
  for (std::size_t at = 0;;) {
    at = text.find_first_not_of(" \t", at);
    if (at == std::string::npos) return vectors;
    if (lowerCase(text.substr(at, 4)) == "none") {
      vectors.emplace_back();
      at += 4;
      continue;
    }
    const auto close = text.find(')', at);
    if (text[at] != '(' || close == std::string::npos) return std::nullopt;
    std::string inside = text.substr(at + 1, close - at - 1);
    std::ranges::replace(inside, ',', ' ');
    const auto words = wordsOf(inside);
    if (words.size() != 3) return std::nullopt;
    Eigen::Vector3d vector;
    for (int i = 0; i < 3; ++i) {
      const auto number = numberIn<double>(words[i]);
      if (!number) return std::nullopt;
      vector[i] = *number;
    }
    vectors.emplace_back();
    if (!vector.array().isNaN().all()) vectors.back() = vector;  // old files have nan for none
    at = close + 1;
  }
}

/// The words of a list in quotes, "mm" "mm" "s"; nothing if there are not `count`. Units that are
/// not known are "".
std::optional<std::vector<std::string>> unitsIn(const std::string& text, std::size_t count) {
  std::vector<std::string> words;
  for (std::size_t at = 0;;) {
    const auto begin = text.find('"', at);
    const auto end = begin == std::string::npos ? begin : text.find('"', begin + 1);
    if (end == std::string::npos) break;
    words.push_back(text.substr(begin + 1, end - begin - 1));
    if (words.back() == "???" || words.back() == "none") words.back().clear();
    at = end + 1;
  }
  if (words.size() != count) return std::nullopt;
  return words;
}

/// Where axes begin, of samples without directions.
Result<void> placeByMins(const Header& header, const std::optional<std::size_t>& time,
                         bool hasDirections, Volume& volume) {
  const bool spaced = !header("spacings").empty() || hasDirections;
  if (!header("axis maxs").empty() && !spaced) {
    return header.wrong("axis maxs", "is not supported; give spacings");
  }
  const auto mins = header.numbers("axis mins", volume.sizes.size());
  if (!mins) return mins.error();
  if (mins->empty()) return {};
  for (const char* field : {"centers", "centerings"}) {
    const auto centers = wordsOf(header.word(field));
    if (std::ranges::find(centers, "cell") == centers.end()) continue;
    return header.wrong(field, "is not supported with axis mins; give a space origin");
  }
  int axis = 0;
  for (std::size_t i = 0; i < mins->size(); ++i) {
    const std::optional<double> min = (*mins)[i];
    if (min && hasDirections && i != time) {
      return header.wrong("axis mins", "contradicts directions in space; give a space origin");
    }
    double& begin = i == time ? volume.startTime : volume.place(axis++, 3);
    begin = min.value_or(begin);
  }
  return {};
}

/// Which axis is the time, if one is.
Result<std::optional<std::size_t>> timeAxisOf(
    const Header& header, const std::vector<std::optional<Eigen::Vector3d>>& directions,
    std::size_t count) {
  const auto kinds = wordsOf(header.word("kinds"));
  if (!kinds.empty() && kinds.size() != count) {
    return header.wrong("kinds", fmt::format("does not have a word for each of {} axes", count));
  }
  std::optional<std::size_t> time;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string kind = kinds.empty() ? "" : kinds[i];
    const bool ofTime = kind == "time" || kind == "list";
    const bool ofSpace = kind == "space" || kind == "domain";
    const bool bare = !directions.empty() && !directions[i];
    if (!ofTime && !ofSpace && !kind.empty() && kind != "none" && kind != "???") {
      return header.wrong("kinds", fmt::format("has an axis of kind '{}': samples are to be single "
                                               "numbers",
                                               shown(kind)));
    }
    if (!ofTime && !bare) continue;
    if (time) {
      return header.wrong(kinds.empty() ? "space directions" : "kinds",
                          "has more than one axis that is not of space");
    }
    time = i;
  }
  if (!time && count == 4 && !directions.empty()) {
    return header.wrong("space directions",
                        "gives all four axes a direction, so none is the time; expected 'none' "
                        "for the axis of time, or its kind, time");
  }
  if (!time && count == 4) time = 3;
  if (count != (time ? 4U : 3U)) {
    return header.wrong("dimension", "is not three axes of space, with or without one of time");
  }
  return time;
}

/// Turns positions to a space that is right-handed: in one that is not, solids are mirror images.
Result<void> takeSpace(const Header& header, bool hasDirections, Volume& volume) {
  const std::string space = header.word("space");
  if (space.ends_with("-time") || space == "rast" || space == "last" || space == "lpst" ||
      space == "3drht" || space == "3dlht") {
    return header.wrong("space",
                        "has four dimensions; expected a space of three, with directions of "
                        "three numbers, and 'none' for the axis of time");
  }
  if (const std::string dimension = header("space dimension");
      !dimension.empty() && dimension != "3") {
    return header.wrong("space dimension", "is not 3, with 'none' for the direction of time");
  }
  const bool ras = space == "right-anterior-superior" || space == "ras";
  const bool las = space == "left-anterior-superior" || space == "las";
  const bool lps = space == "left-posterior-superior" || space == "lps";
  const bool leftHanded = space == "3d-left-handed" || space == "3dlh";
  if (!ras && !las && !lps && !leftHanded && space != "3d-right-handed" && space != "3drh" &&
      space != "scanner-xyz" && !space.empty()) {
    return header.wrong("space",
                        "is not known; NRRD has right-anterior-superior, "
                        "left-anterior-superior, left-posterior-superior, scanner-xyz, "
                        "3D-right-handed and 3D-left-handed");
  }
  if (!hasDirections) return {};  // the axes of the data are not those of the space
  if (lps) volume.space = "LPS";
  if (ras || las) volume.space = "RAS";
  if (las) {
    volume.place.row(0) *= -1;
    volume.notice =
        "its space, left-anterior-superior, is left-handed: x is negated, which makes "
        "it right-anterior-superior (RAS)";
  }
  if (leftHanded) {
    volume.place.row(2) *= -1;
    volume.notice = "its space is left-handed: z is negated, so that the solid is not mirrored";
  }
  return {};
}

/// Units of length and time. What `units` and `space units` say both must agree.
Result<void> takeUnits(const Header& header, const std::optional<std::size_t>& time,
                       Volume& volume) {
  const std::size_t count = volume.sizes.size();
  const auto ofSpace = unitsIn(header("space units"), 3);
  const auto ofAxes = unitsIn(header("units"), count);
  if (!ofSpace && !header("space units").empty()) {
    return header.wrong("space units", "is not three units in quotes");
  }
  if (!ofAxes && !header("units").empty()) {
    return header.wrong("units", fmt::format("is not a unit in quotes for each of {} axes", count));
  }
  if (ofSpace) {
    if (std::ranges::adjacent_find(*ofSpace, std::not_equal_to<>()) != ofSpace->end()) {
      return header.wrong("space units", "are not all the same");
    }
    volume.lengthUnit = ofSpace->front();
  }
  if (!ofAxes) return {};
  std::optional<std::string> unit;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string& here = (*ofAxes)[i];
    if (i == time) {
      volume.timeUnit = here;
    } else if (unit.value_or(here) != here) {
      return header.wrong("units", "are not the same along all axes of space");
    } else {
      unit = here;
    }
  }
  if (unit->empty()) return {};
  if (!volume.lengthUnit.empty() && volume.lengthUnit != *unit) {
    return header.wrong("units",
                        fmt::format("contradicts the space units, '{}'", shown(volume.lengthUnit)));
  }
  volume.lengthUnit = *unit;
  return {};
}

/// Sets which axis is which, and where samples are.
Result<void> place(const Header& header, Volume& volume) {
  const std::size_t count = volume.sizes.size();
  const auto directions = vectorsIn(header("space directions"));
  if (!directions || (!directions->empty() && directions->size() != count)) {
    return header.wrong(
        "space directions",
        fmt::format("is not a vector (x,y,z), or none, for each of {} axes", count));
  }
  const bool hasDirections = !directions->empty();
  const auto time = timeAxisOf(header, *directions, count);
  if (!time) return time.error();
  int axis = 0;
  for (std::size_t i = 0; i < count; ++i) volume.axes += i == *time ? 't' : "xyz"[axis++];

  const auto spacings = header.numbers("spacings", count);
  if (!spacings) return spacings.error();
  int known = 0;
  axis = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto step = spacings->empty() ? std::nullopt : (*spacings)[i];
    if (i == *time) {
      volume.frameTime = step;
      continue;
    }
    known += step ? 1 : 0;
    if (hasDirections) {
      volume.place.col(axis) = *(*directions)[i];
      constexpr double kRounding = 1e-4;  // of numbers in six digits
      const double length = volume.place.col(axis).norm();
      if (step && !(std::abs(std::abs(*step) - length) <= kRounding * length)) {
        return header.wrong("spacings", fmt::format("contradicts the direction of axis {}, whose "
                                                    "length is {}",
                                                    i, length));
      }
    } else {
      volume.place.col(axis) *= step.value_or(1);
    }
    ++axis;
  }
  if (!hasDirections && known != 0 && known != 3) {
    return header.wrong("spacings", "has numbers for some axes of space, and nan for others");
  }
  if (auto set = placeByMins(header, *time, hasDirections, volume); !set) return set;
  const std::string origin = header("space origin");
  if (!origin.empty()) {
    const auto vector = vectorsIn(origin);
    if (!vector || vector->size() != 1 || !vector->front()) {
      return header.wrong("space origin", "is not a vector (x,y,z)");
    }
    volume.place.col(3) = *vector->front();
  }
  if (auto taken = takeSpace(header, hasDirections, volume); !taken) return taken;
  return takeUnits(header, *time, volume);
}

/// The name of a data file.
Result<fs::path> dataFile(const Header& header, const fs::path& folder, const std::string& name) {
  const fs::path path(name);
  const auto climbs = [](const fs::path& part) { return part == ".."; };
  if (name.empty() || path.is_absolute() || std::ranges::any_of(path, climbs)) {
    return namesOtherFolder(header.where, name);
  }
  if (auto within = checkDataFile(header.where, folder / path); !within) {
    return within.error();
  }
  return folder / path;
}

/// "frame%03d.raw 1 10 1": a name for each number.
Result<std::vector<std::string>> numbered(const Header& header,
                                          const std::vector<std::string>& words) {
  const std::string& pattern = words[0];
  const auto percent = pattern.find('%');
  const auto letter = pattern.find('d', percent);
  const auto wrong = [&] {
    return header.wrong(
        "data file", "is not a name with %d followed by the first number, the last and the step");
  };
  if (letter == std::string::npos || (words.size() != 4 && words.size() != 5)) return wrong();
  std::string digits = pattern.substr(percent + 1, letter - percent - 1);
  const bool zeros = digits.starts_with('0');
  const auto width =
      digits.empty() ? std::optional<std::uint32_t>(0) : numberIn<std::uint32_t>(digits);
  const auto first = numberIn<std::int64_t>(words[1]);
  const auto last = numberIn<std::int64_t>(words[2]);
  const auto step = numberIn<std::int64_t>(words[3]);
  constexpr std::int64_t kMost = 1'000'000;
  if (!width || *width > 20 || !first || !last || !step || *step == 0 || *first < 0 || *last < 0 ||
      std::max(*first, *last) > std::int64_t{1} << 40U || (*last - *first) / *step >= kMost) {
    return wrong();
  }
  std::vector<std::string> names;
  for (std::int64_t i = *first; *step > 0 ? i <= *last : i >= *last; i += *step) {
    const std::string number =
        zeros ? fmt::format("{:0{}}", i, *width) : fmt::format("{:{}}", i, *width);
    names.push_back(pattern.substr(0, percent) + number + pattern.substr(letter + 1));
  }
  return names;
}

Result<void> findData(const Header& header, const fs::path& path, Volume& volume) {
  SampleData data;
  const std::string encoding = header.word("encoding");
  if (encoding == "raw") {
    data.encoding = SampleEncoding::Raw;
  } else if (encoding == "gzip" || encoding == "gz") {
    data.encoding = SampleEncoding::Gzip;
  } else if (encoding == "text" || encoding == "txt" || encoding == "ascii") {
    data.encoding = SampleEncoding::Text;
  } else {
    return header.wrong("encoding", "is not supported; raw, gzip and text are");
  }
  if (!header("line skip").empty() && header("line skip") != "0") {
    return header.wrong("line skip", "is not supported; only 'byte skip' is");
  }
  std::optional<std::int64_t> skip = 0;
  if (const std::string text = header("byte skip"); !text.empty()) {
    skip = numberIn<std::int64_t>(text);
    const bool fromEnd = skip == -1 && data.encoding == SampleEncoding::Raw;
    if (!skip || !(*skip >= 0 || fromEnd) || (*skip > 0 && data.encoding == SampleEncoding::Text)) {
      return header.wrong("byte skip", "is not a number of bytes to skip");
    }
  }
  const auto bytes = bytesOfSamples(volume);
  if (!bytes) return bytes.error();

  const std::string name = header("data file");
  std::vector<std::string> names = header.list;
  if (name.empty()) {
    if (!header.end()) return invalid("ends within its header", header.where);
    data.path = path;
    data.offset = *header.end();
    volume.data.push_back(data);
  } else if (!name.starts_with("LIST")) {
    const auto words = wordsOf(name);
    if (words.size() > 1 && words[0].find('%') != std::string::npos) {
      auto all = numbered(header, words);
      if (!all) return all.error();
      names = std::move(*all);
    } else {
      names = {name};
    }
  }
  for (const std::string& one : names) {
    auto file = dataFile(header, path.parent_path(), one);
    if (!file) return file.error();
    data.path = *file;
    volume.data.push_back(data);
  }
  if (volume.data.empty()) return header.wrong("data file", "names no file");
  // A short list could have a large file unpacked many times.
  if (std::set(names.begin(), names.end()).size() != names.size()) {
    return header.wrong("data file", "names a file twice; expected a file for each frame");
  }
  if (volume.data.size() > 1 && volume.axes.back() != 't') {
    return header.wrong("data file",
                        fmt::format("names {} files, a frame each, but the last axis is not the "
                                    "time",
                                    volume.data.size()));
  }
  if (volume.data.size() > 1 && volume.data.size() != volume.frames()) {
    return header.wrong("data file", fmt::format("names {} files; expected one for each of {} "
                                                 "frames",
                                                 volume.data.size(), volume.frames()));
  }
  for (SampleData& one : volume.data) {
    if (*skip >= 0) {
      // Of bytes that are compressed, those unpacked are skipped.
      (one.encoding == SampleEncoding::Raw ? one.offset : one.begin) +=
          static_cast<std::uint64_t>(*skip);
      continue;
    }
    std::error_code error;
    const std::uint64_t size = fs::file_size(one.path, error);
    const std::uint64_t wanted = *bytes / volume.data.size();
    if (error || size < wanted) {
      return invalid(fmt::format("is cut off: {} bytes of samples are expected at its end", wanted),
                     one.path.string());
    }
    one.offset = size - wanted;
  }
  return {};
}

}  // namespace

Result<Volume> readNrrdHeader(const fs::path& path) {
  const auto read = Header::read(path);
  if (!read) return read.error();
  const Header& header = *read;
  Volume volume;
  volume.where = header.where;
  const auto type = typeOf(header("type"));
  if (!type) return header.wrong("type", "is not supported; integers, float and double are");
  volume.type = *type;
  const std::string encoding = header.word("encoding");
  if (sizeOf(*type) > 1 && encoding != "text" && encoding != "ascii" && encoding != "txt") {
    const std::string endian = header.word("endian");
    if (endian != "little" && endian != "big") {
      return header.wrong("endian", "is neither little nor big");
    }
    volume.order = endian == "big" ? std::endian::big : std::endian::little;
  } else {
    volume.order = std::endian::native;
  }
  for (const char* required : {"dimension", "sizes", "encoding"}) {
    if (header(required).empty()) return header.wrong(required, "");
  }
  const auto dimension = numberIn<std::uint32_t>(header("dimension"));
  const auto sizes = header.words("sizes");
  if (!dimension || sizes.size() != *dimension || *dimension < 3 || *dimension > 4) {
    return header.wrong("sizes", fmt::format("has {} numbers, and the dimension is '{}'; expected "
                                             "are three axes, or four with the time",
                                             sizes.size(), shown(header("dimension"))));
  }
  for (const std::string& word : sizes) {
    const auto size = numberIn<std::uint64_t>(word);
    if (!size) return header.wrong("sizes", "has a word that is not a number");
    volume.sizes.push_back(*size);
  }
  if (auto placed = place(header, volume); !placed) return placed.error();
  if (auto found = findData(header, path, volume); !found) return found.error();
  if (auto known = header.checkNames(); !known) return known.error();
  return volume;
}

}  // namespace t4d::voxel4d

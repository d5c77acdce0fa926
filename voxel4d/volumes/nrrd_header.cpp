#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include <fmt/format.h>

#include "model/number.h"
#include "platform/regular_file.h"
#include "voxel4d/volumes/header_text.h"
#include "voxel4d/volumes/headers.h"
#include "voxel4d/volumes/sample_reader.h"

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
      const Place where = {header.where, number};
      if (const auto assigned = line.find(":="); assigned < colon) {
        // A key and a value of somebody's own, of which NRRD takes the last.
        header.keys_.insert_or_assign(line.substr(0, assigned), trimmed(line.substr(assigned + 2)));
        continue;
      }
      if (colon == std::string::npos) {
        return invalid(fmt::format("found '{}', expected 'FIELD: VALUE'", shown(line)), where);
      }
      const std::string field = line.substr(0, colon);
      const std::string value = trimmed(line.substr(colon + 2));
      const auto [first, isNew] = header.fields_.emplace(keyOf(field), value);
      // Programs that copy a header may write a field of their own again.
      if (!isNew && first->second != value) {
        return invalid(
            fmt::format("has the field '{}' a second time, now with the value '{}' instead of '{}'",
                        shown(field), shown(value), shown(first->second)),
            where);
      }
      if (keyOf(field) == "datafile" && value.starts_with("LIST")) {
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
  /// The value of a key of somebody's own; empty if it is not there.
  std::string ofKey(const std::string& key) const {
    const auto found = keys_.find(key);
    return found == keys_.end() ? std::string() : found->second;
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
  /// Where the blank line ends, if the samples are in the same file.
  std::optional<std::uint64_t> end() const { return end_; }

  std::string where;
  std::vector<std::string> list;  // of data files

 private:
  using Values = std::map<std::string, std::string>;

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

  Values fields_;
  Values keys_;
  std::optional<std::uint64_t> end_;
};

/// Vectors of a space, whose fourth number is the time, and 0 in a space of three dimensions.
using SpaceVectors = std::vector<std::optional<Eigen::Vector4d>>;

/// "(1,0,0) none (0, 1, 0)": a vector of `dimension` numbers or nothing for each.
std::optional<SpaceVectors> vectorsIn(const std::string& text, std::size_t dimension) {
  SpaceVectors vectors;
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
    if (words.size() != dimension) return std::nullopt;
    Eigen::Vector4d vector = Eigen::Vector4d::Zero();
    bool isKnown = false;
    for (std::size_t i = 0; i < dimension; ++i) {
      const auto number = numberIn<double>(words[i]);
      if (!number) return std::nullopt;
      vector[static_cast<Eigen::Index>(i)] = *number;
      isKnown = isKnown || !std::isnan(*number);
    }
    vectors.emplace_back();
    if (isKnown) vectors.back() = vector;  // old files have nan for none
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

/// Sets where axes begin for samples without directions.
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

/// A space: its name without the time, and its dimensions with it.
struct Space {
  std::string name;
  std::size_t dimension = 3;

  std::string_view vector() const { return dimension == 4 ? "(x,y,z,t)" : "(x,y,z)"; }
};

Result<Space> spaceOf(const Header& header) {
  Space space{header.word("space")};
  static const std::map<std::string, std::string> kShort = {
      {"rast", "right-anterior-superior-time"},
      {"last", "left-anterior-superior-time"},
      {"lpst", "left-posterior-superior-time"},
      {"ras", "right-anterior-superior"},
      {"las", "left-anterior-superior"},
      {"lps", "left-posterior-superior"},
      {"3drh", "3d-right-handed"},
      {"3dlh", "3d-left-handed"},
      {"3drht", "3d-right-handed-time"},
      {"3dlht", "3d-left-handed-time"}};
  if (const auto found = kShort.find(space.name); found != kShort.end()) space.name = found->second;
  constexpr std::string_view kTime = "-time";
  if (space.name.ends_with(kTime)) {
    space.name.resize(space.name.size() - kTime.size());
    space.dimension = 4;
  }
  constexpr std::array<std::string_view, 6> kNames = {
      "right-anterior-superior", "left-anterior-superior", "left-posterior-superior", "scanner-xyz",
      "3d-right-handed",         "3d-left-handed"};
  if (!space.name.empty() && std::ranges::find(kNames, space.name) == kNames.end()) {
    return header.wrong("space",
                        "is not known; NRRD has right-anterior-superior, "
                        "left-anterior-superior, left-posterior-superior, scanner-xyz, "
                        "3D-right-handed and 3D-left-handed, each also with -time");
  }
  const std::string dimension = header("space dimension");
  if (dimension.empty()) return space;
  if (dimension != "3" && dimension != "4") {
    return header.wrong("space dimension", "is not 3, or 4 with the time");
  }
  const std::size_t given = dimension == "3" ? 3 : 4;
  if (!space.name.empty() && given != space.dimension) {
    return header.wrong("space dimension", fmt::format("contradicts the space '{}', which has {}",
                                                       shown(header("space")), space.dimension));
  }
  space.dimension = given;
  return space;
}

/// The axis along which the time of a space of four dimensions changes, if there is one.
Result<std::optional<std::size_t>> timeAxisInSpace(const Header& header,
                                                   const SpaceVectors& directions) {
  std::optional<std::size_t> time;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    if (!directions[i] || (*directions[i])[3] == 0) continue;
    if (time || !directions[i]->head<3>().isZero(0)) {
      return header.wrong("space directions",
                          "mixes space and time; expected the fourth number to be other than 0 for "
                          "one axis, the time, and the first three to be 0 there");
    }
    time = i;
  }
  return time;
}

/// The axis that is the time, if one is.
Result<std::optional<std::size_t>> timeAxisOf(const Header& header, const SpaceVectors& directions,
                                              std::size_t count) {
  const auto inSpace = timeAxisInSpace(header, directions);
  if (!inSpace) return inSpace.error();
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
    if (!ofTime && !bare && *inSpace != i) continue;
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
void takeSpace(const Space& space, bool hasDirections, Volume& volume) {
  if (!hasDirections) return;  // the axes of the data are not those of the space
  const bool las = space.name == "left-anterior-superior";
  if (space.name == "left-posterior-superior") volume.space = "LPS";
  if (las || space.name == "right-anterior-superior") volume.space = "RAS";
  if (las) {
    volume.place.row(0) *= -1;
    volume.notice =
        "its space, left-anterior-superior, is left-handed: x is negated, which makes "
        "it right-anterior-superior (RAS)";
  }
  if (space.name == "3d-left-handed") {
    volume.place.row(2) *= -1;
    volume.notice = "its space is left-handed: z is negated, so that the solid is not mirrored";
  }
}

/// Sets the units of length and time. `units` and `space units` must agree where both give one.
Result<void> takeUnits(const Header& header, const std::optional<std::size_t>& time,
                       std::size_t dimension, Volume& volume) {
  const std::size_t count = volume.sizes.size();
  auto ofSpace = unitsIn(header("space units"), dimension);
  const auto ofAxes = unitsIn(header("units"), count);
  if (!ofSpace && !header("space units").empty()) {
    return header.wrong(
        "space units", fmt::format("is not a unit in quotes for each of {} dimensions", dimension));
  }
  if (!ofAxes && !header("units").empty()) {
    return header.wrong("units", fmt::format("is not a unit in quotes for each of {} axes", count));
  }
  if (ofSpace) {
    if (dimension == 4) {
      volume.timeUnit = ofSpace->back();
      ofSpace->pop_back();
    }
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
      if (!volume.timeUnit.empty() && !here.empty() && volume.timeUnit != here) {
        return header.wrong("units", fmt::format("contradicts the space units, '{}' of time",
                                                 shown(volume.timeUnit)));
      }
      if (!here.empty()) volume.timeUnit = here;
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

/// "1%2E5" as "1.5": sequences of 3D Slicer have their index values encoded as in URLs.
std::string decoded(const std::string& text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool may = text[i] == '%' && i + 2 < text.size();
    const auto code = model::numberIn<std::uint8_t>(text.substr(i + 1, may ? 2 : 0), 16);
    if (code) {
      plain += static_cast<char>(*code);
      i += 2;
    } else {
      plain += text[i];
    }
  }
  return plain;
}

/// The times of frames in a sequence of 3D Slicer (.seq.nrrd), which are its index values.
Result<void> takeIndexValues(const Header& header, std::size_t time, Volume& volume) {
  const std::string key = fmt::format("axis {} index values", time);
  const auto words = wordsOf(header.ofKey(key));
  if (words.empty()) return {};
  const auto wrong = [&](const std::string& message) {
    return invalid(fmt::format("its '{}' {}", key, message), header.where);
  };
  if (words.size() != volume.sizes[time]) {
    return wrong(fmt::format("has {} values for {} frames", words.size(), volume.sizes[time]));
  }
  const std::string type = lowerCase(header.ofKey(fmt::format("axis {} index type", time)));
  if (type == "text") {
    volume.notice += fmt::format("{}its '{}' are texts, so they are not used as times",
                                 volume.notice.empty() ? "" : "; ", key);
    return {};
  }
  for (const std::string& word : words) {
    const auto value = numberIn<double>(decoded(word));
    if (!value || !std::isfinite(*value)) {
      return wrong(fmt::format("has '{}' where a number is expected", shown(word)));
    }
    if (!volume.times.empty() && !(*value > volume.times.back())) {
      return wrong(fmt::format("has {} for frame {}, after {}; times must increase", *value,
                               volume.times.size(), volume.times.back()));
    }
    volume.times.push_back(*value);
  }
  if (volume.times.size() == 1) {
    volume.times.clear();  // the time of a frame in a file of its own is not used
    return {};
  }
  volume.startTime = volume.times.front();
  return {};
}

/// Sets which axis is which, and where samples are.
Result<void> place(const Header& header, Volume& volume) {
  const std::size_t count = volume.sizes.size();
  const auto space = spaceOf(header);
  if (!space) return space.error();
  const auto directions = vectorsIn(header("space directions"), space->dimension);
  if (!directions || (!directions->empty() && directions->size() != count)) {
    return header.wrong(
        "space directions",
        fmt::format("is not a vector {}, or none, for each of {} axes", space->vector(), count));
  }
  const bool hasDirections = !directions->empty();
  const auto time = timeAxisOf(header, *directions, count);
  if (!time) return time.error();
  int axis = 0;
  for (std::size_t i = 0; i < count; ++i) volume.axes += i == *time ? 't' : "xyz"[axis++];

  const auto spacings = header.numbers("spacings", count);
  if (!spacings) return spacings.error();
  constexpr double kRounding = 1e-4;  // of numbers in six digits
  int known = 0;
  axis = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto step = spacings->empty() ? std::nullopt : (*spacings)[i];
    if (i == *time) {
      volume.frameTime = step;
      const bool inSpace = hasDirections && (*directions)[i] && (*(*directions)[i])[3] != 0;
      if (!inSpace) continue;
      const double apart = (*(*directions)[i])[3];
      if (step && !(std::abs(*step - apart) <= kRounding * std::abs(apart))) {
        return header.wrong("spacings", fmt::format("contradicts the direction of axis {}, along "
                                                    "which frames are {} apart",
                                                    i, apart));
      }
      volume.frameTime = apart;
      continue;
    }
    known += step ? 1 : 0;
    if (hasDirections) {
      volume.place.col(axis) = (*directions)[i]->head<3>();
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
  if (!hasDirections && known == 0) volume.unsized = "xyz";
  if (auto set = placeByMins(header, *time, hasDirections, volume); !set) return set;
  const std::string origin = header("space origin");
  if (!origin.empty()) {
    const auto vector = vectorsIn(origin, space->dimension);
    if (!vector || vector->size() != 1 || !vector->front()) {
      return header.wrong("space origin", fmt::format("is not a vector {}", space->vector()));
    }
    volume.place.col(3) = vector->front()->head<3>();
    if (space->dimension == 4) volume.startTime = (*vector->front())[3];
  }
  takeSpace(*space, hasDirections, volume);
  if (auto taken = takeUnits(header, *time, space->dimension, volume); !taken) return taken;
  return *time ? takeIndexValues(header, **time, volume) : Result<void>();
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

/// The part of a data file before its samples.
struct Skips {
  std::uint64_t lines = 0;
  /// Bytes after the lines, unpacked if they are compressed. Nothing: the samples are at the end.
  std::optional<std::uint64_t> bytes = 0;
};

Result<Skips> skipsOf(const Header& header, SampleEncoding encoding) {
  Skips skips;
  if (const std::string text = header("line skip"); !text.empty()) {
    const auto lines = numberIn<std::uint64_t>(text);
    if (!lines) return header.wrong("line skip", "is not a number of lines to skip");
    skips.lines = *lines;
  }
  const std::string text = header("byte skip");
  if (text == "-1" && encoding != SampleEncoding::Text) {
    skips.bytes.reset();
  } else if (!text.empty()) {
    skips.bytes = numberIn<std::uint64_t>(text);
    if (!skips.bytes) {
      return header.wrong("byte skip",
                          "is not a number of bytes to skip, or -1 for samples at the end of raw "
                          "or gzip data");
    }
  }
  return skips;
}

/// The place in a file after this many lines from `offset` on.
Result<std::uint64_t> afterLines(const fs::path& path, std::uint64_t offset, std::uint64_t lines) {
  auto file = openHeader(path);
  if (!file) return file.error();
  file->seekg(static_cast<std::streamoff>(offset));
  std::array<char, 65536> bytes;
  for (std::uint64_t found = 0; found < lines;) {
    file->read(bytes.data(), bytes.size());
    const auto got = static_cast<std::size_t>(file->gcount());
    if (got == 0) {
      return invalid(
          fmt::format("is cut off: it has {} lines to skip; its header says {}", found, lines),
          path.string());
    }
    for (std::size_t i = 0; i < got && found < lines; ++i, ++offset) {
      if (bytes[i] == '\n') ++found;
    }
  }
  return offset;
}

/// Sets where `wanted` bytes of samples are in a file of data.
Result<void> skip(const Skips& skips, std::uint64_t wanted, SampleData& data) {
  if (skips.lines > 0) {
    const auto after = afterLines(data.path, data.offset, skips.lines);
    if (!after) return after.error();
    data.offset = *after;
  }
  const bool isPacked = data.encoding == SampleEncoding::Gzip;
  if (skips.bytes) {
    (isPacked ? data.begin : data.offset) += *skips.bytes;
    return {};
  }
  std::uint64_t size = 0;
  if (isPacked) {
    const auto unpacked = unpackedBytes(data.path, data.offset);
    if (!unpacked) return unpacked.error();
    size = *unpacked;
  } else {
    const auto stored = platform::sizeOfRegularFile(data.path);
    if (!stored) return stored.error();
    size = *stored - std::min(*stored, data.offset);
  }
  if (size < wanted) {
    return invalid(fmt::format("is cut off: {} bytes of samples are expected at its end, and it "
                               "has {}",
                               wanted, size),
                   data.path.string());
  }
  (isPacked ? data.begin : data.offset) += size - wanted;
  return {};
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
  const auto skips = skipsOf(header, data.encoding);
  if (!skips) return skips.error();
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
    if (auto done = skip(*skips, *bytes / volume.data.size(), one); !done) return done;
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

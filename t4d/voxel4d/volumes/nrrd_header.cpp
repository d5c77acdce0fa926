#include <algorithm>
#include <cmath>
#include <map>

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
  const auto alias = kAliases.find(name);
  return sampleTypeNamed(alias == kAliases.end() ? name : alias->second);
}

/// The lines of a header, by the name of their field.
class Header {
 public:
  static Result<Header> read(const fs::path& path) {
    Header header;
    header.where = path.string();
    std::ifstream file(path, std::ios::binary);
    if (!file) return fail(ErrorCode::Io, "cannot be opened", header.where);
    std::string line;
    constexpr std::uint64_t kLongest = 1U << 20U;
    std::uint64_t bytes = 0;
    for (std::uint64_t number = 1; takeLine(file, line, bytes); ++number) {
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
      if (line.front() == '#' || line.find(":=") != std::string::npos) continue;
      const auto colon = line.find(": ");
      if (colon == std::string::npos) {
        return invalid(fmt::format("found '{}', expected 'FIELD: VALUE'", shown(line)),
                       fmt::format("{}:{}", header.where, number));
      }
      const std::string field = line.substr(0, colon);
      header.fields_[field] = trimmed(line.substr(colon + 2));
      if ((field == "data file" || field == "datafile") &&
          header.fields_[field].starts_with("LIST")) {
        while (takeLine(file, line, bytes)) {
          if (!line.empty()) header.list.push_back(line);
        }
        return header;
      }
    }
    if (bytes == 0) return invalid("is empty", header.where);
    return header;  // a detached header ends with its file
  }

  /// Empty if it is not there; NRRD allows some names with and without a blank.
  std::string operator()(const std::string& field) const {
    auto found = fields_.find(field);
    if (found == fields_.end()) {
      std::string joined = field;
      std::erase(joined, ' ');
      found = fields_.find(joined);
    }
    return found == fields_.end() ? std::string() : found->second;
  }
  std::vector<std::string> words(const std::string& field) const { return wordsOf((*this)(field)); }
  tl::unexpected<Error> wrong(const std::string& field, const std::string& message) const {
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
    if (text.compare(at, 4, "none") == 0) {
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
    vectors.emplace_back(vector);
    at = close + 1;
  }
}

/// The words of a list in quotes: "mm" "mm" "s".
std::vector<std::string> quoted(const std::string& text) {
  std::vector<std::string> words;
  for (std::size_t at = 0;;) {
    const auto begin = text.find('"', at);
    const auto end = begin == std::string::npos ? begin : text.find('"', begin + 1);
    if (end == std::string::npos) return words;
    words.push_back(text.substr(begin + 1, end - begin - 1));
    at = end + 1;
  }
}

/// Where axes begin, of samples without directions.
Result<void> placeByMins(const Header& header, const std::optional<std::size_t>& time,
                         Volume& volume) {
  const bool spaced = !header("spacings").empty() || !header("space directions").empty();
  if (!header("axis maxs").empty() && !spaced) {
    return header.wrong("axis maxs", "is not supported; give spacings");
  }
  const auto mins = header.words("axis mins");
  if (mins.empty()) return {};
  if (mins.size() != volume.sizes.size()) {
    return header.wrong("axis mins", fmt::format("does not have a number for each of {} axes",
                                                 volume.sizes.size()));
  }
  for (const char* field : {"centers", "centerings"}) {
    const auto centers = header.words(field);
    if (std::ranges::find(centers, "cell") == centers.end()) continue;
    return header.wrong(field, "is not supported with axis mins; give a space origin");
  }
  int axis = 0;
  for (std::size_t i = 0; i < mins.size(); ++i) {
    double min = numberIn<double>(mins[i]).value_or(0);
    if (!std::isfinite(min)) min = 0;
    (i == time ? volume.startTime : volume.place(axis++, 3)) = min;
  }
  return {};
}

/// Sets which axis is which, and where samples are.
Result<void> place(const Header& header, Volume& volume) {
  const std::size_t count = volume.sizes.size();
  const auto kinds = header.words("kinds");
  const auto directions = vectorsIn(header("space directions"));
  if (!kinds.empty() && kinds.size() != count) {
    return header.wrong("kinds", fmt::format("does not have a word for each of {} axes", count));
  }
  std::string space = header("space");
  std::ranges::transform(space, space.begin(), [](unsigned char c) { return std::tolower(c); });
  const bool hasTime = space.ends_with("-time") || space == "rast" || space == "last" ||
                       space == "lpst" || space == "3drht" || space == "3dlht";
  if (hasTime) {
    return header.wrong("space",
                        "has four dimensions; expected is a space of three, with directions of "
                        "three numbers, and 'none' for the axis of time");
  }
  if (const std::string dimension = header("space dimension");
      !dimension.empty() && dimension != "3") {
    return header.wrong("space dimension", "is not 3, with 'none' for the direction of time");
  }
  if (!directions || (!directions->empty() && directions->size() != count)) {
    return header.wrong(
        "space directions",
        fmt::format("is not a vector (x,y,z), or none, for each of {} axes", count));
  }
  std::optional<std::size_t> time;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string kind = kinds.empty() ? "" : kinds[i];
    const bool ofTime = kind == "time" || kind == "list";
    const bool ofSpace = kind == "space" || kind == "domain";
    const bool bare = !directions->empty() && !(*directions)[i];
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
  if (!time && count == 4 && !directions->empty()) {
    return header.wrong("space directions",
                        "gives all four axes a direction, so none is the time; expected is 'none' "
                        "for the axis of time, or its kind, time");
  }
  if (!time && count == 4) time = 3;
  if (count != (time ? 4U : 3U)) {
    return header.wrong("dimension", "is not three axes of space, with or without one of time");
  }
  int axis = 0;
  for (std::size_t i = 0; i < count; ++i) volume.axes += i == time ? 't' : "xyz"[axis++];

  const auto spacings = header.words("spacings");
  if (!spacings.empty() && spacings.size() != count) {
    return header.wrong("spacings",
                        fmt::format("does not have a number for each of {} axes", count));
  }
  const auto spacing = [&](std::size_t i) -> std::optional<double> {
    if (spacings.empty()) return std::nullopt;
    const auto number = numberIn<double>(spacings[i]);
    return number && std::isfinite(*number) ? number : std::nullopt;
  };
  axis = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i == time) {
      volume.frameTime = spacing(i);
      continue;
    }
    if (!directions->empty()) {
      volume.place.col(axis) = *(*directions)[i];
      volume.isPlaced = true;
    } else if (const auto step = spacing(i)) {
      volume.place.col(axis) *= *step;
      volume.isPlaced = true;
    }
    ++axis;
  }
  if (auto set = placeByMins(header, time, volume); !set) return set;
  const std::string origin = header("space origin");
  if (!origin.empty()) {
    const auto vector = vectorsIn(origin);
    if (!vector || vector->size() != 1 || !vector->front()) {
      return header.wrong("space origin", "is not a vector (x,y,z)");
    }
    volume.place.col(3) = *vector->front();
  }
  const auto units = quoted(header("units"));
  const auto spaceUnits = quoted(header("space units"));
  for (const std::string& unit : spaceUnits) {
    if (unit != spaceUnits.front()) return header.wrong("space units", "are not all the same");
    volume.lengthUnit = unit;
  }
  bool first = true;
  for (std::size_t i = 0; units.size() == count && i < count; ++i) {
    if (i == time) {
      volume.timeUnit = units[i];
      continue;
    }
    if (!first && units[i] != volume.lengthUnit) {
      return header.wrong("units", "are not the same along all axes of space");
    }
    volume.lengthUnit = units[i];
    first = false;
  }
  return {};
}

/// The name of a data file; it is in the folder of the header, or below.
Result<fs::path> dataFile(const Header& header, const fs::path& folder, const std::string& name) {
  const fs::path path(name);
  const auto climbs = [](const fs::path& part) { return part == ".."; };
  if (name.empty() || path.is_absolute() || std::ranges::any_of(path, climbs)) {
    return invalid(fmt::format("names the data file '{}'; it must be in the same folder or below, "
                               "so that a header from elsewhere cannot have other files read",
                               shown(name)),
                   header.where);
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
  const std::string encoding = header("encoding");
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
  if (!bytes) return pass(bytes.error());

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
      if (!all) return pass(all.error());
      names = std::move(*all);
    } else {
      names = {name};
    }
  }
  for (const std::string& one : names) {
    auto file = dataFile(header, path.parent_path(), one);
    if (!file) return pass(file.error());
    data.path = *file;
    volume.data.push_back(data);
  }
  if (volume.data.empty()) return header.wrong("data file", "names no file");
  if (volume.data.size() > 1 && volume.axes.back() != 't') {
    return header.wrong("data file",
                        fmt::format("names {} files, a frame each, but the last axis is not the "
                                    "time",
                                    volume.data.size()));
  }
  if (volume.data.size() > 1 && volume.data.size() != volume.frames()) {
    return header.wrong("data file", fmt::format("names {} files; expected is one for each of {} "
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
  if (!read) return pass(read.error());
  const Header& header = *read;
  Volume volume;
  volume.where = header.where;
  const auto type = typeOf(header("type"));
  if (!type) return header.wrong("type", "is not supported; integers, float and double are");
  volume.type = *type;
  if (sizeOf(*type) > 1 && header("encoding") != "text" && header("encoding") != "ascii" &&
      header("encoding") != "txt") {
    const std::string endian = header("endian");
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
  if (auto placed = place(header, volume); !placed) return pass(placed.error());
  if (auto found = findData(header, path, volume); !found) return pass(found.error());
  return volume;
}

}  // namespace t4d::voxel4d

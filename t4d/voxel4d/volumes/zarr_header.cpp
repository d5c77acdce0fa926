#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include "t4d/voxel4d/volumes/header_text.h"
#include "t4d/voxel4d/volumes/unit_names.h"
#include "t4d/voxel4d/volumes/zarr.h"
#include "t4d/voxel4d/volumes/zarr_samples.h"

namespace t4d::voxel4d {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// What an image says of its axes and where its samples are.
struct ZarrImage {
  std::string axes;          ///< x, y, z, t or c for each axis of its arrays
  bool axesAssumed = false;  ///< the array does not name them, and neither does the caller
  /// Whether each axis has a scale in a unit. One of 1 without a unit says nothing.
  std::vector<bool> scaled;
  std::vector<double> scale;
  std::vector<double> translation;
  std::string lengthUnit;
  std::string timeUnit;
};

std::string textOf(const json& value) {
  return value.is_string() ? value.get<std::string>() : std::string();
}

/// x, y, z, t or c by a name or a type; 0 for another.
char axisNamed(const std::string& given, const std::string& type = {}) {
  const std::string name = lowerCase(given);
  if (name == "t" || name == "time" || type == "time")
    return type.empty() || type == "time" ? 't' : 0;
  if (name == "c" || name == "channel" || type == "channel") {
    return type.empty() || type == "channel" ? 'c' : 0;
  }
  const bool isSpace = type.empty() || type == "space";
  return isSpace && name.size() == 1 && name[0] >= 'x' && name[0] <= 'z' ? name[0] : 0;
}

Error cannotTellAxes(const std::string& said, const std::string& where) {
  return invalid(fmt::format("has the axes {}, which do not tell x, y, z, t and c", said), where,
                 Remedy::Axes);
}

/// Whether x and y are there, and none twice.
bool areUsable(const std::string& axes) {
  return std::set(axes.begin(), axes.end()).size() == axes.size() &&
         axes.find_first_not_of("ctxyz") == std::string::npos &&
         axes.find('x') != std::string::npos && axes.find('y') != std::string::npos;
}

// OME-Zarr --------------------------------------------------------------------------------------

/// Reads the multiscales of one group.
class OmeReader {
 public:
  OmeReader(const json& image, std::string where) : image_(image), where_(std::move(where)) {}

  /// `given` overrides the axes that the file names, if it is not empty.
  Result<ZarrImage> axes(std::string_view given) const {
    ZarrImage image;
    const json& axes = memberOf(image_, "axes");
    if (axes.is_null()) {  // before version 0.3
      image.axes = given.empty() ? "tczyx" : given;
      return image;
    }
    if (!axes.is_array() || axes.empty()) return wrong("axes", axes);
    std::vector<std::string> names;
    for (const json& axis : axes) {
      const std::string name = textOf(axis.is_string() ? axis : memberOf(axis, "name"));
      const char letter = given.size() == axes.size()
                              ? given[names.size()]
                              : axisNamed(name, textOf(memberOf(axis, "type")));
      names.push_back(shown(name));
      image.axes += letter;
    }
    if (!areUsable(image.axes)) {
      return cannotTellAxes(fmt::format("'{}'", fmt::join(names, "', '")), where_);
    }
    if (auto done = readUnits(axes, image); !done) return done.error();
    return image;
  }

  const json& levels() const { return memberOf(image_, "datasets"); }

  /// The path of a level, which must be in this group.
  Result<std::string> pathOf(const json& level) const {
    const json& path = memberOf(level, "path");
    const std::string text = textOf(path);
    bool good = !text.empty() && text.size() < 1000 && text.find('\\') == std::string::npos &&
                text.find_first_of("?#") == std::string::npos &&
                std::ranges::all_of(text, [](unsigned char c) { return c >= 32 && c != 127; });
    for (const fs::path& part : fs::path(text)) {
      if (part == ".." || part == "." || part.empty() || part == "/") good = false;
    }
    if (good) return text;
    return invalid(fmt::format("names the level '{}'; a level must be in the group",
                               shown(path.is_string() ? text : path.dump().substr(0, 40))),
                   where_);
  }

  /// Scale and translation of a level, and then of the whole.
  Result<void> place(const json& level, ZarrImage& image) const {
    image.scale.assign(image.axes.size(), 1);
    image.translation.assign(image.axes.size(), 0);
    bool hasScale = false;
    for (const json* from : {&level, &image_}) {
      const json& list = memberOf(*from, "coordinateTransformations");
      if (list.is_null()) continue;
      if (!list.is_array()) return wrong("coordinateTransformations", list);
      for (const json& one : list) {
        if (auto done = apply(one, image); !done) return done;
        hasScale = hasScale || textOf(memberOf(one, "type")) == "scale";
      }
    }
    for (std::size_t axis = 0; axis < image.axes.size(); ++axis) {
      const std::string& unit = image.axes[axis] == 't' ? image.timeUnit : image.lengthUnit;
      image.scaled.push_back(hasScale && (!unit.empty() || image.scale[axis] != 1));
    }
    return {};
  }

 private:
  Result<void> readUnits(const json& axes, ZarrImage& image) const {
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const std::string unit = shown(unitNamed(textOf(memberOf(axes[i], "unit"))));
      if (unit.empty() || image.axes[i] == 'c') continue;
      std::string& known = image.axes[i] == 't' ? image.timeUnit : image.lengthUnit;
      if (!known.empty() && known != unit) {
        return invalid(
            fmt::format("has axes in {} and in {}; expected one unit of length", known, unit),
            where_);
      }
      known = unit;
    }
    return {};
  }

  Result<void> apply(const json& transformation, ZarrImage& image) const {
    const std::string type = textOf(memberOf(transformation, "type"));
    if (type == "identity") return {};
    const json& list = memberOf(transformation, type == "scale" ? "scale" : "translation");
    if ((type != "scale" && type != "translation") || list.is_null()) {
      return fail(ErrorCode::Unsupported,
                  fmt::format("has the transformation {}; scale and translation with their numbers "
                              "can be read",
                              shownJson(transformation)),
                  where_);
    }
    if (!list.is_array() || list.size() != image.axes.size()) return wrong(type, list);
    for (std::size_t axis = 0; axis < list.size(); ++axis) {
      if (!list[axis].is_number() || !std::isfinite(list[axis].get<double>())) {
        return wrong(type, list);
      }
      const auto number = list[axis].get<double>();
      if (type == "scale") {
        image.scale[axis] *= number;
        image.translation[axis] *= number;
      } else {
        image.translation[axis] += number;
      }
    }
    return {};
  }

  Error wrong(std::string_view name, const json& value) const {
    return invalid(fmt::format("its image has the {} {}, which cannot be", name, shownJson(value)),
                   where_);
  }

  const json& image_;
  std::string where_;
};

// Arrays ----------------------------------------------------------------------------------------

/// Axes of an array that is alone: those given, those it names, or, which `assumed` says, as of a
/// .npy file.
Result<std::string> axesOfArray(const ZarrNode& node, std::string_view given, bool& assumed) {
  const ZarrArray& array = *node.array;
  const std::size_t count = array.shape.size();
  if (!given.empty()) {
    std::string axes(given);
    if (axes.size() == count + 1) std::erase(axes, 't');
    if (axes.size() == count) return axes;
    return invalid(fmt::format("has {} axes, not those of '{}'", count, given), node.where);
  }
  std::vector<std::string> names = array.names;
  if (const json& of = memberOf(node.attributes, "_ARRAY_DIMENSIONS");
      names.empty() && of.is_array()) {
    for (const json& name : of) names.push_back(textOf(name));
  }
  std::string axes;
  for (const std::string& name : names) {
    if (const char axis = axisNamed(name)) axes += axis;
  }
  if (axes.size() == count && areUsable(axes)) return axes;
  assumed = true;
  if (count == 4) return std::string("txyz");
  if (count == 3) return std::string("xyz");
  return cannotTellAxes(fmt::format("of a shape {}", fmt::join(array.shape, " x ")), node.where);
}

/// Whether an array has frames and channels as another.
Result<void> checkLevel(const ZarrArray& array, const ZarrArray& first, const std::string& axes,
                        const std::string& where) {
  if (array.shape.size() != axes.size()) {
    return invalid(
        fmt::format("has {} axes, but its image has {}", array.shape.size(), axes.size()), where);
  }
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (axes[i] != 't' && axes[i] != 'c') continue;
    if (array.shape[i] == first.shape.at(i)) continue;
    return invalid(fmt::format("has {} {}, but the finest level {}", array.shape[i],
                               axes[i] == 't' ? "frames" : "channels", first.shape[i]),
                   where);
  }
  return {};
}

/// Files with chunks, and their bytes.
struct Stored {
  std::uint64_t files = 0;
  std::uint64_t bytes = 0;
};

/// Of an array in a folder, counted until there are enough.
template <class IsEnough>
Stored storedInFolder(const fs::path& folder, const IsEnough& isEnough) {
  Stored stored;
  std::error_code problem;
  fs::recursive_directory_iterator entry(folder, problem);
  for (; !problem && entry != fs::recursive_directory_iterator(); entry.increment(problem)) {
    if (isEnough(stored)) return stored;
    std::error_code ignored;
    const std::string name = entry->path().filename().string();
    if (name.starts_with(".z") || name == "zarr.json") continue;
    if (!entry->is_regular_file(ignored)) continue;
    ++stored.files;
    const std::uintmax_t size = entry->file_size(ignored);
    if (!ignored) stored.bytes += size;
  }
  return stored;
}

/// Bytes of some files of the frame in the middle, from its middle on, up to so many.
std::uint64_t storedOnServer(const ZarrSamples& samples, std::uint64_t enough) {
  constexpr std::uint64_t kMostFiles = 64;
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30U;
  constexpr std::uint64_t kPart = std::uint64_t{1} << 16U;
  const ZarrArray& array = samples.array;
  std::uint64_t stored = 0;
  for (std::uint64_t i = 0; i < kMostFiles && stored < enough; ++i) {
    std::vector<std::uint64_t> number;
    for (std::size_t axis = 0; axis < array.shape.size(); ++axis) {
      const std::uint64_t size =
          array.chunk[axis] * (array.shards ? array.shards->chunks[axis] : 1);
      const std::uint64_t files = (array.shape[axis] - 1) / size + 1;
      const bool inSpace = samples.axes[axis] != 't' && samples.axes[axis] != 'c';
      number.push_back(samples.axes[axis] == 'c' ? samples.channel / size
                                                 : (files / 2 + (inSpace ? i : 0)) % files);
    }
    const std::string key = array.key(number);
    // Shards may be large.
    if (array.shards && samples.store->read(key, ZarrPart{0, kPart}).value_or(std::nullopt)) {
      stored += kPart;
    } else if (const auto file = samples.store->read(key, kMostBytes).value_or(std::nullopt)) {
      stored += file->size();
    }
  }
  return stored;
}

Result<Volume> volumeOf(std::shared_ptr<ZarrSamples> samples, const ZarrImage& image,
                        const std::optional<std::uint32_t>& channel, const std::string& where,
                        const fs::path& path) {
  const std::size_t channelAxis = samples->axes.find('c');
  const auto chosen = chosenChannel(
      channelAxis == std::string::npos ? 1 : samples->array.shape[channelAxis], channel, where);
  if (!chosen) return chosen.error();
  samples->channel = *chosen;
  Volume volume;
  volume.where = where;
  volume.type = samples->array.type;
  volume.order = std::endian::native;
  volume.axes = spaceAxes(*samples);
  if (samples->axes.find('t') != std::string::npos) volume.axes += 't';
  for (const char axis : volume.axes) {
    volume.sizes.push_back(samples->array.shape[samples->axes.find(axis)]);
  }
  for (std::size_t i = 0; i < image.scale.size(); ++i) {
    const char axis = image.axes[i];
    if (axis == 't') {
      if (image.scaled[i]) volume.frameTime = image.scale[i];
      volume.startTime = image.translation[i];
    } else if (axis != 'c') {
      if (!image.scaled[i]) volume.unsized += axis;
      volume.place(axis - 'x', axis - 'x') = image.scale[i];
      volume.place(axis - 'x', 3) = image.translation[i];
    }
  }
  if (image.scale.empty()) volume.unsized = "xyz";
  if (image.axesAssumed) volume.assumedAxes = samples->axes;
  volume.lengthUnit = image.lengthUnit;
  volume.timeUnit = image.timeUnit;
  SampleData data{.path = path};
  data.encoding = SampleEncoding::Zarr;
  data.zarr = std::move(samples);
  volume.data = {std::move(data)};
  return volume;
}

Result<Volume> readPyramid(std::shared_ptr<const ZarrStore> store, const ZarrNode& group,
                           const json& image, const ZarrChoice& choice, const fs::path& path) {
  const OmeReader reader(image, group.where);
  auto axes = reader.axes(choice.axes);
  if (!axes) return axes.error();
  const json& levels = reader.levels();
  constexpr std::size_t kMostLevels = 100;
  if (!levels.is_array() || levels.empty() || levels.size() > kMostLevels) {
    return invalid("its image names no levels (datasets), or too many", group.where);
  }
  if (choice.level >= levels.size()) {
    return invalid(fmt::format("has {} level{}, so there is no level {} (counted from 0)",
                               levels.size(), levels.size() == 1 ? "" : "s", choice.level),
                   group.where);
  }
  std::vector<std::string> absent;
  std::optional<ZarrArray> first;
  auto samples = std::make_shared<ZarrSamples>();
  std::string where;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const auto at = reader.pathOf(levels[i]);
    if (!at) return at.error();
    auto node = readZarrNode(*store, *at);
    const bool there = node && *node && (*node)->array;
    if (!there) {
      if (!node && i == choice.level) return node.error();
      if (i == choice.level)
        return invalid("there is no array, but it is a level of the image", store->nameOf(*at));
      absent.push_back(*at);
      continue;
    }
    const ZarrArray& array = *(*node)->array;
    if (auto good = checkLevel(array, first.value_or(array), axes->axes, (*node)->where); !good) {
      return good.error();
    }
    if (!first) first = array;
    if (i != choice.level) continue;
    samples->array = array;
    where = (*node)->where;
  }
  if (auto placed = reader.place(levels[choice.level], *axes); !placed) return placed.error();
  samples->store = std::move(store);
  samples->axes = axes->axes;
  auto volume = volumeOf(std::move(samples), *axes, choice.channel, where, path);
  if (volume && !absent.empty()) {
    volume->notice = fmt::format("levels that cannot be read: {}", fmt::join(absent, ", "));
  }
  return volume;
}

/// What is to be read of an array.
struct Announced {
  std::uint64_t frameBytes = 1;
  std::uint64_t frameChunks = 1;
  std::uint64_t chunks = 1;

  static void multiply(std::uint64_t& number, std::uint64_t by) {
    constexpr std::uint64_t kMost = std::uint64_t{1} << 62U;
    number = by > kMost / number ? kMost : number * by;
  }
};

Announced announcedBy(const Volume& volume) {
  const ZarrSamples& samples = *volume.data[0].zarr;
  Announced announced;
  announced.frameBytes = sizeOf(volume.type);
  for (std::size_t i = 0; i < samples.axes.size(); ++i) {
    if (samples.axes[i] == 'c') continue;
    const std::uint64_t size = volume.size(samples.axes[i]);
    const std::uint64_t first = volume.first(samples.axes[i]);
    const std::uint64_t chunk = samples.array.chunk[i];
    const std::uint64_t chunks = (first + size - 1) / chunk - first / chunk + 1;
    Announced::multiply(announced.chunks, chunks);
    if (samples.axes[i] == 't') continue;
    Announced::multiply(announced.frameBytes, size);
    Announced::multiply(announced.frameChunks, chunks);
  }
  return announced;
}

/// The images of a group; null or something else if it has none.
const json& imagesOf(const ZarrNode& group) {
  const json& ome = memberOf(group.attributes, "ome");
  return memberOf(ome.is_object() ? ome : group.attributes, "multiscales");
}

/// The first of several images; "" if it is the only one.
std::string firstOfImages(const json& images) {
  if (images.size() < 2) return {};
  const std::string name = textOf(memberOf(images[0], "name"));
  return fmt::format("holds {} images (multiscales), of which the first{} is used", images.size(),
                     name.empty() ? "" : fmt::format(", '{}',", shown(name)));
}

}  // namespace

Result<void> checkZarrAmount(const Volume& volume) {
  const ZarrSamples& samples = *volume.data[0].zarr;
  const Announced announced = announcedBy(volume);
  const std::uint64_t memory = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) *
                               static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  if (announced.frameBytes > memory / 2) {
    return invalid(fmt::format("has frames of {} bytes, two of which do not fit into memory",
                               announced.frameBytes),
                   volume.where);
  }
  constexpr std::uint64_t kMostChunksOfFrame = std::uint64_t{1} << 20U;
  if (announced.frameChunks > kMostChunksOfFrame) {
    return invalid(fmt::format("has {} chunks in a frame; at most {} are read",
                               announced.frameChunks, kMostChunksOfFrame),
                   volume.where);
  }
  // The most that codecs make of a byte.
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 16U;
  constexpr std::uint64_t kBytesAlways = std::uint64_t{64} << 20U;
  constexpr std::uint64_t kMostChunks = 256;  // for each that is stored
  constexpr std::uint64_t kChunksAlways = std::uint64_t{1} << 17U;
  constexpr std::uint64_t kIndexBytes = 16;  // of a chunk in a shard
  const std::uint64_t enoughBytes =
      announced.frameBytes > kBytesAlways ? announced.frameBytes / kMostBytes + 1 : 0;
  const std::uint64_t enoughChunks =
      announced.chunks > kChunksAlways ? announced.chunks / kMostChunks + 1 : 0;
  const auto isEnough = [&](const Stored& stored) {
    return stored.bytes >= enoughBytes && stored.files + stored.bytes / kIndexBytes >= enoughChunks;
  };
  if (isEnough({})) return {};
  const fs::path folder = samples.store->folder() / samples.array.path;
  const Stored stored = samples.store->remote()
                            ? Stored{enoughChunks, storedOnServer(samples, enoughBytes)}
                            : storedInFolder(folder, isEnough);
  if (isEnough(stored)) return {};
  return invalid(
      fmt::format("announces {} chunks, and frames of {} bytes, but {} bytes are stored in {} "
                  "chunks",
                  announced.chunks, announced.frameBytes, stored.bytes, stored.files),
      volume.where);
}

bool isZarr(const fs::path& path) {
  if (isWebUrl(path)) return true;
  if (std::ranges::any_of(path, [](const fs::path& part) { return part.extension() == ".zarr"; })) {
    return true;
  }
  constexpr std::array kMetadata = {"zarr.json", ".zarray", ".zgroup"};
  return std::ranges::any_of(kMetadata, [&](const char* name) {
    std::error_code ignored;
    return fs::is_regular_file(path / name, ignored);
  });
}

Result<Volume> readZarr(const fs::path& path, const ZarrChoice& choice,
                        const system::WebFiles& web) {
  auto store = ZarrStore::open(path, web);
  if (!store) return store.error();
  auto node = readZarrNode(**store, "");
  if (!node) return node.error();
  const std::string name = (*store)->nameOf("");
  if (!*node) {
    return invalid("has none of zarr.json, .zarray, .zgroup and .zattrs, so it is no Zarr", name);
  }
  if ((*node)->array) {
    ZarrImage alone;
    const auto axes = axesOfArray(**node, choice.axes, alone.axesAssumed);
    if (!axes) return axes.error();
    if (!areUsable(*axes)) return cannotTellAxes("'" + *axes + "'", (*node)->where);
    if (choice.level > 0) {
      return invalid(fmt::format("is one array, so there is no level {}", choice.level), name);
    }
    auto samples = std::make_shared<ZarrSamples>();
    samples->store = *store;
    samples->array = *(*node)->array;
    samples->axes = *axes;
    return volumeOf(std::move(samples), alone, choice.channel, (*node)->where, path);
  }
  const json& images = imagesOf(**node);
  if (images.is_array() && !images.empty() && images[0].is_object()) {
    auto volume = readPyramid(*store, **node, images[0], choice, path);
    const std::string first = firstOfImages(images);
    if (volume && !first.empty()) {
      volume->notice = first + (volume->notice.empty() ? "" : "; " + volume->notice);
    }
    return volume;
  }
  return invalid(
      fmt::format("is a group without an image (multiscales); name an image or an array in it, as "
                  "{}/0",
                  name),
      name);
}

}  // namespace t4d::voxel4d

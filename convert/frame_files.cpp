#include "convert/frame_files.h"

#include <algorithm>
#include <mutex>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "convert/frame_slices.h"
#include "formats/file_extension.h"
#include "formats/input_file.h"
#include "formats/output_folder.h"
#include "formats/text/xml_text.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "formats/usd/usd_writer.h"
#include "platform/cleanup.h"
#include "platform/replaceable.h"

namespace t4d::convert {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

bool isDigit(char c) { return c >= '0' && c <= '9'; }

/// The number in a pattern: %d or %0Nd.
struct NumberPlace {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::size_t digits = 1;
};

std::optional<NumberPlace> numberPlace(std::string_view name) {
  const std::size_t begin = name.find('%');
  if (begin == std::string_view::npos) return std::nullopt;
  NumberPlace place{begin, begin + 1, 1};
  if (place.end + 1 < name.size() && name[place.end] == '0' && isDigit(name[place.end + 1])) {
    place.digits = static_cast<std::size_t>(name[place.end + 1] - '0');
    place.end += 2;
  }
  if (place.end >= name.size() || name[place.end] != 'd') return std::nullopt;
  ++place.end;
  return place;
}

Result<void> checkWritableExtension(const FrameNames& names) {
  const auto* format = formats::triangleMeshFormat("frame" + names.extension);
  if (format != nullptr && format->write != nullptr) return {};
  return fail(ErrorCode::Unsupported,
              fmt::format("unsupported extension '{}': frames are written as {}", names.extension,
                          formats::writableTriangleMeshExtensions()));
}

/// Makes the folder, or checks that the one that exists has nothing that would pass for a frame,
/// and no file of others under the names to write.
Result<std::optional<platform::Cleanup>> prepareFolder(const FrameNames& names,
                                                       std::uint64_t count) {
  const fs::path folder = names.folder.empty() ? fs::path(".") : names.folder;
  std::error_code error;
  if (!fs::exists(folder, error)) {
    const platform::HeldCleanup held;
    fs::create_directories(folder, error);
    if (error) {
      return fail(ErrorCode::Failed, "cannot make the folder: " + error.message(), folder.string());
    }
    return platform::Cleanup::emptyFolder(folder);
  }
  if (!fs::is_directory(folder, error)) {
    return fail(ErrorCode::Failed, "is not a folder", folder.string());
  }
  std::vector<std::string> files = {names.manifest, names.collection};
  std::set<std::string> ours;
  for (std::uint64_t i = 0; i < count; ++i) {
    files.push_back(names.fileName(i, count));
    ours.insert(files.back());
  }
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    const std::string_view view = name;
    if (name.size() <= names.stem.size() + names.extension.size() ||
        !view.starts_with(names.stem) || !view.ends_with(names.extension)) {
      continue;
    }
    const auto number =
        view.substr(names.stem.size(), view.size() - names.stem.size() - names.extension.size());
    if (!std::ranges::all_of(number, isDigit) || ours.contains(name)) continue;
    return fail(ErrorCode::Failed,
                fmt::format("the folder has {}, which would pass for a frame of this series; "
                            "remove it or name another folder",
                            name),
                folder.string());
  }
  if (error) {
    return fail(ErrorCode::Failed, "cannot read the folder: " + error.message(), folder.string());
  }
  if (auto good = platform::checkReplaceable(folder, files); !good) return good.error();
  return std::nullopt;
}

/// The folder of a series, which several threads begin to fill.
class SeriesFolder {
 public:
  SeriesFolder(const FrameNames& names, std::uint64_t count) : names_(names), count_(count) {}
  ~SeriesFolder() {
    std::error_code ignored;
    if (made_) fs::remove(names_.folder, ignored);  // only if it is empty
  }
  SeriesFolder(const SeriesFolder&) = delete;
  SeriesFolder& operator=(const SeriesFolder&) = delete;

  /// Makes it, the first time, and removes the lists of an older series.
  Result<void> prepare() {
    std::call_once(once_, [&] {
      auto made = prepareFolder(names_, count_);
      if (!made) {
        prepared_ = made.error();
        return;
      }
      made_ = std::move(*made);
      for (const std::string& old : {names_.manifest, names_.collection}) {
        if (prepared_) prepared_ = removeOldManifest(names_.folder / old);
      }
    });
    return prepared_;
  }

  /// The series is complete.
  void keep() { made_.reset(); }

 private:
  const FrameNames& names_;
  std::uint64_t count_;
  std::once_flag once_;
  Result<void> prepared_;
  std::optional<platform::Cleanup> made_;  // nothing if it was there
};

Result<void> writeManifestText(const fs::path& path, const ordered_json& members) {
  std::string text;
  try {
    text = members.dump(1) + "\n";
  } catch (const nlohmann::json::exception&) {
    return invalid("a unit or the name of a file is not UTF-8 text", path.string());
  }
  return formats::writeInFolder(path.parent_path(), path.filename().string(), text);
}

/// A ParaView collection.
std::string collectionOf(std::span<const FrameEntry> frames) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" "
      "byte_order=\"LittleEndian\">\n<!-- written by t4d -->\n<Collection>\n";
  for (const FrameEntry& frame : frames) {
    text += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", frame.time,
                        formats::xmlEscaped(frame.file));
  }
  return text + "</Collection>\n</VTKFile>\n";
}

/// Losses of frames, each once, and no more than anyone reads.
class FrameLosses {
 public:
  void add(const std::string& file, const std::vector<std::string>& lines) {
    for (const std::string& line : lines) {
      if (!seen_.insert(line).second) continue;
      if (lines_.size() < kMost) {
        lines_.push_back(fmt::format("{}: {}", file, line));
      } else {
        ++more_;
      }
    }
  }

  std::vector<std::string> lines() const {
    std::vector<std::string> all = lines_;
    if (more_ > 0) all.push_back(fmt::format("and {} more in other frames", more_));
    return all;
  }

 private:
  static constexpr std::size_t kMost = 10;
  std::set<std::string> seen_;
  std::vector<std::string> lines_;
  std::uint64_t more_ = 0;
};

constexpr const char* kClips = ".usda";

bool areClips(const FrameNames& names) {
  return formats::lowerCaseExtension("frame" + names.extension) == kClips;
}

}  // namespace

std::string FrameNames::fileName(std::uint64_t number, std::uint64_t count) const {
  const std::size_t needed = fmt::formatted_size("{}", count - 1);
  return fmt::format("{}{:0{}}{}", stem, number, std::max(digits, needed), extension);
}

Result<FrameNames> frameNames(const std::string& output, std::string_view extension) {
  FrameNames names;
  const fs::path path(output);
  const std::string last = path.filename().string();
  const auto place = numberPlace(last);
  if (!place) {
    const auto* format = formats::triangleMeshFormat(path);
    if (extension.empty() || (format != nullptr && last.find('%') != last.npos)) {
      return invalid(fmt::format(
          "'{}' is neither a folder for files of a given format nor a pattern: that has %d or %04d "
          "for the number of a frame, such as frame_%04d.ply",
          output));
    }
    names.folder = path;
    names.extension = extension;
  } else {
    names.folder = path.parent_path();
    names.stem = last.substr(0, place->begin);
    names.digits = place->digits;
    names.extension = last.substr(place->end);
    if (!extension.empty() && formats::lowerCaseExtension("frame" + names.extension) != extension) {
      return invalid(fmt::format("'{}' is not the pattern of {} files", output, extension));
    }
    std::string series = names.stem;
    while (!series.empty() && std::string_view("_-. ").find(series.back()) != std::string::npos) {
      series.pop_back();
    }
    if (!series.empty()) {
      names.manifest = series + ".manifest.json";
      names.collection = series + ".pvd";
    }
  }
  if (auto good = checkWritableExtension(names); !good) return good.error();
  if (!areClips(names)) return names;
  names.collection = fs::path(names.collection).replace_extension(kClips).string();
  return names;
}

Result<FrameFilesReport> writeFrameFiles(std::span<const model::Body> bodies,
                                         std::span<const double> times, const FrameNames& names,
                                         const FrameFilesOptions& options,
                                         const model::Progress& progress) {
  if (auto good = checkWritableExtension(names); !good) return good.error();
  const model::PartRange own = options.part.of(times.size());
  const bool isWhole = options.part.count == 1;
  SeriesFolder folder(names, times.size());
  struct Written {
    FrameEntry entry;
    std::vector<std::string> losses;
  };
  std::vector<Written> written(own.size());
  formats::MeshWriteOptions common = options.write;
  for (const model::Body& body : bodies) common.usd.bodies.push_back(body.name);
  common.usd.timeCodesPerSecond = options.framesPerSecond;
  common.attributes = common.attributes || options.velocity;
  const auto write = [&](std::size_t number,
                         std::span<const formats::NamedMesh> meshes) -> Result<void> {
    if (auto good = folder.prepare(); !good) return good;
    const std::size_t frame = own.begin + number;
    const std::string name = names.fileName(frame, times.size());
    formats::MeshWriteOptions how = common;
    how.time = times[frame];
    how.usd.timeCode = static_cast<double>(frame);
    auto lost = formats::writeTriangleMeshes(names.folder / name, meshes, how);
    if (!lost) return lost.error();
    std::uint64_t vertices = 0;
    std::uint64_t triangles = 0;
    double volume = 0;
    for (const formats::NamedMesh& named : meshes) {
      vertices += named.mesh.vertices.size();
      triangles += named.mesh.triangles.size();
      volume += signedVolume(named.mesh);
    }
    std::error_code ignored;
    const std::uint64_t bytes = fs::file_size(names.folder / name, ignored);
    written[number] = {{name, times[frame], vertices, triangles, volume, bytes}, std::move(*lost)};
    return {};
  };
  std::optional<formats::UsdClipSet> clips;
  if (areClips(names)) {
    auto made = formats::UsdClipSet::create(common);
    if (!made) return made.error();
    clips = std::move(*made);
  }
  FrameFilesReport report;
  FrameLosses losses;
  FramesManifest manifest;
  const auto list = [&](std::size_t frame,
                        std::span<const formats::NamedMesh> meshes) -> Result<void> {
    if (clips) {
      if (auto added = clips->add(meshes); !added) return added;
    }
    auto& [entry, lost] = written[frame];
    losses.add(entry.file, lost);
    report.bytes += entry.bytes;
    manifest.frames.push_back(std::move(entry));
    return {};
  };
  std::optional<FrameVelocity> velocity = options.velocity;
  if (velocity && !velocity->timeUnits.empty()) {
    velocity->timeUnits.assign(options.velocity->timeUnits.begin() + std::ptrdiff_t(own.begin),
                               options.velocity->timeUnits.begin() + std::ptrdiff_t(own.end));
  }
  auto sliced =
      forEachFrame(bodies, times.subspan(own.begin, own.size()),
                   {options.detail, std::move(velocity), options.paint, options.write.attributes},
                   list, progress, write);
  if (!sliced) return sliced.error();
  static_cast<FrameSlicesReport&>(report) = std::move(*sliced);
  if (!options.write.attributes) report.losses.clear();
  for (std::string& line : losses.lines()) report.losses.push_back(std::move(line));

  const bool collects = formats::lowerCaseExtension("frame" + names.extension) == ".vtp";
  if (collects && isWhole) {
    const auto text = collectionOf(manifest.frames);
    if (auto done = formats::writeInFolder(names.folder, names.collection, text); !done) {
      return done.error();
    }
  }
  manifest.part = options.part;
  manifest.of = times.size();
  if (collects) manifest.collection = names.collection;
  if (clips) {
    std::vector<std::string> files;
    for (const FrameEntry& frame : manifest.frames) files.push_back(frame.file);
    if (auto done = clips->write(names.folder / names.collection, files); !done) {
      return done.error();
    }
  }
  manifest.space = options.space;
  manifest.origin = options.write.origin + options.write.center;
  manifest.light = report.light;
  manifest.distance = report.distance;
  const std::string manifestName =
      isWhole ? names.manifest : manifestOfPart(names.manifest, options.part);
  if (auto done = writeManifest(names.folder / manifestName, manifest); !done) {
    return done.error();
  }
  folder.keep();
  return report;
}

Result<void> writeManifest(const fs::path& path, const FramesManifest& manifest) {
  const auto& [part, of, collection, space, origin, light, distance, frames] = manifest;
  const auto countOf = [](const std::optional<std::uint64_t>& count) {
    return count ? ordered_json(*count) : ordered_json(nullptr);
  };
  ordered_json list = ordered_json::array();
  for (const FrameEntry& frame : frames) {
    list.push_back({{"file", frame.file},
                    {"time", frame.time},
                    {"vertices", countOf(frame.vertices)},
                    {"triangles", countOf(frame.triangles)},
                    {"volume", frame.volume},
                    {"bytes", frame.bytes}});
  }
  ordered_json members = {{"generator", "t4d"},
                          {"length_unit", space.lengthUnit},
                          {"time_unit", space.timeUnit},
                          {"up", space.up},
                          {"origin", {origin.x(), origin.y(), origin.z()}},
                          {"light", light},
                          {"distance", distance},
                          {"frames", std::move(list)}};
  if (part.count > 1) {
    members["part"] = {{"number", part.number}, {"count", part.count}, {"frames", of}};
    if (!collection.empty()) members["part"]["collection"] = collection;
  }
  return writeManifestText(path, members);
}

namespace {

Result<ordered_json> readPart(const fs::path& path) {
  const auto file = formats::readInputFile(path);
  if (!file) return file.error();
  const auto bytes = file->bytes;
  ordered_json part = ordered_json::parse(bytes.begin(), bytes.end(), nullptr, false);
  const auto has = [](const ordered_json& value, const char* name) {
    return value.is_object() && value.contains(name);
  };
  const bool sound = has(part, "frames") && part["frames"].is_array() && has(part, "part") &&
                     has(part["part"], "number") && has(part["part"], "count") &&
                     part["part"]["number"].is_number_unsigned() &&
                     part["part"]["count"].is_number_unsigned() && has(part, "light") &&
                     part["light"].is_boolean() && has(part, "distance");
  if (sound) return part;
  return invalid("is not the manifest of a part of a series of frames", path.string());
}

/// The frames of all parts in the manifest of the first; `paths` are in the order of their numbers.
Result<ordered_json> joined(const std::vector<fs::path>& paths,
                            const std::vector<ordered_json>& parts) {
  ordered_json all = parts.front();
  const std::uint64_t count = all["part"]["count"];
  for (std::size_t i = 0; i < parts.size(); ++i) {
    ordered_json about = parts[i];
    ordered_json first = parts.front();
    for (ordered_json* one : {&about, &first}) {
      for (const char* name : {"frames", "light", "distance"}) one->erase(name);
      (*one)["part"].erase("number");
    }
    if (about != first) {
      return invalid("is of another series than " + paths.front().string(), paths[i].string());
    }
    const std::uint64_t number = parts[i]["part"]["number"];
    if (number != i + 1) {
      return invalid(fmt::format("part {} of {} is {}", number > i + 1 ? i + 1 : number, count,
                                 number > i + 1 ? "missing" : "given twice"),
                     paths[i].string());
    }
    if (i == 0) continue;
    for (const ordered_json& frame : parts[i]["frames"]) all["frames"].push_back(frame);
    all["light"] = all["light"] && parts[i]["light"];
    if (parts[i]["distance"].is_number() && all["distance"].is_number() &&
        parts[i]["distance"] > all["distance"]) {
      all["distance"] = parts[i]["distance"];
    }
  }
  if (parts.size() == count && all["frames"].size() == all["part"].value("frames", 0U)) return all;
  return invalid(fmt::format("part {} of {} is missing", parts.size() + 1, count),
                 paths.back().string());
}

}  // namespace

std::string manifestOfPart(const std::string& manifest, const model::Part& part) {
  const fs::path path(manifest);
  return fmt::format("{}.part-{}-of-{}{}", path.stem().string(), part.number, part.count,
                     path.extension().string());
}

Result<std::uint64_t> joinManifests(const std::vector<fs::path>& paths, const fs::path& into) {
  std::vector<std::pair<ordered_json, fs::path>> read;
  for (const fs::path& path : paths) {
    auto part = readPart(path);
    if (!part) return part.error();
    read.emplace_back(std::move(*part), path);
  }
  std::ranges::stable_sort(read, {}, [](const auto& one) {
    return one.first["part"]["number"].template get<std::uint64_t>();
  });
  std::vector<ordered_json> parts;
  std::vector<fs::path> inOrder;
  for (auto& [part, path] : read) {
    parts.push_back(std::move(part));
    inOrder.push_back(path);
  }
  auto all = joined(inOrder, parts);
  if (!all) return all.error();
  const std::string collection = (*all)["part"].value("collection", "");
  all->erase("part");
  if (!collection.empty()) {
    std::vector<FrameEntry> frames;
    for (const ordered_json& frame : (*all)["frames"]) {
      frames.push_back({.file = frame["file"], .time = frame["time"]});
    }
    if (auto done = formats::writeInFolder(into.parent_path(), collection, collectionOf(frames));
        !done) {
      return done.error();
    }
  }
  if (auto done = writeManifestText(into, *all); !done) return done.error();
  return (*all)["frames"].size();
}

Result<void> removeOldManifest(const fs::path& path) {
  std::error_code error;
  fs::remove(path, error);
  if (!error) return {};
  return fail(ErrorCode::Failed, "cannot remove: " + error.message(), path.string());
}

}  // namespace t4d::convert

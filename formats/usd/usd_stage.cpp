#include "formats/usd/usd_stage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/t4d/names.h"
#include "formats/triangle/written_mesh.h"
#include "formats/zip_entry.h"

namespace t4d::formats {
namespace {

/// Lines of a dictionary, from the members of a JSON object.
Result<std::string> dictionaryLines(const std::string& extras, const std::string& indent) {
  std::string lines;
  if (extras.empty()) return lines;
  const auto json = nlohmann::json::parse(extras, nullptr, false);
  if (!json.is_object()) return invalid("the extras are not a JSON object");
  for (const auto& [key, member] : json.items()) {
    const std::string value = member.is_string()   ? usdString(member.get<std::string>())
                              : member.is_number() ? usdNumber(member.get<double>())
                                                   : usdString(member.dump());
    lines += fmt::format("{}{} {} = {}\n", indent, member.is_number() ? "double" : "string",
                         usdString(key), value);
  }
  return lines;
}

/// "(\n  METADATA\n)" after a property; "" without.
std::string inParentheses(const std::string& metadata, const std::string& indent) {
  if (metadata.empty()) return {};
  std::string text = " (\n";
  for (std::size_t at = 0; at < metadata.size();) {
    const std::size_t end = std::min(metadata.find('\n', at), metadata.size());
    text += fmt::format("{}    {}\n", indent, metadata.substr(at, end - at));
    at = end + 1;
  }
  return text + indent + ")";
}

constexpr const char* kTimeName = "t4d:time";
constexpr const char* kTimeType = "custom double";
const std::string kRootIndent = "    ";
const std::string kBodyIndent = "        ";

}  // namespace

/// Text goes to a file as it is, or into an archive.
class UsdStage::Output {
 public:
  Output(Form form, OutputFile& file)
      : file_(file), archive_(file, "t4d.usda"), isPackage_(form == Form::Package) {}

  Result<void> begin() { return isPackage_ ? archive_.begin() : Result<void>(); }
  Result<void> write(std::string_view text) {
    return isPackage_ ? archive_.write(text) : file_.write(text.data(), text.size());
  }
  Result<void> end() { return isPackage_ ? archive_.end() : Result<void>(); }

 private:
  OutputFile& file_;
  ZipEntryWriter archive_;
  bool isPackage_;
};

Result<UsdStage> UsdStage::create(Form form, double timeCodesPerSecond,
                                  const MeshWriteOptions& options) {
  const double metres = options.placement.metresPerUnit;
  if (!(metres > 0) || !std::isfinite(metres)) {
    return invalid(fmt::format("{} metres for a unit of length, expected more than 0", metres));
  }
  if (!(timeCodesPerSecond > 0) || !std::isfinite(timeCodesPerSecond)) {
    return invalid(fmt::format("{} frames a second, expected more than 0", timeCodesPerSecond));
  }
  auto dictionary = dictionaryLines(options.placement.extras, "            ");
  if (!dictionary) return dictionary.error();
  auto scratch = platform::ScratchFile::create();
  if (!scratch) return scratch.error();
  return UsdStage(form, timeCodesPerSecond, options, std::move(*scratch), std::move(*dictionary));
}

std::size_t UsdStage::addBody(const std::string& name) {
  const std::string plain = usdName(name);
  std::string identifier = plain;
  while (!identifiers_.emplace(identifier, 0).second) {
    identifier = fmt::format("{}_{}", plain, ++identifiers_[plain]);
  }
  bodies_.push_back({.name = asName(name), .identifier = identifier});
  return bodies_.size() - 1;
}

Result<void> UsdStage::put(Property& property, double timeCode, std::string text) {
  auto& samples = property.samples;
  if (!samples.empty() && text == property.last) {
    property.lastCode = timeCode;
    return {};
  }
  if (property.interpolated && !samples.empty() && property.lastCode > samples.back().first) {
    samples.emplace_back(property.lastCode, samples.back().second);
    textBytes_ += samples.back().second.size;
  }
  const std::span<const char> bytes(text.data(), text.size());
  if (auto done = scratch_.append(std::as_bytes(bytes)); !done) return done;
  samples.push_back({timeCode, {scratchBytes_, text.size()}});
  scratchBytes_ += text.size();
  // Its time, and what separates samples.
  constexpr std::uint64_t kAround = 24;
  textBytes_ += text.size() + kAround;
  if (textBytes_ > options_.usd.maxBytes) {
    return fail(ErrorCode::Unsupported,
                fmt::format("more than {} MB of text, more than readers of USD text take; write "
                            "fewer frames, or a file for each (a value clip set)",
                            options_.usd.maxBytes >> 20U));
  }
  property.last = std::move(text);
  property.lastCode = timeCode;
  return {};
}

UsdStage::Property* UsdStage::propertyOf(Body& body, const std::string& name) {
  const auto found =
      std::ranges::find(body.properties, name, &std::pair<std::string, Property>::first);
  return found == body.properties.end() ? nullptr : &found->second;
}

Result<void> UsdStage::put(Body& body, double timeCode, const UsdValue& value) {
  if (Property* property = propertyOf(body, value.name)) {
    if (property->type == value.type && property->metadata == value.metadata) {
      return put(*property, timeCode, value.text());
    }
    addOnce(lost_, fmt::format("'{}' of body '{}': its type, or what it belongs to, changes in "
                               "time, which that of USD cannot",
                               value.name, body.name));
    return put(*property, timeCode, "None");
  }
  Property added{value.type, value.metadata, value.interpolated};
  // A sample would hold for earlier times, too.
  if (body.sampleCount > 0) {
    if (auto done = put(added, body.firstCode, "None"); !done) return done;
  }
  if (auto done = put(added, timeCode, value.text()); !done) return done;
  body.properties.emplace_back(value.name, std::move(added));
  return {};
}

/// Blocks the values that the body no longer has.
Result<void> UsdStage::block(Body& body, double timeCode, const std::vector<UsdValue>& present) {
  for (auto& [name, property] : body.properties) {
    if (std::ranges::find(present, name, &UsdValue::name) != present.end()) continue;
    if (name == "visibility" || name.starts_with("xformOp:")) continue;
    if (auto done = put(property, timeCode, "None"); !done) return done;
  }
  return {};
}

/// Repeats the last values just before a time code. Arrays of other lengths are held anyway.
void UsdStage::hold(Body& body, double timeCode) {
  const double before = std::nextafter(timeCode, -std::numeric_limits<double>::infinity());
  for (auto& [name, property] : body.properties) {
    auto& samples = property.samples;
    if (!property.interpolated || samples.empty() || samples.back().first >= before) continue;
    samples.emplace_back(before, samples.back().second);
    textBytes_ += samples.back().second.size;
    property.lastCode = before;
  }
}

Result<void> UsdStage::sample(std::size_t number, double timeCode, const NamedMesh& named,
                              const model::Point3& center) {
  Body& body = bodies_[number];
  const auto values = usdMeshValues(named, center, options_, rounding_, lost_);
  if (!values) return values.error();
  const bool sameCount = body.vertexCount == named.mesh.vertices.size();
  if (body.sampleCount > 0 && sameCount && body.triangles != named.mesh.triangles) {
    hold(body, timeCode);
  }
  if (auto done = block(body, timeCode, *values); !done) return done;
  for (const UsdValue& value : *values) {
    if (auto done = put(body, timeCode, value); !done) return done;
  }
  if (body.sampleCount++ == 0) body.firstCode = timeCode;
  body.triangles = named.mesh.triangles;
  body.vertexCount = named.mesh.vertices.size();
  return {};
}

Result<void> UsdStage::show(std::size_t body, double timeCode, bool visible) {
  const char* word = visible ? "\"inherited\"" : "\"invisible\"";
  return put(bodies_[body], timeCode, {"token", "visibility", "", false, [word] { return word; }});
}

Result<void> UsdStage::pose(std::size_t number, double timeCode, const Eigen::Quaterniond& rotation,
                            const model::Point3& translation) {
  Body& body = bodies_[number];
  body.moves = true;
  const std::string moved = usdTuple({translation.x(), translation.y(), translation.z()});
  const std::string turned = usdTuple({rotation.w(), rotation.x(), rotation.y(), rotation.z()});
  auto done =
      put(body, timeCode, {"double3", "xformOp:translate", "", true, [&] { return moved; }});
  if (!done) return done;
  return put(body, timeCode, {"quatd", "xformOp:orient", "", true, [&] { return turned; }});
}

Result<void> UsdStage::declare(std::size_t number, const NamedMesh& named) {
  RoundingLoss ignored;
  std::vector<std::string> told;  // by the writer of the clip
  const auto values = usdMeshValues(named, options_.center, options_, ignored, told);
  if (!values) return values.error();
  const auto add = [](Body& to, const std::string& name, const std::string& type,
                      const std::string& metadata) {
    if (propertyOf(to, name) == nullptr) to.properties.emplace_back(name, Property{type, metadata});
  };
  add(root_, kTimeName, kTimeType, "");
  add(bodies_[number], "visibility", "token", "");
  for (const UsdValue& value : *values) {
    add(bodies_[number], value.name, value.type, value.metadata);
  }
  return {};
}

Result<void> UsdStage::meshTime(double timeCode, double time) {
  return put(root_, timeCode, {kTimeType, kTimeName, "", true, [time] { return usdNumber(time); }});
}

std::string UsdStage::header(const Span& played) const {
  std::string text = "#usda 1.0\n(\n";
  if (!dictionary_.empty()) {
    text += "    customLayerData = {\n        dictionary t4d = {\n" + dictionary_ +
            "        }\n    }\n";
  }
  text += "    defaultPrim = \"t4d\"\n    doc = \"written by t4d\"\n";
  text += fmt::format("    endTimeCode = {}\n    framesPerSecond = {}\n", usdNumber(played.end),
                      usdNumber(timeCodesPerSecond_));
  text += fmt::format("    metersPerUnit = {}\n    startTimeCode = {}\n",
                      usdNumber(options_.placement.metresPerUnit), usdNumber(played.begin));
  text += fmt::format("    timeCodesPerSecond = {}\n    upAxis = \"{}\"\n)\n\n",
                      usdNumber(timeCodesPerSecond_), options_.placement.zUp ? "Z" : "Y");
  return text;
}

Result<void> UsdStage::write(const Piece& piece, Output& into) const {
  constexpr std::uint64_t kAtOnce = 1U << 20U;
  std::string bytes;
  for (std::uint64_t done = 0; done < piece.size; done += bytes.size()) {
    bytes.resize(std::min(kAtOnce, piece.size - done));
    if (!scratch_.read(piece.offset + done, std::as_writable_bytes(std::span(bytes)))) {
      return fail(ErrorCode::Failed, "cannot read a temporary file");
    }
    if (auto written = into.write(bytes); !written) return written;
  }
  return {};
}

Result<void> UsdStage::write(const std::string& name, const Property& property,
                             const std::string& indent, Output& into) const {
  const std::string named = fmt::format("{}{} {}", indent, property.type, name);
  const std::string metadata = inParentheses(property.metadata, indent);
  if (property.samples.empty()) return into.write(named + metadata + "\n");
  if (property.samples.size() == 1 && !options_.usd.timeCode) {
    if (auto done = into.write(named + " = "); !done) return done;
    if (auto done = write(property.samples.front().second, into); !done) return done;
    return into.write(metadata + "\n");
  }
  if (!metadata.empty()) {
    if (auto done = into.write(named + metadata + "\n"); !done) return done;
  }
  if (auto done = into.write(named + ".timeSamples = {\n"); !done) return done;
  for (const auto& [code, piece] : property.samples) {
    auto done = into.write(fmt::format("{}    {}: ", indent, usdNumber(code)));
    if (!done) return done;
    if (done = write(piece, into); !done) return done;
    if (done = into.write(",\n"); !done) return done;
  }
  return into.write(indent + "}\n");
}

Result<void> UsdStage::write(const Body& body, Output& into) const {
  std::string text = fmt::format("\n{}def Mesh \"{}\"", kRootIndent, body.identifier);
  if (body.name != body.identifier) {
    text += fmt::format(" (\n{0}    displayName = {1}\n{0})", kRootIndent, usdString(body.name));
  }
  text += fmt::format(
      "\n{0}{{\n{1}uniform token orientation = \"rightHanded\"\n"
      "{1}uniform token subdivisionScheme = \"none\"\n",
      kRootIndent, kBodyIndent);
  if (auto done = into.write(text); !done) return done;
  for (const auto& [name, property] : body.properties) {
    if (auto done = write(name, property, kBodyIndent, into); !done) return done;
  }
  text.clear();
  if (body.moves) {
    text = kBodyIndent +
           "uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\"]\n";
  }
  return into.write(text + kRootIndent + "}\n");
}

Result<void> UsdStage::writeRoot(const std::string& metadata, Output& into) const {
  const std::string begin = "def Xform \"t4d\"" + inParentheses(metadata, "") + "\n{\n";
  if (auto done = into.write(begin); !done) return done;
  for (const auto& [name, property] : root_.properties) {
    if (auto done = write(name, property, kRootIndent, into); !done) return done;
  }
  const model::Point3 origin = options_.origin + options_.center;
  if (origin.isZero(0)) return {};
  return into.write(
      fmt::format("{0}double3 xformOp:translate = {1}\n"
                  "{0}uniform token[] xformOpOrder = [\"xformOp:translate\"]\n",
                  kRootIndent, usdTuple({origin.x(), origin.y(), origin.z()})));
}

Result<std::vector<std::string>> UsdStage::finish(OutputFile& file, const Span& played,
                                                  const std::string& rootMetadata) {
  Output into(form_, file);
  if (auto done = into.begin(); !done) return done.error();
  if (auto done = into.write(header(played)); !done) return done.error();
  if (auto done = writeRoot(rootMetadata, into); !done) return done.error();
  for (const Body& body : bodies_) {
    if (auto done = write(body, into); !done) return done.error();
  }
  if (auto done = into.write("}\n"); !done) return done.error();
  if (auto done = into.end(); !done) return done.error();
  if (auto line = rounding_.line()) lost_.push_back(std::move(*line));
  return lost_;
}

}  // namespace t4d::formats

#include "tools/t4d/convert_input.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/mesh4d/mesh4d_formats.h"
#include "formats/t4d/names.h"
#include "model/amount_text.h"
#include "t4d/check.h"
#include "t4d/edit.h"
#include "t4d/file.h"
#include "t4d/mesh.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

Result<ConvertInput> openT4dToConvert(const ConvertOptions& options, Observer& observer) {
  auto reader =
      formats::T4dReader::open(options.input, formats::T4dOpen::Whole, {}, options.maxCells);
  if (!reader) return reader.error();
  ConvertInput input{.format = std::string(kT4dFormat)};
  input.metadata = reader->metadata();
  std::uint64_t slabs = 0;
  for (std::size_t i = 0; i < reader->bodyCount(); ++i) slabs += reader->body(i).slabCount();
  const auto stage = observer.stage("checking", slabs, "slabs");
  for (std::size_t i = 0; i < reader->bodyCount(); ++i) {
    measure::MeshChecker checker;
    model::AttributeNames names(checker);
    if (auto read = reader->readThrough(i, names, stage->part(reader->body(i).slabCount()));
        !read) {
      return read.error();
    }
    input.attributes.insert(names.names().begin(), names.names().end());
    const measure::MeshReport report = checker.finish();
    const std::string& name = input.metadata.bodies[i].name;
    if (!report.valid() && !options.allowOpen) {
      return invalid(fmt::format("body '{}': {}", name, report.issues.issues.front().message),
                     options.input, Remedy::OpenMesh);
    }
    input.closed = input.closed && report.closed;
    input.oriented = input.oriented && report.oriented;
    input.bodies.push_back({{name, &reader->body(i)}, report.vertices, report.tetrahedra});
  }
  input.reader = std::move(*reader);
  return input;
}

/// A name that no other body has.
std::string freeBodyName(const formats::Mesh4d& body, std::size_t index, std::size_t count,
                         const std::string& path, std::set<std::string>& taken) {
  std::string name = body.name;
  if (name.empty()) {
    name = std::filesystem::path(path).stem().string();
    if (count > 1) name += fmt::format(" {}", index + 1);
  }
  const std::string base = formats::asName(name);
  std::string free = base;
  for (int i = 2; !taken.insert(free).second; ++i) free = fmt::format("{} ({})", base, i);
  return free;
}

/// Mends a body, cuts it into slabs, and adds it.
Result<void> addMendedBody(formats::Mesh4d&& body, const std::string& name,
                           const ConvertOptions& options, const edit::SlabCuts& cuts,
                           const Place& where, ConvertInput& input) {
  for (const model::Attribute& attribute : body.attributes) input.attributes.insert(attribute.name);
  auto mended = edit::mendMesh4d(body, {options.weld, options.allowOpen});
  if (!mended) return mended.error();
  for (const std::string& change : mended->changes) {
    input.notices.push_back(where.text() + ": " + change);
  }
  input.closed = input.closed && mended->closed;
  input.oriented = input.oriented && mended->oriented;
  auto cut = edit::cutIntoSlabs(std::move(body), cuts);
  if (!cut) return cut.error();
  if (cut->splitTetrahedra > 0) {
    input.notices.push_back(fmt::format("{}: split {} tetrahedra at cuts, with {} new vertices",
                                        where.text(), cut->splitTetrahedra, cut->newVertices));
  }
  if (const std::size_t made = cut->mesh.slabs().size(); options.slabs && made < *options.slabs) {
    input.notices.push_back(
        fmt::format("{}: cut into {}, not {}: its vertices have only {} different times",
                    where.text(), model::counted(made, "slab"), *options.slabs, made + 1));
  }
  const model::Mesh& mesh = input.meshes.emplace_back(std::move(cut->mesh));
  formats::CountedBody counted{{name, &mesh}, 0, 0};
  for (const model::Slab& slab : mesh.slabs()) {
    counted.vertices += slab.vertices.size() - slab.connectivity->lowerCount;
    counted.tetrahedra += slab.connectivity->cells.size();
  }
  input.bodies.push_back(counted);
  input.metadata.bodies.push_back({name});
  return {};
}

Result<ConvertInput> openOtherToConvert(const ConvertOptions& options) {
  const formats::Mesh4dFormat* format = nullptr;
  auto loaded = formats::readMesh4d(options.input, formats::mesh4dFormat(options.from), format);
  if (!loaded) return loaded.error();
  ConvertInput input{.format = std::string(format->id)};
  input.dialect = loaded->dialect;
  input.notices = std::move(loaded->notices);
  input.losses = std::move(loaded->losses);
  for (const auto& file : loaded->otherFiles) input.files.push_back(file.string());
  input.named = !std::ranges::all_of(loaded->bodies, &std::string::empty, &formats::Mesh4d::name);
  // Only .t4d has slabs, but cuts that were asked for are made for any format.
  const bool cuts = options.slabs || formatToWrite(options) == kT4dFormat;
  const edit::SlabCuts slabs{cuts ? options.slabs : std::optional(std::uint64_t{1})};
  std::set<std::string> taken;
  const std::size_t count = loaded->bodies.size();
  for (std::size_t i = 0; i < count; ++i) {
    formats::Mesh4d& body = loaded->bodies[i];
    const std::string name = freeBodyName(body, i, count, options.input, taken);
    Place where = options.input;
    if (count > 1) where = placeIn(where, fmt::format("body '{}'", name));
    if (auto added = addMendedBody(std::move(body), name, options, slabs, where, input); !added) {
      Error error = added.error();
      error.where = where;
      return error;
    }
  }
  input.metadata.generator = options.generator;
  input.metadata.backend = "convert";
  input.metadata.detailsJson = ordered_json{
      {"source",
       {{"mesh", std::filesystem::path(options.input).filename().string()},
        {"format", input.format}}}}.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  return input;
}

}  // namespace

Result<ConvertInput> openConvertInput(const ConvertOptions& options, Observer& observer) {
  return isFromT4d(options) ? openT4dToConvert(options, observer) : openOtherToConvert(options);
}

}  // namespace t4d::tools

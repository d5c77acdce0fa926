#include <deque>
#include <filesystem>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "t4d/edit/cut_into_slabs.h"
#include "t4d/edit/mend_mesh4d.h"
#include "t4d/formats/file_extension.h"
#include "t4d/formats/mesh4d/mesh4d_formats.h"
#include "t4d/formats/t4d/names.h"
#include "t4d/formats/t4d/optional_chunks.h"
#include "t4d/formats/t4d/reader.h"
#include "t4d/formats/t4d/stream.h"
#include "t4d/formats/t4d/url.h"
#include "t4d/formats/t4d/writer.h"
#include "t4d/measure/mesh_check.h"
#include "t4d/model/sinks.h"
#include "t4d/system/stopwatch.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/input_options.h"
#include "tools/program/option_checks.h"
#include "tools/program/part_option.h"
#include "tools/program/version.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

constexpr const char* kT4d = "t4d";

struct ConvertArguments {
  std::string input;
  std::string output;
  std::string from;  // "" for what the content tells
  std::string to;    // "" for what the extension tells
  std::optional<std::uint64_t> slabs;
  std::optional<double> weld;
  bool allowOpen = false;
  bool acceptLoss = false;
  std::optional<std::uint64_t> maxCells;
  bool json = false;
};

/// A 4D mesh to be written, and what is to be said about where it comes from.
struct ConvertInput {
  std::string format;
  std::string dialect;
  std::optional<formats::T4dReader> reader;  // of a .t4d
  std::deque<model::Mesh> meshes;            // of others
  std::vector<formats::CountedBody> bodies;
  formats::Metadata metadata;
  std::set<std::string> attributes;
  bool named = true;  // the bodies have names of their own, not that of the file
  bool closed = true;
  bool oriented = true;
  std::vector<std::string> notices;
  std::vector<std::string> losses;
  std::vector<std::string> files;
};

bool isT4d(const ConvertArguments& options) {
  if (!options.from.empty()) return options.from == kT4d;
  const std::string extension = formats::lowerCaseExtension(options.input);
  return extension == ".t4d" || extension == ".t4dm" || !formats::schemeOf(options.input).empty() ||
         formats::isT4d(options.input);
}

Result<void> openT4d(const ConvertArguments& options, ConvertInput& input) {
  auto reader =
      formats::T4dReader::open(options.input, formats::T4dOpen::Whole, {}, options.maxCells);
  if (!reader) return reader.error();
  input.format = kT4d;
  input.metadata = reader->metadata();
  std::uint64_t slabs = 0;
  for (std::size_t i = 0; i < reader->bodyCount(); ++i) slabs += reader->body(i).slabCount();
  ProgressBar bar("checking", slabs, "slabs");
  for (std::size_t i = 0; i < reader->bodyCount(); ++i) {
    measure::MeshChecker checker;
    model::AttributeNames names(checker);
    if (auto read = reader->readThrough(i, names, bar.part(reader->body(i).slabCount())); !read) {
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
  return {};
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

Result<void> openOther(const ConvertArguments& options, bool cut, ConvertInput& input) {
  const formats::Mesh4dFormat* format = nullptr;
  auto loaded = formats::readMesh4d(options.input, formats::mesh4dFormat(options.from), format);
  if (!loaded) return loaded.error();
  input.format = format->id;
  input.dialect = loaded->dialect;
  input.notices = std::move(loaded->notices);
  input.losses = std::move(loaded->losses);
  for (const auto& file : loaded->otherFiles) input.files.push_back(file.string());
  input.named = !std::ranges::all_of(loaded->bodies, &std::string::empty, &formats::Mesh4d::name);
  std::set<std::string> taken;
  const std::size_t count = loaded->bodies.size();
  for (std::size_t i = 0; i < count; ++i) {
    formats::Mesh4d& body = loaded->bodies[i];
    for (const model::Attribute& attribute : body.attributes) {
      input.attributes.insert(attribute.name);
    }
    const std::string name = freeBodyName(body, i, count, options.input, taken);
    const std::string where =
        count > 1 ? fmt::format("{}: body '{}'", options.input, name) : options.input;
    auto mended = edit::mendMesh4d(body, {options.weld, options.allowOpen});
    if (!mended) {
      Error error = mended.error();
      error.where = where;
      return error;
    }
    for (const std::string& change : mended->changes) {
      input.notices.push_back(where + ": " + change);
    }
    input.closed = input.closed && mended->closed;
    input.oriented = input.oriented && mended->oriented;
    // Only .t4d has slabs, but cuts that were asked for are made for any format.
    const edit::SlabCuts cuts{options.slabs || cut ? options.slabs
                                                   : std::optional(std::uint64_t{1})};
    auto slabs = edit::cutIntoSlabs(std::move(body), cuts);
    if (!slabs) {
      Error error = slabs.error();
      error.where = where;
      return error;
    }
    if (slabs->splitTetrahedra > 0) {
      input.notices.push_back(fmt::format("{}: split {} tetrahedra at cuts, with {} new vertices",
                                          where, slabs->splitTetrahedra, slabs->newVertices));
    }
    if (const std::size_t made = slabs->mesh.slabs().size();
        options.slabs && made < *options.slabs) {
      input.notices.push_back(
          fmt::format("{}: cut into {}, not {}: its vertices have only {} different times", where,
                      counted(made, "slab"), *options.slabs, made + 1));
    }
    input.meshes.push_back(std::move(slabs->mesh));
    formats::CountedBody counted{{name, &input.meshes.back()}, 0, 0};
    for (const model::Slab& slab : input.meshes.back().slabs()) {
      counted.vertices += slab.vertices.size() - slab.connectivity->lowerCount;
      counted.tetrahedra += slab.connectivity->cells.size();
    }
    input.bodies.push_back(counted);
    input.metadata.bodies.push_back({name});
  }
  input.metadata.generator = std::string(versionText());
  input.metadata.backend = "convert";
  input.metadata.detailsJson = ordered_json{
      {"source",
       {{"mesh", std::filesystem::path(options.input).filename().string()},
        {"format", input.format}}}}.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  return {};
}

Result<void> writeT4d(const ConvertArguments& options, ConvertInput& input) {
  auto writer = formats::T4dWriter::create(options.output, input.metadata);
  if (!writer) return writer.error();
  std::uint64_t slabs = 0;
  for (const auto& body : input.bodies) slabs += body.source->slabCount();
  ProgressBar bar("writing", slabs, "slabs");
  for (std::size_t i = 0; i < input.bodies.size(); ++i) {
    auto done = model::pump(*input.bodies[i].source, writer->body(i),
                            bar.part(input.bodies[i].source->slabCount()));
    if (!done) return done;
  }
  if (input.reader) {
    if (auto kept = writer->keep(input.reader->optionalChunks()); !kept) return kept;
  }
  auto finished = writer->finish();
  if (!finished) return finished.error();
  for (std::string& loss : writer->losses()) input.losses.push_back(std::move(loss));
  return {};
}

Result<void> writeOther(const ConvertArguments& options, const formats::Mesh4dFormat& format,
                        ConvertInput& input) {
  auto mesh = formats::FlatBodies::of(input.bodies);
  if (!mesh) return mesh.error();
  std::set<std::string> lost = input.attributes;
  if (format.keeps.attributes != nullptr && !lost.empty()) {
    if (auto found = mesh->findAttributes(format.keeps.attributes); !found) return found;
    for (const model::Attribute& kept : mesh->attributes()) lost.erase(kept.name);
  }
  for (std::string& loss : formats::mesh4dLosses(format, *mesh)) {
    input.losses.push_back(std::move(loss));
  }
  const std::string& name = input.bodies.front().name;
  if (!format.keeps.names && input.bodies.size() == 1 && input.named &&
      name != formats::asName(std::filesystem::path(options.output).stem().string())) {
    input.losses.push_back(fmt::format("name of the body not kept by {}: '{}'", format.id, name));
  }
  const auto losesThese = [&](const char* what, const std::set<std::string>& names) {
    if (names.empty()) return;
    input.losses.push_back(
        fmt::format("{} not kept by {}: {}", what, format.id, fmt::join(names, ", ")));
  };
  losesThese("attributes", lost);
  if (!format.keeps.metadata && input.format == kT4d) {
    const formats::Metadata& metadata = input.metadata;
    input.losses.push_back(fmt::format(
        "metadata not kept by {}: units, the upward axis, how the mesh was made", format.id));
    if (!metadata.space.empty()) losesThese("the anatomical space", {metadata.space});
    std::set<std::string> kinds;
    for (const auto& [attribute, meaning] : metadata.attributes) kinds.insert(attribute);
    losesThese("kinds and units of attributes", kinds);
    std::set<std::string> members;
    const auto addMembers = [&](const std::string& others) {
      const auto object = ordered_json::parse(others);
      for (const auto& member : object.items()) members.insert(member.key());
    };
    addMembers(metadata.otherJson);
    for (const formats::BodyInfo& body : metadata.bodies) {
      addMembers(body.otherJson);
      if (!body.color.empty()) members.insert("color");
      if (!body.material.empty()) members.insert("material");
      if (!body.parent.empty()) members.insert("parent");
    }
    losesThese("further members of the metadata", members);
    std::set<std::string> types;
    const auto addType = [&](const auto& /*file*/, const auto& header) -> Result<void> {
      types.insert(header.name());
      return {};
    };
    if (auto added = input.reader->optionalChunks().each(addType); !added) return added;
    losesThese("chunks", types);
  }
  return format.write(options.output, *mesh);
}

std::string titleOf(const ConvertInput& input) {
  if (input.format == kT4d) return ".t4d";
  std::string title(formats::mesh4dFormat(input.format)->name);
  // The name of an OFF file says its dialect.
  if (!input.dialect.empty() && title.find(input.dialect) == title.npos) {
    title += " (" + input.dialect + ")";
  }
  return title;
}

/// Notes on a choice of options that is allowed, but may be a mistake.
void noteChoices(const ConvertArguments& options, const formats::Mesh4dFormat* to,
                 std::vector<std::string>& notices) {
  if (options.slabs && to != nullptr) {
    notices.push_back(fmt::format("{}: {} has no slabs; --slabs only splits tetrahedra at the cuts",
                                  options.output, to->name));
  }
  const std::string extension = formats::lowerCaseExtension(options.output);
  if (options.to.empty()) return;
  const auto* named = formats::writtenMesh4dFormat(options.output);
  const bool ofT4d = extension == ".t4d";
  if (to == nullptr ? named == nullptr
                    : std::ranges::find(to->extensions, extension) != to->extensions.end() ||
                          (named == nullptr && !ofT4d)) {
    return;
  }
  notices.push_back(fmt::format("{}: written as {}, as --to says; its extension is that of {}",
                                options.output,
                                to == nullptr ? std::string(".t4d") : std::string(to->name),
                                ofT4d ? std::string(".t4d") : std::string(named->name)));
}

int run(const ConvertArguments& options) {
  if (const auto misuse = misuseOfOutput(options.output, {&options.input, 1})) {
    return wrongUsage(*misuse);
  }
  const bool toT4d = options.to.empty() ? formats::lowerCaseExtension(options.output) == ".t4d"
                                        : options.to == kT4d;
  const formats::Mesh4dFormat* to = nullptr;
  if (!toT4d) {
    to = options.to.empty() ? formats::writtenMesh4dFormat(options.output)
                            : formats::mesh4dFormat(options.to);
    if (to == nullptr || to->write == nullptr) {
      return wrongUsage(
          fmt::format("unsupported output extension: '{}' is not .t4d, {}; --to names the format",
                      options.output, formats::writableMesh4dExtensions()));
    }
  }
  const system::Stopwatch stopwatch;
  ConvertInput input;
  const bool fromT4d = isT4d(options);
  if (fromT4d && (options.slabs || options.weld)) {
    return wrongUsage("--slabs and --weld are for meshes without slabs; a .t4d has them");
  }
  auto opened = fromT4d ? openT4d(options, input) : openOther(options, toT4d, input);
  if (!opened) return report(opened.error());
  if (const auto misuse = misuseOfOutput(options.output, input.files)) return wrongUsage(*misuse);
  auto written = toT4d ? writeT4d(options, input) : writeOther(options, *to, input);
  if (!written) {
    Error error = written.error();
    if (error.where.empty()) error.where = options.output;
    return report(error);
  }
  noteChoices(options, to, input.notices);
  printNotices(input.notices);
  if (!input.closed || !input.oriented) {
    printNotices({fmt::format("{}: the mesh is {}: slices and volumes of it mean nothing",
                              options.output, input.closed ? "not oriented" : "not closed")});
  }

  std::uint64_t vertices = 0;
  std::uint64_t tetrahedra = 0;
  for (const formats::CountedBody& body : input.bodies) {
    vertices += body.vertices;
    tetrahedra += body.tetrahedra;
  }
  const double seconds = stopwatch.seconds();
  if (options.json) {
    printJson({{"in", {{"format", input.format}, {"dialect", input.dialect}}},
               {"out", {{"format", toT4d ? std::string(kT4d) : std::string(to->id)}}},
               {"bodies", input.bodies.size()},
               {"vertices", vertices},
               {"tetrahedra", tetrahedra},
               {"closed", input.closed},
               {"oriented", input.oriented},
               {"losses", input.losses},
               {"seconds", seconds},
               {"peak_bytes", peakBytes()}});
  } else {
    print("{}: {}, {}, {}; {}, {}\n", options.output,
          counted(input.bodies.size(), "body", "bodies"), counted(vertices, "vertex", "vertices"),
          counted(tetrahedra, "tetrahedron", "tetrahedra"), input.closed ? "closed" : "NOT CLOSED",
          input.oriented ? "oriented" : "NOT ORIENTED");
    print("  {} to {}, {:.2f} s, peak memory {}\n", titleOf(input),
          toT4d ? std::string(".t4d") : std::string(to->name), seconds, sizeText(peakBytes()));
  }
  const int code = reportLosses(input.losses);
  return options.acceptLoss ? kDone : code;
}

/// The id of a format of 4D meshes.
CLI::Validator formatId(bool written) {
  std::vector<std::string> ids = {kT4d};
  for (const formats::Mesh4dFormat& format : formats::mesh4dFormats()) {
    if (written ? format.write != nullptr : format.read != nullptr) ids.emplace_back(format.id);
  }
  return CLI::IsMember(ids);
}

}  // namespace

void addConvert(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("convert", "Convert a 4D mesh between file formats");
  auto options = std::make_shared<ConvertArguments>();
  command
      ->add_option("IN", options->input,
                   "Input file, in a format that `t4d formats` lists; .t4d also by URL")
      ->required();
  command
      ->add_option("OUT", options->output,
                   fmt::format("Output file: .t4d, {}", formats::writableMesh4dExtensions()))
      ->required()
      ->check(someName());
  command->add_option("--from", options->from, "Format of IN (default: from its content)")
      ->check(formatId(false))
      ->type_name("FORMAT");
  command->add_option("--to", options->to, "Format of OUT (default: from its extension)")
      ->check(formatId(true))
      ->type_name("FORMAT");
  command
      ->add_option("--slabs", options->slabs,
                   "Cut into N slabs, splitting tetrahedra (default: cut where none is split)")
      ->check(wholeNumber(1, 1'000'000))
      ->type_name("N");
  command
      ->add_option("--weld", options->weld,
                   "Merge vertices within this distance per axis (default: equal ones, if open)")
      ->check(numberFromZero())
      ->type_name("DISTANCE");
  command->add_flag("--allow-open", options->allowOpen,
                    "Accept meshes that are open or cannot be oriented");
  command->add_flag("--accept-loss", options->acceptLoss,
                    "Exit with 0 even if data was lost (losses are still listed)");
  addNoPartOption(*command,
                  "converting cannot be divided: other formats hold a mesh as one; join the parts "
                  "first (t4d join), or write a .t4d in parts (t4d compress)");
  addMaxCellsOption(*command, options->maxCells);
  command->add_flag("--json", options->json, "Print the result as JSON");
  command->footer(
      "Example:\n  t4d convert bolt.t4d bolt.vtu --accept-loss\n"
      "  t4d convert polytope.off polytope.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools

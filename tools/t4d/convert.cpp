#include "tools/t4d/convert.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "formats/file_extension.h"
#include "formats/listed.h"
#include "formats/mesh4d/mesh4d_formats.h"
#include "formats/t4d/names.h"
#include "formats/t4d/optional_chunks.h"
#include "formats/t4d/url.h"
#include "platform/kept_inputs.h"
#include "platform/stopwatch.h"
#include "t4d/file.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/convert_input.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/version.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

/// Fails if the file that is written has the name of another format.
Result<void> checkName(const ConvertOptions& options) {
  std::error_code ignored;
  const auto there = std::filesystem::status(options.output, ignored);
  const bool isStream = options.output == "-" || is_character_file(there) || is_fifo(there);
  if (options.to.empty() || isStream) return {};
  const auto* format = formats::mesh4dFormat(options.to);
  const std::vector<std::string_view> extensions =
      format == nullptr ? std::vector<std::string_view>{".t4d"} : format->extensions;
  const std::string own = formats::lowerCaseExtension(options.output);
  if (std::ranges::find(extensions, own) != extensions.end()) return {};
  return fail(ErrorCode::Options,
              fmt::format("'{}' does not end with {}, as {} does", options.output,
                          formats::listed(extensions), options.to));
}

/// Checks the formats, and what a .t4d as input excludes.
Result<void> checkConversion(const ConvertOptions& options) {
  if (formatToWrite(options).empty()) {
    const std::string error =
        options.to.empty() ? fmt::format("unsupported output extension: '{}' is not .t4d, {}",
                                         options.output, formats::writableMesh4dExtensions())
                           : fmt::format("'{}' is not a format that can be written", options.to);
    return fail(ErrorCode::Options, error);
  }
  if (auto good = checkName(options); !good) return good;
  if (isFromT4d(options)) {
    if (!options.slabs && !options.weld) return {};
    return fail(ErrorCode::Options,
                "only meshes without slabs are cut and their vertices merged; a .t4d has slabs");
  }
  if (options.from.empty()) return {};
  const auto* from = formats::mesh4dFormat(options.from);
  if (from != nullptr && from->read != nullptr) return {};
  return fail(ErrorCode::Options,
              fmt::format("'{}' is not a format that can be read", options.from));
}

Result<void> writeConvertedT4d(const std::string& output, ConvertInput& input, Observer& observer) {
  auto writer = formats::T4dWriter::create(output, input.metadata);
  if (!writer) return writer.error();
  std::uint64_t slabs = 0;
  for (const auto& body : input.bodies) slabs += body.source->slabCount();
  const auto stage = observer.stage("writing", slabs, "slabs");
  for (std::size_t i = 0; i < input.bodies.size(); ++i) {
    auto done = model::pump(*input.bodies[i].source, writer->body(i),
                            stage->part(input.bodies[i].source->slabCount()));
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

/// The names of what a format does not keep.
class LostNames {
 public:
  LostNames(const formats::Mesh4dFormat& format, std::vector<std::string>& losses)
      : format_(&format), losses_(&losses) {}

  void add(const char* what, const auto& names) {
    if (names.empty()) return;
    losses_->push_back(
        fmt::format("{} not kept by {}: {}", what, format_->id, fmt::join(names, ", ")));
  }

 private:
  const formats::Mesh4dFormat* format_;
  std::vector<std::string>* losses_;
};

/// Members of the metadata that no other format and no other line of the report names.
std::set<std::string> furtherMembers(const formats::Metadata& metadata) {
  std::set<std::string> members;
  const auto add = [&](const std::string& others) {
    const auto object = ordered_json::parse(others);
    for (const auto& member : object.items()) members.insert(member.key());
  };
  add(metadata.otherJson);
  for (const formats::BodyInfo& body : metadata.bodies) {
    add(body.otherJson);
    if (!body.color.empty()) members.insert("color");
    if (!body.material.empty()) members.insert("material");
    if (!body.parent.empty()) members.insert("parent");
  }
  return members;
}

/// Lists what a .t4d has besides its mesh.
Result<void> addLostMetadata(const formats::Mesh4dFormat& format, ConvertInput& input) {
  const formats::Metadata& metadata = input.metadata;
  LostNames lost(format, input.losses);
  std::vector<std::string_view> general;
  if (!metadata.lengthUnit.empty() || !metadata.timeUnit.empty()) general.push_back("units");
  if (metadata.up != formats::Metadata().up) general.push_back("the upward axis");
  if (!metadata.backend.empty() || metadata.detailsJson != "{}") {
    general.push_back("how the mesh was made");
  }
  lost.add("metadata", general);
  if (!metadata.space.empty()) lost.add("the anatomical space", std::set{metadata.space});
  std::set<std::string> kinds;
  for (const auto& [attribute, meaning] : metadata.attributes) kinds.insert(attribute);
  lost.add("kinds and units of attributes", kinds);
  std::set<std::string> detailed;
  for (const formats::BodyInfo& body : metadata.bodies) {
    if (body.detailsJson != "{}") detailed.insert(body.name);
  }
  lost.add("details of bodies", detailed);
  lost.add("further members of the metadata", furtherMembers(metadata));
  std::set<std::string> types;
  const auto addType = [&](const auto& /*file*/, const auto& header) -> Result<void> {
    types.insert(header.name());
    return {};
  };
  if (auto added = input.reader->optionalChunks().each(addType); !added) return added;
  lost.add("chunks", types);
  return {};
}

Result<void> writeConvertedOther(const std::string& output, const formats::Mesh4dFormat& format,
                                 ConvertInput& input) {
  auto mesh = formats::FlatBodies::of(input.bodies);
  if (!mesh) return mesh.error();
  std::set<std::string> attributes = input.attributes;
  if (format.keeps.attributes != nullptr && !attributes.empty()) {
    if (auto found = mesh->findAttributes(format.keeps.attributes); !found) return found;
    for (const model::Attribute& kept : mesh->attributes()) attributes.erase(kept.name);
  }
  for (std::string& loss : formats::mesh4dLosses(format, *mesh)) {
    input.losses.push_back(std::move(loss));
  }
  const std::string& name = input.bodies.front().name;
  if (!format.keeps.names && input.bodies.size() == 1 && input.named &&
      name != formats::asName(std::filesystem::path(output).stem().string())) {
    input.losses.push_back(fmt::format("name of the body not kept by {}: '{}'", format.id, name));
  }
  LostNames(format, input.losses).add("attributes", attributes);
  if (!format.keeps.metadata && input.reader) {
    if (auto added = addLostMetadata(format, input); !added) return added;
  }
  return format.write(output, *mesh);
}

Result<void> writeConverted(const ConvertOptions& options, const std::string& format,
                            ConvertInput& input, Observer& observer) {
  auto written = format == kT4dFormat
                     ? writeConvertedT4d(options.output, input, observer)
                     : writeConvertedOther(options.output, *formats::mesh4dFormat(format), input);
  if (written || !written.error().where.empty()) return written;
  Error error = written.error();
  error.where = options.output;
  return error;
}

}  // namespace

bool isFromT4d(const ConvertOptions& options) {
  if (!options.from.empty()) return options.from == kT4dFormat;
  const std::string extension = formats::lowerCaseExtension(options.input);
  return extension == ".t4d" || extension == ".t4dm" || !formats::schemeOf(options.input).empty() ||
         formats::isT4d(options.input);
}

std::string formatToWrite(const ConvertOptions& options) {
  if (options.to.empty() ? formats::lowerCaseExtension(options.output) == ".t4d"
                         : options.to == kT4dFormat) {
    return std::string(kT4dFormat);
  }
  const auto* format = options.to.empty() ? formats::writtenMesh4dFormat(options.output)
                                          : formats::mesh4dFormat(options.to);
  return format == nullptr || format->write == nullptr ? "" : std::string(format->id);
}

Result<ConvertReport> convert(const ConvertOptions& options, Observer& observer) {
  const platform::KeptInputs kept;
  if (auto good = checkConversion(options); !good) return good.error();
  const platform::Stopwatch stopwatch;
  auto input = openConvertInput(options, observer);
  if (!input) return input.error();
  ConvertReport report;
  report.to = formatToWrite(options);
  if (auto written = writeConverted(options, report.to, *input, observer); !written) {
    return written.error();
  }
  report.from = input->format;
  report.dialect = input->dialect;
  report.bodies = input->bodies.size();
  for (const formats::CountedBody& body : input->bodies) {
    report.vertices += body.vertices;
    report.tetrahedra += body.tetrahedra;
  }
  report.closed = input->closed;
  report.oriented = input->oriented;
  report.losses = std::move(input->losses);
  report.notices = std::move(input->notices);
  report.seconds = stopwatch.seconds();
  return report;
}

void describe(Members& members, const ConvertReport& report) {
  members("in", report, "The format of the input, and how the file uses it.",
          [](Members& own, const ConvertReport& of) {
            own("format", of.from, "Name of the format, as in --from.").notEmpty();
            own("dialect", of.dialect, "The variant of the format; empty if it has only one.");
          });
  members("out", report, "The format of the output.", [](Members& own, const ConvertReport& of) {
    own("format", of.to, "Name of the format, as in --to.").notEmpty();
  });
  members("bodies", report.bodies, "Bodies written.").atLeast(1);
  members("vertices", report.vertices, "Vertices written; those where two slabs meet count once.");
  members("tetrahedra", report.tetrahedra, "Tetrahedra written.");
  members("closed", report.closed, "Whether every triangle has exactly two tetrahedra.");
  members("oriented", report.oriented,
          "Whether the two tetrahedra of each triangle are on opposite sides.");
  members("losses", report.losses, "Data that the output could not keep, one sentence each.");
  addCosts(members, report.seconds);
}

namespace {

struct ConvertArguments {
  ConvertOptions convert;
  bool acceptLoss = false;
  bool json = false;
};

/// The error message if these options cannot be.
std::optional<std::string> misuseOf(const ConvertOptions& options) {
  if (formatToWrite(options).empty()) {
    return fmt::format("unsupported output extension: '{}' is not .t4d, {}; --to names the format",
                       options.output, formats::writableMesh4dExtensions());
  }
  if ((options.slabs || options.weld) && isFromT4d(options)) {
    return "--slabs and --weld are for meshes without slabs; a .t4d has them";
  }
  return std::nullopt;
}

/// The name of a format, given its id.
std::string formatNameOf(const std::string& format) {
  return format == kT4dFormat ? ".t4d" : std::string(formats::mesh4dFormat(format)->name);
}

std::string titleOf(const ConvertReport& report) {
  std::string title = formatNameOf(report.from);
  // The name of an OFF file says its dialect.
  if (!report.dialect.empty() && title.find(report.dialect) == title.npos) {
    title += " (" + report.dialect + ")";
  }
  return title;
}

/// Notes on a choice of options that is allowed, but may be a mistake.
std::vector<std::string> noticesOfChoices(const ConvertOptions& options) {
  std::vector<std::string> notices;
  const std::string written = formatToWrite(options);
  if (options.slabs && written != kT4dFormat) {
    notices.push_back(fmt::format("{}: {} has no slabs; --slabs only splits tetrahedra at the cuts",
                                  options.output, formatNameOf(written)));
  }
  return notices;
}

void printReport(const ConvertReport& report, const std::string& output) {
  print("{}: {}, {}, {}; {}, {}\n", output, counted(report.bodies, "body", "bodies"),
        counted(report.vertices, "vertex", "vertices"),
        counted(report.tetrahedra, "tetrahedron", "tetrahedra"),
        report.closed ? "closed" : "NOT CLOSED", report.oriented ? "oriented" : "NOT ORIENTED");
  print("  {} to {}, {:.2f} s, peak memory {}\n", titleOf(report), formatNameOf(report.to),
        report.seconds, sizeText(peakBytes()));
}

int run(ConvertArguments& arguments) {
  ConvertOptions& options = arguments.convert;
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  options.generator = versionText();
  ConsoleObserver observer;
  const auto done = convert(options, observer);
  if (!done) return report(done.error());
  printNotices(done->notices);
  printNotices(noticesOfChoices(options));
  if (!done->closed || !done->oriented) {
    printNotices({fmt::format("{}: the mesh is {}: slices and volumes of it mean nothing",
                              options.output, done->closed ? "not oriented" : "not closed")});
  }
  if (arguments.json) {
    printAsJson(*done);
  } else {
    printReport(*done, options.output);
  }
  const int code = reportLosses(done->losses);
  return arguments.acceptLoss ? kDone : code;
}

/// The id of a format of 4D meshes.
CLI::Validator formatId(bool written) {
  std::vector<std::string> ids = {std::string(kT4dFormat)};
  for (const formats::Mesh4dFormat& format : formats::mesh4dFormats()) {
    if (written ? format.write != nullptr : format.read != nullptr) ids.emplace_back(format.id);
  }
  return CLI::IsMember(ids);
}

}  // namespace

void addConvert(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("convert", "Convert a 4D mesh between file formats");
  auto options = std::make_shared<ConvertArguments>();
  ConvertOptions& convert = options->convert;
  command
      ->add_option("IN", convert.input,
                   "Input file, in a format that `t4d formats` lists; .t4d also by URL")
      ->required();
  command
      ->add_option("OUT", convert.output,
                   fmt::format("Output file: .t4d, {}", formats::writableMesh4dExtensions()))
      ->required()
      ->check(someName());
  command->add_option("--from", convert.from, "Format of IN (default: from its content)")
      ->check(formatId(false))
      ->type_name("FORMAT");
  command->add_option("--to", convert.to, "Format of OUT (default: from its extension)")
      ->check(formatId(true))
      ->type_name("FORMAT");
  command
      ->add_option("--slabs", convert.slabs,
                   "Cut into N slabs, splitting tetrahedra (default: cut where none is split)")
      ->check(wholeNumber(1, 1'000'000))
      ->type_name("N");
  command
      ->add_option("--weld", convert.weld,
                   "Merge vertices within this distance per axis (default: equal ones, if open)")
      ->check(numberFromZero())
      ->type_name("DISTANCE");
  command->add_flag("--allow-open", convert.allowOpen,
                    "Accept meshes that are open or cannot be oriented");
  command->add_flag("--accept-loss", options->acceptLoss,
                    "Exit with 0 even if data was lost (losses are still listed)");
  addNoPartOption(*command,
                  "converting cannot be divided: other formats hold a mesh as one; join the parts "
                  "first (t4d join), or write a .t4d in parts (t4d compress)");
  addMaxCellsOption(*command, convert.maxCells);
  addJsonOption<ConvertReport>(*command, options->json,
                               "The result of a conversion; numbers are for all bodies together.");
  command->footer(
      "Example:\n  t4d convert bolt.t4d bolt.vtu --accept-loss\n"
      "  t4d convert polytope.off polytope.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools

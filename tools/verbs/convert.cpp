#include "tools/verbs/convert.h"

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
#include "tools/verbs/convert_input.h"
#include "tools/verbs/members.h"

namespace t4d::verbs {
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

}  // namespace t4d::verbs

#include "tools/t4d/du.h"

#include <algorithm>
#include <functional>

#include <fmt/format.h>

#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/info.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"

namespace t4d::tools {
double DuReport::perTetrahedron(std::uint64_t ofBytes) const {
  return tetrahedra == 0 ? 0 : static_cast<double>(ofBytes) / static_cast<double>(tetrahedra);
}

Result<DuReport> du(const std::string& path) {
  auto file = info(path);
  if (!file) return file.error();
  DuReport report{.name = file->name,
                  .bytes = file->bytes,
                  .tetrahedra = file->total().tetrahedra,
                  .chunks = std::move(file->chunks),
                  .otherBytes = file->bytes};
  std::ranges::stable_sort(report.chunks, std::ranges::greater(), &formats::T4dChunks::bytes);
  for (const formats::T4dChunks& some : report.chunks) report.otherBytes -= some.bytes;
  return report;
}

void describe(Members& members, const DuReport& report) {
  const auto perTetrahedron = [&](Members& own, std::uint64_t bytes) {
    own("bytes_per_tetrahedron", report.perTetrahedron(bytes),
        "Bytes divided by the tetrahedra of the file; 0 if it has none.")
        .atLeast(0);
  };
  members("bytes", report.bytes, "Size of the file, in bytes.");
  members("tetrahedra", report.tetrahedra, "Tetrahedra of all bodies.");
  perTetrahedron(members, report.bytes);
  members("chunks", report.chunks, "The chunks of each type, the largest total first.",
          [&](Members& own, const formats::T4dChunks& some) {
            own("type", some.type, "Type of the chunks.");
            own("count", some.count, "Number of chunks of this type.").atLeast(1);
            own("bytes", some.bytes, "Their bytes, including headers and padding.");
            perTetrahedron(own, some.bytes);
          });
  members("other_bytes", report.otherBytes, "Bytes of the header and the footer of the file.");
}

namespace {

std::string whatIs(const std::string& type) {
  static const std::vector<std::pair<std::string, std::string>> known = {
      {"HEAD", "metadata"},        {"CONN", "cells"}, {"LAYR", "positions of layers"},
      {"SLAB", "slabs, interior"}, {"POSE", "poses"}, {"PADD", "padding"},
      {"DONE", "totals"},          {"INDX", "index"}};
  const auto found = std::ranges::find(known, type, &std::pair<std::string, std::string>::first);
  return found == known.end() ? std::string() : found->second;
}

void printReport(const DuReport& report) {
  print("{}: {} for {}\n", report.name, sizeText(report.bytes),
        counted(report.tetrahedra, "tetrahedron", "tetrahedra"));
  std::vector<std::vector<std::string>> rows = {
      {"  chunks", "", "number", "bytes", "share", "per cell"}};
  const auto add = [&](const std::string& type, const std::string& number, std::uint64_t bytes) {
    rows.push_back(
        {"  " + type, whatIs(type), number, grouped(bytes),
         fmt::format("{:.1f} %", 100 * static_cast<double>(bytes) /
                                     static_cast<double>(std::max<std::uint64_t>(report.bytes, 1))),
         fmt::format("{:.3g}", report.perTetrahedron(bytes))});
  };
  for (const formats::T4dChunks& some : report.chunks) {
    add(some.type, grouped(some.count), some.bytes);
  }
  add("ends of the file", "", report.otherBytes);
  add("all", "", report.bytes);
  printTable(rows, "llr");
}

int run(const std::string& path, bool json) {
  const auto done = du(path);
  if (!done) return report(done.error());
  if (json) {
    printAsJson(*done);
  } else {
    printReport(*done);
  }
  return kDone;
}

}  // namespace

void addDu(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("du", "Print what takes up the bytes of a .t4d file");
  auto path = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  command->add_option("FILE", *path, std::string(kT4dFileHelp) + kOrPipeHelp)->required();
  addJsonOption<DuReport>(*command, *json, "What takes up space in a .t4d file.");
  command->footer("Example:\n  t4d du bolt.t4d");
  command->callback([=, &exitCode] { exitCode = run(*path, *json); });
}

}  // namespace t4d::tools

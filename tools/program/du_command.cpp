#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/t4d/reader.h"
#include "t4d/formats/t4d/stream.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/input_options.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

std::string whatIs(const std::string& type) {
  static const std::vector<std::pair<std::string, std::string>> known = {
      {"HEAD", "metadata"},        {"CONN", "cells"}, {"LAYR", "positions of layers"},
      {"SLAB", "slabs, interior"}, {"POSE", "poses"}, {"PADD", "padding"},
      {"DONE", "totals"},          {"INDX", "index"}};
  const auto found = std::ranges::find(known, type, &std::pair<std::string, std::string>::first);
  return found == known.end() ? std::string() : found->second;
}

/// `File` is a reader, or a stream that has ended.
template <class File>
void printUse(const File& file, bool json) {
  std::uint64_t cells = 0;
  for (std::size_t i = 0; i < file.bodyCount(); ++i) cells += file.summary(i).tetrahedra;
  const std::uint64_t all = file.fileBytes();
  std::vector<formats::T4dChunks> chunks = file.chunks();
  std::ranges::stable_sort(chunks, std::ranges::greater(), &formats::T4dChunks::bytes);
  std::uint64_t inChunks = 0;
  for (const formats::T4dChunks& some : chunks) inChunks += some.bytes;
  const auto perCell = [&](std::uint64_t bytes) {
    return cells == 0 ? 0 : static_cast<double>(bytes) / static_cast<double>(cells);
  };
  if (json) {
    ordered_json value = {{"bytes", all},
                          {"tetrahedra", cells},
                          {"bytes_per_tetrahedron", perCell(all)},
                          {"chunks", ordered_json::array()},
                          {"other_bytes", all - inChunks}};
    for (const formats::T4dChunks& some : chunks) {
      value["chunks"].push_back({{"type", some.type},
                                 {"count", some.count},
                                 {"bytes", some.bytes},
                                 {"bytes_per_tetrahedron", perCell(some.bytes)}});
    }
    printJson(value);
    return;
  }
  print("{}: {} for {}\n", file.name(), sizeText(all), counted(cells, "tetrahedron", "tetrahedra"));
  std::vector<std::vector<std::string>> rows = {
      {"  chunks", "", "number", "bytes", "share", "a cell"}};
  const auto add = [&](const std::string& type, const std::string& number, std::uint64_t bytes) {
    rows.push_back(
        {"  " + type, whatIs(type), number, grouped(bytes),
         fmt::format("{:.1f} %", 100 * static_cast<double>(bytes) /
                                     static_cast<double>(std::max<std::uint64_t>(all, 1))),
         fmt::format("{:.3g}", perCell(bytes))});
  };
  for (const formats::T4dChunks& some : chunks) add(some.type, grouped(some.count), some.bytes);
  add("ends of the file", "", all - inChunks);
  add("all", "", all);
  printTable(rows, "llr");
}

int run(const std::string& path, bool json) {
  if (formats::isPipe(path)) {
    auto stream = formats::T4dStream::open(path, formats::kAnyCells);
    if (!stream) return report(stream.error());
    while (true) {
      const auto item = stream->next();
      if (!item) return report(item.error());
      if (!*item) break;
    }
    printUse(*stream, json);
    return kDone;
  }
  const auto reader =
      formats::T4dReader::open(path, formats::T4dOpen::Whole, {}, formats::kAnyCells);
  if (!reader) return report(reader.error());
  printUse(*reader, json);
  return kDone;
}

}  // namespace

void addDu(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("du", "Print what takes up the bytes of a .t4d file");
  auto path = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  command->add_option("FILE", *path, std::string(kT4dFileHelp) + kOrPipeHelp)->required();
  command->add_flag("--json", *json, "Print JSON");
  command->footer("Example:\n  t4d du bolt.t4d");
  command->callback([=, &exitCode] { exitCode = run(*path, *json); });
}

}  // namespace t4d::tools

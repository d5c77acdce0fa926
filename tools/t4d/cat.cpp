#include <cstring>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/input.h"
#include "tools/t4d/option_checks.h"

namespace t4d::tools {
namespace {

struct CatArguments {
  std::string input;
  InputOptions only;
  std::optional<std::uint64_t> slab;
};

/// Text that is printed a piece at a time.
class Lines {
 public:
  ~Lines() { flush(); }

  template <class... Values>
  void add(fmt::format_string<Values...> text, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), text, std::forward<Values>(values)...);
    constexpr std::size_t kPiece = std::size_t{1} << 16U;
    if (text_.size() >= kPiece) flush();
  }

 private:
  void flush() {
    printText(text_);
    text_.clear();
  }

  std::string text_;
};

template <class Scalar>
void addNumbers(Lines& lines, const std::byte* row, std::uint32_t count) {
  for (std::uint32_t i = 0; i < count; ++i) {
    Scalar number;
    std::memcpy(&number, row + i * sizeof(Scalar), sizeof(Scalar));
    lines.add(" {}", +number);
  }
}

void addRow(Lines& lines, const model::Attribute& attribute, std::size_t index) {
  using enum model::ScalarType;
  const std::byte* const row = attribute.row(index);
  const std::uint32_t n = attribute.components;
  lines.add("  {}", shown(attribute.name));
  switch (attribute.type) {
    case UInt8:
      return addNumbers<std::uint8_t>(lines, row, n);
    case Int8:
      return addNumbers<std::int8_t>(lines, row, n);
    case UInt16:
      return addNumbers<std::uint16_t>(lines, row, n);
    case Int16:
      return addNumbers<std::int16_t>(lines, row, n);
    case UInt32:
      return addNumbers<std::uint32_t>(lines, row, n);
    case Int32:
      return addNumbers<std::int32_t>(lines, row, n);
    case UInt64:
      return addNumbers<std::uint64_t>(lines, row, n);
    case Int64:
      return addNumbers<std::int64_t>(lines, row, n);
    case Float32:
      return addNumbers<float>(lines, row, n);
    case Float64:
      return addNumbers<double>(lines, row, n);
  }
}

const char* partOf(const model::VertexCounts& counts, std::uint32_t vertex, std::uint32_t means) {
  if (vertex < counts.lowerCount) return "lower";
  if (vertex >= counts.firstUpper()) return "upper";
  return vertex + means >= counts.firstUpper() ? "mean" : "inner";
}

void printSlab(const std::string& body, std::size_t index, const model::Slab& slab) {
  const model::Connectivity& connectivity = *slab.connectivity;
  const std::uint32_t means = connectivity.means.size();
  Lines lines;
  lines.add(
      "slab {} of '{}': time {} to {}, {} vertices ({} lower, {} upper, {} means), {} cells\n",
      index, shown(body), slab.timeBegin, slab.timeEnd, connectivity.vertexCount,
      connectivity.lowerCount, connectivity.upperCount, means, connectivity.cells.size());
  const auto addAttributes = [&](model::Domain domain, std::size_t row) {
    for (const auto* attributes : {&connectivity.cellAttributes, &slab.attributes}) {
      for (const model::Attribute& attribute : *attributes) {
        if (attribute.domain == domain) addRow(lines, attribute, row);
      }
    }
  };
  for (std::uint32_t i = 0; i < connectivity.vertexCount; ++i) {
    const model::Point4& v = slab.vertices[i];
    lines.add("  {} {}: {} {} {} {}", partOf(connectivity, i, means), i, v[0], v[1], v[2], v[3]);
    if (i >= connectivity.firstMean() && i < connectivity.firstUpper()) {
      const std::uint32_t mean = i - connectivity.firstMean();
      const auto& offsets = connectivity.means.offsets;
      lines.add("  of");
      for (std::uint32_t k = offsets[mean]; k < offsets[mean + 1]; ++k) {
        lines.add(" {}", connectivity.means.sources[k]);
      }
    }
    addAttributes(model::Domain::Vertex, i);
    lines.add("\n");
  }
  for (std::size_t i = 0; i < connectivity.cells.size(); ++i) {
    const auto& [a, b, c, d] = connectivity.cells[i];
    lines.add("  cell {}: {} {} {} {}", i, a, b, c, d);
    addAttributes(model::Domain::Cell, i);
    lines.add("\n");
  }
}

int run(const CatArguments& options) {
  const auto input = openInput(options.input, options.only);
  if (!input) return report(input.error());
  for (const auto& [name, source] : input->bodies) {
    const std::size_t count = source->slabCount();
    if (options.slab && *options.slab >= count) {
      return report(Error{ErrorCode::InvalidInput,
                          fmt::format("body '{}' has no slab {}; it has the slabs 0 to {}", name,
                                      *options.slab, count - 1),
                          input->name,
                          {}});
    }
  }
  for (const auto& [name, source] : input->bodies) {
    const std::size_t first = options.slab.value_or(0);
    const std::size_t end = options.slab ? first + 1 : source->slabCount();
    for (std::size_t i = first; i < end && printError() == 0; ++i) {
      const auto slab = source->slab(i);
      if (!slab) return report(slab.error());
      printSlab(name, i, **slab);
    }
  }
  return kDone;
}

}  // namespace

void addCat(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("cat", "Print the vertices and cells of a .t4d file as text");
  auto options = std::make_shared<CatArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  options->only.addTo(*command);
  command->add_option("--slab", options->slab, "Print only this slab of each body, counted from 0")
      ->type_name("N");
  command->footer("Example:\n  t4d cat bolt.t4d --slab 0 | less");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools

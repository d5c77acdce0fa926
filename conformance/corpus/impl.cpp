#include "conformance/corpus/cases.h"
#include "conformance/corpus/shapes.h"
#include "conformance/corpus/zstd_frame.h"

/// Files that a reader may accept or refuse.
namespace t4d::conformance {
namespace {

using model::Attribute;
using model::Cell;
using model::Connectivity;
using model::Domain;
using model::Slab;

void addHeads(AcceptedCases& cases) {
  const auto add = [&](const std::string& name, const std::string& what, const std::string& head,
                       const std::string& mark) {
    const Image image = Image::of({{"simplex", simplex()}}, {}, head);
    cases.add(name, what)
        .leftOpenIn("head")
        .of(image, {{"simplex", simplex()}})
        .shows({"json"})
        .slicedAt({0.5})
        .at(image.offset("HEAD/json") + head.find(mark));
  };
  const auto with = [&](const std::string& name, const std::string& what,
                        const std::string& members, const std::string& mark) {
    add(name, what, headJson({}, {"simplex"}, members), mark);
  };
  add("member-twice-bodies", "Bodies are named twice: refused, or the last taken.",
      R"({"bodies":[{"name":"other"},{"name":"another"}],"features":[],"bodies":[{"name":"simplex"}]})",
      R"("bodies":["simp)");
  add("member-twice-features", "Features are named twice, first an unknown one: refused, or none.",
      R"({"features":["wavelets"],"bodies":[{"name":"simplex"}],"features":[]})",
      R"("features":[])");
  add("member-twice-by-escape", "Bodies are named twice, the second time in escapes.",
      R"({"features":[],"bodies":[{"name":"other"}],"\u0062odies":["simplex"]})", R"("\u0062)");
  with("member-twice-up", "up is there twice, first with a wrong value.", R"("up":"x","up":"z")",
       R"("up":"z")");
  with("member-twice-in-details", "A member of details is there twice.",
       R"("details":{"a":1,"b":{},"a":2})", R"("a":2)");
  with("surrogate-in-generator", "An escape of an unpaired surrogate.", R"("generator":"a\ud800b")",
       "\\ud800");
  with("surrogate-in-details", "Escapes of a surrogate pair in the wrong order.",
       R"("details":{"a":"\udc00\ud800"})", "\\udc00");
  with("surrogate-in-member-name", "An unpaired surrogate in a member's name.",
       R"("details":{"\udfff":1})", "\\udfff");
  with("number-1e999", "A number that binary64 cannot hold.", R"("details":{"a":1e999})", "1e999");
  with("number-negative-1e400", "A number that binary64 cannot hold.", R"("details":{"a":-1e400})",
       "-1e400");
  with("number-1e-999", "A number that binary64 rounds to 0.", R"("details":{"a":1e-999})",
       "1e-999");
  with("number-of-400-digits", "An integer that binary64 cannot hold.",
       R"("details":{"a":)" + std::string(400, '9') + "}", "999");
  with("number-2-to-the-64", "An integer of more than 64 bits.",
       R"("details":{"a":18446744073709551616})", "184467");
}

void addArrays(AcceptedCases& cases) {
  std::string bytes;
  const std::vector<Slab> slabs = simplex();
  for (const Cell& cell : slabs[0].connectivity->cells) {
    for (const std::uint32_t index : cell) bytes += bytesOf(index);
  }
  for (const int windowLog : {24, 27, 31, 41}) {
    Image image = Image::of({{"simplex", simplex()}}, {}, headJson({"zstd"}, {"simplex"}));
    image.chunk("CONN 0").payload.replace(
        "cells",
        arrayRecord(5, 4, 1, 5, {zstdFrame(transposed(bytes, 16), {.windowLog = windowLog})}));
    cases
        .add("window-of-2-to-the-" + std::to_string(windowLog),
             "A frame of 80 bytes says that decoding takes a window of 2^" +
                 std::to_string(windowLog) + " bytes.")
        .leftOpenIn("limits")
        .of(image, {{"simplex", simplex()}})
        .naming({"zstd"})
        .shows({"zstd"})
        .slicedAt({0.5})
        .at(image.offset("CONN 0/cells/stored") + 5);
  }

  // 4,096 vertices with 128 zeros of 8 bytes each.
  constexpr std::uint32_t kVertices = 4096;
  std::vector<Slab> large = simplex();
  auto connectivity = std::make_shared<Connectivity>(*large[0].connectivity);
  connectivity->vertexCount = kVertices;
  large[0].connectivity = connectivity;
  large[0].vertices.resize(kVertices, model::Point4(0, 0, 0, 0));
  Attribute zeros{"zeros", Domain::Vertex, model::ScalarType::Float64, 128, {}};
  zeros.values.resize(kVertices * zeros.rowBytes());
  large[0].attributes = {zeros};
  Image image = Image::of({{"simplex", large}}, {}, headJson({"zstd"}, {"simplex"}));
  Record& payload = image.chunk("SLAB 0").payload;
  const auto compress = [&](const std::string& array, model::ScalarType type,
                            std::uint8_t components, const std::string& content) {
    const std::size_t rowBytes = model::scalarSize(type) * components;
    payload.replace(array, arrayRecord(static_cast<std::uint8_t>(type), components, 1, kVertices,
                                       {zstdFrame(transposed(content, rowBytes),
                                                  {.windowLog = 12, .blockBytes = 4096})}));
  };
  for (const char* array : {"interior positions", "interior times"}) {
    const std::uint8_t components = array[9] == 'p' ? 3 : 1;
    compress(array, model::ScalarType::Float64, components,
             payload.contents(std::string(array) + "/stored"));
  }
  compress("attribute 0/values", model::ScalarType::Float64, 128,
           std::string(zeros.values.size(), '\0'));
  cases
      .add("expansion-to-4-MiB",
           "An attribute of 4 MiB in a file of 38 KB: a reader without so much memory says so.")
      .leftOpenIn("limits")
      .of(image, {{"simplex", large}})
      .naming({"zstd"})
      .shows({"zstd", "large"})
      .slicedAt({0.5})
      .at(image.offset("SLAB 0/attribute 0/values"));
}

/// The simplex with different cells.
std::vector<Slab> simplexOf(const std::vector<Cell>& cells) {
  std::vector<Slab> slabs = simplex();
  auto connectivity = std::make_shared<Connectivity>(*slabs[0].connectivity);
  connectivity->cells = cells;
  slabs[0].connectivity = connectivity;
  return slabs;
}

void addMeshes(AcceptedCases& cases) {
  const auto add = [&](const std::string& name, const std::string& what,
                       const std::vector<Slab>& slabs, const std::vector<double>& times) {
    cases.add("mesh-" + name, what)
        .leftOpenIn("the-mesh")
        .of({{"faulty", slabs}})
        .shows({"faulty-mesh"})
        .slicedAt(times);
  };
  const std::vector<Slab> right = simplex();
  const std::vector<Cell>& all = right[0].connectivity->cells;
  add("open", "One of the five cells of a simplex is missing.",
      simplexOf({all.begin(), all.end() - 1}), {0.5});
  std::vector<Cell> cells = all;
  cells.push_back({0, 1, 3, 4});
  add("doubled-cell", "A cell is there twice, so that its facets have three cells.",
      simplexOf(cells), {0.5});
  cells = all;
  std::swap(cells[2][0], cells[2][1]);
  add("cell-turned", "One cell has the other orientation.", simplexOf(cells), {0.5});
  cells = all;
  for (Cell& cell : cells) std::swap(cell[0], cell[1]);
  add("inside-out", "All cells have the other orientation: the hypervolume is negative.",
      simplexOf(cells), {0.5});

  // Two simplices; the last corner of one is the first of the other.
  auto pinched = std::make_shared<Connectivity>();
  pinched->vertexCount = 9;
  pinched->cells = all;
  for (Cell cell : all) {
    for (std::uint32_t& corner : cell) corner += 4;
    pinched->cells.push_back(cell);
  }
  Slab two = right[0];
  two.connectivity = pinched;
  two.timeEnd = 2;
  const std::vector<Slab> second = simplex(1, two.vertices[4]);
  two.vertices.insert(two.vertices.end(), second[0].vertices.begin() + 1, second[0].vertices.end());
  add("pinched", "Two simplices share a vertex, around which the cells form two balls.", {two},
      {0.5, 1, 1.5});

  const std::vector<Slab> cross = crossPolytope();
  add("half", "The slab above a layer is missing.", {cross[0]}, {-0.5, 0});
  Slab lacking = cross[1];
  auto fewer = std::make_shared<Connectivity>(*lacking.connectivity);
  fewer->cells.pop_back();
  lacking.connectivity = fewer;
  add("open-at-layer", "A cell above a layer is missing.", {cross[0], lacking}, {-0.5, 0, 0.5});
  Slab turned = cross[1];
  auto other = std::make_shared<Connectivity>(*turned.connectivity);
  for (Cell& cell : other->cells) std::swap(cell[0], cell[1]);
  turned.connectivity = other;
  add("turned-above-layer", "All cells above a layer have the other orientation.",
      {cross[0], turned}, {-0.5, 0, 0.5});
}

}  // namespace

std::vector<AcceptedCase> implCases() {
  AcceptedCases cases(Validity::Either);
  addHeads(cases);
  addArrays(cases);
  addMeshes(cases);
  return cases.finish();
}

}  // namespace t4d::conformance

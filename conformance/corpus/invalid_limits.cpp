#include <span>

#include <fmt/format.h>

#include "conformance/corpus/far_back.h"
#include "conformance/corpus/invalid.h"
#include "conformance/corpus/shapes.h"
#include "conformance/corpus/zstd_frame.h"

namespace t4d::conformance {
namespace {

using model::Attribute;
using model::Domain;
using model::ScalarType;
using model::Slab;
using namespace std::string_literals;

/// Ranges and bounds of two blocks of cells, in a slab with layers and means: CONN 1 and SLAB 1.
void addBlockFaults(InvalidCases& cases) {
  const std::vector<Slab> slabs = manyPrisms();
  const model::Connectivity& step = *slabs[1].connectivity;
  const Base base = baseOf({{"prisms", slabs}}, {.storage = Storage::Repeats});
  const auto range = [&](const std::string& name, const std::string& fault, int block, int number,
                         std::uint32_t value) {
    const std::string place = fmt::format("CONN 1/range {}", block);
    const std::size_t at = 4 * static_cast<std::size_t>(number);
    cases.add(
        "N2-" + name, fault, base, [&](Image& image) { image.setBytes(place, bytesOf(value), at); },
        place, at);
  };
  range("last-of-lower-layer-without-sources",
        "The range of the lower layer ends with the vertices of the cells, not with the sources of "
        "their "
        "means.",
        1, 1, step.lowerCount - 1);
  range("last-of-upper-layer-without-sources",
        "The range of the upper layer ends with the vertices of the cells, not with the sources of "
        "their "
        "means.",
        1, 5, step.vertexCount - 1);
  range("mean-as-itself", "The range of the interior ends with a mean, not with its sources.", 1, 3,
        step.firstUpper());
  range("first-of-lower-layer", "The range of the lower layer begins a vertex too early.", 1, 0,
        step.lowerCount - 4);
  range("first-of-upper-layer",
        "The range of the upper layer of the first block begins a vertex late.", 0, 4,
        step.firstUpper() + 1);

  const auto bound = [&](const std::string& name, const std::string& fault, int block,
                         std::size_t number, const std::vector<double>& values) {
    const std::string place = fmt::format("SLAB 1/bounds {}", block);
    std::string bytes;
    for (const double value : values) bytes += bytesOf(value);
    cases.add(
        "S10-" + name, fault, base, [&](Image& image) { image.setBytes(place, bytes, 8 * number); },
        place, 8 * number);
  };
  bound("of-the-first-block", "The greatest y of the first block is another.", 0, 5, {100.5});
  bound("least-x", "The least x of a block is another.", 1, 0, {-64.5});
  bound("least-y", "The least y of a block is another.", 1, 1, {-1});
  bound("greatest-z", "The greatest z of a block is another.", 1, 6, {100.5});
  bound("of-the-sources",
        "The bounds of a block are those of the sources of its means, not of the means.", 1, 0,
        {-96});
  bound("of-all-cells", "The bounds of a block are those of the slab.", 1, 0,
        {-96, 0, 0, 0, 32, 18, 20, 1});
  bound("least-t", "The least t of a block is another.", 1, 3, {0.5});
  cases.refusedAt(0.75);
  const auto counted = [&](const std::string& name, const std::string& fault, std::uint32_t count) {
    const auto change = [count](Image& image) {
      Record& payload = image.chunk("SLAB 1").payload;
      Record made;
      for (const char* field :
           {"begin", "end", "connectivity", "lower", "upper", "body", "attributes"}) {
        made.putBytes(field, payload.contents(field));
      }
      made.put("bounds", count);
      made.put("reserved", std::uint32_t{0});
      for (std::uint32_t i = 0; i < count; ++i) {
        made.putBytes(fmt::format("bounds {}", i),
                      payload.contents(fmt::format("bounds {}", i % 2)));
      }
      for (const char* array : {"interior positions", "interior times"}) {
        made.add(array, payload.part(array));
      }
      payload = made;
    };
    cases.add("S10-" + name, fault, base, change, "SLAB 1/bounds");
  };
  counted("one-of-two-blocks", "Two blocks of cells have one bound.", 1);
  counted("three-of-two-blocks", "Two blocks of cells have three bounds.", 3);
}

void addFarFaults(InvalidCases& cases) {
  const auto far = [&](const std::string& name, const std::string& fault, FarPart part,
                       std::uint32_t bodies, const std::string& place) {
    const std::uint32_t most = 16 * bodies;
    const bool posed = part == FarPart::Pose || part == FarPart::LayerOfPose;
    const Base base = {
        partFarBack(part, bodies, most).image,
        posed ? std::vector<std::string>{"pose", "index"} : std::vector<std::string>{"index"}};
    cases.add(
        name, fault, base, [&](Image& image) { image = partFarBack(part, bodies, most + 1).image; },
        place);
  };
  far("S12-pose", "upper names the last POSE but 16.", FarPart::Pose, 1, "SLAB 0/upper");
  far("S12-connectivity-of-two-bodies", "Of two bodies; connectivity names the last CONN but 32.",
      FarPart::Connectivity, 2, "SLAB 33/connectivity");
  far("S12-layer-of-two-bodies", "Of two bodies; upper names the last LAYR but 32.", FarPart::Layer,
      2, "SLAB 0/upper");
  far("S12-pose-of-two-bodies", "Of two bodies; upper names the last POSE but 32.", FarPart::Pose,
      2, "SLAB 0/upper");
  far("K6-of-two-bodies", "Of two bodies; a POSE moves the last LAYR but 32.", FarPart::LayerOfPose,
      2, "POSE 33/layer");
}

void addMeansFaults(InvalidCases& cases) {
  const Base base = withMeans();
  const auto replace = [&](const std::string& name, const std::string& fault,
                           const std::string& array, const Record& record,
                           const std::string& field) {
    cases.add(
        name, fault, base,
        [&](Image& image) { image.chunk("CONN 0").payload.replace(array, record); },
        "CONN 0/" + array + "/" + field);
  };
  const std::string sizes = bytesOf(4U) + bytesOf(2U);
  std::string sources;
  for (const std::uint32_t source : {0U, 1U, 2U, 6U, 5U, 6U}) sources += bytesOf(source);
  replace("N6-sizes-of-type-6", "The mean sizes are of signed integers.", "mean sizes",
          arrayRecord(ScalarType::Int32, 1, sizes, Storage::Raw), "scalar type");
  replace("N6-six-rows-of-2-sources", "The mean sources have two numbers in each of six rows.",
          "mean sources", arrayRecord(ScalarType::UInt32, 2, sources + sources, Storage::Raw),
          "components");
}

void addTypeFaults(InvalidCases& cases) {
  Base base = plain();
  base.image.add(noteChunk(5), "SLAB 0");
  for (const auto& [name, type] : {std::pair{"second-of-small-letters", "n_te"},
                                   {"third-of-small-letters", "no{e"},
                                   {"last-of-small-letters", "not@"},
                                   {"second-of-capitals", "NoTE"},
                                   {"third-of-capitals", "NOtE"},
                                   {"second-not-a-letter", "N[TE"},
                                   {"last-of-capitals", "NOT`"}}) {
    cases.add(
        fmt::format("C1-type-wrong-in-the-{}", name),
        "One character of the type of an optional chunk is wrong.", base,
        [type = type](Image& image) { image.setBytes("note/header/type", type); },
        "note/header/type");
  }
}

/// lower names a POSE that has the same header as the one that upper of the slab before names: both
/// are as far from copies of one LAYR.
void addCopiedPose(InvalidCases& cases) {
  const Base base = withPoses();
  cases.add(
      "S7-copy-of-pose-and-layer",
      "lower is a copy of a POSE, with the same header, of a copy of its LAYR.", base,
      [](Image& image) {
        for (const char* part : {"LAYR 1", "POSE 0"}) {
          Image::Chunk copy = image.chunk(part);
          copy.name += " again";
          if (!copy.offsets.empty()) copy.offsets["layer"] = "LAYR 1 again";
          image.add(copy, "POSE 1");
        }
        image.chunk("SLAB 1").offsets["lower"] = "POSE 0 again";
      },
      "SLAB 1/lower");
}

void addNumbersBeyond(InvalidCases& cases) {
  const Solid solid = cornerTetrahedron();
  const std::vector<Slab> slabs = sweep(
      solid, {pose(solid, 0, {0, 0, 0}), pose(solid, 1, {0, 0, 0}), pose(solid, 2, {0, 0, 1})},
      {.capSlabs = false});
  const auto up = [](std::size_t k) { return movedBy({0, 0, k == 0 ? 0.25 : 1}); };
  cases.add(
      "P2-posed-beyond-binary32",
      "A coordinate is finite where it is moved, and not when it is rounded to binary32.",
      baseOf({{"tetrahedron", withPoses(slabs, up, true)}}, {.float32 = true}),
      [](Image& image) { image.set("POSE 1/m00", 1e39); }, "POSE 1/m00");
  Slab nothing;
  nothing.connectivity = std::make_shared<model::Connectivity>();
  nothing.timeBegin = 1;
  nothing.timeEnd = 2;
  cases.add(
      "S1-begin-after-end-of-no-vertices", "begin is greater than end, in a slab without vertices.",
      baseOf({{"nothing", {nothing}}, {"simplex", simplex()}}),
      [](Image& image) { image.set("SLAB 0/begin", 3.0); }, "SLAB 0/begin");
}

void addExpansion(InvalidCases& cases) {
  // 85 rows of 253 bytes are 21,505, which is 1 more than 1,024 x 21.
  std::vector<Slab> slabs = simplex();
  auto connectivity = std::make_shared<model::Connectivity>(*slabs[0].connectivity);
  connectivity->vertexCount = 85;
  slabs[0].connectivity = connectivity;
  slabs[0].vertices.resize(85, model::Point4(0, 0, 0, 0));
  Attribute attribute{"zeros", Domain::Vertex, ScalarType::UInt8, 253, {}};
  attribute.values.resize(std::size_t{85} * 253);
  slabs[0].attributes = {attribute};
  const std::string content(attribute.values.size(), '\0');
  const auto with = [&](const std::string& frame) {
    Image image = Image::of({{"simplex", slabs}}, {.storage = Storage::Library});
    image.chunk("SLAB 0").payload.replace("attribute 0/values",
                                          arrayRecord(1, 253, 1, 85, {frame}));
    return image;
  };
  // 7 bytes of header, two run-length blocks of 4 bytes, a raw block of 3 bytes.
  std::string dense =
      zstdFrame(content.substr(3), {.declaredSize = content.size(), .blockBytes = 10751});
  dense[dense.size() - 4] = static_cast<char>(dense[dense.size() - 4] & ~1);
  dense += "\x19\0\0\0\0\0"s;
  cases.add(
      "A9-a-byte-more-than-1024-times", "An array of 21,505 bytes is stored in 21.",
      {with(zstdFrame(content, {.blockBytes = 4096})), {"zstd", "index"}},
      [&](Image& image) { image = with(dense); }, "SLAB 0/attribute 0/values/rows");
}

/// Faults of HEAD that only one of several values has.
void addHeadFaultsOfOne(InvalidCases& cases) {
  const auto head = [&](const std::string& name, const std::string& fault, const Base& base,
                        const std::string& json) {
    cases.add(
        name, fault, base,
        [&](Image& image) {
          Record payload;
          payload.putBytes("json", json);
          image.chunk("HEAD").payload = payload;
        },
        "HEAD/json");
  };
  std::vector<BodySlabs> four;
  for (const char* name : {"a", "b", "c", "d"}) four.push_back({name, simplex()});
  const Base two = baseOf({four[0], four[1]});
  const Base three = baseOf({four[0], four[1], four[2]});
  const Base all = baseOf(four);
  head("M7-second-is-a-string", "The second body is a string.", two,
       R"({"features":[],"bodies":[{"name":"a"},"b"]})");
  head("M11-parent-unknown-of-two-bodies", "A parent is no body of the file, which has two.", two,
       R"({"features":[],"bodies":[{"name":"a","parent":"b"},{"name":"b","parent":"x"}]})");
  head("M11-parent-unknown-of-a-parent", "A parent of a parent is no body of the file.", all,
       R"({"features":[],"bodies":[{"name":"a","parent":"b"},{"name":"b","parent":"c"},)"
       R"({"name":"c","parent":"x"},{"name":"d"}]})");
  head("M11-three-parents-in-a-circle", "Three bodies are parts of each other.", three,
       R"({"features":[],"bodies":[{"name":"a","parent":"b"},{"name":"b","parent":"c"},)"
       R"({"name":"c","parent":"a"}]})");
  head("M11-part-of-a-circle", "A body is part of two that are parts of each other.", all,
       R"({"features":[],"bodies":[{"name":"a","parent":"b"},{"name":"b","parent":"c"},)"
       R"({"name":"c","parent":"b"},{"name":"d"}]})");
  const auto with = [&](const std::string& name, const std::string& fault,
                        const std::string& members) {
    head(name, fault, plain(), headJson({}, {"simplex"}, members));
  };
  for (const int part : {0, 1, 2, 3}) {
    std::string color;
    for (int i = 0; i < 4; ++i)
      color += fmt::format("{}{}", i > 0 ? "," : "", i == part ? "true" : "0.5");
    head(fmt::format("M11-color-true-at-{}", part), "A number of a color is true.", plain(),
         R"({"features":[],"bodies":[{"name":"simplex","color":[)" + color + "]}]}");
  }
  with("M10-grid-origin-1e400", "A number of the origin is not finite in binary64.",
       R"("grid":{"origin":[0,1e400,0],"step":1})");
  with("M10-grid-origin-negative-1e400", "A number of the origin is not finite in binary64.",
       R"("grid":{"origin":[0,0,-1e400],"step":1})");
  with("M10-grid-step-1e400", "The step is not finite in binary64.",
       R"("grid":{"origin":[0,0,0],"step":1e400})");
  with("M10-grid-origin-true", "A number of the origin is true.",
       R"("grid":{"origin":[0,0,true],"step":1})");
  with("M10-grid-origin-of-four", "The origin has four numbers.",
       R"("grid":{"origin":[0,0,0,0],"step":1})");
  cases.add(
      "H4-flag-1-no-index", "The reserved flag 1 is set, and no other.", unindexed(),
      [](Image& image) { image.set("file/flags", 2U); }, "file/flags");
}

void addCellFaults(InvalidCases& cases) {
  // Cell 4 is (0, 1, 2, 3).
  for (const auto& [name, value, corner] : {std::tuple{"first-and-third", 0U, 2U},
                                            {"second-and-third", 1U, 2U},
                                            {"second-and-last", 1U, 3U}}) {
    const std::size_t at = 64 + std::size_t{4} * corner;
    cases.add(
        fmt::format("N5-{}", name), fmt::format("A cell has the vertex {} twice.", value), plain(),
        [&, value = value](Image& image) {
          image.setBytes("CONN 0/cells/stored", bytesOf(value), at);
        },
        "CONN 0/cells/stored", at);
  }
  const auto repeated = [](const std::vector<std::string>& features) {
    Image stored = Image::of({{"simplex", simplex()}}, {.storage = Storage::Repeats});
    Image image = Image::of({{"simplex", simplex()}}, {}, headJson(features, {"simplex"}));
    image.chunk("CONN 0").payload = stored.chunk("CONN 0").payload;
    return image;
  };
  cases.add(
      "A13-repeats", "The file does not name the feature zstd, and an array has codec 2.",
      {repeated({"zstd"}), {"zstd", "index"}}, [&](Image& image) { image = repeated({}); },
      "CONN 0/cells/codec");
}

/// Faults of slabs of several blocks of cells, of which a reader may read as many as it needs.
void addFaultsOfManyCells(InvalidCases& cases) {
  const std::vector<BodySlabs> bodies = {{"simplices", {manySimplices()}}};
  const ImageOptions options = {.storage = Storage::Repeats};
  const Base two = baseOf(bodies, options);
  const auto with = [&](const std::string& name, const std::string& fault, const std::string& place,
                        const std::function<void(Slab&)>& change) {
    std::vector<BodySlabs> wrong = bodies;
    change(wrong[0].slabs[0]);
    cases.add(
        name, fault, two, [&](Image& image) { image = Image::of(wrong, options); }, place);
  };
  const auto setCell = [](Slab& slab, std::size_t number, const model::Cell& cell) {
    auto connectivity = std::make_shared<model::Connectivity>(*slab.connectivity);
    connectivity->cells[number] = cell;
    slab.connectivity = connectivity;
  };
  with("N5-in-the-second-block", "The last of 65,540 cells has a vertex twice.",
       "CONN 0/cells/stored 1", [&](Slab& slab) {
         model::Cell cell = slab.connectivity->cells.back();
         cell[1] = cell[0];
         setCell(slab, slab.connectivity->cells.size() - 1, cell);
       });
  with("P2-of-65540-vertices", "A coordinate of the last of 65,540 vertices is infinite.",
       "SLAB 0/interior positions/stored 1",
       [](Slab& slab) { slab.vertices.back().x() = kInfinity; });
  with("P4-of-65540-vertices", "The last of 65,540 vertices comes after the slab.",
       "SLAB 0/interior times/stored 1", [](Slab& slab) { slab.vertices.back()[3] = 1.5; });
  cases.add(
      "P1-of-65540-vertices", "The interior has one vertex less than the connectivity.", two,
      [&](Image& image) {
        const std::vector<model::Point4>& vertices = bodies[0].slabs[0].vertices;
        const Record record =
            slabRecord({0, 1}, 0, {}, std::span(vertices).first(vertices.size() - 1), {}, {},
                       Storage::Library);
        for (const char* array : {"interior positions", "interior times"}) {
          image.chunk("SLAB 0").payload.replace(array, record.part(array));
        }
      },
      "SLAB 0/interior positions/rows");
  cases.add(
      "I5-of-65540-cells", "The index says that a slab of 65,540 cells has 65,539.", two,
      [](Image& image) {
        image.freeze("INDX");
        image.chunk("INDX").payload.replace(
            "cells",
            arrayRecord(ScalarType::UInt64, 1, bytesOf(std::uint64_t{65539}), Storage::Raw));
      },
      "INDX/cells/stored");
  cases.refusedAt(0.5);
  cases.add(
      "C10-checksum-in-the-second-block", "The checksum of the second block of cells is wrong.",
      two, [](Image& image) { image.flip("CONN 0/cells/stored 1 checksum"); },
      "CONN 0/cells/stored 1 checksum");
  const Base layered = baseOf({{"crosses", manyCrosses()}}, options);
  const auto after = [&](const std::string& name, const std::string& chunk) {
    cases.add(
        name, "Eight bytes follow the last field, of a slab of 65,600 cells.", layered,
        [&](Image& image) { image.chunk(chunk).payload.putBytes("extra", std::string(8, '\0')); },
        chunk + "/extra");
  };
  after("N11-bytes-after-of-65600-cells", "CONN 1");
  after("L4-bytes-after-of-65600-cells", "LAYR 0");
  after("S9-bytes-after-of-65600-cells", "SLAB 1");
  for (const auto& [name, array] : {std::pair{"connectivity", "CONN 1/cells"},
                                    {"layer", "LAYR 0/positions"},
                                    {"slab", "SLAB 1/interior positions"}}) {
    const std::string place = std::string(array) + "/codec";
    cases.add(
        fmt::format("A3-in-the-{}-of-65600-cells", name),
        "An array has codec 255, of a slab of 65,600 cells.", layered,
        [&](Image& image) { image.set(place, std::uint8_t{255}); }, place);
  }
  cases.add(
      "P3-of-65600-cells", "The layer of a slab of 65,600 cells is at another time.", layered,
      [](Image& image) { image.set("LAYR 0/time", 0.25); }, "LAYR 0/time");
}

/// Faults of arrays whose numbers may be any, so that nothing else is wrong with them: attributes.
void addAttributeNumbers(InvalidCases& cases) {
  const auto withFrame = [](const std::string& distances, const std::string& others,
                            std::uint8_t codec) {
    Base base = baseOf({{"simplex", simplex()}}, {.storage = Storage::Library});
    Record& payload = base.image.chunk("SLAB 0").payload;
    Attribute attribute{"a", Domain::Cell, ScalarType::UInt32, 1, {}};
    attribute.values.resize(20);
    payload.add("attribute 0", attributeRecord(attribute, Storage::Library));
    payload.replace("attribute 0/values",
                    arrayRecord(5, 1, codec, 5, {zstdFrame(distances + transposed(others, 4))}));
    base.image.set("SLAB 0/attributes", 1U);
    return base;
  };
  const Base repeated = withFrame("\0\1\1\1\1"s, bytesOf(2U), 2);
  const Base whole = withFrame(std::string(20, '\2'), "", 1);
  const auto wrong = [&](const std::string& name, const std::string& fault, const Base& base,
                         const Base& with, const std::string& field) {
    cases.add(
        name, fault, base, [&](Image& image) { image = with.image; },
        "SLAB 0/attribute 0/values/" + field);
  };
  wrong("A14-first-of-an-attribute", "The first number of an attribute repeats the one before it.",
        repeated, withFrame("\1\0\1\1\1"s, bytesOf(2U), 2), "stored");
  wrong("A15-number-missing-of-an-attribute", "A number that is not repeated is missing.", repeated,
        withFrame("\0\1\1\1\0"s, bytesOf(2U), 2), "stored");
  wrong("A15-number-too-many-of-an-attribute", "There is one number more than distances of 0.",
        repeated, withFrame("\0\1\1\1\1"s, bytesOf(2U) + bytesOf(2U), 2), "stored");
  wrong("A3-codec-3-of-repeats", "An array of codec 2 has codec 3.", repeated,
        withFrame("\0\1\1\1\1"s, bytesOf(2U), 3), "codec");
  wrong("A3-codec-3-of-a-frame", "An array of codec 1 has codec 3.", whole,
        withFrame(std::string(20, '\2'), "", 3), "codec");

  Slab nothing;
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->cellAttributes = {{"a", Domain::Cell, ScalarType::UInt8, 1, {}}};
  nothing.connectivity = connectivity;
  nothing.timeEnd = 1;
  const Base empty = baseOf({{"nothing", {nothing}}});
  const auto set = [&](const std::string& name, const std::string& fault, const std::string& field,
                       std::uint8_t value) {
    const std::string place = "CONN 0/attribute 0/values/" + field;
    cases.add(
        name, fault, empty, [&](Image& image) { image.set(place, value); }, place);
  };
  set("A1-of-no-rows", "An array of no rows has the scalar type 11.", "scalar type", 11);
  set("A2-of-no-rows", "An array of no rows has no components.", "components", 0);
  cases.add(
      "K4-one-byte-after", "A byte follows the matrix.", withPoses(),
      [](Image& image) { image.chunk("POSE 0").payload.putBytes("extra", "\0"s); }, "POSE 0/extra");
}

/// Faults that a reader misses which looks only at what it reads, or only at checksums.
void addFaultsElsewhere(InvalidCases& cases) {
  cases.add(
      "S8-gap-over-layer-of-another-slab",
      "The slab above a layer begins later than the one below ends; a slice reads the one below.",
      layered(), [](Image& image) { image.set("SLAB 1/begin", 0.125); }, "SLAB 1/begin");
  cases.refusedAt(-0.5);

  const std::string name = "the name of a body whose copy has the same checksum";
  const std::string other = "tHe nAme of A boDY whosE cOpY has thE sAme CheCksum";
  cases.add(
      "I1-name-of-the-same-checksum",
      "The copy of HEAD has another name, but the checksum of HEAD.", baseOf({{name, simplex()}}),
      [&](Image& image) { image.setBytes("INDX/head/stored", headJson({}, {other})); },
      "INDX/head/stored");

  cases.add(
      "O2-second-head-no-index", "A second HEAD is in the middle of a file without index.",
      unindexed(),
      [](Image& image) {
        Image::Chunk head = image.chunk("HEAD");
        head.name = "HEAD again";
        image.add(head, "SLAB 0");
      },
      "HEAD again/header");

  Base posed = withPoses();
  Image::Chunk note = noteChunk(0);
  note.payload = Record();
  note.payload.putBytes("LAYR", posed.image.bytes().substr(posed.image.offset("LAYR 1/header"),
                                                           32 + posed.image.size("LAYR 1")));
  posed.image.add(note, "POSE 1");
  cases.add(
      "K2-within-an-optional-chunk",
      "layer is the distance to what is a LAYR, whole, within an optional chunk.", posed,
      [](Image& image) {
        image.set("POSE 1/layer", image.offset("POSE 1/header") - image.offset("note/LAYR"));
      },
      "POSE 1/layer");
}

}  // namespace

void addLimitFaults(InvalidCases& cases) {
  addHeadFaultsOfOne(cases);
  addCellFaults(cases);
  addBlockFaults(cases);
  addFarFaults(cases);
  addMeansFaults(cases);
  addTypeFaults(cases);
  addCopiedPose(cases);
  addNumbersBeyond(cases);
  addExpansion(cases);
  addFaultsElsewhere(cases);
  addAttributeNumbers(cases);
  addFaultsOfManyCells(cases);
}

}  // namespace t4d::conformance

#include <limits>

#include <fmt/format.h>

#include "conformance/corpus/invalid.h"
#include "conformance/corpus/shapes.h"
#include "conformance/corpus/zstd_frame.h"

/// Faults of array records and attributes.
namespace t4d::conformance {
namespace {

using namespace std::string_literals;
using model::Attribute;
using model::Domain;
using model::ScalarType;

std::vector<model::Slab> simplexWith(const std::vector<Attribute>& own,
                                     const std::vector<Attribute>& ofConnectivity = {}) {
  std::vector<model::Slab> slabs = simplex();
  auto connectivity = std::make_shared<model::Connectivity>(*slabs[0].connectivity);
  connectivity->cellAttributes = ofConnectivity;
  slabs[0].connectivity = connectivity;
  slabs[0].attributes = own;
  return slabs;
}

Attribute numbers(const std::string& name, Domain domain, std::size_t rows) {
  Attribute made{name, domain, ScalarType::UInt8, 1, {}};
  for (std::size_t i = 0; i < rows; ++i) made.values.push_back(std::byte(i));
  return made;
}

/// A simplex with the cell attribute "a" of five bytes.
Base withAttribute() { return baseOf({{"simplex", simplexWith({numbers("a", Domain::Cell, 5)})}}); }

/// A simplex with the attribute.
Base withAttribute(const Attribute& attribute) {
  return baseOf({{"simplex", simplexWith({attribute})}});
}

/// A simplex whose HEAD names zstd and that stores the indices of its cells as `frame`.
struct Compressed {
  std::string content;    ///< the indices, transposed: 80 bytes
  std::string asRepeats;  ///< of codec 2: 20 distances, and 5 numbers

  Compressed() {
    std::string bytes;
    const std::vector<model::Slab> slabs = simplex();
    for (const model::Cell& cell : slabs[0].connectivity->cells) {
      for (const std::uint32_t index : cell) bytes += bytesOf(index);
    }
    content = transposed(bytes, 16);
    asRepeats = repeats(bytes, 4);
  }

  static Base withFrame(const std::string& frame, std::uint8_t codec = 1) {
    Base base{Image::of({{"simplex", simplex()}}, {}, headJson({"zstd"}, {"simplex"})),
              {"zstd", "index"}};
    base.image.chunk("CONN 0").payload.replace("cells", arrayRecord(5, 4, codec, 5, {frame}));
    return base;
  }
  Base right() const { return withFrame(zstdFrame(content)); }
};

void addFrameFaults(InvalidCases& cases) {
  const Compressed compressed;
  const std::string& content = compressed.content;
  const Base right = compressed.right();
  const std::string frame = zstdFrame(content);
  const auto add = [&](const std::string& name, const std::string& fault, const std::string& wrong,
                       std::size_t at = 0) {
    cases.add(
        name, fault, right, [&](Image& image) { image = Compressed::withFrame(wrong).image; },
        "CONN 0/cells/stored", at);
  };
  const std::string half = content.substr(0, 40);
  add("A10-two-frames", "The array is in two frames, one half each.",
      zstdFrame(half) + zstdFrame(content.substr(40)), zstdFrame(half).size());
  add("A10-empty-frame-after", "A frame of no bytes follows the frame.", frame + zstdFrame(""),
      frame.size());
  add("A10-skippable-frame-before", "A skippable frame stands before the frame.",
      zstdSkippableFrame("skip me") + frame);
  add("A10-skippable-frame-after", "A skippable frame follows the frame.",
      frame + zstdSkippableFrame("skip me"), frame.size());
  add("A10-byte-after", "A zero byte follows the frame.", frame + "\0"s, frame.size());
  add("A10-byte-before", "A zero byte stands before the frame.", "\0"s + frame);
  add("A10-cut-off", "The frame lacks its last byte.", frame.substr(0, frame.size() - 1),
      frame.size() - 1);
  std::string unfinished = frame;
  unfinished[6] = static_cast<char>(unfinished[6] & ~1);
  add("A10-no-last-block", "No block of the frame is marked as the last.", unfinished, 6);
  add("A10-raw", "The array itself stands where a frame should.", content);
  // A raw block of the 80 bytes, then the end.
  add("A10-frame-of-zstd-0.7", "The frame is of a version of zstd from before the standard.",
      "\x27\xB5\x2F\xFD\x20\x50\x40\x00\x50"s + content + "\xC0\0\0"s);
  add("A10-zlib", "The stored bytes are compressed with zlib.",
      "\x78\x9C\x63\x60\x60\x60\x60\x64\x60\x00\x00\x00\x05\x00\x02"s);
  add("A10-dictionary", "The frame names a dictionary.", zstdFrame(content, {.dictionaryId = 1}),
      5);

  add("A11-no-size", "The frame does not declare its size.",
      zstdFrame(content, {.declareSize = false, .windowLog = 10}), 4);
  add("A11-size-too-small", "The frame declares 79 bytes and holds 80.",
      zstdFrame(content, {.declaredSize = 79}), 5);
  add("A11-size-too-large", "The frame declares 81 bytes and holds 80.",
      zstdFrame(content, {.declaredSize = 81}), 5);
  add("A11-size-2-to-the-63", "The frame declares 2^63 bytes.",
      zstdFrame(content, {.declaredSize = std::uint64_t{1} << 63}), 5);
  add("A11-fewer-rows", "The frame declares and holds 64 bytes, of an array of 80.",
      zstdFrame(content.substr(16)), 5);
  add("A11-more-rows", "The frame declares and holds 96 bytes, of an array of 80.",
      zstdFrame(content + content.substr(0, 16)), 5);

  add("A12-too-few-bytes", "The frame declares 80 bytes and holds 79.",
      zstdFrame(content.substr(1), {.declaredSize = 80}), 6);
  add("A12-too-many-bytes", "The frame declares 80 bytes and holds 81.",
      zstdFrame(content + "\0"s, {.declaredSize = 80}), 6);
  std::string block = frame;
  block[6] = static_cast<char>(block[6] | 6);
  add("A12-reserved-block-type", "The frame has a block of the reserved type.", block, 6);
  std::string literals = frame;
  literals[6] = static_cast<char>(literals[6] | 4);
  literals[9] = 3;
  add("A12-no-table", "A compressed block repeats a Huffman table where there was none.", literals,
      9);
  std::string reserved = frame;
  reserved[4] = static_cast<char>(reserved[4] | 8);
  add("A12-reserved-bit", "The reserved bit of the frame's header is set.", reserved, 4);
  std::string summed = zstdByLibrary(content, true);
  const std::size_t sum = summed.size() - 4;
  summed[sum] = static_cast<char>(summed[sum] ^ 1);
  add("A12-checksum", "The frame's own checksum is wrong.", summed, sum);

  const std::string& numbers = compressed.asRepeats;
  const auto repeated = [&](const std::string& name, const std::string& fault,
                            const std::string& wrong) {
    cases.add(
        name, fault, Compressed::withFrame(zstdFrame(numbers), 2),
        [&](Image& image) { image = Compressed::withFrame(zstdFrame(wrong), 2).image; },
        "CONN 0/cells/stored");
  };
  const auto changed = [&](std::size_t at, char to) {
    std::string other = numbers;
    other[at] = to;
    return other;
  };
  repeated("A11-distance-missing", "The content has 19 bytes for 20 distances.",
           numbers.substr(0, 19));
  repeated("A11-part-of-a-number", "The content has 2 bytes behind the last number.",
           numbers + "\0\0"s);
  repeated("A11-larger-than-the-array", "The content has 25 numbers for 20 distances.",
           numbers + std::string(80, '\0'));
  // Column after column: scalar 0 is byte 0, scalar 1 byte 5, scalar 4 byte 1.
  // What is not repeated is as many numbers as before, less one.
  const auto oneLess = [&](std::size_t at, char to) {
    return changed(at, to).substr(0, 20) + transposed(std::string(16, '\2'), 4);
  };
  repeated("A14-first-scalar", "The first scalar repeats the one before it.", oneLess(0, 1));
  repeated("A14-second-scalar", "The second scalar repeats the one two places before it.",
           oneLess(5, 2));
  repeated("A14-255", "A scalar of the second row repeats the one 255 places before it.",
           changed(1, '\xFF'));
  repeated("A15-number-missing", "A number that is not repeated is missing.",
           numbers.substr(0, 20) + transposed(std::string(16, '\2'), 4));
  repeated("A15-number-too-many", "There is one number more than distances of 0.",
           numbers.substr(0, 20) + transposed(std::string(24, '\0'), 4));
  repeated("A15-no-numbers", "There are no numbers.", numbers.substr(0, 20));

  // One array is compressed, but the feature is not named.
  const auto with = [](const std::string& chunk, const std::vector<std::string>& features) {
    const std::vector<BodySlabs> cross = {{"cross", crossPolytope()}};
    Image stored = Image::of(cross, {.storage = Storage::Blocks});
    Image image = Image::of(cross, {}, headJson(features, {"cross"}));
    image.chunk(chunk).payload = stored.chunk(chunk).payload;
    return image;
  };
  for (const auto& [name, chunk, array] :
       {std::array<std::string, 3>{"connectivity", "CONN 1", "cells"},
        {"layer", "LAYR 0", "positions"},
        {"slab", "SLAB 1", "interior times"}}) {
    cases.add(
        "A13-" + name, "The file does not name the feature zstd, which it uses.",
        {with(chunk, {"zstd"}), {"zstd", "index"}},
        [&, chunk = chunk](Image& image) { image = with(chunk, {}); },
        chunk + "/" + array + "/codec");
  }
}

}  // namespace

void addArrayFaults(InvalidCases& cases) {
  const Base attribute = withAttribute();
  const Base base = plain();
  const std::string values = "SLAB 0/attribute 0/values/";
  const std::string cells = "CONN 0/cells/";
  const auto set = [&](const std::string& name, const std::string& fault, const Base& of,
                       const std::string& place, auto value) {
    cases.add(
        name, fault, of, [&](Image& image) { image.set(place, value); }, place);
  };
  for (const int type : {0, 11, 255}) {
    set(fmt::format("A1-scalar-type-{}", type), fmt::format("The scalar type is {}.", type),
        attribute, values + "scalar type", static_cast<std::uint8_t>(type));
  }
  set("A1-scalar-type-of-cells", "The scalar type of the cells is 12.", base, cells + "scalar type",
      std::uint8_t{12});
  cases.add(
      "A2-no-components", "Rows have no numbers, and nothing is stored.", attribute,
      [](Image& image) {
        image.chunk("SLAB 0").payload.replace("attribute 0/values", arrayRecord(1, 0, 0, 5, {""}));
      },
      values + "components");
  set("A2-no-components-of-cells", "The cells have no indices.", base, cells + "components"s,
      std::uint8_t{0});
  for (const int codec : {3, 255}) {
    set(fmt::format("A3-codec-{}", codec), fmt::format("The codec is {}.", codec), attribute,
        values + "codec", static_cast<std::uint8_t>(codec));
  }
  for (const int byte : {0, 4}) {
    cases.add(
        fmt::format("A4-reserved-byte-{}", byte), "A reserved byte is not zero.", base,
        [&](Image& image) { image.setBytes(cells + "reserved", "\x01", byte); }, cells + "reserved",
        byte);
  }

  const auto rows = [&](const std::string& name, const std::string& fault, std::uint64_t count) {
    set(name, fault, base, cells + "rows", count);
  };
  rows("A5-65537-rows", "An array of 65,537 rows has one block.", 65537);
  rows("A5-2-to-the-32-rows-more", "An array of 5 rows says that it has 2^32 + 5.",
       (std::uint64_t{1} << 32) + 5);
  rows("A5-size-wraps", "2^60 + 5 rows of 16 bytes are 80 bytes modulo 2^64.",
       (std::uint64_t{1} << 60) + 5);
  rows("A5-rows-2-to-the-63", "The array has 2^63 rows.", std::uint64_t{1} << 63);
  rows("A5-rows-2-to-the-64-less-1", "The array has 2^64 - 1 rows.", kLargest);
  cases.add(
      "A5-no-block", "An array of 5 rows has no block.", base,
      [](Image& image) { image.chunk("CONN 0").payload.dropBlocks(); }, cells + "rows");
  cases.add(
      "A5-block-of-the-array-before", "The last of two arrays has no block.", base,
      [](Image& image) {
        image.chunk("SLAB 0").payload.replace("interior times", arrayRecord(10, 1, 0, 5, {}));
      },
      "SLAB 0/interior times/rows");
  rows("A7-a-row-too-few", "A block of 80 bytes has 4 rows of 16.", 4);
  rows("A7-a-row-too-many", "A block of 80 bytes has 6 rows of 16.", 6);
  cases.add(
      "A7-a-byte-too-many", "A block of 5 rows of 16 bytes has 81.", base,
      [](Image& image) {
        Record& payload = image.chunk("CONN 0").payload;
        payload.replace("cells",
                        arrayRecord(5, 4, 0, 5, {payload.contents("cells/stored") + '\0'}));
      },
      cells + "rows");

  cases.add(
      "A7-a-byte-too-many-of-attribute", "A block of 5 rows of one byte has 6.", attribute,
      [](Image& image) {
        image.chunk("SLAB 0").payload.replace("attribute 0/values",
                                              arrayRecord(1, 1, 0, 5, {std::string(6, '\0')}));
      },
      values + "rows");
  const auto compressed = [](std::size_t bytes) {
    Image image = Image::of({{"simplex", simplexWith({numbers("a", Domain::Cell, 5)})}}, {},
                            headJson({"zstd"}, {"simplex"}));
    image.chunk("SLAB 0").payload.replace(
        "attribute 0/values", arrayRecord(1, 1, 1, 5, {zstdFrame(std::string(bytes, '\7'))}));
    return image;
  };
  cases.add(
      "A11-more-rows-of-attribute", "The frame declares and holds 6 bytes, of an array of 5.",
      {compressed(5), {"zstd", "index"}}, [&](Image& image) { image = compressed(6); },
      values + "rows");

  const Base step = [] {
    const Solid solid = cornerTetrahedron();
    return baseOf(
        {{"tetrahedron", sweep(solid, {pose(solid, 0, {0, 0, 0}), pose(solid, 1, {0, 0, 0})},
                               {.capSlabs = false})}},
        {.storage = Storage::Blocks});
  }();
  for (const int codec : {1, 2}) {
    cases.add(
        fmt::format("A6-codec-{}", codec), fmt::format("An array of no rows has codec {}.", codec),
        step,
        [&](Image& image) {
          image.set("SLAB 0/interior positions/codec", static_cast<std::uint8_t>(codec));
        },
        "SLAB 0/interior positions/codec");
  }
  const Base integers = [] {
    Base made =
        withAttribute(model::makeAttribute<std::uint32_t>("a", Domain::Cell, {7, 7, 7, 7, 7}));
    made.image = Image::of(
        {{"simplex",
          simplexWith({model::makeAttribute<std::uint32_t>("a", Domain::Cell, {7, 7, 7, 7, 7})})}},
        {.storage = Storage::Repeats});
    return made;
  }();
  for (const int type : {6, 9}) {
    set(fmt::format("A8-type-{}", type),
        fmt::format("An array of scalar type {} has codec 2.", type), integers,
        values + "scalar type", static_cast<std::uint8_t>(type));
  }

  // 128 numbers for each of 64 vertices: 65,536 bytes.
  std::vector<model::Slab> room = simplex();
  auto connectivity = std::make_shared<model::Connectivity>(*room[0].connectivity);
  connectivity->vertexCount = 64;
  room[0].connectivity = connectivity;
  room[0].vertices.resize(64, model::Point4(0, 0, 0, 0));
  Attribute zeros{"zeros", Domain::Vertex, ScalarType::Float64, 128, {}};
  zeros.values.resize(64 * zeros.rowBytes());
  room[0].attributes = {zeros};
  const std::string content(zeros.values.size(), '\0');
  const auto expanding = [&](std::size_t blockBytes) {
    Image image = Image::of({{"simplex", room}}, {}, headJson({"zstd"}, {"simplex"}));
    image.chunk("SLAB 0").payload.replace(
        "attribute 0/values",
        arrayRecord(10, 128, 1, 64, {zstdFrame(content, {.blockBytes = blockBytes})}));
    return image;
  };
  const Base roomy = {expanding(4096), {"zstd", "index"}};
  cases.add(
      "A9-63-bytes-for-65536", "An array expands by more than 1,024 times.", roomy,
      [&](Image& image) { image = expanding(4682); }, values + "rows");
  cases.add(
      "A9-largest-blocks", "An array expands by as much as zstd can.", roomy,
      [&](Image& image) { image = expanding(128U << 10); }, values + "rows");
  cases.add(
      "A9-no-bytes", "Five rows of codec 1 are stored in no bytes.", Compressed().right(),
      [](Image& image) { image = Compressed::withFrame("").image; }, cells + "rows");
  addFrameFaults(cases);
}

void addAttributeFaults(InvalidCases& cases) {
  const Base base = withAttribute();
  const std::string attribute = "SLAB 0/attribute 0/";
  for (const int domain : {0, 3, 255}) {
    cases.add(
        fmt::format("T1-domain-{}", domain), fmt::format("The domain is {}.", domain), base,
        [&](Image& image) { image.set(attribute + "domain", static_cast<std::uint8_t>(domain)); },
        attribute + "domain");
  }
  for (const int byte : {0, 2}) {
    cases.add(
        fmt::format("T2-reserved-byte-{}", byte), "A reserved byte is not zero.", base,
        [&](Image& image) { image.setBytes(attribute + "reserved", "\x01", byte); },
        attribute + "reserved", byte);
  }
  const auto named = [&](const std::string& name, const std::string& fault,
                         const std::string& wrong) {
    cases.add(
        name, fault, base,
        [&](Image& image) { image = withAttribute(numbers(wrong, Domain::Cell, 5)).image; },
        attribute + "name");
  };
  named("T3-no-name", "The name has no bytes.", "");
  named("T3-name-of-256-bytes", "The name has 256 bytes.", std::string(256, 'n'));
  cases.add(
      "T3-name-outside", "The name ends behind the payload.", base,
      [&](Image& image) { image.set(attribute + "name length", 200U); }, attribute + "name length");
  cases.add(
      "T3-name-length-2-to-the-32-less-1", "The name has 2^32 - 1 bytes.", base,
      [&](Image& image) { image.set(attribute + "name length", ~0U); }, attribute + "name length");
  for (const auto& [name, bytes] : {std::pair<const char*, std::string>{"nul", "a\0b"s},
                                    {"slash", "a/b"},
                                    {"delete", "a\x7F"},
                                    {"next-line", "\xC2\x85"},
                                    {"right-to-left",
                                     "\xE2\x80\xAE"
                                     "b"}}) {
    const auto with = [&, bytes = bytes](const std::string& text) {
      return withAttribute(numbers(text, Domain::Cell, 5));
    };
    cases.add(
        fmt::format("T4-{}", name), "The name has a character that is not allowed.",
        with(std::string(bytes.size(), 'n')),
        [&, bytes = bytes](Image& image) { image.setBytes(attribute + "name", bytes); },
        attribute + "name");
  }
  for (const auto& [name, what, bytes] : notUtf8()) {
    named(fmt::format("T4-{}", name), fmt::format("The name has {}.", what), "a" + bytes);
  }
  for (const int byte : {0, 6}) {
    cases.add(
        fmt::format("T5-padding-byte-{}", byte), "A byte of padding is not zero.", base,
        [&](Image& image) { image.setBytes(attribute + "name padding", "\x01", byte); },
        attribute + "name padding", byte);
  }

  const auto rows = [&](const std::string& name, const std::string& fault, Domain domain,
                        std::size_t count) {
    cases.add(
        name, fault, withAttribute(numbers("a", domain, 5)),
        [&](Image& image) { image = withAttribute(numbers("a", domain, count)).image; },
        attribute + "values/rows");
  };
  rows("T6-a-cell-too-few", "A cell attribute has 4 rows for 5 cells.", Domain::Cell, 4);
  rows("T6-a-cell-too-many", "A cell attribute has 6 rows for 5 cells.", Domain::Cell, 6);
  const auto vertexRows = [&](const std::string& name, const std::string& fault, const Base& of,
                              const std::string& chunk, std::size_t count) {
    cases.add(
        name, fault, of,
        [&](Image& image) {
          image.chunk(chunk).payload.replace(
              "attribute 0/values",
              arrayRecord(ScalarType::UInt8, 1, std::string(count, '\0'), Storage::Raw));
        },
        chunk + "/attribute 0/values/rows");
  };
  const Base ofVertices = withAttribute(numbers("a", Domain::Vertex, 5));
  vertexRows("T6-a-vertex-too-few", "A vertex attribute has 4 rows for 5 vertices.", ofVertices,
             "SLAB 0", 4);
  vertexRows("T6-no-rows", "A vertex attribute has no rows.", ofVertices, "SLAB 0", 0);
  std::vector<model::Slab> means = {meansSlab()};
  means[0].attributes = {numbers("a", Domain::Vertex, 9)};
  vertexRows("T6-means-stored", "A vertex attribute has rows for the means.",
             baseOf({{"simplex", means}}), "SLAB 0", 9);
  vertexRows("T6-layers-stored", "A vertex attribute of a SLAB has rows for its layer.",
             withLayerAttributes(), "SLAB 0", 7);
  vertexRows("T6-of-layer-too-few", "An attribute of a LAYR has 5 rows for 6 vertices.",
             withLayerAttributes(), "LAYR 0", 5);
  vertexRows("T6-of-layer-too-many", "An attribute of a LAYR has 7 rows for 6 vertices.",
             withLayerAttributes(), "LAYR 0", 7);
  const auto ofConnectivity = [](std::size_t count) {
    return baseOf({{"simplex", simplexWith({}, {numbers("a", Domain::Cell, count)})}});
  };
  cases.add(
      "T6-of-connectivity", "An attribute of a CONN has 4 rows for 5 cells.", ofConnectivity(5),
      [&](Image& image) { image = ofConnectivity(4).image; }, "CONN 0/attribute 0/values/rows");

  const Attribute a = numbers("a", Domain::Cell, 5);
  const Attribute b = numbers("b", Domain::Cell, 5);
  const auto both = [](const std::vector<Attribute>& own, const std::vector<Attribute>& shared) {
    return baseOf({{"simplex", simplexWith(own, shared)}});
  };
  cases.add(
      "T7-twice-in-slab", "A SLAB has two cell attributes of one name.", both({a, b}, {}),
      [&](Image& image) {
        image = both({a, a}, {}).image;
      },
      "SLAB 0/attribute 1/name");
  cases.add(
      "T7-twice-in-connectivity", "A CONN has two attributes of one name.", both({}, {a, b}),
      [&](Image& image) {
        image = both({}, {a, a}).image;
      },
      "CONN 0/attribute 1/name");
  cases.add(
      "T7-in-connectivity-and-slab", "CONN and SLAB have a cell attribute of one name.",
      both({b}, {a}), [&](Image& image) { image = both({a}, {a}).image; },
      "SLAB 0/attribute 0/name");
  const auto vertices = [](const std::string& second) {
    return baseOf({{"simplex", simplexWith({numbers("a", Domain::Vertex, 5),
                                            numbers(second, Domain::Vertex, 5)})}});
  };
  cases.add(
      "T7-vertex-attributes", "A SLAB has two vertex attributes of one name.", vertices("b"),
      [&](Image& image) { image = vertices("a").image; }, "SLAB 0/attribute 1/name");
  cases.add(
      "T7-in-layer", "A LAYR has two attributes of one name.", withLayerAttributes(),
      [&](Image& image) { image.set("LAYR 0/attribute 1/name", 'a'); }, "LAYR 0/attribute 1/name");
}

}  // namespace t4d::conformance

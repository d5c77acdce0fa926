#include <cmath>

#include <fmt/format.h>

#include "conformance/corpus/cases.h"
#include "conformance/corpus/far_back.h"
#include "conformance/corpus/shapes.h"

namespace t4d::conformance {
namespace {

using model::Attribute;
using model::Domain;
using model::ScalarType;
using model::Slab;

/// The simplex in one slab with these attributes.
std::vector<Slab> simplexOfAttributes(const std::vector<Attribute>& attributes) {
  std::vector<Slab> slabs = simplex();
  slabs[0].attributes = attributes;
  return slabs;
}

void addFarParts(AcceptedCases& cases) {
  struct Far {
    FarPart part;
    const char* name;
    const char* what;
  };
  for (const Far& far :
       {Far{FarPart::Connectivity, "connectivity",
            "connectivity of the last slab is the last CONN but 31"},
        Far{FarPart::Layer, "layer", "upper of the first slab is the last LAYR but 31"},
        Far{FarPart::Pose, "pose", "upper of the first slab is the last POSE but 31"},
        Far{FarPart::LayerOfPose, "layer-of-a-pose", "a POSE moves the last LAYR but 31"}}) {
    const FarFile made = partFarBack(far.part, 2, 32);
    cases
        .add(fmt::format("{}-as-far-back-as-can-be", far.name),
             fmt::format("Of two bodies; {}.", far.what))
        .of(made.image, made.bodies)
        .naming(far.part == FarPart::Pose || far.part == FarPart::LayerOfPose
                    ? std::vector<std::string>{"pose"}
                    : std::vector<std::string>{})
        .slicedAt({0.5, 32})
        .encloses(static_cast<double>(made.bodies[0].slabs.size() + 1) / 24);
  }
}

void addNames(AcceptedCases& cases) {
  // U+0020 U+002E U+0030 U+007E U+00A0 U+061B U+061D U+200D U+2010 U+2029 U+202F U+2065 U+206A,
  // each beside characters that names cannot have.
  const std::vector<std::string> characters = {" ",
                                               ".",
                                               "0",
                                               "~",
                                               "\xC2\xA0",
                                               "\xD8\x9B",
                                               "\xD8\x9D",
                                               "\xE2\x80\x8D",
                                               "\xE2\x80\x90",
                                               "\xE2\x80\xA9",
                                               "\xE2\x80\xAF",
                                               "\xE2\x81\xA5",
                                               "\xE2\x81\xAA"};
  std::vector<Attribute> attributes;
  std::string all;
  for (const std::string& character : characters) {
    all += character;
    attributes.push_back(
        model::makeAttribute<std::uint8_t>("a" + character, Domain::Cell, {1, 2, 3, 4, 5}));
  }
  cases
      .add("names-beside-forbidden-ones",
           "Names with characters whose numbers are beside those of characters that names cannot "
           "have.")
      .of({{all, simplexOfAttributes(attributes)}}, {}, headJson({}, {all}))
      .shows({"json", "unicode"})
      .slicedAt({0.5})
      .encloses(1.0 / 24);
}

void addMeansOfRows(AcceptedCases& cases) {
  const Solid solid = cornerTetrahedron();
  std::vector<Slab> slabs = sweep(solid, {pose(solid, 0, {0, 0, 0}), pose(solid, 1, {0, 0, 1})},
                                  {.prism = Prism::Fourteen, .capSlabs = false});
  Slab& slab = slabs[0];
  const std::size_t vertices = slab.vertices.size();
  for (const ScalarType type : {ScalarType::Float32, ScalarType::Float64}) {
    for (const unsigned components : {2U, 3U, 7U}) {
      std::vector<float> singles;
      std::vector<double> doubles;
      for (std::size_t i = 0; i < vertices * components; ++i) {
        const double value = 0.1 * static_cast<double>(i * i % 97) - 3;
        singles.push_back(static_cast<float>(value));
        doubles.push_back(value);
      }
      const bool single = type == ScalarType::Float32;
      const std::string name = fmt::format("{} of binary{}", components, single ? 32 : 64);
      Attribute made = single ? model::makeAttribute(name, Domain::Vertex, singles)
                              : model::makeAttribute(name, Domain::Vertex, doubles);
      made.components = components;
      setMeans(*slab.connectivity, made);
      slab.attributes.push_back(std::move(made));
    }
  }
  cases
      .add("attributes-of-means-with-components",
           "Means inherit rows of 2, 3 and 7 floating-point numbers, each a mean of its own.")
      .of({{"tetrahedron", slabs}})
      .slicedAt({0.5})
      .encloses(1.0 / 6);
}

void addLayersOfOneVertex(AcceptedCases& cases) {
  FarFile chain = partFarBack(FarPart::Layer, 1, 3);
  cases
      .add("layers-of-one-vertex",
           "A slab has one vertex in its lower layer, and one in its upper.")
      .of({{"chain", chain.bodies[0].slabs}})
      .slicedAt({0, 0.5, 1, 1.5, 3})
      .encloses(3.0 / 24);
  std::vector<Slab>& slabs = chain.bodies[0].slabs;
  for (std::uint8_t k = 0; k < slabs.size(); ++k) {
    // The last row of a slab is the first of the next.
    std::vector<std::uint8_t> rows;
    for (std::size_t i = 0; i < slabs[k].vertices.size(); ++i) {
      rows.push_back(static_cast<std::uint8_t>(5 * k + i - (k > 0 ? 1 : 0)));
    }
    slabs[k].attributes = {model::makeAttribute("a", Domain::Vertex, rows)};
  }
  cases.add("attributes-of-layers-of-one-vertex", "A layer has one row of an attribute.")
      .of({{"chain", slabs}}, {.storage = Storage::Library})
      .slicedAt({0.5, 1})
      .encloses(3.0 / 24);
}

void addTypes(AcceptedCases& cases) {
  Image image = Image::of({{"simplex", simplex()}});
  for (const char* type :
       {"notE", "not1", "nOTE", "n0te", "a000", "z9Z9", "A000", "ZZZ9", "NOT0", "AZ9Z"}) {
    Image::Chunk chunk;
    chunk.name = chunk.type = type;
    chunk.flags = 0;
    chunk.payload.putBytes("text", "text");
    image.add(chunk, "SLAB 0");
  }
  cases
      .add("types-of-optional-chunks",
           "Types with capitals, small letters and digits wherever they may be.")
      .of(image, {{"simplex", simplex()}})
      .shows({"optional-chunk"})
      .slicedAt({0.5})
      .encloses(1.0 / 24);
}

void addNumbersOfRepeats(AcceptedCases& cases) {
  // Steps that differ in each byte, up and down, also beyond 2^31, where they wrap.
  const std::vector<std::uint32_t> numbers = {0x12345678, 0x00ABCDEF, 0xFEDCBA98, 0x00010000,
                                              0x80000000, 0x7FFFFFFF, 0xFFFFFFFF, 0,
                                              0x01000000, 0x00FFFFFF};
  Attribute made{"a", Domain::Cell, ScalarType::UInt32, 2, {}};
  for (const std::uint32_t number : numbers) {
    for (const char byte : bytesOf(number)) made.values.push_back(std::byte(byte));
  }
  cases.add("zstd-repeats-of-large-numbers", "Numbers of codec 2 that take four bytes.")
      .of({{"simplex", simplexOfAttributes({made})}}, {.storage = Storage::Repeats})
      .slicedAt({0.5})
      .encloses(1.0 / 24);
}

void addManyPrisms(AcceptedCases& cases) {
  const std::vector<Slab> slabs = manyPrisms();
  cases
      .add("blocks-with-layers-and-means",
           "65,545 cells of a slab with two layers, an interior and means: the last 9, in a block "
           "of their "
           "own, need the sources of their means, which lie beyond their bounds.")
      .of({{"prisms", slabs}}, {.storage = Storage::Repeats})
      .shows({"large"})
      .slicedAt({0.5})
      .encloses(195 + 5.0 / 24, [](double t) { return 195 + 5 * (1 - t) * (1 - t) * (1 - t) / 6; });
}

/// Solids side by side in one slab from -1 to 1: simplices of five cells, then cross-polytopes
/// of 16.
Slab manySolids(std::uint32_t simplices, std::uint32_t crosses) {
  auto connectivity = std::make_shared<model::Connectivity>();
  Slab slab;
  slab.timeBegin = -1;
  slab.timeEnd = 1;
  const auto addCells = [&](const Slab& of, std::size_t first) {
    for (model::Cell cell : of.connectivity->cells) {
      for (std::uint32_t& vertex : cell) vertex += static_cast<std::uint32_t>(first);
      connectivity->cells.push_back(cell);
    }
  };
  const Slab one = simplex()[0];
  for (std::uint32_t i = 0; i < simplices; ++i) {
    addCells(one, slab.vertices.size());
    slab.vertices.insert(slab.vertices.end(), one.vertices.begin(), one.vertices.end());
  }
  const std::vector<Slab> halves = crossPolytope();
  for (std::uint32_t i = 0; i < crosses; ++i) {
    addCells(halves[0], slab.vertices.size());
    addCells(halves[1], slab.vertices.size() + 1);
    slab.vertices.insert(slab.vertices.end(), halves[0].vertices.begin(), halves[0].vertices.end());
    slab.vertices.push_back(halves[1].vertices.back());
  }
  connectivity->vertexCount = static_cast<std::uint32_t>(slab.vertices.size());
  slab.connectivity = connectivity;
  return slab;
}

/// Cells that fill a block to the last row, and one more.
void addFullBlocks(AcceptedCases& cases) {
  const auto add = [&](const std::string& name, const std::string& what, std::uint32_t simplices,
                       std::uint32_t crosses) {
    cases.add(name, what)
        .of({{"crosses", {manySolids(simplices, crosses)}}}, {.storage = Storage::Repeats})
        .shows({"large"})
        .slicedAt({0.5})
        .encloses(simplices / 24.0 + crosses * 2.0 / 3, [=](double t) {
          const double left = 1 - std::abs(t);
          return (simplices / 6.0 + crosses * 4.0 / 3) * left * left * left;
        });
  };
  add("block-of-65536-cells", "65,536 cells are one block, which has no range and no bounds.", 0,
      4096);
  add("block-and-one-cell", "65,537 cells are two blocks, the second of one cell.", 13101, 2);
}

void addManyCrosses(AcceptedCases& cases) {
  cases.add("blocks-with-layers", "Two slabs of 65,600 cells share a layer, and have no means.")
      .of({{"crosses", manyCrosses()}}, {.storage = Storage::Repeats})
      .shows({"large"})
      .slicedAt({-0.5, 0, 0.5})
      .encloses(8200 * 2.0 / 3,
                [](double t) { return 8200 * 4.0 / 3 * std::pow(1 - std::abs(t), 3); });
}

/// A simplex that is cut by hyperplanes whose normals, shorter than 1 and longer, point either way.
void addNormals(AcceptedCases& cases) {
  std::vector<slice::Hyperplane> hyperplanes;
  const std::vector<Slab> slabs = simplex(2, {-0.5, -0.5, -0.5, -0.5});
  for (const Eigen::Vector4d& normal :
       {Eigen::Vector4d(1, 0.5, -0.75, 0.25), Eigen::Vector4d(-0.25, 1, 0.5, 0.75),
        Eigen::Vector4d(0.5, -0.25, 0.75, 1), Eigen::Vector4d(0.75, -0.5, 1, -0.25)}) {
    for (const double length : {0.25, -0.25, 1.0 / 1024, -1.0 / 1024, 1024.0, -1024.0}) {
      hyperplanes.push_back({length * normal, 0.125 * length});
    }
  }
  cases.add("normals-of-any-length", "Slices by normals that are shorter than 1, and longer.")
      .of({{"simplex", slabs}})
      .slicedAt({0.5})
      .slicedBy(hyperplanes)
      .encloses(16.0 / 24, [](double t) { return std::pow(1.5 - t, 3) / 6; });
}

void addParents(AcceptedCases& cases) {
  std::vector<BodySlabs> bodies;
  for (const char* name : {"a", "b", "c", "d"}) bodies.push_back({name, simplex()});
  cases.add("head-parents-of-parents", "Bodies that are parts of parts, in any order.")
      .of(bodies, {},
          R"({"features":[],"bodies":[{"name":"a","parent":"c"},{"name":"b"},{"name":"c","parent":"d"},)"
          R"({"name":"d","parent":"b"}]})")
      .shows({"json"})
      .slicedAt({0.5})
      .encloses(4.0 / 24);
}

void addLargestHead(AcceptedCases& cases) {
  constexpr std::size_t kMost = std::size_t{16} << 20;
  const std::string head = headJson({}, {"simplex"});
  cases.add("head-of-16-MiB", "HEAD is as long as can be: white space. No index has it again.")
      .of({{"simplex", simplex()}}, {.index = false}, head + std::string(kMost - head.size(), ' '))
      .shows({"json", "large"})
      .slicedAt({0.5})
      .encloses(1.0 / 24);
}

}  // namespace

void addLimits(AcceptedCases& cases) {
  addFarParts(cases);
  addNames(cases);
  addMeansOfRows(cases);
  addLayersOfOneVertex(cases);
  addTypes(cases);
  addNumbersOfRepeats(cases);
  addManyPrisms(cases);
  addFullBlocks(cases);
  addManyCrosses(cases);
  addNormals(cases);
  addParents(cases);
  addLargestHead(cases);
}

}  // namespace t4d::conformance

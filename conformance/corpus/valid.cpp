#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "conformance/corpus/cases.h"
#include "conformance/corpus/shapes.h"
#include "conformance/corpus/zstd_frame.h"
#include "formats/t4d/chunk_counts.h"
#include "formats/t4d/chunk_list.h"
#include "formats/t4d/pages.h"

namespace t4d::conformance {
namespace {

using model::Attribute;
using model::Domain;
using model::Point3;
using model::Point4;
using model::ScalarType;
using model::Slab;

using namespace std::string_literals;

double cubed(double x) { return x * x * x; }

/// Slice volume of the unit simplex at the origin: a tetrahedron that shrinks.
double simplexSlice(double time) { return time < 0 || time > 1 ? 0 : cubed(1 - time) / 6; }

AcceptedBuilder& simplexFile(AcceptedCases& cases, const std::string& name, const std::string& what,
                             const ImageOptions& options = {},
                             const std::optional<std::string>& head = {}) {
  return cases.add(name, what)
      .of({{"simplex", simplex()}}, options, head)
      .slicedAt({0.5})
      .encloses(1.0 / 24, simplexSlice);
}

/// Steps of one time unit, each of which moves the solid by (0, 0, 1).
std::vector<Slab> rise(const Solid& solid, int steps, const SweepOptions& options = {}) {
  std::vector<Pose> poses;
  for (int k = 0; k <= steps; ++k) poses.push_back(pose(solid, k, {0, 0, static_cast<double>(k)}));
  return sweep(solid, poses, options);
}

void addShapes(AcceptedCases& cases) {
  simplexFile(cases, "one-simplex", "One slab with empty layers, nothing compressed.")
      .slicedAt({-1, 0, 0.25, 0.5, 1, 2});
  cases.add("cross-polytope", "Two slabs that share a layer of six vertices.")
      .of({{"cross", crossPolytope()}})
      .slicedAt({-1, -0.5, 0, 0.25, 1})
      .encloses(2.0 / 3, [](double t) { return 4.0 / 3 * cubed(1 - std::abs(t)); });
  const Solid box = cube();
  cases
      .add("cube-in-translation",
           "A unit cube in five steps, caps in slabs of their own; the steps share their CONN.")
      .of({{"cube", rise(box, 5)}}, {.storage = Storage::Library})
      .slicedAt({0, 0.5, 2, 4.75, 5})
      .encloses(5, [](double) { return 1; });
  cases.add("cube-that-grows", "A cube that is scaled from 1 to 3, caps in its only slab.")
      .of({{"cube", sweep(box, {pose(box, -1, {0, 0, 0}), pose(box, 1, {0, 0, 0}, 3)},
                          {.capSlabs = false})}})
      .slicedAt({-1, -0.5, 0, 1})
      .encloses(20, [](double t) { return cubed(2 + t); });
  cases
      .add("cube-that-jumps",
           "A cube that is scaled from 1 to 2 at t = 1, in a slab without thickness.")
      .of({{"cube",
            sweep(box, {pose(box, 0, {1, 1, 1}), pose(box, 1, {1, 1, 1}),
                        pose(box, 1, {0.5, 0.5, 0.5}, 2), pose(box, 2, {0.5, 0.5, 0.5}, 2)})}})
      .slicedAt({0.5, 1, 1.5, 2})
      .encloses(9, [](double t) { return t < 1 ? 1 : 8; });
  // Eight steps of the angle whose cosine is 0.6; the closed form for such steps is exact for any
  // solid.
  const Solid tetrahedron = cornerTetrahedron();
  std::vector<Pose> screw;
  for (int k = 0; k <= 8; ++k) screw.push_back(turned(tetrahedron, 0.5 * k, k, {0, 0, 0.125 * k}));
  cases
      .add("screw-with-means",
           "A tetrahedron in a screw motion, 14 cells a step of a triangle: 10 of 18 vertices of a "
           "step are means.")
      .of({{"screw", sweep(tetrahedron, screw, {.prism = Prism::Fourteen})}},
          {.storage = Storage::Library})
      .slicedAt({0, 0.25, 1, 1.625, 4})
      .encloses(4 * 2.6 / 18, [](double t) {
        const double s = 2 * t - std::floor(2 * t);
        return (1 - 2 * s * (1 - s) * 0.4) / 6;
      });
  cases.add("cone-caps", "Caps in which all cells meet in a mean of the solid's eight corners.")
      .of({{"cube", sweep(box, {pose(box, 0, {0, 0, 0}), pose(box, 2, {4, 2, 1})},
                          {.prism = Prism::Fourteen, .cones = true})}})
      .slicedAt({0, 0.5, 1, 2})
      .encloses(2, [](double) { return 1; });
  std::vector<std::array<int, 3>> ring;
  std::vector<std::array<int, 3>> shell;
  for (int x = 0; x < 3; ++x) {
    for (int y = 0; y < 3; ++y) {
      for (int z = 0; z < 3; ++z) {
        if (x == 1 && y == 1 && z == 1) continue;
        shell.push_back({x, y, z});
        if (z == 1) ring.push_back({x, y, z});
      }
    }
  }
  const Solid ringSolid = cubes(ring);
  cases.add("ring", "A solid of genus 1 that moves and shrinks.")
      .of({{"ring",
            sweep(ringSolid, {pose(ringSolid, 0, {0, 0, 0}), pose(ringSolid, 1, {1, 2, 3}, 0.5)})}},
          {.storage = Storage::Library})
      .slicedAt({0, 0.5, 1})
      .encloses(8 * 15.0 / 32, [](double t) { return 8 * cubed(1 - t / 2); });
  const Solid shellSolid = cubes(shell);
  cases.add("hollow-cube", "A solid with a cavity, at rest.")
      .of({{"hollow",
            sweep(shellSolid, {pose(shellSolid, 0, {0, 0, 0}), pose(shellSolid, 1, {0, 0, 0})})}},
          {.storage = Storage::Library})
      .slicedAt({0, 0.5})
      .encloses(26, [](double) { return 26; });
  const Solid two = cubes({{0, 0, 0}, {3, 0, 0}});
  cases.add("two-components", "One body of two cubes that do not touch.")
      .of({{"pair", rise(two, 2)}}, {.storage = Storage::Blocks})
      .slicedAt({0.5, 1})
      .encloses(4, [](double) { return 2; });
  // The second is the first one, rotated by 180 degrees about the z axis.
  const Slab one = simplex()[0];
  Slab pair = one;
  auto cellsOfBoth = std::make_shared<model::Connectivity>(*one.connectivity);
  cellsOfBoth->vertexCount = 10;
  for (const model::Cell& cell : one.connectivity->cells) {
    cellsOfBoth->cells.push_back({cell[0] + 5, cell[1] + 5, cell[2] + 5, cell[3] + 5});
  }
  pair.connectivity = cellsOfBoth;
  for (const Point4& vertex : one.vertices) {
    pair.vertices.push_back({-vertex[0], -vertex[1], vertex[2], vertex[3]});
  }
  cases
      .add("vertices-at-one-place",
           "Two simplices that touch in a triangle, each with vertices of its own there: points of "
           "a "
           "slice are at one place and are not the same.")
      .of({{"pair", {pair}}})
      .slicedAt({0, 0.25, 0.5})
      .encloses(2.0 / 24, [](double t) { return 2 * simplexSlice(t); });
  cases
      .add("cubes-that-merge",
           "A solid of cubes whose slices are two, one, with a hole, and none; cells in layers.")
      .of({{"cubes", cubesInTime({{{0, 0, 0}, {2, 0, 0}},
                                  {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}},
                                  {{0, 0, 0},
                                   {1, 0, 0},
                                   {2, 0, 0},
                                   {0, 1, 0},
                                   {2, 1, 0},
                                   {0, 2, 0},
                                   {1, 2, 0},
                                   {2, 2, 0}},
                                  {{1, 0, 0}}})}},
          {.storage = Storage::Library})
      .slicedAt({0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4})
      .encloses(14, [](double t) {
        return t < 1 ? 2 : t < 2 ? 3 : t < 3 ? 8 : 1;
      });
}

void addSlabs(AcceptedCases& cases) {
  std::vector<Slab> apart = simplex();
  std::vector<Slab> later = simplex(1, {5, 0, 0, 2});
  apart.push_back(later[0]);
  cases.add("gap", "Nothing lies between the two slabs of a body: the slice is empty there.")
      .of({{"gap", apart}})
      .slicedAt({0.5, 1, 1.5, 2, 2.5, 3})
      .encloses(1.0 / 12,
                [](double t) { return t >= 1 && t < 2 ? 0 : simplexSlice(t < 1 ? t : t - 2); });
  std::vector<Slab> touching = simplex();
  touching.push_back(simplex(1, {5, 0, 0, 1})[0]);
  touching[1].connectivity = touching[0].connectivity;
  cases.add("runs-that-touch", "The second slab begins where the first ends, and shares no layer.")
      .of({{"touching", touching}})
      .slicedAt({0.5, 1, 1.5, 2})
      .encloses(1.0 / 12, [](double t) { return simplexSlice(t < 1 ? t : t - 1); });
  const Solid tetrahedron = cornerTetrahedron();
  cases.add("many-slabs", "Forty steps and two caps.")
      .of({{"many", rise(tetrahedron, 40)}}, {.storage = Storage::Blocks})
      .slicedAt({0.5, 20, 39.5})
      .encloses(40.0 / 6, [](double) { return 1.0 / 6; });
  cases.add("caps-alone", "Two caps at one time: a closed mesh that encloses nothing.")
      .of({{"flat", sweep(tetrahedron, {pose(tetrahedron, 1, {0, 0, 0})})}})
      .slicedAt({0.5, 1, 1.5})
      .encloses(0, [](double) { return 0; });

  const auto empty = std::make_shared<model::Connectivity>();
  Slab nothing;
  nothing.connectivity = empty;
  nothing.timeEnd = 1;
  std::vector<Slab> withEmpty = simplex();
  for (const auto& [begin, end] : {std::pair{1.0, 1.0}, {1.5, 4.0}}) {
    nothing.timeBegin = begin;
    nothing.timeEnd = end;
    withEmpty.push_back(nothing);
  }
  cases.add("slabs-without-vertices", "After a simplex, slabs that hold nothing.")
      .of({{"simplex", withEmpty}})
      .slicedAt({0.5, 1, 2, 4})
      .encloses(1.0 / 24, simplexSlice);
  nothing.timeBegin = -3;
  cases
      .add("body-without-vertices",
           "A body whose bounds in DONE are +infinity and -infinity, beside one of a simplex.")
      .of({{"nothing", {nothing}}, {"simplex", simplex()}})
      .slicedAt({0.5, -2})
      .encloses(1.0 / 24, simplexSlice);
  std::vector<Slab> unused = simplex();
  auto wider = std::make_shared<model::Connectivity>(*unused[0].connectivity);
  wider->vertexCount = 7;
  unused[0].connectivity = wider;
  unused[0].vertices.push_back({-7, 0.5, 8, 0.5});
  unused[0].vertices.push_back({0, -9, 0, 1});
  cases.add("unused-vertices", "Vertices that belong to no cell count for the bounds.")
      .of({{"simplex", unused}})
      .slicedAt({0.5})
      .encloses(1.0 / 24, simplexSlice);

  // A layer of two vertices without cells runs through several slabs. One of these has no
  // thickness, and the same LAYR below and above.
  auto above = std::make_shared<model::Connectivity>(*simplex()[0].connectivity);
  above->vertexCount = 7;
  above->upperCount = 2;
  Slab first = simplex()[0];
  first.connectivity = above;
  first.vertices.push_back({1, 2, 3, 1});
  first.vertices.push_back({4, 5, 6, 1});
  auto both = std::make_shared<model::Connectivity>();
  both->vertexCount = 4;
  both->lowerCount = both->upperCount = 2;
  Slab flat;
  flat.connectivity = both;
  flat.timeBegin = flat.timeEnd = 1;
  flat.vertices = {{1, 2, 3, 1}, {4, 5, 6, 1}, {1, 2, 3, 1}, {4, 5, 6, 1}};
  Image image(headJson({}, {"simplex"}));
  image.addConnectivity("CONN 0", *above);
  image.addLayer("LAYR 0", 1, first.upperLayer());
  image.addSlab("SLAB 0", 0, first, "CONN 0", "", "LAYR 0");
  image.addConnectivity("CONN 1", *both);
  image.addSlab("SLAB 1", 0, flat, "CONN 1", "LAYR 0", "LAYR 0");
  image.addEnd();
  cases.add("one-layer-below-and-above", "A flat slab without cells has one LAYR on both sides.")
      .of(image, {{"simplex", {first, flat}}})
      .slicedAt({0.5, 1})
      .encloses(1.0 / 24, simplexSlice);
}

void addNumbers(AcceptedCases& cases) {
  constexpr double kLarge = 1e70;
  cases.add("coordinates-of-1e70", "The hypervolume is near the largest number of binary64.")
      .of({{"large", simplex(kLarge)}})
      .slicedAt({0.25 * kLarge})
      .encloses(kLarge * kLarge * kLarge * kLarge / 24,
                [](double t) { return cubed(1e70 - t) / 6; });
  // Powers of two, so that all products are exact; y is large, so that they are normal numbers.
  std::vector<Slab> small = simplex();
  small[0].vertices[1][0] = std::ldexp(1, -1040);
  small[0].vertices[2][1] = std::ldexp(1, 100);
  small[0].vertices[4][0] = std::numeric_limits<double>::denorm_min();
  cases.add("subnormal-numbers", "x is below the least normal number.")
      .of({{"small", small}})
      .slicedAt({0.5})
      .encloses(std::ldexp(1.0, -940) / 24);
  std::vector<Slab> longLived = simplex();
  longLived[0].timeBegin = -1e300;
  longLived[0].timeEnd = 1e300;
  for (Point4& vertex : longLived[0].vertices) vertex[3] = 2e300 * vertex[3] - 1e300;
  cases.add("times-of-1e300", "Times near the largest number of binary64.")
      .of({{"long", longLived}})
      .slicedAt({-1e299, 0, 5e299})
      .encloses(2e300 / 24, [](double t) { return simplexSlice(t / 2e300 + 0.5); });
  const double next = std::nextafter(1.0, 2.0);
  std::vector<Slab> brief = simplex();
  brief[0].timeBegin = 1;
  brief[0].timeEnd = next;
  for (Point4& vertex : brief[0].vertices) vertex[3] = vertex[3] == 0 ? 1 : next;
  cases.add("neighbouring-times", "A slab from 1 to the next number of binary64.")
      .of({{"brief", brief}})
      .slicedAt({1, next, 0.5, 1.5})
      .encloses((next - 1) / 24, [=](double t) { return t == 1 ? 1.0 / 6 : 0.0; });

  // -0 in every possible place, and 0 where the same number is repeated. The t of a vertex is the
  // time of its layer, which is 0.
  std::vector<Slab> zero = crossPolytope();
  for (Slab& slab : zero) {
    for (Point4& vertex : slab.vertices) {
      for (double& number : vertex.head<3>()) {
        if (number == 0) number = -0.0;
      }
    }
    if (slab.timeEnd == 0) slab.timeEnd = -0.0;
  }
  Image image = Image::of({{"zero", zero}});
  image.set("LAYR 0/time", 0.0);
  image.set("INDX/record 0/end", 0.0);
  image.set("INDX/record 1/begin", -0.0);
  cases
      .add("negative-zero", "-0 and 0 are equal: coordinates, a layer's time, begin, end and INDX.")
      .of(image, {{"zero", zero}})
      .slicedAt({-0.5, 0, 0.5})
      .encloses(2.0 / 3, [](double t) { return 4.0 / 3 * cubed(1 - std::abs(t)); });

  std::vector<Slab> tenths = simplex(0.3, {0.1, 0.2, 0.7, -0.1});
  tenths[0].timeBegin = tenths[0].vertices[0][3];
  cases.add("float32", "Positions in binary32, times in binary64 all the same.")
      .of({{"simplex", tenths}}, {.float32 = true})
      .slicedAt({0.1});
  std::vector<Slab> extreme = simplex();
  extreme[0].vertices[1][0] = std::numeric_limits<float>::denorm_min();
  extreme[0].vertices[2][1] = std::numeric_limits<float>::max();
  cases.add("float32-extremes", "The least and the largest number of binary32.")
      .of({{"simplex", extreme}}, {.float32 = true})
      .slicedAt({0.5})
      .encloses(std::ldexp(1.0, -149) * std::numeric_limits<float>::max() / 24);
  const Solid box = cube();
  const std::vector<Slab> moving = rise(box, 2, {.prism = Prism::Fourteen});
  cases.add("float32-with-means", "Means are made in binary64 of positions in binary32.")
      .of({{"cube",
            sweep(box, {pose(box, 0, {0.1, 0.2, 0.3}, 0.7), pose(box, 0.1, {0.3, 0.2, 0.1}, 0.6)},
                  {.prism = Prism::Fourteen, .capSlabs = false})}},
          {.float32 = true, .storage = Storage::Library})
      .slicedAt({0, 0.05, 0.1});

  Image mixed(headJson({"means", "zstd"}, {"cube"}));
  const auto storeAs = [&](bool float32, Storage storage) {
    mixed.options().float32 = float32;
    mixed.options().storage = storage;
  };
  storeAs(false, Storage::Raw);
  mixed.addConnectivity("start", *moving[0].connectivity);
  mixed.addConnectivity("step", *moving[1].connectivity);
  storeAs(false, Storage::Library);
  mixed.addConnectivity("end", *moving[3].connectivity);
  storeAs(true, Storage::Raw);
  mixed.addLayer("layer 0", 0, moving[0].upperLayer());
  mixed.addSlab("SLAB 0", 0, moving[0], "start", "", "layer 0");
  storeAs(false, Storage::Blocks);
  mixed.addLayer("layer 1", 1, moving[1].upperLayer());
  mixed.addSlab("SLAB 1", 0, moving[1], "step", "layer 0", "layer 1");
  storeAs(true, Storage::Library);
  mixed.addLayer("layer 2", 2, moving[2].upperLayer());
  mixed.addSlab("SLAB 2", 0, moving[2], "step", "layer 1", "layer 2");
  mixed.addSlab("SLAB 3", 0, moving[3], "end", "layer 2", "");
  mixed.addEnd();
  cases.add("mixed-arrays", "Each array has its own type and codec.")
      .of(mixed, {{"cube", moving}}, {.float32 = true, .storage = Storage::Library})
      .slicedAt({0, 0.5, 1, 1.5, 2})
      .encloses(2, [](double) { return 1; });
}

/// The simplex with an array in CONN, one in the interior positions and one attribute, to be stored
/// in any way: 64 vertices, of which 59 are unused, with 128 numbers each.
std::vector<Slab> simplexWithRoom() {
  std::vector<Slab> slabs = simplex();
  auto connectivity = std::make_shared<model::Connectivity>(*slabs[0].connectivity);
  connectivity->vertexCount = 64;
  slabs[0].connectivity = connectivity;
  slabs[0].vertices.resize(64, Point4(0, 0, 0, 0));
  Attribute zeros{"zeros", Domain::Vertex, ScalarType::Float64, 128, {}};
  zeros.values.resize(64 * zeros.rowBytes());
  slabs[0].attributes = {zeros};
  return slabs;
}

void addCompression(AcceptedCases& cases) {
  simplexFile(cases, "zstd-stored-blocks", "Frames of stored blocks.",
              {.storage = Storage::Blocks});
  simplexFile(cases, "zstd-by-the-library", "Frames as the zstd library makes them.",
              {.storage = Storage::Library});
  simplexFile(cases, "zstd-named-and-not-used", "HEAD names features that the file does not use.",
              {}, headJson({"zstd", "means"}, {"simplex"}))
      .naming({"zstd", "means"});

  simplexFile(cases, "zstd-named-twice", "HEAD names a feature twice.",
              {.storage = Storage::Blocks}, headJson({"zstd", "zstd"}, {"simplex"}))
      .naming({"zstd", "zstd"});

  simplexFile(cases, "zstd-repeats", "Indices of cells are references to those shortly before.",
              {.storage = Storage::Repeats});
  const Solid box = cube();
  cases.add("zstd-repeats-with-means", "Cells, sizes and sources of means with codec 2.")
      .of({{"cube", rise(box, 2, {.prism = Prism::Fourteen})}}, {.storage = Storage::Repeats})
      .slicedAt({0, 0.5, 1})
      .encloses(2);
  for (const bool repeat : {false, true}) {
    cases
        .add(repeat ? "blocks-of-repeats" : "blocks-of-library",
             "65,540 cells and as many vertices are in two blocks each.")
        .of({{"simplices", {manySimplices()}}},
            {.storage = repeat ? Storage::Repeats : Storage::Library})
        .shows({"large"})
        .slicedAt({0.5})
        .encloses(13108.0 / 24);
  }
  cases.add("blocks-without-bounds", "The bounds of blocks of cells are left out.")
      .of({{"simplices", {manySimplices()}}}, {.storage = Storage::Repeats, .cellBounds = false})
      .shows({"large"})
      .slicedAt({0.5})
      .encloses(13108.0 / 24);

  // One CONN, stored in several ways.
  const auto cells = [] {
    const std::vector<Slab> slabs = simplex();
    std::string bytes;
    for (const model::Cell& cell : slabs[0].connectivity->cells) {
      for (const std::uint32_t index : cell) bytes += bytesOf(index);
    }
    return transposed(bytes, 16);
  }();
  const auto withFrame = [&](const std::string& name, const std::string& what,
                             const std::string& frame) {
    Image image = Image::of({{"simplex", simplex()}}, {}, headJson({"zstd"}, {"simplex"}));
    image.chunk("CONN 0").payload.replace("cells", arrayRecord(5, 4, 1, 5, {frame}));
    cases.add(name, what)
        .of(image, {{"simplex", simplex()}})
        .naming({"zstd"})
        .shows({"zstd"})
        .slicedAt({0.5})
        .encloses(1.0 / 24, simplexSlice);
  };
  withFrame("zstd-many-blocks", "A frame of blocks of three bytes.",
            zstdFrame(cells, {.blockBytes = 3}));
  withFrame("zstd-with-window", "A frame with a window, of 1 KiB, and its size in 4 bytes.",
            zstdFrame(cells, {.windowLog = 10}));
  withFrame("zstd-window-of-8-MiB", "A frame with the largest window that every decoder takes.",
            zstdFrame(cells, {.windowLog = 23}));
  withFrame("zstd-dictionary-0", "A frame with a dictionary ID of 0, which is none.",
            zstdFrame(cells, {.dictionaryId = 0}));
  withFrame("zstd-with-checksum", "A frame with a checksum of its content.",
            zstdByLibrary(cells, true));

  const std::vector<Slab> room = simplexWithRoom();
  const std::string zeros(64 * 128 * 8, '\0');
  const auto withAttribute = [&](const std::string& name, const std::string& what,
                                 const std::string& frame) {
    Image image = Image::of({{"simplex", room}}, {.storage = Storage::Library});
    image.chunk("SLAB 0").payload.replace("attribute 0/values",
                                          arrayRecord(10, 128, 1, 64, {frame}));
    cases.add(name, what)
        .of(image, {{"simplex", room}}, {.storage = Storage::Library})
        .slicedAt({0.5})
        .encloses(1.0 / 24, simplexSlice);
  };
  // 7 bytes of header, 13 run-length blocks of 4 bytes, a raw block of 5.
  std::string exact = zstdFrame(zeros.substr(0, zeros.size() - 2),
                                {.declaredSize = zeros.size(), .blockBytes = 5042});
  exact[exact.size() - 4] = static_cast<char>(exact[exact.size() - 4] & ~1);
  exact += "\x11\0\0\0\0"s;
  withAttribute("zstd-expansion-of-1024", "65,536 bytes are stored in 64: as dense as is allowed.",
                exact);
  withAttribute("zstd-run-length-blocks", "Run-length blocks, and the size in 2 bytes.",
                zstdFrame(zeros, {.blockBytes = 4096}));
}

std::vector<std::byte> ramp(std::size_t bytes, unsigned seed) {
  std::vector<std::byte> values(bytes);
  for (std::size_t i = 0; i < bytes; ++i) values[i] = std::byte(seed + 37 * i + i * i / 5);
  return values;
}

Attribute attribute(const std::string& name, Domain domain, ScalarType type, unsigned components,
                    std::size_t rows, unsigned seed = 1) {
  Attribute made{name, domain, type, components, {}};
  made.values = ramp(rows * made.rowBytes(), seed);
  return made;
}

template <class T>
Attribute attributeOf(const std::string& name, Domain domain, const std::vector<T>& values) {
  return model::makeAttribute(name, domain, values);
}

constexpr ScalarType kTypes[] = {ScalarType::UInt8,  ScalarType::Int8,   ScalarType::UInt16,
                                 ScalarType::Int16,  ScalarType::UInt32, ScalarType::Int32,
                                 ScalarType::UInt64, ScalarType::Int64,  ScalarType::Float32,
                                 ScalarType::Float64};

std::vector<Slab> simplexWith(const std::vector<Attribute>& own,
                              const std::vector<Attribute>& ofConnectivity = {}) {
  std::vector<Slab> slabs = simplex();
  auto connectivity = std::make_shared<model::Connectivity>(*slabs[0].connectivity);
  connectivity->cellAttributes = ofConnectivity;
  slabs[0].connectivity = connectivity;
  slabs[0].attributes = own;
  return slabs;
}

void addAttributes(AcceptedCases& cases) {
  const auto simplexAttributes = [&](const std::string& name, const std::string& what,
                                     const std::vector<Slab>& slabs,
                                     const ImageOptions& options = {}) -> AcceptedBuilder& {
    return cases.add(name, what)
        .of({{"simplex", slabs}}, options)
        .slicedAt({0.5})
        .encloses(1.0 / 24, simplexSlice);
  };
  simplexAttributes(
      "attribute", "One attribute.",
      simplexWith({attributeOf<std::uint8_t>("kind", Domain::Cell, {0, 1, 2, 3, 4})}));
  for (const Storage storage : {Storage::Raw, Storage::Library}) {
    std::vector<Attribute> own;
    std::vector<Attribute> ofCells;
    std::vector<Attribute> ofConnectivity;
    for (const ScalarType type : kTypes) {
      const auto number = static_cast<unsigned>(type);
      const std::string name = fmt::format("type {}", number);
      own.push_back(attribute(name, Domain::Vertex, type, 1 + number % 3, 5, number));
      ofCells.push_back(attribute("own " + name, Domain::Cell, type, 1, 5, 2 * number));
      ofConnectivity.push_back(attribute(name, Domain::Cell, type, 1 + number % 4, 5, 3 * number));
    }
    own.insert(own.end(), ofCells.begin(), ofCells.end());
    const bool raw = storage == Storage::Raw;
    simplexAttributes(raw ? "attributes-of-all-types" : "attributes-of-all-types-zstd",
                      raw ? "Each type for vertices and cells, in CONN and in SLAB."
                          : "The same, compressed: rows of 1 to 32 bytes are transposed.",
                      simplexWith(own, ofConnectivity), {.storage = storage});
  }
  simplexAttributes("attribute-of-255-components", "Rows of 255 numbers.",
                    simplexWith({attribute("wide", Domain::Vertex, ScalarType::Int16, 255, 5)}));
  std::vector<Attribute> named;
  std::string name;
  for (int length = 1; length <= 9; ++length) {
    name += static_cast<char>('a' + length);
    named.push_back(attribute(name, Domain::Cell, ScalarType::UInt8, 1, 5));
  }
  named.push_back(attribute(std::string(255, 'n'), Domain::Cell, ScalarType::UInt8, 3, 5));
  simplexAttributes("attribute-names-of-all-lengths",
                    "Names of 1 to 9 and of 255 bytes, and their padding.", simplexWith(named));
  simplexAttributes("attribute-names-in-unicode",
                    "Names of one to four bytes a character, and two that look alike.",
                    simplexWith({attribute("\xC3\xA9", Domain::Vertex, ScalarType::UInt8, 1, 5),
                                 attribute("e\xCC\x81", Domain::Vertex, ScalarType::UInt8, 1, 5),
                                 attribute("\xE2\x82\xAC \xF0\x9F\xA7\x8A", Domain::Vertex,
                                           ScalarType::UInt8, 1, 5),
                                 attribute("\xF4\x8F\xBF\xBF\xEF\xBF\xBF\xED\x9F\xBF\xEE\x80\x80",
                                           Domain::Vertex, ScalarType::UInt8, 1, 5),
                                 attribute("a", Domain::Vertex, ScalarType::UInt8, 1, 5)}));
  simplexAttributes("attribute-names-of-two-domains",
                    "A vertex and a cell attribute may be called the same.",
                    simplexWith({attribute("same", Domain::Vertex, ScalarType::UInt8, 1, 5),
                                 attribute("same", Domain::Cell, ScalarType::UInt8, 1, 5)}));
  simplexAttributes(
      "attribute-values-of-any-bits",
      "Infinity, -0, NaN with a payload and signalling NaN are kept as they are.",
      simplexWith(
          {attributeOf<double>(
               "binary64", Domain::Vertex,
               {kInfinity, -0.0, std::bit_cast<double>(std::uint64_t{0x7FF8000000000123}),
                std::bit_cast<double>(std::uint64_t{0xFFF8000000000000}),
                std::bit_cast<double>(std::uint64_t{0x7FF0000000000001})}),
           attributeOf<float>(
               "binary32", Domain::Cell,
               {-std::numeric_limits<float>::infinity(), -0.0F, std::bit_cast<float>(0x7FC00123U),
                std::bit_cast<float>(0xFFC00000U), std::bit_cast<float>(0x7F800001U)})}));
  std::vector<Slab> means =
      rise(cornerTetrahedron(), 1, {.prism = Prism::Fourteen, .capSlabs = false});
  const std::size_t vertices = means[0].vertices.size();
  for (const ScalarType type : kTypes) {
    const auto number = static_cast<unsigned>(type);
    means[0].attributes.push_back(attribute(fmt::format("type {}", number), Domain::Vertex, type,
                                            1 + number % 3, vertices, number));
  }
  std::vector<float> largest(vertices, std::numeric_limits<float>::max());
  largest[0] = kInfinity;
  largest[4] = -kInfinity;
  means[0].attributes.push_back(attributeOf("infinite", Domain::Vertex, largest));
  std::vector<double> odd(vertices, -0.0);
  odd[1] = std::numeric_limits<double>::denorm_min();
  odd[2] = std::bit_cast<double>(std::uint64_t{0xFFF8000000000123});
  odd[3] = std::numeric_limits<double>::max();
  means[0].attributes.push_back(attributeOf("odd", Domain::Vertex, odd));
  std::vector<float> oddFloats(vertices, -0.0F);
  oddFloats[1] = std::numeric_limits<float>::denorm_min();
  oddFloats[2] = std::bit_cast<float>(0xFFC00123U);
  oddFloats[3] = std::numeric_limits<float>::max();
  means[0].attributes.push_back(attributeOf("odd floats", Domain::Vertex, oddFloats));
  for (Attribute& each : means[0].attributes) setMeans(*means[0].connectivity, each);
  cases
      .add("attributes-of-means",
           "Means inherit: the mean of floating-point numbers, of integers that of the first "
           "source.")
      .of({{"tetrahedron", means}})
      .slicedAt({0.5})
      .encloses(1.0 / 6, [](double) { return 1.0 / 6; });
  for (const Storage storage : {Storage::Raw, Storage::Library}) {
    // Vertex 0 below, 1 to 6 in the layer, 7 above.
    std::vector<Slab> cross = crossPolytope();
    for (const ScalarType type : kTypes) {
      const auto number = static_cast<unsigned>(type);
      const Attribute all = attribute(fmt::format("type {}", number), Domain::Vertex, type,
                                      1 + number % 3, 8, number);
      for (std::size_t k = 0; k < 2; ++k) {
        cross[k].attributes.push_back(vertexRows(std::span(&all, 1), k, 7)[0]);
      }
    }
    cases
        .add(storage == Storage::Raw ? "attributes-of-a-layer" : "attributes-of-a-layer-zstd",
             "The layer between two slabs has its attributes once.")
        .of({{"cross", cross}}, {.storage = storage})
        .slicedAt({-0.5, 0, 0.5})
        .encloses(2.0 / 3);
  }
  Slab nothing;
  nothing.connectivity = std::make_shared<model::Connectivity>();
  nothing.timeBegin = nothing.timeEnd = 1;
  nothing.attributes = {attribute("none", Domain::Cell, ScalarType::UInt16, 255, 0)};
  std::vector<Slab> withNothing = simplex();
  withNothing.insert(withNothing.end(), {nothing, nothing});
  cases.add("attribute-of-no-rows", "An attribute of two slabs without cells.")
      .of({{"simplex", withNothing}})
      .slicedAt({0.5})
      .encloses(1.0 / 24, simplexSlice);
}

void addMeans(AcceptedCases& cases) {
  // A mean that rounding makes greater than each of its sources; multiplying by the reciprocal of 3
  // would not.
  auto third = std::make_shared<model::Connectivity>(*simplex()[0].connectivity);
  third->vertexCount = 9;
  third->means.add(std::vector<std::uint32_t>{5, 6, 7});
  Slab equal = simplex(0.0625)[0];
  equal.connectivity = third;
  for (const double t : {0.0, 0.0, 0.0625}) equal.vertices.emplace_back(0.1, 0.1, 0.1, t);
  equal.vertices.resize(9);
  model::setMeans(*third, equal.vertices);
  cases
      .add("means-are-divided",
           "The mean of 0.1, 0.1, 0.1 is 0.30000000000000004 / 3 = 0.10000000000000002.")
      .of({{"simplex", {equal}}})
      .slicedAt({0.03125})
      .encloses(std::pow(0.0625, 4) / 24);

  // ((1 + 2^53) + 1) - 2^53 is 0 in this order; the simplex's first corner depends on it.
  auto ordered = std::make_shared<model::Connectivity>();
  ordered->vertexCount = 9;
  ordered->cells = simplex()[0].connectivity->cells;
  for (model::Cell& cell : ordered->cells) {
    for (std::uint32_t& corner : cell) corner = corner == 0 ? 8 : corner - 1;
  }
  ordered->means.add(std::vector<std::uint32_t>{4, 5, 6, 7});
  Slab sums = simplex()[0];
  sums.connectivity = ordered;
  sums.vertices.erase(sums.vertices.begin());
  const double large = std::ldexp(1, 53);
  for (const double z : {1.0, large, 1.0, -large}) sums.vertices.emplace_back(0, 0, z, 0);
  sums.vertices.resize(9);
  model::setMeans(*ordered, sums.vertices);
  cases.add("means-are-summed-in-order", "The mean of z = 1, 2^53, 1, -2^53 is 0, not 1/2.")
      .of({{"simplex", {sums}}})
      .slicedAt({0.5})
      .encloses(1.0 / 24, simplexSlice);

  // A simplex whose corners are all means: of one vertex, of the same vertex twice, and of vertices
  // of the lower layer, the interior and the upper layer.
  auto all = std::make_shared<model::Connectivity>();
  all->lowerCount = 2;
  all->upperCount = 2;
  all->vertexCount = 11;  // 2 lower, 2 interior, 5 means, 2 upper
  all->means.add(std::vector<std::uint32_t>{0, 1});
  all->means.add(std::vector<std::uint32_t>{2});
  all->means.add(std::vector<std::uint32_t>{3, 3});
  all->means.add(std::vector<std::uint32_t>{0, 1, 2, 2, 3, 9, 9, 10});
  all->means.add(std::vector<std::uint32_t>{9, 10});
  all->cells = simplex()[0].connectivity->cells;
  for (model::Cell& cell : all->cells) {
    for (std::uint32_t& corner : cell) corner += 4;
  }
  Slab sources;
  sources.connectivity = all;
  sources.timeEnd = 1;
  sources.vertices.resize(11);
  sources.vertices[0] = {-1, 0, 0, 0};
  sources.vertices[1] = {1, 0, 0, 0};
  sources.vertices[2] = {1, 0, 0, 0};
  sources.vertices[3] = {0, 1, 0, 0};
  sources.vertices[9] = {-1, -1, 4, 1};
  sources.vertices[10] = {1, 1, -4, 1};
  model::setMeans(*all, sources.vertices);
  cases
      .add("means-of-all-sources",
           "Means of one, of the same twice, and of vertices of every part.")
      .of({{"means", {sources}}})
      .slicedAt({0.1, 0.25, 0.5});
}

/// A file with the slabs of the bodies in this order, each with its own CONN.
Image bodyByBody(const std::vector<BodySlabs>& bodies, const std::vector<std::uint32_t>& order) {
  std::vector<std::string> names;
  names.reserve(bodies.size());
  for (const BodySlabs& body : bodies) names.push_back(body.name);
  Image image(headJson({}, names));
  for (const std::uint32_t body : order) {
    std::string lower;
    for (std::size_t k = 0; k < bodies[body].slabs.size(); ++k) {
      const Slab& slab = bodies[body].slabs[k];
      const std::string number = fmt::format("{}.{}", body, k);
      image.addConnectivity("CONN " + number, *slab.connectivity);
      const std::string upper = slab.connectivity->upperCount > 0 ? "LAYR " + number : "";
      if (!upper.empty()) image.addLayer(upper, slab.timeEnd, slab.upperLayer());
      image.addSlab("SLAB " + number, body, slab, "CONN " + number, lower, upper);
      lower = upper;
    }
  }
  image.addEnd();
  return image;
}

void addPoses(AcceptedCases& cases) {
  const Solid box = cube();
  const auto up = [](std::size_t k) { return movedBy({0, 0, static_cast<double>(k)}); };
  const SweepOptions withMeans{.prism = Prism::Fourteen};
  const std::vector<Slab> moving = withPoses(rise(box, 3, withMeans), up);
  const auto add = [&](const char* name, const char* what, const std::vector<Slab>& slabs,
                       const ImageOptions& options) {
    cases.add(name, what)
        .of({{"cube", slabs}}, options)
        .slicedAt({0, 0.5, 1, 2.75, 3})
        .encloses(3, [](double) { return 1; });
  };
  add("poses", "Layers that are the first one, moved.", moving, {});
  add("poses-no-index", "The same without an index.", moving, {.index = false});
  add("poses-zstd", "The same, compressed.", moving, {.storage = Storage::Library});
  Image late =
      Image::of({{"cube", withPoses(rise(box, 3), [&](std::size_t k) { return up(k + 1); })}});
  late.set("LAYR 0/time", 99.0);
  cases.add("poses-of-a-layer-of-no-slab", "A LAYR that only POSEs name may be at any time.")
      .of(late, {{"cube", withPoses(rise(box, 3), [&](std::size_t k) { return up(k + 1); })}})
      .slicedAt({0, 0.5, 1, 2.75, 3});
  // The angle whose cosine is 0.6; numbers that are rounded at each operation.
  const auto turn = [](std::size_t k) {
    model::Affine3x4 pose = movedBy({0.1 * static_cast<double>(k), 0.7, -0.3});
    if (k % 2 == 1) pose.leftCols<3>() << 0.6, -0.8, 0.1, 0.8, 0.6, 0, 0, 0.1, 1;
    return pose;
  };
  cases.add("poses-that-turn", "A matrix of which each product and each sum is rounded.")
      .of({{"cube", withPoses(rise(cube(0.3), 3, withMeans), turn)}})
      .slicedAt({0, 0.5, 1, 2.75, 3});
  cases.add("poses-in-float32", "Layers that are moved and then rounded to binary32.")
      .of({{"cube", withPoses(rise(cube(0.3F), 3, withMeans), turn, true)}}, {.float32 = true})
      .slicedAt({0, 0.5, 1, 2.75, 3});
  std::vector<Slab> marked = moving;
  for (Slab& slab : marked) {
    std::vector<float> warmth(slab.vertices.size());
    std::vector<std::uint16_t> numbers(slab.vertices.size());
    const auto set = [&](std::size_t first, std::size_t count) {
      for (std::size_t i = 0; i < count; ++i) {
        warmth[first + i] = 0.1F * static_cast<float>(i);
        numbers[first + i] = static_cast<std::uint16_t>(7 * i);
      }
    };
    set(0, slab.connectivity->lowerCount);
    set(slab.connectivity->firstUpper(), slab.connectivity->upperCount);
    slab.attributes = {attributeOf("warmth", Domain::Vertex, warmth),
                       attributeOf("number", Domain::Vertex, numbers)};
    for (Attribute& each : slab.attributes) setMeans(*slab.connectivity, each);
  }
  add("poses-with-attributes", "A layer that is moved has the attributes of the LAYR.", marked, {});
}

void addGrids(AcceptedCases& cases) {
  const Solid box = cube();
  const formats::Grid quarters{{0.25, -1, 100.5}, 0.25};
  const auto up = [](std::size_t k) { return movedBy({0, 0, static_cast<double>(k)}); };
  for (const Storage storage : {Storage::Raw, Storage::Library}) {
    cases
        .add(storage == Storage::Raw ? "grid" : "grid-zstd",
             "Positions of layers and interiors are whole numbers.")
        .of({{"cube", rise(box, 2, {.prism = Prism::Fourteen})}, {"simplex", simplex()}},
            {.storage = storage, .grid = quarters})
        .slicedAt({0, 0.5, 2})
        .encloses(2 + 1.0 / 24);
  }
  const formats::Grid rounded{{0.05, 1e-3, -7}, 0.1};
  cases.add("grid-that-is-rounded", "origin + step x k, of which product and sum are rounded.")
      .of({{"cube", sweep(box, {pose(box, 0, {0.1, 0.2, 0.3}, 7), pose(box, 1, {0.3, 0.2, 9}, 5)},
                          {.prism = Prism::Fourteen})}},
          {.grid = rounded})
      .slicedAt({0, 0.5, 1});
  const double most = std::numeric_limits<std::int32_t>::max();
  cases.add("grid-of-all-numbers", "The least and the greatest whole number.")
      .of({{"simplex", simplex(2 * most + 1, {-most - 1, -most - 1, -most - 1, 0})}},
          {.grid = formats::Grid{{0, 0, 0}, 1}})
      .slicedAt({0.5});
  cases.add("grid-with-poses", "Layers that are moved from a grid.")
      .of({{"cube", withPoses(rise(box, 2), up)}}, {.grid = quarters})
      .slicedAt({0, 0.5, 2})
      .encloses(2, [](double) { return 1; });
  simplexFile(cases, "grid-named-and-not-used", "HEAD has a grid, and positions are binary64.", {},
              headJson({"grid", "pose"}, {"simplex"}, gridJson(quarters)))
      .naming({"grid", "pose"});
  simplexFile(cases, "head-grid-without-feature",
              "HEAD has a grid, a feature that it does not name.", {},
              headJson({}, {"simplex"}, gridJson(quarters)));
}

/// The contents of INDX of a complete file.
formats::Index indexOf(const std::string& file) {
  const formats::ChunkHeader header = formats::listChunks(file).back();
  const std::size_t begin = header.offset + formats::t4d_layout::kChunkHeaderBytes;
  const auto bytes = std::as_bytes(std::span(file)).subspan(begin, header.payloadBytes);
  const auto payload = formats::payloadOf(header, bytes);
  return *formats::decodeIndex(*payload, {});
}

/// Adds a PAGE for each slab, and PGIX, to a complete file of one body.
Image withPages(Image image) {
  using namespace formats::t4d_layout;
  const auto add = [&](const std::string& name, const PayloadWriter& payload) {
    Image::Chunk chunk;
    chunk.name = name;
    chunk.type = name.substr(0, 4);
    chunk.flags = 0;
    const auto text = [](std::span<const std::byte> bytes) {
      return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    };
    chunk.payload.putBytes("fields", text(payload.bytes()));
    for (const auto& block : payload.blocks()) chunk.payload.putBlock("block", text(block.bytes()));
    image.add(chunk, "DONE");
    return formats::listChunks(image.bytes()).rbegin()[2];  // then come DONE and INDX
  };
  const formats::Index index = indexOf(image.bytes());
  formats::PageList list{index.chunks.front(), {}, {}, 0};
  formats::ChunkList chunks;
  formats::SlabList slabs;
  for (const auto& chunk : index.chunks) {
    if (chunk.type == kDone) break;
    chunks.push_back(chunk);
    formats::addChunk(list.chunks, chunk.type, chunk.bytes());
  }
  for (const auto& slab : index.slabs) slabs.push_back(slab);
  std::uint64_t end = chunks.back().end();
  const auto addPage = [&](const formats::PageRun& run) -> Result<void> {
    const auto page = add(fmt::format("PAGE {}", list.pages.size()), encodePage(run, end, 0));
    formats::addChunk(list.chunks, kPage, page.bytes());
    list.pages.push_back(entryOf(run, page.offset));
    list.pages.back().checksum = checksumOf(page);
    end = page.end();
    return {};
  };
  (void)formats::eachPageRun(chunks, slabs, 1, 1, addPage);
  list.offset = end;
  add("PGIX", encodePageList(list));
  return image;
}

void addContainer(AcceptedCases& cases) {
  simplexFile(cases, "no-index", "A file without index and footer.", {.index = false});
  cases.add("no-index-many-slabs", "Slabs are found from the front.")
      .of({{"cross", crossPolytope()}}, {.index = false})
      .slicedAt({-0.5, 0, 0.5, 1})
      .encloses(2.0 / 3, [](double t) { return 4.0 / 3 * cubed(1 - std::abs(t)); });
  simplexFile(cases, "latest-minor-version", "Version 1.65535.", {.minorVersion = 65535});

  simplexFile(
      cases, "space-and-attributes",
      "Version 1.1: HEAD has a space, and kinds of attributes, one of them of a later version.",
      {.minorVersion = 1},
      headJson({}, {"simplex"},
               R"("space":"LPS","attributes":{"velocity":{"kind":"vector",)"
               R"("unit":"length/time"},"example:stress":{"kind":"tensor"}})"));
  simplexFile(cases, "space-and-attributes-of-another-form",
              "A space that is a number, and attributes that are an array: members to be ignored.",
              {.minorVersion = 1},
              headJson({}, {"simplex"}, R"("space":7,"attributes":[{"kind":"vector"}])"));

  const auto optional = [](const std::string& type, std::size_t bytes) {
    Image::Chunk chunk;
    chunk.name = fmt::format("{} {}", type, bytes);
    chunk.type = type;
    chunk.flags = 0;
    chunk.payload.putBytes("bytes", std::string(bytes, '\xEE'));
    return chunk;
  };
  Image later = Image::of({{"simplex", simplex()}}, {.minorVersion = 7},
                          headJson({}, {"simplex"}, R"("colours":{"simplex":"red"})"));
  later.add(optional("COLR", 12), "CONN 0");
  cases
      .add("later-minor-version",
           "Version 1.7, with a member of HEAD and a chunk that 1.0 does not know.")
      .of(later, {{"simplex", simplex()}}, {.minorVersion = 7})
      .shows({"optional-chunk"})
      .slicedAt({0.5})
      .encloses(1.0 / 24, simplexSlice);

  for (const bool index : {true, false}) {
    Image image = Image::of({{"cross", crossPolytope()}}, {.index = index});
    std::size_t bytes = 0;
    for (const char* before : {"CONN 0", "LAYR 0", "SLAB 0", "CONN 1", "SLAB 1", "DONE"}) {
      image.add(optional("note", bytes++), before);
      image.add(optional("N123", 100 + bytes), before);
    }
    image.add(optional("zZ9a", 6), "DONE");
    image.add(optional("NOTE", 7), "DONE");
    Image::Chunk blocks = optional("bloc", 16);
    for (const std::size_t size : {8, 0, 13}) {
      blocks.payload.putBlock(fmt::format("block of {}", size), std::string(size, '\xBB'));
    }
    image.add(blocks, "CONN 1");
    cases
        .add(index ? "optional-chunks" : "optional-chunks-no-index",
             "Chunks of unknown types wherever they may be, with every padding.")
        .of(image, {{"cross", crossPolytope()}}, {.index = index})
        .shows({"optional-chunk"})
        .slicedAt({-0.5, 0, 0.5})
        .encloses(2.0 / 3, [](double t) { return 4.0 / 3 * cubed(1 - std::abs(t)); });
  }

  const std::vector<Slab> risen = rise(cube(), 10);
  cases.add("index-in-pages", "Version 1.1: the index again as a PAGE for each slab, and PGIX.")
      .of(withPages(Image::of({{"cube", risen}}, {.minorVersion = 1})), {{"cube", risen}},
          {.minorVersion = 1})
      .shows({"optional-chunk"})
      .slicedAt({0, 0.5, 7, 9.75})
      .encloses(10, [](double) { return 1; });

  // Parts far before the slabs, in a different order.
  const std::vector<Slab> moving = rise(cube(), 3);
  Image parts = Image::of({{"cube", moving}});
  for (const char* part : {"CONN 2", "LAYR 3", "LAYR 1", "CONN 1", "LAYR 2", "LAYR 0", "CONN 0"}) {
    parts.move(part, "SLAB 0");
  }
  cases.add("parts-in-any-order", "All CONN and LAYR come first, in no order.")
      .of(parts, {{"cube", moving}})
      .slicedAt({0.5, 1, 2.5})
      .encloses(3, [](double) { return 1; });

  const std::vector<BodySlabs> three = {{"cross", crossPolytope()},
                                        {"simplex", simplex(2, {4, 0, 0, -1})},
                                        {"cube", rise(cube(), 2)}};
  const auto threeSlice = [](double t) {
    double volume = std::abs(t) < 1 ? 4.0 / 3 * cubed(1 - std::abs(t)) : 0;
    if (t >= -1 && t < 1) volume += cubed(1 - t) / 6;
    if (t >= 0 && t <= 2) volume += 1;
    return volume;
  };
  cases.add("three-bodies", "Bodies of different lengths take turns.")
      .of(three)
      .slicedAt({-1, -0.5, 0, 0.5, 1, 1.5})
      .encloses(2.0 / 3 + 16.0 / 24 + 2, threeSlice);
  cases
      .add("bodies-in-any-order",
           "One body after the other, the last first, each with its own parts.")
      .of(bodyByBody(three, {2, 0, 1}), three)
      .slicedAt({-0.5, 0.5, 1.5})
      .encloses(2.0 / 3 + 16.0 / 24 + 2, threeSlice);

  // Two bodies that consist of the same parts.
  const std::vector<Slab> cross = crossPolytope();
  Image sharing(headJson({}, {"one", "two"}));
  sharing.addConnectivity("below", *cross[0].connectivity);
  sharing.addConnectivity("above", *cross[1].connectivity);
  sharing.addLayer("middle", 0, cross[0].upperLayer());
  for (const std::uint32_t body : {0U, 1U}) {
    const std::string of = fmt::format(" of {}", body);
    sharing.addSlab("first" + of, body, cross[0], "below", "", "middle");
    sharing.addSlab("second" + of, body, cross[1], "above", "middle", "");
  }
  sharing.addEnd();
  cases.add("bodies-that-share-parts", "Slabs of two bodies name the same CONN and LAYR.")
      .of(sharing, {{"one", cross}, {"two", cross}})
      .slicedAt({0.25})
      .encloses(4.0 / 3, [](double t) { return 8.0 / 3 * cubed(1 - std::abs(t)); });

  // What two files have that were joined: each its own parts, and the layer between them.
  Image joined = Image::of({{"cross", cross}});
  Image::Chunk again = joined.chunk("LAYR 0");
  again.name = "LAYR 1";
  joined.add(again, "SLAB 1");
  joined.chunk("SLAB 1").offsets["lower"] = "LAYR 1";
  cases.add("layer-stored-again", "lower names a copy of the LAYR that upper before it names.")
      .of(joined, {{"cross", cross}})
      .slicedAt({-0.5, 0, 0.25})
      .encloses(2.0 / 3, [](double t) { return 4.0 / 3 * cubed(1 - std::abs(t)); });
  Image spare = Image::of({{"cube", moving}});
  Image::Chunk connectivity = spare.chunk("CONN 1");
  connectivity.name = "CONN 3";
  spare.add(connectivity, "SLAB 2");
  spare.chunk("SLAB 2").offsets["connectivity"] = "CONN 3";
  cases.add("connectivity-stored-again", "A CONN is stored again for later slabs.")
      .of(spare, {{"cube", moving}})
      .slicedAt({0.5, 1.5})
      .encloses(3, [](double) { return 1; });

  // Layers far before the slab that names them as the upper of the slab before.
  const std::vector<BodySlabs> apart = {{"cross", cross}, {"cube", rise(cube(), 40)}};
  Image late = Image::of(apart);
  late.move("SLAB 2", "DONE");
  cases.add("lower-layer-far-back", "lower is 41 LAYRs back, and upper of the slab before.")
      .of(late, apart)
      .slicedAt({-0.5, 0.25})
      .encloses(2.0 / 3 + 40, [](double t) {
        return (std::abs(t) < 1 ? 4.0 / 3 * cubed(1 - std::abs(t)) : 0) + (t >= 0 ? 1 : 0);
      });

  Image padded = Image::of({{"cross", cross}});
  for (const auto& [before, bytes] :
       {std::pair<const char*, std::size_t>{"CONN 0", 4000}, {"SLAB 1", 0}, {"DONE", 8}}) {
    Image::Chunk chunk;
    chunk.name = fmt::format("PADD {}", bytes);
    chunk.type = "PADD";
    chunk.flags = 0;
    chunk.payload.putBytes("zeros", std::string(bytes, '\0'));
    padded.add(chunk, before);
  }
  cases.add("padding", "PADD chunks, one without a byte.")
      .of(padded, {{"cross", cross}})
      .shows({"optional-chunk"})
      .slicedAt({-0.5, 0.25})
      .encloses(2.0 / 3, [](double t) { return 4.0 / 3 * cubed(1 - std::abs(t)); });

  std::vector<BodySlabs> many;
  many.reserve(40);
  for (int i = 0; i < 40; ++i) {
    many.push_back({fmt::format("body {}", i), simplex(1, {2.0 * i, 0, 0, 0.5 * i})});
  }
  cases.add("forty-bodies", "Forty bodies at times of their own.")
      .of(many)
      .slicedAt({10.25})
      .encloses(40.0 / 24);
}

void addHeads(AcceptedCases& cases) {
  const auto withHead = [&](const std::string& name, const std::string& what,
                            const std::string& head,
                            const std::string& body = "simplex") -> AcceptedBuilder& {
    return cases.add(name, what)
        .of({{body, simplex()}}, {}, head)
        .shows({"json"})
        .slicedAt({0.5})
        .encloses(1.0 / 24, simplexSlice);
  };
  withHead(
      "head-all-members", "All members of HEAD, and some of no table.",
      headJson({}, {"simplex"},
               R"("generator":"by hand 1.0","backend":"other","length_unit":"mm",)"
               R"("time_unit":"s","up":"z","details":{"source":{"file":"a.stl","n":[1,2.5,-3e-7]},)"
               R"("true":true,"null":null},"x-colour":"red","features2":["wavelets"],"":0)"));
  withHead("head-white-space",
           "White space of all four kinds around and between; members in any order.",
           "\r\n\t {\t\"bodies\"\n:\r[ { \"name\" : \"simplex\"} ]\n,\n\"up\" : \"y\" , "
           "\"features\":[\t]\n}\n\n "
           "\r\t");
  const std::string unicode =
      "w\xC3\xBCrfel \xD0\xBA\xD1\x83\xD0\xB1 \xE7\xAB\x8B\xE6\x96\xB9 \xF0\x9F\xA7\x8A";
  withHead("head-unicode", "A body's name in Latin, Cyrillic, Chinese and beyond 16 bits.",
           headJson({}, {unicode}, "\"generator\":\"\xE2\x88\x87\""), unicode)
      .shows({"json", "unicode"});
  withHead("head-escapes", "A body's name in escapes, those of a surrogate pair among them.",
           R"({"features":[],"bodies":[{"name":"\u0063ube\u00e9\ud83e\uddca\"\\end"}],)"
           R"("generator":"\/\b\f\n\r\t\u0000","\u0075p":"\u007a"})",
           "cube\xC3\xA9\xF0\x9F\xA7\x8A\"\\end")
      .shows({"json", "unicode"});
  std::string longName;
  for (int i = 0; i < 85; ++i) longName += "\xE2\x82\xAC";
  cases
      .add("head-bodies-with-all-members",
           "Bodies with a colour, a material, a parent and details.")
      .of({{"whole", simplex()}, {"part", crossPolytope()}}, {},
          R"({"features":[],"bodies":[{"name":"whole","color":[0,0.5,1],"details":{"a":[1]},"later":1},)"
          R"({"name":"part","parent":"whole","material":"steel","color":[1,1,1,0]}]})")
      .slicedAt({0.5})
      .encloses(1.0 / 24 + 2.0 / 3);
  withHead("head-name-of-255-bytes", "The longest name of a body: 85 characters of three bytes.",
           headJson({}, {longName}), longName)
      .shows({"json", "unicode"});
  // HEAD is level 1, details level 2.
  std::string deep = "{}";
  for (int level = 63; level >= 2; --level) {
    deep = level % 2 == 0 ? "{\"a\":" + deep + "}" : "[" + deep + "]";
  }
  withHead("head-64-levels", "JSON as deep as is allowed.",
           headJson({}, {"simplex"}, "\"details\":" + deep));
  std::string large;
  for (int i = 0; i < 4000; ++i) {
    large += fmt::format(R"({}"member {}":[{},"{}"])", i == 0 ? "" : ",", i, i * 0.25, i);
  }
  withHead("head-large", "Details of 100 KB.",
           headJson({}, {"simplex"}, "\"details\":{" + large + "}"));
  withHead(
      "head-numbers", "Numbers as JSON has them, up to the largest of binary64.",
      headJson(
          {}, {"simplex"},
          R"("details":{"n":[0,-0,0.0,1e5,1E+5,1e-5,18446744073709551615,-9223372036854775808,)"
          R"(1.7976931348623157e308,5e-324,0.1000000000000000055511151231257827021181583404541015625]})"));
  std::vector<BodySlabs> alike;
  for (const char* name : {"a", "A", "a ", "\xC3\xA9", "e\xCC\x81"}) {
    alike.push_back({name, simplex(1, {2.0 * static_cast<double>(alike.size()), 0, 0, 0})});
  }
  cases.add("head-names-that-look-alike", "Names that differ in case, in a space, in composition.")
      .of(alike)
      .shows({"json", "unicode"})
      .slicedAt({0.5})
      .encloses(5.0 / 24, [](double t) { return 5 * simplexSlice(t); });
}

}  // namespace

std::vector<AcceptedCase> validCases() {
  AcceptedCases cases(Validity::Valid);
  addShapes(cases);
  addSlabs(cases);
  addNumbers(cases);
  addCompression(cases);
  addAttributes(cases);
  addMeans(cases);
  addPoses(cases);
  addGrids(cases);
  addContainer(cases);
  addHeads(cases);
  addLimits(cases);
  return cases.finish();
}

}  // namespace t4d::conformance

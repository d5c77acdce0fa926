#include <algorithm>
#include <functional>
#include <limits>
#include <random>

#include <gmock/gmock.h>

#include "fixtures/pieces.h"
#include "fixtures/solids.h"
#include "formats/t4d/salvage.h"
#include "formats/t4d/test_slabs.h"
#include "model/parallel.h"
#include "t4d/check.h"
#include "t4d/file.h"
#include "t4d/mesh.h"
#include "t4d/sweep.h"

namespace t4d::formats {
namespace {

using model::Connectivity;
using model::Point4;
using model::Slab;
using testing::HasSubstr;

const T4dWriteOptions kAllOptions[] = {
    {3, false, true}, {0, false, true}, {19, false, false}, {3, true, true}, {0, true, false},
};

/// A slab as float32 stores it: positions are rounded, means are those of rounded positions.
Slab rounded(const Slab& slab) {
  Slab result = slab;
  for (Point4& vertex : result.vertices) {
    vertex.head<3>() = vertex.head<3>().cast<float>().cast<double>();
  }
  model::setMeans(*result.connectivity, result.vertices);
  return result;
}

void expectComesBack(const std::vector<std::vector<Slab>>& bodies, const T4dWriteOptions& options) {
  const auto path = writeT4d("round_trip.t4d", bodies, options);
  const auto checked = checkT4dFile(path);
  ASSERT_TRUE(checked) << checked.error().text();
  for (const T4dOpen how : {T4dOpen::Whole, T4dOpen::FromFront}) {
    auto reader = T4dReader::open(path, how);
    ASSERT_TRUE(reader) << reader.error().text();
    EXPECT_EQ(reader->indexed(), options.index);
    EXPECT_FALSE(reader->damage());
    ASSERT_EQ(reader->bodyCount(), bodies.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const model::Source& body = reader->body(i);
      const BodySummary& summary = reader->summary(i);
      ASSERT_EQ(body.slabCount(), bodies[i].size());
      EXPECT_EQ(summary.slabs, bodies[i].size());
      EXPECT_EQ(summary.time.begin, bodies[i].front().timeBegin);
      EXPECT_EQ(summary.time.end, bodies[i].back().timeEnd);
      std::uint64_t vertices = 0;
      std::uint64_t tetrahedra = 0;
      model::Bounds3 bounds;
      for (std::size_t k = 0; k < bodies[i].size(); ++k) {
        const auto slab = body.slab(k);
        ASSERT_TRUE(slab) << slab.error().text();
        const Slab expected = options.float32 ? rounded(bodies[i][k]) : bodies[i][k];
        EXPECT_TRUE(same(**slab, expected)) << "body " << i << ", slab " << k;
        EXPECT_EQ(body.timeSpan(k).begin, expected.timeBegin);
        EXPECT_EQ(body.timeSpan(k).end, expected.timeEnd);
        const Connectivity& connectivity = *expected.connectivity;
        vertices += connectivity.vertexCount - (k == 0 ? 0 : connectivity.lowerCount);
        tetrahedra += connectivity.cells.size();
        for (const Point4& vertex : expected.vertices) bounds.add(vertex.head<3>());
      }
      EXPECT_EQ(summary.vertices, vertices);
      EXPECT_EQ(summary.tetrahedra, tetrahedra);
      EXPECT_EQ(summary.bounds.min, bounds.min);
      EXPECT_EQ(summary.bounds.max, bounds.max);
      // The slabs are the same in any other order, too.
      for (std::size_t k = bodies[i].size(); k-- > 0;) {
        const auto slab = body.slab(k);
        ASSERT_TRUE(slab) << slab.error().text();
        EXPECT_TRUE(same(**slab, options.float32 ? rounded(bodies[i][k]) : bodies[i][k]));
      }
    }
  }
}

/// A slab with layers of `layer` vertices, as many inside, and cells of random vertices.
Slab randomSlab(unsigned seed, std::uint32_t layer, std::size_t cells, double begin,
                std::span<const Point4> lower) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  auto connectivity = std::make_shared<Connectivity>();
  connectivity->vertexCount = 3 * layer;
  connectivity->lowerCount = layer;
  connectivity->upperCount = layer;
  std::uniform_int_distribution<std::uint32_t> vertex(0, 3 * layer - 4);
  for (std::size_t i = 0; i < cells; ++i) {
    const std::uint32_t v = vertex(random);
    connectivity->cells.push_back({v, v + 1, v + 2, v + 3});
  }
  Slab slab{begin, begin + 1, {}, connectivity, {}};
  for (std::uint32_t i = 0; i < 3 * layer; ++i) {
    const double time = i < layer ? 0 : i < 2 * layer ? std::abs(number(random)) : 1;
    slab.vertices.emplace_back(number(random), number(random), number(random), begin + time);
  }
  std::ranges::copy(lower, slab.vertices.begin());
  return slab;
}

TEST(T4dWriter, ASlabInPiecesGivesTheSameBytesAsAWholeOne) {
  constexpr std::uint32_t kLayer = 70'000;
  const Slab first = randomSlab(1, kLayer, 200'000, 5, {});
  const Slab second = randomSlab(2, kLayer, 65'536, 6, first.upperLayer());
  for (const T4dWriteOptions& options : kAllOptions) {
    std::vector<std::string> bytes;
    for (const bool whole : {true, false}) {
      const auto path = temporaryPath("pieces.t4d");
      Metadata metadata;
      metadata.bodies = {{"body"}};
      auto writer = T4dWriter::create(path, metadata, options);
      ASSERT_TRUE(writer);
      for (const Slab* slab : {&first, &second}) {
        const auto put = whole ? writer->body(0).put(*slab)
                               : writer->body(0).putStreamed(fixtures::Pieces(*slab));
        ASSERT_TRUE(put) << put.error().text();
      }
      ASSERT_TRUE(writer->finish());
      bytes.push_back(platform::contents(path));
    }
    EXPECT_TRUE(bytes[0] == bytes[1]) << options.compression;
  }
}

TEST(T4dWriter, RefusesASlabInPiecesForWhatItWouldRefuseWhole) {
  const Slab good = randomSlab(3, 70'000, 70'000, 0, {});
  const auto errorOf = [&](auto change, bool second = false) {
    Slab bad = second ? randomSlab(4, 70'000, 10, 1, good.upperLayer()) : good;
    auto connectivity = *bad.connectivity;
    change(bad, connectivity);
    bad.connectivity = std::make_shared<Connectivity>(std::move(connectivity));
    std::vector<std::string> texts;
    for (const bool whole : {true, false}) {
      Metadata metadata;
      metadata.bodies = {{"body"}};
      auto writer = T4dWriter::create(temporaryPath("bad_pieces.t4d"), metadata);
      EXPECT_TRUE(!second || writer->body(0).put(good));
      const auto put =
          whole ? writer->body(0).put(bad) : writer->body(0).putStreamed(fixtures::Pieces(bad));
      texts.push_back(put ? "accepted" : put.error().text());
    }
    EXPECT_EQ(texts[0], texts[1]);
    return texts[1];
  };
  EXPECT_THAT(errorOf([](Slab&, Connectivity& c) { c.cells[66'000][2] = 210'000; }),
              HasSubstr("slab 0: cell 66000 has the vertex 210000, of 210000"));
  EXPECT_THAT(errorOf([](Slab&, Connectivity& c) { c.cells[66'000][2] = c.cells[66'000][0]; }),
              HasSubstr("twice"));
  EXPECT_THAT(errorOf([](Slab& s, Connectivity&) { s.vertices[69'999][3] = 0.5; }),
              HasSubstr("vertex 69999 of the lower layer is at time 0.5, not 0"));
  EXPECT_THAT(errorOf([](Slab& s, Connectivity&) { s.vertices[139'999][1] = NAN; }),
              HasSubstr("vertex 139999 is ("));
  EXPECT_THAT(errorOf([](Slab& s, Connectivity&) { s.vertices[69'999][2] += 1e-9; }, true),
              HasSubstr("slab 1: its lower layer is not the upper layer of the one before"));
  EXPECT_THAT(errorOf([](Slab& s, Connectivity&) { s.vertices[5][0] += 0.0; }, true), "accepted");
}

TEST(T4dWriter, WritesRandomSlabsThatComeBackBitForBit) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    RandomSlabs random(seed);
    std::vector<std::vector<Slab>> bodies;
    for (unsigned i = 0; i <= seed % 3; ++i) {
      bodies.push_back(random.make(1 + static_cast<int>((seed + i) % 7)));
    }
    expectComesBack(bodies, kAllOptions[seed % std::size(kAllOptions)]);
  }
}

TEST(T4dWriter, WritesOneSlabWithoutLayersAndAnEmptyOne) {
  Slab nothing;
  nothing.connectivity = std::make_shared<Connectivity>();
  for (const T4dWriteOptions& options : kAllOptions) {
    expectComesBack({{simplexSlab()}}, options);
    expectComesBack({{nothing}}, options);
  }
}

model::Mesh sweptTorus() {
  model::ScrewRun run;
  run.duration = 4;
  run.screw.angleDegrees = 130;
  run.screw.translation = {1, 2, 3};
  const auto motion = model::chainScrews(-1, std::span(&run, 1));
  EXPECT_TRUE(motion);
  mesh4d::SweepOptions options;
  options.caps = mesh4d::CapMethod::Cone;
  model::Mesh mesh;
  const auto swept = mesh4d::sweep(fixtures::torus(3, 1, 24, 12), *motion, options, mesh);
  EXPECT_TRUE(swept) << swept.error().text();
  return mesh;
}

TEST(T4dWriter, WritesSweepsThatComeBackBitForBitAndStayClosed) {
  model::Mesh mesh = sweptTorus();
  ASSERT_GT(mesh.slabCount(), 5u);
  const std::vector<Slab> posed(mesh.slabs().begin(), mesh.slabs().end());
  std::vector<Slab> stored = posed;
  for (Slab& slab : stored) slab.upperPose = nullptr;
  for (const T4dWriteOptions& options : kAllOptions) {
    // A pose in float32 is rounded twice; see below.
    const std::vector<Slab>& slabs = options.float32 ? stored : posed;
    expectComesBack({slabs, slabs}, options);
    auto reader = T4dReader::open(writeT4d("sweep.t4d", {slabs}, options));
    ASSERT_TRUE(reader) << reader.error().text();
    const auto report = measure::checkMesh(reader->body(0));
    ASSERT_TRUE(report) << report.error().text();
    EXPECT_TRUE(report->closed && report->oriented);
    EXPECT_EQ(report->vertices, reader->summary(0).vertices);
    EXPECT_EQ(report->tetrahedra, reader->summary(0).tetrahedra);
  }
}

TEST(T4dWriter, StoresSharedConnectivityAndLayersOnceAndMeansNotAtAll) {
  model::Mesh mesh = sweptTorus();
  const std::vector<Slab> slabs(mesh.slabs().begin(), mesh.slabs().end());
  const std::string bytes = platform::contents(writeT4d("shared.t4d", {slabs}, {0, false, true}));
  std::size_t connectivities = 0;
  std::size_t layers = 0;
  std::uint64_t smallest = bytes.size();
  for (const ChunkHeader& chunk : listChunks(bytes)) {
    connectivities += chunk.name() == "CONN" ? 1 : 0;
    layers += chunk.name() == "LAYR" || chunk.name() == "POSE" ? 1 : 0;
    if (chunk.name() == "SLAB") smallest = std::min(smallest, chunk.payloadBytes);
  }
  EXPECT_EQ(smallest, 56u + 2 * t4d_layout::kArrayHeaderBytes);  // two arrays without rows
  EXPECT_EQ(connectivities, 3u);                                 // start cap, all steps, end cap
  EXPECT_EQ(layers, slabs.size() - 1);
}

TEST(T4dWriter, MakesSweptMeshesTwentyTimesSmallerThanTheirArrays) {
  model::Mesh mesh = sweptTorus();
  const std::vector<Slab> slabs(mesh.slabs().begin(), mesh.slabs().end());
  std::size_t raw = 0;
  for (const Slab& slab : slabs) {
    raw += slab.vertices.size() * sizeof(Point4) +
           slab.connectivity->cells.size() * (sizeof(model::Cell) + 5);
  }
  EXPECT_LT(platform::contents(writeT4d("small.t4d", {slabs})).size() * 20, raw);
}

TEST(T4dWriter, StoresTheSameBytesTwice) {
  const std::vector<Slab> slabs = RandomSlabs(5).make(6);
  EXPECT_EQ(platform::contents(writeT4d("a.t4d", {slabs})),
            platform::contents(writeT4d("b.t4d", {slabs})));
}

TEST(T4dWriter, StoresTheSameBytesWithAnyNumberOfThreads) {
  std::vector<model::Mesh> meshes = {sweptTorus()};
  for (const unsigned seed : {1U, 2U, 3U}) {
    meshes.emplace_back();
    for (const Slab& slab : RandomSlabs(seed).make(40)) ASSERT_TRUE(meshes.back().put(slab));
  }
  std::vector<T4dWriteOptions> all(std::begin(kAllOptions), std::end(kAllOptions));
  all.push_back({.step = 1e-3});
  all.push_back({.spareEvery = 3});
  for (const model::Mesh& mesh : meshes) {
    for (const T4dWriteOptions& options : all) {
      const auto written = [&](const model::Source& source, std::size_t threads) {
        const model::ThreadLimit control(threads);
        const auto path = temporaryPath("threads.t4d");
        auto writer = T4dWriter::create(path, metadataOf({"body 0"}), options);
        EXPECT_TRUE(writer);
        const auto pumped = pump(source, writer->body(0));
        EXPECT_TRUE(pumped) << pumped.error().text();
        EXPECT_TRUE(writer->finish());
        return platform::contents(path);
      };
      const std::vector<Slab> slabs(mesh.slabs().begin(), mesh.slabs().end());
      const auto path = writeT4d("one_by_one.t4d", {slabs}, options);
      const std::string bytes = platform::contents(path);
      for (const std::size_t threads : {1U, 2U, 5U}) EXPECT_EQ(written(mesh, threads), bytes);
      // What is read is written again as it was; rounded poses are rounded once more.
      if (options.float32 || options.step) continue;
      const auto reader = T4dReader::open(path);
      ASSERT_TRUE(reader) << reader.error().text();
      for (const std::size_t threads : {1U, 5U})
        EXPECT_EQ(written(reader->body(0), threads), bytes);
    }
  }
}

std::string refusal(const std::vector<Slab>& slabs, const T4dWriteOptions& options = {}) {
  const auto path = temporaryPath("refused.t4d");
  std::filesystem::remove(path);
  auto writer = T4dWriter::create(path, metadataOf({"b"}), options);
  EXPECT_TRUE(writer);
  for (const Slab& slab : slabs) {
    const auto put = writer->body(0).put(slab);
    if (put) continue;
    // What has failed cannot be finished: the file would look whole.
    const auto finished = writer->finish();
    EXPECT_FALSE(finished);
    EXPECT_FALSE(std::filesystem::exists(path));
    return put.error().text();
  }
  return {};
}

/// A slab with a lower layer of 3, an interior of 2 and a mean, an upper layer of 3.
Slab slabOfAll() {
  auto connectivity = std::make_shared<Connectivity>();
  connectivity->vertexCount = 9;
  connectivity->lowerCount = 3;
  connectivity->upperCount = 3;
  connectivity->means.add(std::vector<std::uint32_t>{0, 1, 8});
  connectivity->cells = {{0, 1, 2, 5}, {8, 7, 6, 3}};
  Slab slab;
  slab.timeBegin = 1;
  slab.timeEnd = 2;
  for (int i = 0; i < 9; ++i)
    slab.vertices.push_back({0.1 * i, 0.3, -0.7 * i, i < 3 ? 1. : i < 6 ? 1.5 : 2.});
  slab.connectivity = connectivity;
  model::setMeans(*connectivity, slab.vertices);
  return slab;
}

Slab after(const Slab& slab) {
  Slab next = slab;
  next.timeBegin = slab.timeEnd;
  next.timeEnd = slab.timeEnd + 1;
  for (std::size_t i = 0; i < 9; ++i) next.vertices[i][3] += 1;
  std::copy(slab.upperLayer().begin(), slab.upperLayer().end(), next.vertices.begin());
  model::setMeans(*next.connectivity, next.vertices);
  return next;
}

TEST(T4dWriter, RefusesSlabsThatAreNotSound) {
  const auto refusalOf = [](const std::function<void(Slab&)>& change,
                            const T4dWriteOptions& options = {}) {
    Slab slab = slabOfAll();
    change(slab);
    return refusal({slab}, options);
  };
  const auto withConnectivity = [&](const std::function<void(Connectivity&)>& change) {
    return refusalOf([&](Slab& slab) {
      auto connectivity = std::make_shared<Connectivity>(*slab.connectivity);
      change(*connectivity);
      slab.connectivity = connectivity;
    });
  };
  EXPECT_EQ(refusalOf([](Slab&) {}), "");
  EXPECT_THAT(refusalOf([](Slab& s) { s.connectivity = nullptr; }), HasSubstr("no connectivity"));
  EXPECT_THAT(refusalOf([](Slab& s) { s.vertices.pop_back(); }), HasSubstr("8 vertices"));
  EXPECT_THAT(refusalOf([](Slab& s) { s.vertices[4][1] = std::nan(""); }), HasSubstr("nan"));
  EXPECT_THAT(refusalOf([](Slab& s) { s.timeEnd = 0; }), HasSubstr("lasts from"));
  EXPECT_THAT(refusalOf([](Slab& s) { s.vertices[4][3] = 3; }), HasSubstr("outside"));
  EXPECT_THAT(refusalOf([](Slab& s) { s.vertices[0][3] = 1.25; }), HasSubstr("lower layer"));
  EXPECT_THAT(refusalOf([](Slab& s) { s.vertices[8][3] = 1.25; }), HasSubstr("upper layer"));
  EXPECT_THAT(withConnectivity([](Connectivity& c) { c.cells[0][0] = 9; }), HasSubstr("vertex 9"));
  EXPECT_THAT(withConnectivity([](Connectivity& c) { c.means.sources[0] = 5; }), HasSubstr("mean"));
  EXPECT_THAT(withConnectivity([](Connectivity& c) {
                c.cellAttributes = {model::makeAttribute<int>("a", model::Domain::Cell, {1})};
              }),
              HasSubstr("'a'"));
  EXPECT_THAT(refusalOf([](Slab& s) {
                s.attributes = {model::makeAttribute<int>("a\xff", model::Domain::Cell, {1, 2})};
              }),
              HasSubstr("UTF-8"));
  EXPECT_THAT(
      refusalOf([](Slab& s) {
        s.attributes.push_back({"wide", model::Domain::Cell, model::ScalarType::UInt8, 256, {}});
        s.attributes[0].values.resize(512);
      }),
      HasSubstr("'wide' cannot be stored"));
  EXPECT_THAT(refusalOf([](Slab& s) { s.vertices[4][1] = 1e39; }, {3, true, true}),
              HasSubstr("too large"));
}

TEST(T4dWriter, RefusesSeamsThatDifferInOneBit) {
  const Slab first = slabOfAll();
  EXPECT_EQ(refusal({first, after(first)}), "");
  for (std::size_t vertex = 0; vertex < 3; ++vertex) {
    for (int axis = 0; axis < 3; ++axis) {
      Slab second = after(first);
      double& number = second.vertices[vertex][axis];
      number = std::nextafter(number, 100);
      model::setMeans(*second.connectivity, second.vertices);
      EXPECT_THAT(refusal({first, second}), HasSubstr("slab 1: its lower layer is not the upper"));
    }
  }
  Slab late = after(first);
  late.timeBegin = 2.5;
  for (std::size_t i = 0; i < 3; ++i) late.vertices[i][3] = 2.5;
  model::setMeans(*late.connectivity, late.vertices);
  EXPECT_THAT(refusal({first, late}), HasSubstr("begins at time 2.5"));
  EXPECT_THAT(refusal({simplexSlab(), simplexSlab()}), HasSubstr("begins at time 0"));
}

TEST(T4dWriter, RefusesMeansThatAreNot) {
  for (int axis = 0; axis < 4; ++axis) {
    Slab slab = slabOfAll();
    slab.vertices[5][axis] = std::nextafter(slab.vertices[5][axis], 1.4);
    EXPECT_THAT(refusal({slab}), HasSubstr("not the mean"));
  }
  Slab huge = slabOfAll();
  for (Point4& vertex : huge.vertices) vertex[0] = 1e308;
  EXPECT_THAT(refusal({huge}), HasSubstr("not the mean"));  // their sum is infinite
}

TEST(T4dWriter, StoresAttributesOfALayerOnceAndThoseOfMeansNot) {
  const auto sizeWith = [](std::size_t bytes) {
    Slab first = slabOfAll();
    first.attributes = {
        {"a", model::Domain::Vertex, model::ScalarType::UInt8, 255, std::vector<std::byte>(bytes)}};
    Slab second = after(first);
    const auto path = writeT4d("attributes.t4d", {{first, second}}, {.compression = 0});
    return std::filesystem::file_size(path);
  };
  Slab bare = slabOfAll();
  const auto path = writeT4d("bare.t4d", {{bare, after(bare)}}, {.compression = 0});
  // Three layers of three vertices and two interiors of two have a record of 32 bytes and a block,
  // of which an entry of the table takes 8; two means have nothing.
  const std::size_t rows = 3 * t4d_layout::padded(3 * 255) + 2 * t4d_layout::padded(2 * 255);
  EXPECT_EQ(sizeWith(std::size_t{9} * 255),
            std::filesystem::file_size(path) + rows + std::size_t{5} * (32 + 8));
}

TEST(T4dWriter, RefusesAttributesThatDifferAtALayerOrThatMeansDoNotInherit) {
  Slab first = slabOfAll();
  first.attributes = {
      model::makeAttribute<float>("warmth", model::Domain::Vertex, {1, 2, 3, 4, 5, 0, 7, 8, 9}),
      model::makeAttribute<int>("zone", model::Domain::Vertex, {4, 2, 3, 4, 5, 0, 4, 2, 3})};
  for (model::Attribute& attribute : first.attributes) setMeans(*first.connectivity, attribute);
  const auto nextWith = [&](const std::function<void(Slab&)>& change) {
    Slab next = after(first);
    next.attributes = {
        model::makeAttribute<float>("warmth", model::Domain::Vertex, {7, 8, 9, 4, 5, 0, 7, 8, 9}),
        model::makeAttribute<int>("zone", model::Domain::Vertex, {4, 2, 3, 4, 5, 0, 4, 2, 3})};
    for (model::Attribute& attribute : next.attributes) setMeans(*next.connectivity, attribute);
    change(next);
    return refusal({first, next});
  };
  EXPECT_EQ(nextWith([](Slab&) {}), "");
  EXPECT_THAT(nextWith([](Slab& s) { s.attributes[1].values[8] ^= std::byte{1}; }),
              HasSubstr("slab 1: the attribute 'zone' of its lower layer"));
  EXPECT_THAT(nextWith([](Slab& s) { s.attributes.pop_back(); }),
              HasSubstr("attributes 'warmth', those of the one before 'warmth', 'zone'"));
  EXPECT_THAT(nextWith([](Slab& s) { std::swap(s.attributes[0], s.attributes[1]); }),
              HasSubstr("order have to be the same"));
  EXPECT_THAT(nextWith([](Slab& s) { s.attributes[0].values[20] ^= std::byte{1}; }),
              HasSubstr("the attribute 'warmth' of a mean"));
}

/// The number of chunks of a type.
std::size_t chunksOf(const std::string& type, const std::filesystem::path& path) {
  return std::ranges::count(listChunks(platform::contents(path)), type, &ChunkHeader::name);
}

TEST(T4dWriter, StoresTheLayersOfASweepAsPosesThatGiveTheSameBits) {
  model::Mesh mesh = sweptTorus();
  const std::vector<Slab> slabs(mesh.slabs().begin(), mesh.slabs().end());
  for (const T4dWriteOptions& options : {T4dWriteOptions{}, T4dWriteOptions{.step = 0.25}}) {
    const auto path = writeT4d("poses.t4d", {slabs}, options);
    EXPECT_EQ(chunksOf("LAYR", path), 1U);
    EXPECT_EQ(chunksOf("POSE", path), slabs.size() - 2);
    const auto reader = T4dReader::open(path, T4dOpen::Checked);
    ASSERT_TRUE(reader) << reader.error().text();
    std::vector<Slab> read;
    for (std::size_t i = 1; i + 1 < slabs.size(); ++i) {
      read.push_back(**reader->body(0).slab(i));
      EXPECT_TRUE(same(read.back(), slabs[i])) << i;
    }
    // What has been read is as small when it is written again, with the last layer of another slab.
    EXPECT_EQ(chunksOf("LAYR", writeT4d("again.t4d", {read}, options)), 2U);
  }
  const auto single = writeT4d("single.t4d", {slabs}, {.float32 = true});
  EXPECT_EQ(chunksOf("LAYR", single), 1U);
  ASSERT_TRUE(checkT4dFile(single));
  const auto reader = T4dReader::open(single);
  std::vector<Slab> read;
  for (std::size_t i = 0; i < slabs.size(); ++i) {
    read.push_back(**reader->body(0).slab(i));
    for (std::size_t v = 0; v < slabs[i].lowerLayer().size(); ++v) {
      const model::Point3 vertex = read[i].vertices[v].head<3>();
      EXPECT_EQ(vertex, vertex.cast<float>().cast<double>());
      EXPECT_LT((vertex - slabs[i].vertices[v].head<3>()).norm(), 1e-6);
    }
  }
  // Numbers of float32 are stored as such, also where others are asked for.
  const auto same64 = writeT4d("same.t4d", {read});
  EXPECT_EQ(chunksOf("LAYR", same64), 1U);
  const auto again = T4dReader::open(same64);
  for (std::size_t i = 0; i < read.size(); ++i)
    EXPECT_TRUE(same(**again->body(0).slab(i), read[i]));
}

TEST(T4dWriter, DoesNotTrustAPose) {
  const Slab exact = slabOfAll();
  const auto reference = [&] {
    std::vector<model::Point3> points;
    for (const Point4& vertex : exact.upperLayer()) points.push_back(vertex.head<3>());
    return points;
  };
  const auto written = [&](std::vector<model::Point3> points, const model::Affine3x4& pose) {
    Slab slab = exact;
    slab.upperPose = std::make_shared<const model::LayerPose>(model::LayerPose{
        std::make_shared<const std::vector<model::Point3>>(std::move(points)), pose, false});
    const auto path = writeT4d("hint.t4d", {{slab}});
    const auto reader = T4dReader::open(path, T4dOpen::Checked);
    EXPECT_TRUE(same(**reader->body(0).slab(0), exact));
    return chunksOf("POSE", path);
  };
  model::Affine3x4 moved = model::Affine3x4::Identity();
  EXPECT_EQ(written(reference(), moved), 0U);  // the layer is the reference
  moved(1, 3) = 1e-9;
  EXPECT_EQ(written(reference(), moved), 0U);
  std::vector<model::Point3> other = reference();
  other[1][2] = std::nextafter(other[1][2], 0);
  EXPECT_EQ(written(other, model::Affine3x4::Identity()), 0U);
  other.pop_back();
  EXPECT_EQ(written(other, model::Affine3x4::Identity()), 0U);
  for (model::Point3& point : other = reference()) point *= 0.5;
  moved = model::Affine3x4::Identity() * 2;
  EXPECT_EQ(written(other, moved), 1U);
}

TEST(T4dWriter, RoundsToTheGrid) {
  for (const Point4& at : {Point4(0, 0, 0, 0), Point4(5e6, -7e12, 3, 0)}) {
    constexpr double kStep = 0.001;
    Slab slab = slabOfAll();
    for (Point4& vertex : slab.vertices) vertex += at;
    model::setMeans(*slab.connectivity, slab.vertices);
    const auto path = writeT4d("grid.t4d", {{slab, after(slab)}}, {.step = kStep});
    ASSERT_TRUE(checkT4dFile(path));
    const auto reader = T4dReader::open(path);
    std::vector<Slab> read;
    for (std::size_t i = 0; i < 2; ++i) read.push_back(**reader->body(0).slab(i));
    for (std::size_t v = 0; v < slab.vertices.size(); ++v) {
      const Point4 off = read[0].vertices[v] - slab.vertices[v];
      EXPECT_LE(off.cwiseAbs().maxCoeff(), kStep / 2 * (1 + 1e-6) + 1e-3 * (at[1] < -1e12));
      EXPECT_EQ(off[3], 0);
    }
    // Positions on the grid stay there.
    const auto again = T4dReader::open(writeT4d("again.t4d", {read}, {.step = kStep}));
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_TRUE(same(**again->body(0).slab(i), read[i]));
    }
  }
  Slab far = slabOfAll();
  far.vertices[1][0] = 1e7;
  model::setMeans(*far.connectivity, far.vertices);
  EXPECT_THAT(refusal({far}, {.step = 1e-3}), HasSubstr("use a larger step"));
  const auto path = temporaryPath("refused.t4d");
  EXPECT_FALSE(T4dWriter::create(path, metadataOf({"b"}), {.step = 0}));
  EXPECT_FALSE(T4dWriter::create(path, metadataOf({"b"}), {.float32 = true, .step = 1}));
}

TEST(T4dWriter, RefusesBodiesThatAreNotWellNamedAndBodiesWithoutSlabs) {
  const auto path = temporaryPath("bodies.t4d");
  for (const std::vector<std::string>& names :
       {std::vector<std::string>{}, {""}, {"a", "a"}, {std::string(256, 'x')}}) {
    EXPECT_FALSE(T4dWriter::create(path, metadataOf(names)));
  }
  Metadata metadata = metadataOf({"a"});
  metadata.detailsJson = "[]";
  EXPECT_FALSE(T4dWriter::create(path, metadata));
  metadata.detailsJson = "{\"a\":\"" + std::string(t4d_layout::kMaxHeadBytes, 'x') + "\"}";
  EXPECT_FALSE(T4dWriter::create(path, metadata));
  auto writer = T4dWriter::create(path, metadataOf({"a", "b"}));
  ASSERT_TRUE(writer && writer->body(0).put(simplexSlab()));
  const auto finished = writer->finish();
  ASSERT_FALSE(finished);
  EXPECT_THAT(finished.error().message, HasSubstr("'b' has no slab"));
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(T4dWriter, LeavesNothingWithoutFinish) {
  const auto path = writeFile("old.t4d", "old");
  {
    auto writer = T4dWriter::create(path, metadataOf({"a"}));
    ASSERT_TRUE(writer && writer->body(0).put(simplexSlab()));
    T4dWriter moved = std::move(*writer);
  }
  EXPECT_EQ(platform::contents(path), "old");
  std::size_t parts = 0;
  for (const auto& entry : std::filesystem::directory_iterator(path.parent_path())) {
    parts += entry.path().string().ends_with(".part") ? 1 : 0;
  }
  EXPECT_EQ(parts, 0u);
}

TEST(T4dWriter, DoesNotFinishOnAFullDisk) {
  auto writer = T4dWriter::create("/dev/full", metadataOf({"a"}), {0, false, true});
  ASSERT_TRUE(writer);
  EXPECT_TRUE(writer->body(0).put(simplexSlab()));
  const auto finished = writer->finish();
  ASSERT_FALSE(finished);
  EXPECT_THAT(finished.error().text(), HasSubstr("No space left"));
}

TEST(T4dWriter, SpareCopiesBoundWhatDamageToAPartCosts) {
  constexpr std::uint64_t kEvery = 3;
  const model::Mesh mesh = sweptTorus();
  const std::vector<Slab> slabs(mesh.slabs().begin(), mesh.slabs().end());
  const auto path = writeT4d("spare.t4d", {slabs}, {.spareEvery = kEvery});
  const auto checked = checkT4dFile(path);
  ASSERT_TRUE(checked) << checked.error().text();
  const std::string bytes = platform::contents(path);
  std::size_t parts = 0;
  for (const ChunkHeader& chunk : listChunks(bytes)) {
    if (chunk.type != t4d_layout::kConnectivity && chunk.type != t4d_layout::kLayer) continue;
    ++parts;
    std::string damaged = bytes;
    damaged[chunk.end() - t4d_layout::kAlignment] ^= 1;
    const auto salvage = T4dSalvage::open(writeFile("damaged.t4d", damaged));
    ASSERT_TRUE(salvage) << salvage.error().text();
    EXPECT_LT(salvage->slabsSaved(), mesh.slabCount());
    EXPECT_GE(salvage->slabsSaved() + kEvery, mesh.slabCount()) << chunk.name();
  }
  EXPECT_GE(parts, 2 * mesh.slabCount() / kEvery);
  EXPECT_FALSE(T4dWriter::create(temporaryPath("one.t4d"), {}, {.spareEvery = 1}));
}

TEST(T4dWriter, StoresConnectivityAgainThatIsTooFarBackToBeNamed) {
  // Connectivity k has k vertices more than a simplex.
  std::vector<std::shared_ptr<Connectivity>> all;
  const auto connectivities = [&](std::size_t different) {
    std::vector<Slab> slabs;
    for (std::size_t i = 0; i <= different; ++i) {
      const std::size_t k = i % different;
      Slab slab = simplexSlab();
      if (k == all.size()) {
        all.push_back(std::make_shared<Connectivity>(*slab.connectivity));
        all.back()->vertexCount += static_cast<std::uint32_t>(k);
      }
      slab.connectivity = all[k];
      slab.vertices.resize(slab.vertices.size() + k, slab.vertices[0]);
      slab.timeBegin += static_cast<double>(i);
      slab.timeEnd += static_cast<double>(i);
      for (Point4& vertex : slab.vertices) vertex[3] += static_cast<double>(i);
      slabs.push_back(std::move(slab));
    }
    const auto path = writeT4d("far.t4d", {slabs}, {});
    const auto checked = checkT4dFile(path);
    EXPECT_TRUE(checked) << checked.error().text();
    const std::vector<ChunkHeader> chunks = listChunks(platform::contents(path));
    return std::ranges::count(chunks, t4d_layout::kConnectivity, &ChunkHeader::type);
  };
  EXPECT_EQ(connectivities(16), 16);
  EXPECT_EQ(connectivities(17), 18);
}

}  // namespace
}  // namespace t4d::formats

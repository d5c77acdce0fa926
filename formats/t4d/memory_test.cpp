#include <atomic>
#include <cstdlib>
#include <functional>
#include <new>

#include <fmt/format.h>
#include <malloc.h>

#include "formats/t4d/array_codec.h"
#include "formats/t4d/test_slabs.h"

/// Tests how much memory a file can make its reader ask for. This program counts bytes on the heap.
namespace {

std::atomic<std::size_t> heapBytes = 0;
std::atomic<std::size_t> heapPeak = 0;

void* counted(std::size_t size) {
  void* block = std::malloc(size);
  if (block == nullptr) throw std::bad_alloc();
  heapBytes += ::malloc_usable_size(block);
  if (heapBytes > heapPeak) heapPeak = heapBytes.load();
  return block;
}

void uncounted(void* block) {
  heapBytes -= ::malloc_usable_size(block);
  std::free(block);
}

}  // namespace

void* operator new(std::size_t size) { return counted(size); }
void* operator new[](std::size_t size) { return counted(size); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return counted(size); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return counted(size); }
void operator delete(void* block) noexcept { uncounted(block); }
void operator delete[](void* block) noexcept { uncounted(block); }
void operator delete(void* block, std::size_t) noexcept { uncounted(block); }
void operator delete[](void* block, std::size_t) noexcept { uncounted(block); }

namespace t4d::formats {
namespace {

using t4d_layout::PayloadWriter;

/// The most bytes on the heap at a time during `work`.
std::size_t peakOf(const std::function<void()>& work) {
  const std::size_t before = heapBytes;
  heapPeak = before;
  work();
  return heapPeak - before;
}

struct Layout {
  std::uint32_t vertices = 0;
  std::uint32_t lower = 0;
  std::uint32_t upper = 0;
  std::uint32_t means = 0;
  std::uint32_t attributes = 0;
};

void putLayout(PayloadWriter& payload, const Layout& layout) {
  for (const std::uint32_t number :
       {layout.vertices, layout.lower, layout.upper, layout.means, layout.attributes, 0U}) {
    payload.put(number);
  }
}

/// `rows` rows, compressed as far as the format allows.
void putZeros(PayloadWriter& payload, model::ScalarType type, std::uint8_t components,
              std::size_t rows) {
  const std::vector<std::byte> zeros(rows * components * model::scalarSize(type));
  putArray(payload, {type, components, zeros}, 3);
}

PayloadWriter slabPayload(const SlabParts& parts, std::uint32_t attributes) {
  PayloadWriter payload;
  payload.put(0.0);
  payload.put(0.0);
  payload.put(parts.connectivity);
  payload.put(parts.lower);
  payload.put(parts.upper);
  payload.put(parts.body);
  payload.put(attributes);
  payload.put(std::uint64_t{0});
  return payload;
}

constexpr const char* kHead = R"({"features":["zstd","means"],"bodies":[{"name":"b"}]})";

struct Hostile {
  std::string name;
  std::string bytes;
};

Hostile finished(std::string name, FileBuilder& file, std::uint64_t slabs) {
  Done done;
  done.chunks = file.chunks();
  done.bodies.resize(1);
  done.bodies[0].slabs = slabs;
  file.put(t4d_layout::kDone, encodeDone(done));
  return {std::move(name), file.bytes()};
}

SlabParts putConnectivity(FileBuilder& file, const Layout& layout,
                          const std::function<void(PayloadWriter&)>& rest = {}) {
  PayloadWriter payload;
  putLayout(payload, layout);
  if (rest) {
    rest(payload);
  } else {
    putZeros(payload, model::ScalarType::UInt32, 4, 0);
  }
  SlabParts parts;
  parts.connectivity = file.put(t4d_layout::kConnectivity, payload);
  return parts;
}

std::vector<Hostile> hostileFiles() {
  constexpr std::uint32_t kMany = 400'000;
  std::vector<Hostile> files;
  for (const auto type : {model::ScalarType::Float32, model::ScalarType::Float64}) {
    FileBuilder file(kHead);
    const SlabParts parts = putConnectivity(file, {kMany});
    for (int i = 0; i < 2; ++i) {
      PayloadWriter slab = slabPayload(file.fromHere(parts), 0);
      putZeros(slab, type, 3, kMany);
      putZeros(slab, model::ScalarType::Float64, 1, kMany);
      file.put(t4d_layout::kSlab, slab);
    }
    files.push_back(finished("interior", file, 2));
  }
  for (const auto type : {model::ScalarType::Float32, model::ScalarType::Float64}) {
    FileBuilder file(kHead);
    SlabParts parts = putConnectivity(file, {2 * kMany, kMany, kMany});
    PayloadWriter layer;
    layer.put(0.0);
    layer.put(std::uint64_t{0});
    putZeros(layer, type, 3, kMany);
    parts.lower = parts.upper = file.put(t4d_layout::kLayer, layer);
    for (int i = 0; i < 3; ++i) {
      PayloadWriter slab = slabPayload(file.fromHere(parts), 0);
      putZeros(slab, type, 3, 0);
      putZeros(slab, model::ScalarType::Float64, 1, 0);
      file.put(t4d_layout::kSlab, slab);
    }
    files.push_back(finished("one layer below and above", file, 3));
  }
  {
    FileBuilder file(kHead);
    auto connectivity = std::make_shared<model::Connectivity>();
    connectivity->vertexCount = 4;
    connectivity->cells.assign(kMany, {0, 1, 2, 3});
    model::Slab slab;
    slab.connectivity = connectivity;
    slab.vertices.assign(4, model::Point4::Zero());
    SlabParts parts;
    parts.connectivity =
        file.put(t4d_layout::kConnectivity, encodeConnectivity(*connectivity, {3, false}));
    file.put(t4d_layout::kSlab, encodeSlab(slab, file.fromHere(parts), {3, false}));
    files.push_back(finished("cells", file, 1));
  }
  {
    FileBuilder file(kHead);
    const SlabParts parts =
        putConnectivity(file, {kMany + 1, 0, 0, kMany}, [](PayloadWriter& payload) {
          putZeros(payload, model::ScalarType::UInt32, 4, 0);
          const std::vector<std::uint32_t> sizes(kMany, 1);
          putArray(payload, viewOf(sizes), 3);
          putZeros(payload, model::ScalarType::UInt32, 1, kMany);
        });
    PayloadWriter slab = slabPayload(file.fromHere(parts), 0);
    putZeros(slab, model::ScalarType::Float64, 3, 1);
    putZeros(slab, model::ScalarType::Float64, 1, 1);
    file.put(t4d_layout::kSlab, slab);
    files.push_back(finished("means", file, 1));
  }
  {
    FileBuilder file(kHead);
    const SlabParts parts = putConnectivity(file, {});
    constexpr std::uint32_t kAttributes = 20'000;
    PayloadWriter slab = slabPayload(file.fromHere(parts), kAttributes);
    putZeros(slab, model::ScalarType::Float64, 3, 0);
    putZeros(slab, model::ScalarType::Float64, 1, 0);
    for (std::uint32_t i = 0; i < kAttributes; ++i) {
      slab.put(std::uint32_t{2});
      const std::string name = std::to_string(i);
      slab.put(static_cast<std::uint32_t>(name.size()));
      slab.putBytes(name.data(), name.size());
      slab.pad();
      putZeros(slab, model::ScalarType::UInt8, 1, 0);
    }
    file.put(t4d_layout::kSlab, slab);
    files.push_back(finished("many attributes", file, 1));
  }
  {
    FileBuilder file(kHead);
    const SlabParts parts = putConnectivity(file, {kMany});
    PayloadWriter slab = slabPayload(file.fromHere(parts), 3);
    putZeros(slab, model::ScalarType::Float32, 3, kMany);
    putZeros(slab, model::ScalarType::Float64, 1, kMany);
    for (std::uint32_t i = 0; i < 3; ++i) {
      slab.put(std::uint32_t{1});
      slab.put(std::uint32_t{1});
      slab.put(std::uint64_t{'a' + i});
      putZeros(slab, model::ScalarType::UInt8, 200, kMany);
    }
    file.put(t4d_layout::kSlab, slab);
    files.push_back(finished("large attributes", file, 1));
  }
  {
    std::string head = R"({"features":[],"bodies":[{"name":"b"}],"details":{"a":[)";
    for (int i = 0; i < 60'000; ++i) head += "[],";
    FileBuilder file(head + "0]}}");
    files.push_back({"deep head", file.bytes()});
  }
  {
    std::string head = R"({"features":[],"bodies":[)";
    for (int i = 0; i < 60'000; ++i) head += fmt::format(R"({{"name":"{}"}},)", i);
    FileBuilder file(head + R"({"name":"a"}]})");
    files.push_back({"many bodies", file.bytes()});
  }
  {
    FileBuilder file(kHead);
    const SlabParts parts = putConnectivity(file, {});
    for (int i = 0; i < 20'000; ++i) {
      PayloadWriter slab = slabPayload(file.fromHere(parts), 0);
      putZeros(slab, model::ScalarType::Float64, 3, 0);
      putZeros(slab, model::ScalarType::Float64, 1, 0);
      file.put(t4d_layout::kSlab, slab);
    }
    files.push_back(finished("many slabs", file, 20'000));
  }
  return files;
}

std::size_t allowedFor(const std::string& bytes) {
  return T4dReader::kMemoryPerFileByte * bytes.size() + T4dReader::kMemoryAlways;
}

TEST(T4dReader, KeepsToItsMultipleOfTheFileInMemory) {
  for (const Hostile& hostile : hostileFiles()) {
    const auto path = writeFile("hostile.t4d", hostile.bytes);
    for (const T4dOpen how : {T4dOpen::Whole, T4dOpen::FromFront}) {
      std::string fault;
      const std::size_t peak = peakOf([&] { fault = faultOf(path, how); });
      EXPECT_LE(peak, allowedFor(hostile.bytes)) << hostile.name;
      // Refused too early, a file would show nothing.
      EXPECT_TRUE(fault.empty() || fault.ends_with("it is truncated")) << hostile.name << fault;
    }
  }
}

TEST(T4dReader, RefusesMoreAttributesOfMeansThanTheFileMayRequest) {
  constexpr std::uint32_t kMeans = 400'000;
  FileBuilder file(kHead);
  const SlabParts parts =
      putConnectivity(file, {kMeans + 1, 0, 0, kMeans}, [](PayloadWriter& payload) {
        putZeros(payload, model::ScalarType::UInt32, 4, 0);
        putArray(payload, viewOf(std::vector<std::uint32_t>(kMeans, 1)), 3);
        putZeros(payload, model::ScalarType::UInt32, 1, kMeans);
      });
  PayloadWriter slab = slabPayload(file.fromHere(parts), 1);
  putZeros(slab, model::ScalarType::Float64, 3, 1);
  putZeros(slab, model::ScalarType::Float64, 1, 1);
  slab.put(std::uint32_t{1});
  slab.put(std::uint32_t{1});
  slab.put(std::uint64_t{'a'});
  putZeros(slab, model::ScalarType::Float64, 255, 1);
  file.put(t4d_layout::kSlab, slab);
  const Hostile hostile = finished("attributes of means", file, 1);
  const auto path = writeFile("hostile.t4d", hostile.bytes);
  std::string fault;
  const std::size_t peak = peakOf([&] { fault = faultOf(path, T4dOpen::FromFront); });
  EXPECT_LE(peak, allowedFor(hostile.bytes));
  EXPECT_NE(fault.find("400000 means with 2040 bytes each"), std::string::npos) << fault;
}

/// A file of this many slabs, each with its own connectivity and layers of many vertices.
std::filesystem::path longFile(int slabs) {
  constexpr std::uint32_t kLayer = 3000;
  constexpr std::uint32_t kCells = 10'000;
  const auto path = temporaryPath("long.t4d");
  auto writer = T4dWriter::create(path, metadataOf({"b"}));
  EXPECT_TRUE(writer);
  model::Slab slab;
  slab.vertices.assign(2 * std::size_t{kLayer}, model::Point4::Zero());
  for (int i = 0; i < slabs; ++i) {
    std::mt19937 random(static_cast<unsigned>(i));
    auto connectivity = std::make_shared<model::Connectivity>();
    connectivity->vertexCount = 2 * kLayer;
    connectivity->lowerCount = connectivity->upperCount = kLayer;
    for (std::uint32_t k = 0; k < kCells; ++k) {
      const auto first = static_cast<std::uint32_t>(random() % (2 * kLayer - 4));
      connectivity->cells.push_back({first, first + 1, first + 2, first + 3});
    }
    slab.connectivity = connectivity;
    slab.timeBegin = i;
    slab.timeEnd = i + 1;
    std::copy_n(slab.vertices.end() - kLayer, kLayer, slab.vertices.begin());
    for (auto vertex = slab.vertices.end() - kLayer; vertex != slab.vertices.end(); ++vertex) {
      *vertex << random(), random(), random(), i + 1;
    }
    EXPECT_TRUE(writer->body(0).put(slab));
  }
  EXPECT_TRUE(writer->finish());
  return path;
}

TEST(T4dStream, KeepsAWindowOfTheFileHoweverLongItIs) {
  const auto peakOfStream = [](int slabs) {
    const auto path = longFile(slabs);
    return peakOf([&] { EXPECT_EQ(streamFaultOf(path), ""); });
  };
  const std::size_t shorter = peakOfStream(50);
  const std::size_t longer = peakOfStream(500);
  EXPECT_LE(longer, shorter + 450 * 500) << shorter;
}

TEST(T4dReader, AsksForLittleMemoryWhereNumbersLie) {
  const std::string file =
      platform::contents(writeT4d("liar.t4d", {RandomSlabs(3).make(3)}, {0, false, true}));
  for (const ChunkHeader& chunk : listChunks(file)) {
    for (std::size_t at = chunk.payload(); at + 8 <= chunk.end(); at += 4) {
      for (const std::uint64_t lie : {~std::uint64_t{0}, std::uint64_t{1} << 40,
                                      std::uint64_t{0x7FFFFFFF}, std::uint64_t{file.size()}}) {
        std::string bytes = file;
        overwrite(bytes, at, lie);
        repairChecksums(bytes);
        const auto path = writeFile("liar.t4d", bytes);
        const std::size_t peak = peakOf([&] {
          faultOf(path);
          faultOf(path, T4dOpen::FromFront);
        });
        // Nothing in the file is compressed, so nothing expands.
        EXPECT_LE(peak, 16 * file.size() + T4dReader::kMemoryAlways) << chunk.name() << " " << at;
      }
    }
  }
}

}  // namespace
}  // namespace t4d::formats

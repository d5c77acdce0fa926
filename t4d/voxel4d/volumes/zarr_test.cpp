#include "t4d/voxel4d/volumes/zarr.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <fstream>
#include <map>
#include <mutex>
#include <random>
#include <set>

#include <blosc.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lz4.h>
#include <zlib.h>
#include <zstd.h>

#include "t4d/system/test_folder.h"
#include "t4d/voxel4d/volumes/sample_reader.h"
#include "t4d/voxel4d/volumes/zarr_codec.h"
#include "t4d/voxel4d/volumes/zarr_samples.h"

namespace t4d::voxel4d {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;
using Sizes = std::vector<std::uint64_t>;

std::uint64_t countOf(const Sizes& sizes) {
  std::uint64_t count = 1;
  for (const std::uint64_t size : sizes) count *= size;
  return count;
}

/// Number i of a box in C order.
Sizes indexOf(std::uint64_t i, const Sizes& sizes) {
  Sizes index(sizes.size());
  for (std::size_t axis = sizes.size(); axis-- > 0; i /= sizes[axis]) index[axis] = i % sizes[axis];
  return index;
}

/// The sample at an index: none is like another nearby.
std::uint16_t sampleAt(const Sizes& index) {
  std::uint64_t value = 17;
  for (const std::uint64_t i : index) value = value * 31 + i;
  return static_cast<std::uint16_t>(value);
}

std::string packed(const std::string& codec, const std::string& bytes) {
  std::string out(bytes.size() * 2 + 1000, '\0');
  std::size_t size = 0;
  if (codec == "zstd") {
    size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3);
  } else if (codec == "lz4") {
    const auto whole = static_cast<std::uint32_t>(bytes.size());
    std::memcpy(out.data(), &whole, 4);
    size = 4 + static_cast<std::size_t>(LZ4_compress_default(bytes.data(), out.data() + 4,
                                                             static_cast<int>(bytes.size()),
                                                             static_cast<int>(out.size() - 4)));
  } else if (codec == "zlib" || codec == "gzip") {
    z_stream stream{};
    constexpr int kGzip = 16;
    deflateInit2(&stream, 6, Z_DEFLATED, MAX_WBITS + (codec == "gzip" ? kGzip : 0), 8,
                 Z_DEFAULT_STRATEGY);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    deflate(&stream, Z_FINISH);
    size = stream.total_out;
    deflateEnd(&stream);
  } else if (codec.starts_with("blosc-")) {
    size = static_cast<std::size_t>(blosc_compress_ctx(5, BLOSC_SHUFFLE, 2, bytes.size(),
                                                       bytes.data(), out.data(), out.size(),
                                                       codec.substr(6).c_str(), 0, 1));
  } else {
    return bytes;
  }
  out.resize(size);
  return out;
}

/// An array of 16-bit samples, as it is written here.
struct Written {
  Sizes shape;
  Sizes chunk;
  bool fortran = false;
  std::string codec;           ///< "" for none
  std::set<std::string> left;  ///< out

  std::map<std::string, std::string> files() const {
    std::map<std::string, std::string> all;
    const std::string id = codec.substr(0, codec.find('-'));
    all[".zarray"] = fmt::format(
        R"({{"zarr_format": 2, "shape": [{}], "chunks": [{}], "dtype": "<u2", "order": "{}",
            "compressor": {}, "filters": null, "fill_value": 7}})",
        fmt::join(shape, ","), fmt::join(chunk, ","), fortran ? "F" : "C",
        codec.empty() ? "null" : "{\"id\": \"" + id + "\"}");
    Sizes grid;
    for (std::size_t i = 0; i < shape.size(); ++i) {
      grid.push_back((shape[i] + chunk[i] - 1) / chunk[i]);
    }
    Sizes order = chunk;  // from the slowest axis to the fastest
    if (fortran) std::ranges::reverse(order);
    for (std::uint64_t number = 0; number < countOf(grid); ++number) {
      const Sizes at = indexOf(number, grid);
      const std::string key = fmt::format("{}", fmt::join(at, "."));
      if (left.contains(key)) continue;
      std::string bytes;
      for (std::uint64_t i = 0; i < countOf(chunk); ++i) {
        Sizes index = indexOf(i, order);
        if (fortran) std::ranges::reverse(index);
        for (std::size_t axis = 0; axis < index.size(); ++axis)
          index[axis] += at[axis] * chunk[axis];
        const std::uint16_t sample = sampleAt(index);
        bytes.append(reinterpret_cast<const char*>(&sample), sizeof sample);
      }
      all[key] = packed(codec, bytes);
    }
    return all;
  }
};

/// A web server in memory.
struct Web {
  std::map<std::string, std::string> files;
  std::shared_ptr<std::atomic<int>> requests = std::make_shared<std::atomic<int>>(0);

  system::WebFiles get() const {
    return [files = files, requests = requests](
               const std::string& url, const std::string&,
               std::uint64_t) -> Result<std::optional<system::WebFile>> {
      ++*requests;
      const auto found = files.find(url.substr(std::string_view("http://host/a.zarr/").size()));
      if (found == files.end()) return std::nullopt;
      return system::WebFile{found->second, true};
    };
  }
};

Result<Volume> opened(const Web& web, const ZarrChoice& choice) {
  return readZarr("http://host/a.zarr", choice, web.get());
}

Result<std::vector<std::uint16_t>> samplesOf(const Volume& volume, std::size_t frame) {
  const std::uint64_t frameSamples = volume.size('x') * volume.size('y') * volume.size('z');
  auto reader = openSamples(volume.data[0], volume.type, 0);
  if (!reader) return reader.error();
  if (auto done = (*reader)->skip(frame * frameSamples * 2); !done) return done.error();
  std::vector<std::uint16_t> samples(frameSamples);
  if (auto done = (*reader)->read(std::as_writable_bytes(std::span(samples))); !done) {
    return done.error();
  }
  return samples;
}

Written randomArray(std::mt19937& random, std::size_t axes) {
  const auto upTo = [&](int most) {
    return static_cast<std::uint64_t>(std::uniform_int_distribution(1, most)(random));
  };
  constexpr std::array kCodecs = {
      "", "zlib", "gzip", "zstd", "lz4", "blosc-blosclz", "blosc-lz4", "blosc-zlib", "blosc-zstd"};
  Written array;
  for (std::size_t i = 0; i < axes; ++i) {
    array.shape.push_back(upTo(6));
    array.chunk.push_back(upTo(7));
  }
  array.fortran = upTo(2) == 1;
  array.codec = kCodecs[upTo(kCodecs.size()) - 1];
  return array;
}

TEST(Zarr, FramesAreThoseOfTheArray) {
  std::mt19937 random(11);
  for (int round = 0; round < 200; ++round) {
    std::string axes = round % 2 == 0 ? "txyz" : "tcxyz";
    std::ranges::shuffle(axes, random);
    const Written array = randomArray(random, axes.size());
    const auto c = axes.find('c');
    const std::uint64_t channels = c == std::string::npos ? 1 : array.shape[c];
    const auto channel = static_cast<std::uint32_t>(random() % channels);
    const auto volume = opened({array.files()}, {axes, 0, channel});
    ASSERT_TRUE(volume) << volume.error().text();
    ASSERT_EQ(volume->axes.back(), 't');
    const auto frame = static_cast<std::size_t>(random() % volume->frames());
    const auto samples = samplesOf(*volume, frame);
    ASSERT_TRUE(samples) << samples.error().text();
    Sizes sizes(volume->sizes.begin(), volume->sizes.end() - 1);
    std::ranges::reverse(sizes);
    for (std::uint64_t i = 0; i < samples->size(); ++i) {
      Sizes at = indexOf(i, sizes);
      std::ranges::reverse(at);
      Sizes index;
      for (const char axis : axes) {
        index.push_back(axis == 'c' ? channel : axis == 't' ? frame : at[volume->axes.find(axis)]);
      }
      ASSERT_EQ((*samples)[i], sampleAt(index)) << axes << " " << array.codec;
    }
  }
}

TEST(Zarr, FoldersAndServersHoldTheSame) {
  const system::TestFolder folder;
  const Written array{{2, 5, 6, 7}, {2, 3, 4, 5}, true, "zstd", {"0.1.0.1"}};
  const fs::path path = folder.path() / "a.zarr";
  fs::create_directory(path);
  for (const auto& [name, bytes] : array.files()) {
    std::ofstream(path / name, std::ios::binary) << bytes;
  }
  const auto here = readZarr(path, {}, {});
  const auto there = opened({array.files()}, {});
  ASSERT_TRUE(here && there);
  for (const std::size_t frame : {0, 1}) {
    EXPECT_EQ(samplesOf(*here, frame).value(), samplesOf(*there, frame).value());
  }
  EXPECT_THAT(zarrNotice(*here->data[0].zarr->counts), HasSubstr("2 of 16 chunks have no file"));
}

TEST(Zarr, UrlsNeedSomethingThatRequestsThem) {
  const auto refused = readZarr("https://user:secret@host/a.zarr?key=secret", {}, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where.text(), "https://host/a.zarr");
}

TEST(Zarr, EveryTruncationAndManyFlipsOfAChunkFailOrHaveItsSize) {
  std::mt19937 random(3);
  std::string bytes;
  for (int i = 0; i < 3000; ++i)
    bytes += static_cast<char>(i / 50 + static_cast<int>(random() % 3));
  for (const std::string name :
       {"zlib", "gzip", "zstd", "lz4", "blosc-blosclz", "blosc-lz4", "blosc-zlib", "blosc-zstd"}) {
    const std::array codecs = {*zarrCodecNamed(name.substr(0, name.find('-')))};
    const std::string whole = packed(name, bytes);
    ASSERT_EQ(unpackZarrChunk(whole, codecs, bytes.size()).value(), bytes) << name;
    EXPECT_FALSE(unpackZarrChunk(whole, codecs, bytes.size() + 1)) << name;
    EXPECT_FALSE(unpackZarrChunk(whole, codecs, bytes.size() - 1)) << name;
    for (std::size_t size = 0; size < whole.size(); ++size) {
      EXPECT_FALSE(unpackZarrChunk(whole.substr(0, size), codecs, bytes.size())) << name << size;
    }
    for (int round = 0; round < 3000; ++round) {
      std::string damaged = whole;
      for (int i = 0; i < 1 + round % 3; ++i) {
        damaged[random() % (round % 2 == 0 ? damaged.size() : 24)] = static_cast<char>(random());
      }
      const auto unpacked = unpackZarrChunk(damaged, codecs, bytes.size());
      ASSERT_TRUE(!unpacked || unpacked->size() == bytes.size()) << name;
    }
  }
}

TEST(Zarr, FewBytesAreNotUnpackedToMany) {
  constexpr std::uint64_t kMany = std::uint64_t{1} << 40U;
  for (const ZarrCodec codec : {ZarrCodec::Blosc, ZarrCodec::Gzip, ZarrCodec::Lz4, ZarrCodec::Zlib,
                                ZarrCodec::Zstd, ZarrCodec::Crc32c}) {
    const auto refused = unpackZarrChunk(std::string(1000, 'x'), {&codec, 1}, kMany);
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message, HasSubstr("cannot hold"));
  }
}

TEST(Zarr, CutMetadataAreRefused) {
  const Written array{{2, 3, 3, 3}, {1, 3, 3, 3}, false, "", {}};
  Web web{array.files()};
  const std::string whole = web.files[".zarray"];
  for (std::size_t size = 0; size < whole.size(); ++size) {
    web.files[".zarray"] = whole.substr(0, size);
    const auto refused = opened(web, {});
    ASSERT_FALSE(refused) << size;
    EXPECT_EQ(refused.error().where.text(), "http://host/a.zarr/.zarray");
  }
}

}  // namespace
}  // namespace t4d::voxel4d

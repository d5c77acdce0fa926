#include <array>
#include <cstring>
#include <fstream>
#include <functional>
#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiffio.h>

#include "t4d/system/test_folder.h"
#include "t4d/voxel4d/sample_box.h"
#include "t4d/voxel4d/volumes/volume_frames.h"

/// TIFFs as ImageJ, OME and tifffile write them, by libtiff's writer.
namespace t4d::voxel4d {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr std::uint32_t kWidth = 21;
constexpr std::uint32_t kHeight = 18;
constexpr std::uint64_t kSlices = 4;
constexpr std::uint64_t kFrames = 3;
constexpr std::uint64_t kChannels = 2;

/// Whether the sample of a channel is inside: something without any symmetry; channel 0 has
/// nothing.
bool isInside(std::uint32_t x, std::uint32_t y, std::uint64_t z, std::uint64_t t,
              std::uint64_t channel) {
  return channel == 1 && 2 * x + 3 * y + 5 * z + 7 * t < 47 && x > t && y > 1;
}

struct Plane {
  std::uint64_t z = 0;
  std::uint64_t t = 0;
  std::uint64_t channel = 1;
};

struct Form {
  const char* mode = "w";
  std::uint16_t bits = 8;
  std::uint16_t format = SAMPLEFORMAT_UINT;
  std::uint16_t compression = COMPRESSION_NONE;
  std::uint32_t tile = 0;  // strips without it
  float pixelsPerUnit = 0;
};

/// A page for each plane; 9 inside and 1 outside.
void write(const fs::path& path, const std::vector<Plane>& planes, const std::string& description,
           const Form& form = {}) {
  TIFF* file = TIFFOpen(path.c_str(), form.mode);
  ASSERT_NE(file, nullptr);
  const std::size_t size = form.bits / 8;
  for (std::size_t page = 0; page < planes.size(); ++page) {
    const Plane& plane = planes[page];
    TIFFSetField(file, TIFFTAG_IMAGEWIDTH, kWidth);
    TIFFSetField(file, TIFFTAG_IMAGELENGTH, kHeight);
    TIFFSetField(file, TIFFTAG_BITSPERSAMPLE, form.bits);
    TIFFSetField(file, TIFFTAG_SAMPLEFORMAT, form.format);
    TIFFSetField(file, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(file, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(file, TIFFTAG_COMPRESSION, form.compression);
    if (form.pixelsPerUnit > 0) {
      TIFFSetField(file, TIFFTAG_XRESOLUTION, form.pixelsPerUnit);
      TIFFSetField(file, TIFFTAG_YRESOLUTION, 2 * form.pixelsPerUnit);
    }
    if (page == 0 && !description.empty()) {
      TIFFSetField(file, TIFFTAG_IMAGEDESCRIPTION, description.c_str());
    }
    const auto put = [&](std::byte* at, std::uint32_t x, std::uint32_t y) {
      const bool inside =
          x < kWidth && y < kHeight && isInside(x, y, plane.z, plane.t, plane.channel);
      if (form.format == SAMPLEFORMAT_IEEEFP) {
        const double value = inside ? 9 : 1;
        const auto single = static_cast<float>(value);
        std::memcpy(at, size == 8 ? static_cast<const void*>(&value) : &single, size);
      } else {
        const std::uint64_t value = inside ? 9 : 1;
        std::memcpy(at, &value, size);  // this machine is little-endian
      }
    };
    if (form.tile > 0) {
      TIFFSetField(file, TIFFTAG_TILEWIDTH, form.tile);
      TIFFSetField(file, TIFFTAG_TILELENGTH, form.tile);
      std::vector<std::byte> tile(std::size_t{form.tile} * form.tile * size);
      for (std::uint32_t y = 0; y < kHeight; y += form.tile) {
        for (std::uint32_t x = 0; x < kWidth; x += form.tile) {
          for (std::uint32_t i = 0; i < form.tile * form.tile; ++i) {
            put(tile.data() + i * size, x + i % form.tile, y + i / form.tile);
          }
          ASSERT_GT(TIFFWriteTile(file, tile.data(), x, y, 0, 0), 0);
        }
      }
    } else {
      TIFFSetField(file, TIFFTAG_ROWSPERSTRIP, 5);
      std::vector<std::byte> row(kWidth * size);
      for (std::uint32_t y = 0; y < kHeight; ++y) {
        for (std::uint32_t x = 0; x < kWidth; ++x) put(row.data() + x * size, x, y);
        ASSERT_EQ(TIFFWriteScanline(file, row.data(), y, 0), 1);
      }
    }
    ASSERT_EQ(TIFFWriteDirectory(file), 1);
  }
  TIFFClose(file);
}

/// Those of channel 1, or of both, in the order of these axes, the slowest first.
std::vector<Plane> planesBy(const std::string& axes) {
  std::vector<Plane> planes = {{}};
  for (const char axis : axes) {
    const std::uint64_t count = axis == 'z' ? kSlices : axis == 't' ? kFrames : kChannels;
    std::vector<Plane> more;
    for (const Plane& plane : planes) {
      for (std::uint64_t i = 0; i < count; ++i) {
        Plane next = plane;
        (axis == 'z' ? next.z : axis == 't' ? next.t : next.channel) = i;
        more.push_back(next);
      }
    }
    planes = std::move(more);
  }
  return planes;
}

Result<VolumeFrames> opened(const fs::path& path, VolumeOptions options = {}) {
  options.iso = 5;
  return openVolumeFrames({&path, 1}, options);
}

/// Every sample of every frame is where it belongs.
void expectSamples(const fs::path& path, const VolumeOptions& options = {},
                   std::uint64_t slices = kSlices, std::uint64_t frames = kFrames) {
  SCOPED_TRACE(path.string());
  auto volume = opened(path, options);
  ASSERT_TRUE(volume) << volume.error().text();
  ASSERT_EQ(volume->frames->frameCount(), frames);
  for (std::uint64_t t = 0; t < frames; ++t) {
    const auto frame = volume->frames->frame(t);
    ASSERT_TRUE(frame) << frame.error().text();
    std::uint64_t expected = 0;
    std::uint64_t found = 0;
    for (std::uint64_t z = 0; z < slices; ++z) {
      for (std::uint32_t y = 0; y < kHeight; ++y) {
        for (std::uint32_t x = 0; x < kWidth; ++x) {
          const bool inside = isInside(x, y, z, t, 1);
          expected += inside ? 1 : 0;
          const Coord block{static_cast<std::int32_t>(x / 8), static_cast<std::int32_t>(y / 8),
                            static_cast<std::int32_t>(z / 8)};
          const auto at = std::ranges::find(frame->blocks, block, &Block::coord);
          const bool has =
              at != frame->blocks.end() && (at->inside[x % 8] >> (8 * (y % 8) + z % 8) & 1U) != 0;
          found += has ? 1 : 0;
          ASSERT_EQ(has, inside) << x << ' ' << y << ' ' << z << ' ' << t;
        }
      }
    }
    EXPECT_EQ(countInside(*frame), expected);
    EXPECT_GT(found, 20U);
  }
}

class Tiff : public testing::Test {
 protected:
  std::string faultOf(const std::string& name, const VolumeOptions& options = {}) {
    auto volume = opened(folder_ / name, options);
    if (!volume) return volume.error().text();
    for (std::size_t i = 0; i < volume->frames->frameCount(); ++i) {
      if (const auto frame = volume->frames->frame(i); !frame) return frame.error().text();
    }
    return "(was read)";
  }
  system::TestFolder folder_;
};

std::string imageJ(std::uint64_t slices, std::uint64_t frames, std::uint64_t channels) {
  return fmt::format(
      "ImageJ=1.53t\nimages={}\nchannels={}\nslices={}\nframes={}\nhyperstack=true\nunit=micron\n"
      "spacing=-0.75\nfinterval=0.04\n",
      slices * frames * channels, channels, slices, frames);
}

TEST_F(Tiff, SamplesOfAllTypesStripsTilesAndCompressionsAreRead) {
  const auto planes = planesBy("tz");
  int number = 0;
  for (const auto& [format, bits] : {std::pair{SAMPLEFORMAT_UINT, 8},
                                     {SAMPLEFORMAT_UINT, 16},
                                     {SAMPLEFORMAT_UINT, 32},
                                     {SAMPLEFORMAT_UINT, 64},
                                     {SAMPLEFORMAT_INT, 8},
                                     {SAMPLEFORMAT_INT, 16},
                                     {SAMPLEFORMAT_INT, 32},
                                     {SAMPLEFORMAT_INT, 64},
                                     {SAMPLEFORMAT_IEEEFP, 32},
                                     {SAMPLEFORMAT_IEEEFP, 64}}) {
    for (const char* mode : {"wl", "wb", "w8"}) {
      Form form{mode, static_cast<std::uint16_t>(bits), static_cast<std::uint16_t>(format)};
      form.compression = std::array{COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE,
                                    COMPRESSION_PACKBITS}[static_cast<std::size_t>(number % 4)];
      form.tile = number % 3 == 1 ? 16 : 0;
      const fs::path path = folder_ / fmt::format("{}.tif", number++);
      write(path, planes, imageJ(kSlices, kFrames, 1), form);
      expectSamples(path);
    }
  }
}

TEST_F(Tiff, OfImageJHasSpacingTimeAndChannels) {
  write(folder_ / "a.tif", planesBy("tzc"), imageJ(kSlices, kFrames, kChannels),
        {.pixelsPerUnit = 4});
  expectSamples(folder_ / "a.tif", {.channel = 1});
  const auto volume = opened(folder_ / "a.tif", {.channel = 1});
  ASSERT_TRUE(volume && volume->toSpace);
  EXPECT_EQ(volume->lengthUnit, "um");
  EXPECT_EQ(volume->timeUnit, "s");
  EXPECT_EQ(Eigen::Vector3d(volume->toSpace->diagonal()), Eigen::Vector3d(0.25, 0.125, 0.75));
  EXPECT_EQ(volume->frames->frame(2)->time, 0.08);
  EXPECT_THAT(faultOf("a.tif"), HasSubstr("has 2 channels; choose one, 0 to 1"));
  EXPECT_THAT(faultOf("a.tif", {.channel = 2}), HasSubstr("there is no channel 2"));
}

TEST_F(Tiff, OfImageJLargerThan4GiBHasItsPlanesAfterItsOnlyPage) {
  write(folder_ / "a.tif", {Plane{}}, imageJ(kSlices, kFrames, 1), {"wb", 16});
  // The samples of the page are those of the first plane; here they follow the directory.
  std::string bytes = system::contents(folder_ / "a.tif");
  // libtiff puts the page's data first, at byte 8: the rest is put behind them.
  const std::size_t plane = std::size_t{2} * kWidth * kHeight;
  std::string planes;
  for (const Plane& one : planesBy("tz")) {
    for (std::uint32_t y = 0; y < kHeight; ++y) {
      for (std::uint32_t x = 0; x < kWidth; ++x) {
        planes += '\0';
        planes += isInside(x, y, one.z, one.t, 1) ? '\x09' : '\x01';
      }
    }
  }
  const std::size_t begin = bytes.size();
  // Its strips, which are read from their first on, are moved to the end.
  const auto offsetOf = [&](std::uint32_t value) {
    std::string text;
    for (int shift = 24; shift >= 0; shift -= 8) text += static_cast<char>(value >> shift & 0xFF);
    return text;
  };
  const std::size_t at = bytes.find(offsetOf(8) + offsetOf(8 + 5 * 2 * kWidth));
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at, 4, offsetOf(static_cast<std::uint32_t>(begin)));
  ASSERT_EQ(planes.size(), plane * kSlices * kFrames);
  std::ofstream(folder_ / "a.tif", std::ios::binary) << bytes << planes;
  expectSamples(folder_ / "a.tif");
}

std::string ome(const std::string& order, const std::string& data, const std::string& more = "") {
  return fmt::format(
      R"(<?xml version="1.0" encoding="UTF-8"?><OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06">)"
      R"(<Image ID="Image:0"><Pixels ID="Pixels:0" DimensionOrder="{}" Type="uint8" SizeX="21" )"
      R"(SizeY="18" SizeZ="4" SizeC="2" SizeT="3" PhysicalSizeX="0.5" PhysicalSizeY="0.5" )"
      R"(PhysicalSizeZ="2" PhysicalSizeZUnit="µm" TimeIncrement="40" TimeIncrementUnit="ms"{}>)"
      R"({}</Pixels></Image></OME>)",
      order, more, data);
}

TEST_F(Tiff, OfOmeHasItsPlanesInEveryOrder) {
  for (const std::string order : {"XYCZT", "XYCTZ", "XYZCT", "XYZTC", "XYTCZ", "XYTZC"}) {
    std::string axes;
    for (const std::size_t i : {4U, 3U, 2U}) axes += static_cast<char>(std::tolower(order[i]));
    write(folder_ / (order + ".ome.tif"), planesBy(axes), ome(order, "<TiffData/>"));
    expectSamples(folder_ / (order + ".ome.tif"), {.channel = 1});
  }
  const auto volume = opened(folder_ / "XYCZT.ome.tif", {.channel = 1});
  ASSERT_TRUE(volume && volume->toSpace);
  EXPECT_EQ(Eigen::Vector3d(volume->toSpace->diagonal()), Eigen::Vector3d(0.5, 0.5, 2));
  EXPECT_EQ(volume->lengthUnit, "um");
  EXPECT_EQ(volume->timeUnit, "ms");
  EXPECT_EQ(volume->frames->frame(1)->time, 40);
}

TEST_F(Tiff, OfOmeSaysWhereEachPlaneIs) {
  std::vector<Plane> planes = planesBy("tzc");
  std::ranges::shuffle(planes, std::mt19937(4));
  std::string data;
  for (std::size_t page = 0; page < planes.size(); ++page) {
    data += fmt::format(R"(<TiffData FirstC="{}" FirstZ="{}" FirstT="{}" IFD="{}" PlaneCount="1">)"
                        R"(<UUID FileName="a.ome.tif">urn:uuid:1</UUID></TiffData>)",
                        planes[page].channel, planes[page].z, planes[page].t, page);
  }
  write(folder_ / "a.ome.tif", planes, ome("XYZCT", data));
  expectSamples(folder_ / "a.ome.tif", {.channel = 1});

  const auto fault = [&](const std::string& text) {
    write(folder_ / "b.ome.tif", planesBy("tcz"), text);
    return faultOf("b.ome.tif", {.channel = 1});
  };
  EXPECT_EQ(fault(ome("XYZCT", "")), "(was read)");
  EXPECT_THAT(fault(ome("XYZCT", R"(<TiffData IFD="0"/>)")), HasSubstr("where 1 of 24 planes are"));
  EXPECT_THAT(fault(ome("XYZCT", R"(<TiffData IFD="24"/>)")),
              HasSubstr("TiffData that is damaged"));
  EXPECT_THAT(fault(ome("XYZCT", R"(<TiffData IFD="0" FirstT="3"/>)")), HasSubstr("outside"));
  EXPECT_THAT(fault(ome("XYZCT", R"(<TiffData IFD="0"/><TiffData IFD="1"/>)")),
              HasSubstr("places planes twice"));
  EXPECT_THAT(
      fault(ome("XYZCT", R"(<TiffData IFD="0"><UUID FileName="a"/></TiffData>)"
                         R"(<TiffData IFD="1" FirstZ="1"><UUID FileName="b"/></TiffData>)")),
      HasSubstr("one of several files"));
  EXPECT_THAT(fault(ome("XYZC", "")), HasSubstr("DimensionOrder=\"XYZC\""));
  EXPECT_THAT(fault(ome("XYZCT", "").substr(0, 300)), HasSubstr("OME-XML is damaged"));
  EXPECT_THAT(fault("<OME></OME>"), HasSubstr("has no Pixels"));
  std::string many = ome("XYZCT", "");
  many.replace(many.find("SizeT=\"3\""), 9, "SizeT=\"2000000000\"");
  EXPECT_THAT(fault(many), HasSubstr("has 16000000000 planes, but it has 24 pages"));
}

TEST_F(Tiff, WithoutADescriptionHasPagesThatAreSlicesOrFrames) {
  std::vector<fs::path> series;
  for (std::uint64_t t = 0; t < kFrames; ++t) {
    std::vector<Plane> planes;
    for (std::uint64_t z = 0; z < kSlices; ++z) planes.push_back({z, t, 1});
    write(series.emplace_back(folder_ / fmt::format("s{}.tif", t)), planes, "");
  }
  const auto volume = openVolumeFrames(series, {.iso = 5});
  ASSERT_TRUE(volume) << volume.error().text();
  EXPECT_EQ(volume->frames->frameCount(), kFrames);
  const auto single = openVolumeFrames(std::span(series).first(1), {.iso = 5});
  ASSERT_FALSE(single);
  EXPECT_THAT(single.error().message, HasSubstr("has one frame only"));
  EXPECT_EQ(single.error().remedy, Remedy::PagesAsFrames);
  write(folder_ / "movie.tif", {{0, 0, 1}, {0, 1, 1}, {0, 2, 1}}, "");
  expectSamples(folder_ / "movie.tif", {.axes = "tyx"}, 1);
  EXPECT_THAT(faultOf("movie.tif", {.axes = "tzyx"}), HasSubstr("does not say how its 3 pages"));
  // What tifffile writes.
  write(folder_ / "shaped.tif", planesBy("tz"), R"({"shape": [3, 4, 18, 21]})");
  expectSamples(folder_ / "shaped.tif");
  write(folder_ / "named.tif", planesBy("czt"), R"({"shape": [2, 4, 3, 18, 21], "axes": "CZTYX"})");
  expectSamples(folder_ / "named.tif", {.channel = 1});
  write(folder_ / "told.tif", planesBy("zt"), R"({"shape": [4, 3, 18, 21]})");
  expectSamples(folder_ / "told.tif", {.axes = "ztyx"});
}

TEST_F(Tiff, WhatIsDamagedOrOfAnotherKindIsRefused) {
  write(folder_ / "a.tif", planesBy("tz"), imageJ(5, kFrames, 1));
  EXPECT_THAT(faultOf("a.tif"), HasSubstr("has 15 planes, but it has 12 pages"));
  write(folder_ / "a.tif", planesBy("tz"), "ImageJ=1\nslices=-4\n");
  EXPECT_THAT(faultOf("a.tif"), HasSubstr("its ImageJ description has 'slices=-4'"));
  write(folder_ / "a.tif", planesBy("tz"), "ImageJ=1\nslices=4\nframes=99999999999999999999\n");
  EXPECT_THAT(faultOf("a.tif"), HasSubstr("its ImageJ description has 'frames=99"));
  write(folder_ / "a.tif", planesBy("tz"), imageJ(kSlices, kFrames, 1),
        {"w", 16, SAMPLEFORMAT_IEEEFP});
  EXPECT_THAT(faultOf("a.tif"), HasSubstr("samples of 16 bits"));
  std::ofstream(folder_ / "a.tif") << "no TIFF at all";
  EXPECT_THAT(faultOf("a.tif"), HasSubstr("is no TIFF that can be read"));

  // Cut anywhere, and with any byte changed.
  write(folder_ / "whole.tif", planesBy("tz"), imageJ(kSlices, kFrames, 1),
        {.compression = COMPRESSION_LZW});
  const std::string whole = system::contents(folder_ / "whole.tif");
  for (std::size_t end = 1; end < whole.size(); end += 41) {
    std::ofstream(folder_ / "cut.tif", std::ios::binary) << whole.substr(0, end);
    EXPECT_NE(faultOf("cut.tif"), "(was read)") << end;
  }
  std::mt19937 random(9);
  for (int i = 0; i < 400; ++i) {
    std::string other = whole;
    for (int k = 0; k < 3; ++k) other[random() % other.size()] = static_cast<char>(random());
    std::ofstream(folder_ / "other.tif", std::ios::binary) << other;
    EXPECT_LT(faultOf("other.tif").size(), 1000U);
  }
}

}  // namespace
}  // namespace t4d::voxel4d

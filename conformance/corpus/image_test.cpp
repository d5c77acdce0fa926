#include "conformance/corpus/image.h"

#include <gtest/gtest.h>

#include "conformance/corpus/shapes.h"
#include "platform/test_folder.h"
#include "t4d/file.h"

namespace t4d::conformance {
namespace {

std::string written(const std::vector<BodySlabs>& bodies, const formats::T4dWriteOptions& options) {
  const platform::TestFolder folder;
  const auto file = folder / "file.t4d";
  formats::Metadata metadata;
  for (const BodySlabs& body : bodies) metadata.bodies.push_back({body.name});
  auto writer = formats::T4dWriter::create(file, metadata, options);
  EXPECT_TRUE(writer);
  std::size_t most = 0;
  for (const BodySlabs& body : bodies) most = std::max(most, body.slabs.size());
  for (std::size_t k = 0; k < most; ++k) {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (k < bodies[i].slabs.size()) {
        EXPECT_TRUE(writer->body(i).put(bodies[i].slabs[k]));
      }
    }
  }
  EXPECT_TRUE(writer->finish());
  return platform::contents(file);
}

/// HEAD as written by the writer.
std::string headIn(const std::string& file) {
  std::uint64_t length = 0;
  file.copy(reinterpret_cast<char*>(&length), sizeof length, 32);
  return file.substr(56, length);
}

TEST(Image, IsWhatTheWriterWrites) {
  const Solid box = cube();
  const std::vector<BodySlabs> bodies = {
      {"cross", crossPolytope()},
      {"cube",
       sweep(box, {pose(box, 0, {0, 0, 0}), pose(box, 1, {0.1, 0, 0}), pose(box, 2, {0, 3, 0})},
             {.prism = Prism::Fourteen, .cones = true})}};
  for (const bool index : {true, false}) {
    for (const bool float32 : {true, false}) {
      const std::string file = written(bodies, {0, float32, index});
      const Image image =
          Image::of(bodies, ImageOptions{.index = index, .float32 = float32}, headIn(file));
      EXPECT_EQ(image.bytes(), file) << index << float32;
    }
  }
}

TEST(Image, ChangesWhatIsSetAndTheSumsOverIt) {
  const Image right = Image::of({{"simplex", simplex()}});
  Image image = right;
  image.set("SLAB 0/begin", -1.0);
  const std::string a = right.bytes();
  const std::string b = image.bytes();
  ASSERT_EQ(a.size(), b.size());
  std::vector<std::size_t> changed;
  for (std::size_t i = 0; i < a.size(); i += 4) {
    if (a.substr(i, 4) != b.substr(i, 4)) changed.push_back(i);
  }
  // Begin in SLAB, DONE and INDX, and the checksums over it.
  std::vector<std::size_t> expected = {
      right.offset("SLAB 0/begin") + 4, right.offset("DONE/body 0/begin") + 4,
      right.offset("INDX/times/stored") + 4, right.offset("INDX/times/stored checksum"),
      // The headers of SLAB and DONE in the directory.
      right.offset("INDX/chunks/stored") + 2 * 28 + 24,
      right.offset("INDX/chunks/stored") + 3 * 28 + 24, right.offset("INDX/chunks/stored checksum"),
      right.offset("footer/index checksum"), right.offset("footer/checksum")};
  for (const char* chunk : {"SLAB 0", "DONE", "INDX"}) {
    for (const char* sum : {"/header/front checksum", "/header/header checksum"}) {
      expected.push_back(right.offset(std::string(chunk) + sum));
    }
  }
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(changed, expected);
}

}  // namespace
}  // namespace t4d::conformance

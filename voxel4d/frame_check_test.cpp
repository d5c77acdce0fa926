#include <limits>

#include <gtest/gtest.h>

#include "t4d/mesh.h"
#include "t4d/weave.h"

namespace t4d::voxel4d {
namespace {

/// Two blocks with values, of which the second is all inside, and a tile of 2 x 2 x 2 blocks.
struct Sample {
  std::vector<double> values = std::vector<double>(1024, -1);
  Frame frame;

  Sample() {
    values[0] = 2;
    frame.outsideValue = 3;
    frame.blocks.resize(2);
    frame.blocks[0].coord = {-1, 0, 0};
    frame.blocks[1].coord = {0, 0, 0};
    for (std::size_t i = 0; i < 2; ++i) {
      frame.blocks[i].inside.fill(kAllBits);
      frame.blocks[i].values.doubles = values.data() + 512 * i;
    }
    frame.blocks[0].inside[0] &= ~std::uint64_t{1};
    frame.tiles = {{{2, 0, 0}, 2, -3}};
  }
};

std::string faultOf(const Frame& frame) {
  const auto checked = checkFrame(frame);
  return checked ? "" : checked.error().message;
}

TEST(CheckFrame, AcceptsASoundFrame) {
  EXPECT_EQ(faultOf(Sample().frame), "");
  EXPECT_EQ(faultOf(Frame()), "");
}

TEST(CheckFrame, NamesWhatIsWrong) {
  struct Case {
    std::function<void(Sample&)> spoil;
    std::string message;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Case> cases = {
      {[&](Sample& s) { s.frame.time = nan; }, "its time is nan"},
      {[](Sample& s) { s.frame.outsideValue = -1; },
       "its value outside is -1; expected a positive number, or 0 for no values"},
      {[](Sample& s) {
         s.frame.blocks[1].coord = {-1, 0, 0};
       },
       "the block at (-1, 0, 0) does not come after the one before it"},
      {[](Sample& s) {
         s.frame.blocks[1].coord = {1 << 28, 0, 0};
       },
       "the block at (268435456, 0, 0) lies beyond 32-bit coordinates"},
      {[](Sample& s) {
         s.frame.blocks[1].coord = {3, 1, 0};
       },
       "the block at (3, 1, 0) lies within a tile"},
      {[](Sample& s) { s.frame.blocks[1].values = {}; },
       "the block at (0, 0, 0) has no values, other than its frame"},
      {[](Sample& s) { s.frame.outsideValue = 0, s.frame.tiles.clear(); },
       "the block at (-1, 0, 0) has values, other than its frame"},
      {[](Sample& s) { s.values[3] = 1; },
       "the block at (-1, 0, 0) has the value 1 at its point 3, which it says is inside"},
      {[](Sample& s) { s.values[0] = -1; },
       "the block at (-1, 0, 0) has the value -1 at its point 0, which it says is outside"},
      {[&](Sample& s) { s.values[600] = nan; },
       "the block at (0, 0, 0) has the value nan at its point 88, which it says is inside"},
      {[](Sample& s) { s.frame.tiles[0].size = 3; },
       "the tile at (2, 0, 0) has the size 3, which is not a power of two"},
      {[](Sample& s) { s.frame.tiles[0].size = 4; },
       "the tile at (2, 0, 0) is not at a multiple of its size 4"},
      {[](Sample& s) { s.frame.tiles[0].value = 0; },
       "the tile at (2, 0, 0) has the value 0; expected a negative number"},
      {[](Sample& s) { s.frame.tiles.push_back(s.frame.tiles[0]); },
       "the tile at (2, 0, 0) does not come after the one before it"},
      {[](Sample& s) {
         s.frame.tiles.push_back({{2, 0, 1}, 1, -1});
       },
       "the tile at (2, 0, 1) lies within another"},
  };
  for (const Case& one : cases) {
    Sample sample;
    one.spoil(sample);
    EXPECT_EQ(faultOf(sample.frame), one.message);
  }
}

TEST(Weave, RefusesAFrameThatIsNotSound) {
  class Frames : public FrameSource {
   public:
    const Lattice& lattice() const override { return lattice_; }
    std::size_t frameCount() const override { return 2; }
    Result<Frame> frame(std::size_t index) override {
      Frame frame = sample_.frame;
      frame.time = static_cast<double>(index);
      if (index == 1) std::swap(frame.blocks[0], frame.blocks[1]);
      return frame;
    }

   private:
    Lattice lattice_;
    Sample sample_;
  } frames;
  model::NullSink nothing;
  const auto woven = weave(frames, {}, nothing);
  ASSERT_FALSE(woven);
  EXPECT_EQ(woven.error().text(),
            "frame 1: the block at (-1, 0, 0) does not come after the one before it");
}

}  // namespace
}  // namespace t4d::voxel4d

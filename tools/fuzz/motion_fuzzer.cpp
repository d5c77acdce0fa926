#include <string>

#include "formats/input_file.h"
#include "formats/motion/motion_csv.h"
#include "t4d/motion.h"
#include "tools/fuzz/fuzz.h"
#include "tools/fuzz/many_segments.h"

/// Motion files, JSON if the first byte is that of an object and tables otherwise: an accepted
/// motion has no gaps and only finite numbers.
namespace t4d::fuzz {
namespace {

bool finite(const model::Pose& pose) {
  return pose.rotation.allFinite() && pose.translation.allFinite();
}

bool same(const model::Pose& a, const model::Pose& b) {
  return a.rotation == b.rotation && a.translation == b.translation;
}

int test(std::span<const std::uint8_t> bytes) {
  const std::string text(bytes.begin(), bytes.end());
  if (asksForManySegments(text)) return -1;
  const auto motion = text.starts_with('{') ? formats::parseMotion(text, "motion")
                                            : formats::readMotionCsv({"motion", text});
  if (!motion) {
    must(!motion.error().message.empty() && motion.error().where.file.starts_with("motion"),
         "a refusal says what and where");
    return 0;
  }
  must(!motion->segments.empty(), "a motion has segments");
  const model::Segment* before = nullptr;
  for (const model::Segment& segment : motion->segments) {
    must(std::isfinite(segment.timeBegin) && std::isfinite(segment.timeEnd) &&
             segment.timeBegin < segment.timeEnd,
         "a segment lasts");
    if (before != nullptr) {
      must(before->timeEnd == segment.timeBegin && same(before->end, segment.start),
           "a segment begins where the one before ends");
    }
    must(same(segment.at(0), segment.start) && same(segment.at(1), segment.end),
         "a segment goes from its start to its end");
    for (const double fraction : {0.0, 0.3, 1.0}) {
      const model::Pose pose = segment.at(fraction);
      must(finite(pose), "poses are finite");
      const Eigen::Matrix3d square = pose.rotation * pose.rotation.transpose();
      must(square.isIdentity(1e-9), "poses are rigid");
    }
    before = &segment;
  }
  return 0;
}

}  // namespace
}  // namespace t4d::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return t4d::fuzz::test({data, size});
}

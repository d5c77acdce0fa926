#include <string>

#include "formats/motion/joint_table.h"
#include "formats/motion/mechanism_reader.h"
#include "formats/motion/urdf_reader.h"
#include "tools/fuzz/fuzz.h"
#include "tools/fuzz/many_segments.h"

/// Mechanisms: JSON if the first byte is that of an object; URDF if it is that of an element, with
/// the table of its joints after a zero; and otherwise a table of joints alone. An accepted
/// mechanism is a tree, and its poses are rigid and finite.
namespace t4d::fuzz {
namespace {

void checkTable(const std::string& text) {
  const auto table = formats::readJointTable({"joints.csv", text}, "s");
  if (!table) {
    must(!table.error().message.empty() && table.error().where.file.starts_with("joints.csv"),
         "a refusal says what and where");
    return;
  }
  must(table->times.size() >= 2 && !table->columns.empty(), "a table has rows and joints");
  for (std::size_t i = 1; i < table->times.size(); ++i) {
    must(table->times[i] > table->times[i - 1], "times increase");
  }
  for (const auto& column : table->columns) {
    must(column.values.size() == table->times.size(), "a joint has a value at each time");
  }
}

void checkMechanism(const Result<formats::LoadedMechanism>& loaded) {
  if (!loaded) {
    must(!loaded.error().message.empty() && !loaded.error().where.empty(),
         "a refusal says what and where");
    return;
  }
  const model::Mechanism& mechanism = loaded->mechanism;
  must(mechanism.span().has_value() && !loaded->solids.empty(), "something moves");
  for (std::size_t i = 0; i < mechanism.links.size(); ++i) {
    const std::size_t parent = mechanism.links[i].parent;
    must(parent == model::Link::kWorld || parent < i, "parents come first");
  }
  for (const formats::MechanismSolid& solid : loaded->solids) {
    must(solid.link < mechanism.links.size(), "a solid has a link");
    for (const double time : {mechanism.span()->begin, mechanism.span()->end}) {
      const model::Pose pose = mechanism.at(solid.link, time);
      must(pose.rotation.allFinite() && pose.translation.allFinite(), "poses are finite");
      must((pose.rotation * pose.rotation.transpose()).isIdentity(1e-6), "poses are rigid");
    }
  }
}

int test(std::span<const std::uint8_t> bytes) {
  const std::string text(bytes.begin(), bytes.end());
  if (asksForManySegments(text)) return -1;
  if (text.starts_with('{')) {
    checkMechanism(formats::readMechanism({"mechanism.json", text}));
  } else if (text.starts_with('<')) {
    const auto end = text.find('\0');
    const std::string table = end == std::string::npos ? "" : text.substr(end + 1);
    checkMechanism(formats::readUrdf({"robot.urdf", text.substr(0, end)}, {"joints.csv", table}));
  } else {
    checkTable(text);
  }
  return 0;
}

}  // namespace
}  // namespace t4d::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return t4d::fuzz::test({data, size});
}

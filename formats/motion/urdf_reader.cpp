#include "formats/motion/urdf_reader.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>

#include <expat.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/input_file.h"
#include "formats/motion/basic_solids.h"
#include "formats/motion/joint_table.h"
#include "formats/t4d/names.h"
#include "formats/text/text_scanner.h"
#include "model/degrees.h"
#include "model/limits.h"
#include "model/units.h"
#include "platform/xml_position.h"

namespace t4d::formats {
namespace {

using model::Link;
using model::Pose;

/// An element of the file, its children, and the line it begins at.
struct XmlElement {
  std::string name;
  std::uint64_t line = 0;
  std::map<std::string, std::string> attributes;
  std::vector<std::unique_ptr<XmlElement>> children;

  const XmlElement* child(std::string_view wanted) const {
    const auto found = std::ranges::find_if(
        children, [&](const auto& element) { return element->name == wanted; });
    return found == children.end() ? nullptr : found->get();
  }
};

/// Reads XML as a tree. Fails on elements nested too deeply, and on declarations of entities, which
/// URDF does not have.
class XmlTree {
 public:
  static Result<std::unique_ptr<XmlElement>> read(const InputFile& file) {
    XmlTree tree(file);
    const std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser(XML_ParserCreate(nullptr),
                                                                         XML_ParserFree);
    tree.parser_ = parser.get();
    XML_SetUserData(tree.parser_, &tree);
    XML_SetElementHandler(tree.parser_, onStart, onEnd);
    XML_SetEntityDeclHandler(tree.parser_, onEntity);
    const XML_Status status =
        XML_Parse(tree.parser_, file.bytes.data(), static_cast<int>(file.bytes.size()), XML_TRUE);
    if (!tree.problem_.empty()) return invalid(tree.problem_, tree.here());
    if (status != XML_STATUS_OK) {
      return invalid(fmt::format("is not XML: {}", XML_ErrorString(XML_GetErrorCode(tree.parser_))),
                     tree.here());
    }
    return std::move(tree.root_);
  }

 private:
  explicit XmlTree(const InputFile& file) : file_(file) {}

  static void onStart(void* self, const char* name, const char** attributes) {
    auto* tree = static_cast<XmlTree*>(self);
    constexpr std::size_t kDeepest = 100;
    if (tree->open_.size() == kDeepest) return tree->stop("elements are nested too deeply");
    auto element = std::make_unique<XmlElement>();
    element->name = name;
    element->line = platform::xmlLine(tree->parser_);
    for (; *attributes != nullptr; attributes += 2) {
      element->attributes[attributes[0]] = attributes[1];
    }
    XmlElement* opened = element.get();
    if (tree->open_.empty()) {
      tree->root_ = std::move(element);
    } else {
      tree->open_.back()->children.push_back(std::move(element));
    }
    tree->open_.push_back(opened);
  }
  static void onEnd(void* self, const char* /*name*/) {
    static_cast<XmlTree*>(self)->open_.pop_back();
  }
  static void onEntity(void* self, const char*, int, const char*, int, const char*, const char*,
                       const char*, const char*) {
    static_cast<XmlTree*>(self)->stop("declares an entity, which a URDF file does not need");
  }

  void stop(const char* problem) {
    problem_ = problem;
    XML_StopParser(parser_, XML_FALSE);
  }
  Place here() const { return file_.atLine(platform::xmlLine(parser_)); }

  const InputFile& file_;
  XML_Parser parser_ = nullptr;
  std::unique_ptr<XmlElement> root_;
  std::vector<XmlElement*> open_;
  std::string problem_;
};

/// One of the values of a joint that has several, as columns of a table name it: `base.x`.
struct JointPart {
  enum class Kind : std::uint8_t { Length, Angle, Number };

  const char* name;
  const char* inMoveIt;  // another name for it
  Kind kind = Kind::Length;
};

constexpr std::array<JointPart, 3> kPlanarParts = {
    {{"x", "x"}, {"y", "y"}, {"angle", "theta", JointPart::Kind::Angle}}};
constexpr std::array<JointPart, 7> kFloatingParts = {{{"x", "trans_x"},
                                                      {"y", "trans_y"},
                                                      {"z", "trans_z"},
                                                      {"qx", "rot_x", JointPart::Kind::Number},
                                                      {"qy", "rot_y", JointPart::Kind::Number},
                                                      {"qz", "rot_z", JointPart::Kind::Number},
                                                      {"qw", "rot_w", JointPart::Kind::Number}}};

/// A joint as the file has it.
struct UrdfJoint {
  std::string name;
  std::string type;
  std::uint64_t line = 0;
  std::size_t parent = 0;
  Pose origin = {};
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
  double lower = -HUGE_VAL;
  double upper = HUGE_VAL;
  double velocity = HUGE_VAL;
  std::string mimics = {};
  double multiplier = 1;
  double offset = 0;
  std::vector<double> times = {};   // of the values, which are there once they are known
  std::vector<double> values = {};  // radians or metres
  std::vector<std::vector<double>> partValues = {};  // of a joint with several

  bool moves() const { return turns() || type == "prismatic"; }
  bool turns() const { return type == "revolute" || type == "continuous"; }
  std::span<const JointPart> parts() const {
    if (type == "planar") return kPlanarParts;
    if (type == "floating") return kFloatingParts;
    return {};
  }
  std::string nameOf(const JointPart& part) const { return name + "." + part.name; }
};

/// The names that columns have for a part of a joint.
std::vector<std::string> columnNamesOf(const UrdfJoint& joint, const JointPart& part) {
  std::vector<std::string> names;
  for (const char* word : {part.name, part.inMoveIt}) {
    for (const char separator : {'.', '/', '_'}) names.push_back(joint.name + separator + word);
  }
  return names;
}

struct UrdfLink {
  std::string name;
  const XmlElement* element = nullptr;
  std::optional<UrdfJoint> joint = {};  // to its parent
};

class UrdfReader {
 public:
  UrdfReader(const InputFile& file, const UrdfOptions& options) : file_(file), options_(options) {}

  Result<LoadedMechanism> read(const InputFile& trajectory) {
    auto tree = XmlTree::read(file_);
    if (!tree) return tree.error();
    root_ = std::move(*tree);
    const auto conversion = model::lengthConversion("m", options_.lengthUnit);
    if (!conversion) {
      return invalid(
          fmt::format("is in metres, which cannot be converted to '{}'", options_.lengthUnit),
          file_.path.string());
    }
    scale_ = (*conversion)(1);
    loaded_.lengthUnit = options_.lengthUnit;
    loaded_.timeUnit = options_.timeUnit;
    loaded_.up = "z";  // by the conventions of ROS (REP 103)
    for (const auto step : {&UrdfReader::checkRoot, &UrdfReader::readLinks, &UrdfReader::readJoints,
                            &UrdfReader::sortLinks}) {
      if (auto done = (this->*step)(); !done) return done.error();
    }
    if (auto done = readTrajectory(trajectory); !done) return done.error();
    if (auto done = addLinks(); !done) return done.error();
    if (auto done = addSolids(); !done) return done.error();
    if (!loaded_.mechanism.span()) {
      return invalid("has no joint that moves", file_.path.string());
    }
    return std::move(loaded_);
  }

 private:
  Error wrong(const XmlElement& element, const std::string& message) const {
    return invalid(message, file_.atLine(element.line));
  }

  Result<void> checkRoot() {
    if (root_->name != "robot") {
      return wrong(*root_, fmt::format("found the element <{}>, expected <robot>: is it a URDF "
                                       "file?",
                                       shown(root_->name)));
    }
    for (const auto& child : root_->children) {
      if (!child->name.starts_with("xacro:")) continue;
      return wrong(*child, fmt::format("found <{}>: ", shown(child->name)) + templateAdvice());
    }
    return {};
  }

  std::string templateAdvice() const {
    const std::string name = file_.path.filename().string();
    return fmt::format("the file is a template; expand it first: xacro {} > robot.urdf", name);
  }

  /// A text of the file for a message, without controls.
  static std::string shown(const std::string& text) {
    const std::string quoted = inQuotes(text);
    return quoted.substr(1, quoted.size() - 2);
  }

  Result<std::string> nameOf(const XmlElement& element) const {
    const auto found = element.attributes.find("name");
    if (found == element.attributes.end() || found->second.empty()) {
      return wrong(element, fmt::format("<{}> has no name", shown(element.name)));
    }
    return found->second;
  }

  Result<double> number(const XmlElement& element, const char* attribute, double otherwise) const {
    const auto found = element.attributes.find(attribute);
    if (found == element.attributes.end()) return otherwise;
    const auto read = numbers(element, attribute, found->second, 1);
    if (!read) return read.error();
    return read->front();
  }

  Result<std::vector<double>> numbers(const XmlElement& element, const char* attribute,
                                      const std::string& text, std::size_t count) const {
    const InputFile words{file_.path, text};
    TextScanner scanner(words);
    std::vector<double> all;
    for (std::string_view word = scanner.wordAcrossLines(); !word.empty();
         word = scanner.wordAcrossLines()) {
      double value = 0;
      if (!scanner.parse(word, value, "a number") ||
          !(std::abs(value) <= model::kLargestCoordinate)) {
        const bool isTemplate = word.starts_with("$");
        return wrong(
            element,
            fmt::format("{} of <{}>: found {}, {}", attribute, shown(element.name), inQuotes(word),
                        isTemplate ? templateAdvice() : "expected a finite number"));
      }
      all.push_back(value);
    }
    if (all.size() == count) return all;
    return wrong(element,
                 fmt::format("{} of <{}>: found {}, expected {} number{}", attribute,
                             shown(element.name), inQuotes(text), count, count == 1 ? "" : "s"));
  }

  Result<Eigen::Vector3d> vector(const XmlElement& element, const char* attribute,
                                 const Eigen::Vector3d& otherwise) const {
    const auto found = element.attributes.find(attribute);
    if (found == element.attributes.end()) return otherwise;
    const auto read = numbers(element, attribute, found->second, 3);
    if (!read) return read.error();
    return Eigen::Vector3d(read->data());
  }

  /// The pose of <origin> in an element; the identity without.
  Result<Pose> originOf(const XmlElement& parent) const {
    const XmlElement* origin = parent.child("origin");
    if (origin == nullptr) return Pose();
    const auto xyz = vector(*origin, "xyz", Eigen::Vector3d::Zero());
    if (!xyz) return xyz.error();
    const auto rpy = vector(*origin, "rpy", Eigen::Vector3d::Zero());
    if (!rpy) return rpy.error();
    using Eigen::AngleAxisd;
    const Eigen::Quaterniond turn = AngleAxisd((*rpy)[2], Eigen::Vector3d::UnitZ()) *
                                    AngleAxisd((*rpy)[1], Eigen::Vector3d::UnitY()) *
                                    AngleAxisd((*rpy)[0], Eigen::Vector3d::UnitX());
    return Pose{turn.normalized().toRotationMatrix(), *xyz};
  }

  Result<void> readLinks() {
    for (const auto& element : root_->children) {
      if (element->name != "link") continue;
      const auto name = nameOf(*element);
      if (!name) return name.error();
      if (!linkNumbers_.emplace(*name, links_.size()).second) {
        return wrong(*element, fmt::format("there is a second link {}", inQuotes(*name)));
      }
      links_.push_back({*name, element.get()});
    }
    if (links_.empty()) return wrong(*root_, "has no <link>");
    if (links_.size() <= kMostLinks) return {};
    return wrong(*root_,
                 fmt::format("has {} links; at most {} are accepted", links_.size(), kMostLinks));
  }

  /// The number of the link that <parent> or <child> of a joint names.
  Result<std::size_t> linkOf(const XmlElement& joint, const char* role) const {
    const XmlElement* element = joint.child(role);
    if (element == nullptr) {
      return wrong(joint, fmt::format("the joint has no <{}>", role));
    }
    const auto link = element->attributes.find("link");
    if (link == element->attributes.end()) {
      return wrong(*element, fmt::format("<{}> names no link", role));
    }
    const auto found = linkNumbers_.find(link->second);
    if (found != linkNumbers_.end()) return found->second;
    return wrong(*element,
                 fmt::format("the {} is {}, which is not a link", role, inQuotes(link->second)));
  }

  Result<void> readJoints() {
    for (const auto& element : root_->children) {
      if (element->name != "joint") continue;
      UrdfJoint joint;
      const auto child = readJoint(*element, joint);
      if (!child) return child.error();
      if (!jointLinks_.emplace(joint.name, *child).second) {
        return wrong(*element, fmt::format("there is a second joint {}", inQuotes(joint.name)));
      }
      if (links_[*child].joint) {
        return wrong(
            *element,
            fmt::format("the link {} is the child of two joints, {} (line {}) and {}; a "
                        "robot is a tree",
                        inQuotes(links_[*child].name), inQuotes(links_[*child].joint->name),
                        links_[*child].joint->line, inQuotes(joint.name)));
      }
      links_[*child].joint = std::move(joint);
    }
    for (UrdfLink& link : links_) {
      if (!link.joint || link.joint->mimics.empty()) continue;
      if (jointLinks_.contains(link.joint->mimics)) continue;
      loaded_.notices.push_back(
          fmt::format("joint '{}' mimics '{}', which is not a joint: it is taken as one that "
                      "mimics none",
                      shown(link.joint->name), shown(link.joint->mimics)));
      link.joint->mimics.clear();
    }
    return {};
  }

  /// Returns the link that it moves.
  Result<std::size_t> readJoint(const XmlElement& element, UrdfJoint& joint) {
    const auto name = nameOf(element);
    if (!name) return name.error();
    joint.name = *name;
    joint.line = element.line;
    const auto type = element.attributes.find("type");
    joint.type = type == element.attributes.end() ? "" : type->second;
    constexpr std::array kTypes = {"fixed",     "revolute", "continuous",
                                   "prismatic", "floating", "planar"};
    if (std::ranges::find(kTypes, joint.type) == kTypes.end()) {
      return wrong(element,
                   fmt::format("joint {}: the type is {}, expected one of {}", inQuotes(joint.name),
                               inQuotes(joint.type), fmt::join(kTypes, ", ")));
    }
    const auto parent = linkOf(element, "parent");
    if (!parent) return parent;
    joint.parent = *parent;
    const auto child = linkOf(element, "child");
    if (!child) return child;
    const auto origin = originOf(element);
    if (!origin) return origin.error();
    joint.origin = *origin;
    if (auto axis = readAxis(element, joint); !axis) return axis.error();
    if (auto limits = readLimits(element, joint); !limits) return limits.error();
    if (auto mimic = readMimic(element, joint); !mimic) return mimic.error();
    return child;
  }

  Result<void> readAxis(const XmlElement& element, UrdfJoint& joint) const {
    const XmlElement* axis = element.child("axis");
    if (axis == nullptr || !(joint.moves() || joint.type == "planar")) return {};
    const auto xyz = vector(*axis, "xyz", joint.axis);
    if (!xyz) return xyz.error();
    const double length = xyz->stableNorm();
    if (!(length > 0)) {
      return wrong(*axis, fmt::format("joint {}: the axis has no direction, expected three numbers "
                                      "that are not all zero",
                                      inQuotes(joint.name)));
    }
    joint.axis = *xyz / length;
    return {};
  }

  Result<void> readLimits(const XmlElement& element, UrdfJoint& joint) {
    const XmlElement* limit = element.child("limit");
    if (limit == nullptr || !joint.moves()) return {};
    const auto velocity = number(*limit, "velocity", joint.velocity);
    if (!velocity) return velocity.error();
    if (*velocity < 0) {
      return wrong(*limit, fmt::format("joint {}: the velocity is {}, expected a number from 0 on",
                                       inQuotes(joint.name), *velocity));
    }
    // 0 is written where it is not known.
    if (*velocity > 0) joint.velocity = *velocity;
    if (joint.type == "continuous") return {};
    const auto lower = number(*limit, "lower", 0);
    if (!lower) return lower.error();
    const auto upper = number(*limit, "upper", 0);
    if (!upper) return upper.error();
    if (*lower > *upper) {
      loaded_.notices.push_back(
          fmt::format("joint '{}': its lower limit is {}, above the upper one, {}: it is taken as "
                      "without limits",
                      shown(joint.name), *lower, *upper));
      return {};
    }
    joint.lower = *lower;
    joint.upper = *upper;
    return {};
  }

  Result<void> readMimic(const XmlElement& element, UrdfJoint& joint) const {
    const XmlElement* mimic = element.child("mimic");
    if (mimic == nullptr || !joint.moves()) return {};
    const auto name = mimic->attributes.find("joint");
    if (name == mimic->attributes.end()) return wrong(*mimic, "<mimic> names no joint");
    joint.mimics = name->second;
    const auto multiplier = number(*mimic, "multiplier", 1);
    if (!multiplier) return multiplier.error();
    joint.multiplier = *multiplier;
    const auto offset = number(*mimic, "offset", 0);
    if (!offset) return offset.error();
    joint.offset = *offset;
    return {};
  }

  Result<void> sortLinks() {
    std::vector<std::size_t> parents;
    std::vector<std::string> roots;
    for (const UrdfLink& link : links_) {
      parents.push_back(link.joint ? link.joint->parent : Link::kWorld);
      if (!link.joint) roots.push_back(inQuotes(link.name));
    }
    std::vector<std::size_t> cycle;
    order_ = parentsFirst(parents, cycle);
    if (!cycle.empty()) {
      std::vector<std::string> names;
      for (const std::size_t i : cycle) names.push_back(inQuotes(links_[i].name));
      names.push_back(names.front());
      return wrong(*links_[cycle.front()].element,
                   fmt::format("links hang on each other: {}, each the parent of the one before "
                               "it; a robot is a tree",
                               fmt::join(names, ", ")));
    }
    if (roots.size() == 1) return {};
    return wrong(*root_, fmt::format("has {} roots, links that are the child of no joint: {}; "
                                     "expected one",
                                     roots.size(), fmt::join(roots, ", ")));
  }

  UrdfJoint& jointNamed(const std::string& name) {
    return *links_[jointLinks_.find(name)->second].joint;
  }

  Result<void> readTrajectory(const InputFile& file) {
    const std::filesystem::path& path = file.path;
    std::set<std::string> known;
    for (const auto& [name, link] : jointLinks_) {
      known.insert(name);
      for (const JointPart& part : jointNamed(name).parts()) {
        for (std::string& column : columnNamesOf(jointNamed(name), part)) {
          known.insert(std::move(column));
        }
      }
    }
    auto table = readJointTable(file, loaded_.timeUnit, known);
    if (!table) return table.error();
    nameNumbered(*table, known);
    if (!table->notices.empty()) {
      loaded_.notices.push_back(
          fmt::format("{}: {}", path.string(), fmt::join(table->notices, ", ")));
    }
    loaded_.otherFiles.push_back(path);
    std::set<const JointTable::Column*> used;
    std::vector<std::string> missing;
    std::vector<std::string> unread;
    for (const auto& [name, link] : jointLinks_) {
      UrdfJoint& joint = *links_[link].joint;
      if (auto taken = takeParts(joint, *table, used, path); !taken) return taken;
      const auto found = table->find(name);
      if (found.column == nullptr) {
        const bool rests = joint.moves() ? joint.mimics.empty()
                                         : joint.type != "fixed" && joint.partValues.empty();
        if (rests) missing.push_back(inQuotes(name));
        continue;
      }
      used.insert(found.column);
      if (!joint.moves() || !joint.mimics.empty()) {
        unread.push_back(inQuotes(found.column->name));
        continue;
      }
      const auto kind = joint.turns() ? JointPart::Kind::Angle : JointPart::Kind::Length;
      auto values = valuesOf(found, kind, path);
      if (!values) return values.error();
      joint.values = std::move(*values);
      joint.times = table->times;
    }
    if (auto all = checkAllUsed(*table, used, path); !all) return all;
    if (!missing.empty()) {
      loaded_.notices.push_back(fmt::format("{} has no column for {}, which stay{} at 0",
                                            path.string(), fmt::join(missing, ", "),
                                            missing.size() == 1 ? "s" : ""));
    }
    if (!unread.empty()) {
      loaded_.notices.push_back(
          fmt::format("{}: joints that are fixed, mimic others or have several values (NAME.x) are "
                      "not read: {}",
                      path.string(), fmt::join(unread, ", ")));
    }
    return followAll({table->times.front(), table->times.back()});
  }

  /// The names of all values that joints have of their own, from the root on.
  std::vector<std::string> valueNames() const {
    std::vector<std::string> names;
    for (const std::size_t link : order_) {
      const auto& joint = links_[link].joint;
      if (!joint) continue;
      if (joint->moves() && joint->mimics.empty()) names.push_back(joint->name);
      for (const JointPart& part : joint->parts()) names.push_back(joint->nameOf(part));
    }
    return names;
  }

  /// Gives numbered columns the names of values, if no column is known and there are as many.
  void nameNumbered(JointTable& table, const std::set<std::string>& known) {
    const std::vector<std::string> names = valueNames();
    const auto isThere = [&](const std::string& name) {
      return table.find(name).column != nullptr;
    };
    if (names.empty() || std::ranges::any_of(known, isThere)) return;
    for (const char* stem : {"actual_q", "q", "position", "positions", "joint", "target_q"}) {
      std::vector<JointTable::Column> columns;
      for (const JointTable::Column& column : table.columns) {
        if (column.name == fmt::format("{}_{}", stem, columns.size())) columns.push_back(column);
      }
      if (columns.size() != names.size()) continue;
      for (std::size_t i = 0; i < names.size(); ++i)
        columns[i].name = columns[i].unitless = names[i];
      loaded_.notices.push_back(
          fmt::format("the columns {}_0 to {}_{} are taken as {}; others are not read", stem, stem,
                      names.size() - 1, fmt::join(names, ", ")));
      table.columns = std::move(columns);
      return;
    }
  }

  Result<void> checkAllUsed(const JointTable& table,
                            const std::set<const JointTable::Column*>& used,
                            const std::filesystem::path& path) const {
    for (const JointTable::Column& column : table.columns) {
      if (used.contains(&column)) continue;
      std::vector<std::string> names;
      for (const auto& [name, link] : jointLinks_) {
        const UrdfJoint& joint = *links_[link].joint;
        if (joint.moves()) names.push_back(inQuotes(name));
        for (const JointPart& part : joint.parts()) names.push_back(inQuotes(joint.nameOf(part)));
      }
      return invalid(
          fmt::format("the column {} is not a joint of {}; its joints are {}",
                      inQuotes(column.name), file_.path.string(), fmt::join(names, ", ")),
          path.string());
    }
    return {};
  }

  /// The values of a column, in radians or metres.
  Result<std::vector<double>> valuesOf(const JointTable::Found& found, JointPart::Kind kind,
                                       const std::filesystem::path& path) const {
    std::vector<double> values = found.column->values;
    if (found.unit.empty()) return values;
    const bool turns = kind == JointPart::Kind::Angle;
    if (turns && found.unit == "rad") return values;
    if (turns && found.unit == "deg") {
      for (double& value : values) value *= model::kRadiansPerDegree;
      return values;
    }
    const auto conversion =
        kind == JointPart::Kind::Length ? model::lengthConversion(found.unit, "m") : std::nullopt;
    if (!conversion) {
      constexpr std::array kExpected = {"a unit of length", "rad or deg", "no unit"};
      return invalid(
          fmt::format("the column of {} is in '{}', expected {}", inQuotes(found.column->unitless),
                      found.unit, kExpected[static_cast<std::size_t>(kind)]),
          path.string());
    }
    for (double& value : values) value = (*conversion)(value);
    return values;
  }

  /// Takes the columns of a floating or planar joint: all of them, or none.
  Result<void> takeParts(UrdfJoint& joint, const JointTable& table,
                         std::set<const JointTable::Column*>& used,
                         const std::filesystem::path& path) const {
    std::vector<std::string> missing;
    for (const JointPart& part : joint.parts()) {
      JointTable::Found found;
      for (const std::string& name : columnNamesOf(joint, part)) {
        if (found.column == nullptr) found = table.find(name);
      }
      if (found.column == nullptr) {
        missing.push_back(inQuotes(joint.nameOf(part)));
        continue;
      }
      used.insert(found.column);
      auto values = valuesOf(found, part.kind, path);
      if (!values) return values.error();
      joint.partValues.push_back(std::move(*values));
    }
    if (missing.size() == joint.parts().size()) return {};
    joint.times = table.times;
    if (missing.empty()) return {};
    return invalid(fmt::format("has no column for {}, but for other values of the {} joint {}; "
                               "expected all of them",
                               fmt::join(missing, ", "), joint.type, inQuotes(joint.name)),
                   path.string());
  }

  /// Joints that mimic others get their values. One of those may mimic another one, or rest.
  Result<void> followAll(const model::TimeSpan& span) {
    for (UrdfLink& link : links_) {
      if (!link.joint || link.joint->mimics.empty()) continue;
      std::vector<UrdfJoint*> chain = {&*link.joint};
      while (!chain.back()->mimics.empty() && chain.back()->values.empty()) {
        UrdfJoint& next = jointNamed(chain.back()->mimics);
        if (std::ranges::find(chain, &next) != chain.end()) {
          return invalid(fmt::format("joint {} mimics itself, by way of {}", inQuotes(next.name),
                                     inQuotes(chain.back()->name)),
                         file_.atLine(chain.back()->line));
        }
        chain.push_back(&next);
      }
      if (chain.back()->values.empty()) {
        chain.back()->times = {span.begin, span.end};
        chain.back()->values = {0, 0};
      }
      for (std::size_t i = chain.size() - 1; i-- > 0;) follow(*chain[i + 1], *chain[i]);
    }
    return {};
  }

  static void follow(const UrdfJoint& leader, UrdfJoint& follower) {
    follower.times = leader.times;
    follower.values = leader.values;
    for (double& value : follower.values) value = follower.multiplier * value + follower.offset;
  }

  void noteLimits(const UrdfJoint& joint) {
    const std::string unit = joint.turns() ? "rad" : "m";
    std::string notice =
        noticeOfLimits(joint.name, joint.times, joint.values, joint.lower, joint.upper, unit);
    if (!notice.empty()) loaded_.notices.push_back(std::move(notice));
    std::size_t fast = 0;
    double fastest = 0;
    double when = 0;
    for (std::size_t i = 1; i < joint.values.size(); ++i) {
      const double speed =
          std::abs(joint.values[i] - joint.values[i - 1]) / (joint.times[i] - joint.times[i - 1]);
      if (!(speed > joint.velocity)) continue;
      ++fast;
      if (speed > fastest) {
        fastest = speed;
        when = joint.times[i - 1];
      }
    }
    if (fast == 0) return;
    loaded_.notices.push_back(fmt::format(
        "joint '{}' moves faster than its limit, {:.6g} {}/s, in {} of {} steps; the "
        "fastest is {:.6g}, from time {}",
        shown(joint.name), joint.velocity, unit, fast, joint.values.size() - 1, fastest, when));
  }

  Result<void> addLinks() {
    linkOf_.resize(links_.size());
    rest_.resize(links_.size());
    for (const std::size_t index : order_) {
      const UrdfLink& from = links_[index];
      Link link{from.name};
      rest_[index] = options_.place;
      if (from.joint) {
        const UrdfJoint& joint = *from.joint;
        link.parent = linkOf_[joint.parent];
        rest_[index] = rest_[joint.parent] * scaled(joint.origin);
        if (auto added = addMotion(joint, rest_[index], link); !added) {
          added.error().where = placeIn(file_.atLine(joint.line), "joint " + inQuotes(joint.name));
          return added;
        }
      }
      linkOf_[index] = loaded_.mechanism.links.size();
      loaded_.mechanism.links.push_back(std::move(link));
    }
    return {};
  }

  /// Gives the link the motion of its joint, if there are values.
  Result<void> addMotion(const UrdfJoint& joint, const Pose& rest, Link& link) {
    if (!joint.partValues.empty()) {
      return joint.type == "planar" ? addPlanar(joint, rest, link) : addFloating(joint, rest, link);
    }
    if (joint.values.empty() || !joint.moves()) return {};
    noteLimits(joint);
    return addValue(joint.name, joint.turns(), joint, joint.values, rest.translation,
                    rest.rotation * joint.axis, link);
  }

  /// Gives the link the motion of one value about, or along, an axis as it is at rest.
  Result<void> addValue(const std::string& name, bool turns, const UrdfJoint& joint,
                        const std::vector<double>& values, const model::Point3& origin,
                        const Eigen::Vector3d& axis, Link& link) {
    loaded_.joints.push_back({name, turns ? "rad" : "m", joint.times, values});
    model::Joint along;
    along.type = turns ? model::Joint::Type::Revolute : model::Joint::Type::Prismatic;
    along.origin = origin;
    along.axis = axis.normalized();
    std::vector<double> converted = values;
    for (double& value : converted) {
      value = turns ? value / model::kRadiansPerDegree : value * scale_;
    }
    auto motion = model::jointMotion(along, joint.times, converted);
    if (!motion) return motion.error();
    link.motion = std::move(*motion);
    return {};
  }

  /// A planar joint slides along two axes, by links of its own, and turns about the third.
  Result<void> addPlanar(const UrdfJoint& joint, const Pose& rest, Link& link) {
    const Eigen::Matrix3d plane =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), joint.axis).toRotationMatrix();
    if (joint.axis != Eigen::Vector3d::UnitZ()) {
      const auto text = [](const Eigen::Vector3d& axis) {
        const Eigen::Vector3d round = (1e4 * axis).array().round() / 1e4 + 0.0;  // without -0
        return fmt::format("({}, {}, {})", round.x(), round.y(), round.z());
      };
      loaded_.notices.push_back(fmt::format(
          "joint '{}' is planar about {}, its <axis> or, without one, that of URDF: x goes along "
          "{} and y along {} of its frame; write <axis xyz=\"0 0 1\"/> for those of the frame",
          shown(joint.name), text(joint.axis), text(plane.col(0)), text(plane.col(1))));
    }
    const Eigen::Matrix3d axes = rest.rotation * plane;
    for (int i = 0; i < 3; ++i) {
      const bool turns = kPlanarParts[i].kind == JointPart::Kind::Angle;
      const std::string name = joint.nameOf(kPlanarParts[i]);
      Link slide{name, link.parent};
      Link& moved = turns ? link : slide;
      auto added =
          addValue(name, turns, joint, joint.partValues[i], rest.translation, axes.col(i), moved);
      if (!added || turns) return added;
      link.parent = loaded_.mechanism.links.size();
      loaded_.mechanism.links.push_back(std::move(slide));
    }
    return {};
  }

  /// The poses of a floating joint are joined by screws.
  Result<void> addFloating(const UrdfJoint& joint, const Pose& rest, Link& link) {
    constexpr double kRounded = 1e-3;
    const Eigen::Quaterniond turned(rest.rotation);
    std::vector<model::KeyPose> poses;
    for (std::size_t i = 0; i < joint.times.size(); ++i) {
      const auto value = [&](int part) { return joint.partValues[part][i]; };
      const Eigen::Quaterniond q(value(6), value(3), value(4), value(5));
      if (!(std::abs(q.norm() - 1) <= kRounded)) {
        return invalid(fmt::format("has a quaternion of length {} at time {}, expected 1", q.norm(),
                                   joint.times[i]));
      }
      const Eigen::Quaterniond turn = turned * q.normalized() * turned.conjugate();
      const model::Point3 moved = rest(scale_ * model::Point3(value(0), value(1), value(2)));
      poses.push_back({joint.times[i], moved - turn * rest.translation, turn.normalized()});
    }
    auto motion = model::joinPoses(poses);
    if (!motion) return motion.error();
    for (model::HalfTurn& turn : motion->halfTurns) {
      turn.between += fmt::format(" of joint {}", inQuotes(joint.name));
      loaded_.halfTurns.push_back(turn);
    }
    link.motion = std::move(*motion);
    return {};
  }

  /// The pose converted from metres to the unit of the result.
  Pose scaled(Pose pose) const {
    pose.translation *= scale_;
    return pose;
  }

  std::string chosenGeometry() {
    if (!options_.geometry.empty()) return options_.geometry;
    const auto collides = [](const UrdfLink& link) {
      return link.element->child("collision") != nullptr;
    };
    if (std::ranges::any_of(links_, collides)) return "collision";
    loaded_.notices.emplace_back("no link has collision geometry: the visual geometry is taken");
    return "visual";
  }

  Result<void> addSolids() {
    std::vector<std::string> without;
    std::vector<Error> errors;
    geometry_ = chosenGeometry();
    for (std::size_t i = 0; i < links_.size(); ++i) {
      const UrdfLink& link = links_[i];
      std::size_t count = 0;
      for (const auto& element : link.element->children) {
        if (element->name != geometry_) continue;
        if (auto added = addSolid(i, *element, ++count); !added) {
          errors.push_back(std::move(added.error()));
        }
      }
      const char* other = geometry_ == "visual" ? "collision" : "visual";
      if (count == 0 && link.element->child(other) != nullptr) {
        without.push_back(inQuotes(link.name));
      }
    }
    if (!errors.empty()) return allErrors(std::move(errors));
    if (!without.empty()) {
      loaded_.notices.push_back(fmt::format("{} link{} no {} geometry and {} left out: {}",
                                            without.size(), without.size() == 1 ? " has" : "s have",
                                            geometry_, without.size() == 1 ? "is" : "are",
                                            fmt::join(without, ", ")));
    }
    if (!loaded_.solids.empty()) return {};
    return invalid(fmt::format("no link has {} geometry, of which a solid is made{}", geometry_,
                               options_.geometry.empty() ? ", nor collision geometry" : ""),
                   file_.path.string());
  }

  Result<void> addSolid(std::size_t index, const XmlElement& element, std::size_t count) {
    const UrdfLink& link = links_[index];
    MechanismSolid solid;
    solid.link = linkOf_[index];
    solid.name = uniqueName(count == 1 ? link.name : fmt::format("{} {}", link.name, count));
    solid.where = file_.atLine(element.line);
    const auto origin = originOf(element);
    if (!origin) return origin.error();
    solid.place = rest_[index] * scaled(*origin);
    const XmlElement* geometry = element.child("geometry");
    if (geometry == nullptr || geometry->children.empty()) {
      return wrong(element,
                   fmt::format("<{}> of link {} has no geometry", geometry_, inQuotes(link.name)));
    }
    auto mesh = meshOf(*geometry->children.front(), solid);
    if (!mesh) return mesh.error();
    solid.mesh = std::move(*mesh);
    if (scale_ != 1) {
      for (model::Point3& vertex : solid.mesh.vertices) vertex *= scale_;
    }
    loaded_.solids.push_back(std::move(solid));
    return {};
  }

  std::string uniqueName(const std::string& name) {
    const std::string base = asName(name);
    std::string unique = base;
    for (int i = 2; !solidNames_.insert(unique).second; ++i) unique = fmt::format("{} {}", base, i);
    return unique;
  }

  Result<double> sizeOf(const XmlElement& shape, const char* attribute) const {
    const auto size = number(shape, attribute, 0);
    if (!size || *size >= model::kSmallestExtent) return size;
    return wrong(shape, fmt::format("the {} of <{}> is {}, expected a size above 0", attribute,
                                    shown(shape.name), *size));
  }

  Result<model::TriangleMesh> meshOf(const XmlElement& shape, MechanismSolid& solid) {
    if (shape.name == "box") {
      const auto size = vector(shape, "size", Eigen::Vector3d::Zero());
      if (!size) return size.error();
      if (size->minCoeff() >= model::kSmallestExtent) return boxMesh(*size);
      return wrong(shape, "the size of <box> is not above 0 along each axis");
    }
    if (shape.name == "cylinder") {
      const auto radius = sizeOf(shape, "radius");
      if (!radius) return radius.error();
      const auto length = sizeOf(shape, "length");
      if (!length) return length.error();
      return cylinderMesh(*radius, *length);
    }
    if (shape.name == "capsule") {
      const auto radius = sizeOf(shape, "radius");
      if (!radius) return radius.error();
      const auto length = sizeOf(shape, "length");
      if (!length) return length.error();
      return capsuleMesh(*radius, *length);
    }
    if (shape.name == "sphere") {
      const auto radius = sizeOf(shape, "radius");
      if (!radius) return radius.error();
      return sphereMesh(*radius);
    }
    if (shape.name == "mesh") return fileMesh(shape, solid);
    return wrong(shape, fmt::format("found <{}>, expected box, cylinder, capsule, sphere or mesh",
                                    shown(shape.name)));
  }

  Result<model::TriangleMesh> fileMesh(const XmlElement& shape, MechanismSolid& solid) {
    const auto name = shape.attributes.find("filename");
    if (name == shape.attributes.end()) return wrong(shape, "<mesh> has no filename");
    const auto path = pathOf(shape, name->second);
    if (!path) return path.error();
    auto mesh = readSolid(*path, solid, loaded_);
    if (!mesh) {
      mesh.error().where = placeIn(file_.atLine(shape.line), mesh.error().where.text());
      return mesh;
    }
    const auto scale = vector(shape, "scale", Eigen::Vector3d::Ones());
    if (!scale) return scale.error();
    if (scale->prod() == 0) return wrong(shape, "the scale of <mesh> has a zero");
    for (model::Point3& vertex : mesh->vertices) vertex = vertex.cwiseProduct(*scale);
    if (scale->prod() < 0) {
      for (model::Triangle& triangle : mesh->triangles) std::swap(triangle[1], triangle[2]);
    }
    return mesh;
  }

  /// The path of a mesh (package_path.h).
  Result<std::filesystem::path> pathOf(const XmlElement& shape, const std::string& name) const {
    constexpr std::string_view kPackage = "package://";
    constexpr std::string_view kFile = "file://";
    const std::filesystem::path folder = file_.path.parent_path();
    if (name.starts_with(kFile)) return std::filesystem::path(name.substr(kFile.size()));
    if (!name.starts_with(kPackage)) return folder / name;
    const std::string rest = name.substr(kPackage.size());
    if (auto found = packageFile(rest, folder, options_.packages)) return std::move(*found);
    const std::string package = rest.substr(0, rest.find('/'));
    return fail(
        ErrorCode::Io,
        fmt::format("the mesh {} was not found in the folders that contain this file, nor in "
                    "ROS_PACKAGE_PATH and AMENT_PREFIX_PATH: say where the package is "
                    "(--package {}=FOLDER)",
                    printable(name), printable(package)),
        file_.atLine(shape.line));
  }

  /// A whole text without controls.
  static std::string printable(std::string text) {
    std::ranges::replace_if(
        text, [](unsigned char c) { return std::iscntrl(c) != 0; }, '?');
    return text;
  }

  const InputFile& file_;
  const UrdfOptions& options_;
  std::unique_ptr<XmlElement> root_;
  std::vector<UrdfLink> links_;
  std::map<std::string, std::size_t> linkNumbers_;
  std::map<std::string, std::size_t> jointLinks_;  // the link that each joint moves
  std::vector<std::size_t> order_;                 // links, parents first
  std::vector<std::size_t> linkOf_;                // of the mechanism, for each link
  std::vector<Pose> rest_;                         // of each link in the world
  std::set<std::string> solidNames_;
  std::string geometry_;
  double scale_ = 1;  // of metres
  LoadedMechanism loaded_;
};

}  // namespace

Result<LoadedMechanism> readUrdf(const std::filesystem::path& path,
                                 const std::filesystem::path& trajectory,
                                 const UrdfOptions& options) {
  const auto file = readInputFile(path);
  if (!file) return file.error();
  const auto table = readInputFile(trajectory);
  if (!table) return table.error();
  return readUrdf(*file, *table, options);
}

Result<LoadedMechanism> readUrdf(const InputFile& file, const InputFile& trajectory,
                                 const UrdfOptions& options) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 27;
  if (file.bytes.size() > kMostBytes) {
    return invalid(
        fmt::format("has {} bytes; a robot has at most {}", file.bytes.size(), kMostBytes),
        file.path.string());
  }
  return UrdfReader(file, options).read(trajectory);
}

}  // namespace t4d::formats

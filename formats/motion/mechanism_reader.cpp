#include "formats/motion/mechanism_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "formats/file_extension.h"
#include "formats/gltf/gltf_reader.h"
#include "formats/motion/basic_solids.h"
#include "formats/motion/joint_table.h"
#include "formats/motion/urdf_reader.h"
#include "formats/t4d/names.h"
#include "formats/text/json_check.h"
#include "formats/text/json_object.h"
#include "model/degrees.h"
#include "model/limits.h"
#include "model/units.h"
#include "t4d/motion.h"
#include "t4d/surface.h"

namespace t4d::formats {
namespace {

using model::Link;
using nlohmann::json;

enum class JointKind { Fixed, Revolute, Prismatic, Screw, Free };

constexpr const char* kJointKinds = "fixed, revolute, prismatic, screw or free";

std::optional<JointKind> jointKind(const std::string& name) {
  static const std::map<std::string, JointKind> kNames = {{"fixed", JointKind::Fixed},
                                                          {"revolute", JointKind::Revolute},
                                                          {"prismatic", JointKind::Prismatic},
                                                          {"screw", JointKind::Screw},
                                                          {"free", JointKind::Free}};
  const auto found = kNames.find(name);
  return found == kNames.end() ? std::nullopt : std::optional(found->second);
}

/// Values of a joint over time, in the angle or length unit of the file.
struct JointValues {
  std::vector<double> times;
  std::vector<double> values;
};

/// A body as the file has it.
struct FileBody {
  const json* value = nullptr;
  Place where;
  std::string name;
  std::string parent;
  JointKind kind = JointKind::Fixed;
  model::Joint joint;
  std::optional<std::pair<double, double>> limits;
  std::optional<JointValues> values;  // of a joint with one value, once known
};

class MechanismParser {
 public:
  explicit MechanismParser(const InputFile& file) : file_(file), name_(file.path.string()) {}

  Result<LoadedMechanism> parse(const json& value) {
    const JsonObject whole(
        value, placeIn(name_, "mechanism"),
        {"$schema", "length_unit", "time_unit", "angle_unit", "bodies", "robots"});
    loaded_.lengthUnit = whole.text("length_unit");
    loaded_.timeUnit = whole.text("time_unit");
    angleUnit_ = whole.text("angle_unit");
    if (!angleUnit_.empty() && angleUnit_ != "deg" && angleUnit_ != "rad") {
      refuseJson(fmt::format("is '{}', expected deg or rad", angleUnit_),
                 whole.where("angle_unit"));
    }
    const bool hasRobots = whole.has("robots") && !whole.array("robots").empty();
    if (!hasRobots || whole.has("bodies")) readBodies(whole);
    if (bodies_.empty() && !hasRobots)
      refuseJson("is empty, expected a body or more", whole.where("bodies"));
    sortBodies(whole.where("bodies"));
    for (std::size_t i = 0; i < bodies_.size(); ++i) readMotion(i);
    for (std::size_t i = 0; i < bodies_.size(); ++i) addLink(i);
    std::vector<Error> errors;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (auto added = addSolid(i); !added) errors.push_back(std::move(added.error()));
    }
    if (!errors.empty()) return allErrors(std::move(errors));
    if (hasRobots) {
      std::size_t number = 0;
      for (const json& robot : whole.array("robots")) {
        addRobot(robot, placeIn(name_, fmt::format("robots[{}]", number++)));
      }
    }
    if (loaded_.solids.empty()) {
      refuseJson("have no solid, expected one or more", whole.where("bodies"));
    }
    if (!loaded_.mechanism.span()) {
      refuseJson("have no motion, expected one or more: nothing moves", whole.where("bodies"));
    }
    addRestNotices();
    return std::move(loaded_);
  }

 private:
  static JsonObject bodyObject(const json& value, const Place& where) {
    return {value,
            where,
            {"name", "solid", "unit", "position", "quaternion", "parent", "joint", "motion"}};
  }

  void readBodies(const JsonObject& whole) {
    if (whole.array("bodies").size() > kMostLinks) {
      refuseJson(fmt::format("has {} bodies, expected at most {}", whole.array("bodies").size(),
                             kMostLinks),
                 whole.where("bodies"));
    }
    for (const json& body : whole.array("bodies")) {
      readBody(body, placeIn(name_, fmt::format("bodies[{}]", bodies_.size())));
    }
  }

  void addRobot(const json& value, const Place& where) {
    const JsonObject object(
        value, where, {"name", "robot", "motion", "geometry", "position", "quaternion", "parent"});
    object.need("robot");
    object.need("motion");
    const std::filesystem::path folder = file_.path.parent_path();
    const std::filesystem::path path = folder / object.text("robot");
    if (loaded_.lengthUnit.empty()) loaded_.lengthUnit = "m";
    takeTimeUnit("s");
    UrdfOptions how;
    how.geometry = object.text("geometry");
    if (!how.geometry.empty() && how.geometry != "collision" && how.geometry != "visual") {
      refuseJson(fmt::format("is '{}', expected collision or visual", how.geometry),
                 object.where("geometry"));
    }
    how.place = placeOf(object);
    how.lengthUnit = loaded_.lengthUnit;
    how.timeUnit = loaded_.timeUnit;
    auto robot = readUrdf(path, folder / object.text("motion"), how);
    if (!robot) throw JsonRefusal{robot.error()};
    std::size_t parent = Link::kWorld;
    if (const std::string on = object.text("parent"); !on.empty()) {
      const std::size_t body = numberOf(on);
      if (body == Link::kWorld) {
        refuseJson(fmt::format("is '{}', which is not a body; bodies are {}", on, allNames()),
                   object.where("parent"));
      }
      parent = linkOf_[body];
    }
    loaded_.otherFiles.push_back(path);
    const std::string twice = addMechanism(std::move(*robot), object.text("name"), parent, loaded_);
    if (twice.empty()) return;
    refuseJson(fmt::format("has a link {}, a name that is taken; give the robot a name of its own",
                           inSingleQuotes(twice)),
               object.where());
  }

  /// `position` and `quaternion`.
  static model::Pose placeOf(const JsonObject& object) {
    model::Pose place;
    place.translation = object.numbers<3>("position", model::Point3::Zero());
    checkSize(place.translation.cwiseAbs().maxCoeff(), object.where("position"));
    const Eigen::Vector4d q = object.numbers<4>("quaternion", Eigen::Vector4d::UnitW());
    constexpr double kRounded = 1e-6;
    if (!(std::abs(q.norm() - 1) <= kRounded)) {
      refuseJson(fmt::format("has length {}, expected 1", q.norm()), object.where("quaternion"));
    }
    place.rotation = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix();
    return place;
  }

  void readBody(const json& value, const Place& where) {
    const JsonObject object = bodyObject(value, where);
    FileBody body;
    body.value = &value;
    body.where = where;
    object.need("name");
    body.name = object.text("name");
    if (const auto good = checkName(body.name); !good) {
      refuseJson(good.error().message, object.where("name"));
    }
    for (const FileBody& other : bodies_) {
      if (other.name != body.name) continue;
      refuseJson(fmt::format("is '{}', the name of {}; give each body its own", body.name,
                             other.where.part),
                 object.where("name"));
    }
    body.parent = object.text("parent");
    if (object.has("joint")) readJoint(object.need("joint"), object.where("joint"), body);
    bodies_.push_back(std::move(body));
  }

  void readJoint(const json& value, const Place& where, FileBody& body) {
    const JsonObject joint(value, where, {"type", "axis", "origin", "pitch", "limits"});
    joint.need("type");
    const std::string type = joint.text("type");
    const auto kind = jointKind(type);
    if (!kind) {
      refuseJson(fmt::format("is '{}', expected {}", type, kJointKinds), joint.where("type"));
    }
    body.kind = *kind;
    const bool hasValue = *kind != JointKind::Fixed && *kind != JointKind::Free;
    for (const char* key : {"axis", "origin", "limits"}) {
      if (!hasValue && joint.has(key)) {
        refuseJson(fmt::format("is given, but a {} joint has none", type), joint.where(key));
      }
    }
    if ((*kind == JointKind::Screw) != joint.has("pitch")) {
      refuseJson(joint.has("pitch") ? "is given, but only a screw joint has a pitch"
                                    : "is missing: the length of a turn of a screw joint",
                 joint.where("pitch"));
    }
    if (!hasValue) return;
    joint.need("axis");
    const Eigen::Vector3d axis = joint.numbers<3>("axis", Eigen::Vector3d::UnitZ());
    if (!(axis.stableNorm() > 0) || !std::isfinite(axis.stableNorm())) {
      refuseJson("has no direction, expected three numbers that are not all zero",
                 joint.where("axis"));
    }
    body.joint.axis = axis / axis.stableNorm();
    body.joint.origin = joint.numbers<3>("origin", model::Point3::Zero());
    checkSize(body.joint.origin.cwiseAbs().maxCoeff(), joint.where("origin"));
    body.joint.pitch = joint.number("pitch", 0);
    checkSize(std::abs(body.joint.pitch), joint.where("pitch"));
    body.joint.type = *kind == JointKind::Revolute    ? model::Joint::Type::Revolute
                      : *kind == JointKind::Prismatic ? model::Joint::Type::Prismatic
                                                      : model::Joint::Type::Screw;
    if (!joint.has("limits")) return;
    const Eigen::Vector2d limits = joint.numbers<2>("limits", Eigen::Vector2d::Zero());
    if (!(limits[0] <= limits[1])) {
      refuseJson(fmt::format("are {} and {}, expected the lower one first", limits[0], limits[1]),
                 joint.where("limits"));
    }
    body.limits = {limits[0], limits[1]};
  }

  static void checkSize(double magnitude, const Place& where) {
    if (magnitude <= model::kLargestCoordinate) return;
    refuseJson(fmt::format("has a magnitude of {:.3g}; the largest possible is {}", magnitude,
                           model::kLargestCoordinate),
               where);
  }

  std::size_t numberOf(const std::string& name) const {
    const auto found = std::ranges::find(bodies_, name, &FileBody::name);
    return found == bodies_.end() ? Link::kWorld
                                  : static_cast<std::size_t>(found - bodies_.begin());
  }

  std::string allNames() const {
    std::vector<std::string> names;
    for (const FileBody& body : bodies_) names.push_back(inSingleQuotes(body.name));
    return fmt::format("{}", fmt::join(names, ", "));
  }
  static std::string inSingleQuotes(const std::string& text) { return "'" + text + "'"; }

  /// Finds the parents, and which links come first.
  void sortBodies(const Place& where) {
    for (const FileBody& body : bodies_) {
      parents_.push_back(body.parent.empty() ? Link::kWorld : numberOf(body.parent));
      if (body.parent.empty() || parents_.back() != Link::kWorld) continue;
      refuseJson(
          fmt::format("is '{}', which is not a body; bodies are {}", body.parent, allNames()),
          jsonPlace(body.where, ".parent"));
    }
    std::vector<std::size_t> cycle;
    order_ = parentsFirst(parents_, cycle);
    if (cycle.empty()) return;
    std::vector<std::string> names;
    for (const std::size_t i : cycle) names.push_back(inSingleQuotes(bodies_[i].name));
    names.push_back(names.front());
    refuseJson(fmt::format("hang on each other: {}, each the parent of the one before it; cut the "
                           "loop at one joint, and give the motions of the others",
                           fmt::join(names, ", ")),
               where);
  }

  void readMotion(std::size_t index) {
    FileBody& body = bodies_[index];
    const JsonObject object = bodyObject(*body.value, body.where);
    if (!object.has("motion")) {
      const bool movable = body.kind != JointKind::Fixed;
      if (movable) resting_.push_back(body.name);
      return;
    }
    if (body.kind == JointKind::Fixed) {
      refuseJson(
          "is given, but the joint of the body is fixed: name its type, revolute, "
          "prismatic, screw or free",
          object.where("motion"));
    }
    std::vector<std::size_t> followers;
    if (body.kind != JointKind::Free) valuesOf(index, followers);
  }

  /// The values of a joint; reads them first, and those that it follows.
  const JointValues& valuesOf(std::size_t index, std::vector<std::size_t>& followers) {
    FileBody& body = bodies_[index];
    if (body.values) return *body.values;
    const Place where = jsonPlace(body.where, ".motion");
    if (std::ranges::find(followers, index) != followers.end()) {
      refuseJson("follows itself, by way of the joints that it follows", where);
    }
    followers.push_back(index);
    const JsonObject motion((*body.value)["motion"], where,
                            {"times", "values", "file", "column", "follows", "ratio", "offset"});
    const int ways = static_cast<int>(motion.has("values")) + static_cast<int>(motion.has("file")) +
                     static_cast<int>(motion.has("follows"));
    if (ways != 1) {
      refuseJson("says in " + std::string(ways == 0 ? "no" : "more than one") +
                     " way how the joint moves, expected one of values (with times), file (with "
                     "column) and follows (with ratio)",
                 where);
    }
    allowOnly(motion,
              motion.has("values") ? "times"
              : motion.has("file") ? "column"
                                   : "ratio",
              motion.has("follows"));
    JointValues values = motion.has("values") ? inlineValues(motion)
                         : motion.has("file") ? tableValues(motion, body)
                                              : followedValues(motion, followers);
    if (body.kind != JointKind::Prismatic) needAngleUnit(where);
    noteLimits(body, values);
    body.values = std::move(values);
    return *body.values;
  }

  /// Refuses members of the other ways.
  static void allowOnly(const JsonObject& motion, const std::string& partner, bool follows) {
    for (const char* key : {"times", "column", "ratio", "offset"}) {
      const bool fits = key == partner || (follows && std::string_view(key) == "offset");
      if (motion.has(key) && !fits) {
        refuseJson("does not belong to the other members of the motion", motion.where(key));
      }
    }
  }

  static std::vector<double> numbersOf(const JsonObject& object, const char* key) {
    std::vector<double> numbers;
    for (const json& one : object.array(key)) {
      if (!one.is_number()) {
        refuseJson("is not a number",
                   jsonPlace(object.where(key), fmt::format("[{}]", numbers.size())));
      }
      numbers.push_back(one.get<double>());
    }
    return numbers;
  }

  static JointValues inlineValues(const JsonObject& motion) {
    motion.need("times");
    JointValues values{numbersOf(motion, "times"), numbersOf(motion, "values")};
    if (values.times.size() == values.values.size()) return values;
    refuseJson(fmt::format("has {} numbers, and times {}; expected a value for each time",
                           values.values.size(), values.times.size()),
               motion.where("values"));
  }

  JointValues tableValues(const JsonObject& motion, const FileBody& body) {
    const std::filesystem::path path = file_.path.parent_path() / motion.text("file");
    motion.need("column");
    const std::string column = motion.text("column");
    const JointTable& table = tableAt(path, motion.where("file"));
    const auto [found, unit] = table.find(column);
    if (found == nullptr) {
      std::vector<std::string> names;
      for (const auto& one : table.columns) names.push_back(inSingleQuotes(one.name));
      refuseJson(fmt::format("is '{}', which {} does not have; its columns are {}", column,
                             path.string(), fmt::join(names, ", ")),
                 motion.where("column"));
    }
    JointValues values{table.times, found->values};
    if (unit.empty()) return values;
    const bool ofLength = body.kind == JointKind::Prismatic;
    if (ofLength) {
      const auto conversion = model::lengthConversion(unit, loaded_.lengthUnit);
      if (!conversion) {
        refuseLengthUnit(unit, motion.where("column"));
      }
      for (double& value : values.values) value = (*conversion)(value);
      return values;
    }
    if (unit != "deg" && unit != "rad") {
      refuseJson(fmt::format("is in '{}', expected deg or rad", unit), motion.where("column"));
    }
    // Values are converted to the unit of the file, from which all are converted.
    if (angleUnit_.empty()) angleUnit_ = unit;
    if (unit != angleUnit_) {
      for (double& value : values.values) {
        value = unit == "rad" ? value * model::kDegreesPerRadian : value / model::kDegreesPerRadian;
      }
    }
    return values;
  }

  [[noreturn]] void refuseLengthUnit(const std::string& unit, const Place& where) const {
    refuseJson(
        loaded_.lengthUnit.empty()
            ? fmt::format("is in '{}', and the mechanism has no length_unit; give it one", unit)
            : fmt::format("is in '{}', which cannot be converted to the length_unit, '{}'", unit,
                          loaded_.lengthUnit),
        where);
  }

  const JointTable& tableAt(const std::filesystem::path& path, const Place& where) {
    const auto known = tables_.find(path);
    if (known != tables_.end()) return known->second;
    auto file = readInputFile(path);
    if (!file) refuseJson(fmt::format("names {}", file.error().text()), where);
    auto table = readJointTable(*file, loaded_.timeUnit, namedColumns());
    if (!table) throw JsonRefusal{table.error()};
    takeTimeUnit(table->timeUnit);
    if (!table->notices.empty()) {
      loaded_.notices.push_back(
          fmt::format("{}: {}", path.string(), fmt::join(table->notices, ", ")));
    }
    loaded_.otherFiles.push_back(path);
    return tables_.emplace(path, std::move(*table)).first->second;
  }

  /// The columns that motions name, of any table.
  std::set<std::string> namedColumns() const {
    std::set<std::string> names;
    for (const FileBody& body : bodies_) {
      const json motion = body.value->value("motion", json());
      if (!motion.is_object() || !motion.contains("column")) continue;
      if (motion["column"].is_string()) names.insert(motion["column"].get<std::string>());
    }
    return names;
  }

  /// Takes the unit of a table; that of the file comes first.
  void takeTimeUnit(const std::string& unit) {
    if (loaded_.timeUnit.empty()) loaded_.timeUnit = unit;
  }

  JointValues followedValues(const JsonObject& motion, std::vector<std::size_t>& followers) {
    const std::string name = motion.text("follows");
    const std::size_t leader = numberOf(name);
    if (leader == Link::kWorld) {
      refuseJson(fmt::format("is '{}', which is not a body; bodies are {}", name, allNames()),
                 motion.where("follows"));
    }
    const FileBody& other = bodies_[leader];
    const bool moves = other.kind != JointKind::Fixed && other.kind != JointKind::Free &&
                       other.value->contains("motion");
    if (!moves) {
      refuseJson(fmt::format("is '{}', whose joint has no values over time", name),
                 motion.where("follows"));
    }
    JointValues values = valuesOf(leader, followers);
    const double ratio = motion.number("ratio", 1);
    const double offset = motion.number("offset", 0);
    for (double& value : values.values) value = ratio * value + offset;
    return values;
  }

  void needAngleUnit(const Place& where) const {
    if (!angleUnit_.empty()) return;
    refuseJson(
        "is an angle, and nothing says whether in degrees or radians: give the file an "
        "angle_unit, deg or rad",
        where);
  }

  void noteLimits(const FileBody& body, const JointValues& values) {
    if (!body.limits) return;
    const std::string unit = body.kind == JointKind::Prismatic ? loaded_.lengthUnit : angleUnit_;
    const std::string notice = noticeOfLimits(body.name, values.times, values.values,
                                              body.limits->first, body.limits->second, unit);
    if (!notice.empty()) loaded_.notices.push_back(notice);
  }

  void addLink(std::size_t number) {
    const std::size_t index = order_[number];
    const FileBody& body = bodies_[index];
    linkOf_.resize(bodies_.size());
    linkOf_[index] = number;
    Link link{
        body.name, parents_[index] == Link::kWorld ? Link::kWorld : linkOf_[parents_[index]], {}};
    const Place where = jsonPlace(body.where, ".motion");
    if (body.values) {
      std::vector<double> values = body.values->values;
      const bool slides = body.kind == JointKind::Prismatic;
      loaded_.joints.push_back(
          {body.name, slides ? loaded_.lengthUnit : angleUnit_, body.values->times, values});
      if (body.kind != JointKind::Prismatic && angleUnit_ == "rad") {
        for (double& value : values) value *= model::kDegreesPerRadian;
      }
      auto motion = model::jointMotion(body.joint, body.values->times, values);
      if (!motion) refuseJson(motion.error().text(), where);
      link.motion = std::move(*motion);
    } else if (body.kind == JointKind::Free && body.value->contains("motion")) {
      link.motion = freeMotion((*body.value)["motion"], where);
    }
    loaded_.mechanism.links.push_back(std::move(link));
  }

  /// The motion of a free joint: a motion as in a file of its own, or the name of one.
  model::Motion freeMotion(const json& value, const Place& where) {
    if (!value.is_object() || !value.contains("file")) {
      auto motion = parseMotion(value.dump(), where);
      if (!motion) throw JsonRefusal{motion.error()};
      checkUnits(*motion, where);
      return takeHalfTurns(std::move(*motion), where);
    }
    const JsonObject object(value, where, {"file", "angles", "quaternion"});
    const std::filesystem::path path = file_.path.parent_path() / object.text("file");
    MotionTableOptions table{object.text("angles"), object.text("quaternion")};
    const std::string extension = lowerCaseExtension(path);
    if (extension != ".json") {
      table.lengthUnit = loaded_.lengthUnit;
      table.timeUnit = loaded_.timeUnit;
    }
    std::string form;
    auto motion = formats::readMotion(path, &form, table);
    if (!motion) throw JsonRefusal{motion.error()};
    if (!form.empty()) loaded_.notices.push_back(path.string() + ": " + form);
    loaded_.otherFiles.push_back(path);
    checkUnits(*motion, path.string());
    return takeHalfTurns(std::move(*motion), path.string());
  }

  void checkUnits(const model::Motion& motion, const Place& where) {
    takeTimeUnit(motion.timeUnit);
    if (loaded_.lengthUnit.empty()) loaded_.lengthUnit = motion.lengthUnit;
    const bool fits = (motion.timeUnit.empty() || motion.timeUnit == loaded_.timeUnit) &&
                      (motion.lengthUnit.empty() || motion.lengthUnit == loaded_.lengthUnit);
    if (fits) return;
    refuseJson(
        fmt::format("is in '{}' and '{}', and the mechanism in '{}' and '{}'; use the same "
                    "units",
                    motion.lengthUnit, motion.timeUnit, loaded_.lengthUnit, loaded_.timeUnit),
        where);
  }

  model::Motion takeHalfTurns(model::Motion motion, const Place& where) {
    for (model::HalfTurn turn : motion.halfTurns) {
      turn.between += " of " + where.text();
      loaded_.halfTurns.push_back(std::move(turn));
    }
    return motion;
  }

  Result<void> addSolid(std::size_t index) {
    const FileBody& body = bodies_[index];
    const JsonObject object = bodyObject(*body.value, body.where);
    if (object.has("unit") && !(object.has("solid") && object.need("solid").is_string())) {
      refuseJson("is given, but the body has no solid in a file", object.where("unit"));
    }
    if (!object.has("solid")) return {};
    MechanismSolid solid{body.name, linkOf_[index]};
    solid.place = placeOf(object);
    const json& value = object.need("solid");
    if (value.is_object()) {
      solid.mesh = basicSolid(value, object.where("solid"));
      solid.where = object.where("solid");
    } else {
      const std::filesystem::path path = file_.path.parent_path() / object.text("solid");
      auto mesh = readSolid(path, solid, loaded_);
      if (!mesh) {
        mesh.error().where = placeIn(body.where, mesh.error().where.text());
        return mesh.error();
      }
      solid.mesh = std::move(*mesh);
      convertSolid(object, path, solid.mesh);
    }
    loaded_.solids.push_back(std::move(solid));
    return {};
  }

  /// Converts a solid from the unit of its file, which in glTF and COLLADA is the metre, to that of
  /// the mechanism.
  void convertSolid(const JsonObject& body, const std::filesystem::path& path,
                    model::TriangleMesh& mesh) const {
    const std::string extension = lowerCaseExtension(path);
    const bool inMetres = extension == ".glb" || extension == ".gltf";
    std::string unit = body.text("unit");
    if (unit.empty()) unit = inMetres && !loaded_.lengthUnit.empty() ? "m" : loaded_.lengthUnit;
    const auto conversion = model::lengthConversion(unit, loaded_.lengthUnit);
    if (!conversion) refuseLengthUnit(unit, body.where("unit"));
    if (conversion->isIdentity()) return;
    for (model::Point3& vertex : mesh.vertices) {
      for (double& coordinate : vertex) coordinate = (*conversion)(coordinate);
    }
  }

  static model::TriangleMesh basicSolid(const json& value, const Place& where) {
    const JsonObject solid(value, where, {"box", "cylinder", "sphere"});
    if (value.size() != 1) refuseJson("expected one of box, cylinder and sphere", where);
    const auto positive = [&](double size, const Place& place) {
      if (size >= model::kSmallestExtent && size <= model::kLargestCoordinate) return size;
      refuseJson(fmt::format("has a size of {}, expected one from {} to {}", size,
                             model::kSmallestExtent, model::kLargestCoordinate),
                 place);
    };
    if (solid.has("box")) {
      const Eigen::Vector3d size = solid.numbers<3>("box", Eigen::Vector3d::Zero());
      for (const double side : size) positive(side, solid.where("box"));
      return boxMesh(size);
    }
    if (solid.has("sphere")) {
      return sphereMesh(positive(solid.number("sphere", 0), solid.where("sphere")));
    }
    const JsonObject cylinder(solid.need("cylinder"), solid.where("cylinder"),
                              {"radius", "length"});
    return cylinderMesh(positive(cylinder.number("radius", 0), cylinder.where("radius")),
                        positive(cylinder.number("length", 0), cylinder.where("length")));
  }

  void addRestNotices() {
    if (!resting_.empty()) {
      for (std::string& name : resting_) name = inSingleQuotes(name);
      loaded_.notices.push_back(
          fmt::format("{} joint{} no motion and stay{} at rest: {}", resting_.size(),
                      resting_.size() == 1 ? " has" : "s have", resting_.size() == 1 ? "s" : "",
                      fmt::join(resting_, ", ")));
    }
    const model::TimeSpan all = *loaded_.mechanism.span();
    for (const Link& link : loaded_.mechanism.links) {
      if (!link.motion) continue;
      if (link.motion->timeBegin() == all.begin && link.motion->timeEnd() == all.end) continue;
      loaded_.notices.push_back(fmt::format(
          "'{}' moves from time {} to {} of {} to {}, and rests before and after", link.name,
          link.motion->timeBegin(), link.motion->timeEnd(), all.begin, all.end));
    }
  }

  const InputFile& file_;
  std::string name_;
  std::string angleUnit_;
  std::vector<FileBody> bodies_;
  std::vector<std::size_t> parents_;
  std::vector<std::size_t> order_;   // bodies, parents first
  std::vector<std::size_t> linkOf_;  // of each body
  std::map<std::filesystem::path, JointTable> tables_;
  std::vector<std::string> resting_;
  LoadedMechanism loaded_;
};

}  // namespace

std::string addMechanism(LoadedMechanism more, const std::string& name, std::size_t parent,
                         LoadedMechanism& into) {
  const auto named = [&](const std::string& own) { return name.empty() ? own : name + " " + own; };
  const std::size_t before = into.mechanism.links.size();
  for (Link& link : more.mechanism.links) {
    link.name = named(link.name);
    link.parent = link.parent == Link::kWorld ? parent : link.parent + before;
    into.mechanism.links.push_back(std::move(link));
  }
  std::string twice;
  for (MechanismSolid& solid : more.solids) {
    solid.name = asName(named(solid.name));
    solid.link += before;
    const bool taken =
        std::ranges::find(into.solids, solid.name, &MechanismSolid::name) != into.solids.end();
    if (taken && twice.empty()) twice = solid.name;
    into.solids.push_back(std::move(solid));
  }
  for (JointCourse& joint : more.joints) {
    joint.name = named(joint.name);
    into.joints.push_back(std::move(joint));
  }
  const auto append = [](auto& from, auto& to) { to.insert(to.end(), from.begin(), from.end()); };
  for (std::string& notice : more.notices) notice = name.empty() ? notice : name + ": " + notice;
  append(more.notices, into.notices);
  append(more.losses, into.losses);
  append(more.otherFiles, into.otherFiles);
  append(more.halfTurns, into.halfTurns);
  if (into.up.empty()) into.up = more.up;
  return twice;
}

std::vector<std::size_t> parentsFirst(std::span<const std::size_t> parents,
                                      std::vector<std::size_t>& cycle) {
  std::vector<std::size_t> order;
  std::vector<bool> done(parents.size());
  for (std::size_t i = 0; i < parents.size(); ++i) {
    std::vector<std::size_t> chain;
    for (std::size_t at = i; at != Link::kWorld && !done[at]; at = parents[at]) {
      const auto again = std::ranges::find(chain, at);
      if (again != chain.end()) {
        cycle.assign(again, chain.end());
        return {};
      }
      chain.push_back(at);
    }
    for (auto at = chain.rbegin(); at != chain.rend(); ++at) {
      done[*at] = true;
      order.push_back(*at);
    }
  }
  return order;
}

Result<model::TriangleMesh> readSolid(const std::filesystem::path& path, MechanismSolid& solid,
                                      LoadedMechanism& into) {
  const auto read = readTriangleMesh(path);
  if (!read) {
    Error error = read.error();
    constexpr std::array<std::string_view, 5> kScenes = {".dae", ".fbx", ".usd", ".usdc", ".blend"};
    const bool isScene = std::ranges::find(kScenes, lowerCaseExtension(path)) != kScenes.end();
    if (isScene && error.code == ErrorCode::Unsupported) {
      error.message += "; Python reads it: python3 -m t4d sweep, with the same options";
    }
    return error;
  }
  for (const std::string& notice : read->notices) {
    into.notices.push_back(fmt::format("body '{}': {}", solid.name, notice));
  }
  for (const std::string& loss : read->losses) {
    into.losses.push_back(fmt::format("body '{}': {}", solid.name, loss));
  }
  into.otherFiles.push_back(path);
  into.otherFiles.insert(into.otherFiles.end(), read->otherFiles.begin(), read->otherFiles.end());
  solid.where = path.string();
  return read->mesh;
}

std::string noticeOfLimits(const std::string& joint, std::span<const double> times,
                           std::span<const double> values, double lower, double upper,
                           const std::string& unit) {
  std::size_t count = 0;
  std::size_t worst = 0;
  double most = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double beyond = std::max(values[i] - upper, lower - values[i]);
    if (!(beyond > 0)) continue;
    ++count;
    if (beyond > most) {
      most = beyond;
      worst = i;
    }
  }
  if (count == 0) return {};
  return fmt::format(
      "joint '{}' is beyond its limits, {:.6g} to {:.6g}{}{}, at {} of {} times; the "
      "farthest is {:.6g}, at time {}",
      joint, lower, upper, unit.empty() ? "" : " ", unit, count, values.size(), values[worst],
      times[worst]);
}

Result<LoadedMechanism> readMechanism(const std::filesystem::path& path) {
  auto file = readInputFile(path);
  return file ? readMechanism(*file) : file.error();
}

Result<LoadedMechanism> readMechanism(const InputFile& file) {
  const std::string name = file.path.string();
  try {
    if (auto good = checkJson(file.bytes, name); !good) return good.error();
    const json value = json::parse(file.bytes);
    if (value.is_object() && (value.contains("segments") || value.contains("poses"))) {
      return invalid(
          "is the motion of one solid, expected a mechanism with bodies: name the solid, "
          "and give this file as its motion",
          name);
    }
    return MechanismParser(file).parse(value);
  } catch (const JsonRefusal& refusal) {
    return refusal.error;
  } catch (const json::exception& error) {
    return invalid("is not JSON: " + jsonMessage(error), name);
  }
}

}  // namespace t4d::formats

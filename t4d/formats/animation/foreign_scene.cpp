#include "t4d/formats/animation/foreign_scene.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/animation/fbx_take.h"
#include "t4d/formats/file_extension.h"
#include "t4d/system/isolated.h"

namespace t4d::formats {
namespace {

using nlohmann::json;

constexpr std::uint32_t kGlbMagic = 0x46546c67;
constexpr std::uint32_t kJsonChunk = 0x4e4f534a;
constexpr std::uint32_t kBinaryChunk = 0x004e4942;
enum ComponentType : int { kUint16 = 5123, kUint32 = 5125, kFloat = 5126 };

/// The number that was meant: the shortest decimal that reads as this float.
double decimal(float value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.begin(), text.end(), value).ptr;
  double number = value;
  std::from_chars(text.begin(), end, number);
  return number;
}

/// Column by column, as glTF stores matrices.
json matrixOf(const aiMatrix4x4& matrix) {
  json numbers = json::array();
  for (unsigned column = 0; column < 4; ++column) {
    for (unsigned row = 0; row < 4; ++row) numbers.push_back(decimal(matrix[row][column]));
  }
  return numbers;
}

template <class Value>
struct Key {
  double seconds = 0;
  Value value;
};

aiVector3D between(const aiVector3D& a, const aiVector3D& b, double s) {
  return a + (b - a) * static_cast<float>(s);
}

aiQuaternion between(const aiQuaternion& a, const aiQuaternion& b, double s) {
  aiQuaternion result;
  aiQuaternion::Interpolate(result, a, b, static_cast<float>(s));
  return result;
}

/// The keys within a span, and at its ends what the curve is there. Constant before the first key
/// and after the last one, where nothing is added.
template <class Value>
std::vector<Key<Value>> clipped(const std::vector<Key<Value>>& keys, const model::TimeSpan& span) {
  std::vector<Key<Value>> result;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto& [seconds, value] = keys[i];
    if (i > 0) {
      const auto& before = keys[i - 1];
      for (const double end : {span.begin, span.end}) {
        if (before.seconds < end && end < seconds) {
          const double s = (end - before.seconds) / (seconds - before.seconds);
          result.push_back({end, between(before.value, value, s)});
        }
      }
    }
    if (span.begin <= seconds && seconds <= span.end) result.push_back(keys[i]);
  }
  if (result.empty() && !keys.empty()) {
    result.push_back(keys.front().seconds > span.end ? keys.front() : keys.back());
    result.front().seconds = span.begin;
  }
  return result;
}

std::string oneLineOf(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

/// The scene as glTF.
class GlbConverter {
 public:
  GlbConverter(const InputFile& file, const aiScene& scene, const FbxTakes& takes)
      : file_(file), scene_(scene), takes_(takes) {}

  Result<ForeignScene> convert() {
    if (auto good = checkWhatMoves(); !good) return good.error();
    auto root = rootTransform();
    if (!root) return root.error();
    findNodes(*scene_.mRootNode);
    if (auto done = addAnimations(); !done) return done.error();
    // A node above the file's own root, which may be animated.
    gltf_["nodes"] = json::array({{{"children", {1}}, {"matrix", *root}}});
    for (const aiNode* node : nodes_) {
      if (auto done = addNode(*node); !done) return done.error();
    }
    gltf_["scene"] = 0;
    gltf_["scenes"] = json::array({{{"nodes", {0}}}});
    gltf_["asset"] = {{"version", "2.0"}};
    noteCurves();
    if (skippedFaces_ > 0) {
      result_.losses.push_back(fmt::format("{} points and lines", skippedFaces_));
    }
    if (unusedChannels_ > 0) {
      result_.losses.push_back(
          fmt::format("{} of the animations that move no node", channels(unusedChannels_)));
    }
    return finish();
  }

 private:
  /// Assimp hands out keys, but not what lies between them.
  void noteCurves() {
    const bool isFbx = lowerCaseExtension(file_.path) == ".fbx";
    const auto has = [&](const char* word) { return file_.bytes.find(word) != std::string::npos; };
    const bool curved = has("BEZIER") || has("HERMITE") || has("CARDINAL") || has("BSPLINE");
    if (scene_.mNumAnimations == 0 || (!isFbx && !curved && !has(">STEP") && !has(" STEP"))) return;
    result_.notices.emplace_back(
        "only the keys of its curves are read: between them nodes move evenly; where that differs, "
        "bake the animation, or convert the file to glTF");
  }

  static std::string channels(std::size_t count) {
    return fmt::format("{} channel{}", count, count == 1 ? "" : "s");
  }

  Error refuse(const std::string& what) const {
    return fail(ErrorCode::Unsupported, what, file_.path.string());
  }

  Result<void> checkWhatMoves() {
    std::size_t targets = 0;
    for (unsigned i = 0; i < scene_.mNumMeshes; ++i) targets += scene_.mMeshes[i]->mNumAnimMeshes;
    for (unsigned i = 0; i < scene_.mNumAnimations; ++i) {
      const aiAnimation& animation = *scene_.mAnimations[i];
      if (animation.mNumMeshChannels == 0 && animation.mNumMorphMeshChannels == 0) continue;
      return refuse(
          fmt::format("animation '{}' moves morph targets, which are read of glTF only; convert "
                      "the file to glTF",
                      animation.mName.C_Str()));
    }
    if (targets > 0) {
      result_.losses.push_back(fmt::format("{} morph target{} that the animation does not move",
                                           targets, targets == 1 ? "" : "s"));
    }
    return {};
  }

  std::optional<int> axis(const char* name) const {
    std::int32_t value = 0;
    if (scene_.mMetaData == nullptr || !scene_.mMetaData->Get(name, value)) return std::nullopt;
    return value;
  }

  bool isFbx() const { return lowerCaseExtension(file_.path) == ".fbx"; }

  /// COLLADA's axes and units are in the root node already; FBX has them beside the scene.
  Result<json> rootTransform() {
    aiMatrix4x4 transform;
    if (!isFbx()) return matrixOf(transform);
    // Of x, y and z in glTF.
    const std::array<std::pair<const char*, int>, 3> axes = {
        std::pair{"CoordAxis", 0}, {"UpAxis", 1}, {"FrontAxis", 2}};
    std::set<int> seen;
    for (unsigned row = 0; row < 3; ++row) {
      const std::string name = axes[row].first;
      const int from = axis(name.c_str()).value_or(axes[row].second);
      const int sign = axis((name + "Sign").c_str()).value_or(1);
      if (from < 0 || from > 2 || !seen.insert(from).second || (sign != 1 && sign != -1)) {
        return invalid(
            fmt::format("its axes are not axes: {} is {} with sign {}", name, from, sign),
            file_.path.string());
      }
      for (unsigned column = 0; column < 3; ++column) {
        transform[row][column] = static_cast<int>(column) == from ? static_cast<float>(sign) : 0;
      }
    }
    double centimetres = 1;
    float single = 1;
    if (scene_.mMetaData != nullptr && !scene_.mMetaData->Get("UnitScaleFactor", centimetres) &&
        scene_.mMetaData->Get("UnitScaleFactor", single)) {
      centimetres = decimal(single);
    }
    if (!(centimetres > 0) || !std::isfinite(centimetres)) {
      return invalid(fmt::format("its unit is {} cm", centimetres), file_.path.string());
    }
    json numbers = matrixOf(transform);
    for (std::size_t i = 0; i < 15; ++i) numbers[i] = numbers[i].get<double>() * centimetres / 100;
    return numbers;
  }

  /// Numbers the nodes from 1, parents before their children.
  void findNodes(const aiNode& root) {
    std::vector<const aiNode*> open = {&root};
    while (!open.empty()) {
      const aiNode* node = open.back();
      open.pop_back();
      nodes_.push_back(node);
      numberOf_[node] = static_cast<int>(nodes_.size());
      named_[node->mName.C_Str()].push_back(node);
      for (unsigned i = node->mNumChildren; i > 0; --i) open.push_back(node->mChildren[i - 1]);
    }
  }

  template <class T>
  int addAccessor(const std::vector<T>& numbers, int componentType, const char* type,
                  std::size_t width, json more = json::object()) {
    binary_.resize((binary_.size() + 3) / 4 * 4);
    const std::size_t bytes = numbers.size() * sizeof(T);
    gltf_["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", bytes}});
    binary_.append(reinterpret_cast<const char*>(numbers.data()), bytes);
    more.update({{"bufferView", gltf_["bufferViews"].size() - 1},
                 {"componentType", componentType},
                 {"count", numbers.size() / width},
                 {"type", type}});
    gltf_["accessors"].push_back(std::move(more));
    return static_cast<int>(gltf_["accessors"].size()) - 1;
  }

  /// How Assimp's times of an animation become those of the glTF.
  struct Clock {
    double ticksPerSecond = 1;
    double offset = 0;                         ///< of the file's times, in seconds
    std::optional<model::TimeSpan> take = {};  ///< in seconds of the file
    double begin = 0;                          ///< what becomes 0, in seconds of the file

    double secondsOf(double ticks) const {
      return (ticks + offset * ticksPerSecond) / ticksPerSecond;
    }
  };

  template <class From, class Append>
  void addChannel(json& animation, const aiNode& node, const char* path, const From* from,
                  unsigned count, const Clock& clock, std::size_t width, const Append& append) {
    if (count == 0) return;
    std::vector<Key<decltype(from->mValue)>> keys;
    for (unsigned i = 0; i < count; ++i) {
      keys.push_back({clock.secondsOf(from[i].mTime), from[i].mValue});
    }
    if (clock.take) keys = clipped(keys, *clock.take);
    // Assimp adds single keys at any time, which are constant.
    if (keys.size() == 1) keys.front().seconds = clock.begin;
    std::vector<float> times;
    std::vector<float> values;
    for (const auto& [seconds, value] : keys) {
      times.push_back(static_cast<float>(seconds - clock.begin));
      append(values, value);
    }
    const auto [least, most] = std::ranges::minmax(times);
    const int input = addAccessor(times, kFloat, "SCALAR", 1,
                                  {{"min", json::array({least})}, {"max", json::array({most})}});
    const int output = addAccessor(values, kFloat, width == 3 ? "VEC3" : "VEC4", width);
    animation["channels"].push_back({{"sampler", animation["samplers"].size()},
                                     {"target", {{"node", numberOf_.at(&node)}, {"path", path}}}});
    animation["samplers"].push_back({{"input", input}, {"output", output}});
  }

  /// Times count from the beginning of a take, from the first key without one, and in formats
  /// without takes from a first key before 0.
  Clock clockOf(const aiAnimation& animation, double ticksPerSecond) const {
    Clock clock{ticksPerSecond};
    const FbxTakes::Take take = takes_.takeOf(animation.mDuration / ticksPerSecond);
    clock.offset = take.offset;
    clock.take = take.span;
    if (take.span) {
      clock.begin = take.span->begin;
      return clock;
    }
    double first = std::numeric_limits<double>::infinity();
    const auto look = [&](const auto* keys, unsigned count) {
      if (count > 1) first = std::min(first, clock.secondsOf(keys[0].mTime));
    };
    for (unsigned i = 0; i < animation.mNumChannels; ++i) {
      const aiNodeAnim& channel = *animation.mChannels[i];
      look(channel.mPositionKeys, channel.mNumPositionKeys);
      look(channel.mRotationKeys, channel.mNumRotationKeys);
      look(channel.mScalingKeys, channel.mNumScalingKeys);
    }
    if (first < 0 || (take.offset != 0 && std::isfinite(first))) clock.begin = first;
    return clock;
  }

  Result<void> addAnimations() {
    for (unsigned i = 0; i < scene_.mNumAnimations; ++i) {
      const aiAnimation& from = *scene_.mAnimations[i];
      const double ticks = from.mTicksPerSecond;
      if (!(ticks > 0) || !std::isfinite(ticks)) {
        return invalid(
            fmt::format("animation '{}' does not say how long its times are", from.mName.C_Str()),
            file_.path.string());
      }
      const Clock clock = clockOf(from, ticks);
      if (clock.begin != 0) {
        result_.notices.push_back(fmt::format("animation '{}' begins at {} s, which becomes time 0",
                                              from.mName.C_Str(), clock.begin));
      }
      json animation = {
          {"name", from.mName.C_Str()}, {"channels", json::array()}, {"samplers", json::array()}};
      for (unsigned k = 0; k < from.mNumChannels; ++k) {
        const aiNodeAnim& channel = *from.mChannels[k];
        const auto found = named_.find(channel.mNodeName.C_Str());
        if (found == named_.end()) {
          ++unusedChannels_;
          continue;
        }
        if (found->second.size() > 1) {
          return refuse(fmt::format("animation '{}' moves node '{}', and {} nodes have that name",
                                    from.mName.C_Str(), channel.mNodeName.C_Str(),
                                    found->second.size()));
        }
        const aiNode& node = *found->second.front();
        animated_.insert(&node);
        const auto vector = [](std::vector<float>& into, const aiVector3D& v) {
          into.insert(into.end(), {v.x, v.y, v.z});
        };
        addChannel(animation, node, "translation", channel.mPositionKeys, channel.mNumPositionKeys,
                   clock, 3, vector);
        addChannel(animation, node, "rotation", channel.mRotationKeys, channel.mNumRotationKeys,
                   clock, 4, [](std::vector<float>& into, aiQuaternion q) {
                     q.Normalize();
                     into.insert(into.end(), {q.x, q.y, q.z, q.w});
                   });
        addChannel(animation, node, "scale", channel.mScalingKeys, channel.mNumScalingKeys, clock,
                   3, vector);
      }
      if (!animation["channels"].empty()) gltf_["animations"].push_back(std::move(animation));
    }
    return {};
  }

  Result<void> addNode(const aiNode& node) {
    json made = {{"name", node.mName.C_Str()}};
    for (unsigned i = 0; i < node.mNumChildren; ++i) {
      made["children"].push_back(numberOf_.at(node.mChildren[i]));
    }
    if (!animated_.contains(&node)) {
      // That of FBX's root is of Assimp, which turns the scene from version 5.3 on.
      const bool isOfAssimp = &node == scene_.mRootNode && isFbx();
      made["matrix"] = matrixOf(isOfAssimp ? aiMatrix4x4() : node.mTransformation);
    } else {
      aiVector3D scale;
      aiQuaternion turn;
      aiVector3D shift;
      node.mTransformation.Decompose(scale, turn, shift);
      constexpr float kRounding = 1e-4F;  // relative, far above that of float32
      const aiMatrix4x4 again(scale, turn, shift);
      const float size = std::max({std::abs(scale.x), std::abs(scale.y), std::abs(scale.z)});
      for (unsigned row = 0; row < 3; ++row) {
        for (unsigned column = 0; column < 3; ++column) {
          const float apart = std::abs(again[row][column] - node.mTransformation[row][column]);
          if (apart <= kRounding * size) continue;
          return refuse(
              fmt::format("node '{}' is animated, but its transform is not a translation, "
                          "rotation and scale",
                          node.mName.C_Str()));
        }
      }
      made["translation"] = {decimal(shift.x), decimal(shift.y), decimal(shift.z)};
      made["rotation"] = {turn.x, turn.y, turn.z, turn.w};
      made["scale"] = {decimal(scale.x), decimal(scale.y), decimal(scale.z)};
    }
    if (auto done = addMeshes(node, made); !done) return done;
    gltf_["nodes"].push_back(std::move(made));
    return {};
  }

  Result<void> addMeshes(const aiNode& node, json& made) {
    json primitives = json::array();
    std::vector<int> joints;
    std::vector<float> binds;
    std::size_t skinned = 0;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      const unsigned number = node.mMeshes[i];
      const aiMesh& mesh = *scene_.mMeshes[number];
      if (!geometries_.contains(number)) geometries_[number] = geometryOf(mesh);
      json primitive = geometries_[number];
      if (primitive.empty()) continue;
      if (mesh.HasBones()) {
        ++skinned;
        if (auto done = addBones(mesh, joints, binds, primitive); !done) return done;
      }
      primitives.push_back(std::move(primitive));
    }
    if (primitives.empty()) return {};
    if (skinned > 0) {
      if (skinned < primitives.size()) {
        return refuse(
            fmt::format("node '{}' has meshes with bones and others without", node.mName.C_Str()));
      }
      made["skin"] = gltf_["skins"].size();
      const int matrices = addAccessor(binds, kFloat, "MAT4", 16);
      gltf_["skins"].push_back({{"joints", joints}, {"inverseBindMatrices", matrices}});
    }
    made["mesh"] = gltf_["meshes"].size();
    gltf_["meshes"].push_back({{"primitives", std::move(primitives)}});
    return {};
  }

  /// A primitive; nothing for a mesh without triangles.
  json geometryOf(const aiMesh& mesh) {
    std::vector<std::uint32_t> indices;
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      if (face.mNumIndices == 3) {
        indices.insert(indices.end(), face.mIndices, face.mIndices + 3);
      } else {
        ++skippedFaces_;
      }
    }
    if (indices.empty()) return json::object();
    std::vector<float> positions;
    constexpr float kMost = std::numeric_limits<float>::max();
    std::array<float, 3> least = {kMost, kMost, kMost};
    std::array<float, 3> most = {-kMost, -kMost, -kMost};
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      for (unsigned k = 0; k < 3; ++k) {
        const float coordinate = mesh.mVertices[i][k];
        positions.push_back(coordinate);
        least[k] = std::min(least[k], coordinate);
        most[k] = std::max(most[k], coordinate);
      }
    }
    const int at = addAccessor(positions, kFloat, "VEC3", 3, {{"min", least}, {"max", most}});
    const int corners = addAccessor(indices, kUint32, "SCALAR", 1);
    return {{"attributes", {{"POSITION", at}}}, {"indices", corners}};
  }

  /// A bone with another offset in another mesh is a joint of its own.
  Result<void> addBones(const aiMesh& mesh, std::vector<int>& joints, std::vector<float>& binds,
                        json& primitive) {
    struct Hold {
      std::uint16_t joint;
      float weight;
    };
    std::vector<std::vector<Hold>> holds(mesh.mNumVertices);
    std::size_t most = 0;
    for (unsigned i = 0; i < mesh.mNumBones; ++i) {
      const aiBone& bone = *mesh.mBones[i];
      const auto found = named_.find(bone.mName.C_Str());
      if (found == named_.end() || found->second.size() > 1) {
        return refuse(fmt::format("{} nodes have the name of bone '{}'",
                                  found == named_.end() ? 0 : found->second.size(),
                                  bone.mName.C_Str()));
      }
      if (joints.size() > std::numeric_limits<std::uint16_t>::max()) {
        return refuse("a node hangs on more than 65,536 bones");
      }
      const auto joint = static_cast<std::uint16_t>(joints.size());
      joints.push_back(numberOf_.at(found->second.front()));
      for (unsigned column = 0; column < 4; ++column) {
        for (unsigned row = 0; row < 4; ++row) binds.push_back(bone.mOffsetMatrix[row][column]);
      }
      for (unsigned k = 0; k < bone.mNumWeights; ++k) {
        const aiVertexWeight& weight = bone.mWeights[k];
        if (weight.mVertexId >= holds.size() || weight.mWeight == 0) continue;
        auto& all = holds[weight.mVertexId];
        all.push_back({joint, weight.mWeight});
        most = std::max(most, all.size());
      }
    }
    for (std::size_t set = 0; 4 * set < most; ++set) {
      std::vector<std::uint16_t> numbers(4 * holds.size());
      std::vector<float> weights(4 * holds.size());
      for (std::size_t i = 0; i < holds.size(); ++i) {
        for (std::size_t k = 0; k < 4 && 4 * set + k < holds[i].size(); ++k) {
          numbers[4 * i + k] = holds[i][4 * set + k].joint;
          weights[4 * i + k] = holds[i][4 * set + k].weight;
        }
      }
      json& attributes = primitive["attributes"];
      attributes[fmt::format("JOINTS_{}", set)] = addAccessor(numbers, kUint16, "VEC4", 4);
      attributes[fmt::format("WEIGHTS_{}", set)] = addAccessor(weights, kFloat, "VEC4", 4);
    }
    return {};
  }

  Result<ForeignScene> finish() {
    binary_.resize((binary_.size() + 3) / 4 * 4);
    if (!binary_.empty()) gltf_["buffers"] = json::array({{{"byteLength", binary_.size()}}});
    std::string text = gltf_.dump(-1, ' ', false, json::error_handler_t::replace);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::size_t whole = 28 + text.size() + binary_.size();
    if (whole > std::numeric_limits<std::uint32_t>::max()) {
      return refuse("its meshes and keys take more than the 4 GiB of a binary glTF");
    }
    std::string& bytes = result_.glb.bytes;
    bytes.reserve(whole);
    const auto put = [&](std::size_t number) {
      for (int shift = 0; shift < 32; shift += 8)
        bytes += static_cast<char>(number >> shift & 255U);
    };
    put(kGlbMagic);
    put(2);
    put(whole);
    put(text.size());
    put(kJsonChunk);
    bytes += text;
    put(binary_.size());
    put(kBinaryChunk);
    bytes += binary_;
    result_.glb.path = file_.path;
    return std::move(result_);
  }

  const InputFile& file_;
  const aiScene& scene_;
  const FbxTakes& takes_;
  json gltf_ = json::object();
  std::string binary_;
  std::vector<const aiNode*> nodes_;
  std::map<const aiNode*, int> numberOf_;  // in glTF
  std::map<std::string, std::vector<const aiNode*>> named_;
  std::set<const aiNode*> animated_;
  std::map<unsigned, json> geometries_;  // of the meshes
  std::size_t skippedFaces_ = 0;
  std::size_t unusedChannels_ = 0;
  ForeignScene result_;
};

/// Reads and converts in this process.
Result<ForeignScene> convertHere(const InputFile& file, bool keepAxes) {
  try {
    Assimp::Importer importer;
    importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, keepAxes);
    const std::string hint = lowerCaseExtension(file.path).substr(1);
    std::string bytes = file.bytes;
    FbxTakes takes;
    if (hint == "fbx") takes = FbxTakes::widen(bytes);
    const aiScene* scene = importer.ReadFileFromMemory(
        bytes.data(), bytes.size(), aiProcess_Triangulate | aiProcess_ValidateDataStructure,
        hint.c_str());
    if (scene == nullptr) {
      return invalid(
          fmt::format("Assimp cannot read it: {}", oneLineOf(importer.GetErrorString())));
    }
    if ((scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE) != 0 || scene->mRootNode == nullptr ||
        scene->mNumMeshes == 0) {
      return invalid("holds no mesh");
    }
    return GlbConverter(file, *scene, takes).convert();
  } catch (const std::exception& exception) {
    return invalid(fmt::format("Assimp cannot read it: {}", oneLineOf(exception.what())));
  }
}

/// What comes back from the process that converts: a line of JSON, and the glTF after it.
std::string packed(const Result<ForeignScene>& scene) {
  json head;
  if (scene) {
    head = {{"notices", scene->notices}, {"losses", scene->losses}};
  } else {
    head = {{"error", scene.error().message},
            {"unsupported", scene.error().code == ErrorCode::Unsupported}};
  }
  const std::string line = head.dump(-1, ' ', false, json::error_handler_t::replace);
  return line + '\n' + (scene ? scene->glb.bytes : std::string());
}

Result<ForeignScene> unpacked(const std::string& text, const InputFile& file) {
  const std::size_t end = text.find('\n');
  const json head = json::parse(text.substr(0, end), nullptr, false);
  if (end == text.npos || head.is_discarded()) {
    return fail(ErrorCode::Failed, "nothing came back from Assimp", file.path.string());
  }
  if (head.contains("error")) {
    const bool unsupported = head["unsupported"].get<bool>();
    return fail(unsupported ? ErrorCode::Unsupported : ErrorCode::InvalidInput,
                head["error"].get<std::string>(), file.path.string());
  }
  return ForeignScene{{file.path, text.substr(end + 1)},
                      head["notices"].get<std::vector<std::string>>(),
                      head["losses"].get<std::vector<std::string>>()};
}

}  // namespace

bool readsForeignScenes() { return true; }

Result<ForeignScene> readForeignScene(const InputFile& file, bool keepAxes) {
  // Assimp asserts, and some damaged files keep it busy for ever. Far more than sound files take.
  constexpr std::uint64_t kBytes = std::uint64_t{1} << 30;
  constexpr std::uint64_t kBytesPerByte = 200;
  constexpr std::uint64_t kSeconds = 20;
  constexpr std::uint64_t kBytesPerSecond = 100'000;
  const system::WorkLimits limits = {kBytes + kBytesPerByte * file.bytes.size(),
                                     kSeconds + file.bytes.size() / kBytesPerSecond};
  const auto work =
      system::runIsolated([&] { return packed(convertHere(file, keepAxes)); }, limits);
  if (!work) return work.error();
  using End = system::IsolatedWork::End;
  switch (work->end) {
    case End::Crashed:
      return invalid(fmt::format("Assimp cannot read it: it crashed, by signal {}", work->signal),
                     file.path.string());
    case End::OutOfTime:
      return invalid(
          fmt::format("Assimp cannot read it: it was stopped after {} s", limits.cpuSeconds),
          file.path.string());
    case End::OutOfMemory:
      return invalid(fmt::format("Assimp cannot read it: it needs more than {} MB",
                                 limits.memoryBytes / 1'000'000),
                     file.path.string());
    case End::Returned:
      break;
  }
  return unpacked(work->result, file);
}

}  // namespace t4d::formats

#include "t4d/formats/gltf_builder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/base64.h"
#include "t4d/formats/written_mesh.h"

namespace t4d::formats {
namespace {

// Numbers are written as they are in memory.
static_assert(std::endian::native == std::endian::little);

template <class T>
std::span<const unsigned char> bytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const unsigned char*>(values.data()), values.size() * sizeof(T)};
}

std::span<const float> floatsOf(const std::vector<Eigen::Vector3f>& from) {
  return {from.data()->data(), 3 * from.size()};
}

tinygltf::Value valueOf(const nlohmann::json& json) {
  if (json.is_object()) {
    tinygltf::Value::Object object;
    for (const auto& [key, member] : json.items()) object[key] = valueOf(member);
    return tinygltf::Value(std::move(object));
  }
  if (json.is_array()) {
    tinygltf::Value::Array array;
    for (const auto& entry : json) array.push_back(valueOf(entry));
    return tinygltf::Value(std::move(array));
  }
  if (json.is_string()) return tinygltf::Value(json.get<std::string>());
  if (json.is_boolean()) return tinygltf::Value(json.get<bool>());
  if (json.is_number()) {
    // tinygltf's integers have 32 bits.
    const auto number = json.get<double>();
    const bool isInt =
        json.is_number_integer() && std::abs(number) <= std::numeric_limits<std::int32_t>::max();
    return isInt ? tinygltf::Value(json.get<int>()) : tinygltf::Value(number);
  }
  return {};
}

Result<tinygltf::Node> rootNode(const MeshWriteOptions& options) {
  const GltfPlacement& placement = options.placement;
  const double metres = placement.metresPerUnit;
  if (!(metres > 0) || !std::isfinite(metres)) {
    return invalid(fmt::format("{} metres for a unit of length, expected more than 0", metres));
  }
  auto extras = nlohmann::json::object();
  if (!placement.extras.empty()) {
    extras = nlohmann::json::parse(placement.extras, nullptr, false);
    if (!extras.is_object()) return invalid("the extras are not a JSON object");
  }
  extras["metresPerUnit"] = metres;
  extras["upAxisOfSource"] = placement.zUp ? "z" : "y";
  tinygltf::Node root;
  root.name = "t4d";
  root.extras = valueOf(extras);
  if (metres != 1) root.scale = {metres, metres, metres};
  // A quaternion (x, y, z, w).
  if (placement.zUp) root.rotation = {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)};
  const model::Point3 origin = options.origin + options.center;
  if (!origin.isZero(0)) {
    // A translation comes after the turn and the scale, both of which it must have itself.
    const model::Point3 turned =
        placement.zUp ? model::Point3(origin.x(), origin.z(), -origin.y()) : origin;
    root.translation = {metres * turned.x(), metres * turned.y(), metres * turned.z()};
  }
  return root;
}

}  // namespace

Result<GltfBuilder> GltfBuilder::create(Form form, const MeshWriteOptions& options,
                                        const Limits& limits) {
  auto root = rootNode(options);
  if (!root) return pass(root.error());
  GltfBuilder builder(form, options, limits);
  builder.model_.asset.version = "2.0";
  builder.model_.asset.generator = kGltfGenerator;
  builder.model_.nodes.push_back(std::move(*root));
  return builder;
}

tl::unexpected<Error> GltfBuilder::tooLarge() const {
  return fail(ErrorCode::Unsupported,
              isText_ ? "more geometry than a .gltf can hold; write .glb, or fewer frames or meshes"
                      : "more than the 4 GiB that a .glb can have; write fewer frames or meshes");
}

Result<int> GltfBuilder::addView(std::span<const unsigned char> bytes, int target) {
  const std::size_t hash =
      std::hash<std::string_view>()({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  const auto [begin, end] = views_.equal_range(hash);
  for (auto at = begin; at != end; ++at) {
    const auto index = static_cast<std::size_t>(at->second);
    const tinygltf::BufferView& view = model_.bufferViews[index];
    if (view.target == target && view.byteLength == bytes.size() &&
        std::equal(bytes.begin(), bytes.end(), pieces_[index].begin())) {
      return at->second;
    }
  }
  // Every view begins at a multiple of its largest possible component.
  constexpr std::uint64_t kAlignment = 4;
  const std::uint64_t padded = (bytes.size() + kAlignment - 1) / kAlignment * kAlignment;
  const std::uint64_t most = isText_ ? limits_.textBufferBytes : limits_.binaryBytes;
  if (padded > most - bufferBytes_) return tooLarge();

  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = bufferBytes_;
  view.byteLength = bytes.size();
  view.target = target;
  model_.bufferViews.push_back(std::move(view));
  auto& piece = pieces_.emplace_back();
  piece.reserve(padded);
  piece.assign(bytes.begin(), bytes.end());
  piece.resize(padded);
  bufferBytes_ += padded;
  const int index = static_cast<int>(model_.bufferViews.size() - 1);
  views_.emplace(hash, index);
  return index;
}

Result<int> GltfBuilder::addAccessor(std::span<const unsigned char> bytes, int componentType,
                                     int type, std::size_t count, int target) {
  const auto view = addView(bytes, target);
  if (!view) return view;
  const auto [found, added] = accessors_.emplace(std::tuple(*view, componentType, type),
                                                 static_cast<int>(model_.accessors.size()));
  if (!added) return found->second;
  tinygltf::Accessor accessor;
  accessor.bufferView = *view;
  accessor.componentType = componentType;
  accessor.type = type;
  accessor.count = count;
  model_.accessors.push_back(std::move(accessor));
  return found->second;
}

Result<int> GltfBuilder::addOnes(std::size_t count, const std::vector<std::uint32_t>& indices) {
  const std::vector<float> ones(indices.size(), 1.0F);
  const auto where = addView(bytesOf(indices), 0);
  if (!where) return where;
  const auto values = addView(bytesOf(ones), 0);
  if (!values) return values;
  tinygltf::Accessor accessor;
  accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
  accessor.type = TINYGLTF_TYPE_SCALAR;
  accessor.count = count;
  accessor.sparse.isSparse = true;
  accessor.sparse.count = static_cast<int>(indices.size());
  accessor.sparse.indices.bufferView = *where;
  accessor.sparse.indices.byteOffset = 0;
  accessor.sparse.indices.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  accessor.sparse.values.bufferView = *values;
  accessor.sparse.values.byteOffset = 0;
  model_.accessors.push_back(std::move(accessor));
  return static_cast<int>(model_.accessors.size() - 1);
}

Result<int> GltfBuilder::addFloats(std::span<const float> numbers, int components, bool bounds,
                                   int target) {
  const int type = components == 1 ? TINYGLTF_TYPE_SCALAR : components;  // VEC2 to VEC4 are 2 to 4
  const std::size_t width = std::max<std::size_t>(1, components);
  auto index =
      addAccessor({reinterpret_cast<const unsigned char*>(numbers.data()), numbers.size_bytes()},
                  TINYGLTF_COMPONENT_TYPE_FLOAT, type, numbers.size() / width, target);
  if (!index || !bounds) return index;
  auto& accessor = model_.accessors[static_cast<std::size_t>(*index)];
  accessor.minValues.assign(numbers.begin(), numbers.begin() + components);
  accessor.maxValues = accessor.minValues;
  for (std::size_t i = width; i < numbers.size(); ++i) {
    auto& min = accessor.minValues[i % width];
    auto& max = accessor.maxValues[i % width];
    min = std::min<double>(min, numbers[i]);
    max = std::max<double>(max, numbers[i]);
  }
  return index;
}

Result<int> GltfBuilder::addIndices(const VerticesWithNormals& vertices) {
  // The largest number of each type would mean "restart", so it is not used as an index.
  if (vertices.sources.size() > std::numeric_limits<std::uint32_t>::max()) return tooLarge();
  const bool isShort = vertices.sources.size() <= std::numeric_limits<std::uint16_t>::max();
  const std::size_t count = 3 * vertices.triangles.size();
  std::vector<std::uint16_t> shorts;
  std::vector<std::uint32_t> longs;
  if (isShort) shorts.reserve(count);
  if (!isShort) longs.reserve(count);
  for (const auto& triangle : vertices.triangles) {
    for (const std::uint32_t corner : triangle) {
      if (isShort) shorts.push_back(static_cast<std::uint16_t>(corner));
      if (!isShort) longs.push_back(corner);
    }
  }
  return addAccessor(
      isShort ? bytesOf(shorts) : bytesOf(longs),
      isShort ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
      TINYGLTF_TYPE_SCALAR, count, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
}

Result<void> GltfBuilder::addAttributes(const NamedMesh& named, const VerticesWithNormals& vertices,
                                        tinygltf::Primitive& primitive) {
  for (const model::Attribute& attribute : named.mesh.attributes) {
    const auto lose = [&](const char* why) { addOnce(lost_, lostLine(attribute, why)); };
    std::string name = "_" + plainName(attribute.name);
    for (char& c : name) {
      if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    }
    if (attribute.domain != model::Domain::Vertex) {
      lose("glTF has attributes of vertices only");
    } else if (!fits(attribute, named.mesh)) {
      lose("its rows do not fit the mesh");
    } else if (attribute.components > 4) {
      lose("glTF has attributes of at most 4 components");
    } else if (name.size() == 1 || primitive.attributes.count(name) > 0) {
      lose("it has no name, or that of another");
    } else {
      std::vector<float> numbers;
      for (const std::uint32_t row : vertices.sources) {
        for (std::size_t i = 0; i < attribute.components; ++i) {
          const double number = attributeNumber(attribute, row, i);
          const bool isFloat = std::abs(number) <= std::numeric_limits<float>::max();
          if (isFloat) numbers.push_back(static_cast<float>(number));
        }
      }
      if (numbers.size() != vertices.sources.size() * attribute.components) {
        lose("some of its numbers are not finite in float32, the only type that fits all");
        continue;
      }
      const auto accessor = addFloats(numbers, static_cast<int>(attribute.components), false,
                                      TINYGLTF_TARGET_ARRAY_BUFFER);
      if (!accessor) return pass(accessor.error());
      primitive.attributes[name] = *accessor;
    }
  }
  return {};
}

Result<int> GltfBuilder::addMesh(const NamedMesh& named, const model::Point3& center,
                                 Layout& layout) {
  if (auto good = checkWritable(named); !good) return pass(good.error());
  if (named.mesh.triangles.empty()) return -1;
  const auto rounded = roundedVertices(named, center, rounding_);
  if (!rounded) return pass(rounded.error());
  layout.vertices = normals_ ? withNormals(named.mesh, *normals_) : withoutNormals(named.mesh);
  const VerticesWithNormals& vertices = layout.vertices;
  std::vector<Eigen::Vector3f>& places = layout.places;
  places.clear();
  places.reserve(vertices.sources.size());
  for (const std::uint32_t source : vertices.sources) places.push_back((*rounded)[source]);
  const auto positions = addFloats(floatsOf(places), 3, true, TINYGLTF_TARGET_ARRAY_BUFFER);
  if (!positions) return pass(positions.error());
  const auto indices = addIndices(vertices);
  if (!indices) return pass(indices.error());

  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.attributes["POSITION"] = *positions;
  primitive.indices = *indices;
  primitive.material = materialOf(named.color);
  if (normals_) {
    const auto normals =
        addFloats(floatsOf(vertices.normals), 3, false, TINYGLTF_TARGET_ARRAY_BUFFER);
    if (!normals) return pass(normals.error());
    primitive.attributes["NORMAL"] = *normals;
  }
  if (attributes_) {
    if (auto done = addAttributes(named, vertices, primitive); !done) return pass(done.error());
  }
  tinygltf::Mesh mesh;
  mesh.name = named.name;
  mesh.primitives.push_back(std::move(primitive));
  model_.meshes.push_back(std::move(mesh));
  return static_cast<int>(model_.meshes.size() - 1);
}

Result<void> GltfBuilder::addTarget(int mesh, const Layout& layout, const NamedMesh& shape,
                                    const model::Point3& center) {
  if (auto good = checkWritable(shape); !good) return good;
  if (auto rounded = roundedVertices(shape, center, rounding_); !rounded) {
    return pass(rounded.error());
  }
  const std::size_t count = layout.places.size();
  std::vector<Eigen::Vector3f> moves;
  moves.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    // From the rounded place, so that rounding happens once.
    const model::Point3 move =
        shape.mesh.vertices[layout.vertices.sources[i]] - center - layout.places[i].cast<double>();
    if (!(move.cwiseAbs().maxCoeff() <= std::numeric_limits<float>::max())) {
      return invalid(fmt::format("mesh '{}' moves beyond the float32 numbers of glTF", shape.name));
    }
    moves.push_back(move.cast<float>());
  }
  const auto positions = addFloats(floatsOf(moves), 3, true, TINYGLTF_TARGET_ARRAY_BUFFER);
  if (!positions) return pass(positions.error());
  std::map<std::string, int> target = {{"POSITION", *positions}};
  if (normals_) {
    std::vector<Eigen::Vector3f> turns = normalsWhenMoved(layout.vertices, shape.mesh);
    for (std::size_t i = 0; i < count; ++i) turns[i] -= layout.vertices.normals[i];
    const auto normals = addFloats(floatsOf(turns), 3, false, TINYGLTF_TARGET_ARRAY_BUFFER);
    if (!normals) return pass(normals.error());
    target["NORMAL"] = *normals;
  }
  model_.meshes[static_cast<std::size_t>(mesh)].primitives.front().targets.push_back(
      std::move(target));
  return {};
}

int GltfBuilder::materialOf(const std::optional<Color>& color) {
  const auto [found, added] = materials_.emplace(color, static_cast<int>(model_.materials.size()));
  if (!added) return found->second;
  tinygltf::Material material;
  material.name = color ? fmt::format("color {}", found->second) : "plain";
  material.pbrMetallicRoughness.baseColorFactor = {0.8, 0.8, 0.8, 1};
  if (color) material.pbrMetallicRoughness.baseColorFactor.assign(color->begin(), color->end());
  if (color && (*color)[3] < 1) material.alphaMode = "BLEND";
  material.pbrMetallicRoughness.metallicFactor = 0;
  material.pbrMetallicRoughness.roughnessFactor = 0.8;
  model_.materials.push_back(std::move(material));
  return found->second;
}

int GltfBuilder::addNode(tinygltf::Node node, int parent) {
  const int index = static_cast<int>(model_.nodes.size());
  model_.nodes.push_back(std::move(node));
  model_.nodes[static_cast<std::size_t>(parent)].children.push_back(index);
  return index;
}

Result<std::string> GltfBuilder::documentJson() {
  tinygltf::Scene scene;
  scene.name = "t4d";
  // A root without children would be an empty node.
  if (model_.nodes.front().children.empty()) {
    model_.nodes.clear();
  } else {
    scene.nodes = {0};
  }
  model_.scenes = {std::move(scene)};
  model_.defaultScene = 0;
  std::ostringstream stream;
  try {
    // Compact in a .glb, indented in a .gltf.
    tinygltf::TinyGLTF().WriteGltfSceneToStream(&model_, stream, isText_, false);
  } catch (const std::exception& exception) {
    return invalid(fmt::format("a name or an extra is not UTF-8 text: {}", exception.what()));
  }
  return std::move(stream).str();
}

Result<std::vector<std::string>> GltfBuilder::finish(OutputFile& file) {
  const auto json = documentJson();
  if (!json) return pass(json.error());
  if (auto done = isText_ ? writeText(file, *json) : writeBinary(file, *json); !done) {
    return pass(done.error());
  }
  if (auto line = rounding_.line()) lost_.push_back(std::move(*line));
  return lost_;
}

// tinygltf would copy the buffer and ignore errors of writing, so its document has no buffer: the
// buffer's entry is put in as the first member of the document, and its bytes come from us.

Result<void> GltfBuilder::writeBinary(OutputFile& file, std::string_view document) const {
  std::string json(document);
  if (bufferBytes_ > 0) {
    json.insert(1, fmt::format("\"buffers\":[{{\"byteLength\":{}}}],", bufferBytes_));
  }
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const bool hasBuffer = bufferBytes_ > 0;
  const std::uint64_t length = 12 + 8 + json.size() + (hasBuffer ? 8 + bufferBytes_ : 0);
  if (length > limits_.binaryBytes) return tooLarge();

  constexpr std::uint32_t kVersion = 2;
  const auto chunk = [&](std::uint64_t bytes, const char* type) -> Result<void> {
    const auto bytes32 = static_cast<std::uint32_t>(bytes);
    if (auto done = file.write(&bytes32, 4); !done) return done;
    return file.write(type, 4);
  };
  const auto length32 = static_cast<std::uint32_t>(length);
  if (auto done = file.write("glTF", 4); !done) return done;
  if (auto done = file.write(&kVersion, 4); !done) return done;
  if (auto done = file.write(&length32, 4); !done) return done;
  if (auto done = chunk(json.size(), "JSON"); !done) return done;
  if (auto done = file.write(json.data(), json.size()); !done) return done;
  if (!hasBuffer) return {};
  if (auto done = chunk(bufferBytes_, "BIN"); !done) return done;  // and a zero byte
  for (const auto& piece : pieces_) {
    if (auto done = file.write(piece.data(), piece.size()); !done) return done;
  }
  return {};
}

Result<void> GltfBuilder::writeText(OutputFile& file, std::string_view document) const {
  if (bufferBytes_ == 0) return file.write(document.data(), document.size());
  const std::string before = fmt::format(
      "{{\n  \"buffers\": [\n    {{\n      \"byteLength\": {},\n      \"uri\": "
      "\"data:application/octet-stream;base64,",
      bufferBytes_);
  if (auto done = file.write(before.data(), before.size()); !done) return done;
  // Base64 turns three bytes into four digits: what does not divide waits for the next piece.
  std::vector<unsigned char> waiting;
  for (const auto& piece : pieces_) {
    waiting.insert(waiting.end(), piece.begin(), piece.end());
    const std::size_t whole = waiting.size() / 3 * 3;
    const std::string text = base64(std::span(waiting).first(whole));
    if (auto done = file.write(text.data(), text.size()); !done) return done;
    waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(whole));
  }
  const std::string after = base64(waiting) + "\"\n    }\n  ],";
  if (auto done = file.write(after.data(), after.size()); !done) return done;
  const auto members = document.substr(1);
  return file.write(members.data(), members.size());
}

}  // namespace t4d::formats

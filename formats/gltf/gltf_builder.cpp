#include "formats/gltf/gltf_builder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/gltf/meshopt_pack.h"
#include "formats/t4d/names.h"
#include "formats/text/base64.h"
#include "formats/triangle/vertex_normals.h"
#include "formats/triangle/written_mesh.h"
#include "model/amount_text.h"
#include "model/corner_attributes.h"

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
  const auto& grid = options.gltf.quantization;
  const double scale = grid ? metres * grid->step() : metres;
  if (scale != 1) root.scale = {scale, scale, scale};
  // A quaternion (x, y, z, w).
  if (placement.zUp) root.rotation = {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)};
  const model::Point3 origin = options.origin + (grid ? grid->bounds.min : options.center);
  if (!origin.isZero(0)) {
    // A translation comes after the turn and the scale, both of which it must have itself.
    const model::Point3 turned =
        placement.zUp ? model::Point3(origin.x(), origin.z(), -origin.y()) : origin;
    root.translation = {metres * turned.x(), metres * turned.y(), metres * turned.z()};
  }
  return root;
}

}  // namespace

double Quantization::step() const {
  const double extent = (bounds.max - bounds.min).maxCoeff();
  return extent > 0 ? extent / static_cast<double>((1U << static_cast<unsigned>(bits)) - 1) : 1;
}

Result<GltfBuilder> GltfBuilder::create(Form form, const MeshWriteOptions& options) {
  if (const auto& grid = options.gltf.quantization) {
    if (grid->bits < 1 || grid->bits > 16) {
      return invalid(fmt::format("{} bits for a coordinate, expected 1 to 16", grid->bits));
    }
    if (!grid->bounds.min.allFinite() || !grid->bounds.max.allFinite() ||
        !std::isfinite(grid->step())) {
      return invalid("positions are to be quantized, and their bounds are not finite");
    }
  }
  if (options.gltf.meshopt && !hasMeshopt()) {
    return fail(ErrorCode::Unsupported,
                "this build has no meshoptimizer, which EXT_meshopt_compression needs");
  }
  auto root = rootNode(options);
  if (!root) return root.error();
  GltfBuilder builder(form, options);
  if (options.gltf.quantization) builder.use("KHR_mesh_quantization", true);
  if (options.gltf.meshopt) builder.use("EXT_meshopt_compression", true);
  builder.model_.asset.version = "2.0";
  builder.model_.asset.generator = kGltfGenerator;
  builder.model_.nodes.push_back(std::move(*root));
  return builder;
}

Error GltfBuilder::tooLarge() const {
  return fail(ErrorCode::Unsupported,
              isText_ ? "more geometry than a .gltf can hold; write .glb, or fewer frames or meshes"
                      : "more than the 4 GiB that a .glb can have; write fewer frames or meshes");
}

std::uint64_t GltfBuilder::maxBytes() const {
  constexpr std::uint64_t kTextBytes = std::uint64_t{3} << 29;
  return isText_ ? std::min(kTextBytes, encoding_.maxBytes) : encoding_.maxBytes;
}

void GltfBuilder::use(const std::string& extension, bool required) {
  const auto add = [&](std::vector<std::string>& names) { addOnce(names, extension); };
  add(model_.extensionsUsed);
  if (required) add(model_.extensionsRequired);
}

void GltfBuilder::pointAt(tinygltf::AnimationChannel& channel, const std::string& property) {
  channel.target_extensions["KHR_animation_pointer"] = tinygltf::Value(tinygltf::Value::Object{
      {"pointer",
       tinygltf::Value(fmt::format("/nodes/{}/extensions/{}", channel.target_node, property))}});
  channel.target_path = "pointer";
  hasPointers_ = true;
}

Result<int> GltfBuilder::addView(const Numbers& numbers, int target) {
  const std::span<const unsigned char> bytes = numbers.bytes;
  // Vertices must be multiples of four apart, and those of three short numbers are not: whoever
  // adds such has filled them up, and only then says how far apart they are.
  const std::size_t tight =
      static_cast<std::size_t>(
          tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(numbers.componentType))) *
      static_cast<std::size_t>(
          tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(numbers.type)));
  const std::size_t stride = numbers.elementBytes == tight ? 0 : numbers.elementBytes;
  const std::size_t hash =
      std::hash<std::string_view>()({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  const auto [begin, end] = views_.equal_range(hash);
  for (auto at = begin; at != end; ++at) {
    const auto index = static_cast<std::size_t>(at->second);
    const tinygltf::BufferView& view = model_.bufferViews[index];
    if (view.target == target && view.byteLength == bytes.size() && view.byteStride == stride &&
        pieces_[index].elementBytes == numbers.elementBytes &&
        std::equal(bytes.begin(), bytes.end(), pieces_[index].bytes.begin())) {
      return at->second;
    }
  }
  // Every view begins at a multiple of its largest possible component.
  constexpr std::uint64_t kAlignment = 4;
  const std::uint64_t padded = (bytes.size() + kAlignment - 1) / kAlignment * kAlignment;
  if (bufferBytes_ > maxBytes() || padded > maxBytes() - bufferBytes_) return tooLarge();

  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = bufferBytes_;
  view.byteLength = bytes.size();
  view.byteStride = stride;
  view.target = target;
  model_.bufferViews.push_back(std::move(view));
  Piece& piece = pieces_.emplace_back();
  piece.bytes.reserve(padded);
  piece.bytes.assign(bytes.begin(), bytes.end());
  piece.bytes.resize(padded);
  piece.elementBytes = numbers.elementBytes;
  piece.isTriangles = target == TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER;
  bufferBytes_ += padded;
  const int index = static_cast<int>(model_.bufferViews.size() - 1);
  views_.emplace(hash, index);
  return index;
}

Result<int> GltfBuilder::addAccessor(const Numbers& numbers, int target) {
  const auto view = addView(numbers, target);
  if (!view) return view;
  const auto [found, added] =
      accessors_.emplace(std::tuple(*view, numbers.componentType, numbers.type, numbers.normalized),
                         static_cast<int>(model_.accessors.size()));
  if (!added) return found->second;
  tinygltf::Accessor accessor;
  accessor.bufferView = *view;
  accessor.componentType = numbers.componentType;
  accessor.type = numbers.type;
  accessor.count = numbers.count;
  accessor.normalized = numbers.normalized;
  model_.accessors.push_back(std::move(accessor));
  return found->second;
}

Result<int> GltfBuilder::addTruths(const std::vector<std::uint8_t>& values) {
  return addAccessor({bytesOf(values), TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_SCALAR,
                      1, values.size()},
                     0);
}

Result<int> GltfBuilder::addOnes(std::size_t count, const std::vector<std::uint32_t>& indices) {
  const std::vector<float> ones(indices.size(), 1.0F);
  const auto where = addView({bytesOf(indices), TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                              TINYGLTF_TYPE_SCALAR, 4, indices.size()},
                             0);
  if (!where) return where;
  const auto values = addView(
      {bytesOf(ones), TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_SCALAR, 4, ones.size()}, 0);
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
      addAccessor({{reinterpret_cast<const unsigned char*>(numbers.data()), numbers.size_bytes()},
                   TINYGLTF_COMPONENT_TYPE_FLOAT,
                   type,
                   4 * width,
                   numbers.size() / width},
                  target);
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

Result<int> GltfBuilder::addIndices(const Layout& layout,
                                    std::span<const model::Triangle> triangles) {
  // The largest number of each type would mean "restart", so it is not used as an index.
  const std::size_t vertices = layout.places.size();
  if (vertices > std::numeric_limits<std::uint32_t>::max()) return tooLarge();
  const bool isShort = vertices <= std::numeric_limits<std::uint16_t>::max();
  const std::size_t count = 3 * triangles.size();
  std::vector<std::uint16_t> shorts;
  std::vector<std::uint32_t> longs;
  if (isShort) shorts.reserve(count);
  if (!isShort) longs.reserve(count);
  for (const auto& triangle : triangles) {
    for (const std::uint32_t corner : triangle) {
      if (isShort) shorts.push_back(static_cast<std::uint16_t>(corner));
      if (!isShort) longs.push_back(corner);
    }
  }
  return addAccessor(
      {isShort ? bytesOf(shorts) : bytesOf(longs),
       isShort ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
       TINYGLTF_TYPE_SCALAR, isShort ? 2U : 4U, count},
      TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
}

Result<std::vector<Eigen::Vector3f>> GltfBuilder::placesOf(const NamedMesh& named,
                                                           const model::Point3& center) {
  if (!encoding_.quantization) return roundedVertices(named, center, rounding_);
  const double step = encoding_.quantization->step();
  const model::Point3& least = encoding_.quantization->bounds.min;
  const auto most =
      static_cast<float>((1U << static_cast<unsigned>(encoding_.quantization->bits)) - 1);
  std::vector<Eigen::Vector3f> steps;
  steps.reserve(named.mesh.vertices.size());
  for (const model::Point3& vertex : named.mesh.vertices) {
    const Eigen::Vector3f at = ((vertex - least) / step).array().round().matrix().cast<float>();
    if (!(at.minCoeff() >= 0 && at.maxCoeff() <= most)) {
      return invalid(
          fmt::format("mesh '{}': vertex {} is ({}, {}, {}), outside the bounds of "
                      "quantized positions",
                      named.name, steps.size(), vertex.x(), vertex.y(), vertex.z()));
    }
    steps.push_back(at);
  }
  rounding_.add(named.mesh, steps);
  return steps;
}

Result<int> GltfBuilder::addPositions(const std::vector<Eigen::Vector3f>& places, bool isMove) {
  if (!encoding_.quantization) {
    return addFloats(floatsOf(places), 3, true, TINYGLTF_TARGET_ARRAY_BUFFER);
  }
  // A fourth number makes each a multiple of four bytes.
  std::vector<std::array<std::uint16_t, 4>> numbers;
  numbers.reserve(places.size());
  Eigen::Vector3f min = places.front();
  Eigen::Vector3f max = min;
  for (const Eigen::Vector3f& place : places) {
    auto& four = numbers.emplace_back();
    // A negative number is stored as its two's complement.
    for (int i = 0; i < 3; ++i) {
      four[i] = static_cast<std::uint16_t>(static_cast<std::int32_t>(place[i]));
    }
    min = min.cwiseMin(place);
    max = max.cwiseMax(place);
  }
  const auto index =
      addAccessor({bytesOf(numbers),
                   isMove ? TINYGLTF_COMPONENT_TYPE_SHORT : TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT,
                   TINYGLTF_TYPE_VEC3, 8, places.size()},
                  TINYGLTF_TARGET_ARRAY_BUFFER);
  if (!index) return index;
  auto& accessor = model_.accessors[static_cast<std::size_t>(*index)];
  accessor.minValues = {min.x(), min.y(), min.z()};
  accessor.maxValues = {max.x(), max.y(), max.z()};
  return index;
}

Result<int> GltfBuilder::addNormals(const std::vector<Eigen::Vector3f>& normals) {
  if (!encoding_.quantization) {
    return addFloats(floatsOf(normals), 3, false, TINYGLTF_TARGET_ARRAY_BUFFER);
  }
  std::vector<std::array<std::int8_t, 4>> numbers;
  numbers.reserve(normals.size());
  for (const Eigen::Vector3f& normal : normals) {
    auto& four = numbers.emplace_back();
    for (int i = 0; i < 3; ++i) {
      four[i] = static_cast<std::int8_t>(std::lround(127 * std::clamp(normal[i], -1.0F, 1.0F)));
    }
  }
  return addAccessor(
      {bytesOf(numbers), TINYGLTF_COMPONENT_TYPE_BYTE, TINYGLTF_TYPE_VEC3, 4, normals.size(), true},
      TINYGLTF_TARGET_ARRAY_BUFFER);
}

namespace {

using Short4 = std::array<std::uint16_t, 4>;

Short4 shortsOf(const std::array<float, 4>& color) {
  Short4 shorts{};
  for (std::size_t i = 0; i < 4; ++i) {
    const float number = color[i] >= 0 ? std::min(color[i], 1.0F) : 0.0F;
    shorts[i] = static_cast<std::uint16_t>(std::lround(65535 * number));
  }
  return shorts;
}

/// The attributes of corners that can be written.
std::vector<const model::Attribute*> cornerAttributes(const NamedMesh& named) {
  std::vector<const model::Attribute*> found;
  if (!named.ownCorners) return found;
  for (const model::Attribute& attribute : named.mesh.attributes) {
    const bool ofCorners =
        attribute.domain == model::Domain::Cell && attribute.name.ends_with(model::kCornersOf);
    if (ofCorners && attribute.components % 3 == 0 && fits(attribute, named.mesh)) {
      found.push_back(&attribute);
    }
  }
  return found;
}

/// Gives each corner of a triangle a vertex that has the triangle's colour, if there are any, and
/// what attributes have of the corner: the first one at a vertex keeps it, for others it is copied.
std::vector<model::Triangle> repeatVertices(std::span<const std::array<float, 4>> colors,
                                            std::span<const model::Attribute* const> attributes,
                                            GltfBuilder::Layout& layout) {
  const std::size_t count = layout.vertices.sources.size();
  std::vector<model::Triangle> triangles = layout.vertices.triangles;
  std::vector<std::optional<std::string>> first(count);
  std::map<std::pair<std::uint32_t, std::string>, std::uint32_t> others;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    std::string color;
    if (!colors.empty()) {
      const Short4 shorts = shortsOf(colors[i]);
      color.assign(reinterpret_cast<const char*>(shorts.data()), sizeof shorts);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& corner = triangles[i][k];
      std::string looks = color;
      for (const model::Attribute* attribute : attributes) {
        const std::size_t bytes = attribute->rowBytes() / 3;
        looks.append(reinterpret_cast<const char*>(attribute->row(i) + k * bytes), bytes);
      }
      if (!first[corner]) first[corner] = looks;
      if (*first[corner] == looks) continue;
      const auto [found, added] = others.emplace(
          std::pair(corner, looks), static_cast<std::uint32_t>(count + layout.copies.size()));
      if (added) layout.copies.push_back(corner);
      corner = found->second;
    }
  }
  return triangles;
}

/// Numbers of vertices, and of their copies after them.
std::vector<Eigen::Vector3f> withCopies(std::vector<Eigen::Vector3f> numbers,
                                        std::span<const std::uint32_t> copies) {
  for (const std::uint32_t copied : copies) numbers.push_back(numbers[copied]);
  return numbers;
}

}  // namespace

Result<int> GltfBuilder::addColors(const NamedMesh& named, const Layout& layout,
                                   std::span<const model::Triangle> triangles) {
  const auto& [domain, colors] = *named.colors;
  std::vector<Short4> shorts(layout.places.size(), Short4{});
  if (domain == model::Domain::Vertex) {
    for (std::size_t i = 0; i < shorts.size(); ++i) {
      shorts[i] = shortsOf(colors[layout.vertices.sources[i]]);
    }
  }
  for (std::size_t i = 0; domain == model::Domain::Cell && i < triangles.size(); ++i) {
    for (const std::uint32_t corner : triangles[i]) shorts[corner] = shortsOf(colors[i]);
  }
  return addAccessor({bytesOf(shorts), TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC4,
                      8, shorts.size(), true},
                     TINYGLTF_TARGET_ARRAY_BUFFER);
}

Result<void> GltfBuilder::addAttributes(const NamedMesh& named, const Layout& layout,
                                        std::span<const model::Triangle> triangles,
                                        tinygltf::Primitive& primitive) {
  const auto ofCorners = cornerAttributes(named);
  std::vector<std::uint32_t> sources = layout.vertices.sources;
  for (const std::uint32_t copied : layout.copies) sources.push_back(sources[copied]);
  for (const model::Attribute& attribute : named.mesh.attributes) {
    const auto lose = [&](const char* why) { addOnce(lost_, lostLine(attribute, why)); };
    const bool isOfCorners = std::ranges::find(ofCorners, &attribute) != ofCorners.end();
    const std::size_t components = attribute.components / (isOfCorners ? 3 : 1);
    const std::string given =
        isOfCorners ? attribute.name.substr(0, attribute.name.size() - model::kCornersOf.size())
                    : attribute.name;
    std::string name = "_" + plainName(given);
    for (char& c : name) {
      if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    }
    // glTF has v downward.
    const bool isUv = given == "uv" && components == 2;
    if (isUv) name = "TEXCOORD_0";
    if (attribute.name == kMaterial &&
        !writtenMaterials(named, {.attributes = true, .materials = materialNames_}).empty()) {
      continue;  // primitives have it
    }
    if (attribute.domain != model::Domain::Vertex && !isOfCorners) {
      lose("glTF has attributes of vertices only");
    } else if (!fits(attribute, named.mesh)) {
      lose("its rows do not fit the mesh");
    } else if (components > 4) {
      lose("glTF has attributes of at most 4 components");
    } else if (name.size() == 1 || primitive.attributes.count(name) > 0) {
      lose("it has no name, or that of another");
    } else {
      std::vector<float> numbers(sources.size() * components);
      bool areFloats = true;
      const auto put = [&](std::size_t vertex, std::size_t row, std::size_t first) {
        for (std::size_t i = 0; i < components; ++i) {
          const double known = attributeNumber(attribute, row, first + i);
          const double number = isUv && i == 1 ? 1 - known : known;
          areFloats = areFloats && std::abs(number) <= std::numeric_limits<float>::max();
          if (areFloats) numbers[vertex * components + i] = static_cast<float>(number);
        }
      };
      for (std::size_t i = 0; i < sources.size() && !isOfCorners; ++i) put(i, sources[i], 0);
      for (std::size_t i = 0; i < triangles.size() && isOfCorners; ++i) {
        for (std::size_t k = 0; k < 3; ++k) put(triangles[i][k], i, k * components);
      }
      if (!areFloats) {
        lose("some of its numbers are not finite in float32, the only type that fits all");
        continue;
      }
      const auto accessor =
          addFloats(numbers, static_cast<int>(components), false, TINYGLTF_TARGET_ARRAY_BUFFER);
      if (!accessor) return accessor.error();
      primitive.attributes[name] = *accessor;
    }
  }
  return {};
}

Result<int> GltfBuilder::addMesh(const NamedMesh& named, const model::Point3& center,
                                 Layout& layout) {
  if (auto good = checkWritable(named); !good) return good.error();
  if (named.mesh.triangles.empty()) return -1;
  const auto places = placesOf(named, center);
  if (!places) return places.error();
  layout.vertices = normals_ ? withNormals(named.mesh, *normals_) : withoutNormals(named.mesh);
  layout.copies.clear();
  std::span<const std::array<float, 4>> colors;
  if (named.colors && named.colors->domain == model::Domain::Cell) colors = named.colors->colors;
  std::vector<const model::Attribute*> ofCorners;
  if (attributes_) ofCorners = cornerAttributes(named);
  const std::vector<model::Triangle> triangles = colors.empty() && ofCorners.empty()
                                                     ? layout.vertices.triangles
                                                     : repeatVertices(colors, ofCorners, layout);
  layout.places.clear();
  layout.places.reserve(layout.vertices.sources.size() + layout.copies.size());
  for (const std::uint32_t source : layout.vertices.sources) {
    layout.places.push_back((*places)[source]);
  }
  layout.places = withCopies(std::move(layout.places), layout.copies);
  const auto positions = addPositions(layout.places, false);
  if (!positions) return positions.error();

  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.attributes["POSITION"] = *positions;
  if (normals_) {
    const auto normals = addNormals(withCopies(layout.vertices.normals, layout.copies));
    if (!normals) return normals.error();
    primitive.attributes["NORMAL"] = *normals;
  }
  if (named.colors) {
    const auto colors = addColors(named, layout, triangles);
    if (!colors) return colors.error();
    primitive.attributes["COLOR_0"] = *colors;
  }
  if (attributes_) {
    if (auto done = addAttributes(named, layout, triangles, primitive); !done) return done.error();
  }
  tinygltf::Mesh mesh;
  mesh.name = named.name;
  if (auto done = addPrimitives(named, layout, triangles, std::move(primitive), mesh); !done) {
    return done.error();
  }
  model_.meshes.push_back(std::move(mesh));
  return static_cast<int>(model_.meshes.size() - 1);
}

Result<void> GltfBuilder::addPrimitives(const NamedMesh& named, const Layout& layout,
                                        std::span<const model::Triangle> triangles,
                                        tinygltf::Primitive primitive, tinygltf::Mesh& mesh) {
  const std::vector<std::uint32_t> materials =
      writtenMaterials(named, {.attributes = attributes_, .materials = materialNames_});
  const auto add = [&](std::span<const model::Triangle> some,
                       const std::string& name) -> Result<void> {
    const auto indices = addIndices(layout, some);
    if (!indices) return indices.error();
    primitive.indices = *indices;
    primitive.material = materialOf(named, name);
    mesh.primitives.push_back(primitive);
    return {};
  };
  if (materials.empty()) return add(triangles, "");
  std::vector<std::vector<model::Triangle>> byNumber(materialNames_.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    byNumber[materials[i]].push_back(triangles[i]);
  }
  for (std::size_t number = 0; number < byNumber.size(); ++number) {
    if (byNumber[number].empty()) continue;
    if (auto done = add(byNumber[number], materialNames_[number]); !done) return done;
  }
  return {};
}

Result<void> GltfBuilder::addTarget(int mesh, const Layout& layout, const NamedMesh& shape,
                                    const model::Point3& center) {
  if (auto good = checkWritable(shape); !good) return good;
  const auto places = placesOf(shape, center);
  if (!places) return places.error();
  const std::size_t count = layout.vertices.sources.size();
  std::vector<Eigen::Vector3f> moves;
  moves.reserve(layout.places.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t source = layout.vertices.sources[i];
    if (encoding_.quantization) {
      moves.push_back((*places)[source] - layout.places[i]);
      if (moves.back().cwiseAbs().maxCoeff() <= std::numeric_limits<std::int16_t>::max()) continue;
      return fail(ErrorCode::Unsupported,
                  fmt::format("mesh '{}' moves by more steps of the grid than the 16 bits of a "
                              "morph target can hold; use at most 15 bits",
                              shape.name));
    }
    // Displacements are from the rounded place, so that rounding happens once.
    const model::Point3 move =
        shape.mesh.vertices[source] - center - layout.places[i].cast<double>();
    if (!(move.cwiseAbs().maxCoeff() <= std::numeric_limits<float>::max())) {
      return invalid(fmt::format("mesh '{}' moves beyond the float32 numbers of glTF", shape.name));
    }
    moves.push_back(move.cast<float>());
  }
  const auto positions = addPositions(withCopies(std::move(moves), layout.copies), true);
  if (!positions) return positions.error();
  std::map<std::string, int> target = {{"POSITION", *positions}};
  if (normals_) {
    std::vector<Eigen::Vector3f> turns = normalsWhenMoved(layout.vertices, shape.mesh);
    for (std::size_t i = 0; i < count; ++i) turns[i] -= layout.vertices.normals[i];
    // Up to 2, more than the integers of quantized normals can hold.
    const auto normals = addFloats(floatsOf(withCopies(std::move(turns), layout.copies)), 3, false,
                                   TINYGLTF_TARGET_ARRAY_BUFFER);
    if (!normals) return normals.error();
    target["NORMAL"] = *normals;
  }
  for (auto& primitive : model_.meshes[static_cast<std::size_t>(mesh)].primitives) {
    primitive.targets.push_back(target);
  }
  return {};
}

int GltfBuilder::materialOf(const NamedMesh& named, const std::string& name) {
  const int number = static_cast<int>(model_.materials.size());
  std::optional<Color> color = named.color;
  bool translucent = color && (*color)[3] < 1;
  int known = number;
  if (named.colors) {
    color = Color{1, 1, 1, 1};
    translucent =
        std::ranges::any_of(named.colors->colors, [](const auto& each) { return each[3] < 1; });
    known = coloredMaterials_.emplace(std::pair(name, translucent), number).first->second;
  } else {
    known = materials_.emplace(std::pair(name, color), number).first->second;
  }
  if (known != number) return known;
  tinygltf::Material material;
  material.name = !name.empty() ? name
                  : color       ? fmt::format("{}{}", kGltfColorMaterial, number)
                                : kGltfPlainMaterial;
  material.pbrMetallicRoughness.baseColorFactor = {0.8, 0.8, 0.8, 1};
  if (color) material.pbrMetallicRoughness.baseColorFactor.assign(color->begin(), color->end());
  if (translucent) material.alphaMode = "BLEND";
  material.pbrMetallicRoughness.metallicFactor = 0;
  material.pbrMetallicRoughness.roughnessFactor = 0.8;
  model_.materials.push_back(std::move(material));
  return number;
}

int GltfBuilder::addNode(tinygltf::Node node, int parent) {
  const int index = static_cast<int>(model_.nodes.size());
  model_.nodes.push_back(std::move(node));
  model_.nodes[static_cast<std::size_t>(parent)].children.push_back(index);
  return index;
}

void GltfBuilder::keepNamesInUtf8() {
  std::size_t changed = 0;
  const auto keep = [&](auto& elements) {
    for (auto& element : elements) {
      if (isUtf8(element.name)) continue;
      element.name = asName(element.name);
      ++changed;
    }
  };
  keep(model_.nodes);
  keep(model_.meshes);
  keep(model_.materials);
  keep(model_.animations);
  if (changed == 0) return;
  lost_.push_back(fmt::format("bytes of {} that are not UTF-8, in place of which is _",
                              model::counted(changed, "name")));
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
  keepNamesInUtf8();
  std::ostringstream stream;
  try {
    // Compact in a .glb, indented in a .gltf.
    tinygltf::TinyGLTF().WriteGltfSceneToStream(&model_, stream, isText_, false);
  } catch (const std::exception&) {
    return invalid("a text of it is not UTF-8");
  }
  std::string text = std::move(stream).str();
  if (!hasPointers_) return text;
  // A channel with a pointer has no node, which tinygltf always writes.
  auto json = nlohmann::ordered_json::parse(text);
  for (auto& animation : json["animations"]) {
    for (auto& channel : animation["channels"]) {
      if (channel["target"]["path"] == "pointer") channel["target"].erase("node");
    }
  }
  return json.dump(isText_ ? 2 : -1);
}

Result<std::vector<std::string>> GltfBuilder::finish(OutputFile& file) {
  auto json = documentJson();
  if (!json) return json.error();
  if (encoding_.meshopt) {
    if (auto done = compress(*json); !done) return done.error();
  }
  if (auto done = isText_ ? writeText(file, *json) : writeBinary(file, *json); !done) {
    return done.error();
  }
  if (auto line = rounding_.line()) lost_.push_back(std::move(*line));
  return lost_;
}

Result<void> GltfBuilder::compress(std::string& document) {
  auto json = nlohmann::ordered_json::parse(document);
  const std::uint64_t whole = bufferBytes_;
  bufferBytes_ = 0;
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    Piece& piece = pieces_[i];
    auto& view = json["bufferViews"][i];
    const std::size_t length = model_.bufferViews[i].byteLength;
    const std::size_t count = length / piece.elementBytes;
    const auto packed =
        meshoptPacked({piece.bytes.data(), length}, piece.elementBytes, piece.isTriangles);
    if (packed && packed->size() < length) {
      const std::uint64_t offset = view.value("byteOffset", std::uint64_t{0});
      view["buffer"] = 1;
      view["byteOffset"] = offset;
      view["extensions"]["EXT_meshopt_compression"] = {
          {"buffer", 0},
          {"byteOffset", bufferBytes_},
          {"byteLength", packed->size()},
          {"byteStride", piece.elementBytes},
          {"count", count},
          {"mode", piece.isTriangles ? "TRIANGLES" : "ATTRIBUTES"}};
      piece.bytes.assign(packed->begin(), packed->end());
      piece.bytes.resize((packed->size() + 3) / 4 * 4);
    } else {
      view["byteOffset"] = bufferBytes_;
    }
    bufferBytes_ += piece.bytes.size();
  }
  // What the views refer to when they are decompressed: it has no bytes of its own.
  otherBuffer_ = fmt::format(
      "{{\"byteLength\":{},\"extensions\":{{\"EXT_meshopt_compression\":{{\"fallback\":true}}}}}}",
      whole);
  document = json.dump(isText_ ? 2 : -1);
  return {};
}

// tinygltf would copy the buffer and ignore errors of writing, so its document has no buffer: the
// buffer's entry is put in as the first member of the document, and its bytes come from us.

Result<void> GltfBuilder::writeBinary(OutputFile& file, std::string_view document) const {
  std::string json(document);
  if (bufferBytes_ > 0) {
    json.insert(1, fmt::format("\"buffers\":[{{\"byteLength\":{}}}{}{}],", bufferBytes_,
                               otherBuffer_.empty() ? "" : ",", otherBuffer_));
  }
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const bool hasBuffer = bufferBytes_ > 0;
  const std::uint64_t length = 12 + 8 + json.size() + (hasBuffer ? 8 + bufferBytes_ : 0);
  if (length > maxBytes()) return tooLarge();

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
  for (const Piece& piece : pieces_) {
    if (auto done = file.write(piece.bytes.data(), piece.bytes.size()); !done) return done;
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
  for (const Piece& piece : pieces_) {
    waiting.insert(waiting.end(), piece.bytes.begin(), piece.bytes.end());
    const std::size_t whole = waiting.size() / 3 * 3;
    const std::string text = base64(std::span(waiting).first(whole));
    if (auto done = file.write(text.data(), text.size()); !done) return done;
    waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(whole));
  }
  const std::string after = base64(waiting) + "\"\n    }" +
                            (otherBuffer_.empty() ? "" : ",\n    " + otherBuffer_) + "\n  ],";
  if (auto done = file.write(after.data(), after.size()); !done) return done;
  const auto members = document.substr(1);
  return file.write(members.data(), members.size());
}

}  // namespace t4d::formats

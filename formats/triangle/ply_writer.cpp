#include "formats/triangle/ply_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include <fmt/format.h>

#include "formats/triangle/vertex_normals.h"
#include "formats/triangle/written_mesh.h"
#include "t4d/mesh.h"

namespace t4d::formats {
namespace {

using model::Attribute;
using model::Domain;
using model::ScalarType;

/// An attribute that all meshes have, as declared in the header.
struct Column {
  std::string attribute;  // its name in the meshes
  bool asDouble = false;  // PLY has no 64-bit integers
};

struct Columns {
  std::vector<Column> vertex;
  std::vector<Column> face;
};

bool is64Bit(ScalarType type) { return type == ScalarType::Int64 || type == ScalarType::UInt64; }

const char* plyName(ScalarType type) {
  switch (type) {
    case ScalarType::UInt8:
      return "uchar";
    case ScalarType::Int8:
      return "char";
    case ScalarType::UInt16:
      return "ushort";
    case ScalarType::Int16:
      return "short";
    case ScalarType::UInt32:
      return "uint";
    case ScalarType::Int32:
      return "int";
    case ScalarType::Float32:
      return "float";
    case ScalarType::UInt64:
    case ScalarType::Int64:
    case ScalarType::Float64:
      return "double";
  }
  return "double";
}

const Attribute* find(const model::TriangleMesh& mesh, Domain domain, const std::string& name) {
  for (const Attribute& attribute : mesh.attributes) {
    if (attribute.domain == domain && attribute.name == name) return &attribute;
  }
  return nullptr;
}

bool isExactInDouble(const Attribute& attribute) {
  constexpr double kMost = 9007199254740992.0;  // 2^53: every integer up to here is a double
  for (std::size_t row = 0; row < attribute.rows(); ++row) {
    for (std::size_t i = 0; i < attribute.components; ++i) {
      if (std::abs(attributeNumber(attribute, row, i)) > kMost) return false;
    }
  }
  return true;
}

/// Why an attribute cannot be a column of the joined meshes; empty when it can.
std::string whyNot(const Attribute& attribute, std::span<const NamedMesh> meshes) {
  for (const NamedMesh& named : meshes) {
    const Attribute* same = find(named.mesh, attribute.domain, attribute.name);
    if (same == nullptr) return fmt::format("mesh '{}' does not have it", named.name);
    if (same->type != attribute.type || same->components != attribute.components) {
      return fmt::format("mesh '{}' has it with another type", named.name);
    }
    if (!fits(*same, named.mesh)) return "its rows do not fit the mesh";
    if (is64Bit(same->type) && !isExactInDouble(*same)) {
      return "PLY has no 64-bit integers, and some are not exact in a double";
    }
  }
  return {};
}

/// The names by which readers know colours and texture coordinates of vertices; empty for others.
std::vector<std::string> lookNames(const Attribute& attribute) {
  if (attribute.domain != Domain::Vertex) return {};
  const std::uint32_t count = attribute.components;
  if (attribute.name == "color" && attribute.type == ScalarType::UInt8 && count == 3) {
    return {"red", "green", "blue"};
  }
  if (attribute.name == "color" && attribute.type == ScalarType::UInt8 && count == 4) {
    return {"red", "green", "blue", "alpha"};
  }
  if (attribute.name == "uv" && attribute.type == ScalarType::Float32 && count == 2) {
    return {"s", "t"};
  }
  return {};
}

std::vector<std::string> propertyNames(const Attribute& attribute) {
  const std::string name = plainName(attribute.name);
  if (attribute.components == 1) return {name};
  if (attribute.components == 3 && model::meaningOf(attribute, {}).kind == "vector") {
    return {name + "_x", name + "_y", name + "_z"};
  }
  std::vector<std::string> names;
  for (std::uint32_t i = 0; i < attribute.components; ++i) {
    names.push_back(fmt::format("{}_{}", name, i));
  }
  return names;
}

class Writer {
 public:
  Writer(OutputFile& file, std::span<const NamedMesh> meshes, const MeshWriteOptions& options)
      : file_(file), meshes_(meshes), options_(options) {}

  Result<std::vector<std::string>> write() {
    const bool attributes = options_.attributes;
    std::uint64_t vertices = 0;
    std::uint64_t faces = 0;
    for (const NamedMesh& named : meshes_) {
      written_.push_back(verticesToWrite(named, options_));
      vertices += written_.back().sources.size();
      faces += named.mesh.triangles.size();
    }
    vertexColors_ = hasColors(meshes_, Domain::Vertex, Domain::Vertex);
    faceColors_ = hasColors(meshes_, Domain::Cell, Domain::Vertex);
    if (vertices > std::numeric_limits<std::int32_t>::max()) {
      return fail(
          ErrorCode::Unsupported,
          fmt::format("{} vertices are more than PLY's 32-bit indices can count", vertices));
    }
    const std::string origin = originComment(options_);
    std::string header = fmt::format(
        "ply\nformat binary_little_endian 1.0\ncomment written by t4d\n{}element vertex {}\n"
        "property double x\nproperty double y\nproperty double z\n",
        origin.empty() ? origin : "comment " + origin + "\n", vertices);
    constexpr std::array<const char*, 4> kColorNames = {"red", "green", "blue", "alpha"};
    std::vector<std::string> taken = {"x", "y", "z"};
    const auto declareAll = [&](const char* type, std::span<const char* const> names) {
      for (const char* name : names) header += fmt::format("property {} {}\n", type, name);
      taken.insert(taken.end(), names.begin(), names.end());
    };
    if (options_.normals) declareAll("float", std::array{"nx", "ny", "nz"});
    if (vertexColors_) declareAll("uchar", kColorNames);
    if (attributes) declare(Domain::Vertex, taken, header);
    header += fmt::format("element face {}\nproperty list uchar int vertex_indices\n", faces);
    taken = {"vertex_indices", "vertex_index"};
    if (faceColors_) declareAll("uchar", kColorNames);
    if (attributes) declare(Domain::Cell, taken, header);
    header += "end_header\n";
    if (auto done = file_.write(header.data(), header.size()); !done) return done.error();
    if (auto done = writeVertices(); !done) return done.error();
    if (auto done = writeFaces(); !done) return done.error();
    return lost_;
  }

 private:
  void declare(Domain domain, std::vector<std::string> taken, std::string& header) {
    auto& columns = domain == Domain::Vertex ? columns_.vertex : columns_.face;
    for (const NamedMesh& named : meshes_) {
      for (const Attribute& attribute : named.mesh.attributes) {
        if (attribute.domain != domain ||
            std::ranges::find(columns, attribute.name, &Column::attribute) != columns.end()) {
          continue;
        }
        std::string why = whyNot(attribute, meshes_);
        const auto isTaken = [&](const std::string& name) {
          return std::ranges::find(taken, name) != taken.end();
        };
        auto names = lookNames(attribute);
        if (names.empty() || std::ranges::any_of(names, isTaken)) names = propertyNames(attribute);
        for (const auto& name : names) {
          if (isTaken(name)) why = "another has the same name";
          if (name.empty()) why = "it has no name";
        }
        if (!why.empty()) {
          addOnce(lost_, lostLine(attribute, why));
          continue;
        }
        columns.push_back({attribute.name, is64Bit(attribute.type)});
        taken.insert(taken.end(), names.begin(), names.end());
        for (const auto& name : names) {
          header += fmt::format("property {} {}\n", plyName(attribute.type), name);
        }
      }
    }
  }

  template <class T>
  void put(const T* values, std::size_t count) {
    const auto* bytes = reinterpret_cast<const char*>(values);
    row_.insert(row_.end(), bytes, bytes + count * sizeof(T));
  }

  void putColumns(const std::vector<std::pair<const Attribute*, bool>>& columns, std::size_t row) {
    for (const auto& [attribute, asDouble] : columns) {
      if (!asDouble) put(attribute->row(row), attribute->rowBytes());
      for (std::size_t i = 0; asDouble && i < attribute->components; ++i) {
        const double number = attributeNumber(*attribute, row, i);
        put(&number, 1);
      }
    }
  }

  static std::vector<std::pair<const Attribute*, bool>> inMesh(const std::vector<Column>& columns,
                                                               const model::TriangleMesh& mesh,
                                                               Domain domain) {
    std::vector<std::pair<const Attribute*, bool>> found;
    found.reserve(columns.size());
    for (const auto& [name, asDouble] : columns) {
      found.emplace_back(find(mesh, domain, name), asDouble);
    }
    return found;
  }

  Result<void> endRow() {
    auto done = file_.write(row_.data(), row_.size());
    row_.clear();
    return done;
  }

  Result<void> writeVertices() {
    for (std::size_t mesh = 0; mesh < meshes_.size(); ++mesh) {
      const NamedMesh& named = meshes_[mesh];
      const auto columns = inMesh(columns_.vertex, named.mesh, Domain::Vertex);
      for (std::size_t i = 0; i < written_[mesh].sources.size(); ++i) {
        const std::uint32_t source = written_[mesh].sources[i];
        const model::Point3 vertex = named.mesh.vertices[source] - options_.center;
        put(vertex.data(), 3);
        if (options_.normals) put(written_[mesh].normals[i].data(), 3);
        if (vertexColors_) put(sRgbOf(named, Domain::Vertex, source).data(), 4);
        putColumns(columns, source);
        if (auto done = endRow(); !done) return done;
      }
    }
    return {};
  }

  Result<void> writeFaces() {
    std::uint32_t first = 0;
    for (std::size_t mesh = 0; mesh < meshes_.size(); ++mesh) {
      const NamedMesh& named = meshes_[mesh];
      const auto columns = inMesh(columns_.face, named.mesh, Domain::Cell);
      for (std::size_t i = 0; i < named.mesh.triangles.size(); ++i) {
        auto corners = written_[mesh].triangles[i];
        for (auto& corner : corners) corner += first;
        row_.push_back(3);
        put(corners.data(), 3);
        if (faceColors_) put(sRgbOf(named, Domain::Cell, i).data(), 4);
        putColumns(columns, i);
        if (auto done = endRow(); !done) return done;
      }
      first += static_cast<std::uint32_t>(written_[mesh].sources.size());
    }
    return {};
  }

  OutputFile& file_;
  std::span<const NamedMesh> meshes_;
  const MeshWriteOptions& options_;
  Columns columns_;
  std::vector<VerticesWithNormals> written_;  // of each mesh
  bool vertexColors_ = false;
  bool faceColors_ = false;
  std::vector<std::string> lost_;
  std::vector<char> row_;
};

}  // namespace

// Numbers are written as they are in memory.
static_assert(std::endian::native == std::endian::little);

Result<std::vector<std::string>> writePly(OutputFile& file, std::span<const NamedMesh> meshes,
                                          const MeshWriteOptions& options) {
  return Writer(file, meshes, options).write();
}

}  // namespace t4d::formats

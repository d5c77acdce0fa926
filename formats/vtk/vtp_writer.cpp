#include "formats/vtk/vtp_writer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include "formats/text/xml_text.h"
#include "formats/triangle/vertex_normals.h"
#include "formats/triangle/written_mesh.h"
#include "formats/zlib_block.h"
#include "model/corner_attributes.h"
#include "t4d/mesh.h"

namespace t4d::formats {
namespace {

using model::Attribute;
using model::Domain;
using model::ScalarType;

// Numbers are written as they are in memory.
static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kVtpBlockBytes = std::size_t{1} << 18;

const char* vtkName(ScalarType type) {
  switch (type) {
    case ScalarType::UInt8:
      return "UInt8";
    case ScalarType::Int8:
      return "Int8";
    case ScalarType::UInt16:
      return "UInt16";
    case ScalarType::Int16:
      return "Int16";
    case ScalarType::UInt32:
      return "UInt32";
    case ScalarType::Int32:
      return "Int32";
    case ScalarType::UInt64:
      return "UInt64";
    case ScalarType::Int64:
      return "Int64";
    case ScalarType::Float32:
      return "Float32";
    case ScalarType::Float64:
      return "Float64";
  }
  return "Float64";
}

const Attribute* attributeNamed(const NamedMesh& named, Domain domain, std::string_view name) {
  for (const Attribute& attribute : named.mesh.attributes) {
    if (attribute.domain == domain && attribute.name == name) return &attribute;
  }
  return nullptr;
}

/// Attributes of corners keep the end of their names, by which they are known when they are read.
std::string arrayName(std::string_view name) {
  if (!name.ends_with(model::kCornersOf)) return plainName(name);
  name.remove_suffix(model::kCornersOf.size());
  return plainName(name) + std::string(model::kCornersOf);
}

class VtpWriter {
 public:
  VtpWriter(std::span<const NamedMesh> meshes, const MeshWriteOptions& options)
      : meshes_(meshes), options_(options) {
    for (const NamedMesh& named : meshes) {
      written_.push_back(verticesToWrite(named, options));
      vertices_ += written_.back().sources.size();
      triangles_ += named.mesh.triangles.size();
    }
  }

  Result<std::vector<std::string>> write(OutputFile& file) {
    const std::string origin = originComment(options_);
    std::string head =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
        "byte_order=\"LittleEndian\" header_type=\"UInt64\" "
        "compressor=\"vtkZLibDataCompressor\">\n<!-- written by t4d" +
        (origin.empty() ? origin : "; " + origin) + " -->\n<PolyData>\n" + fieldData() +
        fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfPolys=\"{}\">\n", vertices_, triangles_);
    // Arrays are appended in this order.
    std::string ofPoints;
    if (options_.normals) ofPoints += normals();
    if (has(Domain::Vertex)) ofPoints += colors(Domain::Vertex);
    if (options_.attributes) ofPoints += attributes(Domain::Vertex);
    head += fmt::format("<PointData{}{}>\n", options_.normals ? " Normals=\"Normals\"" : "",
                        vectors_.empty() ? "" : " Vectors=\"" + xmlEscaped(vectors_) + "\"");
    head += ofPoints + "</PointData>\n<CellData>\n";
    if (meshes_.size() > 1) head += bodies();
    if (has(Domain::Cell)) head += colors(Domain::Cell);
    if (options_.attributes) head += attributes(Domain::Cell);
    head += "</CellData>\n<Points>\n";
    head += points();
    head += "</Points>\n<Polys>\n";
    head += polygons();
    head += "</Polys>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
    const std::string_view end = "\n</AppendedData>\n</VTKFile>\n";
    for (const std::string_view part : {std::string_view(head), std::string_view(data_), end}) {
      if (auto done = file.write(part.data(), part.size()); !done) return done.error();
    }
    return lost_;
  }

 private:
  /// The time, where VTK's readers look for it, and the names of bodies.
  std::string fieldData() const {
    std::string text;
    if (options_.time) {
      text += fmt::format(
          "<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
          "format=\"ascii\">{}</DataArray>\n",
          *options_.time);
    }
    if (meshes_.size() > 1) {
      text += fmt::format(
          "<Array type=\"String\" Name=\"body_names\" NumberOfTuples=\"{}\" format=\"ascii\">\n",
          meshes_.size());
      for (const NamedMesh& named : meshes_) {
        // VTK has strings as the numbers of their bytes.
        for (const char c : named.name) text += fmt::format("{} ", static_cast<unsigned char>(c));
        text += "0 ";
      }
      text += "\n</Array>\n";
    }
    return text.empty() ? text : "<FieldData>\n" + text + "</FieldData>\n";
  }

  /// Appends the bytes to the data, and returns the element that says where they are.
  std::string array(std::string_view type, std::string_view name, std::size_t components,
                    std::string_view bytes) {
    std::vector<std::uint64_t> table = {(bytes.size() + kVtpBlockBytes - 1) / kVtpBlockBytes,
                                        kVtpBlockBytes, bytes.size() % kVtpBlockBytes};
    std::string packed;
    for (std::size_t at = 0; at < bytes.size(); at += kVtpBlockBytes) {
      const std::string block = zlibCompressed(bytes.substr(at, kVtpBlockBytes));
      table.push_back(block.size());
      packed += block;
    }
    const std::size_t offset = data_.size();
    data_.append(reinterpret_cast<const char*>(table.data()), table.size() * sizeof(table[0]));
    data_ += packed;
    return fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" "
        "offset=\"{}\"/>\n",
        type, name, components, offset);
  }

  template <class T>
  std::string arrayOf(std::string_view type, std::string_view name, std::size_t components,
                      const std::vector<T>& values) {
    return array(type, name, components,
                 {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
  }

  std::string points() {
    std::vector<double> numbers;
    numbers.reserve(3 * vertices_);
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
      for (const std::uint32_t source : written_[i].sources) {
        const model::Point3 vertex = meshes_[i].mesh.vertices[source] - options_.center;
        numbers.insert(numbers.end(), vertex.data(), vertex.data() + 3);
      }
    }
    return arrayOf("Float64", "Points", 3, numbers);
  }

  std::string polygons() {
    std::vector<std::int64_t> corners;
    std::vector<std::int64_t> ends;
    corners.reserve(3 * triangles_);
    ends.reserve(triangles_);
    std::int64_t first = 0;
    for (const VerticesWithNormals& written : written_) {
      for (const model::Triangle& triangle : written.triangles) {
        for (const std::uint32_t corner : triangle) corners.push_back(first + corner);
        ends.push_back(static_cast<std::int64_t>(corners.size()));
      }
      first += static_cast<std::int64_t>(written.sources.size());
    }
    std::string text = arrayOf("Int64", "connectivity", 1, corners);
    text += arrayOf("Int64", "offsets", 1, ends);
    return text;
  }

  std::string bodies() {
    std::vector<std::int32_t> numbers;
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
      numbers.insert(numbers.end(), meshes_[i].mesh.triangles.size(), static_cast<std::int32_t>(i));
    }
    return arrayOf("Int32", "body", 1, numbers);
  }

  std::string normals() {
    std::vector<Eigen::Vector3f> all;
    for (const VerticesWithNormals& written : written_) {
      all.insert(all.end(), written.normals.begin(), written.normals.end());
    }
    return arrayOf("Float32", "Normals", 3, all);
  }

  bool has(Domain domain) const { return hasColors(meshes_, domain, Domain::Cell); }

  std::string colors(Domain domain) {
    std::vector<std::array<std::uint8_t, 4>> all;
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
      const std::vector<std::uint32_t>& sources = written_[i].sources;
      const bool ofVertices = domain == Domain::Vertex;
      const std::size_t count = ofVertices ? sources.size() : meshes_[i].mesh.triangles.size();
      for (std::size_t row = 0; row < count; ++row) {
        all.push_back(sRgbOf(meshes_[i], domain, ofVertices ? sources[row] : row));
      }
    }
    return arrayOf("UInt8", "color", 4, all);
  }

  /// Why the meshes do not have one array for this attribute; empty if they do.
  std::string whyNot(const Attribute& attribute) const {
    if (plainName(attribute.name).empty()) return "it has no name";
    for (const NamedMesh& named : meshes_) {
      const Attribute* same = attributeNamed(named, attribute.domain, attribute.name);
      if (same == nullptr) return fmt::format("mesh '{}' does not have it", named.name);
      if (same->type != attribute.type || same->components != attribute.components) {
        return fmt::format("mesh '{}' has it with another type", named.name);
      }
      if (!fits(*same, named.mesh)) return "its rows do not fit the mesh";
    }
    return {};
  }

  std::string attributes(Domain domain) {
    std::vector<std::string> seen;
    std::vector<std::string> taken;
    if (domain == Domain::Cell && meshes_.size() > 1) taken.emplace_back("body");
    if (has(domain)) taken.emplace_back("color");
    if (domain == Domain::Vertex && options_.normals) taken.emplace_back("Normals");
    std::string text;
    for (const NamedMesh& named : meshes_) {
      for (const Attribute& attribute : named.mesh.attributes) {
        if (attribute.domain != domain || std::ranges::find(seen, attribute.name) != seen.end()) {
          continue;
        }
        seen.push_back(attribute.name);
        std::string why = whyNot(attribute);
        const std::string name = arrayName(attribute.name);
        if (std::ranges::find(taken, name) != taken.end()) why = "another has the same name";
        if (!why.empty()) {
          addOnce(lost_, lostLine(attribute, why));
          continue;
        }
        taken.push_back(name);
        if (vectors_.empty() && model::meaningOf(attribute, {}).kind == "vector") vectors_ = name;
        std::string bytes;
        for (std::size_t i = 0; i < meshes_.size(); ++i) {
          const Attribute& each = *attributeNamed(meshes_[i], domain, attribute.name);
          if (domain == Domain::Cell) {
            bytes.append(reinterpret_cast<const char*>(each.values.data()), each.values.size());
            continue;
          }
          for (const std::uint32_t source : written_[i].sources) {
            bytes.append(reinterpret_cast<const char*>(each.row(source)), each.rowBytes());
          }
        }
        text += array(vtkName(attribute.type), name, attribute.components, bytes);
      }
    }
    return text;
  }

  std::span<const NamedMesh> meshes_;
  const MeshWriteOptions& options_;
  std::vector<VerticesWithNormals> written_;  // of each mesh
  std::size_t vertices_ = 0;
  std::size_t triangles_ = 0;
  std::string data_;
  std::string vectors_;  // the name of the points' active vectors, if there are any
  std::vector<std::string> lost_;
};

}  // namespace

Result<std::vector<std::string>> writeVtp(OutputFile& file, std::span<const NamedMesh> meshes,
                                          const MeshWriteOptions& options) {
  return VtpWriter(meshes, options).write(file);
}

}  // namespace t4d::formats

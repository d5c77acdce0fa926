#include "formats/mesh4d/g4mf_writer.h"

#include <bit>
#include <cstring>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/output_file.h"
#include "formats/text/base64.h"

namespace t4d::formats {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kG4mfHeaderBytes = 16;  // of the file, and of a chunk
constexpr std::uint64_t kG4mfVertexBytes = 32;
constexpr std::uint64_t kG4mfCellBytes = 16;

// Numbers are written as they are in memory.
static_assert(std::endian::native == std::endian::little);

/// A name as the format allows it: without some characters, and of no other node.
std::string nodeName(const std::string& name, std::set<std::string>& taken) {
  static constexpr std::string_view kForbidden = "\"#*.:|?@<>{}[]/\\%";
  std::string made;
  for (std::size_t i = 0; i < name.size(); ++i) {
    // U+0080 to U+009F are control characters, too: C2 80 to C2 9F.
    const auto byte = static_cast<unsigned char>(name[i]);
    const bool isC1 =
        byte == 0xC2 && i + 1 < name.size() && static_cast<unsigned char>(name[i + 1]) < 0xA0;
    if (isC1) ++i;
    const bool isAllowed =
        byte >= 0x20 && byte != 0x7F && kForbidden.find(name[i]) == std::string_view::npos;
    made += isC1 || !isAllowed ? '_' : name[i];
  }
  std::string unique = made;
  for (int number = 2; !made.empty() && !taken.insert(unique).second; ++number) {
    unique = fmt::format("{} {}", made, number);
  }
  return unique;
}

/// All vertices come first in the buffer, then all cells. The name of a body is that of its node;
/// one that the format forbids is kept as it is in the extras of the node.
ordered_json documentOf(const FlatBodies& mesh) {
  ordered_json document;
  document["asset"] = {{"dimension", 4}, {"generator", "t4d"}};
  ordered_json children = ordered_json::array();
  document["nodes"] = {ordered_json::object()};
  std::set<std::string> taken;
  std::uint64_t vertices = 0;
  std::uint64_t cells = kG4mfVertexBytes * mesh.vertexCount();
  int index = 0;
  for (const CountedBody& body : mesh.bodies()) {
    for (const auto& [offset, count, bytes, type] :
         {std::tuple{&vertices, body.vertices, kG4mfVertexBytes, "float64"},
          std::tuple{&cells, body.tetrahedra, kG4mfCellBytes, "uint32"}}) {
      document["bufferViews"].push_back(
          {{"buffer", 0}, {"byteLength", count * bytes}, {"byteOffset", *offset}});
      document["accessors"].push_back({{"bufferView", document["bufferViews"].size() - 1},
                                       {"componentType", type},
                                       {"vectorSize", 4}});
      *offset += count * bytes;
    }
    document["meshes"].push_back(
        {{"vertices", 2 * index}, {"surfaces", {{{"simplexes", 2 * index + 1}}}}});
    ordered_json node = {{"name", nodeName(body.name, taken)}, {"meshInstance", {{"mesh", index}}}};
    if (node["name"] != body.name) node["extras"] = {{"t4d_name", body.name}};
    document["nodes"].push_back(node);
    children.push_back(++index);
  }
  document["nodes"][0]["children"] = children;
  document["buffers"] = {{{"byteLength", cells}}};
  return document;
}

std::string textOf(const ordered_json& document, int indent) {
  return document.dump(indent, ' ', false, ordered_json::error_handler_t::replace);
}

/// Calls back with the bytes of the buffer in order. The corners of a cell count from the first
/// vertex of its body.
template <class Take>
Result<void> forData(const FlatBodies& mesh, Take take) {
  auto done = mesh.forVertices([&](std::span<const model::Point4> vertices) {
    return take(reinterpret_cast<const char*>(vertices.data()), vertices.size_bytes());
  });
  if (!done) return done;
  std::vector<std::uint32_t> first;
  std::uint32_t next = 0;
  for (const CountedBody& body : mesh.bodies()) {
    first.push_back(next);
    next += static_cast<std::uint32_t>(body.vertices);
  }
  std::vector<model::Cell> some;
  return mesh.forCells([&](std::size_t body, std::span<const model::Cell> cells) {
    some.assign(cells.begin(), cells.end());
    for (model::Cell& cell : some) {
      for (std::uint32_t& corner : cell) corner -= first[body];
    }
    return take(reinterpret_cast<const char*>(some.data()), some.size() * sizeof(model::Cell));
  });
}

Result<void> writeHeader(OutputFile& file, const char* type, std::uint64_t size) {
  char header[kG4mfHeaderBytes] = {};
  std::memcpy(header, type, 4);
  std::memcpy(header + 8, &size, 8);
  return file.write(header, kG4mfHeaderBytes);
}

}  // namespace

Result<void> writeG4mfText(const std::filesystem::path& path, const FlatBodies& mesh) {
  std::string data;
  data.reserve(kG4mfVertexBytes * mesh.vertexCount() + kG4mfCellBytes * mesh.cellCount());
  auto done = forData(mesh, [&](const char* bytes, std::size_t size) -> Result<void> {
    data.append(bytes, size);
    return {};
  });
  if (!done) return done;
  ordered_json document = documentOf(mesh);
  document["buffers"][0]["uri"] =
      "data:application/octet-stream;base64," +
      base64({reinterpret_cast<const std::uint8_t*>(data.data()), data.size()});
  const std::string text = textOf(document, 1) + "\n";
  return writeOutputFile(path, text);
}

Result<void> writeG4mfBinary(const std::filesystem::path& path, const FlatBodies& mesh) {
  auto file = OutputFile::create(path);
  if (!file) return file.error();
  ordered_json document = documentOf(mesh);
  document["buffers"][0]["chunk"] = 1;
  std::string json = textOf(document, -1);
  const std::uint64_t jsonBytes = json.size();
  json.resize((json.size() + 15) / 16 * 16, ' ');
  const std::uint64_t dataBytes =
      kG4mfVertexBytes * mesh.vertexCount() + kG4mfCellBytes * mesh.cellCount();
  auto done = writeHeader(*file, "G4MF", 3 * kG4mfHeaderBytes + json.size() + dataBytes);
  if (done) done = writeHeader(*file, "JSON", jsonBytes);
  if (done) done = file->write(json.data(), json.size());
  if (done) done = writeHeader(*file, "BLOB", dataBytes);
  if (done) {
    done = forData(mesh,
                   [&](const char* bytes, std::size_t size) { return file->write(bytes, size); });
  }
  if (!done) return done;
  return file->commit();
}

}  // namespace t4d::formats

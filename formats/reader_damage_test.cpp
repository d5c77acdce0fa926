#include <algorithm>
#include <random>

#include "formats/mesh4d/test_mesh4d.h"
#include "formats/test_files.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "t4d/file.h"

/// Damaged files must be read or refused, never crash, hang or ask for much memory: run under
/// AddressSanitizer this is a small fuzzer.
namespace t4d::formats {
namespace {

NamedMesh cube() {
  NamedMesh named{"cube", {}};
  for (int i = 0; i < 8; ++i) named.mesh.vertices.push_back(cubeCorner(i));
  for (const auto& s : kCubeSquares) {
    for (const auto& [b, c] : {std::pair{1, 2}, std::pair{2, 3}}) {
      named.mesh.triangles.push_back({static_cast<std::uint32_t>(s[0]),
                                      static_cast<std::uint32_t>(s[b]),
                                      static_cast<std::uint32_t>(s[c])});
    }
  }
  return named;
}

struct Sample {
  std::string file;
  std::string bytes;
  std::string format4d = {};  // the id of a format of 4D meshes
};

/// A file of each format of 4D meshes.
void addSamples4d(std::vector<Sample>& all) {
  const std::vector<Mesh4d> bodies = smallBodies();
  for (const Mesh4dFormat& format : mesh4dFormats()) {
    if (!format.keeps.tetrahedra) continue;
    const auto path = written4d(format, bodies);
    for (const std::string_view extension : format.extensions) {
      auto named = path;
      named.replace_extension(extension);
      if (!std::filesystem::exists(named)) continue;
      const std::string file = std::string(format.id) + std::string(extension);
      all.push_back({file, platform::contents(named), std::string(format.id)});
      // The other file of a pair is whole.
      writeFile("damaged_" + file, platform::contents(named));
    }
  }
  all.push_back({"octahedra.off",
                 "4OFF\n# c\n6 8 12 2\n1 0 0 0\n-1 0 0 0\n0 1 0 0\n0 -1 0 0\n0 0 1 0\n0 0 -1 0\n"
                 "3 0 2 4\n3 2 1 4\n3 1 3 4\n3 3 0 4\n3 2 0 5\n3 1 2 5\n3 3 1 5\n3 0 3 5\n"
                 "8 0 1 2 3 4 5 6 7\n8 7 6 5 4 3 2 1 0\n",
                 "off-stella"});
  all.push_back({"simplex.4do",
                 "4DO 1\norient -Y W X -Z\nv 0 0 0 0\nv 1 0 0 0\nv 0 1 0 0\nv 0 0 1 0\nv 0 0 0 1\n"
                 "vn 0 0 0 1\nco 1 2 3\ntformat co v/vn\nt 0 1/0 2/0 3/0 4/0\nt 0 2/0 0/0 3/0 4/0\n"
                 "t 0 0/0 1/0 3/0 4/0\nt 0 1/0 0/0 2/0 4/0\nt 0 0/0 1/0 2/0 3/0\np 0 1\n",
                 "4do"});
}

std::vector<Sample> samples() {
  std::vector<Sample> all;
  for (const auto& format : triangleMeshFormats()) {
    if (format.write == nullptr) continue;
    const std::string file = "cube" + std::string(format.extension);
    const auto path = temporaryPath(file);
    EXPECT_TRUE(writeTriangleMeshes(path, std::vector{cube()}, {.placement = {0.5, true}}));
    all.push_back({file, platform::contents(path)});
  }
  all.push_back({"text.stl",
                 "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                 "vertex 0 1 0\nendloop\nendfacet\nendsolid a\n"});
  all.push_back({"text.ply",
                 "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
                 "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                 "end_header\n0 0 0\n1 0 0\n0.2 0.2 0\n0 1 0\n-1 -1 0\n5 0 1 2 3 4\n"});
  all.push_back({"strips.ply",
                 "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                 "property float z\nelement tristrips 1\nproperty list int int vertex_indices\n"
                 "end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 3 2 0\n"});
  all.push_back({"text.off",
                 "OFF\n# comment\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n4 0 1 3 2\n3 0 1 "
                 "2 1.0 0 0\n"});
  all.push_back(
      {"text.obj", "v 0 0 0\nv 1 0 0\nv 0.2 0.2 0 1\nv 0 1 0\nf 1/1 2//2 \\\n -2/1/1 4\n"});
  addSamples4d(all);
  return all;
}

void judgeRefusal(const Error& error) {
  EXPECT_FALSE(error.message.empty());
  EXPECT_TRUE(error.where.file.starts_with(temporaryPath("damaged_").string())) << error.text();
}

bool readAndJudge4d(const Sample& sample, const std::string& bytes) {
  const auto loaded = read4d(writeFile("damaged_" + sample.file, bytes), sample.format4d);
  if (!loaded) {
    judgeRefusal(loaded.error());
    return false;
  }
  EXPECT_FALSE(loaded->bodies.empty());
  for (const Mesh4d& body : loaded->bodies) {
    EXPECT_FALSE(body.cells.empty());
    for (const auto& vertex : body.vertices) EXPECT_TRUE(vertex.allFinite());
    for (const auto& cell : body.cells) {
      EXPECT_LT(*std::ranges::max_element(cell), body.vertices.size());
    }
  }
  return true;
}

/// What is read from a damaged file must still be a mesh. True when the file was not refused.
bool readAndJudge(const Sample& sample, const std::string& bytes) {
  if (!sample.format4d.empty()) return readAndJudge4d(sample, bytes);
  const auto loaded =
      readTriangleMesh(writeFile("damaged_" + sample.file, bytes), Keep::Attributes);
  if (!loaded) {
    judgeRefusal(loaded.error());
    return false;
  }
  EXPECT_FALSE(loaded->mesh.triangles.empty());
  for (const auto& vertex : loaded->mesh.vertices) EXPECT_TRUE(vertex.allFinite());
  for (const auto& triangle : loaded->mesh.triangles) {
    EXPECT_LT(*std::ranges::max_element(triangle), loaded->mesh.vertices.size());
  }
  return true;
}

TEST(DamagedFiles, CutAtEveryByteAreReadOrRefused) {
  for (const Sample& sample : samples()) {
    const auto& [file, bytes, format] = sample;
    const bool isBinary = file == "cube.stl" || file == "cube.ply" || file == "cube.glb" ||
                          format == "vtu" || format == "g4b" || format == "meditb";
    // Nothing is lost with the offset after Medit's last keyword, which some writers leave out.
    const std::size_t needed = bytes.size() - (format == "meditb" ? 8 : 0);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const bool read = readAndJudge(sample, bytes.substr(0, size));
      EXPECT_FALSE(read && isBinary && size < needed) << file << " " << size;
    }
    writeFile("damaged_" + file, bytes);
  }
}

TEST(DamagedFiles, WithOtherBytesAreReadOrRefused) {
  constexpr int kRounds = 400;
  std::mt19937 random(7);
  const auto below = [&](std::size_t count) { return random() % count; };
  const std::string telling = "0123456789+-.eE/\\#\n\r {}[]\",:\xff" + std::string(1, '\0');
  for (const Sample& sample : samples()) {
    const std::string& bytes = sample.bytes;
    for (int round = 0; round < kRounds; ++round) {
      std::string damaged = bytes;
      for (std::size_t i = 1 + below(4); i > 0; --i) {
        const std::size_t at = below(damaged.size());
        switch (below(4)) {
          case 0:
            damaged[at] = static_cast<char>(random());
            break;
          case 1:
            damaged[at] = telling[below(telling.size())];
            break;
          case 2:
            damaged.erase(at, 1 + below(8));
            break;
          default:
            damaged.insert(at, damaged.substr(below(damaged.size()), 1 + below(12)));
        }
        if (damaged.empty()) damaged = " ";
      }
      readAndJudge(sample, damaged);
    }
    writeFile("damaged_" + sample.file, bytes);
  }
}

}  // namespace
}  // namespace t4d::formats

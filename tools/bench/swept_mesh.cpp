#include "tools/bench/swept_mesh.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>

#include "mesh4d/cap.h"
#include "platform/part_file.h"
#include "t4d/file.h"
#include "t4d/mesh.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"

namespace t4d::bench {
namespace {

using model::Cell;
using model::Point4;
using model::Slab;

/// The value of a result; benchmarks have no use for an error but to end.
template <class T>
T need(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().text());
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

/// What of a slab a plain file would hold: vertices that the slab before has not, and cells.
std::span<const Point4> newVertices(const Slab& slab) {
  return std::span(slab.vertices).subspan(slab.connectivity->lowerCount);
}

/// The bytes of an array.
template <class T>
std::string_view bytesOf(std::span<const T> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

/// Also waits for the disk and renames the file, as the writer of .t4d does.
void writeRaw(const model::Mesh& mesh, const std::filesystem::path& path) {
  platform::PartFile file = need(platform::PartFile::create(path));
  for (const Slab& slab : mesh.slabs()) {
    need(file.write(bytesOf(newVertices(slab))));
    need(file.write(bytesOf(std::span<const Cell>(slab.connectivity->cells))));
  }
  need(platform::PartFile::putInPlace({&file, 1}));
}

void readRaw(const std::filesystem::path& path, std::vector<std::byte>& buffer) {
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) throw std::runtime_error(path.string() + ": cannot be read");
  while (std::fread(buffer.data(), 1, buffer.size(), file) == buffer.size()) {
  }
  std::fclose(file);
}

std::uint64_t writeT4d(model::Mesh& mesh, const std::filesystem::path& path, int compression) {
  formats::Metadata metadata;
  metadata.bodies = {{"body"}};
  auto writer = need(formats::T4dWriter::create(path, metadata, {.compression = compression}));
  need(pump(mesh, writer.body(0)));
  return need(writer.finish());
}

void readT4d(const std::filesystem::path& path) {
  auto reader = need(formats::T4dReader::open(path));
  model::NullSink drop;
  need(pump(reader.body(0), drop));
}

}  // namespace

Result<void> measureSweptMesh(const model::TriangleMesh& solid, const model::Motion& motion,
                              double minVolumeRatio, const std::filesystem::path& folder,
                              Report& report) try {
  const int n = report.repetitions;
  mesh4d::SweepOptions options;
  options.steps = mesh4d::MinVolumeRatio{minVolumeRatio};
  options.caps = mesh4d::CapMethod::Cone;
  model::NullSink drop;
  const mesh4d::SweepReport swept = need(mesh4d::sweep(solid, motion, options, drop));
  const std::uint64_t sweepPeak = peakBytes();

  const std::uint64_t vertexBytes = swept.vertices * sizeof(Point4);
  const std::uint64_t rawBytes = vertexBytes + swept.tetrahedra * sizeof(Cell);
  report.input +=
      fmt::format(": {} triangles, {} steps; {} vertices, {} cells, raw arrays {:.1f} MB",
                  solid.triangles.size(), swept.steps, swept.vertices, swept.tetrahedra,
                  static_cast<double>(rawBytes) / 1e6);

  const auto sweepOnce = [&] { need(mesh4d::sweep(solid, motion, options, drop)); };
  {
    // Written first, so that no page is new to the process when it is measured.
    std::vector<std::byte> from(rawBytes, std::byte{1});
    std::vector<std::byte> to(rawBytes, std::byte{2});
    report.rows.push_back(compare(n, "sweep", sweepOnce, "memcpy of the raw arrays",
                                  [&] { std::memcpy(to.data(), from.data(), rawBytes); }));
    report.rows.push_back(compare(n, "sweep", sweepOnce, "memcpy of the vertices alone",
                                  [&] { std::memcpy(to.data(), from.data(), vertexBytes); }));
  }
  if (mesh4d::fillSolid(solid, mesh4d::CapMethod::TetGen)) {
    report.rows.push_back(compare(
        n, "filling the solid by TetGen",
        [&] { need(mesh4d::fillSolid(solid, mesh4d::CapMethod::TetGen)); }, "sweep", sweepOnce));
  }

  model::Mesh mesh;
  need(mesh4d::sweep(solid, motion, options, mesh));
  const auto raw = folder / "raw.bin";
  const auto packed = folder / "packed.t4d";
  const auto plain = folder / "plain.t4d";
  std::uint64_t packedBytes = 0;
  std::uint64_t plainBytes = 0;
  const auto writeRawOnce = [&] { writeRaw(mesh, raw); };
  report.rows.push_back(compare(
      n, "write .t4d, zstd 3", [&] { packedBytes = writeT4d(mesh, packed, 3); },
      "write of the raw arrays", writeRawOnce));
  report.rows.push_back(compare(
      n, "write .t4d, uncompressed", [&] { plainBytes = writeT4d(mesh, plain, 0); },
      "write of the raw arrays", writeRawOnce));
  constexpr std::size_t kBufferBytes = std::size_t{1} << 22;
  std::vector<std::byte> buffer(kBufferBytes);
  const auto readRawOnce = [&] { readRaw(raw, buffer); };
  report.rows.push_back(compare(
      n, "read .t4d, zstd 3", [&] { readT4d(packed); }, "read of the raw arrays", readRawOnce));
  report.rows.push_back(compare(
      n, "read .t4d, uncompressed", [&] { readT4d(plain); }, "read of the raw arrays",
      readRawOnce));

  // Between two layers, where every cell of the slab is cut or nearly.
  const std::size_t middle = mesh.slabCount() / 2;
  const model::TimeSpan span = mesh.timeSpan(middle);
  const auto hyperplane = slice::Hyperplane::atTime(0.4 * span.begin + 0.6 * span.end);
  report.rows.push_back(compare(
      n, "slice at t from the file",
      [&] {
        auto reader = need(formats::T4dReader::open(packed));
        need(slice::sliceAtTime(reader.body(0), hyperplane.offset));
      },
      "slicing every slab of the file",
      [&] {
        auto reader = need(formats::T4dReader::open(packed));
        slice::Slicer slicer(hyperplane);
        need(pump(reader.body(0), slicer));
        slicer.finish();
      }));
  const double firstSeconds =
      medianSeconds(4 * n, [&] { need(slice::sliceAtTime(mesh, hyperplane.offset)); });
  const slice::TimeSlicer slicer(mesh);
  int times = 0;
  const double furtherSeconds = medianSeconds(
      4 * n, [&] { need(slicer.at(std::lerp(span.begin, span.end, 0.6 + 0.001 * times++))); });

  const auto megabytes = [](std::uint64_t bytes) { return static_cast<double>(bytes) / 1e6; };
  const auto cells = static_cast<double>(mesh.slabs()[middle].connectivity->cells.size());
  report.figures = {
      {"slicing a slab in memory", 1e-6 * cells / firstSeconds, "million cells a second"},
      {"slicing it at further times", 1e-6 * cells / furtherSeconds, "million cells a second"},
      {"raw arrays / .t4d, zstd 3", megabytes(rawBytes) / megabytes(packedBytes), "times smaller"},
      {"raw arrays / .t4d, uncompressed", megabytes(rawBytes) / megabytes(plainBytes),
       "times smaller"},
      {".t4d, zstd 3", megabytes(packedBytes), "MB"},
      {"peak memory of the sweep", megabytes(sweepPeak), "MB"},
      {"peak memory of all benchmarks", megabytes(peakBytes()), "MB"}};
  for (const auto& path : {raw, packed, plain}) std::filesystem::remove(path);
  return {};
} catch (const std::exception& error) {
  return fail(ErrorCode::Failed, error.what());
}

}  // namespace t4d::bench

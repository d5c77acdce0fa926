#include <optional>
#include <vector>

#include <fmt/format.h>

#include "formats/t4d/chunks.h"
#include "t4d/file.h"
#include "t4d/slice.h"
#include "tools/fuzz/fuzz.h"
#include "tools/t4d/validation.h"

/// A .t4d file, opened in every mode, validated and sliced.
namespace t4d::fuzz {
namespace {

using formats::T4dOpen;
using formats::T4dReader;

/// A hash of all bits of a slab, computed without a copy because memory is measured here.
std::size_t hashOf(const model::Slab& slab) {
  std::size_t hash = 0;
  const auto add = [&](const auto& values) {
    const auto bytes = std::as_bytes(std::span(values));
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    hash = hash * 0x9E3779B97F4A7C15U + std::hash<std::string_view>{}(text) + bytes.size();
  };
  const model::Connectivity& connectivity = *slab.connectivity;
  add(std::array{slab.timeBegin, slab.timeEnd});
  add(std::array{connectivity.vertexCount, connectivity.lowerCount, connectivity.upperCount});
  add(slab.vertices);
  add(connectivity.cells);
  add(connectivity.means.offsets);
  add(connectivity.means.sources);
  for (const auto* attributes : {&connectivity.cellAttributes, &slab.attributes}) {
    for (const model::Attribute& attribute : *attributes) {
      add(attribute.name);
      add(std::array{static_cast<std::uint32_t>(attribute.domain),
                     static_cast<std::uint32_t>(attribute.type), attribute.components});
      add(attribute.values);
    }
  }
  return hash;
}

/// The hash of a slab; nothing if it is refused.
using SlabMark = std::optional<std::size_t>;

SlabMark markOf(const model::Source& body, std::size_t index) {
  const auto slab = body.slab(index);
  if (!slab) {
    must(!slab.error().message.empty() && slab.error().offset, "a refusal says what and where");
    return {};
  }
  must(checkSlab(**slab).has_value(), "a slab given out is sound");
  must(checkConnectivity(*(*slab)->connectivity).has_value(), "its connectivity is sound");
  must(formats::checkStorable((*slab)->connectivity->cellAttributes, (*slab)->attributes)
           .has_value(),
       "its attributes can be stored");
  const model::TimeSpan time = body.timeSpan(index);
  must((*slab)->timeBegin == time.begin && (*slab)->timeEnd == time.end,
       "a slab has the times that are known without it");
  return hashOf(**slab);
}

/// A slab of a body and its offset in the file.
struct ReadSlab {
  std::uint64_t offset = 0;
  SlabMark mark;
  friend bool operator==(const ReadSlab&, const ReadSlab&) = default;
};
using ReadBodies = std::vector<std::vector<ReadSlab>>;

ReadBodies readAll(T4dReader& reader) {
  ReadBodies bodies(reader.bodyCount());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const model::Source& body = reader.body(i);
    for (std::size_t k = 0; k < body.slabCount(); ++k) {
      bodies[i].push_back({reader.slabOffset(i, k), markOf(body, k)});
    }
    for (std::size_t k = body.slabCount(); k-- > 0;) {
      must(markOf(body, k) == bodies[i][k].mark, "a slab is the same when it is read again");
    }
  }
  return bodies;
}

bool allRead(const ReadBodies& bodies) {
  for (const auto& body : bodies) {
    for (const ReadSlab& slab : body) {
      if (!slab.mark) return false;
    }
  }
  return true;
}

/// Slabs at the same offset are equal, however they were found. Either way of reading may refuse a
/// slab, since the index may be wrong.
void compare(const ReadBodies& a, const ReadBodies& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (const ReadSlab& one : a[i]) {
      for (const ReadSlab& other : b[i]) {
        if (one.offset != other.offset || !one.mark || !other.mark) continue;
        must(one.mark == other.mark, "a slab found by the index is the one found from the front");
      }
    }
  }
}

void checkSlices(T4dReader& reader, bool valid) {
  for (std::size_t i = 0; i < reader.bodyCount(); ++i) {
    const model::Source& body = reader.body(i);
    const model::TimeSpan span = timeSpanOf(body);
    std::vector<Result<slice::Slice>> slices;
    for (const double part : {0.0, 0.4, 1.0}) {
      slices.push_back(slice::sliceAtTime(body, std::lerp(span.begin, span.end, part)));
    }
    slices.push_back(slice::slice(body, slice::Hyperplane::across(0, 0.3)));
    slices.push_back(slice::slice(body, {{1, 2, 3, 4}, 0.1}));
    for (const auto& slice : slices) {
      if (!slice) {
        must(!valid, "a valid mesh can be sliced: " + slice.error().text());
        continue;
      }
      const model::TriangleMesh& mesh = slice->mesh;
      for (const model::Triangle& triangle : mesh.triangles) {
        for (const std::uint32_t corner : triangle) {
          must(corner < mesh.vertices.size(), "a slice's triangles have corners");
        }
      }
      must(!valid || isClosed(mesh), "the section of a closed mesh is closed");
    }
  }
}

/// A file that is accepted as a whole is accepted in every way.
void checkJudgement(const std::filesystem::path& path, bool wholeFile) {
  const auto validation = tools::validate(path, {.vertexLinks = true}, {}, formats::kAnyCells);
  must(validation.has_value(), "a file can be judged");
  const auto& issues = validation->issues.issues;
  const bool damaged = std::any_of(issues.begin(), issues.end(), [](const measure::Issue& issue) {
    return issue.code == "file-damaged";
  });
  must(damaged == !wholeFile, "validation finds damage where reading does");
  must(validation->mesh.has_value() == wholeFile, "a whole file has a judgement");
  if (!wholeFile) return;
  auto reader = T4dReader::open(path, T4dOpen::Whole, {}, formats::kAnyCells);
  must(reader.has_value(), "a whole file opens");
  checkSlices(*reader, validation->valid());
}

bool readsAsStream(const std::filesystem::path& path) {
  auto stream = formats::T4dStream::open(path, formats::kAnyCells);
  if (!stream) return false;
  while (true) {
    const auto item = stream->next();
    if (!item || !*item) return item.has_value();
  }
}

int test(std::span<const std::uint8_t> bytes) {
  static MemoryFile file;
  file.set(bytes);
  const HeapMeter heap;
  ReadBodies whole;
  bool opened = false;
  if (auto reader = T4dReader::open(file.path(), T4dOpen::Whole, {}, formats::kAnyCells)) {
    opened = true;
    whole = readAll(*reader);
  }
  ReadBodies front;
  bool undamaged = false;
  if (auto reader = T4dReader::open(file.path(), T4dOpen::FromFront)) {
    undamaged = !reader->damage();
    front = readAll(*reader);
    if (opened) compare(whole, front);
  }
  const auto checked = T4dReader::open(file.path(), T4dOpen::Checked, {}, formats::kAnyCells);
  must(checked.has_value() == undamaged, "no damage from the front is a whole file");
  must(!checked || opened, "a whole file opens by its index");
  // What the index says of the contents of slabs is checked when they are read.
  const auto judged = formats::checkT4dFile(file.path());
  must(!judged || whole == front, "a right file reads the same by its index and from the front");
  must(!judged || (checked && allRead(whole)), "a right file has slabs that can be read");
  must(heap.peak() <= T4dReader::kMemoryPerFileByte * bytes.size() + T4dReader::kMemoryAlways,
       fmt::format("reading {} bytes keeps to its multiple in memory; it took {}", bytes.size(),
                   heap.peak()));
  must(readsAsStream(file.path()) == judged.has_value(), "a pipe is judged as a file is");
  checkJudgement(file.path(), judged.has_value());
  return 0;
}

}  // namespace
}  // namespace t4d::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return t4d::fuzz::test({data, size});
}

#include <algorithm>
#include <string>

#include "formats/animation/mdd_reader.h"
#include "formats/animation/pc2_reader.h"
#include "tools/fuzz/fuzz.h"

/// Point caches; the first byte selects the format. The samples of an accepted cache fill the file,
/// and their points are finite or refused.
namespace t4d::fuzz {
namespace {

class Bytes : public formats::ByteSource {
 public:
  explicit Bytes(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  const std::string& name() const override { return name_; }
  std::uint64_t size() const override { return bytes_.size(); }
  std::uint64_t bytesRead() const override { return 0; }
  Result<void> read(std::uint64_t offset, std::span<std::byte> into) override {
    must(offset <= bytes_.size() && into.size() <= bytes_.size() - offset, "reads are within");
    const auto from = std::as_bytes(bytes_.subspan(offset, into.size()));
    std::copy(from.begin(), from.end(), into.begin());
    return {};
  }

 private:
  std::span<const std::uint8_t> bytes_;
  std::string name_ = "cache";
};

int test(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return -1;
  auto source = std::make_unique<Bytes>(bytes.subspan(1));
  const HeapMeter heap;
  const auto cache = bytes.front() == 'm' ? formats::openMdd(std::move(source))
                                          : formats::openPc2(std::move(source));
  if (!cache) {
    must(!cache.error().message.empty() && cache.error().where.file.starts_with("cache"),
         "a refusal says what and where");
    return 0;
  }
  must(cache->sampleCount() >= 2 && cache->pointCount() > 0, "a cache has samples and points");
  must(cache->times().size() == cache->sampleCount(), "each sample has a time");
  std::vector<model::Point3> points(cache->pointCount());
  for (std::uint64_t i = 0; i < cache->sampleCount(); ++i) {
    if (!cache->read(i, points)) continue;
    must(std::ranges::all_of(points, [](const auto& p) { return p.allFinite(); }),
         "points are finite");
  }
  must(heap.peak() <= 16 * bytes.size() + 65536,
       "reading takes " + std::to_string(heap.peak()) + " bytes");
  return 0;
}

}  // namespace
}  // namespace t4d::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return t4d::fuzz::test({data, size});
}

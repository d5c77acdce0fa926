#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <deque>
#include <limits>
#include <map>
#include <mutex>
#include <optional>

#include <fmt/format.h>

#include "formats/t4d/chunk_writer.h"
#include "formats/t4d/chunks.h"
#include "formats/t4d/first_error.h"
#include "formats/t4d/layer_digest.h"
#include "formats/t4d/layout.h"
#include "formats/t4d/metadata.h"
#include "formats/t4d/optional_chunks.h"
#include "formats/t4d/part_window.h"
#include "formats/t4d/vertex_attributes.h"
#include "formats/triangle/rounding_loss.h"
#include "model/limits.h"
#include "model/parallel.h"
#include "model/shared_parts.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

using namespace t4d_layout;
using model::Connectivity;
using model::Point4;
using model::Slab;
using model::StreamedSlab;

/// A slab whose vertices are made once, where they are few: writing asks for most of them five
/// times.
class WithVertices : public StreamedSlab {
 public:
  explicit WithVertices(const StreamedSlab& slab) : StreamedSlab(slab), slab_(slab) {
    constexpr std::uint32_t kFew = std::uint32_t{1} << 18;
    if (vertexCount > kFew) return;
    vertices_.resize(vertexCount);
    slab.vertices(0, vertices_);
  }

  void vertices(std::uint32_t first, std::span<Point4> into) const override {
    if (vertices_.empty()) return slab_.vertices(first, into);
    std::copy_n(vertices_.begin() + first, into.size(), into.begin());
  }
  void cells(std::uint64_t first, std::span<model::Cell> into) const override {
    slab_.cells(first, into);
  }

 private:
  const StreamedSlab& slab_;
  std::vector<Point4> vertices_;
};

}  // namespace

class T4dWriter::File {
 public:
  File(const std::filesystem::path& path, OutputFile file, const Metadata& metadata,
       const T4dWriteOptions& options)
      : path_(path),
        chunks_(std::move(file), options.index, options.compression, options.pageSlabs),
        metadata_(metadata),
        arrays_{options.compression, options.float32, {}},
        step_(options.step),
        spareEvery_(options.spareEvery),
        window_(metadata.bodies.size()),
        rounding_(options.step) {
    bodies_.reserve(metadata.bodies.size());
    for (std::uint32_t i = 0; i < metadata.bodies.size(); ++i) bodies_.emplace_back(*this, i);
  }

  model::Sink& body(std::size_t index) { return bodies_[index]; }

  std::vector<std::string> losses() const {
    std::vector<std::string> lines = lostChunks_.lines();
    if (auto line = rounding_.line()) lines.insert(lines.begin(), std::move(*line));
    return lines;
  }

  Result<void> keep(const OptionalChunks& chunks) {
    if (error_) return *error_;
    if (!chunks_.begun()) return invalid("has no slab yet", path_.string());
    auto copied = copyOptionalChunks(chunks, chunks_, lostChunks_);
    if (!copied) error_ = copied.error();
    return copied;
  }

  Result<std::uint64_t> finish() {
    if (error_) return *error_;
    for (const Body& body : bodies_) {
      if (body.summary.slabs == 0) {
        return invalid(fmt::format("the body '{}' has no slab", metadata_.bodies[body.index].name));
      }
    }
    std::vector<BodySummary> summaries;
    for (const Body& body : bodies_) {
      if (auto checked = checkExtent(body); !checked) return checked.error();
      summaries.push_back(body.summary);
    }
    return chunks_.finish(summaries);
  }

 private:
  /// A slab, checked and encoded without those before it.
  struct Encoded : model::Sink::Prepared {
    Result<void> sound;
    Result<void> means;
    LayerDigest lower;
    LayerDigest upper;
    SlabExtent extent;
    std::vector<model::Attribute> upperAttributes;
    bool posed = false;  // the hint gives the upper layer
    std::shared_ptr<const PayloadWriter> connectivity;
    // Unless positions are rounded, for which the first slab must be known.
    PayloadWriter upperLayer;  // unless it is posed
    SlabContents contents;
  };

  class Body : public model::Sink {
   public:
    Body(File& file, std::uint32_t bodyIndex) : index(bodyIndex), file_(file) {}
    Result<void> put(const Slab& slab) override { return putPrepared(slab, prepare(slab).get()); }
    std::unique_ptr<Prepared> prepare(const Slab& slab) const override {
      return file_.prepare(slab);
    }
    Result<void> putPrepared(const Slab& slab, Prepared* prepared) override {
      return file_.put(
          *this, [&] { return file_.putSlab(*this, slab, static_cast<Encoded&>(*prepared)); });
    }
    Result<void> putStreamed(const StreamedSlab& slab) override {
      // Only the whole slab tells what rounding does to cells.
      if (file_.arrays_.float32 || file_.step_) return put(assembled(slab));
      return file_.put(*this, [&] { return file_.putStreamed(*this, WithVertices(slab)); });
    }

    std::uint32_t index;
    BodySummary summary;
    // Parts that the next slab may share.
    std::shared_ptr<const Connectivity> connectivity;
    std::uint64_t connectivityOffset = 0;
    LayerDigest upperLayer;
    std::vector<model::Attribute> upperAttributes;
    std::uint64_t upperOffset = 0;
    std::vector<Point4> storedUpper;  // the upper layer as a reader has it, if that is not the same
    // The LAYR that poses of this body name.
    model::LayerPose reference;
    std::vector<model::Attribute> referenceAttributes;
    std::uint64_t referenceOffset = 0;

   private:
    File& file_;
  };

  /// Writes HEAD, unless that has been done: its features and its grid depend on the first slab.
  Result<void> putHead(const Point4& firstVertex, bool posed) {
    if (chunks_.begun()) return {};
    std::vector<std::string> features = {std::string(kFeatureMeans)};
    if (arrays_.level > 0) features.emplace_back(kFeatureZstd);
    const auto& before = metadata_.features;
    poses_ = posed || std::ranges::find(before, kFeaturePose) != before.end();
    if (poses_) features.emplace_back(kFeaturePose);
    if (step_) {
      arrays_.grid = Grid::about(firstVertex.head<3>(), *step_);
      features.emplace_back(kFeatureGrid);
    }
    const auto text = headText(metadata_, features, arrays_.grid);
    if (!text) return text.error();
    return chunks_.begin(*text, minorVersionFor(metadata_));
  }

  using PayloadPointer = std::shared_ptr<const PayloadWriter>;
  struct StoredConnectivity {
    PayloadPointer payload;
    std::size_t bytes = 0;
    std::uint64_t offset = 0;
  };
  struct EncodedConnectivity {
    std::shared_ptr<const Connectivity> connectivity;
    PayloadPointer payload;
  };

  /// After a failure the file cannot be finished: it would look complete, but lack slabs.
  template <class PutSlab>
  Result<void> put(const Body& body, PutSlab putSlab) {
    if (error_) return *error_;
    auto done = putSlab();
    if (!done) {
      error_ = done.error();
      if (error_->where.empty()) {
        error_->where = placeIn(path_.string(), fmt::format("slab {}", body.summary.slabs));
      }
      return *error_;
    }
    return done;
  }

  /// Returns the offset of the chunk.
  Result<std::uint64_t> putChunk(ChunkType type, const PayloadWriter& payload) {
    auto offset = chunks_.put(type, payload);
    if (offset) window_.add({.type = type, .offset = *offset});
    return offset;
  }

  /// How to store the upper layer as a pose, if that gives it exactly.
  std::optional<model::LayerPose> poseOf(const Body& body, const Slab& slab,
                                         const Encoded& encoded) const {
    if (!poses_ || !encoded.posed) return std::nullopt;
    model::LayerPose pose = *slab.upperPose;
    pose.float32 = pose.float32 || arrays_.float32;
    if (isReference(body, pose) && encoded.upperAttributes != body.referenceAttributes) {
      return std::nullopt;
    }
    return pose;
  }

  bool isReference(const Body& body, const model::LayerPose& pose) const {
    return body.reference.reference == pose.reference && body.reference.float32 == pose.float32 &&
           mayBeNamed(kLayer, body.referenceOffset);
  }

  /// Counts a slab that needs the part; only spare copies ask for it.
  void countUse(std::uint64_t offset) {
    if (spareEvery_ > 0) ++uses_[offset];
  }

  /// Whether the part is near enough, and not needed by as many slabs as spare copies allow.
  bool mayBeNamed(ChunkType type, std::uint64_t offset) const {
    const auto uses = uses_.find(offset);
    const bool worn = uses != uses_.end() && uses->second >= spareEvery_;
    return window_.find(type, offset) != nullptr && !worn;
  }

  /// `layer` is as it is stored.
  Result<std::uint64_t> putPosedLayer(Body& body, double time, std::span<const Point4> layer,
                                      const std::vector<model::Attribute>& attributes,
                                      const model::LayerPose& pose) {
    if (!isReference(body, pose)) {
      body.reference = {pose.reference, model::Affine3x4::Identity(), pose.float32};
      body.referenceAttributes = attributes;
      const ArrayOptions arrays{arrays_.level, pose.float32, {}};
      std::vector<Point4> vertices;
      for (const model::Point3& point : *pose.reference) {
        vertices.emplace_back(point[0], point[1], point[2], time);
      }
      auto offset = putChunk(kLayer, encodeLayer(time, vertices, attributes, arrays));
      if (!offset) return offset;
      body.referenceOffset = *offset;
      countUse(*offset);  // the slab after the last one that names it
      // The layer itself, unless a pose made -0 to 0.
      for (Point4& vertex : vertices) vertex = roundedPoint(vertex, arrays);
      const bool same = std::memcmp(vertices.data(), layer.data(), layer.size_bytes()) == 0;
      if (same) {
        countUse(*offset);
        return offset;
      }
    }
    countUse(body.referenceOffset);
    return putChunk(kPose, encodePose({time, chunks_.size() - body.referenceOffset, pose.pose}));
  }

  /// The slab as a reader will have it.
  Slab storedSlab(const Body& body, const Slab& slab,
                  const std::optional<model::LayerPose>& pose) const {
    Slab stored = slab;
    const std::span vertices(stored.vertices);
    for (Point4& vertex : vertices) vertex = roundedPoint(vertex, arrays_);
    if (body.summary.slabs > 0) std::ranges::copy(body.storedUpper, vertices.begin());
    if (pose) {
      const auto upper = vertices.last(slab.connectivity->upperCount);
      for (std::size_t i = 0; i < upper.size(); ++i) upper[i].head<3>() = pose->at(i);
    }
    setMeans(*stored.connectivity, stored.vertices);
    return stored;
  }

  /// Returns the offset of the chunk, which may have been written before: slabs of a motion that
  /// repeats itself, and caps, often have the same connectivity.
  Result<std::uint64_t> putConnectivity(PayloadPointer payload) {
    const auto same = [&](const StoredConnectivity& other) {
      return std::ranges::equal(other.payload->bytes(), payload->bytes()) &&
             other.payload->blocks() == payload->blocks() &&
             mayBeNamed(kConnectivity, other.offset);
    };
    const auto found = std::ranges::find_if(stored_, same);
    if (found != stored_.end()) return found->offset;
    auto offset = putChunk(kConnectivity, *payload);
    if (!offset) return offset;
    std::size_t bytes = payload->size();
    for (const auto& block : payload->blocks()) bytes += block.size();
    storedBytes_ += bytes;
    stored_.push_back({std::move(payload), bytes, *offset});
    while (storedBytes_ > kRememberedBytes ||
           (!stored_.empty() && window_.find(kConnectivity, stored_.front().offset) == nullptr)) {
      storedBytes_ -= stored_.front().bytes;
      stored_.pop_front();
    }
    return offset;
  }

  /// Fails for a body so small that its hypervolume vanishes in doubles. One without any extent
  /// along an axis may be meant.
  Result<void> checkExtent(const Body& body) const {
    const BodySummary& sum = body.summary;
    if (sum.tetrahedra == 0) return {};
    const model::Point3 size = sum.bounds.max - sum.bounds.min;
    const double duration = sum.time.end - sum.time.begin;
    const double digits = size.array().log10().sum() + std::log10(duration);
    if (!std::isfinite(digits) || digits >= std::numeric_limits<double>::min_exponent10) return {};
    return invalid(
        fmt::format("the body '{}' would be {:.3g} by {:.3g} by {:.3g} and last for {:.3g}: its "
                    "hypervolume vanishes in doubles; make it larger, such as {} along each axis",
                    metadata_.bodies[body.index].name, size.x(), size.y(), size.z(), duration,
                    model::kSmallestExtent),
        path_.string());
  }

  static Result<void> checkSeam(const Body& body, double begin, const LayerDigest& lower) {
    if (body.summary.slabs == 0) return {};
    const double last = body.summary.time.end;
    if (lower.size() == 0 ? begin < last : begin != last) {
      return invalid(fmt::format("begins at time {}, the one before ends at {}", begin, last));
    }
    if (lower != body.upperLayer) {
      return invalid("its lower layer is not the upper layer of the one before");
    }
    return {};
  }

  /// Makes the checks that need a slab alone.
  Result<void> checkAlone(const Slab& slab) const {
    if (auto sound = checkSlab(slab); !sound) return sound;
    if (auto sound = checkStorable(slab.connectivity->cellAttributes, slab.attributes); !sound) {
      return sound;
    }
    if (!arrays_.float32) return {};
    constexpr double kLargest = std::numeric_limits<float>::max();
    for (const Point4& vertex : slab.vertices) {
      const double coordinate = vertex.head<3>().cwiseAbs().maxCoeff();
      if (coordinate > kLargest) {
        return invalid(fmt::format("a coordinate of {:.3g} is too large for float32; write float64",
                                   coordinate));
      }
    }
    return {};
  }

  static Result<void> checkMeans(const Slab& slab) {
    if (slab.connectivity->means.size() == 0) return {};
    std::vector<Point4> vertices = slab.vertices;
    setMeans(*slab.connectivity, vertices);
    if (vertices == slab.vertices) return {};
    return invalid("a vertex is not the mean that its connectivity says it is");
  }

  Result<PayloadPointer> encodedConnectivity(
      const std::shared_ptr<const Connectivity>& connectivity) {
    if (!connectivity) return invalid("has no connectivity");
    using Made = Result<EncodedConnectivity>;
    const auto made = connectivities_.get(connectivity.get(), [&]() -> Made {
      if (auto sound = checkConnectivity(*connectivity); !sound) return sound.error();
      return EncodedConnectivity{connectivity, std::make_shared<const PayloadWriter>(
                                                   encodeConnectivity(*connectivity, arrays_))};
    });
    if (!made) return made.error();
    return (*made)->payload;
  }

  std::unique_ptr<Encoded> prepare(const Slab& slab) {
    auto encoded = std::make_unique<Encoded>();
    auto connectivity = encodedConnectivity(slab.connectivity);
    encoded->sound = connectivity ? checkAlone(slab) : connectivity.error();
    if (!encoded->sound) return encoded;
    encoded->connectivity = std::move(*connectivity);
    encoded->means = checkMeans(slab);
    encoded->lower = LayerDigest(slab.lowerLayer());
    encoded->upper = LayerDigest(slab.upperLayer());
    encoded->upperAttributes =
        vertexRows(slab.attributes, slab.connectivity->firstUpper(), slab.connectivity->upperCount);
    encoded->posed =
        slab.upperPose && !slab.upperLayer().empty() && slab.upperPose->gives(slab.upperLayer());
    if (rounds()) return encoded;
    encoded->extent = extentOf(slab);
    if (!encoded->posed) encoded->upperLayer = upperLayerOf(slab, encoded->upperAttributes);
    encoded->contents = encodeContents(slab, arrays_);
    return encoded;
  }

  bool rounds() const { return arrays_.float32 || step_; }
  PayloadWriter upperLayerOf(const Slab& slab,
                             const std::vector<model::Attribute>& attributes) const {
    return encodeLayer(slab.timeEnd, slab.upperLayer(), attributes, arrays_);
  }

  Result<void> checkAgainstBody(const Body& body, const Slab& slab, const Encoded& encoded) {
    if (!encoded.sound) return encoded.sound;
    if (arrays_.grid) {
      if (auto fits = checkGrid(slab); !fits) return fits;
    }
    if (auto joins = checkSeam(body, slab.timeBegin, encoded.lower); !joins) return joins;
    if (!encoded.means) return encoded.means;
    return checkVertexAttributes(slab, body.summary.slabs > 0 ? &body.upperAttributes : nullptr);
  }

  Result<void> checkGrid(const Slab& slab) const {
    for (const Point4& vertex : slab.vertices) {
      for (int axis = 0; axis < 3; ++axis) {
        if (arrays_.grid->number(axis, vertex[axis])) continue;
        return invalid(fmt::format(
            "a coordinate of {:.9g} is more than 2147483647 steps of {} from {}, the origin of the "
            "grid; use a larger step, or no grid",
            vertex[axis], arrays_.grid->step, arrays_.grid->origin[axis]));
      }
    }
    return {};
  }

  Result<void> putSlab(Body& body, const Slab& slab, Encoded& encoded) {
    const bool some = !slab.vertices.empty();
    if (auto begun =
            putHead(some ? slab.vertices[0] : Point4(0, 0, 0, 0), slab.upperPose != nullptr);
        !begun) {
      return begun;
    }
    if (auto checked = checkAgainstBody(body, slab, encoded); !checked) return checked;
    const std::optional<model::LayerPose> pose = poseOf(body, slab, encoded);
    const std::optional<Slab> rounded =
        rounds() ? std::optional(storedSlab(body, slab, pose)) : std::nullopt;
    const Slab& stored = rounded ? *rounded : slab;
    if (slab.connectivity != body.connectivity ||
        !mayBeNamed(kConnectivity, body.connectivityOffset)) {
      auto offset = putConnectivity(encoded.connectivity);
      if (!offset) return offset.error();
      body.connectivity = slab.connectivity;
      body.connectivityOffset = *offset;
    }
    const auto upperLayer = [&] {
      const bool made = !rounded && !encoded.posed;
      return made ? std::move(encoded.upperLayer) : upperLayerOf(slab, encoded.upperAttributes);
    };
    const model::TimeSpan time = {slab.timeBegin, slab.timeEnd};
    auto parts = putLayers(
        body, *slab.connectivity,
        [&] {
          return putChunk(
              kLayer,
              encodeLayer(time.begin, slab.lowerLayer(),
                          vertexRows(slab.attributes, 0, slab.connectivity->lowerCount), arrays_));
        },
        [&] {
          return pose ? putPosedLayer(body, time.end, stored.upperLayer(), encoded.upperAttributes,
                                      *pose)
                      : putChunk(kLayer, upperLayer());
        });
    if (!parts) return parts.error();
    if (rounded) {
      rounding_.add(slab, *rounded);
      body.storedUpper.assign(rounded->upperLayer().begin(), rounded->upperLayer().end());
      encoded.extent = extentOf(stored);
      encoded.contents = encodeContents(stored, arrays_);
    }
    return putRecord(body, time, *slab.connectivity, *parts,
                     encodeSlab(time, *parts, std::move(encoded.contents)), encoded.extent,
                     std::move(encoded.upper), std::move(encoded.upperAttributes));
  }

  /// A range of the vertices of a slab, looked at piece by piece.
  struct Scanned {
    LayerDigest digest;
    model::Bounds3 bounds;
  };

  static Result<Scanned> scan(const StreamedSlab& slab, std::uint32_t begin, std::uint32_t end) {
    Scanned scanned;
    scanned.digest = LayerDigest(end - begin);
    std::mutex mutex;
    FirstError error;
    model::forEach(scanned.digest.blockCount(), [&](std::size_t block) {
      const auto first = begin + static_cast<std::uint32_t>(block * kBlockRows);
      std::vector<Point4> vertices(std::min<std::uint64_t>(kBlockRows, end - first));
      model::isolate([&] { slab.vertices(first, vertices); });
      scanned.digest.setBlock(block, vertices);
      model::Bounds3 bounds;
      for (const Point4& vertex : vertices) bounds.add(vertex.head<3>());
      error.add(block, checkVertices(vertices, slab, slab.time, first));
      const std::scoped_lock lock(mutex);
      scanned.bounds.add(bounds);
    });
    if (auto checked = error.result(); !checked) return checked.error();
    return scanned;
  }

  Result<void> putStreamed(Body& body, const StreamedSlab& slab) {
    if (auto begun = putHead(Point4(0, 0, 0, 0), false); !begun) return begun;
    const auto lower = scan(slab, 0, slab.lowerCount);
    if (!lower) return lower.error();
    if (auto joins = checkSeam(body, slab.time.begin, lower->digest); !joins) return joins;
    if (slab.lowerCount > 0 && !body.upperAttributes.empty()) {
      return invalid(fmt::format("its lower layer lacks the attribute '{}' of the slab before",
                                 body.upperAttributes.front().name));
    }
    const auto interior = scan(slab, slab.lowerCount, slab.firstUpper());
    if (!interior) return interior.error();
    const auto upper = scan(slab, slab.firstUpper(), slab.vertexCount);
    if (!upper) return upper.error();
    SlabExtent extent{slab.cellCount, lower->bounds};
    extent.bounds.add(interior->bounds);
    extent.bounds.add(upper->bounds);

    const auto encodedLayer = [&](double time, std::uint32_t begin, std::uint32_t count) {
      const auto vertices = [&, begin](std::uint64_t first, std::span<Point4> into) {
        slab.vertices(begin + static_cast<std::uint32_t>(first), into);
      };
      return encodeLayer(time, count, vertices, arrays_);
    };
    // A slab of few cells has one block of them, which one thread encodes.
    Result<StreamedConnectivity> connectivity;
    PayloadWriter upperLayer;
    model::together(
        [&] { connectivity = encodeConnectivity(slab, arrays_.level); },
        [&] { upperLayer = encodedLayer(slab.time.end, slab.firstUpper(), slab.upperCount); });
    if (!connectivity) return connectivity.error();
    auto offset =
        putConnectivity(std::make_shared<const PayloadWriter>(std::move(connectivity->payload)));
    if (!offset) return offset.error();
    body.connectivity = nullptr;
    body.connectivityOffset = *offset;
    auto parts = putLayers(
        body, slab,
        [&] { return putChunk(kLayer, encodedLayer(slab.time.begin, 0, slab.lowerCount)); },
        [&] { return putChunk(kLayer, upperLayer); });
    if (!parts) return parts.error();
    return putRecord(
        body, slab.time, slab, *parts,
        encodeSlab(slab.time, *parts, encodeContents(slab, connectivity->bounds, arrays_)), extent,
        upper->digest, {});
  }

  /// The parts of a slab, which comes next; `lower` and `upper` write the layers that are not in
  /// the file yet.
  template <class Lower, class Upper>
  Result<SlabParts> putLayers(Body& body, const model::VertexCounts& counts, Lower lower,
                              Upper upper) {
    std::uint64_t lowerOffset = body.upperOffset;
    if (body.summary.slabs == 0 && counts.lowerCount > 0) {
      const auto offset = lower();
      if (!offset) return offset.error();
      lowerOffset = *offset;
    }
    body.upperOffset = 0;
    if (counts.upperCount > 0) {
      const auto offset = upper();
      if (!offset) return offset.error();
      body.upperOffset = *offset;
    }
    const auto distance = [slab = chunks_.size()](std::uint64_t offset) {
      return offset == 0 ? 0 : slab - offset;
    };
    return SlabParts{distance(body.connectivityOffset), distance(lowerOffset),
                     distance(body.upperOffset), body.index};
  }

  Result<void> putRecord(Body& body, const model::TimeSpan& time, const model::VertexCounts& counts,
                         const SlabParts& parts, const PayloadWriter& payload,
                         const SlabExtent& extent, LayerDigest upperLayer,
                         std::vector<model::Attribute> upperAttributes) {
    const auto offset = putChunk(kSlab, payload);
    if (!offset) return offset.error();
    chunks_.addSlab({*offset, chunks_.size() - *offset, parts, time, extent});
    countUse(body.connectivityOffset);
    addSlab(body.summary, time, counts, extent.cells, extent.bounds);
    body.upperLayer = std::move(upperLayer);
    body.upperAttributes = std::move(upperAttributes);
    return {};
  }

  std::filesystem::path path_;
  ChunkWriter chunks_;
  Metadata metadata_;
  ArrayOptions arrays_;
  std::optional<double> step_;  // of the grid
  std::uint64_t spareEvery_;
  std::map<std::uint64_t, std::uint64_t> uses_;  // slabs that need the part at an offset
  bool poses_ = false;
  PartWindow window_;
  std::vector<Body> bodies_;
  model::SharedParts<const Connectivity*, EncodedConnectivity> connectivities_;
  std::deque<StoredConnectivity> stored_;  // the last ones
  std::size_t storedBytes_ = 0;
  RoundingLoss rounding_;
  LostChunks lostChunks_;
  std::optional<Error> error_;  // the first one
};

T4dWriter::T4dWriter(std::unique_ptr<File> file) : file_(std::move(file)) {}
T4dWriter::T4dWriter(T4dWriter&&) noexcept = default;
T4dWriter& T4dWriter::operator=(T4dWriter&&) noexcept = default;
T4dWriter::~T4dWriter() = default;

Result<T4dWriter> T4dWriter::create(const std::filesystem::path& path, const Metadata& metadata,
                                    const T4dWriteOptions& options) {
  if (options.step && !(std::isfinite(*options.step) && *options.step > 0)) {
    return invalid(
        fmt::format("a grid of step {} is requested; steps are positive", *options.step));
  }
  if (options.spareEvery == 1) {
    return invalid("spare copies after every slab are requested; at least 2 slabs share a copy");
  }
  if (options.step && options.float32) {
    return invalid("a grid and float32 are requested; positions can have only one of them");
  }
  // A reader would reject it.
  const auto parsed = headText(metadata, {}).and_then(parseHead);
  if (!parsed) return invalid(parsed.error().message, path.string());
  auto out = OutputFile::create(path);
  if (!out) return out.error();
  return T4dWriter(std::make_unique<File>(path, std::move(*out), metadata, options));
}

model::Sink& T4dWriter::body(std::size_t index) const { return file_->body(index); }

Result<void> T4dWriter::keep(const OptionalChunks& chunks) { return file_->keep(chunks); }

std::vector<std::string> T4dWriter::losses() const { return file_->losses(); }

Result<std::uint64_t> T4dWriter::finish() { return file_->finish(); }

}  // namespace t4d::formats

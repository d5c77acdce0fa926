#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "formats/output_file.h"
#include "formats/usd/usd_values.h"
#include "platform/scratch_file.h"

namespace t4d::formats {

/// A USD layer in the making: an Xform that says where the solid is, and below it a Mesh for each
/// body. Text has the samples of an attribute together, while they come frame by frame: so values
/// go to a scratch file, and `finish` puts them in order. Only the last value of an attribute is in
/// memory.
///
/// A value that does not change is written once, and again where it ends if players interpolate it.
/// A value that never changes is not animated: a mesh that keeps its triangles has them once.
class UsdStage {
 public:
  enum class Form : std::uint8_t { Text, Package };

  /// Fails on a unit of length or a rate that is not positive and finite, and on extras that are
  /// not a JSON object.
  static Result<UsdStage> create(Form form, double timeCodesPerSecond,
                                 const MeshWriteOptions& options);

  /// Adds a body and returns its number. Its name becomes one that USD allows and no other body
  /// has; as it is, it becomes the `displayName`.
  std::size_t addBody(const std::string& name);

  /// What a body has from this time code on, which is not before the last one. Where the triangles
  /// change, players must not move points to those of others: values are held up to there.
  Result<void> sample(std::size_t body, double timeCode, const NamedMesh& named,
                      const model::Point3& center);
  /// Sets whether the body is visible. The first call, if any, must be before the first sample.
  Result<void> show(std::size_t body, double timeCode, bool visible);
  /// Sets where the body is. The first call, if any, must be before the first sample. Players
  /// rotate along the shorter way.
  Result<void> pose(std::size_t body, double timeCode, const Eigen::Quaterniond& rotation,
                    const model::Point3& translation);
  /// The time of the 4D mesh, as an attribute `t4d:time`.
  Result<void> meshTime(double timeCode, double time);

  /// Names the properties that a body has in the clips of a clip set.
  Result<void> declare(std::size_t body, const NamedMesh& named);

  const model::Point3& center() const { return options_.center; }
  /// The approximate size of the text, in bytes.
  std::uint64_t textBytes() const { return textBytes_; }

  struct Span {
    double begin = 0;
    double end = 0;
  };
  /// Writes all to the file, which the caller commits, and returns what was lost. In a clip, which
  /// has a time code by the options, every value is a sample. `rootMetadata` are lines of the
  /// Xform.
  Result<std::vector<std::string>> finish(OutputFile& file, const Span& played,
                                          const std::string& rootMetadata = {});

 private:
  struct Piece {
    std::uint64_t offset = 0;
    std::uint64_t size = 0;
  };
  struct Property {
    std::string type;
    std::string metadata;
    bool interpolated = true;
    std::vector<std::pair<double, Piece>> samples = {};
    std::string last = {};  // the value that it has since the last sample
    double lastCode = 0;    // until when, so far
  };
  struct Body {
    std::string name;
    std::string identifier;
    std::vector<std::pair<std::string, Property>> properties = {};
    std::vector<std::array<std::uint32_t, 3>> triangles = {};
    std::size_t vertexCount = 0;
    std::uint64_t sampleCount = 0;
    double firstCode = 0;
    bool moves = false;
  };
  class Output;

  UsdStage(Form form, double timeCodesPerSecond, const MeshWriteOptions& options,
           platform::ScratchFile scratch, std::string dictionary)
      : form_(form),
        timeCodesPerSecond_(timeCodesPerSecond),
        options_(options),
        scratch_(std::move(scratch)),
        dictionary_(std::move(dictionary)) {}

  Result<void> put(Body& body, double timeCode, const UsdValue& value);
  Result<void> put(Property& property, double timeCode, std::string text);
  static Property* propertyOf(Body& body, const std::string& name);
  Result<void> block(Body& body, double timeCode, const std::vector<UsdValue>& present);
  void hold(Body& body, double timeCode);
  std::string header(const Span& played) const;
  Result<void> write(const std::string& name, const Property& property, const std::string& indent,
                     Output& into) const;
  Result<void> write(const Piece& piece, Output& into) const;
  Result<void> write(const Body& body, Output& into) const;
  Result<void> writeRoot(const std::string& metadata, Output& into) const;

  Form form_;
  double timeCodesPerSecond_;
  MeshWriteOptions options_;
  platform::ScratchFile scratch_;
  std::uint64_t scratchBytes_ = 0;
  std::uint64_t textBytes_ = 0;
  std::string dictionary_;  // the layer's own data
  std::vector<Body> bodies_;
  std::map<std::string, std::size_t> identifiers_;  // and how often each was wanted again
  Body root_;
  RoundingLoss rounding_;
  std::vector<std::string> lost_;
};

}  // namespace t4d::formats

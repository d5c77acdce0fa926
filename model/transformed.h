#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "model/attribute_meaning.h"
#include "model/layer_pose.h"
#include "model/streamed_slab.h"

namespace t4d::model {

/// A map of space and time: x becomes A x + b for `space` = (A | b), and t becomes
/// timeScale * t + timeShift.
struct Transform {
  Affine3x4 space = Affine3x4::Identity();
  double timeScale = 1;  ///< positive
  double timeShift = 0;

  Point4 operator()(const Point4& point) const;
  double time(double t) const { return timeScale * t + timeShift; }
  bool mirrors() const;
  /// Whether A is singular, or so nearly singular that a solid would become flat up to rounding.
  bool flattens() const;
};

/// Maps all vertices. If space is mirrored, the last two vertices of each cell are exchanged, so
/// that the mesh still faces outward. Layers that are poses of a reference (Slab::upperPose) remain
/// such. Attributes are mapped by their meanings (mapValues); those that cannot be mapped are left
/// out.
///
/// `put` and `putStreamed` fail if two different times become equal, `put` also if a value of an
/// attribute overflows or underflows.
class Transformed : public Sink {
 public:
  /// `into` must outlive this sink. The determinant of A is not zero.
  Transformed(Sink& into, const Transform& by, AttributeMeanings meanings = {})
      : into_(into), by_(by), meanings_(std::move(meanings)), mirrors_(by.mirrors()) {}

  Result<void> put(const Slab& slab) override;
  Result<void> putStreamed(const StreamedSlab& slab) override;

  /// The names of attributes that were left out, with the reasons.
  const std::map<std::string, std::string>& lostAttributes() const { return lost_; }

 private:
  Result<TimeSpan> timesOf(double begin, double end) const;
  Result<bool> mapAttributes(std::vector<Attribute>& attributes, const Connectivity& connectivity);
  Result<void> mapConnectivity(Slab& moved);
  void moveLayers(const Slab& slab, Slab& moved);
  std::vector<Point4> takeLower(std::span<const Point4> given);
  LayerPose poseOf(const LayerPose& given);

  Sink& into_;
  Transform by_;
  AttributeMeanings meanings_;
  std::map<std::string, std::string> lost_;
  bool mirrors_;
  // The last connectivity and its image, which the mapped slabs share.
  std::shared_ptr<const Connectivity> given_;
  std::shared_ptr<const Connectivity> mapped_;
  // The last reference of posed layers and its image.
  std::shared_ptr<const std::vector<Point3>> givenReference_;
  std::shared_ptr<const std::vector<Point3>> movedReference_;
  // The upper layer of the last slab, if it was posed: before and after mapping.
  std::vector<Point4> givenUpper_;
  std::vector<Point4> movedUpper_;
};

}  // namespace t4d::model

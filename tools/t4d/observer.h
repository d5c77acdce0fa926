#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::tools {

/// One of the things that a verb does one after another, such as reading or measuring. It lasts as
/// long as the object.
class Stage {
 public:
  Stage() = default;
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;
  virtual ~Stage() = default;

  /// A callback for the progress of the whole stage; valid while the stage exists.
  virtual model::Progress callback() { return {}; }
  /// A callback for the progress of the next part of the stage, which has this many units.
  virtual model::Progress part(std::uint64_t /*units*/) { return {}; }
};

/// Watches a verb at work; this base class ignores everything.
class Observer {
 public:
  Observer() = default;
  Observer(const Observer&) = delete;
  Observer& operator=(const Observer&) = delete;
  virtual ~Observer() = default;

  /// A stage begins, with a title such as "measuring cells". It has `total` units, such as "slabs";
  /// 0 if that is not known.
  virtual std::unique_ptr<Stage> stage(std::string /*title*/, std::uint64_t /*total*/ = 0,
                                       std::string /*units*/ = {}) {
    return std::make_unique<Stage>();
  }
  /// Something that the user should know, neither a failure nor a loss.
  virtual void note(const std::string& /*notice*/) {}
  void noteEach(const std::vector<std::string>& notices) {
    for (const std::string& notice : notices) note(notice);
  }
};

/// An observer for those who need none.
Observer& nobody();

}  // namespace t4d::tools

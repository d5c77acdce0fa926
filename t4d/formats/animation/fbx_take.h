#pragma once

#include <optional>
#include <string>
#include <vector>

#include "t4d/model/times.h"

/// Assimp leaves out the keys of an FBX file outside its takes (LocalStart to LocalStop), although
/// they shape the curves inside. So it is told of takes that hold all keys, and the true ones are
/// applied afterwards.
namespace t4d::formats {

class FbxTakes {
 public:
  /// Finds the takes in the bytes of an FBX file, text or binary, and widens them there.
  static FbxTakes widen(std::string& bytes);

  /// What Assimp's duration of an animation, in seconds, says about its take.
  struct Take {
    double offset = 0;  ///< of the file's times from Assimp's, in seconds
    /// In seconds of the file; nothing if the file leaves it to the keys.
    std::optional<model::TimeSpan> span = {};
  };
  Take takeOf(double duration) const;

 private:
  std::vector<double> starts_;  // in seconds, in the order of the file
  std::vector<double> stops_;
};

}  // namespace t4d::formats

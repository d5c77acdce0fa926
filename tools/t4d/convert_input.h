#pragma once

#include <deque>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "formats/mesh4d/flat_bodies.h"
#include "t4d/file.h"
#include "t4d/mesh.h"
#include "tools/t4d/convert.h"

namespace t4d::tools {

/// A 4D mesh to be written in another format, and what is to be said about where it comes from.
struct ConvertInput {
  std::string format = {};                        ///< its id
  std::string dialect = {};                       ///< as formats::LoadedMesh4d
  std::optional<formats::T4dReader> reader = {};  ///< owns the bodies of a .t4d
  std::deque<model::Mesh> meshes = {};            ///< those of others
  std::vector<formats::CountedBody> bodies = {};
  formats::Metadata metadata = {};
  std::set<std::string> attributes = {};  ///< their names, of all bodies
  bool named = true;  ///< the bodies have names of their own, not that of the file
  bool closed = true;
  bool oriented = true;
  std::vector<std::string> notices = {};
  std::vector<std::string> losses = {};
  std::vector<std::string> files = {};  ///< that were read besides the one named
};

/// Reads and checks the input; mends and cuts one that is no .t4d.
Result<ConvertInput> openConvertInput(const ConvertOptions& options, Observer& observer);

}  // namespace t4d::tools

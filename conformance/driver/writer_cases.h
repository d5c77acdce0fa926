#pragma once

#include <string>
#include <vector>

#include "t4d/file.h"
#include "t4d/mesh.h"

/// The meshes that a writer under test has to store.
namespace t4d::conformance {

struct WriterCase {
  std::string id;              ///< kind and name: "means/screw-with-means"
  std::string about;           ///< a sentence
  formats::Metadata metadata;  ///< names the bodies
  std::vector<model::Mesh> bodies;
  std::string skipped;  ///< why the case is skipped; empty if it is not
  /// How many connectivities a file may store again, since slabs name parts shortly before alone
  /// (rule S12).
  std::size_t storedAgain = 0;
};

/// All cases, the simplest first: the meshes of the corpus's valid files, each once. The kind tells
/// what a writer must be able to store: "plain" cells and positions, "means", "attributes", several
/// "bodies", members of "head".
std::vector<WriterCase> writerCases();

/// The case as JSON, the input of a writer (docs/conform.md, writer_mesh.schema.json). Layers and
/// connectivities are listed once; slabs refer to them.
struct MeshText {
  std::string json;
  std::size_t connectivities = 0;
  std::size_t layers = 0;
};
MeshText textOf(const WriterCase& test);

}  // namespace t4d::conformance

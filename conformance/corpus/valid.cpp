#include <algorithm>

#include "conformance/corpus/cases.h"
#include "conformance/corpus/shapes.h"

namespace t4d::conformance {
namespace {

/// The features of SPEC.md that the bodies need.
std::vector<std::string> neededFeatures(const std::vector<BodySlabs>& bodies,
                                        const ImageOptions& options) {
  std::vector<std::string> features;
  for (const BodySlabs& body : bodies) {
    for (const model::Slab& slab : body.slabs) {
      if (slab.connectivity->means.size() > 0 && features.empty()) features.emplace_back("means");
    }
  }
  if (options.storage != Storage::Raw) features.emplace_back("zstd");
  return features;
}

class ValidFiles {
 public:
  void add(const std::string& name, const std::string& what, const std::vector<BodySlabs>& bodies,
           const std::vector<double>& times, const ImageOptions& options = {}) {
    CorpusFile file;
    file.id = "valid/" + name;
    file.verdict = Verdict::Valid;
    file.fault = what;
    file.bytes = Image::of(bodies, options).bytes();
    file.features = neededFeatures(bodies, options);
    expect(file, bodies, file.features, times, options);
    file.features.emplace_back(options.index ? "index" : "no-index");
    files_.push_back(std::move(file));
  }

  std::vector<CorpusFile> finish() { return std::move(files_); }

 private:
  std::vector<CorpusFile> files_;
};

}  // namespace

std::vector<CorpusFile> validFiles() {
  ValidFiles files;
  files.add("one-simplex", "One slab with empty layers, nothing compressed.",
            {{"simplex", simplex()}}, {0.5, 0, 1, -1, 2});
  files.add("one-simplex-no-index", "A file without index and footer.", {{"simplex", simplex()}},
            {0.5}, {.index = false});
  files.add("cross-polytope", "Two slabs that share a layer.", {{"cross", crossPolytope()}},
            {-1, -0.5, 0, 0.25, 1});
  const Solid solid = cube();
  files.add("cube-in-translation",
            "A unit cube in five steps with caps of their own: connectivity is stored once.",
            {{"cube", sweep(solid, {pose(solid, 0, {0, 0, 0}), pose(solid, 1, {0, 0, 1}),
                                    pose(solid, 2, {0, 0, 2}), pose(solid, 3, {0, 0, 3}),
                                    pose(solid, 4, {0, 0, 4}), pose(solid, 5, {0, 0, 5})})}},
            {0, 0.5, 2, 4.75, 5}, {.storage = Storage::Library});
  return files.finish();
}

}  // namespace t4d::conformance

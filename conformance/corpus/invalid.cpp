#include "conformance/corpus/invalid.h"

#include "conformance/corpus/shapes.h"

namespace t4d::conformance {

Base baseOf(const std::vector<BodySlabs>& bodies, const ImageOptions& options) {
  std::vector<std::string> features = neededFeatures(bodies, options);
  features.emplace_back(options.index ? "index" : "no-index");
  return {Image::of(bodies, options), features};
}

Base plain() { return baseOf({{"simplex", simplex()}}); }

Base unindexed() { return baseOf({{"simplex", simplex()}}, {.index = false}); }

Base layered() { return baseOf({{"cross", crossPolytope()}}); }

Base withLayerAttributes() {
  std::vector<model::Slab> cross = crossPolytope();
  // Vertex 0 below, 1 to 6 in the layer, 7 above.
  cross[0].attributes = {
      model::makeAttribute<std::uint8_t>("a", model::Domain::Vertex, {0, 1, 2, 3, 4, 5, 6}),
      model::makeAttribute<double>("b", model::Domain::Vertex, {0, 1, 2, 3, 4, 5, 6})};
  cross[1].attributes = {
      model::makeAttribute<std::uint8_t>("a", model::Domain::Vertex, {1, 2, 3, 4, 5, 6, 7}),
      model::makeAttribute<double>("b", model::Domain::Vertex, {1, 2, 3, 4, 5, 6, 7})};
  return baseOf({{"cross", cross}});
}

Base between() {
  const Solid solid = cornerTetrahedron();
  return baseOf(
      {{"tetrahedron", sweep(solid, {pose(solid, 0, {0, 0, 0}), pose(solid, 1, {0, 0, 0})},
                             {.capSlabs = false})}});
}

Base withPoses() {
  const Solid solid = cornerTetrahedron();
  const std::vector<model::Slab> slabs = sweep(
      solid, {pose(solid, 0, {0, 0, 0}), pose(solid, 1, {0, 0, 0}), pose(solid, 2, {0, 0, 1})},
      {.capSlabs = false});
  return baseOf({{"tetrahedron", withPoses(slabs, [](std::size_t k) {
                    return movedBy({0, 0, k == 0 ? 0.25 : 1});
                  })}});
}

model::Slab meansSlab() {
  auto connectivity = std::make_shared<model::Connectivity>(*simplex()[0].connectivity);
  connectivity->vertexCount = 9;
  connectivity->means.add(std::vector<std::uint32_t>{0, 1, 2, 6});
  connectivity->means.add(std::vector<std::uint32_t>{5, 6});
  model::Slab slab = simplex()[0];
  slab.connectivity = connectivity;
  slab.vertices.emplace_back(0.5, 0, 0, 0.5);
  slab.vertices.emplace_back(0, 0.5, 0, 0.5);
  slab.vertices.resize(9);
  model::setMeans(*connectivity, slab.vertices);
  return slab;
}

Base withMeans() { return baseOf({{"simplex", {meansSlab()}}}); }

Image::Chunk noteChunk(std::size_t bytes) {
  Image::Chunk chunk;
  chunk.name = "note";
  chunk.type = "note";
  chunk.flags = 0;
  chunk.payload.putBytes("text", std::string(bytes, 'n'));
  return chunk;
}

const std::vector<NotUtf8>& notUtf8() {
  static const std::vector<NotUtf8> all = {
      {"lone-continuation", "a continuation byte without a first one", "\x80"},
      {"cut-off", "a sequence that is cut off", "\xE2\x82"},
      {"not-continued", "a sequence that another character breaks off", "\xC3(x"},
      {"latin-1", "text in Latin-1", "caf\xE9s"},
      {"overlong-2", "an overlong sequence of two bytes", "\xC0\xAF"},
      {"overlong-3", "an overlong sequence of three bytes", "\xE0\x9F\xBF"},
      {"overlong-4", "an overlong sequence of four bytes", "\xF0\x8F\xBF\xBF"},
      {"surrogate", "a surrogate", "\xED\xA0\x80"},
      {"beyond-10ffff", "a number beyond U+10FFFF", "\xF4\x90\x80\x80"},
      {"five-bytes", "a sequence of five bytes", "\xF8\x88\x80\x80\x80"},
      {"ff", "the byte FF", "\xFF"},
  };
  return all;
}

void InvalidCases::add(const std::string& name, const std::string& fault, const Base& base,
                       const std::function<void(Image&)>& change, const std::string& place,
                       std::size_t at) {
  Image image = base.image;
  change(image);
  addBytes(name, fault, base, image.bytes(), image.offset(place) + at);
}

void InvalidCases::addBytes(const std::string& name, const std::string& fault, const Base& base,
                            const std::string& bytes, std::uint64_t offset) {
  InvalidCase made;
  made.file.id = "invalid/" + name;
  made.file.validity = Validity::Invalid;
  made.file.features = base.features;
  made.file.rule = name.substr(0, name.find('-'));
  made.file.fault = fault;
  made.file.offset = offset;
  made.file.bytes = bytes;
  made.repaired = base.image.bytes();
  cases_.push_back(std::move(made));
}

void InvalidCases::addFlip(const std::string& name, const std::string& fault, const Base& base,
                           const std::string& place, std::size_t at) {
  const std::uint64_t offset = base.image.offset(place) + at;
  std::string bytes = base.image.bytes();
  bytes[offset] = static_cast<char>(bytes[offset] ^ 1);
  addBytes(name, fault, base, bytes, offset);
}

std::vector<InvalidCase> invalidCases() {
  InvalidCases cases;
  addFileHeaderFaults(cases);
  addStructureFaults(cases);
  addChunkFaults(cases);
  addFooterFaults(cases);
  addArrayFaults(cases);
  addAttributeFaults(cases);
  addHeadFaults(cases);
  addConnectivityFaults(cases);
  addLayerFaults(cases);
  addPoseFaults(cases);
  addSlabFaults(cases);
  addAssemblyFaults(cases);
  addDoneFaults(cases);
  addIndexFaults(cases);
  addLimitFaults(cases);
  return cases.finish();
}

}  // namespace t4d::conformance

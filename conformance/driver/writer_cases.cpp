#include "conformance/driver/writer_cases.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "conformance/corpus/cases.h"
#include "conformance/corpus/shapes.h"

namespace t4d::conformance {
namespace {

using model::Attribute;
using model::Connectivity;
using model::Domain;
using model::Slab;
using nlohmann::ordered_json;

/// The bytes of a row as hexadecimal digits: no number is rounded, and a NaN is kept.
std::string hexOf(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte byte : bytes) text += fmt::format("{:02x}", static_cast<unsigned>(byte));
  return text;
}

/// The attributes of a domain, with the rows from `first` to before `end`.
ordered_json attributesOf(std::span<const Attribute> attributes, Domain domain, std::size_t first,
                          std::size_t end) {
  ordered_json list = ordered_json::array();
  for (const Attribute& attribute : attributes) {
    if (attribute.domain != domain) continue;
    ordered_json rows = ordered_json::array();
    for (std::size_t i = first; i < end; ++i) {
      rows.push_back(hexOf({attribute.row(i), attribute.rowBytes()}));
    }
    list.push_back({{"name", attribute.name},
                    {"type", static_cast<int>(attribute.type)},
                    {"components", attribute.components},
                    {"rows", std::move(rows)}});
  }
  return list;
}

ordered_json connectivityJson(const Connectivity& connectivity) {
  ordered_json means = ordered_json::array();
  for (std::uint32_t i = 0; i < connectivity.means.size(); ++i) {
    const auto& offsets = connectivity.means.offsets;
    means.push_back(
        std::span(connectivity.means.sources).subspan(offsets[i], offsets[i + 1] - offsets[i]));
  }
  return {{"vertices", connectivity.vertexCount},
          {"lower", connectivity.lowerCount},
          {"upper", connectivity.upperCount},
          {"cells", connectivity.cells},
          {"means", std::move(means)},
          {"attributes",
           attributesOf(connectivity.cellAttributes, Domain::Cell, 0, connectivity.cells.size())}};
}

/// Lists layers and connectivities once, and refers to them by number.
class MeshWriter {
 public:
  ordered_json slabsOf(const model::Mesh& body) {
    ordered_json slabs = ordered_json::array();
    ordered_json lower;  // null: no layer
    for (const Slab& slab : body.slabs()) {
      const Connectivity& connectivity = *slab.connectivity;
      if (slabs.empty() && connectivity.lowerCount > 0) {
        lower = addLayer(slab, slab.timeBegin, 0, connectivity.lowerCount);
      }
      ordered_json upper;
      if (connectivity.upperCount > 0) {
        upper = addLayer(slab, slab.timeEnd, connectivity.firstUpper(), connectivity.vertexCount);
      }
      ordered_json interior = ordered_json::array();
      for (std::uint32_t i = connectivity.lowerCount; i < connectivity.firstMean(); ++i) {
        const auto& p = slab.vertices[i];
        interior.push_back({p[0], p[1], p[2], p[3]});
      }
      const bool any = !interior.empty();
      slabs.push_back({{"begin", slab.timeBegin},
                       {"end", slab.timeEnd},
                       {"connectivity", numberOf(connectivity)},
                       {"lower", lower},
                       {"upper", upper},
                       {"interior", std::move(interior)},
                       {"interior_attributes",
                        any ? attributesOf(slab.attributes, Domain::Vertex, connectivity.lowerCount,
                                           connectivity.firstMean())
                            : ordered_json::array()},
                       {"cell_attributes", attributesOf(slab.attributes, Domain::Cell, 0,
                                                        connectivity.cells.size())}});
      lower = upper;
    }
    return slabs;
  }

  ordered_json connectivities = ordered_json::array();
  ordered_json layers = ordered_json::array();

 private:
  std::size_t addLayer(const Slab& slab, double time, std::uint32_t first, std::uint32_t end) {
    ordered_json positions = ordered_json::array();
    for (std::uint32_t i = first; i < end; ++i) {
      const auto& p = slab.vertices[i];
      positions.push_back({p[0], p[1], p[2]});
    }
    layers.push_back({{"time", time},
                      {"positions", std::move(positions)},
                      {"attributes", attributesOf(slab.attributes, Domain::Vertex, first, end)}});
    return layers.size() - 1;
  }

  std::size_t numberOf(const Connectivity& connectivity) {
    const auto found = std::ranges::find_if(
        known_, [&](const Connectivity* known) { return *known == connectivity; });
    const auto number = static_cast<std::size_t>(found - known_.begin());
    if (found == known_.end()) {
      known_.push_back(&connectivity);
      connectivities.push_back(connectivityJson(connectivity));
    }
    return number;
  }

  std::vector<const Connectivity*> known_;
};

ordered_json detailsOf(const std::string& detailsJson) { return ordered_json::parse(detailsJson); }

ordered_json bodyJson(const formats::BodyInfo& info) {
  ordered_json body = {{"name", info.name}};
  if (!info.color.empty()) body["color"] = info.color;
  if (!info.material.empty()) body["material"] = info.material;
  if (!info.parent.empty()) body["parent"] = info.parent;
  if (info.detailsJson != "{}") body["details"] = detailsOf(info.detailsJson);
  return body;
}

/// Rows of numbers and texts take a line each.
void print(const ordered_json& value, const std::string& indent, std::string& into) {
  const bool isRow = !value.is_structured() || value.empty() ||
                     (value.is_array() && std::ranges::none_of(value, [](const auto& each) {
                        return each.is_structured() || each.is_string();
                      }));
  if (isRow) {
    into += value.dump(-1, ' ', false);
    return;
  }
  into += value.is_array() ? "[" : "{";
  const char* separator = "\n";
  for (const auto& [key, member] : value.items()) {
    into += separator + indent + " ";
    if (value.is_object()) into += ordered_json(key).dump() + ": ";
    print(member, indent + " ", into);
    separator = ",\n";
  }
  into += "\n" + indent + (value.is_array() ? "]" : "}");
}

bool hasMeans(const model::Mesh& mesh) {
  return std::ranges::any_of(mesh.slabs(),
                             [](const Slab& slab) { return slab.connectivity->means.size() > 0; });
}

bool hasAttributes(const model::Mesh& mesh) {
  return std::ranges::any_of(mesh.slabs(), [](const Slab& slab) {
    return !slab.attributes.empty() || !slab.connectivity->cellAttributes.empty();
  });
}

std::string kindOf(const std::vector<model::Mesh>& bodies) {
  if (bodies.size() > 1) return "bodies";
  if (hasAttributes(bodies[0])) return "attributes";
  return hasMeans(bodies[0]) ? "means" : "plain";
}

model::Mesh meshOf(const std::vector<Slab>& slabs) {
  model::Mesh mesh;
  for (const Slab& slab : slabs) {
    if (!mesh.put(slab)) std::abort();  // a mesh in memory takes every slab of the corpus
  }
  return mesh;
}

WriterCase headCase() {
  WriterCase test{.id = "head/all-members",
                  .about = "Every member of HEAD and of a body.",
                  .metadata = {},
                  .bodies = {meshOf(simplex()), meshOf(simplex(2, {4, 0, 0, 1}))},
                  .skipped = {}};
  formats::Metadata& head = test.metadata;
  head.backend = "by-hand";
  head.lengthUnit = "mm";
  head.timeUnit = "min";
  head.up = "z";
  head.detailsJson = R"({"source":{"file":"a.stl","n":[1,2.5,-3e-7]},"\u00fc":null,"b":true})";
  head.bodies = {{"whole \xF0\x9F\xA7\x8A"}, {"a \"part\" \\ of it"}};
  head.bodies[1].color = {0, 0.5, 1, 0.25};
  head.bodies[1].material = "steel";
  head.bodies[1].parent = head.bodies[0].name;
  head.bodies[1].detailsJson = R"({"a":[1,{"b":[]}]})";
  return test;
}

/// The last of 41 slabs has the connectivity of the first: a part that is too far back to be named.
WriterCase farBackCase() {
  std::vector<Slab> slabs;
  for (std::uint32_t k = 0; k < 40; ++k) {
    // A vertex more in each slab, which no cell needs.
    Slab slab = simplex(1, {0, 0, 0, static_cast<double>(k)})[0];
    auto connectivity = std::make_shared<Connectivity>(*slab.connectivity);
    connectivity->vertexCount += k;
    slab.vertices.resize(connectivity->vertexCount, slab.vertices[0]);
    slab.connectivity = connectivity;
    slabs.push_back(slab);
  }
  slabs.push_back(simplex(1, {0, 0, 0, 40})[0]);
  WriterCase test{
      .id = "plain/connectivity-too-far-back",
      .about = "The last of 41 slabs has the connectivity of the first, which is stored again.",
      .metadata = {},
      .bodies = {meshOf(slabs)},
      .skipped = {},
      .storedAgain = 1};
  test.metadata.bodies.push_back({"simplices"});
  return test;
}

}  // namespace

std::vector<WriterCase> writerCases() {
  std::vector<WriterCase> cases;
  std::set<std::string> seen;
  for (const AcceptedCase& made : validCases()) {
    WriterCase test;
    for (const BodySlabs& body : made.bodies) {
      test.metadata.bodies.push_back({body.name});
      test.bodies.push_back(meshOf(body.slabs));
    }
    // The corpus has some meshes in many files: what differs is how they are stored.
    if (!seen.insert(textOf(test).json).second) continue;
    test.id =
        fmt::format("{}/{}", kindOf(test.bodies), made.file.id.substr(made.file.id.find('/') + 1));
    test.about = made.file.fault;
    cases.push_back(std::move(test));
  }
  cases.push_back(headCase());
  cases.push_back(farBackCase());
  const auto rank = [](const WriterCase& test) {
    constexpr std::array kKinds = {"plain", "means", "attributes", "bodies", "head"};
    return std::ranges::find(kKinds, test.id.substr(0, test.id.find('/'))) - kKinds.begin();
  };
  std::ranges::stable_sort(cases, {}, rank);
  return cases;
}

MeshText textOf(const WriterCase& test) {
  const formats::Metadata& head = test.metadata;
  ordered_json mesh = ordered_json::object();
  if (!head.backend.empty()) mesh["backend"] = head.backend;
  if (!head.lengthUnit.empty()) mesh["length_unit"] = head.lengthUnit;
  if (!head.timeUnit.empty()) mesh["time_unit"] = head.timeUnit;
  mesh["up"] = head.up;
  if (head.detailsJson != "{}") mesh["details"] = detailsOf(head.detailsJson);
  MeshWriter writer;
  mesh["bodies"] = ordered_json::array();
  for (std::size_t i = 0; i < test.bodies.size(); ++i) {
    ordered_json body = bodyJson(head.bodies[i]);
    body["slabs"] = writer.slabsOf(test.bodies[i]);
    mesh["bodies"].push_back(std::move(body));
  }
  MeshText text;
  text.connectivities = writer.connectivities.size();
  text.layers = writer.layers.size();
  mesh["connectivities"] = std::move(writer.connectivities);
  mesh["layers"] = std::move(writer.layers);
  print(mesh, "", text.json);
  text.json += "\n";
  return text;
}

}  // namespace t4d::conformance

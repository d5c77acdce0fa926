#include "conformance/answers.h"

#include <cmath>
#include <cstdlib>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "model/number.h"
#include "platform/crc32c.h"
#include "t4d/slice.h"

namespace t4d::conformance {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

/// Sums and interpolations are off by a few units in the last place of the largest term; a wrong
/// reader is off by much more.
constexpr double kRounding = 1e-10;

std::string count(std::uint64_t number) { return std::to_string(number); }

template <int Dimension>
void putBounds(ordered_json& into, const model::Bounds<Dimension>& bounds) {
  for (const auto& [key, point] : {std::pair{"min", &bounds.min}, {"max", &bounds.max}}) {
    into[key] = nullptr;
    if (bounds.empty()) continue;
    into[key] = ordered_json::array();
    for (const double coordinate : *point) into[key].push_back(hexFloat(coordinate));
  }
}

std::string checksumText(std::uint32_t checksum) { return fmt::format("{:08x}", checksum); }

/// The checksum of the numbers in memory, which are little-endian as in a file, after those before.
template <class Row>
std::uint32_t checksumOf(const std::vector<Row>& rows, std::uint32_t before) {
  static_assert(sizeof(Row) == 4 * sizeof(rows[0][0]), "four numbers, without padding");
  return platform::crc32c(rows.data(), rows.size() * sizeof(Row), before);
}

ordered_json attributeAnswer(const model::Attribute& attribute) {
  const std::uint32_t checksum = platform::crc32c(attribute.values.data(), attribute.values.size());
  return {{"domain", attribute.domain == model::Domain::Vertex ? "vertex" : "cell"},
          {"name", attribute.name},
          {"type", count(static_cast<std::uint64_t>(attribute.type))},
          {"components", count(attribute.components)},
          {"checksum", checksumText(checksum)}};
}

/// Describes one body from its slabs.
class Describer : public model::Sink {
 public:
  Result<void> put(const model::Slab& slab) override {
    const model::Connectivity& connectivity = *slab.connectivity;
    model::Bounds4 bounds;
    for (const model::Point4& vertex : slab.vertices) bounds.add(vertex);
    ordered_json answer = {
        {"begin", hexFloat(slab.timeBegin)},           {"end", hexFloat(slab.timeEnd)},
        {"vertices", count(connectivity.vertexCount)}, {"lower", count(connectivity.lowerCount)},
        {"upper", count(connectivity.upperCount)},     {"means", count(connectivity.means.size())},
        {"cells", count(connectivity.cells.size())}};
    putBounds(answer, bounds);
    answer["attributes"] = ordered_json::array();
    for (const auto* attributes : {&connectivity.cellAttributes, &slab.attributes}) {
      for (const model::Attribute& attribute : *attributes) {
        answer["attributes"].push_back(attributeAnswer(attribute));
      }
    }
    if (slabs_.empty()) time_.begin = slab.timeBegin;
    time_.end = slab.timeEnd;
    vertices_ += connectivity.vertexCount - (slabs_.empty() ? 0 : connectivity.lowerCount);
    cells_ += connectivity.cells.size();
    verticesChecksum_ = checksumOf(slab.vertices, verticesChecksum_);
    cellsChecksum_ = checksumOf(connectivity.cells, cellsChecksum_);
    if (!bounds.empty()) {
      bounds_.add(bounds.min.head<3>());
      bounds_.add(bounds.max.head<3>());
    }
    for (const model::Cell& cell : connectivity.cells) {
      Eigen::Matrix4d corners;
      for (int i = 0; i < 4; ++i) corners.col(i) = slab.vertices[cell[i]];
      const double part = corners.determinant() / 24;
      hypervolume_ += part;
      magnitude_ += std::abs(part);
    }
    slabs_.push_back(std::move(answer));
    return {};
  }

  ordered_json answer(const std::string& name) && {
    ordered_json body = {{"name", name},
                         {"vertices", count(vertices_)},
                         {"cells", count(cells_)},
                         {"begin", hexFloat(time_.begin)},
                         {"end", hexFloat(time_.end)}};
    putBounds(body, bounds_);
    body["hypervolume"] = hexFloat(hypervolume_);
    body["vertices_checksum"] = checksumText(verticesChecksum_);
    body["cells_checksum"] = checksumText(cellsChecksum_);
    body["slabs"] = std::move(slabs_);
    return body;
  }

  ordered_json within() const { return {{"hypervolume", hexFloat(kRounding * magnitude_)}}; }

 private:
  ordered_json slabs_ = ordered_json::array();
  model::TimeSpan time_;
  std::uint64_t vertices_ = 0;
  std::uint64_t cells_ = 0;
  std::uint32_t verticesChecksum_ = 0;
  std::uint32_t cellsChecksum_ = 0;
  model::Bounds3 bounds_;
  double hypervolume_ = 0;
  double magnitude_ = 0;  // of the terms of the hypervolume
};

/// Collects the bodies of one answer.
class AnswerBuilder {
 public:
  explicit AnswerBuilder(ordered_json head) : answer_(std::move(head)) {
    answer_["bodies"] = ordered_json::array();
  }
  void add(ordered_json body, ordered_json within) {
    answer_["bodies"].push_back(std::move(body));
    within_.push_back(std::move(within));
  }
  Answer finish() const { return {answer_.dump(1), within_.dump()}; }

 private:
  ordered_json answer_;
  ordered_json within_ = ordered_json::array();
};

AnswerBuilder description(formats::T4dVersion version, const std::vector<std::string>& features) {
  return AnswerBuilder(
      {{"version", fmt::format("{}.{}", version.major, version.minor)}, {"features", features}});
}

std::vector<NamedSource> bodiesOf(formats::T4dReader& reader) {
  std::vector<NamedSource> bodies;
  for (std::size_t i = 0; i < reader.bodyCount(); ++i) {
    bodies.push_back({reader.metadata().bodies[i].name, &reader.body(i)});
  }
  return bodies;
}

/// Whether the axes of a slice are given by the specification.
bool hasGivenAxes(const slice::Hyperplane& hyperplane) {
  return (hyperplane.normal.array() != 0).count() == 1;
}

void addSlice(AnswerBuilder& answer, const std::string& name, const model::TriangleMesh& mesh,
              bool givenAxes = true) {
  model::Bounds3 bounds;
  std::vector<bool> used(mesh.vertices.size());
  std::uint64_t points = 0;
  double volume = 0;
  double area = 0;
  double edges = 0;
  for (const model::Triangle& triangle : mesh.triangles) {
    const model::Point3& a = mesh.vertices[triangle[0]];
    const model::Point3& b = mesh.vertices[triangle[1]];
    const model::Point3& c = mesh.vertices[triangle[2]];
    volume += a.dot(b.cross(c)) / 6;
    area += (b - a).cross(c - a).norm() / 2;
    edges += (b - a).norm() + (c - b).norm() + (a - c).norm();
    for (const std::uint32_t corner : triangle) {
      if (used[corner]) continue;
      used[corner] = true;
      ++points;
      bounds.add(mesh.vertices[corner]);
    }
  }
  const double reach =
      bounds.empty() ? 0
                     : std::max(bounds.min.cwiseAbs().maxCoeff(), bounds.max.cwiseAbs().maxCoeff());
  ordered_json body = {{"name", name},
                       {"points", count(points)},
                       {"triangles", count(mesh.triangles.size())},
                       {"volume", hexFloat(volume)},
                       {"area", hexFloat(area)}};
  if (givenAxes) putBounds(body, bounds);
  // A point that is off by d changes the area by d times the edges of its triangles and the volume
  // by d times their areas. Rounding in the sums themselves adds as much again.
  answer.add(std::move(body), {{"volume", hexFloat(kRounding * reach * (area + reach * edges))},
                               {"area", hexFloat(kRounding * reach * edges)},
                               {"length", hexFloat(kRounding * reach)}});
}

Result<double> numberIn(const ordered_json& text) {
  if (!text.is_string()) return invalid("is not a string");
  const auto& digits = text.get_ref<const std::string&>();
  char* end = nullptr;
  const double number = std::strtod(digits.c_str(), &end);
  if (digits.empty() || *end != '\0' || std::isspace(static_cast<unsigned char>(digits[0])) != 0) {
    return invalid(fmt::format("\"{}\" is not a number", digits));
  }
  return number;
}

/// Walks the expected and the actual answer side by side.
class Comparison {
 public:
  void compare(const ordered_json& expected, const ordered_json& actual, const std::string& path,
               const ordered_json* within) {
    if (expected.is_object()) {
      if (!actual.is_object()) return differ(path, "is not an object");
      for (const auto& [key, value] : expected.items()) {
        const std::string member = path.empty() ? key : path + "." + key;
        if (!actual.contains(key)) {
          differ(member, "is missing");
        } else if (isText(key)) {
          if (value != actual[key]) differ(member, said(actual[key], value));
        } else {
          compare(value, actual[key], member,
                  within == nullptr ? nullptr : toleranceOf(*within, key));
        }
      }
    } else if (expected.is_array()) {
      if (!actual.is_array()) return differ(path, "is not an array");
      if (actual.size() != expected.size()) {
        return differ(path, fmt::format("has {} entries, not {}", actual.size(), expected.size()));
      }
      for (std::size_t i = 0; i < expected.size(); ++i) {
        const ordered_json* inner = within;
        if (path == "bodies" && within != nullptr) inner = &(*within)[i];
        compare(expected[i], actual[i], fmt::format("{}[{}]", path, i), inner);
      }
    } else if (expected.is_null()) {
      if (!actual.is_null()) differ(path, "is not null");
    } else {
      compareNumbers(expected, actual, path, within);
    }
  }

  std::vector<std::string> finish() { return std::move(differences_); }

 private:
  static bool isText(const std::string& key) {
    return key == "name" || key == "domain" || key.ends_with("checksum") || key == "version" ||
           key == "features";
  }

  /// The tolerance of a member in `within`, which may be one tolerance for all members.
  static const ordered_json* toleranceOf(const ordered_json& within, const std::string& key) {
    if (!within.is_object()) return &within;
    if (const auto found = within.find(key); found != within.end()) return &*found;
    if ((key == "min" || key == "max") && within.contains("length")) return &within["length"];
    return nullptr;
  }

  static std::string said(const ordered_json& actual, const ordered_json& expected) {
    return fmt::format("is {}, not {}",
                       actual.dump(-1, ' ', false, ordered_json::error_handler_t::replace),
                       expected.dump());
  }

  void compareNumbers(const ordered_json& expected, const ordered_json& actual,
                      const std::string& path, const ordered_json* within) {
    const auto right = numberIn(expected);
    const auto found = numberIn(actual);
    if (!found) return differ(path, found.error().message);
    const double allowed =
        within != nullptr && within->is_string() ? numberIn(*within).value_or(0) : 0;
    if (std::abs(*found - *right) <= allowed) return;
    if (allowed == 0 && expected.get_ref<const std::string&>().find('x') == std::string::npos) {
      return differ(path, said(actual, expected));
    }
    differ(path, allowed == 0 ? fmt::format("is {:.17g}, not {:.17g}", *found, *right)
                              : fmt::format("is {:.17g}, not {:.17g} within {:.2g}", *found, *right,
                                            allowed));
  }

  void differ(const std::string& path, const std::string& message) {
    differences_.push_back((path.empty() ? "the answer" : path) + " " + message);
  }

  std::vector<std::string> differences_;
};

}  // namespace

Result<Answer> describe(const std::vector<NamedSource>& bodies, formats::T4dVersion version,
                        const std::vector<std::string>& features) {
  AnswerBuilder answer = description(version, features);
  for (const NamedSource& body : bodies) {
    Describer describer;
    if (auto done = pump(*body.source, describer); !done) return done.error();
    ordered_json within = describer.within();
    answer.add(std::move(describer).answer(body.name), std::move(within));
  }
  return answer.finish();
}

Result<Answer> sliceAt(const std::vector<NamedSource>& bodies, double time) {
  AnswerBuilder answer(ordered_json::object());
  for (const NamedSource& body : bodies) {
    const model::TimeSpan span = timeSpanOf(*body.source);
    if (time < span.begin || time > span.end) {
      addSlice(answer, body.name, {});
      continue;
    }
    auto slice = slice::sliceAtTime(*body.source, time);
    if (!slice) return slice.error();
    addSlice(answer, body.name, slice->mesh);
  }
  return answer.finish();
}

Result<Answer> sliceBy(const std::vector<NamedSource>& bodies,
                       const slice::Hyperplane& hyperplane) {
  AnswerBuilder answer(ordered_json::object());
  for (const NamedSource& body : bodies) {
    auto slice = slice::slice(*body.source, hyperplane);
    if (!slice) return slice.error();
    addSlice(answer, body.name, slice->mesh, hasGivenAxes(hyperplane));
  }
  return answer.finish();
}

Result<Answer> describeFile(const std::filesystem::path& path) {
  auto reader = formats::T4dReader::open(path, formats::T4dOpen::Checked, {}, formats::kAnyCells);
  if (!reader) return reader.error();
  const formats::Metadata& metadata = reader->metadata();
  AnswerBuilder answer = description(reader->version(), metadata.features);
  for (std::size_t i = 0; i < reader->bodyCount(); ++i) {
    Describer describer;
    if (auto done = reader->readThrough(i, describer); !done) return done.error();
    ordered_json within = describer.within();
    answer.add(std::move(describer).answer(metadata.bodies[i].name), std::move(within));
  }
  return answer.finish();
}

Result<Answer> sliceFile(const std::filesystem::path& path, double time) {
  auto reader = formats::T4dReader::open(path, formats::T4dOpen::Whole, {}, formats::kAnyCells);
  if (!reader) return reader.error();
  return sliceAt(bodiesOf(*reader), time);
}

Result<Answer> sliceFile(const std::filesystem::path& path, const slice::Hyperplane& hyperplane) {
  auto reader = formats::T4dReader::open(path, formats::T4dOpen::Whole, {}, formats::kAnyCells);
  if (!reader) return reader.error();
  return sliceBy(bodiesOf(*reader), hyperplane);
}

std::string hexFloat(double number) {
  std::string text = std::signbit(number) ? "-0x" : "0x";
  model::appendNumber(text, std::abs(number), std::chars_format::hex);
  return text;
}

std::vector<std::string> differences(const Answer& expected, const std::string& actual) {
  const ordered_json within = ordered_json::parse(expected.within);
  Comparison comparison;
  comparison.compare(ordered_json::parse(expected.json), ordered_json::parse(actual), "", &within);
  return comparison.finish();
}

}  // namespace t4d::conformance

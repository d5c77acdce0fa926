#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <vector>

#include <Eigen/LU>
#include <fmt/format.h>

#include "model/number.h"
#include "t4d/mesh.h"

namespace t4d::model {
namespace {

bool isFloat(const Attribute& attribute) {
  return attribute.type == ScalarType::Float32 || attribute.type == ScalarType::Float64;
}

/// The linear part of a map: how it stretches, and a matrix in a range where nothing overflows.
struct Linear {
  explicit Linear(const Transform& by) : matrix(by.space.leftCols<3>()) {
    largest = matrix.cwiseAbs().maxCoeff();
    const Eigen::Matrix3d relative = matrix / largest;
    const double stretch = std::cbrt(std::abs(relative.determinant()));
    // Matrices that people type have six digits.
    constexpr double kRounded = 1e-6;
    const Eigen::Matrix3d turn = relative / stretch;
    if ((turn.transpose() * turn).isIdentity(kRounded)) scale = stretch * largest;
    cofactors << relative.row(1).cross(relative.row(2)), relative.row(2).cross(relative.row(0)),
        relative.row(0).cross(relative.row(1));
    if (relative.determinant() < 0) cofactors = -cofactors;
  }

  Eigen::Matrix3d matrix;
  double largest = 1;
  std::optional<double> scale;  ///< if it scales all directions alike
  Eigen::Matrix3d cofactors;    ///< the inverse transpose, times a positive number
};

template <class Scalar, class Map>
Result<void> mapRowsOf(Attribute& attribute, Map map) {
  const std::size_t components = attribute.components;
  std::vector<Scalar> row(components);
  std::vector<double> mapped(components);
  for (std::size_t i = 0; i < attribute.rows(); ++i) {
    std::byte* const bytes = attribute.values.data() + i * attribute.rowBytes();
    std::memcpy(row.data(), bytes, attribute.rowBytes());
    std::ranges::copy(row, mapped.begin());
    const auto isFinite = [](double value) { return std::isfinite(value); };
    const auto isZero = [](double value) { return value == 0; };
    const bool finite = std::ranges::all_of(mapped, isFinite);
    const bool zero = std::ranges::all_of(mapped, isZero);
    const bool vanishes = map(mapped);
    std::ranges::transform(mapped, row.begin(),
                           [](double value) { return static_cast<Scalar>(value); });
    if (finite && !std::ranges::all_of(row, isFinite)) {
      return invalid(fmt::format("a value of row {} becomes too large for its type", i));
    }
    if (!zero && !vanishes && std::ranges::all_of(row, isZero)) {
      return invalid(fmt::format("the values of row {} become too small for their type", i));
    }
    std::memcpy(bytes, row.data(), attribute.rowBytes());
  }
  return {};
}

/// `map` takes a row, and returns whether it may become 0 by rights, as a point may.
template <class Map>
Result<bool> mapRows(Attribute& attribute, Map map) {
  const auto done = attribute.type == ScalarType::Float32 ? mapRowsOf<float>(attribute, map)
                                                          : mapRowsOf<double>(attribute, map);
  if (!done) return done.error();
  return true;
}

Result<bool> scaleRows(Attribute& attribute, const std::string& unit, double factor) {
  if (factor == 1) return false;
  if (!isFloat(attribute)) {
    return fail(ErrorCode::Unsupported,
                fmt::format("whole numbers in the unit '{}' cannot be scaled by {}", unit, factor));
  }
  return mapRows(attribute, [&](std::vector<double>& row) {
    for (double& value : row) value *= factor;
    return false;
  });
}

}  // namespace

AttributeMeaning meaningOf(const Attribute& attribute, const AttributeMeanings& given) {
  if (const auto found = given.find(attribute.name); found != given.end()) return found->second;
  const bool registered =
      attribute.domain == Domain::Vertex && isFloat(attribute) && attribute.components == 3;
  if (registered && attribute.name == "velocity") return {"vector", "length/time"};
  if (registered && attribute.name == "displacement") return {"vector", "length"};
  return {};
}

bool isSpatial(const AttributeMeaning& meaning) {
  return meaning.kind == "vector" || meaning.kind == "point" || meaning.kind == "normal";
}

UnitPowers powersOf(std::string_view unit) {
  constexpr int kMost = 9;
  UnitPowers powers;
  int sign = 1;
  while (!unit.empty()) {
    const std::size_t end = std::min(unit.find_first_of("*/"), unit.size());
    std::string_view factor = unit.substr(0, end);
    int power = 1;
    if (const auto hat = factor.find('^'); hat != factor.npos) {
      power = numberIn<int>(factor.substr(hat + 1)).value_or(kMost + 1);
      if (power < -kMost || power > kMost) return {};
      factor = factor.substr(0, hat);
    }
    if (factor.empty()) return {};
    if (factor == "length") powers.length += sign * power;
    if (factor == "time") powers.time += sign * power;
    if (end == unit.size()) return powers;
    sign = unit[end] == '/' ? -1 : 1;
    unit.remove_prefix(end + 1);
  }
  return {};
}

Result<bool> mapValues(Attribute& attribute, const AttributeMeaning& meaning, const Transform& by) {
  const std::string& kind = meaning.kind;
  const bool inPlace = by.space == Affine3x4::Identity();
  if (inPlace && by.timeScale == 1) return false;
  if (kind == "label" || kind == "color") return false;
  const UnitPowers powers = powersOf(meaning.unit);
  const double slower = std::pow(by.timeScale, powers.time);
  const Linear linear(by);
  const auto cannot = [&] {
    return fail(ErrorCode::Unsupported,
                fmt::format("a {} in the unit '{}' cannot follow a map that does not scale all "
                            "directions alike",
                            kind.empty() ? "scalar" : kind, meaning.unit));
  };
  if (kind.empty() || kind == "scalar") {
    if (powers.length == 0 || inPlace) return scaleRows(attribute, meaning.unit, slower);
    if (!linear.scale) return cannot();
    return scaleRows(attribute, meaning.unit, slower * std::pow(*linear.scale, powers.length));
  }
  if (!isSpatial(meaning)) {
    return fail(ErrorCode::Unsupported, fmt::format("the kind '{}' is not known", kind));
  }
  if (inPlace && (kind != "vector" || slower == 1)) return false;
  if (!isFloat(attribute) || attribute.components != 3) {
    return fail(ErrorCode::Unsupported,
                fmt::format("a {} has three floating-point components", kind));
  }
  if (kind == "point") {
    return mapRows(attribute, [&](std::vector<double>& row) {
      Eigen::Map<Point3> point(row.data());
      point = posed(by.space, point);
      return true;
    });
  }
  if (kind == "normal") {
    return mapRows(attribute, [&](std::vector<double>& row) {
      Eigen::Map<Point3> normal(row.data());
      const double length = normal.stableNorm();
      normal = length * (linear.cofactors * (normal / length)).stableNormalized();
      if (length == 0) normal.setZero();
      return false;
    });
  }
  double factor = slower;
  if (!meaning.unit.empty() && powers.length != 1) {
    if (!linear.scale) return cannot();
    factor *= std::pow(*linear.scale, powers.length - 1);
  }
  return mapRows(attribute, [&](std::vector<double>& row) {
    Eigen::Map<Point3> vector(row.data());
    vector = (linear.matrix * factor) * vector;
    return false;
  });
}

}  // namespace t4d::model

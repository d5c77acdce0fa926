#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "t4d/mesh.h"

/// Sums of products without rounding, overflow or underflow, for signs of volumes that must be
/// right whatever the coordinates.
namespace t4d::model {

/// A sum of products of up to four factors, exact for all finite doubles: a fixed-point number with
/// a bit for every power of two that such a product can have (Kulisch). Does not depend on the
/// order of the summands.
class ExactSum {
 public:
  /// A factor: the exact sum of a few doubles.
  class Factor {
   public:
    Factor() = default;
    explicit Factor(double value) { add(value); }
    static Factor difference(double a, double b);

    /// A factor takes at most twelve nonzero doubles.
    void add(double value) {
      if (value != 0) parts_[count_++] = value;
    }
    void add(const Factor& other) {
      for (const double part : other) add(part);
    }
    const double* begin() const { return parts_.data(); }
    const double* end() const { return parts_.data() + count_; }

   private:
    std::array<double, 12> parts_{};
    std::size_t count_ = 0;
  };

  /// Adds the product of one to four factors, or subtracts it.
  void add(std::span<const Factor* const> factors, bool subtract);
  void add(const ExactSum& other);

  /// -1, 0 or 1; 0 if a factor was not finite.
  int sign() const;
  /// The sum divided by `divisor`, rounded; infinite or 0 beyond the range of doubles; NaN if a
  /// factor was not finite.
  double dividedBy(double divisor) const;

 private:
  void addProduct(const std::array<double, 4>& factors, bool subtract);
  void carry();

  // Digits of 32 bits, the lowest first. Each has room for the sum of 2^30 digits. The lowest bit
  // is that of the fourth power of the smallest double.
  static constexpr int kLowestExponent = 4 * -1074;
  static constexpr std::size_t kDigits = (4 * (1074 + 1024) + 64) / 32 + 2;
  std::array<std::int64_t, kDigits> digits_{};
  std::size_t lowest_ = kDigits;  // all digits before it are 0, as are those from end_ on
  std::size_t end_ = 0;
  std::uint32_t added_ = 0;  // summands since the last carry
  bool finite_ = true;
};

/// The most that products below the range of doubles can take from a sum of them.
inline constexpr double kVanished = 1e-290;

/// Whether a sum of products in doubles is precise enough to do without an exact one: whether
/// rounding leaves no more of it unknown than a small part. The products without their signs add up
/// to `magnitude`.
bool isPrecise(double sum, double magnitude);

/// The sign of the determinant of a matrix of up to four rows and columns, exactly; 0 also if a
/// number is not finite.
int determinantSign(const Eigen::Matrix3d& matrix);
int determinantSign(const Eigen::Matrix4d& matrix);

/// The exact sign of det[b - a, c - a, d - a, e - a].
int orientationSign(const std::array<Point4, 5>& points);

/// Adds det[p, q, r] or det[p, q, r, s], of which each row is given as factors.
void addDeterminant(ExactSum& sum, const std::array<std::array<ExactSum::Factor, 3>, 3>& rows);
void addDeterminant(ExactSum& sum, const std::array<std::array<ExactSum::Factor, 4>, 4>& rows);

}  // namespace t4d::model

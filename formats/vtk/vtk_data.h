#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "formats/vtk/vtk_file.h"

namespace t4d::formats {

/// Collects the point data and cell data of pieces as attributes. Skips arrays that a piece does
/// not have or has with another type, and those that cannot be attributes.
class VtkData {
 public:
  explicit VtkData(VtkFile& vtk) : vtk_(vtk) {}

  /// Adds an array of a piece, of which `before` rows are known from those before it. `rows` are
  /// those that the mesh has, if they are not all of `count`.
  void add(const VtkArray& data, model::Domain domain, std::uint64_t count, std::size_t before,
           std::span<const std::uint32_t> rows = {});
  void skip(const std::string& name) { skipped_.insert(name); }

  /// The attributes that all points and cells have.
  std::vector<model::Attribute> take(std::size_t points, std::size_t cells);
  /// The names of what is skipped, known once the attributes are taken.
  const std::set<std::string>& skipped() const { return skipped_; }

 private:
  VtkFile& vtk_;
  std::map<std::string, model::Attribute> ofPoints_;
  std::map<std::string, model::Attribute> ofCells_;
  std::set<std::string> skipped_;
};

}  // namespace t4d::formats

#include "formats/t4d/cell_limit.h"

#include <fmt/format.h>

#include "t4d/file.h"

namespace t4d::formats {

std::uint64_t usualCellLimit(std::uint64_t fileBytes) {
  constexpr std::uint64_t kAlways = 100'000'000;
  constexpr std::uint64_t kPerByte = 10'000;
  return fileBytes > (kAnyCells - kAlways) / kPerByte ? kAnyCells : kAlways + kPerByte * fileBytes;
}

Result<void> checkCellCount(const std::string& name, std::uint64_t bytes, std::uint64_t cells,
                            std::optional<std::uint64_t> maxCells) {
  const std::uint64_t most = maxCells.value_or(usualCellLimit(bytes));
  if (cells <= most) return {};
  Error error{ErrorCode::InvalidInput,
              fmt::format("has {} cells in all its slabs, more than the {} that are allowed for a "
                          "file of {} bytes",
                          cells, most, bytes),
              name};
  error.remedy = Remedy::MoreCells;
  return error;
}

}  // namespace t4d::formats

#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "t4d/formats/t4d/join.h"
#include "t4d/model/part.h"

/// Joining by many processes into one file, on one machine or on several that share a folder.
///
/// One process plans: it writes all of the joined file but what is copied from the parts as it is,
/// and where that goes, into a folder beside it, `INTO.joining`. Then the parts are copied to their
/// places, in any order, several at a time. The last step checks that all are there, and gives the
/// file its name. It has the bytes of joinT4d.
namespace t4d::formats {

/// Plans such a join. Of parts that a manifest describes only indices and the fronts of chunks are
/// read; others are read through first, as joinT4d does. Fails where that fails, if a join into the
/// same file is planned already, and if the disk lacks room for the file.
Result<JoinReport> planJoin(const std::vector<std::filesystem::path>& files,
                            const std::filesystem::path& into,
                            const model::Progress& progress = {});

/// How many parts are to be copied into a file whose join is planned.
Result<std::uint64_t> plannedParts(const std::filesystem::path& into);

struct SharedCopy {
  std::uint64_t parts = 0;  ///< that were copied; those that had been before are left alone
  std::uint64_t bytes = 0;  ///< of them
};

/// Copies a share of the parts to their places, waits until they are on disk, reads them back and
/// checks every chunk. Fails if a part is no longer the one that was planned, or is damaged. The
/// same share can be copied again, also after it failed or was interrupted.
Result<SharedCopy> copyPlannedParts(const std::filesystem::path& into, const model::Part& share,
                                    const model::Progress& progress = {});

/// Gives the joined file its name, and removes the folder. Fails, and changes nothing, if a part
/// has not been copied.
Result<JoinReport> finishJoin(const std::filesystem::path& into);

}  // namespace t4d::formats

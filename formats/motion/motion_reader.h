#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/motion/motion_csv.h"
#include "model/motion.h"
#include "platform/file_format.h"

namespace t4d::formats {

/// Our JSON and tables of poses.
std::vector<platform::FileFormat> motionFormats();

/// Reads a motion file (docs/motion.md; JSON Schema in formats/motion/motion.schema.json):
/// `segments`, each a screw, or `poses`, joined by screws. Refuses, with the file and the place in
/// it, text that is not JSON, unknown keys, missing keys, values of the wrong kind, and what
/// chainScrews or joinPoses refuse. A .csv, .tsv or .txt file is a table of poses (readMotionCsv),
/// which sets `form`; `table` is for these only.
Result<model::Motion> readMotion(const std::filesystem::path& path, std::string* form = nullptr,
                                 const MotionTableOptions& table = {});

/// Parses the text of a JSON motion file; errors name the file `name`.
Result<model::Motion> parseMotion(const std::string& text, const Place& name);

}  // namespace t4d::formats

#include "t4d/verbs/output_check.h"

#include <filesystem>

#include <fmt/format.h>

namespace t4d::verbs {
namespace {

namespace fs = std::filesystem;

bool sameFile(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return fs::equivalent(a, b, ignored);
}

/// Whether two paths, whose files need not exist, lead to the same file.
bool sameFileOnceWritten(const fs::path& a, const fs::path& b) {
  std::error_code failed;
  const auto whole = [&](const fs::path& path) {
    return fs::weakly_canonical(fs::absolute(path, failed), failed);
  };
  const fs::path first = whole(a);
  const fs::path second = whole(b);
  return a == b || sameFile(a, b) || (!failed && first == second);
}

}  // namespace

std::optional<std::string> misuseOfOutput(const std::string& output,
                                          std::span<const std::string> inputs) {
  for (const std::string& input : inputs) {
    std::error_code ignored;
    if (sameFile(input, output)) {
      return fmt::format("the output {} is the input {}; name another file", output,
                         input == output ? "itself" : input);
    }
    if (!fs::is_directory(input, ignored)) continue;
    for (const auto& entry : fs::directory_iterator(input, ignored)) {
      if (entry.path().extension() == ".vdb" && sameFile(entry.path(), output)) {
        return fmt::format("{} is one of the frames in {}; name another file", output, input);
      }
    }
  }
  return std::nullopt;
}

std::optional<std::string> misuseOfOutputs(std::span<const std::string> outputs) {
  const auto isFile = [](const std::string& name) { return !name.empty() && name != "-"; };
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (isFile(outputs[i]) && isFile(outputs[k]) && sameFileOnceWritten(outputs[i], outputs[k])) {
        return fmt::format("two outputs are the same file, {}{}", outputs[k],
                           outputs[i] == outputs[k] ? "" : " and " + outputs[i]);
      }
    }
  }
  return std::nullopt;
}

}  // namespace t4d::verbs

#include "tools/program/option_checks.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "t4d/formats/file_extension.h"
#include "t4d/formats/output_file.h"
#include "t4d/formats/triangle/triangle_mesh_formats.h"
#include "tools/program/numbers.h"

namespace t4d::tools {
namespace {

namespace fs = std::filesystem;

/// A validator; `wanted` completes "'2.5' is not ...".
template <class Accepts>
CLI::Validator checked(std::string wanted, Accepts accepts) {
  return {[wanted = std::move(wanted), accepts](std::string& text) {
            return accepts(text) ? std::string() : fmt::format("'{}' is not {}", text, wanted);
          },
          ""};
}

template <class Accepts>
CLI::Validator checkedNumber(std::string wanted, Accepts accepts) {
  return checked(std::move(wanted), [accepts](const std::string& text) {
    const auto number = numberOf(text);
    return number && accepts(*number);
  });
}

bool sameFile(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return fs::equivalent(a, b, ignored);
}

/// The same for files that need not exist.
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

CLI::Validator finiteNumber() {
  return checkedNumber("a number", [](double) { return true; });
}

CLI::Validator numberAboveZero() {
  return checkedNumber("a number above 0", [](double number) { return number > 0; });
}

CLI::Validator numberFromZero() {
  return checkedNumber("a number from 0 on", [](double number) { return number >= 0; });
}

CLI::Option* addNumbers(CLI::App& command, const std::string& name, std::vector<double>& numbers,
                        const std::string& help, int least, int most, const std::string& form) {
  return command.add_option(name, numbers, help)
      ->delimiter(',')
      ->expected(least, most)
      ->type_name(form)
      ->check(finiteNumber());
}

CLI::Validator fractionBelowOne() {
  return checkedNumber("a number from 0 to less than 1",
                       [](double number) { return number >= 0 && number < 1; });
}

CLI::Validator wholeNumber(std::uint64_t least, std::uint64_t most) {
  return checked(fmt::format("a whole number from {} to {}", least, most),
                 [=](const std::string& text) {
                   std::uint64_t number = 0;
                   const char* end = text.data() + text.size();
                   const auto [stop, error] = std::from_chars(text.data(), end, number);
                   return error == std::errc() && stop == end && number >= least && number <= most;
                 });
}

CLI::Validator noLoneCopy() {
  return checked("0 or at least 2", [](const std::string& text) { return text != "1"; });
}

void addPartOption(CLI::App& command, std::optional<model::Part>& part, const std::string& help) {
  command
      .add_option_function<std::string>(
          "--part", [&part](const std::string& text) { part = partOf(text); }, help)
      ->check(checked("K/N with whole numbers, K from 1 to N",
                      [](const std::string& text) { return partOf(text).has_value(); }))
      ->type_name("K/N");
}

CLI::Validator evenTimesUpTo(std::uint64_t most) {
  return CLI::Validator(
      [most](std::string& text) {
        if (timesOf(text, most)) return std::string();
        return fmt::format("'{}' is not A:B:N with N from 1 to {}", text, most);
      },
      "A:B:N");
}

CLI::Validator timeSpan() {
  return CLI::Validator(
      [](std::string& text) {
        const auto times = numbersBetween(text, ':');
        if (times && times->size() == 2 && (*times)[0] < (*times)[1]) return std::string();
        return fmt::format("'{}' is not A:B with A below B", text);
      },
      "A:B");
}

CLI::Validator noOtherFormat() {
  return CLI::Validator(
      [](std::string& text) {
        const std::string extension = formats::lowerCaseExtension(text);
        const bool other = formats::triangleMeshFormat(text) != nullptr || extension == ".vdb" ||
                           extension == ".json" || extension == ".t4dm";
        if (!other) return std::string();
        return fmt::format("'{}' has the name of another format; a .t4d is written", text);
      },
      "");
}

CLI::Validator vdbFile() {
  return {[](std::string& path) {
            return formats::lowerCaseExtension(path) == ".vdb"
                       ? std::string()
                       : fmt::format("'{}' does not end with .vdb", path);
          },
          ""};
}

CLI::Validator writableTriangleMesh() {
  return {[](std::string& path) {
            const auto* format = formats::triangleMeshFormat(path);
            return format != nullptr && format->write != nullptr
                       ? std::string()
                       : fmt::format("unsupported output extension: '{}' is not {}", path,
                                     formats::writableTriangleMeshExtensions());
          },
          ""};
}

CLI::Validator someName() {
  return {[](std::string& text) { return text.empty() ? "the name is empty" : std::string(); }, ""};
}

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

Result<void> checkWritable(std::span<const std::string> outputs) {
  for (const std::string& output : outputs) {
    std::error_code ignored;
    // A pipe is opened once only, by its writer.
    if (output.empty() || output == "-" || fs::is_fifo(output, ignored)) continue;
    if (auto created = formats::OutputFile::create(output); !created) return created.error();
  }
  return {};
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

}  // namespace t4d::tools

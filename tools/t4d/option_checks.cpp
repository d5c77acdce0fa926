#include "tools/t4d/option_checks.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "formats/file_extension.h"
#include "formats/listed.h"
#include "formats/output_file.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "model/number.h"
#include "platform/kept_inputs.h"
#include "tools/t4d/numbers.h"

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

bool isPipeOrDevice(const std::string& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (path.starts_with("/dev/")) return true;  // such as /dev/stdout, which may be any file
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

/// The error message if a name has none of these extensions.
std::string wrongExtension(const std::string& path,
                           const std::vector<std::string_view>& extensions) {
  if (std::ranges::find(extensions, formats::lowerCaseExtension(path)) != extensions.end()) {
    return {};
  }
  return fmt::format("'{}' does not end with {}", path, formats::listed(extensions));
}

/// Whether two paths, whose files need not exist, lead to the same file.
bool isOneFile(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  std::error_code failed;
  const auto whole = [&](const fs::path& path) {
    return fs::weakly_canonical(fs::absolute(path, failed), failed);
  };
  const bool same = whole(a) == whole(b);
  return a == b || fs::equivalent(a, b, ignored) || (!failed && same);
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
                   const auto number = model::numberIn<std::uint64_t>(text);
                   return number && *number >= least && *number <= most;
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

CLI::Validator timesUpTo(std::uint64_t most) {
  return CLI::Validator(
      [most](std::string& text) {
        if (timesOf(text, most)) return std::string();
        return fmt::format("'{}' is neither A:B:N, with N from 1 to {}, nor T1,T2,...", text, most);
      },
      "A:B:N|T1,T2,...");
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

CLI::Validator outputFile(std::vector<std::string_view> extensions) {
  return {[extensions = std::move(extensions)](std::string& path) {
            const bool streams = path == "-" || isPipeOrDevice(path);
            return streams ? std::string() : wrongExtension(path, extensions);
          },
          ""};
}

CLI::Validator htmlFile() { return outputFile({".html", ".htm"}); }

CLI::Validator outputByExtension(std::vector<std::string_view> extensions) {
  return {[extensions = std::move(extensions)](std::string& path) {
            return wrongExtension(path, extensions);
          },
          ""};
}

CLI::Validator writableTriangleMesh() {
  return outputByExtension(formats::writableTriangleMeshes());
}

CLI::Validator someName() {
  return {[](std::string& text) { return text.empty() ? "the name is empty" : std::string(); }, ""};
}

Result<void> checkOutputs(std::span<const std::string> outputs,
                          std::span<const std::string> inputs) {
  for (const std::string& input : inputs) platform::noteInput(input);
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const std::string& output = outputs[i];
    if (output.empty() || output == "-") continue;
    for (const std::string& other : outputs.first(i)) {
      if (!isOneFile(output, other)) continue;
      return fail(ErrorCode::Options, fmt::format("two outputs are the same file, {}{}", other,
                                                  output == other ? "" : " and " + output));
    }
    std::error_code ignored;
    // A pipe is opened once only, by its writer.
    if (fs::is_fifo(output, ignored)) continue;
    if (auto created = formats::OutputFile::create(output); !created) return created.error();
  }
  return {};
}

}  // namespace t4d::tools

#include "conformance/backends/program_backend.h"

#include <array>
#include <optional>

#include <fmt/format.h>

#include "formats/output_folder.h"
#include "platform/child_process.h"
#include "platform/replaceable.h"
#include "platform/temporary_folder.h"
#include "t4d/file.h"
#include "t4d/surface.h"

namespace t4d::conformance {
namespace {

namespace fs = std::filesystem;

/// The last line that is not empty, cut to a readable length.
std::string lastLineOf(const std::string& text) {
  constexpr std::size_t kShown = 300;
  const std::size_t end = text.find_last_not_of(" \t\r\n");
  if (end == std::string::npos) return {};
  const std::size_t before = text.find_last_of('\n', end);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  const std::string line = text.substr(begin, end + 1 - begin);
  return line.size() > kShown ? line.substr(0, kShown) + "..." : line;
}

/// The reason why a run failed; empty if it succeeded.
std::string faultOf(const platform::ProgramRun& run, double timeoutSeconds) {
  if (run.end == platform::ProgramRun::End::TimedOut) {
    return fmt::format("timed out after {:g} s (--timeout)", timeoutSeconds);
  }
  if (run.end == platform::ProgramRun::End::Exited && run.code == 0) return {};
  const std::string said = lastLineOf(run.message.empty() ? run.output : run.message);
  return fmt::format(
      "{} {}{}",
      run.end == platform::ProgramRun::End::Exited ? "exited with" : "was ended by signal",
      run.code, said.empty() ? " and printed nothing" : "; last line of output: " + said);
}

class ProgramBackend : public Backend {
 public:
  ProgramBackend(ProgramOptions options, std::vector<std::string> words)
      : options_(std::move(options)), words_(std::move(words)) {}

  std::string name() const override { return "program"; }
  bool supports(const Case& given) const override { return given.mesh.has_value(); }
  Result<Expectation> expectation(const Case& given, const Resolution&) const override {
    return solidExpectation(given, options_.tolerance);
  }

  Result<void> build(const Case& given, const Resolution&, model::Sink& sink) const override {
    std::optional<platform::TemporaryFolder> temporary;
    fs::path folder = options_.keep;
    if (folder.empty()) {
      auto created = platform::TemporaryFolder::create();
      if (!created) return created.error();
      temporary.emplace(std::move(*created));
      folder = temporary->path();
    }
    const std::array<std::string, 3> names = {given.id + ".obj", given.id + ".json",
                                              given.id + ".t4d"};
    const std::array<fs::path, 3> paths = {folder / names[0], folder / names[1], folder / names[2]};
    const auto any = [](const fs::path&) { return true; };
    if (auto good = platform::checkReplaceable(folder, names, any); !good) return good;
    const formats::NamedMesh mesh{given.id, given.mesh->mesh};
    if (auto written = formats::writeTriangleMeshes(paths[0], {&mesh, 1}); !written) {
      return written.error();
    }
    if (auto written = formats::writeInFolder(folder, names[1], given.mesh->motionText); !written) {
      return written;
    }
    std::error_code ignored;
    fs::remove(paths[2], ignored);  // left by an earlier run

    std::vector<std::string> words = words_;
    for (const fs::path& path : paths) words.push_back(path.string());
    const auto ran = platform::runProgram(words, {.limit = options_.timeoutSeconds});
    if (!ran) return ran.error();
    if (auto written =
            formats::writeInFolder(folder, given.id + ".log", ran->output + ran->message);
        !written) {
      return written;
    }
    if (const std::string fault = faultOf(*ran, options_.timeoutSeconds); !fault.empty()) {
      return fail(ErrorCode::Failed, fault, options_.command);
    }
    if (!fs::exists(paths[2])) {
      return fail(ErrorCode::Failed, "exited with 0 and wrote no " + paths[2].filename().string(),
                  options_.command);
    }
    auto reader = formats::T4dReader::open(paths[2]);
    if (!reader) return reader.error();
    if (reader->bodyCount() != 1) {
      return invalid(fmt::format("has {} bodies; a case is one", reader->bodyCount()),
                     paths[2].string());
    }
    return pump(reader->body(0), sink);
  }

 private:
  ProgramOptions options_;
  std::vector<std::string> words_;
};

}  // namespace

Result<std::unique_ptr<Backend>> programBackend(ProgramOptions options) {
  auto words = platform::splitCommand(options.command);
  if (!words) return words.error();
  return std::make_unique<ProgramBackend>(std::move(options), std::move(*words));
}

}  // namespace t4d::conformance

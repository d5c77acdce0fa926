#include "conformance/backends/program_backend.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <optional>
#include <thread>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "conformance/temporary_folder.h"
#include "formats/output_file.h"
#include "formats/t4d/reader.h"
#include "formats/triangle_mesh_writer.h"

namespace t4d::conformance {
namespace {

namespace fs = std::filesystem;

/// The last line of a text file that is not empty, cut to a readable length.
std::string lastLineOf(const fs::path& path) {
  constexpr std::size_t kShown = 300;
  std::ifstream in(path);
  std::string last;
  for (std::string line; std::getline(in, line);) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  }
  return last.size() > kShown ? last.substr(0, kShown) + "..." : last;
}

/// Runs `command` with arguments in a process group of its own, which is killed when time is up.
/// Its output goes to `log`.
Result<void> runCommand(const std::string& command, const std::array<std::string, 3>& arguments,
                        const fs::path& log, double timeoutSeconds) {
  std::array<std::string, 7> words = {"sh",         "-c",         command + " \"$@\"", "sh",
                                      arguments[0], arguments[1], arguments[2]};
  std::array<char*, 8> argv{};
  for (std::size_t i = 0; i < words.size(); ++i) argv[i] = words[i].data();

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(),
                                   O_WRONLY | O_CREAT | O_TRUNC, 0666);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  pid_t child = 0;
  const int spawned = posix_spawn(&child, "/bin/sh", &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (spawned != 0) {
    return fail(ErrorCode::Failed, fmt::format("cannot be started: {}", std::strerror(spawned)));
  }

  const auto begin = std::chrono::steady_clock::now();
  const std::chrono::duration<double> timeout(timeoutSeconds);
  bool timedOut = false;
  int status = 0;
  while (true) {
    const pid_t ended = waitpid(child, &status, timedOut ? 0 : WNOHANG);
    if (ended == child) break;
    if (ended < 0 && errno != EINTR) {
      return fail(ErrorCode::Failed, fmt::format("cannot be waited for: {}", std::strerror(errno)));
    }
    if (!timedOut && std::chrono::steady_clock::now() - begin > timeout) {
      timedOut = true;
      kill(-child, SIGKILL);
      continue;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const std::string said = lastLineOf(log);
  const std::string quoted = said.empty() ? "and printed nothing" : "and said last: " + said;
  if (timedOut) {
    return fail(ErrorCode::Failed,
                fmt::format("was ended after {:g} s (--timeout)", timeoutSeconds));
  }
  if (WIFSIGNALED(status)) {
    return fail(ErrorCode::Failed,
                fmt::format("was ended by signal {} {}", WTERMSIG(status), quoted));
  }
  if (WEXITSTATUS(status) != 0) {
    return fail(ErrorCode::Failed, fmt::format("exited with {} {}", WEXITSTATUS(status), quoted));
  }
  return {};
}

Result<void> writeText(const fs::path& path, const std::string& text) {
  return formats::OutputFile::create(path).and_then([&](formats::OutputFile file) {
    return file.write(text.data(), text.size()).and_then([&] { return file.commit(); });
  });
}

class ProgramBackend : public Backend {
 public:
  explicit ProgramBackend(ProgramOptions options) : options_(std::move(options)) {}

  std::string name() const override { return "program"; }
  bool supports(const Case& given) const override { return given.mesh.has_value(); }
  Result<Law> law(const Case& given, const Resolution&) const override {
    return trueLaw(given, options_.tolerance);
  }

  Result<void> build(const Case& given, const Resolution&, model::Sink& sink) const override {
    std::optional<TemporaryFolder> temporary;
    fs::path folder = options_.keep;
    if (folder.empty()) {
      auto created = TemporaryFolder::create();
      if (!created) return pass(created.error());
      temporary.emplace(std::move(*created));
      folder = temporary->path();
    }
    const std::array<fs::path, 3> paths = {
        folder / (given.id + ".obj"), folder / (given.id + ".json"), folder / (given.id + ".t4d")};
    const formats::NamedMesh mesh{given.id, given.mesh->mesh};
    if (auto written = formats::writeTriangleMeshes(paths[0], {&mesh, 1}); !written) {
      return pass(written.error());
    }
    if (auto written = writeText(paths[1], given.mesh->motionText); !written) return written;
    std::error_code ignored;
    fs::remove(paths[2], ignored);  // of an earlier run

    auto ran = runCommand(options_.command, {paths[0], paths[1], paths[2]},
                          folder / (given.id + ".log"), options_.timeoutSeconds);
    if (!ran) return fail(ran.error().code, ran.error().message, options_.command);
    if (!fs::exists(paths[2])) {
      return fail(ErrorCode::Failed, "exited with 0 and wrote no " + paths[2].filename().string(),
                  options_.command);
    }
    auto reader = formats::T4dReader::open(paths[2]);
    if (!reader) return pass(reader.error());
    if (reader->bodyCount() != 1) {
      return invalid(fmt::format("has {} bodies; a case is one", reader->bodyCount()),
                     paths[2].string());
    }
    return pump(reader->body(0), sink);
  }

 private:
  ProgramOptions options_;
};

}  // namespace

std::unique_ptr<Backend> programBackend(ProgramOptions options) {
  return std::make_unique<ProgramBackend>(std::move(options));
}

}  // namespace t4d::conformance

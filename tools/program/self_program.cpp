#include "tools/program/self_program.h"

#include <array>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "t4d/system/cleanup.h"

namespace t4d::tools {

Result<Finished> runSelf(const std::vector<std::string>& arguments) {
  const auto failed = [](const char* what, int reason) {
    return fail(ErrorCode::Failed, fmt::format("cannot {}: {}", what, std::strerror(reason)));
  };
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return failed("make a pipe", errno);
  std::vector<std::string> words = {"t4d"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  pid_t child = 0;
  const int spawned =
      posix_spawn(&child, "/proc/self/exe", &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  if (spawned != 0) {
    close(ends[0]);
    return failed("start another process", spawned);
  }

  system::Cleanup note = system::Cleanup::process(child);
  Finished finished;
  std::array<char, 4096> buffer;
  while (true) {
    const ssize_t size = read(ends[0], buffer.data(), buffer.size());
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) break;
    finished.output.append(buffer.data(), static_cast<std::size_t>(size));
  }
  close(ends[0]);
  siginfo_t ended{};
  while (waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOWAIT) != 0) {
    if (errno != EINTR) return failed("wait for another process", errno);
  }
  note.release();
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return failed("wait for another process", errno);
  }
  if (!WIFEXITED(status)) {
    return fail(
        ErrorCode::Failed,
        fmt::format("`t4d {}` was ended by signal {}{}", arguments.front(), WTERMSIG(status),
                    WTERMSIG(status) == SIGKILL ? " (out of memory?)" : ""));
  }
  finished.exitCode = WEXITSTATUS(status);
  return finished;
}

}  // namespace t4d::tools

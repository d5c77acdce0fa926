#include "platform/isolated.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <new>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "platform/cleanup.h"
#include "platform/descriptor.h"

#ifdef T4D_ADDRESS_SANITIZER
// Until LLVM 17 the sanitizer does not hold its allocator while a process forks: the child waits
// for ever for a lock that another thread had.
namespace __lsan {
void LockAllocator();
void UnlockAllocator();
}  // namespace __lsan
#endif

namespace t4d::platform {
namespace {

pid_t forkWithTheAllocator() {
#ifdef T4D_ADDRESS_SANITIZER
  __lsan::LockAllocator();
  const pid_t child = fork();
  __lsan::UnlockAllocator();
  return child;
#else
  return fork();
#endif
}

/// Exit codes of the child.
enum Outcome : int { kReturned = 0, kOutOfMemory = 1, kThrew = 2, kNotKept = 3 };

Error cannotIsolate(const char* what) {
  return fail(ErrorCode::Failed, fmt::format("cannot {}: {}", what, std::strerror(errno)));
}

/// The address space that this process uses.
std::uint64_t addressSpaceBytes() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

void limit(int resource, std::uint64_t most) {
  rlimit limits{};
  getrlimit(static_cast<__rlimit_resource>(resource), &limits);
  limits.rlim_cur = std::min<rlim_t>(most, limits.rlim_max);
  setrlimit(static_cast<__rlimit_resource>(resource), &limits);
}

[[noreturn]] void workAsChild(const std::function<std::string()>& work, const WorkLimits& limits,
                              pid_t parent, const Descriptor& result) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kThrew);  // it has ended already
  // The handlers of this process would clean up what belongs to the parent.
  for (int signal = 1; signal < NSIG; ++signal) std::signal(signal, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, limits.cpuSeconds);
  // Sanitizers reserve terabytes of address space, which says nothing about memory.
  constexpr std::uint64_t kReserved = std::uint64_t{1} << 42;
  const std::uint64_t used = addressSpaceBytes();
  if (used < kReserved) limit(RLIMIT_AS, used + limits.memoryBytes);
  try {
    _exit(result.write(work()) ? kReturned : kNotKept);
  } catch (const std::bad_alloc&) {
    _exit(kOutOfMemory);
  } catch (...) {
    _exit(kThrew);
  }
}

Result<std::string> readAll(const Descriptor& file) {
  struct stat status {};
  if (fstat(file.number(), &status) != 0) return cannotIsolate("read the result of a process");
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  if (file.readAt(0, std::as_writable_bytes(std::span(bytes))) != status.st_size) {
    return cannotIsolate("read the result of a process");
  }
  return bytes;
}

}  // namespace

Result<IsolatedWork> runIsolated(const std::function<std::string()>& work,
                                 const WorkLimits& limits) {
  const Descriptor result(memfd_create("t4d", MFD_CLOEXEC));
  if (!result) return cannotIsolate("keep the result of a process");
  const pid_t parent = getpid();
  pid_t child = 0;
  Cleanup note;
  {
    const HeldCleanup held;
    child = forkWithTheAllocator();
    if (child == 0) workAsChild(work, limits, parent, result);
    if (child > 0) note = Cleanup::process(held, child);
  }
  if (child < 0) return cannotIsolate("start a process");
  // Wait without reaping it, so that its number stays its own until the note is released.
  siginfo_t ended{};
  while (waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOWAIT) != 0 &&
         errno == EINTR) {
  }
  note.release();
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  auto bytes = readAll(result);
  if (!bytes) return bytes.error();

  IsolatedWork done;
  if (WIFSIGNALED(status)) {
    done.signal = WTERMSIG(status);
    done.end = done.signal == SIGXCPU ? IsolatedWork::End::OutOfTime : IsolatedWork::End::Crashed;
  } else if (WEXITSTATUS(status) == kReturned) {
    done.result = std::move(*bytes);
  } else if (WEXITSTATUS(status) == kNotKept) {
    errno = ENOSPC;
    return cannotIsolate("keep the result of a process");
  } else {
    done.end = WEXITSTATUS(status) == kOutOfMemory ? IsolatedWork::End::OutOfMemory
                                                   : IsolatedWork::End::Crashed;
  }
  return done;
}

}  // namespace t4d::platform

#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "conformance/driver/evaluate.h"
#include "platform/child_process.h"

namespace t4d::conformance {

/// A reader that answers many requests in one process (formats/t4d/SPEC.md, appendix). It is
/// started at the first request and restarted after each fault, so the next request always gets a
/// working process.
class ServedReader {
 public:
  /// `command` starts a reader for a single request; `--serve` is appended. `stop` as in
  /// RunOptions.
  ServedReader(std::vector<std::string> command, double timeoutSeconds,
               const std::atomic<bool>* stop);

  /// Sends a request about the file at `path`. The limit, `timeoutSeconds` of processor time,
  /// includes starting the reader if needed. Fails if the reader cannot be started or the path has
  /// a line break.
  Result<Reply> ask(const std::vector<std::string>& request, const std::string& path);

  /// Whether it has answered a request since it was started. A fresh process has not.
  bool hasAnswered() const { return answered_ > 0; }
  void restart();

  /// Faults of the reader since its last answer, without a request: it printed more, closed its
  /// standard output, or ended. It is then restarted. Usually empty.
  std::optional<std::string> lateFault();

 private:
  std::vector<std::string> command_;
  double timeoutSeconds_;
  const std::atomic<bool>* stop_;
  std::optional<platform::ChildProcess> process_;
  std::size_t answered_ = 0;
};

}  // namespace t4d::conformance

#include "tools/program/conform_run.h"

#include <sys/resource.h>

#include "t4d/formats/output_file.h"

namespace t4d::tools {
namespace {

std::atomic<bool> signalArrived = false;
volatile std::sig_atomic_t arrivedSignal = 0;

extern "C" void keepSignal(int signal) {
  arrivedSignal = signal;
  signalArrived = true;
}

}  // namespace

Interruptible::Interruptible() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], nullptr, &before_[i]);
    if (before_[i].sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = keepSignal;
    sigaction(kSignals[i], &action, nullptr);
  }
}

Interruptible::~Interruptible() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
}

const std::atomic<bool>& Interruptible::interrupted() { return signalArrived; }

void Interruptible::endIfInterrupted() {
  if (signalArrived) std::raise(arrivedSignal);
}

void disableCoreDumps() {
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
}

Result<void> writeReport(const std::string& path, const std::string& text) {
  auto file = formats::OutputFile::create(path);
  if (!file) return pass(file.error());
  return file->write(text.data(), text.size()).and_then([&] { return file->commit(); });
}

}  // namespace t4d::tools

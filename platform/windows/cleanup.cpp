#include "platform/cleanup.h"

#include <utility>

/// No signal ends a process here, so nothing is registered: a destructor removes what is temporary,
/// and the next file with the same target what a killed process has left.
namespace t4d::platform {

struct Cleanup::Entry {};

namespace {

Cleanup::Entry held;

}  // namespace

HeldCleanup::HeldCleanup() = default;
HeldCleanup::~HeldCleanup() = default;

Cleanup Cleanup::file(const std::filesystem::path& /*path*/) { return Cleanup(&held); }
Cleanup Cleanup::folder(const std::filesystem::path& /*path*/) { return Cleanup(&held); }
Cleanup Cleanup::emptyFolder(const std::filesystem::path& /*path*/) { return Cleanup(&held); }

Cleanup::Cleanup(Cleanup&& other) noexcept : entry_(std::exchange(other.entry_, nullptr)) {}

Cleanup& Cleanup::operator=(Cleanup&& other) noexcept {
  entry_ = std::exchange(other.entry_, nullptr);
  return *this;
}

void Cleanup::release() noexcept { entry_ = nullptr; }

}  // namespace t4d::platform

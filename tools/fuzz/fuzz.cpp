#include "tools/fuzz/fuzz.h"

#include <algorithm>
#include <atomic>

#include <sanitizer/allocator_interface.h>
#include <sys/mman.h>
#include <unistd.h>

namespace t4d::fuzz {
namespace {

std::atomic<std::ptrdiff_t> heapBytes = 0;
std::atomic<std::ptrdiff_t> heapPeak = 0;

void afterMalloc(const volatile void* /*block*/, std::size_t size) {
  const std::ptrdiff_t now = heapBytes += static_cast<std::ptrdiff_t>(size);
  std::ptrdiff_t peak = heapPeak;
  while (now > peak && !heapPeak.compare_exchange_weak(peak, now)) {
  }
}

void beforeFree(const volatile void* block) {
  if (block == nullptr) return;
  heapBytes -=
      static_cast<std::ptrdiff_t>(__sanitizer_get_allocated_size(const_cast<const void*>(block)));
}

}  // namespace

MemoryFile::MemoryFile()
    : descriptor_(::memfd_create("t4d", MFD_CLOEXEC)),
      path_("/proc/self/fd/" + std::to_string(descriptor_)) {
  must(descriptor_ >= 0, "files in memory can be made");
}

MemoryFile::~MemoryFile() { ::close(descriptor_); }

void MemoryFile::set(std::span<const std::uint8_t> bytes) {
  const auto size = static_cast<ssize_t>(bytes.size());
  must(::ftruncate(descriptor_, size) == 0 &&
           ::pwrite(descriptor_, bytes.data(), bytes.size(), 0) == size,
       "files in memory can be written");
}

HeapMeter::HeapMeter() {
  static const int installed = __sanitizer_install_malloc_and_free_hooks(afterMalloc, beforeFree);
  must(installed > 0, "there is room for the hooks of the heap");
  heapBytes = 0;
  heapPeak = 0;
}

std::size_t HeapMeter::peak() const { return static_cast<std::size_t>(heapPeak.load()); }

}  // namespace t4d::fuzz

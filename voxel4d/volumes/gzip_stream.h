#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "platform/open_file.h"

namespace t4d::voxel4d {

/// Unpacks gzip data from an open file, by ISA-L: one member or several, up to the first bytes that
/// begin none.
class GzipStream {
 public:
  enum class State : std::uint8_t {
    Good,
    End,         ///< all has been read, and its checksums are right
    CutOff,      ///< the file ends within a member
    Damaged,     ///< see `fault`
    CannotRead,  ///< see `error`
  };

  /// Reads from the present place of the file.
  explicit GzipStream(platform::OpenFile file);
  GzipStream(const GzipStream&) = delete;
  GzipStream& operator=(const GzipStream&) = delete;
  ~GzipStream();

  /// Returns how many bytes it has set, which are all of them in the state Good.
  std::size_t read(std::span<std::byte> into);

  State state() const { return state_; }
  const char* fault() const { return fault_; }
  const Error& error() const { return error_; }

 private:
  struct Inflate;

  bool fill();
  void startMember();

  platform::OpenFile file_;
  std::unique_ptr<Inflate> inflate_;
  std::vector<std::uint8_t> input_;
  State state_ = State::Good;
  const char* fault_ = "";
  Error error_;
};

}  // namespace t4d::voxel4d

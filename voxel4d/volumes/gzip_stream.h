#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

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
    CannotRead,  ///< `errno` was `reason`
  };

  /// Reads from the present place of the file, which stays open.
  explicit GzipStream(int descriptor);
  GzipStream(const GzipStream&) = delete;
  GzipStream& operator=(const GzipStream&) = delete;
  ~GzipStream();

  /// Returns how many bytes it has set, which are all of them in the state Good.
  std::size_t read(std::span<std::byte> into);

  State state() const { return state_; }
  const char* fault() const { return fault_; }
  int reason() const { return reason_; }

 private:
  struct Inflate;

  bool fill();
  void startMember();

  int descriptor_;
  std::unique_ptr<Inflate> inflate_;
  std::vector<std::uint8_t> input_;
  State state_ = State::Good;
  const char* fault_ = "";
  int reason_ = 0;
};

}  // namespace t4d::voxel4d

#include "voxel4d/volumes/gzip_stream.h"

#include <algorithm>
#include <limits>

#include <isa-l/igzip_lib.h>
#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace t4d::voxel4d {
namespace {

constexpr std::size_t kInputBytes = std::size_t{1} << 18U;

/// To be called after functions of ISA-L 2.30. They leave values in the upper halves of the AVX
/// registers. Until these are cleared, SSE code on this thread takes several times as long.
#ifdef __x86_64__
[[gnu::target("avx"), gnu::noinline]] void clearHalves() { _mm256_zeroupper(); }
void clearUpperHalves() {
  static const bool has = __builtin_cpu_supports("avx") != 0;
  if (has) clearHalves();
}
#else
void clearUpperHalves() {}
#endif

const char* faultOf(int code) {
  switch (code) {
    case ISAL_INVALID_BLOCK:
      return "a block is not valid";
    case ISAL_INVALID_SYMBOL:
      return "a code is not valid";
    case ISAL_INVALID_LOOKBACK:
      return "a repetition begins before the data";
    case ISAL_INVALID_WRAPPER:
      return "the header of a member is not valid";
    case ISAL_UNSUPPORTED_METHOD:
      return "a member is not compressed by deflate";
    case ISAL_INCORRECT_CHECKSUM:
      return "the checksum is not that of the data";
    default:
      return "they need a dictionary";
  }
}

}  // namespace

struct GzipStream::Inflate : inflate_state {};

GzipStream::GzipStream(platform::OpenFile file)
    : file_(std::move(file)), inflate_(std::make_unique<Inflate>()), input_(kInputBytes) {
  isal_inflate_init(&*inflate_);
  inflate_->crc_flag = ISAL_GZIP;
}

GzipStream::~GzipStream() = default;

bool GzipStream::fill() {
  // The bytes that are left come first.
  std::copy_n(inflate_->next_in, inflate_->avail_in, input_.begin());
  inflate_->next_in = input_.data();
  const auto got =
      file_.read(std::as_writable_bytes(std::span(input_)).subspan(inflate_->avail_in));
  if (!got) {
    error_ = got.error();
    state_ = State::CannotRead;
    return false;
  }
  inflate_->avail_in += static_cast<std::uint32_t>(*got);
  return *got > 0;
}

/// Begins the next member, if one follows.
void GzipStream::startMember() {
  while (inflate_->avail_in < 2 && fill()) {
  }
  if (state_ != State::Good) return;
  if (inflate_->avail_in < 2 || inflate_->next_in[0] != 0x1F || inflate_->next_in[1] != 0x8B) {
    state_ = State::End;
    return;
  }
  std::uint8_t* const at = inflate_->next_in;
  const std::uint32_t left = inflate_->avail_in;
  isal_inflate_reset(&*inflate_);
  inflate_->crc_flag = ISAL_GZIP;
  inflate_->next_in = at;
  inflate_->avail_in = left;
}

std::size_t GzipStream::read(std::span<std::byte> into) {
  std::size_t done = 0;
  while (state_ == State::Good && done < into.size()) {
    const auto room = static_cast<std::uint32_t>(
        std::min<std::size_t>(into.size() - done, std::numeric_limits<std::int32_t>::max()));
    inflate_->next_out = reinterpret_cast<std::uint8_t*>(into.data() + done);
    inflate_->avail_out = room;
    const int code = isal_inflate(&*inflate_);
    clearUpperHalves();
    done += room - inflate_->avail_out;
    if (code < 0 || code == ISAL_NEED_DICT) {
      state_ = State::Damaged;
      fault_ = faultOf(code);
    } else if (inflate_->block_state == ISAL_BLOCK_FINISH) {
      startMember();
    } else if (inflate_->avail_out > 0 && !fill() && state_ == State::Good) {
      state_ = State::CutOff;
    }
  }
  return done;
}

}  // namespace t4d::voxel4d

#include "formats/t4d/stored_block.h"

#include <utility>

#include "platform/crc32c.h"

namespace t4d::formats {

std::optional<std::uint64_t> BlockFile::add(std::span<const std::byte> bytes) {
  const std::scoped_lock lock(mutex_);
  if (!file_ && !failed_) {
    auto made = platform::ScratchFile::create();
    if (made) file_ = std::move(*made);
  }
  // After a failure it is not known how much of the bytes is in the file.
  failed_ = failed_ || !file_ || !file_->append(bytes);
  if (failed_) return std::nullopt;
  return std::exchange(size_, size_ + bytes.size());
}

bool BlockFile::read(std::uint64_t offset, std::span<std::byte> into) const {
  return file_ && file_->read(offset, into);
}

StoredBlock::StoredBlock(std::vector<std::byte> bytes)
    : bytes_(std::move(bytes)),
      size_(bytes_.size()),
      checksum_(platform::crc32c(bytes_.data(), bytes_.size())) {}

void StoredBlock::moveTo(const std::shared_ptr<BlockFile>& file) {
  const auto offset = file->add(bytes_);
  if (!offset) return;
  offset_ = *offset;
  file_ = file;
  bytes_ = {};
}

Result<std::span<const std::byte>> StoredBlock::bytes(std::vector<std::byte>& space) const {
  if (!file_) return std::span<const std::byte>(bytes_);
  space.resize(size_);
  if (!file_->read(offset_, space)) {
    return fail(ErrorCode::Failed, "cannot read a temporary file (TMPDIR says where)");
  }
  return std::span<const std::byte>(space);
}

}  // namespace t4d::formats

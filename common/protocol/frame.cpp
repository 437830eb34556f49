#include "common/protocol/frame.h"

#include <algorithm>
#include <string>

namespace enamel::protocol {
namespace {

// The most memory taken before the bytes arrive: a false length costs 64 KiB and no more.
constexpr size_t kStep = size_t{64} << 10;

Status TooLong(size_t size, size_t limit) {
  return Status(Code::kTooLarge, "frame: expected a message of at most " + std::to_string(limit) +
                                     " bytes, found " + std::to_string(size));
}

}  // namespace

Result<Bytes> EncodeFrame(ByteView message) {
  if (message.size() > kMaxFrameBytes) return TooLong(message.size(), kMaxFrameBytes);
  ByteWriter out;
  out.Blob(message);
  return out.Take();
}

std::span<uint8_t> FrameReader::Prepare() {
  ENAMEL_CHECK(!done_ && !refused_);
  if (header_have_ < header_.size()) return std::span(header_).subspan(header_have_);
  size_t step = std::min(kStep, size_ - have_);
  message_.resize(have_ + step);
  return std::span(message_).last(step);
}

Status FrameReader::Resume(size_t n) {
  ENAMEL_CHECK(!done_ && !refused_);
  if (header_have_ < header_.size()) {
    ENAMEL_CHECK(n <= header_.size() - header_have_);
    header_have_ += n;
    if (header_have_ < header_.size()) return Status::Ok();
    size_ = ByteReader(header_).U32();
    refused_ = size_ > limit_;
    if (refused_) return TooLong(size_, limit_);
  } else {
    ENAMEL_CHECK(n <= message_.size() - have_);
    have_ += n;
  }
  // An empty message is done with its header's last byte.
  done_ = have_ == size_;
  return Status::Ok();
}

Bytes FrameReader::Take() {
  ENAMEL_CHECK(done_);
  done_ = false;
  header_have_ = size_ = have_ = 0;
  Bytes out;
  out.swap(message_);
  return out;
}

}  // namespace enamel::protocol

#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "common/base/bytes.h"
#include "common/base/result.h"

// Framing of the station link (schemas/wire/README.md, "Frames"): u32 little-endian length of the
// message, then the message. No I/O here: both ends and the fuzzer drive the same code.
namespace enamel::protocol {

inline constexpr size_t kMaxFrameBytes = size_t{4} << 20;
// The limit for a peer that has not identified itself yet.
inline constexpr size_t kMaxFrameBytesBeforeHello = size_t{16} << 10;

// Length and message as one byte string. Errors: kTooLarge over kMaxFrameBytes.
Result<Bytes> EncodeFrame(ByteView message);

// Splits a stream into messages, whatever pieces it arrives in:
//    while (!reader.done()) { n = read(reader.Prepare()); status = reader.Resume(n); }
//    message = reader.Take();
// Memory is bounded by the bytes received plus 64 KiB, not by the announced length. A length over
// the limit is refused when its last byte arrives; the connection cannot be used after that. Thread
// safety: none.
class FrameReader {
 public:
  explicit FrameReader(size_t limit = kMaxFrameBytes) : limit_(limit) {}

  // Holds from the next frame on.
  void set_limit(size_t limit) { limit_ = limit; }
  // Where the next bytes belong; never asks for a byte of the following frame. Not empty. Valid
  // until Resume. Requires: !done().
  std::span<uint8_t> Prepare();
  // `n` bytes of the prepared space were filled. Errors: kTooLarge (for good).
  // Requires: n <= Prepare().size().
  Status Resume(size_t n);
  // The size that the coming message announces; 0 until its length has come.
  size_t announced() const { return header_have_ < header_.size() ? 0 : size_; }
  // A whole message is here (it may be empty).
  bool done() const { return done_; }
  // The message; the reader begins the next frame. Requires: done().
  Bytes Take();
  // Nothing of a frame has arrived: where a stream may end cleanly.
  bool at_boundary() const { return !done_ && header_have_ == 0; }

 private:
  size_t limit_;
  std::array<uint8_t, 4> header_{};
  size_t header_have_ = 0;
  size_t size_ = 0;  // of the message, once the header is whole
  size_t have_ = 0;  // bytes of it that have arrived
  Bytes message_;
  bool done_ = false;
  bool refused_ = false;
};

}  // namespace enamel::protocol

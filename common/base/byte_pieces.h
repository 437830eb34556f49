#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

#include "common/base/bytes.h"
#include "common/base/result.h"

namespace enamel {

// Content that is read piece by piece, because all of it may be larger than memory. Thread safety:
// one thread at a time.
struct BytePieces {
  uint64_t size = 0;  // of all pieces
  size_t held = 0;    // memory that it takes until it is read
  // Empty: that was all. May block.
  std::function<Result<Bytes>()> next;
};

inline BytePieces InOnePiece(Bytes bytes) {
  auto left = std::make_shared<Bytes>(std::move(bytes));
  const size_t size = left->size();
  return {size, size, [left]() -> Result<Bytes> { return std::exchange(*left, {}); }};
}

inline Result<BytePieces> InOnePiece(Result<Bytes> bytes) {
  ENAMEL_RETURN_IF_ERROR(bytes.status());
  return InOnePiece(std::move(bytes).value());
}

// For content that is small. Errors: what `next` returns.
inline Result<Bytes> AllOf(const BytePieces& content) {
  Bytes out;
  for (;;) {
    ENAMEL_ASSIGN_OR_RETURN(const Bytes piece, content.next());
    if (piece.empty()) return out;
    out.insert(out.end(), piece.begin(), piece.end());
  }
}

}  // namespace enamel

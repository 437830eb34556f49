#include "server/http/tar.h"

#include <algorithm>
#include <array>
#include <deque>
#include <iterator>
#include <memory>
#include <utility>

#include "common/base/check.h"

namespace enamel::server::http {
namespace {

constexpr size_t kTarBlock = 512, kLongestName = 100;
constexpr uint64_t kTarMaxSize = uint64_t{1} << 33;
// Where the header's fields are, and how long.
struct Field {
  size_t at, size;
};
constexpr Field kMode{100, 8}, kUser{108, 8}, kGroup{116, 8}, kSize{124, 12}, kTime{136, 12},
    kSum{148, 8};
constexpr size_t kType = 156, kMagic = 257;

using TarHeader = std::array<char, kTarBlock>;

// Octal digits that fill the field but for a 0 at its end.
void Put(TarHeader& header, const Field& field, uint64_t value) {
  for (size_t i = field.size - 1; i-- > 0; value /= 8) {
    header[field.at + i] = static_cast<char>('0' + value % 8);
  }
}

}  // namespace

void Tar::Add(std::string_view name, BytePieces content) {
  ENAMEL_CHECK(!name.empty() && name.size() <= kLongestName &&
               name.find('/') == std::string_view::npos);
  ENAMEL_CHECK(content.size < kTarMaxSize);
  TarHeader header{};
  std::ranges::copy(name, header.begin());
  Put(header, kMode, 0644);
  Put(header, kUser, 0);
  Put(header, kGroup, 0);
  Put(header, kSize, content.size);
  Put(header, kTime, static_cast<uint64_t>(std::max<int64_t>(0, unix_s_)));
  header[kType] = '0';  // a plain file
  std::ranges::copy(std::string_view("ustar\00000", 8), header.begin() + kMagic);
  // The sum is taken with spaces in its own place.
  std::fill_n(header.begin() + kSum.at, kSum.size, ' ');
  uint64_t sum = 0;
  for (char c : header) sum += static_cast<uint8_t>(c);
  Put(header, {kSum.at, kSum.size - 1}, sum);
  header[kSum.at + kSum.size - 2] = 0;
  parts_.push_back(InOnePiece(Bytes(header.begin(), header.end())));
  const size_t filled = content.size % kTarBlock;
  parts_.push_back(std::move(content));
  if (filled > 0) parts_.push_back(InOnePiece(Bytes(kTarBlock - filled)));
}

BytePieces Tar::Take() {
  parts_.push_back(InOnePiece(Bytes(2 * kTarBlock)));
  BytePieces out;
  for (const BytePieces& part : parts_) {
    out.size += part.size;
    out.held += part.held;
  }
  auto left = std::make_shared<std::deque<BytePieces>>(std::make_move_iterator(parts_.begin()),
                                                       std::make_move_iterator(parts_.end()));
  out.next = [left]() -> Result<Bytes> {
    while (!left->empty()) {
      BytePieces& part = left->front();
      ENAMEL_ASSIGN_OR_RETURN(Bytes piece, part.next());
      if (piece.size() > part.size || (piece.empty() && part.size > 0)) {
        return Status(Code::kStorage, "a file of the archive is not as long as it was said to be");
      }
      part.size -= piece.size();
      if (part.size == 0) left->pop_front();
      if (!piece.empty()) return piece;
    }
    return Bytes();
  };
  return out;
}

}  // namespace enamel::server::http

#include "server/http/paging.h"

#include "common/base/hex.h"
#include "server/http/query.h"

namespace enamel::server::http {
namespace {

constexpr size_t kMaxCursor = 1024;

}  // namespace

Result<Page> PageOf(const Request& request, uint32_t otherwise, uint32_t at_most) {
  Page out;
  ENAMEL_ASSIGN_OR_RETURN(uint32_t limit, QueryLimit(request, otherwise, at_most));
  out.limit = limit;
  auto given = request.query.find("cursor");
  if (given == request.query.end()) return out;
  // In hexadecimal because a key may be a name, with any letters. It is no secret: it names a place
  // in a list that the caller may see.
  Result<Bytes> key = given->second.size() <= kMaxCursor
                          ? FromHex(given->second)
                          : Result<Bytes>(Status(Code::kTooLarge, ""));
  if (!key.ok() || key->empty()) {
    return Status{Code::kInvalidInput, "expected the `next` of the page before", "cursor"};
  }
  out.after = std::string(AsText(*key));
  return out;
}

boost::json::value NextAfter(const std::string& key) {
  return boost::json::value(ToHex(AsBytes(key)));
}

std::string RisingKey(uint64_t number) {
  // The digits of 2^64 - 1: with zeros in front, order as text is order as number.
  constexpr size_t kDigits = 20;
  std::string text = std::to_string(number);
  return std::string(kDigits - text.size(), '0') + text;
}

std::string FallingKey(uint64_t number) { return RisingKey(UINT64_MAX - number); }

}  // namespace enamel::server::http

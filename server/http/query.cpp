#include "server/http/query.h"

#include <charconv>

namespace enamel::server::http {

Result<std::optional<Uuid>> QueryId(const Request& request, const char* name) {
  auto found = request.query.find(name);
  if (found == request.query.end()) return std::optional<Uuid>();
  Result<Uuid> id = Uuid::Parse(found->second);
  if (!id.ok()) return Status{Code::kInvalidInput, "expected a UUID", name};
  return std::optional<Uuid>(*id);
}

Result<std::optional<bool>> QueryFlag(const Request& request, const char* name) {
  auto found = request.query.find(name);
  if (found == request.query.end()) return std::optional<bool>();
  if (found->second == "true") return std::optional<bool>(true);
  if (found->second == "false") return std::optional<bool>(false);
  return Status{Code::kInvalidInput, "expected true or false, found \"" + found->second + "\"",
                name};
}

Result<uint64_t> QueryOffset(const Request& request, const char* name) {
  auto found = request.query.find(name);
  if (found == request.query.end()) return uint64_t{0};
  const std::string& text = found->second;
  uint64_t offset = 0;
  auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), offset);
  if (error == std::errc() && end == text.data() + text.size()) return offset;
  return Status{Code::kInvalidInput,
                "expected a whole number from 0, found \"" + text.substr(0, 80) + "\"", name};
}

Result<uint32_t> QueryLimit(const Request& request, uint32_t otherwise, uint32_t at_most) {
  auto found = request.query.find("limit");
  if (found == request.query.end()) return otherwise;
  const std::string& text = found->second;
  uint32_t limit = 0;
  // from_chars takes neither sign nor space nor locale. A limit beyond the most is refused and not
  // cut, so that nobody takes a part for the whole.
  auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), limit);
  if (error != std::errc() || end != text.data() + text.size() || limit < 1 || limit > at_most) {
    return Status{Code::kInvalidInput,
                  "expected a number from 1 to " + std::to_string(at_most) + ", found \"" +
                      text.substr(0, 80) + "\"",
                  "limit"};
  }
  return limit;
}

}  // namespace enamel::server::http

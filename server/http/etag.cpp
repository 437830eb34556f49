#include "server/http/etag.h"

#include <boost/json.hpp>
#include <charconv>
#include <string_view>
#include <utility>

namespace enamel::server::http {
namespace json = boost::json;

std::string ETagOf(int32_t revision) { return '"' + std::to_string(revision) + '"'; }

Response WithETag(Response response, int32_t revision) {
  response.headers.emplace_back("ETag", ETagOf(revision));
  return response;
}

Result<int32_t> IfMatch(const Request& request) {
  std::string_view text = request.Header("if-match");
  if (text.empty()) {
    return Status{Code::kInvalidInput,
                  "expected the ETag of what is to be changed in the header If-Match; get it first",
                  "if-match"};
  }
  if (text.size() < 3 || text.front() != '"' || text.back() != '"') return int32_t{0};
  text = text.substr(1, text.size() - 2);
  int32_t revision = 0;
  auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), revision);
  bool whole = error == std::errc() && end == text.data() + text.size() && text.front() != '0';
  return whole && revision > 0 ? revision : 0;
}

Response Stale(const Status& status, json::object current, int32_t current_revision) {
  Response response;
  response.status = 412;
  response.content_type = "application/json";
  response.body = json::serialize(json::object{
      {"error",
       {{"code", "precondition_failed"}, {"message", status.message()}, {"field", "if-match"}}},
      {"current", std::move(current)}});
  return WithETag(std::move(response), current_revision);
}

}  // namespace enamel::server::http

#include "server/http/etag.h"

#include <boost/json.hpp>
#include <charconv>
#include <string_view>
#include <utility>

namespace enamel::server::http {
namespace json = boost::json;
namespace {

// A proxy that compresses an answer changes its tag: nginx and HAProxy make it weak (W/"7"), Apache
// and Caddy name the coding in it ("7-gzip"). The revision is the same: it counts changes of the
// thing and not of its bytes. RFC 9110, 13.1.1, matches no weak tag: nobody behind
// a compressing proxy could edit.
std::string_view RevisionIn(std::string_view tag) {
  constexpr std::string_view kWeak = "W/";
  if (tag.starts_with(kWeak)) tag.remove_prefix(kWeak.size());
  if (tag.size() < 3 || tag.front() != '"' || tag.back() != '"') return {};
  tag = tag.substr(1, tag.size() - 2);
  for (std::string_view coding : {"-gzip", "-deflate", "-br", "-zstd"}) {
    if (tag.ends_with(coding)) return tag.substr(0, tag.size() - coding.size());
  }
  return tag;
}

}  // namespace

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
  int32_t revision = 0;
  // One tag: a list or `*` would match a revision that the caller never saw, which is what the
  // header is here to rule out.
  const std::string_view digits = RevisionIn(text);
  auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), revision);
  bool whole = error == std::errc() && end == digits.data() + digits.size();
  // One spelling for each revision, so that "07" does not match an issued "7".
  if (whole && revision > 0 && digits.front() != '0') return revision;
  return Status{
      Code::kInvalidInput,
      "expected one ETag in If-Match as it was given, such as \"7\" with its quotes, found " +
          std::string(text.substr(0, 80)),
      "if-match"};
}

Response Stale(const Status& status, json::object current, int32_t current_revision) {
  Response response;
  // With the thing as it is now: whoever was too late can show both versions without asking again.
  response.status = 412;
  response.content_type = "application/json";
  response.body = json::serialize(json::object{
      {"error",
       {{"code", "precondition_failed"}, {"message", status.message()}, {"field", "if-match"}}},
      {"current", std::move(current)}});
  return WithETag(std::move(response), current_revision);
}

}  // namespace enamel::server::http

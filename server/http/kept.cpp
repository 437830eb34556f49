#include "server/http/kept.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

#include "common/timeline/deflate.h"
#include "server/http/error_response.h"
#include "server/http/static_files.h"

namespace enamel::server::http {
namespace {

std::optional<size_t> Number(std::string_view text) {
  size_t value = 0;
  auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// From the first byte to behind the last, of `size`; empty when it is beyond the end.
struct Range {
  size_t from = 0, to = 0;
};

// None: no single range of bytes.
std::optional<Range> RangeOf(std::string_view header, size_t size) {
  constexpr std::string_view kUnit = "bytes=";
  if (!header.starts_with(kUnit)) return std::nullopt;
  header.remove_prefix(kUnit.size());
  const size_t dash = header.find('-');
  if (dash == std::string_view::npos) return std::nullopt;
  const std::string_view first = header.substr(0, dash), last = header.substr(dash + 1);
  if (first.empty()) {
    const std::optional<size_t> count = Number(last);
    if (!count) return std::nullopt;
    return Range{size - std::min(*count, size), *count == 0 ? 0 : size};
  }
  const std::optional<size_t> from = Number(first);
  if (!from) return std::nullopt;
  if (last.empty()) return Range{*from, size};
  const std::optional<size_t> to = Number(last);
  if (!to || *to < *from) return std::nullopt;
  return Range{*from, *to < size ? *to + 1 : size};
}

Response BeyondTheEnd(size_t size) {
  Response response = ErrorResponse(
      416, "invalid_input",
      "expected a range within the " + std::to_string(size) + " bytes there are", "range");
  response.headers.emplace_back("Content-Range", "bytes */" + std::to_string(size));
  return response;
}

constexpr size_t kWorthPacking = 1000;

}  // namespace

Response Packed(const Request& request, Response response) {
  if (response.content_type != "application/json") return response;
  response.headers.emplace_back("Vary", "Accept-Encoding");
  const std::string_view body = response.Body();
  if (body.size() < kWorthPacking || !Accepts(request.Header("accept-encoding"), "deflate")) {
    return response;
  }
  response.body = AsText(timeline::Deflate(AsBytes(body)));
  response.shared_body = nullptr;
  response.headers.emplace_back("Content-Encoding", "deflate");
  return response;
}

Response KeptResponse(const Request& request, const Kept& kept, SharedBodies& bodies,
                      const SharedBodies::Read& read) {
  // 128 bits: nobody has two that agree in them by chance.
  const std::string tag = '"' + kept.content.Hex().substr(0, 32) + '"';
  Response response;
  if (!kept.cache_control.empty()) {
    response.headers.emplace_back("Cache-Control", kept.cache_control);
  }
  response.headers.emplace_back("ETag", tag);
  if (request.Header("if-none-match").find(tag) != std::string_view::npos) {
    response.status = 304;
    return response;
  }
  const auto body = kept.made ? bodies.Made(kept.content, read) : bodies.Get(kept.content, read);
  if (kept.made && body.status().code() == Code::kUnavailable) return ErrorResponse(body.status());
  // The row names a missing blob: damage of ours, not a wrong address.
  if (!body.ok()) return ErrorResponse(Status{Code::kInternal, body.status().message()});
  const std::string_view all = **body;
  response.shared_body = *body;
  response.content_type = kept.content_type;
  response.headers.emplace_back("Accept-Ranges", "bytes");
  const std::string_view same = request.Header("if-range");
  std::optional<Range> range;
  if (same.empty() || same == tag) range = RangeOf(request.Header("range"), all.size());
  if (!range) return Packed(request, std::move(response));
  if (range->from >= range->to) return BeyondTheEnd(all.size());
  response.status = 206;
  response.headers.emplace_back("Content-Range", "bytes " + std::to_string(range->from) + "-" +
                                                     std::to_string(range->to - 1) + "/" +
                                                     std::to_string(all.size()));
  response.from = range->from;
  response.size = range->to - range->from;
  return response;
}

}  // namespace enamel::server::http

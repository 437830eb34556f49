#include "server/http/wire/request_reader.h"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/beast/core/string.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/url/parse.hpp>
#include <boost/url/url_view.hpp>
#include <functional>
#include <string>

#include "server/http/error_response.h"
#include "server/http/wire/request_head.h"

namespace enamel::server::http {
namespace asio = boost::asio;
namespace beast = boost::beast;
namespace bhttp = boost::beast::http;

namespace {

Method MethodOf(bhttp::verb verb) {
  switch (verb) {
    case bhttp::verb::get:
      return Method::kGet;
    case bhttp::verb::head:
      return Method::kHead;
    case bhttp::verb::post:
      return Method::kPost;
    case bhttp::verb::put:
      return Method::kPut;
    case bhttp::verb::patch:
      return Method::kPatch;
    case bhttp::verb::delete_:
      return Method::kDelete;
    default:
      return Method::kOther;
  }
}

void TakeHeaders(const bhttp::request<bhttp::string_body>& message, Request& out) {
  for (const auto& field : message) {
    std::string name(field.name_string());
    std::transform(name.begin(), name.end(), name.begin(), [](char c) {
      return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
    std::string& value = out.headers[name];
    // A header that comes twice is a list (RFC 9110, 5.3), a cookie's with its own separator (RFC
    // 6265). Those that frame the request came once: CheckRequestHead saw to it.
    if (!value.empty()) value += name == "cookie" ? "; " : ", ";
    value += std::string_view(field.value().data(), field.value().size());
  }
}

bool IsHex(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
}

// Percent-encodes what the URL standard's browsers encode and RFC 3986 does not allow.
std::string Encoded(std::string_view target) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  constexpr std::string_view kForbidden = "\"#<>[\\]^`{|}";
  std::string out;
  for (size_t i = 0; i < target.size(); ++i) {
    const char c = target[i];
    bool escape = c == '%' && i + 2 < target.size() && IsHex(target[i + 1]) && IsHex(target[i + 2]);
    bool allowed = c == '%' ? escape
                            : static_cast<unsigned char>(c) < 0x80 &&
                                  kForbidden.find(c) == std::string_view::npos;
    if (allowed) {
      out += c;
    } else {
      out += '%';
      out += kDigits[static_cast<unsigned char>(c) >> 4];
      out += kDigits[static_cast<unsigned char>(c) & 15];
    }
  }
  return out;
}

// Path and query of an absolute target (RFC 9112 section 3.2.2), which the head's check compared
// with Host.
std::string_view WithoutAuthority(std::string_view target) {
  size_t scheme = target.starts_with('/') ? std::string_view::npos : target.find("://");
  if (scheme == std::string_view::npos) return target;
  size_t end = target.find_first_of("/?#", scheme + 3);
  return end == std::string_view::npos ? std::string_view() : target.substr(end);
}

// Path and decoded query. Errors: kInvalidInput.
Status TakeTarget(std::string_view target, Request& request) {
  if (target == "*") {
    request.path = target;
    return {};
  }
  std::string encoded = Encoded(WithoutAuthority(target));
  if (!encoded.starts_with('/')) encoded.insert(0, "/");
  auto url = boost::urls::parse_origin_form(encoded);
  if (url.has_error()) {
    return {Code::kInvalidInput, "expected a percent-encoded path and query", "request line"};
  }
  auto path = url->encoded_path();
  request.path.assign(path.data(), path.size());
  for (const auto& param : url->params()) request.query[param.key] = param.value;
  return {};
}

Response HeadRefusal(const Status& status) {
  if (status.code() != Code::kVersion) return ErrorResponse(status);
  if (status.field() == "request line") {
    return ErrorResponse(505, "version", status.message(), status.field());
  }
  if (status.field() == "content-encoding") {
    return ErrorResponse(415, "unsupported_media_type", status.message(), status.field());
  }
  return ErrorResponse(501, "not_implemented", status.message(), status.field());
}

Response BodyRefusal(const beast::error_code& error) {
  if (error == bhttp::error::body_limit) {
    return ErrorResponse({Code::kTooLarge, "expected a body of at most 1 MiB", "body"});
  }
  return ErrorResponse(
      {Code::kInvalidInput, "expected a well-formed body: " + error.message(), "body"});
}

}  // namespace

// Takes what Beast lets through between the quotes of a chunk's extension: line ends, say.
struct RequestReader::Parser : bhttp::request_parser<bhttp::string_body> {
  Parser() { on_chunk_header(check_); }

 private:
  static constexpr size_t kMaxExtensionBytes = 1024;
  std::function<void(uint64_t, beast::string_view, beast::error_code&)> check_ =
      [](uint64_t, beast::string_view extension, beast::error_code& error) {
        bool printable = std::all_of(extension.begin(), extension.end(), [](char c) {
          return c == '\t' || (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f);
        });
        if (!printable || extension.size() > kMaxExtensionBytes) {
          error = bhttp::error::bad_chunk_extension;
        }
      };
};

RequestReader::RequestReader() = default;
RequestReader::~RequestReader() = default;

bool RequestReader::in_head() const { return parser_ == nullptr; }

size_t RequestReader::expected_bytes() const {
  const auto length = parser_->content_length();
  return static_cast<size_t>(std::min<uint64_t>(length ? *length : kMaxBodyBytes, kMaxBodyBytes));
}

void RequestReader::RefuseForNow(const Status& why) {
  parser_.reset();
  refusal_ = ErrorResponse(why);
}

RequestReader::Step RequestReader::Refuse(Response refusal) {
  refusal_ = std::move(refusal);
  return Step::kRefused;
}

RequestReader::Step RequestReader::Feed(std::string_view bytes, size_t& used) {
  used = 0;
  if (in_head()) {
    if (searched_ < kLongestOpening) {
      const Status spoken = NotAnotherProtocol(bytes);
      if (!spoken.ok()) return Refuse(ErrorResponse(spoken));
    }
    // From where the last search ended, so that a head that comes byte by byte is not searched
    // quadratically.
    size_t end = FindHeadEnd(bytes, searched_);
    searched_ = bytes.size();
    if (std::min(end, bytes.size()) >= kMaxHeadBytes) {
      return Refuse(ErrorResponse(
          431, "too_large", "expected a request line and headers of less than 16 KiB", "header"));
    }
    if (end == std::string_view::npos) return Step::kMore;
    if (Step step = TakeHead(bytes.substr(0, end)); step != Step::kMore) return step;
    used = end;
  }
  size_t of_body = 0;
  Step step = TakeBody(bytes.substr(used), of_body);
  used += of_body;
  return step;
}

RequestReader::Step RequestReader::TakeHead(std::string_view head) {
  // Ours before Beast's: it is stricter, and what Beast would read leniently never reaches it.
  if (Status valid = CheckRequestHead(head); !valid.ok()) return Refuse(HeadRefusal(valid));
  parser_ = std::make_unique<Parser>();
  parser_->header_limit(kMaxHeadBytes);
  parser_->body_limit(kMaxBodyBytes);
  parser_->eager(true);
  beast::error_code error;
  parser_->put(asio::buffer(head.data(), head.size()), error);
  if (error && error != bhttp::error::need_more) return Refuse(BodyRefusal(error));
  const auto& message = parser_->get();
  request_.method = MethodOf(message.method());
  TakeHeaders(message, request_);
  // HTTP/1.0 clients get one answer: its keep-alive was never agreed on.
  keep_alive_ = message.version() == 11 && message.keep_alive();
  wants_continue_ = beast::iequals(message[bhttp::field::expect], "100-continue");
  auto target = message.target();
  Status valid = TakeTarget({target.data(), target.size()}, request_);
  return valid.ok() ? Step::kMore : Refuse(HeadRefusal(valid));
}

RequestReader::Step RequestReader::TakeBody(std::string_view bytes, size_t& used) {
  beast::error_code error;
  if (!parser_->is_done() && !bytes.empty()) {
    used = parser_->put(asio::buffer(bytes.data(), bytes.size()), error);
    if (error && error != bhttp::error::need_more) return Refuse(BodyRefusal(error));
  }
  // Beast bounds the body alone. Chunks of one byte each, with extensions, would be a long way to a
  // small body.
  body_wire_bytes_ += used;
  if (body_wire_bytes_ > kMaxBodyWireBytes) return Refuse(BodyRefusal(bhttp::error::body_limit));
  if (parser_->is_done()) {
    request_.body = std::move(parser_->get().body());
    return Step::kRequest;
  }
  // The parser took nothing of it: a chunk's head or a trailer that has not ended yet.
  if (bytes.size() - used >= kMaxHeadBytes) {
    return Refuse(ErrorResponse({Code::kTooLarge,
                                 "expected chunk sizes with extensions, and trailers, of less "
                                 "than 16 KiB",
                                 "body"}));
  }
  return std::exchange(wants_continue_, false) ? Step::kContinue : Step::kMore;
}

}  // namespace enamel::server::http

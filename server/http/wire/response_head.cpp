#include "server/http/wire/response_head.h"

#include <spdlog/spdlog.h>

#include <boost/beast/http/status.hpp>
#include <string_view>

namespace enamel::server::http {

namespace {

void Append(std::string& out, std::string_view name, std::string_view value) {
  constexpr std::string_view kEnds("\r\n\0", 3);
  if (name.find_first_of(kEnds) != name.npos || value.find_first_of(kEnds) != value.npos) {
    spdlog::error("http: left out a header of {} bytes: it holds a line end",
                  name.size() + value.size());
    return;
  }
  out.append(name).append(": ").append(value).append("\r\n");
}

}  // namespace

std::string HeadText(const Response& response, bool keep_alive, std::optional<size_t> length) {
  namespace bhttp = boost::beast::http;
  const auto status = static_cast<unsigned>(response.status);
  std::string out = "HTTP/1.1 " + std::to_string(status) + " ";
  out += bhttp::obsolete_reason(bhttp::int_to_status(status));
  out += "\r\n";
  for (const auto& [name, value] : response.headers) Append(out, name, value);
  if (!response.content_type.empty()) Append(out, "Content-Type", response.content_type);
  if (!keep_alive) Append(out, "Connection", "close");
  if (length) Append(out, "Content-Length", std::to_string(*length));
  return out += "\r\n";
}

}  // namespace enamel::server::http

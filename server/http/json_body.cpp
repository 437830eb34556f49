#include "server/http/json_body.h"

#include <algorithm>

#include "server/http/error_response.h"

namespace enamel::server::http {
namespace json = boost::json;

Response JsonResponse(const json::object& object, int status) {
  Response response;
  response.status = status;
  response.content_type = "application/json";
  response.body = json::serialize(object);
  return response;
}

Result<json::object> TextMembers(const Request& request,
                                 std::initializer_list<TextMember> members) {
  json::parse_options options;
  options.max_depth = 4;
  json::error_code error;
  json::value value = json::parse(request.body, error, {}, options);
  if (error || !value.is_object()) {
    return Status{Code::kInvalidInput, "expected a JSON object as body", "body"};
  }
  json::object& object = value.get_object();
  for (const TextMember& member : members) {
    const json::value* found = object.if_contains(member.name);
    if (!found || !found->is_string() || found->get_string().empty() ||
        found->get_string().size() > member.max_length) {
      return Status{Code::kInvalidInput,
                    "expected " + std::string(member.name) + " as text of 1 to " +
                        std::to_string(member.max_length) + " bytes",
                    std::string(member.name)};
    }
  }
  for (const auto& entry : object) {
    bool known = std::any_of(members.begin(), members.end(),
                             [&](const TextMember& member) { return member.name == entry.key(); });
    if (!known) {
      return Status{Code::kInvalidInput, "expected no member of this name",
                    std::string(entry.key())};
    }
  }
  return std::move(object);
}

bool IsJson(const Request& request) {
  std::string type(request.Header("content-type"));
  type = type.substr(0, type.find(';'));
  type.erase(std::remove(type.begin(), type.end(), ' '), type.end());
  return type == "application/json";
}

Response NotJson() {
  return ErrorResponse(415, "unsupported_media_type", "expected Content-Type: application/json",
                       "content-type");
}

}  // namespace enamel::server::http

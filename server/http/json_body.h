#pragma once

#include <boost/json.hpp>
#include <initializer_list>
#include <string>
#include <string_view>

#include "common/base/result.h"
#include "server/http/message.h"

// JSON in and out of messages.
namespace enamel::server::http {

Response JsonResponse(const boost::json::object& object, int status = 200);

// The body as an object with exactly these members, each a string of 1..max_length bytes.
struct TextMember {
  std::string_view name;
  size_t max_length;
};
// Errors: kInvalidInput with the member in field(). Requires: Content-Type was checked (IsJson).
Result<boost::json::object> TextMembers(const Request& request,
                                        std::initializer_list<TextMember> members);
// False unless the Content-Type is application/json: a form of another site cannot send that.
bool IsJson(const Request& request);
Response NotJson();

}  // namespace enamel::server::http

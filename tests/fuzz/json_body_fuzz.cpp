#include "common/base/check.h"
#include "server/http/json_body.h"

namespace {

// Each name and each text has two; inside texts they follow a backslash.
size_t Quotes(const std::string& json) {
  size_t out = 0;
  for (size_t i = 0; i < json.size(); ++i) {
    if (json[i] == '\\') {
      ++i;
    } else if (json[i] == '"') {
      ++out;
    }
  }
  return out;
}

}  // namespace

// Any bytes as the body of a request of the API: refused with a reason, or exactly the requested
// texts, each once, within their lengths, which read back from the JSON they make.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace enamel;
  using namespace enamel::server::http;
  Request request;
  request.body.assign(reinterpret_cast<const char*>(data), size);
  auto members = TextMembers(request, {{"login", 64}, {"password", 1024}});
  if (!members.ok()) {
    ENAMEL_CHECK(!members.status().message().empty());
    return 0;
  }
  ENAMEL_CHECK(members->size() == 2);
  ENAMEL_CHECK(Quotes(request.body) == 8);  // nothing stood there twice
  ENAMEL_CHECK(members->at("login").as_string().size() <= 64);
  request.body = JsonResponse(*members).body;
  auto again = TextMembers(request, {{"login", 64}, {"password", 1024}});
  ENAMEL_CHECK(again.ok() && *again == *members);
  return 0;
}

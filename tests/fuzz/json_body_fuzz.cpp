#include "common/base/check.h"
#include "server/http/json_body.h"

// Any bytes as the body of a request of the API: refused with a reason, or exactly the texts that
// were asked for, within their lengths, which read back from the JSON they make.
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
  ENAMEL_CHECK(members->at("login").as_string().size() <= 64);
  request.body = JsonResponse(*members).body;
  auto again = TextMembers(request, {{"login", 64}, {"password", 1024}});
  ENAMEL_CHECK(again.ok() && *again == *members);
  return 0;
}

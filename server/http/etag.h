#pragma once

#include <boost/json/object.hpp>
#include <cstdint>
#include <string>

#include "common/base/result.h"
#include "server/http/message.h"

// Editing what somebody else may be editing too (RFC 9110, section 8.8.3 and 13.1.1): whoever reads
// a thing gets its revision as ETag, whoever changes it sends that back as If-Match. The store
// compares it inside the transaction that makes the change (server/training/revision.h). Pure
// functions.
//
//   GET                                   PATCH
//   JsonResponse(thing)  + WithETag   ──▶   IfMatch(request) ─▶ store ─▶ WithETag, or Stale
namespace enamel::server::http {

// Strong: "\"7\"".
std::string ETagOf(int32_t revision);
Response WithETag(Response response, int32_t revision);

// The revision that the caller has seen, also from a tag that a compressing proxy changed. Errors:
// kInvalidInput with field "if-match" (HTTP 428) when the header is missing, or is no ETag of ours.
Result<int32_t> IfMatch(const Request& request);

// 412 "precondition_failed", with the thing as it is now in "current" and its ETag.
Response Stale(const Status& status, boost::json::object current, int32_t current_revision);

}  // namespace enamel::server::http

#pragma once

#include <string>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "server/http/message.h"
#include "server/http/shared_bodies.h"

// Answers with content that never changes under its hash: whole, in parts, or not at all if the
// caller has it (RFC 9110, sections 13 and 14). Pure functions.
namespace enamel::server::http {

struct Kept {
  Sha256 content;  // its name, and so its ETag
  std::string content_type;
  std::string cache_control;  // empty: the site's, which is not to keep it
  bool made = false;          // on request, and worth keeping in memory (SharedBodies::Made)
};

// JSON, packed by the coding "deflate" where the caller takes it and that is worth it. Not for an
// answer that holds a secret beside what somebody else may write: its length would give it away.
Response Packed(const Request& request, Response response);

// Packed where it is JSON. 200 with all of it; 206 with the one requested range; 416 for a range
// beyond its end; 304 when If-None-Match names it. Several ranges, an invalid range, and one under an If-Range that names
// something else give all of it, as RFC 9110 allows. `read` is not called for a 304; its failure is
// damage of ours, a 500. A body that the server makes on request is a 503 when its turn does not come.
Response KeptResponse(const Request& request, const Kept& kept, SharedBodies& bodies,
                      const SharedBodies::Read& read);

}  // namespace enamel::server::http

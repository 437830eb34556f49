#pragma once

#include <boost/json/object.hpp>

#include "server/http/routes.h"

// People and their sessions as admins see them (schemas PersonDetail and SessionEntry).
namespace enamel::server::http {

boost::json::object PersonJson(const Person& person);
// The sessions of a person, a page of them, the caller's own marked.
Result<Response> SessionsResponse(const Call& call, SessionRows& sessions_rows, const Uuid& person);

}  // namespace enamel::server::http

#pragma once

#include <boost/asio/awaitable.hpp>

#include "server/http/routes.h"

// The handlers of the route table, by subject: *_handlers.cpp. They trust the table for session,
// role and CSRF, and decide themselves whose data the caller may see.
namespace enamel::server::http {

Response GetHealth(const Call& call);
Response GetMetrics(const Call& call);

boost::asio::awaitable<Response> SignIn(Call call);
Response GetSession(const Call& call);
Response SignOut(const Call& call);

Response ListExercises(const Call& call);
Response GetExercise(const Call& call);
Response ListProfiles(const Call& call);

Response ListAttempts(const Call& call);
Response GetAttempt(const Call& call);
Response GetScore(const Call& call);
Response GetSurface(const Call& call);
Response GetSeries(const Call& call);
Response GetLive(const Call& call);
Response ReleaseAttempt(const Call& call);
Response MakeReference(const Call& call);

Response ListCohorts(const Call& call);
Response ListStations(const Call& call);
Response ListAudit(const Call& call);
Response ListJobs(const Call& call);

}  // namespace enamel::server::http

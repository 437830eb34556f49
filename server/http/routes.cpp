#include "server/http/routes.h"

#include <array>

#include "server/http/handlers.h"

namespace enamel::server::http {
namespace {

const std::array kRoutes = {
    Route{Method::kGet, "/healthz", Need::kNobody, &GetHealth},
    Route{Method::kGet, "/metrics", Need::kNobody, &GetMetrics},
    Route{Method::kPost, "/api/v1/session", Need::kNobody, &SignIn},
    Route{Method::kGet, "/api/v1/session", Need::kPerson, &GetSession},
    Route{Method::kDelete, "/api/v1/session", Need::kPerson, &SignOut},
    Route{Method::kGet, "/api/v1/exercises", Need::kPerson, &ListExercises},
    Route{Method::kGet, "/api/v1/exercises/{id}", Need::kPerson, &GetExercise},
    Route{Method::kGet, "/api/v1/cohorts", Need::kInstructor, &ListCohorts},
    Route{Method::kGet, "/api/v1/attempts", Need::kPerson, &ListAttempts},
    Route{Method::kGet, "/api/v1/attempts/{id}", Need::kPerson, &GetAttempt},
    Route{Method::kGet, "/api/v1/attempts/{id}/score", Need::kPerson, &GetScore},
    Route{Method::kGet, "/api/v1/attempts/{id}/surface", Need::kPerson, &GetSurface},
    Route{Method::kGet, "/api/v1/attempts/{id}/series", Need::kPerson, &GetSeries},
    Route{Method::kGet, "/api/v1/attempts/{id}/live", Need::kInstructor, &GetLive},
    Route{Method::kPost, "/api/v1/attempts/{id}/release", Need::kInstructor, &ReleaseAttempt},
    Route{Method::kPost, "/api/v1/attempts/{id}/reference", Need::kInstructor, &MakeReference},
    Route{Method::kGet, "/api/v1/profiles", Need::kPerson, &ListProfiles},
    Route{Method::kGet, "/api/v1/stations", Need::kInstructor, &ListStations},
    Route{Method::kGet, "/api/v1/audit", Need::kAdmin, &ListAudit},
    Route{Method::kGet, "/api/v1/jobs", Need::kAdmin, &ListJobs},
};

// The text in the place of `{…}` (empty for a pattern without), none when the path does not match.
std::optional<std::string_view> Match(std::string_view pattern, std::string_view path) {
  size_t place = pattern.find('{');
  if (place == std::string_view::npos) {
    return pattern == path ? std::optional(std::string_view{}) : std::nullopt;
  }
  std::string_view before = pattern.substr(0, place);
  std::string_view after = pattern.substr(pattern.find('}') + 1);
  if (path.size() <= before.size() + after.size() || !path.starts_with(before) ||
      !path.ends_with(after)) {
    return std::nullopt;
  }
  std::string_view id = path.substr(before.size(), path.size() - before.size() - after.size());
  return id.find('/') == std::string_view::npos ? std::optional(id) : std::nullopt;
}

}  // namespace

std::span<const Route> Routes() { return kRoutes; }

RouteMatch FindRoute(Method method, std::string_view path) {
  Method wanted = method == Method::kHead ? Method::kGet : method;
  RouteMatch out;
  for (const Route& route : kRoutes) {
    std::optional<std::string_view> id = Match(route.pattern, path);
    if (!id) continue;
    if (!out.allowed_methods.empty()) out.allowed_methods += ", ";
    out.allowed_methods += MethodName(route.method);
    if (route.method == Method::kGet) out.allowed_methods += ", HEAD";
    if (route.method != wanted) continue;
    out.route = &route;
    out.id = *id;
  }
  return out;
}

}  // namespace enamel::server::http

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
    Route{Method::kPost, "/api/v1/session/confirm", Need::kPerson, &ConfirmSession},
    Route{Method::kPost, "/api/v1/session/password", Need::kPerson, &ChangePassword},
    Route{Method::kGet, "/api/v1/sessions", Need::kPerson, &ListSessions},
    Route{Method::kDelete, "/api/v1/sessions/{id}", Need::kPerson, &EndSession},
    Route{Method::kGet, "/api/v1/people", Need::kAdmin, &ListPeople},
    Route{Method::kPost, "/api/v1/people", Need::kAdmin, &AddPerson},
    Route{Method::kGet, "/api/v1/people/{id}", Need::kAdmin, &GetPerson},
    Route{Method::kPatch, "/api/v1/people/{id}", Need::kAdmin, &EditPerson},
    Route{Method::kPost, "/api/v1/people/{id}/password", Need::kAdmin, &ResetPassword},
    Route{Method::kPost, "/api/v1/people/{id}/erase", Need::kAdmin, &ErasePerson},
    Route{Method::kGet, "/api/v1/people/{id}/sessions", Need::kAdmin, &ListSessionsOf},
    Route{Method::kDelete, "/api/v1/people/{id}/sessions", Need::kAdmin, &EndSessionsOf},
    Route{Method::kPost, "/api/v1/roster", Need::kAdmin, &ImportRoster},
    Route{Method::kGet, "/api/v1/exercises", Need::kPerson, &ListExercises},
    Route{Method::kGet, "/api/v1/exercises/{id}", Need::kPerson, &GetExercise},
    Route{Method::kPost, "/api/v1/exercises", Need::kInstructor, &PutDraft},
    Route{Method::kPut, "/api/v1/exercises/{id}", Need::kInstructor, &ReplaceDraft},
    Route{Method::kDelete, "/api/v1/exercises/{id}", Need::kInstructor, &DeleteDraft},
    Route{Method::kGet, "/api/v1/exercises/{id}/document", Need::kPerson, &GetExerciseDocument},
    Route{Method::kGet, "/api/v1/exercises/{id}/initial-surface", Need::kPerson,
          &GetInitialSurface},
    Route{Method::kGet, "/api/v1/exercises/{id}/versions", Need::kPerson, &ListExerciseVersions},
    Route{Method::kGet, "/api/v1/exercises/{id}/references", Need::kPerson, &ListReferences},
    Route{Method::kPost, "/api/v1/exercises/{id}/publish", Need::kInstructor, &PublishDraft},
    Route{Method::kPost, "/api/v1/exercises/{id}/retire", Need::kInstructor, &RetireExercise},
    Route{Method::kPost, "/api/v1/references/{id}/withdraw", Need::kInstructor, &WithdrawReference},
    Route{Method::kGet, "/api/v1/assignments", Need::kPerson, &ListAssignments},
    Route{Method::kPost, "/api/v1/assignments", Need::kInstructor, &AddAssignment},
    Route{Method::kGet, "/api/v1/assignments/{id}", Need::kPerson, &GetAssignment},
    Route{Method::kPut, "/api/v1/assignments/{id}", Need::kInstructor, &ReplaceAssignment},
    Route{Method::kDelete, "/api/v1/assignments/{id}", Need::kInstructor, &DeleteAssignment},
    Route{Method::kPost, "/api/v1/assignments/{id}/release", Need::kInstructor, &ReleaseAssignment},
    Route{Method::kGet, "/api/v1/cohorts", Need::kInstructor, &ListCohorts},
    Route{Method::kPost, "/api/v1/cohorts", Need::kAdmin, &AddCohort},
    Route{Method::kGet, "/api/v1/cohorts/{id}", Need::kInstructor, &GetCohort},
    Route{Method::kPatch, "/api/v1/cohorts/{id}", Need::kAdmin, &EditCohort},
    Route{Method::kPost, "/api/v1/cohorts/{id}/members", Need::kAdmin, &ChangeMembers},
    Route{Method::kGet, "/api/v1/attempts", Need::kPerson, &ListAttempts},
    Route{Method::kGet, "/api/v1/attempts/{id}", Need::kPerson, &GetAttempt},
    Route{Method::kGet, "/api/v1/attempts/{id}/score", Need::kPerson, &GetScore},
    Route{Method::kGet, "/api/v1/attempts/{id}/surface", Need::kPerson, &GetSurface},
    Route{Method::kGet, "/api/v1/attempts/{id}/series", Need::kPerson, &GetSeries},
    Route{Method::kGet, "/api/v1/attempts/{id}/live", Need::kInstructor, &GetLive},
    Route{Method::kPost, "/api/v1/attempts/{id}/release", Need::kInstructor, &ReleaseAttempt},
    Route{Method::kPost, "/api/v1/attempts/{id}/reference", Need::kInstructor, &MakeReference},
    Route{Method::kDelete, "/api/v1/attempts/{id}/release", Need::kInstructor, &WithdrawRelease},
    Route{Method::kPut, "/api/v1/attempts/{id}/override", Need::kInstructor, &PutOverride},
    Route{Method::kDelete, "/api/v1/attempts/{id}/override", Need::kInstructor, &DeleteOverride},
    Route{Method::kPost, "/api/v1/attempts/{id}/rescore", Need::kInstructor, &Rescore},
    Route{Method::kPost, "/api/v1/attempts/{id}/excuse", Need::kInstructor, &Excuse},
    Route{Method::kGet, "/api/v1/attempts/{id}/results", Need::kPerson, &ListResults},
    Route{Method::kGet, "/api/v1/attempts/{id}/annotations", Need::kPerson, &ListAnnotations},
    Route{Method::kPost, "/api/v1/attempts/{id}/annotations", Need::kInstructor, &AddAnnotation},
    Route{Method::kPut, "/api/v1/annotations/{id}", Need::kInstructor, &ReplaceAnnotation},
    Route{Method::kDelete, "/api/v1/annotations/{id}", Need::kInstructor, &DeleteAnnotation},
    Route{Method::kPost, "/api/v1/attempts/{id}/appeal", Need::kPerson, &FileAppeal},
    Route{Method::kPost, "/api/v1/attempts/{id}/appeal/answer", Need::kInstructor, &AnswerAppeal},
    Route{Method::kGet, "/api/v1/profiles", Need::kPerson, &ListProfiles},
    Route{Method::kPost, "/api/v1/profiles", Need::kAdmin, &PutProfile},
    Route{Method::kGet, "/api/v1/profiles/{name}", Need::kPerson, &GetProfile},
    Route{Method::kGet, "/api/v1/profiles/{name}/versions", Need::kInstructor,
          &ListProfileVersions},
    Route{Method::kGet, "/api/v1/profiles/{name}/feel", Need::kPerson, &GetProfileFeel},
    Route{Method::kGet, "/api/v1/profiles/{name}/reports", Need::kInstructor, &ListProfileReports},
    Route{Method::kPost, "/api/v1/profiles/{name}/reports", Need::kAdmin, &AddProfileReport},
    Route{Method::kGet, "/api/v1/profile-reports/{id}", Need::kInstructor, &GetProfileReport},
    Route{Method::kGet, "/api/v1/profiles/{name}/calibrations", Need::kInstructor,
          &ListCalibrations},
    Route{Method::kPost, "/api/v1/profiles/{name}/calibrations", Need::kAdmin, &AddCalibration},
    Route{Method::kGet, "/api/v1/stations", Need::kInstructor, &ListStations},
    Route{Method::kGet, "/api/v1/stations/{id}", Need::kInstructor, &GetStation},
    Route{Method::kPatch, "/api/v1/stations/{id}", Need::kAdmin, &EditStation},
    Route{Method::kPost, "/api/v1/stations/{id}/revoke", Need::kAdmin, &RevokeStation},
    Route{Method::kGet, "/api/v1/enrolment-codes", Need::kAdmin, &ListEnrolCodes},
    Route{Method::kPost, "/api/v1/enrolment-codes", Need::kAdmin, &AddEnrolCode},
    Route{Method::kDelete, "/api/v1/enrolment-codes/{id}", Need::kAdmin, &WithdrawEnrolCode},
    Route{Method::kGet, "/api/v1/audit", Need::kAdmin, &ListAudit},
    Route{Method::kGet, "/api/v1/jobs", Need::kAdmin, &ListJobs},
    Route{Method::kPost, "/api/v1/jobs/{id}/cancel", Need::kAdmin, &CancelJob},
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

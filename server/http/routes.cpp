#include "server/http/routes.h"

#include <array>
#include <tuple>
#include <type_traits>

#include "server/http/handlers/handlers.h"

namespace enamel::server::http {
namespace asio = boost::asio;
namespace {

// A handler is given the rows that its signature names, or the whole store.
template <typename Rows>
Rows& In(Store& s) {
  if constexpr (std::is_same_v<Rows, Store>) {
    return s;
  } else {
    return std::get<Rows&>(std::tie(s.people, s.roster, s.sessions, s.cohorts, s.stations,
                                    s.devices, s.settings, s.saved_texts, s.profiles, s.scenes,
                                    s.exercises, s.rubrics, s.assignments, s.blobs, s.attempts,
                                    s.results, s.remarks, s.references, s.jobs, s.batches,
                                    s.timelines, s.audit, s.erasures, s.retention, s.health));
  }
}

template <auto kHandler, typename... Rows>
constexpr BlockingHandler Adapt(Result<Response> (*)(const Call&, Rows&...)) {
  return [](const Call& call, [[maybe_unused]] Store& store) {
    return kHandler(call, In<Rows>(store)...);
  };
}
template <auto kHandler, typename... Rows>
constexpr AsyncHandler Adapt(asio::awaitable<Result<Response>> (*)(Call, Rows&...)) {
  return
      [](Call call, [[maybe_unused]] Store& store) { return kHandler(call, In<Rows>(store)...); };
}

template <auto kHandler>
constexpr auto Given() {
  return Adapt<kHandler>(kHandler);
}

const std::array kRoutes = {
    Route{Method::kGet, "/livez", Need::kNobody, Given<&GetAlive>()},
    Route{Method::kGet, "/readyz", Need::kNobody, Given<&GetReady>()},
    Route{Method::kGet, "/healthz", Need::kNobody, Given<&GetReady>()},
    Route{Method::kGet, "/metrics", Need::kNobody, Given<&GetMetrics>()},
    Route{Method::kPost, "/api/v1/first-admin", Need::kNobody, Given<&MakeFirstAdmin>()},
    Route{Method::kGet, "/api/v1/builtin-teeth", Need::kAdmin, Given<&ListBuiltinTeeth>()},
    Route{Method::kPost, "/api/v1/builtin-teeth", Need::kAdmin, Given<&PutBuiltinTooth>()},
    Route{Method::kPost, "/api/v1/tooth-imports", Need::kAdmin, Given<&BeginToothImport>()},
    Route{Method::kGet, "/api/v1/tooth-imports/{id}", Need::kAdmin, Given<&GetToothImport>()},
    Route{Method::kPut, "/api/v1/tooth-imports/{id}/bytes", Need::kAdmin, Given<&AddToothBytes>()},
    Route{Method::kGet, "/api/v1/tooth-imports/{id}/surface", Need::kAdmin,
          Given<&GetToothImportSurface>()},
    Route{Method::kGet, "/api/v1/tooth-imports/{id}/start-tooth", Need::kAdmin,
          Given<&GetToothImportInside>()},
    Route{Method::kDelete, "/api/v1/tooth-imports/{id}", Need::kAdmin, Given<&GiveUpToothImport>()},
    Route{Method::kPost, "/api/v1/session", Need::kNobody, Given<&SignIn>()},
    Route{Method::kGet, "/api/v1/session", Need::kPerson, Given<&GetSession>()},
    Route{Method::kDelete, "/api/v1/session", Need::kPerson, Given<&SignOut>()},
    Route{Method::kPost, "/api/v1/session/confirm", Need::kPerson, Given<&ConfirmSession>()},
    Route{Method::kPost, "/api/v1/session/password", Need::kPerson, Given<&ChangePassword>()},
    Route{Method::kPut, "/api/v1/session/pin", Need::kInstructor, Given<&SetPin>()},
    Route{Method::kPut, "/api/v1/session/language", Need::kPerson, Given<&SetLanguage>()},
    Route{Method::kGet, "/api/v1/sessions", Need::kPerson, Given<&ListSessions>()},
    Route{Method::kDelete, "/api/v1/sessions/{id}", Need::kPerson, Given<&EndSession>()},
    Route{Method::kGet, "/api/v1/people", Need::kAdmin, Given<&ListPeople>()},
    Route{Method::kPost, "/api/v1/people", Need::kAdmin, Given<&AddPerson>()},
    Route{Method::kGet, "/api/v1/people/{id}", Need::kAdmin, Given<&GetPerson>()},
    Route{Method::kPatch, "/api/v1/people/{id}", Need::kAdmin, Given<&EditPerson>()},
    Route{Method::kPost, "/api/v1/people/{id}/password", Need::kAdmin, Given<&ResetPassword>()},
    Route{Method::kPost, "/api/v1/people/{id}/erase", Need::kAdmin, Given<&ErasePerson>()},
    Route{Method::kGet, "/api/v1/people/{id}/sessions", Need::kAdmin, Given<&ListSessionsOf>()},
    Route{Method::kDelete, "/api/v1/people/{id}/sessions", Need::kAdmin, Given<&EndSessionsOf>()},
    Route{Method::kPost, "/api/v1/roster", Need::kAdmin, Given<&ImportRoster>()},
    Route{Method::kGet, "/api/v1/exercises", Need::kPerson, Given<&ListExercises>()},
    Route{Method::kGet, "/api/v1/exercises/{id}", Need::kPerson, Given<&GetExercise>()},
    Route{Method::kPost, "/api/v1/exercises", Need::kInstructor, Given<&PutDraft>()},
    Route{Method::kPut, "/api/v1/exercises/{id}", Need::kInstructor, Given<&ReplaceDraft>()},
    Route{Method::kDelete, "/api/v1/exercises/{id}", Need::kInstructor, Given<&DeleteDraft>()},
    Route{Method::kPost, "/api/v1/exercise-trials", Need::kInstructor,
          Given<&BeginExerciseTrial>()},
    Route{Method::kGet, "/api/v1/exercise-trials/{id}", Need::kInstructor,
          Given<&GetExerciseTrial>()},
    Route{Method::kDelete, "/api/v1/exercise-trials/{id}", Need::kInstructor,
          Given<&GiveUpExerciseTrial>()},
    Route{Method::kGet, "/api/v1/exercises/{id}/document", Need::kPerson,
          Given<&GetExerciseDocument>()},
    Route{Method::kGet, "/api/v1/exercises/{id}/initial-surface", Need::kPerson,
          Given<&GetInitialSurface>()},
    Route{Method::kGet, "/api/v1/exercises/{id}/versions", Need::kPerson,
          Given<&ListExerciseVersions>()},
    Route{Method::kGet, "/api/v1/exercises/{id}/references", Need::kPerson,
          Given<&ListReferences>()},
    Route{Method::kPost, "/api/v1/exercises/{id}/publish", Need::kInstructor,
          Given<&PublishDraft>()},
    Route{Method::kPost, "/api/v1/exercises/{id}/retire", Need::kInstructor,
          Given<&RetireExercise>()},
    Route{Method::kPost, "/api/v1/exercises/{id}/offer", Need::kInstructor,
          Given<&OfferExerciseAgain>()},
    Route{Method::kPut, "/api/v1/exercises/{id}/sharing", Need::kInstructor,
          Given<&ShareExercise>()},
    Route{Method::kGet, "/api/v1/exercises/{id}/rubrics", Need::kInstructor, Given<&ListRubrics>()},
    Route{Method::kPost, "/api/v1/exercises/{id}/rubrics", Need::kInstructor,
          Given<&PublishRubric>()},
    Route{Method::kPost, "/api/v1/exercises/{id}/rubrics/preview", Need::kInstructor,
          Given<&PreviewRubricChange>()},
    Route{Method::kGet, "/api/v1/scoring-metrics", Need::kInstructor, Given<&ListScoringMetrics>()},
    Route{Method::kPost, "/api/v1/references/{id}/withdraw", Need::kInstructor,
          Given<&WithdrawReference>()},
    Route{Method::kGet, "/api/v1/assignments", Need::kPerson, Given<&ListAssignments>()},
    Route{Method::kPost, "/api/v1/assignments", Need::kInstructor, Given<&AddAssignment>()},
    Route{Method::kGet, "/api/v1/assignments/{id}", Need::kPerson, Given<&GetAssignment>()},
    Route{Method::kPut, "/api/v1/assignments/{id}", Need::kInstructor, Given<&ReplaceAssignment>()},
    Route{Method::kDelete, "/api/v1/assignments/{id}", Need::kInstructor,
          Given<&DeleteAssignment>()},
    Route{Method::kPost, "/api/v1/assignments/{id}/move", Need::kInstructor,
          Given<&MoveAssignment>()},
    Route{Method::kPost, "/api/v1/assignments/{id}/release", Need::kInstructor,
          Given<&ReleaseAssignment>()},
    Route{Method::kGet, "/api/v1/assignments/{id}/markings", Need::kInstructor,
          Given<&ListMarkings>()},
    Route{Method::kPost, "/api/v1/assignments/{id}/markings", Need::kInstructor,
          Given<&BeginMarking>()},
    Route{Method::kGet, "/api/v1/markings/{id}", Need::kInstructor, Given<&GetMarking>()},
    Route{Method::kPut, "/api/v1/markings/{id}/markers", Need::kInstructor, Given<&SetMarkers>()},
    Route{Method::kDelete, "/api/v1/markings/{id}", Need::kInstructor, Given<&EndMarking>()},
    Route{Method::kPost, "/api/v1/marking-works/{id}/marks", Need::kInstructor, Given<&AddMark>()},
    Route{Method::kGet, "/api/v1/marking-works/{id}/timeline", Need::kInstructor,
          Given<&GetMarkingTimeline>()},
    Route{Method::kPost, "/api/v1/assignments/{id}/standard", Need::kInstructor,
          Given<&FindStandard>()},
    Route{Method::kGet, "/api/v1/assignments/{id}/insight", Need::kInstructor,
          Given<&GetInsight>()},
    Route{Method::kGet, "/api/v1/assignments/{id}/grading", Need::kInstructor,
          Given<&GetAssignmentGrading>()},
    Route{Method::kGet, "/api/v1/cohorts", Need::kInstructor, Given<&ListCohorts>()},
    Route{Method::kPost, "/api/v1/cohorts", Need::kAdmin, Given<&AddCohort>()},
    Route{Method::kGet, "/api/v1/cohorts/{id}", Need::kInstructor, Given<&GetCohort>()},
    Route{Method::kGet, "/api/v1/cohorts/{id}/grades", Need::kInstructor,
          Given<&GetCohortGrades>()},
    Route{Method::kGet, "/api/v1/cohorts/{id}/grades.csv", Need::kInstructor,
          Given<&GetGradesFile>()},
    Route{Method::kGet, "/api/v1/cohorts/{id}/attempts.csv", Need::kInstructor,
          Given<&GetAttemptsFile>()},
    Route{Method::kGet, "/api/v1/cohorts/{id}/grading", Need::kInstructor,
          Given<&GetCohortGrading>()},
    Route{Method::kPatch, "/api/v1/cohorts/{id}", Need::kAdmin, Given<&EditCohort>()},
    Route{Method::kPost, "/api/v1/cohorts/{id}/members", Need::kAdmin, Given<&ChangeMembers>()},
    Route{Method::kPost, "/api/v1/cohorts/{id}/rescore", Need::kInstructor,
          Given<&RescoreCohort>()},
    Route{Method::kGet, "/api/v1/batches", Need::kInstructor, Given<&ListBatches>()},
    Route{Method::kGet, "/api/v1/batches/{id}", Need::kInstructor, Given<&GetBatch>()},
    Route{Method::kPost, "/api/v1/batches/{id}/cancel", Need::kInstructor, Given<&CancelBatch>()},
    Route{Method::kGet, "/api/v1/attempts", Need::kPerson, Given<&ListAttempts>()},
    Route{Method::kGet, "/api/v1/attempts/{id}", Need::kPerson, Given<&GetAttempt>()},
    Route{Method::kGet, "/api/v1/attempts/{id}/score", Need::kPerson, Given<&GetScore>()},
    Route{Method::kGet, "/api/v1/attempts/{id}/signed-result", Need::kPerson,
          Given<&GetSignedResult>()},
    Route{Method::kGet, "/api/v1/attempts/{id}/surface", Need::kPerson, Given<&GetSurface>()},
    Route{Method::kGet, "/api/v1/attempts/{id}/timeline", Need::kPerson, Given<&GetTimeline>()},
    Route{Method::kGet, "/api/v1/attempts/{id}/deviation", Need::kPerson, Given<&GetDeviation>()},
    Route{Method::kGet, "/api/v1/start-teeth/{name}", Need::kPerson, Given<&GetStartTooth>()},
    Route{Method::kGet, "/api/v1/attempts/{id}/series", Need::kPerson, Given<&GetSeries>()},
    Route{Method::kGet, "/api/v1/attempts/{id}/ticks", Need::kPerson, Given<&GetTicks>()},
    Route{Method::kGet, "/api/v1/attempts/{id}/live", Need::kInstructor, Given<&GetLive>()},
    Route{Method::kGet, "/api/v1/attempts/{id}/live-cut", Need::kInstructor, Given<&GetLiveCut>()},
    Route{Method::kGet, "/api/v1/live/{id}/remarks", Need::kInstructor, Given<&ListLiveRemarks>()},
    Route{Method::kPost, "/api/v1/live/{id}/remarks", Need::kInstructor, Given<&SendLiveRemark>()},
    Route{Method::kPost, "/api/v1/attempts/{id}/release", Need::kInstructor,
          Given<&ReleaseAttempt>()},
    Route{Method::kPost, "/api/v1/attempts/{id}/reference", Need::kInstructor,
          Given<&MakeReference>()},
    Route{Method::kDelete, "/api/v1/attempts/{id}/release", Need::kInstructor,
          Given<&WithdrawRelease>()},
    Route{Method::kPut, "/api/v1/attempts/{id}/override", Need::kInstructor, Given<&PutOverride>()},
    Route{Method::kDelete, "/api/v1/attempts/{id}/override", Need::kInstructor,
          Given<&DeleteOverride>()},
    Route{Method::kPost, "/api/v1/attempts/{id}/rescore", Need::kInstructor, Given<&Rescore>()},
    Route{Method::kPost, "/api/v1/attempts/{id}/excuse", Need::kInstructor, Given<&Excuse>()},
    Route{Method::kDelete, "/api/v1/attempts/{id}/excuse", Need::kInstructor,
          Given<&TakeExcuseBack>()},
    Route{Method::kPost, "/api/v1/attempts/{id}/restore-result", Need::kInstructor,
          Given<&RestoreResult>()},
    Route{Method::kGet, "/api/v1/attempts/{id}/results", Need::kPerson, Given<&ListResults>()},
    Route{Method::kGet, "/api/v1/attempts/{id}/annotations", Need::kPerson,
          Given<&ListAnnotations>()},
    Route{Method::kPost, "/api/v1/attempts/{id}/annotations", Need::kInstructor,
          Given<&AddAnnotation>()},
    Route{Method::kPut, "/api/v1/annotations/{id}", Need::kInstructor, Given<&ReplaceAnnotation>()},
    Route{Method::kDelete, "/api/v1/annotations/{id}", Need::kInstructor,
          Given<&DeleteAnnotation>()},
    Route{Method::kGet, "/api/v1/saved-texts", Need::kInstructor, Given<&ListSavedTexts>()},
    Route{Method::kPost, "/api/v1/saved-texts", Need::kInstructor, Given<&AddSavedText>()},
    Route{Method::kPut, "/api/v1/saved-texts/{id}", Need::kInstructor, Given<&ReplaceSavedText>()},
    Route{Method::kDelete, "/api/v1/saved-texts/{id}", Need::kInstructor,
          Given<&DeleteSavedText>()},
    Route{Method::kPost, "/api/v1/attempts/{id}/appeal", Need::kPerson, Given<&FileAppeal>()},
    Route{Method::kPost, "/api/v1/attempts/{id}/appeal/answer", Need::kInstructor,
          Given<&AnswerAppeal>()},
    Route{Method::kGet, "/api/v1/profiles", Need::kPerson, Given<&ListProfiles>()},
    Route{Method::kPost, "/api/v1/profiles", Need::kAdmin, Given<&PutProfile>()},
    Route{Method::kGet, "/api/v1/profiles/{name}", Need::kPerson, Given<&GetProfile>()},
    Route{Method::kGet, "/api/v1/profiles/{name}/versions", Need::kInstructor,
          Given<&ListProfileVersions>()},
    Route{Method::kGet, "/api/v1/profiles/{name}/reports", Need::kInstructor,
          Given<&ListProfileReports>()},
    Route{Method::kPost, "/api/v1/profiles/{name}/reports", Need::kAdmin,
          Given<&AddProfileReport>()},
    Route{Method::kGet, "/api/v1/profile-reports/{id}", Need::kInstructor,
          Given<&GetProfileReport>()},
    Route{Method::kGet, "/api/v1/profiles/{name}/calibrations", Need::kInstructor,
          Given<&ListCalibrations>()},
    Route{Method::kPost, "/api/v1/profiles/{name}/calibrations", Need::kAdmin,
          Given<&AddCalibration>()},
    Route{Method::kGet, "/api/v1/stations", Need::kInstructor, Given<&ListStations>()},
    Route{Method::kGet, "/api/v1/stations/{id}", Need::kInstructor, Given<&GetStation>()},
    Route{Method::kPatch, "/api/v1/stations/{id}", Need::kAdmin, Given<&EditStation>()},
    Route{Method::kPost, "/api/v1/stations/{id}/revoke", Need::kAdmin, Given<&RevokeStation>()},
    Route{Method::kGet, "/api/v1/listed-devices", Need::kInstructor, Given<&ListListedDevices>()},
    Route{Method::kPost, "/api/v1/listed-devices", Need::kAdmin, Given<&ListDevice>()},
    Route{Method::kPost, "/api/v1/listed-devices/remove", Need::kAdmin, Given<&UnlistDevice>()},
    Route{Method::kGet, "/api/v1/station-settings", Need::kAdmin, Given<&ListStationSettings>()},
    Route{Method::kPost, "/api/v1/station-settings", Need::kAdmin, Given<&PutStationSetting>()},
    Route{Method::kPost, "/api/v1/station-settings/remove", Need::kAdmin,
          Given<&RemoveStationSetting>()},
    Route{Method::kGet, "/api/v1/enrolment-codes", Need::kAdmin, Given<&ListEnrolCodes>()},
    Route{Method::kPost, "/api/v1/enrolment-codes", Need::kAdmin, Given<&AddEnrolCode>()},
    Route{Method::kDelete, "/api/v1/enrolment-codes/{id}", Need::kAdmin,
          Given<&WithdrawEnrolCode>()},
    Route{Method::kGet, "/api/v1/audit", Need::kAdmin, Given<&ListAudit>()},
    Route{Method::kGet, "/api/v1/health", Need::kAdmin, Given<&GetServerHealth>()},
    Route{Method::kPost, "/api/v1/backups", Need::kAdmin, Given<&StartBackup>()},
    Route{Method::kGet, "/api/v1/jobs", Need::kAdmin, Given<&ListJobs>()},
    Route{Method::kPost, "/api/v1/jobs/{id}/cancel", Need::kAdmin, Given<&CancelJob>()},
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
  // Else "/people/{id}" would also match "/people/1/password".
  return id.find('/') == std::string_view::npos ? std::optional(id) : std::nullopt;
}

}  // namespace

std::span<const Route> Routes() { return kRoutes; }

RouteMatch FindRoute(Method method, std::string_view path) {
  // HEAD is GET without the body, which the connection leaves out.
  Method wanted = method == Method::kHead ? Method::kGet : method;
  RouteMatch out;
  // One after another: some eighty comparisons of short texts, next to a query to the database. The
  // loop reads the whole table because a 405 has to name the allowed methods.
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

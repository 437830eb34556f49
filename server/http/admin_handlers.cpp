#include "server/http/error_response.h"
#include "server/http/handlers.h"
#include "server/http/json_body.h"
#include "server/http/query.h"

namespace enamel::server::http {
namespace json = boost::json;
namespace {

constexpr uint32_t kDefaultAudit = 100;
constexpr uint32_t kMaxAudit = 1000;
constexpr const char* kJobStates[] = {"failed", "running", "queued", "done", "cancelled"};

Result<json::object> CohortJson(Store& store, const Cohort& cohort) {
  Result<std::vector<Person>> people = store.CohortMembers(cohort.id);
  if (!people.ok()) return people.status();
  json::array members;
  for (const Person& person : *people) {
    members.push_back({{"id", person.id.Text()},
                       {"display_name", person.display_name},
                       {"role", RoleName(person.role)}});
  }
  return json::object{
      {"id", cohort.id.Text()}, {"name", cohort.name}, {"members", std::move(members)}};
}

}  // namespace

Response ListCohorts(const Call& call) {
  const Person& person = call.caller->person;
  Result<std::vector<Cohort>> rows =
      person.role == Role::kAdmin ? call.store.Cohorts() : call.store.CohortsOf(person.id);
  if (!rows.ok()) return ErrorResponse(rows.status());
  json::array cohorts;
  for (const Cohort& row : *rows) {
    Result<json::object> cohort = CohortJson(call.store, row);
    if (!cohort.ok()) return ErrorResponse(cohort.status());
    cohorts.push_back(std::move(*cohort));
  }
  return JsonResponse({{"cohorts", std::move(cohorts)}});
}

Response ListStations(const Call& call) {
  Result<std::vector<StationRow>> rows = call.store.Stations();
  if (!rows.ok()) return ErrorResponse(rows.status());
  json::array stations;
  for (const StationRow& row : *rows) {
    stations.push_back({{"id", row.id.Text()},
                        {"name", row.name},
                        {"revoked", row.revoked},
                        {"enrolled_ms", row.enrolled_ms},
                        {"last_seen_ms", row.last_seen_ms}});
  }
  return JsonResponse({{"stations", std::move(stations)}});
}

Response ListAudit(const Call& call) {
  Result<uint32_t> limit = QueryLimit(call.request, kDefaultAudit, kMaxAudit);
  if (!limit.ok()) return ErrorResponse(limit.status());
  Result<std::vector<AuditRow>> rows = call.store.Audit(*limit);
  if (!rows.ok()) return ErrorResponse(rows.status());
  json::array audit;
  for (const AuditRow& row : *rows) {
    audit.push_back({{"at_ms", row.at_ms},
                     {"actor", row.actor},
                     {"action", row.action},
                     {"object", row.object},
                     {"before", row.before_json},
                     {"after", row.after_json}});
  }
  return JsonResponse({{"audit", std::move(audit)}});
}

Response ListJobs(const Call& call) {
  auto wanted = call.request.query.find("state");
  bool all = wanted == call.request.query.end();
  bool known = all;
  json::array jobs;
  for (const char* state : kJobStates) {
    if (!all && wanted->second != state) continue;
    known = true;
    Result<std::vector<JobRow>> rows = call.store.Jobs(state);
    if (!rows.ok()) return ErrorResponse(rows.status());
    for (const JobRow& row : *rows) {
      jobs.push_back({{"id", row.id.Text()},
                      {"kind", row.kind},
                      {"attempt_id", row.attempt.Text()},
                      {"state", row.state},
                      {"cause", row.cause},
                      {"progress", row.progress},
                      {"tries", row.tries},
                      {"error", row.error}});
    }
  }
  if (!known) {
    return ErrorResponse(
        Status{Code::kInvalidInput, "expected queued, running, done, failed or cancelled", "state"});
  }
  return JsonResponse({{"jobs", std::move(jobs)}});
}

}  // namespace enamel::server::http

#include <algorithm>
#include <boost/json.hpp>

#include "common/base/unix_time.h"
#include "common/base/utf8.h"
#include "server/http/api.h"
#include "server/http/caller.h"
#include "server/http/error_response.h"
#include "server/http/json_body.h"
#include "server/http/operations.h"
#include "server/ops/metrics.h"

// How the server does, for those who run it: figures, of which the page makes sentences.
namespace enamel::server::http {
namespace json = boost::json;
namespace {

constexpr uint32_t kMaxShownJobs = 200;      // that the store lists of a state
constexpr uint32_t kMaxShownAttempts = 200;  // likewise
constexpr UnixMs kMinuteMs = 60'000;
// During an attempt a chunk comes every second; a connection that is silent for a minute has ended
// (schemas/wire/README.md).
constexpr UnixMs kLateMs = 2 * kMinuteMs;
// Somebody who went home without ending an attempt is no fault that could still be mended.
constexpr UnixMs kGivenUpMs = 24 * 60 * kMinuteMs;

Result<json::object> JobsJson(JobRows& jobs) {
  json::object out;
  for (const char* state : {"queued", "running", "failed"}) {
    JobFilter filter;
    filter.state = state;
    filter.limit = kMaxShownJobs;
    ENAMEL_ASSIGN_OR_RETURN(auto rows, jobs.FindJobs(filter));
    out[state] = rows.size();
  }
  out["counted_up_to"] = kMaxShownJobs;
  return out;
}

Result<json::object> StationsJson(StationRows& stations, const StationBoard* board) {
  ENAMEL_ASSIGN_OR_RETURN(auto rows, stations.Stations());
  uint32_t enrolled = 0, online = 0;
  for (const StationRow& row : rows) {
    enrolled += row.revoked ? 0 : 1;
    online += board != nullptr && !row.revoked && board->Connected(row.id) ? 1 : 0;
  }
  return json::object{{"enrolled", enrolled}, {"online", online}};
}

// Attempts in progress, and those that have been silent for longer than a connected station would
// wait.
Result<json::object> RecordingsJson(AttemptRows& attempts, UnixMs now_ms) {
  AttemptFilter filter;
  filter.state = AttemptState::kRecording;
  filter.limit = kMaxShownAttempts;
  ENAMEL_ASSIGN_OR_RETURN(auto rows, attempts.Attempts(filter));
  uint32_t open = 0;
  json::array late;
  for (const AttemptRow& row : rows) {
    const UnixMs silent_ms = now_ms - std::max(row.last_chunk_ms, row.ticketed_ms);
    if (silent_ms >= kGivenUpMs) continue;
    ++open;
    if (silent_ms < kLateMs) continue;
    late.push_back({{"attempt_id", row.id.Text()},
                    {"station_id", row.station.Text()},
                    {"silent_ms", silent_ms}});
  }
  return json::object{{"open", open}, {"late", std::move(late)}};
}

// As the audit trail noted it. What has become of the copy since, nobody notes.
Result<json::value> LastBackup(Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(const auto newest, store.audit.NewestOf(kBackupMade));
  if (!newest) return json::value();
  boost::system::error_code error;
  const json::value after = json::parse(newest->after_json, error);
  const auto number = [&](const char* name) -> int64_t {
    const json::value* found = after.is_object() ? after.get_object().if_contains(name) : nullptr;
    boost::system::error_code none;
    const int64_t value = found != nullptr ? found->to_number<int64_t>(none) : 0;
    return none ? 0 : value;
  };
  return json::value{{"at_ms", newest->at_ms},
                     {"missing", number("missing")},
                     {"place", newest->object},
                     {"bytes", number("bytes")}};
}

Result<json::object> BackupsJson(const BackupRun& backups) {
  ENAMEL_ASSIGN_OR_RETURN(const auto now, backups.Look());
  json::value running, failed, drill;
  if (now.running) {
    running = {{"since_ms", now.running->since_ms},
               {"here", now.running->here},
               {"phase", now.running->phase},
               {"done", now.running->done},
               {"all", now.running->all}};
  }
  if (now.failed) failed = {{"at_ms", now.failed->at_ms}, {"problem", now.failed->problem}};
  if (now.drill) {
    drill = {{"at_ms", now.drill->at_ms},
             {"place", AsUtf8(now.drill->place)},
             {"problem", now.drill->problem}};
  }
  return json::object{{"folder", AsUtf8(now.folder.string())},
                      {"running", std::move(running)},
                      {"failed", std::move(failed)},
                      {"drill", std::move(drill)}};
}

Result<json::array> RetentionJson(RetentionRows& retention) {
  ENAMEL_ASSIGN_OR_RETURN(auto rules, retention.RetentionRules());
  json::array out;
  for (const RetentionRule& rule : rules) {
    out.push_back({{"what", rule.what}, {"days", rule.days}});
  }
  return out;
}

const char* NameOf(sql::Standby standby) {
  switch (standby) {
    case sql::Standby::kNotKept:
      return "";
    case sql::Standby::kNone:
      return "none";
    case sql::Standby::kBehind:
      return "behind";
    case sql::Standby::kMissing:
      return "missing";
    case sql::Standby::kSynchronous:
      return "synchronous";
    case sql::Standby::kUnknown:
      break;
  }
  return "unknown";
}

const char* UnitOf(ops::BudgetUnit unit) {
  switch (unit) {
    case ops::BudgetUnit::kCount:
      return "count";
    case ops::BudgetUnit::kPercent:
      return "percent";
    case ops::BudgetUnit::kMib:
      break;
  }
  return "bytes";
}

// The party that uses most. Admins of a school see no addresses: only /metrics has them.
json::value PartyJson(const ops::BudgetUse& use, Store& store) {
  if (use.party == ops::PartyKind::kNone) return nullptr;
  json::object out{{"kind", ops::NameOf(use.party)}, {"id", nullptr}, {"name", ""}};
  const Result<Uuid> id = Uuid::Parse(use.of);
  if (use.party == ops::PartyKind::kAddress || !id.ok()) return out;
  out["id"] = use.of;
  if (use.party == ops::PartyKind::kStation) {
    const auto station = store.stations.StationById(*id);
    if (station.ok()) out["name"] = station->name;
  } else {
    const auto person = store.people.PersonById(*id);
    if (person.ok()) out["name"] = person->display_name;
  }
  return out;
}

json::array BudgetsJson(const Call& call, Store& store) {
  json::array out;
  for (const ops::BudgetUse& use : call.api->Budgets()) {
    out.push_back({{"budget", use.kind->name},
                   {"unit", UnitOf(use.kind->unit)},
                   {"limit", use.limit},
                   {"most", use.most},
                   {"of", PartyJson(use, store)},
                   {"refused", use.refused}});
  }
  return out;
}

Result<json::object> HealthJson(const Call& call, Store& store) {
  const StoreHealth health = store.health.Health();
  const UnixMs now_ms = enamel::UnixMs();
  const auth::DoorCounts& door = call.authenticator.counts();
  json::object out{
      {"now_ms", now_ms},
      {"started_ms", ops::ProcessStartedMs()},
      {"ingest",
       {{"takes_recordings", health.takes_recordings},
        {"problem", health.problem},
        {"waiting", health.waiting},
        {"chunks", health.chunks},
        {"chunk_bytes", health.chunk_bytes},
        {"sealed", health.sealed}}},
      {"commits",
       {{"count", health.commits},
        {"failed", health.failed_commits},
        {"timed", health.timed_commits},
        {"p99_s", health.commit_p99_s}}},
      {"standby", NameOf(health.standby)},
      {"clock", {{"ahead_ms", health.clock_ahead_ms}, {"problem", health.clock_problem}}},
      {"disk",
       {{"free_bytes", health.free_bytes},
        {"kept_free_bytes", health.min_free_bytes},
        {"database_bytes", health.database_bytes},
        {"log_bytes", health.log_bytes}}},
      {"sign_ins",
       {{"signed_in", door.signed_in.load()},
        {"refused", door.refused.load()},
        {"throttled", door.throttled.load()},
        {"busy", door.busy.load()}}}};
  out["budgets"] = BudgetsJson(call, store);
  ENAMEL_ASSIGN_OR_RETURN(out["jobs"], JobsJson(store.jobs));
  ENAMEL_ASSIGN_OR_RETURN(out["stations"], StationsJson(store.stations, call.stations));
  ENAMEL_ASSIGN_OR_RETURN(out["recordings"], RecordingsJson(store.attempts, now_ms));
  ENAMEL_ASSIGN_OR_RETURN(out["backup"], LastBackup(store));
  ENAMEL_ASSIGN_OR_RETURN(out["backups"], BackupsJson(*call.backups));
  ENAMEL_ASSIGN_OR_RETURN(out["retention"], RetentionJson(store.retention));
  return out;
}

}  // namespace

Result<Response> GetServerHealth(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(json::object health, HealthJson(call, store));
  return JsonResponse(health);
}

Result<Response> StartBackup(const Call& call, Store&) {
  if (Status started = call.backups->Start(ActorOf(call)); !started.ok()) {
    return started;
  }
  ENAMEL_ASSIGN_OR_RETURN(json::object now, BackupsJson(*call.backups));
  return JsonResponse(now, 202);
}

}  // namespace enamel::server::http

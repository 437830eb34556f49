#include <algorithm>
#include <charconv>

#include "server/http/error_response.h"
#include "server/http/json_body.h"
#include "server/http/operations.h"
#include "server/http/paging.h"
#include "server/http/query.h"
#include "server/http/views/audit_view.h"

namespace enamel::server::http {
namespace json = boost::json;
namespace {

constexpr uint32_t kDefaultAudit = 100;
// Rows of the trail are small and read in bulk, by somebody who looks for something.
constexpr uint32_t kMaxAudit = 1000;
constexpr uint32_t kDefaultJobs = 50;
constexpr uint32_t kMaxJobs = 200;
constexpr size_t kMaxFilterText = 200;
constexpr const char* kJobStates[] = {"failed", "running", "queued", "done", "cancelled"};

// A cursor that is an id.
Result<std::optional<Uuid>> IdOf(const Page& page) {
  if (!page.after) return std::optional<Uuid>();
  Result<Uuid> id = Uuid::Parse(*page.after);
  if (!id.ok())
    return Status{Code::kInvalidInput, "expected the `next` of the page before", "cursor"};
  return std::optional<Uuid>(*id);
}

Result<std::string> QueryText(const Request& request, const char* name) {
  auto found = request.query.find(name);
  if (found == request.query.end()) return std::string();
  if (found->second.size() <= kMaxFilterText) return found->second;
  return Status{Code::kInvalidInput, "expected at most 200 bytes", name};
}

Result<UnixMs> QueryTime(const Request& request, const char* name) {
  auto found = request.query.find(name);
  if (found == request.query.end()) return UnixMs{0};
  const std::string& text = found->second;
  UnixMs time = 0;
  auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), time);
  if (error == std::errc() && end == text.data() + text.size() && time >= 0) return time;
  return Status{Code::kInvalidInput, "expected milliseconds since the Unix epoch", name};
}

Result<AuditFilter> AuditFilterOf(const Request& request) {
  AuditFilter out;
  ENAMEL_ASSIGN_OR_RETURN(Page page, PageOf(request, kDefaultAudit, kMaxAudit));
  out.limit = page.limit;
  ENAMEL_ASSIGN_OR_RETURN(std::optional<Uuid> before, IdOf(page));
  out.before = before;
  ENAMEL_ASSIGN_OR_RETURN(std::optional<Uuid> actor, QueryId(request, "actor"));
  out.actor = actor;
  // An empty text is no filter.
  for (auto [name, into] : {std::pair{"action", &out.action}, {"object", &out.object}}) {
    ENAMEL_ASSIGN_OR_RETURN(std::string text, QueryText(request, name));
    *into = text;
  }
  for (auto [name, into] : {std::pair{"from_ms", &out.from_ms}, {"until_ms", &out.until_ms}}) {
    ENAMEL_ASSIGN_OR_RETURN(UnixMs time, QueryTime(request, name));
    *into = time;
  }
  return out;
}

}  // namespace

Result<Response> ListAudit(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(AuditFilter filter, AuditFilterOf(call.request));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<AuditRow> rows, store.audit.FindAudit(filter));
  json::array audit;
  for (const AuditRow& row : rows) audit.push_back(AuditJson(row));
  json::value next;
  // A full page may be the last: the next one is then empty, which costs less than asking for one
  // row more each time. Ids rise with time, so that the last one's is where the next page begins.
  if (rows.size() == filter.limit) next = NextAfter(rows.back().id.Text());
  return JsonResponse({{"audit", std::move(audit)}, {"next", std::move(next)}});
}

Result<Response> ListJobs(const Call& call, Store& store) {
  JobFilter filter;
  ENAMEL_ASSIGN_OR_RETURN(std::string state, QueryText(call.request, "state"));
  filter.state = state;
  if (!filter.state.empty() &&
      std::ranges::find(kJobStates, filter.state) == std::end(kJobStates)) {
    return Status(Code::kInvalidInput, "expected queued, running, done, failed or cancelled",
                  "state");
  }
  ENAMEL_ASSIGN_OR_RETURN(Page page, PageOf(call.request, kDefaultJobs, kMaxJobs));
  filter.limit = page.limit;
  ENAMEL_ASSIGN_OR_RETURN(std::optional<Uuid> before, IdOf(page));
  filter.before = before;
  ENAMEL_ASSIGN_OR_RETURN(std::vector<JobRow> rows, store.jobs.FindJobs(filter));
  json::array jobs;
  for (const JobRow& row : rows) {
    jobs.push_back({{"id", row.id.Text()},
                    {"kind", row.kind},
                    {"attempt_id", row.attempt.Text()},
                    {"state", row.state},
                    {"cause", row.cause},
                    {"progress", row.progress},
                    {"tries", row.tries},
                    {"error", row.error}});
  }
  json::value next;
  if (rows.size() == filter.limit) next = NextAfter(rows.back().id.Text());
  return JsonResponse({{"jobs", std::move(jobs)}, {"next", std::move(next)}});
}

}  // namespace enamel::server::http

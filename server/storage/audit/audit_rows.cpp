#include "server/storage/audit/audit_rows.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"

namespace enamel::server {
namespace {

constexpr char kAuditSelect[] =
    "SELECT at_ms, actor, via, action, object, before_json, after_json, id FROM audit "
    "WHERE tenant = ?1";

// An actor without an id is a command line, a station or the server itself; `via` says which.
Result<std::vector<AuditRow>> AuditIn(
    Query& q, const std::function<bool(const Query&)>& wanted = [](const Query&) { return true; }) {
  std::vector<AuditRow> out;
  while (q.Next()) {
    if (!wanted(q)) continue;
    Uuid actor = q.Id(1);
    std::string who = actor.IsZero() ? q.Text(2) : actor.Text() + " (" + q.Text(2) + ")";
    out.push_back(
        AuditRow{q.Int(0), who, q.Text(3), q.Text(4), q.Text(5), q.Text(6), q.Id(7), q.Text(2)});
  }
  ENAMEL_RETURN_IF_ERROR(q.status());
  return out;
}

}  // namespace

Result<std::vector<AuditRow>> AuditRows::Audit(uint32_t limit) {
  AuditFilter filter;
  filter.limit = limit;
  return FindAudit(filter);
}

Result<std::optional<AuditRow>> AuditRows::NewestOf(const std::string& action) {
  AuditFilter filter;
  filter.action = action;
  filter.limit = 1;
  ENAMEL_ASSIGN_OR_RETURN(auto rows, FindAudit(filter));
  return rows.empty() ? std::nullopt : std::optional(std::move(rows.front()));
}

Result<std::vector<AuditRow>> AuditRows::FindAudit(const AuditFilter& filter) {
  std::string sql = std::string(kAuditSelect) + " AND at_ms BETWEEN ?2 AND ?3";
  int places = 3;
  auto place = [&] { return "?" + std::to_string(++places); };
  bool kind = filter.action.ends_with('.');
  if (filter.actor) sql += " AND actor = " + place();
  if (!filter.action.empty()) {
    const std::string action = place();
    // Not LIKE, in which % and _ of the asker would mean something.
    sql += kind ? " AND substr(action, 1, length(" + action + ")) = " + action
                : " AND action = " + action;
  }
  if (!filter.object.empty()) sql += " AND object = " + place();
  if (filter.before) sql += " AND id < " + place();
  sql += " ORDER BY id DESC LIMIT " + place();
  return rows_.Read([&](Db& db) -> Result<std::vector<AuditRow>> {
    Query q(db, sql.c_str());
    q.Bind(filter.from_ms, filter.until_ms != 0 ? filter.until_ms : INT64_MAX);
    if (filter.actor) q.Bind(*filter.actor);
    if (!filter.action.empty()) q.Bind(filter.action);
    if (!filter.object.empty()) q.Bind(filter.object);
    if (filter.before) q.Bind(*filter.before);
    return AuditIn(q.Bind(std::clamp<uint32_t>(filter.limit, 1, 1000)));
  });
}

// Rows name an attempt by its id and not by its person, so this looks up the person's attempts
// first. It reads all rows, which is rare: for one person's data.
Result<std::vector<AuditRow>> AuditRows::AuditAbout(const Uuid& person) {
  return rows_.Read([&](Db& db) -> Result<std::vector<AuditRow>> {
    std::set<std::string> objects{person.Text()};
    {
      Query q(db, "SELECT id FROM attempts WHERE tenant = ?1 AND person = ?2");
      q.Bind(person);
      while (q.Next()) objects.insert(q.Id(0).Text());
      ENAMEL_RETURN_IF_ERROR(q.status());
    }
    Query q(db, std::string(kAuditSelect) + " ORDER BY id");
    return AuditIn(
        q, [&](const Query& row) { return row.Id(1) == person || objects.contains(row.Text(4)); });
  });
}

Status AuditRows::NoteAudit(const Actor& by, const std::string& action, const std::string& object,
                            const std::string& after_json) {
  return rows_.Write(
      [&](Db& db) { return WriteAudit(db, by, action.c_str(), object, "{}", after_json); });
}

}  // namespace enamel::server

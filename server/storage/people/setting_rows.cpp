#include "server/storage/people/setting_rows.h"

#include <algorithm>
#include <map>

#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/training/names.h"

namespace enamel::server {
namespace {

// As decisions.cpp names it.
std::string ObjectOf(const std::string& name, const std::string& scope) {
  return name + " " + scope;
}

// A name is narrower than any beginning of names, a longer beginning narrower than a shorter one.
std::pair<bool, size_t> Narrowness(const StationSetting& setting) {
  return {!setting.scope.ends_with('*'), setting.scope.size()};
}

}  // namespace

Result<std::vector<StationSetting>> SettingRows::Settings() {
  return rows_.Read([&](Db& db) -> Result<std::vector<StationSetting>> {
    Query q(db,
            "SELECT name, scope, value, fixed, changed_ms FROM station_settings WHERE tenant = ?1 "
            "ORDER BY name, scope");
    return q.All<StationSetting>();
  });
}

Result<protocol::Policy> SettingRows::PolicyFor(const std::string& station) {
  ENAMEL_ASSIGN_OR_RETURN(std::vector<StationSetting> all, Settings());
  std::map<std::string, StationSetting> narrowest;
  for (StationSetting& setting : all) {
    if (!protocol::IsInScope(setting.scope, station)) continue;
    StationSetting& kept = narrowest.try_emplace(setting.name, setting).first->second;
    if (Narrowness(kept) < Narrowness(setting)) kept = std::move(setting);
  }
  protocol::Policy out;
  for (const auto& [name, setting] : narrowest) {
    wire::Setting& to = *out.add_settings();
    to.set_name(name);
    to.set_value(setting.value);
    to.set_fixed(setting.fixed);
  }
  return out;
}

Status SettingRows::PutSetting(const StationSetting& setting, const Actor& by) {
  ENAMEL_RETURN_IF_ERROR(protocol::CheckPolicySetting(setting.name, setting.value));
  ENAMEL_ASSIGN_OR_RETURN(const std::string scope, CheckedName(setting.scope, "scope"));
  if (scope.find('*') < scope.size() - 1) {
    return Status(
        Code::kInvalidInput,
        "expected *, a station's name, or the beginning of names and * at its end; found \"" +
            scope + "\"",
        "scope");
  }
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(
        Insert(db, "station_settings", "name", setting.name, "scope", scope, "value", setting.value,
               "fixed", setting.fixed, "changed_ms", NowMs(),
               " ON CONFLICT (tenant, name, scope) DO UPDATE SET value = excluded.value, fixed = "
               "excluded.fixed, changed_ms = excluded.changed_ms"));
    return WriteAudit(db, by, "setting.put", ObjectOf(setting.name, scope), "{}",
                      JsonOf({{"value", setting.value}, {"fixed", setting.fixed ? "yes" : "no"}}));
  });
}

Status SettingRows::RemoveSetting(const std::string& name, const std::string& scope,
                                  const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    Query q(db, "DELETE FROM station_settings WHERE tenant = ?1 AND name = ?2 AND scope = ?3");
    ENAMEL_RETURN_IF_ERROR(q.Bind(name, scope).Run());
    if (db.Changes() == 0) {
      return Status(Code::kNotFound, "\"" + name + "\" is not set for \"" + scope + "\"", "name");
    }
    return WriteAudit(db, by, "setting.remove", ObjectOf(name, scope), "{}", "{}");
  });
}

}  // namespace enamel::server

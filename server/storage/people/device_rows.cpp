#include "server/storage/people/device_rows.h"

#include <string>
#include <vector>

#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/training/names.h"

// Haptic devices that graded work is done with.
namespace enamel::server {
Result<bool> IsListedIn(Db& db, const Hand& hand) {
  if (hand.kind != HandKind::kHaptic || ListedAs(hand).empty()) return false;
  Query q(db, "SELECT 1 FROM listed_devices WHERE tenant = ?1 AND name = ?2");
  return q.Bind(ListedAs(hand)).Any();
}

Result<std::vector<ListedDevice>> DeviceRows::ListedDevices() {
  return rows_.Read([&](Db& db) -> Result<std::vector<ListedDevice>> {
    // ListedAs, in SQL, of the newest attempts: a school has tens of thousands, and what shook years ago was mended.
    Query q(db,
            "SELECT d.name, d.title, d.added_ms, COALESCE(s.shook_ms, 0) FROM listed_devices d "
            "LEFT JOIN (SELECT CASE hand_unit WHEN '' THEN hand_device ELSE hand_unit END AS name, "
            "MAX(ticketed_ms) AS shook_ms FROM (SELECT hand_unit, hand_device, flags, ticketed_ms "
            "FROM attempts WHERE tenant = ?1 ORDER BY id DESC LIMIT 1000) newest WHERE (flags & "
            "?2) <> 0 GROUP BY 1) s ON s.name = d.name WHERE d.tenant = ?1 ORDER BY d.name");
    return q.Bind(kShook).All<ListedDevice>();
  });
}

Status DeviceRows::ListDevice(const std::string& name, const std::string& title, const Actor& by) {
  ENAMEL_ASSIGN_OR_RETURN(const std::string checked_name, CheckedName(name, "name"));
  ENAMEL_ASSIGN_OR_RETURN(const std::string checked_title, CheckedName(title, "title"));
  if (checked_name.size() > kMaxHandTextBytes || checked_title.size() > kMaxHandTextBytes) {
    return Status(Code::kInvalidInput,
                  "expected at most " + std::to_string(kMaxHandTextBytes) + " bytes of each",
                  checked_name.size() > kMaxHandTextBytes ? "name" : "title");
  }
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(
        Insert(db, "listed_devices", "name", checked_name, "title", checked_title, "added_ms",
               NowMs(), " ON CONFLICT (tenant, name) DO UPDATE SET title = excluded.title"));
    return WriteAudit(db, by, "device.list", checked_name, "{}",
                      JsonOf({{"title", checked_title}}));
  });
}

Status DeviceRows::UnlistDevice(const std::string& name, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    Query q(db, "DELETE FROM listed_devices WHERE tenant = ?1 AND name = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(name).Run());
    if (db.Changes() == 0) {
      return Status(Code::kNotFound, "no device \"" + name + "\" is listed", "name");
    }
    return WriteAudit(db, by, "device.unlist", name, "{}", "{}");
  });
}

Result<bool> DeviceRows::IsListed(const Hand& hand) {
  return rows_.Read([&](Db& db) { return IsListedIn(db, hand); });
}

}  // namespace enamel::server

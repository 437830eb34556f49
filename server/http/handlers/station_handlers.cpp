#include <algorithm>
#include <boost/json.hpp>

#include "common/base/hex.h"
#include "common/base/unix_time.h"
#include "server/auth/token.h"
#include "server/http/caller.h"
#include "server/http/error_response.h"
#include "server/http/etag.h"
#include "server/http/json_body.h"
#include "server/http/operations.h"
#include "server/http/paging.h"
#include "server/http/query.h"
#include "server/training/names.h"
#include "server/training/revision.h"

namespace enamel::server::http {
namespace json = boost::json;
namespace {

constexpr size_t kMaxStationName = 64;  // as in schemas/wire/README.md
// The beginning of a name and an asterisk; a value is a word or a number.
constexpr size_t kMaxScope = kMaxStationName + 1, kMaxSetting = 64;
constexpr int64_t kMaxMinutes = 7 * 24 * 60;
// 128 bits: nobody guesses it within the week that it may be good for.
constexpr size_t kCodeBytes = 16;

// The time in memory is newer than the stored one, which follows once a minute.
UnixMs LastSeenMs(const Call& call, const StationRow& row) {
  return call.stations == nullptr ? row.last_seen_ms
                                  : std::max(row.last_seen_ms, call.stations->HeardMs(row.id));
}

json::object StationJson(const Call& call, const StationRow& row) {
  return {{"id", row.id.Text()},
          {"name", row.name},
          {"revoked", row.revoked},
          {"revoked_ms", row.revoked_ms},
          {"enrolled_ms", row.enrolled_ms},
          {"last_seen_ms", LastSeenMs(call, row)},
          {"software", row.software},
          {"core_version", row.core_version},
          {"revision", row.revision}};
}

Result<Response> StationResponse(const Call& call, const StationRow& row) {
  return WithETag(JsonResponse(StationJson(call, row)), row.revision);
}

Status NoUnrevoking() {
  return {Code::kConflict,
          "a revoked station stays revoked, because others may know its secret; enrol it again "
          "with a new code",
          "revoked"};
}

Status RevokingIsApart() {
  return {Code::kInvalidInput,
          "expected no member revoked, found true; POST /api/v1/stations/{id}/revoke revokes",
          "revoked"};
}

}  // namespace

Result<Response> ListStations(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(Page page, PageOf(call.request, kMaxPage, kMaxPage));
  ENAMEL_ASSIGN_OR_RETURN(std::optional<bool> revoked, QueryFlag(call.request, "revoked"));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<StationRow> rows, store.stations.Stations());
  if (revoked) {
    std::erase_if(rows, [&](const StationRow& row) { return row.revoked != *revoked; });
  }
  json::value next =
      // Names may occur twice; the id makes each place in the list one row's.
      CutPage(rows, page, [](const StationRow& row) { return row.name + "\n" + row.id.Text(); });
  json::array stations;
  for (const StationRow& row : rows) stations.push_back(StationJson(call, row));
  return JsonResponse({{"stations", std::move(stations)}, {"next", std::move(next)}});
}

Result<Response> GetStation(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(StationRow row, store.stations.StationById(call.id));
  return StationResponse(call, row);
}

Result<Response> EditStation(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  // Understood in order to be refused with the reason: it is what somebody tries who wants a
  // revoked station back.
  bool unrevoke = body.Has("revoked") && !body.Flag("revoked", true);
  std::string wanted = body.Text("name", 1, kMaxStationName);
  if (unrevoke) return NoUnrevoking();
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  // Revoking wants the password again, which renaming does not.
  if (body.Has("revoked")) return RevokingIsApart();
  ENAMEL_ASSIGN_OR_RETURN(std::string name, CheckedName(wanted, "name"));
  ENAMEL_ASSIGN_OR_RETURN(int32_t seen, IfMatch(call.request));
  Result<StationRow> row = store.stations.RenameStation(call.id, name, seen, ActorOf(call));
  if (row.ok()) return StationResponse(call, *row);
  if (row.status().field() != kStale) return row.status();
  ENAMEL_ASSIGN_OR_RETURN(StationRow current, store.stations.StationById(call.id));
  return Stale(row.status(), StationJson(call, current), current.revision);
}

Result<Response> RevokeStation(const Call& call, Store& store) {
  ENAMEL_RETURN_IF_ERROR(RequireConfirmed(call));
  ENAMEL_RETURN_IF_ERROR(store.stations.RevokeStation(call.id, ActorOf(call)));
  return GetStation(call, store);
}

Result<Response> ListEnrolCodes(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(Page page, PageOf(call.request, kDefaultPage, kMaxPage));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<EnrolCodeRow> rows,
                          store.stations.OpenEnrolCodes(enamel::UnixMs()));
  json::value next = CutPage(rows, page, [](const EnrolCodeRow& row) { return row.id.Text(); });
  json::array codes;
  for (const EnrolCodeRow& row : rows) {
    codes.push_back(
        {{"id", row.id.Text()}, {"created_ms", row.created_ms}, {"expires_ms", row.expires_ms}});
  }
  return JsonResponse({{"codes", std::move(codes)}, {"next", std::move(next)}});
}

Result<Response> AddEnrolCode(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  int64_t minutes = body.Integer("minutes", 1, kMaxMinutes, 60);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_RETURN_IF_ERROR(RequireConfirmed(call));
  if (call.station_fingerprint.empty()) {
    return Status(Code::kNotFound, "this server accepts no stations");
  }
  Bytes random = auth::NewToken();
  random.resize(kCodeBytes);
  std::string code = ToHex(random);
  UnixMs expires_ms = enamel::UnixMs() + minutes * 60'000;
  // The hash alone is stored; the code is in this answer and nowhere else.
  ENAMEL_ASSIGN_OR_RETURN(
      Uuid id, store.stations.AddEnrolCode(HashSha256(AsBytes(code)), expires_ms, ActorOf(call)));
  return JsonResponse({{"id", id.Text()},
                       {"code", code + "@" + std::string(call.station_fingerprint)},
                       {"station_port", call.station_port},
                       {"expires_ms", expires_ms}},
                      201);
}

Result<Response> WithdrawEnrolCode(const Call& call, Store& store) {
  return DoneOr(store.stations.WithdrawEnrolCode(call.id, ActorOf(call)));
}

Result<Response> ListListedDevices(const Call&, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(std::vector<ListedDevice> rows, store.devices.ListedDevices());
  json::array devices;
  for (const ListedDevice& row : rows) {
    devices.push_back({{"name", row.name},
                       {"title", row.title},
                       {"added_ms", row.added_ms},
                       {"shook_ms", row.shook_ms}});
  }
  return JsonResponse({{"devices", std::move(devices)}});
}

Result<Response> ListDevice(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  const std::string name = body.Text("name", 1, kMaxHandTextBytes);
  const std::string title = body.Text("title", 1, kMaxHandTextBytes);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  if (Status done = store.devices.ListDevice(name, title, ActorOf(call)); !done.ok()) {
    return done;
  }
  return ListListedDevices(call, store);
}

Result<Response> UnlistDevice(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  const std::string name = body.Text("name", 1, kMaxHandTextBytes);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_RETURN_IF_ERROR(store.devices.UnlistDevice(name, ActorOf(call)));
  return ListListedDevices(call, store);
}

Result<Response> ListStationSettings(const Call&, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(const auto rows, store.settings.Settings());
  json::array out;
  for (const StationSetting& row : rows) {
    out.push_back({{"name", row.name},
                   {"scope", row.scope},
                   {"value", row.value},
                   {"fixed", row.fixed},
                   {"changed_ms", row.changed_ms}});
  }
  return JsonResponse({{"settings", std::move(out)}});
}

Result<Response> PutStationSetting(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  StationSetting setting;
  setting.name = body.Text("name", 1, kMaxSetting);
  if (body.Has("scope")) setting.scope = body.Text("scope", 1, kMaxScope);
  setting.value = body.Text("value", 1, kMaxSetting);
  setting.fixed = body.Flag("fixed", false);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_RETURN_IF_ERROR(store.settings.PutSetting(setting, ActorOf(call)));
  return ListStationSettings(call, store);
}

Result<Response> RemoveStationSetting(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  const std::string name = body.Text("name", 1, kMaxSetting);
  const std::string scope = body.Has("scope") ? body.Text("scope", 1, kMaxScope) : "*";
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_RETURN_IF_ERROR(store.settings.RemoveSetting(name, scope, ActorOf(call)));
  return ListStationSettings(call, store);
}

}  // namespace enamel::server::http

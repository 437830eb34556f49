#include <boost/json.hpp>

#include "common/scene/calibration.h"
#include "common/scene/cell.h"
#include "common/scene/json/json.h"
#include "common/scene/profile_criteria.h"
#include "server/http/caller.h"
#include "server/http/error_response.h"
#include "server/http/json_body.h"
#include "server/http/operations.h"
#include "server/http/paging.h"
#include "server/http/query.h"

namespace enamel::server::http {
namespace json = boost::json;
namespace {

constexpr const char* kMediaTypes[] = {"application/json", "text/html"};

json::array NumbersJson(const scene::DeviceProfile& profile) {
  struct Number {
    const char* name;
    const char* unit;
    const scene::Sourced& sourced;
  };
  std::vector<Number> numbers = {
      {"resolution", "nm", profile.resolution_nm},
      {"max_stiffness", "mN/mm", profile.max_stiffness_mn_per_mm},
      {"coupling", "mN/mm", profile.coupling_mn_per_mm},
      {"damping", "mN s/m", profile.damping_mn_s_per_m},
      {"friction", "mN", profile.friction_mn},
      {"mass", "g", profile.mass_g},
      {"peak_force", "mN", profile.peak_force_mn},
      {"continuous_force", "mN", profile.continuous_force_mn},
      {"rate", "Hz", profile.rate_hz},
      {"bus_delay", "ticks", profile.bus_delay_ticks},
      {"workspace_radius", "um", profile.workspace_radius_um},
  };
  // A number without a source was not given: it is optional, and 0 would be a claim.
  if (!profile.electrical_damping_mn_s_per_m.source.empty()) {
    numbers.push_back({"electrical_damping", "mN s/m", profile.electrical_damping_mn_s_per_m});
  }
  if (!profile.structural_mode_hz.source.empty())
    numbers.push_back({"structural_mode", "Hz", profile.structural_mode_hz});
  const std::string& of_cell = profile.cell ? profile.cell->source : profile.resolution_nm.source;
  const scene::Sourced count{scene::CountNm(profile), of_cell},
      support{scene::CellSupportNm(profile), of_cell};
  numbers.push_back({"count", "nm", count});
  numbers.push_back({"cell_support", "nm", support});
  if (profile.torque) {
    const scene::TorqueSpec& torque = *profile.torque;
    numbers.push_back({"axes", "driven", profile.axes});
    numbers.push_back({"peak_torque", "uN m", torque.peak_un_m});
    numbers.push_back({"torque_coupling", "uN m/rad", torque.coupling_un_m_per_rad});
    numbers.push_back({"torque_damping", "uN m s/rad", torque.damping_un_m_s_per_rad});
    numbers.push_back({"torque_friction", "uN m", torque.friction_un_m});
    numbers.push_back({"orientation_cell", "urad", torque.orientation_cell_urad});
  }
  json::array out;
  for (const Number& number : numbers) {
    out.push_back({{"name", number.name},
                   {"value", number.sourced.value},
                   {"unit", number.unit},
                   {"source", number.sourced.source}});
  }
  return out;
}

json::array CriteriaJson(const std::vector<scene::ProfileCriterion>& criteria) {
  json::array out;
  for (const scene::ProfileCriterion& criterion : criteria) {
    out.push_back({{"name", criterion.name},
                   {"title", criterion.title},
                   {"formula", criterion.formula},
                   {"unit", criterion.unit},
                   {"value", criterion.value},
                   {"limit", criterion.limit},
                   {"at_least", criterion.at_least},
                   {"met", criterion.met}});
  }
  return out;
}

json::object VersionJson(const ProfileRow& row) {
  return {{"version", row.version},
          {"title", row.title},
          {"content", row.content.Hex()},
          {"created_ms", row.created_ms}};
}

json::object ReportJson(const ProfileReportRow& row) {
  return {{"id", row.id.Text()},
          {"version", row.version},
          {"media_type", row.media_type},
          {"bytes", row.bytes},
          {"created_ms", row.created_ms}};
}

json::object CalibrationJson(const CalibrationRow& row) {
  json::error_code error;
  // It was checked on arrival. If it is unreadable anyway, the row is shown without it.
  json::value document = json::parse(row.document, error);
  return {{"id", row.id.Text()},
          {"device", row.device},
          {"measured_ms", row.measured_ms},
          {"added_ms", row.added_ms},
          {"document", error ? json::value() : document}};
}

Result<scene::DeviceProfile> Document(StoredBlobs& blobs, const ProfileRow& row) {
  Result<Bytes> bytes = blobs.GetBlob(row.content);
  if (!bytes.ok()) return Status{Code::kInternal, bytes.status().message()};
  Result<scene::DeviceProfile> profile = scene::ProfileFromJson(AsText(*bytes));
  if (!profile.ok()) return Status{Code::kInternal, profile.status().message()};
  return profile;
}

Result<json::object> ProfileJson(StoredBlobs& blobs, const ProfileRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(scene::DeviceProfile profile, Document(blobs, row));
  return json::object{{"name", row.name},
                      {"title", row.title},
                      {"version", row.version},
                      {"created_ms", row.created_ms},
                      {"numbers", NumbersJson(profile)}};
}

// Newest first. Errors: kNotFound.
Result<std::vector<ProfileRow>> VersionsOf(const Call& call, ProfileRows& profiles) {
  Result<std::vector<ProfileRow>> rows = profiles.ProfileVersions(std::string(call.name));
  if (!rows.ok() || !rows->empty()) return rows;
  return Status{Code::kNotFound, "there is no such device profile", "name"};
}

// What the page acts upon: every condition with its figures, also when the profile is refused.
Result<Response> Judgement(const std::vector<scene::ProfileCriterion>& criteria, json::object out,
                           int status) {
  out["acceptable"] = scene::IsAcceptable(criteria);
  out["criteria"] = CriteriaJson(criteria);
  if (scene::IsAcceptable(criteria)) return JsonResponse(out, status);
  for (const scene::ProfileCriterion& criterion : criteria) {
    // The first one that is not met is the error's text; all of them are in `criteria`.
    if (criterion.met) continue;
    out["error"] = {
        {"code", "invalid_input"},
        {"message", "expected " + criterion.formula + ", found " +
                        json::serialize(json::value(criterion.value)) + " against " +
                        json::serialize(json::value(criterion.limit)) + " " + criterion.unit +
                        "; change " + criterion.member + ", or measure the device again"},
        {"field", criterion.member}};
    break;
  }
  return JsonResponse(out, 400);
}

// A page of rows that are ordered newest first: the place in that order is the cursor.
template <typename Row, typename Json>
Result<Response> ListOf(const Call& call, const char* name, const Result<std::vector<Row>>& rows,
                        const Json& json_of) {
  ENAMEL_RETURN_IF_ERROR(rows.status());
  ENAMEL_ASSIGN_OR_RETURN(Page page, PageOf(call.request, kDefaultPage, kMaxPage));
  struct Placed {
    std::string place;
    const Row* row;
  };
  std::vector<Placed> placed;
  for (const Row& row : *rows) {
    // Counted from the oldest, so that new ones move nothing.
    std::string place = std::to_string(1'000'000'000 - (rows->size() - placed.size()));
    placed.push_back({place, &row});
  }
  json::value next = CutPage(placed, page, [](const Placed& entry) { return entry.place; });
  json::array out;
  for (const Placed& entry : placed) out.push_back(json_of(*entry.row));
  return JsonResponse({{name, std::move(out)}, {"next", std::move(next)}});
}

}  // namespace

Result<Response> ListProfiles(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(Page page, PageOf(call.request, kDefaultPage, kMaxPage));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<ProfileRow> rows, store.profiles.Profiles());
  json::value next = CutPage(rows, page, [](const ProfileRow& row) { return row.name; });
  json::array profiles;
  for (const ProfileRow& row : rows) {
    ENAMEL_ASSIGN_OR_RETURN(json::object profile, ProfileJson(store.blobs, row));
    profiles.push_back(std::move(profile));
  }
  return JsonResponse({{"profiles", std::move(profiles)}, {"next", std::move(next)}});
}

Result<Response> GetProfile(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(std::vector<ProfileRow> rows, VersionsOf(call, store.profiles));
  ENAMEL_ASSIGN_OR_RETURN(json::object out, ProfileJson(store.blobs, rows.front()));
  ENAMEL_ASSIGN_OR_RETURN(scene::DeviceProfile profile, Document(store.blobs, rows.front()));
  out.emplace("document", json::parse(scene::ToJson(profile)));
  auto criteria = scene::CheckProfile(profile);
  out.emplace("acceptable", scene::IsAcceptable(criteria));
  out.emplace("criteria", CriteriaJson(criteria));
  return JsonResponse(out);
}

Result<Response> PutProfile(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(std::optional<bool> dry_run, QueryFlag(call.request, "dry_run"));
  Result<scene::DeviceProfile> profile = scene::ProfileFromJson(call.request.body);
  if (!profile.ok()) {
    bool theirs = profile.status().code() == Code::kVersion;
    return theirs
               ? Status{Code::kInvalidInput, profile.status().message(), profile.status().field()}
               : profile.status();
  }
  auto criteria = scene::CheckProfile(*profile);
  json::object out{{"name", profile->name}, {"stored", false}, {"version", nullptr}};
  if (dry_run.value_or(false) || !scene::IsAcceptable(criteria)) {
    return Judgement(criteria, std::move(out), 200);
  }
  ENAMEL_ASSIGN_OR_RETURN(Sha256 content, store.blobs.PutBlob(AsBytes(scene::ToJson(*profile))));
  ENAMEL_RETURN_IF_ERROR(
      store.profiles.PutProfile({profile->name, profile->title, content}, ActorOf(call)));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<ProfileRow> rows,
                          store.profiles.ProfileVersions(profile->name));
  out["stored"] = true;
  out["version"] = rows.front().version;
  return Judgement(criteria, std::move(out), 201);
}

Result<Response> ListProfileVersions(const Call& call, Store& store) {
  return ListOf(call, "versions", VersionsOf(call, store.profiles), VersionJson);
}

Result<Response> ListProfileReports(const Call& call, Store& store) {
  if (auto there = VersionsOf(call, store.profiles); !there.ok()) return there.status();
  return ListOf(call, "reports", store.profiles.ProfileReports(std::string(call.name)), ReportJson);
}

Result<Response> AddProfileReport(const Call& call, Store& store) {
  std::string_view given = call.request.Header("content-type");
  given = given.substr(0, given.find(';'));
  ProfileReportRow row;
  row.profile = std::string(call.name);
  for (const char* type : kMediaTypes) {
    // One of our own texts and never the caller's: it becomes a header when the report is handed
    // out.
    if (given == type) row.media_type = type;
  }
  if (row.media_type.empty()) {
    return ErrorResponse(415, "unsupported_media_type",
                         "expected Content-Type: application/json or text/html", "content-type");
  }
  json::error_code error;
  if (row.media_type == kMediaTypes[0]) {
    json::parse_options options;
    // The page's own components show a report and check it again; this only refuses invalid JSON.
    options.max_depth = 32;
    (void)json::parse(call.request.body, error, {}, options);
  }
  if (error || call.request.body.empty()) {
    return Status(Code::kInvalidInput, "expected what `enamel-lab qualify` wrote as body", "body");
  }
  if (auto there = VersionsOf(call, store.profiles); !there.ok()) return there.status();
  ENAMEL_ASSIGN_OR_RETURN(Sha256 content, store.blobs.PutBlob(AsBytes(call.request.body)));
  row.content = content;
  row.bytes = call.request.body.size();
  ENAMEL_ASSIGN_OR_RETURN(ProfileReportRow added,
                          store.profiles.AddProfileReport(row, ActorOf(call)));
  return JsonResponse(ReportJson(added), 201);
}

// Never shown inside the page: somebody's HTML under our own address could act as the page.
Result<Response> GetProfileReport(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(ProfileReportRow row, store.profiles.ProfileReportById(call.id));
  Result<Bytes> bytes = store.blobs.GetBlob(row.content);
  if (!bytes.ok()) return Status(Code::kInternal, bytes.status().message());
  Response response;
  response.content_type = row.media_type;
  response.body = AsText(*bytes);
  // Safe inside quotes: a profile's name is a-z, 0-9, _ and - only.
  std::string name = row.profile + "-" + std::to_string(row.version) +
                     (row.media_type == kMediaTypes[0] ? ".json" : ".html");
  response.headers.emplace_back("Content-Disposition", "attachment; filename=\"" + name + "\"");
  return response;
}

Result<Response> ListCalibrations(const Call& call, Store& store) {
  if (auto there = VersionsOf(call, store.profiles); !there.ok()) return there.status();
  return ListOf(call, "calibrations", store.profiles.Calibrations(std::string(call.name)),
                CalibrationJson);
}

Result<Response> AddCalibration(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  Result<scene::Calibration> calibration = scene::CalibrationFromJson(call.request.body);
  if (!calibration.ok()) {
    const Status& why = calibration.status();
    return Status(Code::kInvalidInput, why.message(), why.field());
  }
  // The address names the profile and so does the document; this finds a file sent to the wrong
  // profile.
  if (calibration->profile != call.name) {
    return Status(Code::kInvalidInput,
                  "expected a calibration of \"" + std::string(call.name) + "\", found one of \"" +
                      calibration->profile + "\"",
                  "profile");
  }
  CalibrationRow row;
  row.profile = calibration->profile;
  row.device = calibration->device;
  row.measured_ms = calibration->measured_ms;
  row.document = scene::ToJson(*calibration);
  ENAMEL_ASSIGN_OR_RETURN(CalibrationRow added, store.profiles.AddCalibration(row, ActorOf(call)));
  return JsonResponse(CalibrationJson(added), 201);
}

}  // namespace enamel::server::http

#include "server/commands/admin_stations.h"

#include <set>

#include "common/base/file.h"
#include "common/base/hex.h"
#include "common/base/in_document.h"
#include "common/scene/calibration.h"
#include "common/scene/find_profile.h"
#include "common/scene/json/json.h"
#include "common/scene/profile_criteria.h"
#include "server/app/data_folder.h"
#include "server/commands/command_line.h"
#include "server/commands/say.h"

namespace enamel::server::app {
namespace {

// As for a document that comes over the API.
constexpr size_t kMaxDocument = 1 << 20;

Result<std::string> ReadText(const std::filesystem::path& file) {
  ENAMEL_ASSIGN_OR_RETURN(auto bytes, ReadFile(file, kMaxDocument));
  return std::string(AsText(bytes));
}

void Show(const std::vector<scene::ProfileCriterion>& criteria) {
  for (const scene::ProfileCriterion& criterion : criteria) {
    Say("{:<4} {:<42} {:<26} {:.6g} against {:.6g} {}\n", criterion.met ? "ok" : "FAIL",
        criterion.title, criterion.formula, criterion.value, criterion.limit, criterion.unit);
  }
}

std::string MeasuredText(const std::optional<scene::Measured>& measured) {
  if (!measured) return "-";
  return fmt::format("{} ± {}", measured->value, measured->uncertainty);
}

}  // namespace

Result<StationRow> StationNamed(StationRows& stations_rows, const std::string& text) {
  // An id identifies one station whatever the names are, so it is tried first.
  if (auto id = Uuid::Parse(text); id.ok()) {
    auto station = stations_rows.StationById(*id);
    if (!station.ok() || !station->revoked) return station;
    return Status(Code::kNotFound, "station " + text + " is no longer admitted", "station");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto stations, stations_rows.Stations());
  // Revoked ones do not count: a bench that enrolled again has its name twice, and the old row is
  // not the one meant.
  std::erase_if(stations, [&](const StationRow& row) { return row.revoked || row.name != text; });
  if (stations.size() == 1) return stations.front();
  return Status(Code::kNotFound,
                stations.empty() ? "no admitted station is called \"" + text + "\""
                                 : std::to_string(stations.size()) + " stations are called \"" +
                                       text + "\"; give the id that admin list-stations shows",
                "station");
}

Status ListStations(const std::filesystem::path& data) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto stations, store->stations.Stations());
  for (const StationRow& row : stations) {
    Say("{}  {:<24} {:<8} last seen {} UTC  {}{}\n", row.id.Text(), row.name,
        row.revoked ? "revoked" : "admitted", UtcText(row.last_seen_ms),
        row.software.empty() ? "-" : row.software,
        row.core_version == 0 ? "" : fmt::format(", core {}", row.core_version));
    Say("{:36}  key {}\n", "", ToHex(row.public_key));
  }
  // What `enamel-station verify` asks for on a computer that is no station of this server.
  ENAMEL_ASSIGN_OR_RETURN(auto identity, EnsureIdentity(data));
  Say("key of this server's tickets and results  {}\n", ToHex(identity.ticket_key.public_key));
  return Status::Ok();
}

Status ListAwaited(const std::filesystem::path& data) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  AuditFilter filter;
  // Waiting recordings are at the stations and in no table here. Only the audit trail has the
  // missing thing of each refusal.
  filter.action = "attempt.awaits";
  filter.limit = 1000;
  ENAMEL_ASSIGN_OR_RETURN(auto rows, store->audit.FindAudit(filter));
  std::set<std::string> seen;  // newest first: the last word about each attempt counts
  size_t waiting = 0;
  for (const AuditRow& row : rows) {
    auto attempt = Uuid::Parse(row.object);
    if (!attempt.ok() || !seen.insert(row.object).second) continue;
    auto known = store->attempts.AttemptById(*attempt);
    // Taken since: the missing thing has come back.
    if (known.ok()) continue;
    if (known.status().code() != Code::kNotFound) return known.status();
    ++waiting;
    Say("{}  at {}  since {} UTC  awaits {}\n", row.object, row.actor, UtcText(row.at_ms),
        row.after_json);
  }
  if (waiting == 0) {
    Say("nothing waits\n");
    return Status::Ok();
  }
  Say("person: admin add-person --id ID; exercise: publish the same document; profile: admin "
      "put-profile with the same document. Stations offer the recordings again by themselves\n");
  return Status::Ok();
}

Status RevokeStation(const std::filesystem::path& data, const std::string& station) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto row, StationNamed(store->stations, station));
  ENAMEL_RETURN_IF_ERROR(store->stations.RevokeStation(row.id, kCommandLine));
  Say("{} ({}) is no longer admitted; to use it again, enrol it with a new code\n", row.name,
      row.id.Text());
  return Status::Ok();
}

Status ListDevice(const std::filesystem::path& data, const std::string& name,
                  const std::string& title) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_RETURN_IF_ERROR(store->devices.ListDevice(name, title, kCommandLine));
  Say("graded work may now be done with the haptic device {} ({})\n", name, title);
  return Status::Ok();
}

Status UnlistDevice(const std::filesystem::path& data, const std::string& name) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_RETURN_IF_ERROR(store->devices.UnlistDevice(name, kCommandLine));
  Say("{} is no longer on the list; what was done with it stays\n", name);
  return Status::Ok();
}

Status ListListedDevices(const std::filesystem::path& data) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto rows, store->devices.ListedDevices());
  for (const ListedDevice& row : rows) {
    Say("{:<40} {:<24} since {} UTC\n", row.name, row.title, UtcText(row.added_ms));
  }
  if (rows.empty()) Say("no device is listed: admin list-device NAME --title TEXT lists one\n");
  return Status::Ok();
}

Status SetStations(const std::filesystem::path& data, const StationSetting& setting) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_RETURN_IF_ERROR(store->settings.PutSetting(setting, kCommandLine));
  Say("{} is {} at {}{}; a station gets it when it connects, and its programs use it when they "
      "start\n",
      setting.name, setting.value, setting.scope == "*" ? "every station" : setting.scope,
      setting.fixed ? ", whatever its own settings file says" : "");
  return Status::Ok();
}

Status UnsetStations(const std::filesystem::path& data, const std::string& name,
                     const std::string& scope) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_RETURN_IF_ERROR(store->settings.RemoveSetting(name, scope, kCommandLine));
  Say("{} is no longer set for {}\n", name, scope);
  return Status::Ok();
}

Status ListStationSettings(const std::filesystem::path& data) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto rows, store->settings.Settings());
  for (const StationSetting& row : rows) {
    Say("{:<14} {:<20} {:<12} {:<6} since {} UTC\n", row.name, row.scope, row.value,
        row.fixed ? "fixed" : "", UtcText(row.changed_ms));
  }
  if (rows.empty())
    Say("stations keep their own settings: admin set-stations NAME VALUE sets one\n");
  return Status::Ok();
}

Status PutProfile(const std::filesystem::path& data, const std::string& name_or_path,
                  bool check_only) {
  ENAMEL_ASSIGN_OR_RETURN(auto profile, scene::FindProfile(name_or_path));
  auto criteria = scene::CheckProfile(profile);
  // Also when all is well: an admin who lets a device into a course sees by how much each criterion
  // is met.
  Show(criteria);
  if (!scene::IsAcceptable(criteria)) {
    return {Code::kInvalidInput, "device profile \"" + profile.name +
                                     "\" does not meet every criterion above; nothing was stored"};
  }
  // Before the data folder is opened, so that a profile can be checked where there is none.
  if (check_only) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  // Our own writer formats it: the same profile has the same hash, whatever the layout of the file.
  ENAMEL_ASSIGN_OR_RETURN(auto content, store->blobs.PutBlob(AsBytes(scene::ToJson(profile))));
  ENAMEL_RETURN_IF_ERROR(
      store->profiles.PutProfile({profile.name, profile.title, content}, kCommandLine));
  ENAMEL_ASSIGN_OR_RETURN(auto versions, store->profiles.ProfileVersions(profile.name));
  Say("device profile \"{}\" version {}\n", profile.name, versions.front().version);
  return Status::Ok();
}

Status AddProfileReport(const std::filesystem::path& data, const std::string& profile,
                        const std::filesystem::path& file) {
  ENAMEL_ASSIGN_OR_RETURN(auto bytes, ReadFile(file, kMaxDocument));
  ProfileReportRow row;
  row.profile = profile;
  row.bytes = bytes.size();
  std::string extension = file.extension().string();
  row.media_type = extension == ".json" ? "application/json" : "text/html";
  if (extension != ".json" && extension != ".html") {
    return {Code::kInvalidInput,
            "a report is a .html or .json file of `enamel-lab qualify --report`, found " +
                file.string()};
  }
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto content, store->blobs.PutBlob(bytes));
  row.content = content;
  ENAMEL_ASSIGN_OR_RETURN(auto added, store->profiles.AddProfileReport(row, kCommandLine));
  Say("report {} about \"{}\" version {}\n", added.id.Text(), profile, added.version);
  return Status::Ok();
}

Status AddCalibration(const std::filesystem::path& data, const std::filesystem::path& file) {
  ENAMEL_ASSIGN_OR_RETURN(auto text, ReadText(file));
  auto calibration = scene::CalibrationFromJson(text);
  if (!calibration.ok()) return InDocument(file.string(), calibration.status());
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  CalibrationRow row;
  row.profile = calibration->profile;
  row.device = calibration->device;
  row.measured_ms = calibration->measured_ms;
  row.document = scene::ToJson(*calibration);
  ENAMEL_ASSIGN_OR_RETURN(auto added, store->profiles.AddCalibration(row, kCommandLine));
  Say("calibration {} of {}, profile \"{}\"\n", added.id.Text(), row.device, row.profile);
  return Status::Ok();
}

Status ListCalibrations(const std::filesystem::path& data, const std::string& profile) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto rows, store->profiles.Calibrations(profile));
  for (const CalibrationRow& row : rows) {
    ENAMEL_ASSIGN_OR_RETURN(auto calibration, scene::CalibrationFromJson(row.document));
    Say("{} UTC  {}  resolution {} nm, noise {} nm, friction {} mN, damping {} mN s/m, mass {} g, "
        "delay {} ticks, answers {} us, jitter {} us\n",
        UtcText(row.measured_ms), row.device, MeasuredText(calibration.resolution_nm),
        MeasuredText(calibration.noise_nm), MeasuredText(calibration.friction_mn),
        MeasuredText(calibration.damping_mn_s_per_m), MeasuredText(calibration.mass_g),
        MeasuredText(calibration.bus_delay_ticks), MeasuredText(calibration.answer_us),
        MeasuredText(calibration.answer_jitter_us));
  }
  if (rows.empty()) Say("no device of profile \"{}\" was measured yet\n", profile);
  return Status::Ok();
}

void DeclareStations(CommandGroup admin) {
  struct Folder {
    std::filesystem::path data;
    std::string station;
  };
  auto [list, l] =
      Declare<Folder>(admin, "list-stations", "Stations by name: admitted, seen, software",
                      [](const Folder& o) { return ListStations(o.data); });
  AddData(list, l.data);
  AddExample(list, "");

  auto [awaited, a] = Declare<Folder>(
      admin, "list-awaited", "Recordings that wait at stations for something a restore has lost",
      [](const Folder& o) { return ListAwaited(o.data); });
  AddData(awaited, a.data);
  AddExample(awaited, "");

  auto [revoke, r] =
      Declare<Folder>(admin, "revoke-station", "Revoke a station permanently",
                      [](const Folder& o) { return RevokeStation(o.data, o.station); });
  AddData(revoke, r.data);
  revoke->add_option("--station", r.station, "Its name, or the id list-stations shows")->required();
  AddExample(revoke, "--station chair-07");

  struct Listing {
    std::filesystem::path data;
    std::string name, title;
  };
  auto [put, p] =
      Declare<Listing>(admin, "list-device", "Allow a haptic device for graded work",
                       [](const Listing& o) { return ListDevice(o.data, o.name, o.title); });
  put->add_option("NAME", p.name,
                  "Its unit, as `enamel-station devices` shows it; its model where it has none")
      ->required();
  AddData(put, p.data);
  put->add_option("--title", p.title, "For people: \"chair 3\"")->required();
  AddExample(put, "omega3:1234 --title \"chair 3\"");

  auto [take, t] = Declare<Listing>(admin, "unlist-device", "Take it off that list",
                                    [](const Listing& o) { return UnlistDevice(o.data, o.name); });
  take->add_option("NAME", t.name, "As list-listed-devices shows it")->required();
  AddData(take, t.data);
  AddExample(take, "omega3:1234");

  auto [show, s] = Declare<Listing>(admin, "list-listed-devices",
                                    "Haptic devices that are allowed for graded work",
                                    [](const Listing& o) { return ListListedDevices(o.data); });
  AddData(show, s.data);
  AddExample(show, "");
}

void DeclareStationSettings(CommandGroup admin) {
  struct Setting {
    std::filesystem::path data;
    StationSetting row;
  };
  constexpr const char* kScope =
      "\"lab2-*\": stations whose names begin with lab2-; or one station's name; else every "
      "station";
  auto [set, p] = Declare<Setting>(admin, "set-stations", "Set a setting of stations from here",
                                   [](const Setting& o) { return SetStations(o.data, o.row); });
  set->add_option("NAME", p.row.name, "As in a station's settings file: language")->required();
  set->add_option("VALUE", p.row.value, "Its value: de")->required();
  AddData(set, p.data);
  set->add_option("--at", p.row.scope, kScope)->capture_default_str();
  set->add_flag("--fixed", p.row.fixed, "Before the station's own settings file, not behind it");
  AddExample(set, "language de --at \"lab2-*\"");

  auto [unset, u] = Declare<Setting>(
      admin, "unset-stations", "Leave a setting to stations again",
      [](const Setting& o) { return UnsetStations(o.data, o.row.name, o.row.scope); });
  unset->add_option("NAME", u.row.name, "As list-station-settings shows it")->required();
  AddData(unset, u.data);
  unset->add_option("--at", u.row.scope, kScope)->capture_default_str();
  AddExample(unset, "language --at \"lab2-*\"");

  auto [show, s] =
      Declare<Setting>(admin, "list-station-settings", "What stations are set to from here",
                       [](const Setting& o) { return ListStationSettings(o.data); });
  AddData(show, s.data);
  AddExample(show, "");
}

void DeclareProfiles(CommandGroup admin) {
  struct Document {
    std::filesystem::path data, file;
    std::string profile;
    bool check_only = false;
  };
  auto [put, p] = Declare<Document>(
      admin, "put-profile", "Check a device profile and store it",
      [](const Document& o) { return PutProfile(o.data, o.profile, o.check_only); });
  put->add_option("PROFILE", p.profile,
                  "A built-in profile's name, as phantom_desktop, or a document: FILE.json "
                  "(schemas/device_profile.schema.json)")
      ->required();
  AddData(put, p.data);
  put->add_flag("--check", p.check_only, "Only show the criteria with their figures");
  AddExample(put, "omega3.json --check");

  auto [report, r] = Declare<Document>(
      admin, "add-report", "Attach a qualification report to a profile",
      [](const Document& o) { return AddProfileReport(o.data, o.profile, o.file); });
  report->add_option("FILE", r.file, "What `enamel-lab qualify --report` wrote")
      ->required()
      ->check(CLI::ExistingFile);
  AddData(report, r.data);
  report->add_option("--profile", r.profile, "Name of the profile")->required();
  AddExample(report, "omega3-report.json --profile omega3");

  auto [add, a] =
      Declare<Document>(admin, "add-calibration", "Store a device's calibration",
                        [](const Document& o) { return AddCalibration(o.data, o.file); });
  add->add_option("FILE", a.file, "What `enamel-station calibrate` wrote")
      ->required()
      ->check(CLI::ExistingFile);
  AddData(add, a.data);
  AddExample(add, "today.json");

  auto [list, l] =
      Declare<Document>(admin, "list-calibrations", "Calibrations of the devices of a profile",
                        [](const Document& o) { return ListCalibrations(o.data, o.profile); });
  AddData(list, l.data);
  list->add_option("--profile", l.profile, "Name of the profile")->required();
  AddExample(list, "--profile omega3");
}

}  // namespace enamel::server::app

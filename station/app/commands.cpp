#include "station/app/commands.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <cstdio>

#include "common/base/file.h"
#include "common/import/scene_folder.h"
#include "common/scene/builtin.h"
#include "common/scene/json.h"
#include "station/app/places.h"
#include "station/app/simulate.h"
#include "station/devices/operators.h"
#include "station/spool/spool.h"
#include "station/uplink/private_folder.h"
#include "station/uplink/uploader.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;
using unsigned_ll = unsigned long long;

const char* StateOf(const SpooledAttempt& a) {
  if (!a.refused.empty()) return "refused";
  if (a.complete()) return "uploaded";
  return a.seal ? "waiting" : "unfinished";
}

Result<std::unique_ptr<Spool>> OpenSpool(const fs::path& data) {
  ENAMEL_RETURN_IF_ERROR(MakePrivateFolder(data));
  return Spool::Open(data);
}

const scene::DeviceProfile* FindProfile(const std::vector<scene::DeviceProfile>& all,
                                        const std::string& name) {
  auto it = std::find_if(all.begin(), all.end(), [&](const auto& p) { return p.name == name; });
  return it == all.end() ? nullptr : &*it;
}

Result<scene::BuiltScene> LoadScene(const std::string& source, int voxel_um) {
  constexpr std::string_view kBuiltin = "builtin:";
  if (source.starts_with(kBuiltin)) {
    return scene::BuildBuiltinScene(source.substr(kBuiltin.size()), voxel_um * 1000);
  }
  auto folder = import::LoadSceneFolder(source);
  if (!folder.ok()) return folder.status();
  return scene::BuiltScene{std::move(folder->scene), std::move(folder->volume)};
}

}  // namespace

Status EnrolStation(const EnrolOptions& options) {
  auto server = net::ParseEndpoint(options.server);
  if (!server.ok()) return server.status();
  auto code = ParseEnrolCode(options.code);
  if (!code.ok()) return code.status();
  if (fs::exists(options.data / "station.json")) {
    return Status(Code::kConflict,
                  (options.data / "station.json").string() +
                      " exists: this station is enrolled already. Its recordings "
                      "are signed with that key: upload them before you move it away");
  }
  // Before the code is used up.
  ENAMEL_RETURN_IF_ERROR(MakePrivateFolder(options.data));
  ENAMEL_RETURN_IF_ERROR(CheckOutputFile(options.data / "station.json", "--data"));
  auto credentials = ServerLink::Enrol(*server, *code, options.name);
  if (!credentials.ok()) return credentials.status();
  ENAMEL_RETURN_IF_ERROR(SaveCredentials(options.data, *credentials));
  std::printf("enrolled as station %s (%s) at %s\n", credentials->name.c_str(),
              credentials->station.Text().c_str(), credentials->server.Text().c_str());
  return Status::Ok();
}

Status UploadSpool(const fs::path& data, const std::string& server) {
  auto credentials = LoadCredentialsFor(data, server);
  if (!credentials.ok()) return credentials.status();
  auto spool = Spool::Open(data);
  if (!spool.ok()) return spool.status();
  auto attempts = (*spool)->List();
  if (!attempts.ok()) return attempts.status();
  ServerLink link;
  Status worst;
  int sent = 0;
  for (const SpooledAttempt& attempt : *attempts) {
    if (attempt.complete() || !attempt.refused.empty()) continue;
    // Broken off, and the server has all there is of it.
    if (!attempt.seal && attempt.committed == attempt.chunks) continue;
    if (!link.connected()) ENAMEL_RETURN_IF_ERROR(link.Connect(*credentials));
    Status status = UploadAttempt(link, **spool, attempt.id);
    if (!status.ok() && IsTransient(status)) return status;
    auto after = (*spool)->Get(attempt.id);
    if (!after.ok()) return after.status();
    std::printf("%s  %s  %u of %u chunks  %s\n", attempt.id.Text().c_str(), StateOf(*after),
                after->committed, after->chunks, status.message().c_str());
    if (status.ok() && !after->seal) {
      std::printf(
          "  no end of it is recorded (it broke off, or goes on): it is kept here and on the "
          "server, and not scored\n");
    }
    if (!status.ok()) worst = status;
    ++sent;
  }
  if (sent == 0) std::printf("nothing to upload\n");
  return worst;
}

Status ListSpool(const fs::path& data) {
  auto spool = OpenSpool(data);
  if (!spool.ok()) return spool.status();
  auto attempts = (*spool)->List();
  if (!attempts.ok()) return attempts.status();
  if (attempts->empty()) std::printf("the spool %s is empty\n", (*spool)->file().c_str());
  for (const SpooledAttempt& a : *attempts) {
    std::printf("%s  %-10s  %s on %s  %llu ticks  %u of %u chunks on the server  %.1f kB%s%s\n",
                a.id.Text().c_str(), StateOf(a), a.exercise.c_str(), a.profile.c_str(),
                static_cast<unsigned_ll>(a.ticks), a.committed, a.chunks,
                static_cast<double>(a.bytes) / 1000, a.refused.empty() ? "" : ": ",
                a.refused.c_str());
  }
  return Status::Ok();
}

Status VerifySpool(const fs::path& data) {
  auto spool = OpenSpool(data);
  if (!spool.ok()) return spool.status();
  std::optional<trace::PublicKey> key;
  if (auto credentials = LoadCredentials(data); credentials.ok()) key = credentials->public_key();
  auto verdicts = (*spool)->Verify(key);
  if (!verdicts.ok()) return verdicts.status();
  Status worst;
  for (const SpoolVerdict& v : *verdicts) {
    std::printf("%s  %s\n", v.attempt.id.Text().c_str(),
                v.status.ok() ? "whole" : v.status.message().c_str());
    if (!v.status.ok()) {
      worst = Status(v.status.code(), "attempt " + v.attempt.id.Text() + ": " + v.status.message());
    }
  }
  if (worst.ok()) {
    std::printf("%zu attempts: chains%s and seals are right\n", verdicts->size(),
                key ? ", signatures" : "");
  }
  return worst;
}

Status ExportFromSpool(const fs::path& data, const std::string& attempt, const fs::path& out) {
  auto id = Uuid::Parse(attempt);
  if (!id.ok()) return id.status();
  auto spool = Spool::Open(data);
  if (!spool.ok()) return spool.status();
  ENAMEL_RETURN_IF_ERROR(CheckOutputFile(out, "--out"));
  auto file = (*spool)->Export(*id);
  if (!file.ok()) return file.status();
  Bytes bytes = trace::EncodeTraceFile(*file);
  ENAMEL_RETURN_IF_ERROR(WriteFileDurably(out, bytes, 0600));
  std::printf("%s: %zu chunks, %zu bytes%s\n", out.c_str(), file->chunks.size(), bytes.size(),
              file->seal ? ", sealed" : ", not sealed");
  return Status::Ok();
}

Status SimulateAttempt(const SimulateCommand& options) {
  ENAMEL_RETURN_IF_ERROR(CheckOutputFile(options.json, "--json"));
  auto built = LoadScene(options.scene, options.voxel_um);
  if (!built.ok()) return built.status();
  std::vector<scene::DeviceProfile> profiles = scene::BuiltinProfiles();
  const scene::DeviceProfile* profile = FindProfile(profiles, options.profile);
  if (profile == nullptr) {
    return Status(Code::kNotFound,
                  "no device profile '" + options.profile +
                      "': 'enamel-station profiles' shows those there are",
                  "profile");
  }
  scene::Exercise exercise =
      scene::ClassOneExercise(built->scene, HashSha256(AsBytes(scene::ToJson(built->scene))));
  auto report = Simulate(*built, exercise, *profile, options.operator_name, options.seed);
  if (!report.ok()) return report.status();
  double rate = exercise.rate_hz;
  std::printf("%s cuts '%s' on %s: %llu ticks (%.0f s), computed in %.1f s\n",
              options.operator_name.c_str(), built->scene.name.c_str(), profile->name.c_str(),
              static_cast<unsigned_ll>(report->ticks), static_cast<double>(report->ticks) / rate,
              report->seconds);
  std::printf("force sent: median %.2f N, 95 %% %.2f N, peak %.2f N; bounded in %llu ticks\n",
              report->force_p50_n, report->force_p95_n, report->force_max_n,
              static_cast<unsigned_ll>(report->bounded_ticks));
  boost::json::object removed, planes;
  for (size_t t = 1; t < report->removed_mm3.size(); ++t) {
    if (report->removed_mm3[t] <= 0) continue;
    std::printf("removed %-9s %8.3f mm3\n", std::string(cutting::kTissueNames[t]).c_str(),
                report->removed_mm3[t]);
    removed[std::string(cutting::kTissueNames[t])] = report->removed_mm3[t];
  }
  std::printf("plane      median    mean     rms   um beyond the exercise's box\n");
  for (const PlaneError& p : report->planes) {
    std::printf("%-8s %+8.1f %+7.1f %7.1f\n", p.name.c_str(), p.median_um, p.mean_um, p.rms_um);
    planes[p.name] = p.median_um;
  }
  return WriteJsonFile(options.json, {{"ticks", report->ticks},
                                  {"force_p95_n", report->force_p95_n},
                                  {"force_max_n", report->force_max_n},
                                  {"state_hash", report->state_hash},
                                  {"removed_mm3", removed},
                                  {"plane_median_um", planes}});
}

void PrintDevices() {
  std::printf("simulated  always there; held by one of:\n");
  for (const OperatorPreset& p : OperatorPresets()) {
    std::printf("  %-20s %s\n", std::string(p.name).c_str(), std::string(p.summary).c_str());
  }
}

void PrintProfiles() {
  for (const scene::DeviceProfile& p : scene::BuiltinProfiles()) {
    std::printf("%s (%s)\n", p.name.c_str(), p.title.c_str());
    auto line = [](const char* what, const scene::Sourced& n, double unit, const char* name) {
      std::printf("  %-22s %10.4g %-8s %s\n", what, static_cast<double>(n.value) * unit, name,
                  n.source.c_str());
    };
    line("resolution", p.resolution_nm, 1e-3, "um");
    line("coupling Kc", p.coupling_mn_per_mm, 1e-3, "N/mm");
    line("maximum stiffness K", p.max_stiffness_mn_per_mm, 1e-3, "N/mm");
    line("damping b", p.damping_mn_s_per_m, 1e-3, "N s/m");
    line("friction c", p.friction_mn, 1e-3, "N");
    line("mass", p.mass_g, 1, "g");
    line("peak force", p.peak_force_mn, 1e-3, "N");
    line("continuous force", p.continuous_force_mn, 1e-3, "N");
    line("rate", p.rate_hz, 1, "Hz");
  }
}

}  // namespace enamel::station

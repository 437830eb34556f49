#include "station/app/commands.h"

#include <unistd.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <cstdio>

#include "common/base/file.h"
#include "common/base/pin.h"
#include "common/base/unix_time.h"
#include "common/base/utf8.h"
#include "common/import/scene_folder.h"
#include "common/program/example.h"
#include "common/program/input.h"
#include "common/program/output.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/find_profile.h"
#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "station/app/command_line.h"
#include "station/app/simulate.h"
#include "station/devices/operators.h"
#include "station/session/by_name.h"
#include "station/uplink/private_folder.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;
using unsigned_ll = unsigned long long;

Result<EnrolCode> CodeOf(const EnrolOptions& options, const std::string& name) {
  if (options.codes.empty()) return ParseEnrolCode(options.code);
  constexpr size_t kMaxTable = size_t{2} << 20;
  ENAMEL_ASSIGN_OR_RETURN(auto table, program::ReadInput(options.codes, kMaxTable));
  return FindEnrolCode(table, name);
}

}  // namespace

Status EnrolStation(const EnrolOptions& options) {
  ENAMEL_ASSIGN_OR_RETURN(auto server, net::ParseEndpoint(options.server));
  std::optional<Credentials> before;
  if (options.again) {
    ENAMEL_ASSIGN_OR_RETURN(auto loaded, LoadCredentials(options.data));
    before = loaded;
    // Its key signed the recordings in the spool. Enrolling over it would make those recordings
    // foreign.
  } else if (fs::exists(options.data / "station.json")) {
    return Status(
        Code::kConflict,
        (options.data / "station.json").string() +
            " exists: this station is enrolled already. Its recordings "
            "are signed with that key: upload them before you move it away. If the server "
            "was restored and no longer knows it, --again enrols it as the same station");
  }
  const bool keeps_name = options.name.empty() && before;
  ENAMEL_ASSIGN_OR_RETURN(auto code, CodeOf(options, keeps_name ? before->name : options.name));
  // Before the code is used up.
  ENAMEL_RETURN_IF_ERROR(MakePrivateFolder(options.data));
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options.data / "station.json", "--data"));
  ENAMEL_ASSIGN_OR_RETURN(auto credentials, ServerLink::Enrol(server, code, options.name, before));
  ENAMEL_RETURN_IF_ERROR(SaveCredentials(options.data, credentials));
  std::printf("enrolled as station %s (%s) at %s\n", credentials.name.c_str(),
              credentials.station.Text().c_str(), credentials.server.Text().c_str());
  return Status::Ok();
}

Status ReserveAttempt(const ReserveCommand& options) {
  ENAMEL_RETURN_IF_ERROR(CheckPin(options.pin));
  ENAMEL_ASSIGN_OR_RETURN(auto workplace, Workplace::Open(options.workplace));
  ENAMEL_ASSIGN_OR_RETURN(auto person, workplace->SignIn(options.login, options.password));
  ENAMEL_ASSIGN_OR_RETURN(auto prepared,
                          PrepareByName(*workplace, {options.exercise, {}, {}}, options.profile));
  ENAMEL_RETURN_IF_ERROR(workplace->Reserve(prepared, options.pin));
  std::printf("reserved for %s, for the next 12 hours at this station:\n",
              person.display_name.c_str());
  return ListReserved(options.workplace.data);
}

Status ListReserved(const fs::path& data) {
  ENAMEL_ASSIGN_OR_RETURN(auto spool, Spool::Open(data));
  ENAMEL_ASSIGN_OR_RETURN(auto tickets, TicketSafe(*spool).List());
  if (tickets.empty()) std::printf("nothing is reserved here\n");
  for (const LockedTicket& t : tickets) {
    const int64_t left_min = (t.expires_unix_ms - UnixMs()) / 60'000;
    std::printf("%s  %s: %s on %s, %lld h %02lld min left%s\n", t.attempt.Text().c_str(),
                Printable(t.person).c_str(), Printable(t.title).c_str(),
                Printable(t.profile).c_str(), static_cast<long long>(left_min / 60),
                static_cast<long long>(left_min % 60),
                spool->Get(t.attempt).ok() ? "  (begun)" : "");
  }
  return Status::Ok();
}

Status GiveBackReserved(const GiveBackCommand& options) {
  ENAMEL_ASSIGN_OR_RETURN(auto id, Uuid::Parse(options.attempt));
  if (options.pin.empty() && options.login.empty()) {
    return Status(Code::kInvalidInput,
                  "to give a ticket back, set its PIN in ENAMEL_PIN; if it is forgotten, name its "
                  "person with --user, password in ENAMEL_PASSWORD",
                  "pin");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto workplace, Workplace::Open(options.workplace));
  if (options.pin.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(auto person, workplace->SignIn(options.login, options.password));
  }
  // Requires the PIN or the person's password, so that others at this chair cannot hand it back.
  ENAMEL_ASSIGN_OR_RETURN(auto given, options.pin.empty() ? workplace->GiveBack(id)
                                                          : workplace->GiveBack(id, options.pin));
  std::printf("%s is given back: %s\n", options.attempt.c_str(),
              given == HandedBack::kAtServer
                  ? "it no longer counts"
                  : "it can no longer be used here; the server could not be reached, so this "
                    "station returns it later");
  return Status::Ok();
}

Status SimulateAttempt(const SimulateCommand& options) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options.json, "--json"));
  ENAMEL_ASSIGN_OR_RETURN(auto built, import::LoadScene(options.scene, options.voxel_um * 1000));
  ENAMEL_ASSIGN_OR_RETURN(auto profile, scene::FindProfile(options.profile));
  scene::Exercise exercise =
      // The hash under which the server would store the scene, so that an exercise made here is the
      // same document.
      scene::ClassOneExercise(built.scene, HashSha256(AsBytes(scene::ToJson(built.scene))));
  // As a server would refuse it.
  if (const auto coarse = scene::WhyTooCoarse(exercise, built.scene.voxel_nm))
    return Status(Code::kInvalidInput, *coarse, "voxel_um");
  ENAMEL_ASSIGN_OR_RETURN(auto report,
                          Simulate(built, exercise, profile, options.operator_name, options.seed));
  double rate = exercise.rate_hz;
  std::printf("%s cuts '%s' on %s: %llu ticks (%.0f s), computed in %.1f s\n",
              options.operator_name.c_str(), built.scene.name.c_str(), profile.name.c_str(),
              static_cast<unsigned_ll>(report.ticks), static_cast<double>(report.ticks) / rate,
              report.seconds);
  std::printf("force: median %.2f N, 95 %% %.2f N, peak %.2f N; bounded in %llu ticks\n",
              report.force_p50_n, report.force_p95_n, report.force_max_n,
              static_cast<unsigned_ll>(report.bounded_ticks));
  boost::json::object removed, planes;
  for (size_t t = 1; t < report.removed_mm3.size(); ++t) {
    if (report.removed_mm3[t] <= 0) continue;
    std::printf("removed %-9s %8.3f mm3\n", std::string(cutting::kTissueNames[t]).c_str(),
                report.removed_mm3[t]);
    removed[std::string(cutting::kTissueNames[t])] = report.removed_mm3[t];
  }
  std::printf("plane      median    mean     rms   um beyond the exercise's box\n");
  for (const PlaneError& p : report.planes) {
    std::printf("%-8s %+8.1f %+7.1f %7.1f\n", p.name.c_str(), p.median_um, p.mean_um, p.rms_um);
    planes[p.name] = p.median_um;
  }
  return program::WriteJsonFile(options.json, {{"ticks", report.ticks},
                                               {"force_p95_n", report.force_p95_n},
                                               {"force_max_n", report.force_max_n},
                                               {"state_hash", report.state_hash},
                                               {"removed_mm3", removed},
                                               {"plane_median_um", planes}});
}

void PrintScenes() {
  for (const scene::BuiltinScene& s : scene::BuiltinScenes()) {
    std::printf("builtin:%-14s %s\n", std::string(s.name).c_str(), std::string(s.summary).c_str());
    // As coarse as possible: exercises come from landmarks, not from voxels.
    auto built = scene::BuildBuiltinScene(s.name, 500'000);
    if (!built.ok()) continue;
    for (const scene::Exercise& e : scene::BuiltinExercises(built->scene, {})) {
      std::printf("  %-28s %s%s\n", e.name.c_str(), e.title.c_str(), e.graded ? "" : " (practice)");
    }
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
    if (!p.electrical_damping_mn_s_per_m.source.empty()) {
      line("electrical damping", p.electrical_damping_mn_s_per_m, 1e-3, "N s/m");
    }
    if (!p.torque) continue;
    line("peak torque", p.torque->peak_un_m, 1e-3, "mN m");
    line("torque coupling K", p.torque->coupling_un_m_per_rad, 1e-6, "N m/rad");
    line("torque damping b_rot", p.torque->damping_un_m_s_per_rad, 1e-3, "mN m s");
    line("torque friction c_rot", p.torque->friction_un_m, 1e-3, "mN m");
    line("orientation cell", p.torque->orientation_cell_urad, 1e-3, "mrad");
  }
}

namespace {

std::string HostName() {
  char name[256] = {};
  return ::gethostname(name, sizeof name - 1) == 0 && name[0] != 0 ? name : "station";
}

}  // namespace

void DeclareEnrol(CommandGroup group) {
  auto options = std::make_shared<EnrolOptions>();
  EnrolOptions& o = *options;
  // The machine's known name; an admin can choose another at the server.
  o.name = HostName();
  CLI::App* cmd =
      group.app.add_subcommand("enrol", "Make this machine a station of a server (once)");
  AddDataOption(*cmd, group.place);
  cmd->add_option("--server", o.server, "HOST:PORT of its station link")->required();
  CLI::Option* code =
      cmd->add_option("--code", o.code, "CODE@FINGERPRINT from 'enamel-server admin enrol-code'");
  cmd->add_option("--codes", o.codes,
                  "Table from 'enamel-server admin enrol-code --names FILE', which has this "
                  "station's --name; - for standard input")
      ->excludes(code);
  cmd->add_option("--name", o.name, "What to call this station")->capture_default_str();
  cmd->add_flag("--again", o.again,
                "Enrol again as the same station: the server was restored and does not know it; "
                "what is recorded here stays good");
  program::AddExamples(
      *cmd, {"--server enamel.example.edu:8443 --code CODE@FINGERPRINT --name chair-07"});
  cmd->callback([options, cmd, group] {
    options->data = group.place.data;
    // When enrolling again, the name stays unless another is given.
    if (options->again && cmd->count("--name") == 0) options->name.clear();
    group.exit_code = Finish(EnrolStation(*options));
  });
}

void DeclareReserve(CommandGroup group) {
  struct Options {
    ReserveCommand reserve;
    std::string give_back;
  };
  auto [cmd, o] = Declare<Options>(
      group, "reserve", "Take a ticket now, for an attempt within 12 hours that needs no server",
      [&place = group.place](Options& options) {
        ReserveCommand& reserve = options.reserve;
        reserve.workplace = place.Options();
        // From the environment: anybody who lists processes sees the command line.
        reserve.password = Environment("ENAMEL_PASSWORD");
        reserve.pin = Environment("ENAMEL_PIN");
        if (!options.give_back.empty()) {
          return GiveBackReserved(
              {reserve.workplace, options.give_back, reserve.login, reserve.password, reserve.pin});
        }
        return reserve.exercise.empty() ? ListReserved(place.data) : ReserveAttempt(reserve);
      });
  AddWorkplaceSettings(*cmd, group.place);
  cmd->add_option("--exercise", o.reserve.exercise, "Name of the exercise");
  cmd->add_option("--profile", o.reserve.profile, "Name of the device profile");
  cmd->add_option("--user", o.reserve.login, "Login of the person at this station");
  cmd->add_option("--give-back", o.give_back,
                  "ID of a reserved attempt that is not wanted any more: it then does not "
                  "count.\nPIN in ENAMEL_PIN; forgotten: --user and ENAMEL_PASSWORD");
  cmd->footer(
      "Password in ENAMEL_PASSWORD, PIN (6 to 12 digits) in ENAMEL_PIN. Without --exercise it "
      "lists what is reserved here.\n"
      "'run --reserved ID' with ENAMEL_PIN makes the attempt. The PIN keeps others at this chair "
      "from using it;\n"
      "six digits do not keep out anybody who can read this station's disk. Exams cannot be "
      "reserved.");
  program::AddExamples(*cmd, {"--user anna --exercise class-1-molar-46 --profile phantom_desktop",
                              "--give-back 6f1c9a52-3d0e-4b7a-9c41-2f8d5e07a613"});
}

void DeclareSimulate(CommandGroup group) {
  auto [cmd, o] = Declare<SimulateCommand>(
      group, "simulate", "Make an attempt without a server and print its walls, forces and ticks",
      SimulateAttempt);
  cmd->add_option("--scene", o.scene, "builtin:molar, builtin:block, or an imported scene's folder")
      ->capture_default_str();
  cmd->add_option("--profile", o.profile, "Device profile, or its document (FILE.json)")
      ->capture_default_str();
  AddOperator(cmd, o.operator_name);
  cmd->add_option("--voxel-um", o.voxel_um, "Voxel of a built-in scene")->capture_default_str();
  cmd->add_option("--seed", o.seed, "Of the tremor; 0: the operator's own")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  cmd->add_option("--json", o.json, "Write the facts to this file");
  program::AddExamples(*cmd, {"--profile phantom_desktop --operator dentist"});
}

void DeclareLists(CommandGroup group) {
  CLI::App* scenes =
      group.app.add_subcommand("scenes", "List the built-in scenes and their exercises");
  program::AddExamples(*scenes, {""});
  scenes->callback(PrintScenes);
  CLI::App* profiles = group.app.add_subcommand(
      "profiles", "List device profiles and where their numbers come from");
  program::AddExamples(*profiles, {""});
  profiles->callback(PrintProfiles);
}

}  // namespace enamel::station

#include "station/app/first_hour/command.h"

#include <link.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <boost/json.hpp>
#include <cstdio>
#include <fstream>
#include <thread>

#include "common/base/file.h"
#include "common/base/unix_time.h"
#include "common/program/output.h"
#include "common/scene/find_profile.h"
#include "station/app/first_hour/hour.h"
#include "station/app/first_hour/simulated_unit.h"
#include "station/loop/realtime.h"
#include "station/session/stop_signals.h"
#include "station/uplink/server_link.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

constexpr int kRate_hz = 1000;
constexpr size_t kLongestScript = 1 << 16;

std::string ProcessorModel() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    const size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "";
}

json::object Computer(const RealtimeGrant* grant) {
  utsname name{};
  (void)uname(&name);
  json::object out{{"kernel", std::string(name.sysname) + " " + name.release},
                   {"machine", name.machine},
                   {"processor", ProcessorModel()},
                   {"processors", std::thread::hardware_concurrency()},
                   {"realtime", nullptr}};
  if (grant != nullptr) {
    out["realtime"] = json::object{{"fifo", grant->fifo},
                                   {"memory_locked", grant->memory_locked},
                                   {"refused", grant->refused}};
  }
  return out;
}

// The libraries that drivers use, as the files that are loaded: their names hold the version.
json::array Libraries() {
  json::array out;
  dl_iterate_phdr(
      [](dl_phdr_info* info, size_t, void* found) {
        for (const char* wanted : {"libhidapi", "libusb-1", "libdhd", "libdrd", "libHD."}) {
          const fs::path file(info->dlpi_name);
          if (file.filename().string().starts_with(wanted)) {
            std::error_code error;
            const fs::path real = fs::canonical(file, error);
            static_cast<json::array*>(found)->emplace_back(
                (error ? file : real).filename().string());
          }
        }
        return 0;
      },
      &out);
  return out;
}

void PrintSummary(const json::object& document) {
  std::printf("\n");
  for (const auto& [name, step] : document.at("steps").as_object()) {
    std::printf("%-12s %-12s %s\n", std::string(name).c_str(), step.at("state").as_string().c_str(),
                step.at("reason").as_string().c_str());
  }
  for (const json::value& p : document.at("problems").as_array())
    std::printf("not as expected, %s: %s\n", p.at("step").as_string().c_str(),
                p.at("text").as_string().c_str());
}

Result<std::vector<first_hour::ScriptLine>> ReadScript(const fs::path& file) {
  ENAMEL_ASSIGN_OR_RETURN(const Bytes bytes, ReadFile(file, kLongestScript));
  auto lines = first_hour::ParseScript(AsText(bytes));
  if (lines.ok()) return lines;
  return Status(lines.status().code(), file.string() + ", " + lines.status().message(), "answers");
}

// The hour with whoever answers; writes the document after each step.
Status Lead(const FirstHourCommand& options, first_hour::HourSetup setup, json::object about) {
  Status kept;
  setup.stop = &StopsAsked();
  setup.max_force_n = options.max_force_n;
  setup.tick_s = 1.0 / kRate_hz;
  const auto document_of = [&](const json::object& found) {
    json::object document = about;
    document["ended_ms"] = UnixMs();
    document["libraries"] = Libraries();
    for (const auto& [key, value] : found) document[key] = value;
    return document;
  };
  setup.keep = [&](const json::object& found) {
    kept = program::WriteJsonFile(options.out, document_of(found));
    if (!kept.ok()) setup.person->Tell("Not written: " + kept.message());
  };
  const json::object document = document_of(first_hour::Hour(setup).Run());
  kept = program::WriteJsonFile(options.out, document);
  PrintSummary(document);
  ENAMEL_RETURN_IF_ERROR(kept);
  std::printf("\n%s: send this file as the guide says (docs/haptic_devices.md)\n",
              options.out.c_str());
  if (document.at("complete").as_bool()) return Status::Ok();
  return Status(Code::kUnavailable, "the first hour did not reach its end: " +
                                        std::string(document.at("ended_by").as_string().c_str()) +
                                        "; what was found so far is in " + options.out.string());
}

}  // namespace

Status RunFirstHour(const FirstHourCommand& options) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options.out, "--out"));
  const bool real = !options.device.starts_with(kSimulated);
  std::vector<first_hour::ScriptLine> lines;
  const bool scripted = !options.answers.empty();
  if (scripted) {
    ENAMEL_ASSIGN_OR_RETURN(lines, ReadScript(options.answers));
  }
  if (real && ::isatty(STDIN_FILENO) == 0) {
    return Status(Code::kInvalidInput,
                  "motors push only after somebody has typed yes: run this on a terminal",
                  "device");
  }
  CatchStopSignals();
  json::object about{{"enamel_first_hour", 1},
                     {"software", SoftwareName()},
                     {"began_ms", UnixMs()},
                     {"rate_hz", kRate_hz},
                     {"max_force_n", options.max_force_n}};
  first_hour::Terminal terminal;
  first_hour::Script script(std::move(lines), terminal, !real);
  first_hour::HourSetup setup;
  if (real) {
    const RealtimeGrant grant = RequestRealtime();
    about["computer"] = Computer(&grant);
    setup.person = scripted ? static_cast<first_hour::Person*>(&script) : &terminal;
    setup.open = [&] { return OpenToMeasure(options.device, options.profile, kRate_hz); };
    return Lead(options, std::move(setup), std::move(about));
  }
  about["computer"] = Computer(nullptr);
  ENAMEL_ASSIGN_OR_RETURN(auto profile,
                          scene::FindProfile(options.device.substr(kSimulated.size())));
  auto compared = profile;
  if (!options.profile.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(compared, scene::FindProfile(options.profile));
  }
  first_hour::SimulatedPerson person(terminal, scripted ? &script : nullptr);
  setup.person = &person;
  setup.by_clock = false;
  setup.open = [&]() -> Result<MeasuredDevice> {
    MeasuredDevice unit = person.Unit(profile, 1.0 / kRate_hz);
    unit.profile = compared;
    return unit;
  };
  return Lead(options, std::move(setup), std::move(about));
}

}  // namespace enamel::station

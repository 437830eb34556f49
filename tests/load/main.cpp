#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <csignal>
#include <cstdio>
#include <thread>

#include "common/base/file.h"
#include "tests/load/load.h"

// enamel-loadgen: command line only.
namespace {

using namespace enamel;
using namespace enamel::load;

struct Arguments {
  LoadOptions load;
  double minutes = 1;
  size_t score_attempts = 0;
  Marking::Options marking;
  std::string server, page;
  std::filesystem::path json;
};

constexpr char kAbout[] =
    "Many stations against one server: what arrives, how soon, and what it costs.\n\n"
    "Starts an enamel-server of its own on loopback with scoring paused, enrols the stations over\n"
    "the station link, lets each stream a recorded movement of its own at 1 kHz over TLS, seals "
    "the\n"
    "attempts, and compares every trace in the store with what was sent, byte by byte. Chunks are\n"
    "encoded and signed before the clock starts.\n\n"
    "  enamel-loadgen --stations 1000 --minutes 5 --json load.json\n"
    "  enamel-loadgen --stations 100 --minutes 2 --kills 5 --cuts 50 --hostile 25\n"
    "  enamel-loadgen --stations 200 --minutes 1 --api-reads 20\n"
    "  enamel-loadgen --stations 200 --minutes 4 --score-attempts 42\n"
    "  enamel-loadgen --stations 500 --minutes 3 --viewers 50 --alternate 3\n"
    "  enamel-loadgen --idle 10000 --minutes 1\n"
    "  enamel-loadgen --stations 50 --server 127.0.0.1:8443 --data DIR   (a server that runs)\n\n"
    "Exit codes: 0 all that was committed is there once; 1 not, or it could not run; 2 wrong "
    "usage.";

void AddOptions(CLI::App& app, Arguments& a) {
  LoadOptions& o = a.load;
  app.add_option("--stations", o.stations, "Stations that stream")->check(CLI::Range(0, 100'000));
  app.add_option("--minutes", a.minutes, "How long they stream")
      ->check(CLI::Range(0.02, 24 * 60.0))
      ->capture_default_str();
  app.add_option("--json", a.json, "Write the figures to this file");
  app.add_option("--idle", o.idle, "Stations that only stay connected")
      ->check(CLI::Range(0, 100'000));
  app.add_option("--threads", o.threads, "Threads of the stations")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--chunk-ticks", o.chunk_ticks, "Ticks in a chunk")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--loop-seconds", o.loop_seconds,
                 "After so long a station's movement repeats (its chunks never do)")
      ->check(CLI::Range(0.5, 3600.0))
      ->capture_default_str();
  app.add_option("--motion", o.motion, "Trace file to take the movement from; else simulated")
      ->check(CLI::ExistingFile);

  auto* server = app.add_option("--server", a.server,
                                "Station link of a running server, host:port; needs --data");
  auto* data = app.add_option("--data", o.data,
                              "Data folder: of that server, or for our own (else a temporary one)");
  server->needs(data);
  app.add_option("--page", a.page, "Page of that server, host:port, for readers and viewers")
      ->needs(server);
  app.add_option("--server-pid", o.server_pid, "Its process, to account for its CPU time")
      ->needs(server);
  app.add_option("--server-program", o.server_program,
                 "enamel-server to start; else the one beside this program");

  std::string faults = "Faults";
  app.add_option("--kills", o.kills, "kill -9 and restart of our server, at random moments")
      ->group(faults)
      ->check(CLI::Range(0, 10'000))
      ->excludes(server);
  app.add_option("--cuts", o.cuts, "Station connections reset at random moments")
      ->group(faults)
      ->check(CLI::Range(0, 1'000'000));
  app.add_option("--repeated", o.disturbances.repeated, "Share of chunks sent twice")
      ->group(faults)
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--disordered", o.disturbances.disordered,
                 "Share of chunks that come before the one in front of them")
      ->group(faults)
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--hostile", o.hostile,
                 "Peers that are half open, drip bytes, never read, send too much or noise")
      ->group(faults)
      ->check(CLI::Range(0, 10'000));

  std::string jobs = "Scoring beside it";
  app.add_option("--score-attempts", a.score_attempts,
                 "Recordings that are sealed when the stations begin, and scored meanwhile")
      ->group(jobs)
      ->check(CLI::Range(1, 10'000))
      ->excludes(server);
  app.add_option("--attempt-minutes", a.marking.minutes, "Length of each of them")
      ->group(jobs)
      ->check(CLI::Range(0.1, 120.0))
      ->capture_default_str();
  app.add_option("--attempt-kinds", a.marking.different, "How many of them are recorded anew")
      ->group(jobs)
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--job-threads", o.job_threads, "Attempts scored at once by our server")
      ->group(jobs)
      ->check(CLI::Range(0, 64))
      ->capture_default_str();

  std::string page = "Page and live view";
  app.add_option("--api-reads", o.api_reads_per_s, "API reads per second")
      ->group(page)
      ->check(CLI::Range(0.0, 10'000.0));
  app.add_option("--live-hz", o.disturbances.live_hz, "LiveState per station and second")
      ->group(page)
      ->check(CLI::Range(0.0, 1000.0));
  app.add_option("--viewers", o.viewers, "Instructors who watch live")
      ->group(page)
      ->check(CLI::Range(0, 10'000));
  app.add_option("--slow-viewers", o.slow_viewers, "Viewers that never read")
      ->group(page)
      ->check(CLI::Range(0, 10'000));
  app.add_option("--alternate", o.alternate,
                 "Stretches without and with the viewers in turn, so many of each")
      ->group(page)
      ->check(CLI::Range(0, 100));
}

Status Complete(Arguments& a, const char* program) {
  LoadOptions& o = a.load;
  o.seconds = a.minutes * 60;
  if (a.score_attempts > 0) {
    o.marking = a.marking;
    o.marking->attempts = a.score_attempts;
    if (o.job_threads == 0) {
      o.job_threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    }
  }
  if (o.stations + o.idle == 0) {
    return Status(Code::kInvalidInput, "expected --stations or --idle, found neither");
  }
  if (!a.server.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(auto endpoint, net::ParseEndpoint(a.server));
    o.server = endpoint;
  }
  if (!a.page.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(auto endpoint, net::ParseEndpoint(a.page));
    o.page = endpoint;
  }
  bool needs_page = o.api_reads_per_s > 0 || o.viewers + o.slow_viewers > 0;
  if (o.server && !o.page && needs_page) {
    return Status(Code::kInvalidInput, "readers and viewers of a given server need --page");
  }
  if (o.server_program.empty()) {
    std::error_code error;
    auto self = std::filesystem::read_symlink("/proc/self/exe", error);
    o.server_program =
        (error ? std::filesystem::path(program) : self).parent_path() / "enamel-server";
  }
  return Status::Ok();
}

void AddStreamFacts(const Arguments& a, LoadReport& r, boost::json::object& out) {
  StreamFigures& s = r.stream;
  auto ticks = static_cast<double>(std::max<uint64_t>(1, s.ticks_sent));
  out["chunk_ticks"] = a.load.chunk_ticks;
  out["ticks_sent"] = s.ticks_sent;
  out["ticks_committed"] = s.ticks_committed;
  out["ticks_stored"] = r.read_back.ticks_stored;
  out["ticks_lost"] = r.read_back.ticks_lost;
  out["ticks_doubled"] = r.read_back.ticks_doubled;
  out["commit_p50_ms"] = Quantile(s.commit_ms, 0.5);
  out["commit_p99_ms"] = Quantile(s.commit_ms, 0.99);
  out["commit_max_ms"] = Quantile(s.commit_ms, 1);
  out["late_p99_ms"] = Quantile(s.late_ms, 0.99);
  out["bytes_per_tick"] = static_cast<double>(s.chunk_bytes) / ticks;
  out["bytes_per_s"] = static_cast<double>(s.bytes_sent) / std::max(1e-9, r.wall_s);
  out["server_cpu_s_per_mtick"] = r.server_cpu_s / ticks * 1e6;
  out["server_cpu_percent_per_station"] =
      100 * r.server_cpu_s / std::max(1e-9, r.wall_s) / static_cast<double>(r.stations);
  out["load_average"] = boost::json::array(r.load_average.begin(), r.load_average.end());
  out["seal_s"] = r.seal_s;
  out["reconnects"] = s.reconnects;
}

void AddFaultFacts(const Arguments& a, const LoadReport& r, boost::json::object& out) {
  if (a.load.kills > 0) {
    out["kills"] = r.restart_s.size();
    out["restart_max_s"] = r.restart_s.empty() ? 0 : *std::ranges::max_element(r.restart_s);
  }
  if (a.load.cuts > 0) out["cuts"] = r.stream.cuts;
  if (r.stream.repeats > 0) out["repeated_chunks"] = r.stream.repeats;
  if (r.stream.disorders > 0) out["disordered_chunks"] = r.stream.disorders;
  if (a.load.hostile > 0) out["hostile_thrown_out"] = r.hostile_thrown_out;
}

void AddMarkingFacts(const Arguments& a, const LoadReport& r, boost::json::object& out) {
  if (!a.load.marking) return;
  out["attempts_to_score"] = a.load.marking->attempts;
  out["attempt_minutes"] = a.load.marking->minutes;
  out["attempts_scored"] = r.marking.scored;
  out["attempts_failed"] = r.marking.failed;
  out["attempt_cutting_share"] = r.marking.cutting_share;
  out["job_threads"] = a.load.job_threads;
  out["attempts_sealed_s"] = r.marking.seal_s;
  out["attempts_scored_s"] = r.marking.marked_s;
  out["replay_realtime_factor"] = r.marking.replay_realtime;
}

void AddPageFacts(const Arguments& a, LoadReport& r, boost::json::object& out) {
  if (r.stream.live_states > 0) out["live_states"] = r.stream.live_states;
  if (a.load.api_reads_per_s > 0) {
    out["api_reads"] = r.api_ms.size();
    out["api_failures"] = r.api_failures;
    out["api_p50_ms"] = Quantile(r.api_ms, 0.5);
    out["api_p99_ms"] = Quantile(r.api_ms, 0.99);
  }
  if (a.load.viewers + a.load.slow_viewers > 0) {
    out["viewers"] = a.load.viewers;
    out["viewer_events"] = r.viewer_events;
    out["viewer_bytes"] = r.viewer_bytes;
  }
  if (a.load.alternate == 0) return;
  double without = Median(r.cpu_without_viewers), with = Median(r.cpu_with_viewers);
  out["cpu_s_per_mtick_without_viewers"] =
      boost::json::array(r.cpu_without_viewers.begin(), r.cpu_without_viewers.end());
  out["cpu_s_per_mtick_with_viewers"] =
      boost::json::array(r.cpu_with_viewers.begin(), r.cpu_with_viewers.end());
  out["viewers_extra_cpu_percent"] = without > 0 ? 100 * (with / without - 1) : 0;
}

boost::json::object Facts(const Arguments& a, LoadReport& r) {
  boost::json::object out{{"format", 1}, {"stations", r.stations}, {"seconds", a.load.seconds}};
  if (r.stations > 0) AddStreamFacts(a, r, out);
  if (a.load.idle > 0) out["idle_connected"] = r.idle_connected;
  out["server_cpu_s"] = r.server_cpu_s;
  out["loadgen_cpu_s"] = r.loadgen_cpu_s;
  out["wall_s"] = r.wall_s;
  out["server_rss_mb"] = r.server_rss_mb;
  out["server_peak_rss_mb"] = r.server_peak_rss_mb;
  AddFaultFacts(a, r, out);
  AddMarkingFacts(a, r, out);
  AddPageFacts(a, r, out);
  out["problem"] = r.problem;
  return out;
}

// Without the exponents that a machine likes.
std::string ForPeople(const boost::json::value& value) {
  if (value.is_double()) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value.as_double());
    return text;
  }
  if (!value.is_array()) return boost::json::serialize(value);
  std::string out;
  for (const auto& element : value.as_array())
    out += (out.empty() ? "" : "  ") + ForPeople(element);
  return out;
}

bool Sound(const LoadReport& r) {
  return r.problem.empty() && r.read_back.ticks_lost == 0 && r.read_back.ticks_doubled == 0 &&
         r.stream.ticks_committed == r.stream.ticks_sent;
}

int Finish(const Arguments& a, LoadReport& report) {
  boost::json::object facts = Facts(a, report);
  for (const auto& member : facts) {
    std::printf("%-34s %s\n", std::string(member.key()).c_str(), ForPeople(member.value()).c_str());
  }
  if (!a.json.empty()) {
    Status written = WriteFileDurably(a.json, AsBytes(boost::json::serialize(facts) + "\n"));
    if (!written.ok()) {
      std::fprintf(stderr, "enamel-loadgen: %s\n", written.message().c_str());
      return 1;
    }
  }
  if (Sound(report)) return 0;
  std::fprintf(stderr, "enamel-loadgen: not all that was sent is there once: %s\n",
               report.problem.empty() ? "see the figures" : report.problem.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(kAbout);
  Arguments arguments;
  AddOptions(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  std::signal(SIGPIPE, SIG_IGN);  // a server that was killed is an error of the write
  spdlog::set_level(spdlog::level::warn);
  if (Status status = Complete(arguments, argv[0]); !status.ok()) {
    std::fprintf(stderr, "enamel-loadgen: %s\n", status.message().c_str());
    return 2;
  }
  auto report = RunLoad(
      arguments.load, [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); });
  if (!report.ok()) {
    std::fprintf(stderr, "enamel-loadgen: %s\n", report.status().message().c_str());
    return 1;
  }
  return Finish(arguments, *report);
}

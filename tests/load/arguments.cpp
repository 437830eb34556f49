#include "tests/load/arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <thread>

namespace enamel::load {

void AddOptions(CLI::App& app, Arguments& a) {
  LoadOptions& o = a.load;
  app.footer("Example:\n  enamel-loadgen --stations 40 --minutes 1 --json load.json");
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
  app.add_option("--server-pid", o.server_pids,
                 "Its process (repeatable), with those that it starts, to account for CPU time")
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

}  // namespace enamel::load

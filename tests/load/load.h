#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/load/figures.h"
#include "tests/load/marking.h"
#include "tests/load/read_back.h"
#include "tests/load/server_process.h"
#include "tests/load/stations/station.h"

namespace enamel::load {

struct LoadOptions {
  size_t stations = 0, idle = 0;
  double seconds = 60;
  size_t chunk_ticks = 500;
  double loop_seconds = 30;      // of each station's motion before it repeats
  std::filesystem::path motion;  // trace file; empty: simulated
  int threads = 1;               // of the stations; preparing uses every processor
  // Our own server in its own folder, unless one is given by address, fingerprint and data.
  std::filesystem::path server_program, data;
  std::optional<net::Endpoint> server, page;
  std::vector<pid_t> server_pids{};
  // Disturbances.
  int kills = 0, cuts = 0;
  size_t hostile = 0;
  Disturbances disturbances;
  // Running alongside the stations.
  std::optional<Marking::Options> marking;  // scored while they stream
  int job_threads = 0;                      // of our own server
  double api_reads_per_s = 0;
  size_t viewers = 0, slow_viewers = 0;
  int alternate =
      0;  // pairs of equal stretches without and with the viewers; 0: with, all the time
};

struct LoadReport {
  StreamFigures stream;
  ReadBack read_back;
  size_t stations = 0, idle_connected = 0;
  double wall_s = 0;                           // from the first tick to the last commit
  double server_cpu_s = 0, loadgen_cpu_s = 0;  // while the clock ran
  double server_rss_mb = 0, server_peak_rss_mb = 0;
  double seal_s = 0;
  std::vector<double> restart_s;  // from kill to ready
  uint64_t hostile_thrown_out = 0;
  Marking::Figures marking;
  std::vector<float> api_ms;
  uint64_t api_failures = 0;
  uint64_t viewer_events = 0, viewer_bytes = 0;
  // Server CPU seconds per million ticks of the stretches of an alternated run.
  std::vector<double> cpu_without_viewers, cpu_with_viewers;
  std::vector<double> load_average;  // at begin and end, over one minute
  std::string problem;               // the first station, reader or viewer that had one
};

// Sets up, runs and reads back. `say` receives progress, line by line. Errors: failures that kept
// the load from running; failures during the run are in the report.
Result<LoadReport> RunLoad(const LoadOptions& options,
                           const std::function<void(const std::string&)>& say);

}  // namespace enamel::load

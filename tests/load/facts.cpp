#include "tests/load/facts.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>
#include <cstdlib>

#include "common/program/output.h"

namespace enamel::load {
namespace {

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
  out["refused_chunks"] = s.refused;
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

}  // namespace

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

// Without exponents, for people.
std::string ForPeople(const boost::json::value& value) {
  if (value.is_double()) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value.as_double());
    return program::JsonText(std::strtod(text, nullptr));
  }
  if (!value.is_array()) return program::JsonText(value);
  std::string out;
  for (const auto& element : value.as_array())
    out += (out.empty() ? "" : "  ") + ForPeople(element);
  return out;
}

bool Sound(const LoadReport& r) {
  return r.problem.empty() && r.read_back.ticks_lost == 0 && r.read_back.ticks_doubled == 0 &&
         r.stream.ticks_committed == r.stream.ticks_sent;
}

}  // namespace enamel::load

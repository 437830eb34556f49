#include "station/session/loop_facts.h"

#include <spdlog/fmt/fmt.h>

#include <boost/json.hpp>

namespace enamel::station {
namespace {

namespace json = boost::json;

json::object Tick(const FaultTick& t) {
  return {{"counts", {t.input.counts[0], t.input.counts[1], t.input.counts[2]}},
          {"flags", t.input.flags},
          {"gap_ticks", t.input.gap_ticks},
          {"force_n", {t.force_sent_n.x, t.force_sent_n.y, t.force_sent_n.z}},
          {"late_us", t.late_s * 1e6},
          {"fresh", t.fresh},
          {"attached", t.attached},
          {"driven", t.driven}};
}

}  // namespace

json::array FaultFacts(std::span<const FaultRecord> records) {
  json::array out;
  for (const FaultRecord& record : records) {
    json::array ticks;
    for (size_t i = 0; i < record.count; ++i) ticks.push_back(Tick(record.ticks[i]));
    out.push_back({{"why", FaultText(record.fault)}, {"tick", record.tick}, {"ticks", ticks}});
  }
  return out;
}

json::object DurationFacts(const DurationHistogram& h) {
  json::object doublings;
  for (size_t octave = 0; octave < DurationHistogram::kOctaves; ++octave) {
    uint64_t count = 0;
    for (size_t i = 0; i < DurationHistogram::kSplit; ++i) {
      count += h.InBucket(octave * DurationHistogram::kSplit + i);
    }
    // Most are empty, and the document is kept with every attempt.
    if (count == 0) continue;
    // By the end of the doubling: "below_2048" needs no explanation.
    size_t next = (octave + 1) * DurationHistogram::kSplit;
    doublings["below_" + std::to_string(DurationHistogram::Floor_ns(next))] = count;
  }
  return {{"count", h.count()},
          {"mean_us", h.mean_ns() * 1e-3},
          {"p50_us", h.Quantile_ns(0.5) * 1e-3},
          {"p99_us", h.Quantile_ns(0.99) * 1e-3},
          {"max_us", static_cast<double>(h.max_ns()) * 1e-3},
          {"ns", doublings}};
}

std::string CountsText(const LoopCounters& counters) {
  return fmt::format("{} ticks, {} late, {} in gaps, {} interruptions, {} faults", counters.ticks,
                     counters.late_ticks, counters.missed_ticks(), counters.interruptions,
                     counters.faults);
}

json::object LoopFacts(const TickLoop& loop, const Device& device) {
  const LoopCounters& counters = loop.counters();
  const DeviceCounters bus = device.counters();
  return {{"version", kLoopFactsVersion},
          {"ticks", counters.ticks},
          {"gap_ticks", counters.gap_ticks},
          {"late_ticks", counters.late_ticks},
          {"skipped_ticks", counters.skipped_ticks},
          {"stale_ticks", counters.stale_ticks},
          {"bounded_ticks", counters.bounded_ticks},
          {"put_downs", counters.put_downs},
          {"interruptions", counters.interruptions},
          {"leak_j", counters.leak_j},
          {"lateness", DurationFacts(loop.lateness())},
          {"tick", DurationFacts(loop.durations())},
          {"fault_count", counters.faults},
          {"faults", FaultFacts(loop.fault_records())},
          {"device",
           {{"name", device.Name()},
            {"samples", bus.samples},
            {"lost", bus.lost},
            {"duplicated", bus.duplicated},
            {"refused", bus.refused},
            {"writes", bus.writes},
            {"write_errors", bus.write_errors},
            {"detached", bus.detached}}}};
}

}  // namespace enamel::station

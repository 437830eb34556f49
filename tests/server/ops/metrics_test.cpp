#include "server/ops/metrics.h"

#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>
#include <sstream>

namespace enamel::server::ops {
namespace {

using namespace std::chrono_literals;

// Reads the text as the format's description has it (line by line, no knowledge of the writer).
struct Parsed {
  std::map<std::string, double> samples;  // "name{labels}" to value
  std::map<std::string, std::string> types;
  std::set<std::string> helps;
};

Parsed Parse(const std::string& text) {
  static const std::regex sample(
      R"re(([a-zA-Z_:][a-zA-Z0-9_:]*(?:\{[a-zA-Z_][a-zA-Z0-9_]*="(?:[^"\\\n]|\\.)*"(?:,[a-zA-Z_][a-zA-Z0-9_]*="(?:[^"\\\n]|\\.)*")*\})?) (\S+))re");
  Parsed out;
  EXPECT_TRUE(text.empty() || text.back() == '\n');
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string hash, kind, name, rest;
    if (line.starts_with("#")) {
      words >> hash >> kind >> name >> rest;
      if (kind == "TYPE") {
        EXPECT_TRUE(out.types.emplace(name, rest).second) << name << " has two types";
      }
      if (kind == "HELP") out.helps.insert(name);
      continue;
    }
    std::smatch match;
    if (!std::regex_match(line, match, sample)) {
      ADD_FAILURE() << "not a sample: " << line;
      continue;
    }
    EXPECT_TRUE(out.samples.emplace(match[1], std::stod(match[2])).second) << "twice: " << line;
  }
  return out;
}

TEST(MetricsTest, TextIsWhatTheFormatSays) {
  Metrics metrics;
  metrics.Add([](MetricsText& text) {
    text.Counter("a_total", "Things.", 3);
    text.Gauge("b", "Things by kind.", 1.5, {{"kind", "x"}, {"place", "a \"b\" \\ c\nd"}});
    text.Gauge("b", "Things by kind.", -2e9, {{"kind", "y"}, {"place", ""}});
  });
  metrics.Add(AddProcess);
  Parsed parsed = Parse(metrics.Text());
  EXPECT_EQ(parsed.samples.at("a_total"), 3);
  EXPECT_EQ(parsed.types.at("a_total"), "counter");
  EXPECT_EQ(parsed.types.at("b"), "gauge");
  EXPECT_EQ(parsed.samples.at(R"re(b{kind="x",place="a \"b\" \\ c\nd"})re"), 1.5);
  EXPECT_EQ(parsed.samples.at(R"re(b{kind="y",place=""})re"), -2e9);
  EXPECT_GT(parsed.samples.at("process_resident_memory_bytes"), 1e5);
  EXPECT_GT(parsed.samples.at("process_open_fds"), 2);
  EXPECT_EQ(parsed.types.size(), parsed.helps.size());
}

TEST(MetricsTest, DurationsAreCountedOnceAndAccumulate) {
  Histogram histogram;
  const std::chrono::nanoseconds durations[] = {0ns, 500us, 501us, 30ms, 9s, 11s, 1h};
  for (auto duration : durations) histogram.Add(duration);
  MetricsText text;
  text.Durations("read_seconds", "Reads.", histogram.counts());
  text.Durations("call_seconds", "Calls.", histogram.counts(), {{"of", "keys"}});
  Parsed parsed = Parse(text.Take());
  EXPECT_EQ(parsed.samples.at("call_seconds_bucket{of=\"keys\",le=\"0.001\"}"), 3);
  EXPECT_EQ(parsed.samples.at("call_seconds_count{of=\"keys\"}"), 7);
  EXPECT_EQ(parsed.types.at("read_seconds"), "histogram");
  EXPECT_EQ(parsed.samples.at("read_seconds_bucket{le=\"0.0005\"}"), 2) << "up to and with";
  EXPECT_EQ(parsed.samples.at("read_seconds_bucket{le=\"0.001\"}"), 3);
  EXPECT_EQ(parsed.samples.at("read_seconds_bucket{le=\"0.025\"}"), 3);
  EXPECT_EQ(parsed.samples.at("read_seconds_bucket{le=\"0.05\"}"), 4);
  EXPECT_EQ(parsed.samples.at("read_seconds_bucket{le=\"10\"}"), 5);
  EXPECT_EQ(parsed.samples.at("read_seconds_bucket{le=\"+Inf\"}"), 7);
  EXPECT_EQ(parsed.samples.at("read_seconds_count"), 7);
  EXPECT_NEAR(parsed.samples.at("read_seconds_sum"), 3620.031001, 1e-6);
}

}  // namespace
}  // namespace enamel::server::ops

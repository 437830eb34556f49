#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/mutex.h"

// Figures for a monitoring system, in Prometheus' text format 0.0.4
// (https://prometheus.io/docs/instrumenting/exposition_formats/).
namespace enamel::server::ops {

// Counts durations in fixed steps from 0.5 ms to 10 s. Thread safety: any thread, no lock.
class Histogram {
 public:
  static constexpr std::array<double, 14> kUpToS = {0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05,
                                                    0.1,    0.25,  0.5,    1,     2.5,  5,     10};
  void Add(std::chrono::nanoseconds duration);

  struct Counts {
    std::array<uint64_t, kUpToS.size() + 1> each{};  // not cumulative; the last: longer
    double sum_s = 0;
  };
  Counts counts() const;

 private:
  std::array<std::atomic<uint64_t>, kUpToS.size() + 1> counts_{};
  std::atomic<uint64_t> sum_ns_{0};
};

// Builds the text. A name is given its HELP and TYPE the first time it is used; uses of one name
// must follow one another. Thread safety: none.
class MetricsText {
 public:
  using Labels = std::vector<std::pair<std::string_view, std::string_view>>;
  // Names end in _total.
  void Counter(std::string_view name, std::string_view help, double value, const Labels& = {});
  void Gauge(std::string_view name, std::string_view help, double value, const Labels& = {});
  // Names end in _seconds.
  void Durations(std::string_view name, std::string_view help, const Histogram::Counts& counts);
  std::string Take() { return std::move(text_); }

 private:
  void Head(std::string_view name, std::string_view help, std::string_view type);
  void Line(std::string_view name, double value, const Labels& labels);

  std::string text_, last_name_;
};

// Anything with metrics adds a source; a request calls them all. Thread safety: any thread.
class Metrics {
 public:
  // Does not wait for the database, which may hang. Must outlive this, or be
  // captured by value.
  using Source = std::function<void(MetricsText&)>;
  void Add(Source source);
  std::string Text() const;

 private:
  mutable Mutex mutex_;
  std::vector<Source> sources_ ENAMEL_GUARDED_BY(mutex_);
};

// When this process started, Unix time in milliseconds.
int64_t ProcessStartedMs();

// CPU time, memory, open files and start time of this process, under Prometheus' usual names.
void AddProcess(MetricsText& text);

}  // namespace enamel::server::ops

#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/histogram.h"
#include "common/base/mutex.h"

// Figures for a monitoring system, in Prometheus' text format 0.0.4
// (https://prometheus.io/docs/instrumenting/exposition_formats/).
namespace enamel::server::ops {

// Builds the text. A name is given its HELP and TYPE the first time it is used; uses of one name
// must follow one another. Thread safety: none.
class MetricsText {
 public:
  using Labels = std::vector<std::pair<std::string_view, std::string_view>>;
  // Names end in _total.
  void Counter(std::string_view name, std::string_view help, double value, const Labels& = {});
  void Gauge(std::string_view name, std::string_view help, double value, const Labels& = {});
  // Names end in _seconds.
  void Durations(std::string_view name, std::string_view help, const Histogram::Counts& counts,
                 const Labels& = {});
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

// Which program this is: a figure of 1, with the version as its label.
void AddBuild(MetricsText& text, std::string_view version);

// When a certificate ends, Unix time; 0: not known.
void AddCertificate(MetricsText& text, std::string_view of, int64_t until_ms);

// When this process started, Unix time in milliseconds.
int64_t ProcessStartedMs();

// CPU time, memory, open files and start time of this process, under Prometheus' usual names.
void AddProcess(MetricsText& text);

}  // namespace enamel::server::ops

#include "server/ops/metrics.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "common/base/unix_time.h"

namespace enamel::server::ops {
namespace {

// As few digits as read back the same; with an exponent only where that is much shorter.
std::string Number(double value) {
  char buffer[64];
  double size = std::abs(value);
  bool plain = size == 0 || (size >= 1e-6 && size < 1e15);
  auto [end, error] =
      plain ? std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed)
            : std::to_chars(buffer, buffer + sizeof buffer, value);
  return std::string(buffer, end);
}

std::string Escaped(std::string_view value) {
  std::string out;
  for (char c : value) {
    if (c == '\\' || c == '"') out += '\\';
    if (c == '\n') {
      out += "\\n";
    } else {
      out += c;
    }
  }
  return out;
}

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

size_t OpenFiles() {
  std::error_code error;
  std::filesystem::directory_iterator begin("/proc/self/fd", error), end;
  return error ? 0 : static_cast<size_t>(std::distance(begin, end));
}

// Before main: as near to the start of the process as this program can tell.
const auto kStarted = std::chrono::steady_clock::now();

}  // namespace

void MetricsText::Head(std::string_view name, std::string_view help, std::string_view type) {
  // A name with several labels is announced once, before the first of its lines, as the format
  // wants it.
  if (last_name_ == name) return;
  last_name_ = name;
  text_.append("# HELP ").append(name).append(" ").append(help).append("\n# TYPE ");
  text_.append(name).append(" ").append(type).append("\n");
}

void MetricsText::Line(std::string_view name, double value, const Labels& labels) {
  text_.append(name);
  char before = '{';
  for (const auto& [label, content] : labels) {
    text_ += before;
    text_.append(label).append("=\"").append(Escaped(content)).append("\"");
    before = ',';
  }
  if (!labels.empty()) text_ += '}';
  text_.append(" ").append(Number(value)).append("\n");
}

void MetricsText::Counter(std::string_view name, std::string_view help, double value,
                          const Labels& labels) {
  Head(name, help, "counter");
  Line(name, value, labels);
}

void MetricsText::Gauge(std::string_view name, std::string_view help, double value,
                        const Labels& labels) {
  Head(name, help, "gauge");
  Line(name, value, labels);
}

void MetricsText::Durations(std::string_view name, std::string_view help,
                            const Histogram::Counts& counts, const Labels& labels) {
  Head(name, help, "histogram");
  const std::string base(name);
  Labels bucket = labels;
  // Buckets are cumulative: each counts everything up to its bound (Prometheus, text format 0.0.4).
  uint64_t all = 0;
  for (size_t i = 0; i < counts.each.size(); ++i) {
    all += counts.each[i];
    const std::string bound = i < Histogram::kUpToS.size() ? Number(Histogram::kUpToS[i]) : "+Inf";
    bucket.emplace_back("le", bound);
    Line(base + "_bucket", static_cast<double>(all), bucket);
    bucket.pop_back();
  }
  Line(base + "_sum", counts.sum_s, labels);
  Line(base + "_count", static_cast<double>(all), labels);
}

void Metrics::Add(Source source) {
  MutexLock lock(mutex_);
  sources_.push_back(std::move(source));
}

std::string Metrics::Text() const {
  std::vector<Source> sources;
  {
    MutexLock lock(mutex_);
    // Adding another one does not wait for these.
    sources = sources_;
  }
  MetricsText text;
  for (const Source& source : sources) source(text);
  return text.Take();
}

int64_t ProcessStartedMs() {
  // Once, so that it stays constant: by the same clock as other times (common/base/unix_time.h).
  static const int64_t started_ms =
      UnixMs() - std::chrono::duration_cast<std::chrono::milliseconds>(
                     std::chrono::steady_clock::now() - kStarted)
                     .count();
  return started_ms;
}

void AddProcess(MetricsText& text) {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  uint64_t pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  auto page_bytes = static_cast<double>(::sysconf(_SC_PAGESIZE));
  text.Counter("process_cpu_seconds_total", "User and system CPU time.",
               Seconds(usage.ru_utime) + Seconds(usage.ru_stime));
  text.Gauge("process_resident_memory_bytes", "Resident memory.",
             static_cast<double>(resident) * page_bytes);
  text.Gauge("process_open_fds", "Open file descriptors.", static_cast<double>(OpenFiles()));
  text.Gauge("process_start_time_seconds", "When the process started, Unix time.",
             static_cast<double>(ProcessStartedMs()) / 1000);
}

void AddBuild(MetricsText& text, std::string_view version) {
  text.Gauge("enamel_build_info", "1; the label says which program this is.", 1,
             {{"version", version}});
}

void AddCertificate(MetricsText& text, std::string_view of, int64_t until_ms) {
  if (until_ms == 0) return;
  text.Gauge("enamel_certificate_expires_seconds", "When a certificate ends, Unix time.",
             static_cast<double>(until_ms) / 1000, {{"of", of}});
}

}  // namespace enamel::server::ops

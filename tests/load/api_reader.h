#pragma once

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "tests/load/http_client.h"
#include "tests/load/school.h"

namespace enamel::load {

// An instructor's page, read repeatedly on a separate thread: lists, an attempt, the exercises.
class ApiReader {
 public:
  // `reads_per_s`: requests start at fixed times, so that a slow answer does not reduce the load.
  ApiReader(net::Endpoint page, const School& school, double reads_per_s);
  ~ApiReader() { Stop(); }
  void Stop();

  // After Stop.
  std::vector<float>& latencies_ms() { return latencies_ms_; }
  uint64_t failures() const { return failures_; }
  const std::string& problem() const { return problem_; }

 private:
  void Run(const std::stop_token& stop);
  void ReadOne(HttpClient& client, uint64_t turn);

  const net::Endpoint page_;
  const School& school_;
  const double period_s_;
  std::string attempt_;
  std::vector<float> latencies_ms_;
  uint64_t failures_ = 0;
  std::string problem_;
  std::jthread thread_;
};

}  // namespace enamel::load

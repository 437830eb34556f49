#pragma once

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "common/base/uuid.h"
#include "tests/load/http_client.h"
#include "tests/load/school.h"

namespace enamel::load {

// Instructors who watch attempts live (schemas/api/openapi.yaml, /attempts/{id}/live): one
// connection each, all on one thread, which reads and counts.
class Viewers {
 public:
  // Viewer i watches attempts[i % attempts.size()]. `slow`: number of further viewers that never
  // read.
  Viewers(net::Endpoint page, const School& school, std::vector<Uuid> attempts, size_t count,
          size_t slow);
  ~Viewers() { Stop(); }
  void Stop();

  uint64_t events() const { return events_; }
  uint64_t bytes() const { return bytes_; }
  const std::string& problem() const { return problem_; }  // after Stop

 private:
  void Run(const std::stop_token& stop);
  int Watch(const Uuid& attempt, const std::string& cookie, bool slow);
  void ReadAll(std::vector<int>& sockets, const std::stop_token& stop);

  const net::Endpoint page_;
  const School& school_;
  const std::vector<Uuid> attempts_;
  const size_t count_, slow_;
  std::atomic<uint64_t> events_{0}, bytes_{0};
  std::string problem_;
  std::jthread thread_;
};

}  // namespace enamel::load

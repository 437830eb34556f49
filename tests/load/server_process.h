#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/net/frame_client.h"

namespace enamel::load {

// Our own enamel-server: started on ports of its choice, killed as abruptly as by a power cut, and
// started again on the same ports. The destructor kills it. Thread safety: none, except pid().
class ServerProcess {
 public:
  // `log`: the file its standard error is appended to.
  ServerProcess(std::filesystem::path program, std::filesystem::path data,
                std::filesystem::path log, std::vector<std::string> more_arguments = {});
  ~ServerProcess();
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  // Returns once it reports ready. Errors: kUnavailable with the end of its log.
  Status Start();
  void Kill();  // SIGKILL
  // SIGTERM, and SIGKILL after 15 s.
  void Stop();

  pid_t pid() const { return pid_; }
  const net::Endpoint& stations() const { return stations_; }
  const net::Endpoint& page() const { return page_; }
  const Sha256& fingerprint() const { return fingerprint_; }

 private:
  Status ReadReadyLine(int fd);

  const std::filesystem::path program_, data_, log_;
  const std::vector<std::string> more_arguments_;
  pid_t pid_ = -1;
  net::Endpoint stations_{"127.0.0.1", 0}, page_{"127.0.0.1", 0};
  Sha256 fingerprint_;
};

// Figures from /proc of processes and their children, including ended ones; zeros for missing
// processes. Peaks are since they were started.
struct ProcessUse {
  double cpu_s = 0;  // user and system, all threads
  double rss_mb = 0, peak_rss_mb = 0;
};
ProcessUse UseOf(const std::vector<pid_t>& pids);

}  // namespace enamel::load

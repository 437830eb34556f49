#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/protocol/messages.h"
#include "common/trace/trace.h"
#include "tests/load/school.h"
#include "tests/load/stations/link.h"

namespace enamel::load {

// The ways to misuse an enrolled chair's key and credential.
enum class Misuse : uint8_t {
  kUnfinished,  // 150 links, each with a frame of 4 MiB that lacks its last byte
  kSmall,       // pings and moments without an end
  kChunks,      // chunks with gaps of 2^32 - 1 ticks
  kReconnects,  // Hello, and away
  kTickets,     // for one attempt after the other
  kOffers,      // of 1024 attempts and 1024 tickets that nobody knows
  kDownloads,   // of the same content
};
inline constexpr size_t kMisuses = 7;
const char* NameOf(Misuse misuse);

// Runs on one thread of its own at nice 19. Thread safety: one thread uses it; the counts are for
// any.
class Thief {
 public:
  struct Counts {
    std::atomic<uint64_t> links{0}, frames{0}, replies{0}, over_budget{0};
  };

  // `turn_s`: how long each of `misuses` takes, which are not none.
  Thief(const LinkTarget& target, const School& school, std::string code,
        std::vector<Misuse> misuses, double turn_s)
      : target_(target),
        school_(school),
        code_(std::move(code)),
        misuses_(std::move(misuses)),
        turn_s_(turn_s) {}
  ~Thief() { Stop(); }
  Thief(const Thief&) = delete;
  Thief& operator=(const Thief&) = delete;

  // The chair, before it is stolen. Errors: kUnavailable.
  Status Enrol();
  void Begin();
  void Stop();

  const Counts& counts() const { return counts_; }
  // After Stop: the refusals, by code and message, and how many of each.
  const std::map<std::string, uint64_t>& refusals() const { return refusals_; }

 private:
  struct Line {
    std::unique_ptr<Link> link;
    bool said_hello = false, greeted = false, opened = false, asked = false;
    size_t waiting = 0;  // replies
    uint32_t last_id = 0;
    std::string session;
    double again_s = 0;
  };

  void Run(const std::stop_token& stop);
  void Step(Line& line, Misuse misuse, double now);
  void Read(Line& line, Misuse misuse);
  void Take(Line& line, Misuse misuse, const wire::Reply& reply);
  void Do(Line& line, Misuse misuse);
  void Ask(Line& line, wire::Request request);
  void SignIn(Line& line);
  void AskForTicket(Line& line);
  void SendNonsense(Line& line);

  const LinkTarget& target_;
  const School& school_;
  const std::string code_;
  const std::vector<Misuse> misuses_;
  const double turn_s_;
  const trace::KeyPair keys_ = trace::NewKeyPair();
  std::string station_id_, credential_;
  Bytes ticket_;
  Bytes header_, nonsense_;
  std::map<std::string, uint64_t> refusals_;
  Counts counts_;
  std::jthread thread_;
};

}  // namespace enamel::load

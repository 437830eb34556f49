#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <random>
#include <string>

#include "common/protocol/messages.h"
#include "tests/load/figures.h"
#include "tests/load/stations/link.h"
#include "tests/load/stations/recording.h"

namespace enamel::load {

// A load's goals for its stations, one after the other.
enum class Goal {
  kTicket,  // enrolled, and with `ticketed` signed in and holding a ticket
  kOpen,    // the attempt is open (or, without a recording, hello is said)
  kStream,  // every chunk committed, each sent no earlier than its last tick would have happened
  kSeal,
};

// Disturbances and companions of the streams. Shares are of chunks, 0 to 1.
struct Disturbances {
  double repeated = 0;    // sent twice
  double disordered = 0;  // sent before the one in front of it
  double live_hz = 0;     // LiveState per station and second
};

struct StationPlan {
  const School* school = nullptr;
  std::string code, name;
  bool ticketed = true;  // false: only connects
  size_t chunk_ticks = 500;
  Disturbances disturbances;
};

// One simulated station: protocol, schedule and account of one attempt. Everything runs on its
// engine's thread; times are seconds of one steady clock.
class Station {
 public:
  Station(const LinkTarget& target, int epoll, uint64_t tag, StationPlan plan,
          StreamFigures& figures);

  // The chunks of the attempt, made from its ticket.
  void Prepare(std::vector<Payload> payloads, uint32_t chunks);
  // Chunk k is due at start_s + (k + 1) chunk lengths.
  void SetStart(double start_s) { start_s_ = start_s; }
  void SetGoal(Goal goal) { goal_ = goal; }
  // Sends only the chunks due at `now`; the attempt ends there.
  void EndAt(double now);

  // Does everything possible now: connects, reads, answers, sends. Returns the time of the next
  // call without an event; infinity: only at an event.
  double Advance(double now);
  // Simulates a pulled cable.
  void Cut();

  bool Reached() const;
  bool connected() const { return greeted_ && link_.state() == Link::State::kOpen; }
  bool in_setup() const { return link_.state() != Link::State::kClosed && !Reached(); }
  const std::string& problem() const { return problem_; }  // why it gave up; empty: it did not
  const Recording* recording() const { return recording_.get(); }
  uint32_t committed() const { return committed_; }
  uint32_t sent() const { return sent_; }
  uint32_t Due(double now) const;
  uint64_t ticks() const { return committed_ticks_; }

 private:
  struct InFlight {
    uint32_t id = 0, seq = 0;
    uint64_t ends_at = 0;  // bytes of this connection when its last one is out
    double out_s = 0;      // when that was; 0: not yet
    bool repeat = false, disordered = false;
  };

  void Read(double now);
  void Take(const wire::Reply& reply, double now);
  void TakeChunkReply(const wire::Reply& reply, double now);
  void Commit(uint32_t chunks);
  void SayHello();
  void AskNext();
  void Ask(wire::Request request);
  void Pump(double now);
  void SendChunk(uint32_t seq, double now, bool repeat, bool disordered);
  void NoteWritten(double now);
  void SendLive(double now);
  void Lost(double now);
  void GiveUp(const std::string& why);
  double NextWake(double now) const;

  StationPlan plan_;
  StreamFigures& figures_;
  Link link_;
  Goal goal_ = Goal::kTicket;
  trace::KeyPair keys_ = trace::NewKeyPair();
  std::mt19937 random_;
  std::string station_id_, credential_, session_;
  Bytes ticket_;
  std::unique_ptr<Recording> recording_;
  std::string problem_;

  // Of this connection.
  bool up_ = false, said_hello_ = false, greeted_ = false, asked_ = false, opened_ = false;
  uint32_t last_id_ = 0;
  std::deque<InFlight> in_flight_;
  double asked_s_ = 0, live_s_ = 0, ping_s_ = 0;

  // Of the attempt.
  double start_s_ = 0, again_s_ = 0;
  double pause_s_ = 0.1;
  uint32_t next_ = 0, sent_ = 0, committed_ = 0;
  uint32_t last_chunk_ = UINT32_MAX;  // the attempt has no more than these
  uint64_t committed_ticks_ = 0;
  bool sealed_ = false;
};

}  // namespace enamel::load

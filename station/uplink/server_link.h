#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/net/frame_client.h"
#include "common/protocol/messages.h"
#include "station/uplink/blob_cache.h"
#include "station/uplink/credentials.h"

namespace enamel::station {

// A person signed in at this station for this connection.
struct Person {
  Uuid id;
  std::string display_name;
  std::string role;
  std::string session;  // opaque
};

struct Catalogue {
  struct Exercise {
    std::string name, title;
    Sha256 exercise, scene, volume;
  };
  struct Profile {
    std::string name, title;
    Sha256 profile;
  };
  std::vector<Exercise> exercises;
  std::vector<Profile> profiles;
};

// What the server has made of an attempt so far.
struct AttemptProgress {
  std::string state;        // "recording", "sealed", "scoring", "scored", "failed", "quarantined"
  double progress = 0;      // 0..1 while scoring
  std::string result_json;  // once scored and visible to the person (schemas/score.md); else empty
};

// The station's side of the wire protocol (schemas/wire), one request at a time, blocking.
//
// Every method returns the server's refusal as its Status, or kUnavailable when the connection
// broke or the server did not answer in time: then connect again. Thread safety: one thread; Cancel
// from any. Real-time: never.
class ServerLink {
 public:
  static constexpr std::chrono::seconds kTimeout{20};

  // Connects and enrols with a fresh key pair. The credentials are not yet saved.
  static Result<Credentials> Enrol(const net::Endpoint& server, const EnrolCode& code,
                                   const std::string& name);

  // Connects and says hello. Errors: kUnauthenticated (another certificate, or the station is not
  // known any more), kUnavailable.
  Status Connect(const Credentials& credentials);
  bool connected() const { return client_.connected(); }
  // False when the server's core is of another version: uploads only.
  bool may_begin_attempts() const { return may_begin_; }

  Result<Person> SignIn(const std::string& login, const std::string& password);
  Result<Catalogue> ListExercises(const Person& person);
  // From the cache if it is there. Errors: kConflict when what came is not what was asked for.
  Result<Bytes> FetchBlob(const Sha256& name, const BlobCache& cache);
  // Signature, station, exercise and profile are checked.
  Result<trace::Ticket> RequestTicket(const Credentials& credentials, const Person& person,
                                      const Sha256& exercise, const Sha256& profile,
                                      bool as_reference);

  // Errors: kNotFound, also for somebody else's attempt.
  Result<AttemptProgress> AttemptStatus(const Person& person, const Uuid& attempt);
  // Keeps a connection alive that has nothing to say.
  Status Ping();

  // Returns the first chunk the server does not have.
  Result<uint32_t> OpenAttempt(ByteView header);
  // Sends without waiting; acknowledgements come from NextAck in any order.
  Status SendChunk(ByteView chunk);
  struct Ack {
    uint32_t seq = 0;
    bool committed = false;
  };
  Result<Ack> NextAck();
  Status Seal(const trace::Seal& seal);

  void Close() { client_.Close(); }
  void Cancel() { client_.Cancel(); }

 private:
  Status Send(wire::Request& request);
  Result<wire::Reply> Receive(uint32_t reply_to);
  Result<wire::Reply> Call(wire::Request& request);

  net::FrameClient client_;
  uint32_t last_id_ = 0;
  bool may_begin_ = false;
};

// "enamel-station 0.1.0".
std::string SoftwareName();

}  // namespace enamel::station

#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/net/frame_client.h"
#include "common/protocol/attempt_facts.h"
#include "common/protocol/messages.h"
#include "common/protocol/remark.h"
#include "common/protocol/station_policy.h"
#include "station/spool/chair_terms.h"
#include "station/uplink/blob_cache.h"
#include "station/uplink/credentials.h"
#include "station/uplink/live_mailbox.h"

namespace enamel::station {

// A person signed in at this station for this connection.
struct Person {
  Uuid id;
  std::string display_name;
  std::string role;
  std::string session;  // opaque
  // The password was for one use: the server allows nothing here until the person chooses another
  // (ChoosePassword, or on the page).
  bool must_change_password = false;
};

struct Catalogue {
  // Of an exercise's documents: what tells exercises of one title apart.
  struct Facts {
    int tooth = 0;         // FDI number; 0: none
    std::string landmark;  // where to cut, by the scene's name for it: "mesial_box"
    bool caries = false, neighbours = false;  // the scene has such tissue
    bool graded = true;                       // scores are seen after their release
  };
  struct Exercise {
    std::string name, title;
    Sha256 exercise, scene, volume;
    Uuid assignment;  // zero: none
    // Of the assignment (schemas/wire/station.proto, ExerciseRef); 0: no limit.
    int64_t due_unix_ms = 0;
    bool late_allowed = false;
    uint32_t attempt_limit = 0, attempts_left = 0;
    bool exam = false;
    HandsAllowed hands = HandsAllowed::kAny;
    Status refusal;                         // why an attempt cannot be begun now; ok: it can
    std::optional<double> best_score = {};  // of this person's that may be seen, 0..100
    std::optional<Facts> facts = {};        // none: not read (Workplace::Describe)
    std::string last_remark = {};  // somebody else's, about this person's work; empty: none
    bool sign_off = false;         // a second person signs at the chair (SignOff)
    int64_t opens_unix_ms = 0;     // of the assignment; 0: it is open
    std::string stations = {};     // names of those that the exam is taken at; empty: any
  };
  struct Profile {
    std::string name, title;
    Sha256 profile;
  };
  std::vector<Exercise> exercises;
  std::vector<Profile> profiles;
};

// Contents of a request for a ticket.
struct TicketRequest {
  Sha256 exercise, profile;
  Uuid assignment;            // from the catalogue
  bool as_reference = false;  // instructors only
  bool for_later = false;     // to be used with or without the server
  Hand hand{};                // what will hold the tool; kNotTold: not known yet
};
struct IssuedTicket {
  trace::Ticket ticket;
  HandsAllowed hands = HandsAllowed::kAny;  // hands it admits; all if the server gave none
  ChairTerms terms;
};

// When a second person signs an exam attempt at this chair.
enum class SignedAt { kStart, kEnd };

struct HeldAttempt {
  Uuid attempt;
  uint32_t chunks = 0;
};
struct Wanted {
  std::vector<Uuid> attempts;
  std::vector<Uuid> revoked;  // tickets
};

// The server's progress with an attempt.
struct AttemptProgress {
  std::string state;        // "recording", "sealed", "scoring", "scored", "failed", "quarantined"
  double progress = 0;      // 0..1 while scoring
  Status problem;           // why it failed or is quarantined
  std::string result_json;  // once scored and visible to the person (schemas/score.md); else empty
  // With it: of this person's attempts at the exercise, oldest first, this one's among them.
  struct Score {
    Uuid attempt;
    double score = 0;  // 0..100
  };
  std::vector<Score> scores = {};
};

// The station's side of the wire protocol (schemas/wire), one request at a time, blocking.
//
// Every method returns the server's refusal as its Status, or kUnavailable when the connection
// broke or the server did not answer in time: then connect again. Thread safety: one thread; Cancel
// from any. Real-time: never.
class ServerLink {
 public:
  static constexpr std::chrono::seconds kTimeout{20};  // to connect
  // A server that is busy sends StillWaiting every second. One that owes an answer and sends nothing
  // for this long hangs: connecting again may reach another.
  static constexpr std::chrono::seconds kSilence{5};

  explicit ServerLink(std::chrono::milliseconds silence = kSilence) : silence_(silence) {}

  // Connects and enrols with a fresh key pair; or, with `before`, as that station with its id and
  // key (name empty: its old one). The credentials are not yet saved.
  static Result<Credentials> Enrol(const net::Endpoint& server, const EnrolCode& code,
                                   const std::string& name,
                                   const std::optional<Credentials>& before = {});

  // Connects and exchanges hellos. Errors: kUnauthenticated (another certificate, or the server
  // does not know the station any more), kUnavailable.
  Status Connect(const Credentials& credentials);
  bool connected() const { return client_.connected(); }
  // False when the server's core has another version: uploads only.
  bool may_begin_attempts() const { return may_begin_; }
  // The page's address, from the server's hello; empty if missing or unsuitable
  // (protocol::IsPageUrl).
  const std::string& page_url() const { return page_url_; }
  // What the server wants of this station's settings, from its hello.
  const protocol::Policy& policy() const { return policy_; }
  // How far the server's clock is ahead of this machine's, ms, accurate to half the duration of the
  // hello.
  int64_t server_ahead_ms() const { return server_ahead_ms_; }

  Result<Person> SignIn(const std::string& login, const std::string& password);
  // Replaces the one-time password that `person` signed in with on this connection. Returns the
  // person with another session. Errors: kInvalidInput with field kNewPassword (the server's
  // rules), kForbidden (the old one is wrong); kUnavailable also while tries are slowed
  // down.
  Result<Person> ChoosePassword(const Person& person, const std::string& one_time,
                                const std::string& chosen);
  Result<Catalogue> ListExercises(const Person& person);
  // From the cache if possible. Errors: kConflict when the answer is not the requested blob.
  Result<Bytes> FetchBlob(const Sha256& name, const BlobCache& cache);
  // Checks signature, station, exercise and profile.
  Result<IssuedTicket> RequestTicket(const Credentials& credentials, const Person& person,
                                     const TicketRequest& wanted);

  // Signs an attempt of this station by a second person's login and PIN, which only the server
  // checks. Returns the person's name. Errors: kUnauthenticated, kForbidden (may not sign this),
  // kConflict (too late, signed by somebody else); kUnavailable also while tries are slowed down.
  Result<std::string> SignOff(const Uuid& attempt, SignedAt at, const std::string& login,
                              const std::string& pin);

  // Errors: kNotFound, also for somebody else's attempt.
  Result<AttemptProgress> AttemptStatus(const Person& person, const Uuid& attempt);
  // How far a scored attempt lies from its reference (common/timeline/deviation.h). Errors: those of AttemptStatus; kForbidden
  // before the score may be seen, kNotFound also without a reference, kConflict, kTooLarge.
  Result<Bytes> Deviation(const Person& person, const Uuid& attempt);
  // Makes a scored attempt its exercise's reference, with the dentist's consent. Errors: kForbidden
  // without the right, kConflict before it is scored, and with field protocol::kAnyway when the
  // attempt does not meet the exercise's criteria and `anyway` gives no reason to accept it.
  Status MarkReference(const Person& person, const Uuid& attempt, const std::string& dentist,
                       bool consent, const std::string& anyway = {});
  // Keeps an idle connection alive. Returns messages for the chair of `attempt`, which has shown
  // messages up to `shown`; none without an attempt.
  Result<std::vector<protocol::Remark>> Ping(const std::optional<Uuid>& attempt = {},
                                             uint64_t shown = 0);

  // Asks which of the attempts the server lacks entirely, and which of the tickets (by attempt)
  // must not be used any more. At most 1024 of each.
  Result<Wanted> OfferAttempts(const std::vector<HeldAttempt>& attempts,
                               const std::vector<Uuid>& tickets);

  // Reports that the ticket of this attempt was not used and will not be. Errors: kNotFound (no
  // such ticket of this station), kConflict (the attempt was opened); asking again changes neither.
  Status ReturnTicket(const Uuid& attempt);

  struct Opened {
    uint32_t next_seq = 0;  // first chunk the server does not have
    bool watched = false;
  };
  Result<Opened> OpenAttempt(ByteView header, const protocol::AttemptFacts& facts);
  // Sends without waiting; PollAck returns the acknowledgements. `shown`: highest id of the
  // attempt's messages that was shown.
  Status SendChunk(ByteView chunk, uint64_t shown = 0);
  struct Ack {
    Uuid attempt;
    uint32_t seq = 0;
    bool committed = false;
    bool watched = false;                     // LiveState is wanted
    std::vector<protocol::Remark> remarks{};  // to the attempt's chair
  };
  // The next acknowledgement, or nothing within `patience`. Errors: kUnavailable, after kSilence too.
  Result<std::optional<Ack>> PollAck(std::chrono::milliseconds patience);
  // Has no answer.
  Status SendLive(const Uuid& attempt, const LivePoint& point);
  Status Seal(const trace::Seal& seal);

  void Close() { client_.Close(); }
  void Cancel() { client_.Cancel(); }

 private:
  Status Send(wire::Request& request);
  Result<wire::Reply> Receive(uint32_t reply_to);
  Result<wire::Reply> Call(wire::Request& request);
  // A request that SignedIn answers.
  Result<Person> CallForPerson(wire::Request& request);

  // Closes a connection on which nothing has moved for too long.
  Status LeaveSilent();

  const std::chrono::milliseconds silence_;
  net::FrameClient client_;
  uint32_t last_id_ = 0;
  bool may_begin_ = false;
  std::string page_url_;
  protocol::Policy policy_;
  int64_t server_ahead_ms_ = 0;
};

// "enamel-station 0.1.0".
std::string SoftwareName();

}  // namespace enamel::station

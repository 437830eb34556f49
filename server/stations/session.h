#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "common/protocol/attempt_facts.h"
#include "common/protocol/messages.h"
#include "common/protocol/remark.h"
#include "common/trace/trace.h"
#include "server/auth/authenticator.h"
#include "server/live/live_board.h"
#include "server/live/station_board.h"
#include "server/stations/arrivals.h"
#include "server/stations/content.h"
#include "server/storage/store.h"
#include "server/training/ticket_rules.h"

namespace enamel::server::stations {

// How long after its ticket ran out a recording may still be opened here. The station checks that
// it begins in time; it may have been cut off from the server since.
inline constexpr UnixMs kLateUploadMs = 7ll * 24 * 60 * 60 * 1000;
inline constexpr size_t kBlobPartBytes = 1 << 20;
// A station that is revoked learns of it this long after, at the latest, and its connection ends:
// with its next request (here), or without one (StationServer).
inline constexpr UnixMs kAdmittedEveryMs = 2000;
// When a station said something last is written to the store this often at most.
inline constexpr UnixMs kNotedEveryMs = 60'000;
inline constexpr size_t kMaxSignedIn = 8;  // people signed in on one connection

// What all sessions share. Everything in it outlives them and may be used from any thread.
struct Services {
  Store& store;
  auth::Authenticator& authenticator;
  LiveBoard& live;
  Content& content;
  trace::KeyPair ticket_key;
  std::string software;  // "enamel-server 0.9.0"
  std::string release;   // "0.9.0" (protocol::MayMeet)
  std::function<UnixMs()> clock;
  std::string page_url{};  // where people open the page (protocol::IsPageUrl); empty: not told
  StationBoard* board = nullptr;  // who is connected; none: nobody asks
  Arrivals arrivals{};
  // What this server measures, for the school's others; none: there are none. Does not wait.
  std::function<wire::Measured()> measure{};
};

// kUnauthenticated: the answer to a station whose connection ends because it was revoked.
Status RevokedStation();

// What to send back and whether the connection ends after it. No reply: to LiveState.
struct Answer {
  std::optional<wire::Reply> reply;
  bool close = false;
  Uuid attempt{};  // whose recording it is about, for the log; zero: none that is known
};

// The server's end of the station protocol (schemas/wire/README.md) without any I/O of its own: a
// request in, an answer out. One per connection. It returns a chunk's ChunkAck only once the store
// has the chunk durably. Thread safety: one call at a time. Calls block on the store and decode
// chunks: run them in StorePool.
class Session {
 public:
  Session(Services& services, std::string peer_address)
      : services_(services), peer_address_(std::move(peer_address)) {}

  auth::Authenticator& authenticator() const { return services_.authenticator; }
  // After Welcome: larger frames are allowed.
  bool welcomed() const { return station_.has_value(); }
  // What the station is called; empty before Welcome.
  std::string name() const { return station_ ? station_->name : std::string(); }
  bool has_sign_ins() const { return !signed_in_.empty(); }
  const std::optional<StationRow>& station() const { return station_; }

  // Handle answers it without touching the store: no thread of its own is needed.
  bool IsQuick(const wire::Request& request) const {
    return (request.has_live_state() || request.has_ping()) && KnownAdmitted();
  }
  // Everything but sign-in, ChoosePassword and sign-off, which wait for the hashing threads:
  //   if (auto who = session.SignInWanted(request)) answer = session.FinishSignIn(request, co_await
  //   …);
  Answer Handle(const wire::Request& request);
  std::optional<auth::SignInRequest> SignInWanted(const wire::Request& request) const;
  Answer FinishSignIn(const wire::Request& request, const Result<auth::SignedIn>& result);
  // A one-time password is replaced: with Authenticator::ChangePassword, then FinishSignIn. Blocks.
  // Errors: kForbidden when it is another kind of password; PersonOf's.
  struct PasswordChoice {
    auth::Identity identity;
    auth::Authenticator::PasswordChange change;
  };
  Result<PasswordChoice> PasswordWanted(const wire::Request& request);
  // The same of a sign-off, with Authenticator::CheckPin.
  std::optional<auth::SignInRequest> SignOffWanted(const wire::Request& request) const;
  Answer FinishSignOff(const wire::Request& request, const Result<Person>& signer);

  // Ends the sign-ins made on this connection. Blocks.
  void End();

 private:
  Result<wire::Reply> Dispatch(const wire::Request& request);
  Result<wire::Reply> Do(const wire::Hello& hello);
  Result<wire::Reply> Do(const wire::Enrol& enrol);
  Result<wire::Reply> Do(const wire::ListExercises& request);
  Result<wire::Reply> Do(const wire::GetBlob& request);
  Result<wire::Reply> Do(const wire::RequestTicket& request);
  Result<wire::Reply> Do(const wire::OpenAttempt& request);
  Result<wire::Reply> Do(const wire::PutChunk& request);
  Result<wire::Reply> Do(const wire::SealAttempt& request);
  Result<wire::Reply> Do(const wire::AttemptStatus& request);
  Result<wire::Reply> Do(const wire::GetDeviation& request);
  Result<wire::Reply> Do(const wire::MarkReference& request);
  Result<wire::Reply> Do(const wire::OfferAttempts& request);
  Result<wire::Reply> Do(const wire::ReturnTicket& request);
  Result<wire::Reply> Do(const wire::Ping& ping);
  Result<wire::Reply> Do(const wire::SignOff& request, const Person& signer);
  void Take(const wire::LiveState& live);
  // Adds the remarks for the chair of this station's attempt, which has shown those up to `shown`.
  void AddRemarks(const Uuid& attempt, uint64_t shown,
                  google::protobuf::RepeatedPtrField<wire::Remark>& out);
  Status KeepFacts(const AttemptRow& row, const protocol::AttemptFacts& facts);

  // Not yet to be looked up again, or not welcomed.
  bool KnownAdmitted() const;
  // Looked up every kAdmittedEveryMs. Errors: RevokedStation.
  Status StillAdmitted();
  // It has said something.
  void NoteHeard();
  Result<auth::Identity> IdentityOf(const std::string& session_token);
  Result<Person> PersonOf(const std::string& session_token);
  // An attempt that the person of this session may see. Errors: kNotFound for others' attempts, as
  // if they did not exist, so that nobody learns of them; PersonOf's.
  struct Seen {
    Person person;
    AttemptRow row;
    bool teaches = false;
  };
  Result<Seen> SeenAttempt(const std::string& session_token, const std::string& attempt);
  Result<bool> MaySeeScore(const Seen& seen);
  // Own scores of the attempt's person at its exercise (schemas/wire/README.md, "Own scores").
  Status AddScores(const Seen& seen, wire::AttemptState& out);
  Result<std::vector<ExerciseRow>> ExercisesOf(const Person& person);
  // Names of an exam's stations, for people.
  Result<std::string> StationsText(const AssignmentRow& assignment);
  Status AddExercise(const ExerciseRow& row, const std::vector<SceneRow>& scenes,
                     wire::Exercises& out);
  struct Outcome {
    double best_score = 0;
    std::string last_remark;  // empty: none
    int looked_at = 0;        // attempts, for a remark
  };
  Result<std::map<Uuid, Outcome>> OutcomesOf(const Person& person,
                                             const std::vector<AssignedRow>& assigned);
  // Somebody else's newest about this attempt; empty: none.
  Result<std::string> LastRemark(const Uuid& attempt, const Uuid& person);
  Status AddAssigned(const AssignedRow& row, const std::vector<SceneRow>& scenes,
                     wire::Exercises& out);
  // The assignment that a ticket of this person for this exercise counts under; none: reference
  // cuts, and trials of instructors and admins. Errors: kForbidden (not assigned, or not now);
  // field() names the rule.
  Result<std::optional<AssignedRow>> AssignmentFor(const Person& person,
                                                   const ExerciseRow& exercise,
                                                   const wire::RequestTicket& request);
  Status HandMayTake(const AssignedRow& assigned, const wire::RequestTicket& request);
  Status GuessTerms(const trace::Ticket& ticket, AttemptRow& row);
  // Rate and time limit of the exercise's document.
  Status SetTiming(AttemptRow& row);
  Status CheckHeader(const trace::Header& header);
  Status CheckParams(const trace::Header& header);
  // From now on the request is about this attempt. Errors: kNotFound unless it was ticketed for this
  // station.
  Status MustBeOurs(const Uuid& attempt);
  // Whether this server lacks some of an attempt that a station of its had finished sending.
  Result<bool> Lacks(const wire::HeldAttempt& held);
  // Whether a ticket that was not used yet must not be any more.
  Result<bool> Revoked(const Uuid& attempt);
  // Errors: kConflict when the ticket ran out longer than kLateUploadMs ago.
  Status MayStillBegin(const trace::Ticket& ticket) const;
  // The thing that this ticket's recording last waited for, as in the audit trail; empty: never.
  Result<std::string> ToldToAwait(const Uuid& attempt);
  // Tells it to wait: kUnavailable with field protocol::kAwaited. Audited when it is news.
  Status Await(const trace::Ticket& ticket, const std::string& what, const std::string& which);
  // The attempt of a ticket that was issued here and is not known any more: the server was restored
  // from a backup made before it. Whether it was to be a reference is not in a ticket. Errors also:
  // kConflict (person erased, ticket too old and never told to wait), kUnavailable with field
  // protocol::kAwaited (person, exercise or profile is newer than the backup).
  Result<AttemptRow> Readmit(const trace::Ticket& ticket);
  Status NotSigned(ByteView chunk);

  Services& services_;
  const std::string peer_address_;
  std::optional<StationRow> station_;
  std::unique_ptr<StationBoard::Connection> entered_;  // from Welcome on
  uint32_t station_core_version_ = 0;
  std::string software_;
  bool shows_remarks_ = false;
  UnixMs noted_ms_ = 0;         // when the store was told last that it was heard
  UnixMs admitted_ms_ = 0;      // when it was known to be admitted last
  std::set<Sha256> signed_in_;  // token hashes
  std::set<Uuid> ours_;         // attempts known to be of this station
  Uuid about_;                  // Answer::attempt of the request under way
  // The blob being fetched part by part.
  Sha256 fetched_hash_;
  Content::Blob fetched_;
};

}  // namespace enamel::server::stations

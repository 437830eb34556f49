#pragma once

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "common/base/mutex.h"
#include "common/protocol/refusals.h"
#include "station/session/look_back.h"
#include "station/session/prepared_attempt.h"
#include "station/session/running_attempt.h"
#include "station/session/ticket_safe.h"
#include "station/spool/spool.h"
#include "station/uplink/server_link.h"

namespace enamel::station {

// A ticket taken in advance, and whether its attempt was begun and interrupted.
struct ReservedAttempt {
  LockedTicket ticket;
  bool cut_off = false;
};

// Outcome of handing back a ticket. In both cases it can no longer be opened here.
enum class HandedBack {
  kAtServer,  // it no longer counts
  kLater,     // the server could not be reached: the uploader returns it later
};

// Field of MarkReference's kConflict that a reason would resolve.
inline constexpr const char* kNeedsReason = protocol::kAnyway;

// Field of SignIn's kForbidden for a one-time password.
inline constexpr const char* kOneTimePassword = "one_time_password";

struct WorkplaceOptions {
  std::filesystem::path data;
  std::string server = {};  // HOST:PORT when it has moved since enrolment; else empty
  Retention retention = {};
  UploaderOptions uploader = {};  // its `retention` is the one above
};

// The steps of an attempt, for the command line and the window:
//
//   SignIn -> Exercises -> Prepare -> TakeTicket -> Begin -> (RunningAttempt) -> Progress ->
//   SignOut
//
// A step that fails changes nothing: try it again, or take another one. A sign-in lasts as long as
// the connection, which is kept alive here; once it is lost the person signs in again. Every step
// except Begin and SignOut waits for the server while that says that it works on it, so the window
// calls them from a separate thread. Thread safety: any thread; steps wait for each other.
//
// Sign-ins, sign-outs and attempts are logged, with people's ids; never typed text.
//
// Errors of the steps: the server's refusals in its words, kUnavailable when it cannot be reached
// (the message says what to do), kUnauthenticated when nobody is signed in.
inline constexpr char kServerAway[] = "server_away";
// Field of MakeReady's errors: this station cannot record now (kStorage), or another program here
// records (kConflict).
inline constexpr char kRecordingHere[] = "recording_here";

class Workplace {
 public:
  // Loads the credentials, opens the spool. Errors: LoadCredentials', the spool's.
  static Result<std::unique_ptr<Workplace>> Open(const WorkplaceOptions& options);
  ~Workplace();
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;

  const std::filesystem::path& data() const { return data_; }  // the station's folder
  // Connects if needed. Errors also: kVersion when the server's core differs (recordings can be
  // uploaded, attempts not begun); kForbidden with field kOneTimePassword for such a password, with
  // where to change it (the page's address, if the server gives it).
  Result<Person> SignIn(const std::string& login, const std::string& password);
  // The same with a one-time password, which `chosen` replaces. Until it does, the one-time
  // password works. Errors also: ServerLink::ChoosePassword's.
  Result<Person> SignInChoosing(const std::string& login, const std::string& one_time,
                                const std::string& chosen);
  // Ends the connection and with it the sign-in, at once: a step waiting for the server ends with
  // kUnavailable (field "cancelled").
  void SignOut();
  // The person signed in; none once the connection is lost.
  std::optional<Person> person() const;

  Result<Catalogue> Exercises();
  // Adds the facts of every exercise, from its documents in the cache or at the server. Those of
  // which they cannot be read stay without: what is wrong shows when one is prepared. Remembers the
  // practice exercises for Practices, and fetches the device profiles that these need.
  void Describe(Catalogue& catalogue);
  // Fetches the documents that are not in the cache yet.
  Result<PreparedAttempt> Prepare(const Catalogue::Exercise& exercise,
                                  const Catalogue::Profile& profile);
  // Checks, before a ticket is spent, that this process may record here, and that the spool takes a
  // durable test write and has room. TakeTicket and Begin call it if needed. Errors: kConflict
  // while another process records here; kStorage with the room needed.
  Status MakeReady(PreparedAttempt& prepared);
  // Takes the ticket. From here on the server waits for this attempt, so prepare everything else
  // first. `as_reference`: instructors only. An earlier ticket that was not used is handed back
  // first.
  Status TakeTicket(PreparedAttempt& prepared, bool as_reference);
  // Starts ticking. `device` outlives the attempt. Requires: a ticket. Errors: MakeReady's, the
  // spool's.
  Result<std::unique_ptr<RunningAttempt>> Begin(PreparedAttempt& prepared, Device& device,
                                                const AttemptOptions& options);
  // An attempt that needs signatures (ChairTerms::sign_off): a second person signs its start,
  // between TakeTicket and Begin, and its end. The server checks login and PIN, and nothing of them
  // is kept here; needs nobody signed in. Returns the name of whoever signed. Errors:
  // ServerLink::SignOff's.
  Result<std::string> SignOff(const Uuid& attempt, SignedAt at, const std::string& login,
                              const std::string& pin);
  // The end of such an attempt is signed, or will not be: until then Begin holds its seal back, and
  // it is not handed in. Again, or for another attempt: nothing changes. A program that ends before
  // leaves it to the next one, which hands it in.
  void HandIn(const Uuid& attempt) { uploader_.ReleaseSeal(attempt); }
  // For a person who turns back after TakeTicket, without Begin: the uploader returns the ticket,
  // so that it does not count. Does not wait for the server. Without such a ticket it does nothing.
  void HandBackUnused();

  // Tickets taken in advance: workplace_reserved.cpp.

  // Takes a ticket now and locks it with a PIN, for an attempt within 12 hours with or without the
  // server. The cache holds its documents once it was prepared. Errors also: the PIN's
  // (CheckPin); kForbidden for an exam.
  Status Reserve(const PreparedAttempt& prepared, const std::string& pin);
  // Tickets taken in advance whose attempt was not begun (use PrepareReserved), or was interrupted
  // (use PrepareResume with the PIN). Needs no server.
  Result<std::vector<ReservedAttempt>> Reserved();
  // Gives back a ticket taken in advance, so that it does not count: with its PIN, or without it
  // when its person is signed in (or somebody who may see that person's attempts). Tries to notify
  // the server at once; failing that, the uploader does later. For entries of Reserved that are not
  // interrupted. Errors: TicketSafe::Open's (PIN), kConflict when it was begun, kNotFound; without
  // a PIN also those of Progress.
  Result<HandedBack> GiveBack(const Uuid& attempt, const std::string& pin);
  Result<HandedBack> GiveBack(const Uuid& attempt);
  // Needs no server. Errors: TicketSafe::Open's; kConflict when it was begun (resume it then);
  // kForbidden when the server would refuse the recording: another station's, not signed by it,
  // expired.
  Result<PreparedAttempt> PrepareReserved(const Uuid& attempt, const std::string& pin);

  // Practice without the server, which needs nobody signed in: workplace_practice.cpp.

  // Whether this station remembers any practice exercise. Their documents may be lost meanwhile.
  bool RemembersPractice() const;
  // The practice exercises, never graded ones or exams, of which the cache has every document; and
  // the device profiles that it has. Reads them all: wait for the disk elsewhere than in the window.
  Catalogue Practices() const;
  // Prepares one of them, for a run of which nothing is recorded. Errors: kNotFound when the cache
  // has lost a document; kForbidden when it is graded.
  Result<PreparedAttempt> PreparePractice(const Catalogue::Exercise& exercise,
                                          const Catalogue::Profile& profile) const;

  // Attempts that the spool has: workplace_resume.cpp.

  // Interrupted attempts without an end. Attempts still being made are among them.
  Result<std::vector<SpooledAttempt>> Unfinished();
  // Unfinished attempts of one person.
  Result<std::vector<SpooledAttempt>> UnfinishedOf(const Uuid& person);
  // One person's attempts handed in here that the spool still has, newest first; without those that
  // the server refused.
  Result<std::vector<SpooledAttempt>> HandedInOf(const Uuid& person, size_t most);
  // Replays an attempt's recording to the same tooth and core, checked bit by bit. The person
  // signed in must be the attempt's, or the PIN that of its reserved ticket. Errors: kForbidden
  // (somebody else's), kConflict (ended; or the replay differs from the recording), kVersion
  // (another core). `keep_going` receives the progress, 0..1, and may cancel.
  using KeepGoing = std::function<bool(double progress)>;
  Result<PreparedAttempt> PrepareResume(const Uuid& attempt, const KeepGoing& keep_going = {});
  Result<PreparedAttempt> PrepareResume(const Uuid& attempt, const std::string& pin,
                                        const KeepGoing& keep_going = {});
  // A recording that the spool has, to look at a moment of it again: for the person signed in, whose
  // it must be. Errors: kForbidden (somebody else's), kVersion (made by another version), kNotFound.
  Result<std::unique_ptr<LookBack>> LookBackAt(const Uuid& attempt);
  // Seals it where its recording ends.
  Result<trace::Seal> Close(const Uuid& attempt);

  // The server's progress with an attempt.
  Result<AttemptProgress> Progress(const Uuid& attempt);
  // How far it lies from its reference, as ServerLink::Deviation gives it.
  Result<Bytes> Deviation(const Uuid& attempt);
  // Makes a scored attempt the reference of its exercise: instructors, with the dentist's consent.
  // Errors also: kConflict with field kNeedsReason when the attempt does not meet the exercise's
  // criteria and `anyway` gives no reason to accept it.
  Status MarkReference(const Uuid& attempt, const std::string& dentist, bool consent,
                       const std::string& anyway = {});

  Spool& spool() { return *spool_; }
  Uploader& uploader() { return uploader_; }
  const Credentials& credentials() const { return credentials_; }

 private:
  Workplace(const WorkplaceOptions& options, Credentials credentials, std::unique_ptr<Spool> spool);
  Result<Person> SignInAtServer(const std::string& login, const std::string& password,
                                const std::string& chosen);
  Result<Person> Logged(Result<Person> person) const;
  Status ConnectForPeople(ServerLink& link);
  Status CheckTicket(const trace::Ticket& ticket) const;
  Status MeasureGap(PreparedAttempt& prepared);
  // Exclusive use of the connection for this object's lifetime.
  struct LinkInUse {
    std::unique_lock<Mutex> alone;
    std::shared_ptr<ServerLink> link;
    ServerLink& operator*() const { return *link; }
    ServerLink* operator->() const { return link.get(); }
  };
  LinkInUse UseLink();
  void ForgetPerson(const char* how) ENAMEL_REQUIRES(mutex_);
  // The person on this connection. Errors: kUnauthenticated.
  Result<Person> SignedIn(const ServerLink& link);
  Result<std::string> SignOffAtServer(const Uuid& attempt, SignedAt at, const std::string& login,
                                      const std::string& pin);
  Status TellReturned(ServerLink& link);
  Result<HandedBack> HandBackNow(const Uuid& attempt);
  Status AskForTicket(PreparedAttempt& prepared, bool as_reference);
  Result<trace::Header> HeaderOf(const Uuid& attempt);
  using Fetch = std::function<Result<Bytes>(const Sha256&)>;
  static Result<Catalogue::Facts> FactsOf(const Sha256& exercise, const Fetch& fetch);
  Result<PreparedAttempt> FromCache(const Sha256& exercise, const Sha256& profile) const;
  Result<PreparedAttempt> OfHeader(const trace::Header& header);
  Result<PreparedAttempt> Replayed(const trace::Header& header, const KeepGoing& keep_going);
  void KeepAlive();

  const std::filesystem::path data_;
  const Credentials credentials_;
  const std::unique_ptr<Spool> spool_;
  TicketSafe safe_;
  Uploader uploader_;
  mutable Mutex link_mutex_;  // held while a request is under way
  mutable Mutex mutex_;
  // Its target, except for Cancel, is guarded by link_mutex_.
  std::shared_ptr<ServerLink> link_ ENAMEL_GUARDED_BY(mutex_) = std::make_shared<ServerLink>();
  std::condition_variable_any changed_;
  std::optional<Person> person_ ENAMEL_GUARDED_BY(mutex_);
  Uuid unused_ ENAMEL_GUARDED_BY(mutex_);  // taken by TakeTicket and not used
  bool stop_ ENAMEL_GUARDED_BY(mutex_) = false;
  std::thread keep_alive_;
};

}  // namespace enamel::station

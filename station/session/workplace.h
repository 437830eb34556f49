#pragma once

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "station/session/prepared_attempt.h"
#include "station/session/running_attempt.h"
#include "station/session/ticket_safe.h"
#include "station/spool/spool.h"
#include "station/uplink/server_link.h"

namespace enamel::station {

// A ticket for later, and whether its attempt was begun and cut off.
struct ReservedAttempt {
  LockedTicket ticket;
  bool cut_off = false;
};

// What became of a ticket that was handed back: it opens nothing here any more either way.
enum class HandedBack {
  kAtServer,  // it no longer counts
  kLater,     // the server could not be asked: the uploader tells it as soon as it can
};

// Field of MarkReference's kConflict where a reason would do.
inline constexpr const char* kNeedsReason = protocol::kAnyway;

struct WorkplaceOptions {
  std::filesystem::path data;
  std::string server = {};  // HOST:PORT when it has moved since enrolment; else empty
  Retention retention = {};
  UploaderOptions uploader = {};  // its `retention` is the one above
};

// A person's way through an attempt, step by step, for the command line and the window:
//
//   SignIn -> Exercises -> Prepare -> TakeTicket -> Begin -> (RunningAttempt) -> Progress ->
//   SignOut
//
// A step that fails changes nothing: it can be tried again, or another one taken. A sign-in lasts
// as long as the connection, which is kept alive here; once it is lost the person signs in again.
// Every step but Begin and SignOut may wait for the server for up to ServerLink::kTimeout: the
// window calls them from a thread of its own. Thread safety: any thread; steps wait for each other.
//
// Sign-ins and -outs, and attempts, are logged, people by their id; never what was typed.
//
// Errors of the steps: the server's refusals in its words, kUnavailable when it cannot be reached
// (what to do is in the message), kUnauthenticated when nobody is signed in.
class Workplace {
 public:
  // Loads the credentials, opens the spool. Errors: LoadCredentials', the spool's.
  static Result<std::unique_ptr<Workplace>> Open(const WorkplaceOptions& options);
  ~Workplace();
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;

  const std::filesystem::path& data() const { return data_; }  // the station's folder
  // Connects if need be. Errors also: kVersion when this server's core is another: recordings can
  // be uploaded, attempts not begun; kForbidden with where to change a password that was for one
  // use (the page's address, where the server says it).
  Result<Person> SignIn(const std::string& login, const std::string& password);
  // Ends the connection and with it the sign-in, at once: a step that waits for the server ends
  // with kUnavailable (field "cancelled").
  void SignOut();
  // Who is signed in; nobody once the connection is lost.
  std::optional<Person> person() const;

  Result<Catalogue> Exercises();
  // Fetches what of it is not in the cache yet.
  Result<PreparedAttempt> Prepare(const Catalogue::Exercise& exercise,
                                  const Catalogue::Profile& profile);
  // Before a ticket is spent: the spool is this attempt's alone, takes a durable test write and has
  // room for it. TakeTicket and Begin do it where it was not done. Errors: kConflict while another
  // process records here; kStorage with how much room is needed.
  Status MakeReady(PreparedAttempt& prepared);
  // From here on the server waits for this attempt: have everything else in place before.
  // `as_reference`: instructors only. A ticket taken before and not begun with is handed back
  // first.
  Status TakeTicket(PreparedAttempt& prepared, bool as_reference);
  // Begins to tick. `device` outlives the attempt. Requires: a ticket. Errors: MakeReady's, the
  // spool's.
  Result<std::unique_ptr<RunningAttempt>> Begin(PreparedAttempt& prepared, Device& device,
                                                const AttemptOptions& options);
  // The ticket of TakeTicket, where Begin did not follow, will not be used: the uploader returns
  // it, so that it does not count. For who turns back in between; does not wait for the server.
  // Without such a ticket: nothing.
  void HandBackUnused();

  // Takes a ticket now and locks it with a PIN, to make the attempt within 12 hours with or without
  // the server. Its documents are in the cache once it was prepared. Errors also: the PIN's
  // (TicketSafe::CheckPin); kForbidden for an exam.
  Status Reserve(const PreparedAttempt& prepared, const std::string& pin);
  // Tickets for later whose attempt was not begun, or was cut off: PrepareReserved takes the one,
  // PrepareResume with the PIN the other. Needs no server.
  Result<std::vector<ReservedAttempt>> Reserved();
  // A person who will not use a ticket for later gives it back, so that it does not count: with its
  // PIN, or, the PIN forgotten, signed in as its person (or who may see that person's attempts).
  // Tries to tell the server at once; without it the uploader does later. For a button beside the
  // list of Reserved that are not cut off. Errors: TicketSafe::Open's (PIN), kConflict when it was
  // begun, kNotFound; without a PIN also those of Progress.
  Result<HandedBack> GiveBack(const Uuid& attempt, const std::string& pin);
  Result<HandedBack> GiveBack(const Uuid& attempt);
  // Needs no server. Errors: TicketSafe::Open's; kConflict when it was begun (resume it then);
  // kForbidden when the server would not take its recording: another station's, not signed by it,
  // expired.
  Result<PreparedAttempt> PrepareReserved(const Uuid& attempt, const std::string& pin);

  // Attempts that were cut off and have no end. Those being made are among them.
  Result<std::vector<SpooledAttempt>> Unfinished();
  // Those of one person.
  Result<std::vector<SpooledAttempt>> UnfinishedOf(const Uuid& person);
  // What one person handed in here and the spool still has, newest first; not what the server
  // refused.
  Result<std::vector<SpooledAttempt>> HandedInOf(const Uuid& person, size_t most);
  // Replays what was recorded of one: the same tooth and the same core to the bit, which is
  // checked. The person signed in must be the attempt's; or the PIN is that of its reserved ticket.
  // Errors: kForbidden (somebody else's), kConflict (ended; or it does not replay to what was
  // recorded), kVersion (another core). `keep_going` sees the progress, 0..1, and may cancel.
  using KeepGoing = std::function<bool(double progress)>;
  Result<PreparedAttempt> PrepareResume(const Uuid& attempt, const KeepGoing& keep_going = {});
  Result<PreparedAttempt> PrepareResume(const Uuid& attempt, const std::string& pin,
                                        const KeepGoing& keep_going = {});
  // Seals it as far as it goes.
  Result<trace::Seal> Close(const Uuid& attempt);

  // What the server has made of an attempt so far.
  Result<AttemptProgress> Progress(const Uuid& attempt);
  // Makes a scored attempt the reference of its exercise: instructors, with the dentist's consent.
  // Errors also: kConflict with field kNeedsReason where it does not do what the exercise asks for
  // and `anyway` does not say why it is right all the same.
  Status MarkReference(const Uuid& attempt, const std::string& dentist, bool consent,
                       const std::string& anyway = {});

  Spool& spool() { return *spool_; }
  Uploader& uploader() { return uploader_; }
  const Credentials& credentials() const { return credentials_; }

 private:
  Workplace(const WorkplaceOptions& options, Credentials credentials, std::unique_ptr<Spool> spool);
  Result<Person> SignInAtServer(const std::string& login, const std::string& password);
  Status ConnectForPeople(ServerLink& link);
  Status CheckTicket(const trace::Ticket& ticket) const;
  Status MeasureGap(PreparedAttempt& prepared);
  // The connection, for as long as this lives, alone.
  struct LinkInUse {
    std::unique_lock<std::mutex> alone;
    std::shared_ptr<ServerLink> link;
    ServerLink& operator*() const { return *link; }
    ServerLink* operator->() const { return link.get(); }
  };
  LinkInUse UseLink();
  void ForgetPerson(const char* how);  // requires: mutex_ is held
  // Who it is on this connection. Errors: kUnauthenticated.
  Result<Person> SignedIn(const ServerLink& link);
  Status TellReturned(ServerLink& link);
  Result<HandedBack> HandBackNow(const Uuid& attempt);
  Status AskForTicket(PreparedAttempt& prepared, bool as_reference);
  Result<trace::Header> HeaderOf(const Uuid& attempt);
  Result<PreparedAttempt> FromCache(const trace::Ticket& ticket);
  Result<PreparedAttempt> Replayed(const trace::Header& header, const KeepGoing& keep_going);
  void KeepAlive();

  const std::filesystem::path data_;
  const Credentials credentials_;
  const std::unique_ptr<Spool> spool_;
  TicketSafe safe_;
  Uploader uploader_;
  mutable std::mutex link_mutex_;  // held while a request is under way
  mutable std::mutex mutex_;
  // The pointer guarded by mutex_; what it points to, but for Cancel, by link_mutex_.
  std::shared_ptr<ServerLink> link_ = std::make_shared<ServerLink>();
  std::condition_variable changed_;
  std::optional<Person> person_;  // guarded by mutex_
  Uuid unused_;                   // taken by TakeTicket and not begun with; guarded by mutex_
  bool stop_ = false;             // guarded by mutex_
  std::thread keep_alive_;
};

}  // namespace enamel::station

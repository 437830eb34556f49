#pragma once

#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <functional>
#include <string>
#include <string_view>

#include "common/base/mutex.h"
#include "common/base/result.h"
#include "server/auth/device_tokens.h"
#include "server/auth/password.h"
#include "server/auth/refusal_trail.h"
#include "server/auth/sign_in_places.h"
#include "server/auth/throttle.h"
#include "server/storage/people/session_rows.h"
#include "server/storage/store.h"
#include "server/storage/store_pool.h"

namespace enamel::server::auth {

struct AuthOptions {
  UnixMs idle_ms = 30 * 60 * 1000;
  UnixMs absolute_ms = 12 * 60 * 60 * 1000;
  PasswordCost cost;
  size_t hash_threads = 2;  // 64 MiB each while hashing
  // Instead of threads of its own: those of all schools of a process, of hash_threads. Whoever
  // waits for one of them keeps the authenticator.
  std::shared_ptr<StorePool> hashing{};
  // Sign-ins of an address beyond these are refused with kUnavailable (SignInPlaces).
  size_t max_waiting = 64;
  std::function<UnixMs()> clock;  // empty: the system's, which may be set back and forth
  // Milliseconds of a clock that only goes forward, for slowing down. Empty: `clock` where that is
  // given, else the system's.
  std::function<int64_t()> elapsed;
  // How long after the password was given the session may do what asks for it again.
  UnixMs confirmed_ms = 5 * 60 * 1000;
  // How long a password that was made up here can be signed in with. Not a day: a roster is
  // imported some days before the first lesson, and a weekend lies between. Not longer: nobody
  // guesses it, but it lies about on paper.
  UnixMs one_time_ms = UnixMs{7} * 24 * 60 * 60 * 1000;
  // Compares a password with a verifier; empty: VerifyPassword. Tests count its calls.
  std::function<bool(std::string_view, const std::string&)> verify;
};

// Who a request is from.
struct Identity {
  Person person;
  Sha256 token_hash;
  std::string csrf;  // expected X-Enamel-Csrf
  Uuid session;
  UnixMs confirmed_until_ms = 0;  // until then the password need not be given again
};

struct SignedIn {
  Bytes token;  // 32 bytes; the page gets it as 64 hex digits in the cookie
  Identity identity;
  std::string device_tokens{};  // DeviceTokens, for the browser to keep; of the page
};

// How a session was begun (SessionRow::via).
inline constexpr char kViaPage[] = "page";
inline constexpr char kViaStation[] = "station";

struct SignInRequest {
  std::string login, password;  // for CheckPin, the PIN in place of the password
  std::string address;          // peer, for throttling
  std::string via;              // kViaPage or kViaStation
  std::string device{};         // SessionRow::device
  // The page's cookie that came with the request, 64 hex digits; its session ends when this one
  // begins: the browser forgets it.
  std::string earlier{};
  std::string log_id{};         // what the log calls the request (LogRequest)
  std::string device_tokens{};  // the browser's (DeviceTokens)
  std::string chair{};          // the id of the station, which is a place of its own
};

// Counts since the start. Wrong passwords count wherever the server asks for one.
struct DoorCounts {
  std::atomic<uint64_t> signed_in{0}, refused{0}, throttled{0}, busy{0}, signed_out{0};
};

// Sign-in, sessions, sign-out. Refusals are counted and go into RefusalTrail. Thread safety: any
// thread.
//
// A wrong password, an unknown login and a disabled person get the same answer (kUnauthenticated)
// after the same work: one argon2id at `cost`, whatever the stored verifier cost. Too many
// failures: kUnavailable, field "throttled" (HTTP 429). Too many sign-ins at once: kUnavailable.
//
// A generated password opens sessions that can do nothing but replace it, within
// AuthOptions::one_time_ms: whoever closes the page before choosing a password signs in again. The
// new password ends all of them. The right password given too late gets an explanation
// (kUnauthenticated, field "one_time_password"). At a station it opens nothing usable.
class Authenticator {
 public:
  explicit Authenticator(Store& store, AuthOptions options = {});
  ~Authenticator();

  // Runs on the hashing threads, after what Throttle holds it for; continues on the caller's
  // executor.
  boost::asio::awaitable<Result<SignedIn>> SignIn(SignInRequest request);
  // The same on this thread, outside the bound and not held: for the command line and tests.
  Result<SignedIn> SignInHere(const SignInRequest& request);

  // Whose PIN this is: checked, throttled and answered as a password, with the same counters, and
  // no session begins. Nobody has one who still has a one-time password. Ten wrong PINs in a row
  // lock a person's PIN, also over a restart, until SetPin: then a right one gets the same answer
  // as a wrong one. Errors: as of SignIn; kForbidden, field kPinLocked. That answer shows that this
  // login has a PIN: it takes ten wrong ones to get it, each of them audited.
  boost::asio::awaitable<Result<Person>> CheckPin(SignInRequest request);
  Result<Person> CheckPinHere(const SignInRequest& request);
  // Chooses one's own PIN, which signs exams at a chair, and unlocks it. The caller has asked for
  // the password (IsConfirmed). Hashed on the hashing threads. Errors: enamel::CheckPin's.
  boost::asio::awaitable<Status> SetPin(Identity identity, std::string pin, std::string address);

  // Gives the password of a session once more: it may then do for AuthOptions::confirmed_ms what
  // asks for that. Throttled and hashed as sign-in is. Errors: kForbidden, field "password" (it is
  // wrong); kUnavailable as of SignIn.
  boost::asio::awaitable<Status> Confirm(Identity identity, std::string password,
                                         std::string address);  // via the page
  // Another password of one's own. Ends all sessions of the person and begins a new one. Errors: as
  // of Confirm about the old one; kInvalidInput, field "new_password" (policy, or the old one
  // again).
  struct PasswordChange {
    std::string old_password, new_password;
    std::string address, via, device{}, device_tokens{};
  };
  boost::asio::awaitable<Result<SignedIn>> ChangePassword(Identity identity, PasswordChange change);
  // When the person's one-time password expires.
  UnixMs OneTimeUntil(const Person& person) const {
    return person.password_ms + options_.one_time_ms;
  }
  // Whether the password was given lately enough.
  bool IsConfirmed(const Identity& identity) const { return Now() < identity.confirmed_until_ms; }

  // The current holder of this token (32 bytes); renews the idle time. Blocks (store): call it
  // through a StorePool. Errors: kUnauthenticated.
  Result<Identity> Authenticate(ByteView token);
  // `cookie` is the token as 64 hex digits, of a session of the page: those of the station link are
  // good on their connection and nowhere else.
  Result<Identity> AuthenticateHex(std::string_view cookie);
  // The person of this session, as Authenticate, without renewing it: for work that continues by
  // itself.
  Result<Person> StillSignedIn(const Sha256& token_hash);
  Status SignOut(const Sha256& token_hash);
  // Of the page: with the address in the log and the audit trail (`session.end`).
  Status SignOutFrom(const Identity& identity, const std::string& address);

  const DoorCounts& counts() const { return counts_; }
  RefusalTrail& refusals() { return refusals_; }

  // Policy, then a verifier for PeopleRows::CreatePerson and SetPassword. Blocks.
  Result<std::string> NewVerifier(std::string_view password, std::string_view login,
                                  std::string_view name = {}) const;

 private:
  UnixMs Now() const;
  int64_t Elapsed() const;
  // Of the clock that failures are counted by.
  UnixMs CountedAt() const { return asking_ ? Now() : Elapsed(); }
  bool Verify(const std::string& password, const std::string& verifier) const;
  // Counts and notes why nobody came in.
  Status TurnAway(const char* why, std::string login, const std::string& address,
                  const std::string& via, Status status);
  enum class Secret : uint8_t { kPassword, kPin };
  Result<Person> PersonAdmitted(const std::string& login, const SignInRequest& request,
                                Secret secret);
  Result<SignedIn> SignInAdmitted(const std::string& login, const SignInRequest& request);
  Result<Person> PinAdmitted(const std::string& login, const SignInRequest& request);
  Status CheckOwnPassword(const Identity& identity, const std::string& password,
                          const std::string& address, const std::string& via);
  // Whether a one-time password has not expired yet.
  Status CheckOneTimePassword(const Person& person) const;
  // `via`, `address` and `device` of whoever begins it.
  Result<SignedIn> BeginSession(const Person& person, const std::string& via,
                                const std::string& address, const std::string& device);
  void EndEarlier(const SignInRequest& request);
  Status NoteSignedOut(const Uuid& person, const std::string& address);
  Result<SessionRow> OpenSession(const Sha256& token_hash);
  Result<Identity> IdentityOf(ByteView token, const SessionRow& session);
  Result<SignedIn> ChangePasswordHere(const Identity& identity, const PasswordChange& change);
  template <typename T>
  using AdmittedWork = Result<T> (Authenticator::*)(const std::string& login,
                                                    const SignInRequest& request);
  // The work of a try that may proceed, on the hashing threads; and on this one, not held.
  template <typename T>
  boost::asio::awaitable<Result<T>> OnceAdmitted(SignInRequest request, AdmittedWork<T> work);
  template <typename T>
  Result<T> AdmittedHere(const SignInRequest& request, AdmittedWork<T> work);
  Origin OriginOf(const std::string& login, const SignInRequest& request) const;
  // How this try may proceed; resumes once it may.
  boost::asio::awaitable<Result<Line>> Admitted(std::string login, Origin origin, std::string via);
  Status NotAdmitted(const std::string& login, const std::string& address, const std::string& via,
                     const Status& why);
  // Runs on the threads of a pool, when it is the turn of this login or place; of all pools a
  // bounded number wait.
  template <typename Work>
  auto InPlace(std::string login, Origin origin, Line line, std::string via, StorePool& pool,
               Work work) -> boost::asio::awaitable<decltype(work())>;
  Store& store_;
  const AuthOptions options_;
  const std::string decoy_verifier_;  // verified against when there is no such login
  const DeviceTokens devices_;
  Throttle throttle_;
  SignInPlaces places_;
  DoorCounts counts_;
  RefusalTrail refusals_;
  // Asks the store what other servers have counted; none: this one counts alone, in memory.
  std::optional<StorePool> asking_;
  const std::shared_ptr<StorePool> hashing_;  // last: its threads use the others
};

}  // namespace enamel::server::auth

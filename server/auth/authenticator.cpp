#include "server/auth/authenticator.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cctype>
#include <chrono>
#include <cstdlib>

#include "common/base/hex.h"
#include "common/base/log_request.h"
#include "common/base/pin.h"
#include "common/base/unix_time.h"
#include "server/auth/address_block.h"
#include "server/auth/token.h"
#include "server/ops/yield_to_others.h"
#include "server/storage/store_engine.h"

namespace enamel::server::auth {
namespace {

// The store renews the idle time at most this often: requests of a page come in bursts.
constexpr UnixMs kTouchEveryMs = 60'000;
// A clock that is set back by more than this ends the sessions made before: they would last longer
// than they may, by as much.
constexpr UnixMs kClockSlackMs = 60 * 60 * 1000;

constexpr size_t kTokenBytes = 32;
constexpr UnixMs kDayMs = 24 * 60 * 60 * 1000;
constexpr char kOneTimePassword[] = "one_time_password";

// One answer for all of it: who guesses does not learn which logins there are.
Status Refused() {
  return Status(Code::kUnauthenticated, "login or password is wrong, or the account is disabled");
}

Status RefusedPin() {
  return Status(Code::kUnauthenticated,
                "login or PIN is wrong, or this person has chosen no PIN: instructors choose one "
                "on the page, under their name");
}

// A right PIN and a wrong one get the same answer.
Status LockedPin() {
  return Status(Code::kForbidden,
                "this PIN is locked after " + std::to_string(PeopleRows::kMaxWrongPins) +
                    " wrong ones: set a new PIN on the page, under your name, where you confirm it "
                    "with your password",
                kPinLocked);
}

Status Ended() {
  return Status(Code::kUnauthenticated, "not signed in, or the session has ended; sign in again");
}

std::string LowerLogin(std::string login) {
  std::transform(login.begin(), login.end(), login.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return login;
}

// A verifier that no password fits, to be checked where there is none to check: the answer then
// takes as long.
std::string Decoy(const PasswordCost& cost) {
  auto verifier = HashPassword(ToHex(NewToken()), cost);
  ENAMEL_CHECK(verifier.ok());
  return *verifier;
}

std::unique_ptr<FailureCounters> CountersOf(Store& store) {
  if (store.shared) return std::make_unique<SharedCounters>(store);
  return std::make_unique<MemoryCounters>();
}

// Where SignInPlaces counts a try.
std::string PlaceOf(const Origin& origin) {
  return origin.party.empty() ? AddressSite(origin.address) : "=" + origin.party;
}

// Whoever has the session signed in with it: guesses from elsewhere do not delay it.
Origin OriginOf(const Identity& identity, const std::string& address) {
  return {address, "session " + identity.session.Text(), true};
}

// Gives a place back once the work is done, also where that threw.
class Leaving {
 public:
  Leaving(SignInPlaces& places, const Turn& turn) : places_(places), turn_(turn) {}
  ~Leaving() { places_.Leave(turn_); }
  Leaving(const Leaving&) = delete;
  Leaving& operator=(const Leaving&) = delete;

 private:
  SignInPlaces& places_;
  const Turn& turn_;
};

}  // namespace

Authenticator::Authenticator(Store& store, AuthOptions options)
    : store_(store),
      options_(std::move(options)),
      decoy_verifier_(Decoy(options_.cost)),
      devices_(
          DataKey(ByteView(store.engine->ticket_key).first(DataKey::kBytes)).Derive("ENdevice", 1)),
      throttle_(CountersOf(store)),
      places_(options_.max_waiting),
      refusals_(store, [this] { return Elapsed(); }),
      hashing_(options_.hashing ? options_.hashing
                                : std::make_shared<StorePool>(options_.hash_threads)) {
  if (store.shared) asking_.emplace(size_t{2});
}

Authenticator::~Authenticator() = default;

UnixMs Authenticator::Now() const {
  if (options_.clock) return options_.clock();
  return enamel::UnixMs();
}

int64_t Authenticator::Elapsed() const {
  if (options_.elapsed) return options_.elapsed();
  if (options_.clock) return options_.clock();
  return std::chrono::duration_cast<std::chrono::milliseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

bool Authenticator::Verify(const std::string& password, const std::string& verifier) const {
  auto same = [&](const std::string& against) {
    return options_.verify ? options_.verify(password, against) : VerifyPassword(password, against);
  };
  bool matches = same(verifier);
  // The work of one argon2id at the usual cost, whatever this one cost.
  if (!CostsAsMuch(verifier, options_.cost)) (void)same(decoy_verifier_);
  return matches;
}

Status Authenticator::TurnAway(const char* why, std::string login, const std::string& address,
                               const std::string& via, Status status) {
  const std::string_view reason = why;
  ++(reason == "throttled" ? counts_.throttled : reason == "busy" ? counts_.busy : counts_.refused);
  refusals_.Note({why, address, via, std::move(login), {}, {}});
  return status;
}

Status Authenticator::NotAdmitted(const std::string& login, const std::string& address,
                                  const std::string& via, const Status& why) {
  // The store failed, or its threads are busy, which was noted: that is no refusal of this person.
  if (why.retry_after_s() == 0) return why;
  return TurnAway("throttled", login, address, via, why);
}

template <typename Work>
auto Authenticator::InPlace(std::string login, Origin origin, Line line, std::string via,
                            StorePool& pool, Work work)
    -> boost::asio::awaitable<decltype(work())> {
  const std::optional<Turn> turn =
      places_.Take(login, PlaceOf(origin), line, !origin.party.empty());
  if (!turn) {
    co_return TurnAway(
        "busy", std::move(login), origin.address, via,
        Status(Code::kUnavailable, "too many sign-ins at once; try again in a few seconds"));
  }
  auto result = co_await pool.Run(*turn, [&] {
    const Leaving leaving(places_, *turn);
    // Many sign-ins delay other sign-ins and no requests.
    if (&pool == hashing_.get()) {
      static thread_local const bool yields = (ops::YieldToOthers(), true);
      (void)yields;
    }
    return work();
  });
  co_return result;
}

Origin Authenticator::OriginOf(const std::string& login, const SignInRequest& request) const {
  if (!request.chair.empty()) return {request.address, "chair " + request.chair};
  const std::string device = devices_.NameFor(login, request.device_tokens, Now());
  if (device.empty()) return {request.address};
  return {request.address, "device " + device, true};
}

boost::asio::awaitable<Result<Line>> Authenticator::Admitted(std::string login, Origin origin,
                                                             std::string via) {
  Result<Admission> admission = Admission{};
  if (asking_) {
    const Line line = origin.known ? Line::kFirst : Line::kUsual;
    admission = co_await InPlace(login, origin, line, via, *asking_,
                                 [&] { return throttle_.Admit(login, origin, CountedAt()); });
  } else {
    admission = throttle_.Admit(login, origin, CountedAt());
  }
  if (!admission.ok()) co_return NotAdmitted(login, origin.address, via, admission.status());
  // Held on a timer: no thread waits, and the connection gets its answer when its turn comes.
  if (admission->hold_ms > 0) {
    boost::asio::steady_timer turn(co_await boost::asio::this_coro::executor,
                                   std::chrono::milliseconds(admission->hold_ms));
    boost::system::error_code ignored;
    co_await turn.async_wait(boost::asio::redirect_error(boost::asio::use_awaitable, ignored));
  }
  co_return admission->line;
}

template <typename T>
boost::asio::awaitable<Result<T>> Authenticator::OnceAdmitted(SignInRequest request,
                                                              AdmittedWork<T> work) {
  const std::string login = LowerLogin(request.login);
  const Origin origin = OriginOf(login, request);
  const Result<Line> line = co_await Admitted(login, origin, request.via);
  if (!line.ok()) co_return line.status();
  co_return co_await InPlace(login, origin, *line, request.via, *hashing_, [&] {
    const LogRequest logged(request.log_id);
    return (this->*work)(login, request);
  });
}

template <typename T>
Result<T> Authenticator::AdmittedHere(const SignInRequest& request, AdmittedWork<T> work) {
  const std::string login = LowerLogin(request.login);
  const Status admitted = throttle_.Admit(login, OriginOf(login, request), CountedAt()).status();
  if (!admitted.ok()) return NotAdmitted(login, request.address, request.via, admitted);
  return (this->*work)(login, request);
}

boost::asio::awaitable<Result<SignedIn>> Authenticator::SignIn(SignInRequest request) {
  return OnceAdmitted(std::move(request), &Authenticator::SignInAdmitted);
}

Result<SignedIn> Authenticator::SignInHere(const SignInRequest& request) {
  return AdmittedHere(request, &Authenticator::SignInAdmitted);
}

Result<Person> Authenticator::PersonAdmitted(const std::string& login, const SignInRequest& request,
                                             Secret secret) {
  const bool by_pin = secret == Secret::kPin;
  const char* const wrong = by_pin ? "pin" : "password";
  const Status refused = by_pin ? RefusedPin() : Refused();
  const Origin origin = OriginOf(login, request);
  // Nobody has such a one, so that the quick answer tells nothing.
  if (request.password.size() > kMaxPasswordLength || login.size() > 256) {
    ENAMEL_RETURN_IF_ERROR(throttle_.Failed(login, origin, CountedAt()));
    return TurnAway(wrong, login, request.address, request.via, refused);
  }
  auto person = store_.people.PersonByLogin(login);
  if (!person.ok() && person.status().code() != Code::kNotFound) return person.status();
  std::string verifier = decoy_verifier_;
  PeopleRows::PinTry pin;
  if (person.ok()) {
    if (by_pin) {
      ENAMEL_ASSIGN_OR_RETURN(pin, store_.people.TryPin(person->id));
      if (!pin.locked && !pin.verifier.empty()) verifier = pin.verifier;
    } else {
      ENAMEL_ASSIGN_OR_RETURN(verifier, store_.people.PasswordVerifier(person->id));
    }
  }
  // The same work whether or not the person exists.
  bool matches = Verify(request.password, verifier);
  const bool barred = person.ok() && (person->disabled || (by_pin && person->must_change_password));
  if (!matches || !person.ok() || barred) {
    ENAMEL_RETURN_IF_ERROR(throttle_.Failed(login, origin, CountedAt()));
    if (pin.last) {
      const std::string chair = request.device.empty() ? "" : " " + request.device;
      ENAMEL_RETURN_IF_ERROR(
          store_.people.NotePinLocked(person->id, Actor{Uuid{}, request.via + chair}));
    }
    if (pin.locked || pin.last) {
      return TurnAway(kPinLocked, login, request.address, request.via, LockedPin());
    }
    const bool disabled = matches && person.ok();
    return TurnAway(disabled ? "disabled" : wrong, login, request.address, request.via, refused);
  }
  if (by_pin) {
    ENAMEL_RETURN_IF_ERROR(store_.people.PinWasRight(person->id));
  }
  ENAMEL_RETURN_IF_ERROR(throttle_.Succeeded(login, origin, CountedAt()));
  return person;
}

Result<SignedIn> Authenticator::SignInAdmitted(const std::string& login,
                                               const SignInRequest& request) {
  ENAMEL_ASSIGN_OR_RETURN(const auto person, PersonAdmitted(login, request, Secret::kPassword));
  if (Status late = CheckOneTimePassword(person); !late.ok()) {
    return TurnAway("one-time", login, request.address, request.via, late);
  }
  auto signed_in = BeginSession(person, request.via, request.address, request.device);
  ENAMEL_RETURN_IF_ERROR(signed_in.status());
  ++counts_.signed_in;
  // A browser that shows its tokens needs no place: neither its address nor this server's memory.
  places_.Know(login,
               PlaceOf(OriginOf(login, {.address = request.address, .chair = request.chair})));
  if (request.via == kViaPage) {
    signed_in->device_tokens = devices_.With(login, request.device_tokens, Now());
  }
  EndEarlier(request);
  return signed_in;
}

Result<Person> Authenticator::PinAdmitted(const std::string& login, const SignInRequest& request) {
  return PersonAdmitted(login, request, Secret::kPin);
}

boost::asio::awaitable<Result<Person>> Authenticator::CheckPin(SignInRequest request) {
  return OnceAdmitted(std::move(request), &Authenticator::PinAdmitted);
}

Result<Person> Authenticator::CheckPinHere(const SignInRequest& request) {
  return AdmittedHere(request, &Authenticator::PinAdmitted);
}

boost::asio::awaitable<Status> Authenticator::SetPin(Identity identity, std::string pin,
                                                     std::string address) {
  if (Status fit = enamel::CheckPin(pin); !fit.ok()) co_return fit;
  const Person& person = identity.person;
  const Origin origin = auth::OriginOf(identity, address);
  co_return co_await InPlace(
      person.login, origin, Line::kFirst, kViaPage, *hashing_, [&]() -> Status {
        ENAMEL_ASSIGN_OR_RETURN(auto verifier, HashPassword(pin, options_.cost));
        return store_.people.SetPin(person.id, verifier, Actor{person.id, kViaPage});
      });
}

Status Authenticator::CheckOneTimePassword(const Person& person) const {
  if (!person.must_change_password || Now() < OneTimeUntil(person)) return Status::Ok();
  return Status(Code::kUnauthenticated,
                "this one-time password was valid for " +
                    std::to_string(options_.one_time_ms / kDayMs) +
                    " days; ask an administrator for another",
                kOneTimePassword);
}

// Whichever person's it was: the browser has no way back to it.
void Authenticator::EndEarlier(const SignInRequest& request) {
  auto token = FromHex(request.earlier);
  if (!token.ok() || token->size() != kTokenBytes) return;
  const Sha256 hash = TokenHash(*token);
  auto earlier = store_.sessions.FindSession(hash);
  if (!earlier.ok() || earlier->via != kViaPage) return;
  Status ended = store_.sessions.EndSession(hash);
  if (ended.ok()) ended = NoteSignedOut(earlier->person, request.address);
  if (!ended.ok()) spdlog::warn("page: an earlier session did not end: {}", ended.message());
}

Result<SignedIn> Authenticator::BeginSession(const Person& person, const std::string& via,
                                             const std::string& address,
                                             const std::string& device) {
  SignedIn out;
  out.token = NewToken();
  UnixMs now = Now();
  SessionRow row{TokenHash(out.token),       person.id, now,         now,
                 now + options_.absolute_ms, via,       Uuid::New(), now,
                 AddressText(address),       device};
  out.identity =
      Identity{person, row.token_hash, CsrfFor(out.token), row.id, now + options_.confirmed_ms};
  ENAMEL_RETURN_IF_ERROR(store_.sessions.CreateSession(row));
  return out;
}

Status Authenticator::CheckOwnPassword(const Identity& identity, const std::string& password,
                                       const std::string& address, const std::string& via) {
  const Person& person = identity.person;
  const Origin origin = auth::OriginOf(identity, address);
  ENAMEL_ASSIGN_OR_RETURN(auto verifier, store_.people.PasswordVerifier(person.id));
  if (password.size() <= kMaxPasswordLength && Verify(password, verifier)) {
    return throttle_.Succeeded(person.login, origin, CountedAt());
  }
  ENAMEL_RETURN_IF_ERROR(throttle_.Failed(person.login, origin, CountedAt()));
  return TurnAway("password", person.login, address, via,
                  Status(Code::kForbidden, "that is not your password; try again", "password"));
}

boost::asio::awaitable<Status> Authenticator::Confirm(Identity identity, std::string password,
                                                      std::string address) {
  const std::string& login = identity.person.login;
  const Origin origin = auth::OriginOf(identity, address);
  const Result<Line> line = co_await Admitted(login, origin, kViaPage);
  if (!line.ok()) co_return line.status();
  co_return co_await InPlace(login, origin, *line, kViaPage, *hashing_, [&]() -> Status {
    ENAMEL_RETURN_IF_ERROR(CheckOwnPassword(identity, password, address, kViaPage));
    return store_.sessions.ConfirmSession(identity.token_hash, Now());
  });
}

Result<SignedIn> Authenticator::ChangePasswordHere(const Identity& identity,
                                                   const PasswordChange& change) {
  const Person& person = identity.person;
  ENAMEL_RETURN_IF_ERROR(
      CheckOwnPassword(identity, change.old_password, change.address, change.via));
  // After checking the old password, so that this reveals nothing to somebody who does not know it.
  if (change.new_password == change.old_password) {
    return Status(Code::kInvalidInput, "that is already your password; choose another",
                  kNewPassword);
  }
  auto verifier = NewVerifier(change.new_password, person.login, person.display_name);
  if (!verifier.ok()) {
    const Status& why = verifier.status();
    return Status(why.code(), why.message(), why.field().empty() ? "" : kNewPassword);
  }
  ENAMEL_RETURN_IF_ERROR(
      store_.people.SetPassword(person.id, *verifier, false, Actor{person.id, change.via}));
  ENAMEL_ASSIGN_OR_RETURN(auto changed, store_.people.PersonById(person.id));
  auto signed_in = BeginSession(changed, change.via, change.address, change.device);
  if (signed_in.ok() && change.via == kViaPage) {
    signed_in->device_tokens = devices_.With(person.login, change.device_tokens, Now());
  }
  return signed_in;
}

boost::asio::awaitable<Result<SignedIn>> Authenticator::ChangePassword(Identity identity,
                                                                       PasswordChange change) {
  const std::string& login = identity.person.login;
  const Origin origin = auth::OriginOf(identity, change.address);
  const Result<Line> line = co_await Admitted(login, origin, change.via);
  if (!line.ok()) co_return line.status();
  co_return co_await InPlace(login, origin, *line, change.via, *hashing_,
                             [&] { return ChangePasswordHere(identity, change); });
}

Result<SessionRow> Authenticator::OpenSession(const Sha256& token_hash) {
  auto session = store_.sessions.FindSession(token_hash);
  if (!session.ok()) {
    return session.status().code() == Code::kNotFound ? Ended() : session.status();
  }
  UnixMs now = Now();
  bool set_back = now < session->created_ms - kClockSlackMs;
  if (now >= session->expires_ms || set_back || now - session->last_used_ms > options_.idle_ms) {
    ENAMEL_RETURN_IF_ERROR(store_.sessions.EndSession(token_hash));
    return Ended();
  }
  return session;
}

Result<Identity> Authenticator::Authenticate(ByteView token) {
  if (token.size() != 32) return Ended();
  ENAMEL_ASSIGN_OR_RETURN(auto session, OpenSession(TokenHash(token)));
  return IdentityOf(token, session);
}

Result<Identity> Authenticator::IdentityOf(ByteView token, const SessionRow& session) {
  ENAMEL_ASSIGN_OR_RETURN(auto person, store_.people.PersonById(session.person));
  if (person.disabled) return Ended();
  // Either way: with a clock set back, the idle time counts from now.
  UnixMs now = Now();
  Sha256 hash = TokenHash(token);
  if (std::abs(now - session.last_used_ms) >= std::min(kTouchEveryMs, options_.idle_ms / 4)) {
    ENAMEL_RETURN_IF_ERROR(store_.sessions.TouchSession(hash, now));
  }
  return Identity{person, hash, CsrfFor(token), session.id,
                  session.confirmed_ms + options_.confirmed_ms};
}

Result<Person> Authenticator::StillSignedIn(const Sha256& token_hash) {
  ENAMEL_ASSIGN_OR_RETURN(auto session, OpenSession(token_hash));
  auto person = store_.people.PersonById(session.person);
  if (person.ok() && person->disabled) return Ended();
  return person;
}

Result<Identity> Authenticator::AuthenticateHex(std::string_view cookie) {
  if (cookie.size() != 64) return Ended();
  auto token = FromHex(cookie);
  if (!token.ok()) return Ended();
  ENAMEL_ASSIGN_OR_RETURN(auto session, OpenSession(TokenHash(*token)));
  // A station's session is bound to its connection; as a cookie it is worth nothing.
  if (session.via != kViaPage) return Ended();
  return IdentityOf(*token, session);
}

Status Authenticator::SignOut(const Sha256& token_hash) {
  return store_.sessions.EndSession(token_hash);
}

Status Authenticator::SignOutFrom(const Identity& identity, const std::string& address) {
  ENAMEL_RETURN_IF_ERROR(SignOut(identity.token_hash));
  return NoteSignedOut(identity.person.id, address);
}

Status Authenticator::NoteSignedOut(const Uuid& id, const std::string& address) {
  ++counts_.signed_out;
  const std::string person = id.Text(), from = AddressText(address);
  spdlog::info("page: {} at {} signed out", person, from);
  return store_.audit.NoteAudit({id, kViaPage}, "session.end", person,
                                R"({"address":")" + from + R"("})");
}

Result<std::string> Authenticator::NewVerifier(std::string_view password, std::string_view login,
                                               std::string_view name) const {
  ENAMEL_RETURN_IF_ERROR(CheckPasswordPolicy(password, login, name));
  return HashPassword(password, options_.cost);
}

}  // namespace enamel::server::auth

#include "server/http/api.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <exception>
#include <utility>

#include "common/base/log_request.h"
#include "common/base/utf8.h"
#include "server/auth/token.h"
#include "server/http/error_response.h"
#include "server/http/site.h"

namespace enamel::server::http {

namespace asio = boost::asio;

namespace {

bool IsSafe(Method method) { return method == Method::kGet || method == Method::kHead; }

Response NoSuchRoute(const Request& request, const RouteMatch& match) {
  if (match.allowed_methods.empty()) {
    return ErrorResponse({Code::kNotFound,
                          "expected a path of the API (schemas/api/openapi.yaml), "
                          "found " +
                              request.path});
  }
  Response response = ErrorResponse(405, "method_not_allowed",
                                    "expected " + match.allowed_methods + " for this path");
  response.headers.emplace_back("Allow", match.allowed_methods);
  return response;
}

Status CheckRole(Need need, const Person& person) {
  bool allowed = need == Need::kPerson || person.role == Role::kAdmin ||
                 (need == Need::kInstructor && person.role == Role::kInstructor);
  if (allowed) return {};
  return {Code::kForbidden, std::string("only ") +
                                (need == Need::kAdmin ? "admins" : "instructors and admins") +
                                " can do this; your role is " + RoleName(person.role)};
}

Status CheckCsrf(const Request& request, const auth::Identity& caller) {
  // A read changes nothing, and another site's page cannot see its answer: no session cookie goes
  // along from there (SameSite=Strict), and no header here lets it read.
  if (IsSafe(request.method)) return {};
  // In constant time: how long a comparison takes would otherwise tell how much of a guess is
  // right.
  if (auth::SameSecret(request.Header("x-enamel-csrf"), caller.csrf)) return {};
  return {Code::kForbidden,
          "expected the session's csrf value in the header X-Enamel-Csrf; get it from "
          "GET /api/v1/session",
          "x-enamel-csrf"};
}

// A one-time password only lets its owner change it (and sign out).
Status CheckPasswordIsOwn(const Route& route, const Person& person) {
  bool own_session = route.pattern == "/api/v1/session" ||  // and not /api/v1/sessions
                     route.pattern.starts_with("/api/v1/session/");
  if (!person.must_change_password || own_session) return {};
  return {Code::kForbidden,
          "this password is only good for choosing your own; do that first (POST "
          "/api/v1/session/password)",
          std::string(kChangePassword)};
}

Status CheckAllowed(const Request& request, const Route& route, const auth::Identity& caller) {
  ENAMEL_RETURN_IF_ERROR(CheckRole(route.need, caller.person));
  ENAMEL_RETURN_IF_ERROR(CheckCsrf(request, caller));
  return CheckPasswordIsOwn(route, caller.person);
}

// The attempt that a path names, for the log; zero: none.
Uuid AttemptOf(const Request& request) {
  constexpr std::string_view kBefore = "/api/v1/attempts/";
  constexpr size_t kIdBytes = 36;
  if (!request.path.starts_with(kBefore)) return {};
  const auto id = Uuid::Parse(std::string_view(request.path).substr(kBefore.size(), kIdBytes));
  return id.ok() ? *id : Uuid{};
}

bool IsName(std::string_view text) {
  return text.size() <= 64 && std::ranges::all_of(text, [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
         });
}

// The text at the place of the pattern's `{id}` or `{name}`.
Status FillPlace(const RouteMatch& match, Call& call) {
  if (match.id.empty()) return {};
  if (match.route->pattern.find("{name}") != std::string_view::npos) {
    call.name = match.id;
    if (IsName(match.id)) return {};
    return {Code::kInvalidInput, "expected 1 to 64 of a-z 0-9 _ - in the path", "name"};
  }
  Result<Uuid> id = Uuid::Parse(match.id);
  if (!id.ok()) return {Code::kInvalidInput, "expected a UUID in the path", "id"};
  call.id = *id;
  return {};
}

Response NotInTime(const Request& request) {
  std::string what =
      IsSafe(request.method) ? "" : "; it may still happen: check before you try again";
  return ErrorResponse({Code::kUnavailable, "the server was too busy to do this in time" + what});
}

// Counts a request in for as long as it lives.
class InFlight {
 public:
  InFlight(std::atomic<size_t>& count, size_t limit) : count_(count), granted_(++count_ <= limit) {}
  ~InFlight() { --count_; }
  InFlight(const InFlight&) = delete;
  InFlight& operator=(const InFlight&) = delete;
  bool granted() const { return granted_; }

 private:
  std::atomic<size_t>& count_;
  const bool granted_;
};

}  // namespace

Api::Api(Store& store, auth::Authenticator& authenticator, Monitoring monitoring, size_t threads,
         size_t max_in_flight, std::chrono::milliseconds work, const ops::Budgets& budgets)
    : store_(store),
      authenticator_(authenticator),
      monitoring_(std::move(monitoring)),
      max_in_flight_(max_in_flight),
      work_(work),
      budgets_(budgets),
      places_(max_in_flight, budgets),
      unsent_(ops::LimitOf(ops::kAnswers, budgets)),
      pool_(std::in_place, threads, (threads + 1) / 2),
      changes_(std::in_place, threads, (threads + 1) / 2),
      teeth_(std::in_place, store),
      backups_(std::in_place, store),
      trials_(std::in_place, store.blobs) {}

bool Api::Owns(std::string_view path) {
  return path == "/livez" || path == "/readyz" || path == "/healthz" || path == "/metrics" ||
         path == "/api" || path.starts_with("/api/");
}

void Api::AddFigures(ops::MetricsText& text) const {
  constexpr std::string_view kKinds[] = {"1xx", "2xx", "3xx", "4xx", "5xx"};
  for (size_t i = 1; i <= std::size(kKinds); ++i) {
    text.Counter("enamel_http_answers_total", "API answers by kind of status.",
                 static_cast<double>(answers_[i].load()), {{"status", kKinds[i - 1]}});
  }
  const auth::DoorCounts& door = authenticator_.counts();
  const std::pair<std::string_view, const std::atomic<uint64_t>*> kOutcomes[] = {
      {"signed_in", &door.signed_in},
      {"refused", &door.refused},
      {"throttled", &door.throttled},
      {"busy", &door.busy}};
  for (const auto& [outcome, count] : kOutcomes) {
    text.Counter("enamel_sign_ins_total",
                 "Sign-ins at page and stations, and passwords asked for again, by outcome.",
                 static_cast<double>(count->load()), {{"outcome", outcome}});
  }
  text.Counter("enamel_sign_outs_total", "Sign-outs at the page.",
               static_cast<double>(door.signed_out.load()));
  text.Counter("enamel_http_forbidden_total", "API requests without the right to them.",
               static_cast<double>(forbidden_.load()));
  text.Durations("enamel_http_read_seconds", "API reads, from the whole request to the answer.",
                 reads_.counts());
  ops::AddBudgets(text, Budgets());
}

std::vector<ops::BudgetUse> Api::Budgets() const {
  std::vector<ops::BudgetUse> out;
  if (monitoring_.budgets) out = monitoring_.budgets();
  out.push_back(places_.Uses());
  if (live_ != nullptr) {
    for (const ops::BudgetUse& use : live_->Uses()) out.push_back(use);
  }
  const HeldBytes::Use answers = unsent_.Most();
  const bool person = Uuid::Parse(answers.of).ok();
  ops::BudgetUse& use = out.emplace_back();
  use.kind = &ops::kAnswers;
  use.limit = ops::LimitOf(ops::kAnswers, budgets_);
  use.most = answers.bytes;
  if (!answers.of.empty()) use.party = person ? ops::PartyKind::kPerson : ops::PartyKind::kAddress;
  use.of = answers.of;
  use.refused = unsent_.refused();
  return out;
}

void Api::EndWork() {
  // A pool's destructor waits for its running work. Nobody posts any more: the connections have
  // ended.
  pool_.reset();
  changes_.reset();
  apart_.reset();
  teeth_.reset();
  backups_.reset();
  trials_.reset();
}

asio::awaitable<Response> Api::Handle(Request request) {
  auto begin = std::chrono::steady_clock::now();
  request.answer_by = begin + work_;
  const bool read = IsSafe(request.method);
  const std::string id = request.id;
  const Uuid attempt = AttemptOf(request);
  const std::string what = MethodName(request.method) + (" " + Printable(request.path));
  Response response = co_await AnswerInTime(std::move(request));
  auto kind = static_cast<size_t>(response.status / 100);
  if (kind < answers_.size()) ++answers_[kind];
  const auto took = std::chrono::steady_clock::now() - begin;
  if (read) reads_.Add(took);
  const LogRequest logged(id);
  const LogAttempt of(attempt);
  spdlog::debug("http: {}: {} after {:.1f} ms", what, response.status,
                std::chrono::duration<double, std::milli>(took).count());
  co_return response;
}

// A request and its answer, shared by the worker and the waiting connection. On the connection's
// strand.
struct Api::Work {
  Work(const asio::any_io_executor& executor, Request r)
      : request(std::move(r)), deadline(executor, request.answer_by) {}

  const Request request;
  asio::steady_timer deadline;  // cancelled when it is done
  Response response;
  std::exception_ptr failure;
  bool done = false;
};

// Two coroutines: work in a store's thread cannot be taken back, so who waits must be able to leave
// without it. Both run on the executor of the connection, never at once.
asio::awaitable<Response> Api::AnswerInTime(Request request) {
  auto executor = co_await asio::this_coro::executor;
  // Shared by both coroutines: the one that answers first may go while the other still uses it.
  auto work = std::make_shared<Work>(executor, std::move(request));
  asio::co_spawn(executor, Do(work), [self = shared_from_this(), work](std::exception_ptr failure) {
    work->failure = std::move(failure);
    work->done = true;
    work->deadline.cancel();
  });
  // What needs no thread is done already, and has cancelled a timer that was not waited for.
  if (!work->done) co_await work->deadline.async_wait(asio::as_tuple(asio::use_awaitable));
  if (work->failure) std::rethrow_exception(work->failure);
  if (work->done) co_return std::move(work->response);
  const LogRequest logged(work->request.id);
  const LogAttempt of(AttemptOf(work->request));
  spdlog::warn("http: {} {} had no answer within {} ms", MethodName(work->request.method),
               Printable(work->request.path), work_.count());
  co_return NotInTime(work->request);
}

asio::awaitable<void> Api::Do(std::shared_ptr<Work> work) {
  try {
    work->response = co_await Answer(work->request);
  } catch (const std::exception& error) {
    // The libraries throw, for example where a large answer finds no memory.
    const LogRequest logged(work->request.id);
    const LogAttempt of(AttemptOf(work->request));
    work->response = ErrorResponse(Status{Code::kInternal, error.what(), work->request.path});
  }
  work->response.school_ended = work->request.school_ended;
}

asio::awaitable<Response> Api::Answer(const Request& request) {
  // The route before the caller: that an address does not exist is no secret.
  RouteMatch match = FindRoute(request.method, request.path);
  if (!match.route) co_return NoSuchRoute(request, match);
  Call call{request,  authenticator_,       nullptr,       {},       {},           &monitoring_,
            live_,    station_fingerprint_, station_port_, &*apart_, first_admin_, stations_,
            &*teeth_, &*backups_,           &*trials_,     &cuts_,   draining_,    &bodies_,
            this};
  if (Status place = FillPlace(match, call); !place.ok()) co_return ErrorResponse(place);
  const Route& route = *match.route;
  if (!IsSafe(request.method)) {
    if (Status same = CheckSameSite(request); !same.ok()) {
      Response refused = ErrorResponse(same);
      const LogRequest logged(request.id);
      NoteForbidden(call, route, refused);
      co_return refused;
    }
  }
  auto* async = std::get_if<AsyncHandler>(&route.handler);
  // Sign-in is bounded by its hashing.
  if (async && route.need == Need::kNobody) co_return Answered(co_await (*async)(call, store_));
  RequestPlaces::Place own = places_.Take(request);
  if (own.held == nullptr) {
    const std::string why =
        "too many of your requests are under way at once; try again in a few seconds";
    co_return ErrorResponse(Uuid::Parse(own.of).ok()
                                ? ops::OverBudget(ops::kPersonRequests, budgets_, why)
                                : Status(Code::kUnavailable, why));
  }
  // Lives as long as the work, also when the caller has been answered in its stead: the bound is on
  // what runs.
  InFlight place(in_flight_, max_in_flight_);
  if (!place.granted()) {
    co_return ErrorResponse({Code::kUnavailable, "the server is busy; try again in a few seconds"});
  }
  Response response;
  if (async) {
    response = co_await Asynchronous(call, route, own.of);
  } else {
    StorePool& pool = IsSafe(request.method) ? *pool_ : *changes_;
    response = co_await pool.Run(Turn(own.of), [&] { return Blocking(call, route); });
  }
  if (response.BodyBytes() < RequestPlaces::kLargeBytes) co_return response;
  const void* where = response.Body().data();
  size_t bytes = response.Body().size();
  if (response.shared_body) {
    where = response.shared_body->data();
    bytes = response.shared_body->size();
  } else if (response.pieces) {
    where = own.held.get();  // nobody else's
    bytes = response.pieces->held;
  }
  response.held = unsent_.Add(own.of, where, bytes);
  if (response.held == nullptr) {
    co_return ErrorResponse(ops::OverBudget(
        ops::kAnswers, budgets_,
        "too much of what you asked for has not been read yet; try again in a few seconds"));
  }
  response.place = std::move(own.held);
  co_return response;
}

asio::awaitable<Response> Api::Asynchronous(Call& call, const Route& route, std::string of) {
  AsyncHandler handler = std::get<AsyncHandler>(route.handler);
  // The session is in the database, hence a store's thread looks it up; the handler then does its
  // own waiting.
  Result<auth::Identity> caller = co_await pool_->Run(Turn(std::move(of)), [&] {
    const LogRequest logged(call.request.id);
    return Identify(call.request);
  });
  if (!caller.ok()) co_return ErrorResponse(caller.status());
  call.caller = &*caller;
  Status allowed = CheckAllowed(call.request, route, *caller);
  // Not in one expression: g++ 12 destroys the result of a co_await in ?: twice.
  if (allowed.ok()) co_return Answered(co_await handler(call, store_));
  Response refused = ErrorResponse(allowed);
  // The check of a wrong password has already noted it.
  const LogRequest logged(call.request.id);
  NoteForbidden(call, route, refused);
  co_return refused;
}

// Answers that our page expects on the way (confirm_password, change_password) are no refusals.
void Api::NoteForbidden(const Call& call, const Route& route, const Response& response) {
  if (response.refusal != CodeName(Code::kForbidden)) return;
  ++forbidden_;
  const Uuid person = call.caller != nullptr ? call.caller->person.id : Uuid{};
  authenticator_.refusals().Note({"forbidden", call.request.peer, auth::kViaPage, "", person,
                                  MethodName(route.method) + (" " + std::string(route.pattern))});
}

Response Api::Blocking(Call& call, const Route& route) {
  const LogRequest logged(call.request.id);
  const LogAttempt of(AttemptOf(call.request));
  // The caller already got 503 ("not done") and may have sent the request again.
  if (std::chrono::steady_clock::now() >= call.request.answer_by) return NotInTime(call.request);
  auto handler = std::get<BlockingHandler>(route.handler);
  if (route.need == Need::kNobody) return Answered(handler(call, store_));
  Result<auth::Identity> caller = Identify(call.request);
  if (!caller.ok()) return ErrorResponse(caller.status());
  call.caller = &*caller;
  Status allowed = CheckAllowed(call.request, route, *caller);
  Response response = allowed.ok() ? Answered(handler(call, store_)) : ErrorResponse(allowed);
  NoteForbidden(call, route, response);
  return response;
}

Result<auth::Identity> Api::Identify(const Request& request) {
  std::optional<std::string> cookie = SessionCookie(request);
  if (!cookie) return Status{Code::kUnauthenticated, "sign in first"};
  Result<auth::Identity> caller = authenticator_.AuthenticateHex(*cookie);
  if (caller.ok()) places_.Know(request, caller->person.id);
  return caller;
}

asio::awaitable<bool> Api::StillAllowed(EventSource& events) {
  co_return co_await pool_->Run([&] { return events.StillAllowed(); });
}

asio::awaitable<Result<Bytes>> Api::NextPiece(const BytePieces& body) {
  co_return co_await pool_->Run([&]() -> Result<Bytes> {
    try {
      return body.next();
    } catch (const std::exception& error) {  // no memory
      return Status(Code::kInternal, error.what());
    }
  });
}

}  // namespace enamel::server::http

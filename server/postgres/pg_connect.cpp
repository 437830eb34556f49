#include <netdb.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <utility>
#include <vector>

#include "common/sql/query.h"
#include "server/postgres/libpq.h"
#include "server/postgres/pg_db.h"
#include "server/postgres/pg_text.h"

// Finding the server that takes writes.
namespace enamel::sql {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr std::chrono::seconds kConnect{2};
constexpr milliseconds kAgain{200};
constexpr size_t kMaxPlaces = 16;

// A socket of this machine ("/run/…", "@…"), or an address that does not leave it.
bool IsHere(const std::string& host) {
  return host.empty() || host.front() == '/' || host.front() == '@' || host == "localhost" ||
         host.starts_with("127.") || host == "::1";
}

std::vector<std::string> PartsOf(const std::string& list) {
  std::vector<std::string> out;
  for (size_t begin = 0; begin <= list.size();) {
    const size_t end = std::min(list.find(',', begin), list.size());
    out.push_back(list.substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}

// Of the hosts, one that is elsewhere; empty: none.
std::string Elsewhere(const std::string& hosts) {
  const auto all = PartsOf(hosts);
  const auto at = std::ranges::find_if_not(all, IsHere);
  return at == all.end() ? std::string() : *at;
}

// What a connection string says of where to connect.
struct Words {
  std::string host, hostaddr, port, service, sslmode;
};

Result<Words> WordsOf(const Libpq& pq, const std::string& server) {
  char* why = nullptr;
  PQconninfoOption* const all = pq.conninfo_parse(server.c_str(), &why);
  if (all == nullptr) {
    Status bad(Code::kInvalidInput, "expected a connection string of libpq, found another: " +
                                        FirstLine(why) + "; mend it");
    pq.freemem(why);
    return bad;
  }
  Words out;
  const std::pair<const char*, std::string*> wanted[] = {{"host", &out.host},
                                                         {"hostaddr", &out.hostaddr},
                                                         {"port", &out.port},
                                                         {"service", &out.service},
                                                         {"sslmode", &out.sslmode}};
  for (const PQconninfoOption* word = all; word->keyword != nullptr; ++word) {
    for (const auto& [name, value] : wanted) {
      if (word->val != nullptr && std::string(word->keyword) == name) *value = word->val;
    }
  }
  pq.conninfo_free(all);
  return out;
}

// One address to connect to. Empty: as the connection string says.
struct Place {
  std::string host, hostaddr, port;
};

// Empty: not known; libpq then gives the reason.
std::vector<std::string> AddressesOf(const std::string& host) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0) return {};
  std::vector<std::string> out;
  for (const addrinfo* at = found; at != nullptr; at = at->ai_next) {
    char text[NI_MAXHOST] = "";
    if (::getnameinfo(at->ai_addr, at->ai_addrlen, text, sizeof text, nullptr, 0, NI_NUMERICHOST) ==
        0)
      out.emplace_back(text);
  }
  ::freeaddrinfo(found);
  return out;
}

// Never empty. Where libpq has to say what is wrong with the lists, or takes them from a service:
// the one place that it chooses.
std::vector<Place> PlacesOf(const Words& words) {
  const auto hosts = PartsOf(words.host), addresses = PartsOf(words.hostaddr),
             ports = PartsOf(words.port);
  const bool named = !words.host.empty(), numbered = !words.hostaddr.empty();
  const size_t count = std::max(hosts.size(), addresses.size());
  const auto fits = [&](const std::vector<std::string>& list) {
    return list.size() == count && std::ranges::count(list, "") == 0;
  };
  if ((!named && !numbered) || (named && !fits(hosts)) || (numbered && !fits(addresses)) ||
      (ports.size() > 1 && !fits(ports)))
    return {Place{}};
  std::vector<Place> out;
  for (size_t i = 0; i < count; ++i) {
    Place place;
    place.port = ports.size() > 1 ? ports[i] : ports[0];
    if (named) place.host = hosts[i];
    if (numbered) place.hostaddr = addresses[i];
    const bool is_name = !numbered && place.host.front() != '/' && place.host.front() != '@';
    const auto found = is_name ? AddressesOf(place.host) : std::vector<std::string>();
    if (found.empty()) out.push_back(place);
    for (const std::string& address : found) {
      place.hostaddr = address;
      out.push_back(place);
    }
  }
  out.resize(std::min(out.size(), kMaxPlaces));
  return out;
}

}  // namespace

// Connects to all places at once: libpq tries them one after another, and a place that hangs would
// delay the others by two seconds each. While one place has not answered, this asks those again
// that refused: somebody may have promoted a standby meanwhile.
class PgDb::Race {
 public:
  Race(const Libpq& pq, const PgDbOptions& options, const std::vector<Place>& places)
      : pq_(pq), options_(options), until_(steady_clock::now() + kConnect) {
    for (const Place& place : places) runners_.push_back(Begin(place));
  }
  ~Race() {
    for (const Runner& runner : runners_) pq_.finish(runner.handle);
  }
  Race(const Race&) = delete;
  Race& operator=(const Race&) = delete;

  size_t size() const { return runners_.size(); }
  // Until each is there or has failed.
  void AwaitAll() {
    while (Step()) {
    }
  }
  // One that is there, as soon as there is one; the caller's from here on. Null: there is none more.
  pg_conn* Next() {
    for (;;) {
      const auto there = std::ranges::find(runners_, PGRES_POLLING_OK, &Runner::state);
      if (there != runners_.end()) {
        pg_conn* const out = there->handle;
        runners_.erase(there);
        return out;
      }
      if (!Step()) return nullptr;
    }
  }
  // Of those that are there, without taking them.
  std::vector<pg_conn*> There() const {
    std::vector<pg_conn*> out;
    for (const Runner& runner : runners_) {
      if (runner.state == PGRES_POLLING_OK) out.push_back(runner.handle);
    }
    return out;
  }
  // Why the others are not. Among several causes, names the one that somebody has to mend: a standby beside a
  // primary that cannot be reached is as it should be.
  PgFailure Problem(bool opening) const {
    PgFailure out{PgFailure::Kind::kReadOnly, {}, {}, opening};
    for (const Runner& runner : runners_) {
      std::string words = "no answer from " + WhereOf(runner.place) + " within " +
                          std::to_string(kConnect.count()) + " s";
      std::string state;
      if (runner.state == PGRES_POLLING_FAILED) {
        words = FirstLine(pq_.error_message(runner.handle));
        state = TakeState(words);
      }
      out.words += (out.words.empty() ? "" : "; ") + words;
      const PgFailure::Kind kind = state.empty() ? PgFailure::Kind::kNotThere : PgKindOf(state);
      if (Weight(kind) <= Weight(out.kind)) continue;
      out.kind = kind;
      out.state = state;
    }
    return out;
  }

 private:
  struct Runner {
    Place place;
    pg_conn* handle;
    PostgresPollingStatusType state = PGRES_POLLING_WRITING;  // libpq wants it begun so
    steady_clock::time_point begun = steady_clock::now();
  };
  Runner Begin(const Place& place) const {
    // Keywords before dbname are defaults, which the server's own words replace; keywords after it
    // are not. A read-only connection also goes to the primary: a standby may lack the newest
    // commits.
    const char* const names[] = {"tcp_user_timeout",
                                 "keepalives_idle",
                                 "keepalives_interval",
                                 "keepalives_count",
                                 "target_session_attrs",
                                 "dbname",
                                 "client_encoding",
                                 "fallback_application_name",
                                 "host",
                                 "hostaddr",
                                 "port",
                                 options_.any ? "target_session_attrs" : nullptr,
                                 nullptr};
    const char* const values[] = {"5000",
                                  "5",
                                  "2",
                                  "3",
                                  options_.read_only ? "primary" : "read-write",
                                  options_.server.c_str(),
                                  "UTF8",
                                  "enamel",
                                  place.host.c_str(),
                                  place.hostaddr.c_str(),
                                  place.port.c_str(),
                                  "any",
                                  nullptr};
    Runner out{place, pq_.connect_start_params(names, values, /*expand_dbname*/ 1)};
    // With the SQLSTATE (TakeState).
    pq_.set_error_verbosity(out.handle, PQERRORS_VERBOSE);
    if (pq_.status(out.handle) == CONNECTION_BAD) out.state = PGRES_POLLING_FAILED;
    return out;
  }
  static bool Runs(const Runner& runner) {
    return runner.state == PGRES_POLLING_READING || runner.state == PGRES_POLLING_WRITING;
  }

  // Waits until one connection has news. False: none is being made, or their time is over.
  bool Step() {
    std::vector<pollfd> sockets;
    std::vector<Runner*> running;
    for (Runner& runner : runners_) {
      if (!Runs(runner)) continue;
      running.push_back(&runner);
      sockets.push_back(
          {pq_.socket(runner.handle),
           static_cast<short>(runner.state == PGRES_POLLING_READING ? POLLIN : POLLOUT), 0});
    }
    auto left = std::chrono::ceil<milliseconds>(until_ - steady_clock::now());
    if (running.empty() || left.count() <= 0) return false;
    for (Runner& runner : runners_) {
      if (runner.state != PGRES_POLLING_FAILED) continue;
      const auto again =
          std::chrono::ceil<milliseconds>(runner.begun + kAgain - steady_clock::now());
      left = std::min(left, std::max(again, milliseconds(0)));
      if (again.count() > 0) continue;
      pq_.finish(runner.handle);
      runner = Begin(runner.place);
      return true;
    }
    if (::poll(sockets.data(), sockets.size(), static_cast<int>(left.count())) < 1) return true;
    for (size_t i = 0; i < running.size(); ++i) {
      if (sockets[i].revents != 0) running[i]->state = pq_.connect_poll(running[i]->handle);
    }
    return true;
  }

  static int Weight(PgFailure::Kind kind) {
    if (kind == PgFailure::Kind::kReadOnly) return 0;
    return kind == PgFailure::Kind::kNotThere ? 1 : 2;
  }

  static std::string WhereOf(const Place& place) {
    if (!place.host.empty()) return place.host;
    return place.hostaddr.empty() ? "the server" : place.hostaddr;
  }

  const Libpq& pq_;
  const PgDbOptions& options_;
  const steady_clock::time_point until_;
  std::vector<Runner> runners_;
};

Status PgDb::MustBePrivate(const Libpq& pq, const std::string& server) {
  ENAMEL_ASSIGN_OR_RETURN(const Words words, WordsOf(pq, server));
  std::string elsewhere = Elsewhere(words.host);
  if (elsewhere.empty()) elsewhere = Elsewhere(words.hostaddr);
  if (!words.service.empty()) elsewhere = "service " + words.service;
  if (elsewhere.empty() || words.sslmode == "verify-full") return Status::Ok();
  // Without sslmode, libpq uses plaintext where the server has no TLS, and checks no certificate.
  return Status(
      Code::kInvalidInput,
      "expected sslmode=verify-full for a PostgreSQL server on another machine, found " +
          (words.sslmode.empty() ? std::string("no sslmode") : "sslmode=" + words.sslmode) +
          " for " + elsewhere +
          ": passwords and recordings would travel in the clear, or to anybody; add "
          "sslmode=verify-full and sslrootcert=FILE to the connection string");
}

Status PgDb::Connect() {
  ++connection_;
  demoted_ = false;
  set_up_ = false;
  hangs_ = false;
  failure_ = {};
  pq_.finish(std::exchange(handle_, nullptr));
  ENAMEL_ASSIGN_OR_RETURN(const Words words, WordsOf(pq_, options_.server));
  Race race(pq_, options_, PlacesOf(words));
  Status refused;
  const auto use = [&](pg_conn* handle) {
    handle_ = handle;
    // Notices ("already exists, skipping") are nobody's business.
    pq_.set_notice_receiver(
        handle, [](void*, const PGresult*) {}, nullptr);
    return pq_.set_nonblocking(handle, 1) == 0 ? Status::Ok() : Fail(nullptr);
  };
  // After a start nobody knows which of several primaries was promoted last: all are asked.
  if (race.size() > 1 && options_.newest && *options_.newest == 0) {
    race.AwaitAll();
    for (pg_conn* const there : race.There()) {
      if (use(there).ok()) (void)LearnTimeline();
    }
    handle_ = nullptr;
  }
  while (pg_conn* const next = race.Next()) {
    refused = use(next);
    if (refused.ok()) refused = LearnTimeline();
    if (refused.ok()) refused = SetUp();
    set_up_ = refused.ok();
    if (set_up_) return refused;
    pq_.finish(std::exchange(handle_, nullptr));
  }
  ENAMEL_RETURN_IF_ERROR(refused);
  return Fail(race.Problem(opening_));
}

Result<int64_t> PgDb::ReadTimeline() {
  // The first eight digits of the names of its log.
  PGresult* const result =
      Ask("SELECT CASE WHEN pg_is_in_recovery() THEN 0 ELSE ('x' || "
          "substr(pg_walfile_name(pg_current_wal_lsn()), 1, 8))::bit(32)::int END");
  const bool told = pq_.result_status(result) == PGRES_TUPLES_OK;
  Result<int64_t> out =
      told ? Result<int64_t>(std::stoll(pq_.getvalue(result, 0, 0))) : Fail(result);
  pq_.clear(result);
  return out;
}

PgHost PgDb::Described(std::string where) {
  PgHost out;
  out.where = std::move(where);
  const auto timeline = ReadTimeline();
  if (!timeline.ok()) out.problem = failure_.words;
  out.timeline = timeline.ok() ? *timeline : 0;
  out.takes_writes = out.timeline > 0;
  out.version = pq_.server_version(handle_);
  out.tls = pq_.ssl_in_use(handle_) == 1;
  auto* const tls = static_cast<SSL*>(pq_.ssl_struct(handle_, "OpenSSL"));
  X509* const certificate = tls == nullptr ? nullptr : SSL_get1_peer_certificate(tls);
  if (certificate != nullptr) {
    std::tm end{};
    if (ASN1_TIME_to_tm(X509_get0_notAfter(certificate), &end) == 1)
      out.certificate_until_ms = int64_t{::timegm(&end)} * 1000;
    X509_free(certificate);
  }
  return out;
}

Result<std::vector<PgHost>> PgDb::Hosts(const PgDbOptions& options) {
  ENAMEL_ASSIGN_OR_RETURN(const Libpq* pq, LoadLibpq());
  ENAMEL_RETURN_IF_ERROR(MustBePrivate(*pq, options.server));
  ENAMEL_ASSIGN_OR_RETURN(const Words words, WordsOf(*pq, options.server));
  PgDbOptions one = options;
  one.any = true;
  std::vector<PgHost> out;
  for (const Place& place : PlacesOf(words)) {
    Race race(*pq, one, {place});
    std::string where = place.host.empty() ? place.hostaddr : place.host;
    if (!place.host.empty() && !place.hostaddr.empty()) where += " (" + place.hostaddr + ")";
    PgDb db(*pq, one);
    db.handle_ = race.Next();
    if (db.handle_ == nullptr) {
      PgFailure problem = race.Problem(/*opening=*/true);
      out.push_back({std::move(where), std::move(problem.words), problem.kind});
    } else {
      pq->set_nonblocking(db.handle_, 1);
      out.push_back(db.Described(std::move(where)));
    }
  }
  return out;
}

Status PgDb::LearnTimeline() {
  if (!options_.newest) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(timeline_, ReadTimeline());
  for (int64_t newest = *options_.newest; timeline_ > newest;) {
    if (options_.newest->compare_exchange_weak(newest, timeline_)) break;
  }
  return MustBeNewest();
}

Status PgDb::MustBeNewest() {
  if (!IsReplaced()) return Status::Ok();
  return Fail(PgFailure{PgFailure::Kind::kReplaced,
                        {},
                        "the server is on timeline " + std::to_string(timeline_) + ", another on " +
                            std::to_string(options_.newest->load()),
                        opening_});
}

bool PgDb::IsReplaced() const { return options_.newest && timeline_ < *options_.newest; }

}  // namespace enamel::sql

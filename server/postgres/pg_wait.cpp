#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>

#include "server/postgres/libpq.h"
#include "server/postgres/pg_db.h"

// Waiting for the server. A server that hangs keeps its connections open and its kernel answers
// keepalives, so only a deadline of ours finds out.
namespace enamel::sql {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

PGresult* PgDb::Answer() {
  Await();
  return pq_.get_result(handle_);
}

PGresult* PgDb::LastAnswer(bool sent) {
  PGresult* last = nullptr;
  while (PGresult* const next = sent ? Answer() : nullptr) {
    pq_.clear(last);
    last = next;
  }
  return last;
}

PGresult* PgDb::Ask(const std::string& sql) {
  return LastAnswer(pq_.send_query(handle_, sql.c_str()) == 1);
}

void PgDb::Await() {
  const auto asked = steady_clock::now();
  auto look_at = asked + options_.patience;
  for (;;) {
    const int unsent = pq_.flush(handle_);
    const int socket = pq_.socket(handle_);
    if (socket < 0 || unsent < 0 || (unsent == 0 && pq_.is_busy(handle_) == 0)) return;
    const auto left = std::chrono::ceil<milliseconds>(look_at - steady_clock::now());
    if (left.count() <= 0) {
      if (!IsWorthWaiting(asked)) return GiveUp();
      look_at = steady_clock::now() + 3 * options_.patience;
      continue;
    }
    pollfd ready{socket, static_cast<short>(unsent > 0 ? POLLIN | POLLOUT : POLLIN), 0};
    if (::poll(&ready, 1, static_cast<int>(left.count())) < 1) continue;
    if ((ready.revents & ~POLLOUT) != 0 && pq_.consume_input(handle_) == 0) return;
  }
}

bool PgDb::IsWorthWaiting(steady_clock::time_point asked) const {
  if (bounded_ && steady_clock::now() - asked > kLongest) return false;
  return ServerAnswers();
}

bool PgDb::ServerAnswers() const {
  // The machine and port of this connection, whatever others the connection string names. libpq
  // rounds a shorter time up to two seconds.
  const char* const names[] = {
      "dbname", "host", "hostaddr", "port", "connect_timeout", "target_session_attrs", nullptr};
  const char* const values[] = {options_.server.c_str(),
                                pq_.host(handle_),
                                pq_.hostaddr(handle_),
                                pq_.port(handle_),
                                "2",
                                "any",
                                nullptr};
  const PGPing answer = pq_.ping_params(names, values, /*expand_dbname*/ 1);
  return answer == PQPING_OK || answer == PQPING_REJECT;
}

void PgDb::GiveUp() {
  hangs_ = true;
  ::shutdown(pq_.socket(handle_), SHUT_RDWR);
  // libpq learns of it from reading to the end.
  while (pq_.socket(handle_) >= 0 && pq_.consume_input(handle_) == 1) {
  }
}

}  // namespace enamel::sql

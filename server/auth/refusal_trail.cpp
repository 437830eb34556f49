#include "server/auth/refusal_trail.h"

#include <spdlog/spdlog.h>

#include <boost/asio/post.hpp>

#include "common/base/log_request.h"
#include "server/auth/address_block.h"

namespace enamel::server::auth {
namespace {

bool IsPowerOfTen(uint64_t count) {
  while (count >= 10 && count % 10 == 0) count /= 10;
  return count == 1;
}

}  // namespace

RefusalTrail::RefusalTrail(Store& store, std::function<int64_t()> elapsed_ms)
    : store_(store), elapsed_ms_(std::move(elapsed_ms)) {}

RefusalTrail::~RefusalTrail() { pool_.join(); }

void RefusalTrail::Note(TurnedAway refused) {
  // A door must not wait for the trail. What does not fit is counted in the figures and leaves no
  // row.
  if (++waiting_ > kMaxWaiting) {
    --waiting_;
    return;
  }
  // The clock is the caller's: it may not be read on another thread. Nor is the request known
  // there.
  boost::asio::post(pool_, [this, refused = std::move(refused), now_ms = elapsed_ms_(),
                            request = std::string(LogRequest::Current())] {
    const LogRequest logged(request);
    Take(refused, now_ms);
    --waiting_;
  });
}

void RefusalTrail::Settle() {
  std::promise<void> done;
  boost::asio::post(pool_, [&done] { done.set_value(); });
  done.get_future().wait();
}

void RefusalTrail::Take(const TurnedAway& refused, int64_t now_ms) {
  if (counts_.empty() || now_ms - window_begin_ms_ > kWindowMs) {
    counts_.clear();
    rows_ = 0;
    window_begin_ms_ = now_ms;
  }
  Uuid person = refused.person;
  if (person.IsZero() && !refused.login.empty()) {
    if (auto found = store_.people.PersonByLogin(refused.login); found.ok()) person = found->id;
  }
  const std::string key = refused.why + "|" + AddressText(refused.address) + "|" +
                          (person.IsZero() ? "" : person.Text());
  // Every key has made a row: there are no more keys than rows.
  if (rows_ >= kMaxRows && !counts_.contains(key)) return;
  uint64_t count = ++counts_[key];
  if (rows_ >= kMaxRows || !IsPowerOfTen(count)) return;
  ++rows_;
  Write(refused, person, count);
}

void RefusalTrail::Write(const TurnedAway& refused, const Uuid& person, uint64_t count) {
  const bool last = rows_ == kMaxRows;
  const std::string who = person.IsZero() ? "nobody" : person.Text();
  const std::string address = AddressText(refused.address), times = std::to_string(count);
  const bool asked = !refused.what.empty();
  spdlog::warn("{}: {} of {} at {} refused: {}{}; {} in 15 minutes{}", refused.via,
               asked ? "request" : "sign-in", who, address, refused.why,
               asked ? " (" + refused.what + ")" : "", times,
               last ? "; more refusals in these 15 minutes are only counted" : "");
  std::string after = R"({"address":")" + address + R"(","count":")" + times + R"(","reason":")" +
                      (last ? "many" : refused.why) + '"';
  if (asked) after += R"(,"request":")" + refused.what + '"';
  const Actor by{asked ? person : Uuid{}, refused.via};
  Status noted =
      store_.audit.NoteAudit(by, asked ? "request.refused" : "session.refused", who, after + "}");
  if (!noted.ok()) spdlog::warn("audit: a refusal could not be written: {}", noted.message());
}

}  // namespace enamel::server::auth

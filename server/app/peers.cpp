#include "server/app/peers.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "common/base/counted.h"
#include "common/base/stoppable_sleep.h"
#include "common/net/frame_client.h"

namespace enamel::server::app {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

// How often this server looks whether it has trouble.
constexpr milliseconds kLook{250};
// A heartbeat without an answer for so long is worth a question: there is an answer by the time
// that health calls it trouble (DatabaseLook::kLate).
constexpr milliseconds kSuspicious{1'000};
// Connecting, and answering.
constexpr milliseconds kAnswerWithin{1'000};
// Questions and answers take time on the way.
constexpr milliseconds kSlack{500};
constexpr size_t kMaxPeers = 16;
// By then every server has noticed an S3 store that fails.
constexpr milliseconds kBucketsSeen{6'000};

uint64_t Ms(Clock::duration time) {
  return static_cast<uint64_t>(std::chrono::duration_cast<milliseconds>(time).count());
}

// The database answered this peer after it had stopped to answer here: its heartbeat is younger than
// the trouble.
bool HasDatabase(const wire::Measured& peer, milliseconds troubled) {
  const uint64_t silence = peer.database_silence_ms();
  return !peer.writes_fail() && peer.oldest_wait_ms() <= Ms(StoreHealthCheck::kLongestWait) &&
         silence <= Ms(DatabaseLook::kLate) && silence + Ms(kSlack) < Ms(troubled);
}

}  // namespace

wire::Measured MeasuredBy(Store& store) {
  const StoreHealth health = store.health.Health();
  wire::Measured out;
  out.set_server(protocol::ToField(store.look.server().view()));
  out.set_database_silence_ms(Ms(store.look.silence()));
  out.set_oldest_wait_ms(static_cast<uint64_t>(health.oldest_wait_s * 1000));
  out.set_writes_fail(health.writes_fail);
  out.set_blobs_fail(health.blobs_fail);
  out.set_keys_fail(health.keys_fail);
  out.set_timeline(store.look.timeline());
  return out;
}

Peers::Peers(Store& store, const Sha256& certificate, milliseconds every)
    : store_(store), certificate_(certificate), every_(every) {
  if (store.shared) thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

std::optional<PeersView> Peers::view() const {
  MutexLock lock(mutex_);
  return view_;
}

void Peers::Run(const std::stop_token& stop) {
  bool troubled = false;
  do {
    const StoreHealth health = store_.health.Health();
    const auto unanswered = store_.look.unanswered();
    const auto now = Clock::now();
    const auto note = [&](bool is, Clock::time_point since, auto& noted) {
      noted = is ? std::optional(std::min(noted.value_or(since), since)) : std::nullopt;
    };
    // The first question without an answer is older than the suspicion.
    note(health.database_fails || unanswered > kSuspicious, now - unanswered, database_);
    note(health.blobs_fail || health.keys_fail, now, buckets_);
    troubled = database_ || buckets_;
    std::optional<PeersView> found;
    if (troubled) found = Ask(store_.look.peers());
    Tell(health, found.value_or(PeersView{}));
    MutexLock lock(mutex_);
    view_ = found;
  } while (!SleepUntilStopped(stop, troubled ? every_ : std::min(every_, kLook)));
}

PeersView Peers::Ask(const std::vector<DatabaseLook::Peer>& peers) {
  std::vector<std::optional<wire::Measured>> answers(std::min(peers.size(), kMaxPeers));
  {
    std::vector<std::jthread> each;
    for (size_t i = 0; i < answers.size(); ++i) {
      each.emplace_back([&, i] { answers[i] = Ask(peers[i]); });
    }
  }
  const auto now = Clock::now();
  const auto for_ms = [&](const auto& since) {
    return since ? std::chrono::duration_cast<milliseconds>(now - *since) : milliseconds(0);
  };
  // They look at S3 stores every other second, and wait for seconds.
  const bool young = for_ms(buckets_) < kBucketsSeen;
  PeersView out;
  out.asked = answers.size();
  for (const auto& answer : answers) {
    if (!answer) continue;
    ++out.answered;
    store_.look.Learn(answer->timeline());
    out.database += HasDatabase(*answer, for_ms(database_)) ? 0 : 1;
    out.blobs += young || answer->blobs_fail() ? 1 : 0;
    out.keys += young || answer->keys_fail() ? 1 : 0;
  }
  return out;
}

// Each change once.
void Peers::Tell(const StoreHealth& health, const PeersView& view) {
  const auto say = [&](const char* what, size_t same) {
    if (view.answered == 0) return std::string();
    const std::string of = " of " + Counted(view.answered, "other server") + " that answer";
    if (same == view.answered) {
      return "none" + of + " reaches the " + what + " either: look there";
    }
    return std::to_string(view.answered - same) + of + " can use the " + what +
           ": check this machine, and its network";
  };
  std::string text;
  if (health.database_fails) {
    text = say("database", view.database);
  } else if (health.blobs_fail) {
    text = say("store of blobs", view.blobs);
  } else if (health.keys_fail) {
    text = say("store of keys", view.keys);
  }
  if (!text.empty() && text != told_) spdlog::warn("{}", text);
  told_ = text;
}

// None: no answer, or that of another server than the row's, such as this one.
std::optional<wire::Measured> Peers::Ask(const DatabaseLook::Peer& peer) const {
  net::FrameClient client;
  wire::Request request;
  request.set_id(1);
  request.mutable_measure();
  if (!client.Connect({peer.host, peer.port}, certificate_, kAnswerWithin).ok()) return {};
  if (!client.Send(protocol::Serialize(request), kAnswerWithin).ok()) return {};
  const auto frame = client.Receive(kAnswerWithin);
  if (!frame.ok()) return {};
  const auto reply = protocol::ParseReply(*frame);
  if (!reply.ok() || !reply->has_measured()) return {};
  if (reply->measured().server() != protocol::ToField(peer.server.view())) return {};
  return reply->measured();
}

}  // namespace enamel::server::app

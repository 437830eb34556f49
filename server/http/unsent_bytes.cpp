#include "server/http/unsent_bytes.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace enamel::server::http {

void UnsentBytes::Sending::OnGivenUp(std::function<void()> close) {
  {
    MutexLock lock(mutex_);
    if (!given_up_) {
      close_ = std::move(close);
      return;
    }
  }
  close();
}

void UnsentBytes::State::Remove(std::list<Entry>::iterator entry) {
  if (--uses[entry->body] == 0) {
    uses.erase(entry->body);
    bytes -= entry->bytes;
  }
  if ((of[entry->of] -= entry->bytes) == 0) of.erase(entry->of);
  entries.erase(entry);
}

std::list<UnsentBytes::Entry>::iterator UnsentBytes::State::OldestOfMost(size_t than) {
  const auto most = std::ranges::max_element(of, {}, [](const auto& one) { return one.second; });
  if (most == of.end() || most->second <= than) return entries.end();
  return std::ranges::find(entries, most->first, &Entry::of);
}

std::shared_ptr<UnsentBytes::Sending> UnsentBytes::Add(const std::string& of, const void* body,
                                                       size_t bytes) {
  std::vector<std::shared_ptr<Sending>> given_up;
  std::shared_ptr<Sending> out;
  {
    State& state = *state_;
    MutexLock lock(state.mutex);
    const auto had = state.of.find(of);
    const size_t mine = bytes + (had == state.of.end() ? 0 : had->second);
    const auto fits = [&]() ENAMEL_REQUIRES(state.mutex) {
      return state.bytes + (state.uses.contains(body) ? 0 : bytes) <= most_;
    };
    while (!fits()) {
      const auto entry = state.OldestOfMost(mine);
      if (entry == state.entries.end()) break;
      if (auto sending = entry->sending.lock()) given_up.push_back(std::move(sending));
      state.Remove(entry);
    }
    if (fits()) {
      if (++state.uses[body] == 1) state.bytes += bytes;
      state.of[of] += bytes;
      const uint64_t id = state.next_id++;
      const auto entry = state.entries.insert(state.entries.end(), {id, of, body, bytes, {}});
      out = {new Sending, [kept = state_, id](Sending* sending) {
               {
                 MutexLock end(kept->mutex);
                 const auto at = std::ranges::find(kept->entries, id, &Entry::id);
                 if (at != kept->entries.end()) kept->Remove(at);
               }
               delete sending;
             }};
      entry->sending = out;
    }
  }
  for (const auto& sending : given_up) {
    std::function<void()> close;
    {
      MutexLock lock(sending->mutex_);
      sending->given_up_ = true;
      close = std::exchange(sending->close_, nullptr);
    }
    if (close) close();
  }
  return out;
}

size_t UnsentBytes::bytes() const {
  MutexLock lock(state_->mutex);
  return state_->bytes;
}

}  // namespace enamel::server::http

#include "server/net/held_bytes.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace enamel::server {

void HeldBytes::Held::OnGivenUp(std::function<void()> close) {
  {
    MutexLock lock(mutex_);
    if (!given_up_) {
      close_ = std::move(close);
      return;
    }
  }
  close();
}

void HeldBytes::State::Remove(std::list<Entry>::iterator entry) {
  if (--uses[entry->where] == 0) {
    uses.erase(entry->where);
    bytes -= entry->bytes;
  }
  if ((of[entry->of] -= entry->bytes) == 0) of.erase(entry->of);
  entries.erase(entry);
}

std::list<HeldBytes::Entry>::iterator HeldBytes::State::OldestOfMost(size_t than) {
  const auto most = std::ranges::max_element(of, {}, [](const auto& one) { return one.second; });
  if (most == of.end() || most->second <= than) return entries.end();
  return std::ranges::find(entries, most->first, &Entry::of);
}

std::shared_ptr<HeldBytes::Held> HeldBytes::Add(const std::string& of, const void* where,
                                                size_t bytes) {
  std::vector<std::shared_ptr<Held>> given_up;
  std::shared_ptr<Held> out;
  {
    State& state = *state_;
    MutexLock lock(state.mutex);
    const auto had = state.of.find(of);
    const size_t mine = bytes + (had == state.of.end() ? 0 : had->second);
    const auto fits = [&]() ENAMEL_REQUIRES(state.mutex) {
      return state.bytes + (state.uses.contains(where) ? 0 : bytes) <= most_;
    };
    while (!fits()) {
      const auto entry = state.OldestOfMost(mine);
      if (entry == state.entries.end()) break;
      if (auto held = entry->held.lock()) given_up.push_back(std::move(held));
      ++state.refused;
      state.Remove(entry);
    }
    if (!fits()) {
      ++state.refused;
    } else {
      if (++state.uses[where] == 1) state.bytes += bytes;
      state.of[of] += bytes;
      const uint64_t id = state.next_id++;
      const auto entry = state.entries.insert(state.entries.end(), {id, of, where, bytes, {}});
      out = {new Held, [kept = state_, id](Held* held) {
               {
                 MutexLock end(kept->mutex);
                 const auto at = std::ranges::find(kept->entries, id, &Entry::id);
                 if (at != kept->entries.end()) kept->Remove(at);
               }
               delete held;
             }};
      entry->held = out;
    }
  }
  for (const auto& held : given_up) {
    std::function<void()> close;
    {
      MutexLock lock(held->mutex_);
      held->given_up_ = true;
      close = std::exchange(held->close_, nullptr);
    }
    if (close) close();
  }
  return out;
}

size_t HeldBytes::bytes() const {
  MutexLock lock(state_->mutex);
  return state_->bytes;
}

HeldBytes::Use HeldBytes::Most(std::string_view of_begins) const {
  Use out;
  MutexLock lock(state_->mutex);
  for (const auto& [of, bytes] : state_->of) {
    if (bytes > out.bytes && of.starts_with(of_begins)) out = {of, bytes};
  }
  return out;
}

uint64_t HeldBytes::refused() const {
  MutexLock lock(state_->mutex);
  return state_->refused;
}

}  // namespace enamel::server

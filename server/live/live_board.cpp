#include "server/live/live_board.h"

#include <algorithm>
#include <iterator>

namespace enamel::server {
namespace {

constexpr size_t kMaxAttempts = 1024;

void AppendRow(const LiveSample& sample, std::string& out) {
  out += '[' + std::to_string(sample.tick);
  for (int32_t value : sample.anchor_um) out += ',' + std::to_string(value);
  for (int32_t value : sample.force_mn) out += ',' + std::to_string(value);
  out += ',' + std::to_string(sample.flags) + ']';
}

std::string EventOf(std::deque<LiveSample>::const_iterator from,
                    std::deque<LiveSample>::const_iterator end) {
  std::string out = "{\"tick\":" + std::to_string(std::prev(end)->tick) + ",\"rows\":[";
  for (auto at = from; at != end; ++at) {
    if (at != from) out += ',';
    AppendRow(*at, out);
  }
  return out + "]}";
}

}  // namespace

void LiveBoard::Put(std::span<const LiveSample> samples) {
  if (samples.empty()) return;
  const LiveSample& last = samples.back();
  MutexLock lock(state_->mutex);
  auto [at, fresh] = state_->latest.try_emplace(last.attempt, last);
  // Chunks are committed half a second after the LiveState of the same ticks: whoever is behind
  // adds nothing.
  if (!fresh && last.tick <= at->second.tick) return;
  at->second = last;
  if (auto channel = state_->channels.find(last.attempt); channel != state_->channels.end()) {
    auto& recent = channel->second.recent;
    for (const LiveSample& sample : samples) {
      // Ticks grow along the deque, which LiveWatch::Next searches by halves.
      if (recent.empty() || sample.tick > recent.back().tick) recent.push_back(sample);
      if (recent.size() > kMaxRows) recent.pop_front();
    }
  }
  if (state_->latest.size() <= kMaxAttempts) return;
  // A search through all of them, only when there is one attempt too many.
  state_->latest.erase(std::min_element(
      state_->latest.begin(), state_->latest.end(),
      [](const auto& a, const auto& b) { return a.second.received_ms < b.second.received_ms; }));
}

void LiveBoard::Remove(const Uuid& attempt) {
  MutexLock lock(state_->mutex);
  state_->latest.erase(attempt);
  if (auto channel = state_->channels.find(attempt); channel != state_->channels.end()) {
    // The channel stays until its last watcher has seen the end and left.
    channel->second.ended = true;
  }
}

std::optional<LiveSample> LiveBoard::Latest(const Uuid& attempt) const {
  MutexLock lock(state_->mutex);
  auto at = state_->latest.find(attempt);
  if (at == state_->latest.end()) return std::nullopt;
  return at->second;
}

bool LiveBoard::Watched(const Uuid& attempt) const {
  // Most of the time nobody watches: then a chunk is not worth a lock that all stations share.
  if (state_->watches == 0) return false;
  MutexLock lock(state_->mutex);
  return state_->channels.contains(attempt);
}

std::map<Uuid, std::optional<LiveSample>> LiveBoard::WatchedNow() const {
  std::map<Uuid, std::optional<LiveSample>> out;
  if (state_->watches == 0) return out;
  MutexLock lock(state_->mutex);
  for (const auto& [attempt, channel] : state_->channels) {
    if (channel.ended) continue;
    auto at = state_->latest.find(attempt);
    out[attempt] = at == state_->latest.end() ? std::nullopt : std::optional(at->second);
  }
  return out;
}

std::unique_ptr<LiveWatch> LiveBoard::Watch(const Uuid& attempt, const Uuid& person) {
  MutexLock lock(state_->mutex);
  const auto mine = state_->watches_of.find(person);
  const size_t has = mine == state_->watches_of.end() ? 0 : mine->second;
  if (has >= static_cast<size_t>(limits_.person_views)) {
    ++state_->refused_of_person;
    return nullptr;
  }
  if (state_->watches >= static_cast<size_t>(limits_.views)) {
    ++state_->refused;
    return nullptr;
  }
  ++state_->watches_of[person];
  ++state_->watches;
  ++state_->channels[attempt].watches;
  return std::make_unique<LiveWatch>(state_, attempt, person);
}

Status LiveBoard::WhyNot(const Uuid& person) const {
  MutexLock lock(state_->mutex);
  const auto mine = state_->watches_of.find(person);
  if (mine != state_->watches_of.end() &&
      mine->second >= static_cast<size_t>(limits_.person_views)) {
    return ops::OverBudget(ops::kPersonViews, limits_,
                           "you have as many live views open as you may; close some of them");
  }
  return ops::OverBudget(ops::kViews, limits_,
                         "too many people are watching already; try again later");
}

std::vector<ops::BudgetUse> LiveBoard::Uses() const {
  ops::BudgetUse of_person, all;
  of_person.kind = &ops::kPersonViews;
  all.kind = &ops::kViews;
  MutexLock lock(state_->mutex);
  for (const auto& [person, count] : state_->watches_of) {
    if (count <= of_person.most) continue;
    of_person.most = count;
    of_person.party = ops::PartyKind::kPerson;
    of_person.of = person.Text();
  }
  all.most = state_->watches;
  of_person.refused = state_->refused_of_person;
  all.refused = state_->refused;
  for (ops::BudgetUse* use : {&of_person, &all}) use->limit = ops::LimitOf(*use->kind, limits_);
  return {of_person, all};
}

LiveWatch::~LiveWatch() {
  MutexLock lock(state_->mutex);
  --state_->watches;
  const auto mine = state_->watches_of.find(person_);
  if (--mine->second == 0) state_->watches_of.erase(mine);
  auto channel = state_->channels.find(attempt_);
  if (--channel->second.watches == 0) state_->channels.erase(channel);
}

std::shared_ptr<const std::string> LiveWatch::Next() {
  MutexLock lock(state_->mutex);
  LiveBoard::Channel& channel = state_->channels.at(attempt_);
  ended_ = channel.ended;
  auto from = channel.recent.cbegin(), end = channel.recent.cend();
  if (seen_) {
    from = std::upper_bound(from, end, *seen_,
                            [](uint64_t tick, const LiveSample& s) { return tick < s.tick; });
  }
  if (from == end) return nullptr;
  seen_ = channel.recent.back().tick;
  // Watchers that have kept up ask for the same moments: the first of them makes the text, all
  // share it.
  if (!channel.event || channel.first != from->tick || channel.last != *seen_) {
    channel.event = std::make_shared<const std::string>(EventOf(from, end));
    channel.first = from->tick;
    channel.last = *seen_;
  }
  return channel.event;
}

}  // namespace enamel::server

#include "server/auth/failure_counters.h"

#include <algorithm>

namespace enamel::server::auth {
namespace {

constexpr size_t kMaxCounters = 20'000;

}  // namespace

SignInCounter MemoryCounters::Read(const Map& map, const std::string& name) {
  auto at = map.find(name);
  return at == map.end() ? SignInCounter{} : at->second;
}

void MemoryCounters::Write(Map& map, const std::string& name, const SignInCounter& counter,
                           UnixMs now_ms) {
  if (counter == SignInCounter{}) {
    map.erase(name);
    return;
  }
  map[name] = counter;
  if (map.size() <= kMaxCounters) return;
  std::erase_if(map, [&](const auto& entry) { return entry.second.until_ms < now_ms; });
  // Under a flood of new names nothing is old enough: then the one longest silent goes.
  while (map.size() > kMaxCounters) {
    map.erase(
        std::ranges::min_element(map, {}, [](const auto& entry) { return entry.second.until_ms; }));
  }
}

Status MemoryCounters::Apply(const OfTry<std::string>& names, UnixMs now_ms, const Change& change) {
  MutexLock lock(mutex_);
  const OfTry<SignInCounter> before{Read(counters_, names.here), Read(counters_, names.place),
                                    Read(counters_, names.anywhere), Read(known_, names.known)};
  OfTry<SignInCounter> after = before;
  change(after);
  if (after.here != before.here) Write(counters_, names.here, after.here, now_ms);
  if (after.place != before.place) Write(counters_, names.place, after.place, now_ms);
  if (after.anywhere != before.anywhere) Write(counters_, names.anywhere, after.anywhere, now_ms);
  if (after.known != before.known) Write(known_, names.known, after.known, now_ms);
  return Status::Ok();
}

Status SharedCounters::Apply(const OfTry<std::string>& names, UnixMs, const Change& change) {
  const auto key = [](const std::string& name) { return HashSha256(AsBytes(name)); };
  return store_.sign_ins.Change(
      {key(names.here), key(names.place), key(names.anywhere), key(names.known)},
      [&](std::vector<SignInCounter>& all) {
        OfTry<SignInCounter> counters{all[0], all[1], all[2], all[3]};
        change(counters);
        all = {counters.here, counters.place, counters.anywhere, counters.known};
      });
}

}  // namespace enamel::server::auth

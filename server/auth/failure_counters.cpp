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
                                    Read(counters_, names.site), Read(counters_, names.anywhere),
                                    Read(known_, names.known)};
  OfTry<SignInCounter> after = before;
  change(after);
  const auto write = [&](Map& map, SignInCounter OfTry<SignInCounter>::*one,
                         const std::string& name) ENAMEL_REQUIRES(mutex_) {
    if (!name.empty() && after.*one != before.*one) Write(map, name, after.*one, now_ms);
  };
  write(counters_, &OfTry<SignInCounter>::here, names.here);
  write(counters_, &OfTry<SignInCounter>::place, names.place);
  write(counters_, &OfTry<SignInCounter>::site, names.site);
  write(counters_, &OfTry<SignInCounter>::anywhere, names.anywhere);
  write(known_, &OfTry<SignInCounter>::known, names.known);
  return Status::Ok();
}

Status SharedCounters::Apply(const OfTry<std::string>& names, UnixMs, const Change& change) {
  std::vector<Sha256> keys;
  for (const std::string* name :
       {&names.here, &names.place, &names.anywhere, &names.known, &names.site}) {
    if (!name->empty()) keys.push_back(HashSha256(AsBytes(*name)));
  }
  return store_.sign_ins.Change(keys, [&](std::vector<SignInCounter>& all) {
    OfTry<SignInCounter> counters{all[0], all[1], names.site.empty() ? SignInCounter{} : all[4],
                                  all[2], all[3]};
    change(counters);
    all = {counters.here, counters.place, counters.anywhere, counters.known};
    if (!names.site.empty()) all.push_back(counters.site);
  });
}

}  // namespace enamel::server::auth

#include "server/app/schools.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <set>
#include <utility>

#include "common/base/sha256.h"
#include "common/base/stoppable_sleep.h"
#include "common/protocol/messages.h"
#include "server/app/school.h"
#include "server/auth/token.h"
#include "server/http/api.h"

namespace enamel::server::app {

// Filled by whoever lets go of a school last, on whatever thread that is. Of each the Api goes
// first.
struct Schools::Ended {
  Mutex mutex;
  std::vector<std::unique_ptr<std::pair<std::shared_ptr<School>, std::shared_ptr<http::Api>>>> all
      ENAMEL_GUARDED_BY(mutex);
};

namespace {

// Both live as long as either is held.
template <typename T, typename Both>
std::shared_ptr<T> PartOf(const std::shared_ptr<Both>& both, T* part) {
  return std::shared_ptr<T>(both, part);
}

// How a school's store knows who says this first. kKnows: it is at home there.
enum class Acquaintance : uint8_t { kNone, kKnowsOf, kKnows };

Result<Acquaintance> Knows(StationRows& stations, const wire::Request& first) {
  if (first.has_enrol()) {
    ENAMEL_ASSIGN_OR_RETURN(const bool its,
                            stations.IsEnrolCode(HashSha256(AsBytes(first.enrol().code()))));
    return its ? Acquaintance::kKnows : Acquaintance::kNone;
  }
  // The chosen school's session refuses an invalid id.
  const auto id = protocol::ReadUuid(first.hello().station_id(), "station_id");
  if (!id.ok()) return Acquaintance::kNone;
  // The credential, not the id, which is no secret: another school may have enrolled the same id.
  const auto admitted =
      stations.StationByCredential(*id, auth::TokenHash(AsBytes(first.hello().credential())));
  if (admitted.ok() && !admitted->revoked) return Acquaintance::kKnows;
  if (admitted.ok()) return Acquaintance::kKnowsOf;
  if (admitted.status().code() != Code::kNotFound) return admitted.status();
  const auto known = stations.StationById(*id);
  if (!known.ok() && known.status().code() != Code::kNotFound) return known.status();
  return known.ok() ? Acquaintance::kKnowsOf : Acquaintance::kNone;
}

}  // namespace

Schools::Schools(Store& store, Open open, Forget forget)
    : store_(store),
      open_(std::move(open)),
      forget_(std::move(forget)),
      ended_(std::make_shared<Ended>()) {}

void Schools::Begin() {
  Read();
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

Schools::~Schools() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  {
    MutexLock lock(mutex_);
    served_.clear();
  }
  EndThose();
}

void Schools::Run(const std::stop_token& stop) {
  do {
    Look(stop);
  } while (!SleepUntilStopped(stop, kLookEvery));
}

void Schools::Look(const std::stop_token& stop) {
  Read();
  std::vector<std::string> names;
  {
    MutexLock lock(mutex_);
    for (const auto& [name, served] : served_) names.push_back(name);
  }
  for (const std::string& name : names) {
    if (stop.stop_requested()) return;
    OpenOne(name);
  }
  EndThose();
}

void Schools::Read() {
  const auto rows = store_.schools.Schools();
  // A failure is in the store's log; the schools stay as before.
  if (!rows.ok()) return;
  std::vector<std::shared_ptr<School>> closed;
  {
    MutexLock lock(mutex_);
    read_ = true;
    std::set<std::string> names;
    for (const SchoolRow& row : *rows) {
      names.insert(row.name);
      Served& served = served_[row.name];
      // Stations get the first host name when they connect.
      const bool same = served.row.id == row.id && row.state == SchoolState::kServed &&
                        served.row.hosts.front() == row.hosts.front();
      if (served.school && !same) closed.push_back(LetGo(served));
      served.row = row;
      gone_.erase(row.name);
    }
    for (auto& [name, served] : served_) {
      if (names.contains(name)) continue;
      if (served.school) closed.push_back(LetGo(served));
      gone_[name] = served.before;
    }
    std::erase_if(served_, [&](const auto& one) { return !names.contains(one.first); });
  }
  for (const auto& school : closed) school->End();
  closed.clear();
  EndThose();
  std::vector<std::string> forgotten;
  {
    MutexLock lock(mutex_);
    for (const auto& [name, before] : gone_) {
      if (before.expired()) forgotten.push_back(name);
    }
    for (const std::string& name : forgotten) gone_.erase(name);
  }
  for (const std::string& name : forgotten) {
    spdlog::info("school {} is gone", name);
    forget_(name);
  }
}

std::shared_ptr<School> Schools::LetGo(Served& served) {
  spdlog::info("school {} is no longer served as {}", served.row.name, served.row.hosts.front());
  std::shared_ptr<School> school = std::exchange(served.school, nullptr);
  served.api.reset();
  served.before = school;
  return school;
}

Result<Schools::Opened> Schools::TryToOpen(const SchoolRow& row) {
  // Such as no more threads: that is one school's trouble.
  try {
    ENAMEL_ASSIGN_OR_RETURN(auto opened, open_(row));
    opened.school->Start();
    return opened;
  } catch (const std::exception& error) {
    return Status(Code::kUnavailable, error.what());
  }
}

void Schools::OpenOne(const std::string& name) {
  SchoolRow row;
  {
    MutexLock lock(mutex_);
    const auto at = served_.find(name);
    if (at == served_.end() || at->second.school) return;
    if (at->second.row.state != SchoolState::kServed) return;
    // An earlier use of it has not ended yet: that comes first.
    if (!at->second.before.expired()) return;
    row = at->second.row;
  }
  EndThose();
  auto opened = TryToOpen(row);
  MutexLock lock(mutex_);
  const auto at = served_.find(name);
  if (at == served_.end() || at->second.row.id != row.id) return;
  Served& served = at->second;
  if (!opened.ok()) {
    // Once for each cause: it is tried again every two seconds.
    if (served.problem != opened.status().message()) {
      spdlog::error("school {} cannot be served: {}", name, opened.status().message());
    }
    served.problem = opened.status().message();
    return;
  }
  served.problem.clear();
  if (draining_) opened->api->Drain();
  // One end for both, whichever is held last.
  auto* both = new std::pair(opened->school, opened->api);
  const std::shared_ptr<std::remove_pointer_t<decltype(both)>> held(
      both, [ended = ended_](auto* last) {
        MutexLock end_lock(ended->mutex);
        ended->all.emplace_back(last);
      });
  served.school = PartOf(held, opened->school.get());
  served.api = PartOf(held, opened->api.get());
  spdlog::info("school {} is served as {}", name, row.hosts.front());
}

void Schools::EndThose() {
  decltype(Ended::all) all;
  {
    MutexLock lock(ended_->mutex);
    all = std::move(ended_->all);
    ended_->all.clear();
  }
  // The Api's threads first, which touch the store.
  for (const auto& one : all) {
    one->second->EndWork();
    one->first->StopJobs();
  }
}

std::vector<Schools::Served> Schools::Listed() const {
  MutexLock lock(mutex_);
  std::vector<Served> out;
  for (const auto& [name, served] : served_) out.push_back(served);
  return out;
}

std::optional<http::OtherSchool> Schools::AtHost(const std::string& host) {
  MutexLock lock(mutex_);
  if (!read_) return http::OtherSchool{};
  for (const auto& [name, served] : served_) {
    if (std::ranges::count(served.row.hosts, host) == 0) continue;
    http::OtherSchool out;
    out.api = served.api;
    out.suspended = served.row.state != SchoolState::kServed;
    if (served.school) out.ended = PartOf(served.school, &served.school->ended());
    return out;
  }
  return std::nullopt;
}

Result<std::shared_ptr<stations::Services>> Schools::ServicesOf(const wire::Request& first) {
  const std::shared_ptr<stations::Services> own;
  const std::vector<Served> all = Listed();
  if (all.empty() || !(first.has_hello() || first.has_enrol())) return own;
  // If the own store fails, the answer to the request reports it.
  const auto here = Knows(store_.stations, first);
  if (!here.ok() || *here == Acquaintance::kKnows) return own;
  bool missing = false;
  std::shared_ptr<School> knows_of;
  for (const Served& served : all) {
    const auto known = served.school ? Knows(served.school->store().stations, first)
                                     : Result<Acquaintance>(Status(Code::kUnavailable, ""));
    if (!known.ok()) {
      missing = true;
    } else if (*known == Acquaintance::kKnows) {
      return PartOf(served.school, &served.school->services());
    } else if (*known == Acquaintance::kKnowsOf) {
      knows_of = served.school;
    }
  }
  if (missing) {
    // The station may belong to that school. It keeps its recordings until the school is back.
    return Status(Code::kUnavailable,
                  "no school that can be reached admits this station; it may belong to a school "
                  "that is suspended or cannot be reached. Nothing is lost; try again later");
  }
  if (*here == Acquaintance::kNone && knows_of) {
    return PartOf(knows_of, &knows_of->services());
  }
  return own;
}

std::vector<std::shared_ptr<stations::Services>> Schools::All() {
  std::vector<std::shared_ptr<stations::Services>> out;
  for (const Served& served : Listed()) {
    if (served.school) out.push_back(PartOf(served.school, &served.school->services()));
  }
  return out;
}

void Schools::Drain() {
  MutexLock lock(mutex_);
  draining_ = true;
  for (const auto& [name, served] : served_) {
    if (served.api) served.api->Drain();
  }
}

void Schools::StopWaiting() {
  for (const Served& served : Listed()) {
    if (served.school) served.school->store().StopWaiting();
  }
}

}  // namespace enamel::server::app

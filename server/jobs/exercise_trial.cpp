#include "server/jobs/exercise_trial.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/scene/json/json.h"
#include "common/scene/prepared_target.h"
#include "common/scene/volume_blob.h"
#include "server/ops/yield_to_others.h"

namespace enamel::server {
namespace {

Status NoSuchTrial() {
  return {Code::kNotFound, "this trial does not exist any more; try the exercise again"};
}

}  // namespace

Result<scoring::Trial> TryStored(StoredBlobs& blobs, scene::Exercise exercise,
                                 const std::function<bool(double)>& progress) {
  auto fetch = [&](const Sha256& hash) { return blobs.GetBlob(hash); };
  ENAMEL_ASSIGN_OR_RETURN(const auto text, fetch(exercise.scene));
  ENAMEL_ASSIGN_OR_RETURN(const auto scene, scene::SceneFromJson(AsText(text)));
  ENAMEL_ASSIGN_OR_RETURN(const auto blob, fetch(scene.volume));
  ENAMEL_ASSIGN_OR_RETURN(const auto initial, scene::DecodeVolume(blob));
  ENAMEL_RETURN_IF_ERROR(scene::LoadPreparedTarget(initial, fetch, exercise.target));
  return scoring::TryExercise(scene, exercise, initial, progress);
}

ExerciseTrials::~ExerciseTrials() {
  std::jthread last;
  {
    MutexLock lock(mutex_);
    last = std::move(thread_);
  }
  // Stops and joins, without the lock that it takes.
}

Result<ExerciseTrials::About> ExerciseTrials::Begin(const Uuid& person, scene::Exercise exercise) {
  MutexLock lock(mutex_);
  std::erase_if(entries_, [&](const Entry& entry) { return entry.person == person; });
  const auto waiting = std::ranges::count(entries_, State::kWaiting,
                                          [](const Entry& entry) { return entry.about.state; });
  if (static_cast<size_t>(waiting) >= kMaxWaiting) {
    return Status(Code::kUnavailable,
                  "too many exercises are being tried; try again in some minutes");
  }
  Entry entry{person, std::move(exercise), {}};
  entry.about.id = Uuid::New();
  entries_.push_back(std::move(entry));
  if (!thread_.joinable()) {
    thread_ = std::jthread([this](const std::stop_token& stop) { Loop(stop); });
  }
  wake_.notify_one();
  return AboutOf(entries_.back());
}

Result<ExerciseTrials::About> ExerciseTrials::Get(const Uuid& person, const Uuid& id) const {
  MutexLock lock(mutex_);
  for (const Entry& entry : entries_) {
    if (entry.about.id == id && entry.person == person) return AboutOf(entry);
  }
  return NoSuchTrial();
}

Status ExerciseTrials::GiveUp(const Uuid& person, const Uuid& id) {
  MutexLock lock(mutex_);
  const auto gone = std::erase_if(
      entries_, [&](const Entry& entry) { return entry.about.id == id && entry.person == person; });
  return gone > 0 ? Status::Ok() : NoSuchTrial();
}

ExerciseTrials::About ExerciseTrials::AboutOf(const Entry& entry) const {
  About about = entry.about;
  for (const Entry& other : entries_) {
    if (&other == &entry) break;
    about.ahead += other.over() ? 0 : 1;
  }
  return about;
}

const ExerciseTrials::Entry* ExerciseTrials::Next() const {
  for (const Entry& entry : entries_) {
    if (entry.about.state == State::kWaiting) return &entry;
  }
  return nullptr;
}

ExerciseTrials::Entry* ExerciseTrials::Find(const Uuid& id) {
  for (Entry& entry : entries_) {
    if (entry.about.id == id) return &entry;
  }
  return nullptr;
}

bool ExerciseTrials::Note(const Uuid& id, double share) {
  MutexLock lock(mutex_);
  Entry* entry = Find(id);
  if (entry == nullptr) return false;
  entry->about.state = State::kWorking;
  entry->about.share = share;
  return true;
}

void ExerciseTrials::Finish(const Uuid& id, Result<scoring::Trial> trial, double took_s) {
  MutexLock lock(mutex_);
  Entry* entry = Find(id);
  if (entry == nullptr) return;
  entry->about.state = trial.ok() ? State::kDone : State::kFailed;
  entry->about.took_s = took_s;
  entry->exercise = {};
  if (trial.ok()) {
    entry->about.trial = std::move(*trial);
  } else {
    entry->about.problem = trial.status();
  }
  // The oldest go first; their readers have long seen them.
  while (entries_.size() > kMaxKept + kMaxWaiting && entries_.front().over()) {
    entries_.pop_front();
  }
}

void ExerciseTrials::Loop(const std::stop_token& stop) {
  using Clock = std::chrono::steady_clock;
  ops::YieldToOthers();
  while (!stop.stop_requested()) {
    Uuid id;
    scene::Exercise exercise;
    {
      MutexLock lock(mutex_);
      wake_.wait(mutex_, stop, [this]() ENAMEL_REQUIRES(mutex_) { return Next() != nullptr; });
      const Entry* next = Next();
      if (stop.stop_requested() || next == nullptr) return;
      id = next->about.id;
      exercise = next->exercise;
    }
    const auto begin = Clock::now();
    auto trial = TryStored(blobs_, std::move(exercise),
                           [&](double share) { return !stop.stop_requested() && Note(id, share); });
    if (stop.stop_requested()) return;
    Finish(id, std::move(trial), std::chrono::duration<double>(Clock::now() - begin).count());
  }
}

const char* StateName(ExerciseTrials::State state) {
  switch (state) {
    case ExerciseTrials::State::kWaiting:
      return "waiting";
    case ExerciseTrials::State::kWorking:
      return "working";
    case ExerciseTrials::State::kDone:
      return "done";
    case ExerciseTrials::State::kFailed:
      return "failed";
  }
  return "";
}

}  // namespace enamel::server

#pragma once

#include <condition_variable>
#include <list>
#include <optional>
#include <stop_token>
#include <thread>

#include "common/base/mutex.h"
#include "common/base/result.h"
#include "common/scoring/trial.h"
#include "server/storage/store.h"

namespace enamel::server {

// The trial of an exercise that this school could publish (scoring::TryExercise), with the tooth
// read from the store. `progress` as there. Errors: those of the store and of TryExercise.
Result<scoring::Trial> TryStored(StoredBlobs& blobs, scene::Exercise exercise,
                                 const std::function<bool(double)>& progress = {});

// Tries drafts on a thread of its own, which yields to others: one at a time, in the order in which
// they came. A person has one, so nobody waits for more than one of each other person; the next one
// ends it. The outcome can be read until then, or until kMaxKept newer ones are done.
//
// Thread safety: any thread. The destructor ends the trial that runs, within a step of its
// measuring.
class ExerciseTrials {
 public:
  static constexpr size_t kMaxWaiting = 16;  // five minutes of the costliest built-in exercise
  static constexpr size_t kMaxKept = 64;

  enum class State { kWaiting, kWorking, kDone, kFailed };
  struct About {
    Uuid id;
    State state = State::kWaiting;
    size_t ahead = 0;  // others that come first
    double share = 0;  // of the work
    double took_s = 0;
    std::optional<scoring::Trial> trial;  // once done
    Status problem;                       // once failed
  };

  explicit ExerciseTrials(StoredBlobs& blobs) : blobs_(blobs) {}
  ~ExerciseTrials();
  ExerciseTrials(const ExerciseTrials&) = delete;
  ExerciseTrials& operator=(const ExerciseTrials&) = delete;

  // Errors: kUnavailable while kMaxWaiting others wait.
  Result<About> Begin(const Uuid& person, scene::Exercise exercise);
  // Errors: kNotFound, also for another person's.
  Result<About> Get(const Uuid& person, const Uuid& id) const;
  // Ends and forgets it. Errors: as Get.
  Status GiveUp(const Uuid& person, const Uuid& id);

 private:
  struct Entry {
    Uuid person;
    scene::Exercise exercise;
    About about;
    bool over() const { return about.state == State::kDone || about.state == State::kFailed; }
  };
  using Entries = std::list<Entry>;  // in the order in which they came

  void Loop(const std::stop_token& stop);
  const Entry* Next() const ENAMEL_REQUIRES(mutex_);  // none waits: nullptr
  Entry* Find(const Uuid& id) ENAMEL_REQUIRES(mutex_);
  About AboutOf(const Entry& entry) const ENAMEL_REQUIRES(mutex_);
  // False once it was given up.
  bool Note(const Uuid& id, double share);
  void Finish(const Uuid& id, Result<scoring::Trial> trial, double took_s);

  StoredBlobs& blobs_;
  mutable Mutex mutex_;
  std::condition_variable_any wake_;
  Entries entries_ ENAMEL_GUARDED_BY(mutex_);
  std::jthread thread_ ENAMEL_GUARDED_BY(mutex_);  // from the first Begin on
};

const char* StateName(ExerciseTrials::State state);

}  // namespace enamel::server

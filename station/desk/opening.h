#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/base/fd.h"
#include "common/language/words.h"
#include "station/desk/background_task.h"
#include "station/session/workplace.h"

namespace enamel::station::desk {

// Field of the error when another window uses the folder.
inline constexpr char kWindowOpen[] = "window_open";

// Why the station cannot be used, for the student and for the administrator.
struct OpeningProblem {
  // The first three in the reader's language; the last in English, like commands and log.
  std::string what;       // what is wrong
  std::string safe;       // what is not lost
  std::string todo;       // what the student can do
  std::string operators;  // what the program found, and the commands that repair it
};
OpeningProblem OpeningProblemOf(const language::Words& words, const Status& problem,
                                const std::filesystem::path& data);

// Opens a window's workplace, which may fail at first (not enrolled, a damaged spool, a disk that
// cannot be written). Gives the reason and tries again on request. One window at a time uses a
// folder: another is refused (kConflict, field kWindowOpen) until this is destroyed or its program
// ends in any way. Commands are not windows. Thread safety: the window's thread.
class Opening {
 public:
  // Tries at once, and waits for the disk.
  explicit Opening(WorkplaceOptions options);

  // Null until opened.
  Workplace* workplace() { return workplace_.get(); }
  // Error of the last try, or ok.
  const Status& problem() const { return problem_; }
  OpeningProblem explained(const language::Words& words) const {
    return OpeningProblemOf(words, problem_, options_.data);
  }
  // For the operator's panel: the facts available despite the problem.
  std::vector<std::string> Lines() const;

  void TryAgain();
  bool busy() const { return task_.busy(); }
  void Tick() { task_.Poll(); }  // once a frame

 private:
  Status Lock();

  const WorkplaceOptions options_;
  std::unique_ptr<Fd> lock_;  // of the folder, for windows
  Status problem_;
  std::unique_ptr<Workplace> workplace_;
  BackgroundTask task_;
};

}  // namespace enamel::station::desk

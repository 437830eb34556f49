#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/language/words.h"
#include "station/desk/background_task.h"
#include "station/session/workplace.h"

namespace enamel::station::desk {

// Why the station cannot be used, for who sits at it and for who looks after it.
struct OpeningProblem {
  // The first three in the reader's language; the last in English, as commands and log are.
  std::string what;       // is wrong
  std::string safe;       // what nobody has to fear for
  std::string todo;       // by who sits here
  std::string operators;  // what the program found, and the commands that mend it
};
OpeningProblem OpeningProblemOf(const language::Words& words, const Status& problem,
                                const std::filesystem::path& data);

// The way to a workplace where it cannot be opened at once (not enrolled, a damaged spool, a disk
// that cannot be written): why, and again as often as somebody asks. Thread safety: the window's
// thread.
class Opening {
 public:
  // Tries at once, and waits for the disk.
  explicit Opening(WorkplaceOptions options);

  // Null until it could be opened.
  Workplace* workplace() { return workplace_.get(); }
  // Of the last try, or ok.
  const Status& problem() const { return problem_; }
  OpeningProblem explained(const language::Words& words) const {
    return OpeningProblemOf(words, problem_, options_.data);
  }
  // For the operator's panel: what is there, whatever is wrong.
  std::vector<std::string> Lines() const;

  void TryAgain();
  bool busy() const { return task_.busy(); }
  void Tick() { task_.Poll(); }  // once a frame

 private:
  const WorkplaceOptions options_;
  Status problem_;
  std::unique_ptr<Workplace> workplace_;
  BackgroundTask task_;
};

}  // namespace enamel::station::desk

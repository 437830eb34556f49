#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/storage/actor.h"
#include "server/training/types.h"

namespace enamel::server {

// Corrections of the rubric of an exercise that is published. The exercise's document, and with it
// every recording that names it, stays as it is; scores name the rubric's version.
// A part of Store (store.h), which says what holds for all parts.
class RubricStore {
 public:
  virtual ~RubricStore() = default;

  // What counts now. None: the rubric in the exercise's document.
  virtual Result<std::optional<RubricRow>> RubricFor(const Uuid& exercise) = 0;
  virtual Result<std::vector<RubricRow>> Rubrics(const Uuid& exercise) = 0;  // newest first
  // Exercise, version, content (a stored blob) and reason of `row` count. Scores that are there
  // stay until they are made again. Errors: kNotFound (exercise, blob), kConflict with field kStale
  // (version is not one more than the newest correction's: somebody else was first), without one (a
  // draft, which is edited instead; the newest correction says the same).
  virtual Result<RubricRow> PublishRubric(const RubricRow& row, const Actor& by) = 0;
};

}  // namespace enamel::server

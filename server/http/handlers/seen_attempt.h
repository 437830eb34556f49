#pragma once

#include <span>

#include "common/base/result.h"
#include "server/http/caller.h"
#include "server/http/routes.h"

namespace enamel::server::http {

// An attempt the caller may see, with the facts that access.h needs.
struct SeenAttempt {
  AttemptRow row;
  bool teaches = false;
  bool graded = true;
};
// Errors: kNotFound, the same for a missing attempt and one that the caller may not see.
Result<SeenAttempt> SeeAttempt(const Call& call, Store& store, const Uuid& attempt);
// The same for callers who may also review it (CanReviewAttempt); kForbidden for others.
Result<SeenAttempt> ReviewAttempt(const Call& call, Store& store, const Uuid& attempt);

// Narrows an instructor's list to the attempts that SeeAttempt would open.
void NarrowToTaught(const Call& call, AttemptFilter& filter);

// Whether `attempt` is its exercise's reference and the caller may play it back (CanSeeReferenceCut).
// The rest of that attempt stays hidden. Looks at the caller's newest 200 scored attempts. Errors: the store's.
Result<bool> IsCallersReference(const Call& call, Store& store, const Uuid& attempt);

// kForbidden while the caller marks one of the attempts blind: until all of its markers are done.
Status ScoresMustNotBeHidden(const Call& call, Store& store, std::span<const Uuid> attempts);
inline Status ScoreMustNotBeHidden(const Call& call, Store& store, const Uuid& attempt) {
  return ScoresMustNotBeHidden(call, store, {&attempt, 1});
}

// kConflict, with its state.
Status RequireScored(const AttemptRow& row);

}  // namespace enamel::server::http

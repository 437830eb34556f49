#pragma once

#include "common/base/sha256.h"
#include "common/scoring/score.h"

namespace enamel::server {

// Of points and reasons alone, as schemas/result.md writes them: equal for two scores that differ
// in what was measured besides, or by which version of the metrics.
Sha256 JudgementOf(const scoring::ScoreResult& score);

}  // namespace enamel::server

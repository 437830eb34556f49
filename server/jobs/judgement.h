#pragma once

#include "common/base/sha256.h"
#include "common/scoring/score.h"

namespace enamel::server {

// The hash of points and reasons alone, as schemas/result.md defines it: equal for two scores that
// differ only in other measurements, or in the version of the metrics.
Sha256 JudgementOf(const scoring::ScoreResult& score);

}  // namespace enamel::server

#include "server/jobs/marked_work.h"

#include <string>

#include "server/agreement/standard.h"
#include "server/jobs/regrade.h"

namespace enamel::server {

Result<std::vector<ScoredWork>> ScoredUnder(Store& store, const Uuid& assignment) {
  AttemptFilter which;
  which.assignment = assignment;
  ENAMEL_ASSIGN_OR_RETURN(auto rows, ScoredAttempts(store.attempts, which));
  std::vector<ScoredWork> out;
  for (const AttemptRow& row : rows) {
    ENAMEL_ASSIGN_OR_RETURN(auto score, StoredScore(store.blobs, store.results, row.id));
    out.push_back({row.id, std::move(score)});
  }
  if (out.empty()) {
    return Status(Code::kNotFound, "no scored attempt under assignment " + assignment.Text() +
                                       "; enamel-server admin list-assignments shows their ids");
  }
  return out;
}

std::vector<Mark> ComputedMarks(const std::vector<ScoredWork>& works) {
  std::vector<Mark> out;
  const std::string marker(kComputed);
  for (const ScoredWork& work : works) {
    // Examiners mark a criterion without knowing the gates, so the gates are divided out. With a
    // closed gate the points before it are unknown.
    double share = 1;
    for (const auto& gate : work.score.gates) share *= gate.share;
    for (const auto& c : work.score.criteria) {
      if (!c.judged || share <= 0) continue;
      out.push_back({work.attempt.Text(), c.title, marker, c.points / share, c.max_points});
    }
    out.push_back(
        {work.attempt.Text(), std::string(kTotalCriterion), marker, work.score.score, 100});
  }
  return out;
}

}  // namespace enamel::server

#include "server/jobs/marked_work.h"

#include <algorithm>
#include <iterator>
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

std::vector<scoring::CriterionResult> MarkedGroups(const scoring::ScoreResult& score) {
  std::vector<scoring::CriterionResult> out;
  std::ranges::copy_if(score.criteria, std::back_inserter(out), [](const auto& criterion) {
    return criterion.group != scoring::Group::kHand;
  });
  return out;
}

std::vector<Mark> ComputedMarks(const std::vector<ScoredWork>& works) {
  std::vector<Mark> out;
  const std::string marker(kComputed);
  for (const ScoredWork& work : works) {
    for (const scoring::CriterionResult& group : MarkedGroups(work.score)) {
      // A group may cost more than a person can take off for it.
      const double points = std::max(0.0, group.most - group.lost);
      out.push_back({work.attempt.Text(), group.title, marker, points, group.most});
    }
    out.push_back(
        {work.attempt.Text(), std::string(kTotalCriterion), marker, work.score.score, 100});
  }
  return out;
}

}  // namespace enamel::server

#include "server/training/grade.h"

#include <algorithm>

namespace enamel::server {
namespace {

// Requires: not empty.
double MeanOf(const std::vector<double>& values) {
  double sum = 0;
  for (double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

// Requires: not empty.
double MedianOf(std::vector<double> values) {
  std::ranges::sort(values);
  const size_t middle = values.size() / 2;
  if (values.size() % 2 == 1) return values[middle];
  return (values[middle - 1] + values[middle]) / 2;
}

}  // namespace

Grade GradeOver(Counting counting, std::vector<GradedAttempt> attempts) {
  // By time and then by id, so that the order in which they were read changes nothing.
  std::ranges::sort(attempts, [](const GradedAttempt& a, const GradedAttempt& b) {
    return a.ticketed_ms != b.ticketed_ms ? a.ticketed_ms < b.ticketed_ms : a.id < b.id;
  });
  Grade out;
  out.attempts = static_cast<uint32_t>(attempts.size());
  out.regrading = std::ranges::any_of(attempts, &GradedAttempt::again);
  const bool unknown = std::ranges::any_of(
      attempts, [](const GradedAttempt& attempt) { return attempt.again && !attempt.score; });
  std::erase_if(attempts, [](const GradedAttempt& attempt) { return !attempt.score; });
  out.counted = static_cast<uint32_t>(attempts.size());
  if (attempts.empty() || unknown) return out;
  out.shown = std::ranges::all_of(attempts, &GradedAttempt::shown);
  std::vector<double> scores;
  for (const GradedAttempt& attempt : attempts) scores.push_back(*attempt.score);
  const GradedAttempt* one = nullptr;
  switch (counting) {
    case Counting::kBest:
      one = &attempts[static_cast<size_t>(std::ranges::max_element(scores) - scores.begin())];
      break;
    case Counting::kLast:
      one = &attempts.back();
      break;
    case Counting::kMean:
      out.score = MeanOf(scores);
      break;
    case Counting::kMedian:
      out.score = MedianOf(scores);
      break;
  }
  if (one != nullptr) {
    out.score = *one->score;
    out.attempt = one->id;
  }
  return out;
}

GradeSummary SummaryOf(const std::vector<Grade>& grades) {
  GradeSummary out;
  out.students = static_cast<uint32_t>(grades.size());
  std::vector<double> scores;
  for (const Grade& grade : grades) {
    if (grade.score) scores.push_back(*grade.score);
  }
  out.graded = static_cast<uint32_t>(scores.size());
  if (scores.empty()) return out;
  out.mean = MeanOf(scores);
  out.median = MedianOf(scores);
  out.lowest = *std::ranges::min_element(scores);
  out.highest = *std::ranges::max_element(scores);
  return out;
}

}  // namespace enamel::server

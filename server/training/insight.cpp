#include "server/training/insight.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace enamel::server {
namespace {

constexpr size_t kFewest = 8;  // of fewer, one that stands out moves the median
constexpr double kFarZ = 3.5;
constexpr double kNormalMad = 0.6745;  // MAD of the standard normal distribution
// Its standard deviation over its mean absolute deviation: the square root of pi / 2.
constexpr double kPerMeanDeviation = 1.2533;

// A number of somebody's.
struct Of {
  size_t student;
  double value;
};

std::vector<double> ValuesOf(const std::vector<Of>& all) {
  std::vector<double> out;
  for (const Of& each : all) out.push_back(each.value);
  return out;
}

void CountTenth(double percent, Tenths& tenths) {
  ++tenths[static_cast<size_t>(std::clamp(std::floor(percent / 10), 0.0, 9.0))];
}

// Stands for the standard deviation; 0 where all values are equal.
double ScaleOf(const std::vector<double>& away) {
  if (const double mad = SpreadOf(away)->median; mad > 0) return mad / kNormalMad;
  const double sum = std::accumulate(away.begin(), away.end(), 0.0);
  return kPerMeanDeviation * sum / static_cast<double>(away.size());
}

void FindOutliers(const std::string& what, const std::vector<Of>& all, std::vector<Outlier>& out) {
  if (all.size() < kFewest) return;
  const double median = SpreadOf(ValuesOf(all))->median;
  std::vector<double> away;
  for (const Of& each : all) away.push_back(std::abs(each.value - median));
  const double scale = ScaleOf(away);
  if (scale == 0) return;
  for (const Of& each : all) {
    const double z = (each.value - median) / scale;
    if (std::abs(z) > kFarZ) out.push_back({each.student, what, each.value, median, z});
  }
}

// A criterion's figures while reading the students.
struct Gathered {
  CriterionInsight insight;
  std::vector<double> lost;
  std::vector<Of> values;
};

void Gather(const StudentWork& work, size_t student, std::vector<Gathered>& all) {
  for (const CriterionLost& criterion : work.criteria) {
    auto to = std::ranges::find(
        all, criterion.name,
        [](const Gathered& each) -> const std::string& { return each.insight.name; });
    if (to == all.end()) to = all.insert(to, Gathered{});
    CriterionInsight& insight = to->insight;
    insight.name = criterion.name;
    insight.group = criterion.group;
    insight.title = criterion.title;
    insight.unit = criterion.unit;
    if (!criterion.judged) continue;
    ++insight.judged;
    insight.to_change += criterion.to_change ? 1 : 0;
    to->lost.push_back(criterion.lost);
    if (criterion.value) to->values.push_back({student, *criterion.value});
  }
}

// What one student lost by the mistakes of one kind at one place, and the dearest of them.
struct MadeByOne {
  double points = 0;
  const MistakeMade* dearest = nullptr;
};
using KindAndPlace = std::pair<std::string, std::string>;
using MadeByClass = std::map<KindAndPlace, std::vector<MadeByOne>>;

void GatherMistakes(const StudentWork& work, MadeByClass& all) {
  std::map<KindAndPlace, MadeByOne> made;
  for (const MistakeMade& mistake : work.mistakes) {
    MadeByOne& to = made[{mistake.kind, mistake.place}];
    to.points += mistake.points;
    if (to.dearest == nullptr || mistake.points > to.dearest->points) to.dearest = &mistake;
  }
  for (const auto& [what, by_one] : made) {
    if (by_one.points >= kWorthTelling) all[what].push_back(by_one);
  }
}

// Requires: somebody made it.
MistakeInsight InsightInto(const std::vector<MadeByOne>& made) {
  const MistakeMade& any = *made.front().dearest;
  MistakeInsight out{any.kind, any.place, any.group, any.unit, 0, 0, 0, {}};
  out.students = static_cast<uint32_t>(made.size());
  std::vector<double> sizes;
  for (const MadeByOne& by_one : made) {
    out.points += by_one.points;
    sizes.push_back(by_one.dearest->size);
    for (size_t i = 0; i < out.at_mm.size(); ++i) out.at_mm[i] += by_one.dearest->at_mm[i];
  }
  for (double& coordinate : out.at_mm) coordinate /= static_cast<double>(made.size());
  out.size = SpreadOf(std::move(sizes))->median;
  return out;
}

std::vector<MistakeInsight> DearestFirst(const MadeByClass& all) {
  std::vector<MistakeInsight> out;
  for (const auto& [what, made] : all) out.push_back(InsightInto(made));
  std::ranges::stable_sort(out, std::ranges::greater{}, &MistakeInsight::points);
  return out;
}

std::optional<size_t> Commonest(const std::vector<MistakeInsight>& mistakes) {
  const auto found = std::ranges::max_element(mistakes, {}, &MistakeInsight::students);
  if (found == mistakes.end()) return std::nullopt;
  return static_cast<size_t>(found - mistakes.begin());
}

}  // namespace

std::optional<Spread> SpreadOf(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  std::ranges::sort(values);
  const auto at = [&](double share) {
    const double place = share * static_cast<double>(values.size() - 1);
    const auto below = static_cast<size_t>(place);
    const size_t above = std::min(below + 1, values.size() - 1);
    return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
  };
  return Spread{static_cast<uint32_t>(values.size()),
                values.front(),
                at(0.25),
                at(0.5),
                at(0.75),
                values.back()};
}

Insight InsightOf(const std::vector<StudentWork>& students) {
  Insight out;
  out.students = static_cast<uint32_t>(students.size());
  std::vector<Gathered> criteria;
  MadeByClass mistakes;
  std::vector<Of> scores, times;
  for (size_t i = 0; i < students.size(); ++i) {
    const StudentWork& work = students[i];
    if (work.attempts == 0) {
      ++out.not_started;
      continue;
    }
    times.push_back({i, work.time_s});
    if (!work.score) {
      ++out.waiting;
      continue;
    }
    ++out.scored;
    out.failed += work.failed ? 1 : 0;
    scores.push_back({i, *work.score});
    CountTenth(*work.score, out.score_tenths);
    Gather(work, i, criteria);
    GatherMistakes(work, mistakes);
  }
  out.scores = SpreadOf(ValuesOf(scores));
  out.times_s = SpreadOf(ValuesOf(times));
  out.mistakes = DearestFirst(mistakes);
  out.commonest = Commonest(out.mistakes);
  FindOutliers("score", scores, out.outliers);
  FindOutliers("time_all_attempts_s", times, out.outliers);
  for (Gathered& each : criteria) {
    FindOutliers(each.insight.name, each.values, out.outliers);
    each.insight.values = SpreadOf(ValuesOf(each.values));
    each.insight.lost = SpreadOf(each.lost);
    const double sum = std::accumulate(each.lost.begin(), each.lost.end(), 0.0);
    if (each.insight.judged > 0) each.insight.mean_lost = sum / each.insight.judged;
    out.criteria.push_back(std::move(each.insight));
  }
  std::ranges::stable_sort(out.outliers, [](const Outlier& a, const Outlier& b) {
    return a.student != b.student ? a.student < b.student : std::abs(a.z) > std::abs(b.z);
  });
  return out;
}

}  // namespace enamel::server

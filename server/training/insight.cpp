#include "server/training/insight.h"

#include <algorithm>
#include <cmath>
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
  double points = 0;
  double lost = 0;
  std::vector<Of> values;
};

Gathered& Named(std::vector<Gathered>& all, const CriterionPoints& criterion) {
  for (Gathered& each : all) {
    if (each.insight.name == criterion.name) return each;
  }
  all.push_back({});
  all.back().insight.name = criterion.name;
  all.back().insight.title = criterion.title;
  all.back().insight.unit = criterion.unit;
  return all.back();
}

void Gather(const StudentWork& work, size_t student, std::vector<Gathered>& all) {
  for (const CriterionPoints& criterion : work.criteria) {
    Gathered& to = Named(all, criterion);
    // A criterion worth nothing has no points to lose. A metric that was not measured has no value,
    // and its points are lost.
    if (criterion.max_points <= 0) continue;
    CriterionInsight& insight = to.insight;
    ++insight.judged;
    insight.max_points = std::max(insight.max_points, criterion.max_points);
    insight.half_lost += criterion.points <= criterion.max_points / 2 ? 1 : 0;
    CountTenth(100 * criterion.points / criterion.max_points, insight.earned);
    to.points += criterion.points;
    to.lost += criterion.max_points - criterion.points;
    if (criterion.judged) to.values.push_back({student, criterion.value});
  }
}

void GatherGates(const StudentWork& work, std::vector<GateInsight>& all) {
  for (const GateTaken& gate : work.gates) {
    if (gate.share >= 1) continue;
    auto found = std::ranges::find(all, gate.name, &GateInsight::name);
    if (found == all.end()) found = all.insert(all.end(), GateInsight{gate.name, gate.title, 0});
    ++found->taken;
  }
}

std::optional<size_t> Commonest(const std::vector<Gathered>& all) {
  std::optional<size_t> out;
  for (size_t i = 0; i < all.size(); ++i) {
    const auto rank = [&](size_t place) {
      return std::pair(all[place].insight.half_lost, all[place].lost);
    };
    if (all[i].insight.half_lost > 0 && (!out || rank(i) > rank(*out))) out = i;
  }
  return out;
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
    GatherGates(work, out.gates);
  }
  out.scores = SpreadOf(ValuesOf(scores));
  out.times_s = SpreadOf(ValuesOf(times));
  out.commonest = Commonest(criteria);
  FindOutliers("score", scores, out.outliers);
  FindOutliers("time_all_attempts_s", times, out.outliers);
  for (Gathered& each : criteria) {
    FindOutliers(each.insight.name, each.values, out.outliers);
    each.insight.values = SpreadOf(ValuesOf(each.values));
    if (each.insight.judged > 0) each.insight.mean_points = each.points / each.insight.judged;
    out.criteria.push_back(std::move(each.insight));
  }
  std::ranges::stable_sort(out.outliers, [](const Outlier& a, const Outlier& b) {
    return a.student != b.student ? a.student < b.student : std::abs(a.z) > std::abs(b.z);
  });
  return out;
}

}  // namespace enamel::server

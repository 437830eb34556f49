#pragma once

#include <boost/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/scene/builtin/builtin.h"
#include "common/scene/parts.h"
#include "station/lab/app/explain.h"
#include "station/lab/cutting/scene_cost.h"
#include "station/lab/suites/joint_front.h"

// The steps of ExplainScene. Private to explain*.cpp.
namespace enamel::station::lab {

// Enough for a p99 of six ticks; parts are measured a dozen times while somebody waits.
inline constexpr size_t kTicks = 600;
inline constexpr int kReplays = 5;
// In each round of cases that take turns: of each tick the shorter, or another program's turn would be in it.
inline constexpr int kRunsOfRound = 2;

// The subject of the explanation.
struct Explained {
  scene::BuiltScene built;
  scene::Exercise exercise;
  scene::DeviceProfile profile;
  core::CoreParams params;
};

Result<scene::BuiltScene> LoadAt(const ExplainCommand& options, int32_t voxel_nm);

// One line on a terminal that the next one replaces; lines elsewhere.
void ShowProgress(const std::string& what);
void EndProgress();

// Cost of a part: where it is kept, its cost; where it is left out, the cost it would have.
struct Worth {
  std::optional<Interval> ns_per_tick;
  std::optional<double> mb;
  std::string note;
  bool within_noise = false;  // nobody can tell the cost from the plan's difference from itself
};

// Every part with its worth (explain_parts.cpp).
struct Appraisal {
  StepCost base;
  Interval noise_ns;  // the plan against itself, measured as a part is
  double volume_mb = 0;
  std::vector<std::pair<scene::Part, Worth>> rows{};
};
Appraisal Appraise(const Explained& subject, std::vector<scene::Part> parts);

// What fits a tick of options.budget_us (explain_budget.cpp): prints it and adds it to `out`.
// Errors: kUnavailable when nothing does.
Status DecideBudget(const ExplainCommand& options, const Explained& subject, const StepCost& base,
                    boost::json::object& out);

}  // namespace enamel::station::lab

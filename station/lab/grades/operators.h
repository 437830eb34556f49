#pragma once

#include <boost/json/fwd.hpp>
#include <functional>
#include <string>
#include <vector>

#include "common/base/result.h"

// Whether scores rank skill: the eight simulated people of devices/operators.h with a published
// rank cut and are graded against the dentist among them. The less skilled err more and more often
// (devices/mistakes.h). Document:
// schemas/lab_operators.schema.json. Thread safety: functions, any thread. Blocks.
namespace enamel::station::lab {

struct OperatorsOptions {
  int32_t voxel_nm = 100'000;
  std::vector<std::string> devices = {"omega3", "phantom_desktop"};
  std::vector<uint64_t> seeds = {0, 101};  // of tremor and mistakes; 0: each operator's own
  std::vector<std::string> exercises;      // names or their beginnings; empty: all they can cut
  std::vector<std::string> operators;      // of those with a rank; empty: all eight
  bool quick = false;                      // the first device and seed
};

struct OperatorRow {
  std::string exercise, device, name;
  int rank = 0;
  uint64_t seed = 0;
  bool critical_fail = false;
  double score = 0;
};
// Spearman's correlation of rank and score over all of an exercise's rows on one device. Work that
// is not acceptable has the score 0, the lowest there is, and is not left out.
struct SkillOrder {
  std::string exercise, device;
  size_t rows = 0;
  double spearman = 0;
};

// An operator who has no plan for an exercise on a device.
struct LeftOut {
  std::string exercise, device, name;
};

// Difference of one operator's mean scores on the devices, over the same seeds on each: the same
// skill should get the same grade. Excludes seeds with a critical failure on any device.
struct EqualSkill {
  std::string exercise, name;
  size_t seeds = 0;
  double points = 0;  // the highest mean less the lowest
};

struct OperatorsFindings {
  std::vector<OperatorRow> rows;
  std::vector<SkillOrder> order;
  std::vector<EqualSkill> equal_skill;  // none with fewer than two devices
  std::vector<std::string> not_cut;     // exercises no simulated person can do yet
  std::vector<LeftOut> left_out;
};

// Spearman's rank correlation, ties at their mean rank; 0 where all of one side are equal.
// Requires: equally long.
double Spearman(const std::vector<double>& a, const std::vector<double>& b);

// For rows in any order; exercises and operators in the order in which they first appear.
std::vector<EqualSkill> EqualSkillOf(const std::vector<OperatorRow>& rows);

// How many of one operator's rows have all 100 points, to two decimals.
struct FullMarks {
  size_t full = 0, rows = 0;
};
FullMarks FullMarksOf(const std::vector<OperatorRow>& rows, const std::string& name);

// `row` is called with each row as it comes, `progress` (what, 0..1) between them; both may be
// empty. Errors: kNotFound when no device, exercise or operator has such a name; those of the scene's
// builder.
Result<OperatorsFindings> MeasureOperators(
    const OperatorsOptions& options, const std::function<void(const OperatorRow&)>& row = {},
    const std::function<void(const std::string&, double)>& progress = {});

boost::json::object OperatorsJson(const OperatorsFindings& findings);

}  // namespace enamel::station::lab

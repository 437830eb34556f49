#pragma once

#include <boost/json/fwd.hpp>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "station/lab/grades/hollow.h"

// Tries the laws that no grade may break on random mixtures of faults: cuts a fault larger, or a
// further one, and measures and prices the new volume by the exercise's own rubric. Thread safety:
// functions, any thread. Blocks.
namespace enamel::station::lab {

struct MixturesOptions {
  int count = 60;  // of all exercises together, in turn
  // So many more grids, parts of a voxel apart, in which the tooth, its task and each mixture are made anew.
  int offsets = 0;
  uint64_t seed = 1;
  std::vector<int32_t> voxels_nm = {100'000};
  std::vector<std::string> exercises;  // names or their beginnings; empty: all built in
};

struct MixtureRow {
  std::string exercise;
  double voxel_mm = 0;
  uint64_t seed = 0;
  std::vector<std::string> faults;  // what was done
  std::vector<std::string> missed;  // faults that were asked for and not found
  double score = 0;
  std::vector<double> larger;  // the score with each fault made larger
  double further = 0;          // with one more
  double offset_spread = 0;    // of the scores at all offsets, the largest less the smallest
  double exact = 0;            // of the task itself
  double sum_error = 0;        // |points of the mistakes - points lost|, the largest of all
  // Faults that alone cost a point. A fault is found where a mistake of the mixture is on its side, at a
  // region that the fault reached.
  size_t asked = 0, found = 0;
  // Mistakes of the mixture that cost a point and more. One is invented where no fault of its side
  // reached its place.
  size_t mistakes = 0, invented = 0;
  double lost = 0, uneven = 0;      // points of all mistakes, and of those that nothing explains
  size_t sentences = 0;             // said of all these cuts
  std::vector<std::string> wrong;   // those that are false (sentences.h)
  std::vector<std::string> broken;  // laws, in words
};

// `row` is called with each row as it comes, `progress` (what, 0..1) between them; both may be empty.
// Errors: kNotFound when no exercise has such a name; those of the scenes' builder and of scoring::JudgeCut.
Result<std::vector<MixtureRow>> TryMixtures(
    const MixturesOptions& options, const std::function<void(const MixtureRow&)>& row = {},
    const std::function<void(const std::string&, double)>& progress = {});

boost::json::object MixturesJson(const std::vector<MixtureRow>& rows);

}  // namespace enamel::station::lab

#pragma once

#include <functional>

#include "common/scene/calibration.h"
#include "station/lab/suites/findings.h"
#include "station/lab/suites/options.h"

// The suites. Each adds to Findings; all are deterministic except for nanoseconds.
namespace enamel::station::lab {

// Reports progress: what, done, of how many. May be called from several threads.
using Progress = std::function<void(const char*, size_t, size_t)>;

struct SuiteContext {
  const QualifyOptions& options;
  Findings& findings;
  Progress progress;
};

void RunPaperSuite(SuiteContext& context);
void RunLawsSuite(SuiteContext& context);
void RunEstimatorsSuite(SuiteContext& context);
void RunExtremeSuite(SuiteContext& context);
void RunAdversarySuite(SuiteContext& context);
void RunRandomSuite(SuiteContext& context);
void RunHandSuite(SuiteContext& context);
void RunMapSuite(SuiteContext& context);
void RunStrokesSuite(SuiteContext& context);
void RunPecksSuite(SuiteContext& context);
void RunWithdrawalSuite(SuiteContext& context);
void RunWatchSuite(SuiteContext& context);
void RunCalibrationSuite(SuiteContext& context);
void RunCuttingSuite(SuiteContext& context);
void RunFrontSuite(SuiteContext& context);

// Calls job(i) for i < n on `threads` threads, lowest first. `job` must not throw.
void ParallelFor(size_t n, int threads, const std::function<void(size_t)>& job);

// Runs the trial and fills in its measurements; the caller fills in names and nanoseconds.
Row RunRow(const DeviceModel& model, const TrialSpec& spec);
// Whether the theorem of coupling.h covers this law.
bool ProvedLaw(haptics::LawKind law);
// Whether the theorem of coupling.h covers this trial: an anchored law, Kc and c within the
// profile's.
bool Proved(const TrialSpec& spec);
// Cost of law, estimator and output chain, least of several repeats, ns.
double NanosecondsPerTick(const TrialSpec& spec);
// Goals of a velocity hand's cut, per axis: max(floor, factor Kc delta / 2).
double ErrorGoal(const DeviceModel& model, double floor_n, double factor);

// A calibration document, with the path in its errors.
Result<scene::Calibration> CalibrationIn(const std::string& path);
// The largest Kc that the clauses allow at the bad end of each interval (scene/rate.h).
Table BadEnds(const scene::DeviceProfile& profile, const scene::Calibration& calibration);
// How the random suite draws: speeds uniformly; speeds logarithmically, which favours slow cuts;
// also the loop rate, 500 Hz to 8 kHz with Kc as at 1 kHz where that is passive; B as a matrix with
// axes of its own in any direction.
enum class Draw { kUniform, kSlow, kRates, kMatrix };
TrialSpec RandomCase(const DeviceModel& model, uint64_t seed, Draw draw);

}  // namespace enamel::station::lab

#include <stdlib.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "common/program/example.h"
#include "common/program/log.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "station/devices/operators.h"
#include "station/lab/bench/bench.h"
#include "station/lab/cutting/cutting_ticks.h"
#include "station/loop/tick_loop.h"
#include "station/spool/recorder.h"

// A working day's recording: its size on disk and in memory.
namespace enamel::station::lab::bench {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double kRecordRate_hz = 1000;
constexpr double kNoise_counts = 0.3;  // of the encoder, one sigma
constexpr double kGoalBytesPerTick = 12, kGoalMbPer8h = 350;

struct RecordOptions {
  double hours = 8;
  int voxel_um = 50;
  std::string profile = "phantom_desktop";
  std::string operator_name = "student";
  std::string folder, json;
};

double Resident_mb() {
  std::ifstream in("/proc/self/statm");
  long total = 0, resident = 0;
  in >> total >> resident;
  return static_cast<double>(resident) * static_cast<double>(::sysconf(_SC_PAGESIZE)) * 1e-6;
}

// The simulated device, its encoder read with noise. After its operator has finished, a hand that
// waits in the air, trembling, while the attempt has cut for more than a third of its time.
class NoisyDevice final : public Device {
 public:
  NoisyDevice(Device& inner, double sigma_counts, uint32_t seed)
      : inner_(inner), sigma_(sigma_counts), random_(seed) {}

  std::string Name() const override { return "noisy"; }
  Hand hand() const override { return inner_.hand(); }
  DeviceSample ReadSample() noexcept override {
    // Once its operator has finished, the simulated device is not called any more: it would end the
    // attempt.
    DeviceSample sample = waiting_ ? held_ : inner_.ReadSample();
    if (!waiting_ && (sample.buttons & kFinish) != 0) {
      waiting_ = true;
      sample.buttons = 0;
      held_ = sample;
    }
    ++ticks_;
    for (size_t i = 0; i < 3; ++i) {
      double tremor = waiting_ ? 2 * std::sin(0.063 * static_cast<double>(ticks_) *
                                              (1 + 0.1 * static_cast<double>(i)))
                               : 0;
      // Recordings of a noiseless encoder would pack far better than any real device's.
      sample.counts[i] += static_cast<int32_t>(std::lround(tremor + sigma_ * normal_(random_)));
    }
    return sample;
  }
  void SendForce(const dvec3& force_n) noexcept override { inner_.SendForce(force_n); }
  void ShowBur(const dvec3& tip_m) noexcept override { inner_.ShowBur(tip_m); }
  bool waiting() const { return waiting_; }

 private:
  Device& inner_;
  const double sigma_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  uint64_t ticks_ = 0;
  bool waiting_ = false;
  DeviceSample held_;
};

class CutCounter final : public TickObserver {
 public:
  void OnTick(const core::Core&, const Snapshot& snapshot) noexcept override {
    ticks_.Add(snapshot.removed != before_);
    before_ = snapshot.removed;
  }
  uint64_t cutting() const { return ticks_.cutting(); }

 private:
  CuttingTicks ticks_{static_cast<uint32_t>(kRecordRate_hz)};
  cutting::RemovedUnits before_{};
};

struct Totals {
  uint64_t ticks = 0, cutting = 0, bytes = 0;
  int attempts = 0;
};

struct World {
  scene::BuiltScene built;
  scene::Exercise exercise;
  scene::DeviceProfile profile;
  core::CoreParams params;
};

Result<World> Load(const RecordOptions& options) {
  ENAMEL_ASSIGN_OR_RETURN(auto built, scene::BuildBuiltinScene("molar", options.voxel_um * 1000));
  World w{std::move(built), {}, {}, {}};
  w.exercise =
      scene::ClassOneExercise(w.built.scene, HashSha256(AsBytes(scene::ToJson(w.built.scene))));
  bool found = false;
  for (const scene::DeviceProfile& p : scene::BuiltinProfiles()) {
    if (p.name != options.profile) continue;
    w.profile = p;
    found = true;
  }
  if (!found) return Status(Code::kNotFound, "no device profile '" + options.profile + "'");
  ENAMEL_ASSIGN_OR_RETURN(auto params, scene::CompilePlan(w.built.scene, w.exercise, w.profile));
  w.params = params;
  return w;
}

// One attempt into the spool; `most` ticks at most.
Status Attempt(const World& w, const RecordOptions& options, Spool& spool, uint64_t most,
               Totals& totals) {
  const auto seed = static_cast<uint32_t>(totals.attempts + 1);
  const OperatorPreset* preset = FindOperator(options.operator_name);
  if (preset == nullptr)
    return Status(Code::kNotFound, "no operator '" + options.operator_name + "'");
  ENAMEL_ASSIGN_OR_RETURN(
      auto device, MakeSimulatedDevice(*preset, w.built.scene, w.exercise, w.profile, w.params,
                                       w.built.volume, seed));
  NoisyDevice noisy(*device, kNoise_counts, seed);
  trace::Header header;
  // Each attempt is separate in the spool, as on a station.
  header.ticket.attempt = Uuid::New();
  header.params = w.params;
  header.station_software = "enamel-lab";
  header.hand.kind = HandKind::kProgram;
  ENAMEL_RETURN_IF_ERROR(spool.BeginAttempt(header, w.exercise.name, w.profile.name));
  core::Core core(w.params, w.built.volume);
  SampleRing ring(4 * Recorder::kTicksPerChunk);
  CutCounter cuts;
  TickLoop loop(noisy, core, ring, {.lockstep = true, .faults_when_late = false}, &cuts);
  Recorder recorder(spool, ring, header.ticket.attempt, HashSha256(trace::EncodeHeader(header)),
                    trace::NewKeyPair().secret_key);
  uint64_t ticks = 0;
  // A third of the ticks cut; pure cutting would take too much space.
  while (ticks < most && (!noisy.waiting() || cuts.cutting() * 3 > ticks)) {
    loop.Tick();
    // The recorder runs on this thread: it packs when a chunk is full, as on its own.
    if (++ticks % Recorder::kTicksPerChunk != 0) continue;
    ENAMEL_RETURN_IF_ERROR(recorder.Pump().status());
  }
  ENAMEL_RETURN_IF_ERROR(recorder.Finish().status());
  ENAMEL_ASSIGN_OR_RETURN(auto stored, spool.Get(header.ticket.attempt));
  totals.ticks += stored.ticks;
  totals.bytes += stored.bytes;
  totals.cutting += cuts.cutting();
  ++totals.attempts;
  return Status::Ok();
}

double OnDisk_mb(const fs::path& folder) {
  uintmax_t bytes = 0;
  for (const auto& entry : fs::directory_iterator(folder)) bytes += entry.file_size();
  return static_cast<double>(bytes) * 1e-6;
}

Status MeasureRecord(const RecordOptions& options, const fs::path& folder, Rows& rows) {
  ENAMEL_ASSIGN_OR_RETURN(auto world, Load(options));
  ENAMEL_ASSIGN_OR_RETURN(auto spool, Spool::Open(folder));
  const auto most = static_cast<uint64_t>(options.hours * 3600 * kRecordRate_hz);
  // Eight lines, which would show memory that grows with time.
  const uint64_t step = std::max<uint64_t>(1, most / 8);
  std::printf("%7s %9s %11s %9s %9s %11s %9s\n", "hours", "attempts", "ticks", "cutting", "B/tick",
              "spool MB", "RSS MB");
  Totals totals;
  uint64_t next = step;
  Progress progress;
  auto begin = Clock::now();
  while (totals.ticks < most) {
    ENAMEL_RETURN_IF_ERROR(Attempt(world, options, *spool, most - totals.ticks, totals));
    progress.Show("recording", static_cast<double>(totals.ticks) / static_cast<double>(most));
    // Attempts vary in length: prints a line after each eighth.
    if (totals.ticks < next && totals.ticks < most) continue;
    while (next <= totals.ticks) next += step;
    progress.Clear();
    double hours = static_cast<double>(totals.ticks) / kRecordRate_hz / 3600;
    double per_tick = static_cast<double>(totals.bytes) / static_cast<double>(totals.ticks);
    double cutting = static_cast<double>(totals.cutting) / static_cast<double>(totals.ticks);
    double disk_mb = OnDisk_mb(folder), resident_mb = Resident_mb();
    std::printf("%7.2f %9d %11llu %8.1f%% %9.2f %11.1f %9.1f\n", hours, totals.attempts,
                static_cast<unsigned long long>(totals.ticks), 100 * cutting, per_tick, disk_mb,
                resident_mb);
    rows.Add({{"hours", hours},
              {"attempts", totals.attempts},
              {"ticks", totals.ticks},
              {"cutting_ratio", cutting},
              {"bytes_per_tick", per_tick},
              {"spool_mb", disk_mb},
              {"resident_mb", resident_mb}});
  }
  double took_s = std::chrono::duration<double>(Clock::now() - begin).count();
  double per_tick = static_cast<double>(totals.bytes) / static_cast<double>(totals.ticks);
  // From the disk, not the chunks: pages and indexes of the spool count too.
  double mb_8h = OnDisk_mb(folder) * 8 / options.hours;
  std::printf("\n%.0f s, %.0f x real time. Bytes a tick: %s. Spool for 8 h: %s MB\n", took_s,
              static_cast<double>(totals.ticks) / kRecordRate_hz / took_s,
              AgainstGoal(per_tick, kGoalBytesPerTick).c_str(),
              AgainstGoal(mb_8h, kGoalMbPer8h).c_str());
  return Status::Ok();
}

int RunRecord(RecordOptions& options) {
  if (!CanWrite(options.json)) return 1;
  std::string name =
      ((options.folder.empty() ? fs::temp_directory_path() : fs::path(options.folder)) /
       "enamel_record_XXXXXX")
          .string();
  if (::mkdtemp(name.data()) == nullptr) {
    program::SayError("cannot make a folder in " + options.folder + ": choose one with --folder");
    return 1;
  }
  char method[400];
  std::snprintf(
      method, sizeof method,
      "attempts of operator '%s' on %s at the built-in molar, %d um voxels, one after the "
      "other as fast as the machine can; encoder counts with Gaussian noise of %.2f counts; after "
      "each attempt the hand waits in the air while more than a third of the ticks have cut. "
      "Chunks as a "
      "station makes and stores them",
      options.operator_name.c_str(), options.profile.c_str(), options.voxel_um, kNoise_counts);
  std::printf("Method: %s.\n\n", method);
  Rows rows("record", method);
  Status status = MeasureRecord(options, name, rows);
  std::error_code ignored;
  fs::remove_all(name, ignored);
  if (!status.ok()) {
    program::SayError(status.message());
    return 1;
  }
  return rows.Write(options.json);
}

template <typename Named>
std::vector<std::string> NamesOf(const Named& all) {
  std::vector<std::string> out;
  for (const auto& one : all) out.emplace_back(one.name);
  return out;
}

}  // namespace

void RegisterRecord(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<RecordOptions>();
  CLI::App* record =
      app.add_subcommand("record", "Bytes and memory of a working day's recording, accelerated");
  record->add_option("--hours", options->hours, "Of recorded time")
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  record->add_option("--voxel-um", options->voxel_um, "Voxel")
      ->check(CLI::Range(5, 500))
      ->capture_default_str();
  record->add_option("--profile", options->profile, "Device profile")
      ->check(CLI::IsMember(NamesOf(scene::BuiltinProfiles())))
      ->capture_default_str();
  record->add_option("--operator", options->operator_name, "Who holds it")
      ->check(CLI::IsMember(NamesOf(OperatorPresets())))
      ->capture_default_str();
  record->add_option(
      "--folder", options->folder,
      "Folder for the spool, which is removed; else the system's folder for temporary files");
  record->add_option("--json", options->json, "Write the rows to this file");
  program::AddExamples(*record, {"--hours 8"});
  record->callback([options, exit_code] { *exit_code = RunRecord(*options); });
}

}  // namespace enamel::station::lab::bench

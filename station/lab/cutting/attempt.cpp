#include "station/lab/cutting/attempt.h"

#include <algorithm>
#include <cmath>

#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "common/scene/tooth_number.h"
#include "common/scene/volume_blob.h"
#include "station/lab/cutting/cutting_ticks.h"

namespace enamel::station::lab {
namespace {

// A stroke that cuts, and a hand that moves through the air.
constexpr double kStroke_m_s = 2e-3, kMove_m_s = 15e-3;
constexpr double kAbove_m = 0.6e-3;  // where the first layer lies above the landmark
constexpr double kLift_m = 5e-3;
// Physiological tremor is at 8 to 12 Hz; against the tooth it is a quarter (Put).
constexpr double kTremor_m = 20e-6, kTremor_hz = 9;
constexpr size_t kChunkTicks = 500;
constexpr int kRows = 4;

std::array<uint8_t, 32> Seed(uint8_t value) {
  std::array<uint8_t, 32> seed;
  seed.fill(value);
  return seed;
}

// Position of the hand and state of the pedal, tick by tick.
class Hand {
 public:
  Hand(const scene::Exercise& exercise, const scene::Scene& scene, const AttemptOptions& options)
      : options_(options), tick_s_(1.0 / exercise.rate_hz) {
    const scene::PointUm& at = scene.landmarks.at(exercise.target.landmark);
    landmark_ = dvec3(at[0], at[1], at[2]) * 1e-6;
    double radius = exercise.bur_radius_um * 1e-6;
    // The bur's axis stays its radius inside the box.
    half_x_ = std::max(0.1e-3, exercise.target.half_size_um[0] * 1e-6 - radius);
    half_y_ = std::max(0.1e-3, exercise.target.half_size_um[1] * 1e-6 - radius);
    mesial_x_ = scene::MesialX(scene.tooth);
    depth_ = exercise.target.depth_um * 1e-6 + options.floor_extra_m;
    double stroke_s = 2 * half_x_ / kStroke_m_s;
    // Lift, pause and descent belong to every stroke.
    double cycle_s = stroke_s * (1 + options.pause_strokes) + 2 * kLift_m / kMove_m_s;
    strokes_ = std::max(1.0, static_cast<double>(options.ticks) * tick_s_ / cycle_s);
    at_ = landmark_ + dvec3(0, 0, kLift_m);
    Wait(0.8);
  }

  core::TickInput Next(const core::CoreParams& params) {
    while (queue_at_ == queue_.size()) Stroke();
    const Point& p = queue_[queue_at_++];
    core::TickInput in;
    for (int i = 0; i < 3; ++i) {
      auto n = static_cast<size_t>(i);
      double nm = p.at[i] * 1e9 - static_cast<double>(params.device_origin_nm[n]);
      in.counts[n] = static_cast<int32_t>(std::lround(nm / params.resolution_nm[n]));
    }
    in.flags = p.pedal ? core::kBurOn : 0;
    in.bur_speed_krpm = p.pedal ? 200 : 0;
    return in;
  }

 private:
  struct Point {
    dvec3 at;
    bool pedal;
  };

  void Put(const dvec3& at, bool pedal) {
    double phase = 6.28318530717958648 * kTremor_hz * static_cast<double>(made_++) * tick_s_;
    // Ratios that do not repeat within an attempt: a periodic recording would pack too well.
    dvec3 tremor(std::sin(phase), std::sin(1.31 * phase + 1), std::sin(0.83 * phase + 2));
    queue_.push_back({at + tremor * (pedal ? 0.25 : 1.0) * kTremor_m, pedal});
  }
  void Go(const dvec3& to, double speed_m_s, bool pedal) {
    dvec3 way = to - at_;
    double length = std::sqrt(Dot(way, way));
    int ticks = std::max(1, static_cast<int>(length / (speed_m_s * tick_s_)));
    for (int i = 1; i <= ticks; ++i) Put(at_ + way * (static_cast<double>(i) / ticks), pedal);
    at_ = to;
  }
  void Wait(double s) {
    auto ticks = static_cast<int>(s / tick_s_);
    for (int i = 0; i < ticks; ++i) Put(at_, false);
  }
  // Down, along the box at this layer's depth, up, and a look at it.
  void Stroke() {
    queue_.clear();
    queue_at_ = 0;
    double share = std::min(1.0, stroke_ / strokes_);
    double z = landmark_.z + kAbove_m - share * (kAbove_m + depth_);
    auto row = static_cast<int>(stroke_) % kRows;
    double y = landmark_.y + half_y_ * (2.0 * row / (kRows - 1) - 1), way = row % 2 == 0 ? 1 : -1;
    double distal = landmark_.x - mesial_x_ * half_x_,
           mesial = landmark_.x + mesial_x_ * (half_x_ + options_.mesial_extra_m);
    dvec3 from(way > 0 ? distal : mesial, y, z), to(way > 0 ? mesial : distal, y, z);
    dvec3 up(0, 0, kLift_m);
    Go(from + up, kMove_m_s, false);
    Go(from + up * 0.1, kMove_m_s, true);
    Go(from, kStroke_m_s, true);
    Go(to, kStroke_m_s, true);
    Go(to + up, kMove_m_s, true);
    Wait(options_.pause_strokes * 2 * half_x_ / kStroke_m_s);
    stroke_ += 1;
  }

  const AttemptOptions options_;
  double tick_s_;
  dvec3 landmark_{0}, at_{0};
  double half_x_ = 0, half_y_ = 0, depth_ = 0, strokes_ = 1, stroke_ = 0;
  int mesial_x_ = 1;
  std::vector<Point> queue_;
  size_t queue_at_ = 0;
  uint64_t made_ = 0;
};

class Recorder {
 public:
  explicit Recorder(const trace::Header& header)
      : attempt_(header.ticket.attempt),
        keys_(trace::KeyPairFromSeed(Seed(2))),
        chain_(attempt_, HashSha256(trace::EncodeHeader(header))) {}

  void Put(const core::TickInput& input, const core::TickWitness& witness, uint64_t state_hash,
           Attempt& out) {
    ticks_.push_back({input, witness});
    state_hash_ = state_hash;
    if (ticks_.size() == kChunkTicks) Flush(out);
  }
  void Flush(Attempt& out) {
    if (ticks_.empty()) return;
    trace::ChunkHead head;
    head.attempt = attempt_;
    head.seq = chain_.next_seq();
    head.first_tick = chain_.next_tick();
    head.state_hash = state_hash_;
    head.previous = chain_.head();
    out.chunks.push_back(trace::EncodeChunk(head, ticks_, keys_.secret_key));
    ENAMEL_CHECK(chain_.Accept(*trace::DecodeChunkHead(out.chunks.back())).ok());
    ticks_.clear();
    out.seal = chain_.MakeSeal();
  }

 private:
  Uuid attempt_;
  trace::KeyPair keys_;
  trace::ChainVerifier chain_;
  std::vector<trace::Tick> ticks_;
  uint64_t state_hash_ = 0;
};

trace::Header MakeHeader(const scene::BuiltScene& built, const scene::Exercise& exercise,
                         const scene::DeviceProfile& profile, const core::CoreParams& params) {
  trace::Header header;
  // All fixed: two runs make the same recording, byte by byte.
  header.ticket.attempt.bytes.fill(0x41);
  header.ticket.exercise = HashSha256(AsBytes(scene::ToJson(exercise)));
  header.ticket.profile = HashSha256(AsBytes(scene::ToJson(profile)));
  header.ticket.expires_unix_ms = 1;
  trace::SignTicket(header.ticket, trace::KeyPairFromSeed(Seed(1)).secret_key);
  header.scene = HashSha256(AsBytes(scene::ToJson(built.scene)));
  header.volume = built.scene.volume;
  header.params = params;
  header.station_software = "enamel-measure";
  header.hand.kind = HandKind::kProgram;
  return header;
}

}  // namespace

Result<Attempt> RecordAttempt(const AttemptOptions& options,
                              const std::function<void(double)>& progress) {
  ENAMEL_ASSIGN_OR_RETURN(auto built, scene::BuildBuiltinScene(options.scene, options.voxel_nm));
  scene::Exercise exercise =
      scene::ClassOneExercise(built.scene, HashSha256(AsBytes(scene::ToJson(built.scene))));
  std::vector<scene::DeviceProfile> profiles = scene::BuiltinProfiles();
  auto profile = std::find_if(profiles.begin(), profiles.end(),
                              [](const auto& p) { return p.name == "phantom_desktop"; });
  ENAMEL_CHECK(profile != profiles.end());
  ENAMEL_ASSIGN_OR_RETURN(auto params, scene::CompilePlan(built.scene, exercise, *profile));
  Attempt out;
  out.header = MakeHeader(built, exercise, *profile, params);
  core::Core core(params, built.volume);
  Hand hand(exercise, built.scene, options);
  Recorder recorder(out.header);
  CuttingTicks cutting(static_cast<uint32_t>(params.rate_hz));
  for (uint64_t i = 0; i < options.ticks; ++i) {
    if (progress && i % 5000 == 0) {
      progress(static_cast<double>(i) / static_cast<double>(options.ticks));
    }
    core::TickInput input = hand.Next(params);
    core::TickOutput tick = core.Step(input);
    cutting.Add(
        std::any_of(tick.removed.begin(), tick.removed.end(), [](int64_t r) { return r != 0; }));
    recorder.Put(input, tick.witness, core.state_hash(), out);
  }
  recorder.Flush(out);
  out.cutting_share = static_cast<double>(cutting.cutting()) / static_cast<double>(options.ticks);
  out.built = std::move(built);
  out.exercise = std::move(exercise);
  return out;
}

}  // namespace enamel::station::lab

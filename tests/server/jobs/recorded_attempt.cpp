#include "tests/server/jobs/recorded_attempt.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "common/scene/volume_blob.h"

namespace enamel::test {
namespace {

constexpr int32_t kVoxel_nm = 100'000;
constexpr double kBurRadius_mm = 0.5;

// Tick by tick positions of the tip above the landmark, mm.
class Path {
 public:
  Path(dvec3 start, int32_t rate_hz) : at_(start), rate_hz_(rate_hz) {}
  void Move(const dvec3& to, double mm_per_s) {
    dvec3 from = at_;
    double length = std::sqrt(Dot(to - from, to - from));
    int n = static_cast<int>(std::ceil(length / mm_per_s * rate_hz_));
    for (int i = 1; i <= n; ++i)
      points.push_back(from + (to - from) * (static_cast<double>(i) / n));
    at_ = to;
  }
  void Rest(int ms) {
    points.insert(points.end(), static_cast<size_t>(ms) * static_cast<size_t>(rate_hz_) / 1000,
                  at_);
  }
  std::vector<dvec3> points;

 private:
  dvec3 at_;
  int32_t rate_hz_;
};

double Between(std::mt19937_64& random, double lo, double hi) {
  return lo + (hi - lo) * static_cast<double>(random() >> 11) * 0x1p-53;
}

// To and fro in and around the cavity, in the air too, at any pace: what no rubric expects.
std::vector<dvec3> WanderingPath(const scene::CavityTarget& target, uint64_t seed,
                                 int32_t rate_hz) {
  std::mt19937_64 random(seed);
  const double x = target.half_size_um[0] * 1e-3, y = target.half_size_um[1] * 1e-3;
  Path path({0, 0, 8}, rate_hz);
  path.Rest(600);
  const int strokes = static_cast<int>(Between(random, 3, 12));
  for (int i = 0; i < strokes; ++i) {
    const dvec3 to(Between(random, -1.5 * x, 1.5 * x), Between(random, -1.5 * y, 1.5 * y),
                   Between(random, -1.5, 0.6));
    path.Move(to, Between(random, 1, 30));
    if (Between(random, 0, 1) < 0.3) path.Rest(static_cast<int>(Between(random, 1, 200)));
  }
  return path.points;
}

std::vector<dvec3> PathOf(const scene::CavityTarget& target, const PathOptions& options,
                          int32_t rate_hz) {
  double x0 = -target.half_size_um[0] * 1e-3 + kBurRadius_mm, x1 = -x0 + options.mesial_extra_mm;
  double y1 = target.half_size_um[1] * 1e-3 - kBurRadius_mm, z = -target.depth_um * 1e-3;
  Path path({0, 0, 8}, rate_hz);
  path.Rest(600);  // force and cutting come on in free air
  path.Move({0, 0, 0.2}, 40);
  path.Move({0, 0, z}, 4 * options.pace);
  path.Rest(60);
  const dvec3 corners[] = {{x1, 0, z},   {x1, y1, z},  {x0, y1, z},
                           {x0, -y1, z}, {x1, -y1, z}, {x1, 0, z}};
  for (const dvec3& c : corners) {
    path.Move(c, 8 * options.pace);
    path.Rest(60);
  }
  path.Move({0, 0, z}, 8 * options.pace);
  path.Move({0, 0, 8}, 40);
  return path.points;
}

// A bad link or loop, now and then.
void Disturb(std::mt19937_64& random, core::TickInput& input) {
  const uint64_t chance = random() % 1000;
  if (chance < 5) input.flags |= core::kLateTick;
  if (chance == 5) input.gap_ticks = static_cast<uint32_t>(1 + random() % 400);
  if (chance == 6) input.flags &= static_cast<uint8_t>(~core::kBurOn);
  if (chance > 996) input.counts[chance % 3] += static_cast<int32_t>(random() % 41) - 20;
}

std::array<int32_t, 3> CountsOf(const dvec3& above_landmark_mm, const core::CoreParams& params) {
  std::array<int32_t, 3> out;
  for (int i = 0; i < 3; ++i) {
    double mm = above_landmark_mm[i] - (i == 2 ? 8 : 0);  // count 0 is 8 mm above the landmark
    out[static_cast<size_t>(i)] =
        static_cast<int32_t>(std::lround(mm * 1e6 / params.resolution_nm[static_cast<size_t>(i)]));
  }
  return out;
}

}  // namespace

const World& World::Get() {
  static const World world(1000, 10, haptics::kDefaultLaw);
  return world;
}

World::World(int32_t rate_hz, int32_t damping_mn_s_per_mm, haptics::LawKind law) {
  auto built = scene::BuildBuiltinScene("block", kVoxel_nm);
  ENAMEL_CHECK(built.ok());
  scene = built->scene;
  volume = built->volume;
  // 10: soft enough that the anchor follows the tip within the rests at the corners.
  for (auto& t : scene.tissues) t.damping_mn_s_per_mm = damping_mn_s_per_mm;
  volume_blob = scene::EncodeVolume(volume);
  exercise = scene::ClassOneExercise(scene, HashSha256(AsBytes(scene::ToJson(scene))));
  exercise.target.half_size_um = {1'500, 1'000, 0};
  exercise.target.depth_um = 1'000;
  exercise.rate_hz = rate_hz;
  for (scene::BurSpec bur : scene.burs) {
    if (bur.name != "pear-12") continue;
    bur.name.clear();
    exercise.other_burs = {bur};
  }
  exercise.law = law;
  for (const auto& p : scene::BuiltinProfiles()) {
    if (p.name == "phantom_desktop") profile = p;
  }
  // Whole cells: a scripted way along a wall that was cut before would touch it by the nanometre.
  profile.cell.reset();
  profile.rate_hz.value = rate_hz;
  auto plan = scene::CompilePlan(scene, exercise, profile);
  ENAMEL_CHECK(plan.ok());
  params = *plan;
}

Recording World::Record(const Uuid& attempt, const Uuid& station,
                        const PathOptions& options) const {
  trace::Header header;
  header.ticket.attempt = attempt;
  header.ticket.station = station;
  header.ticket.exercise = HashSha256(AsBytes(scene::ToJson(exercise)));
  header.ticket.profile = HashSha256(AsBytes(scene::ToJson(profile)));
  header.scene = exercise.scene;
  header.volume = HashSha256(volume_blob);
  header.params = params;
  header.station_software = "test 1";
  header.hand.kind = HandKind::kProgram;

  Recording recording;
  recording.header = trace::EncodeHeader(header);
  core::Core core(header.params, volume);
  Sha256 previous = HashSha256(recording.header);
  std::vector<trace::Tick> ticks;
  uint64_t first = 0;
  auto flush = [&] {
    if (ticks.empty()) return;
    trace::ChunkHead head;
    head.attempt = attempt;
    head.seq = static_cast<uint32_t>(recording.chunks.size());
    head.first_tick = first;
    head.state_hash = core.state_hash();
    head.previous = previous;
    recording.chunks.push_back(trace::EncodeChunk(head, ticks, station_key.secret_key));
    previous = trace::DecodeChunkHead(recording.chunks.back())->hash;
    first += ticks.size();
    ticks.clear();
  };
  const bool wanders = options.wander != 0;
  std::vector<dvec3> points = wanders
                                  ? WanderingPath(exercise.target, options.wander, exercise.rate_hz)
                                  : PathOf(exercise.target, options, exercise.rate_hz);
  std::mt19937_64 random(options.wander);
  for (size_t i = 0; i < points.size(); ++i) {
    trace::Tick tick;
    tick.input.counts = CountsOf(points[i], params);
    tick.input.flags = core::kBurOn;
    if (options.bur != 0 && i >= static_cast<size_t>(exercise.rate_hz) * 15 / 100) {
      tick.input.flags |= core::BurFlags(options.bur);
    }
    if (options.late && i % 100 == 0) tick.input.flags |= core::kLateTick;
    if (i == points.size() - 50) tick.input.gap_ticks = options.gap_ticks;
    if (wanders) Disturb(random, tick.input);
    tick.witness = core.Step(tick.input).witness;
    ticks.push_back(tick);
    if (ticks.size() ==
        std::min(static_cast<size_t>(exercise.rate_hz) / 4, trace::kMaxTicksPerChunk)) {
      flush();
    }
  }
  flush();
  recording.seal = {attempt, static_cast<uint32_t>(recording.chunks.size()), core.ticks(), previous,
                    core.state_hash()};
  return recording;
}

Bytes World::Resign(ByteView bytes, const std::function<void(trace::Tick&)>& change) const {
  auto chunk = trace::DecodeChunk(bytes);
  ENAMEL_CHECK(chunk.ok());
  change(chunk->ticks[chunk->ticks.size() / 2]);
  return trace::EncodeChunk(chunk->head, chunk->ticks, station_key.secret_key);
}

}  // namespace enamel::test

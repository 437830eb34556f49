// Re-runs the core on a recorded attempt and prints what it found, one line per fact. Built twice,
// by g++ -O3 and by clang++ -O0; tests/determinism compares the two outputs byte for byte.
//   core_replay record SEED TRACE VOLUME   makes a recording (a seeded hand on a two-tissue ball)
//   core_replay replay TRACE VOLUME        re-runs it

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>

#include "common/base/file.h"
#include "common/scene/builder.h"
#include "common/scene/volume_blob.h"
#include "common/trace/replay.h"
#include "common/trace/trace.h"

namespace {

using namespace enamel;

int Fail(const Status& status) {
  std::fprintf(stderr, "core_replay: %s\n", status.message().c_str());
  return 1;
}

// A ball of 3 mm with a dentin core of 2 mm, off the grid.
cutting::Volume Ball(int32_t voxel_nm) {
  cutting::GridSpec spec;
  spec.voxel_nm = voxel_nm;
  spec.bricks = ivec3(static_cast<int>(7.4e6 / voxel_nm / 8) + 1);
  spec.origin_nm = {-3'700'013, -3'700'007, -3'700'003};
  return scene::BuildVolume(spec, [](const dvec3& p) {
    double r = glm::length(p);
    return scene::FieldSample{r - 3e-3, r < 2e-3 ? cutting::Tissue::kDentin : cutting::Tissue::kEnamel};
  });
}

core::CoreParams ParamsFor(uint64_t seed) {
  core::CoreParams p;
  p.law = seed % 2 ? haptics::LawKind::kGatedMaxwell : haptics::LawKind::kMaxwell;
  p.kc_mn_per_mm = 2500 + static_cast<int32_t>(seed % 5) * 1700;
  p.resolution_nm = {9'000, 10'000, 20'000};
  p.device_origin_nm = {17, -23, 41};
  p.peak_force_mn = 6000;
  p.bur_shape = seed % 3 ? cutting::BurShape::kCylinder : cutting::BurShape::kSphere;
  p.bur_radius_nm = 500'000;
  p.bur_length_nm = 4'000'000;
  p.damping_mn_s_per_mm[1] = 1500;
  p.damping_mn_s_per_mm[2] = 900;
  p.rotational_kc_un_m_per_rad = seed % 4 ? 0 : 20'000;
  return p;
}

int Record(uint64_t seed, const char* trace_path, const char* volume_path) {
  cutting::Volume ball = Ball(seed % 2 ? 100'000 : 75'000);
  Bytes blob = scene::EncodeVolume(ball);
  trace::Header header;
  header.ticket.attempt = Uuid::New();
  header.volume = HashSha256(blob);
  header.params = ParamsFor(seed);
  header.station_software = "core_replay";
  trace::TraceFile file;
  file.header = trace::EncodeHeader(header);
  trace::KeyPair keys = trace::NewKeyPair();

  core::Core core(header.params, ball);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  dvec3 tip(0.4e-3 * normal(random), 0.4e-3 * normal(random), 4.4e-3), velocity(0);
  Quat tilt;
  trace::ChunkHead head;
  head.attempt = header.ticket.attempt;
  head.previous = HashSha256(file.header);
  std::vector<trace::Tick> ticks;
  for (int i = -600; i < 11'400; ++i) {
    // Wanders between the ball's middle and the air above it; now and then the pedal is lifted, a tick is
    // lost, the bur tilts.
    dvec3 goal(0, 0, i >= 0 && i % 4000 < 2600 ? 1e-3 : 4.4e-3);
    velocity = velocity * 0.995 + dvec3(normal(random), normal(random), normal(random)) * 1.2e-8 - (tip - goal) * 2e-6;
    tip += velocity;
    tilt = Quat{tilt.x + 1e-4 * normal(random), tilt.y + 1e-4 * normal(random), 0, 1}.Normalised();
    trace::Tick tick;
    for (int a = 0; a < 3; ++a) {
      tick.input.counts[static_cast<size_t>(a)] =
          static_cast<int32_t>(std::lround(tip[a] * 1e9 / header.params.resolution_nm[static_cast<size_t>(a)]));
    }
    tick.input.orientation = ToQuantised(tilt);
    tick.input.flags = i % 4000 > 2300 && i % 4000 < 2500 ? 0 : core::kBurOn;
    if (random() % 1000 == 0) tick.input.gap_ticks = 1 + static_cast<uint32_t>(random() % 40);
    tick.witness = core.Step(tick.input).witness;
    ticks.push_back(tick);
    if (ticks.size() == 400 || i == 11'399) {
      head.state_hash = core.state_hash();
      file.chunks.push_back(trace::EncodeChunk(head, ticks, keys.secret_key));
      head.previous = trace::DecodeChunkHead(file.chunks.back()).value().hash;
      head.first_tick += ticks.size();
      ++head.seq;
      ticks.clear();
    }
  }
  file.seal = trace::Seal{head.attempt, head.seq, head.first_tick, head.previous, core.state_hash()};
  Status written = WriteFileDurably(trace_path, trace::EncodeTraceFile(file));
  if (written.ok()) written = WriteFileDurably(volume_path, blob);
  return written.ok() ? 0 : Fail(written);
}

int Replay(const char* trace_path, const char* volume_path) {
  auto trace_bytes = ReadFile(trace_path);
  if (!trace_bytes.ok()) return Fail(trace_bytes.status());
  auto file = trace::DecodeTraceFile(*trace_bytes);
  if (!file.ok()) return Fail(file.status());
  auto header = trace::DecodeHeader(file->header);
  if (!header.ok()) return Fail(header.status());
  if (Status known = core::ValidateParams(header->params); !known.ok()) return Fail(known);
  auto blob = ReadFile(volume_path);
  if (!blob.ok()) return Fail(blob.status());
  auto volume = scene::DecodeVolume(*blob);
  if (!volume.ok()) return Fail(volume.status());
  core::Core core(header->params, std::move(*volume));
  auto report = trace::Replay(core, *header, file->chunks);
  if (!report.ok()) return Fail(report.status());
  std::printf("ticks %llu\nchunks %u\ngap_ticks %llu\nwitness_ok %d %s\nstate_hash %016llx\n",
              static_cast<unsigned long long>(report->ticks), report->chunks,
              static_cast<unsigned long long>(report->gap_ticks), report->witness_ok, report->what.c_str(),
              static_cast<unsigned long long>(report->state_hash));
  for (size_t t = 1; t < cutting::kTissueCount; ++t) {
    std::printf("removed %s %lld\n", std::string(cutting::TissueName(static_cast<cutting::Tissue>(t))).c_str(),
                static_cast<long long>(core.removed()[t]));
  }
  std::printf("final_volume %s\n", HashSha256(scene::EncodeVolume(core.volume())).Hex().c_str());
  return report->witness_ok ? 0 : 3;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 5 && std::strcmp(argv[1], "record") == 0) {
    return Record(std::strtoull(argv[2], nullptr, 10), argv[3], argv[4]);
  }
  if (argc == 4 && std::strcmp(argv[1], "replay") == 0) return Replay(argv[2], argv[3]);
  std::fprintf(stderr, "usage: core_replay record SEED TRACE VOLUME | replay TRACE VOLUME\n");
  return 2;
}

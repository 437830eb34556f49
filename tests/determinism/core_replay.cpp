// Re-runs the core on a recorded attempt and prints its findings, one fact a line. Built several
// times, by g++ -O3 and by clang++ -O0 among others; tests/determinism compares the outputs byte
// for byte.
//   core_replay record SEED TRACE VOLUME   makes a recording (a seeded hand on a two-tissue ball)
//   core_replay replay TRACE VOLUME        re-runs it
//   core_replay digest TRACE VOLUME [TICK] re-runs it and prints a line per tick: state hash, and a
//                                          hash of each brick it changed; with TICK, that tick's
//                                          first count is one more
//   core_replay diff DIGEST DIGEST         names the first tick, and brick, in which two digests
//                                          differ

#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "common/base/state_hash.h"
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
    return scene::FieldSample{r - 3e-3,
                              r < 2e-3 ? cutting::Tissue::kDentin : cutting::Tissue::kEnamel};
  });
}

core::CoreParams ParamsFor(uint64_t seed) {
  core::CoreParams p;
  constexpr haptics::LawKind kLaws[] = {haptics::LawKind::kMaxwell, haptics::LawKind::kLeadMaxwell};
  p.law = kLaws[seed % std::size(kLaws)];
  p.kc_mn_per_mm = 2500 + static_cast<int32_t>(seed % 5) * 1700;
  p.resolution_nm = {9'000, 10'000, 20'000};
  p.device_origin_nm = {17, -23, 41};
  p.peak_force_mn = 6000;
  // All shapes in seven recordings, cylinder and sphere in the first two.
  constexpr cutting::BurShape kShapes[] = {
      cutting::BurShape::kCylinder, cutting::BurShape::kSphere,       cutting::BurShape::kCone,
      cutting::BurShape::kFlame,    cutting::BurShape::kInvertedCone, cutting::BurShape::kPear,
      cutting::BurShape::kWheel};
  p.bur_shape = kShapes[(seed - 1) % std::size(kShapes)];
  p.bur_radius_nm = 500'000;
  p.bur_length_nm = p.bur_shape == cutting::BurShape::kWheel ? 600'000 : 4'000'000;
  p.bur_narrow_radius_nm = 300'000;
  if (seed % 3 == 0) {
    p.shank_radius_nm = 800'000;
    p.neck_nm = 1'000'000;
    p.axial_damping_mn_s_per_mm[1] = 2500;
  }
  if (seed % 5 == 0) {
    p.handpiece_stall_un_m = 2330;
    p.handpiece_tangential_permille = 300;
    p.handpiece_lag_us = 50'000;
  }
  if (seed % 3 == 0) {
    p.friction_mn = {90, 25, 80};
    p.friction_measured = seed % 2 == 0;
  }
  p.damping_mn_s_per_mm[1] = 1500;
  p.damping_mn_s_per_mm[2] = 900;
  // Every second ball has an enamel that is cut by load, with a handpiece that feels it.
  if (seed % 2 == 0) {
    p.coulomb_mn[1] = 60;
    p.feed_exponent[1] = cutting::FeedExponent::kHalf;
    p.feed_um_per_s[1] = 430;
    p.bur_friction_permille[1] = 500;
    p.handpiece_stall_un_m = 2330;
    p.handpiece_tangential_permille = 0;
    p.handpiece_lag_us = 50'000;
  }
  p.rotational_kc_un_m_per_rad = seed % 4 ? 0 : 20'000;
  // Every second recording is of a six-axis device, with touch cues and its spring on the board.
  if (seed % 2 == 0) {
    p.rotational_kc_un_m_per_rad = 800'000;
    p.peak_torque_un_m = 100'000;
    p.rotation_cell_urad = 300;
    p.contact_cue_mn = 300;
    p.chatter_cue_mn = 200;
    p.cue_energy_nj = 200'000;
    p.cue_power_nw = 1'000'000;
    p.bus_delay_ticks = static_cast<uint32_t>(seed / 2 % 3);
    p.spring_on_board = true;
  }
  // The next of the shapes, to change to.
  core::OtherBur other;
  other.shape = kShapes[seed % std::size(kShapes)];
  other.radius_nm = 400'000;
  other.length_nm = other.shape == cutting::BurShape::kWheel ? 600'000 : 3'000'000;
  other.narrow_radius_nm = 300'000;
  other.rotational_kc_un_m_per_rad = p.rotational_kc_un_m_per_rad;
  p.other_burs = {other};
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
  header.hand.kind = HandKind::kProgram;
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
    // Wanders between the ball's middle and the air above it; occasionally the pedal is lifted, a
    // tick is lost, the bur tilts.
    dvec3 goal(0, 0, i >= 0 && i % 4000 < 2600 ? 1e-3 : 4.4e-3);
    velocity = velocity * 0.995 + dvec3(normal(random), normal(random), normal(random)) * 1.2e-8 -
               (tip - goal) * 2e-6;
    tip += velocity;
    tilt = Quat{tilt.x + 1e-4 * normal(random), tilt.y + 1e-4 * normal(random), 0, 1}.Normalised();
    trace::Tick tick;
    for (int a = 0; a < 3; ++a) {
      tick.input.counts[static_cast<size_t>(a)] = static_cast<int32_t>(
          std::lround(tip[a] * 1e9 / header.params.resolution_nm[static_cast<size_t>(a)]));
    }
    tick.input.orientation = ToQuantised(tilt);
    tick.input.flags = i % 4000 > 2300 && i % 4000 < 2500 ? 0 : core::kBurOn;
    tick.input.bur_speed_krpm = static_cast<uint16_t>(150 + i % 4000 / 16);
    if (random() % 1000 == 0) tick.input.gap_ticks = 1 + static_cast<uint32_t>(random() % 40);
    if (tick.input.gap_ticks % 2 == 1) tick.input.flags |= core::kLateTick | core::kHeldGap;
    // Between two cuts.
    tick.input.flags |= core::BurFlags(static_cast<size_t>((i + 1000) / 4000 % 2));
    // A board whose guard holds the rest point back now and then.
    if (header.params.spring_on_board && i % 7 == 0) {
      for (int32_t& off : tick.input.rest_off_nm)
        off = static_cast<int32_t>(random() % 4001) - 2000;
      tick.input.share_lost = static_cast<uint16_t>(random() % 3000);
    }
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
  file.seal =
      trace::Seal{head.attempt, head.seq, head.first_tick, head.previous, core.state_hash()};
  Status written = WriteFileDurably(trace_path, trace::EncodeTraceFile(file));
  if (written.ok()) written = WriteFileDurably(volume_path, blob);
  return written.ok() ? 0 : Fail(written);
}

struct Recording {
  trace::Header header;
  std::vector<Bytes> chunks;
  cutting::Volume volume;
};

Result<Recording> Read(const char* trace_path, const char* volume_path) {
  ENAMEL_ASSIGN_OR_RETURN(auto trace_bytes, ReadFile(trace_path));
  ENAMEL_ASSIGN_OR_RETURN(auto file, trace::DecodeTraceFile(trace_bytes));
  ENAMEL_ASSIGN_OR_RETURN(auto header, trace::DecodeHeader(file.header));
  ENAMEL_RETURN_IF_ERROR(core::ValidateParams(header.params));
  ENAMEL_ASSIGN_OR_RETURN(auto blob, ReadFile(volume_path));
  ENAMEL_ASSIGN_OR_RETURN(auto volume, scene::DecodeVolume(blob));
  return Recording{std::move(header), std::move(file.chunks), std::move(volume)};
}

int Digest(const char* trace_path, const char* volume_path, uint64_t disturbed_tick) {
  auto recording = Read(trace_path, volume_path);
  if (!recording.ok()) return Fail(recording.status());
  core::Core core(recording->header.params, std::move(recording->volume));
  for (const Bytes& bytes : recording->chunks) {
    auto chunk = trace::DecodeChunk(bytes);
    if (!chunk.ok()) return Fail(chunk.status());
    for (trace::Tick& tick : chunk->ticks) {
      uint64_t number = core.ticks();
      if (number == disturbed_tick) tick.input.counts[0] += 1;
      core.Step(tick.input);
      std::printf("%" PRIu64 " %016" PRIx64, number, core.state_hash());
      for (int32_t brick : core.touched()) {
        StateHash samples;
        for (int16_t phi : core.volume().Phi(brick).phi) samples.U64(static_cast<uint16_t>(phi));
        std::printf(" %d:%016" PRIx64, brick, samples.value());
      }
      std::printf("\n");
    }
  }
  return 0;
}

// 1 if the digests differ.
int Diff(const char* path_a, const char* path_b) {
  std::ifstream a(path_a), b(path_b);
  std::string line_a, line_b;
  for (;;) {
    bool more_a = static_cast<bool>(std::getline(a, line_a)),
         more_b = static_cast<bool>(std::getline(b, line_b));
    if (!more_a && !more_b) return 0;
    if (more_a && more_b && line_a == line_b) continue;
    std::istringstream words_a(line_a), words_b(line_b);
    std::string tick, hash, word_a, word_b;
    (more_a ? words_a : words_b) >> tick >> hash;
    std::cout << "first difference in tick " << tick << ": ";
    if (more_a != more_b) {
      std::cout << "one run ends before it\n";
      return 1;
    }
    words_b >> tick >> hash;
    for (;;) {
      word_a.clear(), word_b.clear();
      words_a >> word_a, words_b >> word_b;
      if (word_a != word_b) {
        std::cout << "brick "
                  << (word_a.empty() ? word_b : word_a)
                         .substr(0, (word_a.empty() ? word_b : word_a).find(':'))
                  << (word_a.empty() || word_b.empty() ? ", changed in one run only\n" : "\n");
        return 1;
      }
      if (word_a.empty()) break;
    }
    std::cout << "in the scalars or the input; every brick it changed agrees\n";
    return 1;
  }
}

int Replay(const char* trace_path, const char* volume_path) {
  auto recording = Read(trace_path, volume_path);
  if (!recording.ok()) return Fail(recording.status());
  core::Core core(recording->header.params, std::move(recording->volume));
  auto report = trace::Replay(core, recording->header, recording->chunks);
  if (!report.ok()) return Fail(report.status());
  std::printf("ticks %llu\nchunks %u\ngap_ticks %llu\nwitness_ok %d %s\nstate_hash %016llx\n",
              static_cast<unsigned long long>(report->ticks), report->chunks,
              static_cast<unsigned long long>(report->gap_ticks), report->witness_ok,
              report->what.c_str(), static_cast<unsigned long long>(report->state_hash));
  for (size_t t = 1; t < cutting::kTissueCount; ++t) {
    std::printf("removed %s %lld\n",
                std::string(cutting::TissueName(static_cast<cutting::Tissue>(t))).c_str(),
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
  if ((argc == 4 || argc == 5) && std::strcmp(argv[1], "digest") == 0) {
    return Digest(argv[2], argv[3], argc == 5 ? std::strtoull(argv[4], nullptr, 10) : UINT64_MAX);
  }
  if (argc == 4 && std::strcmp(argv[1], "diff") == 0) return Diff(argv[2], argv[3]);
  std::fprintf(stderr,
               "usage: core_replay record SEED TRACE VOLUME | replay TRACE VOLUME | digest TRACE "
               "VOLUME [TICK] | "
               "diff DIGEST DIGEST\n");
  return 2;
}

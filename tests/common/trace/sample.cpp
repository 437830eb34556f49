#include "tests/common/trace/sample.h"

#include <cmath>

namespace enamel::trace::sample {
namespace {

constexpr int32_t kCell_nm = 23'000;  // a Phantom Desktop's
constexpr int32_t kVoxel_nm = 100'000;

std::array<uint8_t, 32> Seed(uint8_t value) {
  std::array<uint8_t, 32> seed;
  seed.fill(value);
  return seed;
}

template <typename T>
T Filled(uint8_t value) {
  T out;
  out.bytes.fill(value);
  return out;
}

core::CoreParams MakeParams() {
  core::CoreParams p;
  p.kc_mn_per_mm = 1860;
  p.resolution_nm = {kCell_nm, kCell_nm, kCell_nm};
  p.peak_force_mn = 7900;
  p.soft_start_ticks = 100;
  p.bur_radius_nm = 600'000;
  p.damping_mn_s_per_mm = {0, 6500, 3000, 500, 1500, 4000, 2500, 6500};
  p.other_burs = {{cutting::BurShape::kCylinder, 400'000, 2'000'000}};
  return p;
}

int16_t PhiOfHeight(double height_m) {
  double phi = height_m / (kVoxel_nm * 1e-9) * cutting::kPhiPerVoxel;
  return static_cast<int16_t>(std::min(32767.0, std::max(-32767.0, phi)));
}

// Where the hand wants the tip at a time, mm: down to the block, sideways and slowly deeper, up.
dvec3 PathAt(double t_s) {
  double tremor = 0.01 * std::sin(2 * 3.14159265358979 * 9.3 * t_s);
  double depth = t_s < 0.5 ? 0.4 - 0.8 * t_s : -0.25 * (t_s - 0.5);
  double lift = t_s > 5.0 ? 3.0 * (t_s - 5.0) : 0.0;
  double sweep = 0.9 * std::sin(1.1 * t_s);
  return {sweep + 0.4 * tremor, 0.35 * std::sin(0.7 * t_s) - tremor, depth + lift + 0.3 * tremor};
}

int32_t Count(double mm) { return static_cast<int32_t>(std::lround(mm * 1e6 / kCell_nm)); }

}  // namespace

KeyPair ServerKeys() { return KeyPairFromSeed(Seed(1)); }
KeyPair StationKeys() { return KeyPairFromSeed(Seed(2)); }

Header MakeHeader() {
  Header header;
  Ticket& ticket = header.ticket;
  ticket.attempt = Filled<Uuid>(0xa1);
  ticket.nonce.fill(0xa2);
  ticket.person = Filled<Uuid>(0xa3);
  ticket.station = Filled<Uuid>(0xa4);
  ticket.exercise = Filled<Sha256>(0xb1);
  ticket.profile = Filled<Sha256>(0xb2);
  ticket.issued_unix_ms = 1'767'225'600'000;
  ticket.expires_unix_ms = ticket.issued_unix_ms + 12 * 3600 * 1000;
  SignTicket(ticket, ServerKeys().secret_key);
  header.scene = Filled<Sha256>(0xc1);
  header.volume = Filled<Sha256>(0xc2);
  header.params = MakeParams();
  header.station_software = "enamel-station 0.1.0";
  header.hand = {HandKind::kHaptic, "omega.3", "hid", "hid:1209:0001:A7"};
  return header;
}

cutting::Volume MakeBlock() {
  cutting::GridSpec spec;
  spec.voxel_nm = kVoxel_nm;
  spec.bricks = {8, 8, 5};
  spec.origin_nm = {-3'200'000, -3'200'000, -3'000'000};
  cutting::Volume volume(spec);
  for (int brick = 0; brick < spec.brick_count(); ++brick) {
    int brick_z = brick / (spec.bricks.x * spec.bricks.y);
    std::array<int16_t, cutting::kBrickVoxels> phi;
    std::array<uint8_t, cutting::kBrickVoxels> labels;
    for (size_t v = 0; v < phi.size(); ++v) {
      int layer = brick_z * cutting::kBrickSide + static_cast<int>(v) / 64;
      double z_m = spec.origin_m().z + layer * spec.voxel_m();
      phi[v] = PhiOfHeight(z_m);
      labels[v] =
          static_cast<uint8_t>(z_m > -0.4e-3 ? cutting::Tissue::kEnamel : cutting::Tissue::kDentin);
    }
    volume.SetBrick(brick, phi, labels, cutting::Tissue::kEnamel);
  }
  return volume;
}

std::vector<core::TickInput> CutInputs(size_t ticks) {
  std::vector<core::TickInput> inputs(ticks);
  for (size_t i = 0; i < ticks; ++i) {
    dvec3 mm = PathAt(static_cast<double>(i) * 1e-3);
    inputs[i].counts = {Count(mm.x), Count(mm.y), Count(mm.z)};
    bool pedal = i > 300 && i < 5500;
    inputs[i].flags = pedal ? core::kBurOn : 0;
    inputs[i].bur_speed_krpm = pedal ? 200 : 0;
  }
  return inputs;
}

std::vector<Tick> OddTicks() {
  std::vector<Tick> ticks(6);
  for (int i = 0; i < 6; ++i) {
    Tick& t = ticks[static_cast<size_t>(i)];
    t.input.counts = {100 + i, -200 - 3 * i, i * i};
    t.input.orientation = {static_cast<int16_t>(-5 * i), 12, 0, 32767};
    t.input.flags = i < 3 ? core::kBurOn : 0;
    t.input.bur_speed_krpm = i < 3 ? 200 : 0;
    t.witness.anchor_100nm = {230'000 + 7 * i * i, -460'000, -2'147'483'647};
    t.witness.force_sent_mn = {-28'000 - 150 * i, 90 * i, 2'147'483'647};
    t.witness.force_computed_mn = {-28'000 - 150 * i, 95 * i, -2'147'483'647};
    t.witness.flags = static_cast<uint16_t>(i);
    t.input.rest_off_nm = {-i, i > 4 ? 2'147'483'647 : 0, 300 * i};
    t.input.share_lost = static_cast<uint16_t>(i < 2 ? 65'535 : 0);
  }
  ticks[0].witness.flags = core::kAnchorReset;
  ticks[4].input.gap_ticks = 12;
  ticks[5].input.flags = core::kFaulted | core::kLateTick | core::BurFlags(5);
  return ticks;
}

Recording Record(const std::vector<core::TickInput>& inputs, size_t per_chunk) {
  Recording out;
  out.header = MakeHeader();
  core::Core core(out.header.params, MakeBlock());
  ChainVerifier chain(out.header.ticket.attempt, HashSha256(EncodeHeader(out.header)));
  for (size_t first = 0; first < inputs.size(); first += per_chunk) {
    size_t count = std::min(per_chunk, inputs.size() - first);
    for (size_t i = first; i < first + count; ++i) {
      out.ticks.push_back({inputs[i], core.Step(inputs[i]).witness});
    }
    ChunkHead head;
    head.attempt = out.header.ticket.attempt;
    head.seq = chain.next_seq();
    head.first_tick = chain.next_tick();
    head.state_hash = core.state_hash();
    head.previous = chain.head();
    std::span<const Tick> ticks(out.ticks);
    out.chunks.push_back(EncodeChunk(head, ticks.subspan(first, count), StationKeys().secret_key));
    ENAMEL_CHECK(chain.Accept(*DecodeChunkHead(out.chunks.back())).ok());
  }
  out.seal = chain.MakeSeal();
  return out;
}

}  // namespace enamel::trace::sample

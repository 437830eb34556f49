#include "tests/common/trace/describe.h"

#include "common/base/hex.h"
#include "common/trace/columns.h"

namespace enamel::trace {
namespace {

namespace json = boost::json;

// All numbers as int64, which is what the parser makes of them.
int64_t Number(auto v) { return static_cast<int64_t>(v); }

template <typename T, size_t N>
json::array Numbers(const std::array<T, N>& values) {
  json::array out;
  for (T v : values) out.push_back(Number(v));
  return out;
}

std::string Hex64(uint64_t v) {
  ByteWriter big_endian;
  for (int shift = 56; shift >= 0; shift -= 8) big_endian.U8(static_cast<uint8_t>(v >> shift));
  return ToHex(big_endian.bytes());
}

json::array Describe(const std::vector<core::OtherBur>& burs) {
  json::array out;
  for (const core::OtherBur& bur : burs) {
    out.push_back({{"shape", Number(bur.shape)},
                   {"radius_nm", Number(bur.radius_nm)},
                   {"length_nm", Number(bur.length_nm)},
                   {"narrow_radius_nm", Number(bur.narrow_radius_nm)},
                   {"shank_radius_nm", Number(bur.shank_radius_nm)},
                   {"neck_nm", Number(bur.neck_nm)},
                   {"rotational_kc_un_m_per_rad", Number(bur.rotational_kc_un_m_per_rad)}});
  }
  return out;
}

json::object Describe(const core::CoreParams& p) {
  return {{"core_version", Number(p.core_version)},
          {"rate_hz", Number(p.rate_hz)},
          {"law", Number(p.law)},
          {"pass_through_at_rest", p.pass_through_at_rest},
          {"kc_mn_per_mm", Number(p.kc_mn_per_mm)},
          {"resolution_nm", Numbers(p.resolution_nm)},
          {"device_origin_nm", Numbers(p.device_origin_nm)},
          {"peak_force_mn", Number(p.peak_force_mn)},
          {"soft_start_ticks", Number(p.soft_start_ticks)},
          {"bur_shape", Number(p.bur_shape)},
          {"bur_radius_nm", Number(p.bur_radius_nm)},
          {"bur_length_nm", Number(p.bur_length_nm)},
          {"damping_mn_s_per_mm", Numbers(p.damping_mn_s_per_mm)},
          {"rotational_kc_un_m_per_rad", Number(p.rotational_kc_un_m_per_rad)},
          {"bur_narrow_radius_nm", Number(p.bur_narrow_radius_nm)},
          {"shank_radius_nm", Number(p.shank_radius_nm)},
          {"neck_nm", Number(p.neck_nm)},
          {"axial_damping_mn_s_per_mm", Numbers(p.axial_damping_mn_s_per_mm)},
          {"handpiece_stall_un_m", Number(p.handpiece_stall_un_m)},
          {"handpiece_tangential_permille", Number(p.handpiece_tangential_permille)},
          {"handpiece_lag_us", Number(p.handpiece_lag_us)},
          {"bus_delay_ticks", Number(p.bus_delay_ticks)},
          {"peak_torque_un_m", Number(p.peak_torque_un_m)},
          {"coulomb_mn", Numbers(p.coulomb_mn)},
          {"feed_um_per_s", Numbers(p.feed_um_per_s)},
          {"bur_friction_permille", Numbers(p.bur_friction_permille)},
          {"feed_exponent", Numbers(p.feed_exponent)},
          {"rotation_cell_urad", Number(p.rotation_cell_urad)},
          {"contact_cue_mn", Number(p.contact_cue_mn)},
          {"chatter_cue_mn", Number(p.chatter_cue_mn)},
          {"cue_energy_nj", Number(p.cue_energy_nj)},
          {"cue_power_nw", Number(p.cue_power_nw)},
          {"cell_half_nm", Numbers(p.cell_half_nm)},
          {"cell_ball_nm", Number(p.cell_ball_nm)},
          {"spring_on_board", p.spring_on_board},
          {"friction_mn", Numbers(p.friction_mn)},
          {"friction_measured", p.friction_measured},
          {"other_burs", Describe(p.other_burs)}};
}

json::object Describe(const ChunkHead& head) {
  return {{"attempt", head.attempt.Text()},        {"seq", Number(head.seq)},
          {"first_tick", Number(head.first_tick)}, {"count", Number(head.count)},
          {"gap_ticks", Number(head.gap_ticks)},   {"state_hash", Hex64(head.state_hash)},
          {"previous", head.previous.Hex()}};
}

json::object Describe(const Tick& tick) {
  return {{"counts", Numbers(tick.input.counts)},
          {"orientation", Numbers(tick.input.orientation)},
          {"input_flags", Number(tick.input.flags)},
          {"bur_speed_krpm", Number(tick.input.bur_speed_krpm)},
          {"gap_ticks", Number(tick.input.gap_ticks)},
          {"anchor_100nm", Numbers(tick.witness.anchor_100nm)},
          {"force_sent_mn", Numbers(tick.witness.force_sent_mn)},
          {"force_computed_mn", Numbers(tick.witness.force_computed_mn)},
          {"witness_flags", Number(tick.witness.flags)},
          {"rest_off_nm", Numbers(tick.input.rest_off_nm)},
          {"share_lost", Number(tick.input.share_lost)}};
}

}  // namespace

json::object Describe(const Ticket& t) {
  return {{"attempt", t.attempt.Text()},        {"nonce", ToHex(t.nonce)},
          {"person", t.person.Text()},          {"station", t.station.Text()},
          {"exercise", t.exercise.Hex()},       {"profile", t.profile.Hex()},
          {"issued_unix_ms", t.issued_unix_ms}, {"expires_unix_ms", t.expires_unix_ms},
          {"signature", ToHex(t.signature)}};
}

json::object Describe(const Header& h) {
  return json::object{{"ticket", Describe(h.ticket)},
                      {"scene", h.scene.Hex()},
                      {"volume", h.volume.Hex()},
                      {"params", Describe(h.params)},
                      {"station_software", h.station_software},
                      {"hand",
                       {{"kind", HandKindName(h.hand.kind)},
                        {"device", h.hand.device},
                        {"driver", h.hand.driver},
                        {"unit", h.hand.unit}}},
                      {"hash", HashSha256(EncodeHeader(h)).Hex()}};
}

json::object Describe(const Chunk& chunk) {
  json::array ticks;
  for (const Tick& tick : chunk.ticks) ticks.push_back(Describe(tick));
  return {{"head", Describe(chunk.head)},
          {"hash", chunk.hash.Hex()},
          {"signature", ToHex(chunk.signature)},
          {"payload", ToHex(EncodeColumns(chunk.ticks))},
          {"ticks", std::move(ticks)}};
}

json::object Describe(const Seal& seal) {
  return {{"attempt", seal.attempt.Text()},
          {"chunks", Number(seal.chunks)},
          {"ticks", Number(seal.ticks)},
          {"last_chunk", seal.last_chunk.Hex()},
          {"state_hash", Hex64(seal.state_hash)}};
}

json::object Describe(const TraceFile& file) {
  json::array chunks;
  for (const Bytes& bytes : file.chunks) {
    auto chunk = DecodeChunkHead(bytes);
    ENAMEL_CHECK(chunk.ok());
    json::object item = Describe(chunk->head);
    item["hash"] = chunk->hash.Hex();
    item["bytes"] = Number(bytes.size());
    chunks.push_back(std::move(item));
  }
  auto header = DecodeHeader(file.header);
  ENAMEL_CHECK(header.ok());
  json::object out{
      {"header", Describe(*header)}, {"chunks", std::move(chunks)}, {"truncated", file.truncated}};
  if (file.seal) out["seal"] = Describe(*file.seal);
  return out;
}

}  // namespace enamel::trace

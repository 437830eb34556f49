#include <cmath>
#include <cstring>

#include "common/base/bytes.h"
#include "common/base/check.h"
#include "common/board/board.h"

namespace {

using namespace enamel;

constexpr double kPeak_n = 12;

// A report of the bytes that are there: sealed, so that it gets past the checksum, or as it is.
void Deliver(EnBoard& board, ByteView bytes, bool sealed) {
  uint8_t report[kEnSpringBytes] = {};
  const size_t n = std::min<size_t>(bytes.size(), sizeof report);
  std::memcpy(report, bytes.data(), n);
  if (sealed) {
    report[0] = kEnSpringId;
    report[1] = kEnReportVersion;
    const uint16_t crc = EnCrc16(report, sizeof report - 2);
    report[54] = static_cast<uint8_t>(crc);
    report[55] = static_cast<uint8_t>(crc >> 8);
  }
  EnBoardReceive(&board, report, sealed ? sizeof report : n);
}

}  // namespace

// Any bytes as a host and a hand: first byte of a round says how many ticks pass, whether the next
// bytes are a report, and how the tip moves. The force stays within the peak, the energy in the tank
// within its cap, and what the board tells is encoded whole.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  EnBoardParams params{};
  params.tick_s = 1 / 8000.0;
  params.delay_ticks = 1;
  params.kc_n_per_m = 20e3;
  params.cell.half_m = {4.5e-6, 4.5e-6, 4.5e-6};
  params.peak_n = kPeak_n;
  params.damping_n_s_per_m = 6;
  EnBoard board;
  ENAMEL_CHECK(EnBoardStart(&board, &params));
  ByteReader in(ByteView(data, size));
  EnVec tip = {0, 0, 0};
  while (in.remaining() > 0) {
    const uint8_t what = in.U8();
    const size_t length = std::min<size_t>(in.remaining(), kEnSpringBytes);
    if (what & 1) Deliver(board, in.Raw(length), (what & 2) != 0);
    // To a place within the 2 m of a 32-bit nanometre, or a cell on.
    if (what & 4 && in.remaining() >= 4) {
      tip.x = in.I32() * 1e-9;
    } else {
      tip.y += 9e-6;
    }
    const int ticks = 1 << (what >> 4);
    for (int k = 0; k < ticks; ++k) {
      const EnVec force = EnBoardTick(&board, tip);
      const double square = force.x * force.x + force.y * force.y + force.z * force.z;
      ENAMEL_CHECK(square <= kPeak_n * kPeak_n * (1 + 1e-9));
      ENAMEL_CHECK(EnBoardDrives(&board) || square == 0);
      ENAMEL_CHECK(board.spring.tank.energy_j >= 0 &&
                   board.spring.tank.energy_j <= board.spring.tank.cap_j);
      ENAMEL_CHECK(board.spring.share >= 0 && board.spring.share <= 1);
    }
    EnPoseReport told{};
    EnBoardTell(&board, &told);
    uint8_t pose[kEnPoseBytes];
    EnWritePose(&told, pose);
    ENAMEL_CHECK(EnCheckReport(pose, sizeof pose, kEnPoseId, sizeof pose) == kEnWhole);
  }
  return 0;
}

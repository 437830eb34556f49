#include "server/jobs/judgement.h"

#include <bit>

namespace enamel::server {

Sha256 JudgementOf(const scoring::ScoreResult& score) {
  ByteWriter out;
  auto number = [&](double value) { out.U64(std::bit_cast<uint64_t>(value)); };
  out.U32(static_cast<uint32_t>(score.criteria.size()));
  for (const scoring::CriterionResult& criterion : score.criteria) {
    out.Text(criterion.name);
    number(criterion.points);
    number(criterion.max_points);
    out.Text(criterion.reason);
    out.U8(criterion.judged ? 1 : 0);
  }
  out.U32(static_cast<uint32_t>(score.gates.size()));
  for (const scoring::GateResult& gate : score.gates) {
    out.Text(gate.name);
    number(gate.share);
    out.Text(gate.reason);
  }
  number(score.score);
  out.U8(score.critical_fail ? 1 : 0);
  return HashSha256(out.bytes());
}

}  // namespace enamel::server

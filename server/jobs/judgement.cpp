#include "server/jobs/judgement.h"

#include <bit>

namespace enamel::server {

namespace {

// By codes and values, so that a sentence may be worded better without a release being withdrawn.
void WriteWhy(const std::vector<scoring::Reason>& reasons, const std::string& comment,
              ByteWriter& out) {
  out.U32(static_cast<uint32_t>(reasons.size()));
  for (const scoring::Reason& reason : reasons) {
    out.Text(reason.code);
    out.U32(static_cast<uint32_t>(reason.values.size()));
    for (double value : reason.values) out.U64(std::bit_cast<uint64_t>(value));
    for (const std::string& unit : reason.units) out.Text(unit);
  }
  out.Text(comment);
}

}  // namespace

Sha256 JudgementOf(const scoring::ScoreResult& score) {
  ByteWriter out;
  auto number = [&](double value) { out.U64(std::bit_cast<uint64_t>(value)); };
  out.U32(static_cast<uint32_t>(score.criteria.size()));
  for (const scoring::CriterionResult& criterion : score.criteria) {
    out.Text(criterion.name);
    number(criterion.lost);
    out.Text(scoring::NameOf(criterion.state));
    WriteWhy(criterion.reasons, criterion.comment, out);
    out.U8(criterion.judged ? 1 : 0);
  }
  out.U32(static_cast<uint32_t>(score.mistakes.size()));
  for (const scoring::Mistake& mistake : score.mistakes) {
    out.Text(scoring::NameOf(mistake.kind));
    out.Text(mistake.place);
    number(mistake.size);
    number(mistake.points);
  }
  number(score.score);
  out.U8(score.critical_fail ? 1 : 0);
  out.U32(static_cast<uint32_t>(score.borderline.size()));
  for (const scoring::CriticalResult& limit : score.borderline) out.Text(limit.error);
  return HashSha256(out.bytes());
}

}  // namespace enamel::server

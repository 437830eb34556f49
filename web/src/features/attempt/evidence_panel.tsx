import type { AttemptDetail } from "../../api/types";
import { formatDateTime, formatQuantity } from "../../base/format";
import { say } from "../../base/words";
import { Card } from "../../widgets/basics";

interface Props {
  readonly attempt: AttemptDetail;
  readonly evidence: NonNullable<AttemptDetail["evidence"]>;
}

// How the hand moved in an exam, for the reviewer: figures, and no verdict. Station and device are
// in the recording's panel beside it.
export function EvidencePanel({ attempt, evidence }: Props) {
  const tremor = evidence.tremor_um === null ? say("evidence.no_tremor") : formatQuantity(evidence.tremor_um, "um");
  const near = attempt.nearness;
  const figures: [string, string][] = [
    [say("evidence.tremor"), tremor],
    [say("evidence.still"), formatQuantity(evidence.still_percent, "%")],
    [say("evidence.late"), formatQuantity(evidence.late_percent, "%")],
    [say("evidence.gaps"), formatQuantity(evidence.gap_percent, "%")],
    [say("evidence.nearest"), near === null ? say("evidence.no_other") : formatQuantity(near.nearest_mm, "mm")],
    [say("evidence.unit"), attempt.hand.unit === "" ? say("evidence.no_unit") : attempt.hand.unit],
  ];
  return (
    <Card title={say("evidence.title")}>
      <p>
        {evidence.rank === null
          ? say("evidence.no_rank")
          : say("evidence.rank", { place: String(evidence.rank), count: evidence.of })}
      </p>
      {evidence.too_calm && (
        <p>{say("evidence.too_calm", { limit: formatQuantity(evidence.least_tremor_um, "um") })}</p>
      )}
      <dl class="facts stacked">
        {figures.map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>{value}</dd>
          </div>
        ))}
        <div>
          <dt>{say("evidence.sign_ins")}</dt>
          <dd>
            {evidence.sign_ins.length === 0 && say("common.none_there")}
            {evidence.sign_ins.map(({ at_ms, via }) => (
              <p key={`${at_ms} ${via}`}>
                {formatDateTime(at_ms)}, {via === "page" ? say("evidence.on_page") : via.replace(/^station /, "")}
              </p>
            ))}
          </dd>
        </div>
      </dl>
      <p class="hint">{say("evidence.hint")}</p>
    </Card>
  );
}

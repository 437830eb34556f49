import type { AttemptDetail } from "../../api/types";
import { formatDateTime, formatQuantity } from "../../base/format";
import { say } from "../../base/words";
import { Card } from "../../widgets/basics";

type Evidence = NonNullable<AttemptDetail["evidence"]>;
type SignOff = NonNullable<AttemptDetail["sign_off"]>;

// What speaks for and against an exam attempt, for the reviewer: who signed at the chair, and how
// the hand moved. Station and device are in the recording's panel beside it.
export function EvidencePanel({ attempt }: { readonly attempt: AttemptDetail }) {
  const { evidence, sign_off: signOff } = attempt;
  return (
    <>
      {signOff !== null && <Signatures signOff={signOff} />}
      {evidence !== null && <Hand attempt={attempt} evidence={evidence} />}
    </>
  );
}

function Signatures({ signOff }: { readonly signOff: SignOff }) {
  const text = (signed: SignOff["start"], none: string) =>
    signed === null ? none : say("evidence.signed", { name: signed.by, when: formatDateTime(signed.at_ms) });
  return (
    <Card title={say("evidence.sign_off")}>
      <dl class="facts stacked">
        <div>
          <dt>{say("evidence.start")}</dt>
          <dd>{text(signOff.start, say("evidence.start_unsigned"))}</dd>
        </div>
        <div>
          <dt>{say("evidence.end")}</dt>
          <dd>{text(signOff.end, say("evidence.end_unsigned"))}</dd>
        </div>
      </dl>
      <p class="hint">{say("evidence.sign_off_hint")}</p>
    </Card>
  );
}

interface Props {
  readonly attempt: AttemptDetail;
  readonly evidence: Evidence;
}

// Figures, and no verdict.
function Hand({ attempt, evidence }: Props) {
  const tremor = evidence.tremor_um === null ? say("evidence.no_tremor") : formatQuantity(evidence.tremor_um, "um");
  const near = attempt.nearness;
  const figures: [string, string][] = [
    [say("evidence.tremor"), tremor],
    [say("evidence.still"), formatQuantity(evidence.still_percent, "%")],
    [say("evidence.late"), formatQuantity(evidence.late_percent, "%")],
    [say("evidence.gaps"), formatQuantity(evidence.gap_percent, "%")],
    [say("evidence.nearest"), near === null ? say("evidence.no_other") : formatQuantity(near.nearest_mm, "mm")],
    [say("evidence.preset"), near?.preset ? formatQuantity(near.preset.nearest_mm, "mm") : say("common.none_there")],
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
      <p class="hint">
        {near?.worth_a_look === true ? "" : say("evidence.proves_nothing")} {say("evidence.hint")}
      </p>
    </Card>
  );
}

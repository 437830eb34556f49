import type { AttemptDetail, Criterion, Deduction, Gate, Score } from "../../api/types";
import { measuredText } from "../../api/worded";
import { formatDateTime, formatNumber, formatPoints, formatScore } from "../../base/format";
import { say } from "../../base/words";
import { Badge, Brief, Card, Notice, type Tone } from "../../widgets/basics";
import { still } from "../../widgets/still";
import { deductionsOf, deductionText } from "./deductions";
import { byLostPoints, failures, lostPoints, summarySentence } from "./summary";

const kPointsShown = 0.05; // fewer lost points are full marks
const kRingRadius = 52;
const kRingLength = 2 * Math.PI * kRingRadius;

interface Props {
  readonly score: Score; // as computed
  readonly reference: string | undefined;
  readonly override: AttemptDetail["override"]; // what an instructor says instead
  readonly onPlace: ((deduction: Deduction) => void) | undefined; // shows it on the tooth and the timeline
}

export const ScorePanel = still(function ScorePanel({ score, reference, override, onPlace }: Props) {
  return (
    <Card title={say("score.title")} className="score-card">
      <div class="score-head">
        <ScoreRing value={override?.score ?? score.score} critical={score.critical_fail && override === null} />
        <div>
          {override !== null && <OverrideText score={score} override={override} />}
          <p class="summary">
            {override !== null ? say("score.computed", { text: summarySentence(score) }) : summarySentence(score)}
          </p>
          <Badge tone={kTones[score.acceptance]}>{say(`acceptance.${score.acceptance}`)}</Badge>
          <p class="hint">
            {reference === undefined
              ? say("score.no_reference", { version: String(score.rubric_version) })
              : say("score.compared", { reference, version: String(score.rubric_version) })}
          </p>
        </div>
      </div>
      <Critical score={score} />
      <Gates gates={score.gates ?? []} />
      <Criteria criteria={byLostPoints(score.criteria)} deductions={score.deductions} onPlace={onPlace} />
    </Card>
  );
});

const kTones = { acceptable: "good", with_remarks: "warning", not_acceptable: "bad" } as const;

// What no examiner passes comes before the points.
function Critical({ score }: { readonly score: Score }) {
  const errors = failures(score);
  if (errors.length === 0) return null;
  return (
    <Notice tone="bad" title={say("score.not_acceptable")}>
      <ul>
        {errors.map((error) => (
          <li key={error}>{error}</li>
        ))}
      </ul>
      <p class="hint">{say("score.without_critical", { points: formatScore(score.points) })}</p>
    </Notice>
  );
}

function OverrideText({
  score,
  override,
}: {
  readonly score: Score;
  readonly override: NonNullable<AttemptDetail["override"]>;
}) {
  return (
    <Notice
      tone="warning"
      title={say("score.set_by", {
        by: override.by === "" ? say("score.an_instructor") : override.by,
        set: formatScore(override.score),
        computed: formatScore(score.score),
      })}
    >
      <p class="instructions">{override.reason}</p>
      <p class="hint">{formatDateTime(override.at_ms)}</p>
    </Notice>
  );
}

function ScoreRing({ value, critical }: { readonly value: number; readonly critical: boolean }) {
  const share = Math.min(Math.max(value / 100, 0), 1);
  return (
    <div class={`score-ring ${toneOf(share, critical)}`}>
      <svg viewBox="0 0 120 120" aria-hidden="true">
        <circle class="ring-track" cx="60" cy="60" r={kRingRadius} />
        <circle
          class="ring-value"
          cx="60"
          cy="60"
          r={kRingRadius}
          stroke-dasharray={`${share * kRingLength} ${kRingLength}`}
          transform="rotate(-90 60 60)"
        />
      </svg>
      <p class="score-number" data-testid="score">
        {formatScore(value)}
        <span class="score-of"> {say("score.of")}</span>
      </p>
    </div>
  );
}

function toneOf(share: number, critical: boolean): Tone {
  if (critical || share < 0.5) return "bad";
  return share < 0.75 ? "warning" : "good";
}

// What took points of every criterion: said before them, as it explains them.
function Gates({ gates }: { readonly gates: readonly Gate[] }) {
  const closing = gates.filter((gate) => gate.share < 1);
  return (
    <>
      {closing.map((gate) => (
        <Notice
          key={gate.name}
          tone="warning"
          title={say("score.gate", { percent: formatNumber(100 * gate.share, 1) })}
        >
          <p>{gate.reason}</p>
        </Notice>
      ))}
    </>
  );
}

interface Placed {
  readonly deductions: readonly Deduction[] | undefined;
  readonly onPlace: Props["onPlace"];
}

// Where points were lost, a line each; what has full marks is folded away.
function Criteria({ criteria, ...placed }: Placed & { readonly criteria: readonly Criterion[] }) {
  const isFull = (criterion: Criterion) => lostPoints(criterion) < kPointsShown;
  const lost = criteria.filter((criterion) => !isFull(criterion));
  const full = criteria.filter(isFull);
  const judged = full.filter(({ max_points: most }) => most > 0).length;
  return (
    <>
      {lost.length > 0 && <CriteriaTable label={say("score.criteria")} criteria={lost} {...placed} />}
      {full.length > 0 && (
        <details class="full-marks" open={lost.length === 0}>
          <summary>{say("score.full", { count: judged })}</summary>
          <CriteriaTable label={say("score.full", { count: judged })} criteria={full} {...placed} />
        </details>
      )}
    </>
  );
}

function CriteriaTable({
  label,
  criteria,
  ...placed
}: Placed & { readonly label: string; readonly criteria: readonly Criterion[] }) {
  return (
    <table class="criteria">
      <caption class="hidden">{label}</caption>
      <thead class="hidden">
        <tr>
          <th scope="col">{say("common.criterion")}</th>
          <th scope="col">{say("score.measured")}</th>
          <th scope="col">{say("common.points")}</th>
          <th scope="col">{say("score.show_me")}</th>
        </tr>
      </thead>
      <tbody>
        {criteria.map((criterion) => (
          <CriterionRow key={criterion.name} criterion={criterion} {...placed} />
        ))}
      </tbody>
    </table>
  );
}

function CriterionRow({ criterion, deductions, onPlace }: Placed & { readonly criterion: Criterion }) {
  const share = criterion.max_points > 0 ? criterion.points / criterion.max_points : 1;
  const places = deductionsOf(deductions, criterion.name);
  return (
    <tr>
      <th scope="row">
        {criterion.reason === "" && places.length === 0 ? (
          criterion.title
        ) : (
          <details>
            <summary>{criterion.title}</summary>
            <p class="reason">{criterion.reason}</p>
            {places.map((deduction) => (
              <p class="reason" key={deduction.left ? "left" : "over"}>
                {deductionText(deduction)}
              </p>
            ))}
          </details>
        )}
      </th>
      <td class="number">
        {criterion.judged === false ? "–" : measuredText(criterion.name, criterion.value, criterion.unit)}
      </td>
      <td class={`number points ${toneOf(share, false)}`}>
        {criterion.max_points === 0 ? (
          say("insight.not_judged")
        ) : (
          <>
            <b>{formatPoints(criterion.points)}</b> / {formatPoints(criterion.max_points)}
          </>
        )}
      </td>
      <td class="number">
        {onPlace !== undefined &&
          places.map((deduction) => (
            <button
              type="button"
              class="button small quiet"
              key={deduction.left ? "left" : "over"}
              title={deductionText(deduction)}
              onClick={() => onPlace(deduction)}
            >
              <Brief
                shown={say(
                  places.length === 1 ? "score.show_me" : deduction.left ? "score.show_left" : "score.show_over",
                )}
                full={say("score.show_which", { criterion: criterion.title, what: deductionText(deduction) })}
              />
            </button>
          ))}
      </td>
    </tr>
  );
}

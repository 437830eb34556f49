import type { AttemptDetail, Criterion, Mistake, Region, Score } from "../../api/types";
import { wordedTitle } from "../../api/builtin_words";
import { borderlineText, measuredText, mistakeText, regionText, regionTitle, remedyText } from "../../api/worded";
import { isWorthAdvice } from "../../api/worth";
import { formatDateTime, formatPoints, formatScore, lostText } from "../../base/format";
import { spokenLanguage } from "../../base/language";
import { say } from "../../base/words";
import { Badge, Brief, Card, Notice, type Tone } from "../../widgets/basics";
import { still } from "../../widgets/still";
import { deductionsOf, deductionText, type FaultPlace, placeOf } from "./deductions";
import { failures, type GroupLoss, groupsOf, kPointsShown, summarySentence } from "./summary";

const kShownAtFirst = 3; // mistakes: more than that nobody works on at once
const kRingRadius = 52;
const kRingLength = 2 * Math.PI * kRingRadius;

interface Props {
  readonly score: Score; // as computed
  readonly reference: string | undefined; // who cut it; undefined: nobody, or somebody whose name is not there
  readonly override: AttemptDetail["override"]; // what an instructor says instead
  readonly own: boolean; // the reader made the attempt
  readonly graded: boolean; // a person decides what is borderline, before the release
  readonly onPlace: ((place: FaultPlace) => void) | undefined; // shows it on the tooth and the timeline
}

export const ScorePanel = still(function ScorePanel({ score, reference, override, own, graded, onPlace }: Props) {
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
          <ToBeDone regions={score.regions} />
          <p class="hint">{comparedText(score, reference)}</p>
        </div>
      </div>
      <Critical score={score} />
      <Borderline score={score} undecided={graded && override === null} decided={graded && override !== null} />
      <Mistakes score={score} own={own} onPlace={onPlace} />
      <Groups groups={groupsOf(score)} />
      <Board rows={score.board} />
    </Card>
  );
});

const kTones = { acceptable: "good", with_remarks: "warning", not_acceptable: "bad" } as const;
const kStateTones = { acceptable: "good", modify: "warning", redo: "bad" } as const;

function comparedText({ reference_attempt: attempt, rubric_version }: Score, reference: string | undefined): string {
  const version = String(rubric_version);
  return attempt === ""
    ? say("score.own_target", { version })
    : say("score.compared", { reference: reference ?? say("attempt.earlier_reference"), version });
}

// Why the whole is not acceptable, or has remarks, where no critical error says it.
function ToBeDone({ regions }: { readonly regions: readonly Region[] }) {
  const state = (["redo", "modify"] as const).find((each) => regions.some((region) => region.state === each));
  if (state === undefined) return null;
  const names = regions.filter((region) => region.state === state).map(regionTitle);
  return <p>{say(`score.${state}`, { places: names.join(spokenLanguage() === "zh" ? "、" : ", ") })}</p>;
}

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

// Limits that lie within the uncertainty of what was measured.
function Borderline({
  score: { borderline },
  undecided,
  decided,
}: {
  readonly score: Score;
  readonly undecided: boolean;
  readonly decided: boolean;
}) {
  if (borderline.length === 0) return null;
  return (
    <Notice tone="warning" title={say("score.borderline")}>
      <ul>
        {borderline.map((limit) => (
          <li key={`${limit.error} ${limit.name}`}>{borderlineText(limit)}</li>
        ))}
      </ul>
      <p class="hint">
        {say(decided ? "score.borderline_decided" : undecided ? "score.borderline_decide" : "score.borderline_scored")}
      </p>
    </Notice>
  );
}

// As a licensing board grades: by category, the worst part decides. Nothing where no limit at all was read.
function Board({ rows }: { readonly rows: Score["board"] }) {
  if (rows.every(({ grade }) => grade === null)) return null;
  return (
    <section class="board">
      <h3>{say("board.title")}</h3>
      <dl class="facts stacked">
        {rows.map(({ category, grade, borderline, source }) => (
          <div key={category}>
            <dt>{say(`group.${category}`)}</dt>
            <dd>
              {grade === null ? say("board.no_limit") : <BoardGrade grade={grade} borderline={borderline} />}
              {source !== "" && <p class="hint">{wordedTitle(source)}</p>}
            </dd>
          </div>
        ))}
      </dl>
    </section>
  );
}

function BoardGrade({
  grade,
  borderline,
}: {
  readonly grade: "satisfactory" | "critical";
  readonly borderline: boolean;
}) {
  if (borderline) return <Badge tone="warning">{say("score.borderline")}</Badge>;
  return <Badge tone={grade === "critical" ? "bad" : "good"}>{say(`board.${grade}`)}</Badge>;
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

interface Placed {
  readonly score: Score;
  readonly onPlace: Props["onPlace"];
}
interface Numbered {
  readonly mistake: Mistake;
  readonly number: number; // in the score, from 0
}

// The dearest mistakes with what to do about them; the others are folded away.
function Mistakes({ score, own, onPlace }: Placed & { readonly own: boolean }) {
  const all = score.mistakes
    .map((mistake, number): Numbered => ({ mistake, number }))
    .filter(({ mistake }) => mistake.points >= kPointsShown);
  const worth = all.filter(({ mistake }) => isWorthAdvice(mistake));
  const small = all.slice(worth.length); // the dearest are first
  const rest = worth.slice(kShownAtFirst);
  const list = (items: readonly Numbered[]) => (
    <ol start={(items[0]?.number ?? 0) + 1}>
      {items.map((each) => (
        <MistakeItem key={each.number} {...each} score={score} onPlace={onPlace} />
      ))}
    </ol>
  );
  return (
    <section class="mistakes">
      <h3>{countText(all.length, worth.length, own)}</h3>
      {score.beyond > 0 && <p>{say("score.beyond", { points: formatPoints(score.beyond) })}</p>}
      {worth.length > 0 && list(worth.slice(0, kShownAtFirst))}
      {rest.length > 0 && (
        <details>
          <summary>{say("score.more_mistakes", { count: rest.length })}</summary>
          {list(rest)}
        </details>
      )}
      {small.length > 0 && (
        <details>
          <summary>{say("score.smallest", { count: small.length })}</summary>
          {list(small)}
        </details>
      )}
    </section>
  );
}

function countText(all: number, worth: number, own: boolean): string {
  if (all === 0) return say("score.no_mistake");
  if (worth === 0) return say("score.small_mistakes");
  return say(own ? "score.your_mistakes" : "score.mistakes", { count: worth });
}

function MistakeItem({ mistake, number, score, onPlace }: Placed & Numbered) {
  const text = mistakeText(mistake);
  const deductions = deductionsOf(score, number);
  const place = deductions.length === 0 ? placeOf(score, number) : undefined;
  const remedy = isWorthAdvice(mistake) ? remedyText(mistake) : "";
  return (
    <li>
      <div class="mistake">
        <b>{text}</b>
        <span class="lost">{lostText(mistake.points)}</span>
        {deductions.map((deduction) => (
          <ShowButton
            key={deduction.left ? "left" : "over"}
            shown={say(
              deductions.length === 1 ? "score.show_me" : deduction.left ? "score.show_left" : "score.show_over",
            )}
            full={say("score.show_which", { mistake: text, what: deductionText(deduction) })}
            place={deduction}
            onPlace={onPlace}
          />
        ))}
        {place !== undefined && (
          <ShowButton
            shown={say("score.show_me")}
            full={`${say("score.show_me")} ${text}`}
            place={place}
            onPlace={onPlace}
          />
        )}
      </div>
      {deductions.map((deduction) => (
        <p class="reason" key={deduction.left ? "left" : "over"}>
          {deductionText(deduction)}
        </p>
      ))}
      {remedy !== "" && <p class="remedy">{remedy}</p>}
    </li>
  );
}

interface ShowProps {
  readonly shown: string;
  readonly full: string;
  readonly place: FaultPlace;
  readonly onPlace: Props["onPlace"];
}

function ShowButton({ shown, full, place, onPlace }: ShowProps) {
  if (onPlace === undefined) return null;
  return (
    <button type="button" class="button small quiet" title={full} onClick={() => onPlace(place)}>
      <Brief shown={shown} full={full} />
    </button>
  );
}

// What each group cost; unfolded, what each of its regions or figures did.
function Groups({ groups }: { readonly groups: readonly GroupLoss[] }) {
  return (
    <details>
      <summary>{say("score.by_group")}</summary>
      <ul class="groups">
        {groups.map((group) => (
          <li key={group.group}>
            <details>
              <summary>
                <span>{group.title}</span>
                <span class="lost">{lostText(group.lost)}</span>
                <Badge tone={kStateTones[group.state]}>{say(`grade_state.${group.state}`)}</Badge>
              </summary>
              <Parts group={group} />
            </details>
          </li>
        ))}
      </ul>
    </details>
  );
}

function Parts({ group: { title, regions, criteria } }: { readonly group: GroupLoss }) {
  return (
    <table class="parts">
      <caption class="hidden">{title}</caption>
      <thead class="hidden">
        <tr>
          <th scope="col">{say("score.part")}</th>
          <th scope="col">{say("score.measured")}</th>
          <th scope="col">{say("score.lost")}</th>
          <th scope="col">{say("common.state")}</th>
        </tr>
      </thead>
      <tbody>
        {regions.map((region) => (
          <PartRow
            key={region.name}
            title={regionTitle(region)}
            measured={regionText(region)}
            lost={lostText(region.lost)}
            state={region.state}
          />
        ))}
        {criteria.map((criterion) => (
          <PartRow
            key={criterion.name}
            title={criterion.title}
            measured={criterion.judged ? measuredText(criterion.name, criterion.value, criterion.unit) : ""}
            lost={criterion.judged ? lostText(criterion.lost) : say("insight.not_judged")}
            state={criterion.judged ? criterion.state : undefined}
            reason={criterion.reason}
          />
        ))}
      </tbody>
    </table>
  );
}

interface PartProps {
  readonly title: string;
  readonly measured: string; // empty: nothing to say
  readonly lost: string;
  readonly state: Criterion["state"] | undefined; // undefined: not judged
  readonly reason?: string;
}

function PartRow({ title, measured, lost, state, reason = "" }: PartProps) {
  return (
    <tr>
      <th scope="row">
        {title}
        {reason !== "" && <p class="reason">{reason}</p>}
      </th>
      <td class="number measured">{measured}</td>
      <td class="number">{lost}</td>
      <td class={`state ${state === undefined ? "" : kStateTones[state]}`}>
        {state !== undefined && (
          <Brief
            shown={state === "acceptable" ? "✓" : say(`grade_state.${state}`)}
            full={say(`grade_state.${state}`)}
          />
        )}
      </td>
    </tr>
  );
}

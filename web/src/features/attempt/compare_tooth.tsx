import { useMemo, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Anatomy } from "../../api/tooth_number";
import type { Attempt, AttemptDetail } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatDateTime, formatMoment, formatScore } from "../../base/format";
import { say } from "../../base/words";
import { Loading, Segmented } from "../../widgets/basics";
import { GhostLegend } from "../../widgets/tooth/legend";
import { type LookHandle, ToothView } from "../../widgets/tooth/tooth_view";
import type { Placement, Sync } from "./compare";
import { outlook } from "./deviation";
import type { ToothChoices } from "./tooth_tools";
import type { Other } from "./use_other";

const kMostOthers = 50;

interface ChoiceProps {
  readonly client: Client;
  readonly attempt: AttemptDetail;
  readonly staff: boolean;
  readonly chosen: string | undefined;
  readonly onChoose: (id: string | undefined, name: string) => void;
}

// The attempt that this one is compared with: the reference, another one of the same person, or of
// somebody else's whom one may see.
export function CompareChoice({ client, attempt, staff, chosen, onChoose }: ChoiceProps) {
  const [asked, setAsked] = useState(false); // the list is fetched when somebody wants it
  const { loaded } = useRequest(asked ? attempt.exercise.id : undefined, (signal) =>
    client.attempts({ exercise: attempt.exercise.id, state: "scored", limit: kMostOthers }, signal),
  );
  const others = loaded.state === "ready" ? loaded.value.items.filter((other) => other.id !== attempt.id) : [];
  const own = others.filter((other) => other.person.id === attempt.person.id);
  const reference = comparable(attempt, staff);
  return (
    <select
      aria-label={say("compare.with")}
      value={chosen ?? ""}
      onFocus={() => setAsked(true)}
      onPointerDown={() => setAsked(true)}
      onChange={({ currentTarget: { value, selectedOptions } }) =>
        onChoose(value || undefined, selectedOptions[0]?.title ?? "")
      }
    >
      <option value="">{say("compare.nothing")}</option>
      {reference !== undefined && (
        <option value={reference.attempt_id} title={referenceName(reference)}>
          {referenceName(reference)}
        </option>
      )}
      {own.length > 0 && (
        <optgroup label={say("compare.same_person")}>
          {own.map((other) => (
            <option key={other.id} value={other.id} title={attemptName(other)}>
              {title(other)}
            </option>
          ))}
        </optgroup>
      )}
      {others.length > own.length && (
        <optgroup label={say("compare.others")}>
          {others
            .filter((other) => !own.includes(other))
            .map((other) => (
              <option key={other.id} value={other.id} title={attemptName(other)}>
                {attemptName(other)}
              </option>
            ))}
        </optgroup>
      )}
      {asked && loaded.state === "loading" && <option disabled>{say("loading.short")}</option>}
    </select>
  );
}

// Students are offered it with the dentist's consent: only then does the answer name the dentist.
type Reference = NonNullable<AttemptDetail["reference"]>;
export function comparable({ id, reference }: AttemptDetail, staff: boolean): Reference | undefined {
  if (reference === null || reference.attempt_id === id) return undefined;
  return staff || reference.dentist !== null ? reference : undefined;
}

const title = (attempt: Attempt) =>
  `${formatDateTime(attempt.ticketed_ms)}${attempt.score === null ? "" : `, ${formatScore(attempt.score)}`}`;

// Whose it is, when, and its score.
export function attemptName(attempt: Attempt): string {
  return `${attempt.person.display_name}, ${title(attempt)}`;
}

export function referenceName({ dentist }: Reference): string {
  return dentist === null ? say("compare.reference") : say("compare.reference_of", { dentist });
}

interface BarProps {
  readonly other: Other;
  readonly placement: Placement;
  readonly onPlacement: (placement: Placement) => void;
}

// Under the teeth: placement and moment of the other one, and the legend of its colours.
export function CompareBar({ other, placement, onPlacement }: BarProps) {
  return (
    <div class="compare-bar">
      <Segmented
        legend={say("compare.placement")}
        name="compare-placement"
        value={placement}
        onChange={onPlacement}
        choices={[
          { value: "side", title: say("compare.side") },
          { value: "top", title: say("compare.top") },
        ]}
      />
      <select
        aria-label={say("compare.moment")}
        value={other.sync}
        onChange={(event) => other.setSync(event.currentTarget.value as Sync)}
      >
        <option value="time">{say("compare.same_time")}</option>
        <option value="removed">{say("compare.same_removed")}</option>
        <option value="path">{say("compare.same_path")}</option>
      </select>
      <span class="other-time">{other.at === undefined ? "" : formatMoment(other.at)}</span>
      {placement === "top" && (isReady(other) ? <GhostLegend /> : <OtherMissing other={other} />)}
    </div>
  );
}

export function isReady(other: Other): boolean {
  return other.playback.state.state === "ready";
}

// Why the other attempt is not seen.
function OtherMissing({
  other: {
    playback: { state },
  },
}: {
  readonly other: Other;
}) {
  if (state.state === "loading") return <Loading what={say("loading.other_attempt")} />;
  if (state.state === "ready") return null;
  return (
    <p class="hint" role="status">
      {say("compare.cannot", { reason: state.state === "failed" ? state.error.message : state.message })}
    </p>
  );
}

interface Props {
  readonly name: string;
  readonly other: Other;
  readonly anatomy: Anatomy | undefined; // of the same exercise
  readonly choices: ToothChoices;
  readonly look: LookHandle; // both are looked at alike
}

// Another attempt, at the moment that belongs to this one's.
export function OtherTooth({ name, other, anatomy, choices, look }: Props) {
  const { playback } = other;
  const compared = playback.deviation.state === "ready" ? playback.deviation.compared : undefined;
  const cut = playback.head?.cut;
  const angled = useMemo(
    () => ({ ...outlook(compared, undefined, anatomy?.mesial), cavity: cut }),
    [compared, anatomy, cut],
  );
  if (!isReady(other) || playback.film === undefined) return <OtherMissing other={other} />;
  return (
    <div class="other-tooth">
      <ToothView
        led
        film={playback.film}
        anatomy={anatomy}
        busy={!playback.drawn}
        mode={compared === undefined || playback.showing ? "tissue" : choices.mode}
        label={`${say("compare.other")} ${name}`}
        name={name}
        angled={angled}
        section={choices.section}
        look={look}
      />
    </div>
  );
}

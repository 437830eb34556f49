import type { Anatomy } from "../../api/tooth_number";
import { formatMoment } from "../../base/format";
import { say } from "../../base/words";
import type { AngledView, ColorMode } from "../../tooth/messages";
import { Loading, Segmented } from "../../widgets/basics";
import { GhostLegend } from "../../widgets/tooth/legend";
import { type LookHandle, ToothView } from "../../widgets/tooth/tooth_view";
import type { Placement, Sync } from "./compare";
import type { ToothChoices } from "./tooth_choices";
import type { Other } from "./use_other";

// The other attempt and what belongs to it, loaded when there is one.

interface BarProps {
  readonly other: Other;
  readonly placement: Placement;
  readonly onPlacement: (placement: Placement) => void;
  readonly cut: boolean; // then the other one is an outline, which the section's legend names
}

// Under the teeth: placement and moment of the other one, and the legend of its colours.
export function CompareBar({ other, placement, onPlacement, cut }: BarProps) {
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
      {placement === "top" && (other.ready ? !cut && <GhostLegend /> : <OtherMissing other={other} />)}
    </div>
  );
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
  readonly mode: ColorMode; // of both
  readonly angled: AngledView;
  readonly look: LookHandle; // both are looked at alike
}

// Another attempt, at the moment that belongs to this one's.
export function OtherTooth({ name, other, anatomy, choices, mode, angled, look }: Props) {
  const { playback } = other;
  if (!other.ready || playback.film === undefined) return <OtherMissing other={other} />;
  return (
    <div class="other-tooth">
      <ToothView
        led
        film={playback.film}
        anatomy={anatomy}
        busy={!playback.drawn}
        mode={mode}
        label={`${say("compare.other")} ${name}`}
        name={name}
        angled={angled}
        section={choices.section}
        look={look}
      />
    </div>
  );
}

import type { ComponentChildren } from "preact";
import { Segmented } from "../../widgets/basics";
import type { ColorMode } from "../../widgets/tooth/scene";
import type { SectionPlane } from "../../widgets/tooth/section";

export interface ToothChoices {
  readonly mode: ColorMode;
  readonly section: SectionPlane | undefined;
  readonly follow: boolean;
}

interface Props {
  readonly choices: ToothChoices;
  readonly onChoices: (choices: ToothChoices) => void;
  readonly compared: boolean;                   // there is a deviation to colour by
  readonly played: boolean;                     // there is a bur to follow
  readonly children?: ComponentChildren;
}

const kSections: ReadonlyArray<readonly [SectionPlane["across"], string]> = [
  ["y", "Mesio-distal"], ["x", "Bucco-lingual"], ["z", "Horizontal"], ["view", "Along the view"],
];
const kSteps = 100;

// What is shown of the tooth: by which colours, cut where, and whether one stays at the bur.
export function ToothTools({ choices, onChoices, compared, played, children }: Props) {
  const { mode, section, follow } = choices;
  const set = (change: Partial<ToothChoices>) => onChoices({ ...choices, ...change });
  const chooseSection = (across: string) => {
    const known = kSections.find(([name]) => name === across)?.[0];
    set({ section: known === undefined ? undefined : { across: known, share: 0, flipped: false } });
  };
  return (
    <div class="tooth-choices no-print">
      {compared && <Segmented legend="Colours show" name="tooth-mode" value={mode} onChange={(value) => set({ mode: value })}
                              choices={[{ value: "deviation", title: "Deviation" }, { value: "tissue", title: "Tissues" }]} />}
      <select aria-label="Section" value={section?.across ?? ""} onChange={(event) => chooseSection(event.currentTarget.value)}>
        <option value="">No section</option>
        {kSections.map(([across, title]) => <option key={across} value={across}>{title}</option>)}
      </select>
      {section !== undefined && (
        <>
          <input type="range" min={-kSteps} max={kSteps} value={section.share * kSteps} aria-label="Place of the section"
                 aria-valuetext={`${Math.round(section.share * 100)} percent from the middle to the edge`} onInput={(event) => set({ section: { ...section, share: Number(event.currentTarget.value) / kSteps } })} />
          <button type="button" class="button small" aria-pressed={section.flipped} onClick={() => set({ section: { ...section, flipped: !section.flipped } })}>Other side</button>
        </>
      )}
      {played && <button type="button" class="button small" aria-pressed={follow} onClick={() => set({ follow: !follow })}>Follow the bur</button>}
      {children}
    </div>
  );
}

import type { ComponentChildren } from "preact";
import { say } from "../../base/words";
import { Segmented } from "../../widgets/basics";
import { part } from "../../widgets/part";
import type { SectionPlane } from "../../tooth/messages";

import type { ToothChoices } from "./tooth_choices";

export const Closer = part("closer", () => import("./closer"));

interface Props {
  readonly choices: ToothChoices;
  readonly onChoices: (choices: ToothChoices) => void;
  readonly compared: boolean; // there is a deviation to colour by
  readonly played: boolean; // there is a bur to follow
  readonly measures: boolean; // points for distances are put
  readonly onMeasures: (on: boolean) => void;
  readonly children?: ComponentChildren;
}

const kSections: readonly SectionPlane["across"][] = ["y", "x", "z", "view"];

// What is shown of the tooth: by which colours, cut where, and whether one stays at the bur.
export function ToothTools({ choices, onChoices, compared, played, measures, onMeasures, children }: Props) {
  const { mode, section, follow, target } = choices;
  const set = (change: Partial<ToothChoices>) => onChoices({ ...choices, ...change });
  const chooseSection = (across: string) => {
    const known = kSections.find((name) => name === across);
    set({ section: known === undefined ? undefined : { across: known, share: 0, flipped: false } });
  };
  return (
    <div class="tooth-choices no-print">
      {compared && (
        <Segmented
          legend={say("tools.colours")}
          name="tooth-mode"
          value={mode}
          onChange={(value) => set({ mode: value })}
          choices={[
            { value: "deviation", title: say("tools.deviation") },
            { value: "tissue", title: say("tools.tissues") },
          ]}
        />
      )}
      <select
        aria-label={say("section.title")}
        value={section?.across ?? ""}
        onChange={(event) => chooseSection(event.currentTarget.value)}
      >
        <option value="">{say("section.none")}</option>
        {kSections.map((across) => (
          <option key={across} value={across}>
            {say(`section.${across}`)}
          </option>
        ))}
      </select>
      {section !== undefined && (
        <Closer
          show={({ SectionTools }) => <SectionTools section={section} onSection={(moved) => set({ section: moved })} />}
        />
      )}
      {played && (
        <button type="button" class="button small" aria-pressed={follow} onClick={() => set({ follow: !follow })}>
          {say("tools.follow")}
        </button>
      )}
      <button
        type="button"
        class="button small"
        aria-pressed={target}
        title={say("tools.target_hint")}
        onClick={() => set({ target: !target })}
      >
        {say("tools.target")}
      </button>
      <button
        type="button"
        class="button small"
        aria-pressed={measures}
        title={say("measure.hint")}
        onClick={() => onMeasures(!measures)}
      >
        {say("tools.measure")}
      </button>
      {children}
    </div>
  );
}

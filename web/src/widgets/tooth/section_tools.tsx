import { formatNumber } from "../../base/format";
import { say } from "../../base/words";
import type { SectionPlane } from "../../tooth/messages";

const kSteps = 100;

interface Props {
  readonly section: SectionPlane;
  readonly onSection: (section: SectionPlane) => void;
}

// Where a tooth is cut open, and which side of it is hidden.
export function SectionTools({ section, onSection }: Props) {
  return (
    <>
      <input
        type="range"
        min={-kSteps}
        max={kSteps}
        value={section.share * kSteps}
        aria-label={say("section.place")}
        aria-valuetext={say("section.percent", { percent: formatNumber(section.share * 100, 0) })}
        onInput={(event) => onSection({ ...section, share: Number(event.currentTarget.value) / kSteps })}
      />
      <button
        type="button"
        class="button small"
        aria-pressed={section.flipped}
        onClick={() => onSection({ ...section, flipped: !section.flipped })}
      >
        {say("section.other")}
      </button>
    </>
  );
}

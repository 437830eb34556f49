import type { NextStep } from "../api/progress";
import { formatPoints } from "../base/format";
import { say } from "../base/words";
import { Notice } from "./basics";

// What to work on, and why.
export function NextStepNotice({ next: { title, lost, times, of, remedy } }: { readonly next: NextStep }) {
  const points = formatPoints(lost);
  return (
    <Notice tone="neutral" title={say("progress.next")}>
      <p>
        <b>{title}</b>
      </p>
      <p>
        {of === 1
          ? say("progress.lost_once", { points })
          : say("progress.lost_often", { points, times: String(times), count: String(of) })}
      </p>
      {remedy !== "" && <p>{remedy}</p>}
    </Notice>
  );
}

import type { NextStep } from "../api/progress";
import { formatPoints } from "../base/format";
import { say } from "../base/words";
import { Notice } from "./basics";

// What to work on, and why.
export function NextStepNotice({ next }: { readonly next: NextStep }) {
  const points = formatPoints(next.lost);
  return (
    <Notice tone="neutral" title={say("progress.next", { title: next.title })}>
      <p>
        {next.of === 1 ? say("progress.lost_once", { points }) : say("progress.lost_often", { points, count: next.of })}{" "}
        {next.reason}
      </p>
    </Notice>
  );
}

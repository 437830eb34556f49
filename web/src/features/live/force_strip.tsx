import { forceSize, type LiveRow } from "../../api/live";
import { formatNumber } from "../../base/format";
import { say } from "../../base/words";
import { Canvas, type Drawing } from "../../widgets/canvas";
import { line } from "./lines";
import { largestForce, shownSeconds } from "./track";

const kMinForceN = 2;

interface Props {
  readonly rows: readonly LiveRow[];
  readonly rateHz: number;
}

// Force over the last seconds, newest on the right.
export function ForceStrip({ rows, rateHz }: Props) {
  const top = Math.max(kMinForceN, Math.ceil(largestForce(rows)));
  const seconds = shownSeconds(rows, rateHz);
  const draw = ({ context, width, height, color }: Drawing) => {
    const end = rows.at(-1)?.tick ?? 0;
    const x = (tick: number) => width * (1 - (end - tick) / (seconds * rateHz));
    const y = (force: number) => height - 2 - (height - 16) * (force / top);
    context.strokeStyle = color("--line");
    context.fillStyle = color("--text-soft");
    context.font = "11px system-ui, sans-serif";
    for (const level of [top / 2, top]) {
      line(context, [
        [0, y(level)],
        [width, y(level)],
      ]);
      context.fillText(`${formatNumber(level, 1)} N`, 2, y(level) - 3);
    }
    context.strokeStyle = color("--plot-force");
    context.lineWidth = 1.5;
    line(
      context,
      rows.map((row) => [x(row.tick), y(forceSize(row))]),
    );
  };
  return (
    <Canvas
      className="live-strip"
      stamp={rows}
      draw={draw}
      label={say("live.force_label", { seconds: formatNumber(seconds, 0), force: formatNumber(largestForce(rows)) })}
    />
  );
}

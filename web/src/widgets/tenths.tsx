import { say } from "../base/words";

const kBar = 8;
const kHeight = 26;

// Counts by tenths of a scale from 0 to 100: bars, and the same in words.
export function Tenths({ counts, what }: { readonly counts: readonly number[]; readonly what: string }) {
  const most = Math.max(1, ...counts);
  return (
    <svg
      class="tenths"
      viewBox={`0 0 ${kBar * counts.length} ${kHeight + 2}`}
      role="img"
      aria-label={`${what}: ${tenthsText(counts)}`}
    >
      <title>{tenthsText(counts)}</title>
      {counts.map(
        (count, i) =>
          count > 0 && (
            <rect
              key={i}
              x={i * kBar + 0.5}
              width={kBar - 1}
              y={kHeight * (1 - count / most)}
              height={kHeight * (count / most)}
            />
          ),
      )}
      <line x1={0} x2={kBar * counts.length} y1={kHeight + 0.5} y2={kHeight + 0.5} />
    </svg>
  );
}

// "2 from 0 to 10 %, 5 from 90 to 100 %".
export function tenthsText(counts: readonly number[]): string {
  const told = counts.flatMap((count, i) =>
    count === 0 ? [] : [say("insight.tenth", { count, from: 10 * i, to: 10 * (i + 1) })],
  );
  return told.length === 0 ? say("insight.no_values") : told.join(", ");
}

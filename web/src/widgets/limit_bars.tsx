import { formatNumber } from "../base/format";
import { say } from "../base/words";

export interface Limited {
  readonly title: string;
  readonly share: number; // of the limit: 1 is on it
  readonly ok: boolean;
}

const kRange = 1.5; // of the limit; what is more is drawn to the end

// How much of its limit each figure uses. A table beside it has the numbers.
export function LimitBars({ items, label }: { readonly items: readonly Limited[]; readonly label: string }) {
  return (
    <div
      class="limit-bars"
      role="img"
      aria-label={`${label}: ${items.map((item) => `${item.title} ${percent(item.share)}`).join(", ")}`}
    >
      {items.map((item) => (
        <div key={item.title} class="limit-bar">
          <span>{item.title}</span>
          <span class="limit-track">
            <span
              class={item.ok ? "limit-fill" : "limit-fill bad"}
              style={{ width: `${(100 * Math.min(Math.max(item.share, 0), kRange)) / kRange}%` }}
            />
            <span class="limit-mark" style={{ left: `${100 / kRange}%` }} />
          </span>
        </div>
      ))}
    </div>
  );
}

function percent(share: number): string {
  return Number.isFinite(share) ? say("limit.used", { percent: formatNumber(100 * share, 0) }) : say("limit.none");
}

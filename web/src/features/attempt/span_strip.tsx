import { formatMoment, formatNumber } from "../../base/format";
import { say } from "../../base/words";
import { still } from "../../widgets/still";
import { kContactN, type Span, type SpanKind } from "./spans";

const kKinds: readonly SpanKind[] = ["contact", "limit", "late", "gap", "lost"];

const titleOf = (kind: SpanKind) => say(`span_kind.${kind}`);
const meaningOf = (kind: SpanKind) =>
  kind === "contact" ? say("span_meaning.contact", { force: formatNumber(kContactN, 2) }) : say(`span_meaning.${kind}`);

interface Props {
  readonly spans: readonly Span[];
  readonly fromS: number; // where the axis begins and ends
  readonly toS: number;
  readonly onTime: (timeS: number) => void;
}

// Parts of the attempt on the axis of time. For the eye and the pointer: keys go from mark to mark,
// and the list says the same.
export const SpanStrip = still(function SpanStrip({ spans, fromS, toS, onTime }: Props) {
  const share = (timeS: number) => 100 * Math.min(1, Math.max(0, (timeS - fromS) / (toS - fromS || 1)));
  const press = (event: MouseEvent) => {
    const box = (event.currentTarget as HTMLElement).getBoundingClientRect();
    onTime(fromS + ((event.clientX - box.left) / box.width) * (toS - fromS));
  };
  return (
    // biome-ignore lint/a11y/useKeyWithClickEvents: the page's keys x and z go from one to the next
    <div class="spans" role="img" aria-label={stripText(spans)} onClick={press}>
      {spans.map((span, i) => (
        <span
          key={i}
          class={`span ${span.kind}`}
          style={{ left: `${share(span.fromS)}%`, right: `${100 - share(span.toS)}%` }}
          title={spanText(span)}
        />
      ))}
    </div>
  );
});

// The legend of the kinds that are on the strip.
export const SpanLegend = still(function SpanLegend({ spans }: { readonly spans: readonly Span[] }) {
  return (
    <p class="span-legend hint">
      {kKinds
        .filter((kind) => spans.some((span) => span.kind === kind))
        .map((kind) => (
          <span key={kind} class="legend-item" title={meaningOf(kind)}>
            <span class={`span-sample ${kind}`} />
            {titleOf(kind)}
          </span>
        ))}
    </p>
  );
});

function spanText({ kind, fromS, toS }: Span): string {
  const [from, to] = [formatMoment(fromS), formatMoment(toS)];
  return kind === "lost" ? `${titleOf(kind)}, ${from}` : say("span_kind.from_to", { title: titleOf(kind), from, to });
}

function stripText(spans: readonly Span[]): string {
  const counts = kKinds
    .map((kind) => [titleOf(kind), spans.filter((span) => span.kind === kind).length] as const)
    .filter(([, count]) => count > 0);
  return say("span_kind.strip", {
    counts: counts.map(([title, count]) => `${title}: ${formatNumber(count, 0)}`).join(", "),
  });
}

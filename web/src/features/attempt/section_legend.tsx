import { useEffect, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { say } from "../../base/words";
import { kCutColor, kGhostColor, kTargetColor } from "../../tooth/line_colors";
import type { FilmLink } from "../../tooth/link";
import { DeviationLegend, TissueLegend } from "../../widgets/tooth/legend";
import type { Opened, openFilm } from "./open_film";

interface LegendProps {
  readonly open: typeof openFilm;
  readonly client: Client;
  readonly film: FilmLink;
  readonly beside: FilmLink | undefined; // another attempt at the same tooth
  readonly start: string | undefined; // hash of the tooth before; undefined: only a surface is there
  readonly tissues: readonly number[]; // at the surface
  readonly deviation: boolean; // colours the surface
  readonly target: boolean; // and `other`: is outlined
  readonly other: boolean;
  readonly reference: (() => void) | undefined; // shows it; undefined: there is none, or another tooth is shown
}

// Fills the cut with its tissues, and says what is seen in it.
export function SectionLegend(props: LegendProps) {
  const { open, client, film, beside, start, tissues, deviation, target, other, reference } = props;
  const [inside, setInside] = useState<Opened>();
  useEffect(() => {
    if (start === undefined) return undefined;
    let abandoned = false;
    void open(client, film, start).then((told) => {
      if (!abandoned) setInside(told);
    });
    return () => {
      abandoned = true;
    };
  }, [open, client, film, start]);
  useEffect(() => {
    if (beside !== undefined && start !== undefined) void open(client, beside, start);
  }, [open, client, beside, start]);
  const lines = [
    [kCutColor, say("section.edge")],
    ...(target ? [[kTargetColor, say("section.target")] as const] : []),
    ...(other ? [[kGhostColor, say("section.compared")] as const] : []),
  ] as const;
  return (
    <div class="section-legend">
      {deviation && <DeviationLegend />}
      <TissueLegend tissues={inside?.ok ? inside.value : tissues} />
      <div class="legend">
        {lines.map(([color, text]) => (
          <span key={color} class="legend-item">
            <span class="swatch line" style={{ background: color }} />
            {text}
          </span>
        ))}
        {reference !== undefined && (
          <button type="button" class="button small quiet" onClick={() => reference()}>
            {say("section.outline_reference")}
          </button>
        )}
      </div>
      <p class="hint" role="status">
        {start === undefined
          ? say("section.no_inside")
          : inside?.ok === false
            ? say("section.not_opened", { reason: inside.error })
            : ""}
      </p>
    </div>
  );
}

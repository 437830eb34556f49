import { useEffect, useRef } from "preact/hooks";
import { formatSigned } from "../../base/format";
import { say } from "../../base/words";
import { deviationScalePixels, kDeviationRangeMm, kUntouchedColor } from "../../tooth/deviation_scale";
import { kGhostColor } from "../../tooth/line_colors";
import { tissueColor } from "../../tooth/tissue_color";
import { tissueTitle } from "./tissue";

const kTicks = [-0.5, -0.3, -0.1, 0.1, 0.3, 0.5] as const;
const kPixels = 220;

export function DeviationLegend() {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const context = canvas.current?.getContext("2d");
    if (context == null) return;
    const row = new ImageData(new Uint8ClampedArray(deviationScalePixels(kPixels)), kPixels, 1);
    context.putImageData(row, 0, 0);
  }, []);
  return (
    <div class="legend">
      <div class="legend-scale">
        <div class="legend-ends">
          <span>{say("legend.less")}</span>
          <span>{say("legend.as_reference")}</span>
          <span>{say("legend.more")}</span>
        </div>
        {/* biome-ignore lint/a11y/noAriaHiddenOnFocusable: a canvas takes no focus, and the numbers stand below */}
        <canvas ref={canvas} width={kPixels} height={1} aria-hidden="true" />
        <div class="legend-ticks">
          {kTicks.map((mm) => (
            <span key={mm} style={{ left: `${50 + (50 * mm) / kDeviationRangeMm}%` }}>
              {formatSigned(mm, 1)}
            </span>
          ))}
        </div>
      </div>
      <span class="legend-item">
        <span class="swatch" style={{ background: kUntouchedColor }} />
        {say("legend.untouched")}
      </span>
      <span class="legend-item hint">{say("legend.lines")}</span>
    </div>
  );
}

export function TissueLegend({ tissues }: { readonly tissues: readonly number[] }) {
  return (
    <div class="legend">
      {tissues.map((tissue) => (
        <span key={tissue} class="legend-item">
          <span class="swatch" style={{ background: tissueColor(tissue) }} />
          {tissueTitle(tissue)}
        </span>
      ))}
    </div>
  );
}

// For another tooth over the one in view.
export function GhostLegend() {
  return (
    <>
      <span class="legend-item">
        <span class="swatch" style={{ background: kGhostColor }} />
        {say("compare.more_left")}
      </span>
      <span class="legend-item">
        <span
          class="swatch"
          style={{ background: `repeating-linear-gradient(135deg, ${kGhostColor} 0 2.5px, transparent 2.5px 5px)` }}
        />
        {say("compare.less_left")}
      </span>
    </>
  );
}

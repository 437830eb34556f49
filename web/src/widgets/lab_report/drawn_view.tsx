import type { ComponentChildren } from "preact";
import type { Drawable } from "../../api/drawable";
import { Card } from "../basics";
import { StrokesView } from "../strokes/strokes_view";
import { LabReportView } from "./report_view";

// All that can be drawn of a report: strokes, and what else was found. `aside` stands in the first card's corner.
export function DrawnView({ drawable, aside }: { readonly drawable: Drawable; readonly aside?: ComponentChildren }) {
  return (
    <>
      {drawable.strokes !== undefined && (
        <Card title="Force against time" aside={aside}>
          <p>Six short motions of a hand, drawn beside what would be ideal: press, stroke, reverse, lift, nick an edge, slip out. The thick line
            is what the device does. Where it leaves the dashed line the hand feels something that is not tissue: it sticks, it kicks, or it
            comes late.</p>
          <StrokesView strokes={drawable.strokes} />
        </Card>
      )}
      {drawable.report !== undefined && <LabReportView report={drawable.report} aside={drawable.strokes === undefined ? aside : undefined} />}
    </>
  );
}

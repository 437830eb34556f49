import type { ComponentChildren } from "preact";
import type { Drawable } from "../../api/drawable";
import { say } from "../../base/words";
import { Card } from "../basics";
import { StrokesView } from "../strokes/strokes_view";
import { LabReportView } from "./report_view";

// The drawable parts of a report: strokes, and other findings. `aside` goes into the first card's
// corner.
export function DrawnView({ drawable, aside }: { readonly drawable: Drawable; readonly aside?: ComponentChildren }) {
  return (
    <>
      {drawable.strokes !== undefined && (
        <Card title={say("strokes.title")} aside={aside}>
          <p>{say("strokes.introduction")}</p>
          <StrokesView strokes={drawable.strokes} />
        </Card>
      )}
      {drawable.report !== undefined && (
        <LabReportView report={drawable.report} aside={drawable.strokes === undefined ? aside : undefined} />
      )}
    </>
  );
}

import { fail, ok, type Result } from "../base/result";
import { labReportIn, type LabReport } from "./lab_report";
import { strokesIn, type Strokes } from "./strokes";

// What can be drawn of a report of enamel-lab's. The members are named as in what it writes, so
// that this is such a report itself.
export interface Drawable {
  readonly report?: LabReport;
  readonly strokes?: Strokes;
}

// Errors: nothing can be drawn, or a part that is there cannot be read.
export function drawableIn(document: unknown): Result<Drawable, string> {
  const report = labReportIn(document);
  if (report?.ok === false) return fail(report.error);
  const onlyReport = report !== undefined && !("strokes" in (document as object));
  const strokes = onlyReport ? undefined : strokesIn(document);
  if (strokes?.ok === false) return fail(strokes.error);
  return ok({
    ...(report === undefined ? {} : { report: report.value }),
    ...(strokes === undefined ? {} : { strokes: strokes.value }),
  });
}

export function titleOf(drawable: Drawable): string {
  return drawable.report?.title ?? "How cutting feels: force against time";
}

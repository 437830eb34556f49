import { render } from "preact";
import { drawableIn, titleOf } from "../api/drawable";
import { ErrorNotice } from "../widgets/basics";
import { DrawnView } from "../widgets/lab_report/drawn_view";

// The page of scripts/draw_report.mjs: one file that holds its report, opened without a server.
function Report() {
  const found = drawableIn(JSON.parse(document.getElementById("report")?.textContent ?? "null"));
  return (
    <main>
      <h1>{found.ok ? titleOf(found.value) : "A report"}</h1>
      {found.ok ? <DrawnView drawable={found.value} /> : <ErrorNotice title="Nothing to draw" message={found.error} />}
    </main>
  );
}

const root = document.getElementById("app");
if (root === null) throw new Error("expected an element with id app");
render(<Report />, root);

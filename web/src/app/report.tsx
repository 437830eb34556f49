import { render } from "preact";
import { strokesIn } from "../api/strokes";
import { Card, ErrorNotice } from "../widgets/basics";
import { StrokesView } from "../widgets/strokes/strokes_view";

// The page of scripts/draw_report.mjs: one file that holds its report, opened without a server.
function Report() {
  const found = strokesIn(JSON.parse(document.getElementById("report")?.textContent ?? "null"));
  return (
    <main>
      <h1>How cutting feels: force against time</h1>
      <p class="lead">Six short motions of a hand, drawn beside what would be ideal. The thick line is what the device does. Where it leaves the
        dashed line the hand feels something that is not tissue: it sticks, it kicks, or it comes late.</p>
      <Card title="Press, stroke, reverse, lift, nick an edge, slip out">
        {found.ok ? <StrokesView strokes={found.value} /> : <ErrorNotice title="Nothing to draw" message={found.error} />}
      </Card>
    </main>
  );
}

const root = document.getElementById("app");
if (root === null) throw new Error("expected an element with id app");
render(<Report />, root);
